//! Evaluation anywhere: against refinement in double precision, against dicing, against polynomials, and close to irregular vertices.
#![allow(missing_docs)]

#[path = "evaluate/oracle.rs"]
mod oracle;
mod support;
#[path = "evaluate/triangle_oracle.rs"]
mod triangle_oracle;
#[path = "evaluate/triangles.rs"]
mod triangles;

use earmark::evaluate::{EvaluateError, Place, Sample, Tangents};
use earmark::scheme::{Boundary, Scheme};
use earmark::{Cage, Surface, SurfaceOptions};
use oracle::{cage_of, compare, surface_of};
use support::*;

const EDGES: Boundary = Boundary::EdgeAndCorner;

fn d(a: [f32; 3], b: [f32; 3]) -> f64 {
    distance(&a.map(f64::from), &b.map(f64::from))
}
fn length(a: [f32; 3]) -> f64 {
    d(a, [0.0; 3])
}
fn dot(a: [f32; 3], b: [f32; 3]) -> f64 {
    (0..3).map(|k| f64::from(a[k]) * f64::from(b[k])).sum()
}
fn options() -> SurfaceOptions {
    SurfaceOptions {
        scheme: Some(Scheme::CatmullClark),
        ..SurfaceOptions::default()
    }
}
fn is_finite(s: &Sample) -> bool {
    let second = s.second.unwrap_or_default();
    [
        s.position, s.du, s.dv, s.normal, second.duu, second.duv, second.dvv,
    ]
    .iter()
    .flatten()
    .all(|c| c.is_finite())
        && (length(s.normal) - 1.0).abs() < 1e-5
}

fn noisy_grid(n: u32, seed: u64) -> Shape {
    let mut noise = Noise(seed);
    let mut shape = grid(n, |_, _| 0.0);
    for p in &mut shape.points {
        let b = noise.point();
        *p = [p[0] + 0.4 * b[0], p[1] + 0.4 * b[1], b[2]];
    }
    shape
}

fn smooth(mut shape: Shape) -> Shape {
    shape.creases.clear();
    shape.sharp_vertices.clear();
    shape
}

#[test]
fn agrees_with_deep_refinement_at_interior_vertices() {
    for n in [3, 5, 6, 8, 12] {
        compare(&star(n, u64::from(n)), EDGES, 6);
    }
    compare(&cube(), EDGES, 5);
    compare(&star(80, 1), EDGES, 3);
}

#[test]
fn agrees_with_deep_refinement_at_boundaries_and_corners() {
    for boundary in [EDGES, Boundary::EdgeOnly] {
        for k in [1, 2, 3, 4, 7] {
            compare(&half_star(k, u64::from(k)), boundary, 6);
        }
        compare(&half_star(70, 2), boundary, 3);
        compare(&noisy_grid(4, 5), boundary, 4);
    }
}

#[test]
fn agrees_with_deep_refinement_on_mixed_polygons() {
    compare(&smooth(gem()), EDGES, 5);
    compare(&smooth(patch()), EDGES, 4);
    compare(&smooth(patch()), Boundary::EdgeOnly, 4);
}

#[test]
fn agrees_with_deep_refinement_at_creases() {
    compare(&gem(), EDGES, 5);
    compare(&patch(), EDGES, 5);
    compare(&patch(), Boundary::EdgeOnly, 4);
    // An infinite crease across, a fading one that meets it, a dart, and a corner.
    let crossed = noisy_grid(6, 7)
        .crease(21, 22, 10.0)
        .crease(22, 23, 10.0)
        .crease(23, 24, 10.0)
        .crease(22, 29, 2.5)
        .crease(29, 36, 1.2)
        .corner(38, 3.0);
    compare(&crossed, EDGES, 5);
}

#[test]
fn small_faces_far_from_the_origin_lose_nothing() {
    let mut shape = star(5, 3);
    for p in &mut shape.points {
        *p = p.map(|c| 50.0 + c / 64.0);
    }
    // Rounded to numbers of the cage first: what is asked of derivatives is relative to them.
    compare(&shape, EDGES, 5);
}

