//! Rings around the corners of a triangle, as far as the triangle can see them, and their refinement.
//!
//! Ring edge 0 of a corner is the face's side that leaves it, edge 1 the side that comes in; numbers grow counter-clockwise. A regular
//! corner has a whole hexagon, beyond a boundary filled up with ghosts `p + q − r`, which make the smooth rules give the boundary rules.
//! An irregular one has a window of edges that loses one at each open end per step. Sums are symmetric or run in an order of the fan's
//! own, so every face around a vertex gets the same bits for the same point.

use super::super::basis::MAX_LEVEL;
use super::super::point::{P4, Point};
use crate::topology::{Fan, FanRule, NONE, Topology};

/// The half-edge after `h` in its triangle.
#[inline]
pub(super) fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// The half-edge before `h`.
#[inline]
pub(super) fn prev(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

/// The next outgoing half-edge counter-clockwise, or [`NONE`].
#[inline]
pub(super) fn rotate(t: &Topology, h: u32) -> u32 {
    t.twin(prev(h))
}

/// The next outgoing half-edge clockwise, or [`NONE`].
#[inline]
pub(super) fn rotate_back(t: &Topology, h: u32) -> u32 {
    let twin = t.twin(h);
    if twin == NONE { NONE } else { next(twin) }
}

/// The rule that a fan follows: its own, but never one that its shape does not allow.
pub(super) fn rule(fan: &Fan) -> FanRule {
    match (fan.rule, fan.closed) {
        (FanRule::Corner, _) => FanRule::Corner,
        (_, true) => FanRule::Smooth,
        (_, false) => FanRule::Crease,
    }
}

/// Whether the surface around is an ordinary box spline: valence 6, or three faces on a boundary.
pub(crate) fn is_regular(fan: &Fan) -> bool {
    match rule(fan) {
        FanRule::Smooth => fan.faces == 6,
        FanRule::Crease => fan.faces == 3,
        FanRule::Corner => false,
    }
}

/// Point of edge a–b with c and d opposite.
#[inline(always)]
pub(super) fn edge_point<P: Point>(a: P, b: P, c: P, d: P) -> P {
    (a + b) * 0.375 + (c + d) * 0.125
}

/// Point of a vertex with six neighbours.
#[inline(always)]
pub(super) fn vertex_point<P: Point>(v: P, e: [P; 6]) -> P {
    v * 0.625 + (((e[0] + e[1]) + (e[2] + e[3])) + (e[4] + e[5])) * 0.0625
}

/// The point across edge p–q from r, where there is none.
#[inline(always)]
pub(super) fn ghost<P: Point>(p: P, q: P, r: P) -> P {
    (p + q) - r
}

/// A regular vertex and its six neighbours from ring edge 0 on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hexagon<P = P4> {
    pub(super) v: P,
    pub(super) e: [P; 6],
    /// Ring edge at which the fan's own order begins.
    first: usize,
    open: bool,
}

impl<P: Point> Hexagon<P> {
    pub(super) const EMPTY: Self = Self {
        v: P::ZERO,
        e: [P::ZERO; 6],
        first: 0,
        open: false,
    };

    /// The ring of the vertex that `h` leaves, which must be regular.
    pub(super) fn gather(t: &Topology, points: &[[f32; 3]], h: u32) -> Self {
        let at = |g: u32| P::of(points[t.vertex(g) as usize]);
        let mut out = Self {
            v: at(h),
            ..Self::EMPTY
        };
        let mut g = h;
        let mut least = h;
        for i in 0..6 {
            out.e[i] = at(next(g));
            if g < least {
                (least, out.first) = (g, i);
            }
            let after = rotate(t, g);
            if after == NONE {
                out.e[i + 1] = at(prev(g));
                out.open_ring(t, points, h, i + 1);
                break;
            }
            g = after;
        }
        out
    }

    /// Completes a ring that ends with ring edge `last`.
    fn open_ring(&mut self, t: &Topology, points: &[[f32; 3]], h: u32, last: usize) {
        self.open = true;
        let mut g = h;
        // Three faces: whatever is not ahead is behind.
        for i in last..3 {
            g = rotate_back(t, g);
            if g == NONE {
                break;
            }
            self.e[5 - (i - last)] = P::of(points[t.vertex(next(g)) as usize]);
        }
        self.first = (last + 3) % 6;
        let r = |k: usize| self.e[(self.first + k) % 6];
        let (four, five) = (ghost(self.v, r(3), r(2)), ghost(self.v, r(0), r(1)));
        self.e[(self.first + 4) % 6] = four;
        self.e[(self.first + 5) % 6] = five;
    }

    /// The six neighbours from ring edge `s` on.
    pub(super) fn from(&self, s: usize) -> [P; 6] {
        std::array::from_fn(|i| self.e[(s + i) % 6])
    }

