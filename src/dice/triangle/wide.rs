//! What evaluation near a vertex of many faces needs of its whole ring, found once per frame: nobody should walk such a ring once per face.

use super::fans::{Mask, ring_sums};
use super::ring::rule;
use crate::topology::{FanRule, Ring, Topology};

/// Most faces of a fan whose whole ring is gathered for evaluation.
pub(super) const RING_FACES: u32 = 64;

/// Of a fan of more faces; relative to the vertex.
#[derive(Clone, Debug)]
pub(super) struct WideFan {
    /// Mean of the edges; of an open fan, of its two ends.
    pub(super) mean: [f64; 3],
    /// Tangents of the flat star, along the first spoke and a quarter turn on.
    pub(super) tangents: [[f64; 3]; 2],
    /// Half-edges out of the vertex, sorted, with their places in the ring.
    pub(super) places: Vec<(u32, u32)>,
}

/// Factors that make the sums of the tangent masks the tangents of the flat star which the ring is closest to: spokes of unit length at
/// equal angles give unit vectors.
pub(super) fn scales(closed: bool, faces: u32) -> [f64; 2] {
    let n = f64::from(faces);
    match (closed, faces) {
        // Masks and spokes are cosines and sines.
        (true, _) => [2.0 / n, 2.0 / n],
        // Across a boundary of one face there is no spoke.
        (false, 1) => [0.5, 0.0],
        // The ends of a boundary do not move in the second mode.
        (false, _) => [0.5, 2.0 / n],
    }
}

impl WideFan {
    pub(super) fn new(t: &Topology, id: u32, points: &[[f32; 3]], mask: Option<&Mask>) -> Self {
        let fan = t.fans()[id as usize];
        let smooth = rule(&fan) == FanRule::Smooth;
        let sums = ring_sums(t, &fan, points, mask);
        let scales = scales(fan.closed, fan.faces);
        let mut places: Vec<(u32, u32)> = Ring::of_fan(t, id).zip(0..).collect();
        places.sort_unstable();
        Self {
            mean: [0, 1, 2].map(|c| {
                if smooth {
                    sums.edges[c] / f64::from(fan.faces)
                } else {
                    0.5 * (sums.ends[0][c] + sums.ends[1][c])
                }
            }),
            tangents: [0, 1].map(|k| sums.tangents[k].map(|c| c * scales[k])),
            places,
        }
    }
}
