//! Limit points: eigenvectors of the refinement rules, normals as deep refinement has them.
#![allow(missing_docs)]

mod support;

use earmark::refine::{Level, Options, limit};
use earmark::scheme::{Boundary, CreaseMethod};
use earmark::topology::Ring;
use support::*;

#[test]
fn semi_sharp_cube() {
    let mut shape = cube();
    for [a, b] in cube_edges() {
        shape = shape.crease(a, b, 2.0);
    }
    let base = shape.level(Boundary::EdgeAndCorner);
    for k in 0..4 {
        let level = step(base.clone(), k);
        assert_close(
            &limit(&level, &Options::default()).positions[7],
            &[0.875; 3],
            1e-14,
        );
    }
}

/// The limit of a level and of the next one agree: masks are eigenvectors of the rules. Normals where `plane` says so.
fn limit_is_an_eigenvector(
    shape: &Shape,
    options: &Options,
    vertex: usize,
    plane: bool,
    what: &str,
) {
    let base = shape.level(Boundary::EdgeAndCorner);
    let first = limit(&base, options);
    let level = refined(base.clone(), 1, options);
    let second = limit(&level, options);
    assert_close(&first.positions[vertex], &second.positions[vertex], 1e-13);
    if plane {
        let normals = |level: &Level<f64>, limit: &earmark::refine::Limit<f64>| -> Vec<[f64; 3]> {
            Ring::of_fan(&level.topology, vertex as u32)
                .map(|h| limit.normals[limit.normal_index(&level.topology, h) as usize])
                .collect()
        };
        let (a, b) = (normals(&base, &first), normals(&level, &second));
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(&b) {
            assert!(distance(a, b) < 1e-9, "{what}: normals {a:?} and {b:?}");
        }
    }
}

#[test]
fn limit_masks_are_eigenvectors() {
    let options = Options::default();
    for n in 2..=64 {
        limit_is_an_eigenvector(&star(n, 3), &options, 0, n > 2, &format!("valence {n}"));
        let dart = star(n, 5).crease(0, 1, 10.0);
        limit_is_an_eigenvector(&dart, &options, 0, n > 2, &format!("dart of valence {n}"));
        limit_is_an_eigenvector(
            &half_star(n - 1, 8),
            &options,
            0,
            true,
            &format!("boundary of {} faces", n - 1),
        );
        for across in [2, n / 2, n - 1] {
            if (2..n).contains(&across) {
                let crease = star(n, 9)
                    .crease(0, 1, 10.0)
                    .crease(0, 1 + 2 * across, 10.0);
                limit_is_an_eigenvector(
                    &crease,
                    &options,
                    0,
                    true,
                    &format!("crease, {across} of {n}"),
                );
            }
        }
    }
    // Beyond the tables.
    for n in [65, 200] {
        limit_is_an_eigenvector(&star(n, 3), &options, 0, true, "high valence");
        let dart = star(n, 5).crease(0, 1, 10.0);
        limit_is_an_eigenvector(&dart, &options, 0, false, "dart of high valence");
    }
}

#[test]
fn limit_does_not_depend_on_the_level() {
    let chaikin = Options {
        creases: CreaseMethod::Chaikin,
        ..Options::default()
    };
    let smooth_triangles = Options {
        triangles: earmark::scheme::TriangleRule::Smooth,
        ..Options::default()
    };
    for shape in [gem(), patch()] {
        for options in [Options::default(), chaikin, smooth_triangles] {
            for boundary in [Boundary::EdgeOnly, Boundary::EdgeAndCorner] {
                let mut level = shape.level(boundary);
                let first = limit(&level, &options).positions;
                for k in 1..=5 {
                    level = refined(level, 1, &options);
                    let later = limit(&level, &options).positions;
                    for (v, (a, b)) in first.iter().zip(&later).enumerate() {
                        let d = distance(a, b);
                        assert!(d < 1e-12, "{options:?} vertex {v} level {k}: {d:.2e}");
                    }
                }
            }
        }
    }
}

