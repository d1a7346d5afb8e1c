//! Loop, Modified Butterfly and Kobbelt's scheme: values known beforehand, invariants, smoothness.
#![allow(missing_docs, clippy::print_stdout)]

#[path = "common/loop_oracle.rs"]
mod loop_oracle;
mod support;

use earmark::refine::{Level, Options, RefineError, Timings, has_semi_sharp, limit};
use earmark::scheme::{Boundary, FaceVaryingRule, Scheme};
use earmark::topology::{ConnectOptions, Ring, connect};
use std::collections::BTreeSet;
use support::*;

fn by(scheme: Scheme) -> Options {
    Options {
        scheme,
        ..Options::default()
    }
}

/// Every face of `shape` as a fan of triangles.
fn triangulated(shape: &Shape) -> Shape {
    let faces: Vec<[u32; 3]> = shape
        .face_offsets
        .windows(2)
        .flat_map(|w| {
            let f = shape.corners[w[0] as usize..w[1] as usize].to_vec();
            (1..f.len() - 1).map(move |i| [f[0], f[i], f[i + 1]])
        })
        .collect();
    let slices: Vec<&[u32]> = faces.iter().map(|f| f.as_slice()).collect();
    Shape {
        creases: shape.creases.clone(),
        sharp_vertices: shape.sharp_vertices.clone(),
        ..Shape::new(&shape.points, &slices)
    }
}

/// Lattice of unit equilateral triangles with `n` steps along each side, height by `height`.
fn lattice(n: u32, height: impl Fn(f64, f64) -> f64) -> Shape {
    let mut shape = triangulated(&grid(n, |_, _| 0.0));
    for p in &mut shape.points {
        let (x, y) = (p[0] - 0.5 * p[1], p[1] * 0.75_f64.sqrt());
        *p = [x, y, height(x, y)];
    }
    // The fan's diagonals run along (1, 1), which the shear must make short.
    for p in &shape.points {
        assert!(p[2].is_finite());
    }
    shape
}

/// Points so far inside a lattice that no stencil has met the border.
fn is_inside(p: &[f64; 3], n: f64) -> bool {
    let y = p[1] / 0.75_f64.sqrt();
    let x = p[0] + 0.5 * y;
    let clear = 3.5..=n - 3.5;
    clear.contains(&x) && clear.contains(&y)
}

/// `n` faces around vertex 0 with random heights: triangles or quads.
fn disc(n: u32, quads: bool, seed: u64) -> Shape {
    let shape = star(n, seed);
    if quads {
        return shape;
    }
    // The ends of the edges alone.
    let points: Vec<[f64; 3]> = std::iter::once(shape.points[0])
        .chain((0..n).map(|i| shape.points[1 + 2 * i as usize]))
        .collect();
    let faces: Vec<[u32; 3]> = (0..n).map(|i| [0, 1 + i, 1 + (i + 1) % n]).collect();
    let slices: Vec<&[u32]> = faces.iter().map(|f| f.as_slice()).collect();
    Shape::new(&points, &slices)
}

/// The part of a level within `rings` rings of faces around vertex 0, vertices in their order.
fn around(level: &Level<f64>, rings: usize) -> Level<f64> {
    let t = &level.topology;
    let mut vertices = BTreeSet::from([0]);
    let mut faces = BTreeSet::new();
    for _ in 0..rings {
        for v in vertices.clone() {
            for h in Ring::of_fan(t, v) {
                let f = t.face_of(h);
                faces.insert(f);
                vertices.extend(t.face_halves(f).map(|g| t.vertex(g)));
            }
        }
    }
    let name: Vec<u32> = vertices.iter().copied().collect();
    let mut offsets = vec![0];
    let mut corners = Vec::new();
    for &f in &faces {
        let of_face = t.face_halves(f).map(|g| t.vertex(g));
        corners.extend(of_face.map(|v| name.binary_search(&v).unwrap() as u32));
        offsets.push(corners.len() as u32);
    }
    let options = ConnectOptions {
        boundary: Boundary::EdgeOnly,
        ..ConnectOptions::default()
    };
    let (topology, _) = connect(name.len(), &offsets, corners, &options);
    let points = name.iter().map(|&v| level.points[v as usize]).collect();
    Level::new(topology, points).unwrap()
}

