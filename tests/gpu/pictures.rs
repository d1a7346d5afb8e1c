//! Pictures against the processor's goldens, and what a picture costs.

use crate::{asset, gpu, gpu_with, plain, torus, uniform};
use earmark::film::Image;
use earmark::frame::{Drawing, Refinement};
use earmark::gpu::{DeviceOptions, Gpu, GpuError, GpuScene};
use earmark::patch::PatchKind;
use earmark::scheme::Scheme;
use earmark::shade::ShadeMode;
use earmark::tessellate::DepthTags;
use earmark::{Camera, Renderer, Scene, SurfaceOptions};
use std::path::Path;

/// Mean and 99.9th percentile of the differences of channels, out of 255.
fn differences(a: &Image, b: &Image) -> (f64, u8) {
    assert_eq!((a.width, a.height), (b.width, b.height));
    let mut all: Vec<u8> = (a.data.iter().zip(&b.data))
        .map(|(a, b)| a.abs_diff(*b))
        .collect();
    all.sort_unstable();
    let sum: u64 = all.iter().map(|&d| u64::from(d)).sum();
    (sum as f64 / all.len() as f64, all[all.len() * 999 / 1000])
}

fn check(name: &str, got: &Image, want: &Image) -> (f64, u8) {
    let found = differences(got, want);
    if !(found.0 <= 0.1 && found.1 <= 2) {
        let out = Path::new(env!("CARGO_TARGET_TMPDIR"));
        for (kind, image) in [("gpu", got), ("cpu", want)] {
            let png = earmark::film::png::encode(image).unwrap();
            std::fs::write(out.join(format!("{name}.{kind}.png")), png).unwrap();
        }
    }
    println!(
        "gpu picture {name}: mean {:.4}, 99.9th percentile {}",
        found.0, found.1
    );
    assert!(found.0 <= 0.1, "{name}: mean {}", found.0);
    assert!(found.1 <= 2, "{name}: 99.9th percentile {}", found.1);
    found
}

fn golden(name: &str) -> Image {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("golden/{name}.png"));
    let picture = image::load_from_memory(&std::fs::read(path).unwrap())
        .unwrap()
        .into_rgba8();
    Image {
        width: picture.width(),
        height: picture.height(),
        data: picture.into_raw(),
    }
}

fn draw(gpu: &Gpu, renderer: &Renderer, scene: &Scene, camera: &Camera) -> Image {
    let mut ready = GpuScene::new(gpu, renderer, scene, camera).unwrap();
    ready.draw().unwrap().image
}

