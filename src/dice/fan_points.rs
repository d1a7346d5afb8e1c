//! What every fan contributes to the faces around it, once per frame: its limit point and unit normal, and what its control point
//! becomes under refinement.
//!
//! The control point of a fan of any valence n follows a recursion of three means: of itself, of its edge neighbours and of its face
//! neighbours. So a vertex of valence 50,000 costs its faces no more than one of valence 5. Memory is proportional to the cage.

use super::point::P4;
use super::tangent_masks::{TangentMask, TangentMasks};
use super::vectors::{V3, add, are_parallel, cross, normal_of_ends, unit};
use crate::topology::{Fan, FanRule, NONE, Ring, Topology};
use rayon::prelude::*;

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

/// Whether the tangents of a fan that is no corner have one direction, or none: its normal is then that of its ring.
#[cfg(feature = "gpu")]
pub(crate) fn has_no_plane(
    t: &Topology,
    masks: &TangentMasks,
    points: &[[f32; 3]],
    id: u32,
) -> bool {
    let fan = t.fans()[id as usize];
    are_parallel(ring_sums(t, &fan, points, masks.of(&fan)).tangents)
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
    let mask = if normals { masks.of(&fan) } else { None };
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
    let area = || ring_area(t, &fan, points);
    let chosen = match fan.rule {
        FanRule::Corner => normal_of_ends(s.ends, area()),
        _ if are_parallel(s.tangents) => None,
        _ => unit(cross(s.tangents[0], s.tangents[1])),
    };
    let n = chosen.or_else(|| unit(area())).unwrap_or([0.0, 0.0, 1.0]);
    (limit, std::array::from_fn(|c| n[c] as f32))
}
