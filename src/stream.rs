//! Limit points and normals of a whole surface, block by block, without storing them: what a program needs that wants the points and
//! not a picture. Each thread has its own [`BlockStream`] and buffers, and takes the quads that it likes.

use crate::dice::face::Sides;
use crate::dice::{FacePatch, MAX_LEVEL};
use crate::records::{BlockSize, Grid3};
use crate::simd::Level;
use crate::surface::{QuadPatch, Surface};

/// Dices quads of a surface at one level into blocks.
///
/// ```
/// use earmark::{Cage, Surface, records::Grid3, stream::BlockStream};
///
/// let points = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|b| 2.0 * b as f32 - 1.0)).collect();
/// let corners = vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
/// let surface = Surface::new(Cage::new(points, &[4; 6], corners)?, &Default::default());
/// let mut stream = BlockStream::new(&surface, 6);
/// let (mut points, mut normals) = (Grid3::boxed(), Grid3::boxed());
/// let (mut blocks, mut lowest) = (0, 0.0_f32);
/// for quad in 0..6 {
///     stream.quad(quad, |stream, u, v| {
///         stream.dice(u, v, &mut points, Some(&mut normals));
///         blocks += 1;
///         lowest = lowest.min(points.get(32, 32)[2]);
///     });
/// }
/// assert_eq!(blocks, 6 * 2 * 2);
/// assert!(lowest < -0.6);
/// # Ok::<(), earmark::mesh::CageError>(())
/// ```
#[derive(Clone, Debug)]
pub struct BlockStream<'a> {
    surface: &'a Surface,
    patch: QuadPatch,
    level: u32,
}

impl<'a> BlockStream<'a> {
    /// A stream of the quads of [`Surface::quads`], each of which becomes `4^level` micro-quads.
    ///
    /// # Panics
    /// When `level` is above 10.
    #[must_use]
    pub fn new(surface: &'a Surface, level: u32) -> Self {
        assert!(level <= MAX_LEVEL, "level {level} is above {MAX_LEVEL}");
        surface.ensure(level);
        Self {
            surface,
            patch: QuadPatch::for_level(Level::detect()),
            level,
        }
    }

    /// The same stream with other vector instructions than the strongest of this machine; never changes a bit.
    #[must_use]
    pub fn with_simd(mut self, simd: Level) -> Self {
        self.patch.set_simd(simd);
        self
    }

    /// Blocks along each side of a quad.
    #[must_use]
    pub fn blocks_per_side(&self) -> u32 {
        FacePatch::blocks_per_side(self.level)
    }

    /// Points of a block; neighbouring blocks share those of their common side.
    #[must_use]
    pub fn block_size(&self) -> BlockSize {
        FacePatch::block_size(self.level)
    }

    /// Prepares quad `q` (or triangle; see [`Surface::is_triangular`]) and calls `each` for its blocks, by row and column.
    ///
    /// # Panics
    /// When there is no such quad.
    pub fn quad(&mut self, q: u32, mut each: impl FnMut(&Self, u32, u32)) {
        self.patch
            .prepare_points(self.surface, q, self.level, None, Sides::Normals);
        let n = self.blocks_per_side();
        let triangles = self.surface.is_triangular();
        for v in 0..n {
            for u in if triangles { v } else { 0 }..n {
                each(self, u, v);
            }
        }
    }

    /// Limit points, and unit limit normals where asked for, of block (`u`, `v`) of the quad that was prepared last.
    #[inline]
    pub fn dice(&self, u: u32, v: u32, points: &mut Grid3, normals: Option<&mut Grid3>) {
        self.patch.dice(self.surface, u, v, points, normals);
    }
}
