//! Edges around a vertex, over all of its fans.
//!
//! A manifold vertex has one fan and its edges are those of the fan. At other vertices an edge may belong to several fans, but counts once:
//! rules go by the edges of the vertex.

use crate::topology::{NONE, Ring, Topology};
use rayon::prelude::*;

/// An edge seen from one of its ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spoke {
    /// The edge.
    pub edge: u32,
    /// Which end of the edge is here: 0 where [`Topology::edge_half`] starts, else 1.
    pub end: u32,
    /// A corner at the other end, in a face of this fan.
    pub far_corner: u32,
}

/// What of a topology is not found in its own arrays: fans beyond the first of a vertex, half-edges beyond the pair of an edge.
///
/// Both lists are empty for a manifold.
#[derive(Clone, Debug, Default)]
pub struct Incidence {
    /// (vertex, fan), sorted.
    extra_fans: Vec<(u32, u32)>,
    /// (edge, half-edge), sorted, of half-edges without twin that are not the edge's first.
    extra_halves: Vec<(u32, u32)>,
}

impl Incidence {
    /// Collects the lists of `t`.
    #[must_use]
    pub fn new(t: &Topology) -> Self {
        let mut extra_fans: Vec<_> = (t.vertex_count as u32..t.fans.len() as u32)
            .map(|fan| (t.fan_vertex(fan), fan))
            .collect();
        extra_fans.sort_unstable();
        let mut extra_halves: Vec<_> = (0..t.half_count() as u32)
            .into_par_iter()
            .with_min_len(1 << 14)
            .filter(|&h| t.twin(h) == NONE && t.edge_half(t.edge(h)) != h)
            .map(|h| (t.edge(h), h))
            .collect();
        extra_halves.sort_unstable();
        Self {
            extra_fans,
            extra_halves,
        }
    }

    /// Fans of vertex `v` beyond the one that bears its number.
    pub fn extra_fans(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        let start = self.extra_fans.partition_point(|&(u, _)| u < v);
        self.extra_fans[start..]
            .iter()
            .take_while(move |&&(u, _)| u == v)
            .map(|&(_, fan)| fan)
    }

    /// Half-edges of edge `e` beyond its first and the twin of that.
    pub fn extra_halves(&self, e: u32) -> impl Iterator<Item = u32> + '_ {
        let start = self.extra_halves.partition_point(|&(u, _)| u < e);
        self.extra_halves[start..]
            .iter()
            .take_while(move |&&(u, _)| u == e)
            .map(|&(_, h)| h)
    }

    /// All (edge, half-edge) pairs beyond the first of each edge and its twin, sorted.
    #[must_use]
    pub fn all_extra_halves(&self) -> &[(u32, u32)] {
        &self.extra_halves
    }

    /// Whether every vertex has one fan.
    #[must_use]
    pub fn single_fans(&self) -> bool {
        self.extra_fans.is_empty()
    }

    /// All half-edges of edge `e`, from its first one.
    pub fn halves(&self, t: &Topology, e: u32) -> impl Iterator<Item = u32> + '_ {
        let first = t.edge_half(e);
        let twin = t.twin(first);
        std::iter::once(first)
            .chain((twin != NONE).then_some(twin))
            .chain(self.extra_halves(e))
    }

    /// Fills `spokes` with the edges around vertex `v`, in ring order of its fans.
    pub fn spokes(&self, t: &Topology, v: u32, spokes: &mut Vec<Spoke>) {
        spokes.clear();
        fan_spokes(t, v, spokes);
        if self.extra_fans.is_empty() {
            return;
        }
        let before = spokes.len();
        for fan in self.extra_fans(v) {
            fan_spokes(t, fan, spokes);
        }
        if spokes.len() > before {
            spokes.sort_unstable_by_key(|s| (s.edge, s.end, s.far_corner));
            spokes.dedup_by_key(|s| (s.edge, s.end));
        }
    }
}

/// Adds the edges of one fan in ring order, the last edge of an open fan included.
pub fn fan_spokes(t: &Topology, fan: u32, spokes: &mut Vec<Spoke>) {
    let info = t.fans()[fan as usize];
    if info.first == NONE {
        return;
    }
    let mut last = info.first;
    for h in Ring::of_fan(t, fan) {
        last = h;
        spokes.push(Spoke {
            edge: t.edge(h),
            end: start_end(t, h),
            far_corner: t.next(h),
        });
    }
    if !info.closed {
        let h = t.prev(last);
        spokes.push(Spoke {
            edge: t.edge(h),
            end: 1 - start_end(t, h),
            far_corner: h,
        });
    }
}

/// Which end of its edge half-edge `h` leaves.
#[must_use]
#[inline]
pub fn start_end(t: &Topology, h: u32) -> u32 {
    let first = t.edge_half(t.edge(h));
    if h == first {
        0
    } else if t.twin(h) == first {
        1
    } else {
        // Not manifold: by direction.
        let ends = |h: u32| (t.vertex(h), t.vertex(t.next(h)));
        u32::from(ends(h) != ends(first))
    }
}
