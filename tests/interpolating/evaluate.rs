//! Evaluation of interpolating surfaces at dyadic places, against whole-mesh refinement in f64.

use super::support::random_cages::{RandomCage, random_cage, random_triangles};
use super::{asset, cases, oracle, sheet};
use earmark::evaluate::{EvaluateError, Place, Sample, Tangents};
use earmark::refine::{Level, refine};
use earmark::scheme::Scheme;
use earmark::topology::{ConnectOptions, NONE, Ring, Topology, connect};
use earmark::{Cage, Surface, SurfaceOptions};
use std::collections::{BTreeMap, BTreeSet};

const BOTH: [Scheme; 2] = [Scheme::Kobbelt, Scheme::Butterfly];

/// A random cage under an interpolating scheme.
fn of_random(random: &RandomCage, scheme: Scheme) -> Surface {
    let shape = &random.shape;
    let points = shape.points.iter().map(|p| p.map(|c| c as f32));
    let mut builder = Cage::builder().points(points);
    for face in shape.face_offsets.windows(2) {
        builder = builder.face(shape.corners[face[0] as usize..face[1] as usize].to_vec());
    }
    for (k, crease) in shape.creases.iter().enumerate() {
        let [a, b] = crease.vertices;
        // Sharp or nothing: fading creases mean nothing here.
        builder = builder.crease(a, b, if k % 3 == 0 { f32::INFINITY } else { 0.0 });
    }
    for corner in &shape.sharp_vertices {
        builder = builder.corner(corner.vertex, f32::INFINITY);
    }
    let mut cage = builder.build().unwrap();
    if !shape.corner_uvs.is_empty() {
        let uvs = shape.uvs.iter().map(|p| p.map(|c| c as f32)).collect();
        cage = cage.with_uvs(uvs, shape.corner_uvs.clone()).unwrap();
    }
    let options = SurfaceOptions {
        scheme: Some(scheme),
        boundary: Some(random.case.boundary),
        face_varying: Some(random.case.fvar),
        ..SurfaceOptions::default()
    };
    Surface::new(cage, &options)
}

/// Random cages and those of the other tests.
fn all_cases() -> Vec<(String, Surface)> {
    let mut out: Vec<_> = cases().into_iter().map(|(name, s, _)| (name, s)).collect();
    for index in 0..36 {
        let (quads, triangles) = (random_cage(index), random_triangles(index));
        out.push((
            format!("quads {}", quads.case.name),
            of_random(&quads, Scheme::Kobbelt),
        ));
        out.push((
            format!("triangles {}", triangles.case.name),
            of_random(&triangles, Scheme::Butterfly),
        ));
    }
    out
}

/// The whole mesh at a level of the faces that are drawn.
fn whole(surface: &Surface, level: u32) -> Level<f64> {
    let options = surface.refine_options();
    let rule = surface.face_varying_rule();
    let t = surface.topology().clone();
    let base = Level::<f64>::of_cage(surface.cage(), t, options.scheme, rule).unwrap();
    let level = level + u32::from(surface.is_split());
    refine(base, &options, level, None, &mut Default::default()).unwrap()
}

/// Place on the cage of grid point (i, j) of `n` in face `q` of those that are drawn; `None` where it ends a quad of a polygon.
fn place(surface: &Surface, q: u32, [i, j]: [u32; 2], n: u32) -> Option<Place> {
    let [s, t] = [i, j].map(|i| i as f32 / n as f32);
    let face = surface.cage_face(q);
    let place = |u, v| Some(Place { face, u, v });
    if surface.is_triangular() {
        // The grid's columns are the weights of corners 1 and 2 together.
        return place(s - t, t);
    }
    let halves = surface.topology().face_halves(face);
    if !surface.is_split() {
        return place(s, t);
    }
    let k = q - halves.start;
    if halves.len() == 4 {
        let [s, t] = [0.5 * s, 0.5 * t];
        return match k {
            0 => place(s, t),
            1 => place(1.0 - t, s),
            2 => place(1.0 - s, 1.0 - t),
            _ => place(t, 1.0 - s),
        };
    }
    (i < n || k + 1 == halves.len() as u32)
        .then(|| place(k as f32 + s, t))
        .flatten()
}

