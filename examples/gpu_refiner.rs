//! An engine's own device and pipeline draw a surface that earmark refines on the device:
//! `cargo run --release --features gpu --example gpu_refiner OUT.png [SIZE] [software]`.
//!
//! The device, its queue and the render pipeline are this program's. Limit points, their normals and quads never leave the device: the vertex
//! shader pulls them from the refiner's buffers. Needs no window. `software` takes adapters that compute on the processor.

#![allow(clippy::print_stdout)]

use earmark::camera::Sphere;
use earmark::film::{Image, png};
use earmark::gpu::{Gpu, Refiner};
use earmark::load::{LoadOptions, Loader};
use earmark::records::ScreenSize;
use earmark::{Camera, files};
use std::path::Path;

const SHADER: &str = "
struct View { x: vec4<f32>, y: vec4<f32>, w: vec4<f32>, eye: vec4<f32>, size: vec4<f32> }
@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> points: array<f32>;
@group(0) @binding(2) var<storage, read> corners: array<u32>;
@group(0) @binding(3) var<storage, read> normals: array<f32>;

struct Out { @builtin(position) screen: vec4<f32>, @location(0) at: vec3<f32>, @location(1) normal: vec3<f32> }

@vertex fn pull(@builtin(vertex_index) index: u32) -> Out {
    // Two triangles per quad.
    var order = array<u32, 6>(0u, 1u, 2u, 0u, 2u, 3u);
    let h = 4u * (index / 6u) + order[index % 6u];
    let v = corners[h];
    let normal = vec3<f32>(normals[3u * h], normals[3u * h + 1u], normals[3u * h + 2u]);
    let at = vec3<f32>(points[3u * v], points[3u * v + 1u], points[3u * v + 2u]);
    let p = vec4<f32>(at, 1.0);
    let w = dot(view.w, p);
    // From 1/256 pixel, y down, to clip space.
    let x = dot(view.x, p) / (128.0 * view.size.x) - w;
    let y = w - dot(view.y, p) / (128.0 * view.size.y);
    // Depth from 0 at the near distance to 1 far away.
    return Out(vec4<f32>(x, y, w - view.size.z, w), at, normal);
}

@fragment fn shade(in: Out) -> @location(0) vec4<f32> {
    let n = normalize(in.normal);
    let v = normalize(view.eye.xyz - in.at);
    let facing = n * sign(dot(n, v));
    let light = 0.15 + 0.75 * max(dot(facing, normalize(v + vec3<f32>(-0.4, 0.9, 0.1))), 0.0);
    return vec4<f32>(vec3<f32>(0.53, 0.49, 0.44) * light, 1.0);
}";

const LEVEL: u32 = 4;

fn entry(binding: u32, buffer: &wgpu::Buffer) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry {
        binding,
        resource: buffer.as_entire_binding(),
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, out, rest @ ..] = arguments.as_slice() else {
        return Err("usage: gpu_refiner OUT.png [SIZE] [software]".into());
    };
    let size: u32 = rest.first().map_or(Ok(512), |s| s.parse())?;
    let software = rest.iter().any(|a| a == "software");

    // What an engine has already.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter =
        pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    if adapter.get_info().device_type == wgpu::DeviceType::Cpu && !software {
        return Err("the only adapter is software; add the word: software".into());
    }
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_limits: adapter.limits(),
        ..wgpu::DeviceDescriptor::default()
    }))?;

    // The cage, refined on that device.
    let mut loader = Loader::new(LoadOptions::default());
    loader.add_file(Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/assets/creature.obj"
    )))?;
    let (scene, _) = loader.finish();
    let surface = &scene.objects[0].surface;
    let gpu = Gpu::of_device(&device, &queue);
    let refiner = Refiner::with_limit(&gpu, surface, LEVEL)?;
    let limit = refiner.limit_points().zip(refiner.normals());
    let (points, normals) = limit.ok_or("no limit")?;
    let screen = ScreenSize {
        width: size,
        height: size,
        samples: 1,
    };
    let sphere = Sphere::of_points(surface.cage().points().iter().copied());
    let view = Camera::default().framing(&sphere, screen)?;

    let p = &view.projection;
    let [x, y, z] = view.eye;
    let side = size as f32;
    let numbers = [p.x, p.y, p.w, [x, y, z, 0.0], [side, side, p.near, 0.0]];
    let uniform = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 80,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    queue.write_buffer(&uniform, 0, bytemuck::cast_slice(&numbers));

    let target = |format, usage| {
        device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width: size,
                height: size,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    };
    let color_format = wgpu::TextureFormat::Rgba8UnormSrgb;
    let depth_format = wgpu::TextureFormat::Depth32Float;
    let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
    let color = target(color_format, attachment | wgpu::TextureUsages::COPY_SRC);
    let depth = target(depth_format, attachment);
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(SHADER.into()),
    });
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("pull"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: depth_format,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("shade"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(color_format.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            entry(0, &uniform),
            entry(1, points),
            entry(2, refiner.corners()),
            entry(3, normals),
        ],
    });

    // One frame: refine, then draw what was refined.
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    refiner.encode(&mut encoder);
    let (color_view, depth_view) = (
        color.create_view(&Default::default()),
        depth.create_view(&Default::default()),
    );
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &color_view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                store: wgpu::StoreOp::Store,
            },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &depth_view,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(1.0),
                store: wgpu::StoreOp::Store,
            }),
            stencil_ops: None,
        }),
        ..wgpu::RenderPassDescriptor::default()
    });
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &bindings, &[]);
    pass.draw(0..6 * refiner.face_count(), 0..1);
    drop(pass);

    // Only to look at it: the picture comes back.
    let row = (4 * size).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let staging = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row) * u64::from(size),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    encoder.copy_texture_to_buffer(
        color.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &staging,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row),
                rows_per_image: None,
            },
        },
        color.size(),
    );
    queue.submit([encoder.finish()]);
    staging.map_async(wgpu::MapMode::Read, .., |_| ());
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let mut image = Image::new(size, size);
    let bytes = staging.get_mapped_range(..)?;
    for (to, from) in image
        .data
        .chunks_exact_mut(4 * size as usize)
        .zip(bytes.chunks_exact(row as usize))
    {
        to.copy_from_slice(&from[..to.len()]);
    }
    files::write_atomic(Path::new(out), &png::encode(&image)?)?;
    let covered = image.data.chunks_exact(4).filter(|p| p[3] != 0).count();
    println!("{} quads, {covered} pixels", refiner.face_count());
    if covered == 0 {
        return Err("nothing was drawn".into());
    }
    Ok(())
}