/// Directions to neighbours at depth are perpendicular to the limit normal, and faces there look the same way.
#[test]
fn normals_are_those_of_deep_refinement() {
    let check = |shape: &Shape, tolerance: f64, what: &str| {
        let base = shape.level(Boundary::EdgeAndCorner);
        let limits = limit(&base, &Options::default());
        let deep = step(base.clone(), 6);
        let t = &deep.topology;
        let x = limits.positions[0];
        let positions = limit(&deep, &Options::default()).positions;
        for (h, base_half) in Ring::of_fan(t, 0).zip(Ring::of_fan(&base.topology, 0)) {
            let normal = limits.normals[limits.normal_index(&base.topology, base_half) as usize];
            let ends = [t.next(h), t.prev(h)].map(|h| {
                let p = positions[t.vertex(h) as usize];
                let d: [f64; 3] = std::array::from_fn(|k| p[k] - x[k]);
                let length = distance(&d, &[0.0; 3]);
                d.map(|c| c / length)
            });
            for d in ends {
                let dot: f64 = (0..3).map(|k| d[k] * normal[k]).sum();
                assert!(dot.abs() < tolerance, "{what}: {dot:.1e}");
            }
            let [a, b] = ends;
            let cross = [
                a[1] * b[2] - a[2] * b[1],
                a[2] * b[0] - a[0] * b[2],
                a[0] * b[1] - a[1] * b[0],
            ];
            let side: f64 = (0..3).map(|k| cross[k] * normal[k]).sum();
            assert!(side > 0.0, "{what}: the normal points to the wrong side");
        }
    };
    for n in 3..=8 {
        check(&star(n, 21), 0.06, &format!("valence {n}"));
    }
    for n in 3..=6 {
        let dart = star(n, 22).crease(0, 1, 10.0);
        check(&dart, 0.1, &format!("dart of valence {n}"));
    }
    for k in 2..=3 {
        check(&half_star(k, 23), 0.06, &format!("boundary of {k} faces"));
    }
    check(
        &star(5, 24).crease(0, 1, 10.0).crease(0, 5, 10.0),
        0.06,
        "crease",
    );
}

#[test]
fn sectors_have_their_own_normals() {
    let mut shape = cube();
    for [a, b] in cube_edges() {
        shape = shape.crease(a, b, 10.0);
    }
    let level = step(shape.level(Boundary::EdgeAndCorner), 2);
    let limits = limit(&level, &Options::default());
    let t = &level.topology;
    for h in 0..t.half_count() as u32 {
        // Faces of the cube stay flat: face by face the normal is an axis.
        let axis = [
            [0.0, 0.0, -1.0],
            [0.0, 0.0, 1.0],
            [0.0, -1.0, 0.0],
            [0.0, 1.0, 0.0],
            [-1.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
        ][level.base_face(t.face_of(h)) as usize];
        let n = limits.normals[limits.normal_index(t, h) as usize];
        assert_close(&n, &axis, 1e-12);
    }
    // 8 corners with three normals each, 36 vertices inside edges with two, 54 inside faces.
    assert_eq!(limits.normals.len(), 8 * 3 + 36 * 2 + 54);
}

#[test]
fn collapsed_meshes_have_unit_normals() {
    for shape in [gem(), patch(), star(2, 1), half_star(1, 1)] {
        for scale in [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1e-30; 3]] {
            let mut flat = shape.clone();
            for p in &mut flat.points {
                *p = std::array::from_fn(|k| scale[k] * p[k]);
            }
            let level = step(flat.level(Boundary::EdgeAndCorner), 1);
            for n in limit(&level, &Options::default()).normals {
                assert!((distance(&n, &[0.0; 3]) - 1.0).abs() < 1e-12, "{n:?}");
            }
        }
    }
}

/// The children of a Chaikin edge differ, and the far one decides when the midpoint gives way: only its own neighbour tells.
#[test]
fn chaikin_looks_beyond_the_edge() {
    let options = Options {
        creases: CreaseMethod::Chaikin,
        ..Options::default()
    };
    let mut noise = Noise(31);
    let mut shape = grid(6, |_, _| 0.0);
    for p in &mut shape.points {
        p[2] = noise.number();
    }
    let shape = shape
        .crease(24, 25, 1.8)
        .crease(24, 23, 2.4)
        .crease(25, 26, 6.0);
    let mut level = shape.level(Boundary::EdgeAndCorner);
    let first = limit(&level, &options).positions[24];
    for _ in 0..5 {
        level = refined(level, 1, &options);
        assert_close(&limit(&level, &options).positions[24], &first, 1e-14);
    }
}

/// Two creases at an angle beyond 180 degrees on one side: normals of both sides look the same way.
#[test]
fn reflex_corners() {
    let shape = grid(2, |_, _| 0.0)
        .crease(4, 5, 10.0)
        .crease(4, 7, 10.0)
        .corner(4, 10.0);
    let level = shape.level(Boundary::EdgeAndCorner);
    for n in limit(&level, &Options::default()).normals {
        assert_close(&n, &[0.0, 0.0, 1.0], 1e-12);
    }
}