#[test]
fn pictures_are_the_goldens() {
    let Some(gpu) = gpu("pictures") else { return };
    let camera = Camera::default();
    let mut cases: Vec<(String, &str, Scheme, u32, ShadeMode, u32, Camera)> = Vec::new();
    let mut add = |name: &str, asset, scheme, level, mode, samples, camera| {
        cases.push((name.to_owned(), asset, scheme, level, mode, samples, camera));
    };
    use Scheme::{Bilinear, CatmullClark, Loop};
    use ShadeMode::{Depth, Level, Lit, Normals};
    for a in [
        "corner",
        "cube",
        "fan24",
        "fan3",
        "fan5",
        "fan8",
        "grid",
        "mobius",
        "octahedron",
        "part",
        "tetrahedron",
        "torus",
    ] {
        let name = format!("{a}_catmull-clark_l3");
        add(&name, a, CatmullClark, 3, Lit, 4, camera);
    }
    add(
        "creature_catmull-clark_l4",
        "creature",
        CatmullClark,
        4,
        Lit,
        4,
        camera,
    );
    add(
        "creature_catmull-clark_l2_normals",
        "creature",
        CatmullClark,
        2,
        Normals,
        1,
        camera,
    );
    let turned = camera.with_ortho().with_orbit(200.0, 10.0);
    add(
        "creature_catmull-clark_l3_ortho_16",
        "creature",
        CatmullClark,
        3,
        Lit,
        16,
        turned,
    );
    add(
        "creature_catmull-clark_l3_single",
        "creature",
        CatmullClark,
        3,
        Lit,
        1,
        camera,
    );
    add(
        "part_catmull-clark_l6_single",
        "part",
        CatmullClark,
        6,
        Lit,
        1,
        camera,
    );
    add(
        "part_catmull-clark_l2_depth",
        "part",
        CatmullClark,
        2,
        Depth,
        1,
        camera,
    );
    add(
        "part_catmull-clark_l7_near",
        "part",
        CatmullClark,
        7,
        Lit,
        4,
        camera.with_zoom(6.0),
    );
    add(
        "torus_catmull-clark_l6_level",
        "torus",
        CatmullClark,
        6,
        Level,
        1,
        camera,
    );
    add(
        "part_creased_catmull-clark_l3",
        "part_creased",
        CatmullClark,
        3,
        Lit,
        4,
        camera,
    );
    add(
        "part_creased_bilinear_l2",
        "part_creased",
        Bilinear,
        2,
        Lit,
        4,
        camera,
    );
    add("octahedron_loop_l4", "octahedron", Loop, 4, Lit, 4, camera);
    add(
        "tetrahedron_loop_l6",
        "tetrahedron",
        Loop,
        6,
        Lit,
        4,
        camera,
    );
    add(
        "creature_qas_l4",
        "creature",
        CatmullClark,
        4,
        Lit,
        4,
        camera,
    );
    add(
        "creature_catmull-clark_l2_uv",
        "creature",
        CatmullClark,
        2,
        ShadeMode::Uv,
        1,
        camera,
    );
    let (mut worst, mut run) = ((0.0_f64, 0), 0);
    for (name, file, scheme, level, mode, samples, camera) in cases {
        let patches = match name.contains("_qas_") {
            true => PatchKind::Qas,
            false => PatchKind::None,
        };
        let options = SurfaceOptions {
            scheme: Some(scheme),
            patches,
            ..SurfaceOptions::default()
        };
        let scene = asset(file, options);
        let mut renderer = uniform(256, 256, level);
        renderer.size.samples = samples;
        renderer.mode = mode;
        let image = draw(&gpu, &renderer, &scene, &camera);
        let found = check(&name, &image, &golden(&name));
        worst = (worst.0.max(found.0), worst.1.max(found.1));
        run += 1;
    }
    println!(
        "gpu pictures: {run} cases, mean at most {:.4}, 99.9th percentile at most {}",
        worst.0, worst.1
    );
}

#[test]
fn tessellated_pictures_are_the_processors() {
    let Some(gpu) = gpu("tessellated pictures") else {
        return;
    };
    let mut run = 0;
    for (name, scheme) in [
        ("creature", Scheme::CatmullClark),
        ("part", Scheme::CatmullClark),
        ("part_creased", Scheme::CatmullClark),
        ("octahedron", Scheme::Loop),
    ] {
        let options = SurfaceOptions {
            scheme: Some(scheme),
            ..SurfaceOptions::default()
        };
        let scene = asset(name, options);
        let tags = Refinement::DepthTags(DepthTags::by_distance());
        for (what, refinement) in [
            ("adaptive", Refinement::Default { max_level: 8 }),
            ("tags", tags),
        ] {
            let mut renderer = Renderer::new(256, 256);
            renderer.refinement = refinement;
            let camera = Camera::default();
            let want = renderer.render(&scene, &camera).unwrap();
            let mut ready = GpuScene::new(&gpu, &renderer, &scene, &camera).unwrap();
            let got = ready.draw().unwrap();
            assert_eq!(got.stats.microtriangles, want.stats.microtriangles);
            check(&format!("{what}_{name}"), &got.image, &want.image);
            run += 1;
        }
    }
    println!("gpu tessellated pictures: {run} cases");
}

/// Triangles have one tone each: a sample that shows another triangle shows it.
#[test]
fn samples_show_the_processors_triangles() {
    let Some(gpu) = gpu("triangles") else { return };
    let (mut run, mut samples, mut others) = (0, 0, 0);
    for (name, level) in [("creature", 3), ("part", 3), ("torus", 4), ("fan24", 2)] {
        let scene = plain(asset(name, SurfaceOptions::default()));
        let mut renderer = uniform(256, 256, level);
        renderer.size.samples = 1;
        renderer.mode = ShadeMode::Flat;
        let camera = Camera::default();
        let want = renderer.render(&scene, &camera).unwrap().image;
        let got = draw(&gpu, &renderer, &scene, &camera);
        let pixels = got.data.chunks_exact(4).zip(want.data.chunks_exact(4));
        let seen = pixels.filter(|(a, b)| a[3] != 0 || b[3] != 0);
        let found: Vec<bool> = seen
            .map(|(a, b)| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 1))
            .collect();
        let differ = found.iter().filter(|&&d| d).count();
        assert!(
            differ * 1000 <= found.len(),
            "{name}: {differ} of {}",
            found.len()
        );
        samples += found.len();
        others += differ;
        run += 1;
    }
    println!("gpu triangles: {run} cases, {others} of {samples} samples show another triangle");
}

