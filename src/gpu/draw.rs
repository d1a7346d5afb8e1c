//! A scene on a device, and its pictures.

use super::chunk::{ChunkData, chunks};
use super::device::Gpu;
use super::dicer::Dicer;
use super::error::GpuError;
use super::pipelines::Pipelines;
use super::plan::{ObjectPlan, plan};
use super::read_back::{ReadBlock, read, read_floats};
use super::records::{Chunk, Frame, Material, POINT_FLOATS, Record, words};
use super::timer::Timer;
use super::upload::{DeviceChunk, device_chunk, point_words, textures, uniform};
use super::view::{Drawn, frame_record};
use crate::camera::{Camera, View};
use crate::film::{Film, Image};
use crate::frame::{Renderer, Scene};
use crate::shade::{ShadeMode, SurfaceMaterial};
use crate::topology::NONE;
use std::time::{Duration, Instant};
use wgpu::BufferUsages as Usage;

/// Workgroups along x of a dispatch; more go into further rows.
pub(super) const ACROSS: u32 = 32768;
/// Workgroups that share the list of large quads.
const LARGE_GROUPS: u32 = 1024;
/// Invocations of a workgroup.
const GROUP: u32 = 64;

/// What a picture took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GpuStats {
    /// Faces of the cages.
    pub faces: u64,
    /// Micro-triangles.
    pub microtriangles: u64,
    /// Pixels with something in them.
    pub pixels_covered: u64,
    /// Bytes written to the device for this picture: points that moved, and the view.
    pub bytes_up: u64,
    /// Bytes read back: the picture.
    pub bytes_down: u64,
    /// Copies that read back.
    pub read_backs: u32,
    /// Chunks of blocks.
    pub chunks: u32,
    /// Bands of rows that the picture was drawn in.
    pub bands: u32,
    /// Bytes of the scene on the device.
    pub scene_bytes: u64,
    /// Shapes of surroundings with a table of weights each.
    pub shapes: u32,
    /// Time on the device by stage; empty unless asked for, or where the device keeps no time.
    pub stages: Vec<(&'static str, Duration)>,
    /// Wall time from the first byte up to the last one down.
    pub wall: Duration,
}

/// A finished picture.
#[derive(Clone, Debug)]
pub struct GpuFrame {
    /// The picture.
    pub image: Image,
    /// What it took.
    pub stats: GpuStats,
    /// The view that the camera came to.
    pub view: View,
}

struct Band {
    rows: [u32; 2],
    frame: wgpu::Buffer,
    /// Per chunk and pass.
    tile: Vec<Vec<wgpu::BindGroup>>,
    large: Vec<Vec<wgpu::BindGroup>>,
    shade: Vec<wgpu::BindGroup>,
    film: wgpu::BindGroup,
}

/// A scene whose cage, tables and blocks are on a device. Between pictures its points may move and the view change; what was decided
/// for the view it was made for (adaptive blocks) stays.
pub struct GpuScene<'a> {
    gpu: &'a Gpu,
    pipelines: &'a Pipelines,
    drawn: Drawn,
    view: View,
    control: wgpu::Buffer,
    control_points: Vec<[f32; 3]>,
    moved: bool,
    diced: bool,
    chunks: Vec<DeviceChunk>,
    bands: Vec<Band>,
    keys: wgpu::Buffer,
    sums: wgpu::Buffer,
    image: wgpu::Buffer,
    staging: wgpu::Buffer,
    timer: Option<Timer>,
    stats: GpuStats,
}

impl std::fmt::Debug for GpuScene<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("GpuScene")
            .field("chunks", &self.chunks.len())
            .finish_non_exhaustive()
    }
}

/// Stages that are timed, in the order of their passes.
const TIMED: [&str; 4] = ["dice", "tile", "shade", "film"];

