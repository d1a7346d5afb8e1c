//! Whole-mesh levels on the device: control points after some steps of Catmull-Clark, Loop or the bilinear scheme, with their connectivity, and the
//! limit of the last, in buffers that the caller draws from.
//!
//! Every point is gathered from its neighbours, in stages named as on the processor: `face`, `edge`, `vertex`, `connectivity`, `limit`.
//! Connectivity follows by formulas and is made once; when points move, only points are made again.

mod limit;
mod mesh;
mod step;

use super::device::Gpu;
use super::dicer::MOST_AROUND;
use super::error::GpuError;
use super::read_back::read_floats;
use super::timer::{self, Timer};
use super::wgsl::{Faces, MeshStep};
use crate::dice::MAX_LEVEL;
use crate::scheme::{CreaseMethod, Scheme, TriangleRule};
use crate::surface::Surface;
use limit::LimitBuffers;
use mesh::{Counts, Level, TOO_LARGE, most_around};
use std::time::{Duration, Instant};
use step::{Shared, Stages, Step};

/// Refines a cage on a device, level by level.
///
/// Made for a device and queue of the caller's ([`Gpu::of_device`]). [`Refiner::encode`] appends the work to an encoder; the results lie in
/// [`Refiner::points`] and [`Refiner::corners`], and on demand in [`Refiner::limit_points`] and [`Refiner::normals`]: storage buffers that
/// shaders of the caller may read.
///
/// Polygons become quads with the first level. Faces that are holes are among the rest. Neither texture coordinates nor colours are refined.
#[derive(Debug)]
pub struct Refiner {
    levels: Vec<Level>,
    steps: Vec<Step>,
    limit: Option<LimitBuffers>,
}

/// Storage buffers that a stage binds, which is what WebGPU promises.
const STORAGE_BUFFERS: u32 = 8;

fn check(gpu: &Gpu, surface: &Surface, levels: u32) -> Result<(), GpuError> {
    let t = surface.topology();
    let refuse = |what| Err(GpuError::Unsupported { what });
    if gpu.device().limits().max_storage_buffers_per_shader_stage < STORAGE_BUFFERS {
        return refuse("levels on a device whose stages bind fewer than 8 storage buffers");
    }
    if levels > MAX_LEVEL {
        return refuse("levels above 10");
    }
    if surface.scheme().is_interpolating() {
        return refuse("levels of interpolating schemes");
    }
    let manifold = t.fans().len() == t.vertex_count()
        && (0..t.half_count() as u32).all(|h| {
            let own = t.edge_half(t.edge(h));
            own == h || t.twin(h) == own
        });
    if !manifold {
        return refuse("levels of cages that are not manifold");
    }
    // The ends of an edge each walk around their vertex.
    let chaikin = surface.refine_options().creases == CreaseMethod::Chaikin;
    if chaikin && most_around(t) > MOST_AROUND {
        return refuse("levels with Chaikin creases and vertices of more than 512 faces");
    }
    // Before anything is made.
    let triangles = surface.scheme().is_triangular();
    let mut counts = Counts::of(t);
    counts.sizes(gpu)?;
    for _ in 0..levels {
        counts = counts.next(triangles).ok_or(TOO_LARGE)?;
        counts.sizes(gpu)?;
    }
    Ok(())
}

/// The first step of a surface; further ones are of quads or triangles.
fn first_step(surface: &Surface) -> MeshStep {
    let options = surface.refine_options();
    MeshStep {
        faces: match (
            surface.scheme().is_triangular(),
            surface.topology().all_quads(),
        ) {
            (true, _) => Faces::Triangles,
            (false, true) => Faces::Quads,
            (false, false) => Faces::Polygons,
        },
        linear: options.scheme == Scheme::Bilinear,
        chaikin: options.creases == CreaseMethod::Chaikin,
        smooth_triangles: options.triangles == TriangleRule::Smooth,
    }
}

impl Refiner {
    /// A refiner of `surface`'s cage, by `levels` steps (0 to 10; 0 is the cage itself), with the points that it has now.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for interpolating schemes, cages that are not manifold, Chaikin creases with more than 512 faces around a vertex,
    /// more than 10 levels, and devices whose stages bind fewer than 8 storage buffers; what the device cannot hold.
    pub fn new(gpu: &Gpu, surface: &Surface, levels: u32) -> Result<Self, GpuError> {
        check(gpu, surface, levels)?;
        gpu.caught(|| Self::on(gpu, surface, levels))
    }

    /// The same with the limit of the last level: where its vertices end up, and the unit normals there.
    ///
    /// # Errors
    /// As [`Refiner::new`]; [`GpuError::Unsupported`] also where creases still fade at the last level, for polygons at level 0, and for vertices
    /// of more than 512 faces and faces of as many corners.
    pub fn with_limit(gpu: &Gpu, surface: &Surface, levels: u32) -> Result<Self, GpuError> {
        check(gpu, surface, levels)?;
        limit::check(surface, levels)?;
        gpu.caught(|| {
            let mut made = Self::on(gpu, surface, levels)?;
            let step = first_step(surface).next();
            let last = (levels, made.last());
            made.limit = Some(LimitBuffers::new(gpu, surface, step, last)?);
            Ok(made)
        })
    }

