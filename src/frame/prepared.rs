//! Buffers of one thread that items are diced with, and what in them is prepared.

use super::leaf::Spare;
use crate::dice::face::Sides;
use crate::simd::Level;
use crate::surface::{QuadPatch, Surface};
use std::time::Duration;

/// Buffers of one thread.
#[derive(Default)]
pub(super) struct SourceScratch {
    pub(super) patch: QuadPatch,
    pub(super) prepared: Option<(u32, Sides)>,
    /// Of the surface that is drawn, what is prepared: quad and level.
    pub(super) leaf: Option<(usize, u32, u32, Sides)>,
    pub(super) spare: Spare,
    /// Points that were diced since this was asked last.
    pub(super) diced: u64,
}

impl SourceScratch {
    pub(super) fn new(simd: Level) -> Self {
        let mut scratch = Self::default();
        scratch.patch.set_simd(simd);
        scratch
    }

    /// Whether time spent displacing is measured from now on.
    pub(super) fn measure(&mut self, on: bool) {
        self.patch.clock.set(on.then_some(Duration::ZERO));
    }

    /// Time spent displacing since this was asked last.
    pub(super) fn take_displaced(&self) -> Duration {
        let spent = self.patch.clock.get().unwrap_or_default();
        self.patch
            .clock
            .set(self.patch.clock.get().map(|_| Duration::ZERO));
        spent
    }

    /// Points that were diced since this was asked last.
    pub(super) fn take_diced(&mut self) -> u64 {
        std::mem::take(&mut self.diced)
    }

    /// Forgets which item is prepared: numbers of another scene mean other items.
    pub(super) fn forget(&mut self) {
        self.prepared = None;
        self.leaf = None;
    }

    /// Prepares a quad of a surface at a level, unless it is.
    pub(super) fn prepare(&mut self, surface: &Surface, quad: u32, level: u32, sides: Sides) {
        // The address tells surfaces of one scene apart.
        let of = std::ptr::from_ref(surface) as usize;
        let ready = self
            .leaf
            .is_some_and(|(s, q, l, have)| (s, q, l) == (of, quad, level) && have >= sides);
        if !ready {
            self.patch.prepare_points(surface, quad, level, None, sides);
            self.leaf = Some((of, quad, level, sides));
            self.prepared = None;
        }
    }
}

impl SourceScratch {
    /// Prepares a quad for hulls of its parts, unless it is.
    pub(super) fn prepare_part_hulls(&mut self, surface: &Surface, quad: u32, level: u32) {
        let of = std::ptr::from_ref(surface) as usize;
        let is_ready = |(s, q, l, _): (usize, u32, u32, Sides)| (s, q, l) == (of, quad, level);
        if !self.leaf.is_some_and(is_ready) {
            self.patch.prepare_part_hulls(surface, quad, level);
            // Nothing can be diced.
            self.leaf = Some((of, quad, level, Sides::Hull));
            self.prepared = None;
        }
    }
}
