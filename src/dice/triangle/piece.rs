//! A regular triangle of a face, or of one of its refinements: twelve control points and where in the face's grid they belong.
//!
//! A row of the grid is a quartic curve of the piece, found by blending its net, and lanes run along it. The bits of a point depend on
//! the piece and its place in it alone, never on the block that asks, so blocks agree along their common lines.

use super::super::basis::Target;
use super::super::point::P4;
use super::super::regular::{LANES, LINE, Line, unit_cross, weigh3};
use super::basis::{BEZIER, Bernstein, Expansion, expansion};
use super::small::{SMALL_LEVEL, Small};
use crate::records::{BLOCK_STRIDE, Grid3};

/// Twelve control points, in the order of [`OFFSETS`](super::basis::OFFSETS).
pub(super) type Net12 = [P4; 12];

/// Where a control triangle lies in the grid of its face: its corner 0 at `origin`, and steps of its own lattice in grid points. Corner 1
/// is `size` steps `du` from corner 0, corner 2 another `size` steps `dv` on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) origin: [i32; 2],
    pub(crate) du: [i32; 2],
    pub(crate) dv: [i32; 2],
    pub(crate) size: u32,
}

impl Place {
    /// The whole grid of a face of `size` segments.
    pub(crate) fn root(size: u32) -> Self {
        Self {
            origin: [0, 0],
            du: [1, 0],
            dv: [0, 1],
            size,
        }
    }

    /// Grid point of lattice point (`i`, `j`).
    pub(crate) fn at(&self, [i, j]: [i32; 2]) -> [i32; 2] {
        [0, 1].map(|k| self.origin[k] + i * self.du[k] + j * self.dv[k])
    }

    /// The same triangle with its corners 1, 2, 0 as corners 0, 1, 2.
    pub(crate) fn turned(&self) -> Self {
        Self {
            origin: self.at([self.size as i32, 0]),
            du: self.dv,
            dv: [0, 1].map(|k| -self.du[k] - self.dv[k]),
            size: self.size,
        }
    }

    /// Child `c` of a 1-to-4 split: 0 to 2 at the corners, 3 in the middle, whose corners are the middles of sides 1, 2, 0.
    pub(crate) fn child(&self, c: usize) -> Self {
        let half = self.size as i32 / 2;
        let at = [[0, 0], [half, 0], [half, half], [2 * half, half]][c];
        let sign = if c == 3 { -1 } else { 1 };
        Self {
            origin: self.at(at),
            du: self.du.map(|d| sign * d),
            dv: self.dv.map(|d| sign * d),
            size: half as u32,
        }
    }
}

/// The net seen from corner 1: entry `k` of the turned net is entry `TURN[k]`.
const TURN: [usize; 12] = [6, 9, 11, 2, 5, 8, 10, 1, 4, 7, 0, 3];

/// The net with corner 1 as its corner 0.
pub(super) fn turn(net: &Net12) -> Net12 {
    TURN.map(|k| net[k])
}

/// 25 points in Bernstein form over the square of which the triangle is one half.
pub(super) type Tensor = [[P4; 5]; 5];

/// Row `r` of the Bernstein form. Loops, here and below, where closures would not be inlined into the kernels and so compiled without
/// their instructions.
#[inline(always)]
pub(super) fn expand_row(net: &Net12, weights: &Expansion, r: usize) -> [P4; 5] {
    let mut out = [P4::ZERO; 5];
    for c in 0..5 {
        let w = &weights[5 * r + c];
        let low = (net[0] * w[0] + net[1] * w[1]) + (net[2] * w[2] + net[3] * w[3]);
        let mid = (net[4] * w[4] + net[5] * w[5]) + (net[6] * w[6] + net[7] * w[7]);
        let top = (net[8] * w[8] + net[9] * w[9]) + (net[10] * w[10] + net[11] * w[11]);
        out[c] = ((low + top) + mid) * (1.0 / 24.0);
    }
    out
}

#[inline(always)]
fn expand(net: &Net12, weights: &Expansion) -> Tensor {
    let mut out = [[P4::ZERO; 5]; 5];
    for r in 0..5 {
        out[r] = expand_row(net, weights, r);
    }
    out
}

/// Cubic coefficients of what is a cubic given as a quartic.
#[inline(always)]
pub(super) fn reduced(q: [P4; 5]) -> [P4; 4] {
    let third = 1.0 / 3.0;
    [
        q[0],
        (q[1] * 4.0 - q[0]) * third,
        (q[3] * 4.0 - q[4]) * third,
        q[4],
    ]
}

/// Differences of neighbours: the derivative, up to the degree.
#[inline(always)]
pub(super) fn differences(q: &[P4; 5]) -> [P4; 4] {
    [q[1] - q[0], q[2] - q[1], q[3] - q[2], q[4] - q[3]]
}