#[test]
fn polynomials_are_reproduced_with_their_derivatives() {
    // Control values u^a v^b give u³ + u, u² + 1/3, u, 1 and their products.
    let f = |k: usize, x: f64| [1.0, x, x * x + 1.0 / 3.0, x * x * x + x][k];
    let f1 = |k: usize, x: f64| [0.0, 1.0, 2.0 * x, 3.0 * x * x + 1.0][k];
    let f2 = |k: usize, x: f64| [0.0, 0.0, 2.0, 6.0 * x][k];
    for a in 0..4 {
        for b in 0..4 {
            let middle = |x: f64| x - 2.5;
            let shape = grid(5, |u, v| {
                middle(u).powi(a as i32) * middle(v).powi(b as i32)
            });
            let surface = surface_of(&shape, EDGES);
            for (u, v) in [(0.0, 0.0), (0.3, 0.8), (1.0, 0.5), (0.125, 1e-6)] {
                let s = surface.evaluate(12, u, v).unwrap();
                let (x, y) = (f64::from(u) - 0.5, f64::from(v) - 0.5);
                let second = s.second.unwrap();
                let close = |got: [f32; 3], want: f64| {
                    assert!(
                        (f64::from(got[2]) - want).abs() < 2e-6,
                        "{a} {b}: {got:?} {want}"
                    );
                };
                close(s.position, f(a, x) * f(b, y));
                close(s.du, f1(a, x) * f(b, y));
                close(s.dv, f(a, x) * f1(b, y));
                close(second.duu, f2(a, x) * f(b, y));
                close(second.duv, f1(a, x) * f1(b, y));
                close(second.dvv, f(a, x) * f2(b, y));
                assert!((s.du[0] - 1.0).abs() < 1e-6 && s.du[1].abs() < 1e-6);
            }
        }
    }
}

/// Points and normals of dicing, and texture coordinates, at all grid points.
fn like_dice(surface: &Surface, level: u32, tolerance: f64) {
    let n = 1_u32 << level;
    let box_size = {
        let [lo, hi] = surface.cage().bounds();
        (0..3).map(|k| f64::from(hi[k] - lo[k])).fold(0.0, f64::max)
    };
    for q in 0..surface.quads().face_count() as u32 {
        let diced = surface.dice(q, level);
        let face = surface.cage_face(q);
        let halves = surface.topology().face_halves(face);
        let mut evaluator = surface.face_evaluator(face).unwrap();
        for (k, &point) in diced.points.iter().enumerate() {
            let (s, t) = (
                (k as u32 % (n + 1)) as f32 / n as f32,
                (k as u32 / (n + 1)) as f32 / n as f32,
            );
            let (u, v) = match (surface.is_split(), halves.len()) {
                (false, _) => (s, t),
                (true, 4) => match q - halves.start {
                    0 => (0.5 * s, 0.5 * t),
                    1 => (1.0 - 0.5 * t, 0.5 * s),
                    2 => (1.0 - 0.5 * s, 1.0 - 0.5 * t),
                    _ => (0.5 * t, 1.0 - 0.5 * s),
                },
                // The end of a quad is the start of the next one.
                _ if s == 1.0 => continue,
                _ => ((q - halves.start) as f32 + s, t),
            };
            let sample = evaluator.at(u, v).unwrap();
            let off = d(sample.position, point);
            assert!(off <= tolerance * box_size, "face {face} ({u}, {v}): {off}");
            let normal = d(sample.normal, diced.normals[k]);
            assert!(normal < 2e-4, "face {face} ({u}, {v}): normals {normal}");
            if !diced.uvs.is_empty() {
                let uv = evaluator.uv(u, v).unwrap();
                assert!((0..2).all(|c| (uv[c] - diced.uvs[k][c]).abs() < 2e-6));
            }
        }
    }
}

