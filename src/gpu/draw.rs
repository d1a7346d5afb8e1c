//! A scene on a device, and its pictures.

use super::chunk::{ChunkData, chunks};
use super::device::Gpu;
use super::dicer::Dicer;
use super::error::GpuError;
use super::pipelines::{Pipelines, Stage};
use super::plan::plan;
use super::read_back::{ReadBlock, read, read_floats};
use super::records::{Frame, Material, POINT_FLOATS, Record, words};
use super::timer::Timer;
use super::upload::{DeviceChunk, device_chunk, point_words, textures};
use super::view::{Drawn, frame_record};
use super::wgsl::GROUP;
use crate::camera::{Camera, View};
use crate::film::{Film, Image};
use crate::frame::{Renderer, Scene};
use crate::limits::Budget;
use crate::mesh::Cage;
use crate::shade::{ShadeMode, SurfaceMaterial};
use crate::topology::NONE;
use std::time::{Duration, Instant};
use wgpu::BufferUsages as Usage;

/// Workgroups that share the list of large quads.
const LARGE_GROUPS: u32 = 1024;

/// What a picture took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GpuStats {
    /// Faces of the cages.
    pub faces: u64,
    /// Micro-triangles.
    pub microtriangles: u64,
    /// Level of each object; of adaptive ones, their deepest.
    pub levels: Vec<u32>,
    /// Pixels with something in them.
    pub pixels_covered: u64,
    /// Bytes written to the device for this picture: points that moved, and the view.
    pub bytes_up: u64,
    /// Bytes read back: the picture.
    pub bytes_down: u64,
    /// Buffers that were read back.
    pub read_backs: u32,
    /// Chunks of blocks.
    pub chunks: u32,
    /// Bands of rows that the picture was drawn in.
    pub bands: u32,
    /// Bytes of the scene on the device.
    pub scene_bytes: u64,
    /// Shapes of surroundings with a table of weights each.
    pub shapes: u32,
    /// Time on the device by stage, of all bands together; `dice` only where points moved. Empty unless asked for, or where the device
    /// keeps no time or not as many times as there are bands.
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

