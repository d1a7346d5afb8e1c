//! Surfaces of interpolating schemes, face by face from tables, against whole-mesh refinement, and their edges.
#![allow(missing_docs)]

#[path = "common/mod.rs"]
mod common;
#[path = "common/coverage.rs"]
mod coverage;
#[path = "common/edges.rs"]
mod edges;
#[path = "common/oracle.rs"]
mod oracle;
#[path = "support/mod.rs"]
mod support;

#[path = "interpolating/evaluate.rs"]
mod evaluate;

use common::{assets, load};
use earmark::dice::DiceFault;
use earmark::frame::coverage::CoverageFault;
use earmark::refine::{Level, refine};
use earmark::scheme::{FaceVaryingRule, Scheme};
use earmark::topology::NONE;
use earmark::{Cage, Scene, Surface, SurfaceOptions};

fn options(scheme: Scheme) -> SurfaceOptions {
    SurfaceOptions {
        scheme: Some(scheme),
        ..SurfaceOptions::default()
    }
}

/// An asset under a scheme; Butterfly takes the triangles of its faces.
fn asset(name: &str, scheme: Scheme) -> Surface {
    let scene = load(&assets().join(name));
    let cage = scene.objects[0].surface.cage().clone();
    let cage = match scheme {
        Scheme::Butterfly => cage.triangulated(),
        _ => cage,
    };
    Surface::new(cage, &options(scheme))
}

fn icosahedron() -> Cage {
    let g = 1.618_034;
    let mut points = Vec::new();
    for a in [-1.0, 1.0] {
        for b in [-g, g] {
            points.extend([[0.0, a, b], [a, b, 0.0], [b, 0.0, a]]);
        }
    }
    let close = |p: [f32; 3], q: [f32; 3]| {
        let d: f32 = (0..3).map(|k| (p[k] - q[k]).powi(2)).sum();
        (d - 4.0).abs() < 0.1
    };
    let mut corners = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                let p = [points[i], points[j], points[k]];
                if close(p[0], p[1]) && close(p[1], p[2]) && close(p[0], p[2]) {
                    let [a, b, c] = p;
                    let u = [0, 1, 2].map(|n| b[n] - a[n]);
                    let v = [0, 1, 2].map(|n| c[n] - a[n]);
                    let det = a[0] * (u[1] * v[2] - u[2] * v[1])
                        + a[1] * (u[2] * v[0] - u[0] * v[2])
                        + a[2] * (u[0] * v[1] - u[1] * v[0]);
                    corners.extend(match det > 0.0 {
                        true => [i, j, k].map(|x| x as u32),
                        false => [i, k, j].map(|x| x as u32),
                    });
                }
            }
        }
    }
    assert_eq!(corners.len(), 60);
    Cage::new(points, &[3; 20], corners).unwrap()
}

/// A bumpy sheet of `n` by `n` squares, as quads or as triangles; `crease` is a row of infinitely sharp edges.
fn sheet(n: u32, scheme: Scheme, crease: Option<u32>) -> Surface {
    let points: Vec<[f32; 3]> = (0..(n + 1) * (n + 1))
        .map(|k| {
            let (i, j) = (k % (n + 1), k / (n + 1));
            let h = ((i * 7 + j * 13 + i * j) % 5) as f32 * 0.15;
            [i as f32, j as f32, h]
        })
        .collect();
    let at = |i: u32, j: u32| j * (n + 1) + i;
    let mut builder = Cage::builder().points(points);
    for j in 0..n {
        for i in 0..n {
            let q = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            match scheme {
                Scheme::Butterfly => {
                    builder = builder.face([q[0], q[1], q[2]]).face([q[0], q[2], q[3]]);
                }
                _ => builder = builder.face(q),
            }
        }
    }
    if let Some(row) = crease {
        for i in 0..n {
            builder = builder.crease(at(i, row), at(i + 1, row), f32::INFINITY);
        }
    }
    Surface::new(builder.build().unwrap(), &options(scheme))
}

/// All cases: name, surface, deepest level of the cage to compare.
fn cases() -> Vec<(String, Surface, u32)> {
    let mut out = Vec::new();
    for scheme in [Scheme::Kobbelt, Scheme::Butterfly] {
        for (name, level) in [
            ("cube.obj", 5),
            ("tetrahedron.obj", 5),
            ("octahedron.obj", 5),
            ("fan3.obj", 5),
            ("fan5.obj", 5),
            ("fan8.obj", 5),
            ("corner.obj", 5),
            ("mobius.obj", 5),
            ("torus.obj", 4),
            ("part.obj", 3),
            ("creature.obj", 3),
        ] {
            out.push((format!("{scheme:?} {name}"), asset(name, scheme), level));
        }
        for (n, crease) in [(2, None), (5, None), (5, Some(2)), (2, Some(1))] {
            let name = format!("{scheme:?} sheet {n} {crease:?}");
            out.push((name, sheet(n, scheme, crease), 5));
        }
    }
    let icosahedron = Surface::new(icosahedron(), &options(Scheme::Butterfly));
    out.push(("icosahedron".into(), icosahedron, 6));
    out
}