impl<'a> GpuScene<'a> {
    /// Puts `scene` on the device, as `renderer` draws it and `camera` sees it.
    ///
    /// # Errors
    /// [`GpuError`]: what this backend does not draw, a budget, or what the device cannot hold.
    pub fn new(
        gpu: &'a Gpu,
        renderer: &Renderer,
        scene: &Scene,
        camera: &Camera,
    ) -> Result<Self, GpuError> {
        let view = renderer.view(scene, camera)?;
        let plans = plan(renderer, scene, &view)?;
        let wants_uvs = renderer.mode == ShadeMode::Uv || !scene.textures.is_empty();
        let cages = || scene.objects.iter().map(|o| o.surface.cage());
        let all_points: usize = cages().map(|c| c.points().len()).sum();
        let uvs = cages().flat_map(|c| c.uvs().iter().flatten());
        let mut values: Vec<u32> = uvs.map(|c| c.to_bits()).collect();
        let mut first_color = (3 * all_points + values.len()) as u32;
        let colors = cages().flat_map(|c| c.colors().iter().flatten());
        values.extend(colors.map(|c| c.to_bits()));
        let (mut first_point, mut first_face) = (0, 0);
        let mut first_uv = 3 * all_points as u32;
        let mut dicers = Vec::new();
        let mut control_points = Vec::new();
        for (object, plan) in scene.objects.iter().zip(&plans) {
            dicers.push(Dicer::new(
                object,
                plan,
                [first_point, first_face, first_uv, first_color],
                wants_uvs,
                &renderer.limits,
            )?);
            let points = object.surface.control_base();
            control_points.extend_from_slice(points);
            first_point += points.len() as u32;
            first_uv += 2 * object.surface.cage().uvs().len() as u32;
            first_color += 3 * object.surface.cage().colors().len() as u32;
            first_face += object.surface.cage().face_count() as u32;
        }
        let data = chunks(scene, &dicers, &plans, gpu.max_binding, &renderer.limits)?;
        let id_bits = id_bits(&plans)?;
        let shapes: usize = dicers.iter().map(|d| d.table_size().0).sum();
        drop(dicers);
        let control = (control_points, values);
        Self::upload(gpu, renderer, scene, view, &data, control, id_bits).map(|mut made| {
            made.stats.faces = scene.face_count() as u64;
            made.stats.microtriangles = plans.iter().map(|p| p.triangles).sum();
            made.stats.shapes = shapes as u32;
            made
        })
    }

    fn upload(
        gpu: &'a Gpu,
        renderer: &Renderer,
        scene: &Scene,
        view: View,
        data: &[ChunkData],
        (control_points, values): (Vec<[f32; 3]>, Vec<u32>),
        id_bits: u32,
    ) -> Result<Self, GpuError> {
        let pipelines = gpu.pipelines()?;
        let size = renderer.size;
        let control = [point_words(&control_points), values].concat();
        let control = gpu.filled("control points", &control)?;
        let phases: usize = if gpu.wide { 1 } else { 2 };
        let mut scene_bytes = control.size();
        let mut made = Vec::new();
        for chunk in data {
            let chunk = device_chunk(gpu, pipelines, &control, chunk, phases, &mut scene_bytes)?;
            made.push(chunk);
        }
        let default = scene.default_material.unwrap_or(SurfaceMaterial::CLAY);
        let materials = scene.materials.iter().chain([&default]);
        let (textures, places) = textures(gpu, scene)?;
        scene_bytes += textures.size();
        let materials = materials.map(|m| Material {
            diffuse: [m.diffuse[0], m.diffuse[1], m.diffuse[2], 1.0],
            map: m
                .diffuse_map
                .and_then(|map| places.get(map as usize).copied())
                .unwrap_or(NONE),
            padding: [0; 3],
        });
        let materials = gpu.filled("materials", &words(&materials.collect::<Vec<_>>()))?;
        // Rows of the picture whose keys fit a binding.
        let row = 16 * u64::from(size.width) * u64::from(size.samples.div_ceil(2).max(1));
        let rows = (gpu.max_binding / row).clamp(1, u64::from(size.height)) as u32;
        let band_pixels = u64::from(size.width) * u64::from(rows);
        let storage = Usage::STORAGE | Usage::COPY_DST;
        let keys = gpu.empty("keys", band_pixels * 8 * u64::from(size.samples), storage)?;
        let sums = gpu.empty("sums", band_pixels * 16, storage)?;
        let image_bytes = 4 * u64::from(size.width) * u64::from(size.height);
        let image = gpu.empty("picture", image_bytes, storage | Usage::COPY_SRC)?;
        let staging = gpu.empty("picture", image_bytes, Usage::COPY_DST | Usage::MAP_READ)?;
        let whole = uniform(
            gpu,
            &Chunk {
                groups: ACROSS,
                ..Chunk::default()
            },
        )?;
        let mut bands = Vec::new();
        for start in (0..size.height).step_by(rows as usize) {
            let end = (start + rows).min(size.height);
            let frame = gpu.empty(
                "frame",
                Frame::SIZE as u64,
                Usage::UNIFORM | Usage::COPY_DST,
            )?;
            let drawn = |stage: &super::pipelines::Stage, c: &DeviceChunk, phase: usize| {
                stage.bind(
                    gpu,
                    &[
                        (0, &frame),
                        (1, &c.phases[phase]),
                        (2, &c.blocks),
                        (3, &c.points),
                        (4, &keys),
                        (5, &c.large),
                    ],
                )
            };
            let all = |stage: &super::pipelines::Stage| -> Vec<Vec<wgpu::BindGroup>> {
                let of = |c| (0..phases).map(|p| drawn(stage, c, p)).collect();
                made.iter().map(of).collect()
            };
            let shade = made.iter().map(|c| {
                pipelines.shade.bind(
                    gpu,
                    &[
                        (0, &frame),
                        (1, &c.phases[0]),
                        (2, &c.blocks),
                        (3, &c.points),
                        (4, &keys),
                        (5, &c.faces),
                        (6, &materials),
                        (7, &sums),
                        (8, &c.uvs),
                        (9, &textures),
                        (10, &c.colors),
                    ],
                )
            });
            let film = [(0, &frame), (1, &whole), (2, &sums), (3, &image)];
            bands.push(Band {
                rows: [start, end],
                tile: all(&pipelines.tile),
                large: all(&pipelines.large),
                shade: shade.collect(),
                film: pipelines.film.bind(gpu, &film),
                frame,
            });
        }
        scene_bytes += keys.size() + sums.size() + image.size();
        gpu.check()?;
        Ok(Self {
            gpu,
            drawn: Drawn {
                size,
                mode: renderer.mode,
                background: renderer.background,
                id_bits,
            },
            view,
            control,
            control_points,
            moved: true,
            diced: false,
            stats: GpuStats {
                chunks: made.len() as u32,
                bands: bands.len() as u32,
                scene_bytes,
                ..GpuStats::default()
            },
            chunks: made,
            bands,
            keys,
            sums,
            image,
            staging,
            timer: if renderer.measure {
                Timer::of_stages(gpu, TIMED.len() as u32)?
            } else {
                None
            },
            pipelines,
        })
    }

