//! Refinement against what is known without a reference: golden values, eigenvectors, invariances.
#![allow(missing_docs)]

mod support;

use earmark::refine::{Level, Options, Timings, limit, refine};
use earmark::scheme::{Boundary, CreaseMethod, Scheme};
use support::*;

#[test]
fn polynomials_on_a_grid() {
    let inner =
        |p: &[f64; 3], n: f64| (2.5..=n - 2.5).contains(&p[0]) && (2.5..=n - 2.5).contains(&p[1]);
    for (a, b) in [(1, 0), (2, 0), (3, 0), (2, 3), (3, 1), (0, 2), (3, 3)] {
        // After k steps u² carries (1 − 4^−k)/3 on top, u³ that many times u; products multiply.
        let term = |x: f64, power: i32, k: i32| {
            let rest = (1.0 - 4.0_f64.powi(-k)) / 3.0;
            match power {
                0 => 1.0,
                1 => x,
                2 => x * x + rest,
                _ => x.powi(3) + 3.0 * rest * x,
            }
        };
        let mut level = grid(8, |u, v| u.powi(a) * v.powi(b)).level(Boundary::EdgeAndCorner);
        for k in 0..=3 {
            let limits = limit(&level, &Options::default());
            let mut seen = 0;
            for (p, q) in level.points.iter().zip(&limits.positions) {
                if inner(p, 8.0) {
                    let want = term(p[0], a, k) * term(p[1], b, k);
                    assert!(
                        (p[2] - want).abs() < 1e-10,
                        "u^{a} v^{b} level {k} at {p:?}: {want}"
                    );
                    let want = term(p[0], a, 60) * term(p[1], b, 60);
                    assert!(
                        (q[2] - want).abs() < 1e-10,
                        "u^{a} v^{b} limit of level {k} at {q:?}: {want}"
                    );
                    seen += 1;
                }
            }
            assert!(seen >= 9);
            level = step(level, 1);
        }
    }
}

#[test]
fn cube_values() {
    let base = cube().level(Boundary::EdgeAndCorner);
    let limits = limit(&base, &Options::default());
    let level = step(base, 1);
    let corner = level.points[7];
    assert_close(&corner, &[5.0 / 9.0; 3], 1e-15);
    assert_close(&limits.positions[7], &[0.5; 3], 1e-15);
    assert_close(&limits.normals[7], &[1.0 / 3.0_f64.sqrt(); 3], 1e-15);
    // Children of faces follow those of vertices; face 1 is z = 1.
    assert_close(
        &limit(&level, &Options::default()).positions[8 + 1],
        &[0.0, 0.0, 68.0 / 81.0],
        1e-15,
    );
    assert!(
        level.points[14..]
            .iter()
            .any(|p| distance(p, &[0.75, 0.75, 0.0]) < 1e-15)
    );
}

#[test]
fn affine_maps_commute() {
    let map = |p: &[f64; 3]| {
        [
            3.0 * p[0] - p[1] + 0.5 * p[2] + 7.0,
            0.2 * p[0] + p[1] - 11.0,
            p[0] - 0.3 * p[1] - 2.0 * p[2] + 0.1,
        ]
    };
    for shape in all_shapes() {
        let mut moved = shape.clone();
        moved.points = shape.points.iter().map(map).collect();
        for scheme in [Scheme::CatmullClark, Scheme::Bilinear] {
            let options = Options {
                scheme,
                ..Options::default()
            };
            let a = refined(shape.level(Boundary::EdgeAndCorner), 3, &options);
            let b = refined(moved.level(Boundary::EdgeAndCorner), 3, &options);
            let image: Vec<[f64; 3]> = a.points.iter().map(map).collect();
            assert_all_close(&image, &b.points, 1e-12);
            let (a, b) = (limit(&a, &options), limit(&b, &options));
            let image: Vec<[f64; 3]> = a.positions.iter().map(map).collect();
            assert_all_close(&image, &b.positions, 1e-12);
        }
    }
}

/// Renames vertices, reorders faces, rotates corners; with `mirror` also turns every face over.
fn renumbered(shape: &Shape, mirror: bool) -> (Shape, Vec<u32>) {
    let n = shape.points.len();
    let mut noise = Noise(99);
    let mut new_name: Vec<u32> = (0..n as u32).collect();
    for i in (1..n).rev() {
        let j = ((noise.number() + 0.5) * (i + 1) as f64) as usize;
        new_name.swap(i, j);
    }
    let mut points = vec![[0.0; 3]; n];
    for (v, p) in shape.points.iter().enumerate() {
        points[new_name[v] as usize] = *p;
    }
    let mut faces: Vec<Vec<u32>> = shape
        .face_offsets
        .windows(2)
        .map(|w| {
            shape.corners[w[0] as usize..w[1] as usize]
                .iter()
                .map(|&v| new_name[v as usize])
                .collect()
        })
        .collect();
    for (i, f) in faces.iter_mut().enumerate() {
        let turn = i % f.len();
        f.rotate_left(turn);
        if mirror {
            f.reverse();
        }
    }
    faces.reverse();
    let slices: Vec<&[u32]> = faces.iter().map(Vec::as_slice).collect();
    let mut out = Shape::new(&points, &slices);
    for c in &shape.creases {
        let [a, b] = c.vertices.map(|v| new_name[v as usize]);
        out = out.crease(b, a, c.sharpness);
    }
    for c in &shape.sharp_vertices {
        out = out.corner(new_name[c.vertex as usize], c.sharpness);
    }
    (out, new_name)
}