/// From row `a` to row `b`, as cubics.
#[inline(always)]
pub(super) fn step_across(a: &[P4; 5], b: &[P4; 5]) -> [P4; 4] {
    reduced([
        b[0] - a[0],
        b[1] - a[1],
        b[2] - a[2],
        b[3] - a[3],
        b[4] - a[4],
    ])
}

/// Five rows blended by quartic weights.
#[inline(always)]
fn blend5<const N: usize>(w: &[Vec<f32>; 5], at: usize, rows: &[[P4; N]; 5]) -> [P4; N] {
    let w = [w[0][at], w[1][at], w[2][at], w[3][at], w[4][at]];
    let mut out = [P4::ZERO; N];
    for c in 0..N {
        let ends = rows[0][c] * w[0] + rows[4][c] * w[4];
        let inner = rows[1][c] * w[1] + rows[3][c] * w[3];
        out[c] = (ends + inner) + rows[2][c] * w[2];
    }
    out
}

/// Four rows blended by cubic weights.
#[inline(always)]
fn blend4(w: &[Vec<f32>; 4], at: usize, rows: &[[P4; 4]; 4]) -> [P4; 4] {
    let w = [w[0][at], w[1][at], w[2][at], w[3][at]];
    let mut out = [P4::ZERO; 4];
    for c in 0..4 {
        let ends = rows[0][c] * w[0] + rows[3][c] * w[3];
        out[c] = ends + (rows[1][c] * w[1] + rows[2][c] * w[2]);
    }
    out
}

/// One component of the points that the weights from `at` on make of `q`; see [`weigh3`].
#[inline(always)]
fn weigh5_one(w: &[Vec<f32>; 5], at: usize, n: usize, q: &[P4; 5], c: usize, out: &mut Line) {
    let (w0, w1, w2) = (&w[0][at..at + n], &w[1][at..at + n], &w[2][at..at + n]);
    let (w3, w4) = (&w[3][at..at + n], &w[4][at..at + n]);
    let (q0, q1, q2, q3, q4) = (q[0].0[c], q[1].0[c], q[2].0[c], q[3].0[c], q[4].0[c]);
    let out = &mut out[..n];
    for i in 0..n {
        out[i] = ((w0[i] * q0 + w4[i] * q4) + (w1[i] * q1 + w3[i] * q3)) + w2[i] * q2;
    }
}

/// A quartic along a line.
#[inline(always)]
pub(super) fn weigh5(w: &[Vec<f32>; 5], at: usize, n: usize, q: &[P4; 5], out: &mut [Line; 3]) {
    let [x, y, z] = out;
    weigh5_one(w, at, n, q, 0, x);
    weigh5_one(w, at, n, q, 1, y);
    weigh5_one(w, at, n, q, 2, z);
}

/// A quartic box spline over a triangle of a face's grid.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// Relative to `base`.
    net: Net12,
    base: P4,
    /// Grid point of corner 0.
    corner: [i32; 2],
    /// Whether its lattice runs against the grid's, so that corner 0 is the last point of its rows.
    down: bool,
    size: i32,
    level: u32,
}

/// Grid points wanted, first and last.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range {
    pub(super) low: [i32; 2],
    pub(super) high: [i32; 2],
}

impl Piece {
    /// `place.size` must be `2^level`, and its directions those of one of the six turns of the grid's lattice.
    pub(super) fn new(mut net: Net12, base: P4, mut place: Place, level: u32) -> Self {
        for _ in 0..2 {
            if place.du[1] != 0 {
                net = turn(&net);
                place = place.turned();
            }
        }
        debug_assert!(place.du[1] == 0 && place.dv == [0, place.du[0]] && place.du[0].abs() == 1);
        Self {
            net,
            base,
            corner: place.origin,
            down: place.du[0] < 0,
            size: place.size as i32,
            level,
        }
    }

    /// First grid row and column.
    fn origin(&self) -> [i32; 2] {
        let back = if self.down { self.size } else { 0 };
        self.corner.map(|c| c - back)
    }

