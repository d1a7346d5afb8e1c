//! A step from a level to the next: its stages, and what they are bound to.

use super::mesh::{Counts, Level, most_around, polygon_words};
use crate::gpu::device::Gpu;
use crate::gpu::error::GpuError;
use crate::gpu::pipelines::module;
use crate::gpu::wgsl::{self, ACROSS, Faces, GROUP, MeshStep, Source};
use crate::scheme::loop_scheme;
use crate::surface::Surface;

/// Pipelines of the stages. They share one layout, so that a step has one set of bindings.
#[derive(Clone, Debug)]
pub(super) struct Stages {
    layout: wgpu::BindGroupLayout,
    /// Nothing where faces have no points.
    face: Option<wgpu::ComputePipeline>,
    edge: wgpu::ComputePipeline,
    vertex: wgpu::ComputePipeline,
    halves: wgpu::ComputePipeline,
    edges: wgpu::ComputePipeline,
    vertices: wgpu::ComputePipeline,
}

/// What is the same for all steps of a surface.
pub(super) struct Shared {
    /// See [`polygon_words`]; nothing where all faces are alike.
    polygons: wgpu::Buffer,
    /// Weights of neighbours under Loop's rules, by valence.
    neighbours: wgpu::Buffer,
}

/// A step with its bindings.
#[derive(Debug)]
pub(super) struct Step {
    stages: Stages,
    counts: Counts,
    bindings: wgpu::BindGroup,
}

/// How a buffer is bound.
const UNIFORM: wgpu::BufferBindingType = wgpu::BufferBindingType::Uniform;
const READ: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: true };
const WRITE: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: false };
/// The mesh with its half-edges, the rest and points; the child's; polygons and weights.
const BOUND: [wgpu::BufferBindingType; 10] = [
    UNIFORM, READ, READ, READ, UNIFORM, WRITE, WRITE, WRITE, READ, READ,
];

impl Stages {
    pub(super) fn new(gpu: &Gpu, step: MeshStep) -> Self {
        let device = gpu.device();
        let entries = (0..)
            .zip(BOUND)
            .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer {
                    ty,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            });
        let entries: Vec<_> = entries.collect();
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("levels"),
            entries: &entries,
        });
        let pipelines = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("levels"),
            bind_group_layouts: &[Some(&layout)],
            ..wgpu::PipelineLayoutDescriptor::default()
        });
        let made = |module: &wgpu::ShaderModule, entry| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: Some(&pipelines),
                module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        let of = |source: Source, entry| made(&module(gpu, &source), entry);
        let connectivity = module(gpu, &wgsl::connectivity(step));
        Self {
            face: (step.faces != Faces::Triangles).then(|| of(wgsl::face(step), "face")),
            edge: of(wgsl::edge(step), "edge"),
            vertex: of(wgsl::vertex(step), "vertex"),
            halves: made(&connectivity, "halves_pass"),
            edges: made(&connectivity, "edges_pass"),
            vertices: made(&connectivity, "vertices_pass"),
            layout,
        }
    }
}

impl Shared {
    pub(super) fn new(gpu: &Gpu, surface: &Surface, step: MeshStep) -> Result<Self, GpuError> {
        let t = surface.topology();
        let polygons = match step.faces {
            Faces::Polygons => polygon_words(t),
            Faces::Quads | Faces::Triangles => Vec::new(),
        };
        let neighbours: Vec<u32> = match step.faces {
            Faces::Triangles => {
                let most = most_around(t).max(6);
                let weights = (1..=most).map(|n| loop_scheme::neighbour(n) as f32);
                std::iter::once(0.0)
                    .chain(weights)
                    .map(f32::to_bits)
                    .collect()
            }
            Faces::Quads | Faces::Polygons => Vec::new(),
        };
        Ok(Self {
            polygons: gpu.filled("polygons", &polygons)?,
            neighbours: gpu.filled("weights of neighbours", &neighbours)?,
        })
    }
}

impl Step {
    /// From a level to the next.
    pub(super) fn new(
        gpu: &Gpu,
        stages: &Stages,
        shared: &Shared,
        [parent, child]: [&Level; 2],
    ) -> Self {
        let buffers = [
            &parent.mesh,
            &parent.halves,
            &parent.rest,
            &parent.points,
            &child.mesh,
            &child.halves,
            &child.rest,
            &child.points,
            &shared.polygons,
            &shared.neighbours,
        ];
        let entries = (0..).zip(buffers).map(|(binding, b)| wgpu::BindGroupEntry {
            binding,
            resource: b.as_entire_binding(),
        });
        let entries: Vec<_> = entries.collect();
        let bindings = gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("levels"),
            layout: &stages.layout,
            entries: &entries,
        });
        Self {
            stages: stages.clone(),
            counts: parent.counts,
            bindings,
        }
    }

    /// Makes the connectivity of the child, which has `counts`.
    pub(super) fn connect(&self, gpu: &Gpu, counts: Counts) {
        let mut encoder = gpu
            .device()
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("connectivity"),
            timestamp_writes: None,
        });
        self.run(&mut pass, &self.stages.halves, self.counts.halves);
        self.run(&mut pass, &self.stages.edges, counts.edges);
        self.run(&mut pass, &self.stages.vertices, counts.vertices);
        drop(pass);
        gpu.queue().submit([encoder.finish()]);
    }

    /// Makes the points of the child.
    pub(super) fn encode(&self, pass: &mut wgpu::ComputePass<'_>) {
        let counts = self.counts;
        if let Some(face) = &self.stages.face {
            self.run(pass, face, counts.faces);
        }
        self.run(pass, &self.stages.edge, counts.edges);
        self.run(pass, &self.stages.vertex, counts.vertices);
    }

    fn run(&self, pass: &mut wgpu::ComputePass<'_>, pipeline: &wgpu::ComputePipeline, count: u32) {
        let groups = count.div_ceil(GROUP);
        if groups == 0 {
            return;
        }
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &self.bindings, &[]);
        pass.dispatch_workgroups(groups.min(ACROSS), groups.div_ceil(ACROSS), 1);
    }
}
