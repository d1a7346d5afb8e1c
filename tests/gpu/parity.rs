//! Everything at once: small assets at levels 1 to 3, adaptive, displaced; all assets and the reference models at levels 1 to 5 if
//! EARMARK_THOROUGH is 1, which takes a quarter of an hour and more; or those whose names it is, with commas between.

use crate::pictures::{check, draw, other_triangles};
use crate::points::{blocks, compare};
use crate::{gpu, plain};
use earmark::displace::{Displacement, Function};
use earmark::frame::Refinement;
use earmark::{Camera, Renderer};
use std::path::PathBuf;

/// Most micro-quads of a case, and where there is little time.
const MOST: [u64; 2] = [2_000_000, 20_000];

/// Whether there is time for everything.
fn is_thorough() -> bool {
    std::env::var_os("EARMARK_THOROUGH").is_some()
}

pub(crate) fn models() -> Vec<PathBuf> {
    let mut all = crate::common::models(&crate::common::assets());
    if let Some(shared) = crate::common::shared().filter(|_| is_thorough()) {
        all.extend(crate::common::models(&shared.join("models")));
    }
    let wanted = std::env::var("EARMARK_THOROUGH").unwrap_or_default();
    let wanted: Vec<&str> = wanted
        .split(',')
        .filter(|w| !["", "1"].contains(w))
        .collect();
    all.retain(|path| wanted.is_empty() || wanted.contains(&&*crate::common::name(path)));
    all
}

#[test]
fn everything_is_the_processors() {
    let Some(gpu) = gpu("parity") else { return };
    let (mut far, mut turned) = (0.0_f64, 0.0_f64);
    let (mut points, mut beyond, mut bare) = (0, 0, 0);
    let (mut samples, mut differ) = (0, 0);
    let (mut mean, mut top) = (0.0_f64, 0);
    let (mut run, mut left_out) = (0, 0);
    let (levels, most) = match is_thorough() {
        true => (1..=5, MOST[0]),
        false => (1..=3, MOST[1]),
    };
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
            let mut is_small = true;
            for level in levels.clone() {
                let split = u32::from(scene.objects[0].surface.is_split());
                is_small = (quads as u64) << (2 * (level - split.min(level))) <= most;
                if !is_small || scene.objects.len() > 1 {
                    left_out += 1;
                    continue;
                }
                let surface = &scene.objects[0].surface;
                let got = compare(surface, &blocks(&gpu, &scene, level), level);
                let off = got.beyond[1];
                let [d, n] = other_triangles(&gpu, &scene, level);
                println!(
                    "parity {name} level {level} displaced {displaced}: {:.1e} of the model, {:.4} degrees, {} points and {off} normals beyond the bars, {:?} unexplained, {} bare of {}; {d} of {n} samples",
                    got.distance,
                    got.angle(),
                    got.beyond[0],
                    got.unexplained,
                    got.bare,
                    got.points
                );
                let what = format!("{name} at level {level}, displaced: {displaced}");
                // Where heights are those of the surface's curvature it turns about at a point, and normals there are of no direction.
                let few = got.points / 2000;
                let odd = got.points / 50_000;
                assert!(
                    got.unexplained[0] == 0 && got.unexplained[1] <= odd,
                    "{what}: rounding does not explain {:?}",
                    got.unexplained
                );
                let [moved, turned_off] = got.beyond;
                assert!(
                    moved <= few && turned_off <= few && got.bare <= few,
                    "{what}: {moved} points, {turned_off} normals, {} bare of {few}",
                    got.bare
                );
                assert!(d * 1000 <= n, "{what}: {d} of {n} samples");
                far = far.max(got.distance);
                turned = turned.max(got.angle());
                (points, beyond, bare) = (points + got.points, beyond + off, bare + got.bare);
                (samples, differ) = (samples + n, differ + d);
                run += 1;
            }
            if !is_small && !is_thorough() {
                continue;
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
        "gpu parity: {run} cases, {left_out} left out, {points} points off by at most {far:.1e} of the model, normals by {turned:.4} degrees, {beyond} of them by more than 0.05, {bare} without one; {differ} of {samples} samples show another triangle; adaptive pictures: mean at most {mean:.4}, 99.9th percentile {top}"
    );
    assert!(run > 30 || is_thorough() && run > 0);
}
