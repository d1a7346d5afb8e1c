//! The tensor kernel: a regular patch is a bicubic B-spline, diced row by row with lanes along u.
//!
//! First the four rows of the net are blended into four points per row of the grid, with lanes along v, then every lane of a row blends
//! those four. Sums run as `(w0 p0 + w3 p3) + (w1 p1 + w2 p2)` everywhere.

use super::basis::{Basis, LineWeights, Target};
use super::point::P4;
use super::sheet::{Quadrant, Rows, Sheet};
use crate::records::{BLOCK_STRIDE, Grid3};
use std::hint::{black_box, select_unpredictable};

/// Points in one vector of the kernels.
pub(crate) const LANES: usize = 16;

/// Points in a line of the kernels: a row of a block, rounded up to whole vectors.
pub(crate) const LINE: usize = BLOCK_STRIDE;

/// One component along a line.
pub(crate) type Line = [f32; LINE];

/// Component `c` of the points that the weights from `at` on make of `q`; `n` is a multiple of [`LANES`] at most [`LINE`].
///
/// The trip count is not a constant on purpose: loops of a small constant length are unrolled before they could be vectorised.
#[inline(always)]
pub(crate) fn weigh(w: &[Vec<f32>; 4], at: usize, n: usize, q: &[P4; 4], c: usize, out: &mut Line) {
    let (w0, w1, w2, w3) = (
        &w[0][at..at + n],
        &w[1][at..at + n],
        &w[2][at..at + n],
        &w[3][at..at + n],
    );
    let (q0, q1, q2, q3) = (q[0].0[c], q[1].0[c], q[2].0[c], q[3].0[c]);
    let out = &mut out[..n];
    for i in 0..n {
        out[i] = (w0[i] * q0 + w3[i] * q3) + (w1[i] * q1 + w2[i] * q2);
    }
}

/// All three components.
#[inline(always)]
pub(crate) fn weigh3(w: &[Vec<f32>; 4], at: usize, n: usize, q: &[P4; 4], out: &mut [Line; 3]) {
    let [x, y, z] = out;
    weigh(w, at, n, q, 0, x);
    weigh(w, at, n, q, 1, y);
    weigh(w, at, n, q, 2, z);
}

/// Three components in lanes, aligned so that no vector crosses a cache line.
#[repr(align(64))]
pub(super) struct Lanes3<const W: usize>(pub(super) [[f32; W]; 3]);

impl<const W: usize> Lanes3<W> {
    #[inline(always)]
    pub(super) fn zeros() -> Self {
        Self([[0.0; W]; 3])
    }
}

/// Keeps the loop around it scalar. Loops over lanes become vectors; without this the compiler would rather vectorise the loop over rows or
/// components around them, and gather and scatter.
#[inline(always)]
pub(super) fn one_by_one() {
    black_box(());
}

/// Four weights for each of `W` lanes.
pub(super) type Weights<const W: usize> = [[f32; W]; 4];

/// Each lane's blend of four numbers, into the first `W` of `out`.
#[inline(always)]
pub(super) fn mix<const W: usize>(w: &Weights<W>, q: [f32; 4], out: &mut [f32]) {
    let out = &mut out[..W];
    for i in 0..W {
        out[i] = (w[0][i] * q[0] + w[3][i] * q[3]) + (w[1][i] * q[1] + w[2][i] * q[2]);
    }
}

/// Each lane's blend of four points.
#[inline(always)]
pub(super) fn mix3<const W: usize>(w: &Weights<W>, q: &[P4; 4], out: &mut Lanes3<W>) {
    for c in 0..3 {
        one_by_one();
        let q = [q[0].0[c], q[1].0[c], q[2].0[c], q[3].0[c]];
        mix(w, q, &mut out.0[c]);
    }
}

#[inline(always)]
pub(super) fn blend(w: [f32; 4], p: [P4; 4]) -> P4 {
    (p[0] * w[0] + p[3] * w[3]) + (p[1] * w[1] + p[2] * w[2])
}

/// The block that sheets are diced into, in points of a grid that has every `2^shift`-th point of the sheets' own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlockRange {
    /// Levels that the grid is coarser than the sheets'.
    pub(crate) shift: u32,
    /// Grid point at which the block begins.
    pub(crate) start: [u32; 2],
    /// Last grid column of the block: what is beyond in its rows means nothing and may be written.
    pub(crate) end: u32,
    /// First grid point wanted along u and v.
    pub(crate) low: [u32; 2],
    /// Last grid point wanted.
    pub(crate) high: [u32; 2],
}

