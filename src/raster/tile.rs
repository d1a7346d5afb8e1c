//! Tiles of visibility samples. A tile is a rectangle of pixels with one cell per sample; [`Cell`] says what a hit does to it, so
//! that the same rasteriser writes visibility keys for pictures and counts for tests.
//!
//! Cells stand sample plane by sample plane, row by row, and every row ends in an apron of [`APRON`] unused cells, so that vectors
//! of pixels may overrun the right border unmasked. A tile at its usual size fits the level 2 cache of a core.

use super::setup::PixelBox;
use crate::dispatch;
use crate::records::SampleId;
use crate::simd::{LANES, Level};

/// Unused cells at the end of every row of a tile.
pub(super) const APRON: usize = LANES;

/// More cells than there are from any to the next cache line.
const LINE: usize = 8;

/// Side in pixels of the tiles that frames are cut into. It trades blocks diced twice at tile borders against the cache, so tiles are larger
/// where dicing costs more than the samples of a tile; it never changes a pixel.
#[must_use]
pub fn tile_side(samples: u32, is_costly: bool) -> u32 {
    match (samples, is_costly) {
        (0..=1, _) => 256,
        (2..=4, false) => 128,
        (2..=4, true) => 256,
        (_, false) => 64,
        (_, true) => 128,
    }
}

/// What stands at a sample of a tile.
pub trait Cell: Copy + Default {
    /// Takes note of one covered sample, or, where `hit` is false, of none. `front`: the triangle is seen counter-clockwise.
    fn put(&mut self, hit: bool, depth: f32, id: u32, front: bool);
    /// What a hit does, worked out beforehand.
    type Packed: Copy + Default;
    /// For [`Cell::put_packed`].
    fn pack(depth: f32, id: u32, front: bool) -> Self::Packed;
    /// [`Cell::put`] of a hit.
    fn put_packed(&mut self, hit: Self::Packed);
}

/// Visibility key: the bits of the depth above the complement of the id; 0 where nothing was drawn.
///
/// Depths are positive, so their bits are in the order of their values and the nearest surface has the largest key. Among equal
/// depths **the lower id wins**. A maximum has no order, so a picture cannot depend on the order of drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key(pub u64);

impl Key {
    /// Nothing was drawn here.
    pub const EMPTY: Self = Self(0);

    /// The key of a surface.
    #[must_use]
    #[inline(always)]
    pub const fn new(depth: f32, id: SampleId) -> Self {
        Self((depth.to_bits() as u64) << 32 | !id.0 as u64)
    }

    /// Depth of the nearest surface, 0 where there is none.
    #[must_use]
    #[inline(always)]
    pub const fn depth(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    /// Id of the nearest surface.
    #[must_use]
    #[inline(always)]
    pub const fn id(self) -> Option<SampleId> {
        if self.0 == 0 {
            None
        } else {
            Some(SampleId(!(self.0 as u32)))
        }
    }
}

impl Cell for Key {
    #[inline(always)]
    fn put(&mut self, hit: bool, depth: f32, id: u32, front: bool) {
        self.put_packed(if hit { Self::pack(depth, id, front) } else { 0 });
    }

    type Packed = u64;

    #[inline(always)]
    fn pack(depth: f32, id: u32, _front: bool) -> u64 {
        u64::from(depth.to_bits()) << 32 | u64::from(!id)
    }

    #[inline(always)]
    fn put_packed(&mut self, key: u64) {
        // Both are below 2^63; signed order is the one that vectors of 64 bits have an instruction for. Stored in any case, as
        // conditional stores do not vectorise.
        self.0 = (self.0 as i64).max(key as i64) as u64;
    }
}

/// Counts instead of keys: how often a sample is covered. For tests of coverage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Coverage {
    /// Triangles over the sample.
    pub hits: i32,
    /// Triangles seen from the front less those seen from behind: 0 everywhere for a closed surface.
    pub balance: i32,
}

impl Cell for Coverage {
    #[inline(always)]
    fn put(&mut self, hit: bool, _depth: f32, _id: u32, front: bool) {
        self.hits += i32::from(hit);
        self.balance += i32::from(hit & front) - i32::from(hit & !front);
    }