#[test]
fn colours_of_vertices_are_drawn() {
    let Some(gpu) = gpu("colours") else { return };
    // Red below, blue above.
    let text = "v -1 -1 -1 1 0 0\nv 1 -1 -1 1 0 0\nv 1 1 -1 0 0 1\nv -1 1 -1 0 0 1\nv -1 -1 1 1 0 0\nv 1 -1 1 1 0 0\nv 1 1 1 0 0 1\nv -1 1 1 0 0 1\n\
                f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 4 1 5 8\n";
    let mut loader = earmark::load::Loader::new(earmark::load::LoadOptions::default());
    let nothing = &mut earmark::mesh::resolver::NoFiles;
    let cage = loader
        .read(text.as_bytes(), "cube.obj", nothing)
        .unwrap()
        .cage;
    loader.add_cage(cage, "cube.obj", nothing).unwrap();
    let scene = loader.finish().0;
    let renderer = uniform(128, 128, 3);
    let want = renderer.render(&scene, &Camera::default()).unwrap().image;
    let got = draw(&gpu, &renderer, &scene, &Camera::default());
    check("colours", &got, &want);
    // There are colours to be seen.
    assert!(want.data.chunks_exact(4).any(|p| p[0].abs_diff(p[2]) > 60));
    println!("gpu colours: 1 case");
}

#[test]
fn close_views_are_clipped_like_the_processors() {
    let Some(gpu) = gpu("clipped pictures") else {
        return;
    };
    let scene = asset("torus", SurfaceOptions::default());
    let mut run = 0;
    // Inside of the ring, and through the surface.
    for (eye, target) in [
        ([0.0, 0.2, 0.0], [0.0, 0.0, 1.0]),
        ([1.35, 0.05, 0.0], [0.0, 0.0, 0.6]),
    ] {
        for level in [1, 3] {
            let camera = Camera::default()
                .with_eye_target(eye, target)
                .with_fov(80.0)
                .with_near_far(0.05, 10.0);
            let renderer = uniform(192, 128, level);
            let want = renderer.render(&scene, &camera).unwrap().image;
            let got = draw(&gpu, &renderer, &scene, &camera);
            check(&format!("clipped_{run}"), &got, &want);
            run += 1;
        }
    }
    println!("gpu clipped pictures: {run} cases");
}

#[test]
fn both_kinds_of_keys_give_the_same_picture() {
    let Some(wide) = gpu("keys") else { return };
    let two_pass = DeviceOptions {
        two_pass: true,
        ..DeviceOptions::default()
    };
    let Some(two_pass) = gpu_with("keys", &two_pass) else {
        return;
    };
    let one = wide.adapter().wide_atomics;
    let mut run = 0;
    for (name, level) in [("creature", 3), ("part", 1), ("fan24", 5)] {
        let scene = asset(name, SurfaceOptions::default());
        let renderer = uniform(200, 150, level);
        let [a, b] = [&wide, &two_pass].map(|g| draw(g, &renderer, &scene, &Camera::default()));
        // Depths of two shaders may be contracted differently: at edges of equal depth another quad may win.
        check(&format!("keys_{name}"), &a, &b);
        run += 1;
    }
    println!("gpu keys: {run} cases, the device has maxima of 64 bits: {one}");
}

#[test]
fn chunks_and_bands_change_no_byte() {
    let Some(whole) = gpu("chunks") else { return };
    let small = DeviceOptions {
        max_binding: 1_500_000,
        ..DeviceOptions::default()
    };
    let Some(small) = gpu_with("chunks", &small) else {
        return;
    };
    let mut run = 0;
    for name in ["creature", "part_creased"] {
        let scene = plain(asset(name, SurfaceOptions::default()));
        let renderer = uniform(400, 300, 4);
        let camera = Camera::default();
        let mut parts = GpuScene::new(&small, &renderer, &scene, &camera).unwrap();
        let got = parts.draw().unwrap();
        assert!(
            got.stats.chunks > 1 && got.stats.bands > 2,
            "{:?}",
            got.stats
        );
        let want = draw(&whole, &renderer, &scene, &camera);
        assert_eq!(got.image.data, want.data, "{name}");
        run += 1;
    }
    println!("gpu chunks: {run} cases");
}

