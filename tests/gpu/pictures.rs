//! Pictures against the processor's goldens, and what a picture costs.

use crate::refusals::refused_as;
use crate::table::goldens;
use crate::{asset, colored, displaced, gpu, gpu_with, plain, torus, uniform};
use earmark::film::Image;
use earmark::frame::{Drawing, Refinement};
use earmark::gpu::{DeviceOptions, Gpu, GpuScene};
use earmark::load::{LoadOptions, Loader};
use earmark::mesh::resolver::NoFiles;
use earmark::patch::PatchKind;
use earmark::scheme::Scheme;
use earmark::shade::{Relief, ShadeMode};
use earmark::tessellate::DepthTags;
use earmark::texture::{Meaning, Texture};
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

pub(crate) fn check(name: &str, got: &Image, want: &Image) -> (f64, u8) {
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

pub(crate) fn draw(gpu: &Gpu, renderer: &Renderer, scene: &Scene, camera: &Camera) -> Image {
    let mut ready = GpuScene::new(gpu, renderer, scene, camera).unwrap();
    ready.draw().unwrap().image
}

#[test]
fn pictures_are_the_goldens() {
    let Some(gpu) = gpu("pictures") else { return };
    let (mut worst, mut run) = ((0.0_f64, 0), 0);
    for g in goldens(&displaced::ALL) {
        let mut scene = g.scene();
        displaced::edit(&g.name, &mut scene);
        let image = draw(&gpu, &g.renderer(), &scene, &g.camera);
        let found = check(&g.name, &image, &golden(&g.name));
        worst = (worst.0.max(found.0), worst.1.max(found.1));
        run += 1;
    }
    assert!(run > 40, "{run} drawn");
    println!(
        "gpu pictures: {run} cases, mean at most {:.4}, 99.9th percentile at most {}",
        worst.0, worst.1
    );
}

/// A picture with stripes of full and of no opacity in its alpha channel, and of heights in red.
pub(crate) fn stripes(side: u32) -> Texture {
    let texel = |i: u32| {
        let (x, y) = (i % side, i / side);
        let alpha = if (x / 8 + y / 16) % 2 == 0 { 255 } else { 40 };
        [(x * 37 % 256) as u8, 128, (y * 11 % 256) as u8, alpha]
    };
    let all = (0..side * side).map(texel).collect();
    Texture::from_rgba8(side, side, all, Meaning::Data).unwrap()
}

#[test]
fn opacity_and_relief_are_the_processors() {
    let Some(gpu) = gpu("maps") else { return };
    let mut run = 0;
    let two_pass = DeviceOptions {
        two_pass: true,
        ..DeviceOptions::default()
    };
    let Some(two_pass) = gpu_with("maps", &two_pass) else {
        return;
    };
    for (what, level, mode) in [
        ("opacity", 2, ShadeMode::Lit),
        ("opacity", 4, ShadeMode::Flat),
        ("bump", 3, ShadeMode::Lit),
        ("bump", 2, ShadeMode::Normals),
        ("normals", 3, ShadeMode::Lit),
        ("both", 3, ShadeMode::Level),
        ("both", 0, ShadeMode::Lit),
    ] {
        let mut scene = asset("creature", SurfaceOptions::default());
        scene.textures.push(stripes(64));
        let map = scene.textures.len() as u32 - 1;
        for m in &mut scene.materials {
            if what == "opacity" || what == "both" {
                (m.opacity_map, m.opacity) = (Some(map), 0.9);
            }
            m.relief = match what {
                "bump" | "both" => Some(Relief::Heights {
                    map,
                    strength: 0.02,
                }),
                "normals" => Some(Relief::Normals(map)),
                _ => None,
            };
        }
        for (keys, gpu) in [("", &gpu), ("_two_pass", &two_pass)] {
            if !keys.is_empty() && what != "opacity" {
                continue;
            }
            // Near enough that some quads are large.
            for zoom in [1.0, 6.0] {
                let mut renderer = uniform(200, 150, level);
                renderer.mode = mode;
                let camera = Camera::default().with_zoom(zoom);
                let want = renderer.render(&scene, &camera).unwrap().image;
                let got = draw(gpu, &renderer, &scene, &camera);
                check(&format!("{what}_{level}_{zoom}{keys}"), &got, &want);
                run += 1;
            }
        }
    }
    // Some of it is cut out.
    let plain = asset("creature", SurfaceOptions::default());
    let mut cut = plain.clone();
    cut.textures.push(stripes(64));
    for m in &mut cut.materials {
        m.opacity_map = Some(cut.textures.len() as u32 - 1);
    }
    let renderer = uniform(200, 150, 2);
    let camera = Camera::default();
    let seen = |scene: &Scene| {
        let mut ready = GpuScene::new(&gpu, &renderer, scene, &camera).unwrap();
        ready.draw().unwrap().stats.pixels_covered
    };
    assert!(seen(&cut) < seen(&plain));
    println!("gpu maps: {run} cases");
}

#[test]
fn displaced_pictures_are_the_processors() {
    let Some(gpu) = gpu("displaced pictures") else {
        return;
    };
    let mut run = 0;
    for (name, by, refinement) in [
        ("creature", "map", Refinement::Default { max_level: 5 }),
        ("creature", "pixels", Refinement::Uniform(3)),
        ("creature", "pixels", Refinement::Default { max_level: 5 }),
        (
            "part_creased",
            "noise",
            Refinement::Default { max_level: 8 },
        ),
        ("octahedron", "noise", Refinement::Default { max_level: 8 }),
        (
            "part",
            "noise",
            Refinement::DepthTags(DepthTags::by_distance()),
        ),
    ] {
        let mut scene = asset(name, SurfaceOptions::default());
        let surface = &mut scene.objects[0].surface;
        surface.set_displacement(Some(displaced::by(by)));
        let mut renderer = Renderer::new(256, 192);
        renderer.refinement = refinement;
        let camera = Camera::default();
        let want = renderer.render(&scene, &camera).unwrap();
        let mut ready = GpuScene::new(&gpu, &renderer, &scene, &camera).unwrap();
        let got = ready.draw().unwrap();
        assert_eq!(got.stats.microtriangles, want.stats.microtriangles);
        check(
            &format!("displaced_{name}_{by}_{run}"),
            &got.image,
            &want.image,
        );
        run += 1;
    }
    println!("gpu displaced pictures: {run} cases");
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
            let [own, other] = [&got.stats.microtriangles, &want.stats.microtriangles];
            match got.stats.coarse {
                0 => assert_eq!(own, other),
                // A few corners are as deep as the device has levels.
                coarse => assert!(coarse < 100 && own.abs_diff(*other) * 10 < *other, "{own}"),
            }
            check(&format!("{what}_{name}"), &got.image, &want.image);
            run += 1;
        }
    }
    println!("gpu tessellated pictures: {run} cases");
}