    /// Whether the front is seen.
    type Packed = bool;

    #[inline(always)]
    fn pack(_depth: f32, _id: u32, front: bool) -> bool {
        front
    }

    #[inline(always)]
    fn put_packed(&mut self, front: bool) {
        self.put(true, 0.0, 0, front);
    }
}

/// A rectangle of pixels with a cell per sample.
#[derive(Clone, Debug)]
pub struct Tile<C = Key> {
    pub(super) x0: i32,
    pub(super) y0: i32,
    pub(super) width: i32,
    pub(super) height: i32,
    samples: u32,
    pub(super) stride: usize,
    pub(super) cells: Vec<C>,
    /// Where the first row begins: at a cache line.
    base: usize,
}

impl<C: Cell> Tile<C> {
    /// An empty tile whose upper left pixel is (`x0`, `y0`). Pixels must lie below 16384 in both directions.
    ///
    /// # Panics
    /// A pixel is out of that range, or `samples` is not 1, 4, 8 or 16.
    #[must_use]
    pub fn new(x0: u32, y0: u32, width: u32, height: u32, samples: u32) -> Self {
        let mut tile = Self {
            x0: 0,
            y0: 0,
            width: 0,
            height: 0,
            samples,
            stride: 0,
            cells: Vec::new(),
            base: 0,
        };
        tile.place(x0, y0, width, height, samples);
        tile
    }

    /// Moves the tile and empties it, keeping its memory.
    ///
    /// # Panics
    /// As [`Tile::new`].
    pub fn place(&mut self, x0: u32, y0: u32, width: u32, height: u32, samples: u32) {
        assert!(
            matches!(samples, 1 | 4 | 8 | 16),
            "{samples} samples per pixel"
        );
        let limit = super::MAX_SCREEN;
        assert!(
            x0 <= limit && y0 <= limit && width <= limit - x0 && height <= limit - y0,
            "tile outside the screen"
        );
        (self.x0, self.y0) = (x0 as i32, y0 as i32);
        (self.width, self.height) = (width as i32, height as i32);
        self.samples = samples;
        self.stride = width as usize + APRON;
        self.cells.clear();
        let len = self.stride * height as usize * samples as usize;
        self.cells.resize(len + LINE, C::default());
        self.base = self.cells.as_ptr().align_offset(64).min(LINE);
    }

    /// Empties every cell.
    pub fn clear(&mut self) {
        self.cells.fill(C::default());
    }

    /// Upper left pixel.
    #[must_use]
    pub fn origin(&self) -> [u32; 2] {
        [self.x0 as u32, self.y0 as u32]
    }
    /// Pixels across and down.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.width as u32, self.height as u32]
    }
    /// Samples per pixel.
    #[must_use]
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Sample `sample` of all pixels of row `y`, which counts from the tile's upper border.
    #[must_use]
    #[inline]
    pub fn row(&self, y: u32, sample: u32) -> &[C] {
        let at = self.plane(sample as usize) + y as usize * self.stride;
        &self.cells[at..at + self.width as usize]
    }

    /// [`Tile::row`], filled up to whole vectors with cells of the apron. What these hold means nothing.
    #[must_use]
    #[inline]
    pub(crate) fn padded_row(&self, y: u32, sample: u32) -> &[C] {
        let at = self.plane(sample as usize) + y as usize * self.stride;
        &self.cells[at..at + (self.width as usize).next_multiple_of(LANES)]
    }

    /// The cell at a sample; `x` and `y` count from the tile's upper left pixel.
    #[must_use]
    #[inline]
    pub fn cell(&self, x: u32, y: u32, sample: u32) -> C {
        self.row(y, sample)[x as usize]
    }

    #[inline(always)]
    pub(super) fn plane(&self, sample: usize) -> usize {
        self.base + sample * self.height as usize * self.stride
    }
}

impl Tile<Key> {
    /// Lets one more surface take part at a sample; `x` and `y` count from the tile's upper left pixel.
    pub fn merge(&mut self, x: u32, y: u32, sample: u32, key: Key) {
        let at = self.plane(sample as usize) + y as usize * self.stride + x as usize;
        self.cells[at] = self.cells[at].max(key);
    }