/// Calls `then` with every grid point of a level that is a place: face that is drawn, place, corner of the whole mesh.
fn each(surface: &Surface, level: u32, mut then: impl FnMut(u32, Place, u32)) {
    let n = 1 << level;
    for q in 0..surface.quads().face_count() as u32 {
        let corners = oracle::grid_corners(surface, q, level);
        for (k, h) in (0..).zip(corners).filter(|c| c.1 != u32::MAX) {
            if let Some(place) = place(surface, q, [k % (n + 1), k / (n + 1)], n) {
                then(q, place, h);
            }
        }
    }
}

fn narrow<const N: usize>(p: [f64; N]) -> [f32; N] {
    p.map(|c| c as f32)
}

#[test]
fn points_have_the_bits_of_whole_mesh_refinement() {
    let mut compared = 0;
    for (name, surface) in all_cases() {
        // Points of the levels above are among them.
        let level = if surface.quads().face_count() > 60 {
            2
        } else {
            3
        };
        let fine = whole(&surface, level);
        let mut walk = surface.face_evaluator(0).unwrap();
        each(&surface, level, |q, p, h| {
            if walk.face() != p.face {
                walk = surface.face_evaluator(p.face).unwrap();
            }
            let got: [f32; 3] = walk.at_as(p.u, p.v).unwrap();
            let want = narrow(fine.points[fine.topology.vertex(h) as usize]);
            assert_eq!(got, want, "{name} level {level} face {q} at {p:?}");
            if let Some(uvs) = &fine.uvs {
                let want = narrow(uvs.values[uvs.corners[h as usize] as usize]);
                assert_eq!(
                    walk.uv(p.u, p.v),
                    Some(want),
                    "{name} level {level} at {p:?}"
                );
            }
            compared += 1;
        });
    }
    assert!(compared > 100_000, "{compared}");
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn length(a: [f64; 3]) -> f64 {
    a.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// Degrees between two directions.
fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let (a, b) = (a.map(|c| c / length(a)), b.map(|c| c / length(b)));
    let half = (length(minus(a, b)) / 2.0).min(1.0).asin();
    2.0 * half.to_degrees()
}

/// Whether the rules make derivatives by u and v of a vertex of the cage.
fn is_regular(t: &Topology, fan: u32, triangles: bool) -> bool {
    let f = t.fans()[fan as usize];
    let n = if triangles { 6 } else { 4 };
    let cut =
        Ring::of_fan(t, fan).any(|h| t.edge_sharpness(t.edge(h)) >= 10.0 && t.twin(h) != NONE);
    let tip = t.vertex_sharpness(t.fan_vertex(fan)) >= 10.0;
    !cut && if f.closed {
        f.faces == n && !tip
    } else {
        2 * f.faces == n && !tip || f.faces == 1 && tip
    }
}

/// Differences of derivatives and of their directions, from one-sided differences of a level.
#[derive(Default, Debug)]
struct Errors {
    derivative: f64,
    degrees: f64,
}

fn differences(surface: &Surface, coarse: u32, fine_level: u32) -> Errors {
    let fine = whole(surface, fine_level);
    let (n, fine_n) = (1_i32 << coarse, 1_i32 << fine_level);
    let step = fine_n / n;
    let triangles = surface.is_triangular();
    let size = oracle::size(surface);
    let mut errors = Errors::default();
    for q in 0..surface.quads().face_count() as u32 {
        let corners = oracle::grid_corners(surface, q, fine_level);
        let at = |[i, j]: [i32; 2]| {
            let h = corners[(j * (fine_n + 1) + i) as usize];
            fine.points[fine.topology.vertex(h) as usize]
        };
        for (i, j) in (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))) {
            if triangles && j > i {
                continue;
            }
            let own = [i * step, j * step];
            let Some(p) = place(surface, q, [i, j].map(|i| i as u32), n as u32) else {
                continue;
            };
            let sample = surface.evaluate(p.face, p.u, p.v).unwrap();
            // Steps by u and v in the grid; of a quad that is a quarter of its face they are other sides, so look at whole ones alone.
            let steps = match triangles {
                true => [[1, 0], [1, 1]],
                false => [[1, 0], [0, 1]],
            };
            let quads = surface.topology().face_halves(p.face).len() == 4;
            if surface.is_split() && quads {
                continue;
            }
            let t = surface.quads();
            let corner = match (i, j) {
                (0, 0) => Some(0),
                (i, 0) if i == n => Some(1),
                (i, j) if i == n && j == n => Some(2),
                (0, j) if j == n => Some(3),
                _ => None,
            };
            let fan = corner.map(|c| t.fan(t.face_halves(q).start + c));
            let regular = fan.is_none_or(|fan| is_regular(t, fan, triangles));
            // At other borders what is across shrinks at another rate than what is along, and directions with it.
            let directed = regular || fan.is_some_and(|fan| t.fans()[fan as usize].closed);
            for (d, got) in steps.into_iter().zip([sample.du, sample.dv]) {
                let inside = |[i, j]: [i32; 2]| {
                    i >= 0 && j >= 0 && i <= fine_n && j <= fine_n && (!triangles || j <= i)
                };
                let sides = [1, -1].map(|s| [own[0] + s * d[0], own[1] + s * d[1]]);
                let got = got.map(f64::from);
                for (sign, side) in [1.0, -1.0].into_iter().zip(sides) {
                    if !inside(side) {
                        continue;
                    }
                    let chord = minus(at(side), at(own)).map(|c| sign * c * f64::from(fine_n));
                    if regular {
                        let error = length(minus(chord, got)) / size;
                        errors.derivative = errors.derivative.max(error);
                    }
                    if directed && length(chord) > 1e-3 * size {
                        errors.degrees = errors.degrees.max(angle(chord, got));
                    }
                }
            }
        }
    }
    errors
}

