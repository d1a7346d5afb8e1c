//! Loop's rules on whole meshes in f64, in the plainest way.

use super::super::fans::beta;
use super::V3;
use crate::topology::{Fan, FanRule, NONE, Ring, Topology};

pub(super) fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
pub(super) fn cross(a: V3, b: V3) -> V3 {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
pub(super) fn mix(terms: &[(f64, V3)]) -> V3 {
    std::array::from_fn(|c| terms.iter().map(|(w, p)| w * p[c]).sum())
}

/// The neighbours of a fan, counter-clockwise.
pub(super) fn ring(t: &Topology, id: u32) -> Vec<u32> {
    let halves: Vec<u32> = Ring::of_fan(t, id).collect();
    let mut out: Vec<u32> = halves.iter().map(|&h| t.fan(t.next(h))).collect();
    if !t.fans()[id as usize].closed {
        out.push(t.fan(t.prev(*halves.last().unwrap())));
    }
    out
}

/// Points by fan after one step, and the connectivity with a vertex per fan.
pub(super) fn refine_once(t: &Topology, points: &[V3]) -> (Topology, Vec<V3>) {
    let at = |h: u32| points[t.fan(h) as usize];
    let mut out = Vec::new();
    for (id, fan) in t.fans().iter().enumerate() {
        let v = points[id];
        if fan.first == NONE || fan.rule == FanRule::Corner {
            out.push(v);
            continue;
        }
        let ring: Vec<V3> = ring(t, id as u32)
            .iter()
            .map(|&f| points[f as usize])
            .collect();
        let n = ring.len() as f64;
        out.push(if fan.closed {
            let c = 0.375 + 0.25 * (2.0 * std::f64::consts::PI / n).cos();
            let b = (0.625 - c * c) / n;
            let mut terms = vec![(1.0 - n * b, v)];
            terms.extend(ring.iter().map(|&p| (b, p)));
            mix(&terms)
        } else {
            mix(&[(0.75, v), (0.125, ring[0]), (0.125, *ring.last().unwrap())])
        });
    }
    let halves = t.half_count() as u32;
    let mut edges = vec![NONE; halves as usize];
    let mut middles = Vec::new();
    for h in 0..halves {
        let g = t.twin(h);
        if g != NONE && g < h {
            edges[h as usize] = edges[g as usize];
            continue;
        }
        edges[h as usize] = out.len() as u32;
        middles.push(h);
        let (a, b) = (at(h), at(t.next(h)));
        out.push(if g == NONE {
            mix(&[(0.5, a), (0.5, b)])
        } else {
            let (c, d) = (at(t.prev(h)), at(t.prev(g)));
            mix(&[(0.375, a), (0.375, b), (0.125, c), (0.125, d)])
        });
    }
    let mut s = Topology {
        vertex_count: out.len(),
        twins: vec![NONE; 4 * halves as usize],
        ..Topology::default()
    };
    let child = |h: u32, second: bool| {
        4 * (h - h % 3) + [[0, 3], [4, 7], [8, 2]][h as usize % 3][usize::from(second)]
    };
    for f in 0..halves / 3 {
        let v = [0, 1, 2].map(|c| t.fan(3 * f + c));
        let e = [0, 1, 2].map(|c| edges[(3 * f + c) as usize]);
        s.corner_vertices.extend([
            v[0], e[0], e[2], e[0], v[1], e[1], e[2], e[1], v[2], e[1], e[2], e[0],
        ]);
        for (a, b) in [(1, 10), (5, 11), (6, 9)] {
            s.twins[(12 * f + a) as usize] = 12 * f + b;
            s.twins[(12 * f + b) as usize] = 12 * f + a;
        }
    }
    for h in 0..halves {
        let g = t.twin(h);
        if g != NONE {
            for second in [false, true] {
                s.twins[child(h, second) as usize] = child(g, !second);
            }
        }
    }
    s.face_offsets = (0..=4 * halves / 3).map(|f| 3 * f).collect();
    s.corner_faces = (0..4 * halves).map(|h| h / 3).collect();
    for fan in t.fans() {
        let first = match fan.first {
            NONE => NONE,
            h => child(h, false),
        };
        s.fans.push(Fan { first, ..*fan });
    }
    for h in middles {
        let closed = t.twin(h) != NONE;
        s.fans.push(Fan {
            first: child(h, true),
            faces: if closed { 6 } else { 3 },
            closed,
            rule: if closed {
                FanRule::Smooth
            } else {
                FanRule::Crease
            },
        });
    }
    (s, out)
}

/// Limit point of a fan, and its unit normal where the rules have a tangent plane and we know it by heart.
pub(super) fn limit(t: &Topology, points: &[V3], id: u32) -> (V3, Option<V3>) {
    let fan = t.fans()[id as usize];
    let v = points[id as usize];
    let e: Vec<V3> = ring(t, id).iter().map(|&f| points[f as usize]).collect();
    let n = e.len() as f64;
    let (a, b) = (e[0], *e.last().unwrap());
    let (point, tangents) = match (fan.rule, fan.closed, fan.faces) {
        (FanRule::Corner, _, k) => {
            let t = (k <= 1).then(|| [mix(&[(1.0, a), (-1.0, v)]), mix(&[(1.0, b), (-1.0, v)])]);
            (v, t)
        }
        (_, true, k) => {
            let w = 1.0 / (n + 0.375 / beta(k));
            let mut terms = vec![(1.0 - n * w, v)];
            terms.extend(e.iter().map(|&p| (w, p)));
            let wave = |f: fn(f64) -> f64| {
                let angle = |i: usize| 2.0 * std::f64::consts::PI * i as f64 / n;
                let terms: Vec<_> = e
                    .iter()
                    .enumerate()
                    .map(|(i, &p)| (f(angle(i)), p))
                    .collect();
                mix(&terms)
            };
            (mix(&terms), Some([wave(f64::cos), wave(f64::sin)]))
        }
        (_, false, k) => {
            let point = mix(&[(2.0 / 3.0, v), (1.0 / 6.0, a), (1.0 / 6.0, b)]);
            let along = mix(&[(1.0, a), (-1.0, b)]);
            let across = match k {
                1 => Some(mix(&[(1.0, a), (1.0, b), (-2.0, v)])),
                2 => Some(mix(&[(1.0, e[1]), (-1.0, v)])),
                3 => Some(mix(&[
                    (1.0, e[1]),
                    (1.0, e[2]),
                    (-1.0, v),
                    (-0.5, a),
                    (-0.5, b),
                ])),
                _ => None,
            };
            (point, across.map(|across| [along, across]))
        }
    };
    let normal = tangents.map(|[a, b]| {
        let n = cross(a, b);
        let l = dot(n, n).sqrt();
        n.map(|c| c / l)
    });
    (point, normal)
}

/// Vertex of the finest mesh at each grid point (row by row) of a triangle of the coarsest; [`NONE`] above the diagonal.
pub(super) fn grid_vertices(levels: &[Topology], face: u32) -> Vec<u32> {
    let n = 1_i32 << (levels.len() - 1);
    let mut grid = vec![NONE; ((n + 1) * (n + 1)) as usize];
    let mut stack = vec![(0_usize, face, [[0, 0], [n, 0], [n, n]])];
    while let Some((depth, f, p)) = stack.pop() {
        if depth + 1 == levels.len() {
            for c in 0..3 {
                let v = levels[depth].fan(3 * f + c as u32);
                grid[(p[c][1] * (n + 1) + p[c][0]) as usize] = v;
            }
            continue;
        }
        let mid = |a: [i32; 2], b: [i32; 2]| [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
        let e = [0, 1, 2].map(|c| mid(p[c], p[(c + 1) % 3]));
        let children = [
            [p[0], e[0], e[2]],
            [e[0], p[1], e[1]],
            [e[2], e[1], p[2]],
            [e[1], e[2], e[0]],
        ];
        for (k, child) in children.into_iter().enumerate() {
            stack.push((depth + 1, 4 * f + k as u32, child));
        }
    }
    grid
}