#[test]
fn agrees_with_dicing() {
    for name in [
        "torus",
        "fan3",
        "fan5",
        "fan8",
        "fan24",
        "grid",
        "corner",
        "cube",
        "mobius",
        "octahedron",
        "creature",
    ] {
        let path =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("assets/{name}.obj"));
        let bytes = std::fs::read(path).unwrap();
        let cage = earmark::mesh::obj::read(
            &bytes,
            name,
            &mut earmark::mesh::resolver::NoFiles,
            &Default::default(),
        )
        .unwrap()
        .cage;
        like_dice(&Surface::new(cage, &options()), 2, 1e-6);
    }
}

fn eigenvalue(turn: f64) -> f64 {
    let (cos, half) = (turn.cos(), (0.5 * turn).cos());
    5.0 / 16.0 + (cos + half * (2.0 * (9.0 + cos)).sqrt()) / 16.0
}

#[test]
fn derivatives_grow_by_the_eigenvalue_towards_a_vertex() {
    for n in [3_u32, 5, 6, 8, 12] {
        let turn = std::f64::consts::TAU / f64::from(n);
        let (lambda, next) = (eigenvalue(turn), eigenvalue(2.0 * turn).max(0.25));
        let surface = surface_of(&star(n, 4), EDGES);
        let corner = surface.evaluate(0, 0.0, 0.0).unwrap();
        assert!(corner.second.is_none());
        let at = |k: i32| {
            let h = 2.0_f32.powi(-k);
            surface.evaluate(0, 0.75 * h, 0.5 * h).unwrap()
        };
        for k in 30..38 {
            let (a, b) = (at(k), at(k + 1));
            for (a, b) in [(a.du, b.du), (a.dv, b.dv)] {
                let ratio = length(b) / length(a);
                assert!(
                    (ratio / (2.0 * lambda) - 1.0).abs() < 1e-4,
                    "{n} {k}: {ratio} {lambda}"
                );
                assert!(dot(a, b) / length(a) / length(b) > 1.0 - 1e-6);
            }
            let settled = 10.0 * (next / lambda).powi(k) + 1e-5;
            assert!(d(a.normal, corner.normal) < settled, "{n} {k}");
            assert!(d(a.position, corner.position) < 1e-5);
        }
        // Twice as close costs nothing more, and below any number there is still the corner.
        for k in [39, 41, 60, 120, 149] {
            assert!(is_finite(&at(k)), "{n} {k}");
        }
        assert_eq!(at(60).du, corner.du);
    }
}

#[test]
fn tangents_at_a_corner_are_those_of_the_flat_star() {
    for n in 3..20_u32 {
        let turn = std::f64::consts::TAU / f64::from(n);
        let c = 1.0 / (4.0 * eigenvalue(turn) - 1.0);
        let mut shape = star(n, 1);
        let spoke = |i: u32| {
            let a = turn * f64::from(i);
            [a.cos(), a.sin(), 0.0]
        };
        shape.points[0] = [0.0; 3];
        for i in 0..n {
            let (a, b) = (spoke(i), spoke(i + 1));
            shape.points[1 + 2 * i as usize] = a;
            shape.points[2 + 2 * i as usize] = std::array::from_fn(|k| c * (a[k] + b[k]));
        }
        let surface = surface_of(&shape, EDGES);
        for i in 0..n {
            let s = surface.evaluate(i, 0.0, 0.0).unwrap();
            assert_close(&s.du.map(f64::from), &spoke(i), 1e-6);
            assert_close(&s.dv.map(f64::from), &spoke(i + 1), 1e-6);
            assert_close(&s.normal.map(f64::from), &[0.0, 0.0, 1.0], 1e-6);
        }
    }
}

#[test]
fn neighbours_meet_across_pieces_and_faces() {
    let surface = surface_of(&star(5, 8), EDGES);
    for k in 1..22 {
        let h = 2.0_f32.powi(-k);
        for x in [0.2 * h, 0.5 * h, h] {
            let (below, above) = (f32::from_bits(h.to_bits() - 1), h);
            let a = surface.evaluate(1, below, x).unwrap();
            let b = surface.evaluate(1, above, x).unwrap();
            assert!(d(a.position, b.position) < 3e-7, "{k} {x}");
            assert!(d(a.du, b.du) < 1e-5 * length(a.du));
            // Side 0 of face 1 is side 3 of face 0.
            let left = surface.evaluate(1, x, 0.0).unwrap();
            let right = surface.evaluate(0, 0.0, x).unwrap();
            assert!(d(left.position, right.position) < 3e-7);
            assert!(d(left.du, right.dv) < 1e-5 * length(left.du), "{k} {x}");
        }
    }
}