#[test]
fn derivatives_are_those_of_deep_refinement() {
    let smooth = |name: &str, s| (name.to_owned(), asset(name, s));
    for scheme in BOTH {
        let mut surfaces: Vec<(String, Surface)> = Vec::new();
        for name in [
            "cube.obj",
            "octahedron.obj",
            "fan3.obj",
            "fan5.obj",
            "fan8.obj",
        ] {
            surfaces.push(smooth(name, scheme));
        }
        surfaces.push(("sheet".into(), sheet(3, scheme, None)));
        surfaces.push(("creased".into(), sheet(4, scheme, Some(2))));
        for (name, surface) in surfaces {
            let [a, c] = [4, 6].map(|level| differences(&surface, 2, level));
            let what = format!("{scheme:?} {name}: {a:?} {c:?}");
            assert!(a.derivative > 0.0 && a.degrees > 0.0, "{what}");
            assert!(c.derivative < 0.45 * a.derivative, "{what}");
            assert!(c.degrees < 0.55 * a.degrees && c.degrees < 10.0, "{what}");
        }
    }
}

#[test]
fn normals_are_those_of_dicing() {
    let mut compared = 0;
    for (name, surface, _) in cases() {
        if name.contains("mobius") || surface.quads().face_count() > 1000 {
            continue;
        }
        let level = 3;
        for q in 0..surface.quads().face_count() as u32 {
            let (grid, n) = (surface.dice(q, level), 1 << level);
            for (k, h) in (0..).zip(oracle::grid_corners(&surface, q, level)) {
                let place = place(&surface, q, [k % (n + 1), k / (n + 1)], n);
                if let (true, Some(p)) = (h != u32::MAX, place) {
                    let got = surface.evaluate(p.face, p.u, p.v).unwrap();
                    let want = grid.normals[k as usize];
                    let angle = oracle::angle(got.normal, want.map(f64::from));
                    assert!(angle < 0.05, "{name} face {q} at {p:?}: {angle} degrees");
                    assert_eq!(got.second, None);
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 10_000, "{compared}");
}

/// Some rings around face `f` as a mesh of its own, of which it is face 0.
fn crop(level: &Level<f64>, f: u32, rings: usize) -> Level<f64> {
    let t = &level.topology;
    let (mut faces, mut known) = (vec![f], BTreeSet::from([f]));
    for _ in 0..rings {
        for k in 0..faces.len() {
            for h in t.face_halves(faces[k]) {
                let around = Ring::of_fan(t, t.fan(h)).map(|g| t.face_of(g));
                faces.extend(around.filter(|g| known.insert(*g)).collect::<Vec<_>>());
            }
        }
    }
    let (mut points, mut corners, mut offsets) = (Vec::new(), Vec::new(), vec![0]);
    let mut number = BTreeMap::new();
    for f in faces {
        for h in t.face_halves(f) {
            let v = t.vertex(h);
            corners.push(*number.entry(v).or_insert_with(|| {
                points.push(level.points[v as usize]);
                points.len() as u32 - 1
            }));
        }
        offsets.push(corners.len() as u32);
    }
    let (t, _) = connect(points.len(), &offsets, corners, &ConnectOptions::default());
    Level::new(t, points).unwrap()
}

#[test]
fn the_deepest_points_are_those_of_a_mesh_refined_as_deep() {
    let mut random = super::common::Random(7);
    let mut worst = 0.0_f64;
    for (name, scheme) in [
        ("cube.obj", Scheme::Kobbelt),
        ("torus.obj", Scheme::Kobbelt),
        ("torus.obj", Scheme::Butterfly),
        ("octahedron.obj", Scheme::Butterfly),
        ("tetrahedron.obj", Scheme::Butterfly),
    ] {
        let surface = asset(name, scheme);
        let options = surface.refine_options();
        let size = oracle::size(&surface);
        for k in 0..24 {
            let face = random.next() % surface.quads().face_count() as u32;
            // Odd numbers are new at the last level; some lie in the corner where a vertex is extraordinary.
            let width = if k % 3 == 0 { 16 } else { 512 };
            let [x, y] = [0, 1].map(|_| random.next() % width * 2 % 1024 + 1);
            let [x, y] = match scheme {
                Scheme::Butterfly if x + y > 1024 => [(x / 2) | 1, y / 2],
                _ => [x, y],
            };
            let mut mesh = crop(&whole(&surface, 0), face, 5);
            let (mut at, mut size_here) = ([x, y], 1024);
            while size_here > 1 {
                let half = size_here / 2;
                let inner = |k: usize, low: bool| if low { at[k] } else { at[k] - half };
                let (child, next) = match scheme {
                    Scheme::Kobbelt => match (at[0] < half, at[1] < half) {
                        (true, true) => (0, at),
                        (false, true) => (1, [inner(0, false), at[1]]),
                        (false, false) => (2, [inner(0, false), inner(1, false)]),
                        (true, false) => (3, [at[0], inner(1, false)]),
                    },
                    _ if at[0] + at[1] <= half => (0, at),
                    _ if at[0] >= half => (1, [inner(0, false), at[1]]),
                    _ if at[1] >= half => (2, [at[0], inner(1, false)]),
                    _ => (3, [half - at[0], half - at[1]]),
                };
                let finer = refine(mesh, &options, 1, None, &mut Default::default()).unwrap();
                mesh = crop(&finer, child, 5);
                (at, size_here) = (next, half);
            }
            let c = match at {
                [0, 0] => 0,
                [1, 0] => 1,
                [1, 1] => 2,
                _ if scheme == Scheme::Butterfly => 2,
                _ => 3,
            };
            let want = mesh.points[mesh.topology.vertex(c) as usize];
            let [u, v] = [x, y].map(|x| x as f32 / 1024.0);
            let got: [f32; 3] = surface.evaluate_as(face, u, v).unwrap();
            let error = length(minus(got.map(f64::from), want)) / size;
            worst = worst.max(error);
            assert!(
                error < 1e-7,
                "{scheme:?} {name} face {face} ({u}, {v}): {error}"
            );
        }
    }
    eprintln!("worst {worst}");
}

#[test]
fn faces_agree_along_their_sides() {
    let mut compared = 0;
    for (name, surface) in all_cases() {
        if surface.is_split() {
            continue;
        }
        let t = surface.quads();
        let triangles = surface.is_triangular();
        for h in (0..t.half_count() as u32).step_by(1 + t.half_count() / 50) {
            let g = t.twin(h);
            if g == NONE {
                continue;
            }
            for k in [1, 338, 512, 777, 1023] {
                let sample = |h: u32, k: u32| {
                    let f = t.face_of(h);
                    let x = k as f32 / 1024.0;
                    let (u, v) = match (h - t.face_halves(f).start, triangles) {
                        (0, _) => (x, 0.0),
                        (1, true) => (1.0 - x, x),
                        (2, true) => (0.0, 1.0 - x),
                        (1, _) => (1.0, x),
                        (2, _) => (1.0 - x, 1.0),
                        _ => (0.0, 1.0 - x),
                    };
                    surface.evaluate(f, u, v).unwrap()
                };
                let (a, b) = (sample(h, k), sample(g, 1024 - k));
                assert_eq!(a.position, b.position, "{name} edge of {h} at {k}");
                let turn = oracle::angle(a.normal, b.normal.map(f64::from));
                assert!(turn < 1e-3, "{name} edge of {h} at {k}: {turn} degrees");
                compared += 1;
            }
        }
    }
    assert!(compared > 1000, "{compared}");
}

#[test]
fn other_places_are_refused() {
    for scheme in BOTH {
        let surface = asset("octahedron.obj", scheme);
        let asset = asset("cube.obj", scheme);
        let mut face = asset.face_evaluator(0).unwrap();
        let step = 1.0 / 1024.0;
        assert!(asset.evaluate(0, 3.0 * step, 5.0 * step).is_some());
        for (u, v) in [
            (0.3, 0.25),
            (0.25, 0.3),
            (0.5 * step, 0.0),
            (0.5, 0.5 - 0.25 * step),
        ] {
            assert!(asset.evaluate(0, u, v).is_none(), "{scheme:?} {u} {v}");
            assert!(face.at(u, v).is_none() && face.uv(u, v).is_none());
            let places = [(0.5, 0.25), (u, v)].map(|(u, v)| Place { face: 0, u, v });
            let mut out = [[7.0; 3]; 2];
            let error = asset.evaluate_many(&places, &mut out);
            assert_eq!(
                error,
                Err(EvaluateError::NotDyadic { index: 1 }),
                "{scheme:?}"
            );
            assert_eq!(out, [[7.0; 3]; 2]);
        }
        let beyond = if scheme == Scheme::Butterfly {
            0.5 + step
        } else {
            1.0 + step
        };
        for (f, u, v) in [
            (0, beyond, 0.5),
            (0, -step, 0.5),
            (0, 0.5, -step),
            (0, f32::NAN, 0.5),
            (0, f32::INFINITY, 0.0),
            (1000, 0.5, 0.5),
        ] {
            assert!(asset.evaluate(f, u, v).is_none(), "{scheme:?} {u} {v}");
            let error = asset.evaluate_many(&[Place { face: f, u, v }], &mut [[0.0; 3]]);
            assert_eq!(
                error,
                Err(EvaluateError::NoSuchPlace { index: 0 }),
                "{scheme:?}"
            );
        }
        // Polygons of Kobbelt's scheme have a quad per corner; triangles of Butterfly have none.
        assert_eq!(
            surface.evaluate(0, 2.75, 0.25).is_some(),
            scheme == Scheme::Kobbelt
        );
        assert!(surface.evaluate(0, 3.0 + step, 0.25).is_none());
        let mut few = vec![[0.0; 3]; asset.face_evaluator(0).unwrap().grid_len(3)];
        let error = asset.face_evaluator(0).unwrap().grid(3, &mut few);
        assert_eq!(error, Err(EvaluateError::NotDyadic { index: 1 }));
    }
}

#[test]
fn many_places_are_each_place() {
    let mut random = super::common::Random(3);
    for (name, surface) in all_cases() {
        let faces = surface.topology().face_count() as u32;
        let places: Vec<Place> = (0..200)
            .map(|_| {
                let face = random.next() % faces;
                let n = surface.topology().face_halves(face).len() as u32;
                let wide = if surface.is_triangular() || n == 4 {
                    1
                } else {
                    n
                };
                let (mut x, mut y) = (random.next() % (1024 * wide + 1), random.next() % 1025);
                if surface.is_triangular() && x + y > 1024 {
                    (x, y) = (1024 - x, 1024 - y);
                }
                let [u, v] = [x, y].map(|x| x as f32 / 1024.0);
                Place { face, u, v }
            })
            .collect();
        let mut samples = vec![Sample::default(); places.len()];
        surface.evaluate_many(&places, &mut samples).unwrap();
        let mut points = vec![[0.0; 3]; places.len()];
        surface.evaluate_many(&places, &mut points).unwrap();
        for ((p, sample), point) in places.iter().zip(&samples).zip(&points) {
            assert_eq!(
                surface.evaluate(p.face, p.u, p.v),
                Some(*sample),
                "{name} {p:?}"
            );
            assert_eq!(sample.position, *point, "{name} {p:?}");
            let tangents: Tangents = surface.evaluate_as(p.face, p.u, p.v).unwrap();
            assert_eq!((tangents.du, tangents.dv), (sample.du, sample.dv));
            let length = length(sample.normal.map(f64::from));
            assert!((length - 1.0).abs() < 1e-5, "{name} {p:?}: {sample:?}");
        }
    }
}

#[test]
fn grids_are_their_places() {
    for (name, surface, _) in cases() {
        let mut face = surface.face_evaluator(0).unwrap();
        let n = 8;
        let mut out = vec![Sample::default(); face.grid_len(n)];
        face.grid(n, &mut out).unwrap();
        let sides = surface.topology().face_halves(0).len();
        let quads = if surface.is_triangular() || sides == 4 {
            1
        } else {
            sides
        };
        let mut k = 0;
        for quad in 0..quads {
            for j in 0..=n {
                for i in 0..=if surface.is_triangular() { n - j } else { n } {
                    let [u, v] = [i, j].map(|i| i as f32 / n as f32);
                    if quads == 1 || i < n {
                        let want = surface.evaluate(0, quad as f32 + u, v).unwrap();
                        assert_eq!(out[k], want, "{name} {quad} {i} {j}");
                    }
                    k += 1;
                }
            }
        }
        assert_eq!(k, out.len(), "{name}");
    }
}

#[test]
fn vertices_of_the_cage_are_its_points() {
    for (name, surface) in all_cases() {
        let cage = surface.cage();
        for f in 0..cage.face_count() {
            let corners = cage.face(f);
            for (k, &v) in corners.iter().enumerate() {
                let (u, v_at) = match (corners.len(), k) {
                    (3, 1) if surface.is_triangular() => (1.0, 0.0),
                    (3, 2) if surface.is_triangular() => (0.0, 1.0),
                    (4, _) => [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)][k],
                    _ => (k as f32, 0.0),
                };
                let got: [f32; 3] = surface.evaluate_as(f as u32, u, v_at).unwrap();
                assert_eq!(got, cage.points()[v as usize], "{name} face {f} corner {k}");
            }
        }
    }
}