    /// The view that it was made for.
    #[must_use]
    pub fn view(&self) -> &View {
        &self.view
    }

    /// Moves the control points of all objects, one after the other in the order of the scene; they go up with the next picture.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] where there are not as many as before.
    pub fn move_points(&mut self, points: &[[f32; 3]]) -> Result<(), GpuError> {
        if points.len() != self.control_points.len() {
            return Err(GpuError::Unsupported {
                what: "another number of points than the scene was made with",
            });
        }
        self.control_points.copy_from_slice(points);
        self.moved = true;
        Ok(())
    }

    /// Draws what it was made for.
    ///
    /// # Errors
    /// [`GpuError`] of the device.
    pub fn draw(&mut self) -> Result<GpuFrame, GpuError> {
        let view = self.view;
        self.draw_view(&view)
    }

    /// Draws through another view of the same size.
    ///
    /// # Errors
    /// [`GpuError`] of the device.
    pub fn draw_view(&mut self, view: &View) -> Result<GpuFrame, GpuError> {
        if view.size != self.drawn.size {
            return Err(GpuError::Unsupported {
                what: "views of another size than the scene was made for",
            });
        }
        let begin = Instant::now();
        let mut stats = self.stats.clone();
        let queue = self.gpu.queue();
        let mut encoder = self
            .gpu
            .device()
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        if self.moved {
            let words = point_words(&self.control_points);
            queue.write_buffer(&self.control, 0, bytemuck::cast_slice(&words));
            stats.bytes_up += 4 * words.len() as u64;
            self.moved = false;
            self.diced = false;
        }
        for band in &self.bands {
            let frame = frame_record(&self.drawn, view, band.rows);
            let words = words(&[frame]);
            queue.write_buffer(&band.frame, 0, bytemuck::cast_slice(&words));
            stats.bytes_up += 4 * words.len() as u64;
        }
        if !self.diced {
            self.encode_dice(&mut encoder);
            self.diced = true;
        }
        for band in &self.bands {
            self.encode_band(&mut encoder, band);
        }
        encoder.copy_buffer_to_buffer(&self.image, 0, &self.staging, 0, self.staging.size());
        stats.read_backs += 1;
        stats.bytes_down +=
            4 * u64::from(self.drawn.size.width) * u64::from(self.drawn.size.height);
        if let Some(timer) = &self.timer {
            timer.resolve(&mut encoder);
        }
        queue.submit([encoder.finish()]);
        let bytes = read(self.gpu, &self.staging)?;
        stats.wall = begin.elapsed();
        if let Some(timer) = &self.timer {
            stats.stages = TIMED.into_iter().zip(timer.read_all(self.gpu)?).collect();
        }
        let mut image = Image::new(self.drawn.size.width, self.drawn.size.height);
        let length = image.data.len();
        image.data.copy_from_slice(&bytes[..length]);
        let empty = Film::new(self.drawn.mode.encoding(), self.drawn.background).empty();
        stats.pixels_covered = image.data.chunks_exact(4).filter(|p| **p != empty).count() as u64;
        Ok(GpuFrame {
            image,
            stats,
            view: *view,
        })
    }

