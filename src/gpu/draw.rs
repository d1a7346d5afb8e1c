//! A scene on a device, and its pictures.

use super::deciding;
use super::device::Gpu;
use super::error::GpuError;
use super::flatness::COUNT_BYTES;
use super::further::Further;
use super::pipelines::{Pipelines, Stage};
use super::plan::{Plan, plan};
use super::read_back::{ReadBlock, read, read_floats};
use super::ready::Ready;
use super::records::{Frame, POINT_FLOATS, Record, words};
use super::stats::{GpuFrame, GpuStats};
use super::timer::Timer;
use super::upload::{DeviceChunk, device_chunk, materials, point_words, textures};
use super::view::{Drawn, frame_record};
use super::wgsl::{GROUP, STILL, Variant};
use crate::camera::{Camera, View};
use crate::film::{Film, Image};
use crate::frame::{Renderer, Scene};
use crate::limits::Budget;
use std::time::{Duration, Instant};
use wgpu::BufferUsages as Usage;

/// Workgroups that share the list of large quads.
const LARGE_GROUPS: u32 = 1024;

pub(super) struct Band {
    rows: [u32; 2],
    frame: wgpu::Buffer,
    /// Per chunk and pass.
    tile: Vec<Vec<wgpu::BindGroup>>,
    large: Vec<Vec<wgpu::BindGroup>>,
    shade: Vec<wgpu::BindGroup>,
    film: wgpu::BindGroup,
}

/// A scene whose cage, tables and blocks are on a device. Between pictures its points may move and the view change. Blocks that the device
/// decides on follow both; what the processor decided for the view it was made for stays.
pub struct GpuScene<'a> {
    pub(super) gpu: &'a Gpu,
    pub(super) pipelines: &'a Pipelines,
    pub(super) drawn: Drawn,
    pub(super) view: View,
    control: wgpu::Buffer,
    control_points: Vec<[f32; 3]>,
    further: Further,
    moved: bool,
    /// Whether points of sides, and blocks, are those of the control points.
    pub(super) sided: bool,
    pub(super) diced: bool,
    /// The view that blocks are decided by, whatever is drawn, and the one that they were.
    pub(super) decided_by: Option<View>,
    pub(super) decided_for: Option<View>,
    pub(super) chunks: Vec<DeviceChunk>,
    pub(super) bands: Vec<Band>,
    keys: wgpu::Buffer,
    sums: wgpu::Buffer,
    /// A band of the picture.
    image: wgpu::Buffer,
    /// The whole picture, on its way down.
    pub(super) staging: wgpu::Buffer,
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

/// Stages of a band that are timed, in the order of their passes. Times of the first band come first; those of [`BEFORE`] are last,
/// because pictures may go without.
pub(super) const TIMED: [&str; 3] = ["tile", "shade", "film"];

/// Stages that only new views and moved points need.
const BEFORE: [&str; 2] = [FLATNESS, DICE];
pub(super) const FLATNESS: &str = "flatness";
pub(super) const DICE: &str = "dice";

