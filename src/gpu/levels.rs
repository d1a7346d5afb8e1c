//! Whole-mesh levels on the device: control points after some steps of Catmull-Clark, with their connectivity, in buffers that the caller
//! draws from.
//!
//! Every point is gathered from its neighbours, in stages named as on the processor: `face`, `edge`, `vertex`, `connectivity`. Connectivity
//! follows by formulas and is made once; when points move, only points are made again.

use super::device::Gpu;
use super::error::GpuError;
use super::pipelines::{Stage, module, stage};
use super::records::{Record, Step, words};
use super::timer::{self, Timer};
use super::wgsl::{self, ALIGN, GROUP};
use crate::dice::MAX_LEVEL;
use crate::scheme::{CreaseMethod, Scheme};
use crate::surface::Surface;
use crate::topology::{NONE, Topology};
use std::time::{Duration, Instant};
use wgpu::BufferUsages as Usage;

/// Refines a cage of quads on a device, level by level.
///
/// Made for a device and queue of the caller's ([`Gpu::of_device`]). [`Refiner::encode`] appends the work to an encoder; the results lie in
/// [`Refiner::points`] and [`Refiner::corners`], which shaders of the caller may read.
#[derive(Debug)]
pub struct Refiner {
    stages: Stages,
    levels: Vec<Level>,
    steps: Vec<StepBuffers>,
}

#[derive(Debug)]
struct Stages {
    face: Stage,
    edge: Stage,
    vertex: Stage,
    halves: Stage,
    edges: Stage,
    vertices: Stage,
}

/// A level's buffers. Half-edges hold vertices, twins and edges; the rest half-edges of edges, first half-edges of vertices, sharpness.
#[derive(Debug)]
struct Level {
    counts: Counts,
    halves: wgpu::Buffer,
    rest: wgpu::Buffer,
    points: wgpu::Buffer,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Counts {
    vertices: u32,
    edges: u32,
    faces: u32,
}

#[derive(Debug)]
struct StepBuffers {
    counts: Counts,
    face: wgpu::BindGroup,
    edge: wgpu::BindGroup,
    vertex: wgpu::BindGroup,
}

impl Counts {
    fn next(self) -> Option<Self> {
        let Self {
            vertices,
            edges,
            faces,
        } = self;
        let next = Self {
            vertices: vertices.checked_add(edges)?.checked_add(faces)?,
            edges: edges.checked_mul(2)?.checked_add(faces.checked_mul(4)?)?,
            faces: faces.checked_mul(4)?,
        };
        Some(next)
    }
    fn halves(self) -> u64 {
        4 * u64::from(self.faces)
    }
    fn record(self) -> Step {
        Step {
            vertices: self.vertices,
            edges: self.edges,
            faces: self.faces,
            padding: 0,
        }
    }
}

/// A part of a buffer as a binding.
#[derive(Clone, Copy)]
struct Part<'a> {
    buffer: &'a wgpu::Buffer,
    words: [u64; 2],
}

const TOO_LARGE: GpuError = GpuError::OutOfMemory {
    what: "a level of this size in one buffer",
};

fn check(surface: &Surface, levels: u32) -> Result<(), GpuError> {
    let t = surface.topology();
    let options = surface.refine_options();
    let refuse = |what| Err(GpuError::Unsupported { what });
    if levels > MAX_LEVEL {
        return refuse("levels above 10");
    }
    if surface.scheme() != Scheme::CatmullClark {
        return refuse("levels of other schemes than Catmull-Clark");
    }
    if !t.all_quads() {
        return refuse("levels of cages with other polygons than quads");
    }
    if options.creases != CreaseMethod::Uniform {
        return refuse("levels with Chaikin creases");
    }
    let manifold = t.fans().len() == t.vertex_count()
        && (0..t.half_count() as u32).all(|h| {
            let own = t.edge_half(t.edge(h));
            own == h || t.twin(h) == own
        });
    if !manifold {
        return refuse("levels of cages that are not manifold");
    }
    Ok(())
}

impl Refiner {
    /// A refiner of `surface`'s cage, by `levels` steps (0 to 10; 0 is the cage itself), with the points that it has now.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] unless the cage is a manifold of quads under Catmull-Clark with uniform creases; what the device cannot hold.
    pub fn new(gpu: &Gpu, surface: &Surface, levels: u32) -> Result<Self, GpuError> {
        check(surface, levels)?;
        gpu.caught(|| Self::on(gpu, surface, levels))
    }

