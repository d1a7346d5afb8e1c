//! Bins: which items may touch which tile. Items are whatever the caller counts (quads, not triangles). Chunks of items are binned
//! in parallel and concatenated in order, so a bin lists its items in ascending order whatever the threads did.

use super::setup::PixelBox;
use crate::records::ScreenSize;
use rayon::prelude::*;

/// Items binned by one task. Fixed, for the work to be cut the same way for any number of threads.
const CHUNK: usize = 4096;

/// The tiles of a picture, row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileGrid {
    side: u32,
    size: [u32; 2],
}

impl TileGrid {
    /// Cuts a picture into tiles of `side` pixels; those at the right and lower border may be smaller.
    ///
    /// # Panics
    /// `side` is 0.
    #[must_use]
    pub fn new(screen: ScreenSize, side: u32) -> Self {
        assert!(side > 0, "tiles of no size");
        Self {
            side,
            size: [screen.width, screen.height],
        }
    }

    /// Side of the tiles in pixels.
    #[must_use]
    pub fn side(&self) -> u32 {
        self.side
    }
    /// Tiles across.
    #[must_use]
    pub fn cols(&self) -> u32 {
        self.size[0].div_ceil(self.side)
    }
    /// Tiles down.
    #[must_use]
    pub fn rows(&self) -> u32 {
        self.size[1].div_ceil(self.side)
    }
    /// Number of tiles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.cols() as usize * self.rows() as usize
    }
    /// The picture has no pixels.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Left, upper, width and height of a tile in pixels.
    #[must_use]
    pub fn rect(&self, tile: usize) -> [u32; 4] {
        let cols = self.cols() as usize;
        let (x, y) = (
            (tile % cols) as u32 * self.side,
            (tile / cols) as u32 * self.side,
        );
        [
            x,
            y,
            self.side.min(self.size[0] - x),
            self.side.min(self.size[1] - y),
        ]
    }

    /// Number of tiles that a box touches.
    pub(crate) fn touches(&self, b: &PixelBox) -> u64 {
        let span = |k: usize| {
            let last = (b.high[k].min(self.size[k]).max(1) - 1) / self.side;
            u64::from((last + 1).saturating_sub(b.low[k] / self.side))
        };
        span(0) * span(1)
    }

    /// Calls `f` for every tile that a box touches.
    #[inline]
    fn touched(&self, b: &PixelBox, mut f: impl FnMut(usize)) {
        let cols = self.cols();
        let last = |k: usize| (b.high[k].min(self.size[k]).max(1) - 1) / self.side;
        if b.low[0] >= self.size[0] || b.low[1] >= self.size[1] {
            return;
        }
        for row in b.low[1] / self.side..=last(1) {
            for col in b.low[0] / self.side..=last(0) {
                f((row * cols + col) as usize);
            }
        }
    }
}

/// Items per tile.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bins {
    /// Where each tile's items begin, and one end more.
    starts: Vec<usize>,
    items: Vec<u32>,
}

impl Bins {
    /// Bins items by their boxes; items without a box are in no bin.
    ///
    /// # Panics
    /// There are more than 2^32 items.
    #[must_use]
    pub fn new(grid: &TileGrid, boxes: &[Option<PixelBox>]) -> Self {
        assert!(u32::try_from(boxes.len()).is_ok(), "too many items");
        let chunks: Vec<Self> = boxes
            .par_chunks(CHUNK)
            .enumerate()
            .map(|(k, boxes)| Self::of_chunk(grid, (k * CHUNK) as u32, boxes))
            .collect();
        if let [one] = chunks.as_slice() {
            return one.clone();
        }
        let mut out = Self {
            starts: Vec::with_capacity(grid.len() + 1),
            items: Vec::with_capacity(chunks.iter().map(|c| c.items.len()).sum()),
        };
        out.starts.push(0);
        for tile in 0..grid.len() {
            for chunk in &chunks {
                out.items.extend_from_slice(chunk.items(tile));
            }
            out.starts.push(out.items.len());
        }
        out
    }

    /// Counting sort: sizes, then starts, then items.
    fn of_chunk(grid: &TileGrid, first: u32, boxes: &[Option<PixelBox>]) -> Self {
        let mut starts = vec![0; grid.len() + 1];
        for b in boxes.iter().flatten() {
            grid.touched(b, |tile| starts[tile + 1] += 1);
        }
        for tile in 0..grid.len() {
            starts[tile + 1] += starts[tile];
        }
        let mut next = starts.clone();
        let mut items = vec![0; starts[grid.len()]];
        for (item, b) in (first..).zip(boxes) {
            if let Some(b) = b {
                grid.touched(b, |tile| {
                    items[next[tile]] = item;
                    next[tile] += 1;
                });
            }
        }
        Self { starts, items }
    }

    /// Items of a tile, ascending.
    #[must_use]
    pub fn items(&self, tile: usize) -> &[u32] {
        &self.items[self.starts[tile]..self.starts[tile + 1]]
    }

    /// Entries of all bins together: items count once for every tile that they touch.
    #[must_use]
    pub fn total(&self) -> usize {
        self.items.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_hold_what_touches_in_order() {
        let screen = ScreenSize {
            width: 300,
            height: 170,
            samples: 1,
        };
        let grid = TileGrid::new(screen, 64);
        assert_eq!((grid.cols(), grid.rows(), grid.len()), (5, 3, 15));
        assert_eq!(grid.rect(14), [256, 128, 44, 42]);
        let boxes: Vec<Option<PixelBox>> = (0..10_000_u32)
            .map(|k| {
                let x = k.wrapping_mul(2_654_435_761) % 290;
                let y = k.wrapping_mul(40_503) % 160;
                (k % 7 != 0).then_some(PixelBox {
                    low: [x, y],
                    high: [x + 1 + k % 90, y + 1 + k % 50],
                    nearest: 1.0,
                })
            })
            .collect();
        let bins = Bins::new(&grid, &boxes);
        let mut total = 0;
        for tile in 0..grid.len() {
            let [x, y, width, height] = grid.rect(tile);
            let want: Vec<u32> = (0..boxes.len() as u32)
                .filter(|&k| {
                    boxes[k as usize].is_some_and(|b| {
                        b.low[0] < x + width
                            && b.high[0] > x
                            && b.low[1] < y + height
                            && b.high[1] > y
                    })
                })
                .collect();
            assert_eq!(bins.items(tile), want);
            total += want.len();
        }
        assert_eq!(bins.total(), total);
    }
}
