//! Everything at once, minutes long: all assets and reference models at levels 1 to 5, adaptive, displaced. Run by name with `--ignored`.

use crate::pictures::{check, draw};
use crate::points::{blocks, compare};
use crate::{gpu, plain, uniform};
use earmark::displace::{Displacement, Function};
use earmark::frame::Refinement;
use earmark::shade::ShadeMode;
use earmark::{Camera, Renderer, Scene};
use std::path::PathBuf;

/// Most micro-quads of a case.
const MOST: u64 = 2_000_000;

fn models() -> Vec<PathBuf> {
    let mut all = crate::common::models(&crate::common::assets());
    if let Some(shared) = crate::common::shared() {
        all.extend(crate::common::models(&shared.join("models")));
    }
    all
}

/// Samples of a flat picture that differ, and how many there are.
fn others(gpu: &earmark::gpu::Gpu, scene: &Scene, level: u32) -> [usize; 2] {
    let mut renderer = uniform(256, 256, level);
    renderer.size.samples = 1;
    renderer.mode = ShadeMode::Flat;
    let camera = Camera::default();
    let want = renderer.render(scene, &camera).unwrap().image;
    let got = draw(gpu, &renderer, scene, &camera);
    let pixels = got.data.chunks_exact(4).zip(want.data.chunks_exact(4));
    let seen: Vec<_> = pixels.filter(|(a, b)| a[3] != 0 || b[3] != 0).collect();
    let differ = |(a, b): &&(&[u8], &[u8])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1);
    [seen.iter().filter(differ).count(), seen.len()]
}

#[test]
#[ignore = "minutes: all assets and models at all levels"]
fn everything_is_the_processors() {
    let Some(gpu) = gpu("parity") else { return };
    let (mut far, mut turned) = (0.0_f64, 0.0_f64);
    let (mut points, mut beyond, mut bare) = (0, 0, 0);
    let (mut samples, mut differ) = (0, 0);
    let (mut mean, mut top) = (0.0_f64, 0);
    let mut run = 0;
    for path in models() {
        let name = crate::common::name(&path);
        let mut scene = plain(crate::common::load(&path));
        let quads: usize = scene
            .objects
            .iter()
            .map(|o| o.surface.quads().face_count())
            .sum();
        for displaced in [false, true] {
            if displaced {
                for object in &mut scene.objects {
                    let [low, high] = object.surface.cage().bounds();
                    let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f32::max);
                    let by = format!("fbm:frequency={},octaves=3", 6.0 / size);
                    let by: Function = by.parse().unwrap();
                    let by = Displacement::function(by).scaled(0.01 * size);
                    object.surface.set_displacement(Some(by));
                }
            }
            for level in 1..=5 {
                let split = u32::from(scene.objects[0].surface.is_split());
                if (quads as u64) << (2 * (level - split.min(level))) > MOST
                    || scene.objects.len() > 1
                {
                    continue;
                }
                let surface = &scene.objects[0].surface;
                let got = compare(surface, &blocks(&gpu, &scene, level), level);
                let off = got.angles.iter().filter(|&&a| a > 0.05).count();
                let [d, n] = others(&gpu, &scene, level);
                println!(
                    "parity {name} level {level} displaced {displaced}: {:.1e} of the model, {:.4} degrees, {off} beyond 0.05, {} bare of {}; {d} of {n} samples",
                    got.distance,
                    got.angle(),
                    got.bare,
                    got.points
                );
                far = far.max(got.distance);
                turned = turned.max(got.angle());
                (points, beyond, bare) = (points + got.points, beyond + off, bare + got.bare);
                (samples, differ) = (samples + n, differ + d);
                run += 1;
            }
            let mut renderer = Renderer::new(256, 256);
            // Tables of displaced surfaces are large.
            let max_level = if displaced { 5 } else { 8 };
            renderer.refinement = Refinement::Default { max_level };
            let camera = Camera::default();
            let want = renderer.render(&scene, &camera).unwrap();
            let got = draw(&gpu, &renderer, &scene, &camera);
            let found = check(&format!("parity_{name}_{displaced}"), &got, &want.image);
            (mean, top) = (mean.max(found.0), top.max(found.1));
            run += 1;
        }
    }
    println!(
        "gpu parity: {run} cases, {points} points off by at most {far:.1e} of the model, normals by {turned:.4} degrees, {beyond} of them by more than 0.05, {bare} without one; {differ} of {samples} samples show another triangle; adaptive pictures: mean at most {mean:.4}, 99.9th percentile {top}"
    );
}
