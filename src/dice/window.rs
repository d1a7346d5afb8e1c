//! The ring around one corner of a quad, as far as the quad can see it, and its refinement.
//!
//! A window holds the sectors `-left … right` of a vertex' ring; sector 0 is the quad's own. One step of Catmull-Clark makes every
//! new point of the ring from its two neighbouring sectors, so an open end of the window loses one sector per step, and a window of
//! `1 + steps` sectors to either side is enough for any valence. What the vertex itself becomes is [`FanSeries`](super::fan_points)'s
//! matter. All formulas are symmetric in the bits (`(a + c) + (b + d)` over opposite corners), so a point of the ring has the same
//! bits seen from every face around the vertex.

use super::basis::MAX_LEVEL;
use super::point::{P4, Point};
use crate::topology::{NONE, Topology};

/// Most sectors to either side: one for every step, one for the net, one to spare for the rows opposite an edge.
const REACH: usize = MAX_LEVEL as usize + 3;

/// Part of a vertex' ring.
#[derive(Clone, Debug)]
pub(crate) struct Window {
    pub(crate) v: P4,
    edges: [P4; 2 * REACH + 2],
    faces: [P4; 2 * REACH + 1],
    /// Sectors present clockwise of the own one.
    left: i32,
    right: i32,
    /// Whether the fan ends there, so that the outermost edge is a boundary.
    open_left: bool,
    open_right: bool,
    /// Number of sectors if they are all there and close around the vertex; then they stand from the first place on. Otherwise 0.
    ring: usize,
}

impl Window {
    pub(crate) const EMPTY: Self = Self {
        v: P4::ZERO,
        edges: [P4::ZERO; 2 * REACH + 2],
        faces: [P4::ZERO; 2 * REACH + 1],
        left: 0,
        right: 0,
        open_left: false,
        open_right: false,
        ring: 0,
    };

    /// Gathers `reach` sectors to either side of half-edge `h`, fewer at a boundary; or all of a fan of no more.
    pub(crate) fn gather(&mut self, t: &Topology, points: &[[f32; 3]], h: u32, reach: usize) {
        let at = |g: u32| P4::new(points[t.vertex(g) as usize]);
        let reach = reach.min(REACH);
        self.v = at(h);
        let fan = t.fans()[t.fan(h) as usize];
        self.ring = 0;
        if fan.closed && fan.faces as usize <= 2 * reach + 1 {
            self.ring = fan.faces as usize;
            let mut g = h;
            for i in 0..self.ring {
                let next = t.next(g);
                self.edges[i] = at(next);
                self.faces[i] = at(t.next(next));
                g = t.rotate(g);
            }
            return;
        }
        let mut put = |i: i32, g: u32| {
            let next = t.next(g);
            self.edges[(REACH as i32 + i) as usize] = at(next);
            self.faces[(REACH as i32 + i) as usize] = at(t.next(next));
        };
        put(0, h);
        let (mut last, mut right) = (h, 0);
        self.open_right = false;
        while right < reach as i32 {
            let g = t.rotate(last);
            if g == NONE {
                self.open_right = true;
                break;
            }
            right += 1;
            put(right, g);
            last = g;
        }
        let (mut first, mut left) = (h, 0);
        self.open_left = false;
        while left < reach as i32 {
            let g = t.rotate_back(first);
            if g == NONE {
                self.open_left = true;
                break;
            }
            left += 1;
            put(-left, g);
            first = g;
        }
        self.edges[(REACH as i32 + right + 1) as usize] = at(t.prev(last));
        (self.left, self.right) = (left, right);
    }

    /// The sectors next to the own one.
    pub(crate) fn near(&self) -> Near {
        if self.ring > 0 {
            let mut near = Near {
                v: self.v,
                left: 2,
                right: 2,
                ..Near::EMPTY
            };
            // From sector −2 on.
            let mut i = self.ring.saturating_sub(2);
            for k in 0..6 {
                near.edges[k] = self.edges[i];
                if k < 5 {
                    near.faces[k] = self.faces[i];
                }
                i = if i + 1 < self.ring { i + 1 } else { 0 };
            }
            return near;
        }
        let at = REACH - 2;
        let mut near = Near {
            v: self.v,
            left: self.left.min(2),
            right: self.right.min(2),
            ..Near::EMPTY
        };
        near.edges.copy_from_slice(&self.edges[at..at + 6]);
        near.faces.copy_from_slice(&self.faces[at..at + 5]);
        near
    }

    /// Calls `out` with every point of the window.
    pub(crate) fn each(&self, mut out: impl FnMut(P4)) {
        out(self.v);
        let edges = match self.ring {
            0 => {
                let first = (REACH as i32 - self.left) as usize;
                first..(REACH as i32 + self.right + 2) as usize
            }
            n => 0..n,
        };
        let faces = match self.ring {
            0 => edges.start..edges.end - 1,
            n => 0..n,
        };
        self.edges[edges].iter().for_each(|&p| out(p));
        self.faces[faces].iter().for_each(|&p| out(p));
    }