    /// The ring after one step.
    pub(super) fn refined(&self) -> Self {
        let e = &self.e;
        let r = self.from(self.first);
        let v = if self.open {
            self.v * 0.75 + (r[0] + r[3]) * 0.125
        } else {
            vertex_point(self.v, r)
        };
        Self {
            v,
            e: std::array::from_fn(|i| edge_point(self.v, e[i], e[(i + 5) % 6], e[(i + 1) % 6])),
            ..*self
        }
    }

    pub(super) fn near(&self) -> Near<P> {
        Near {
            v: self.v,
            e: [self.e[5], self.e[0], self.e[1], self.e[2]],
        }
    }
}

/// A vertex and its ring edges −1 to 2; ghosts stand beyond a boundary.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near<P = P4> {
    pub(super) v: P,
    pub(super) e: [P; 4],
}

impl<P: Point> Near<P> {
    /// The same points with `by` added.
    pub(super) fn moved(&self, by: P) -> Self {
        Self {
            v: self.v + by,
            e: self.e.map(|p| p + by),
        }
    }
    /// Ring edge `i`, −1 to 2.
    #[inline]
    pub(super) fn e(&self, i: i32) -> P {
        self.e[(i + 1) as usize]
    }
}

/// Most sectors to either side: one for every step, one for the ring that is left.
const REACH: usize = MAX_LEVEL as usize + 2;
const MIDDLE: i32 = REACH as i32;

/// Part of the ring of an irregular vertex: edges `low` to `high`, relative to a base.
#[derive(Clone, Debug)]
pub(super) struct Window {
    v: P4,
    edges: [P4; 2 * REACH + 2],
    low: i32,
    high: i32,
    /// Whether the fan ends there.
    open_low: bool,
    open_high: bool,
}

impl Window {
    pub(super) const EMPTY: Self = Self {
        v: P4::ZERO,
        edges: [P4::ZERO; 2 * REACH + 2],
        low: 0,
        high: 1,
        open_low: false,
        open_high: false,
    };

    /// Gathers `reach` sectors to either side of the own one, fewer at a boundary; points relative to `base`.
    pub(super) fn gather(
        &mut self,
        t: &Topology,
        points: &[[f32; 3]],
        h: u32,
        reach: usize,
        base: P4,
    ) {
        let at = |g: u32| P4::new(points[t.vertex(g) as usize]) - base;
        let reach = reach.min(REACH) as i32;
        self.v = at(h);
        self.edges[REACH] = at(next(h));
        (self.low, self.high) = (0, 1);
        self.open_low = false;
        self.open_high = false;
        let mut g = h;
        loop {
            self.edges[(MIDDLE + self.high) as usize] = at(prev(g));
            if self.high > reach {
                break;
            }
            g = rotate(t, g);
            if g == NONE {
                self.open_high = true;
                break;
            }
            self.high += 1;
        }
        g = h;
        while self.low > -reach {
            g = rotate_back(t, g);
            if g == NONE {
                self.open_low = true;
                break;
            }
            self.low -= 1;
            self.edges[(MIDDLE + self.low) as usize] = at(next(g));
        }
    }

    /// Whether a fan of so many faces is in the window all around.
    pub(super) fn holds(&self, fan: &Fan) -> bool {
        if fan.closed {
            self.high - self.low + 1 >= fan.faces as i32
        } else {
            self.open_low && self.open_high
        }
    }

    /// One step of refinement; `v` is what the vertex becomes.
    pub(super) fn step(&mut self, v: P4) {
        let k = |i: i32| (MIDDLE + i) as usize;
        let mut before = self.edges[k(self.low)];
        for i in self.low + 1..self.high {
            let own = self.edges[k(i)];
            self.edges[k(i)] = edge_point(self.v, own, before, self.edges[k(i + 1)]);
            before = own;
        }
        for (open, end, inwards) in [
            (self.open_low, &mut self.low, 1),
            (self.open_high, &mut self.high, -1),
        ] {
            if open {
                self.edges[k(*end)] = (self.v + self.edges[k(*end)]) * 0.5;
            } else {
                *end += inwards;
            }
        }
        self.v = v;
    }

    pub(super) fn near(&self) -> Near {
        let e = |i: i32| self.edges[(MIDDLE + i) as usize];
        let below = if self.low < 0 {
            e(-1)
        } else {
            ghost(self.v, e(0), e(1))
        };
        let above = if self.high > 1 {
            e(2)
        } else {
            ghost(self.v, e(1), e(0))
        };
        Near {
            v: self.v,
            e: [below, e(0), e(1), above],
        }
    }

    /// Calls `out` with every point of the window.
    pub(super) fn each(&self, mut out: impl FnMut(P4)) {
        out(self.v);
        (self.low..=self.high).for_each(|i| out(self.edges[(MIDDLE + i) as usize]));
    }
}