/// A scene that is ready to go to the device.
struct Ready {
    chunks: Vec<ChunkData>,
    /// Control points of all objects.
    points: Vec<[f32; 3]>,
    /// What stands behind them: texture coordinates, then colours.
    values: Vec<u32>,
    stats: GpuStats,
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
    /// A band of the picture.
    image: wgpu::Buffer,
    /// The whole picture, on its way down.
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

/// Stages of a band that are timed, in the order of their passes. Times of the first band come first; that of `dice` is last, because
/// pictures may go without.
const TIMED: [&str; 3] = ["tile", "shade", "film"];

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
        let budget = &mut Budget::new(&renderer.limits);
        let plan = plan(renderer, scene, &view, budget)?;
        let wants_uvs = renderer.mode == ShadeMode::Uv || !scene.textures.is_empty();
        let cages = || scene.objects.iter().map(|o| o.surface.cage());
        let all_points: usize = cages().map(|c| c.points().len()).sum();
        let numbers = |c: &Cage| 2 * c.uvs().len() + 3 * c.colors().len();
        let all_values: usize = cages().map(numbers).sum();
        // Kept here, and put together for the device.
        let bytes = 4 * (3 * all_points as u128 + all_values as u128);
        budget.take("the control points of the GPU backend", 2 * bytes, bytes)?;
        let uvs = cages().flat_map(|c| c.uvs().iter().flatten());
        let mut values: Vec<u32> = uvs.map(|c| c.to_bits()).collect();
        let mut first_color = (3 * all_points + values.len()) as u32;
        let colors = cages().flat_map(|c| c.colors().iter().flatten());
        values.extend(colors.map(|c| c.to_bits()));
        let (mut first_point, mut first_face) = (0, 0);
        let mut first_uv = 3 * all_points as u32;
        let mut dicers = Vec::new();
        let mut control_points = Vec::new();
        for (object, plan) in scene.objects.iter().zip(&plan.objects) {
            dicers.push(Dicer::new(
                object,
                plan,
                [first_point, first_face, first_uv, first_color],
                wants_uvs,
                budget,
            )?);
            let points = object.surface.control_base();
            control_points.extend_from_slice(points);
            first_point += points.len() as u32;
            first_uv += 2 * object.surface.cage().uvs().len() as u32;
            first_color += 3 * object.surface.cage().colors().len() as u32;
            first_face += object.surface.cage().face_count() as u32;
        }
        let data = chunks(&dicers, &plan.objects, gpu.max_binding, budget)?;
        let shapes: usize = dicers.iter().map(|d| d.tables.len()).sum();
        drop(dicers);
        let stats = GpuStats {
            faces: scene.face_count() as u64,
            microtriangles: plan.triangles,
            levels: plan.levels,
            shapes: shapes as u32,
            ..GpuStats::default()
        };
        let drawn = Drawn {
            size: renderer.size,
            mode: renderer.mode,
            background: renderer.background,
            light_turn: renderer.light_turn,
            id_bits: plan.id_bits,
        };
        let ready = Ready {
            chunks: data,
            points: control_points,
            values,
            stats,
        };
        let mut made = gpu.caught(|| Self::upload(gpu, drawn, scene, view, ready, budget))?;
        made.measuring(renderer.measure)?;
        Ok(made)
    }

    fn upload(
        gpu: &'a Gpu,
        drawn: Drawn,
        scene: &Scene,
        view: View,
        ready: Ready,
        budget: &mut Budget<'_>,
    ) -> Result<Self, GpuError> {
        let pipelines = gpu.pipelines()?;
        let size = drawn.size;
        let Ready {
            chunks,
            points: control_points,
            values,
            mut stats,
        } = ready;
        let control = [point_words(&control_points), values].concat();
        let control = gpu.filled("control points", &control)?;
        let phases: usize = if gpu.wide { 1 } else { 2 };
        let mut scene_bytes = control.size();
        let mut made = Vec::new();
        for chunk in chunks {
            // Its words on their way to the device.
            budget.take("the chunks of the GPU backend", 0, chunk.bytes())?;
            let chunk = device_chunk(gpu, pipelines, &control, chunk, phases, &mut scene_bytes)?;
            made.push(chunk);
        }
        let default = scene.default_material.unwrap_or(SurfaceMaterial::CLAY);
        let materials = scene.materials.iter().chain([&default]);
        let (textures, places) = textures(gpu, scene, budget)?;
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
        // Rows of the picture whose keys, and sums of 16 bytes a pixel, fit a binding.
        let row_bytes = 8 * u64::from(size.width) * u64::from(size.samples.max(2));
        let rows = (gpu.max_binding / row_bytes).clamp(1, u64::from(size.height)) as u32;
        let band_pixels = u64::from(size.width) * u64::from(rows);
        let storage = Usage::STORAGE | Usage::COPY_DST;
        let keys = gpu.empty("keys", band_pixels * 8 * u64::from(size.samples), storage)?;
        let sums = gpu.empty("sums", band_pixels * 16, storage)?;
        let image = gpu.empty("picture", 4 * band_pixels, storage | Usage::COPY_SRC)?;
        let image_bytes = 4 * u64::from(size.width) * u64::from(size.height);
        // The picture, and its bytes as they come down.
        budget.take("the picture", 2 * u128::from(image_bytes), 0)?;
        let staging = gpu.empty("picture", image_bytes, Usage::COPY_DST | Usage::MAP_READ)?;
        let mut bands = Vec::new();
        for start in (0..size.height).step_by(rows as usize) {
            let end = (start + rows).min(size.height);
            let frame = gpu.empty(
                "frame",
                Frame::SIZE as u64,
                Usage::UNIFORM | Usage::COPY_DST,
            )?;
            let drawn = |stage: &Stage, c: &DeviceChunk, phase: usize| {
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
            let all = |stage: &Stage| -> Vec<Vec<wgpu::BindGroup>> {
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
            let film = [(0, &frame), (1, &sums), (2, &image)];
            bands.push(Band {
                rows: [start, end],
                tile: all(&pipelines.tile),
                large: all(&pipelines.large),
                shade: shade.collect(),
                film: pipelines.film.bind(gpu, &film),
                frame,
            });
        }
        stats.chunks = made.len() as u32;
        stats.bands = bands.len() as u32;
        stats.scene_bytes = scene_bytes + keys.size() + sums.size() + image.size();
        Ok(Self {
            gpu,
            drawn,
            view,
            control,
            control_points,
            // They are there with the rest.
            moved: false,
            diced: false,
            stats,
            chunks: made,
            bands,
            keys,
            sums,
            image,
            staging,
            timer: None,
            pipelines,
        })
    }

    /// Whether stages are timed from now on, which takes time itself.
    ///
    /// # Errors
    /// [`GpuError`] of the device.
    #[doc(hidden)]
    pub fn measuring(&mut self, on: bool) -> Result<(), GpuError> {
        let stages = self.bands.len() * TIMED.len() + 1;
        self.timer = match on {
            true => Timer::of_stages(self.gpu, stages as u32)?,
            false => None,
        };
        Ok(())
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
        let gpu = self.gpu;
        gpu.caught(|| self.drawn_from(view))
    }

    fn drawn_from(&mut self, view: &View) -> Result<GpuFrame, GpuError> {
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
        let mut frame = frame_record(&self.drawn, view);
        for band in &self.bands {
            [frame.band_start, frame.band_end] = band.rows;
            let words = words(&[frame]);
            queue.write_buffer(&band.frame, 0, bytemuck::cast_slice(&words));
            stats.bytes_up += 4 * words.len() as u64;
        }
        let mut timed = (self.bands.len() * TIMED.len()) as u32;
        if !self.diced {
            self.encode_dice(&mut encoder, timed);
            self.diced = true;
            timed += 1;
        }
        let row_bytes = 4 * u64::from(self.drawn.size.width);
        for (k, band) in self.bands.iter().enumerate() {
            self.encode_band(&mut encoder, band, (k * TIMED.len()) as u32);
            let [start, end] = band.rows.map(|row| u64::from(row) * row_bytes);
            encoder.copy_buffer_to_buffer(&self.image, 0, &self.staging, start, end - start);
        }
        stats.read_backs += 1;
        stats.bytes_down += row_bytes * u64::from(self.drawn.size.height);
        if let Some(timer) = &self.timer {
            timer.resolve(&mut encoder, timed);
        }
        queue.submit([encoder.finish()]);
        let bytes = read(self.gpu, &self.staging)?;
        stats.wall = begin.elapsed();
        if let Some(timer) = &self.timer {
            stats.stages = self.by_stage(&timer.read(self.gpu, timed)?);
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

    /// Times of stages: of all bands together, and of `dice` where there is one more.
    fn by_stage(&self, times: &[Duration]) -> Vec<(&'static str, Duration)> {
        let (bands, dice) = times.split_at(self.bands.len() * TIMED.len());
        let mut out: Vec<_> = dice.iter().map(|&time| ("dice", time)).collect();
        for (k, name) in TIMED.into_iter().enumerate() {
            out.push((name, bands.iter().skip(k).step_by(TIMED.len()).sum()));
        }
        out
    }

    fn pass<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        name: &'static str,
        number: u32,
    ) -> wgpu::ComputePass<'e> {
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(name),
            timestamp_writes: self.timer.as_ref().map(|t| t.of_stage(number)),
        })
    }

    fn encode_dice(&self, encoder: &mut wgpu::CommandEncoder, number: u32) {
        let mut pass = self.pass(encoder, "dice", number);
        for c in &self.chunks {
            let groups = c.data.spots.div_ceil(GROUP);
            self.pipelines.sides.run(&mut pass, &c.sides, groups);
            self.pipelines
                .inside
                .run(&mut pass, &c.inside, c.data.blocks);
        }
    }

    /// Draws a band; its passes are numbered from `first` on.
    fn encode_band(&self, encoder: &mut wgpu::CommandEncoder, band: &Band, first: u32) {
        let [tile, shade, film] = TIMED;
        encoder.clear_buffer(&self.keys, 0, None);
        encoder.clear_buffer(&self.sums, 0, None);
        for c in &self.chunks {
            encoder.clear_buffer(&c.large, 0, Some(4));
        }
        let p = self.pipelines;
        let mut pass = self.pass(encoder, tile, first);
        let phases = self.chunks.first().map_or(0, |c| c.phases.len());
        for phase in 0..phases {
            for (k, c) in self.chunks.iter().enumerate() {
                p.tile.run(&mut pass, &band.tile[k][phase], c.data.blocks);
                p.large.run(&mut pass, &band.large[k][phase], LARGE_GROUPS);
            }
        }
        drop(pass);
        let pixels = self.drawn.size.width * (band.rows[1] - band.rows[0]);
        let groups = pixels.div_ceil(GROUP);
        let mut pass = self.pass(encoder, shade, first + 1);
        for bindings in &band.shade {
            p.shade.run(&mut pass, bindings, groups);
        }
        drop(pass);
        let mut pass = self.pass(encoder, film, first + 2);
        p.film.run(&mut pass, &band.film, groups);
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
