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

use common::{assets, load};
use earmark::dice::DiceFault;
use earmark::frame::coverage::CoverageFault;
use earmark::refine::{Level, limit, refine};
use earmark::scheme::{FaceVaryingRule, Scheme};
use earmark::{Cage, Scene, Surface, SurfaceOptions};

fn options(scheme: Scheme) -> SurfaceOptions {
    SurfaceOptions {
        scheme,
        ..SurfaceOptions::default()
    }
}

fn sizes(cage: &Cage) -> Vec<u32> {
    (0..cage.face_count())
        .map(|f| cage.face(f).len() as u32)
        .collect()
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
            ("cube.obj", 6),
            ("tetrahedron.obj", 6),
            ("octahedron.obj", 6),
            ("fan3.obj", 6),
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
            assert!(worst.normal < 0.05, "{name} level {level}: {worst:?}");
        }
    }
}