    fn pass<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        stage: usize,
    ) -> wgpu::ComputePass<'e> {
        let times = self.timer.as_ref().map(|t| t.of_stage(stage as u32));
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(TIMED[stage]),
            timestamp_writes: times,
        })
    }

    fn encode_dice(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = self.pass(encoder, 0);
        for c in &self.chunks {
            let groups = c.data.spots.div_ceil(GROUP);
            self.pipelines
                .sides
                .run(&mut pass, &c.sides, groups, ACROSS);
            self.pipelines
                .inside
                .run(&mut pass, &c.inside, c.data.blocks, ACROSS);
        }
    }

    fn encode_band(&self, encoder: &mut wgpu::CommandEncoder, band: &Band) {
        encoder.clear_buffer(&self.keys, 0, None);
        encoder.clear_buffer(&self.sums, 0, None);
        for c in &self.chunks {
            encoder.clear_buffer(&c.large, 0, Some(4));
        }
        let p = self.pipelines;
        let mut pass = self.pass(encoder, 1);
        let phases = self.chunks.first().map_or(0, |c| c.phases.len());
        for phase in 0..phases {
            for (k, c) in self.chunks.iter().enumerate() {
                p.tile
                    .run(&mut pass, &band.tile[k][phase], c.data.blocks, ACROSS);
                p.large
                    .run(&mut pass, &band.large[k][phase], LARGE_GROUPS, ACROSS);
            }
        }
        drop(pass);
        let pixels = self.drawn.size.width * (band.rows[1] - band.rows[0]);
        let groups = pixels.div_ceil(GROUP);
        let mut pass = self.pass(encoder, 2);
        for bindings in &band.shade {
            p.shade.run(&mut pass, bindings, groups, ACROSS);
        }
        drop(pass);
        let mut pass = self.pass(encoder, 3);
        p.film.run(&mut pass, &band.film, groups, ACROSS);
    }

    /// The diced points of all blocks, read back for tests. Nothing before the first picture.
    ///
    /// # Errors
    /// [`GpuError`] of the device.
    #[doc(hidden)]
    pub fn read_blocks(&self) -> Result<Vec<ReadBlock>, GpuError> {
        let mut out = Vec::new();
        for c in &self.chunks {
            let bytes = 4 * u64::from(POINT_FLOATS) * u64::from(c.data.points);
            let floats = read_floats(self.gpu, &c.points, bytes)?;
            let points = floats.as_chunks::<{ POINT_FLOATS as usize }>().0;
            for b in &c.named {
                let side = (1 << b.log) + 1;
                let first = (b.base + c.data.spots) as usize;
                out.push(ReadBlock {
                    quad: b.quad,
                    start: b.start,
                    side,
                    points: points[first..first + side * side].to_vec(),
                });
            }
        }
        Ok(out)
    }
}

/// Bits of rows and columns in ids.
fn id_bits(plans: &[ObjectPlan]) -> Result<u32, GpuError> {
    let all = || plans.iter().flat_map(|p| &p.blocks);
    let bits = all().map(|b| b.log).max().unwrap_or(0);
    let count = all().count() as u64;
    if count << (2 * bits + 1) > u64::from(u32::MAX) {
        return Err(GpuError::OutOfMemory {
            what: "the numbers of more than 4 thousand million micro-triangles: lower the level",
        });
    }
    Ok(bits)
}
