//! The whole ring around one corner of a quad in double precision, and its refinement.
//!
//! Unlike a [`Window`](crate::dice::window) it keeps all sectors of a fan (up to a number; beyond, a window wide enough for the deepest
//! step), so it can be refined as often as a parameter asks for. Points are moved so that the vertex' limit is the origin: refinement
//! then shrinks everything, and what lies 2⁻⁴⁰ from the vertex is as exact as what lies far.

use super::MAX_DEPTH;
use crate::dice::face::Channel;
use crate::dice::fan_points::RING_FACES;
use crate::dice::point::{D4, Point};
use crate::dice::tangent_masks::TangentMask;
use crate::dice::vectors::V3;
use crate::dice::window::{Around, edge_point, face_point};
use crate::scheme::by_valence::ByValence;
use crate::topology::{Fan, FanRule, NONE};
use std::sync::LazyLock;

/// A vertex with its ring. Sector 0 belongs to the quad that asked.
#[derive(Clone, Debug, Default)]
pub(super) struct Ring {
    /// e, f, e, f, … from sector `first` on; one more e at the end unless closed.
    spokes: Vec<D4>,
    first: i32,
    /// Sectors to either side that are valid; of a closed ring, all.
    left: i32,
    right: i32,
    closed: bool,
    /// Whether the fan ends there.
    open: [bool; 2],
    v: D4,
    /// Means of edge and face neighbours of a smooth fan; of a crease, of its two ends.
    edges: D4,
    faces: D4,
    fan: Option<Fan>,
}

impl Ring {
    /// Gathers the ring of half-edge `h`'s vertex, in a mesh of quads.
    pub(super) fn gather(&mut self, channel: Channel<'_>, h: u32) {
        let t = channel.topology;
        let (twins, vertices) = (&t.twins[..], &t.corner_vertices[..]);
        let at = |g: u32| D4::wide(channel.points[vertices[g as usize] as usize]);
        let next = |g: u32| (g & !3) | ((g + 1) & 3);
        let prev = |g: u32| (g & !3) | ((g + 3) & 3);
        let id = t.fan(h);
        let fan = t.fans()[id as usize];
        self.fan = Some(fan);
        self.spokes.clear();
        self.v = at(h);
        let wide = fan.faces > RING_FACES;
        let reach = if wide {
            MAX_DEPTH as i32 + 3
        } else {
            fan.faces as i32
        };
        self.closed = fan.closed && !wide;
        self.open = [false; 2];
        let (mut start, mut left) = (h, 0);
        if !self.closed {
            while left < reach {
                let twin = twins[start as usize];
                if twin == NONE {
                    self.open[0] = true;
                    break;
                }
                (start, left) = (next(twin), left + 1);
            }
        }
        (self.first, self.left) = (-left, left);
        let (mut g, mut i) = (start, -left);
        let last = if self.closed { reach - 1 } else { reach };
        loop {
            self.spokes.push(at(next(g)));
            self.spokes.push(at(g ^ 2));
            if i == last {
                break;
            }
            let twin = twins[prev(g) as usize];
            if twin == NONE {
                self.open[1] = true;
                break;
            }
            (g, i) = (twin, i + 1);
        }
        self.right = i;
        if !self.closed {
            self.spokes.push(at(prev(g)));
        }
        self.set_means(channel, id, wide);
    }

    fn set_means(&mut self, channel: Channel<'_>, id: u32, wide: bool) {
        if let (true, Some(wide)) = (wide, channel.fans.wide(id)) {
            self.edges = self.v + D4::new(wide.edges);
            self.faces = self.v + D4::new(wide.faces);
        } else if self.closed {
            let (mut edges, mut faces) = (D4::ZERO, D4::ZERO);
            for s in self.spokes.chunks_exact(2) {
                edges = edges + s[0];
                faces = faces + s[1];
            }
            let inverse = 2.0 / self.spokes.len() as f64;
            (self.edges, self.faces) = (edges.times(inverse), faces.times(inverse));
        } else {
            let ends = self.spokes[0] + self.spokes[self.spokes.len() - 1];
            (self.edges, self.faces) = (ends * 0.5, ends * 0.5);
        }
    }

    fn rule(&self) -> FanRule {
        self.fan.map_or(FanRule::Corner, |f| f.rule)
    }

    #[inline]
    fn place(&self, i: i32) -> usize {
        let mut k = i - self.first;
        if self.closed {
            // Not by a remainder: divisions are slow, and this is seldom more than one turn.
            let n = self.right + 1;
            while k < 0 {
                k += n;
            }
            while k >= n {
                k -= n;
            }
        }
        debug_assert!(k >= 0);
        2 * k as usize
    }

    /// Where the vertex ends up.
    pub(super) fn limit(&self) -> D4 {
        match self.fan {
            Some(fan) if fan.rule == FanRule::Smooth => {
                smooth_limit(f64::from(fan.faces), self.v, self.edges, self.faces)
            }
            Some(fan) if fan.rule == FanRule::Crease => {
                self.v + (self.edges - self.v).times(1.0 / 3.0)
            }
            _ => self.v,
        }
    }

    /// Moves the origin.
    pub(super) fn shift(&mut self, origin: D4) {
        for p in &mut self.spokes {
            *p = *p - origin;
        }
        self.v = self.v - origin;
        self.edges = self.edges - origin;
        self.faces = self.faces - origin;
    }