    /// Writes what lies in `range` into a block that begins at grid point `start`.
    #[inline(always)]
    pub(super) fn dice(
        &self,
        target: Target,
        range: Range,
        start: [i32; 2],
        points: &mut Grid3,
        normals: Option<&mut Grid3>,
    ) {
        let [x0, y0] = self.origin();
        let (low, high) = (
            [range.low[0].max(x0), range.low[1].max(y0)],
            [
                range.high[0].min(x0 + self.size),
                range.high[1].min(y0 + self.size),
            ],
        );
        // A triangle of an up piece needs column ≥ row, of a down piece row ≥ column.
        let apart = if self.down {
            low[0] - x0 > high[1] - y0
        } else {
            low[1] - y0 > high[0] - x0
        };
        if low[0] > high[0] || low[1] > high[1] || apart {
            return;
        }
        if self.level <= SMALL_LEVEL {
            self.dice_small(target, range, start, points, normals);
            return;
        }
        let limit = expand(&self.net, expansion(Target::Limit, 0));
        let refined;
        let net = match target {
            Target::Limit => &limit,
            Target::Refined => {
                refined = expand(&self.net, expansion(target, self.level));
                &refined
            }
        };
        let rows = Rows {
            low,
            high,
            origin: [x0, y0],
            start,
        };
        self.dice_points(net, &rows, points);
        if let Some(normals) = normals {
            self.dice_normals(&limit, &rows, normals);
        }
    }

    #[inline(always)]
    fn dice_small(
        &self,
        target: Target,
        range: Range,
        start: [i32; 2],
        points: &mut Grid3,
        normals: Option<&mut Grid3>,
    ) {
        let small = Small::get(target, self.level);
        let mut line = [[0.0; LINE]; 3];
        small.points(&self.net, &mut line);
        let base = self.base.xyz();
        self.scatter(small, &line, base, range, start, points);
        if let Some(normals) = normals {
            small.normals(&self.net, fallback(&self.net), &mut line);
            self.scatter(small, &line, [0.0; 3], range, start, normals);
        }
    }

    /// Writes the lanes of a small piece to their places, if these are in `range`.
    #[inline(always)]
    fn scatter(
        &self,
        small: &Small,
        line: &[Line; 3],
        base: [f32; 3],
        range: Range,
        start: [i32; 2],
        out: &mut Grid3,
    ) {
        let sign = if self.down { -1 } else { 1 };
        let [x0, y0] = self.origin();
        let inside = x0 >= range.low[0]
            && y0 >= range.low[1]
            && x0 + self.size <= range.high[0]
            && y0 + self.size <= range.high[1];
        for (k, place) in small.places.iter().enumerate() {
            let (x, y) = (
                self.corner[0] + sign * place[0],
                self.corner[1] + sign * place[1],
            );
            let within = |at: i32, c: usize| range.low[c] <= at && at <= range.high[c];
            if inside || (within(x, 0) && within(y, 1)) {
                let (i, j) = ((x - start[0]) as usize, (y - start[1]) as usize);
                let p = [
                    base[0] + line[0][k],
                    base[1] + line[1][k],
                    base[2] + line[2][k],
                ];
                out.set(i, j, p);
            }
        }
    }

    #[inline(always)]
    fn dice_points(&self, net: &Tensor, rows: &Rows, out: &mut Grid3) {
        let b = Bernstein::get(self.level);
        let mut line = [[0.0; LINE]; 3];
        for y in rows.low[1]..=rows.high[1] {
            let Some(row) = self.row(rows, y) else {
                continue;
            };
            let mut q = blend5(&b.quartic, row.j, net);
            for p in &mut q {
                *p = self.base + *p;
            }
            if self.down {
                q = [q[4], q[3], q[2], q[1], q[0]];
            }
            let lanes = row.count.next_multiple_of(LANES);
            weigh5(&b.quartic, row.first, lanes, &q, &mut line);
            put(out, row.to, row.count, &line);
        }
    }

    #[inline(always)]
    fn dice_normals(&self, net: &Tensor, rows: &Rows, out: &mut Grid3) {
        let b = Bernstein::get(self.level);
        let spare = fallback(&self.net);
        let mut along = [[P4::ZERO; 4]; 5];
        for r in 0..5 {
            along[r] = differences(&net[r]);
        }
        let mut across = [[P4::ZERO; 4]; 4];
        for r in 0..4 {
            across[r] = step_across(&net[r], &net[r + 1]);
        }
        let (mut du, mut dv, mut unit) = ([[0.0; LINE]; 3], [[0.0; LINE]; 3], [[0.0; LINE]; 3]);
        for y in rows.low[1]..=rows.high[1] {
            let Some(row) = self.row(rows, y) else {
                continue;
            };
            let mut u = blend5(&b.quartic, row.j, &along);
            let mut v = blend4(&b.cubic, row.j, &across);
            if self.down {
                u = [u[3], u[2], u[1], u[0]];
                v = [v[3], v[2], v[1], v[0]];
            }
            let lanes = row.count.next_multiple_of(LANES);
            weigh3(&b.cubic, row.first, lanes, &u, &mut du);
            weigh3(&b.cubic, row.first, lanes, &v, &mut dv);
            unit_cross(&du, &dv, lanes, spare, &mut unit);
            put(out, row.to, row.count, &unit);
        }
    }