/// Unit normals of the faces around vertex 0, each by the triangle at it.
fn face_normals(level: &Level<f64>) -> Vec<[f64; 3]> {
    let t = &level.topology;
    let x = level.points[0];
    Ring::of_fan(t, 0)
        .map(|h| {
            let [a, b] = [t.next(h), t.prev(h)].map(|g| {
                let p = level.points[t.vertex(g) as usize];
                [0, 1, 2].map(|k| p[k] - x[k])
            });
            let n = [
                a[1] * b[2] - a[2] * b[1],
                a[2] * b[0] - a[0] * b[2],
                a[0] * b[1] - a[1] * b[0],
            ];
            let length = distance(&n, &[0.0; 3]);
            n.map(|c| c / length)
        })
        .collect()
}

fn angle(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    2.0 * (0.5 * distance(a, b)).min(1.0).asin()
}

#[test]
fn loop_polynomials() {
    let (n, inf) = (12, 60);
    let rest = |k: i32| 1.0 - 4.0_f64.powi(-k);
    // Cage value, and value after k steps.
    type Value = fn(f64, f64, f64) -> f64;
    let cases: [Value; 4] = [
        |x, _, r| x * x + 0.25 * r,
        |x, y, _| x * y,
        |x, _, r| x * x * x + 0.75 * r * x,
        |x, y, _| 2.0 * x - 3.0 * y + 1.0,
    ];
    for (i, value) in cases.into_iter().enumerate() {
        let shape = lattice(n, |x, y| value(x, y, 0.0));
        let mut level = shape.level(Boundary::EdgeAndCorner);
        for k in 0..=3 {
            let limits = limit(&level, &by(Scheme::Loop));
            let mut seen = 0;
            for (p, q) in level.points.iter().zip(&limits.positions) {
                if is_inside(p, f64::from(n)) {
                    let want = value(p[0], p[1], rest(k));
                    assert!(
                        (p[2] - want).abs() < 1e-11,
                        "{i} level {k} at {p:?}: {want}"
                    );
                    let want = value(q[0], q[1], rest(inf));
                    assert!((q[2] - want).abs() < 1e-11, "{i} limit at {q:?}: {want}");
                    seen += 1;
                }
            }
            assert!(seen > 20);
            level = refined(level, 1, &by(Scheme::Loop));
        }
    }
}

fn octahedron() -> Shape {
    let mut points = Vec::new();
    for k in 0..3 {
        for s in [1.0, -1.0] {
            let mut p = [0.0; 3];
            p[k] = s;
            points.push(p);
        }
    }
    let faces: Vec<[u32; 3]> = (0..8_u32)
        .map(|i| {
            let [a, b, c] = [i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2)];
            if (i.count_ones() & 1) == 0 {
                [a, b, c]
            } else {
                [a, c, b]
            }
        })
        .collect();
    let slices: Vec<&[u32]> = faces.iter().map(|f| f.as_slice()).collect();
    Shape::new(&points, &slices)
}

#[test]
fn loop_octahedron() {
    let base = octahedron().level(Boundary::EdgeAndCorner);
    for k in 0..4 {
        let level = refined(base.clone(), k, &by(Scheme::Loop));
        let limits = limit(&level, &by(Scheme::Loop));
        assert_close(&limits.positions[0], &[24.0 / 55.0, 0.0, 0.0], 1e-15);
        assert_close(&limits.normals[0], &[1.0, 0.0, 0.0], 1e-15);
    }
}