/// Most passes of [`BEFORE`]: sides are diced first, what is inside last.
const MOST_BEFORE: usize = 3;

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
        Self::for_view(gpu, renderer, scene, view)
    }

    /// The same for a view that is known.
    ///
    /// # Errors
    /// As [`GpuScene::new`].
    pub fn for_view(
        gpu: &'a Gpu,
        renderer: &Renderer,
        scene: &Scene,
        view: View,
    ) -> Result<Self, GpuError> {
        if let Some(flatness) = renderer.flatness(scene) {
            let budget = &mut Budget::new(&renderer.limits);
            let plan = deciding::plan(renderer, scene, flatness, budget);
            let made =
                plan.and_then(|plan| Self::planned(gpu, renderer, (scene, view), plan, budget));
            match made.and_then(|mut made| Ok((made.covers()?, made))) {
                Ok((true, made)) => return Ok(made),
                // The processor needs less memory, and has deeper levels.
                Ok((false, _)) | Err(GpuError::OutOfMemory { .. } | GpuError::Limit(_)) => {}
                Err(e) => return Err(e),
            }
        }
        Self::decided_by_processor(gpu, renderer, scene, view)
    }

    /// The same where the processor decides on all blocks, for this view.
    ///
    /// # Errors
    /// As [`GpuScene::new`].
    #[doc(hidden)]
    pub fn decided_by_processor(
        gpu: &'a Gpu,
        renderer: &Renderer,
        scene: &Scene,
        view: View,
    ) -> Result<Self, GpuError> {
        let budget = &mut Budget::new(&renderer.limits);
        let plan = plan(renderer, scene, &view, budget)?;
        Self::planned(gpu, renderer, (scene, view), plan, budget)
    }

    fn planned(
        gpu: &'a Gpu,
        renderer: &Renderer,
        (scene, view): (&Scene, View),
        plan: Plan,
        budget: &mut Budget<'_>,
    ) -> Result<Self, GpuError> {
        let (ready, drawn) = Ready::of(renderer, scene, plan, gpu.max_binding, budget)?;
        let mut made = gpu.caught(|| Self::upload(gpu, drawn, scene, view, ready, budget))?;
        made.decided_by = renderer.decided_by;
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
        let size = drawn.size;
        let Ready {
            chunks,
            points: control_points,
            further,
            heights,
            values,
            mut stats,
        } = ready;
        let looks = || chunks.iter().map(|c| c.look);
        let pipelines = gpu.pipelines(Variant {
            lifted: looks().any(|l| l.rise.shape != STILL),
            tilted: looks().any(|l| l.tilted),
            cut: looks().any(|l| l.cut),
        })?;
        let control = [
            point_words(&control_points),
            point_words(further.vectors()),
            values,
        ]
        .concat();
        let control = gpu.filled("control points", &control)?;
        let heights: &[u32] = bytemuck::cast_slice(&heights);
        let heights = gpu.filled("heights", heights)?;
        let phases: usize = if gpu.wide { 1 } else { 2 };
        let mut scene_bytes = control.size() + heights.size();
        let mut made = Vec::new();
        for chunk in chunks {
            // Its words on their way to the device.
            budget.take("the chunks of the GPU backend", 0, chunk.bytes())?;
            let chunk = device_chunk(
                gpu,
                pipelines,
                [&control, &heights],
                chunk,
                phases,
                &mut scene_bytes,
            )?;
            made.push(chunk);
        }
        let (textures, places) = textures(gpu, scene, budget)?;
        scene_bytes += textures.size();
        let materials = gpu.filled("materials", &words(&materials(scene, &places)))?;
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
        let counts = made.iter().filter(|c| c.flatness.is_some()).count() as u64;
        let staging = gpu.empty(
            "picture",
            image_bytes + counts * COUNT_BYTES,
            Usage::COPY_DST | Usage::MAP_READ,
        )?;
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
                        (6, &c.faces),
                        (7, &materials),
                        (8, &c.uvs),
                        (9, &textures),
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
                        (11, &c.tangents),
                        (12, &c.rise),
                        (13, &heights),
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
            further,
            // They are there with the rest.
            moved: false,
            sided: false,
            diced: false,
            decided_by: None,
            decided_for: None,
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
        let stages = self.bands.len() * TIMED.len() + MOST_BEFORE;
        self.timer = match on {
            true => Timer::of_stages(self.gpu, stages as u32)?,
            false => None,
        };
        Ok(())
    }

    /// Whether it draws through `view` what one would draw that is made for it, of the same scene by a renderer with the same settings:
    /// whether blocks are not decided by the view that it was made for, and levels are the same.
    ///
    /// # Errors
    /// [`GpuError::Render`]: a level or a view that there is not.
    pub fn serves(
        &self,
        renderer: &Renderer,
        scene: &Scene,
        view: &View,
    ) -> Result<bool, GpuError> {
        let follows = self.decides() && self.decided_by == renderer.decided_by;
        let fixed = (!self.drawn.tessellated || follows) && self.drawn.size == view.size;
        Ok(fixed && renderer.levels(scene, view)? == self.stats.levels)
    }

    /// The view that it was made for.
    #[must_use]
    pub fn view(&self) -> &View {
        &self.view
    }

    /// Moves the control points of all objects, one after the other in the order of the scene; they go up with the next picture.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] where there are not as many as before, or some of PN triangles are not finite.
    pub fn move_points(&mut self, points: &[[f32; 3]]) -> Result<(), GpuError> {
        if points.len() != self.control_points.len() {
            return Err(GpuError::Unsupported {
                what: "another number of points than the scene was made with",
            });
        }
        self.further.follow(points)?;
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
            let mut words = point_words(&self.control_points);
            if self.further.follows() {
                words.extend(point_words(self.further.vectors()));
            }
            queue.write_buffer(&self.control, 0, bytemuck::cast_slice(&words));
            stats.bytes_up += 4 * words.len() as u64;
            self.moved = false;
            self.sided = false;
        }
        let mut frame = frame_record(&self.drawn, view);
        for band in &self.bands {
            [frame.band_start, frame.band_end] = band.rows;
            let words = words(&[frame]);
            queue.write_buffer(&band.frame, 0, bytemuck::cast_slice(&words));
            stats.bytes_up += 4 * words.len() as u64;
        }
        let mut before = Vec::new();
        stats.bytes_up += self.encode_flatness(&mut encoder, view, &mut before)?;
        if !self.diced {
            self.encode_dice(&mut encoder, self.first_before() + before.len() as u32);
            self.diced = true;
            before.push(DICE);
        }
        let timed = self.first_before() + before.len() as u32;
        let row_bytes = 4 * u64::from(self.drawn.size.width);
        for (k, band) in self.bands.iter().enumerate() {
            self.encode_band(&mut encoder, band, (k * TIMED.len()) as u32);
            let [start, end] = band.rows.map(|row| u64::from(row) * row_bytes);
            encoder.copy_buffer_to_buffer(&self.image, 0, &self.staging, start, end - start);
        }
        stats.read_backs += 1;
        self.copy_counts(&mut encoder);
        stats.bytes_down += self.image_bytes() + COUNT_BYTES * self.deciding().count() as u64;
        if let Some(timer) = &self.timer {
            timer.resolve(&mut encoder, timed);
        }
        queue.submit([encoder.finish()]);
        let bytes = read(self.gpu, &self.staging)?;
        stats.wall = begin.elapsed();
        if let Some(timer) = &self.timer {
            stats.stages = self.by_stage(&timer.read(self.gpu, timed)?, &before);
        }
        self.count(&bytes, &mut stats)?;
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

    /// Times of stages: of all bands together, and of those `before` that there were.
    fn by_stage(
        &self,
        times: &[Duration],
        before: &[&'static str],
    ) -> Vec<(&'static str, Duration)> {
        let (bands, own) = times.split_at(self.bands.len() * TIMED.len());
        let mut out = Vec::new();
        for name in BEFORE {
            let times = before.iter().zip(own).filter(|(b, _)| **b == name);
            let mut times = times.map(|(_, time)| *time).peekable();
            if times.peek().is_some() {
                out.push((name, times.sum()));
            }
        }
        for (k, name) in TIMED.into_iter().enumerate() {
            out.push((name, bands.iter().skip(k).step_by(TIMED.len()).sum()));
        }
        out
    }

    pub(super) fn pass<'e>(
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
        let mut pass = self.pass(encoder, DICE, number);
        for c in &self.chunks {
            self.by_block(&self.pipelines.inside, &mut pass, &c.inside, c);
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
                self.by_block(&p.tile, &mut pass, &band.tile[k][phase], c);
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
            for b in &self.named(c)? {
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
