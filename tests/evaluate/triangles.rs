//! Surfaces of triangles by Loop's scheme: against refinement in double precision, polynomials, and each other.

use super::support::random_cages::{RandomCage, random_triangles};
use super::support::*;
use super::triangle_oracle::*;
use super::{EDGES, d, dot, is_finite, length};
use earmark::evaluate::{EvaluateError, FaceEvaluator, Place, Sample, Tangents};
use earmark::scheme::{Boundary, FaceVaryingRule, Scheme};
use earmark::{Cage, Surface, SurfaceOptions};

/// As for quads: points to 1e-6 of the box, first derivatives to 1e-5 of their size, second ones to 1e-4.
#[track_caller]
fn compare(shape: &Shape, boundary: Boundary, depth: u32) {
    let e = errors(shape, boundary, depth);
    assert!(e.checked > 0, "derivatives were compared");
    assert!(e.point <= 1e-6 && e.slope <= 1e-5, "{e:?}");
    assert!(e.bend <= 1e-4 && e.normal <= 2e-5, "{e:?}");
}

#[test]
fn agrees_with_deep_refinement_inside() {
    for n in [3, 4, 5, 6, 7, 8, 12] {
        compare(&wheel(n, true, n.into()), EDGES, 6);
    }
    compare(&icosahedron(1), EDGES, 6);
    (0..3).for_each(|seed| compare(&lumpy(seed), EDGES, 5));
    compare(&wheel(80, true, 1), EDGES, 3);
}

#[test]
fn agrees_with_deep_refinement_at_boundaries() {
    for boundary in [EDGES, Boundary::EdgeOnly] {
        for k in [1, 2, 3, 4, 7] {
            compare(&wheel(k, false, k.into()), boundary, 6);
        }
        compare(&wheel(70, false, 2), boundary, 3);
        compare(&sheet(4, 0.4, |_, _| 0.0), boundary, 4);
    }
}

#[test]
fn agrees_with_deep_refinement_at_creases() {
    // An infinite crease across, a fading one that meets it, a dart, and a corner.
    let crossed = sheet(6, 0.4, |_, _| 0.0)
        .crease(21, 22, 10.0)
        .crease(22, 23, 10.0)
        .crease(23, 24, 10.0)
        .crease(22, 29, 2.5)
        .crease(29, 36, 1.2)
        .corner(38, 3.0);
    let e = errors(&crossed, EDGES, 5);
    assert!(e.checked > 0 && e.point <= 1e-6 && e.slope <= 1e-5, "{e:?}");
    assert!(e.bend <= 2e-3 && e.normal <= 2e-4, "{e:?}");
    // Along the whole border, and everything infinite: both sides are boundaries.
    let mut closed = icosahedron(4);
    for k in 0..3 {
        let (a, b) = (closed.corners[k], closed.corners[(k + 1) % 3]);
        closed = closed.crease(a, b, 10.0);
    }
    compare(&closed, EDGES, 5);
    compare(&wheel(6, true, 3).corner(0, 10.0), EDGES, 5);
}

/// The cage of a random shape, and its texture coordinates.
fn random(index: u64) -> (Surface, RandomCage) {
    let random = random_triangles(index);
    let shape = &random.shape;
    let uvs = shape.uvs.iter().map(|p| p.map(|c| c as f32)).collect();
    let mut cage = super::oracle::cage_of(shape);
    cage = cage.with_uvs(uvs, shape.corner_uvs.clone()).unwrap();
    let case = &random.case;
    let options = SurfaceOptions {
        scheme: Some(Scheme::Loop),
        boundary: Some(case.boundary),
        face_varying: Some(case.fvar),
        creases: Some(case.options.creases),
        triangles: Some(case.options.triangles),
        ..SurfaceOptions::default()
    };
    (Surface::new(cage, &options), random)
}