#[test]
fn a_vertex_of_many_faces_costs_no_more_at_each() {
    // 50,000 faces around one vertex: would each walk its ring, this test would not end.
    const N: u32 = 50_000;
    let surface = surface_of(&star(N, 2), EDGES);
    let mut last = None;
    for f in 0..N {
        let mut face = surface.face_evaluator(f).unwrap();
        let (corner, near) = (face.at(0.0, 0.0).unwrap(), face.at(1e-7, 2e-7).unwrap());
        assert!(is_finite(&corner) && is_finite(&near));
        if let Some(last) = last.replace(corner) {
            assert!(d(last.dv, corner.du) < 1e-5 * length(corner.du) + 1e-9);
        }
        assert!(length(corner.du) > 0.0);
        assert!(corner.normal == surface.fan_limit(0).1);
    }
    let few = surface_of(&star(600, 2), EDGES);
    like_dice_positions(&few, 300);
}

fn like_dice_positions(surface: &Surface, q: u32) {
    let diced = surface.dice(q, 4);
    for (k, &point) in diced.points.iter().enumerate() {
        let (u, v) = ((k % 17) as f32 / 16.0, (k / 17) as f32 / 16.0);
        let p: [f32; 3] = surface.evaluate_as(q, u, v).unwrap();
        assert!(d(p, point) < 2e-6, "{u} {v}: {p:?} {point:?}");
    }
}

#[test]
fn nothing_is_ever_nan() {
    let mut noise = Noise(5);
    let parameters = [0.0, 1e-40, 1e-6, 0.25, 0.5, 0.999_999, 1.0];
    for round in 0..300 {
        let count = 4 + round % 9;
        let points: Vec<[f32; 3]> = (0..count)
            .map(|_| match round % 4 {
                0 => [1.0; 3],
                1 => [noise.number() as f32, 0.0, 0.0],
                2 => noise.point().map(|c| (c * 1e-12) as f32),
                _ => noise.point().map(|c| (c * 1e6) as f32),
            })
            .collect();
        // Any corners at all: flipped faces, edges of many faces, faces that meet themselves.
        let sizes: Vec<u32> = (0..1 + round % 8)
            .map(|i| if round % 3 == 0 { 4 } else { 3 + i % 3 })
            .collect();
        let corners = (0..sizes.iter().sum::<u32>())
            .map(|_| ((noise.number() + 0.5) * f64::from(count)) as u32)
            .collect();
        let cage = Cage::new(points, &sizes, corners).unwrap();
        let surface = Surface::new(cage, &options());
        for face in 0..sizes.len() as u32 {
            let mut evaluator = surface.face_evaluator(face).unwrap();
            for u in parameters {
                for v in parameters {
                    let s = evaluator.at(u, v).unwrap();
                    assert!(is_finite(&s), "round {round} face {face} ({u}, {v}): {s:?}");
                }
            }
        }
    }
}