    /// What the vertex becomes; advances the means.
    fn step_vertex(&mut self) -> D4 {
        match self.rule() {
            FanRule::Corner => self.v,
            FanRule::Crease => {
                let next = self.v * 0.75 + self.edges * 0.25;
                self.edges = (self.v + self.edges) * 0.5;
                next
            }
            FanRule::Smooth => {
                let n = f64::from(self.fan.map_or(4, |f| f.faces));
                next_vertex(n, self.v, &mut self.edges, &mut self.faces)
            }
        }
    }

    /// One step of refinement.
    pub(super) fn step(&mut self) {
        let v = self.v;
        let next = self.step_vertex();
        let s = &mut self.spokes[..];
        let n = s.len();
        if self.closed {
            step_closed(v, s);
        } else {
            for k in (0..n - 1).step_by(2) {
                s[k + 1] = face_point(v, s[k], s[k + 1], s[k + 2]);
            }
            for k in (2..n - 1).step_by(2) {
                s[k] = edge_point(v, s[k], s[k - 1], s[k + 1]);
            }
            // Edges at a cut through the fan are lost: their places hold finite but meaningless points.
            for (end, k) in [(0, 0), (1, n - 1)] {
                if self.open[end] {
                    s[k] = (v + s[k]) * 0.5;
                }
            }
            self.left -= i32::from(!self.open[0]);
            self.right -= i32::from(!self.open[1]);
        }
        self.v = next;
    }

    /// Tangents along the two sides of the own quad at an irregular vertex: those of the flat star that the ring is closest to. Of a
    /// corner, the sides themselves.
    pub(super) fn tangents(&self, channel: Channel<'_>, h: u32) -> [D4; 2] {
        let Some(fan) = self.fan else {
            return [D4::ZERO; 2];
        };
        if fan.rule == FanRule::Corner {
            return [self.e(0) - self.v, self.e(1) - self.v];
        }
        let id = channel.topology.fan(h);
        let wide = channel.fans.wide(id);
        let (stars, place) = match wide {
            Some(wide) => {
                let at = wide.places.binary_search_by_key(&h, |p| p.0);
                let place = at.map_or(0, |at| wide.places[at].1);
                (wide.tangents, f64::from(place))
            }
            // A closed ring is counted from the own sector on.
            None => (self.star(fan), f64::from(-self.first)),
        };
        if fan.closed && fan.faces == 2 {
            let along = D4::new(stars[0]);
            return [along, along * -1.0];
        }
        let turn = if fan.closed { 2.0 } else { 1.0 } * std::f64::consts::PI / f64::from(fan.faces);
        [place, place + 1.0].map(|i| {
            let (cos, sin) = (libm::cos(turn * i), libm::sin(turn * i));
            D4::new(stars[0]).times(cos) + D4::new(stars[1]).times(sin)
        })
    }

    fn star(&self, fan: Fan) -> [V3; 2] {
        static MASKS: [LazyLock<ByValence<TangentMask>>; 2] = [
            LazyLock::new(|| ByValence::new(|n| TangentMask::of(false, n))),
            LazyLock::new(|| ByValence::new(|n| TangentMask::of(true, n))),
        ];
        MASKS[usize::from(fan.closed)].with(fan.faces, |mask| {
            let scales = mask.scales(fan.closed);
            [0, 1].map(|k| {
                let mut sum = D4::ZERO;
                for (p, w) in self.spokes.iter().zip(&mask.weights) {
                    sum = sum + (*p - self.v).times(w[k]);
                }
                let sum = sum.times(scales[k]).0;
                [sum[0], sum[1], sum[2]]
            })
        })
    }
}

/// Where a smooth vertex of `n` faces ends up; `edges` and `faces` are the means of its edge and face neighbours.
#[inline(always)]
pub(super) fn smooth_limit(n: f64, v: D4, edges: D4, faces: D4) -> D4 {
    (v.times(n) + edges.times(4.0) + faces).times(1.0 / (n + 5.0))
}

/// What a smooth vertex of `n` faces becomes in one step; advances the means.
#[inline(always)]
pub(super) fn next_vertex(n: f64, v: D4, edges: &mut D4, faces: &mut D4) -> D4 {
    let next_faces = ((v + *faces) + (*edges + *edges)) * 0.25;
    let next = (v.times(n - 2.0) + (*edges + next_faces)).times(1.0 / n);
    *edges = ((v + *edges) + (next_faces + next_faces)) * 0.25;
    *faces = next_faces;
    next
}

/// One step of the closed ring e, f, e, f, … around `v`.
#[inline(always)]
pub(super) fn step_closed(v: D4, s: &mut [D4]) {
    let (n, Some(&first)) = (s.len(), s.first()) else {
        return;
    };
    for k in (0..n).step_by(2) {
        let after = if k + 2 < n { s[k + 2] } else { first };
        s[k + 1] = face_point(v, s[k], s[k + 1], after);
    }
    let mut before = s[n - 1];
    for k in (0..n).step_by(2) {
        s[k] = edge_point(v, s[k], before, s[k + 1]);
        before = s[k + 1];
    }
}

impl Around<D4> for Ring {
    #[inline(always)]
    fn v(&self) -> D4 {
        self.v
    }
    #[inline(always)]
    fn e(&self, i: i32) -> D4 {
        self.spokes[self.place(i)]
    }
    #[inline(always)]
    fn f(&self, i: i32) -> D4 {
        self.spokes[self.place(i) + 1]
    }
    #[inline(always)]
    fn has(&self, i: i32) -> bool {
        self.closed || (-self.left <= i && i <= self.right)
    }
}