#[test]
fn random_cages_agree_with_deep_refinement() {
    let mut seams = 0;
    for index in 0..72 {
        let (surface, random) = random(index);
        let base = base_level(&random.shape, &random.case);
        let e = errors_of(&surface, base, &random.case.options, 3);
        // Where creases fade, control levels are of single precision.
        assert!(e.point <= 1e-6 && e.slope <= 3e-5, "{index}: {e:?}");
        assert!(e.uv <= 2e-6, "{index}: {e:?}");
        seams += usize::from(e.uv > 0.0);
    }
    assert!(seams > 30);
}

#[test]
fn cubics_are_reproduced_with_their_derivatives() {
    let power = |x: f64, n: i32| if n < 0 { 0.0 } else { x.powi(n) };
    for a in 0..=3_i32 {
        for b in 0..=3 - a {
            // Derivative (p, q) of x^a y^b.
            let part = |p: i32, q: i32, x: f64, y: f64| {
                let falling = |n: i32, k: i32| (0..k).map(|i| f64::from(n - i)).product::<f64>();
                falling(a, p) * falling(b, q) * power(x, a - p) * power(y, b - q)
            };
            // Limits are values and a sixth of the Laplacian of the lattice.
            let want = |p: i32, q: i32, x: f64, y: f64| {
                let bends = part(p + 2, q, x, y) + part(p, q + 2, x, y) - part(p + 1, q + 1, x, y);
                part(p, q, x, y) + bends / 6.0
            };
            let shape = sheet(6, 0.0, |x, y| power(x - 2.5, a) * power(y - 2.5, b));
            let surface = surface_of(&shape, EDGES);
            // The two triangles of a cell, the second one turned.
            for (face, sign) in [(28, 1.0), (29, -1.0)] {
                for (u, v) in [
                    (0.0, 0.0),
                    (0.3, 0.2),
                    (0.0, 1.0),
                    (1.0, 0.0),
                    (0.125, 0.875),
                ] {
                    let s = surface.evaluate(face, u, v).unwrap();
                    let [x, y] = [u, v].map(|c| sign * (f64::from(c) - 0.5));
                    let second = s.second.unwrap();
                    let close = |got: [f32; 3], want: f64| {
                        let off = (f64::from(got[2]) - want).abs();
                        assert!(off < 2e-6, "{a} {b} ({u}, {v}): {got:?} {want}");
                    };
                    close(s.position, want(0, 0, x, y));
                    close(s.du, sign * want(1, 0, x, y));
                    close(s.dv, sign * want(0, 1, x, y));
                    close(second.duu, want(2, 0, x, y));
                    close(second.duv, want(1, 1, x, y));
                    close(second.dvv, want(0, 2, x, y));
                    assert!((f64::from(s.position[0]) - 2.5 - x).abs() < 1e-6);
                    assert!((f64::from(s.du[0]) - sign).abs() < 1e-6 && s.dv[0].abs() < 1e-6);
                    assert!(a > 0 || b > 0 || d(s.normal, [0.0, 0.0, 1.0]) < 1e-6);
                }
            }
        }
    }
}

#[test]
fn small_faces_far_from_the_origin_lose_nothing() {
    let mut shape = wheel(5, true, 3);
    for p in &mut shape.points {
        *p = p.map(|c| f64::from((50.0 + c / 64.0) as f32));
    }
    let e = errors(&shape, EDGES, 5);
    // Positions are numbers of 24 bits; all else is as if they were not.
    assert!(
        e.point <= 2e-4 && e.slope <= 1e-5 && e.bend <= 1e-4,
        "{e:?}"
    );
    assert!(e.normal <= 2e-5 && e.checked > 0, "{e:?}");
}

