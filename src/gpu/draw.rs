//! A scene on a device, and its pictures.

use super::bands::{Bands, Shared, TIMED};
use super::deciding;
use super::device::Gpu;
use super::error::GpuError;
use super::flatness::COUNT_BYTES;
use super::further::Further;
use super::pipelines::Pipelines;
use super::plan::{Plan, plan};
use super::raster::Raster;
use super::read_back::{ReadBlock, read, read_floats};
use super::ready::Ready;
use super::records::{POINT_FLOATS, words};
use super::stats::{GpuFrame, GpuStats};
use super::timer::{self, Timer};
use super::upload::{DeviceChunk, device_chunk, materials, point_words, textures};
use super::view::{Drawn, frame_record};
use super::wgsl::{STILL, Variant};
use crate::camera::{Camera, View};
use crate::film::{Film, Image};
use crate::frame::{Aov, Renderer, Scene};
use crate::limits::{Budget, Limits};
use std::time::{Duration, Instant};

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
    /// Most micro-faces of a picture.
    pub(super) limits: Limits,
    pub(super) chunks: Vec<DeviceChunk>,
    pub(super) bands: Bands,
    pub(super) timer: Option<Timer>,
    stats: GpuStats,
}

impl std::fmt::Debug for GpuScene<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("GpuScene")
            .field("chunks", &self.chunks.len())
            .finish_non_exhaustive()
    }
}

/// Stages that only new views and moved points need. Their times are last, because pictures may go without.
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
        let (ready, drawn) = Ready::of(renderer, (scene, &view), plan, gpu.max_binding, budget)?;
        let mut made = gpu.caught(|| Self::upload(gpu, drawn, scene, view, ready, budget))?;
        made.decided_by = renderer.decided_by;
        made.raster_by(gpu.raster)?;
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
        let Ready {
            chunks,
            points: control_points,
            further,
            heights,
            values,
            outputs,
            mut stats,
        } = ready;
        let looks = || chunks.iter().map(|c| c.look);
        let pipelines = gpu.pipelines(Variant {
            lifted: looks().any(|l| l.rise.shape != STILL),
            tilted: looks().any(|l| l.tilted),
            cut: looks().any(|l| l.cut),
            listed: chunks.iter().any(|c| !c.lists.is_empty()),
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
        let shared = Shared {
            materials,
            textures,
            heights,
        };
        let bands = Bands::new(gpu, pipelines, (drawn.size, outputs), &made, shared, budget)?;
        stats.chunks = made.len() as u32;
        stats.bands = bands.len() as u32;
        stats.scene_bytes = scene_bytes;
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
            limits: Limits {
                max_faces: budget.limits().max_faces,
                ..Limits::default()
            },
            stats,
            chunks: made,
            bands,
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
    /// whether blocks are not decided by the view that it was made for, and levels are the same. A picture of blocks that the device decides on
    /// may fall short all the same ([`GpuScene::draw_view`]).
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

    /// Moves the control points of all objects, one after the other in the order of the scene; they go up with the next picture. Which
    /// vertices have no tangent plane, because two sides of a slit lie at one place, is told by the points that the scene was made with.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] where there are not as many as before, some of PN triangles are not finite, or positions are written beside the
    /// picture, whose range is that of the points before.
    pub fn move_points(&mut self, points: &[[f32; 3]]) -> Result<(), GpuError> {
        if points.len() != self.control_points.len() {
            return Err(GpuError::Unsupported {
                what: "another number of points than the scene was made with",
            });
        }
        if self.bands.outputs().wants(Aov::Position) {
            return Err(GpuError::Unsupported {
                what: "positions beside the picture of points that moved",
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
    /// As [`GpuScene::draw_view`].
    pub fn draw(&mut self) -> Result<GpuFrame, GpuError> {
        let view = self.view;
        self.draw_view(&view)
    }

    /// Draws through another view of the same size. Where the device decides on blocks, [`GpuStats::falls_short`] says whether they are coarser
    /// than asked for.
    ///
    /// # Errors
    /// [`GpuError`] of the device; [`GpuError::OutOfMemory`] also where a view asks for more blocks than there is room for.
    pub fn draw_view(&mut self, view: &View) -> Result<GpuFrame, GpuError> {
        if view.size != self.drawn.size {
            return Err(GpuError::Unsupported {
                what: "views of another size than the scene was made for",
            });
        }
        let gpu = self.gpu;
        let drawn = gpu.caught(|| self.drawn_from(view));
        if drawn.is_err() {
            // Nobody knows what was done of it.
            (self.moved, self.sided, self.decided_for) = (true, false, None);
        }
        drawn
    }

    fn drawn_from(&mut self, view: &View) -> Result<GpuFrame, GpuError> {
        let begin = Instant::now();
        let mut stats = self.stats.clone();
        stats.scene_bytes += self.bands.bytes();
        stats.raster = match self.bands.by_hardware {
            Some(_) => Raster::Hardware,
            None => Raster::Compute,
        };
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
        stats.bytes_up += self.bands.send(queue, frame_record(&self.drawn, view));
        let mut before = Vec::new();
        stats.bytes_up += self.encode_flatness(&mut encoder, view, &mut before)?;
        if !self.diced {
            self.encode_dice(&mut encoder, self.first_before() + before.len() as u32);
            self.diced = true;
            before.push(DICE);
        }
        let timed = self.first_before() + before.len() as u32;
        let drawn = (self.pipelines, &*self.chunks);
        let timer = self.timer.as_ref();
        (self.bands).encode(self.gpu, &mut encoder, drawn, timer)?;
        let [picture, down] = self.bands.down();
        stats.read_backs += 1;
        self.copy_counts(&mut encoder);
        stats.bytes_down += down + COUNT_BYTES * self.deciding().count() as u64;
        if let Some(timer) = &self.timer {
            timer.resolve(&mut encoder, timed);
        }
        queue.submit([encoder.finish()]);
        let bytes = read(self.gpu, self.bands.staging(), ..)?;
        stats.wall = begin.elapsed();
        if let Some(timer) = &self.timer {
            stats.stages = self.by_stage(&timer.read(self.gpu, timed)?, &before);
        }
        self.count(&bytes[down as usize..], &mut stats)?;
        let mut image = Image::new(self.drawn.size.width, self.drawn.size.height);
        // Buffers are a little longer.
        let (pixels, codes) = bytes[..down as usize].split_at(picture as usize);
        image.data.copy_from_slice(pixels);
        let planes = self.bands.outputs().planes(view, codes);
        let empty = Film::new(self.drawn.mode.encoding(), self.drawn.background).empty();
        stats.pixels_covered = image.data.chunks_exact(4).filter(|p| **p != empty).count() as u64;
        Ok(GpuFrame {
            image,
            planes,
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
        for (k, name) in self.bands.timed().into_iter().enumerate() {
            out.push((name, bands.iter().skip(k).step_by(TIMED.len()).sum()));
        }
        out
    }

    /// Micro-triangles as they were planned; 0 where the device decides.
    pub(super) fn planned_triangles(&self) -> u64 {
        self.stats.microtriangles
    }

    fn encode_dice(&self, encoder: &mut wgpu::CommandEncoder, number: u32) {
        let mut pass = timer::pass(self.timer.as_ref(), encoder, DICE, number);
        for c in &self.chunks {
            c.by_block(&self.pipelines.inside, &mut pass, &c.inside);
        }
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
