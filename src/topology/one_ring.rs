//! The one-ring of a fan, counter-clockwise.

use super::{NONE, Topology};

/// Outgoing half-edges around a vertex, from a given one on, counter-clockwise. In face `i` the ring edge `e_i` leaves the vertex and
/// the corner `f_i` lies opposite.
#[derive(Clone, Debug)]
pub struct Ring<'a> {
    topology: &'a Topology,
    start: u32,
    at: u32,
    begun: bool,
}

impl<'a> Ring<'a> {
    /// All half-edges of fan `fan`, from its first one.
    #[must_use]
    pub fn of_fan(topology: &'a Topology, fan: u32) -> Self {
        Self::from_half(topology, topology.fans()[fan as usize].first)
    }
    /// Half-edges from `h` on: once around a closed fan, or up to the boundary.
    #[must_use]
    pub fn from_half(topology: &'a Topology, h: u32) -> Self {
        Self {
            topology,
            start: h,
            at: h,
            begun: false,
        }
    }
}

impl Iterator for Ring<'_> {
    type Item = u32;
    #[inline(always)]
    fn next(&mut self) -> Option<u32> {
        if self.at == NONE || (self.begun && self.at == self.start) {
            return None;
        }
        self.begun = true;
        let h = self.at;
        self.at = self.topology.rotate(h);
        Some(h)
    }
}