    fn on(gpu: &Gpu, surface: &Surface, levels: u32) -> Result<Self, GpuError> {
        let points_source = |source: &wgsl::Source, entry| stage(gpu, &module(gpu, source), entry);
        let connectivity = module(gpu, &wgsl::connectivity());
        let stages = Stages {
            face: points_source(&wgsl::face(), "face"),
            edge: points_source(&wgsl::edge(), "edge"),
            vertex: points_source(&wgsl::vertex(), "vertex"),
            halves: stage(gpu, &connectivity, "halves_pass"),
            edges: stage(gpu, &connectivity, "edges_pass"),
            vertices: stage(gpu, &connectivity, "vertices_pass"),
        };
        let mut made = Self {
            stages,
            levels: vec![first_level(gpu, surface)?],
            steps: Vec::new(),
        };
        for _ in 0..levels {
            made.add_level(gpu)?;
        }
        Ok(made)
    }

    fn last(&self) -> &Level {
        &self.levels[self.levels.len() - 1]
    }

    /// Makes room for the next level and its connectivity.
    fn add_level(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        let parent = self.last();
        let counts = parent.counts.next().ok_or(TOO_LARGE)?;
        let level = empty_level(gpu, counts)?;
        let step = gpu.empty("step", Step::SIZE as u64, Usage::UNIFORM | Usage::COPY_DST)?;
        let record = words(&[parent.counts.record()]);
        gpu.queue()
            .write_buffer(&step, 0, bytemuck::cast_slice(&record));
        let shared = |stage: &Stage, own: &[u32], extra: &[(u32, &wgpu::Buffer)]| {
            let parts = parent.parts();
            let mut entries = vec![entry(0, Part::whole(&step))];
            let used = (1..).zip(parts).filter(|(n, _)| own.contains(n));
            entries.extend(used.map(|(n, part)| entry(n, part)));
            entries.extend(extra.iter().map(|&(n, b)| entry(n, Part::whole(b))));
            gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &stage.pipeline.get_bind_group_layout(0),
                entries: &entries,
            })
        };
        let s = &self.stages;
        let points = [(7, &parent.points), (8, &level.points)];
        let buffers = StepBuffers {
            counts: parent.counts,
            face: shared(&s.face, &[1], &points),
            edge: shared(&s.edge, &[1, 2, 4, 6], &points),
            vertex: shared(&s.vertex, &[1, 2, 3, 5, 6], &points),
        };
        let halves = [(7, &level.halves)];
        let rest = [(8, &level.rest)];
        let made = [
            (
                &s.halves,
                shared(&s.halves, &[1, 2, 3, 4], &halves),
                parent.counts.halves(),
            ),
            (
                &s.edges,
                shared(&s.edges, &[1, 2, 3, 4, 6], &rest),
                parent.counts.halves() + 2 * u64::from(parent.counts.edges),
            ),
            (
                &s.vertices,
                shared(&s.vertices, &[2, 4, 5, 6], &rest),
                u64::from(counts.vertices),
            ),
        ];
        let mut encoder = gpu
            .device()
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("connectivity"),
            timestamp_writes: None,
        });
        for (stage, bindings, count) in &made {
            stage.run(&mut pass, bindings, groups(*count));
        }
        drop(pass);
        gpu.queue().submit([encoder.finish()]);
        self.levels.push(level);
        self.steps.push(buffers);
        Ok(())
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
            let s = &self.stages;
            let c = step.counts;
            s.face.run(&mut pass, &step.face, groups(c.faces.into()));
            s.edge.run(&mut pass, &step.edge, groups(c.edges.into()));
            s.vertex
                .run(&mut pass, &step.vertex, groups(c.vertices.into()));
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

    /// Its quads: four vertices each, as `u32`, before anything else that the buffer holds; counter-clockwise. A storage buffer.
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
        let bytes = 12 * u64::from(level.counts.vertices);
        let points = super::read_back::read_floats(gpu, &level.points, bytes)?;
        let corners = super::read_back::read_floats(gpu, &level.halves, 4 * level.counts.halves())?;
        Ok((points, corners.iter().map(|c| c.to_bits()).collect()))
    }
}

fn groups(count: u64) -> u32 {
    count.div_ceil(u64::from(GROUP)) as u32
}

impl<'a> Part<'a> {
    fn whole(buffer: &'a wgpu::Buffer) -> Self {
        Self {
            buffer,
            words: [0, buffer.size() / 4],
        }
    }
}

