//! Squares of bicubic B-splines, two by two, over one net of control points.
//!
//! A quad with four regular corners is one spline. Any other is a sheet of its once-refined net, with a spline at each regular corner, and
//! towards every irregular corner a sheet per step, half as wide as the one before and with splines in all quadrants but the corner's own.

use super::basis::Target;
use super::net::Net;
use super::point::P4;
use std::ops::{Deref, DerefMut};

/// Up to four B-splines over neighbouring squares of a face's grid.
#[derive(Clone, Debug)]
pub(crate) struct Sheet {
    /// Control points, row by row; `net[1][1]` belongs to the origin, `net[3][3]` is diagonally across the middle.
    pub(crate) net: Net<5>,
    /// Grid column and row of the origin.
    pub(crate) origin: [u32; 2],
    /// Grid segments along each side of a quadrant; 0 for the origin alone.
    pub(crate) size: u32,
    /// Refinement steps that the quadrants' nets have still to go.
    pub(crate) level: u32,
    /// Corner of the face that the sheet leads to; also the quadrant before the first in rank.
    pub(crate) corner: usize,
    /// Which quadrants are splines, bit by bit, in the order of a face's corners.
    pub(crate) present: u8,
    /// First and last grid column and row that no wider sheet of the same face shows.
    pub(crate) own: [[u32; 2]; 2],
}

/// The control points of a B-spline, row by row.
pub(super) type Rows<'a> = [&'a [P4; 4]; 4];

/// The 16 control points from row `at[0]` and column `at[1]` on, each 0 or 1.
#[inline(always)]
pub(super) fn rows(net: &Net<5>, [row, col]: [usize; 2]) -> Rows<'_> {
    let lines = match row {
        0 => &net[..4],
        _ => &net[1..],
    };
    let part = |line| -> &[P4; 4] {
        let ([first @ .., _], [_, last @ ..]): (&[P4; 5], &[P4; 5]) = (line, line);
        if col == 0 { first } else { last }
    };
    [
        part(&lines[0]),
        part(&lines[1]),
        part(&lines[2]),
        part(&lines[3]),
    ]
}

/// A quadrant of a sheet: one B-spline.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quadrant<'a> {
    pub(super) sheet: &'a Sheet,
    /// Row and column of its control points in the sheet's net.
    pub(super) at: [usize; 2],
    pub(super) origin: [u32; 2],
    /// First and last column and row that no quadrant of higher rank and no wider sheet shows.
    pub(super) own: [[u32; 2]; 2],
}

/// Row and column of the quadrants, in the order of a face's corners.
const PLACES: [[usize; 2]; 4] = [[0, 0], [0, 1], [1, 1], [1, 0]];

/// Whether a face's corner is at the high end along u and v.
pub(super) const HIGH: [[bool; 2]; 4] =
    [[false, false], [true, false], [true, true], [false, true]];

/// The sheets of a face, in room that is used again: their nets are made where they stay.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sheets {
    room: Vec<Sheet>,
    used: usize,
}

impl Sheets {
    pub(super) fn clear(&mut self) {
        self.used = 0;
    }

    /// One more, which holds what was there before.
    #[inline(always)]
    pub(super) fn add(&mut self) -> &mut Sheet {
        if self.used == self.room.len() {
            self.room.push(Sheet::EMPTY);
        }
        self.used += 1;
        &mut self.room[self.used - 1]
    }
}

impl Deref for Sheets {
    type Target = [Sheet];

    #[inline(always)]
    fn deref(&self) -> &[Sheet] {
        &self.room[..self.used]
    }
}

impl DerefMut for Sheets {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [Sheet] {
        &mut self.room[..self.used]
    }
}

impl Sheet {
    const EMPTY: Self = Self {
        net: [[P4::ZERO; 5]; 5],
        origin: [0; 2],
        size: 0,
        level: 0,
        corner: 0,
        present: 0,
        own: [[0; 2]; 2],
    };

    /// Makes it one spline, with its net in the first rows and columns: over a whole grid of `2^level` segments.
    #[inline(always)]
    pub(super) fn be_whole(&mut self, level: u32) {
        self.be_single([0, 0], 1 << level, level);
    }

    /// The same over a part of a grid; for `size` 0 the first corner.
    #[inline(always)]
    pub(super) fn be_single(&mut self, origin: [u32; 2], size: u32, level: u32) {
        self.origin = origin;
        self.size = size;
        self.level = level;
        self.corner = 0;
        self.present = 1;
        self.own = [origin, origin.map(|k| k + size)];
    }

    #[inline(always)]
    pub(super) fn has(&self, quadrant: usize) -> bool {
        self.present >> quadrant & 1 != 0
    }

    /// Where two quadrants meet the one of lower rank number is seen.
    #[inline(always)]
    fn rank(&self, quadrant: usize) -> usize {
        (quadrant + 4 - self.corner) & 3
    }

