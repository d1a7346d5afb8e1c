//! A regular triangle of a face, or of one of its refinements: twelve control points and where in the face's grid they belong.
//!
//! A row of the grid is a quartic curve of the piece, found by blending its net, and lanes run along it. The bits of a point depend on
//! the piece and its place in it alone, never on the block that asks, so blocks agree along their common lines.

use super::super::basis::Target;
use super::super::point::P4;
use super::super::regular::{LANES, LINE, Line, unit_cross, weigh3};
use super::basis::{BEZIER, Bernstein, expansion};
use super::place::Place;
use super::small::{SMALL_LEVEL, Small};
use super::tensor::{
    Net12, Tensor, blend4, blend5, differences, expand, fallback, restricted, step_across, turn,
    weigh5,
};
use crate::records::{BLOCK_STRIDE, Grid3};

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

/// The block that pieces are diced into, in points of a grid that has every `2^shift`-th point of the pieces' own.
#[derive(Clone, Copy, Debug)]
pub(super) struct BlockRange {
    /// Levels that the grid is coarser than the pieces'.
    pub(super) shift: u32,
    /// Points wanted; the block begins at the first.
    pub(super) range: Range,
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

    /// Control points of a piece that stands for a whole face.
    pub(super) fn whole_net(&self) -> Option<[[f32; 3]; 12]> {
        let whole = self.corner == [0; 2] && !self.down && self.base == P4::ZERO;
        whole.then(|| self.net.map(P4::xyz))
    }

    /// First grid row and column.
    fn origin(&self) -> [i32; 2] {
        let back = if self.down { self.size } else { 0 };
        self.corner.map(|c| c - back)
    }

