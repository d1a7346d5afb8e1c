//! Closed displaced models have as many fronts as backs, and pictures have the same bytes however they are made.

use super::*;
use earmark::frame::Refinement;
use earmark::frame::coverage::CoverageFault;
use earmark::simd::Level;
use earmark::tessellate::Flatness;
use earmark::{Camera, Renderer, Scene};

/// Closed models with seams and creases, each displaced in its own way.
fn scenes() -> Vec<(&'static str, Scene)> {
    let map = || Displacement::map(noise_map(24, 5)).scaled(0.3).biased(-0.1);
    let displaced = |mut surface: Surface, displacement| {
        surface.set_displacement(Some(displacement));
        Scene::of(surface)
    };
    let smooth = SurfaceOptions::default();
    let triangles = torus(6, 6, true, &smooth).cage().triangulated();
    let mut out = vec![
        (
            "map on seams",
            displaced(torus(6, 6, false, &smooth), map()),
        ),
        (
            "map on creases",
            displaced(torus(6, 6, true, &smooth), map()),
        ),
        (
            "noise on creases",
            displaced(
                torus(6, 6, true, &smooth),
                noise("ridged:frequency=2").scaled(0.2),
            ),
        ),
        (
            "map on triangles",
            displaced(Surface::new(triangles, &by(Scheme::Loop)), map()),
        ),
        (
            "map on kobbelt",
            displaced(torus(6, 6, false, &by(Scheme::Kobbelt)), map()),
        ),
        (
            "map on bilinear",
            displaced(torus(6, 6, false, &by(Scheme::Bilinear)), map()),
        ),
    ];
    for (asset, scale) in [("creature", 0.05), ("octahedron", 0.3)] {
        let mut scene = common::load(&common::assets().join(format!("{asset}.obj")));
        let displacement = match asset {
            "creature" => map().scaled(scale).biased(0.0),
            _ => noise("fbm:frequency=2").scaled(scale),
        };
        scene.objects[0]
            .surface
            .set_displacement(Some(displacement));
        out.push((asset, scene));
    }
    out.retain(|(_, scene)| common::is_closed(&scene.objects[0].surface));
    out
}

#[test]
fn closed_models_have_as_many_fronts_as_backs() {
    for (name, scene) in scenes() {
        for level in [0, 1, 2, 3, 5, 6] {
            if level > 3 && scene.face_count() > 200 {
                continue;
            }
            let c = coverage::count(&scene, 96, level, 3, CoverageFault::None);
            assert!(c.covered > 1000, "{name} level {level}: {c:?}");
            assert_eq!(c.unequal, 0, "{name} level {level}: {c:?}");
        }
        for pixels in [0.25, 2.0, 20.0] {
            let mut renderer = coverage::renderer(96, 0);
            renderer.refinement = Refinement::Adaptive(Flatness {
                pixels,
                degrees: 20.0 * pixels,
                max_level: 6,
            });
            for view in coverage::views(&scene, &renderer, 2, 9) {
                let c = renderer
                    .signed_coverage(&scene, &view, CoverageFault::None)
                    .unwrap();
                assert_eq!(c.unequal, 0, "{name} at {pixels} px: {c:?}");
            }
        }
    }
}

#[test]
fn pictures_have_the_same_bytes_for_any_threads_and_instructions() {
    let scenes: Vec<_> = scenes()
        .into_iter()
        .filter(|s| s.0.contains("creases") || s.0.contains("triangles"))
        .collect();
    assert_eq!(scenes.len(), 3);
    for (name, scene) in scenes {
        for refinement in [
            Refinement::Uniform(3),
            Refinement::Adaptive(Flatness {
                pixels: 1.0,
                ..Flatness::default()
            }),
        ] {
            let draw = |threads: usize, simd: Level| {
                let mut renderer = Renderer::new(72, 72);
                renderer.refinement = refinement;
                renderer.simd = simd;
                let pool = rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .unwrap();
                pool.install(|| renderer.render(&scene, &Camera::default()).unwrap().image)
            };
            let first = draw(1, Level::SCALAR);
            for (threads, simd) in [(2, Level::SCALAR), (8, Level::detect())] {
                assert!(
                    draw(threads, simd) == first,
                    "{name} {refinement:?} {threads} {simd:?}"
                );
            }
            for simd in Level::available() {
                assert!(draw(1, simd) == first, "{name} {refinement:?} {simd:?}");
            }
        }
    }
}