#[test]
fn numbering_and_orientation_do_not_matter() {
    for shape in all_shapes() {
        for mirror in [false, true] {
            for creases in [CreaseMethod::Uniform, CreaseMethod::Chaikin] {
                let options = Options {
                    creases,
                    ..Options::default()
                };
                let (other, new_name) = renumbered(&shape, mirror);
                let a = refined(shape.level(Boundary::EdgeOnly), 2, &options);
                let b = refined(other.level(Boundary::EdgeOnly), 2, &options);
                assert!(support::set_distance(&a.points, &b.points, 1e-3) < 1e-7);
                let (la, lb) = (limit(&a, &options), limit(&b, &options));
                for (v, &w) in new_name.iter().enumerate() {
                    let w = w as usize;
                    assert_close(&a.points[v], &b.points[w], 1e-7);
                    assert_close(&la.positions[v], &lb.positions[w], 1e-7);
                    if la.corner_normals.is_empty() {
                        let flipped = lb.normals[w].map(|c| if mirror { -c } else { c });
                        assert_close(&la.normals[v], &flipped, 1e-6);
                    }
                }
            }
        }
    }
}

#[test]
fn ten_is_infinite() {
    let sharp = |s: f32| {
        let mut shape = gem();
        for c in &mut shape.creases {
            if c.sharpness >= 10.0 {
                c.sharpness = s;
            }
        }
        shape.corner(3, s)
    };
    let points = |s: f32| {
        let level = step(sharp(s).level(Boundary::EdgeAndCorner), 3);
        let limits = limit(&level, &Options::default());
        (level.points, limits.positions, limits.normals)
    };
    let ten = points(10.0);
    assert!(ten == points(25.0), "10 and 25 differ");
    assert!(ten == points(f32::INFINITY), "10 and infinity differ");
    assert!(ten != points(9.0), "9 is infinite too");
}

#[test]
fn zero_is_no_tag_and_sharpness_is_continuous() {
    let ring = |s: f32| {
        let shape = cube()
            .crease(0, 1, s)
            .crease(1, 3, s)
            .crease(3, 2, s)
            .crease(2, 0, s)
            .corner(7, s);
        step(shape.level(Boundary::EdgeAndCorner), 4).points
    };
    assert_all_close(
        &step(cube().level(Boundary::EdgeAndCorner), 4).points,
        &ring(0.0),
        0.0,
    );
    for s in [0.0, 1.0, 2.0, 3.0_f32] {
        let below = (s - 1e-4).max(0.0);
        assert_all_close(&ring(below), &ring(s), 1e-3);
        assert_all_close(&ring(s), &ring(s + 1e-4), 1e-3);
    }
    assert!(distance(&ring(1.0)[0], &ring(2.0)[0]) > 0.05);
}

#[test]
fn steps_add_up() {
    for shape in all_shapes() {
        for creases in [CreaseMethod::Uniform, CreaseMethod::Chaikin] {
            let options = Options {
                creases,
                ..Options::default()
            };
            let base = shape.level(Boundary::EdgeAndCorner);
            let once = refined(base.clone(), 3, &options);
            let twice = refined(refined(base, 1, &options), 2, &options);
            assert_eq!(once.points, twice.points);
            assert_eq!(once.depth(), 3);
        }
    }
}

#[test]
fn bilinear_keeps_points() {
    let options = Options {
        scheme: Scheme::Bilinear,
        ..Options::default()
    };
    let shape = patch();
    let level = refined(shape.level(Boundary::EdgeOnly), 3, &options);
    assert_all_close(&level.points[..shape.points.len()], &shape.points, 0.0);
    let limits = limit(&level, &options);
    assert_all_close(&limits.positions, &level.points, 0.0);
    let edge: [f64; 3] = std::array::from_fn(|k| 0.5 * (shape.points[0][k] + shape.points[1][k]));
    assert!(level.points.iter().any(|p| distance(p, &edge) < 1e-15));
}

#[test]
fn single_precision_follows_double() {
    let shape = gem();
    let topology = shape.topology(Boundary::EdgeAndCorner);
    let points = shape.points.iter().map(|p| p.map(|c| c as f32)).collect();
    let single = Level::<f32>::new(topology, points).unwrap();
    let options = Options::default();
    let single = refine(single, &options, 4, None, &mut Timings::default()).unwrap();
    let double = step(shape.level(Boundary::EdgeAndCorner), 4);
    let widen = |p: &[[f32; 3]]| -> Vec<[f64; 3]> { p.iter().map(|p| p.map(f64::from)).collect() };
    assert_all_close(&widen(&single.points), &double.points, 2e-6);
    let (a, b) = (limit(&single, &options), limit(&double, &options));
    assert_all_close(&widen(&a.positions), &b.positions, 2e-6);
}

#[test]
fn threads_do_not_change_bits() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let level = step(patch().level(Boundary::EdgeAndCorner), 5);
            let limits = limit(&level, &Options::default());
            (
                level.points,
                limits.positions,
                limits.normals,
                limits.corner_normals,
            )
        })
    };
    assert!(run(1) == run(5));
}
