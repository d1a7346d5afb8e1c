//! What every fan contributes to the faces around it, once per frame: its limit point and unit normal, and what its control point
//! becomes under refinement.
//!
//! The control point of a fan of any valence n follows a recursion of three means: of itself, of its edge neighbours and of its face
//! neighbours. So a vertex of valence 50,000 costs its faces no more than one of valence 5. Memory is proportional to the cage.
//!
//! Masks: Halstead, Kass, DeRose, *Efficient, fair interpolation using Catmull-Clark surfaces*, 1993, for the interior; the second
//! tangent of a boundary is the exact left eigenvector of its rule, which for three or more faces differs from the usual one.

use super::point::P4;
use crate::topology::{Fan, FanRule, NONE, Ring, Topology};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Tangent weights around a fan of one kind, made once per topology.
#[derive(Clone, Debug)]
pub(crate) struct TangentMask {
    /// (T1, T2) weights of e0, f0, e1, f1, …; of the vertex at the end.
    pub(super) weights: Vec<[f64; 2]>,
}

impl TangentMask {
    /// The mask of a fan of `faces` faces.
    pub(super) fn of(closed: bool, faces: u32) -> Self {
        if closed {
            interior_tangents(faces)
        } else {
            boundary_tangents(faces)
        }
    }

    /// Factors that make the two tangents those of the flat star which the ring is closest to: spokes of unit length at equal angles
    /// give unit vectors. These are left times right eigenvectors; a right one is the mask with its edge weights divided by 4.
    pub(super) fn scales(&self, closed: bool) -> [f64; 2] {
        // Opposite spokes: the mask is ±1 there, and so is the star. The same along a boundary.
        if closed && self.weights.len() == 5 {
            return [0.5, 0.5];
        }
        let last = self.weights.len() - 2;
        let product = |k: usize| {
            let mut sum = 0.0;
            for (i, w) in self.weights[..=last].iter().enumerate() {
                // The ends of a boundary do not move in the second mode.
                if closed || (i > 0 && i < last) {
                    sum += w[k] * w[k] * if i % 2 == 0 { 0.25 } else { 1.0 };
                }
            }
            if sum > 0.0 { 1.0 / sum } else { 0.0 }
        };
        if closed {
            [product(0), product(1)]
        } else {
            [0.5, product(1)]
        }
    }
}

/// Tangent masks of all kinds of irregular fans of a mesh.
#[derive(Clone, Debug, Default)]
pub(crate) struct TangentMasks(BTreeMap<(bool, u32), TangentMask>);

impl TangentMasks {
    pub(crate) fn new(t: &Topology) -> Self {
        let mut masks = BTreeMap::new();
        for fan in t.fans() {
            if fan.first != NONE && fan.rule != FanRule::Corner {
                masks
                    .entry((fan.closed, fan.faces))
                    .or_insert_with(|| TangentMask::of(fan.closed, fan.faces));
            }
        }
        Self(masks)
    }
}

/// Subdominant eigenvalue of the sector angle `cos`, `cos_half`, and the weight of face points against edge points.
fn eigen(cos: f64, cos_half: f64) -> (f64, f64) {
    let lambda = 5.0 / 16.0 + (cos + cos_half * (2.0 * (9.0 + cos)).sqrt()) / 16.0;
    (lambda, 1.0 / (4.0 * lambda - 1.0))
}

fn interior_tangents(n: u32) -> TangentMask {
    if n == 2 {
        // The tangents of the valence-2 rule are the differences across; see the limits of valence 2 in the crate documentation.
        return TangentMask {
            weights: vec![[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0], [0.0, 0.0]],
        };
    }
    let angle = |i: f64| 2.0 * std::f64::consts::PI * i / f64::from(n);
    let (_, c) = eigen(libm::cos(angle(1.0)), libm::cos(angle(0.5)));
    let mut weights = Vec::with_capacity(2 * n as usize + 1);
    for i in 0..n {
        let (a, b) = (angle(f64::from(i)), angle(f64::from(i + 1)));
        weights.push([4.0 * libm::cos(a), 4.0 * libm::sin(a)]);
        weights.push([
            c * (libm::cos(a) + libm::cos(b)),
            c * (libm::sin(a) + libm::sin(b)),
        ]);
    }
    weights.push([0.0; 2]);
    TangentMask { weights }
}

