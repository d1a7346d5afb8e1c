//! Adaptive tessellation: no cracks at unequal levels, triangles as close to the surface as asked for.

mod common;
#[path = "common/coverage.rs"]
mod coverage;

use earmark::flatness::Flatness;
use earmark::frame::Refinement;
use earmark::frame::coverage::CoverageFault;

#[test]
fn closed_models_have_as_many_fronts_as_backs_at_every_tolerance() {
    let (mut samples, mut covered, mut triangles) = (0, 0, 0);
    for path in common::models(&common::assets()) {
        let scene = common::load(&path);
        if !common::is_closed(&scene.objects[0].surface) {
            continue;
        }
        for pixels in [0.05, 0.25, 1.0, 4.0, 30.0] {
            let mut renderer = coverage::renderer(160, 0);
            renderer.refinement = Refinement::Adaptive(Flatness {
                pixels,
                degrees: 20.0 * pixels,
                ..Flatness::default()
            });
            for view in coverage::views(&scene, &renderer, 6, 7) {
                let c = renderer
                    .signed_coverage(&scene, &view, CoverageFault::None)
                    .unwrap();
                assert_eq!(
                    c.unequal,
                    0,
                    "{} at {pixels} pixels: {} of {} samples",
                    path.display(),
                    c.unequal,
                    c.samples
                );
                samples += c.samples;
                covered += c.covered;
                triangles += renderer
                    .render_view(&scene, &view)
                    .unwrap()
                    .stats
                    .microtriangles;
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
