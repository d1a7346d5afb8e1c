//! The whole ring around one corner of a triangle in double precision, and its refinement: twin of the one for quads.
//!
//! All edges of a fan up to a number of faces; beyond, a window wide enough for the deepest step. Points are moved so that the vertex'
//! limit is the origin: refinement then shrinks everything, and what lies 2⁻⁴⁰ from the vertex is as exact as what lies far.

use super::super::fans::{beta, interior_tangents, side_tangents};
use super::super::patch::TriangleChannel;
use super::super::ring::{Near, edge_point, ghost, next, prev, rotate, rotate_back, rule};
use super::super::wide::{RING_FACES, scales};
use crate::dice::evaluate::MAX_DEPTH;
use crate::dice::point::{D4, Point};
use crate::topology::{Fan, FanRule, NONE};

/// A vertex with the ends of its edges. Edge 0 is the side of the own triangle that leaves it, edge 1 the one that comes in.
#[derive(Clone, Debug, Default)]
pub(super) struct Ring {
    /// From edge `low` on; of a closed ring, all from edge 0 on.
    edges: Vec<D4>,
    low: i32,
    closed: bool,
    /// Whether the fan ends there.
    open: [bool; 2],
    v: D4,
    /// Mean of the edges of a smooth fan; of a crease, of its two ends.
    mean: D4,
    /// Whether edges are missing, so that the mean follows its own recursion. Where none is, it is taken anew after every step: roundings
    /// between the two would fade by 5/8 a step only, when the ring shrinks by up to four.
    wide: bool,
    fan: Option<Fan>,
}