#[test]
fn derivatives_grow_by_the_eigenvalue_towards_a_vertex() {
    for n in [3_u32, 4, 5, 7, 8, 12] {
        let cos = |k: f64| (std::f64::consts::TAU * k / f64::from(n)).cos();
        let lambda = 0.375 + 0.25 * cos(1.0);
        let others = (2..n.max(3) - 1).map(|k| 0.375 + 0.25 * cos(k.into()));
        let next = others.fold(lambda * lambda, f64::max).max(0.125);
        let surface = surface_of(&wheel(n, true, 4), EDGES);
        let corner = surface.evaluate(0, 0.0, 0.0).unwrap();
        assert!(corner.second.is_none());
        let at = |k: i32| {
            let h = 2.0_f32.powi(-k);
            surface.evaluate(0, 0.5 * h, 0.25 * h).unwrap()
        };
        for k in 30..38 {
            let (a, b) = (at(k), at(k + 1));
            for (a, b) in [(a.du, b.du), (a.dv, b.dv)] {
                let ratio = length(b) / length(a);
                let off = (ratio / (2.0 * lambda) - 1.0).abs();
                let settled = 1e-4 + (next / lambda).powi(k - 8);
                assert!(off < settled, "{n} {k}: {ratio} {lambda}");
                assert!(dot(a, b) / length(a) / length(b) > 0.999);
            }
            let settled = 10.0 * (next / lambda).powi(k) + 1e-5;
            assert!(d(a.normal, corner.normal) < settled, "{n} {k}");
            assert!(d(a.position, corner.position) < 1e-5);
        }
        // Twice as close costs nothing more, and below any number there is still the corner.
        for k in [38, 39, 41, 60, 120, 148] {
            assert!(is_finite(&at(k)), "{n} {k}");
        }
        assert_eq!(at(60).du, corner.du);
    }
}

#[test]
fn tangents_at_a_corner_are_those_of_the_flat_star() {
    for n in 3..20_u32 {
        let mut shape = wheel(n, true, 1);
        shape.points[0] = [0.0; 3];
        let spoke = |i: u32| {
            let a = std::f64::consts::TAU * f64::from(i) / f64::from(n);
            [a.cos(), a.sin(), 0.0]
        };
        for i in 0..n {
            shape.points[1 + i as usize] = spoke(i);
        }
        // Every corner of a face in turn is at the middle.
        for corners in shape.corners.chunks_exact_mut(3).take(1) {
            corners.rotate_right(1);
        }
        let second = (shape.corners.chunks_exact(3))
            .position(|c| c[0] == 0)
            .unwrap();
        shape.corners[3 * second..3 * second + 3].rotate_right(2);
        let surface = surface_of(&shape, EDGES);
        for (f, corners) in shape.corners.chunks_exact(3).enumerate() {
            let Some(c) = corners.iter().position(|&v| v == 0) else {
                continue;
            };
            let (u, v) = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)][c];
            let s = surface.evaluate(f as u32, u, v).unwrap();
            let place = |k: usize| match corners[k] {
                0 => [0.0; 3],
                i => spoke(i - 1),
            };
            let side = |k: usize| [0, 1, 2].map(|x| place(k)[x] - place(0)[x]);
            // The star is the triangle itself, laid flat.
            assert_close(&s.du.map(f64::from), &side(1), 1e-6);
            assert_close(&s.dv.map(f64::from), &side(2), 1e-6);
            assert_close(&s.normal.map(f64::from), &[0.0, 0.0, 1.0], 1e-6);
        }
    }
}

/// Sides of the faces of a shape that two faces share: parameters of both along them, in one direction.
fn shared_sides(shape: &Shape) -> Vec<[(u32, usize); 2]> {
    let end = |h: usize| shape.corners[h / 3 * 3 + (h + 1) % 3];
    let mut out = Vec::new();
    for h in 0..shape.corners.len() {
        for g in h + 1..shape.corners.len() {
            if shape.corners[h] == end(g) && shape.corners[g] == end(h) {
                out.push([(h as u32 / 3, h % 3), (g as u32 / 3, g % 3)]);
            }
        }
    }
    out
}

/// Parameters at `x` along side `c`, and the derivative along it.
fn on_side(c: usize, x: f32) -> ([f32; 2], [f64; 2]) {
    match c {
        0 => ([x, 0.0], [1.0, 0.0]),
        1 => ([1.0 - x, x], [-1.0, 1.0]),
        _ => ([0.0, 1.0 - x], [0.0, -1.0]),
    }
}

