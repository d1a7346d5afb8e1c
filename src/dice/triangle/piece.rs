//! A regular triangle of a face, or of one of its refinements: twelve control points and where in the face's grid they belong.
//!
//! A row of the grid is a quartic curve of the piece, found by blending its net, and lanes run along it. The bits of a point depend on
//! the piece and its place in it alone, never on the block that asks, so blocks agree along their common lines.

use super::super::basis::Target;
use super::super::point::P4;
use super::super::regular::{LANES, LINE, Line, unit_cross, weigh3};
use super::basis::{BEZIER, Bernstein, expansion};
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

/// Row `r` of the Bernstein form.
#[inline(always)]
pub(super) fn expand_row(net: &Net12, weights: &[[f32; 12]; 25], r: usize) -> [P4; 5] {
    std::array::from_fn(|c| {
        let w = &weights[5 * r + c];
        let pair = |a: usize, b: usize| net[a] * w[a] + net[b] * w[b];
        let sum = (pair(0, 1) + pair(2, 3)) + (pair(4, 5) + pair(6, 7));
        (sum + (pair(8, 9) + pair(10, 11))) * (1.0 / 24.0)
    })
}

#[inline(always)]
fn expand(net: &Net12, weights: &[[f32; 12]; 25]) -> Tensor {
    std::array::from_fn(|r| expand_row(net, weights, r))
}

/// Cubic coefficients of what is a cubic given as a quartic.
#[inline(always)]
pub(super) fn reduced(q: [P4; 5]) -> [P4; 4] {
    let inner = |a: P4, b: P4| (b * 4.0 - a) * (1.0 / 3.0);
    [q[0], inner(q[0], q[1]), inner(q[4], q[3]), q[4]]
}

/// Differences of neighbours: the derivative, up to the degree.
#[inline(always)]
pub(super) fn differences(q: &[P4; 5]) -> [P4; 4] {
    [q[1] - q[0], q[2] - q[1], q[3] - q[2], q[4] - q[3]]
}

#[inline(always)]
fn blend5(w: [f32; 5], p: [P4; 5]) -> P4 {
    ((p[0] * w[0] + p[4] * w[4]) + (p[1] * w[1] + p[3] * w[3])) + p[2] * w[2]
}

#[inline(always)]
fn blend4(w: [f32; 4], p: [P4; 4]) -> P4 {
    (p[0] * w[0] + p[3] * w[3]) + (p[1] * w[1] + p[2] * w[2])
}

/// One component of the points that the weights from `at` on make of `q`; see [`weigh3`].
#[inline(always)]
fn weigh5_one(w: &[Vec<f32>; 5], at: usize, n: usize, q: [f32; 5], out: &mut Line) {
    let (w0, w1, w2) = (&w[0][at..at + n], &w[1][at..at + n], &w[2][at..at + n]);
    let (w3, w4) = (&w[3][at..at + n], &w[4][at..at + n]);
    let out = &mut out[..n];
    for i in 0..n {
        out[i] = ((w0[i] * q[0] + w4[i] * q[4]) + (w1[i] * q[1] + w3[i] * q[3])) + w2[i] * q[2];
    }
}

/// A quartic along a line.
#[inline(always)]
pub(super) fn weigh5(w: &[Vec<f32>; 5], at: usize, n: usize, q: &[P4; 5], out: &mut [Line; 3]) {
    let [x, y, z] = out;
    weigh5_one(w, at, n, q.map(|p| p.0[0]), x);
    weigh5_one(w, at, n, q.map(|p| p.0[1]), y);
    weigh5_one(w, at, n, q.map(|p| p.0[2]), z);
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
        for (k, place) in small.places.iter().enumerate().take(LANES) {
            let at = [0, 1].map(|c| self.corner[c] + sign * place[c]);
            if (0..2).all(|c| (range.low[c]..=range.high[c]).contains(&at[c])) {
                let [i, j] = [0, 1].map(|c| (at[c] - start[c]) as usize);
                out.set(i, j, [0, 1, 2].map(|c| base[c] + line[c][k]));
            }
        }
    }

    #[inline(always)]
    fn dice_points(&self, net: &Tensor, rows: &Rows, out: &mut Grid3) {
        let b = Bernstein::get(self.level);
        let mut line = [[0.0; LINE]; 3];
        self.each_row(rows, |j, first, n, to| {
            let w = [0, 1, 2, 3, 4].map(|k| b.quartic[k][j]);
            let mut q: [P4; 5] = std::array::from_fn(|c| {
                self.base + blend5(w, [net[0][c], net[1][c], net[2][c], net[3][c], net[4][c]])
            });
            if self.down {
                q.reverse();
            }
            weigh5(&b.quartic, first, n.next_multiple_of(LANES), &q, &mut line);
            put(out, to, n, &line);
        });
    }

    #[inline(always)]
    fn dice_normals(&self, net: &Tensor, rows: &Rows, out: &mut Grid3) {
        let b = Bernstein::get(self.level);
        let spare = fallback(&self.net);
        let along: [[P4; 4]; 5] = std::array::from_fn(|r| differences(&net[r]));
        let across: [[P4; 4]; 4] =
            std::array::from_fn(|r| reduced(std::array::from_fn(|c| net[r + 1][c] - net[r][c])));
        let (mut du, mut dv, mut unit) = ([[0.0; LINE]; 3], [[0.0; LINE]; 3], [[0.0; LINE]; 3]);
        self.each_row(rows, |j, first, n, to| {
            let w5 = [0, 1, 2, 3, 4].map(|k| b.quartic[k][j]);
            let w4 = [0, 1, 2, 3].map(|k| b.cubic[k][j]);
            let mut u: [P4; 4] = std::array::from_fn(|c| {
                blend5(
                    w5,
                    [
                        along[0][c],
                        along[1][c],
                        along[2][c],
                        along[3][c],
                        along[4][c],
                    ],
                )
            });
            let mut v: [P4; 4] = std::array::from_fn(|c| {
                blend4(w4, [across[0][c], across[1][c], across[2][c], across[3][c]])
            });
            if self.down {
                u.reverse();
                v.reverse();
            }
            let lanes = n.next_multiple_of(LANES);
            weigh3(&b.cubic, first, lanes, &u, &mut du);
            weigh3(&b.cubic, first, lanes, &v, &mut dv);
            unit_cross(&du, &dv, lanes, spare, &mut unit);
            put(out, to, n, &unit);
        });
    }

    /// Calls `f` for every row with the row's number in the piece, the first column from the piece's left end, the number of points
    /// and where they go.
    #[inline(always)]
    fn each_row(&self, rows: &Rows, mut f: impl FnMut(usize, usize, usize, usize)) {
        let [x0, y0] = rows.origin;
        for y in rows.low[1]..=rows.high[1] {
            let (j, left, right) = if self.down {
                (self.size - (y - y0), x0, x0 + (y - y0))
            } else {
                (y - y0, x0 + (y - y0), x0 + self.size)
            };
            let (left, right) = (left.max(rows.low[0]), right.min(rows.high[0]));
            if left <= right {
                let to =
                    (y - rows.start[1]) as usize * BLOCK_STRIDE + (left - rows.start[0]) as usize;
                f(
                    j as usize,
                    (left - x0) as usize,
                    (right - left + 1) as usize,
                    to,
                );
            }
        }
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
