//! What is not drawn and says why, limits, and devices that have less.

use crate::pictures::{check, draw};
use crate::{asset, gpu, gpu_with, plain, torus, uniform};
use earmark::displace::Displacement;
use earmark::frame::RenderError;
use earmark::gpu::{DeviceOptions, Gpu, GpuError, GpuScene, Raster};
use earmark::limits::LimitError;
use earmark::{Camera, Renderer, Scene, SurfaceOptions};

/// What a scene is refused for.
pub(crate) fn refused_as(gpu: &Gpu, renderer: &Renderer, scene: &Scene) -> &'static str {
    match GpuScene::new(gpu, renderer, scene, &Camera::default()) {
        Err(GpuError::Unsupported { what }) => what,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("not refused"),
    }
}

#[test]
fn what_is_not_drawn_is_refused() {
    let Some(gpu) = gpu("refusals") else { return };
    let scene = asset("cube", SurfaceOptions::default());
    let mut renderer = uniform(64, 64, 2);
    let ask = |renderer: &Renderer, scene: &Scene| {
        GpuScene::new(&gpu, renderer, scene, &Camera::default()).map(|_| ())
    };
    assert_eq!(ask(&renderer, &scene), Ok(()));
    let refused = |renderer: &Renderer, scene: &Scene, what: &str| {
        let said = refused_as(&gpu, renderer, scene);
        assert!(said.contains(what), "{what}: {said}");
    };
    let by_rule = Displacement::vector(0.1, |_| [0.1, 0.0, 0.0]);
    let mut ruled = scene.clone();
    ruled.objects[0].surface.set_displacement(Some(by_rule));
    refused(&renderer, &ruled, "rule of the caller's");
    // A vertex of more faces than tables are made for.
    let n = 600_u32;
    let spoke = |k: u32| (k as f32 / (2 * n) as f32 * std::f32::consts::TAU).sin_cos();
    let ring = (0..2 * n).map(|k| [spoke(k).0, spoke(k).1, 0.0]);
    let points: Vec<[f32; 3]> = std::iter::once([0.0; 3]).chain(ring).collect();
    let faces = (0..n).flat_map(|k| [0, 1 + 2 * k, 2 + 2 * k, 1 + (2 * k + 2) % (2 * n)]);
    let fan = earmark::Cage::new(points, &vec![4; n as usize], faces.collect()).unwrap();
    let fan = Scene::of(earmark::Surface::new(fan, &SurfaceOptions::default()));
    refused(&renderer, &fan, "512");
    renderer.size.samples = 3;
    let said = ask(&renderer, &scene);
    assert!(
        matches!(
            said,
            Err(GpuError::Render(RenderError::Size { samples: 3, .. }))
        ),
        "{said:?}"
    );
    renderer.size.samples = 1;
    let missing = DeviceOptions {
        allow_software: true,
        name: Some("no such adapter".to_owned()),
        ..DeviceOptions::default()
    };
    assert!(matches!(
        Gpu::open(&missing),
        Err(GpuError::NoSuchAdapter { .. })
    ));
    let tiny = DeviceOptions {
        max_binding: 1000,
        ..DeviceOptions::default()
    };
    let Some(tiny) = gpu_with("refusals", &tiny) else {
        return;
    };
    let refused = GpuScene::new(&tiny, &uniform(64, 64, 4), &scene, &Camera::default());
    assert!(matches!(refused, Err(GpuError::OutOfMemory { .. })));
    println!("gpu refusals: 5 cases");
}

/// Every kind of memory counts: what is drawn with just as much as it takes is not drawn with a little less.
#[test]
fn limits_hold() {
    let Some(gpu) = gpu("limits") else { return };
    let scene = torus(16, 12);
    let mut renderer = uniform(64, 64, 6);
    let ask =
        |renderer: &Renderer| GpuScene::new(&gpu, renderer, &scene, &Camera::default()).map(|_| ());
    renderer.limits.max_faces = Some(192 << 12);
    assert_eq!(ask(&renderer), Ok(()));
    renderer.limits.max_faces = Some((192 << 12) - 1);
    let said = ask(&renderer);
    assert!(
        matches!(said, Err(GpuError::Limit(LimitError::Faces { .. }))),
        "{said:?}"
    );
    renderer.limits.max_faces = None;
    let mut said = Vec::new();
    let mut most = 1000;
    loop {
        renderer.limits.max_memory = Some(most);
        match ask(&renderer) {
            Ok(()) => break,
            Err(GpuError::Limit(e)) => said.push(e.to_string()),
            Err(other) => panic!("{other}"),
        }
        most = most * 9 / 8;
    }
    for what in ["blocks", "faces", "tables", "chunks"] {
        let of = format!("the {what} of the GPU backend");
        assert!(said.iter().any(|s| s.contains(&of)), "{what}: {said:?}");
    }
    println!("gpu limits: {} cases", said.len() + 2);
}