/// Dices the parts of all sheets inside a block, the last ones first.
///
/// Sheets follow each other from the widest to those next to irregular corners, so where two meet the wider one is seen. Which that is does
/// not depend on how many follow: the points of a level are among those of the next, bit for bit.
#[inline(always)]
pub(crate) fn dice_sheets(
    sheets: &[Sheet],
    target: Target,
    range: BlockRange,
    points: &mut Grid3,
    mut normals: Option<&mut Grid3>,
) {
    let mut lines = Lines::default();
    for (_, quadrant, area) in areas(sheets, range) {
        let basis = Basis::get(target, quadrant.sheet.level.saturating_sub(range.shift));
        let normals = normals.as_deref_mut();
        area.dice(&quadrant.net(), basis, &mut lines, points, normals);
    }
}

/// The parts of a block that are diced, with the numbers of their sheets. What is seen where several meet comes last.
#[inline(always)]
pub(super) fn areas(
    sheets: &[Sheet],
    range: BlockRange,
) -> impl Iterator<Item = (usize, Quadrant<'_>, Area)> {
    let ranked = |(number, sheet)| (0..4).rev().map(move |rank| (number, sheet, rank));
    let all = sheets.iter().enumerate().rev().flat_map(ranked);
    all.filter_map(move |(number, sheet, rank): (usize, &Sheet, usize)| {
        let q = (rank + sheet.corner) & 3;
        let quadrant = sheet.has(q).then(|| sheet.quadrant(q))?;
        Some((number, quadrant, Area::of(&quadrant, range)?))
    })
}

/// The part of a block that a quadrant shows.
///
/// Whole vectors are written from column `left` to before `right`. Whatever else they hold is also on the quadrant's border, and what is
/// seen there is diced after it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Area {
    /// First column and number of columns, of the block.
    col: usize,
    cols: usize,
    row: usize,
    rows: usize,
    left: usize,
    right: usize,
    /// The block's columns less the quadrant's.
    offset: isize,
    /// First row, of the quadrant.
    first: usize,
}

impl Area {
    #[inline(always)]
    fn of(quadrant: &Quadrant<'_>, range: BlockRange) -> Option<Self> {
        let size = quadrant.sheet.size >> range.shift;
        // The corners of a quadrant smaller than a cell of the grid belong to wider ones too.
        if size == 0 && quadrant.sheet.size > 0 {
            return None;
        }
        let round = (1 << range.shift) - 1;
        let (mut low, mut high) = (range.low, range.high);
        for k in 0..2 {
            low[k] = low[k].max((quadrant.own[0][k] + round) >> range.shift);
            high[k] = high[k].min(quadrant.own[1][k] >> range.shift);
        }
        if low[0] > high[0] || low[1] > high[1] {
            return None;
        }
        let [u, v] = quadrant.origin;
        let origin = [u >> range.shift, v >> range.shift];
        let right = if origin[0] + size >= range.end {
            LINE
        } else {
            (origin[0] + size + 1 - range.start[0]) as usize
        };
        Some(Self {
            col: (low[0] - range.start[0]) as usize,
            cols: (high[0] - low[0] + 1) as usize,
            row: (low[1] - range.start[1]) as usize,
            rows: (high[1] - low[1] + 1) as usize,
            left: origin[0].saturating_sub(range.start[0]) as usize,
            right,
            offset: range.start[0] as isize - origin[0] as isize,
            first: (low[1] - origin[1]) as usize,
        })
    }

    #[inline(always)]
    pub(super) fn dice(
        &self,
        net: &Rows<'_>,
        basis: &Basis,
        lines: &mut Lines,
        points: &mut Grid3,
        normals: Option<&mut Grid3>,
    ) {
        let room = self.right - self.left;
        if self.cols > 8 && room >= 16 {
            self.dice_lanes::<16>(net, basis, lines, points, normals);
        } else if self.cols > 4 && room >= 8 {
            self.dice_lanes::<8>(net, basis, lines, points, normals);
        } else if self.cols > 2 && room >= 4 {
            self.dice_lanes::<4>(net, basis, lines, points, normals);
        } else {
            self.dice_singly(net, basis, lines, points, normals);
        }
    }

    #[inline(always)]
    fn dice_lanes<const W: usize>(
        &self,
        net: &Rows<'_>,
        basis: &Basis,
        lines: &mut Lines,
        points: &mut Grid3,
        normals: Option<&mut Grid3>,
    ) {
        self.points::<W>(net, basis, lines, points);
        if let Some(normals) = normals {
            self.normals::<W>(net, basis, lines, normals);
        }
    }

    /// The column from which the vector is written that shows `col`, the first one without it. Vectors begin at multiples of `W` unless one
    /// is enough elsewhere.
    #[inline(always)]
    fn vector<const W: usize>(&self, col: Option<usize>) -> Option<usize> {
        let end = self.col + self.cols;
        let col = col.unwrap_or_else(|| {
            let whole = (self.col - self.col % W).max(self.left);
            match self.cols <= W && whole + W < end {
                true => self.col,
                false => whole,
            }
        });
        (col < end).then(|| col.min(self.right - W))
    }