#[test]
fn scenes_above_a_binding_are_drawn() {
    let Some(gpu) = gpu("large scene") else {
        return;
    };
    // 1,440 quads at level 6: 6.3 million points of 24 bytes.
    let scene = torus(48, 30);
    let renderer = uniform(256, 256, 6);
    let mut ready = GpuScene::new(&gpu, &renderer, &scene, &Camera::default()).unwrap();
    let got = ready.draw().unwrap();
    assert!(got.stats.scene_bytes > 128 << 20);
    if gpu.adapter().max_binding <= 128 << 20 {
        assert!(got.stats.chunks > 1);
    }
    let want = renderer.render(&scene, &Camera::default()).unwrap().image;
    check("large_scene", &got.image, &want);
    println!(
        "gpu large scene: {} MiB in {} chunks",
        got.stats.scene_bytes >> 20,
        got.stats.chunks
    );
}

#[test]
fn nothing_but_the_picture_is_read_back() {
    let Some(gpu) = gpu("copies") else { return };
    let scene = asset("creature", SurfaceOptions::default());
    let renderer = uniform(160, 120, 4);
    let mut ready = GpuScene::new(&gpu, &renderer, &scene, &Camera::default()).unwrap();
    let first = ready.draw().unwrap();
    let points = scene.objects[0].surface.cage().points().to_vec();
    let frame = 4 * earmark::gpu::records::words(&[earmark::gpu::records::Frame::default()]).len();
    // The view alone moves.
    let second = ready.draw().unwrap();
    assert_eq!(second.stats.bytes_up, frame as u64);
    // Points move.
    let lifted: Vec<[f32; 3]> = points.iter().map(|p| [p[0], p[1] + 0.05, p[2]]).collect();
    ready.move_points(&lifted).unwrap();
    let third = ready.draw().unwrap();
    assert_eq!(third.stats.bytes_up, (frame + 12 * points.len()) as u64);
    assert_ne!(third.image.data, second.image.data);
    for stats in [&first.stats, &second.stats, &third.stats] {
        assert_eq!((stats.read_backs, stats.bytes_down), (1, 4 * 160 * 120));
    }
    assert_eq!(first.image.data, second.image.data);
    // Back again, and the picture is the same.
    ready.move_points(&points).unwrap();
    assert_eq!(ready.draw().unwrap().image.data, first.image.data);
    println!(
        "gpu copies: up {} bytes with moved points, down {} bytes",
        third.stats.bytes_up, third.stats.bytes_down
    );
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
    renderer.drawing = Drawing::Cage;
    assert!(matches!(
        ask(&renderer, &scene),
        Err(GpuError::Unsupported { .. })
    ));
    renderer.drawing = Drawing::Limit;
    renderer.size.samples = 3;
    assert!(matches!(ask(&renderer, &scene), Err(GpuError::Render(_))));
    renderer.size.samples = 1;
    renderer.limits.max_memory = Some(1000);
    assert!(matches!(ask(&renderer, &scene), Err(GpuError::Limit(_))));
    // A vertex of more faces than tables are made for.
    renderer.limits.max_memory = None;
    let n = 600_u32;
    let spoke = |k: u32| (k as f32 / (2 * n) as f32 * std::f32::consts::TAU).sin_cos();
    let ring = (0..2 * n).map(|k| [spoke(k).0, spoke(k).1, 0.0]);
    let points: Vec<[f32; 3]> = std::iter::once([0.0; 3]).chain(ring).collect();
    let faces = (0..n).flat_map(|k| [0, 1 + 2 * k, 2 + 2 * k, 1 + (2 * k + 2) % (2 * n)]);
    let fan = earmark::Cage::new(points, &vec![4; n as usize], faces.collect()).unwrap();
    let fan = Scene::of(earmark::Surface::new(fan, &SurfaceOptions::default()));
    assert!(matches!(
        ask(&renderer, &fan),
        Err(GpuError::Unsupported { .. })
    ));
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
    println!("gpu refusals: 7 cases");
}