#[test]
fn bad_arguments_have_no_sample() {
    let surface = surface_of(&cube(), EDGES);
    assert!(surface.face_evaluator(6).is_none());
    let nan = f32::NAN;
    for (face, u, v) in [
        (6, 0.5, 0.5),
        (u32::MAX, 0.5, 0.5),
        (0, nan, 0.5),
        (0, 0.5, nan),
        (0, -1e-9, 0.0),
        (0, 1.000_001, 0.0),
        (0, 0.0, f32::INFINITY),
    ] {
        assert!(surface.evaluate(face, u, v).is_none(), "{face} {u} {v}");
        let place = [Place::default(), Place { face, u, v }];
        let mut out = [Sample::default(); 2];
        let error = surface.evaluate_many(&place, &mut out);
        assert_eq!(error, Err(EvaluateError::NoSuchPlace { index: 1 }));
        assert_eq!(out[0], Sample::default());
    }
    let mut face = surface.face_evaluator(2).unwrap();
    assert!(face.at(0.5, nan).is_none() && face.uv(0.5, 0.5).is_none());
    assert!(face.grid(4, &mut [[0.0; 3]; 24]).is_err());
    assert!(face.grid::<[f32; 3]>(0, &mut []).is_err());
    assert!(face.grid::<[f32; 3]>(u32::MAX, &mut []).is_err());
    let error = surface.evaluate_many(&[Place::default()], &mut [[0.0; 3]; 2]);
    assert_eq!(error, Err(EvaluateError::WrongCount { got: 2, wanted: 1 }));
    // Interpolating surfaces are known at dyadic places alone.
    let points = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let butterfly = SurfaceOptions {
        scheme: Some(Scheme::Butterfly),
        ..SurfaceOptions::default()
    };
    let cage = Cage::new(points, &[3], vec![0, 1, 2]).unwrap();
    let butterfly = Surface::new(cage, &butterfly);
    assert!(
        butterfly.evaluate(0, 0.2, 0.2).is_none() && butterfly.evaluate(0, 0.25, 0.5).is_some()
    );
    let place = Place {
        u: 0.2,
        ..Place::default()
    };
    let error = butterfly.evaluate_many(&[place], &mut [[0.0; 3]]);
    assert_eq!(error, Err(EvaluateError::NotDyadic { index: 0 }));
    // Polygons: u from 0 to the number of corners.
    let triangles = surface_of(&smooth(gem()), EDGES);
    assert!(
        triangles.evaluate(0, 5.0, 1.0).is_some() && triangles.evaluate(0, 5.01, 1.0).is_none()
    );
    assert!(triangles.evaluate(1, 1.5, 0.0).is_none());
}

#[test]
fn all_ways_in_give_the_same_bits() {
    for shape in [smooth(gem()), star(5, 2)] {
        let surface = surface_of(&shape, EDGES);
        let faces = surface.topology().face_count() as u32;
        let mut noise = Noise(3);
        let mut unit = move || (noise.number() + 0.5) as f32;
        let places: Vec<Place> = (0..40_000)
            .map(|_| {
                let face = (unit() * faces as f32) as u32 % faces;
                let n = surface.topology().face_halves(face).len();
                let width = if n == 4 { 1.0 } else { n as f32 };
                Place {
                    face,
                    u: unit() * width,
                    v: unit(),
                }
            })
            .collect();
        let mut many = vec![Sample::default(); places.len()];
        surface.evaluate_many(&places, &mut many).unwrap();
        let pool = |threads| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap()
        };
        for threads in [1, 3] {
            let mut again = vec![Sample::default(); places.len()];
            pool(threads)
                .install(|| surface.evaluate_many(&places, &mut again))
                .unwrap();
            assert!(again == many);
        }
        for (p, sample) in places.iter().zip(&many).take(3000) {
            assert_eq!(surface.evaluate(p.face, p.u, p.v).as_ref(), Some(sample));
            let t: Tangents = surface.evaluate_as(p.face, p.u, p.v).unwrap();
            assert_eq!(
                (t.position, t.du, t.dv),
                (sample.position, sample.du, sample.dv)
            );
        }
        for f in 0..faces {
            let mut face = surface.face_evaluator(f).unwrap();
            let (n, side) = (6, 7);
            let mut grid = vec![Sample::default(); face.grid_len(n)];
            face.grid(n, &mut grid).unwrap();
            for (k, sample) in grid.iter().enumerate() {
                let (i, j) = (k % side, k / side % side);
                // The end of a polygon's quad is named by the start of the next one.
                if grid.len() > side * side && i == side - 1 {
                    continue;
                }
                let u = (k / (side * side)) as f32 + i as f32 / n as f32;
                let want = face.at(u, j as f32 / n as f32).unwrap();
                assert!(d(sample.position, want.position) < 1e-6 && d(sample.du, want.du) < 1e-4);
                assert!(d(sample.normal, want.normal) < 1e-4, "{f} {k}");
                if grid.len() == side * side {
                    assert_eq!(*sample, want);
                }
            }
        }
    }
}

