//! The ears of every quad: the published buffers of the per-quad stages, for any valence and with boundaries.
//!
//! After Antal, Szirmay-Kalos, Jeni, *Rendering subdivision surfaces efficiently on the GPU*: a quad is refined on its own from a quad
//! buffer, a position buffer, a valence buffer and an adjacency buffer that lists its four ears. There the adjacency buffer reserves
//! 20 entries per quad; here it holds each fan's ring once, and an ear is a run of it, found by the sector of the quad in the ring.
//! So the buffer is linear in the mesh also at a vertex of valence 50,000, and every quad still reads nothing but its own ears.
//!
//! ```text
//!            e2 ──── f2 ──── e3          ring of corner 0, valence 5, from the quad's own sector on:
//!           ╱        │         ╲         e0 f0 e1 f1 e2 f2 e3 f3 e4 f4
//!         f1         │          f3       e0, f0, e1   corners 1, 2, 3 of the quad
//!           ╲        │         ╱         f1 … f4      brought by the edges to the neighbours
//!            e1 ──── 0 ──── e4           ear          e2 f2 e3 f3 e4, that is 2n − 5 points
//!             │  quad │       │
//!            f0 ──── e0 ──── f4
//! ```
//!
//! Corners run cyclically: corner 0 at (u, v) = (0, 0), 1 at (1, 0), 2 at (1, 1), 3 at (0, 1). Antal's strips list the same corners as
//! 0, 1, 3, 2; that permutation is the only difference in order.

use super::{NONE, Ring, Topology};

/// The buffers, for engines and GPUs; on the CPU the dicing code walks the same rings in the connectivity itself.
#[derive(Clone, Debug, Default)]
pub struct Ears {
    /// Four vertices per quad, cyclic.
    pub quads: Vec<[u32; 4]>,
    /// Per quad corner: the fan whose ring holds its ear.
    pub corner_fans: Vec<[u32; 4]>,
    /// Per quad corner: the quad's own sector in that ring.
    pub sectors: Vec<[u32; 4]>,
    /// Per fan: number of edges (valence), and bit 31 set where the fan is open.
    pub valences: Vec<u32>,
    /// Per fan: first entry of its ring in `rings`; one more at the end.
    pub ring_offsets: Vec<u32>,
    /// Rings, e0 f0 e1 f1 … per fan; an open ring ends with its last edge.
    pub rings: Vec<u32>,
}

/// Bit in [`Ears::valences`] of an open fan.
pub const OPEN: u32 = 1 << 31;

impl Ears {
    /// Lays out the ears of a quad mesh.
    ///
    /// # Panics
    /// When a face is not a quad; see [`split`](super::split::split).
    #[must_use]
    pub fn new(t: &Topology) -> Self {
        assert!(
            t.all_quads(),
            "ears are made of quads; split the mesh first"
        );
        let quads = t.face_count();
        let mut ears = Self {
            quads: (0..quads)
                .map(|q| std::array::from_fn(|c| t.vertex(4 * q as u32 + c as u32)))
                .collect(),
            corner_fans: (0..quads)
                .map(|q| std::array::from_fn(|c| t.fan(4 * q as u32 + c as u32)))
                .collect(),
            sectors: vec![[0; 4]; quads],
            ..Self::default()
        };
        for fan in 0..t.fans().len() as u32 {
            let info = t.fans()[fan as usize];
            ears.ring_offsets.push(ears.rings.len() as u32);
            ears.valences
                .push(info.edges() | if info.closed { 0 } else { OPEN });
            if info.first == NONE {
                continue;
            }
            for (sector, h) in Ring::of_fan(t, fan).enumerate() {
                ears.sectors[h as usize / 4][h as usize % 4] = sector as u32;
                let next = t.next(h);
                ears.rings.extend([t.vertex(next), t.vertex(t.next(next))]);
                if !info.closed && sector + 1 == info.faces as usize {
                    ears.rings.push(t.vertex(t.prev(h)));
                }
            }
        }
        ears.ring_offsets.push(ears.rings.len() as u32);
        ears
    }

    /// The ring around corner `corner` of quad `quad`, from the quad's own sector on: e0 (towards the next corner), f0 (opposite),
    /// e1, f1, …. At an open fan it runs to the boundary and goes on from the other end of the fan, behind a [`NONE`].
    pub fn ring(&self, quad: usize, corner: usize) -> impl Iterator<Item = u32> + '_ {
        let fan = self.corner_fans[quad][corner] as usize;
        let ring =
            &self.rings[self.ring_offsets[fan] as usize..self.ring_offsets[fan + 1] as usize];
        let (before, after) = ring.split_at(2 * self.sectors[quad][corner] as usize);
        let gap = (self.valences[fan] & OPEN != 0).then_some(NONE);
        after
            .iter()
            .copied()
            .chain(gap)
            .chain(before.iter().copied())
    }

    /// The ear of a corner: the points that neither the quad nor its edge neighbours bring, in ring order; 2n − 5 of them at an
    /// interior corner of valence n above 2.
    pub fn ear(&self, quad: usize, corner: usize) -> impl Iterator<Item = u32> + '_ {
        let fan = self.corner_fans[quad][corner] as usize;
        let length = (self.ring_offsets[fan + 1] - self.ring_offsets[fan]) as usize;
        // Skip e0 f0 e1 f1 in front, and the last face point, which the edge to the next corner brings.
        self.ring(quad, corner).take(length.max(1) - 1).skip(4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::{ConnectOptions, connect};

    #[test]
    fn ears_of_a_grid_are_the_bspline_stencil() {
        // 3×3 quads over 4×4 vertices: the middle quad's stencil is all sixteen vertices, each once.
        let corners: Vec<u32> = (0..9)
            .flat_map(|q| {
                let v = q / 3 * 4 + q % 3;
                [v, v + 1, v + 5, v + 4]
            })
            .collect();
        let offsets: Vec<u32> = (0..=9).map(|f| 4 * f).collect();
        let (t, warnings) = connect(16, &offsets, corners, &ConnectOptions::default());
        assert!(warnings.is_empty());
        let ears = Ears::new(&t);
        let mut stencil: Vec<u32> = ears.quads[4].to_vec();
        for corner in 0..4 {
            let ear: Vec<u32> = ears.ear(4, corner).collect();
            assert_eq!(ear.len(), 3);
            stencil.extend(ear);
        }
        stencil.sort_unstable();
        assert_eq!(stencil, (0..16).collect::<Vec<_>>());
    }
}
