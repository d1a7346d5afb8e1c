//! Cages of triangles, and what deep refinement in double precision by Loop's rules says about their limit.

use super::is_finite;
use super::oracle::cage_of;
use super::support::*;
use earmark::refine::{Level, Options, limit};
use earmark::scheme::{Boundary, Scheme};
use earmark::topology::NONE;
use earmark::{Surface, SurfaceOptions};

type V3 = [f64; 3];

pub(crate) fn loops() -> Options {
    Options {
        scheme: Scheme::Loop,
        ..Options::default()
    }
}

pub(crate) fn surface_of(shape: &Shape, boundary: Boundary) -> Surface {
    let options = SurfaceOptions {
        scheme: Some(Scheme::Loop),
        boundary: Some(boundary),
        ..SurfaceOptions::default()
    };
    Surface::new(cage_of(shape), &options)
}

pub(crate) fn shape_of(points: &[V3], faces: &[[u32; 3]]) -> Shape {
    let faces: Vec<&[u32]> = faces.iter().map(|f| f.as_slice()).collect();
    Shape::new(points, &faces)
}

/// Points (i, j) of the lattice with i, j from 0 to `n`, point (i, j) at (i + j/2, j) before noise.
pub(crate) fn sheet(n: u32, noise: f64, height: impl Fn(f64, f64) -> f64) -> Shape {
    let (mut random, mut points, mut faces) = (Noise(n.into()), Vec::new(), Vec::new());
    for j in 0..=n {
        for i in 0..=n {
            let (x, y) = (f64::from(i), f64::from(j));
            let b = random.point().map(|c| noise * c);
            points.push([x + b[0], y + b[1], height(x, y) + b[2]]);
        }
    }
    let at = |i: u32, j: u32| j * (n + 1) + i;
    for j in 0..n {
        for i in 0..n {
            faces.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
            faces.push([at(i + 1, j + 1), at(i, j + 1), at(i + 1, j)]);
        }
    }
    shape_of(&points, &faces)
}

/// Vertex 0 amid (or, open, at the border of) `n` triangles, with two rings of vertices around it.
pub(crate) fn wheel(n: u32, closed: bool, seed: u64) -> Shape {
    let mut noise = Noise(seed);
    let full = if closed { 2.0 } else { 1.0 } * std::f64::consts::PI;
    let count = if closed { n } else { n + 1 };
    let mut points = vec![[0.0, 0.0, 0.4 * noise.number()]];
    for radius in [1.0, 2.0] {
        for i in 0..count {
            let a = full * (f64::from(i) + 0.5 * (radius - 1.0)) / f64::from(n);
            let b = noise.point().map(|c| 0.2 * c);
            points.push([radius * a.cos() + b[0], radius * a.sin() + b[1], 2.0 * b[2]]);
        }
    }
    let mut faces = Vec::new();
    for i in 0..n {
        let (a, b) = (1 + i, 1 + (i + 1) % count);
        faces.push([0, a, b]);
        faces.push([b, a, a + count]);
        if closed || i + 1 < n {
            faces.push([b, a + count, b + count]);
        }
    }
    shape_of(&points, &faces)
}

pub(crate) fn icosahedron(seed: u64) -> Shape {
    let g = 0.5 + 1.25_f64.sqrt();
    let mut noise = Noise(seed);
    let mut points: Vec<V3> = Vec::new();
    for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
        points.extend([[0.0, a, b], [a, b, 0.0], [b, 0.0, a]]);
    }
    let near = |p: &V3, q: &V3| (distance(p, q) - 2.0).abs() < 1e-9;
    let mut faces = Vec::new();
    for a in 0..12_u32 {
        for b in 0..12 {
            for c in 0..12 {
                let [p, q, r] = [a, b, c].map(|i| points[i as usize]);
                let first = a < b && a < c;
                if !(first && near(&p, &q) && near(&q, &r) && near(&r, &p)) {
                    continue;
                }
                let [x, y, z] = [0, 1, 2].map(|k| {
                    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                    (q[i] - p[i]) * (r[j] - p[j]) - (q[j] - p[j]) * (r[i] - p[i])
                });
                if x * p[0] + y * p[1] + z * p[2] > 0.0 {
                    faces.push([a, b, c]);
                }
            }
        }
    }
    assert_eq!(faces.len(), 20);
    for p in &mut points {
        let b = noise.point();
        *p = [0, 1, 2].map(|k| p[k] + 0.4 * b[k]);
    }
    shape_of(&points, &faces)
}