    /// Row and column of a quadrant in the net, and its origin.
    #[inline(always)]
    pub(super) fn place(&self, q: usize) -> ([usize; 2], [u32; 2]) {
        let [row, col] = PLACES[q];
        let origin = [
            self.origin[0] + col as u32 * self.size,
            self.origin[1] + row as u32 * self.size,
        ];
        ([row, col], origin)
    }

    #[inline(always)]
    pub(super) fn quadrant(&self, q: usize) -> Quadrant<'_> {
        let ([row, col], origin) = self.place(q);
        let (mut low, mut high) = (origin, origin.map(|k| k + self.size));
        // The neighbours along u and along v.
        for (k, (other, second)) in [(q ^ 1, col == 1), (3 - q, row == 1)]
            .into_iter()
            .enumerate()
        {
            if self.has(other) && self.rank(other) < self.rank(q) {
                if second {
                    low[k] += 1;
                } else {
                    high[k] -= 1;
                }
            }
            low[k] = low[k].max(self.own[0][k]);
            high[k] = high[k].min(self.own[1][k]);
        }
        Quadrant {
            sheet: self,
            at: [row, col],
            origin,
            own: [low, high],
        }
    }

    /// All splines, in no order that matters.
    pub(super) fn quadrants(&self) -> impl Iterator<Item = Quadrant<'_>> {
        (0..4).filter(|&q| self.has(q)).map(|q| self.quadrant(q))
    }

    /// Moves the sheet over the grid of a larger face.
    pub(super) fn shift(&mut self, by: [u32; 2]) {
        let [low, high] = &mut self.own;
        for place in [&mut self.origin, low, high] {
            *place = [place[0] + by[0], place[1] + by[1]];
        }
    }
}

impl Quadrant<'_> {
    /// Its 16 control points, where they stand.
    #[inline(always)]
    pub(super) fn net(&self) -> Rows<'_> {
        rows(&self.sheet.net, self.at)
    }

    /// Points whose convex hull holds the diced points between the given columns and rows (in units of the quadrant's size).
    pub(super) fn hull(
        &self,
        target: Target,
        u: [f32; 2],
        v: [f32; 2],
        out: &mut impl FnMut([f32; 3]),
    ) {
        let net = self.net();
        if target == Target::Refined {
            net.into_iter().flatten().for_each(|p| out(p.xyz()));
            return;
        }
        let along_u: Net<4> = std::array::from_fn(|r| bezier(*net[r], u));
        for c in 0..4 {
            let column = bezier(
                [along_u[0][c], along_u[1][c], along_u[2][c], along_u[3][c]],
                v,
            );
            column.iter().for_each(|p| out(p.xyz()));
        }
    }

    /// The same for what it shows between grid places `start` and `end`.
    pub(super) fn part_hull(
        &self,
        target: Target,
        [start, end]: [[u32; 2]; 2],
        out: &mut impl FnMut([f32; 3]),
    ) {
        let range = |k: usize| {
            let lo = self.origin[k].max(start[k]);
            let hi = (self.origin[k] + self.sheet.size).min(end[k]);
            let scale = 1.0 / self.sheet.size.max(1) as f32;
            (lo <= hi).then(|| [lo, hi].map(|x| (x - self.origin[k]) as f32 * scale))
        };
        if let (Some(u), Some(v)) = (range(0), range(1)) {
            self.hull(target, u, v, out);
        }
    }
}

/// Bézier points over `[a, b]` of the B-spline segment with control points `p`: its blossom at (a,a,a), (a,a,b), (a,b,b), (b,b,b).
fn bezier(p: [P4; 4], [a, b]: [f32; 2]) -> [P4; 4] {
    if [a, b] == [0.0, 1.0] {
        // All of it, as for most faces of a frame: a seventh of the operations.
        let end = |p: P4, q: P4, r: P4| ((p + r) + q * 4.0) * (1.0 / 6.0);
        let inner = |p: P4, q: P4| (p + p + q) * (1.0 / 3.0);
        return [
            end(p[0], p[1], p[2]),
            inner(p[1], p[2]),
            inner(p[2], p[1]),
            end(p[1], p[2], p[3]),
        ];
    }
    let mix = |p: P4, q: P4, t: f32| p + (q - p) * t;
    let blossom = |u: f32, v: f32, w: f32| {
        let q: [P4; 3] = std::array::from_fn(|i| mix(p[i], p[i + 1], (u + 2.0 - i as f32) / 3.0));
        let r: [P4; 2] = std::array::from_fn(|i| mix(q[i], q[i + 1], (v + 1.0 - i as f32) / 2.0));
        mix(r[0], r[1], w)
    };
    [
        blossom(a, a, a),
        blossom(a, a, b),
        blossom(a, b, b),
        blossom(b, b, b),
    ]
}