#[test]
fn loop_follows_the_textbook() {
    for shape in [
        gem(),
        patch(),
        disc(9, false, 4),
        octahedron().crease(0, 2, 1.3),
    ] {
        let shape = triangulated(&shape);
        let mut level = shape.level(Boundary::EdgeOnly);
        let mut mesh = loop_oracle::Mesh {
            points: shape.points.clone(),
            ..Default::default()
        };
        let triangles = shape.corners.chunks_exact(3);
        mesh.triangles = triangles
            .map(|t| [0, 1, 2].map(|k| t[k] as usize))
            .collect();
        for c in &shape.creases {
            let [a, b] = c.vertices.map(|v| v as usize);
            mesh.edges.insert((a.min(b), a.max(b)), c.sharpness);
        }
        for c in &shape.sharp_vertices {
            mesh.corners.insert(c.vertex as usize, c.sharpness);
        }
        for k in 1..=4 {
            level = refined(level, 1, &by(Scheme::Loop));
            mesh = mesh.refined();
            assert_eq!(level.points.len(), mesh.points.len());
            assert_all_close(
                &level.points[..shape.points.len()],
                &mesh.points[..shape.points.len()],
                1e-13,
            );
            let error = set_distance(&level.points, &mesh.points, 1e-3);
            assert!(error < 1e-12, "level {k}: {error:.1e}");
            let centres = |points: &[[f64; 3]], faces: &[[usize; 3]]| -> Vec<[f64; 3]> {
                let middle = |f: &[usize; 3]| {
                    std::array::from_fn(|c| f.iter().map(|&v| points[v][c]).sum::<f64>() / 3.0)
                };
                faces.iter().map(middle).collect()
            };
            let ours: Vec<[usize; 3]> = (0..level.topology.face_count())
                .map(|f| [0, 1, 2].map(|c| level.topology.vertex((3 * f + c) as u32) as usize))
                .collect();
            let error = set_distance(
                &centres(&level.points, &ours),
                &centres(&mesh.points, &mesh.triangles),
                1e-3,
            );
            assert!(error < 1e-12, "faces of level {k}: {error:.1e}");
        }
    }
}

/// Limits of a level and of the next agree: positions everywhere, normals where there is one plane.
#[test]
fn loop_limit_does_not_depend_on_the_level() {
    let options = by(Scheme::Loop);
    for shape in [gem(), patch()] {
        let mut level = triangulated(&shape).level(Boundary::EdgeOnly);
        let first = limit(&level, &options);
        for k in 1..=4 {
            level = refined(level, 1, &options);
            let later = limit(&level, &options);
            assert_all_close(
                &first.positions,
                &later.positions[..first.positions.len()],
                1e-12,
            );
            assert!(k < 4 || level.depth() == 4);
        }
    }
    for n in 3..=20 {
        for shape in [
            disc(n, false, 3),
            disc(n, false, 5).crease(0, 1, 10.0),
            disc(n, false, 9)
                .crease(0, 1, 10.0)
                .crease(0, 1 + n / 2, 10.0),
        ] {
            let level = shape.level(Boundary::EdgeOnly);
            let (a, b) = (
                limit(&level, &options),
                limit(&refined(level, 1, &options), &options),
            );
            assert_close(&a.positions[0], &b.positions[0], 1e-13);
            assert_close(&a.normals[0], &b.normals[0], 1e-9);
        }
    }
}

#[test]
fn sizes_are_foretold() {
    let shape = triangulated(&patch());
    let base = shape.level(Boundary::EdgeAndCorner);
    for scheme in [Scheme::Loop, Scheme::Butterfly] {
        for k in 0..=3 {
            let c = earmark::refine::counts(&base.topology, scheme, k);
            let level = refined(base.clone(), k, &by(scheme));
            let t = &level.topology;
            let sizes = [
                t.vertex_count(),
                t.face_count(),
                t.edge_count(),
                t.half_count(),
            ];
            let foretold = [c.vertices, c.faces, c.edges, c.corners];
            assert_eq!(sizes.map(|n| n as u128), foretold);
            // Descent: centres of faces lie over their ancestors, once the heights are gone.
            for f in 0..t.face_count() as u32 {
                assert_eq!(level.base_face(f), f >> (2 * k));
            }
        }
    }
}

#[test]
fn only_triangles_are_taken() {
    let level = patch().level(Boundary::EdgeAndCorner);
    for scheme in [Scheme::Loop, Scheme::Butterfly] {
        let e = level
            .next(&by(scheme), &mut Timings::default())
            .unwrap_err();
        let want = RefineError::NotTriangle {
            face: 0,
            corners: 4,
        };
        assert_eq!(e, want);
    }
}