/// A closed cage of valences from 3 on: vertices put into faces of an icosahedron, and into their children.
pub(crate) fn lumpy(seed: u64) -> Shape {
    let base = icosahedron(seed);
    let (mut points, mut random) = (base.points, Noise(seed + 9));
    let mut faces: Vec<[u32; 3]> = (base.corners.chunks_exact(3))
        .map(|c| [c[0], c[1], c[2]])
        .collect();
    for _ in 0..12 {
        let f = ((random.number() + 0.5) * faces.len() as f64) as usize;
        let [a, b, c] = faces[f];
        let middle = |k: usize| [a, b, c].map(|v| points[v as usize][k]).iter().sum::<f64>();
        let bump = random.point();
        let new = points.len() as u32;
        let p = [0, 1, 2].map(|k| middle(k) / 3.0 + 0.3 * bump[k]);
        points.push(p);
        faces[f] = [a, b, new];
        faces.extend([[b, c, new], [c, a, new]]);
    }
    shape_of(&points, &faces)
}

/// Face of the cage, parameters of corner 0, and length of a side (negative where turned), of every face of level `depth`.
fn places(faces: u32, depth: u32) -> Vec<(u32, [f64; 2], f64)> {
    let mut out: Vec<(u32, [f64; 2], f64)> = (0..faces).map(|f| (f, [0.0; 2], 1.0)).collect();
    for _ in 0..depth {
        let split = |&(f, [u, v], s): &(u32, [f64; 2], f64)| {
            let h = 0.5 * s;
            [
                (f, [u, v], h),
                (f, [u + h, v], h),
                (f, [u, v + h], h),
                (f, [u + h, v + h], -h),
            ]
        };
        out = out.iter().flat_map(split).collect();
    }
    out
}

fn mix(terms: &[(f64, V3)]) -> V3 {
    std::array::from_fn(|c| terms.iter().map(|(w, p)| w * p[c]).sum())
}
fn size(v: V3) -> f64 {
    distance(&v, &[0.0; 3])
}

/// Derivatives [du, dv, duu, duv, dvv] by steps of the level at the vertex of `h`, if it is regular and inside: differences along the three
/// directions of the lattice.
fn derivatives(level: &Level<f64>, h: u32) -> Option<[V3; 5]> {
    let t = &level.topology;
    let fan = t.fans()[t.fan(h) as usize];
    if !fan.closed || fan.faces != 6 || t.vertex_sharpness(t.vertex(h)) > 0.0 {
        return None;
    }
    let (mut e, mut g) = ([[0.0; 3]; 6], h);
    for e in &mut e {
        *e = level.points[t.vertex(t.next(g)) as usize];
        if t.edge_sharpness(t.edge(g)) > 0.0 {
            return None;
        }
        g = t.rotate(g);
        if g == NONE {
            return None;
        }
    }
    let v = level.points[t.vertex(h) as usize];
    // Along edge k: two thirds of the difference along it, and a third of those beside it that have a part in it.
    let slope = |k: usize| {
        let side = |i: usize, w: f64| [(w, e[i % 6]), (-w, e[(i + 3) % 6])];
        let terms = [
            side(k, 1.0 / 3.0),
            side(k + 1, 1.0 / 6.0),
            side(k + 5, 1.0 / 6.0),
        ];
        mix(&terms.concat())
    };
    let bend = |k: usize| mix(&[(1.0, e[k]), (1.0, e[k + 3]), (-2.0, v)]);
    let (uu, vv, across) = (bend(0), bend(1), bend(2));
    // The third direction is v − u: its second derivative is duu + dvv − 2 duv.
    let uv = mix(&[(0.5, uu), (0.5, vv), (-0.5, across)]);
    Some([slope(0), slope(1), uu, uv, vv])
}