#[test]
fn neighbours_meet_across_pieces_and_faces() {
    let creased = lumpy(2).crease(0, 1, 2.3);
    for shape in [wheel(5, true, 8), wheel(4, false, 1), lumpy(1), creased] {
        let surface = surface_of(&shape, EDGES);
        let (mut sides, extent) = (0, extent(&shape.points));
        for [(f, c), (g, e)] in shared_sides(&shape) {
            let (mut f, mut g) = [f, g].map(|f| surface.face_evaluator(f).unwrap()).into();
            sides += 1;
            for k in 0..=32 {
                let x = if k < 16 {
                    k as f32 / 15.0
                } else {
                    0.5_f32.powi(k - 14)
                };
                let ([u, v], along) = on_side(c, x);
                let a = f.at(u, v).unwrap();
                let ([u, v], back) = on_side(e, 1.0 - x);
                let b = g.at(u, v).unwrap();
                assert!(d(a.position, b.position) < 1e-6 * extent, "{k}");
                let slope = |s: &Sample, w: [f64; 2], sign: f64| -> [f64; 3] {
                    [0, 1, 2]
                        .map(|i| sign * (w[0] * f64::from(s.du[i]) + w[1] * f64::from(s.dv[i])))
                };
                let (p, q) = (slope(&a, along, 1.0), slope(&b, back, -1.0));
                // Parameters of the other side are rounded.
                let size = length(a.du) + length(a.dv) + 1e-3;
                if x == 0.0 || x > 1e-3 {
                    assert!(distance(&p, &q) < 1e-4 * size, "{c} {e} {x}: {p:?} {q:?}");
                }
                assert!(d(a.normal, b.normal) < 1e-3 || x < 1e-3, "{x}");
            }
        }
        assert!(sides > 3);
    }
    // Across pieces of one triangle, on both sides of any line between two.
    let surface = surface_of(&wheel(5, true, 8), EDGES);
    for k in 1..22 {
        let h = 2.0_f32.powi(-k);
        let below = f32::from_bits(h.to_bits() - 1);
        for x in [0.2 * h, 0.5 * h] {
            for [p, q] in [
                [[below, x], [h, x]],
                [[x, below], [x, h]],
                [[below - x, x], [h - x, x]],
            ] {
                let a = surface.evaluate(0, p[0], p[1]).unwrap();
                let b = surface.evaluate(0, q[0], q[1]).unwrap();
                assert!(d(a.position, b.position) < 3e-7, "{k} {x}");
                assert!(d(a.du, b.du) < 2e-5 * length(a.du), "{k} {x}");
            }
        }
    }
}

#[test]
fn a_vertex_of_many_faces_costs_no_more_at_each() {
    // Would each of the faces walk the ring, this test would not end.
    const N: u32 = 50_000;
    let shape = wheel(N, true, 2);
    let surface = surface_of(&shape, EDGES);
    let mut last: Option<Sample> = None;
    for (f, corners) in (0..).zip(shape.corners.chunks_exact(3)) {
        if corners[0] != 0 {
            continue;
        }
        let mut face = surface.face_evaluator(f).unwrap();
        let (corner, near) = (face.at(0.0, 0.0).unwrap(), face.at(1e-7, 2e-7).unwrap());
        assert!(is_finite(&corner) && is_finite(&near));
        if let Some(last) = last.replace(corner) {
            assert!(d(last.dv, corner.du) < 1e-5 * length(corner.du) + 1e-9);
        }
        assert!(length(corner.du) > 0.0);
    }
    assert!(last.is_some());
}

