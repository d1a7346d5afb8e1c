//! What becomes of vertices under Loop's rules: limit points, limit normals, and the points of irregular vertices from step to step.
//!
//! A vertex depends on itself and on the mean of its ring, and these two follow a recursion of their own: the mean of the next ring is
//! 3/8 of the vertex and 5/8 of this mean. So a vertex of valence 50,000 costs each of its faces no more than one of valence 5.
//!
//! Tangents are left eigenvectors of the rules; for sides of four or more faces that is not the usual mask of a boundary.

use super::super::point::P4;
use super::super::vectors::{V3, add, are_parallel, cross, normal_of_ends, unit};
use super::ring::{is_regular, next, prev, rule};
use super::wide::{RING_FACES, WideFan};
use crate::topology::{Fan, FanRule, NONE, Ring, Topology};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Weight of each neighbour of a smooth vertex of valence `n` in one step.
pub(super) fn beta(n: u32) -> f64 {
    let n = f64::from(n);
    let c = match n {
        6.0 => 0.5,
        4.0 => 0.0,
        3.0 => -0.5,
        _ => libm::cos(2.0 * PI / n),
    };
    let a = 0.375 + 0.25 * c;
    (0.625 - a * a) / n
}

/// Tangent weights around a fan: (T1, T2) of every edge, of the vertex at the end.
pub(super) type Mask = Vec<[f64; 2]>;

/// Tangent masks of all kinds of fans of a mesh, by closedness and number of faces.
#[derive(Clone, Debug, Default)]
pub(crate) struct TriangleMasks(BTreeMap<(bool, u32), Mask>);

impl TriangleMasks {
    pub(crate) fn new(t: &Topology) -> Self {
        let mut masks = BTreeMap::new();
        for fan in t.fans() {
            if fan.first != NONE && rule(fan) != FanRule::Corner {
                masks.entry((fan.closed, fan.faces)).or_insert_with(|| {
                    if fan.closed {
                        interior_tangents(fan.faces)
                    } else {
                        side_tangents(fan.faces)
                    }
                });
            }
        }
        Self(masks)
    }
}

pub(super) fn interior_tangents(n: u32) -> Mask {
    let angle = |i: u32| 2.0 * PI * f64::from(i) / f64::from(n);
    let mut mask: Mask = (0..n)
        .map(|i| [libm::cos(angle(i)), libm::sin(angle(i))])
        .collect();
    mask.push([0.0; 2]);
    mask
}

/// Along the boundary, and across it into a side of `k` faces.
pub(super) fn side_tangents(k: u32) -> Mask {
    let n = k as usize;
    let mut mask = vec![[0.0; 2]; n + 2];
    mask[0][0] = 1.0;
    mask[n][0] = -1.0;
    if n == 1 {
        (mask[0][1], mask[1][1], mask[2][1]) = (1.0, 1.0, -2.0);
        return mask;
    }
    let angle = |i: usize| PI * i as f64 / f64::from(k);
    let lambda = 0.375 + 0.25 * libm::cos(angle(1));
    let mut sum = 0.0;
    for (i, w) in mask.iter_mut().enumerate().take(n).skip(1) {
        w[1] = libm::sin(angle(i));
        sum += w[1];
    }
    // The columns of the ends and of the vertex in "mask times matrix is lambda times mask":
    // (1/2 − λ) la + 1/8 lx = −1/8 le1,   la + (3/4 − λ) lx = −3/8 Σle.
    let (p, q) = (-0.125 * mask[1][1], -0.375 * sum);
    let (a11, a12, a21, a22) = (0.5 - lambda, 0.125, 1.0, 0.75 - lambda);
    let det = a11 * a22 - a12 * a21;
    let end = (p * a22 - a12 * q) / det;
    mask[0][1] = end;
    mask[n][1] = end;
    mask[n + 1][1] = (a11 * q - a21 * p) / det;
    mask
}

