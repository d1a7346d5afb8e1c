//! A sample's place in its block, whether the block is a grid or a list of triangles.

use crate::math;
use crate::raster::{
    Cell, ProjectedBlock, Tile, barycentrics, draw_block, draw_list, list_weights,
};
use crate::records::{BLOCK_STRIDE, Grid3, SampleId};
use crate::simd::Level;

/// Draws a block as a grid, or the triangles of a list over its points.
pub(super) fn draw<C: Cell>(
    simd: Level,
    tile: &mut Tile<C>,
    block: &ProjectedBlock,
    list: Option<&[[u16; 3]]>,
    rank: u32,
) {
    match list {
        Some(list) => draw_list(simd, tile, block, list, rank),
        None => draw_block(simd, tile, block, rank),
    }
}

/// The points around a sample, and their weights.
#[derive(Clone, Copy)]
pub(super) enum Spot {
    /// Of the micro-quad with this id: points (i, j), (i+1, j), (i+1, j+1), (i, j+1).
    Quad(SampleId, [f32; 4]),
    /// Of a triangle, by the indices of its points.
    Triangle([usize; 3], [f32; 3]),
}

impl Spot {
    /// The spot of sample `at` (column, row, sample) that shows `id`.
    #[inline]
    pub(super) fn of(
        block: &ProjectedBlock,
        list: Option<&[[u16; 3]]>,
        id: SampleId,
        [x, y, sample]: [u32; 3],
        samples: u32,
    ) -> Self {
        match list {
            None => Self::Quad(id, barycentrics(block, id, x, y, sample, samples)),
            Some(list) => {
                let corners = list[(id.0 & 2047) as usize].map(usize::from);
                let w = list_weights(block, corners, x, y, sample, samples);
                Self::Triangle(corners, w)
            }
        }
    }

    /// Interpolates a quantity of the block.
    #[inline(always)]
    pub(super) fn mix(&self, a: &[f32]) -> f32 {
        match self {
            Self::Quad(id, w) => {
                let k = id.row() as usize * BLOCK_STRIDE + id.col() as usize;
                // One check of bounds for all four corners.
                let a = &a[k..k + BLOCK_STRIDE + 2];
                (w[0] * a[0] + w[1] * a[1]) + (w[2] * a[BLOCK_STRIDE + 1] + w[3] * a[BLOCK_STRIDE])
            }
            Self::Triangle(k, w) => (w[0] * a[k[0]] + w[1] * a[k[1]]) + w[2] * a[k[2]],
        }
    }

    /// The same of three quantities.
    #[inline(always)]
    pub(super) fn mix3(&self, g: &Grid3) -> [f32; 3] {
        [self.mix(&g.x), self.mix(&g.y), self.mix(&g.z)]
    }

    /// Normal of the triangle, outward, of twice its area.
    #[inline]
    pub(super) fn geometric(&self, points: &Grid3) -> [f32; 3] {
        match self {
            Self::Quad(id, _) => {
                let (i, j) = (id.col() as usize, id.row() as usize);
                let middle = match id.half() {
                    0 => (i + 1, j),
                    _ => (i, j + 1),
                };
                let p = points.get(i, j);
                let (q, r) = (points.get(middle.0, middle.1), points.get(i + 1, j + 1));
                let n = math::cross(math::sub(q, p), math::sub(r, p));
                if id.half() == 0 { n } else { n.map(|c| -c) }
            }
            Self::Triangle(k, _) => {
                let [p, q, r] = k.map(|k| [points.x[k], points.y[k], points.z[k]]);
                math::cross(math::sub(q, p), math::sub(r, p))
            }
        }
    }
}