/// Samples that show another triangle than the processor's, and all that show any: triangles have one tone each.
pub(crate) fn other_triangles(gpu: &Gpu, scene: &Scene, level: u32) -> [usize; 2] {
    let mut renderer = uniform(256, 256, level);
    renderer.size.samples = 1;
    renderer.mode = ShadeMode::Flat;
    let camera = Camera::default();
    let want = renderer.render(scene, &camera).unwrap().image;
    let got = draw(gpu, &renderer, scene, &camera);
    let pixels = got.data.chunks_exact(4).zip(want.data.chunks_exact(4));
    let seen = pixels.filter(|(a, b)| a[3] != 0 || b[3] != 0);
    let found: Vec<bool> = seen
        .map(|(a, b)| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 1))
        .collect();
    [found.iter().filter(|&&d| d).count(), found.len()]
}

#[test]
fn samples_show_the_processors_triangles() {
    let Some(gpu) = gpu("triangles") else { return };
    let (mut run, mut samples, mut others) = (0, 0, 0);
    for (name, level) in [("creature", 3), ("part", 3), ("torus", 4), ("fan24", 2)] {
        let scene = plain(asset(name, SurfaceOptions::default()));
        let [differ, seen] = other_triangles(&gpu, &scene, level);
        assert!(differ * 1000 <= seen, "{name}: {differ} of {seen}");
        samples += seen;
        others += differ;
        run += 1;
    }
    println!("gpu triangles: {run} cases, {others} of {samples} samples show another triangle");
}