#[test]
fn nothing_is_ever_nan() {
    let mut noise = Noise(5);
    let places = [0.0, 1e-40, 1e-6, 0.25, 0.5, 0.999_999, 1.0];
    for round in 0..300_u32 {
        let count = 3 + round % 9;
        let points: Vec<[f32; 3]> = (0..count)
            .map(|_| match round % 4 {
                0 => [1.0; 3],
                1 => [noise.number() as f32, 0.0, 0.0],
                2 => noise.point().map(|c| (c * 1e-12) as f32),
                _ => noise.point().map(|c| (c * 1e6) as f32),
            })
            .collect();
        // Any corners at all: flipped faces, edges of many faces, faces that meet themselves.
        let faces = 1 + round % 8;
        let corners = (0..3 * faces)
            .map(|_| ((noise.number() + 0.5) * f64::from(count)) as u32)
            .collect();
        let cage = Cage::new(points, &vec![3; faces as usize], corners).unwrap();
        let surface = Surface::new(cage, &SurfaceOptions::default());
        assert_eq!(surface.scheme(), Scheme::Loop);
        for face in 0..faces {
            let mut evaluator = surface.face_evaluator(face).unwrap();
            for u in places {
                for v in places {
                    let (u, v) = if u + v > 1.0 {
                        (1.0 - u, 1.0 - v)
                    } else {
                        (u, v)
                    };
                    let s = evaluator.at(u, v).unwrap();
                    assert!(is_finite(&s), "round {round} face {face} ({u}, {v}): {s:?}");
                }
            }
        }
    }
}

#[test]
fn places_beside_the_triangle_have_no_sample() {
    let surface = surface_of(&icosahedron(1), EDGES);
    assert!(surface.face_evaluator(20).is_none());
    let nan = f32::NAN;
    for (face, u, v) in [
        (20, 0.5, 0.25),
        (u32::MAX, 0.5, 0.25),
        (0, nan, 0.5),
        (0, 0.5, nan),
        (0, -1e-9, 0.0),
        (0, 0.2, -1e-9),
        (0, 1.000_001, 0.0),
        (0, 0.6, 0.5),
        (0, 0.5, 0.500_001),
        (0, 0.0, f32::INFINITY),
    ] {
        assert!(surface.evaluate(face, u, v).is_none(), "{face} {u} {v}");
        let places = [Place::default(), Place { face, u, v }];
        let mut out = [Sample::default(); 2];
        let error = surface.evaluate_many(&places, &mut out);
        assert_eq!(error, Err(EvaluateError::NoSuchPlace { index: 1 }));
        assert_eq!(out[0], Sample::default());
    }
    let mut face = surface.face_evaluator(2).unwrap();
    assert!(face.at(0.5, nan).is_none() && face.at(0.75, 0.75).is_none());
    assert!(face.uv(0.5, 0.5).is_none());
    assert!(face.grid(4, &mut [[0.0; 3]; 25]).is_err());
    assert!(face.grid::<[f32; 3]>(0, &mut []).is_err());
    // Sums that are 1 by rounding are on the side.
    let near = 1.0 - 0.5 * f32::EPSILON;
    assert_eq!(
        face.at(near, f32::EPSILON),
        face.at(near, 0.5 * f32::EPSILON)
    );
    for (u, v) in [
        (0.1, 0.9),
        (0.3, 0.7),
        (1.0 / 3.0, 2.0 / 3.0),
        (1.0 - 0.5 * f32::EPSILON, f32::EPSILON),
    ] {
        assert!(
            u + v <= 1.0 && is_finite(&face.at(u, v).unwrap()),
            "{u} {v}"
        );
    }
}

/// The grid of a face by [`FaceEvaluator::grid`], and place by place.
fn grids<S: earmark::evaluate::Evaluated>(face: &mut FaceEvaluator<'_>, n: u32) -> [Vec<S>; 2] {
    let mut grid = vec![S::default(); face.grid_len(n)];
    assert_eq!(grid.len(), ((n + 1) * (n + 2) / 2) as usize);
    face.grid(n, &mut grid).unwrap();
    let at = |i: u32| i as f32 / n as f32;
    let rows = (0..=n).flat_map(|j| (0..=n - j).map(move |i| (i, j)));
    let single = rows.map(|(i, j)| face.at_as(at(i), at(j)).unwrap());
    [grid, single.collect()]
}