#[test]
fn faces_are_what_whole_mesh_refinement_makes() {
    for (name, surface, deepest) in cases() {
        let first = u32::from(surface.is_split());
        for level in first..=deepest {
            let worst = oracle::compare(&surface, level);
            eprintln!(
                "{name} level {level}: {worst:?} {:?}",
                surface.table_bytes(level - first)
            );
            assert!(worst.count > 0);
            assert!(worst.point < 2e-6, "{name} level {level}: {worst:?}");
            // The strip's two ends meet with opposite windings, an edge of which masks know nothing.
            if !name.contains("mobius") {
                assert!(worst.normal < 0.05, "{name} level {level}: {worst:?}");
            }
        }
    }
}

#[test]
fn cage_vertices_lie_on_the_surface() {
    for (name, surface, _) in cases() {
        let (t, cage) = (surface.quads(), surface.control_base());
        // The first step makes quads of polygons, and keeps the vertices where they are.
        for h in 0..t.half_count() as u32 {
            let v = t.vertex(h) as usize;
            if v < cage.len() {
                assert_eq!(surface.control_points()[v], cage[v], "{name}");
                assert_eq!(surface.fan_limit(t.fan(h)).0, cage[v], "{name}");
            }
        }
        let grid = surface.dice(0, 3);
        let first = surface.control_points()[t.vertex(0) as usize];
        assert_eq!(grid.points[0], first, "{name}");
    }
}

#[test]
fn both_faces_of_every_edge_give_the_same_bits() {
    let mut compared = 0;
    for (name, surface, _) in cases() {
        let scene = Scene::of(surface);
        let surface = &scene.objects[0].surface;
        let view = edges::view_of(&scene);
        for level in [1, 2, 3, 5] {
            let (differ, n) = edges::compare(surface, &view, level, DiceFault::None);
            assert_eq!(
                differ, 0,
                "{name} at level {level}: {differ} of {n} points differ"
            );
            compared += n;
        }
    }
    assert!(compared > 100_000);
}

#[test]
fn faces_that_dice_their_own_sides_are_noticed() {
    for scheme in [Scheme::Kobbelt, Scheme::Butterfly] {
        let scene = Scene::of(asset("creature.obj", scheme));
        let view = edges::view_of(&scene);
        let surface = &scene.objects[0].surface;
        let (differ, _) = edges::compare(surface, &view, 4, DiceFault::OwnDirection);
        assert!(differ > 0, "{scheme:?}");
    }
}

#[test]
fn creases_share_points_and_keep_their_normals() {
    for scheme in [Scheme::Kobbelt, Scheme::Butterfly] {
        let surface = sheet(5, scheme, Some(2));
        let plain = sheet(5, scheme, None);
        let (cut, whole) = (surface.quads(), plain.quads());
        let (mut shared, mut differ) = (0, 0);
        for h in 0..whole.half_count() as u32 {
            let g = whole.twin(h);
            if g == NONE || cut.twin(h) != NONE {
                continue;
            }
            let side = |h: u32, back: bool| -> Vec<([f32; 3], [f32; 3])> {
                let f = cut.face_of(h);
                let grid = surface.dice(f, 5);
                let n = grid.side - 1;
                let mut out: Vec<_> = (0..=n)
                    .map(|k| {
                        let [i, j] = match (h - cut.face_halves(f).start, surface.is_triangular()) {
                            (0, _) => [k, 0],
                            (1, _) => [n, k],
                            (2, true) => [n - k, n - k],
                            (2, false) => [n - k, n],
                            _ => [0, n - k],
                        };
                        (
                            grid.points[j * grid.side + i],
                            grid.normals[j * grid.side + i],
                        )
                    })
                    .collect();
                if back {
                    out.reverse();
                }
                out
            };
            for (a, b) in side(h, false).into_iter().zip(side(g, true)) {
                assert_eq!(a.0, b.0, "{scheme:?}");
                shared += 1;
                differ += u32::from(a.1 != b.1);
            }
        }
        assert_eq!(shared, 2 * 5 * 33, "{scheme:?}");
        assert!(differ > 300, "{scheme:?}: {differ}");
    }
}

