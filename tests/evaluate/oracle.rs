//! What deep refinement in double precision says about the limit: points everywhere, derivatives at regular vertices.

use super::support::*;
use earmark::refine::{Level, Options, limit};
use earmark::scheme::{Boundary, Scheme};
use earmark::topology::{NONE, Topology};
use earmark::{Cage, Surface, SurfaceOptions};

pub(crate) fn cage_of(shape: &Shape) -> Cage {
    let mut cage = Cage::builder().points(shape.points.iter().map(|p| p.map(|c| c as f32)));
    for w in shape.face_offsets.windows(2) {
        let corners = &shape.corners[w[0] as usize..w[1] as usize];
        cage = cage.face(corners.iter().copied());
    }
    for c in &shape.creases {
        cage = cage.crease(c.vertices[0], c.vertices[1], c.sharpness);
    }
    for c in &shape.sharp_vertices {
        cage = cage.corner(c.vertex, c.sharpness);
    }
    cage.build().unwrap()
}

pub(crate) fn surface_of(shape: &Shape, boundary: Boundary) -> Surface {
    let options = SurfaceOptions {
        scheme: Some(Scheme::CatmullClark),
        boundary: Some(boundary),
        ..SurfaceOptions::default()
    };
    Surface::new(cage_of(shape), &options)
}

/// Face of the cage, parameters of corner 0, and length of a side in parameters, of every face of level `depth` ≥ 1.
fn places(base: &Topology, depth: u32) -> Vec<(u32, [f64; 2], f64)> {
    const STEPS: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut out = Vec::new();
    for f in 0..base.face_count() as u32 {
        let halves = base.face_halves(f);
        for j in 0..halves.len() {
            out.push(if halves.len() == 4 {
                (f, STEPS[j].map(|x| 0.5 * x), 0.5)
            } else {
                (f, [j as f64, 0.0], 1.0)
            });
        }
    }
    for _ in 1..depth {
        out = out
            .iter()
            .flat_map(|&(f, [u, v], size)| {
                STEPS.map(|[i, j]| (f, [u + 0.5 * size * i, v + 0.5 * size * j], 0.5 * size))
            })
            .collect();
    }
    out
}

type V3 = [f64; 3];

fn mix(terms: &[(f64, V3)]) -> V3 {
    std::array::from_fn(|c| terms.iter().map(|(w, p)| w * p[c]).sum())
}
fn size(v: V3) -> f64 {
    distance(&v, &[0.0; 3])
}

/// Derivatives [du, dv, duu, duv, dvv] by steps of the level at the vertex of `h`, if it is regular and inside.
fn derivatives(level: &Level<f64>, h: u32) -> Option<[V3; 5]> {
    let t = &level.topology;
    let fan = t.fans()[t.fan(h) as usize];
    if !fan.closed || fan.faces != 4 || t.vertex_sharpness(t.vertex(h)) > 0.0 {
        return None;
    }
    let at = |g: u32| level.points[t.vertex(g) as usize];
    let (mut e, mut f, mut g) = ([[0.0; 3]; 4], [[0.0; 3]; 4], h);
    for i in 0..4 {
        e[i] = at(t.next(g));
        f[i] = at(t.next(t.next(g)));
        if t.edge_sharpness(t.edge(g)) > 0.0 {
            return None;
        }
        g = t.rotate(g);
        if g == NONE {
            return None;
        }
    }
    let v = at(h);
    let slope = |a: usize, b: usize, fs: [usize; 4]| {
        mix(&[
            (1.0 / 3.0, e[a]),
            (-1.0 / 3.0, e[b]),
            (1.0 / 12.0, f[fs[0]]),
            (1.0 / 12.0, f[fs[1]]),
            (-1.0 / 12.0, f[fs[2]]),
            (-1.0 / 12.0, f[fs[3]]),
        ])
    };
    // Rows across the direction weigh 1/6, 2/3, 1/6.
    let bend = |a: usize, b: usize, c: usize, d: usize| {
        let mut terms = vec![(2.0 / 3.0, e[a]), (2.0 / 3.0, e[b]), (-4.0 / 3.0, v)];
        terms.extend(f.map(|p| (1.0 / 6.0, p)));
        terms.extend([(-1.0 / 3.0, e[c]), (-1.0 / 3.0, e[d])]);
        mix(&terms)
    };
    Some([
        slope(0, 2, [0, 3, 1, 2]),
        slope(1, 3, [0, 1, 2, 3]),
        bend(0, 2, 1, 3),
        mix(&[(0.25, f[0]), (-0.25, f[1]), (0.25, f[2]), (-0.25, f[3])]),
        bend(1, 3, 0, 2),
    ])
}

/// Compares the surface of `shape` with level `depth` and its limit: points to 1e-6 of the box, first derivatives to 1e-5 of their size,
/// second ones to 1e-4 of theirs.
pub(crate) fn compare(shape: &Shape, boundary: Boundary, depth: u32) {
    let mut shape = shape.clone();
    for p in &mut shape.points {
        *p = p.map(|c| f64::from(c as f32));
    }
    let surface = surface_of(&shape, boundary);
    let base = shape.level(boundary);
    let places = places(&base.topology, depth);
    let level = step(base, depth);
    let points = limit(&level, &Options::default()).positions;
    let reach = points
        .iter()
        .flatten()
        .fold(0.0, |m: f64, c| m.max(c.abs()));
    // Results are numbers of 24 bits.
    let allowed = 1e-6 * extent(&shape.points) + 1.2e-7 * reach;
    // Control levels below creases are of single precision, which second differences feel.
    let creased = !shape.creases.is_empty() || !shape.sharp_vertices.is_empty();
    let noise = if creased { 1e-7 * reach } else { 0.0 };
    let mut checked = 0;
    for (f, &(face, [u, v], side)) in places.iter().enumerate() {
        let h = 4 * f as u32;
        let sample = surface.evaluate(face, u as f32, v as f32).unwrap();
        let what = || {
            format!(
                "face {face} ({u}, {v}) of {} faces, {boundary:?}",
                shape.faces()
            )
        };
        let off = distance(
            &sample.position.map(f64::from),
            &points[level.topology.vertex(h) as usize],
        );
        assert!(off <= allowed, "{}: {off}", what());
        let (Some(want), Some(second)) = (derivatives(&level, h), sample.second) else {
            continue;
        };
        checked += 1;
        let scale = |k: usize| if k < 2 { side } else { side * side };
        let want: Vec<V3> = (0..5).map(|k| want[k].map(|c| c / scale(k))).collect();
        let got = [sample.du, sample.dv, second.duu, second.duv, second.dvv];
        let first = size(want[0]) + size(want[1]);
        let bend = want[2..].iter().map(|v| size(*v)).sum::<f64>();
        for k in 0..5 {
            let off = distance(&got[k].map(f64::from), &want[k]);
            let allowed = if k < 2 {
                1e-5 * first
            } else {
                1e-4 * bend + 1e-5 * first + noise / (side * side)
            };
            assert!(
                off <= allowed,
                "{}: derivative {k} off by {off}, {allowed} allowed",
                what()
            );
        }
    }
    assert!(checked > 0, "derivatives were compared");
}