/// Largest errors: of points by the extent of the shape, of first and second derivatives by their size, of normals, of texture coordinates;
/// and how many derivatives there were.
#[derive(Debug, Default)]
pub(crate) struct Errors {
    pub(crate) point: f64,
    pub(crate) slope: f64,
    pub(crate) bend: f64,
    pub(crate) normal: f64,
    pub(crate) uv: f64,
    pub(crate) checked: usize,
}

pub(crate) fn errors(shape: &Shape, boundary: Boundary, depth: u32) -> Errors {
    let mut shape = shape.clone();
    for p in &mut shape.points {
        *p = p.map(|c| f64::from(c as f32));
    }
    let surface = surface_of(&shape, boundary);
    errors_of(&surface, shape.level(boundary), &loops(), depth)
}

pub(crate) fn errors_of(
    surface: &Surface,
    base: Level<f64>,
    options: &Options,
    depth: u32,
) -> Errors {
    let places = places(base.topology.face_count() as u32, depth);
    let extent = extent(&base.points);
    let level = refined(base, depth, options);
    let t = &level.topology;
    assert_eq!(places.len(), t.face_count());
    let limits = limit(&level, options);
    let mut out = Errors::default();
    let worst = |m: &mut f64, x: f64| *m = if x.is_nan() { f64::INFINITY } else { m.max(x) };
    for (f, &(face, [u, v], side)) in places.iter().enumerate() {
        for (c, [u, v]) in [[u, v], [u + side, v], [u, v + side]]
            .into_iter()
            .enumerate()
        {
            let h = 3 * f as u32 + c as u32;
            let sample = surface.evaluate(face, u as f32, v as f32).unwrap();
            assert!(is_finite(&sample), "face {face} ({u}, {v}): {sample:?}");
            let want = &limits.positions[t.vertex(h) as usize];
            let off = distance(&sample.position.map(f64::from), want);
            worst(&mut out.point, off / extent);
            if let Some(uvs) = &level.uvs {
                let mut evaluator = surface.face_evaluator(face).unwrap();
                let got = evaluator.uv(u as f32, v as f32).unwrap();
                let want = limits.uvs[uvs.corners[h as usize] as usize];
                (0..2).for_each(|k| worst(&mut out.uv, (f64::from(got[k]) - want[k]).abs()));
            }
            let fan = t.fans()[t.fan(h) as usize];
            if t.vertex_sharpness(t.vertex(h)) == 0.0 && fan.faces > 1 {
                let want = limits.normals[limits.normal_index(t, h) as usize];
                let off = distance(&sample.normal.map(f64::from), &want);
                worst(&mut out.normal, off);
            }
            let (0, Some(want), Some(second)) = (c, derivatives(&level, h), sample.second) else {
                continue;
            };
            out.checked += 1;
            let scale = |k: usize| if k < 2 { side } else { side * side };
            let want: Vec<V3> = (0..5).map(|k| want[k].map(|c| c / scale(k))).collect();
            let got = [sample.du, sample.dv, second.duu, second.duv, second.dvv];
            let off = |k: usize| distance(&got[k].map(f64::from), &want[k]);
            let first = size(want[0]) + size(want[1]);
            let bend = want[2..].iter().map(|v| size(*v)).sum::<f64>();
            (0..2).for_each(|k| worst(&mut out.slope, off(k) / first));
            (2..5).for_each(|k| worst(&mut out.bend, off(k) / (bend + 0.1 * first)));
        }
    }
    out
}
