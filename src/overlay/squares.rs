//! Squares over a rectangle of pixels, and what is in each: so that nobody looks at all lines for those of a place.

use super::lines::Segment;

/// Squares of one side that cover a rectangle of pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Squares {
    origin: [f64; 2],
    side: f64,
    /// Across and down.
    count: [usize; 2],
}

impl Squares {
    /// Squares of `side` pixels over a rectangle with its upper left corner and its size.
    pub(super) fn new(origin: [f64; 2], size: [f64; 2], side: f64) -> Self {
        Self {
            origin,
            side,
            count: size.map(|s| (s / side).ceil().max(1.0) as usize),
        }
    }

    /// Number of squares.
    pub(super) fn len(&self) -> usize {
        self.count[0] * self.count[1]
    }

    /// Index of a square by its column and row.
    pub(super) fn index(&self, x: usize, y: usize) -> usize {
        y * self.count[0] + x
    }

    /// First and last square of a box: columns and rows. Where the box is outside, the squares at the border.
    pub(super) fn range(&self, low: [f64; 2], high: [f64; 2]) -> [[usize; 2]; 2] {
        let square = |v: f64, k: usize| {
            let c = ((v - self.origin[k]) / self.side).floor().max(0.0) as usize;
            c.min(self.count[k] - 1)
        };
        [
            [square(low[0], 0), square(low[1], 1)],
            [square(high[0], 0), square(high[1], 1)],
        ]
    }

    /// The squares that a stretch of a line goes through, row by row, and those as near as `slack` pixels; `[low, high]` is the box of the
    /// stretch.
    pub(super) fn through(
        &self,
        line: &Segment,
        stretch: [f64; 2],
        [low, high]: [[f64; 2]; 2],
        slack: f64,
        visit: &mut dyn FnMut(usize),
    ) {
        let [first, last] = self.range(low, high);
        let (a, b) = (line.a, line.b);
        for y in first[1]..=last[1] {
            let [mut from, mut to] = stretch;
            if first[1] < last[1] {
                let top = self.origin[1] + y as f64 * self.side - slack;
                let bottom = top + self.side + 2.0 * slack;
                let [t0, t1] = [top, bottom].map(|v| (v - a[1]) / (b[1] - a[1]));
                from = from.max(t0.min(t1));
                to = to.min(t0.max(t1));
            }
            let [x0, x1] = [from, to].map(|t| a[0] + (b[0] - a[0]) * t);
            let low = [x0.min(x1) - slack, low[1]];
            let high = [x0.max(x1) + slack, high[1]];
            let [low, high] = self.range(low, high);
            for x in low[0]..=high[0] {
                visit(self.index(x, y));
            }
        }
    }
}

/// Numbers by square.
#[derive(Default)]
pub(super) struct Cells {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Cells {
    /// Sorts numbers below `items` into cells; `each` says which cells one is in, less than 2³² in all.
    pub(super) fn new(
        cells: usize,
        items: usize,
        each: impl Fn(usize, &mut dyn FnMut(usize)),
    ) -> Self {
        let mut starts = vec![0_u32; cells + 1];
        for k in 0..items {
            each(k, &mut |c| starts[c + 1] += 1);
        }
        for c in 0..cells {
            starts[c + 1] += starts[c];
        }
        let mut next = starts.clone();
        let mut found = vec![0; starts[cells] as usize];
        for k in 0..items {
            each(k, &mut |c| {
                found[next[c] as usize] = k as u32;
                next[c] += 1;
            });
        }
        Self {
            starts,
            items: found,
        }
    }

    /// The numbers in a cell, in order.
    pub(super) fn of(&self, cell: usize) -> &[u32] {
        &self.items[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    /// How often numbers are in cells.
    pub(super) fn len(&self) -> usize {
        self.items.len()
    }
}