    /// Writes what lies in `block` into it. Whatever the block, a point has the same bits.
    #[inline(always)]
    pub(super) fn dice(
        &self,
        target: Target,
        block: BlockRange,
        points: &mut Grid3,
        normals: Option<&mut Grid3>,
    ) {
        let BlockRange { shift, range } = block;
        let size = self.size >> shift;
        // The corners of a piece smaller than a cell of the grid belong to wider ones too.
        if size == 0 {
            return;
        }
        let [x0, y0] = self.origin().map(|k| k >> shift);
        let (low, high) = (
            [range.low[0].max(x0), range.low[1].max(y0)],
            [range.high[0].min(x0 + size), range.high[1].min(y0 + size)],
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
            self.dice_small(target, block, points, normals);
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
            size,
            level: self.level - shift,
            start: range.low,
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
        block: BlockRange,
        points: &mut Grid3,
        normals: Option<&mut Grid3>,
    ) {
        let small = Small::get(target, self.level);
        let mut line = [[0.0; LINE]; 3];
        small.points(&self.net, &mut line);
        let base = self.base.xyz();
        self.scatter(small, &line, base, block, points);
        if let Some(normals) = normals {
            small.normals(&self.net, fallback(&self.net), &mut line);
            self.scatter(small, &line, [0.0; 3], block, normals);
        }
    }

    /// Writes the lanes of a small piece to their places, if these are in `range`.
    #[inline(always)]
    fn scatter(
        &self,
        small: &Small,
        line: &[Line; 3],
        base: [f32; 3],
        BlockRange { shift, range }: BlockRange,
        out: &mut Grid3,
    ) {
        let sign = if self.down { -1 } else { 1 };
        let [x0, y0] = self.origin().map(|k| k >> shift);
        let (size, start) = (self.size >> shift, range.low);
        let inside = x0 >= range.low[0]
            && y0 >= range.low[1]
            && x0 + size <= range.high[0]
            && y0 + size <= range.high[1];
        let between = (1 << shift) - 1;
        let corner = self.corner.map(|k| k >> shift);
        for (k, place) in small.places.iter().enumerate() {
            if (place[0] | place[1]) & between != 0 {
                continue;
            }
            let (x, y) = (
                corner[0] + sign * (place[0] >> shift),
                corner[1] + sign * (place[1] >> shift),
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
        let b = Bernstein::get(rows.level);
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
        let b = Bernstein::get(rows.level);
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
            (rows.size - up, x0, x0 + up)
        } else {
            (up, x0 + up, x0 + rows.size)
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

    /// Parameters between two grid points along s and t, in points of the piece's own lattice; none where the piece is not.
    fn within(&self, range: Range) -> Option<[[i32; 2]; 2]> {
        let origin = self.origin();
        let [s, t] = [0, 1].map(|k| {
            let low = (range.low[k] - origin[k]).max(0);
            let high = (range.high[k] - origin[k]).min(self.size);
            if self.down {
                [self.size - high, self.size - low]
            } else {
                [low, high]
            }
        });
        (s[0] <= s[1] && t[0] <= t[1] && t[0] <= s[1]).then_some([s, t])
    }

    /// The part of the piece between parameters, as Bézier points.
    fn restricted(&self, range: [[i32; 2]; 2]) -> Tensor {
        let scale = 1.0 / self.size as f32;
        let [s, t] = range.map(|r| r.map(|k| k as f32 * scale));
        let net = expand(&self.net, expansion(Target::Limit, 0));
        let along: Tensor = std::array::from_fn(|r| restricted(net[r], s));
        let columns: Tensor =
            std::array::from_fn(|c| restricted([0, 1, 2, 3, 4].map(|r: usize| along[r][c]), t));
        std::array::from_fn(|r| std::array::from_fn(|c| columns[c][r]))
    }

    /// Bounds of the unit normals between two grid points: the least and greatest components. `Some(None)` where there are no good ones,
    /// `None` where the piece is not.
    pub(super) fn normals_within(&self, range: Range) -> Option<Option<[[f32; 3]; 2]>> {
        // Derivatives of nothing are nothing: a line or a point is part of something wider.
        let widened = self.within(range)?.map(|[low, high]| match low < high {
            true => [low, high],
            false => [(low - 1).max(0), (high + 1).min(self.size)],
        });
        let net = self.restricted(widened);
        let none = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        let (mut along, mut across) = (none, none);
        for r in 0..5 {
            for c in 0..4 {
                hold(&mut along, (net[r][c + 1] - net[r][c]).xyz());
                hold(&mut across, (net[c + 1][r] - net[c][r]).xyz());
            }
        }
        Some(unit_within(along, across))
    }

    /// The same for the part between two grid points; nothing where there is none.
    pub(super) fn hull_within(&self, target: Target, range: Range, out: &mut impl FnMut([f32; 3])) {
        let Some([s, t]) = self.within(range) else {
            return;
        };
        if target == Target::Refined || (s == [0, self.size] && t == [0, self.size]) {
            self.hull(target, out);
            return;
        }
        let net = self.restricted([s, t]);
        let all = net.as_flattened().iter();
        all.for_each(|p| out((*p + self.base).xyz()));
    }
}

/// Makes bounds hold a vector.
pub(super) fn hold(bounds: &mut [[f32; 3]; 2], v: [f32; 3]) {
    bounds[0] = [0, 1, 2].map(|k| bounds[0][k].min(v[k]));
    bounds[1] = [0, 1, 2].map(|k| bounds[1][k].max(v[k]));
}

/// Bounds of unit vectors along the cross products of vectors within bounds; none where products may be short of what their factors are.
fn unit_within(a: [[f32; 3]; 2], b: [[f32; 3]; 2]) -> Option<[[f32; 3]; 2]> {
    let (mut low, mut high) = ([0.0_f32; 3], [0.0_f32; 3]);
    for k in 0..3 {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let [first, second] = [[i, j], [j, i]].map(|[x, y]: [usize; 2]| {
            let all = [
                a[0][x] * b[0][y],
                a[0][x] * b[1][y],
                a[1][x] * b[0][y],
                a[1][x] * b[1][y],
            ];
            let of = |f: fn(f32, f32) -> f32| all[1..].iter().fold(all[0], |x, &y| f(x, y));
            [of(f32::min), of(f32::max)]
        });
        (low[k], high[k]) = (first[0] - second[1], first[1] - second[0]);
    }
    let size = |v: [f32; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    let largest = |[low, high]: [[f32; 3]; 2]| size([0, 1, 2].map(|k| f32::max(-low[k], high[k])));
    let least = size([0, 1, 2].map(|k| low[k].max(-high[k]).max(0.0)));
    // Also false of what is no number.
    if !(least > 1e-4 * largest(a) * largest(b) && least > f32::MIN_POSITIVE) {
        return None;
    }
    let (short, long) = (least.sqrt(), largest([low, high]).sqrt());
    // Normals are rounded, and those of sides are found by other sums.
    const SLACK: f32 = 1e-3;
    let above = |x: f32| if x > 0.0 { x / short } else { x / long } + SLACK;
    Some([low.map(|x| -above(-x)), high.map(above)])
}

/// Rows of a piece to be diced, in grid points.
struct Rows {
    low: [i32; 2],
    high: [i32; 2],
    origin: [i32; 2],
    size: i32,
    /// The piece's, of that grid.
    level: u32,
    start: [i32; 2],
}

/// Part of a row: its number in the piece, the first column from the piece's left end, the number of points and where they go.
struct Row {
    j: usize,
    first: usize,
    count: usize,
    to: usize,
}

/// Writes the first `n` points of a line.
#[inline(always)]
fn put(grid: &mut Grid3, at: usize, n: usize, line: &[Line; 3]) {
    grid.x[at..at + n].copy_from_slice(&line[0][..n]);
    grid.y[at..at + n].copy_from_slice(&line[1][..n]);
    grid.z[at..at + n].copy_from_slice(&line[2][..n]);
}