    /// One step of refinement; `v` is what the vertex becomes.
    pub(crate) fn step(&mut self, v: P4) {
        if self.ring > 0 {
            return self.step_ring(v);
        }
        let o = REACH as i32;
        for i in -self.left..=self.right {
            let k = (o + i) as usize;
            self.faces[k] = face_point(self.v, self.edges[k], self.faces[k], self.edges[k + 1]);
        }
        for i in -self.left + 1..=self.right {
            let k = (o + i) as usize;
            self.edges[k] = edge_point(self.v, self.edges[k], self.faces[k - 1], self.faces[k]);
        }
        if self.open_left {
            let k = (o - self.left) as usize;
            self.edges[k] = (self.v + self.edges[k]) * 0.5;
        } else {
            self.left -= 1;
        }
        if self.open_right {
            let k = (o + self.right + 1) as usize;
            self.edges[k] = (self.v + self.edges[k]) * 0.5;
        } else {
            self.right -= 1;
        }
        self.v = v;
    }

    fn step_ring(&mut self, v: P4) {
        let n = self.ring;
        let (edges, faces) = (&mut self.edges[..n], &mut self.faces[..n]);
        let first = edges[0];
        for i in 0..n {
            let after = if i + 1 < n { edges[i + 1] } else { first };
            faces[i] = face_point(self.v, edges[i], faces[i], after);
        }
        let mut before = faces[n - 1];
        for i in 0..n {
            edges[i] = edge_point(self.v, edges[i], before, faces[i]);
            before = faces[i];
        }
        self.v = v;
    }
}

/// The five sectors around the own one, kept from a window of some depth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    pub(crate) v: P4,
    edges: [P4; 6],
    faces: [P4; 5],
    left: i32,
    right: i32,
}

impl Near {
    pub(crate) const EMPTY: Self = Self {
        v: P4::ZERO,
        edges: [P4::ZERO; 6],
        faces: [P4::ZERO; 5],
        left: 0,
        right: 0,
    };

    /// Ring edge `i`; present for `-left ≤ i ≤ right + 1`, at most from −2 to 3.
    #[inline]
    pub(crate) fn e(&self, i: i32) -> P4 {
        debug_assert!(-self.left <= i && i <= self.right + 1);
        self.edges[(i + 2) as usize]
    }
    /// Face corner `i`; present for `-left ≤ i ≤ right`, at most from −2 to 2.
    #[inline]
    pub(crate) fn f(&self, i: i32) -> P4 {
        debug_assert!(self.has(i));
        self.faces[(i + 2) as usize]
    }
    /// Whether sector `i` is there.
    #[inline]
    pub(crate) fn has(&self, i: i32) -> bool {
        -self.left <= i && i <= self.right
    }
}

/// A vertex with the part of its ring that is at hand; sector 0 is the own one.
pub(crate) trait Around<P> {
    fn v(&self) -> P;
    /// Ring edge `i`.
    fn e(&self, i: i32) -> P;
    /// Face corner `i`.
    fn f(&self, i: i32) -> P;
    /// Whether sector `i` is there.
    fn has(&self, i: i32) -> bool;
}

impl Around<P4> for Near {
    #[inline(always)]
    fn v(&self) -> P4 {
        self.v
    }
    #[inline(always)]
    fn e(&self, i: i32) -> P4 {
        self.e(i)
    }
    #[inline(always)]
    fn f(&self, i: i32) -> P4 {
        self.f(i)
    }
    #[inline(always)]
    fn has(&self, i: i32) -> bool {
        self.has(i)
    }
}

/// Centroid of the quad a, b, c, d.
#[inline(always)]
pub(crate) fn face_point<P: Point>(a: P, b: P, c: P, d: P) -> P {
    ((a + c) + (b + d)) * 0.25
}

/// Smooth edge point of edge a–b between the face points f and g.
#[inline(always)]
pub(crate) fn edge_point<P: Point>(a: P, b: P, f: P, g: P) -> P {
    ((a + b) + (f + g)) * 0.25
}

/// Smooth point of a valence-4 vertex in the middle of a 3×3 net.
#[inline(always)]
pub(crate) fn vertex_point<P: Point>(n: [[P; 3]; 3]) -> P {
    let corners = (n[0][0] + n[2][2]) + (n[0][2] + n[2][0]);
    let sides = (n[0][1] + n[2][1]) + (n[1][0] + n[1][2]);
    (n[1][1] * 36.0 + sides * 6.0 + corners) * (1.0 / 64.0)
}