fn boundary_tangents(k: u32) -> TangentMask {
    let n = k as usize;
    let mut weights = vec![[0.0; 2]; 2 * n + 2];
    weights[0][0] = 1.0;
    weights[2 * n][0] = -1.0;
    if n == 1 {
        weights[0][1] = 1.0;
        weights[2][1] = 1.0;
        weights[3][1] = -2.0;
        return TangentMask { weights };
    }
    let angle = |i: f64| std::f64::consts::PI * i / f64::from(k);
    let (lambda, c) = eigen(libm::cos(angle(1.0)), libm::cos(angle(0.5)));
    let (mut edges, mut faces) = (0.0, 0.0);
    for i in 0..n {
        let (a, b) = (angle(i as f64), angle((i + 1) as f64));
        if i > 0 {
            weights[2 * i][1] = 4.0 * libm::sin(a);
            edges += weights[2 * i][1];
        }
        weights[2 * i + 1][1] = c * (libm::sin(a) + libm::sin(b));
        faces += weights[2 * i + 1][1];
    }
    // Weights of the two boundary edges and of the vertex from the eigenvector equations of the crease rule:
    // (1/2 − λ) la + 1/8 lx = −(1/4 lf0 + 1/16 le1),   la + (3/4 − λ) lx = −(3/8 Σle + 1/4 Σlf).
    let (p, q) = (
        -(0.25 * weights[1][1] + weights[2][1] / 16.0),
        -(0.375 * edges + 0.25 * faces),
    );
    let (a11, a12, a21, a22) = (0.5 - lambda, 0.125, 1.0, 0.75 - lambda);
    let det = a11 * a22 - a12 * a21;
    let la = (p * a22 - a12 * q) / det;
    weights[0][1] = la;
    weights[2 * n][1] = la;
    weights[2 * n + 1][1] = (a11 * q - a21 * p) / det;
    TangentMask { weights }
}

/// Refinement of a fan's control point, by means of its ring.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FanSeries {
    point: P4,
    edges: P4,
    faces: P4,
    /// Number of faces of a closed fan, 0 for a crease, −1 for a corner.
    kind: i32,
}

impl FanSeries {
    /// The control point after one more step; also advances the means.
    #[inline]
    pub(crate) fn step(&mut self) -> P4 {
        match self.kind {
            -1 => {}
            0 => {
                let next = self.point * 0.75 + self.edges * 0.25;
                self.edges = (self.point + self.edges) * 0.5;
                self.point = next;
            }
            n => {
                let faces = ((self.point + self.faces) + (self.edges + self.edges)) * 0.25;
                let inverse = 1.0 / n as f32;
                let next = self.point * ((n - 2) as f32 * inverse) + (self.edges + faces) * inverse;
                self.edges = ((self.point + self.edges) + (faces + faces)) * 0.25;
                self.faces = faces;
                self.point = next;
            }
        }
        self.point
    }
}

/// Limit points and normals of all fans, and the means of the irregular ones.
#[derive(Clone, Debug, Default)]
pub(crate) struct FanPoints {
    pub(crate) limits: Vec<[f32; 3]>,
    /// Unit normals; empty for a face-varying channel.
    pub(crate) normals: Vec<[f32; 3]>,
    series: Vec<FanSeries>,
    /// Per fan its place in `series`; [`NONE`] where regular. Depends on topology alone.
    irregular: Vec<u32>,
    /// The fans of so many faces that nobody should walk their ring more than once per frame, by number.
    wide: Vec<(u32, WideFan)>,
}

/// Most faces of a fan whose whole ring is gathered for evaluation.
pub(super) const RING_FACES: u32 = 64;

/// What evaluation near a vertex of many faces needs of its whole ring; relative to the vertex.
#[derive(Clone, Debug)]
pub(super) struct WideFan {
    /// Means of the edge and the face neighbours; for an open fan the mean of its two ends.
    pub(super) edges: V3,
    pub(super) faces: V3,
    /// Tangents of the flat star, along the first spoke and a quarter turn on.
    pub(super) tangents: [V3; 2],
    /// Half-edges out of the vertex, sorted, with their places in the ring.
    pub(super) places: Vec<(u32, u32)>,
}

impl FanPoints {
    pub(super) fn wide(&self, fan: u32) -> Option<&WideFan> {
        let at = self.wide.binary_search_by_key(&fan, |w| w.0).ok()?;
        Some(&self.wide[at].1)
    }

    pub(crate) fn series(&self, fan: u32) -> Option<FanSeries> {
        self.series
            .get(self.irregular[fan as usize] as usize)
            .copied()
    }

