//! Blocks that are lists of triangles, of refinement patterns: over the points of their grid, or over points with places of their own.

use crate::records::{BLOCK_POINTS, BLOCK_STRIDE};
use crate::tessellate::{Leaf, List};

/// A list as the device has it.
#[derive(Clone, Debug, Default)]
pub(super) struct PlannedList {
    /// Two words per triangle, the numbers of its points in the block; from [`Self::around`] on, per point and once more where the numbers of
    /// the triangles around it begin, counted from there, and these.
    pub(super) words: Vec<u32>,
    /// Triangles.
    pub(super) count: u32,
}

/// Micro-quads along the side of a block that holds the points of a leaf, as a power of two.
pub(super) fn log(leaf: &Leaf, list: &List) -> u32 {
    match list.points.len() {
        0 => leaf.log.into(),
        points => (0..)
            .find(|log| ((1_usize << log) + 1).pow(2) >= points)
            .unwrap_or(u32::from(leaf.log)),
    }
}

/// The same of a block whose micro-triangles have numbers for all of a list.
pub(super) fn id_log(list: &List) -> u32 {
    let bits = list.triangles.len().next_power_of_two().ilog2();
    bits.saturating_sub(1).div_ceil(2)
}

/// Words of a list over a block of so many points.
fn len(list: &List, points: usize) -> usize {
    (2 + 3) * list.triangles.len() + points + 1
}

/// Bytes of a list on the device.
pub(super) fn bytes(leaf: &Leaf, list: &List) -> usize {
    let side = (1_usize << log(leaf, list)) + 1;
    4 * len(list, side * side)
}

impl PlannedList {
    pub(super) fn new(leaf: &Leaf, list: &List) -> Self {
        let side = (1_usize << log(leaf, list)) + 1;
        let row = match list.points.len() {
            0 => side,
            _ => BLOCK_POINTS,
        };
        let own = |k: u16| {
            let k = usize::from(k);
            k / BLOCK_STRIDE * row + k % BLOCK_STRIDE
        };
        let triangles: Vec<[usize; 3]> = list.triangles.iter().map(|t| t.map(own)).collect();
        let points = side * side;
        let mut words = Vec::with_capacity(len(list, points));
        for &[a, b, c] in &triangles {
            words.extend([a as u32 | (b as u32) << 16, c as u32]);
        }
        let mut around: Vec<Vec<u32>> = vec![Vec::new(); points];
        for (number, t) in (0..).zip(&triangles) {
            for &k in t {
                around[k].push(number);
            }
        }
        let mut begin = points as u32 + 1;
        words.push(begin);
        for own in &around {
            begin += own.len() as u32;
            words.push(begin);
        }
        words.extend(around.iter().flatten());
        Self {
            words,
            count: triangles.len() as u32,
        }
    }

    /// Where in its words it stands which triangles are around each point.
    pub(super) fn around(&self) -> u32 {
        2 * self.count
    }
}