/// Refinement of a fan's control point, by the mean of its ring. Both are kept relative to the limit point: towards it rings shrink
/// (by four in every step at valence 3) until nothing of their shape would be left in the last bits of absolute coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Series {
    /// The limit point.
    pub(super) base: P4,
    point: P4,
    /// Mean of the ring; of the two ends of a crease.
    mean: P4,
    /// Weight of the mean in one step, and what the mean takes of the point.
    weights: [f32; 2],
}

impl Series {
    /// The control point after one more step, relative to the base; also advances the mean.
    #[inline]
    pub(super) fn step(&mut self) -> P4 {
        let [w, m] = self.weights;
        let point = self.point * (1.0 - w) + self.mean * w;
        self.mean = self.point * m + self.mean * (1.0 - m);
        self.point = point;
        point
    }
}

/// Limit points and normals of all fans, and the series of the irregular ones.
#[derive(Clone, Debug, Default)]
pub(crate) struct TriangleFans {
    pub(crate) limits: Vec<[f32; 3]>,
    /// Unit normals; empty for a face-varying channel.
    pub(crate) normals: Vec<[f32; 3]>,
    series: Vec<Series>,
    /// Per fan its place in `series`; [`NONE`] where regular.
    irregular: Vec<u32>,
    /// Fans of many faces, by number.
    wide: Vec<(u32, WideFan)>,
}

impl TriangleFans {
    pub(super) fn wide(&self, fan: u32) -> Option<&WideFan> {
        let at = self.wide.binary_search_by_key(&fan, |w| w.0).ok()?;
        Some(&self.wide[at].1)
    }

    pub(super) fn series(&self, fan: u32) -> Option<Series> {
        self.series
            .get(self.irregular[fan as usize] as usize)
            .copied()
    }

    /// Evaluates all fans of `t`, whose faces must be triangles, at `points` (by vertex). With `steps` the positions are the control
    /// points after so many refinements instead of limit points.
    pub(crate) fn new(
        t: &Topology,
        masks: &TriangleMasks,
        points: &[[f32; 3]],
        steps: Option<u32>,
        normals: bool,
    ) -> Self {
        let mut irregular = vec![NONE; t.fans().len()];
        let mut list = Vec::new();
        for (id, fan) in t.fans().iter().enumerate() {
            if fan.first != NONE && !is_regular(fan) {
                irregular[id] = list.len() as u32;
                list.push(id as u32);
            }
        }
        let mut out = Self {
            irregular,
            ..Self::default()
        };
        let wide = |fan: u32| {
            let kind = t.fans()[fan as usize];
            let mask = masks.0.get(&(kind.closed, kind.faces));
            (kind.faces > RING_FACES).then(|| (fan, WideFan::new(t, fan, points, mask)))
        };
        out.wide = list.iter().filter_map(|&fan| wide(fan)).collect();
        out.series = list
            .par_iter()
            .with_min_len(256)
            .map(|&fan| series(t, fan, points))
            .collect();
        let both: Vec<([f32; 3], [f32; 3])> = (0..t.fans().len() as u32)
            .into_par_iter()
            .with_min_len(1024)
            .map(|fan| evaluate(t, masks, points, fan, normals))
            .collect();
        out.limits = match steps {
            None => both.iter().map(|b| b.0).collect(),
            Some(n) => (0..t.fans().len() as u32)
                .into_par_iter()
                .with_min_len(1024)
                .map(|fan| refined(t, fan, points, n))
                .collect(),
        };
        if normals {
            out.normals = both.iter().map(|b| b.1).collect();
        }
        out
    }
}

/// Sums over a ring, relative to its vertex, in f64.
pub(super) struct RingSums {
    pub(super) edges: V3,
    pub(super) ends: [V3; 2],
    pub(super) tangents: [V3; 2],
    /// Sum of the cross products of neighbouring spokes: a normal when all else fails.
    area: V3,
}