    /// Evaluates all fans of `t` at `points` (by vertex).
    ///
    /// With `steps` the positions are the control points after so many refinements instead of limit points.
    pub(crate) fn new(
        t: &Topology,
        masks: &TangentMasks,
        points: &[[f32; 3]],
        steps: Option<u32>,
        normals: bool,
    ) -> Self {
        let mut irregular = vec![NONE; t.fans().len()];
        let mut list = Vec::new();
        for (id, fan) in t.fans().iter().enumerate() {
            if fan.first != NONE && !fan.is_regular() {
                irregular[id] = list.len() as u32;
                list.push(id as u32);
            }
        }
        let mut out = Self {
            irregular,
            ..Self::default()
        };
        out.wide = list
            .iter()
            .filter(|&&fan| t.fans()[fan as usize].faces > RING_FACES)
            .map(|&fan| (fan, wide_fan(t, fan, points)))
            .collect();
        out.series = list
            .par_iter()
            .with_min_len(256)
            .map(|&fan| series(t, fan, points))
            .collect();
        let evaluate = |fan: usize| evaluate_fan(t, masks, points, fan as u32, normals);
        let both: Vec<([f32; 3], [f32; 3])> = (0..t.fans().len())
            .into_par_iter()
            .with_min_len(1024)
            .map(evaluate)
            .collect();
        out.limits = match steps {
            None => both.iter().map(|b| b.0).collect(),
            Some(n) => (0..t.fans().len() as u32)
                .into_par_iter()
                .map(|fan| refined_fan(t, fan, points, n))
                .collect(),
        };
        if normals {
            out.normals = both.iter().map(|b| b.1).collect();
        }
        out
    }
}

pub(super) type V3 = [f64; 3];

fn add(a: V3, b: V3, k: f64) -> V3 {
    [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]]
}
fn cross(a: V3, b: V3) -> V3 {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
fn unit(a: V3) -> Option<V3> {
    let m = a[0].abs().max(a[1].abs()).max(a[2].abs());
    if !(m > 0.0 && m.is_finite()) {
        return None;
    }
    let s = [a[0] / m, a[1] / m, a[2] / m];
    let l = (s[0] * s[0] + s[1] * s[1] + s[2] * s[2]).sqrt();
    Some([s[0] / l, s[1] / l, s[2] / l])
}

/// Sums over a ring, relative to its vertex, in f64: means of edge and face neighbours, ends of an open ring.
struct RingSums {
    edges: V3,
    faces: V3,
    ends: [V3; 2],
    tangents: [V3; 2],
}

fn ring_sums(t: &Topology, fan: &Fan, points: &[[f32; 3]], mask: Option<&TangentMask>) -> RingSums {
    let origin = points[t.vertex(fan.first) as usize];
    let at = |h: u32| {
        let p = points[t.vertex(h) as usize];
        [
            f64::from(p[0]) - f64::from(origin[0]),
            f64::from(p[1]) - f64::from(origin[1]),
            f64::from(p[2]) - f64::from(origin[2]),
        ]
    };
    let zero = [0.0; 3];
    let mut s = RingSums {
        edges: zero,
        faces: zero,
        ends: [zero; 2],
        tangents: [zero; 2],
    };
    let weights = mask.map_or(&[][..], |m| &m.weights[..]);
    let weight = |i: usize| weights.get(i).copied().unwrap_or([0.0; 2]);
    let (mut sector, mut last) = (0, fan.first);
    for h in Ring::of_fan(t, t.fan(fan.first)) {
        let next = t.next(h);
        let (e, f) = (at(next), at(t.next(next)));
        if sector == 0 {
            s.ends[0] = e;
        }
        s.edges = add(s.edges, e, 1.0);
        s.faces = add(s.faces, f, 1.0);
        let (we, wf) = (weight(2 * sector), weight(2 * sector + 1));
        for k in 0..2 {
            s.tangents[k] = add(add(s.tangents[k], e, we[k]), f, wf[k]);
        }
        sector += 1;
        last = h;
    }
    s.ends[1] = at(t.prev(last));
    if !fan.closed {
        let we = weight(2 * sector);
        for k in 0..2 {
            s.tangents[k] = add(s.tangents[k], s.ends[1], we[k]);
        }
    }
    s
}

/// Sum of the cross products of neighbouring spokes: a normal when all else fails.
fn ring_area(t: &Topology, fan: &Fan, points: &[[f32; 3]]) -> V3 {
    let origin = points[t.vertex(fan.first) as usize].map(f64::from);
    let at = |h: u32| {
        let p = points[t.vertex(h) as usize].map(f64::from);
        [p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]]
    };
    Ring::of_fan(t, t.fan(fan.first)).fold([0.0; 3], |area, h| {
        add(area, cross(at(t.next(h)), at(t.prev(h))), 1.0)
    })
}

