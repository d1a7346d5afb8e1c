//! Pictures of patches: no cracks, the same bytes for any threads and vectors, adaptive as any surface.

use super::*;
use earmark::camera::Camera;
use earmark::displace::{Displacement, Function};
use earmark::frame::coverage::{CoverageFault, SignedCoverage};
use earmark::frame::{Refinement, Renderer};
use earmark::simd::Level;
use earmark::tessellate::Flatness;
use earmark::{Scene, film};

fn scene(cage: &Cage, scheme: Scheme, kind: PatchKind) -> Scene {
    Scene::of(surface(cage, scheme, kind))
}

fn cages() -> Vec<(&'static str, Cage, Scheme)> {
    vec![
        ("creature", asset("creature"), Scheme::CatmullClark),
        ("prism", prism(), Scheme::CatmullClark),
        ("creased cube", creased_cube(10.0), Scheme::CatmullClark),
        ("icosahedron", icosahedron(), Scheme::Loop),
        ("octahedron", asset("octahedron"), Scheme::Butterfly),
        ("cube", asset("cube"), Scheme::Kobbelt),
    ]
}

#[test]
fn closed_models_have_as_many_fronts_as_backs_at_every_sample() {
    let mut sum = SignedCoverage::default();
    for (name, cage, scheme) in cages() {
        for kind in [PatchKind::Qas, PatchKind::Pn] {
            let scene = scene(&cage, scheme, kind);
            for level in 0..=6 {
                let c = coverage::count(&scene, 160, level, 4, CoverageFault::None);
                assert_eq!(c.unequal, 0, "{name} {kind:?} at level {level}");
                sum.samples += c.samples;
                sum.covered += c.covered;
            }
        }
    }
    println!(
        "patches: 0 of {} samples unequal, {} covered",
        sum.samples, sum.covered
    );
    assert!(sum.covered > 100_000);
}

#[test]
fn adaptive_pictures_have_no_cracks_and_keep_their_tolerance() {
    for (name, cage, scheme) in cages() {
        for kind in [PatchKind::Qas, PatchKind::Pn] {
            let scene = scene(&cage, scheme, kind);
            for pixels in [0.25, 2.0] {
                let mut renderer = Renderer::new(160, 160);
                renderer.refinement = Refinement::Adaptive(Flatness {
                    pixels,
                    ..Flatness::default()
                });
                for view in coverage::views(&scene, &renderer, 4, 11) {
                    let c = renderer.signed_coverage(&scene, &view, CoverageFault::None);
                    assert_eq!(c.unwrap().unequal, 0, "{name} {kind:?} at {pixels} pixels");
                    let d = renderer.deviation(&scene, &view, 4).unwrap();
                    assert!(
                        d.pixels <= pixels,
                        "{name} {kind:?} at {pixels} pixels: {d:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn displaced_patches_have_no_cracks() {
    let mut covered = 0;
    for (name, cage, scheme) in cages() {
        for kind in [PatchKind::Qas, PatchKind::Pn] {
            let mut scene = scene(&cage, scheme, kind);
            let ripples: Function = "ripples".parse().unwrap();
            let displacement = Displacement::function(ripples).scaled(0.02 * size(&cage));
            scene.objects[0]
                .surface
                .set_displacement(Some(displacement));
            for level in [2, 5] {
                let c = coverage::count(&scene, 160, level, 3, CoverageFault::None);
                assert_eq!(c.unequal, 0, "{name} {kind:?} at level {level}");
                covered += c.covered;
            }
        }
    }
    assert!(covered > 100_000);
}

#[test]
fn threads_and_vectors_change_nothing() {
    for (name, cage, scheme) in cages() {
        for kind in [PatchKind::Qas, PatchKind::Pn] {
            let scene = scene(&cage, scheme, kind);
            let draw = |threads: usize, simd: Level| {
                let mut renderer = Renderer::new(160, 160);
                renderer.refinement = Refinement::Uniform(3);
                renderer.simd = simd;
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                let finished = pool
                    .unwrap()
                    .install(|| renderer.render(&scene, &Camera::default()));
                film::png::encode(&finished.unwrap().image).unwrap()
            };
            let first = draw(1, Level::SCALAR);
            for threads in [2, 8] {
                assert!(draw(threads, Level::detect()) == first, "{name} {kind:?}");
            }
            for simd in Level::available() {
                assert!(draw(2, simd) == first, "{name} {kind:?} {}", simd.name());
            }
        }
    }
}

#[test]
fn an_animated_cage_is_as_a_fresh_one() {
    for kind in [PatchKind::Qas, PatchKind::Pn] {
        for (_, cage, scheme) in cages() {
            let mut moved = surface(&cage, scheme, kind);
            let points: Vec<[f32; 3]> = (cage.points().iter())
                .map(|p| [p[0] * 1.25, p[1] - 0.1, p[2] * p[2] * 0.1 + p[2]])
                .collect();
            moved.update_points(&points).unwrap();
            // Diagonals stay where they were at first.
            let mut fresh = surface(moved.cage(), scheme, PatchKind::None);
            assert_eq!(fresh.cage().points(), points);
            fresh.update_points(cage.points()).unwrap();
            let mut fresh = surface(fresh.cage(), scheme, kind);
            fresh.update_points(&points).unwrap();
            for q in (0..moved.quads().face_count() as u32).step_by(31) {
                assert_eq!(moved.dice(q, 2), fresh.dice(q, 2));
            }
        }
    }
}

#[test]
fn framing_knows_that_pn_triangles_go_through_the_cage() {
    let cage = asset("cube");
    let limit = scene(&cage, Scheme::CatmullClark, PatchKind::None);
    let pn = scene(&cage, Scheme::CatmullClark, PatchKind::Pn);
    let radius = |s: &Scene| s.bounding_sphere().radius;
    assert!((radius(&limit) - 0.75_f64.sqrt()).abs() < 1e-6);
    assert!((radius(&pn) - 3.0_f64.sqrt()).abs() < 1e-6);
}
