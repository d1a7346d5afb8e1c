//! Plain data between the stages: what `dice` hands to `raster`, and what `raster` hands to `shade`.
//!
//! A *block* is a grid of at most 33×33 points (32×32 micro-quads); it is the unit that is diced, culled, rasterised and shaded.

/// Most points along one side of a block.
pub const BLOCK_POINTS: usize = 33;
/// Points from one row of a block to the next. 33 rounded up to a multiple of 16, so that 16 lanes may overrun a row.
pub const BLOCK_STRIDE: usize = 48;
/// Length of one component array of a block.
pub const BLOCK_LEN: usize = BLOCK_POINTS * BLOCK_STRIDE;

/// One three-component quantity over the points of a block, component by component (structure of arrays).
///
/// The point in column `i` and row `j` stands at index `j * BLOCK_STRIDE + i`. Entries beyond `cols` hold finite but
/// meaningless values.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Grid3 {
    /// First component.
    pub x: [f32; BLOCK_LEN],
    /// Second component.
    pub y: [f32; BLOCK_LEN],
    /// Third component.
    pub z: [f32; BLOCK_LEN],
}

impl Grid3 {
    /// A grid of zeros, on the heap (19 KB).
    #[must_use]
    pub fn boxed() -> Box<Self> {
        Box::new(Self {
            x: [0.0; BLOCK_LEN],
            y: [0.0; BLOCK_LEN],
            z: [0.0; BLOCK_LEN],
        })
    }

    /// The point in column `i` and row `j`.
    #[must_use]
    #[inline]
    pub fn get(&self, i: usize, j: usize) -> [f32; 3] {
        let k = j * BLOCK_STRIDE + i;
        [self.x[k], self.y[k], self.z[k]]
    }

    /// The point at place `k` of the component arrays.
    #[inline]
    pub(crate) fn at(&self, k: usize) -> [f32; 3] {
        [self.x[k], self.y[k], self.z[k]]
    }

    /// Sets the point at place `k` of the component arrays.
    #[inline]
    pub(crate) fn put(&mut self, k: usize, p: [f32; 3]) {
        (self.x[k], self.y[k], self.z[k]) = (p[0], p[1], p[2]);
    }

    /// Sets the point in column `i` and row `j`.
    #[inline]
    pub fn set(&mut self, i: usize, j: usize, p: [f32; 3]) {
        let k = j * BLOCK_STRIDE + i;
        self.x[k] = p[0];
        self.y[k] = p[1];
        self.z[k] = p[2];
    }
}

/// Size of a block in points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockSize {
    /// Points along u, 2 to 33.
    pub cols: usize,
    /// Points along v, 2 to 33.
    pub rows: usize,
}

impl BlockSize {
    /// Places of all points in the component arrays of a [`Grid3`], row by row.
    #[inline]
    pub(crate) fn indices(self) -> impl Iterator<Item = usize> {
        (0..self.rows).flat_map(move |j| j * BLOCK_STRIDE..j * BLOCK_STRIDE + self.cols)
    }
}

/// Id of a visibility sample: which block of the tile, which micro-quad of the block, which half of the micro-quad.
///
/// | bits | meaning |
/// |---|---|
/// | 31…11 | rank of the block in the tile, in (face, block) order |
/// | 10…6 | row of the micro-quad, 0 to 31 |
/// | 5…1 | column of the micro-quad, 0 to 31 |
/// | 0 | half: 0 on the side of (i+1, j), 1 on the side of (i, j+1) |
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SampleId(pub u32);

impl SampleId {
    /// Number of block ranks that are given: one less than fits, because the complement of an empty sample looks like the last.
    pub const MAX_BLOCKS: u32 = (1 << 21) - 1;

    /// Packs an id. `rank` must be below [`SampleId::MAX_BLOCKS`], `col` and `row` below 32, `half` 0 or 1.
    #[must_use]
    #[inline]
    pub const fn new(rank: u32, col: u32, row: u32, half: u32) -> Self {
        Self(rank << 11 | row << 6 | col << 1 | half)
    }
    /// Rank of the block in the tile.
    #[must_use]
    #[inline]
    pub const fn rank(self) -> u32 {
        self.0 >> 11
    }
    /// Column of the micro-quad.
    #[must_use]
    #[inline]
    pub const fn col(self) -> u32 {
        (self.0 >> 1) & 31
    }
    /// Row of the micro-quad.
    #[must_use]
    #[inline]
    pub const fn row(self) -> u32 {
        (self.0 >> 6) & 31
    }
    /// Half of the micro-quad.
    #[must_use]
    #[inline]
    pub const fn half(self) -> u32 {
        self.0 & 1
    }
}

/// The map from model space to the screen, ready for the rasteriser. Row-major; each row is multiplied with (x, y, z, 1) as
/// `((r0*x + r1*y) + (r2*z + r3))`, in this order, nothing fused.
///
/// Perspective: `X/W`, `Y/W` are the screen position in units of 1/256 pixel, y down; depth is `1/W`; visible where `W >= near`.
/// Orthographic: `W` is 1 and its row (0, 0, 0, 1); depth is the `d` row, `1 + (far - z)/(far - near)`; visible where depth <= 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Row of X.
    pub x: [f32; 4],
    /// Row of Y.
    pub y: [f32; 4],
    /// Row of W: distance along the view axis in perspective, in model units.
    pub w: [f32; 4],
    /// Row of the depth of an orthographic view; unused in perspective.
    pub d: [f32; 4],
    /// Near distance, above 0 in perspective.
    pub near: f32,
    /// Orthographic view.
    pub ortho: bool,
}

/// Size of the picture and its samples per pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScreenSize {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples per pixel: 1, 4, 8 or 16.
    pub samples: u32,
}
