//! Pipelines of all stages, made once per device and variant.

use super::device::Gpu;
use super::error::GpuError;
use super::raster::RasterStage;
use super::wgsl::{self, ACROSS, Keys, Source, Variant};
use std::sync::OnceLock;

/// A stage's pipeline.
#[derive(Debug)]
pub(super) struct Stage {
    pub(super) pipeline: wgpu::ComputePipeline,
}

/// All of them.
#[derive(Debug)]
pub(super) struct Pipelines {
    pub(super) sides: Stage,
    pub(super) curves: Stage,
    pub(super) inside: Stage,
    pub(super) tile: Stage,
    pub(super) large: Stage,
    pub(super) shade: Stage,
    pub(super) film: Stage,
    outputs: OnceLock<Stage>,
    raster: OnceLock<RasterStage>,
    variant: Variant,
}

impl Pipelines {
    pub(super) fn new(gpu: &Gpu, variant: Variant) -> Self {
        let keys = if gpu.wide { Keys::Wide } else { Keys::TwoPass };
        let dice = module(gpu, &wgsl::dice(variant));
        Self {
            sides: stage(gpu, &dice, "sides"),
            curves: stage(gpu, &dice, "curves"),
            inside: stage(gpu, &dice, "inside"),
            tile: stage(gpu, &module(gpu, &wgsl::tile(keys, variant)), "main"),
            large: stage(gpu, &module(gpu, &wgsl::large(keys, variant)), "main"),
            shade: stage(gpu, &module(gpu, &wgsl::shade(variant)), "main"),
            film: stage(gpu, &module(gpu, &wgsl::film()), "main"),
            outputs: OnceLock::new(),
            raster: OnceLock::new(),
            variant,
        }
    }

    /// What writes outputs beside the picture, made when they are first asked for.
    pub(super) fn outputs(&self, gpu: &Gpu) -> Result<&Stage, GpuError> {
        if let Some(made) = self.outputs.get() {
            return Ok(made);
        }
        let source = wgsl::outputs(self.variant);
        let made = gpu.caught(|| Ok(stage(gpu, &module(gpu, &source), "main")))?;
        Ok(self.outputs.get_or_init(|| made))
    }

    /// The device's own rasteriser: nothing of it is made before it is asked for.
    pub(super) fn raster(&self, gpu: &Gpu) -> Result<&RasterStage, GpuError> {
        if let Some(made) = self.raster.get() {
            return Ok(made);
        }
        let made = gpu.caught(|| RasterStage::new(gpu, self.variant))?;
        Ok(self.raster.get_or_init(|| made))
    }
}

pub(super) fn module(gpu: &Gpu, source: &Source) -> wgpu::ShaderModule {
    gpu.device()
        .create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(source.name),
            source: wgpu::ShaderSource::Wgsl(source.text.as_str().into()),
        })
}

pub(super) fn stage(gpu: &Gpu, module: &wgpu::ShaderModule, entry: &'static str) -> Stage {
    let pipeline = gpu
        .device()
        .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: None,
            module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
    Stage { pipeline }
}

/// Binds buffers and textures to the numbers that a source gives them.
pub(super) fn bind(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    buffers: &[(u32, &wgpu::Buffer)],
    textures: &[(u32, &wgpu::TextureView)],
) -> wgpu::BindGroup {
    let buffers = buffers.iter().map(|&(binding, b)| wgpu::BindGroupEntry {
        binding,
        resource: b.as_entire_binding(),
    });
    let textures = textures.iter().map(|&(binding, t)| wgpu::BindGroupEntry {
        binding,
        resource: wgpu::BindingResource::TextureView(t),
    });
    let entries: Vec<wgpu::BindGroupEntry<'_>> = buffers.chain(textures).collect();
    gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout,
        entries: &entries,
    })
}

impl Stage {
    /// Binds buffers to the numbers that the source gives them.
    pub(super) fn bind(&self, gpu: &Gpu, buffers: &[(u32, &wgpu::Buffer)]) -> wgpu::BindGroup {
        bind(gpu, &self.pipeline.get_bind_group_layout(0), buffers, &[])
    }

    /// Runs `groups` workgroups, in rows of [`ACROSS`].
    pub(super) fn run(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        bindings: &wgpu::BindGroup,
        groups: u32,
    ) {
        if groups == 0 {
            return;
        }
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, bindings, &[]);
        pass.dispatch_workgroups(groups.min(ACROSS), groups.div_ceil(ACROSS), 1);
    }
}