    /// Column of the quadrant.
    #[inline(always)]
    fn column(&self, col: usize) -> usize {
        (col as isize + self.offset) as usize
    }

    #[inline(always)]
    fn points<const W: usize>(
        &self,
        net: &Rows<'_>,
        basis: &Basis,
        [lines, _]: &mut Lines,
        out: &mut Grid3,
    ) {
        for row in (0..self.rows).step_by(ROWS) {
            let lines = &mut lines[..(self.rows - row).min(ROWS)];
            blend_rows(&basis.point, self.first + row, net, lines);
            let mut next = self.vector::<W>(None);
            while let Some(col) = next {
                let w = basis.point.lanes::<W>(self.column(col));
                for (j, q) in lines.iter().enumerate() {
                    one_by_one();
                    let at = (self.row + row + j) * BLOCK_STRIDE + col;
                    mix(&w, four(q, 0), &mut out.x[at..]);
                    mix(&w, four(q, 1), &mut out.y[at..]);
                    mix(&w, four(q, 2), &mut out.z[at..]);
                }
                next = self.vector::<W>(Some(col + W));
            }
        }
    }

    #[inline(always)]
    fn normals<const W: usize>(
        &self,
        net: &Rows<'_>,
        basis: &Basis,
        lines: &mut Lines,
        out: &mut Grid3,
    ) {
        let spare = fallback(net);
        let lanes = black_box(W);
        let (mut du, mut dv, mut unit) = (
            Lanes3::<W>::zeros(),
            Lanes3::<W>::zeros(),
            Lanes3::<W>::zeros(),
        );
        for row in (0..self.rows).step_by(ROWS) {
            let [along, across] = self.slopes(row, net, basis, lines);
            let mut next = self.vector::<W>(None);
            while let Some(col) = next {
                let limit = basis.limit.lanes::<W>(self.column(col));
                let slope = basis.slope.lanes::<W>(self.column(col));
                for (j, (q, r)) in along.iter().zip(across).enumerate() {
                    for c in 0..3 {
                        one_by_one();
                        mix(&slope, four(q, c), &mut du.0[c]);
                        mix(&limit, four(r, c), &mut dv.0[c]);
                    }
                    unit_lanes(&du, &dv, lanes, spare, &mut unit);
                    let at = (self.row + row + j) * BLOCK_STRIDE + col;
                    out.x[at..at + W].copy_from_slice(&unit.0[0]);
                    out.y[at..at + W].copy_from_slice(&unit.0[1]);
                    out.z[at..at + W].copy_from_slice(&unit.0[2]);
                }
                next = self.vector::<W>(Some(col + W));
            }
        }
    }

    /// From row `row` on, what derivatives along u and along v are made of.
    #[inline(always)]
    fn slopes<'a>(
        &self,
        row: usize,
        net: &Rows<'_>,
        basis: &Basis,
        [along, across]: &'a mut Lines,
    ) -> [&'a [[f32; 16]]; 2] {
        let rows = (self.rows - row).min(ROWS);
        let (along, across) = (&mut along[..rows], &mut across[..rows]);
        blend_rows(&basis.limit, self.first + row, net, along);
        blend_rows(&basis.slope, self.first + row, net, across);
        [along, across]
    }

    /// Few points, one by one.
    #[inline(always)]
    fn dice_singly(
        &self,
        net: &Rows<'_>,
        basis: &Basis,
        lines: &mut Lines,
        points: &mut Grid3,
        mut normals: Option<&mut Grid3>,
    ) {
        let columns = self.col..self.col + self.cols;
        for row in (0..self.rows).step_by(ROWS) {
            let middle = &mut lines[0][..(self.rows - row).min(ROWS)];
            blend_rows(&basis.point, self.first + row, net, middle);
            for (j, q) in middle.iter().enumerate() {
                for i in columns.clone() {
                    one_by_one();
                    let p = blend(basis.point.at(self.column(i)), points_of(q));
                    points.set(i, self.row + row + j, p.xyz());
                }
            }
            let Some(normals) = normals.as_deref_mut() else {
                continue;
            };
            let spare = fallback(net);
            let [along, across] = self.slopes(row, net, basis, lines);
            for (j, (q, r)) in along.iter().zip(across).enumerate() {
                for i in columns.clone() {
                    let du = blend(basis.slope.at(self.column(i)), points_of(q));
                    let dv = blend(basis.limit.at(self.column(i)), points_of(r));
                    let unit = unit_of(du.xyz(), dv.xyz(), spare);
                    normals.set(i, self.row + row + j, unit);
                }
            }
        }
    }
}

/// Most rows of the grid that are blended before any of them is read.
const ROWS: usize = 16;

