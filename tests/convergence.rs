//! Where OpenSubdiv's limit masks are not the limit of its own rules: refinement around the vertex to level 10 shows that ours are.
#![allow(missing_docs)]

mod support;

use earmark::mesh::{Corner, Crease};
use earmark::refine::{Level, Options, limit};
use earmark::scheme::{Boundary, Scheme};
use earmark::topology::{ConnectOptions, Ring, connect};
use support::*;

/// The faces around vertex 0 as a mesh of their own, with the sharpness that is left; the vertex stays vertex 0.
fn ring(level: &Level<f64>) -> Level<f64> {
    let t = &level.topology;
    let faces: Vec<u32> = Ring::of_fan(t, 0).map(|h| t.face_of(h)).collect();
    let mut number = std::collections::BTreeMap::from([(0, 0)]);
    let mut points = vec![level.points[0]];
    let (mut corners, mut offsets, mut creases) = (Vec::new(), vec![0], Vec::new());
    for f in faces {
        for h in t.face_halves(f) {
            let v = t.vertex(h);
            let next = points.len() as u32;
            let new = *number.entry(v).or_insert(next);
            if new == next {
                points.push(level.points[v as usize]);
            }
            corners.push(new);
        }
        offsets.push(corners.len() as u32);
    }
    for h in (0..t.half_count() as u32).filter(|&h| t.edge_sharpness(t.edge(h)) > 0.0) {
        let ends = [t.vertex(h), t.vertex(t.next(h))].map(|v| number.get(&v));
        if let [Some(&a), Some(&b)] = ends {
            creases.push(Crease {
                vertices: [a, b],
                sharpness: t.edge_sharpness(t.edge(h)),
            });
        }
    }
    let corner = Corner {
        vertex: 0,
        sharpness: t.vertex_sharpness(0),
    };
    let options = ConnectOptions {
        boundary: Boundary::EdgeOnly,
        creases: &creases,
        corners: &[corner],
        holes: &[],
    };
    let (t, _) = connect(points.len(), &offsets, corners, &options);
    Level::new(t, points).unwrap()
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let l = a.iter().map(|c| c * c).sum::<f64>().sqrt();
    a.map(|c| c / l)
}

/// Normal of the corner of half-edge `h` as it is drawn.
fn corner_normal(level: &Level<f64>, h: u32) -> [f64; 3] {
    let t = &level.topology;
    let at = |h: u32| level.points[t.vertex(h) as usize];
    let (a, b) = (minus(at(t.next(h)), at(h)), minus(at(t.prev(h)), at(h)));
    unit([
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ])
}

/// Refines around vertex 0 to `depth` and compares the limit that was foretold at every level; returns distance of the point, and the
/// largest angle of the normals of its corners, in degrees.
fn converge(shape: &Shape, options: &Options, depth: u32) -> (f64, f64) {
    let mut level = step_by(shape.level(Boundary::EdgeOnly), options);
    let foretold = limit(&level, options);
    let t = &level.topology;
    // Corners around the vertex keep their order from level to level, beginning with the same edge.
    let normals: Vec<[f64; 3]> = Ring::of_fan(t, 0)
        .map(|h| foretold.normals[foretold.normal_index(t, h) as usize])
        .collect();
    let position = foretold.positions[0];
    for _ in 1..depth {
        level = step_by(ring(&level), options);
    }
    let mut worst: f64 = 0.0;
    let t = &level.topology;
    let deep: Vec<[f64; 3]> = Ring::of_fan(t, 0)
        .map(|h| corner_normal(&level, h))
        .collect();
    assert_eq!(deep.len(), normals.len());
    for n in &normals {
        // The ring may begin elsewhere: each foretold normal must be that of some corner, and all corners of one.
        let nearest = |set: &[[f64; 3]], n: &[f64; 3]| {
            set.iter()
                .map(|m| distance(m, n))
                .fold(f64::INFINITY, f64::min)
        };
        worst = worst.max(nearest(&deep, n));
    }
    for m in &deep {
        let nearest = normals
            .iter()
            .map(|n| distance(m, n))
            .fold(f64::INFINITY, f64::min);
        worst = worst.max(nearest);
    }
    (distance(&level.points[0], &position), worst.to_degrees())
}

