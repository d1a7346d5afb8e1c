//! The points of a part in one row: what is done in lanes has no ends of rows, and of a triangle's half nothing above the diagonal.

use crate::dice::face::Part;
use crate::records::{BLOCK_LEN, BLOCK_STRIDE, Grid3};
use crate::simd::LANES;
use std::ops::Range;

/// Where the points of a part stand, row by row. A grid that holds them in this order is *packed*.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    side: usize,
    /// Only the points with column ≥ row; the others repeat the diagonal.
    half: bool,
}

impl Layout {
    pub(super) fn of(part: Part, triangle: bool) -> Self {
        Self {
            side: part.segments as usize + 1,
            half: triangle && part.start[0] == part.start[1],
        }
    }

    pub(super) fn rows(self) -> Range<usize> {
        0..self.side
    }

    /// Columns of row `j`.
    pub(super) fn columns(self, j: usize) -> Range<usize> {
        if self.half {
            j..self.side
        } else {
            0..self.side
        }
    }

    /// Place of the first point of row `j`.
    pub(super) fn first(self, j: usize) -> usize {
        match self.half {
            true => j * self.side - j * j.saturating_sub(1) / 2,
            false => j * self.side,
        }
    }

    /// Number of points.
    pub(super) fn count(self) -> usize {
        self.first(self.side)
    }

    /// Place of a point.
    pub(super) fn place(self, [i, j]: [usize; 2]) -> usize {
        // Above the diagonal is what is on it.
        self.first(j) + i.saturating_sub(self.columns(j).start)
    }

    /// Packs a grid; what fills the last vector is zeros.
    pub(super) fn pack(self, from: &Grid3, to: &mut Grid3) {
        let count = self.count();
        let end = count.next_multiple_of(LANES).min(BLOCK_LEN);
        for (from, to) in [
            (&from.x, &mut to.x),
            (&from.y, &mut to.y),
            (&from.z, &mut to.z),
        ] {
            for j in self.rows() {
                let columns = self.columns(j);
                let row = &from[j * BLOCK_STRIDE + columns.start..];
                copy(row, &mut to[self.first(j)..], columns.len());
            }
            to[count..end].fill(0.0);
        }
    }

    /// Unpacks a grid.
    pub(super) fn unpack(self, from: &Grid3, to: &mut Grid3) {
        for (from, to) in [
            (&from.x, &mut to.x),
            (&from.y, &mut to.y),
            (&from.z, &mut to.z),
        ] {
            for j in self.rows() {
                let columns = self.columns(j);
                let row = &from[self.first(j)..];
                let to = &mut to[j * BLOCK_STRIDE..];
                to[..columns.start].fill(row[0]);
                copy(row, &mut to[columns.start..], columns.len());
            }
        }
    }
}

/// Copies `n` numbers, and what follows them up to a whole vector: nothing that is needed stands there yet.
#[inline(always)]
fn copy(from: &[f32], to: &mut [f32], n: usize) {
    let (from, _) = from.as_chunks::<LANES>();
    let (to, _) = to.as_chunks_mut::<LANES>();
    for (to, from) in to.iter_mut().zip(from).take(n.div_ceil(LANES)) {
        *to = *from;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_follow_each_other_and_come_back() {
        for (segments, start) in [
            (0, [0, 0]),
            (1, [0, 0]),
            (4, [8, 8]),
            (32, [32, 0]),
            (32, [0, 0]),
        ] {
            for triangle in [false, true] {
                let part = Part {
                    level: 7,
                    start,
                    segments,
                };
                let layout = Layout::of(part, triangle);
                let (mut grid, mut packed, mut back) =
                    (Grid3::boxed(), Grid3::boxed(), Grid3::boxed());
                let side = segments as usize + 1;
                let mut next = 0;
                for j in 0..side {
                    for i in 0..side {
                        // As dicing folds it.
                        let i = if layout.half { i.max(j) } else { i };
                        grid.set(i, j, [i as f32, j as f32, 1.0]);
                    }
                    for i in layout.columns(j) {
                        assert_eq!(layout.place([i, j]), next);
                        next += 1;
                    }
                }
                assert_eq!(layout.count(), next);
                layout.pack(&grid, &mut packed);
                layout.unpack(&packed, &mut back);
                for j in 0..side {
                    for i in 0..side {
                        let on = if layout.half { i.max(j) } else { i };
                        assert_eq!(back.get(i, j), [on as f32, j as f32, 1.0]);
                        assert_eq!(packed.at(layout.place([i, j])), back.get(i, j));
                    }
                }
            }
        }
    }
}
