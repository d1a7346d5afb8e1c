//! Stage `raster`: keys by the device's own rasteriser, in place of the compute stages `tile` and `large`.
//!
//! A pass draws one sample of every pixel of a band: all chunks into a target of ids and one of depths, of which a compute pass makes keys. Corners
//! lie on the 1/256 pixel that the compute stages snap to, moved by the place of the sample, so the target's pixel centres are our samples,
//! for any number of them, and what is covered is decided by the same edges and the same rule. For that the viewport is a square whose side is a
//! power of two: nothing of a snapped corner is rounded on the way through clip space. A device whose rasteriser keeps fewer than eight bits of a pixel (Vulkan
//! asks for four) snaps corners again, coarser.
//!
//! Depths grow towards the eye, near / w, in 32-bit floats (Reed, Depth precision visualized, 2015). Of equal depths the first that is drawn
//! stays: of the lowest chunk, of grids before lists, of smaller blocks before larger ones, then of the lowest id; in the compute stages it is
//! the lowest id. Depths are interpolated by the device, so which are equal is its own affair.

use super::device::Gpu;
use super::error::GpuError;
use super::order::{Order, grid_corners};
use super::pipelines::{Pipelines, Stage, bind, module, stage};
use super::records::Target;
use super::timer::{self, Timer};
use super::upload::{DeviceChunk, uniform};
use super::wgsl::{self, GROUP, Variant};
use crate::records::ScreenSize;
use std::collections::HashMap;
use std::sync::Mutex;

/// What draws keys.
///
/// Both ways draw the same picture but for samples within about 1/256 pixel of an edge, ties in depth, and triangles through the near plane or
/// far beyond the picture, which the device clips itself. Which is quicker depends on device, picture and sizes of triangles. The default is
/// never a measured one: timings vary, and with them bytes would, from run to run on one machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Raster {
    /// Compute stages `tile` and `large`: the same bytes every time on one device, and on devices with little or no graphics throughput
    /// the quicker way.
    #[default]
    Compute,
    /// The device's own rasteriser, stage `raster`, one pass for each sample of a pixel.
    Hardware,
    /// Whichever of both was quicker on this device when a picture of this size and about as many micro-triangles was first made ready:
    /// both then draw it. Scenes whose blocks the device decides on count as one number.
    Measured,
}

/// What was measured on a device: by width, height, samples, and micro-triangles as a power of two.
pub(super) type Measured = Mutex<HashMap<[u32; 4], Raster>>;

/// Name of the stage.
pub(super) const RASTER: &str = "raster";

const IDS: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
const DEPTHS: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Its pipelines.
#[derive(Debug)]
pub(super) struct RasterStage {
    draw: wgpu::RenderPipeline,
    collect: Stage,
    by_size: Stage,
    corners: wgpu::Buffer,
}

impl RasterStage {
    pub(super) fn new(gpu: &Gpu, variant: Variant) -> Result<Self, GpuError> {
        let all = grid_corners();
        let usage = wgpu::BufferUsages::INDEX | wgpu::BufferUsages::COPY_DST;
        let corners = gpu.empty("corners of grids", 2 * all.len() as u64, usage)?;
        gpu.queue()
            .write_buffer(&corners, 0, bytemuck::cast_slice(&all));
        let module = module(gpu, &wgsl::raster(variant));
        let number = wgpu::VertexAttribute {
            format: wgpu::VertexFormat::Uint32,
            offset: 0,
            shader_location: 0,
        };
        let blocks = wgpu::VertexBufferLayout {
            array_stride: 4,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &[number],
        };
        let descriptor = wgpu::RenderPipelineDescriptor {
            label: Some(RASTER),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("corner"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[Some(blocks)],
            },
            // Both sides are drawn.
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTHS,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("seen"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(IDS.into())],
            }),
            multiview_mask: None,
            cache: None,
        };
        Ok(Self {
            draw: gpu.device().create_render_pipeline(&descriptor),
            collect: stage(gpu, &module, "collect"),
            by_size: stage(gpu, &module, "by_size"),
            corners,
        })
    }
}

/// What a sample of a band is drawn by: its number for both passes.
#[derive(Debug)]
struct SamplePass {
    draw: wgpu::BindGroup,
    collect: wgpu::BindGroup,
}

/// What a band binds.
#[derive(Debug)]
struct BandPass {
    rows: u32,
    /// Per chunk.
    draw: Vec<wgpu::BindGroup>,
    collect: wgpu::BindGroup,
}

/// The targets of a picture, and what is bound for it.
#[derive(Debug)]
pub(super) struct HardwareRaster {
    width: u32,
    ids: wgpu::TextureView,
    depths: wgpu::TextureView,
    /// Pixels along the side of the viewport.
    side: u32,
    samples: Vec<SamplePass>,
    bands: Vec<BandPass>,
    /// Per chunk.
    orders: Vec<Order>,
    target_bytes: u64,
}

/// What a picture is drawn into, and which bands it has: the uniform of each, its rows, and what the stage binds of each chunk beside.
pub(super) struct Picture<'a> {
    pub(super) size: ScreenSize,
    pub(super) keys: &'a wgpu::Buffer,
    pub(super) bands: Vec<PictureBand<'a>>,
}

