//! Blocks that the device decides on against the processor's, for a few views of all assets; for more, and of the reference models, too, if
//! EARMARK_THOROUGH is set, which then may name models, with commas between.

use crate::parity::models;
use crate::pictures::check;
use crate::{asset, gpu, gpu_with, plain, torus};
use earmark::frame::Refinement;
use earmark::gpu::records::{Frame, Metric, words};
use earmark::gpu::{DeviceOptions, Gpu, GpuError, GpuScene, ReadBlock};
use earmark::scheme::Scheme;
use earmark::tessellate::Flatness;
use earmark::{Camera, Renderer, Scene, SurfaceOptions};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Share of the tolerance within which a tested error may be on either side.
const NEAR: f32 = 1e-4;

/// Deepest level that the device decides on, of quads.
const DEEPEST: u32 = 5;

/// Blocks of each face: where they begin, their size, and their points, in units that are coarser than rounding and finer than what a moved
/// point moves by.
type Blocks = BTreeMap<u32, Vec<([u32; 2], usize, Vec<[i64; 3]>)>>;

fn by_face(blocks: &[ReadBlock], scene: &Scene) -> Blocks {
    let [low, high] = scene.objects[0].surface.cage().bounds();
    let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f32::max);
    let mut out = Blocks::new();
    for b in blocks {
        let unit = |c: f32| (f64::from(c / size) * 2e4).round() as i64;
        let points = b.points.iter().map(|p| [p[0], p[1], p[2]].map(unit));
        let own = (b.start, b.side, points.collect());
        out.entry(b.quad).or_default().push(own);
    }
    out
}

/// Faces whose blocks are not the same.
fn other(a: &Blocks, b: &Blocks) -> BTreeSet<u32> {
    let is_same = |q: &u32| {
        let (Some(a), Some(b)) = (a.get(q), b.get(q)) else {
            return false;
        };
        let mut blocks = a.iter().zip(b);
        a.len() == b.len()
            && blocks.all(|(a, b)| {
                let mut points = a.2.iter().flatten().zip(b.2.iter().flatten());
                (a.0, a.1) == (b.0, b.1) && points.all(|(a, b)| a.abs_diff(*b) <= 1)
            })
    };
    let all = a.keys().chain(b.keys());
    all.copied().filter(|q| !is_same(q)).collect()
}

fn adaptive(pixels: u32, flatness: Flatness) -> Renderer {
    let mut renderer = Renderer::new(pixels, pixels);
    renderer.refinement = Refinement::Adaptive(flatness);
    renderer
}