pub(super) fn ring_sums(
    t: &Topology,
    fan: &Fan,
    points: &[[f32; 3]],
    mask: Option<&Mask>,
) -> RingSums {
    let origin = points[t.vertex(fan.first) as usize];
    let at = |h: u32| {
        let p = points[t.vertex(h) as usize];
        [0, 1, 2].map(|c| f64::from(p[c]) - f64::from(origin[c]))
    };
    let mut s = RingSums {
        edges: [0.0; 3],
        ends: [[0.0; 3]; 2],
        tangents: [[0.0; 3]; 2],
        area: [0.0; 3],
    };
    let weigh = |tangents: &mut [V3; 2], i: usize, e: V3| {
        if let Some(mask) = mask {
            for k in 0..2 {
                tangents[k] = add(tangents[k], e, mask[i][k]);
            }
        }
    };
    let mut sector = 0;
    for h in Ring::of_fan(t, t.fan(fan.first)) {
        let (e, after) = (at(next(h)), at(prev(h)));
        if sector == 0 {
            s.ends[0] = e;
        }
        s.edges = add(s.edges, e, 1.0);
        s.area = add(s.area, cross(e, after), 1.0);
        weigh(&mut s.tangents, sector, e);
        s.ends[1] = after;
        sector += 1;
    }
    if !fan.closed {
        let end = s.ends[1];
        s.edges = add(s.edges, end, 1.0);
        weigh(&mut s.tangents, sector, end);
    }
    s
}

/// The limit point less the vertex.
fn limit_offset(fan: &Fan, s: &RingSums) -> V3 {
    match rule(fan) {
        FanRule::Smooth => {
            let n = f64::from(fan.faces);
            s.edges.map(|c| c / (n + 0.375 / beta(fan.faces)))
        }
        FanRule::Crease => [0, 1, 2].map(|c| (s.ends[0][c] + s.ends[1][c]) / 6.0),
        FanRule::Corner => [0.0; 3],
    }
}

fn series(t: &Topology, id: u32, points: &[[f32; 3]]) -> Series {
    let fan = t.fans()[id as usize];
    let origin = points[t.fan_vertex(id) as usize].map(f64::from);
    let s = ring_sums(t, &fan, points, None);
    let base = add(origin, limit_offset(&fan, &s), 1.0).map(|c| c as f32);
    let place = |v: V3, k: f64| {
        P4::new([0, 1, 2].map(|c| (origin[c] - f64::from(base[c]) + v[c] * k) as f32))
    };
    let n = f64::from(fan.faces);
    let point = place([0.0; 3], 0.0);
    let (mean, weights) = match rule(&fan) {
        FanRule::Smooth => {
            let w = (n * beta(fan.faces)) as f32;
            (place(s.edges, 1.0 / n), [w, 0.375])
        }
        FanRule::Crease => (place(add(s.ends[0], s.ends[1], 1.0), 0.5), [0.25, 0.5]),
        FanRule::Corner => (point, [0.0, 0.0]),
    };
    Series {
        base: P4::new(base),
        point,
        mean,
        weights,
    }
}

fn refined(t: &Topology, id: u32, points: &[[f32; 3]], steps: u32) -> [f32; 3] {
    if t.fans()[id as usize].first == NONE || steps == 0 {
        return points[t.fan_vertex(id) as usize];
    }
    let mut s = series(t, id, points);
    let last = (0..steps).fold(P4::ZERO, |_, _| s.step());
    (s.base + last).xyz()
}

/// Whether the tangents of a fan that is no corner have one direction, or none: its normal is then that of its ring.
#[cfg(feature = "gpu")]
pub(crate) fn has_no_plane(
    t: &Topology,
    masks: &TriangleMasks,
    points: &[[f32; 3]],
    id: u32,
) -> bool {
    let fan = t.fans()[id as usize];
    let mask = masks.0.get(&(fan.closed, fan.faces));
    are_parallel(ring_sums(t, &fan, points, mask).tangents)
}