fn series(t: &Topology, id: u32, points: &[[f32; 3]]) -> FanSeries {
    let fan = t.fans()[id as usize];
    let origin = points[t.fan_vertex(id) as usize];
    let s = ring_sums(t, &fan, points, None);
    let n = f64::from(fan.faces);
    let place = |v: V3, k: f64| {
        P4::new(std::array::from_fn(|c| {
            (f64::from(origin[c]) + v[c] * k) as f32
        }))
    };
    let point = P4::new(origin);
    match fan.rule {
        FanRule::Smooth => FanSeries {
            point,
            edges: place(s.edges, 1.0 / n),
            faces: place(s.faces, 1.0 / n),
            kind: fan.faces as i32,
        },
        FanRule::Crease => {
            let mean = place(add(s.ends[0], s.ends[1], 1.0), 0.5);
            FanSeries {
                point,
                edges: mean,
                faces: mean,
                kind: 0,
            }
        }
        FanRule::Corner => FanSeries {
            point,
            edges: point,
            faces: point,
            kind: -1,
        },
    }
}

fn wide_fan(t: &Topology, id: u32, points: &[[f32; 3]]) -> WideFan {
    let fan = t.fans()[id as usize];
    let mask = TangentMask::of(fan.closed, fan.faces);
    let s = ring_sums(t, &fan, points, Some(&mask));
    let scales = mask.scales(fan.closed);
    let zero = [0.0; 3];
    let n = f64::from(fan.faces);
    let mut places: Vec<(u32, u32)> = Ring::of_fan(t, id).zip(0..).collect();
    places.sort_unstable();
    WideFan {
        edges: if fan.closed {
            add(zero, s.edges, 1.0 / n)
        } else {
            add(add(zero, s.ends[0], 0.5), s.ends[1], 0.5)
        },
        faces: add(zero, s.faces, 1.0 / n),
        tangents: [0, 1].map(|k| add(zero, s.tangents[k], scales[k])),
        places,
    }
}

/// What the point of a fan becomes in one step of a mesh of any polygons; `faces` are its new face points.
pub(crate) fn step_fan(t: &Topology, id: u32, points: &[[f32; 3]], faces: &[[f32; 3]]) -> [f32; 3] {
    let fan = t.fans()[id as usize];
    let v = points[t.fan_vertex(id) as usize];
    if fan.first == NONE || fan.rule == FanRule::Corner {
        return v;
    }
    let wide = |p: [f32; 3]| p.map(f64::from);
    let at = |h: u32| wide(points[t.vertex(h) as usize]);
    let v = wide(v);
    let mut sum = [0.0; 3];
    if fan.closed {
        for h in Ring::of_fan(t, id) {
            sum = add(
                sum,
                add(at(t.next(h)), wide(faces[t.face_of(h) as usize]), 1.0),
                1.0,
            );
        }
        let n = f64::from(fan.faces);
        return std::array::from_fn(|c| (((n - 2.0) * v[c] + sum[c] / n) / n) as f32);
    }
    let last = Ring::of_fan(t, id).last().unwrap_or(fan.first);
    let ends = add(at(t.next(fan.first)), at(t.prev(last)), 1.0);
    std::array::from_fn(|c| (0.75 * v[c] + 0.125 * ends[c]) as f32)
}

fn refined_fan(t: &Topology, id: u32, points: &[[f32; 3]], steps: u32) -> [f32; 3] {
    if t.fans()[id as usize].first == NONE || steps == 0 {
        return points[t.fan_vertex(id) as usize];
    }
    let mut s = series(t, id, points);
    (0..steps).fold(P4::ZERO, |_, _| s.step()).xyz()
}

