//! Points and normals along a cage edge, by the edge's own rule: the operands are the rings of its two end vertices and nothing else,
//! so both faces at the edge get the same bits without talking to each other.
//!
//! * Both ends regular: the twelve points around the edge are a B-spline strip.
//! * Otherwise each half belongs to its end. At a regular end the half is a strip of the once-refined net. At an irregular end it is a
//!   chain of strips, each half as long as the one before, from the nets of deeper and deeper levels. The middle is that of the half at the
//!   lower vertex number.
//! * On a boundary the points (not the normals) come from the boundary polygon alone, so that all faces of a non-manifold edge agree.
//!
//! A face takes the strips from its own nets. Their points have the same bits in the nets of the face beyond, because all rules of
//! refinement are symmetric in the bits; so is what follows: exchanging left and right, or walking the other way, changes no bit.

use super::basis::{Basis, Target};
use super::net::Net;
use super::point::P4;
use super::regular::{LANES, Lanes3, blend, mix3, one_by_one, unit_lanes, unit_of};
use crate::records::{BLOCK_STRIDE, Grid3};
use crate::simd::Level;
use std::hint::black_box;

/// Samples along one side of a face: positions and unit normals, component by component, padded by [`LANES`].
#[derive(Clone, Debug, Default)]
pub(crate) struct EdgeSamples {
    pub(crate) points: [Vec<f32>; 3],
    pub(crate) normals: [Vec<f32>; 3],
}

impl EdgeSamples {
    pub(crate) fn resize(&mut self, segments: usize) {
        for v in self.points.iter_mut().chain(&mut self.normals) {
            v.resize(segments + 1 + LANES, 0.0);
        }
    }
    /// Takes over all samples of `from`, from its end if `reversed`: points, normals, or both.
    pub(crate) fn copy(&mut self, from: &Self, reversed: bool, [points, normals]: [bool; 2]) {
        let pairs = (self.points.iter_mut().zip(&from.points).filter(|_| points)).chain(
            self.normals
                .iter_mut()
                .zip(&from.normals)
                .filter(|_| normals),
        );
        for (to, from) in pairs {
            let n = to.len() - LANES;
            to[..n].copy_from_slice(&from[..n]);
            if reversed {
                to[..n].reverse();
            }
        }
    }
    pub(crate) fn set(&mut self, i: usize, point: [f32; 3], normal: [f32; 3]) {
        for c in 0..3 {
            self.points[c][i] = point[c];
            self.normals[c][i] = normal[c];
        }
    }
}

/// Samples of a strip that are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SamplePart {
    All,
    /// The last one is left to the strip that follows.
    ButLast,
    First,
}

/// Which samples of a strip are wanted and where they go: at `0, 1/n, … 1` with `n = 2^level`, to places `at`, `at + step`, ….
#[derive(Clone, Copy, Debug)]
pub(crate) struct Samples {
    pub(crate) target: Target,
    pub(crate) level: u32,
    pub(crate) at: i64,
    pub(crate) step: i64,
    pub(crate) simd: Level,
    /// Whether normals are wanted too.
    pub(crate) normals: bool,
    /// Which of them are wanted.
    pub(crate) part: SamplePart,
}

/// Where a line of samples goes; places count from the line's begin.
pub(super) trait Put {
    /// The first `n` of `W` values, at `at` and the places after it.
    fn put<const W: usize>(&mut self, at: usize, n: usize, values: &Lanes3<W>);
    fn put_one(&mut self, at: usize, value: [f32; 3]);
}

/// A row or column of a block.
pub(super) struct GridLine<'a> {
    grid: &'a mut Grid3,
    /// Index of the first place, and from one place to the next.
    first: usize,
    step: usize,
}

impl<'a> GridLine<'a> {
    /// Row or column `across`, whichever side `c` is.
    #[inline(always)]
    pub(super) fn new(grid: &'a mut Grid3, c: usize, across: usize) -> Self {
        let (first, step) = match c & 1 {
            0 => (across * BLOCK_STRIDE, 1),
            _ => (across, BLOCK_STRIDE),
        };
        Self { grid, first, step }
    }
}

