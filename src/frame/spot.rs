//! A sample's place in its block, whether the block is a grid or a list of triangles.

use crate::math;
use crate::raster::{
    Cell, ProjectedBlock, Tile, barycentrics, draw_apart, draw_block, draw_list, list_weights,
};
use crate::records::{BLOCK_STRIDE, Grid3, SampleId};
use crate::simd::Level;

/// What of a block is drawn.
#[derive(Clone, Copy)]
pub(super) enum Shape<'a> {
    /// All of its micro-quads.
    Grid,
    /// Every second one in both directions.
    Apart,
    /// Triangles, by the indices of their points.
    List(&'a [[u16; 3]]),
}

impl<'a> Shape<'a> {
    /// The triangles, where it is no grid.
    pub(super) fn list(self) -> Option<&'a [[u16; 3]]> {
        match self {
            Self::List(list) => Some(list),
            Self::Grid | Self::Apart => None,
        }
    }
}

/// Draws a block.
pub(super) fn draw<C: Cell>(
    simd: Level,
    tile: &mut Tile<C>,
    block: &ProjectedBlock,
    shape: Shape<'_>,
    rank: u32,
) {
    match shape {
        Shape::Grid => draw_block(simd, tile, block, rank),
        Shape::Apart => draw_apart(simd, tile, block, rank),
        Shape::List(list) => draw_list(simd, tile, block, list, rank),
    }
}

/// The points around a sample, and their weights.
pub(super) trait Spot {
    /// Interpolates a quantity of the block.
    fn mix(&self, a: &[f32]) -> f32;
    /// Normal of the triangle, outward, of twice its area.
    fn geometric(&self, points: &Grid3) -> [f32; 3];
    /// Interpolates three quantities.
    #[inline(always)]
    fn mix3(&self, g: &Grid3) -> [f32; 3] {
        [self.mix(&g.x), self.mix(&g.y), self.mix(&g.z)]
    }
}

/// Of a micro-quad: points (i, j), (i+1, j), (i+1, j+1), (i, j+1).
pub(super) struct Quad {
    id: SampleId,
    weights: [f32; 4],
}

impl Quad {
    /// The spot of sample `at` (column, row, sample) that shows `id`.
    #[inline(always)]
    pub(super) fn new(
        block: &ProjectedBlock,
        id: SampleId,
        [x, y, sample]: [u32; 3],
        samples: u32,
    ) -> Self {
        let weights = barycentrics(block, id, x, y, sample, samples);
        Self { id, weights }
    }
}

impl Spot for Quad {
    #[inline(always)]
    fn mix(&self, a: &[f32]) -> f32 {
        let w = self.weights;
        let k = self.id.row() as usize * BLOCK_STRIDE + self.id.col() as usize;
        // One check of bounds for all four corners.
        let a = &a[k..k + BLOCK_STRIDE + 2];
        (w[0] * a[0] + w[1] * a[1]) + (w[2] * a[BLOCK_STRIDE + 1] + w[3] * a[BLOCK_STRIDE])
    }

    #[inline(always)]
    fn geometric(&self, points: &Grid3) -> [f32; 3] {
        geometric(points, self.id)
    }
}

/// Normal of a half of a micro-quad, outward, of twice its area.
#[inline(always)]
pub(super) fn geometric(points: &Grid3, id: SampleId) -> [f32; 3] {
    let (i, j) = (id.col() as usize, id.row() as usize);
    let middle = match id.half() {
        0 => (i + 1, j),
        _ => (i, j + 1),
    };
    let p = points.get(i, j);
    let (q, r) = (points.get(middle.0, middle.1), points.get(i + 1, j + 1));
    let n = math::cross(math::sub(q, p), math::sub(r, p));
    match id.half() {
        0 => n,
        _ => n.map(|c| -c),
    }
}

/// Of a triangle of a list, by the indices of its points.
pub(super) struct Listed {
    corners: [usize; 3],
    weights: [f32; 3],
}

impl Listed {
    /// The spot of sample `at` (column, row, sample) that shows `id`.
    #[inline]
    pub(super) fn new(
        block: &ProjectedBlock,
        list: &[[u16; 3]],
        id: SampleId,
        [x, y, sample]: [u32; 3],
        samples: u32,
    ) -> Self {
        let corners = list[(id.0 & 2047) as usize].map(usize::from);
        let weights = list_weights(block, corners, x, y, sample, samples);
        Self { corners, weights }
    }
}

impl Spot for Listed {
    #[inline(always)]
    fn mix(&self, a: &[f32]) -> f32 {
        let (k, w) = (self.corners, self.weights);
        (w[0] * a[k[0]] + w[1] * a[k[1]]) + w[2] * a[k[2]]
    }

    fn geometric(&self, points: &Grid3) -> [f32; 3] {
        let [p, q, r] = self
            .corners
            .map(|k| [points.x[k], points.y[k], points.z[k]]);
        math::cross(math::sub(q, p), math::sub(r, p))
    }
}