fn evaluate_fan(
    t: &Topology,
    masks: &TangentMasks,
    points: &[[f32; 3]],
    id: u32,
    normals: bool,
) -> ([f32; 3], [f32; 3]) {
    let fan = t.fans()[id as usize];
    let origin = points[t.fan_vertex(id) as usize];
    if fan.first == NONE {
        return (origin, [0.0, 0.0, 1.0]);
    }
    let mask = if normals {
        masks.0.get(&(fan.closed, fan.faces))
    } else {
        None
    };
    let s = ring_sums(
        t,
        &fan,
        points,
        if fan.rule == FanRule::Corner {
            None
        } else {
            mask
        },
    );
    let n = f64::from(fan.faces);
    let offset = match fan.rule {
        // Limit of the smooth rule: weights n/(n+5), 4/(n(n+5)), 1/(n(n+5)).
        FanRule::Smooth => {
            std::array::from_fn(|c| (4.0 * s.edges[c] + s.faces[c]) / (n * (n + 5.0)))
        }
        FanRule::Crease => std::array::from_fn(|c| (s.ends[0][c] + s.ends[1][c]) / 6.0),
        FanRule::Corner => [0.0; 3],
    };
    let limit = std::array::from_fn(|c| (f64::from(origin[c]) + offset[c]) as f32);
    if !normals {
        return (limit, [0.0; 3]);
    }
    let normal = match fan.rule {
        FanRule::Corner if fan.faces == 1 => cross(s.ends[0], s.ends[1]),
        FanRule::Corner => ring_area(t, &fan, points),
        _ => cross(s.tangents[0], s.tangents[1]),
    };
    // Tangents that cancel to rounding have no direction: compare with the size of what was summed.
    let size = |v: V3| v[0].abs().max(v[1].abs()).max(v[2].abs());
    let scale = size(s.tangents[0]) * size(s.tangents[1]);
    let flat = fan.rule != FanRule::Corner && size(normal) <= 1e-10 * scale;
    let chosen = if flat { None } else { unit(normal) };
    let n = chosen
        .or_else(|| unit(ring_area(t, &fan, points)))
        .unwrap_or([0.0, 0.0, 1.0]);
    (limit, std::array::from_fn(|c| n[c] as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tangent_weights_sum_to_zero() {
        for n in 2..=64 {
            for mask in [interior_tangents(n), boundary_tangents(n)] {
                for k in 0..2 {
                    let sum: f64 = mask.weights.iter().map(|w| w[k]).sum();
                    let size: f64 = mask.weights.iter().map(|w| w[k].abs()).sum();
                    assert!(sum.abs() <= 1e-12 * size, "{n} {k}: {sum}");
                }
            }
        }
    }

    #[test]
    fn tangents_of_a_flat_star_are_its_spokes() {
        for n in 3..=40 {
            for closed in [true, false] {
                let mask = TangentMask::of(closed, n);
                let scales = mask.scales(closed);
                let turn = if closed { 2.0 } else { 1.0 } * std::f64::consts::PI / f64::from(n);
                // Along the first spoke and across, of the right eigenvector.
                let c = mask.weights[1][1] / libm::sin(turn);
                let mut sums = [[0.0; 2]; 2];
                for (i, w) in mask.weights[..mask.weights.len() - 1].iter().enumerate() {
                    let (a, b) = (turn * (i / 2) as f64, turn * (i / 2 + 1) as f64);
                    let p = if i % 2 == 0 {
                        [libm::cos(a), libm::sin(a)]
                    } else {
                        [libm::cos(a) + libm::cos(b), libm::sin(a) + libm::sin(b)].map(|x| c * x)
                    };
                    for k in 0..2 {
                        for j in 0..2 {
                            sums[k][j] += w[k] * scales[k] * p[j];
                        }
                    }
                }
                assert!((sums[1][1] - 1.0).abs() < 1e-12, "{closed} {n} {sums:?}");
                assert!((sums[0][0] - 1.0).abs() < 1e-12, "{closed} {n} {sums:?}");
                assert!(sums[0][1].abs() < 1e-12, "{closed} {n} {sums:?}");
            }
        }
    }

    #[test]
    fn boundary_with_two_faces_has_the_bspline_tangent() {
        // Known mask of the regular boundary: x −4, a and b −1, e1 4, f 1 each, up to a factor.
        let w = boundary_tangents(2).weights;
        let k = w[1][1];
        let got: Vec<f64> = w.iter().map(|w| w[1] / k).collect();
        for (g, want) in got.iter().zip([-1.0, 1.0, 4.0, 1.0, -1.0, -4.0]) {
            assert!((g - want).abs() < 1e-12, "{got:?}");
        }
    }
}