/// The first `n` values, to places of a column from index `first` on.
#[inline(always)]
fn scatter<const W: usize>(column: [&mut [f32]; 3], first: usize, n: usize, values: &Lanes3<W>) {
    let last = first + (n - 1) * BLOCK_STRIDE;
    let [x, y, z] = column.map(|c| &mut c[first..=last]);
    for i in 0..n {
        x[i * BLOCK_STRIDE] = values.0[0][i];
        y[i * BLOCK_STRIDE] = values.0[1][i];
        z[i * BLOCK_STRIDE] = values.0[2][i];
    }
}

impl Put for GridLine<'_> {
    #[inline(always)]
    fn put<const W: usize>(&mut self, at: usize, n: usize, values: &Lanes3<W>) {
        let first = self.first + at * self.step;
        let Grid3 { x, y, z } = &mut *self.grid;
        if self.step > 1 {
            // A number that is known makes lanes of it.
            match n == W {
                true => scatter([x, y, z], first, W, values),
                false => scatter([x, y, z], first, n, values),
            }
        } else if n == W {
            x[first..first + W].copy_from_slice(&values.0[0]);
            y[first..first + W].copy_from_slice(&values.0[1]);
            z[first..first + W].copy_from_slice(&values.0[2]);
        } else {
            for i in 0..n {
                one_by_one();
                x[first + i] = values.0[0][i];
                y[first + i] = values.0[1][i];
                z[first + i] = values.0[2][i];
            }
        }
    }
    #[inline(always)]
    fn put_one(&mut self, at: usize, value: [f32; 3]) {
        let k = self.first + at * self.step;
        (self.grid.x[k], self.grid.y[k], self.grid.z[k]) = (value[0], value[1], value[2]);
    }
}

/// A list of points, filled from its end if `reversed`.
pub(super) struct PointLine<'a> {
    pub(super) points: &'a mut [[f32; 3]],
    pub(super) reversed: bool,
}

impl Put for PointLine<'_> {
    #[inline(always)]
    fn put<const W: usize>(&mut self, at: usize, n: usize, values: &Lanes3<W>) {
        for i in 0..n {
            self.put_one(at + i, [0, 1, 2].map(|c| values.0[c][i]));
        }
    }
    #[inline(always)]
    fn put_one(&mut self, at: usize, value: [f32; 3]) {
        let last = self.points.len() - 1;
        self.points[if self.reversed { last - at } else { at }] = value;
    }
}

/// The part of a side that a block shows, in points of a grid that has every `2^shift`-th point of the face's own.
#[derive(Clone, Copy, Debug)]
pub(super) struct SideRange {
    pub(super) target: Target,
    pub(super) shift: u32,
    /// First and last place, and that of the line's begin.
    pub(super) low: u32,
    pub(super) high: u32,
    pub(super) start: u32,
}

/// Three by four control points along a side of a face, in the direction in which u or v grows, where they stand in a net.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strip<'a> {
    net: &'a Net<5>,
    /// Row or column of the middle line; the one before is on the side of the lower v or u.
    line: usize,
    /// Columns or rows of the four.
    places: [usize; 4],
    /// Whether it runs along v.
    vertical: bool,
}

/// Where a strip lies on its side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    /// Place of its begin, and segments.
    pub(super) first: u32,
    /// Steps of refinement that its points have still to go.
    pub(super) level: u32,
    /// First and last place that it shows.
    pub(super) own: [u32; 2],
}

impl Span {
    /// The places of a range that the strip shows, and the level that they have there.
    #[inline(always)]
    pub(super) fn run(&self, range: SideRange) -> Option<(Run, u32)> {
        let round = (1 << range.shift) - 1;
        let low = ((self.own[0] + round) >> range.shift).max(range.low);
        let high = (self.own[1] >> range.shift).min(range.high);
        let run = |low: u32, high: u32| Run {
            at: (low - range.start) as usize,
            first: (low - (self.first >> range.shift)) as usize,
            count: (high - low + 1) as usize,
        };
        (low <= high).then(|| (run(low, high), self.level.saturating_sub(range.shift)))
    }
}