fn step_by(level: Level<f64>, options: &Options) -> Level<f64> {
    refined(level, 1, options)
}

#[test]
fn limits_are_those_of_level_ten() {
    let options = Options::default();
    let sharp = |mut shape: Shape, s: f32| {
        for [a, b] in cube_edges() {
            shape = shape.crease(a, b, s);
        }
        shape
    };
    // What OpenSubdiv gives is named beside each case.
    let cases: Vec<(&str, Shape, f64)> = vec![
        ("interior valence 2 (the control point)", star(2, 3), 180.0),
        ("semi-sharp cube (a sharp corner)", sharp(cube(), 2.0), 0.1),
        (
            "semi-sharp crease (an infinite one)",
            star(4, 6).crease(0, 1, 1.7).crease(0, 5, 1.7),
            0.1,
        ),
        (
            "dart of valence 3 (the smooth mask)",
            star(3, 5).crease(0, 1, 10.0),
            1.0,
        ),
        (
            "dart of valence 4 (the smooth mask)",
            star(4, 5).crease(0, 1, 10.0),
            1.0,
        ),
        (
            "dart of valence 6 (the smooth mask)",
            star(6, 5).crease(0, 1, 10.0),
            // The plane is approached like 0.85 to the power of the level.
            5.0,
        ),
        (
            "boundary of 3 faces (another tangent)",
            half_star(3, 8),
            2.0,
        ),
        (
            "crease with 3 faces on each side (another tangent)",
            star(6, 9).crease(0, 1, 10.0).crease(0, 7, 10.0),
            2.0,
        ),
    ];
    for (name, shape, degrees) in &cases {
        let mut last = f64::INFINITY;
        for depth in [4, 7, 10] {
            let (point, normal) = converge(shape, &options, depth);
            println!(
                "convergence: {name}, level {depth}: {point:.1e} away, normals {normal:.3} degrees"
            );
            assert!(point <= last * 0.5, "{name}: {point} after {last}");
            last = point.max(1e-13);
            if depth == 10 {
                // The second largest eigenvalue of a dart grows with its valence, to 0.56 at 6.
                assert!(point < 2e-4, "{name}: {point}");
                assert!(normal <= *degrees, "{name}: {normal} degrees");
            }
        }
    }
}

#[test]
fn loop_limits_are_those_of_level_ten() {
    let options = Options {
        scheme: Scheme::Loop,
        ..Options::default()
    };
    for n in [3, 5, 6, 8] {
        for sharpness in [0.0, 1.5, 10.0] {
            let mut shape = wheel(n);
            if sharpness > 0.0 {
                shape = shape.crease(0, 1, sharpness);
            }
            let (point, normal) = converge(&shape, &options, 10);
            println!(
                "convergence: Loop, valence {n}, one edge of sharpness {sharpness}: {point:.1e} away, normals {normal:.3} degrees"
            );
            assert!(
                point < 1e-4 && normal < if n < 8 { 1.0 } else { 5.0 },
                "valence {n}: {point}, {normal} degrees"
            );
        }
    }
}

/// Triangles around vertex 0, uneven.
fn wheel(n: u32) -> Shape {
    let mut points = vec![[0.0, 0.0, 0.3]];
    points.extend((0..n).map(|i| {
        let a = std::f64::consts::TAU * f64::from(i) / f64::from(n);
        let r = 1.0 + 0.2 * f64::from(i % 2);
        [r * a.cos(), r * a.sin(), 0.3 * (2.0 * a + 0.4).sin()]
    }));
    let faces: Vec<[u32; 3]> = (0..n).map(|i| [0, 1 + i, 1 + (i + 1) % n]).collect();
    let faces: Vec<&[u32]> = faces.iter().map(|f| f.as_slice()).collect();
    Shape::new(&points, &faces)
}