fn entry(binding: u32, part: Part<'_>) -> wgpu::BindGroupEntry<'_> {
    let [start, count] = part.words;
    wgpu::BindGroupEntry {
        binding,
        resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: part.buffer,
            offset: 4 * start,
            size: std::num::NonZeroU64::new(4 * count),
        }),
    }
}

impl Level {
    /// Vertices, twins and edges of half-edges, half-edges of edges, first half-edges, sharpness.
    fn parts(&self) -> [Part<'_>; 6] {
        let c = self.counts;
        let [twins, edges] = half_parts(c);
        let [firsts, sharpness] = rest_parts(c);
        let half = |start| Part {
            buffer: &self.halves,
            words: [start, c.halves()],
        };
        let rest = |start, count: u64| Part {
            buffer: &self.rest,
            words: [start, count],
        };
        let (e, v) = (u64::from(c.edges), u64::from(c.vertices));
        [
            half(0),
            half(twins),
            half(edges),
            rest(0, e),
            rest(firsts, v),
            rest(sharpness, e + v),
        ]
    }
}

/// Where twins and edges begin among the words of half-edges.
fn half_parts(c: Counts) -> [u64; 2] {
    let stride = c.halves().next_multiple_of(u64::from(ALIGN));
    [stride, 2 * stride]
}

/// Where first half-edges and sharpness begin in the rest.
fn rest_parts(c: Counts) -> [u64; 2] {
    let firsts = u64::from(c.edges).next_multiple_of(u64::from(ALIGN));
    let sharpness = firsts + u64::from(c.vertices).next_multiple_of(u64::from(ALIGN));
    [firsts, sharpness]
}

fn empty_level(gpu: &Gpu, counts: Counts) -> Result<Level, GpuError> {
    let usage = Usage::STORAGE | Usage::COPY_DST | Usage::COPY_SRC;
    let [_, edges] = half_parts(counts);
    let [_, sharpness] = rest_parts(counts);
    let rest = sharpness + u64::from(counts.edges) + u64::from(counts.vertices);
    let sizes = [
        4 * (edges + counts.halves()),
        4 * rest,
        12 * u64::from(counts.vertices),
    ];
    // Their numbers are words of the shaders.
    let words = edges + counts.halves();
    if words > u64::from(u32::MAX) || sizes.iter().any(|&bytes| bytes > gpu.max_binding) {
        return Err(TOO_LARGE);
    }
    let [halves, rest, points] = sizes;
    Ok(Level {
        counts,
        halves: gpu.empty("half-edges", halves, usage | Usage::INDEX)?,
        rest: gpu.empty("edges", rest, usage)?,
        points: gpu.empty("points", points, usage | Usage::VERTEX)?,
    })
}

fn first_level(gpu: &Gpu, surface: &Surface) -> Result<Level, GpuError> {
    let t: &Topology = surface.topology();
    let counts = Counts {
        vertices: t.vertex_count() as u32,
        edges: t.edge_count() as u32,
        faces: t.face_count() as u32,
    };
    let level = empty_level(gpu, counts)?;
    let halves = 0..t.half_count() as u32;
    let edges = 0..counts.edges;
    let put = |buffer: &wgpu::Buffer, at: u64, words: Vec<u32>| {
        gpu.queue()
            .write_buffer(buffer, 4 * at, bytemuck::cast_slice(&words));
    };
    let [twins, edge_start] = half_parts(counts);
    put(
        &level.halves,
        0,
        halves.clone().map(|h| t.vertex(h)).collect(),
    );
    put(
        &level.halves,
        twins,
        halves.clone().map(|h| t.twin(h)).collect(),
    );
    put(
        &level.halves,
        edge_start,
        halves.map(|h| t.edge(h)).collect(),
    );
    let [firsts, sharpness] = rest_parts(counts);
    put(
        &level.rest,
        0,
        edges.clone().map(|e| t.edge_half(e)).collect(),
    );
    let first = t
        .fans()
        .iter()
        .map(|f| if f.faces == 0 { NONE } else { f.first });
    put(&level.rest, firsts, first.collect());
    let sharp = edges.map(|e| t.edge_sharpness(e));
    let sharp = sharp.chain((0..counts.vertices).map(|v| t.vertex_sharpness(v)));
    put(&level.rest, sharpness, sharp.map(f32::to_bits).collect());
    let points = surface.control_base().iter().flatten();
    put(&level.points, 0, points.map(|c| c.to_bits()).collect());
    Ok(level)
}