    /// The part of grid row `y` that is wanted of this piece.
    #[inline(always)]
    fn row(&self, rows: &Rows, y: i32) -> Option<Row> {
        let [x0, y0] = rows.origin;
        let up = y - y0;
        let (j, left, right) = if self.down {
            (self.size - up, x0, x0 + up)
        } else {
            (up, x0 + up, x0 + self.size)
        };
        let (left, right) = (left.max(rows.low[0]), right.min(rows.high[0]));
        if left > right {
            return None;
        }
        let to = (y - rows.start[1]) as usize * BLOCK_STRIDE + (left - rows.start[0]) as usize;
        Some(Row {
            j: j as usize,
            first: (left - x0) as usize,
            count: (right - left + 1) as usize,
            to,
        })
    }

    /// Points whose convex hull holds the piece.
    pub(super) fn hull(&self, target: Target, out: &mut impl FnMut([f32; 3])) {
        if target == Target::Refined {
            self.net.iter().for_each(|p| out((*p + self.base).xyz()));
            return;
        }
        for row in &BEZIER {
            let terms = row.iter().zip(&self.net);
            let sum = terms.fold(P4::ZERO, |sum, (&w, p)| sum + *p * f32::from(w));
            out((sum * (1.0 / 24.0) + self.base).xyz());
        }
    }

    /// The same for the part between two grid points; nothing where there is none.
    pub(super) fn hull_within(&self, target: Target, range: Range, out: &mut impl FnMut([f32; 3])) {
        let origin = self.origin();
        // Parameters of the range along s and t, in points of the piece's own lattice.
        let [s, t] = [0, 1].map(|k| {
            let low = (range.low[k] - origin[k]).max(0);
            let high = (range.high[k] - origin[k]).min(self.size);
            if self.down {
                [self.size - high, self.size - low]
            } else {
                [low, high]
            }
        });
        if s[0] > s[1] || t[0] > t[1] || t[0] > s[1] {
            return;
        }
        if target == Target::Refined || (s == [0, self.size] && t == [0, self.size]) {
            self.hull(target, out);
            return;
        }
        let scale = 1.0 / self.size as f32;
        let [s, t] = [s, t].map(|r| r.map(|k| k as f32 * scale));
        let net = expand(&self.net, expansion(Target::Limit, 0));
        let along: Tensor = std::array::from_fn(|r| restricted(net[r], s));
        for c in 0..5 {
            let column = [
                along[0][c],
                along[1][c],
                along[2][c],
                along[3][c],
                along[4][c],
            ];
            restricted(column, t)
                .iter()
                .for_each(|p| out((*p + self.base).xyz()));
        }
    }
}

/// Rows of a piece to be diced, in grid points.
struct Rows {
    low: [i32; 2],
    high: [i32; 2],
    origin: [i32; 2],
    start: [i32; 2],
}

/// Part of a row: its number in the piece, the first column from the piece's left end, the number of points and where they go.
struct Row {
    j: usize,
    first: usize,
    count: usize,
    to: usize,
}

/// Bézier points over `[a, b]` of a quartic over `[0, 1]`.
fn restricted(q: [P4; 5], [a, b]: [f32; 2]) -> [P4; 5] {
    std::array::from_fn(|i| {
        let mut row = q;
        for step in 0..4 {
            let x = if step < i { b } else { a };
            for k in 0..4 - step {
                row[k] = row[k] + (row[k + 1] - row[k]) * x;
            }
        }
        row[0]
    })
}

/// A normal for points where the tangents are parallel: that of the control triangle.
pub(super) fn fallback(net: &Net12) -> [f32; 3] {
    let n = (net[5] - net[4]).cross(net[8] - net[4]);
    n.unit().map_or([0.0, 0.0, 1.0], P4::xyz)
}

/// Writes the first `n` points of a line.
#[inline(always)]
fn put(grid: &mut Grid3, at: usize, n: usize, line: &[Line; 3]) {
    grid.x[at..at + n].copy_from_slice(&line[0][..n]);
    grid.y[at..at + n].copy_from_slice(&line[1][..n]);
    grid.z[at..at + n].copy_from_slice(&line[2][..n]);
}

#[cfg(test)]
mod tests {
    use super::super::basis::OFFSETS;
    use super::*;

    #[test]
    fn turning_thrice_is_nothing_and_follows_the_lattice() {
        for (k, &from) in TURN.iter().enumerate() {
            let [i, j] = OFFSETS[k];
            assert_eq!(OFFSETS[from], [1 - j, i - j]);
            assert_eq!(TURN[TURN[from]], k);
        }
        let place = Place::root(8);
        assert_eq!(place.turned().turned().turned(), place);
        assert_eq!(place.turned().origin, [8, 0]);
        assert_eq!(place.child(3).at([4, 0]), [4, 4]);
        assert_eq!(place.child(3).at([4, 4]), [4, 0]);
    }
}
