//! The device's own rasteriser against the compute stages, sample by sample, and against the processor's pictures.

use crate::patterns::{cut, patterned};
use crate::pictures::check;
use crate::{asset, gpu_with, plain, uniform};
use earmark::film::Image;
use earmark::frame::Refinement;
use earmark::gpu::{DeviceOptions, Gpu, GpuScene, Raster};
use earmark::scheme::Scheme;
use earmark::shade::ShadeMode;
use earmark::tessellate::Pattern;
use earmark::{Camera, Renderer, Scene, SurfaceOptions};
use std::sync::OnceLock;

/// One device for all tests of this file, whose scenes are drawn by its own rasteriser from the beginning.
fn hardware(what: &str) -> Option<&'static Gpu> {
    static DEVICE: OnceLock<Option<Gpu>> = OnceLock::new();
    let options = DeviceOptions {
        raster: Raster::Hardware,
        ..DeviceOptions::default()
    };
    DEVICE.get_or_init(|| gpu_with(what, &options)).as_ref()
}

/// Samples that show something, those that show something else by the device's own rasteriser, and of these such that only one of both shows
/// anything.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    seen: usize,
    other: usize,
    bare: usize,
}

/// Draws a picture both ways and compares samples; the second one is returned.
fn both_ways(ready: &mut GpuScene) -> (Image, Found) {
    ready.raster_by(Raster::Compute).unwrap();
    let first = ready.draw().unwrap();
    assert_eq!(first.stats.raster, Raster::Compute);
    let want = ready.read_keys().unwrap();
    ready.raster_by(Raster::Hardware).unwrap();
    let second = ready.draw().unwrap();
    assert_eq!(second.stats.raster, Raster::Hardware);
    assert_eq!(second.stats.bands, 1);
    let got = ready.read_keys().unwrap();
    assert_eq!(got.len(), want.len());
    let mut found = Found::default();
    for (a, b) in got.iter().zip(&want) {
        let [a, b] = [a, b].map(|key| (key[1] != 0).then_some(key[0]));
        found.seen += usize::from(a.is_some() || b.is_some());
        found.other += usize::from(a != b);
        found.bare += usize::from(a.is_some() != b.is_some());
    }
    // Twice the same.
    assert_eq!(second.image.data, ready.draw().unwrap().image.data);
    (second.image, found)
}

fn of(name: &str, scheme: Scheme) -> Scene {
    let options = SurfaceOptions {
        scheme: Some(scheme),
        ..SurfaceOptions::default()
    };
    plain(asset(name, options))
}

/// A picture of some samples, and what is drawn how.
fn cases() -> Vec<(&'static str, Scene, Renderer, Camera)> {
    let creature = || of("creature", Scheme::CatmullClark);
    let torus = || of("torus", Scheme::CatmullClark);
    let base = Camera::default();
    let with = |samples: u32, level: u32| {
        let mut renderer = uniform(200, 150, level);
        renderer.size.samples = samples;
        renderer
    };
    let by = |refinement: Refinement| {
        let mut renderer = with(4, 0);
        renderer.refinement = refinement;
        renderer
    };
    let adaptive = || by(Refinement::Default { max_level: 8 });
    let flat = |mut renderer: Renderer| {
        renderer.mode = ShadeMode::Flat;
        renderer
    };
    // Inside of the ring, and through the surface.
    let inside = |eye, target| {
        (base.with_eye_target(eye, target))
            .with_fov(80.0)
            .with_near_far(0.05, 10.0)
    };
    let ring = inside([0.0, 0.2, 0.0], [0.0, 0.0, 1.0]);
    let through = inside([1.35, 0.05, 0.0], [0.0, 0.0, 0.6]);
    // The half of the ring that is behind.
    let half = (base.with_ortho())
        .with_eye_target([0.0, 1.0, 2.0], [0.0; 3])
        .with_near_far(2.2, 6.0);
    let split = patterned(Pattern::Split);
    vec![
        ("samples_1", creature(), with(1, 3), base),
        ("samples_4", creature(), with(4, 3), base),
        ("samples_8", creature(), with(8, 2), base),
        ("samples_16", creature(), with(16, 2), base),
        ("flat", creature(), flat(with(4, 2)), base),
        (
            "ortho",
            of("part_creased", Scheme::CatmullClark),
            with(4, 2),
            base.with_ortho(),
        ),
        ("ortho_clipped", torus(), with(4, 2), half),
        ("loop", of("octahedron", Scheme::Loop), with(4, 4), base),
        ("close", creature(), with(4, 1), base.with_zoom(20.0)),
        ("ring", torus(), with(4, 1), ring),
        ("through", torus(), with(4, 3), through),
        ("adaptive", creature(), adaptive(), base),
        ("cut_split", cut(), flat(by(split)), base.with_zoom(2.0)),
    ]
}