    fn on(gpu: &Gpu, surface: &Surface, levels: u32) -> Result<Self, GpuError> {
        let mut made = Self {
            levels: vec![Level::of_cage(gpu, surface)?],
            steps: Vec::new(),
            limit: None,
        };
        let mut step = first_step(surface);
        let shared = Shared::new(gpu, surface, step)?;
        let mut stages = None;
        for _ in 0..levels {
            let stages = match &mut stages {
                Some((of, stages)) if *of == step => stages,
                other => &mut other.insert((step, Stages::new(gpu, step))).1,
            };
            let triangles = step.faces == Faces::Triangles;
            step = step.next();
            let parent = made.last();
            let counts = parent.counts.next(triangles).ok_or(TOO_LARGE)?;
            let child = Level::empty(gpu, counts)?;
            let step = Step::new(gpu, stages, &shared, [parent, &child]);
            step.connect(gpu, counts);
            made.levels.push(child);
            made.steps.push(step);
        }
        Ok(made)
    }

    fn last(&self) -> &Level {
        &self.levels[self.levels.len() - 1]
    }

    /// Moves the cage's points, three numbers each.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] where there are not as many as before.
    pub fn move_points(&self, queue: &wgpu::Queue, points: &[[f32; 3]]) -> Result<(), GpuError> {
        if points.len() != self.levels[0].counts.vertices as usize {
            return Err(GpuError::Unsupported {
                what: "another number of points than the cage has",
            });
        }
        queue.write_buffer(&self.levels[0].points, 0, bytemuck::cast_slice(points));
        Ok(())
    }

    /// Appends the refinement of all levels to `encoder`. Nothing is read back.
    pub fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        self.encode_timed(encoder, None);
    }

    fn encode_timed(&self, encoder: &mut wgpu::CommandEncoder, times: Option<&Timer>) {
        let mut pass = timer::pass(times, encoder, "levels", 0);
        for step in &self.steps {
            step.encode(&mut pass);
        }
        if let Some(limit) = &self.limit {
            limit.encode(&mut pass);
        }
    }

    /// Refines, waits, and says how long it took: on the device where that keeps time, else until it was done.
    ///
    /// # Errors
    /// [`GpuError`] of the device.
    pub fn timed(&self, gpu: &Gpu) -> Result<Duration, GpuError> {
        gpu.caught(|| self.timed_on(gpu))
    }

    fn timed_on(&self, gpu: &Gpu) -> Result<Duration, GpuError> {
        let times = Timer::of_stages(gpu, 1)?;
        let mut encoder = gpu
            .device()
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let begin = Instant::now();
        self.encode_timed(&mut encoder, times.as_ref());
        if let Some(times) = &times {
            times.resolve(&mut encoder, 1);
        }
        gpu.queue().submit([encoder.finish()]);
        gpu.wait()?;
        match times {
            Some(times) => Ok(times.read(gpu, 1)?.iter().sum()),
            None => Ok(begin.elapsed()),
        }
    }

    /// Points of the last level: three `f32` each, in the order of [`refine::Level`](crate::refine::Level). A storage buffer.
    #[must_use]
    pub fn points(&self) -> &wgpu::Buffer {
        &self.last().points
    }

    /// Where the vertices of the last level end up: three `f32` each. A storage buffer; nothing without [`Refiner::with_limit`].
    #[must_use]
    pub fn limit_points(&self) -> Option<&wgpu::Buffer> {
        self.limit.as_ref().map(|limit| &limit.points)
    }

    /// Unit normals of the limit, outward: three `f32` for every corner of [`Refiner::corners`], the same around a vertex unless sharp edges meet
    /// there. Where tangents are parallel they are those of the faces around. A storage buffer; nothing without [`Refiner::with_limit`].
    #[must_use]
    pub fn normals(&self) -> Option<&wgpu::Buffer> {
        self.limit.as_ref().map(|limit| &limit.normals)
    }

    /// The faces of the last level: four vertices each (of Loop's triangles three; of a cage's own polygons as many as they have), as `u32`, before
    /// anything else that the buffer holds; counter-clockwise. A storage buffer.
    #[must_use]
    pub fn corners(&self) -> &wgpu::Buffer {
        &self.last().halves
    }

    /// Faces of the last level.
    #[must_use]
    pub fn face_count(&self) -> u32 {
        self.last().counts.faces
    }

    /// Vertices of the last level.
    #[must_use]
    pub fn vertex_count(&self) -> u32 {
        self.last().counts.vertices
    }

    /// Points and corners of a level, read back for tests.
    ///
    /// # Errors
    /// [`GpuError`] of the device.
    #[doc(hidden)]
    pub fn read(&self, gpu: &Gpu, level: usize) -> Result<(Vec<f32>, Vec<u32>), GpuError> {
        let level = &self.levels[level];
        let points = read_words(gpu, &level.points, 3 * level.counts.vertices)?;
        let corners = read_words(gpu, &level.halves, level.counts.halves)?;
        Ok((points, corners.iter().map(|c| c.to_bits()).collect()))
    }

    /// Limit points and normals, read back for tests; nothing without [`Refiner::with_limit`].
    ///
    /// # Errors
    /// [`GpuError`] of the device.
    #[doc(hidden)]
    pub fn read_limit(&self, gpu: &Gpu) -> Result<Option<[Vec<f32>; 2]>, GpuError> {
        let Some(limit) = &self.limit else {
            return Ok(None);
        };
        let counts = self.last().counts;
        Ok(Some([
            read_words(gpu, &limit.points, 3 * counts.vertices)?,
            read_words(gpu, &limit.normals, 3 * counts.halves)?,
        ]))
    }
}

fn read_words(gpu: &Gpu, buffer: &wgpu::Buffer, count: u32) -> Result<Vec<f32>, GpuError> {
    read_floats(gpu, buffer, 4 * u64::from(count))
}
