//! Blocks that the device decides on against the processor's, for a few views.

use crate::pictures::check;
use crate::{asset, gpu, plain};
use earmark::frame::Refinement;
use earmark::gpu::{Gpu, GpuScene, ReadBlock};
use earmark::tessellate::Flatness;
use earmark::{Camera, Renderer, Scene, SurfaceOptions};
use std::collections::{BTreeMap, BTreeSet};

/// Share of the tolerance within which a tested error may be on either side.
const NEAR: f32 = 1e-4;

/// Blocks of each face: where they begin, their size, and their points to some digits, which say what was moved.
type Blocks = BTreeMap<u32, Vec<([u32; 2], usize, Vec<[i64; 3]>)>>;

fn by_face(blocks: &[ReadBlock], size: f32) -> Blocks {
    let mut out = Blocks::new();
    for b in blocks {
        // Coarser than rounding, finer than what a moved point moves by.
        let digits = |p: &[f32; 6]| [p[0], p[1], p[2]].map(|c| (f64::from(c / size) * 2e4).round() as i64);
        let points = b.points.iter().map(digits).collect();
        out.entry(b.quad).or_default().push((b.start, b.side, points));
    }
    out
}

fn size(scene: &Scene) -> f32 {
    let [low, high] = scene.objects[0].surface.cage().bounds();
    (0..3).map(|k| high[k] - low[k]).fold(0.0, f32::max)
}

/// Faces whose blocks are not the same.
fn other(a: &Blocks, b: &Blocks) -> BTreeSet<u32> {
    let near = |a: &[[i64; 3]], b: &[[i64; 3]]| {
        let all = a.iter().flatten().zip(b.iter().flatten());
        a.len() == b.len() && all.clone().all(|(a, b)| a.abs_diff(*b) <= 1)
    };
    let same = |q: &u32| match (a.get(q), b.get(q)) {
        (Some(a), Some(b)) => {
            a.len() == b.len()
                && a.iter()
                    .zip(b)
                    .all(|(a, b)| (a.0, a.1) == (b.0, b.1) && near(&a.2, &b.2))
        }
        (None, None) => true,
        _ => false,
    };
    a.keys().chain(b.keys()).copied().filter(|q| !same(q)).collect()
}

fn adaptive(size: u32, flatness: Flatness) -> Renderer {
    let mut renderer = Renderer::new(size, size);
    renderer.refinement = Refinement::Adaptive(flatness);
    renderer
}

fn cameras() -> Vec<(&'static str, Camera)> {
    let base = Camera::default();
    vec![
        ("default", base.clone()),
        ("far", base.clone().with_zoom(0.4)),
        ("side", base.clone().with_eye_target([4.0, 3.0, 1.0], [0.0; 3]).with_zoom(0.9)),
    ]
}

/// Faces where the device differs although no test is near its tolerance, those that differ, and all.
fn compare(gpu: &Gpu, scene: &Scene, camera: &Camera, pixels: u32) -> Option<[usize; 3]> {
    let flatness = Flatness::default();
    let renderer = adaptive(pixels, flatness);
    let view = renderer.view(scene, camera).unwrap();
    let mut here = GpuScene::for_view(gpu, &renderer, scene, view).unwrap();
    let drawn = here.draw().unwrap();
    if !drawn.stats.decides {
        return None;
    }
    let size = size(scene);
    let got = by_face(&here.read_blocks().unwrap(), size);
    let processor = |times: f32| {
        let wanted = Flatness {
            pixels: flatness.pixels * times,
            degrees: flatness.degrees * times,
            ..flatness
        };
        let renderer = adaptive(pixels, wanted);
        let mut there = GpuScene::decided_by_processor(gpu, &renderer, scene, view).unwrap();
        let drawn = there.draw().unwrap();
        (by_face(&there.read_blocks().unwrap(), size), drawn)
    };
    let (want, want_drawn) = processor(1.0);
    let differ = other(&got, &want);
    let near: BTreeSet<u32> = [1.0 - NEAR, 1.0 + NEAR]
        .into_iter()
        .flat_map(|times| other(&processor(times).0, &want))
        .collect();
    let beyond: Vec<u32> = differ.difference(&near).copied().collect();
    for q in beyond.iter().take(4) {
        let show = |b: &Blocks| b.get(q).map(|b| b.iter().map(|b| (b.0, b.1)).collect::<Vec<_>>());
        println!("face {q}: {:?} for {:?}", show(&got), show(&want));
    }
    check("flatness", &drawn.image, &want_drawn.image);
    Some([beyond.len(), differ.len(), want.len()])
}

#[test]
fn blocks_are_the_processors() {
    let Some(gpu) = gpu("flatness") else { return };
    let mut sum = [0; 4];
    let only = std::env::var("EARMARK_ONLY").unwrap_or_default();
    for name in ["torus", "creature", "cube", "part", "part_creased", "fan5", "fan24", "corner", "mobius", "octahedron"] {
        if !only.is_empty() && only != name {
            continue;
        }
        let scene = plain(asset(name, SurfaceOptions::default()));
        for (what, camera) in cameras() {
            let found = compare(&gpu, &scene, &camera, 256);
            println!("gpu flatness {name} {what}: {found:?}");
            if let Some(found) = found {
                for (sum, found) in sum.iter_mut().zip(found) {
                    *sum += found;
                }
                sum[3] += 1;
            }
        }
    }
    println!("gpu flatness: {sum:?}");
}

#[test]
fn levels_probe() {
    let Some(gpu) = gpu("probe") else { return };
    for name in ["creature", "cube", "part", "part_creased", "fan24", "corner", "octahedron"] {
        let scene = plain(asset(name, SurfaceOptions::default()));
        let renderer = adaptive(256, Flatness::default());
        let view = renderer.view(&scene, &Camera::default()).unwrap();
        let mut there = GpuScene::decided_by_processor(&gpu, &renderer, &scene, view).unwrap();
        let drawn = there.draw().unwrap();
        println!("probe {name} levels {:?} tris {}", drawn.stats.levels, drawn.stats.microtriangles);
    }
}