/// A device of the caller's, on which nobody listens for errors, and which is smaller than its adapter.
#[test]
fn a_callers_device_gives_errors() {
    let Some(own) = gpu("a caller's device") else {
        return;
    };
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    let name = own.adapter().name.as_str();
    let adapter = adapters.iter().find(|a| a.get_info().name == name).unwrap();
    let asked = wgpu::DeviceDescriptor {
        required_limits: wgpu::Limits {
            max_storage_buffers_per_shader_stage: 12,
            ..wgpu::Limits::default()
        },
        ..wgpu::DeviceDescriptor::default()
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&asked)).unwrap();
    let theirs = Gpu::of_device(&device, &queue);
    let scene = plain(asset("cube", SurfaceOptions::default()));
    let camera = Camera::default();
    // One that binds fewer buffers than a stage needs.
    let few = wgpu::DeviceDescriptor::default();
    let (few, few_queue) = pollster::block_on(adapter.request_device(&few)).unwrap();
    let few = Gpu::of_device(&few, &few_queue);
    let refused = GpuScene::new(&few, &uniform(64, 64, 2), &scene, &camera);
    assert!(
        matches!(&refused, Err(GpuError::Unsupported { what }) if what.contains("storage buffers")),
        "{refused:?}"
    );
    // Nothing is rasterised by hardware that is wider than a target of it; the compute stages have none.
    let wide = asked.required_limits.max_texture_dimension_2d + 1;
    let mut ready = GpuScene::new(&theirs, &uniform(wide, 8, 1), &scene, &camera).unwrap();
    let refused = ready.raster_by(Raster::Hardware);
    assert!(
        matches!(&refused, Err(GpuError::Unsupported { what }) if what.contains("rasteriser")),
        "{refused:?}"
    );
    assert_eq!(ready.draw().unwrap().stats.raster, Raster::Compute);
    // Larger than its largest buffer.
    let most = asked.required_limits.max_buffer_size;
    let large = uniform(8192, (most / (4 * 8192) + 1) as u32, 1);
    let refused = GpuScene::new(&theirs, &large, &scene, &camera);
    assert!(
        matches!(&refused, Err(GpuError::OutOfMemory { .. })),
        "{refused:?}"
    );
    let deep = earmark::gpu::Refiner::new(&theirs, &torus(64, 64).objects[0].surface, 6);
    assert!(
        matches!(&deep, Err(GpuError::OutOfMemory { .. })),
        "{deep:?}"
    );
    // It draws what fits.
    let renderer = uniform(64, 64, 2);
    let want = draw(&own, &renderer, &scene, &camera);
    check("theirs", &draw(&theirs, &renderer, &scene, &camera), &want);
    // A device that is gone is an error, too.
    let mut ready = GpuScene::new(&theirs, &renderer, &scene, &camera).unwrap();
    device.destroy();
    assert!(ready.draw().is_err());
    assert!(GpuScene::new(&theirs, &renderer, &scene, &camera).is_err());
    println!("gpu caller's device: 5 cases");
}

#[test]
fn nothing_to_draw_is_drawn() {
    let Some(gpu) = gpu("nothing") else { return };
    let mut scene = asset("part", SurfaceOptions::default());
    for material in &mut scene.materials {
        material.opacity = 0.0;
    }
    let renderer = uniform(64, 64, 2);
    let want = renderer.render(&scene, &Camera::default()).unwrap();
    let mut ready = GpuScene::new(&gpu, &renderer, &scene, &Camera::default()).unwrap();
    let got = ready.draw().unwrap();
    assert_eq!(got.image.data, want.image.data);
    assert_eq!((got.stats.chunks, got.stats.microtriangles), (0, 0));
    assert_eq!(got.stats.pixels_covered, 0);
    println!("gpu nothing: 1 case");
}