#[test]
fn interpolating_schemes_keep_the_cage() {
    let open = patch();
    for shape in [gem(), open] {
        for scheme in [Scheme::Butterfly, Scheme::Kobbelt] {
            let shape = match scheme {
                Scheme::Kobbelt => shape.clone(),
                _ => triangulated(&shape),
            };
            assert!(has_semi_sharp(&shape.topology(Boundary::EdgeOnly)));
            let uvs: Vec<[f64; 2]> = shape.points.iter().map(|p| [p[0], p[2]]).collect();
            let mut level = shape
                .level(Boundary::EdgeOnly)
                .with_uvs(&uvs, &shape.corners, scheme, FaceVaryingRule::CornersPlus1)
                .unwrap();
            for _ in 0..4 {
                level = refined(level, 1, &by(scheme));
                assert!(level.points[..shape.points.len()] == shape.points[..]);
                assert!(level.points.iter().flatten().all(|c| c.is_finite()));
            }
            let limits = limit(&level, &by(scheme));
            assert!(limits.positions == level.points);
            assert_eq!(limits.uvs, level.uvs.as_ref().unwrap().values);
            for n in &limits.normals {
                assert!((distance(n, &[0.0; 3]) - 1.0).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn interpolating_schemes_reproduce_cubics() {
    for (a, b) in [(1, 0), (2, 0), (1, 1), (3, 0), (2, 1), (1, 2), (0, 3)] {
        let height = |x: f64, y: f64| 1.0 + x.powi(a) * y.powi(b) * 0.01;
        let shapes = [
            (lattice(12, height), Scheme::Butterfly),
            (grid(12, height), Scheme::Kobbelt),
        ];
        for (shape, scheme) in shapes {
            let mut level = shape.level(Boundary::EdgeAndCorner);
            for k in 0..=3 {
                let limits = limit(&level, &by(scheme));
                let mut seen = 0;
                for (p, n) in level.points.iter().zip(&limits.normals) {
                    let inside = match scheme {
                        Scheme::Kobbelt => p[..2].iter().all(|c| (3.5..=8.5).contains(c)),
                        _ => is_inside(p, 12.0),
                    };
                    if !inside {
                        continue;
                    }
                    let (x, y) = (p[0], p[1]);
                    assert!(
                        (p[2] - height(x, y)).abs() < 1e-11,
                        "{scheme:?} level {k} at {p:?}"
                    );
                    let slope = |c: i32, t: f64| {
                        if c == 0 {
                            0.0
                        } else {
                            f64::from(c) * t.powi(c - 1)
                        }
                    };
                    let dx = 0.01 * slope(a, x) * y.powi(b);
                    let dy = 0.01 * x.powi(a) * slope(b, y);
                    let length = (dx * dx + dy * dy + 1.0).sqrt();
                    let want = [-dx / length, -dy / length, 1.0 / length];
                    assert!(
                        distance(n, &want) < 1e-10,
                        "{scheme:?} normal of level {k} at {p:?}"
                    );
                    seen += 1;
                }
                assert!(seen > 20);
                level = refined(level, 1, &by(scheme));
            }
        }
    }
}

/// Kobbelt's scheme on a sheet with a plain border is a product of curves, so it reproduces lines up to the border and along it cubics.
#[test]
fn linear_functions_reach_the_border() {
    let plane = |x: f64, y: f64| 0.3 * x - 0.2 * y + 0.1;
    for (shape, scheme) in [
        (lattice(4, plane), Scheme::Butterfly),
        (grid(4, plane), Scheme::Kobbelt),
    ] {
        for boundary in [Boundary::EdgeAndCorner, Boundary::EdgeOnly] {
            let level = refined(shape.level(boundary), 3, &by(scheme));
            for p in &level.points {
                assert!((p[2] - plane(p[0], p[1])).abs() < 1e-13);
            }
            let up = [-0.3, 0.2, 1.0].map(|c| c / (1.13_f64).sqrt());
            for n in limit(&level, &by(scheme)).normals {
                assert_close(&n, &up, 1e-10);
            }
        }
    }
}

/// The largest angle between normals of faces at a vertex falls from level to level; and they turn to the limit normal.
#[test]
fn interpolating_surfaces_are_smooth() {
    for (scheme, quads) in [(Scheme::Butterfly, false), (Scheme::Kobbelt, true)] {
        for n in 3..=9 {
            let base = disc(n, quads, u64::from(n));
            let first = limit(&base.level(Boundary::EdgeOnly), &by(scheme)).normals[0];
            let mut level = base.level(Boundary::EdgeOnly);
            let mut spread = Vec::new();
            for k in 1..=8 {
                level = around(&refined(level, 1, &by(scheme)), 5);
                let normals = face_normals(&level);
                let pairs = normals
                    .iter()
                    .flat_map(|a| normals.iter().map(move |b| angle(a, b)));
                spread.push(pairs.fold(0.0, f64::max));
                let limits = limit(&level, &by(scheme));
                assert!(
                    distance(&limits.normals[0], &first) < 1e-9,
                    "{scheme:?} {n} level {k}"
                );
                let turned = normals.iter().map(|m| angle(m, &first)).fold(0.0, f64::max);
                assert!(turned <= spread[k - 1] + 1e-9, "{scheme:?} {n} level {k}");
            }
            let rates: Vec<f64> = (4..8).map(|k| spread[k - 1] / spread[k]).collect();
            println!(
                "smoothness: {scheme:?} valence {n}: {rates:.3?}, last {:.1e}",
                spread[7]
            );
            // Quadratic terms carry a factor of the level, so single steps vary; the mean of four counts.
            let mean = (spread[3] / spread[7]).powf(0.25);
            println!("smoothness: {scheme:?} valence {n}: mean {mean:.3}");
            // By the spectrum: the ratio of the tangents' eigenvalue to the next one, which falls with the valence for Kobbelt.
            let wanted = match (scheme, n) {
                (Scheme::Kobbelt, 3 | 5) => 1.4,
                (Scheme::Kobbelt, 6..) => 1.05,
                _ => 1.5,
            };
            assert!(mean >= wanted, "{scheme:?} valence {n}: {rates:?}");
        }
    }
}

/// Every part of a mesh that holds the two rings of an edge gives its point the same bits.
#[test]
fn parts_agree_with_the_whole() {
    for scheme in [Scheme::Loop, Scheme::Butterfly, Scheme::Kobbelt] {
        for n in [3, 5, 6, 9] {
            let quads = scheme == Scheme::Kobbelt;
            let base = disc(n, quads, 17).level(Boundary::EdgeOnly);
            let whole = refined(base, 3, &by(scheme));
            let part = around(&whole, 4);
            let (a, b) = (
                around(&refined(whole, 1, &by(scheme)), 2),
                around(&refined(part, 1, &by(scheme)), 2),
            );
            // New vertices may be numbered otherwise; faces are not.
            let corners = |level: &Level<f64>| -> Vec<[f64; 3]> {
                let t = &level.topology;
                let vertices = (0..t.half_count() as u32).map(|h| t.vertex(h));
                vertices.map(|v| level.points[v as usize]).collect()
            };
            assert!(corners(&a) == corners(&b), "{scheme:?} valence {n}");
        }
    }
}

/// Texture coordinates equal to the points' x and y follow the points on closed meshes, and everywhere without seams.
#[test]
fn coordinates_follow_points() {
    for scheme in [Scheme::Loop, Scheme::Butterfly, Scheme::Kobbelt] {
        for shape in [gem(), patch()] {
            let shape = match scheme {
                Scheme::Kobbelt => shape,
                _ => triangulated(&shape),
            };
            let uvs: Vec<[f64; 2]> = shape.points.iter().map(|p| [p[0], p[1]]).collect();
            let base = shape
                .level(Boundary::EdgeAndCorner)
                .with_uvs(&uvs, &shape.corners, scheme, FaceVaryingRule::CornersPlus1)
                .unwrap();
            let level = refined(base, 3, &by(scheme));
            let uvs = level.uvs.as_ref().unwrap();
            for h in 0..level.topology.half_count() as u32 {
                let p = level.points[level.topology.vertex(h) as usize];
                let uv = uvs.values[uvs.corners[h as usize] as usize];
                assert_close(&[p[0], p[1]], &uv, 1e-13);
            }
        }
    }
}

/// A seam is a border of texture coordinates: both sides run along it by the rule of curves.
#[test]
fn seams_are_borders() {
    for scheme in [Scheme::Butterfly, Scheme::Kobbelt] {
        let shape = match scheme {
            Scheme::Kobbelt => grid(4, |_, _| 0.0),
            _ => triangulated(&grid(4, |_, _| 0.0)),
        };
        // Corners hold all rows straight, also where seams end.
        let ends = [0, 2, 4, 20, 22, 24];
        let shape = ends.into_iter().fold(shape, |s, v| s.corner(v, 10.0));
        // Right of x = 2 values are moved by 10: the seam runs from bottom to top.
        let mut values: Vec<[f64; 2]> = shape.points.iter().map(|p| [p[0], p[1]]).collect();
        let n = values.len() as u32;
        let moved: Vec<[f64; 2]> = values.iter().map(|u| [u[0] + 10.0, u[1]]).collect();
        values.extend(moved);
        let mut corners = shape.corners.clone();
        for w in shape.face_offsets.windows(2) {
            let face = w[0] as usize..w[1] as usize;
            let right = shape.corners[face.clone()].iter().all(|&v| v % 5 >= 2);
            if right {
                corners[face].iter_mut().for_each(|c| *c += n);
            }
        }
        for rule in [
            FaceVaryingRule::None,
            FaceVaryingRule::CornersPlus1,
            FaceVaryingRule::All,
        ] {
            let base = shape
                .level(Boundary::EdgeAndCorner)
                .with_uvs(&values, &corners, scheme, rule)
                .unwrap();
            let level = refined(base, 3, &by(scheme));
            let uvs = level.uvs.as_ref().unwrap();
            for h in 0..level.topology.half_count() as u32 {
                let p = level.points[level.topology.vertex(h) as usize];
                let uv = uvs.values[uvs.corners[h as usize] as usize];
                let side = if uv[0] > 5.0 { 10.0 } else { 0.0 };
                assert_close(&[p[0] + side, p[1]], &uv, 1e-12);
            }
        }
    }
}

/// A crease from border to border makes two sheets that know nothing of each other.
#[test]
fn creases_cut() {
    for scheme in [Scheme::Butterfly, Scheme::Kobbelt] {
        let make = |far: f64| {
            let heights = |x: f64, y: f64| if x > 2.0 { far * (x + y) } else { 0.1 * x * y };
            let mut shape = match scheme {
                Scheme::Kobbelt => grid(4, heights),
                _ => triangulated(&grid(4, heights)),
            };
            for j in 0..4 {
                shape = shape.crease(2 + 5 * j, 7 + 5 * j, 10.0);
            }
            refined(shape.level(Boundary::EdgeAndCorner), 3, &by(scheme))
        };
        let (a, b) = (make(1.0), make(-7.0));
        for (p, q) in a.points.iter().zip(&b.points) {
            if p[0] <= 2.0 {
                assert_eq!(p, q, "{scheme:?}");
            }
        }
        let normals = limit(&a, &by(scheme));
        assert!(normals.normals.len() > a.points.len(), "one per side");
    }
}

/// Normals on borders, at corners, at darts and beside other extraordinary vertices against deep refinement.
#[test]
fn border_normals_are_those_of_deep_refinement() {
    for scheme in [Scheme::Butterfly, Scheme::Kobbelt] {
        let quads = scheme == Scheme::Kobbelt;
        for k in 1..=5 {
            let half = half_star(k, 40 + u64::from(k));
            let shape = match quads {
                true => half,
                false => {
                    let points: Vec<[f64; 3]> = std::iter::once(half.points[0])
                        .chain((0..=k).map(|i| half.points[1 + 2 * i as usize]))
                        .collect();
                    let faces: Vec<[u32; 3]> = (0..k).map(|i| [0, 1 + i, 2 + i]).collect();
                    let slices: Vec<&[u32]> = faces.iter().map(|f| f.as_slice()).collect();
                    Shape::new(&points, &slices)
                }
            };
            let base = shape.level(Boundary::EdgeOnly);
            let first = limit(&base, &by(scheme)).normals[0];
            let mut level = base;
            for _ in 0..9 {
                level = around(&refined(level, 1, &by(scheme)), 5);
            }
            let worst = face_normals(&level)
                .iter()
                .map(|m| angle(m, &first))
                .fold(0.0, f64::max);
            println!("border normals: {scheme:?}, {k} faces: {worst:.1e}");
            assert!(distance(&first, &limit(&level, &by(scheme)).normals[0]) < 1e-6);
            if k == if quads { 2 } else { 3 } {
                assert!(worst < 0.05, "{scheme:?}, {k} faces: {worst}");
            }
        }
    }
}
