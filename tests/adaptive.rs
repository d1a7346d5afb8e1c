//! Adaptive tessellation: no cracks at unequal levels, triangles as close to the surface as asked for.

mod common;
#[path = "common/coverage.rs"]
mod coverage;

use earmark::frame::Refinement;
use earmark::frame::coverage::CoverageFault;
use earmark::tessellate::Flatness;
use earmark::{Cage, Scene, Surface, SurfaceOptions};

/// A closed torus of `4 n` by `n` quads, one side flat, with infinite creases around, a dart, and some that fade.
fn creased(n: u32) -> Scene {
    let (m, turn) = (4 * n, std::f32::consts::TAU);
    let at = |i: u32, j: u32| (i % m) * n + j % n;
    let mut cage = Cage::builder();
    let points = (0..m * n).map(|k| {
        let (i, j) = (k / n, k % n);
        let (a, b) = (turn * i as f32 / m as f32, turn * j as f32 / n as f32);
        let r = 2.0 + b.cos() * (0.7 + 0.2 * (3.0 * a).sin());
        [r * a.cos(), (b.sin() * 0.7).max(-0.4), r * a.sin()]
    });
    cage = cage.points(points);
    for (i, j) in (0..m).flat_map(|i| (0..n).map(move |j| (i, j))) {
        cage = cage.face([at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
    }
    for i in 0..m {
        cage = cage.crease(at(i, 0), at(i + 1, 0), 10.0);
        cage = cage.crease(at(i, n / 2), at(i + 1, n / 2), 0.3 * (i % 9) as f32);
    }
    for j in 1..3 {
        cage = cage.crease(at(2, j), at(2, j + 1), 10.0);
    }
    Scene::of(Surface::new(
        cage.build().unwrap(),
        &SurfaceOptions::default(),
    ))
}

#[test]
fn closed_models_have_as_many_fronts_as_backs_at_every_tolerance() {
    let (mut samples, mut covered, mut triangles) = (0, 0, 0);
    let mut scenes = vec![("creased".to_owned(), creased(6))];
    for path in common::models(&common::assets()) {
        scenes.push((path.display().to_string(), common::load(&path)));
    }
    scenes.retain(|(_, scene)| common::is_closed(&scene.objects[0].surface));
    for (name, scene) in &scenes {
        for pixels in [0.05, 0.25, 1.0, 4.0, 30.0] {
            let mut renderer = coverage::renderer(160, 0);
            renderer.refinement = Refinement::Adaptive(Flatness {
                pixels,
                degrees: 20.0 * pixels,
                ..Flatness::default()
            });
            for view in coverage::views(scene, &renderer, 6, 7) {
                let c = renderer
                    .signed_coverage(scene, &view, CoverageFault::None)
                    .unwrap();
                assert_eq!(
                    c.unequal, 0,
                    "{name} at {pixels} pixels: {} of {} samples",
                    c.unequal, c.samples
                );
                samples += c.samples;
                covered += c.covered;
                let drawn = renderer.render_view(scene, &view).unwrap();
                triangles += drawn.stats.microtriangles;
            }
        }
    }
    println!("adaptive: 0 of {samples} samples unequal, {covered} covered, {triangles} triangles");
    assert!(covered > 100_000);
}

#[test]
fn triangles_are_as_close_to_the_surface_as_asked_for() {
    let (mut worst, mut bent, mut views) = (0.0_f32, 0.0_f32, 0);
    for path in common::models(&common::assets()) {
        let scene = common::load(&path);
        for pixels in [0.25, 1.0] {
            let mut renderer = coverage::renderer(512, 0);
            renderer.refinement = Refinement::Adaptive(Flatness {
                pixels,
                ..Flatness::default()
            });
            for view in coverage::views(&scene, &renderer, 3, 11) {
                let d = renderer.deviation(&scene, &view, 2).unwrap();
                let what = format!("{} at {pixels} pixels: {d:?}", path.display());
                assert!(d.pixels <= pixels, "{what}");
                // Folds of a pixel's width, and corners where the surface has no tangent plane, bend as they like.
                let bends = ["creature.obj", "part_creased.obj"];
                let smooth = !bends.iter().any(|name| path.ends_with(name));
                assert!(!smooth || d.degrees <= 3.0, "{what}");
                worst = worst.max(d.pixels / pixels);
                bent = bent.max(d.degrees);
                views += 1;
            }
        }
    }
    println!("adaptive: {worst} of the tolerance at most in {views} views, {bent} degrees");
    assert!(worst > 0.3, "nothing was measured");
}