#[test]
fn colours_of_vertices_are_drawn() {
    let Some(gpu) = gpu("colours") else { return };
    let mut run = 0;
    let quad = "f 4 3 2 1";
    let triangles = "f 4 3 2\nf 4 2 1";
    for (patches, drawing, first, level) in [
        (PatchKind::None, Drawing::Limit, quad, 3),
        (PatchKind::None, Drawing::Refined, quad, 3),
        (PatchKind::None, Drawing::Cage, quad, 3),
        (PatchKind::Qas, Drawing::Limit, quad, 3),
        (PatchKind::Pn, Drawing::Limit, quad, 3),
        (PatchKind::None, Drawing::Limit, triangles, 0),
        (PatchKind::None, Drawing::Refined, triangles, 0),
        (PatchKind::None, Drawing::Refined, triangles, 3),
    ] {
        let options = SurfaceOptions {
            patches,
            ..SurfaceOptions::default()
        };
        let scene = colored(options, first);
        let mut renderer = uniform(128, 128, level);
        renderer.drawing = drawing;
        let want = renderer.render(&scene, &Camera::default()).unwrap().image;
        let got = draw(&gpu, &renderer, &scene, &Camera::default());
        let what = format!("colours_{patches:?}_{drawing:?}_{level}_{}", first.len());
        check(&what, &got, &want);
        // There are colours to be seen.
        assert!(want.data.chunks_exact(4).any(|p| p[0].abs_diff(p[2]) > 60));
        run += 1;
    }
    println!("gpu colours: {run} cases");
}