#[test]
fn hardware_draws_the_same_triangles() {
    let Some(gpu) = hardware("hardware raster") else {
        return;
    };
    let (mut run, mut all, mut decided) = (0, Found::default(), 0);
    for (name, scene, renderer, camera) in cases() {
        let mut ready = GpuScene::new(gpu, &renderer, &scene, &camera).unwrap();
        let (image, found) = both_ways(&mut ready);
        println!("gpu hardware raster {name}: {found:?}");
        assert!(found.seen > 1000, "{name}: {found:?}");
        assert!(found.other * 1000 <= found.seen, "{name}: {found:?}");
        let want = renderer.render(&scene, &camera).unwrap().image;
        check(&format!("raster_{name}"), &image, &want);
        decided += usize::from(ready.draw().unwrap().stats.decides);
        all.seen += found.seen;
        all.other += found.other;
        all.bare += found.bare;
        run += 1;
    }
    assert_eq!(decided, 1);
    println!("gpu hardware raster: {run} cases, {all:?}");
}

#[test]
fn hardware_draws_chunks_and_bands_the_same() {
    let Some(whole) = hardware("hardware chunks") else {
        return;
    };
    let small = DeviceOptions {
        max_binding: 1_500_000,
        raster: Raster::Hardware,
        ..DeviceOptions::default()
    };
    let Some(small) = gpu_with("hardware chunks", &small) else {
        return;
    };
    let scene = of("creature", Scheme::CatmullClark);
    let renderer = uniform(400, 300, 4);
    let camera = Camera::default();
    let mut parts = GpuScene::new(&small, &renderer, &scene, &camera).unwrap();
    let got = parts.draw().unwrap();
    assert!(
        got.stats.chunks > 1 && got.stats.bands > 2,
        "{:?}",
        got.stats
    );
    assert_eq!(got.stats.raster, Raster::Hardware);
    let mut one = GpuScene::new(whole, &renderer, &scene, &camera).unwrap();
    let want = one.draw().unwrap();
    assert_eq!(want.stats.bands, 1);
    assert_eq!(got.image.data, want.image.data);
    let own = renderer.render(&scene, &camera).unwrap().image;
    check("raster_bands", &got.image, &own);
    // What is drawn by follows points and views.
    let points = scene.objects[0].surface.cage().points();
    let lifted: Vec<[f32; 3]> = points.iter().map(|p| [p[0], p[1] + 0.05, p[2]]).collect();
    one.move_points(&lifted).unwrap();
    let moved = one.draw().unwrap();
    assert_ne!(moved.image.data, want.image.data);
    println!("gpu hardware chunks: {} bands", got.stats.bands);
}

#[test]
fn what_is_measured_is_kept() {
    let Some(gpu) = hardware("measured raster") else {
        return;
    };
    let scene = of("creature", Scheme::CatmullClark);
    let mut renderer = uniform(120, 90, 2);
    renderer.measure = true;
    let draw = |raster: Option<Raster>| {
        let mut ready = GpuScene::new(gpu, &renderer, &scene, &Camera::default()).unwrap();
        if let Some(raster) = raster {
            ready.raster_by(raster).unwrap();
        }
        ready.draw().unwrap()
    };
    let named = |raster| match raster {
        Raster::Hardware => "raster",
        _ => "tile",
    };
    let [compute, hardware] = [Raster::Compute, Raster::Hardware].map(|r| draw(Some(r)));
    // As the device was opened.
    assert_eq!(draw(None).image.data, hardware.image.data);
    for (drawn, raster) in [(&compute, Raster::Compute), (&hardware, Raster::Hardware)] {
        assert_eq!(drawn.stats.raster, raster);
        if gpu.adapter().timestamps {
            let times = drawn.stats.stages.iter().map(|s| s.0);
            let want = ["dice", named(raster), "shade", "film"];
            assert_eq!(times.collect::<Vec<_>>(), want);
            assert!(drawn.stats.stages.iter().all(|s| s.1 <= drawn.stats.wall));
        }
    }
    // Targets and orders of blocks are counted.
    assert!(hardware.stats.scene_bytes >= compute.stats.scene_bytes + 8 * 120 * 90);
    let first = draw(Some(Raster::Measured)).stats.raster;
    assert_ne!(first, Raster::Measured);
    for _ in 0..3 {
        let again = draw(Some(Raster::Measured));
        assert_eq!(again.stats.raster, first);
        let same = match first {
            Raster::Hardware => &hardware,
            _ => &compute,
        };
        assert_eq!(again.image.data, same.image.data);
    }
    println!("gpu measured raster: {} was quicker", named(first));
}