fn evaluate(
    t: &Topology,
    masks: &TriangleMasks,
    points: &[[f32; 3]],
    id: u32,
    normals: bool,
) -> ([f32; 3], [f32; 3]) {
    let fan = t.fans()[id as usize];
    let origin = points[t.fan_vertex(id) as usize];
    if fan.first == NONE {
        return (origin, [0.0, 0.0, 1.0]);
    }
    let rule = rule(&fan);
    let mask = match normals && rule != FanRule::Corner {
        true => masks.0.get(&(fan.closed, fan.faces)),
        false => None,
    };
    let s = ring_sums(t, &fan, points, mask);
    let offset = limit_offset(&fan, &s);
    let limit = [0, 1, 2].map(|c| (f64::from(origin[c]) + offset[c]) as f32);
    if !normals {
        return (limit, [0.0; 3]);
    }
    // The tangents of a corner are its two ends: from three faces on by convention, there being no tangent plane.
    let chosen = match rule {
        FanRule::Corner if !fan.closed => normal_of_ends(s.ends, s.area),
        FanRule::Corner => None,
        _ if are_parallel(s.tangents) => None,
        _ => unit(cross(s.tangents[0], s.tangents[1])),
    };
    let normal = chosen.or_else(|| unit(s.area)).unwrap_or([0.0, 0.0, 1.0]);
    (limit, normal.map(|c| c as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One step of the ring of a fan on weights: what the mask weighs after the step, in terms of the ring before.
    fn transposed(closed: bool, n: usize, mask: &[f64]) -> Vec<f64> {
        let edges = if closed { n } else { n + 1 };
        let mut out = vec![0.0; edges + 1];
        let x = edges;
        for i in 0..edges {
            let w = mask[i];
            if !closed && (i == 0 || i == n) {
                out[i] += 0.5 * w;
                out[x] += 0.5 * w;
            } else {
                out[i] += 0.375 * w;
                out[x] += 0.375 * w;
                out[(i + 1) % edges] += 0.125 * w;
                out[(i + edges - 1) % edges] += 0.125 * w;
            }
        }
        let w = mask[x];
        if closed {
            let b = beta(n as u32);
            out[x] += w * (1.0 - n as f64 * b);
            (0..n).for_each(|i| out[i] += w * b);
        } else {
            out[x] += 0.75 * w;
            out[0] += 0.125 * w;
            out[n] += 0.125 * w;
        }
        out
    }

    #[test]
    fn masks_are_left_eigenvectors() {
        let check = |closed: bool, n: usize, mask: Vec<f64>, lambda: f64, sum: f64| {
            let after = transposed(closed, n, &mask);
            for (a, m) in after.iter().zip(&mask) {
                assert!(
                    (a - lambda * m).abs() < 1e-12,
                    "{closed} {n}: {mask:?} {after:?}"
                );
            }
            assert!(
                (mask.iter().sum::<f64>() - sum).abs() < 1e-11,
                "{closed} {n}"
            );
        };
        for n in 2..=40_u32 {
            let theta = 2.0 * PI / f64::from(n);
            let column = |m: &Mask, k: usize| m.iter().map(|w| w[k]).collect::<Vec<f64>>();
            for k in 0..2 {
                let lambda = 0.375 + 0.25 * theta.cos();
                let mask = column(&interior_tangents(n), k);
                check(true, n as usize, mask, lambda, 0.0);
            }
            let w = 1.0 / (f64::from(n) + 0.375 / beta(n));
            let mut limit = vec![w; n as usize + 1];
            limit[n as usize] = 1.0 - f64::from(n) * w;
            check(true, n as usize, limit, 1.0, 1.0);
            let side = side_tangents(n);
            check(false, n as usize, column(&side, 0), 0.5, 0.0);
            let lambda = 0.375 + 0.25 * (0.5 * theta).cos();
            check(false, n as usize, column(&side, 1), lambda, 0.0);
        }
        let one = side_tangents(1);
        check(false, 1, one.iter().map(|w| w[1]).collect(), 0.25, 0.0);
    }

    #[test]
    fn regular_boundary_has_the_tangent_of_the_box_spline() {
        // Three faces: √3 (e1 + e2 − x) − √3/2 (a + b).
        let side = side_tangents(3);
        let scale = side[1][1];
        for (w, want) in side.iter().zip([-0.5, 1.0, 1.0, -0.5, -1.0]) {
            assert!((w[1] / scale - want).abs() < 1e-12, "{side:?}");
        }
    }
}
