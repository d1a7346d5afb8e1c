//! Whose points and normals sides and corners have: faces that share them take them from one place.

use super::dicer::{Dicer, Shown};
use crate::scheme::Scheme;
use crate::topology::NONE;

/// The half-edges whose faces give a side its points, and its normals.
#[derive(Clone, Copy)]
pub(super) struct Owners {
    pub(super) position: u32,
    pub(super) normal: u32,
}

impl Dicer<'_> {
    /// Whose points a side has: those of the edge's first half-edge; normals are one's own along creases and borders.
    pub(super) fn side_owners(&self, h: u32) -> Owners {
        let (whole, cut) = (self.surface.whole_quads(), self.surface.quads());
        let twin = cut.twin(h);
        let own = twin == NONE || self.is_faceted();
        Owners {
            position: whole.edge_half(whole.edge(h)),
            normal: if own { h } else { h.min(twin) },
        }
    }

    /// The same of a corner: the first half-edge around.
    pub(super) fn corner_owners(&self, h: u32) -> Owners {
        let (whole, cut) = (self.surface.whole_quads(), self.surface.quads());
        let first = |found: u32| if found == NONE { h } else { found };
        Owners {
            position: first(whole.fans()[whole.fan(h) as usize].first),
            normal: match self.is_faceted() {
                true => h,
                false => first(cut.fans()[cut.fan(h) as usize].first),
            },
        }
    }

    /// Half-edges whose faces say something of the side `h` or the corner that it begins with.
    pub(super) fn sources(&self, h: u32) -> impl Iterator<Item = u32> + use<> {
        let [a, b] = [self.side_owners(h), self.corner_owners(h)];
        let mut all = vec![a.position, a.normal, b.position, b.normal];
        if self.is_displaced() {
            let mitred = [self.surface.mitred_side(h), self.surface.mitred_corner(h)];
            all.extend(mitred.into_iter().flatten().flatten());
        }
        all.into_iter()
    }

    /// How many normals the directions of a side's points are mitres of, and that of the corner that it begins with.
    pub(super) fn mitred(&self, h: u32) -> [u64; 2] {
        if !self.is_displaced() {
            return [0; 2];
        }
        let mitred = [self.surface.mitred_side(h), self.surface.mitred_corner(h)];
        mitred.map(|all| all.map_or(0, |all| all.len() as u64))
    }

    /// Whether every face has normals of its own all around.
    pub(super) fn is_faceted(&self) -> bool {
        self.surface.scheme() == Scheme::Bilinear || self.shown == Shown::Pn
    }

    pub(super) fn corner_count(&self) -> u32 {
        if self.surface.is_triangular() { 3 } else { 4 }
    }

    /// Column and row of the point `k` of `n` along side `c`.
    pub(super) fn along(&self, c: u32, k: u32, n: u32) -> [u32; 2] {
        if self.surface.is_triangular() {
            return [[k, 0], [n, k], [n - k, n - k]][c as usize];
        }
        [[k, 0], [n, k], [n - k, n], [0, n - k]][c as usize]
    }
}