impl Ring {
    /// Gathers the ring of the vertex that half-edge `h` leaves.
    pub(super) fn gather(&mut self, channel: TriangleChannel<'_>, h: u32) {
        let t = channel.topology;
        let at = |g: u32| D4::wide(channel.points[t.vertex(g) as usize]);
        let id = t.fan(h);
        let fan = t.fans()[id as usize];
        self.fan = Some(fan);
        self.edges.clear();
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
                let before = rotate_back(t, start);
                if before == NONE {
                    self.open[0] = true;
                    break;
                }
                (start, left) = (before, left + 1);
            }
        }
        self.low = -left;
        let last = if self.closed { reach - 1 } else { reach };
        let (mut g, mut i) = (start, -left);
        loop {
            self.edges.push(at(next(g)));
            if i == last {
                break;
            }
            let after = rotate(t, g);
            if after == NONE {
                self.open[1] = true;
                break;
            }
            (g, i) = (after, i + 1);
        }
        if !self.closed {
            self.edges.push(at(prev(g)));
        }
        self.wide = channel.fans.wide(id).is_some();
        self.mean = match channel.fans.wide(id) {
            Some(wide) => self.v + D4::new(wide.mean),
            None => self.own_mean(),
        };
    }

    /// The mean by the edges themselves, where all of them are there.
    fn own_mean(&self) -> D4 {
        if self.closed {
            let sum = self.edges.iter().fold(D4::ZERO, |sum, &e| sum + e);
            return sum.times(1.0 / self.edges.len() as f64);
        }
        (self.edges[0] + self.edges[self.edges.len() - 1]) * 0.5
    }

    fn rule(&self) -> FanRule {
        self.fan.as_ref().map_or(FanRule::Corner, rule)
    }

    fn faces(&self) -> u32 {
        self.fan.map_or(6, |f| f.faces)
    }

    /// Where the vertex ends up.
    pub(super) fn limit(&self) -> D4 {
        match self.rule() {
            FanRule::Smooth => {
                let n = f64::from(self.faces());
                let w = n / (n + 0.375 / beta(self.faces()));
                self.v + (self.mean - self.v).times(w)
            }
            FanRule::Crease => self.v + (self.mean - self.v).times(1.0 / 3.0),
            FanRule::Corner => self.v,
        }
    }

    /// Moves the origin.
    pub(super) fn shift(&mut self, origin: D4) {
        for p in &mut self.edges {
            *p = *p - origin;
        }
        self.v = self.v - origin;
        self.mean = self.mean - origin;
    }

    /// One step of refinement.
    pub(super) fn step(&mut self) {
        let v = self.v;
        match self.rule() {
            FanRule::Corner => {}
            FanRule::Crease => {
                self.v = v * 0.75 + self.mean * 0.25;
                self.mean = (v + self.mean) * 0.5;
            }
            FanRule::Smooth => {
                let w = f64::from(self.faces()) * beta(self.faces());
                self.v = v.times(1.0 - w) + self.mean.times(w);
                self.mean = v * 0.375 + self.mean * 0.625;
            }
        }
        let e = &mut self.edges[..];
        let last = e.len() - 1;
        let (first, mut before) = (e[0], e[last]);
        for k in 0..=last {
            let own = e[k];
            let after = if k < last { e[k + 1] } else { first };
            e[k] = if self.closed || (0 < k && k < last) {
                edge_point(v, own, before, after)
            } else {
                (v + own) * 0.5
            };
            before = own;
        }
        // Edges at a cut through the fan are lost.
        if !self.closed && !self.open[1] {
            self.edges.pop();
        }
        if !self.closed && !self.open[0] {
            self.edges.remove(0);
            self.low += 1;
        }
        if !self.wide {
            self.mean = self.own_mean();
        }
    }

    fn edge(&self, i: i32) -> Option<D4> {
        let n = self.edges.len() as i32;
        let k = if self.closed {
            i.rem_euclid(n)
        } else {
            i - self.low
        };
        self.edges.get(usize::try_from(k).ok()?).copied()
    }

    /// What the triangle sees of the ring; ghosts stand beyond a boundary.
    pub(super) fn near(&self) -> Near<D4> {
        let e = |i: i32| self.edge(i).unwrap_or(self.v);
        let (e0, e1) = (e(0), e(1));
        let below = self.edge(-1).unwrap_or_else(|| ghost(self.v, e0, e1));
        let above = self.edge(2).unwrap_or_else(|| ghost(self.v, e1, e0));
        Near {
            v: self.v,
            e: [below, e0, e1, above],
        }
    }

    /// Tangents along the two sides of the own triangle at an irregular vertex: those of the flat star that the ring is closest to. Of a
    /// corner, the sides themselves.
    pub(super) fn tangents(&self, channel: TriangleChannel<'_>, h: u32) -> [D4; 2] {
        let (Some(fan), Some(e0), Some(e1)) = (self.fan, self.edge(0), self.edge(1)) else {
            return [D4::ZERO; 2];
        };
        if self.rule() == FanRule::Corner {
            return [e0 - self.v, e1 - self.v];
        }
        let (stars, place) = match channel.fans.wide(channel.topology.fan(h)) {
            Some(wide) => {
                let at = wide.places.binary_search_by_key(&h, |p| p.0);
                let place = at.map_or(0, |at| wide.places[at].1);
                (wide.tangents.map(D4::new), f64::from(place))
            }
            // A closed ring is counted from the own sector on.
            None => (self.star(fan), f64::from(-self.low)),
        };
        let turn = if fan.closed { 2.0 } else { 1.0 } * std::f64::consts::PI / f64::from(fan.faces);
        [place, place + 1.0].map(|i| {
            let (cos, sin) = (libm::cos(turn * i), libm::sin(turn * i));
            stars[0].times(cos) + stars[1].times(sin)
        })
    }

    fn star(&self, fan: Fan) -> [D4; 2] {
        let mask = if fan.closed {
            interior_tangents(fan.faces)
        } else {
            side_tangents(fan.faces)
        };
        let scales = scales(fan.closed, fan.faces);
        [0, 1].map(|k| {
            let terms = self.edges.iter().zip(&mask);
            let sum = terms.fold(D4::ZERO, |sum, (&e, w)| sum + (e - self.v).times(w[k]));
            sum.times(scales[k])
        })
    }
}
