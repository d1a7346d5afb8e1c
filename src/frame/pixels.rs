//! Pixels of a tile in the making.

use super::Frame;
use super::tile::Scratch;
use super::visible::Fragment;
use std::ops::Range;

/// Colours of fragments on their way to pixels.
#[derive(Debug, Default)]
pub(super) struct Pixels {
    /// Pixels of the tile, row by row.
    pub(super) bytes: Vec<[u8; 4]>,
    /// Where a pixel has several samples: their colours added up.
    pub(super) sums: Vec<[f32; 4]>,
    pub(super) width: usize,
}

impl Pixels {
    /// Makes the pixels of a tile empty, as far as spans of its rows reach; no others are read.
    pub(super) fn clear(&mut self, width: u32, spans: &[[u32; 2]], several: bool, empty: [u8; 4]) {
        self.width = width as usize;
        let len = self.width * spans.len();
        if self.bytes.len() < len {
            self.bytes.resize(len, empty);
        }
        if several && self.sums.len() < len {
            self.sums.resize(len, [0.0; 4]);
        }
        for (y, &[low, high]) in (0..).zip(spans) {
            let range = self.range(y, low, high);
            if several {
                self.sums[range.clone()].fill([0.0; 4]);
            }
            self.bytes[range].fill(empty);
        }
    }

    #[inline(always)]
    fn range(&self, y: usize, low: u32, high: u32) -> Range<usize> {
        let row = y * self.width;
        // Spans of empty rows end before they begin.
        row + low.min(high) as usize..row + high as usize
    }

    /// Pixels of a row.
    pub(super) fn row(&self, y: usize, low: u32, high: u32) -> &[[u8; 4]] {
        &self.bytes[self.range(y, low, high)]
    }

    #[inline(always)]
    pub(super) fn index(&self, f: Fragment) -> usize {
        f.y() as usize * self.width + f.x() as usize
    }
}

/// Averages the samples of pixels that have several; those that are of one colour have their bytes.
pub(super) fn resolve(frame: &Frame<'_>, s: &mut Scratch) {
    let samples = frame.size.samples;
    if samples == 1 {
        return;
    }
    let share = 1.0 / samples as f32;
    for (y, &[low, high]) in s.visible.spans.iter().enumerate() {
        let range = s.pixels.range(y, low, high);
        let sums = &s.pixels.sums[range.clone()];
        for (sum, pixel) in sums.iter().zip(&mut s.pixels.bytes[range]) {
            if sum[3] > 0.0 {
                *pixel = frame.film.pixel(sum.map(|c| c * share));
            }
        }
    }
}