#[test]
fn all_ways_in_give_the_same_bits() {
    let creased = lumpy(5).crease(0, 1, 1.5).corner(3, 10.0);
    for shape in [
        icosahedron(3),
        lumpy(2),
        creased,
        wheel(6, true, 1),
        sheet(4, 0.2, |_, _| 0.0),
    ] {
        let surface = surface_of(&shape, EDGES);
        let faces = shape.faces() as u32;
        let mut noise = Noise(3);
        let mut unit = move || (noise.number() + 0.5) as f32;
        let places: Vec<Place> = (0..30_000)
            .map(|_| {
                let face = (unit() * faces as f32) as u32 % faces;
                let (u, v) = (unit(), unit());
                let (u, v) = if u + v > 1.0 {
                    (1.0 - u, 1.0 - v)
                } else {
                    (u, v)
                };
                Place { face, u, v }
            })
            .collect();
        let mut many = vec![Sample::default(); places.len()];
        surface.evaluate_many(&places, &mut many).unwrap();
        for threads in [1, 3] {
            let mut again = vec![Sample::default(); places.len()];
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap()
                .install(|| surface.evaluate_many(&places, &mut again))
                .unwrap();
            assert!(again == many);
        }
        for (p, sample) in places.iter().zip(&many).take(3000) {
            assert_eq!(surface.evaluate(p.face, p.u, p.v).as_ref(), Some(sample));
            let t: Tangents = surface.evaluate_as(p.face, p.u, p.v).unwrap();
            let want = (sample.position, sample.du, sample.dv);
            assert_eq!((t.position, t.du, t.dv), want);
            let position: [f32; 3] = surface.evaluate_as(p.face, p.u, p.v).unwrap();
            assert_eq!(position, sample.position);
        }
        for f in 0..faces {
            let mut face = surface.face_evaluator(f).unwrap();
            assert_eq!(face.face(), f);
            for n in [1, 6, 16, 23] {
                let [a, b] = grids::<Sample>(&mut face, n);
                assert!(a == b, "{f} {n}");
                let [a, b] = grids::<Tangents>(&mut face, n);
                assert!(a == b, "{f} {n}");
            }
        }
    }
}

#[test]
fn linear_texture_coordinates_are_linear() {
    let shape = sheet(3, 0.0, |_, _| 0.0);
    let uvs: Vec<[f32; 2]> = (shape.points.iter())
        .map(|p| [p[0] as f32, p[1] as f32 * 2.0])
        .collect();
    let cage = super::oracle::cage_of(&shape);
    let cage = cage.with_uvs(uvs, shape.corners.clone()).unwrap();
    let options = SurfaceOptions {
        face_varying: Some(FaceVaryingRule::All),
        ..SurfaceOptions::default()
    };
    let surface = Surface::new(cage, &options);
    // The triangle from (2, 2) to the left and down.
    let uv = surface.face_evaluator(9).unwrap().uv(0.25, 0.5).unwrap();
    assert!(
        (uv[0] - 1.75).abs() < 1e-6 && (uv[1] - 3.0).abs() < 1e-6,
        "{uv:?}"
    );
}

/// A sum that is 1 only after rounding lies on the side: beside a corner, it is the corner, features included.
#[test]
fn corners_but_for_rounding_are_corners() {
    let (tiny, mut differ) = (f32::EPSILON / 2.0, 0);
    for i in 0..24 {
        let (surface, _) = random(i);
        for f in 0..surface.topology().face_count() as u32 {
            for (near, corner) in [([1.0, tiny], [1.0, 0.0]), ([tiny, 1.0], [0.0, 1.0])] {
                let at = |[u, v]: [f32; 2]| surface.evaluate(f, u, v).unwrap().position;
                assert_eq!(at(near), at(corner), "cage {i} face {f}");
                let inside = [corner[0] * 0.999, corner[1] * 0.999];
                differ += u32::from(at(inside) != at(corner));
            }
        }
    }
    assert!(differ > 0);
}