    /// Whether something nearer than all of a box's depths stands at every sample of the box in the tile: a surface inside the hull
    /// that the box was made of changes nothing then.
    #[must_use]
    pub fn hides(&self, level: Level, hull: &PixelBox) -> bool {
        let clip = |v: u32, from: i32, size: i32| (v as i32 - from).clamp(0, size) as usize;
        let [x0, x1] = [hull.low[0], hull.high[0]].map(|x| clip(x, self.x0, self.width));
        let [y0, y1] = [hull.low[1], hull.high[1]].map(|y| clip(y, self.y0, self.height));
        if x0 >= x1 || y0 >= y1 {
            return true;
        }
        // The largest key at that depth: ids decide among equals, so the sample must be nearer.
        let most = u64::from(hull.nearest.to_bits()) << 32 | 0xffff_ffff;
        (0..self.samples as usize).all(|s| {
            let at = self.plane(s) + y0 * self.stride + x0;
            let (rows, len) = (y1 - y0, x1 - x0);
            dispatch!(
                level,
                all_above(&self.cells[at..], self.stride, rows, len, most)
            )
        })
    }

    /// Gives every sample that shows something the id that `f` makes of its own; depths stay.
    pub fn update_ids(&mut self, mut f: impl FnMut(SampleId) -> SampleId) {
        for cell in &mut self.cells {
            if let Some(id) = cell.id() {
                *cell = Key::new(cell.depth(), f(id));
            }
        }
    }
}

/// Whether the first `len` keys of all rows are above `most`.
#[inline(always)]
fn all_above(cells: &[Key], stride: usize, rows: usize, len: usize, most: u64) -> bool {
    for row in 0..rows {
        // Both below 2^63: the signed comparison is the one that vectors have.
        let mut least = i64::MAX;
        for key in &cells[row * stride..row * stride + len] {
            least = least.min(key.0 as i64);
        }
        if least <= most as i64 {
            return false;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_behind_every_sample_is_hidden() {
        let mut tile = Tile::<Key>::new(64, 0, 32, 16, 4);
        let hull = |low: [u32; 2], high: [u32; 2], nearest| PixelBox { low, high, nearest };
        let all = hull([0, 0], [100, 100], 0.5);
        for sample in 0..4 {
            for y in 0..16 {
                for x in 0..32 {
                    tile.merge(x, y, sample, Key::new(0.6, SampleId(7)));
                }
            }
        }
        for level in Level::available() {
            assert!(tile.hides(level, &all));
            // Among equal depths the id decides, so nothing is hidden.
            assert!(!tile.hides(level, &hull([0, 0], [100, 100], 0.6)));
            assert!(!tile.hides(level, &hull([0, 0], [100, 100], f32::MAX)));
            // Beside the tile.
            assert!(tile.hides(level, &hull([0, 0], [64, 100], 9.0)));
        }
        // One sample that shows nothing.
        let at = tile.plane(3) + 5 * tile.stride + 9;
        tile.cells[at] = Key::EMPTY;
        for level in Level::available() {
            assert!(!tile.hides(level, &all));
            assert!(!tile.hides(level, &hull([73, 5], [74, 6], 0.5)));
            assert!(tile.hides(level, &hull([74, 5], [90, 6], 0.5)));
            assert!(tile.hides(level, &hull([64, 6], [96, 16], 0.5)));
        }
    }

    #[test]
    fn keys_order_by_depth_then_lower_id() {
        let key = |depth, id| Key::new(depth, SampleId(id));
        assert!(key(0.5, 7) > key(0.25, 0));
        assert!(key(0.5, 3) > key(0.5, 4));
        assert!(key(f32::MIN_POSITIVE, u32::MAX) > Key::EMPTY);
        let mut cell = Key::EMPTY;
        for (depth, id) in [(0.5, 9), (0.5, 2), (0.25, 1), (0.5, 5)] {
            cell.put(true, depth, id, true);
        }
        cell.put(false, 9.0, 0, true);
        assert_eq!((cell.depth(), cell.id()), (0.5, Some(SampleId(2))));
        assert_eq!(Key::EMPTY.id(), None);
    }
}