impl<'a> Strip<'a> {
    /// The strip along side `side` of the spline whose net begins at a row and column of `net`.
    #[inline(always)]
    pub(super) fn of(net: &'a Net<5>, [row, col]: [usize; 2], side: usize) -> Self {
        // The line of control points that belongs to the side.
        let middle = if side == 1 || side == 2 { 2 } else { 1 };
        let (line, first) = match side & 1 {
            0 => (row & 1, col & 1),
            _ => (col & 1, row & 1),
        };
        Self {
            net,
            line: line + middle,
            places: [0, 1, 2, 3].map(|i| first + i),
            vertical: side & 1 == 1,
        }
    }

    /// The strip whose begin or end is the middle of side `side`, from the once-refined net, as the half at the end `high` or low says
    /// it; and whether it is the strip's end.
    pub(super) fn at_middle(
        net: &'a Net<5>,
        side: usize,
        high: bool,
        regular: bool,
    ) -> (Self, bool) {
        let middle = if side == 1 || side == 2 { 3 } else { 1 };
        // An irregular end has no regular row behind it, and the row at the far end has no weight in the middle.
        let places = match (high, regular) {
            (false, true) => [0, 1, 2, 3],
            (false, false) => [1, 2, 3, 3],
            (true, true) => [1, 2, 3, 4],
            (true, false) => [1, 1, 2, 3],
        };
        let strip = Self {
            net,
            line: middle,
            places,
            vertical: side & 1 == 1,
        };
        (strip, high != regular)
    }

    /// What `f` makes of the four points of the line before, of the middle line and of the line after.
    #[inline(always)]
    fn each(&self, f: impl Fn(P4, P4, P4) -> P4) -> [P4; 4] {
        let Self { net, line: k, .. } = *self;
        let mut out = [P4::ZERO; 4];
        if self.vertical {
            for (out, &i) in out.iter_mut().zip(&self.places) {
                *out = f(net[i][k - 1], net[i][k], net[i][k + 1]);
            }
        } else {
            let (low, middle, high) = (&net[k - 1], &net[k], &net[k + 1]);
            for (out, &i) in out.iter_mut().zip(&self.places) {
                *out = f(low[i], middle[i], high[i]);
            }
        }
        // Through memory: the compiler would leave out the fourth of each point and go through the others one by one.
        black_box(out)
    }

    /// The strip's middle line: each centre blended with its neighbours.
    #[inline(always)]
    fn across(&self, [side, centre]: [f32; 2]) -> [P4; 4] {
        self.each(|minus, middle, plus| (minus + plus) * side + middle * centre)
    }

    /// Differences across, and a normal for points where the tangents are parallel.
    #[inline(always)]
    fn slopes(&self) -> ([P4; 4], [f32; 3]) {
        let across = self.each(|minus, _, plus| plus - minus);
        let centre = |i: usize| match self.vertical {
            false => self.net[self.line][self.places[i]],
            true => self.net[self.places[i]][self.line],
        };
        let along = centre(2) - centre(1);
        let normal = if self.vertical {
            (across[1] + across[2]).cross(along)
        } else {
            along.cross(across[1] + across[2])
        };
        let spare = match normal.unit() {
            // As in `unit_of`: no -0, which the other face would see as 0.
            Some(normal) => normal.xyz().map(|c| c + 0.0),
            None => [0.0, 0.0, 1.0],
        };
        (across, spare)
    }

    /// Points and normals of a run of places of a level.
    #[inline(always)]
    pub(super) fn sample(
        &self,
        run: Run,
        target: Target,
        level: u32,
        points: &mut impl Put,
        normals: Option<&mut impl Put>,
    ) {
        match run.count {
            9.. => self.sample_lanes::<16>(run, target, level, points, normals),
            5..=8 => self.sample_lanes::<8>(run, target, level, points, normals),
            _ => self.sample_lanes::<4>(run, target, level, points, normals),
        }
    }

