//! Whose points and normals sides and corners have: faces that share them take them from one place.

use super::dicer::{Dicer, Shown};
use crate::scheme::Scheme;
use crate::topology::NONE;

/// The half-edges whose faces give a side its points, and its normals.
#[derive(Clone, Copy)]
pub(super) struct Owners {
    pub(super) position: u32,
    pub(super) normal: u32,
    /// Whose derivatives the normals of a displaced surface are made of: not each its own where only patches have normals of their own.
    pub(super) jet: u32,
}

impl Owners {
    /// A half-edge's own face alone.
    pub(super) fn own(h: u32) -> Self {
        Self {
            position: h,
            normal: h,
            jet: h,
        }
    }
}

impl Dicer<'_> {
    /// Whose points a side has: those of the edge's first half-edge; normals are one's own along creases and borders.
    pub(super) fn side_owners(&self, h: u32) -> Owners {
        let (whole, cut) = (self.surface.whole_quads(), self.surface.quads());
        let twin = cut.twin(h);
        let jet = match twin == NONE || self.surface.scheme() == Scheme::Bilinear {
            true => h,
            false => h.min(twin),
        };
        Owners {
            position: whole.edge_half(whole.edge(h)),
            normal: if self.is_faceted() { h } else { jet },
            jet,
        }
    }

    /// The same of a corner: the first half-edge around.
    pub(super) fn corner_owners(&self, h: u32) -> Owners {
        let (whole, cut) = (self.surface.whole_quads(), self.surface.quads());
        let first = |found: u32| if found == NONE { h } else { found };
        let jet = match self.surface.scheme() == Scheme::Bilinear {
            true => h,
            false => first(cut.fans()[cut.fan(h) as usize].first),
        };
        Owners {
            position: first(whole.fans()[whole.fan(h) as usize].first),
            normal: if self.is_faceted() { h } else { jet },
            jet,
        }
    }

    /// Half-edges whose faces say something of the side `h` or the corner that it begins with.
    pub(super) fn sources(&self, h: u32) -> impl Iterator<Item = u32> + use<> {
        let [a, b] = [self.side_owners(h), self.corner_owners(h)];
        let mut all = vec![a.position, a.normal, b.position, b.normal];
        if self.is_displaced() {
            let mitred = [self.surface.mitred_side(h), self.surface.mitred_corner(h)];
            all.extend(mitred.into_iter().flatten().flatten());
            all.extend([a.jet, b.jet]);
        }
        if self.shown == Shown::Qas && self.is_displaced() {
            // Their normals are those of curves, which run through points of others.
            let whole = self.surface.whole_quads();
            for h in self.surface.mitred_side(h).into_iter().flatten() {
                let corners = [h, whole.next(h)].map(|h| self.corner_owners(h));
                for owners in corners.into_iter().chain([self.side_owners(h)]) {
                    all.extend([owners.position, owners.normal]);
                }
            }
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

    /// Whose place the stencil of a normal has: displaced patches have normals of nets, and derivatives elsewhere.
    pub(super) fn evaluated(&self, owners: Owners) -> u32 {
        match self.lifts_patches() {
            true => owners.jet,
            false => owners.normal,
        }
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