/// The four points that each of some rows of the grid is made of, number by number: one vector. Written long before they are read, which
/// would have to wait otherwise.
pub(super) type Lines = [[[f32; 16]; ROWS]; 2];

/// The columns of a net, each blended for the rows from `first` on.
#[inline(always)]
fn blend_rows(weights: &LineWeights, first: usize, net: &Rows<'_>, lines: &mut [[f32; 16]]) {
    let mut flat = [[0.0; 16]; 4];
    for (to, from) in flat.iter_mut().zip(net) {
        for (to, from) in to.as_chunks_mut().0.iter_mut().zip(*from) {
            *to = from.0;
        }
    }
    for (j, line) in lines.iter_mut().enumerate() {
        one_by_one();
        mix(&flat, weights.at(first + j), line);
    }
}

/// Component `c` of four points.
#[inline(always)]
fn four(q: &[f32; 16], c: usize) -> [f32; 4] {
    [q[c], q[4 + c], q[8 + c], q[12 + c]]
}

/// Four points, one by one.
#[inline(always)]
fn points_of(q: &[f32; 16]) -> [P4; 4] {
    [0, 4, 8, 12].map(|k| P4([q[k], q[k + 1], q[k + 2], q[k + 3]]))
}

/// A normal for points where the tangents are parallel: that of the patch as a whole.
#[inline(always)]
fn fallback(net: &Rows<'_>) -> [f32; 3] {
    let n = (net[2][2] - net[1][1]).cross(net[2][1] - net[1][2]);
    match n.unit() {
        Some(n) => n.xyz(),
        None => [0.0, 0.0, 1.0],
    }
}

/// Unit cross product; `spare` where there is none.
#[inline(always)]
pub(super) fn unit_of(a: [f32; 3], b: [f32; 3], spare: [f32; 3]) -> [f32; 3] {
    // Scale both by their largest component, so that squares stay inside f32 for cages of any size.
    let ma = a[0].abs().max(a[1].abs()).max(a[2].abs());
    let mb = b[0].abs().max(b[1].abs()).max(b[2].abs());
    let (ia, ib) = (
        1.0 / ma.max(f32::MIN_POSITIVE),
        1.0 / mb.max(f32::MIN_POSITIVE),
    );
    let (ax, ay, az) = (a[0] * ia, a[1] * ia, a[2] * ia);
    let (bx, by, bz) = (b[0] * ib, b[1] * ib, b[2] * ib);
    // The zero added makes -0 of one face's side the 0 of the other's.
    let nx = (ay * bz - az * by) + 0.0;
    let ny = (az * bx - ax * bz) + 0.0;
    let nz = (ax * by - ay * bx) + 0.0;
    let square = (nx * nx + ny * ny) + nz * nz;
    // Below this the cross product is rounding noise of the two unit-sized factors.
    let sound = square > 1e-12;
    let inverse = 1.0 / select_unpredictable(sound, square, 1.0).sqrt();
    [
        select_unpredictable(sound, nx * inverse, spare[0]),
        select_unpredictable(sound, ny * inverse, spare[1]),
        select_unpredictable(sound, nz * inverse, spare[2]),
    ]
}

/// [`unit_of`] along a line of `n` points.
#[inline(always)]
pub(crate) fn unit_cross(
    a: &[Line; 3],
    b: &[Line; 3],
    n: usize,
    spare: [f32; 3],
    out: &mut [Line; 3],
) {
    let (a0, a1, a2) = (&a[0][..n], &a[1][..n], &a[2][..n]);
    let (b0, b1, b2) = (&b[0][..n], &b[1][..n], &b[2][..n]);
    let [x, y, z] = out;
    let (x, y, z) = (&mut x[..n], &mut y[..n], &mut z[..n]);
    for i in 0..n {
        [x[i], y[i], z[i]] = unit_of([a0[i], a1[i], a2[i]], [b0[i], b1[i], b2[i]], spare);
    }
}

/// [`unit_of`] in lanes; `n` is `W`, but the compiler must not know: see [`weigh`].
#[inline(always)]
pub(super) fn unit_lanes<const W: usize>(
    a: &Lanes3<W>,
    b: &Lanes3<W>,
    n: usize,
    spare: [f32; 3],
    out: &mut Lanes3<W>,
) {
    let (a0, a1, a2) = (&a.0[0][..n], &a.0[1][..n], &a.0[2][..n]);
    let (b0, b1, b2) = (&b.0[0][..n], &b.0[1][..n], &b.0[2][..n]);
    let [x, y, z] = &mut out.0;
    let (x, y, z) = (&mut x[..n], &mut y[..n], &mut z[..n]);
    for i in 0..n {
        [x[i], y[i], z[i]] = unit_of([a0[i], a1[i], a2[i]], [b0[i], b1[i], b2[i]], spare);
    }
}