    #[inline(always)]
    fn sample_lanes<const W: usize>(
        &self,
        run: Run,
        target: Target,
        level: u32,
        points: &mut impl Put,
        normals: Option<&mut impl Put>,
    ) {
        let basis = Basis::get(target, level);
        let row = self.across(basis.across);
        let mut line = Lanes3::<W>::zeros();
        for i in (0..run.count).step_by(W) {
            mix3(&basis.point.lanes::<W>(run.first + i), &row, &mut line);
            points.put(run.at + i, (run.count - i).min(W), &line);
        }
        let Some(normals) = normals else { return };
        let along = self.across(Basis::get(Target::Limit, 0).across);
        let (across, spare) = self.slopes();
        let (mut du, mut dv) = (Lanes3::<W>::zeros(), Lanes3::<W>::zeros());
        let lanes = black_box(W);
        for i in (0..run.count).step_by(W) {
            mix3(&basis.slope.lanes::<W>(run.first + i), &along, &mut du);
            mix3(&basis.limit.lanes::<W>(run.first + i), &across, &mut dv);
            if self.vertical {
                unit_lanes(&dv, &du, lanes, spare, &mut line);
            } else {
                unit_lanes(&du, &dv, lanes, spare, &mut line);
            }
            normals.put(run.at + i, (run.count - i).min(W), &line);
        }
    }

    /// Normal at one place of a level.
    #[inline(always)]
    fn normal(&self, level: u32, at: usize) -> [f32; 3] {
        let basis = Basis::get(Target::Limit, level);
        let along = self.across(Basis::get(Target::Limit, 0).across);
        let (across, spare) = self.slopes();
        let du = blend(basis.slope.at(at), along).xyz();
        let dv = blend(basis.limit.at(at), across).xyz();
        if self.vertical {
            unit_of(dv, du, spare)
        } else {
            unit_of(du, dv, spare)
        }
    }

    /// Point and normal at the begin of the strip or at its end, which is place `n` of `level`.
    pub(super) fn end(&self, target: Target, level: u32, end: bool) -> [f32; 3] {
        let basis = Basis::get(target, level);
        let at = if end { 1 << level } else { 0 };
        blend(basis.point.at(at), self.across(basis.across)).xyz()
    }

    pub(super) fn end_normal(&self, level: u32, end: bool) -> [f32; 3] {
        self.normal(level, if end { 1 << level } else { 0 })
    }
}

/// Places of a line, and the first of them on a strip.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    at: usize,
    first: usize,
    count: usize,
}

/// Points of a boundary curve from its own polygon: `p[1]` to `p[2]`, with the neighbours before and after.
#[inline(always)]
pub(super) fn sample_polygon(p: &[P4; 4], level: u32, range: SideRange, points: &mut impl Put) {
    let basis = Basis::get(range.target, level.saturating_sub(range.shift));
    let count = (range.high - range.low + 1) as usize;
    let mut line = Lanes3::<16>::zeros();
    for i in (0..count).step_by(16) {
        mix3(
            &basis.point.lanes::<16>(range.low as usize + i),
            p,
            &mut line,
        );
        points.put(
            (range.low - range.start) as usize + i,
            (count - i).min(16),
            &line,
        );
    }
}

impl Samples {
    /// Number of samples.
    #[inline(always)]
    pub(crate) fn count(&self) -> usize {
        match self.part {
            SamplePart::All => (1 << self.level) + 1,
            SamplePart::ButLast => 1 << self.level,
            SamplePart::First => 1,
        }
    }
}

/// Points of a boundary curve from its own polygon: `p[1]` to `p[2]`, with the neighbours before and after.
pub(crate) fn sample_boundary(
    p: [P4; 4],
    target: Target,
    level: u32,
    out: &mut EdgeSamples,
    at: i64,
    step: i64,
) {
    let basis = Basis::get(target, level);
    for i in 0..=1_usize << level {
        let w: [f32; 4] = basis.point.at(i);
        let q = (p[0] * w[0] + p[3] * w[3]) + (p[1] * w[1] + p[2] * w[2]);
        for c in 0..3 {
            out.points[c][(at + i as i64 * step) as usize] = q.0[c];
        }
    }
}