/// One of these bands.
pub(super) struct PictureBand<'a> {
    pub(super) rows: u32,
    pub(super) frame: &'a wgpu::Buffer,
    /// Per chunk.
    pub(super) read: Vec<Vec<(u32, &'a wgpu::Buffer)>>,
}

fn target(
    gpu: &Gpu,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
) -> Result<wgpu::TextureView, GpuError> {
    let memory = (gpu.device()).push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let texture = gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: Some(RASTER),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    match pollster::block_on(memory.pop()) {
        Some(_) => Err(GpuError::OutOfMemory {
            what: "the targets of the device's rasteriser",
        }),
        None => {
            (gpu.check()).map(|()| texture.create_view(&wgpu::TextureViewDescriptor::default()))
        }
    }
}

impl HardwareRaster {
    pub(super) fn new(
        gpu: &Gpu,
        pipelines: &Pipelines,
        picture: &Picture<'_>,
        chunks: &[DeviceChunk],
    ) -> Result<Self, GpuError> {
        let ScreenSize { width, samples, .. } = picture.size;
        let rows = picture.bands.iter().map(|b| b.rows).max().unwrap_or(1);
        let side = width.max(rows).next_power_of_two();
        if side > gpu.device().limits().max_texture_dimension_2d {
            return Err(GpuError::Unsupported {
                what: "pictures so large by the device's own rasteriser",
            });
        }
        let stage = pipelines.raster(gpu)?;
        let ids = target(gpu, [width, rows], IDS)?;
        let depths = target(gpu, [width, rows], DEPTHS)?;
        let layouts = |group: u32| {
            let collect = &stage.collect.pipeline;
            let draw = stage.draw.get_bind_group_layout(group);
            [draw, collect.get_bind_group_layout(group)]
        };
        let [draw, collect] = &layouts(1);
        let pass = |sample: u32| {
            let of = Target {
                sample,
                step: 1.0 / (128 * side) as f32,
                ..Target::default()
            };
            let number = uniform(gpu, &of)?;
            let own = |layout| bind(gpu, layout, &[(0, &number)], &[]);
            Ok(SamplePass {
                draw: own(draw),
                collect: own(collect),
            })
        };
        let samples = (0..samples).map(pass).collect::<Result<_, GpuError>>()?;
        let [draw, collect] = &layouts(0);
        let band = |b: &PictureBand<'_>| BandPass {
            rows: b.rows,
            draw: (b.read.iter())
                .map(|read| bind(gpu, draw, read, &[]))
                .collect(),
            collect: bind(
                gpu,
                collect,
                &[(0, b.frame), (4, picture.keys)],
                &[(11, &ids), (12, &depths)],
            ),
        };
        let order = |c| Order::new(gpu, &stage.by_size, c);
        Ok(Self {
            width,
            side,
            samples,
            bands: picture.bands.iter().map(band).collect(),
            orders: chunks.iter().map(order).collect::<Result<_, _>>()?,
            target_bytes: 8 * u64::from(width) * u64::from(rows),
            ids,
            depths,
        })
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        self.target_bytes + self.orders.iter().map(Order::bytes).sum::<u64>()
    }

    /// Sorts blocks that the device has just decided on.
    pub(super) fn sort(&self, stage: &RasterStage, pass: &mut wgpu::ComputePass<'_>) {
        for order in &self.orders {
            order.sort(&stage.by_size, pass);
        }
    }

    /// Draws all keys of a band; its time is kept as that of stage `number`.
    pub(super) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        (stage, timer): (&RasterStage, Option<&Timer>),
        (band, number): (usize, u32),
    ) {
        let band = &self.bands[band];
        for (k, sample) in self.samples.iter().enumerate() {
            let times = match k {
                0 => timer::opening(timer, number),
                _ => None,
            };
            let mut pass = self.begin(encoder, times);
            pass.set_pipeline(&stage.draw);
            let side = self.side as f32;
            pass.set_viewport(0.0, 0.0, side, side, 0.0, 1.0);
            pass.set_index_buffer(stage.corners.slice(..), wgpu::IndexFormat::Uint16);
            pass.set_bind_group(1, &sample.draw, &[]);
            for (bindings, order) in band.draw.iter().zip(&self.orders) {
                pass.set_bind_group(0, bindings, &[]);
                order.draw(&mut pass);
            }
            drop(pass);
            let times = timer.filter(|_| k + 1 == self.samples.len());
            let mut pass = timer::last_pass(times, encoder, RASTER, number);
            pass.set_bind_group(1, &sample.collect, &[]);
            let groups = (self.width * band.rows).div_ceil(GROUP);
            stage.collect.run(&mut pass, &band.collect, groups);
        }
    }

    /// Begins a pass over empty targets.
    fn begin<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        times: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) -> wgpu::RenderPass<'e> {
        let store = wgpu::StoreOp::Store;
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(RASTER),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.ids,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depths,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: times,
            ..wgpu::RenderPassDescriptor::default()
        })
    }
}