/// Views that have all of a model in the picture, and one that has not.
fn cameras() -> [(&'static str, Camera); 5] {
    let base = Camera::default();
    [
        ("default", base),
        ("far", base.with_zoom(0.3)),
        ("turned", base.with_orbit(200.0, -20.0).with_zoom(0.8)),
        ("ortho", base.with_ortho().with_zoom(0.8)),
        ("near", base.with_zoom(2.5)),
    ]
}

/// What was found of a case.
#[derive(Default)]
struct Found {
    /// Faces whose blocks differ although no test is near its tolerance, and those where one is.
    beyond: Vec<u32>,
    near: usize,
    faces: usize,
}

fn compare(gpu: &Gpu, scene: &Scene, camera: &Camera, what: &str) -> Option<Found> {
    let split = u32::from(scene.objects[0].surface.is_split());
    let wanted = Flatness {
        max_level: DEEPEST + split,
        ..Flatness::default()
    };
    let renderer = adaptive(256, wanted);
    let view = renderer.view(scene, camera).unwrap();
    let mut here = GpuScene::for_view(gpu, &renderer, scene, view).unwrap();
    let drawn = here.draw().unwrap();
    if !drawn.stats.decides {
        return None;
    }
    assert_eq!(drawn.stats.coarse, 0, "{what}");
    let got = by_face(&here.read_blocks().unwrap(), scene);
    let processor = |times: f32| {
        let wanted = Flatness {
            pixels: wanted.pixels * times,
            degrees: wanted.degrees * times,
            ..wanted
        };
        let renderer = adaptive(256, wanted);
        let mut there = GpuScene::decided_by_processor(gpu, &renderer, scene, view).unwrap();
        let drawn = there.draw().unwrap();
        (by_face(&there.read_blocks().unwrap(), scene), drawn)
    };
    let (want, want_drawn) = processor(1.0);
    check(&format!("flatness_{what}"), &drawn.image, &want_drawn.image);
    let differ = other(&got, &want);
    let mut out = Found {
        faces: want.len(),
        ..Found::default()
    };
    if differ.is_empty() {
        assert_eq!(drawn.stats.microtriangles, want_drawn.stats.microtriangles);
        assert_eq!(drawn.stats.levels, want_drawn.stats.levels);
        return Some(out);
    }
    let near: BTreeSet<u32> = [1.0 - NEAR, 1.0 + NEAR]
        .into_iter()
        .flat_map(|times| other(&processor(times).0, &want))
        .collect();
    out.near = differ.intersection(&near).count();
    out.beyond = differ.difference(&near).copied().collect();
    for q in out.beyond.iter().take(3) {
        let places = |b: &Blocks| {
            let own = b.get(q).map(|b| b.iter().map(|b| (b.0, b.1)));
            own.map(Iterator::collect::<Vec<_>>)
        };
        println!(
            "{what}, face {q}: {:?} for {:?}",
            places(&got),
            places(&want)
        );
    }
    Some(out)
}

#[test]
fn blocks_are_the_processors() {
    let Some(gpu) = gpu("flatness") else { return };
    let thorough = std::env::var_os("EARMARK_THOROUGH").is_some();
    let (mut run, mut left_out, mut faces) = (0, 0, 0);
    let [mut near, mut outside] = [0; 2];
    for (number, path) in models().into_iter().enumerate() {
        let name = crate::common::name(&path);
        let scene = plain(crate::common::load(&path));
        let surface = &scene.objects[0].surface;
        if scene.objects.len() > 1 || surface.scheme() != Scheme::CatmullClark {
            continue;
        }
        let cameras = cameras();
        let count = cameras.len();
        for (k, (view, camera)) in cameras.into_iter().enumerate() {
            // Two views of each model, and all views of some.
            if !thorough && (k + number) % count > 1 {
                continue;
            }
            let what = format!("{name}_{view}");
            let Some(found) = compare(&gpu, &scene, &camera, &what) else {
                left_out += 1;
                continue;
            };
            println!(
                "gpu flatness {what}: {} faces, {} near a tolerance, {} others",
                found.faces,
                found.near,
                found.beyond.len()
            );
            // Parts beyond the sides of the picture are not looked for.
            if view == "near" {
                outside += found.beyond.len();
            } else {
                assert_eq!(found.beyond, [0_u32; 0], "{what}");
            }
            assert!(found.near * 200 <= found.faces, "{what}: {}", found.near);
            near += found.near;
            faces += found.faces;
            run += 1;
        }
    }
    println!(
        "gpu flatness: {run} cases, {left_out} left out, {faces} faces, {near} of them near a tolerance; {outside} partly beyond the picture"
    );
    assert!(run > 15 || thorough && run > 0);
}

/// Directed segments of the rims of all blocks, those that cancel left out.
fn open_segments(blocks: &[ReadBlock]) -> usize {
    let mut sum: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
    for b in blocks {
        let n = b.side - 1;
        let at = |i: usize, j: usize| {
            let p = b.points[j * b.side + i];
            // Zeros have one sign.
            [p[0], p[1], p[2]].map(|c| (c + 0.0).to_bits())
        };
        let rim = (0..n).flat_map(|k| {
            [
                [at(k, 0), at(k + 1, 0)],
                [at(n, k), at(n, k + 1)],
                [at(k + 1, n), at(k, n)],
                [at(0, k + 1), at(0, k)],
            ]
        });
        for [a, b] in rim.filter(|[a, b]| a != b) {
            let (key, way) = if a < b { ([a, b], 1) } else { ([b, a], -1) };
            *sum.entry(key).or_default() += way;
        }
    }
    sum.values().filter(|&&s| s != 0).count()
}

#[test]
fn blocks_of_the_device_are_watertight() {
    let Some(gpu) = gpu("watertight blocks") else {
        return;
    };
    let mut run = 0;
    for path in models() {
        let name = crate::common::name(&path);
        let scene = plain(crate::common::load(&path));
        let surface = &scene.objects[0].surface;
        if surface.scheme() != Scheme::CatmullClark || !crate::common::is_closed(surface) {
            continue;
        }
        let wanted = Flatness {
            max_level: DEEPEST + u32::from(surface.is_split()),
            ..Flatness::default()
        };
        // All of it in the picture.
        for zoom in [0.1, 0.6, 1.0] {
            let renderer = adaptive(256, wanted);
            let camera = Camera::default().with_zoom(zoom);
            let mut ready = GpuScene::new(&gpu, &renderer, &scene, &camera).unwrap();
            if !ready.draw().unwrap().stats.decides {
                continue;
            }
            let mut blocks = ready.read_blocks().unwrap();
            assert_eq!(open_segments(&blocks), 0, "{name} at {zoom}");
            // A point that is elsewhere is seen.
            blocks[0].points[0][0] += 1.0;
            assert!(open_segments(&blocks) > 0);
            run += 1;
        }
    }
    assert!(
        run >= 6 || std::env::var_os("EARMARK_THOROUGH").is_some(),
        "{run}"
    );
    println!("gpu watertight blocks: {run} cases");
}

#[test]
fn blocks_follow_the_view_and_the_points() {
    let Some(gpu) = gpu("moving blocks") else {
        return;
    };
    let mut scene = asset("creature", SurfaceOptions::default());
    let renderer = adaptive(200, Flatness::default());
    let views = [0.3, 0.8].map(|zoom| {
        let camera = Camera::default().with_zoom(zoom);
        renderer.view(&scene, &camera).unwrap()
    });
    let up = |record: Vec<u32>| 4 * record.len() as u64;
    let (frame, metric) = (words(&[Frame::default()]), words(&[Metric::default()]));
    let (frame, metric) = (up(frame), up(metric));
    let made = |scene: &Scene, view| {
        let mut ready = GpuScene::for_view(&gpu, &renderer, scene, view).unwrap();
        ready.draw().unwrap()
    };
    let mut ready = GpuScene::for_view(&gpu, &renderer, &scene, views[0]).unwrap();
    let first = ready.draw().unwrap();
    assert!(first.stats.decides && ready.serves(&renderer, &scene, &views[1]).unwrap());
    let second = ready.draw_view(&views[1]).unwrap();
    let again = ready.draw_view(&views[1]).unwrap();
    assert!(second.stats.microtriangles > first.stats.microtriangles);
    assert_eq!(second.image.data, made(&scene, views[1]).image.data);
    assert_eq!(again.image.data, second.image.data);
    // Up goes the view, for the picture and for deciding; down come the picture and a few counts.
    assert_eq!(second.stats.bytes_up, frame + metric);
    assert_eq!(again.stats.bytes_up, frame);
    assert_eq!(second.stats.read_backs, 1);
    assert_eq!(second.stats.bytes_down, 4 * 200 * 200 + 32);
    let points = scene.objects[0].surface.cage().points();
    let moved: Vec<[f32; 3]> = points.iter().map(|p| [p[0], 1.5 * p[1], p[2]]).collect();
    ready.move_points(&moved).unwrap();
    let third = ready.draw_view(&views[1]).unwrap();
    assert_eq!(
        third.stats.bytes_up,
        frame + metric + 12 * moved.len() as u64
    );
    scene.objects[0].surface.update_points(&moved).unwrap();
    let want = made(&scene, views[1]);
    assert_eq!(third.image.data, want.image.data);
    assert_eq!(third.stats.microtriangles, want.stats.microtriangles);
    println!(
        "gpu moving blocks: {} triangles, then {}, then {}; up {} bytes for a view",
        first.stats.microtriangles,
        second.stats.microtriangles,
        third.stats.microtriangles,
        second.stats.bytes_up
    );
}

#[test]
fn what_has_no_room_is_an_error() {
    let Some(gpu) = gpu("room for blocks") else {
        return;
    };
    let scene = torus(9, 7);
    let mut renderer = adaptive(256, Flatness::default());
    let [far, near] = [0.05, 1.0].map(|zoom| {
        let camera = Camera::default().with_zoom(zoom);
        renderer.view(&scene, &camera).unwrap()
    });
    let mut ready = GpuScene::for_view(&gpu, &renderer, &scene, far).unwrap();
    let few = ready.draw().unwrap().stats.microtriangles;
    assert!(ready.draw_view(&near).unwrap().stats.microtriangles > few);
    // A few of its triangles are none, because their points moved.
    renderer.limits.max_faces = Some(few);
    let mut ready = GpuScene::for_view(&gpu, &renderer, &scene, far).unwrap();
    assert!(ready.draw().unwrap().stats.decides);
    let error = ready.draw_view(&near).unwrap_err();
    assert!(matches!(error, GpuError::OutOfMemory { .. }), "{error}");
    // Where there is room it goes on.
    assert_eq!(ready.draw_view(&far).unwrap().stats.microtriangles, few);
    // Where tables do not fit the processor decides.
    let small = DeviceOptions {
        max_binding: 200_000,
        ..DeviceOptions::default()
    };
    let Some(small) = gpu_with("room for blocks", &small) else {
        return;
    };
    renderer.limits.max_faces = None;
    let mut ready = GpuScene::for_view(&small, &renderer, &scene, far).unwrap();
    let drawn = ready.draw().unwrap();
    assert!(!drawn.stats.decides && drawn.stats.microtriangles == few);
    println!("gpu room for blocks: 4 cases");
}

#[test]
fn what_asks_for_deeper_levels_is_the_processors() {
    let Some(gpu) = gpu("deeper levels") else {
        return;
    };
    let scene = plain(asset("cube", SurfaceOptions::default()));
    let renderer = adaptive(256, Flatness::default());
    let [far, near] = [0.05, 1.0].map(|zoom| {
        let camera = Camera::default().with_zoom(zoom);
        renderer.view(&scene, &camera).unwrap()
    });
    let mut ready = GpuScene::for_view(&gpu, &renderer, &scene, far).unwrap();
    let first = ready.draw().unwrap().stats;
    assert!(first.decides && !first.falls_short);
    let second = ready.draw_view(&near).unwrap().stats;
    assert!(second.falls_short && second.coarse > 0);
    // Made for the view, it has the processor's blocks.
    let mut ready = GpuScene::for_view(&gpu, &renderer, &scene, near).unwrap();
    let got = ready.draw().unwrap();
    assert!(!got.stats.decides && got.stats.coarse == 0);
    let want = renderer.render(&scene, &Camera::default()).unwrap();
    assert_eq!(got.stats.microtriangles, want.stats.microtriangles);
    println!("gpu deeper levels: 3 cases");
}