#[test]
fn closed_models_have_as_many_fronts_as_backs_at_every_sample() {
    let mut covered = 0;
    for (name, surface, _) in cases() {
        if !common::is_closed(&surface) {
            continue;
        }
        let scene = Scene::of(surface);
        for level in [0, 2, 3, 5] {
            let c = coverage::count(&scene, 160, level, 4, CoverageFault::None);
            assert_eq!(c.unequal, 0, "{name} at level {level}");
            covered += c.covered;
        }
    }
    assert!(covered > 100_000);
}

#[test]
fn texture_coordinates_are_what_whole_mesh_refinement_makes() {
    let mut compared = 0;
    for scheme in [Scheme::Kobbelt, Scheme::Butterfly] {
        for name in ["creature.obj", "torus.obj", "grid.obj"] {
            for rule in [
                FaceVaryingRule::CornersPlus1,
                FaceVaryingRule::None,
                FaceVaryingRule::Boundaries,
                FaceVaryingRule::All,
            ] {
                let cage = asset(name, scheme).cage().clone();
                let options = SurfaceOptions {
                    face_varying: Some(rule),
                    ..options(scheme)
                };
                let surface = Surface::new(cage, &options);
                let first = u32::from(surface.is_split());
                let level = first + 3;
                let base =
                    Level::<f64>::of_cage(surface.cage(), surface.topology().clone(), scheme, rule)
                        .unwrap();
                let o = surface.refine_options();
                let fine = refine(base, &o, level, None, &mut Default::default()).unwrap();
                let uvs = fine.uvs.as_ref().unwrap();
                for q in 0..surface.quads().face_count() as u32 {
                    let grid = surface.dice(q, level - first);
                    let corners = oracle::grid_corners(&surface, q, level - first);
                    for (k, h) in corners.into_iter().enumerate().filter(|c| c.1 != u32::MAX) {
                        let want = uvs.values[uvs.corners[h as usize] as usize];
                        let got = grid.uvs[k];
                        for c in 0..2 {
                            let error = (f64::from(got[c]) - want[c]).abs();
                            assert!(error < 2e-6, "{scheme:?} {name} {rule:?} face {q}: {error}");
                        }
                        compared += 1;
                    }
                }
            }
        }
    }
    assert!(compared > 100_000);
}

#[test]
fn moved_points_leave_nothing_of_the_old_ones() {
    for scheme in [Scheme::Kobbelt, Scheme::Butterfly] {
        let mut moved = asset("torus.obj", scheme);
        let before = moved.dice(3, 4);
        let points: Vec<[f32; 3]> = (moved.control_base().iter())
            .map(|p| [p[0] + 0.3 * p[1], p[1] * 1.5, p[2] - p[0] * p[0]])
            .collect();
        moved.update_points(&points).unwrap();
        let cage = moved.cage();
        let sizes: Vec<u32> = (0..cage.face_count())
            .map(|f| cage.face(f).len() as u32)
            .collect();
        let fresh = Cage::new(points, &sizes, cage.corner_vertices().to_vec())
            .and_then(|c| c.with_uvs(cage.uvs().to_vec(), cage.corner_uvs().to_vec()))
            .unwrap();
        let fresh = Surface::new(fresh, &options(scheme));
        assert_ne!(moved.dice(3, 4).points, before.points);
        for q in 0..moved.quads().face_count() as u32 {
            let (a, b) = (moved.dice(q, 4), fresh.dice(q, 4));
            assert!(
                a.points == b.points && a.normals == b.normals,
                "{scheme:?} {q}"
            );
        }
    }
}

#[test]
fn blocks_share_their_border() {
    use earmark::records::Grid3;
    use earmark::stream::BlockStream;
    for scheme in [Scheme::Kobbelt, Scheme::Butterfly] {
        let surface = asset("octahedron.obj", scheme);
        // Two blocks a side: what blocks share is the same.
        let mut stream = BlockStream::new(&surface, 6);
        let whole = surface.dice(1, 6);
        let mut points = Grid3::boxed();
        stream.quad(1, |stream, u, v| {
            stream.dice(u, v, &mut points, None);
            for j in 0..=32 {
                for i in 0..=32 {
                    let k = (v as usize * 32 + j) * whole.side + u as usize * 32 + i;
                    if !surface.is_triangular() || j + 32 * v as usize <= i + 32 * u as usize {
                        assert_eq!(points.get(i, j), whole.points[k]);
                    }
                }
            }
        });
    }
}