#[test]
fn cages_and_control_points_are_drawn() {
    let Some(gpu) = gpu("cages") else { return };
    let mut run = 0;
    for (name, scheme) in [
        ("creature", Scheme::CatmullClark),
        ("part", Scheme::CatmullClark),
        ("part_creased", Scheme::CatmullClark),
        ("part_creased", Scheme::Bilinear),
        ("octahedron", Scheme::Loop),
        ("octahedron", Scheme::Butterfly),
    ] {
        let scene = asset(
            name,
            SurfaceOptions {
                scheme: Some(scheme),
                ..SurfaceOptions::default()
            },
        );
        for (drawing, level, mode) in [
            (Drawing::Cage, 0, ShadeMode::Lit),
            (Drawing::Cage, 2, ShadeMode::Uv),
            (Drawing::Limit, 0, ShadeMode::Lit),
            (Drawing::Limit, 0, ShadeMode::Uv),
            (Drawing::Refined, 0, ShadeMode::Normals),
            (Drawing::Refined, 1, ShadeMode::Lit),
            (Drawing::Refined, 3, ShadeMode::Normals),
        ] {
            let mut renderer = uniform(160, 120, level);
            (renderer.drawing, renderer.mode) = (drawing, mode);
            let camera = Camera::default();
            let want = renderer.render(&scene, &camera).unwrap();
            if scheme == Scheme::Bilinear && drawing != Drawing::Cage && level == 0 {
                let said = refused_as(&gpu, &renderer, &scene);
                assert!(said.contains("level 0 of bilinear surfaces"), "{said}");
                continue;
            }
            let mut ready = GpuScene::new(&gpu, &renderer, &scene, &camera).unwrap();
            let got = ready.draw().unwrap();
            assert_eq!(got.stats.microtriangles, want.stats.microtriangles);
            let what = format!("{drawing:?}_{level}_{mode:?}_{name}_{scheme:?}");
            check(&what, &got.image, &want.image);
            run += 1;
        }
    }
    // Level 0 of polygons that are patches after it, and that are displaced.
    for (patches, by) in [
        (PatchKind::Qas, None),
        (PatchKind::Pn, None),
        (PatchKind::None, Some("noise")),
        (PatchKind::Qas, Some("noise")),
        (PatchKind::Pn, Some("noise")),
    ] {
        let options = SurfaceOptions {
            patches,
            ..SurfaceOptions::default()
        };
        let mut scene = asset("part", options);
        let surface = &mut scene.objects[0].surface;
        surface.set_displacement(by.map(displaced::by));
        let renderer = uniform(160, 120, 0);
        let camera = Camera::default();
        let want = renderer.render(&scene, &camera).unwrap().image;
        let got = draw(&gpu, &renderer, &scene, &camera);
        check(&format!("level_0_{patches:?}_{by:?}"), &got, &want);
        run += 1;
    }
    // Normals that are given, at some corners alone.
    let text = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvn 1 0 1\nvn -1 0 1\nf 1//1 2//2 3//2 4//1\nv 2 0 1\nf 3 2 5\n";
    let mut loader = Loader::new(LoadOptions::default());
    let nothing = &mut NoFiles;
    let cage = loader.read(text.as_bytes(), "given.obj", nothing).unwrap();
    loader.add_cage(cage.cage, "given.obj", nothing).unwrap();
    let scene = loader.finish().0;
    let mut renderer = uniform(160, 120, 0);
    renderer.drawing = Drawing::Cage;
    let want = renderer.render(&scene, &Camera::default()).unwrap().image;
    let mut ready = GpuScene::new(&gpu, &renderer, &scene, &Camera::default()).unwrap();
    check("cage_normals", &ready.draw().unwrap().image, &want);
    // Points move, what is given stays.
    let points = [[0.0, 0.5, 0.0]; 5]
        .iter()
        .zip(scene.objects[0].surface.cage().points());
    let points: Vec<[f32; 3]> = points
        .map(|(d, p)| [p[0] + d[0], p[1] + d[1], p[2] + d[2]])
        .collect();
    ready.move_points(&points).unwrap();
    assert_ne!(ready.draw().unwrap().image.data, want.data);
    println!("gpu cages: {} cases", run + 1);
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
fn lights_turn_as_the_processors() {
    let Some(gpu) = gpu("lights") else { return };
    let scene = asset("creature", SurfaceOptions::default());
    let mut renderer = uniform(160, 120, 3);
    let plain = draw(&gpu, &renderer, &scene, &Camera::default());
    renderer.light_turn = 90.0;
    let got = draw(&gpu, &renderer, &scene, &Camera::default());
    let want = renderer.render(&scene, &Camera::default()).unwrap().image;
    check("lights_90", &got, &want);
    assert!(differences(&got, &plain).0 > 1.0);
    println!("gpu lights: 1 case");
}

/// Triangles of one view, seen in another.
#[test]
fn another_view_may_decide() {
    let Some(gpu) = gpu("deciding views") else {
        return;
    };
    let scene = asset("creature", SurfaceOptions::default());
    let mut renderer = Renderer::new(160, 120);
    renderer.refinement = Refinement::Default { max_level: 8 };
    let [near, far] = [4.0, 0.5].map(|zoom| Camera::default().with_zoom(zoom));
    let triangles = |renderer: &Renderer, camera: &Camera| {
        let mut ready = GpuScene::new(&gpu, renderer, &scene, camera).unwrap();
        ready.draw().unwrap().stats.microtriangles
    };
    let [own, want] = [&far, &near].map(|camera| triangles(&renderer, camera));
    let deciding = renderer.view(&scene, &near).unwrap();
    renderer.decided_by = Some(deciding);
    assert_eq!(triangles(&renderer, &far), want);
    assert_ne!(own, want);
    // Of the processor's blocks as well.
    let want = renderer.render(&scene, &far).unwrap().stats.microtriangles;
    let seen = renderer.view(&scene, &far).unwrap();
    let mut ready = GpuScene::decided_by_processor(&gpu, &renderer, &scene, seen).unwrap();
    assert_eq!(ready.draw().unwrap().stats.microtriangles, want);
    println!("gpu deciding views: 1 case");
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
    assert!(!two_pass.adapter().wide_atomics);
    // A device without maxima of 64 bits has one kind alone: that is compared with the processor's.
    let one = wide.adapter().wide_atomics;
    let mut run = 0;
    for (name, level) in [("creature", 3), ("part", 1), ("fan24", 5)] {
        let scene = asset(name, SurfaceOptions::default());
        let renderer = uniform(200, 150, level);
        let camera = Camera::default();
        let got = draw(&two_pass, &renderer, &scene, &camera);
        let want = renderer.render(&scene, &camera).unwrap().image;
        check(&format!("keys_32_{name}"), &got, &want);
        if one {
            // Depths of two shaders may be contracted differently: at edges of equal depth another quad may win.
            let other = draw(&wide, &renderer, &scene, &camera);
            check(&format!("keys_{name}"), &got, &other);
            check(&format!("keys_64_{name}"), &other, &want);
        }
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
    let most = 64 << 20;
    let options = DeviceOptions {
        max_binding: most,
        ..DeviceOptions::default()
    };
    let Some(gpu) = gpu_with("large scene", &options) else {
        return;
    };
    assert_eq!(gpu.adapter().max_binding, most);
    // 1,440 quads at level 6: 6.3 million points of 24 bytes.
    let scene = torus(48, 30);
    let renderer = uniform(256, 256, 6);
    let mut ready = GpuScene::new(&gpu, &renderer, &scene, &Camera::default()).unwrap();
    let got = ready.draw().unwrap();
    let points = 1440 * 65 * 65 * 24;
    assert!(got.stats.scene_bytes > points);
    assert!(
        u64::from(got.stats.chunks) > points / most,
        "{}",
        got.stats.chunks
    );
    let want = renderer.render(&scene, &Camera::default()).unwrap().image;
    check("large_scene", &got.image, &want);
    println!(
        "gpu large scene: {} MiB in {} chunks",
        got.stats.scene_bytes >> 20,
        got.stats.chunks
    );
}

#[test]
fn stages_are_timed_over_all_bands() {
    let options = DeviceOptions {
        max_binding: 1_500_000,
        ..DeviceOptions::default()
    };
    let Some(gpu) = gpu_with("times", &options) else {
        return;
    };
    let scene = plain(asset("creature", SurfaceOptions::default()));
    let mut renderer = uniform(400, 300, 3);
    let mut ready = GpuScene::new(&gpu, &renderer, &scene, &Camera::default()).unwrap();
    let untimed = ready.draw().unwrap();
    assert!(untimed.stats.bands > 2);
    assert_eq!(untimed.stats.stages, []);
    renderer.measure = true;
    let mut ready = GpuScene::new(&gpu, &renderer, &scene, &Camera::default()).unwrap();
    let [first, second] = [0, 1].map(|_| ready.draw().unwrap());
    assert_eq!(first.image.data, untimed.image.data);
    let [with, without] = [&first, &second].map(|f| {
        let times = f.stats.stages.iter();
        times.map(|(name, _)| *name).collect::<Vec<_>>()
    });
    if gpu.adapter().timestamps {
        assert_eq!(with, ["dice", "tile", "shade", "film"]);
        assert_eq!(without, ["tile", "shade", "film"]);
        let spent: std::time::Duration = first.stats.stages.iter().map(|s| s.1).sum();
        assert!(!spent.is_zero() && spent <= first.stats.wall, "{spent:?}");
    } else {
        assert_eq!((with.len(), without.len()), (0, 0));
    }
    println!(
        "gpu times: {} bands, the device keeps time: {}",
        first.stats.bands,
        gpu.adapter().timestamps
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
