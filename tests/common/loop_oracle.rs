//! Loop subdivision as a textbook has it: edges in a map, one vertex after the other, uniform creases. Shares nothing with the crate.
#![allow(dead_code, missing_docs, unreachable_pub)]

use std::collections::BTreeMap;

pub type Point = [f64; 3];

#[derive(Clone, Debug, Default)]
pub struct Mesh {
    pub points: Vec<Point>,
    pub triangles: Vec<[usize; 3]>,
    /// By the lower and the higher vertex.
    pub edges: BTreeMap<(usize, usize), f32>,
    pub corners: BTreeMap<usize, f32>,
}

fn key(a: usize, b: usize) -> (usize, usize) {
    (a.min(b), a.max(b))
}

fn less(s: f32) -> f32 {
    if s >= 10.0 { s } else { (s - 1.0).max(0.0) }
}

fn mix(terms: &[(f64, Point)]) -> Point {
    let mut sum = [0.0; 3];
    for (w, p) in terms {
        for k in 0..3 {
            sum[k] += w * p[k];
        }
    }
    sum
}

impl Mesh {
    /// Vertices opposite every edge.
    fn opposite(&self) -> BTreeMap<(usize, usize), Vec<usize>> {
        let mut out: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
        for t in &self.triangles {
            for k in 0..3 {
                let apex = t[(k + 2) % 3];
                out.entry(key(t[k], t[(k + 1) % 3])).or_default().push(apex);
            }
        }
        out
    }

    fn vertex(&self, v: usize, ring: &[(usize, f32)]) -> Point {
        let x = self.points[v];
        let rule = |corner: f32, sharp: &[usize]| -> Point {
            if corner > 0.0 || sharp.len() > 2 {
                x
            } else if let [a, b] = sharp {
                mix(&[
                    (0.75, x),
                    (0.125, self.points[*a]),
                    (0.125, self.points[*b]),
                ])
            } else {
                let n = ring.len() as f64;
                let c = 3.0 / 8.0 + (std::f64::consts::TAU / n).cos() / 4.0;
                let beta = (5.0 / 8.0 - c * c) / n;
                let mut terms = vec![(1.0 - n * beta, x)];
                terms.extend(ring.iter().map(|&(u, _)| (beta, self.points[u])));
                mix(&terms)
            }
        };
        let corner = self.corners.get(&v).copied().unwrap_or(0.0);
        let sharp = |of: &dyn Fn(f32) -> f32| -> Vec<usize> {
            let kept = ring.iter().filter(|(_, s)| of(*s) > 0.0);
            kept.map(|&(u, _)| u).collect()
        };
        let (before, after) = (sharp(&|s| s), sharp(&less));
        let class = |corner: f32, sharp: &[usize]| match sharp.len() {
            _ if corner > 0.0 => 3,
            0 | 1 => 0,
            n => n.min(3),
        };
        let (parent, child) = (class(corner, &before), class(less(corner), &after));
        if parent == child || parent == 0 {
            return rule(corner, &before);
        }
        let lost: Vec<f32> = std::iter::once(corner)
            .chain(ring.iter().map(|r| r.1))
            .filter(|&s| s > 0.0 && less(s) <= 0.0)
            .collect();
        let w = if lost.is_empty() {
            0.0
        } else {
            f64::from(lost.iter().sum::<f32>() / lost.len() as f32).min(1.0)
        };
        mix(&[
            (w, rule(corner, &before)),
            (1.0 - w, rule(less(corner), &after)),
        ])
    }

    pub fn refined(&self) -> Mesh {
        let opposite = self.opposite();
        let sharpness = |e: (usize, usize)| {
            let border = opposite[&e].len() != 2;
            let tagged = self.edges.get(&e).copied().unwrap_or(0.0);
            if border { 10.0 } else { tagged }
        };
        let mut rings: Vec<Vec<(usize, f32)>> = vec![Vec::new(); self.points.len()];
        let mut out = Mesh::default();
        let mut born = BTreeMap::new();
        for (i, (&e, across)) in opposite.iter().enumerate() {
            let s = sharpness(e);
            rings[e.0].push((e.1, s));
            rings[e.1].push((e.0, s));
            born.insert(e, self.points.len() + i);
            let (a, b) = (self.points[e.0], self.points[e.1]);
            let middle = mix(&[(0.5, a), (0.5, b)]);
            let smooth = || {
                let [c, d] = [across[0], across[1]].map(|v| self.points[v]);
                mix(&[(0.375, a), (0.375, b), (0.125, c), (0.125, d)])
            };
            out.points.push(match s {
                s if s > 1.0 => middle,
                s if s > 0.0 => mix(&[(f64::from(s), middle), (1.0 - f64::from(s), smooth())]),
                _ => smooth(),
            });
            for v in [e.0, e.1] {
                out.edges.insert((v, born[&e]), less(s));
            }
        }
        let mut points: Vec<Point> = (0..self.points.len())
            .map(|v| self.vertex(v, &rings[v]))
            .collect();
        points.append(&mut out.points);
        out.points = points;
        for &[a, b, c] in &self.triangles {
            let [x, y, z] = [(a, b), (b, c), (c, a)].map(|(p, q)| born[&key(p, q)]);
            out.triangles
                .extend([[a, x, z], [x, b, y], [z, y, c], [y, z, x]]);
        }
        out.corners = self.corners.iter().map(|(&v, &s)| (v, less(s))).collect();
        out
    }
}