#[test]
fn bilinear_surfaces_are_bilinear() {
    let options = SurfaceOptions {
        scheme: Some(Scheme::Bilinear),
        ..SurfaceOptions::default()
    };
    let shape = grid(2, |u, v| u * v * v);
    let surface = Surface::new(cage_of(&shape), &options);
    // Corners at heights 0, 1, 8 and 4 over the last quad.
    let s = surface.evaluate(3, 0.25, 0.5).unwrap();
    let [a, b, c, d] = [1.0, 2.0, 8.0, 4.0];
    let want = (a * 0.75 + b * 0.25) * 0.5 + (d * 0.75 + c * 0.25) * 0.5;
    assert!((s.position[2] - want).abs() < 1e-6, "{s:?} {want}");
    let slope = (b - a) * 0.5 + (c - d) * 0.5;
    assert!((s.du[2] - slope).abs() < 2e-6 && (s.du[0] - 1.0).abs() < 1e-6);
    assert!((s.second.unwrap().duv[2] - (a - b + c - d)).abs() < 1e-5);
}

#[test]
fn linear_texture_coordinates_are_bilinear() {
    let shape = grid(3, |_, _| 0.0);
    let uvs: Vec<[f32; 2]> = shape
        .points
        .iter()
        .map(|p| [p[0] as f32, p[1] as f32 * 2.0])
        .collect();
    let cage = cage_of(&shape)
        .with_uvs(uvs, shape.corners.clone())
        .unwrap();
    let surface = Surface::new(
        cage,
        &SurfaceOptions {
            face_varying: Some(earmark::scheme::FaceVaryingRule::All),
            ..SurfaceOptions::default()
        },
    );
    let mut face = surface.face_evaluator(4).unwrap();
    let uv = face.uv(0.25, 0.5).unwrap();
    assert!(
        (uv[0] - 1.25).abs() < 1e-6 && (uv[1] - 3.0).abs() < 1e-6,
        "{uv:?}"
    );
}

/// Beside any corner, features and the ends of creases included, the surface is as close to the corner's limit as the place is.
#[test]
fn surfaces_are_continuous_at_every_corner() {
    use support::random_cages::{random_cage, random_triangles};
    let mut corners = 0;
    for i in 0..24 {
        for random in [random_cage(i), random_triangles(i)] {
            let case = &random.case;
            let options = SurfaceOptions {
                scheme: Some(case.options.scheme),
                boundary: Some(case.boundary),
                face_varying: Some(case.fvar),
                creases: Some(case.options.creases),
                triangles: Some(case.options.triangles),
                ..SurfaceOptions::default()
            };
            let surface = Surface::new(cage_of(&random.shape), &options);
            for f in (0..surface.topology().face_count() as u32).step_by(5) {
                let n = surface.topology().face_halves(f).len();
                let (places, inside) = match (surface.is_triangular(), n) {
                    (true, _) => (vec![[0.0, 0.0]], [0.3, 0.3]),
                    (_, 4) => (vec![[0.0, 0.0], [1.0, 1.0]], [0.5, 0.4]),
                    _ => (vec![[0.0, 0.0]], [0.5, 0.4]),
                };
                for corner in places {
                    let at = |[u, v]: [f32; 2]| surface.evaluate(f, u, v).unwrap().position;
                    let limit = at(corner);
                    let size = distance_between(limit, at(inside)).max(0.1);
                    for near in [1e-3, 1e-4, 1e-5, 1e-6, 1e-12] {
                        let place = [0, 1].map(|k| corner[k] + (inside[k] - corner[k]) * near);
                        let off = distance_between(at(place), limit) / size;
                        // Beside vertices of many faces parameters run faster than distances, by the square at most.
                        let most = 8.0 * near.sqrt() * near.powf(0.25) + 2e-6;
                        assert!(
                            off < most,
                            "cage {i} face {f}: {off} at {near} from {corner:?}"
                        );
                    }
                    corners += 1;
                }
            }
        }
    }
    assert!(corners > 100);
}

fn distance_between(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>().sqrt()
}
