//! What every step of refinement adds: a point that is new in a step lies off the middle of the edge that it splits, by its *surplus*.
//!
//! Triangles of one level are as far from the surface as all later surpluses say: at the middle of an edge by the edge's own, a quarter
//! along it by half of that and by one of the next step (Yserentant, *On the multi-level splitting of finite element spaces*, 1986). So a
//! grid is measured once for all of its levels, every point once, and curves that an edge cuts in the middle are not missed.

use super::screen::{Metric, Seen};
use crate::dispatch;
use crate::records::{BLOCK_STRIDE, Grid3};
use crate::simd::Level;
use crate::tessellate::quadtree::{MAX_LOG, Shape};

/// What a step of the grid below the samples is expected to leave: a quarter where the surface has second derivatives.
pub(crate) const LEFT: f32 = 0.4;

/// What is smaller, in pixels, has no normals of its own to be seen. Moved points make two cells one triangle, which should not be above a
/// pixel then.
pub(crate) const DOT: f32 = 0.45;

/// By how much more than two steps the later ones may add at an irregular corner.
pub(crate) const UNEVEN: f32 = 1.3;

/// Planes are whole vectors of any width.
const LANES: usize = 16;

/// Points with a surplus in each direction of step `k`, `2^k + 1` in a row like the cells' corners, the last of a row or column without meaning,
/// and what is beyond the last row.
const fn plane(k: u32) -> usize {
    (((1 << k) + 1) * ((1 << k) + 1_usize)).next_multiple_of(LANES)
}

/// Where step `k` of a square begins: planes of what splits edges along u, along v, and diagonals, step by step.
const BEFORE: [usize; MAX_LOG as usize + 1] = {
    let mut out = [0; MAX_LOG as usize + 1];
    let mut k = 0;
    while k < MAX_LOG {
        out[k as usize + 1] = out[k as usize] + 3 * plane(k);
        k += 1;
    }
    out
};

/// Six components of points: as the eye sees them, and their normals.
pub(super) type Six = [Vec<f32>; 6];

/// Measures surpluses; buffers of one thread.
#[derive(Debug)]
pub(super) struct Surplus {
    simd: Level,
    log: u32,
    /// Samples of a step.
    samples: Six,
    /// Those of even rows, at even and odd columns, and those of odd rows: the samples of the step before, and what splits its edges.
    phases: [Six; 4],
    /// Distances, and distances of normals, by what is allowed; and lengths of the edges in pixels.
    found: [Vec<f32>; 3],
    /// What step `k` adds to each of the `2^k` by `2^k` cells, step by step.
    cells: Vec<Added>,
    /// The most that step `k` adds anywhere, distance or bend.
    most: [f32; MAX_LOG as usize + 1],
}

/// What a step adds to a cell or segment.
#[derive(Clone, Copy, Debug, Default)]
struct Added {
    /// Distance, and that of normals, by what is allowed.
    far: f32,
    bend: f32,
    /// The longest edge, in pixels.
    length: f32,
}

impl Added {
    fn max(self, o: Self) -> Self {
        Self {
            far: self.far.max(o.far),
            bend: self.bend.max(o.bend),
            length: self.length.max(o.length),
        }
    }

    /// The larger of distance and bend, of triangles as long as `length`.
    fn of(self, length: f32) -> f32 {
        match length > DOT {
            true => self.far.max(self.bend),
            false => self.far,
        }
    }

    /// Whether triangles are too far that lack this step and the one below, which adds `next` to the parts; later ones add `more` times as
    /// much as is to be expected.
    fn is_far(self, next: Self, more: f32) -> bool {
        // Normals between the samples count as long as the triangles do, however small their parts are.
        let below = |own: f32, next: f32| more * (0.5 * own + next) > 1.0;
        let bent = self.length > DOT && below(self.bend, next.bend);
        self.of(self.length) > 1.0 || below(self.far, next.far) || bent
    }
}

/// Where the cells of step `k` begin.
fn first_cell(k: u32) -> usize {
    ((1 << (2 * k)) - 1) / 3
}

/// Samples of a square of a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Square {
    /// `2^log` segments along each side.
    pub(super) log: u32,
    /// Of a triangle, only what is not above the diagonal counts.
    pub(super) shape: Shape,
    /// Whether each corner of the square is one of the face's.
    pub(super) corners: [bool; 4],
    /// Whether it is an irregular one.
    pub(super) irregular: [bool; 4],
}

impl Square {
    /// How much of what a step may add to cell (`x`, `y`) of the `2^k` by `2^k` beyond the samples it is expected to add. At an irregular vertex,
    /// where parameters run unevenly, that is nearly all of it at a high valence; at any corner of a face there may be a feature that the
    /// samples do not know.
    pub(super) fn left(&self, k: u32, at: [u32; 2]) -> f32 {
        match self.is_at(self.corners, k, at) {
            true => 1.0,
            false => LEFT,
        }
    }

    /// Whether cell (`x`, `y`) of the `2^k` by `2^k` is at one of some corners.
    fn is_at(&self, corners: [bool; 4], k: u32, at: [u32; 2]) -> bool {
        let last = (1 << k) - 1;
        let ends = [[0, 0], [last, 0], [last, last], [0, last]];
        (0..4).any(|c| corners[c] && ends[c] == at)
    }
}

impl Surplus {
    pub(super) fn new(simd: Level) -> Self {
        Self {
            simd,
            log: 0,
            samples: Default::default(),
            phases: Default::default(),
            found: Default::default(),
            cells: Vec::new(),
            most: Default::default(),
        }
    }

    /// Measures the points of a grid of `2^log` segments a side. `points` becomes what the eye sees.
    pub(super) fn grid(
        &mut self,
        metric: &Metric<'_>,
        (log, shape): (u32, Shape),
        points: &mut Grid3,
        normals: &Grid3,
    ) {
        self.log = log;
        self.found
            .iter_mut()
            .for_each(|f| f.resize(BEFORE[MAX_LOG as usize], 0.0));
        let cells = first_cell(log).max(self.cells.len());
        self.cells.resize(cells, Added::default());
        dispatch!(self.simd, self.steps(metric, points, normals));
        if shape == Shape::Triangle {
            self.halve();
        }
    }

    /// Cells on the diagonal of a triangle are half.
    fn halve(&mut self) {
        for k in 0..self.log {
            let (n, size) = (1 << k, plane(k));
            for x in 0..n {
                let u = BEFORE[k as usize] + x * (n + 1) + x;
                let (v, d) = (u + size, u + 2 * size);
                self.cells[first_cell(k) + x * n + x] = self.worst([u, v + 1, d].into_iter());
            }
        }
    }

    /// What step `k` adds to its cells, whole squares.
    #[inline(always)]
    fn gather_cells(&mut self, k: u32) {
        let (n, row, size) = (1_usize << k, (1_usize << k) + 1, plane(k));
        let (first, at) = (BEFORE[k as usize], first_cell(k));
        self.most[k as usize] = 0.0;
        for y in 0..n {
            let out = &mut self.cells[at + y * n..at + (y + 1) * n];
            let edges = |c: usize| {
                let f = &self.found[c];
                let u = first + y * row;
                let (v, d) = (u + size, u + 2 * size);
                [u, u + row, v, v + 1, d].map(|from| &f[from..from + n])
            };
            let ([fa, fb, fc, fd, fe], [ba, bb, bc, bd, be], [la, lb, lc, ld, le]) =
                (edges(0), edges(1), edges(2));
            let mut all = 0.0_f32;
            for x in 0..n {
                let most = |a: f32, b: f32, c: f32, d: f32, e: f32| a.max(b).max(c.max(d)).max(e);
                let far = most(fa[x], fb[x], fc[x], fd[x], fe[x]);
                let bend = most(ba[x], bb[x], bc[x], bd[x], be[x]);
                let length = most(la[x], lb[x], lc[x], ld[x], le[x]);
                out[x] = Added { far, bend, length };
                all = all.max(far.max(bend));
            }
            self.most[k as usize] = self.most[k as usize].max(all);
        }
    }

    /// Step by step from the finest.
    #[inline(always)]
    fn steps(&mut self, metric: &Metric<'_>, points: &mut Grid3, normals: &Grid3) {
        transform(&metric.seen(), 1 << self.log, points);
        let grids = [
            &points.x, &points.y, &points.z, &normals.x, &normals.y, &normals.z,
        ];
        for k in (0..self.log).rev() {
            let (n, size) = (1 << k, plane(k));
            for (c, samples) in self.samples.iter().enumerate() {
                let phases = self.phases.each_mut().map(|p| &mut p[c]);
                if k + 1 == self.log {
                    split(n, grids[c], BLOCK_STRIDE, phases);
                } else {
                    split(n, samples, 2 * n + 1, phases);
                }
            }
            let [even, u, v, diagonal] = &self.phases;
            for (d, (middle, next)) in [(u, 1), (v, n + 1), (diagonal, n + 2)].iter().enumerate() {
                let first = BEFORE[k as usize] + d * size;
                let found = self.found.each_mut().map(|f| &mut f[first..first + size]);
                metric.surpluses(middle, even, *next, found);
            }
            std::mem::swap(&mut self.samples, &mut self.phases[0]);
            self.gather_cells(k);
        }
    }

    /// Measures the points of a line of `2^log` segments.
    pub(super) fn line(
        &mut self,
        metric: &Metric<'_>,
        log: u32,
        points: &[[f32; 3]],
        normals: &[[f32; 3]],
    ) {
        let seen = metric.seen();
        self.samples.iter_mut().for_each(Vec::clear);
        for (&p, n) in points.iter().zip(normals) {
            let p = seen.point(p);
            for k in 0..3 {
                self.samples[k].push(p[k]);
                self.samples[3 + k].push(n[k]);
            }
        }
        self.log = log;
        self.found
            .iter_mut()
            .for_each(|f| f.resize(f.len().max(1 << log), 0.0));
        dispatch!(self.simd, self.halves(metric));
    }

    #[inline(always)]
    fn halves(&mut self, metric: &Metric<'_>) {
        for k in (0..self.log).rev() {
            let n = 1 << k;
            let [even, odd, ..] = &mut self.phases;
            for (c, samples) in self.samples.iter().enumerate() {
                even[c].clear();
                odd[c].clear();
                even[c].extend(samples.iter().step_by(2));
                odd[c].extend(samples[1..].iter().step_by(2));
            }
            let found = self.found.each_mut().map(|f| &mut f[n - 1..2 * n - 1]);
            metric.surpluses(odd, even, 1, found);
            std::mem::swap(&mut self.samples, &mut self.phases[0]);
        }
    }

    /// What a set of edges adds.
    fn worst(&self, edges: impl Iterator<Item = usize>) -> Added {
        let [far, bend, length] = &self.found;
        let edge = |k: usize| Added {
            far: far[k],
            bend: bend[k],
            length: length[k],
        };
        edges.map(edge).fold(Added::default(), Added::max)
    }

    /// What step `k` adds to segment `i` of the `2^k` of a line.
    fn of_segment(&self, k: u32, i: usize) -> Added {
        self.worst(std::iter::once((1 << k) - 1 + i))
    }

    /// Whether segment `i` of the `2^k` of a line is too far from its chord; `None` where no sample tells.
    pub(super) fn is_bent(&self, k: u32, i: usize) -> Option<bool> {
        if k >= self.log {
            return None;
        }
        let own = self.of_segment(k, i);
        let next = match k + 1 < self.log {
            true => [0, 1].map(|c| self.of_segment(k + 1, 2 * i + c)),
            false => <[Added; 2]>::default(),
        };
        Some(own.is_far(next[0].max(next[1]), 1.0))
    }

    /// What step `k` adds to cell (`x`, `y`) of the `2^k` by `2^k` of a square.
    fn of_cell(&self, k: u32, [x, y]: [u32; 2]) -> Added {
        self.cells[first_cell(k) + ((y as usize) << k) + x as usize]
    }

    /// How many samples along a side a square asks for, as a power of two, if every step leaves a quarter of the one before.
    pub(super) fn promising(&self, square: &Square) -> u32 {
        let Some(k) = self.log.checked_sub(1) else {
            return 1;
        };
        let cells = (0..1_u32 << (2 * k)).map(|c| [c & ((1 << k) - 1), c >> k]);
        let cells = cells.filter(|[x, y]| square.shape == Shape::Square || y <= x);
        let added = cells.map(|c| self.of_cell(k, c));
        let mut left = added.fold(0.0_f32, |m, a| m.max(a.of(a.length)));
        let mut log = self.log;
        while left > 1.0 && log < MAX_LOG {
            (left, log) = (left * 0.25, log + 1);
        }
        log
    }

    /// Whether no cell of the `2^k` by `2^k` can be too far, whatever its corners are.
    fn is_quiet(&self, k: u32) -> bool {
        let most = |k: u32| self.most[k as usize];
        if k == self.log {
            return most(k - 1) <= 1.0;
        }
        match k + 1 < self.log {
            true => most(k) <= 1.0 && UNEVEN * (0.5 * most(k) + most(k + 1)) <= 1.0,
            false => 2.0 * most(k) <= 1.0,
        }
    }

    /// What the step after the last may add to the quarters of cell (`x`, `y`) of that, if it left none of it out.
    pub(super) fn beyond(&self, square: &Square, at: [u32; 2]) -> f32 {
        let k = self.log - 1;
        if self.is_quiet(self.log) {
            return 0.0;
        }
        // Where normals turn fast, a step may add nothing by chance: those beside it add something.
        let near = |c: u32| c.saturating_sub(1)..=(c + 1).min((1 << k) - 1);
        let cells = near(at[1]).flat_map(|y| near(at[0]).map(move |x| [x, y]));
        let cells = cells.filter(|[x, y]| square.shape == Shape::Square || y <= x);
        let added = cells.map(|c| self.of_cell(k, c));
        let added = added.fold(Added::default(), Added::max);
        added.of(0.5 * self.of_cell(k, at).length)
    }

    /// Whether cell (`x`, `y`) of the `2^k` by `2^k` of a square is too far from the surface; `k` is a step of the samples.
    pub(super) fn is_far(&self, square: &Square, k: u32, at: [u32; 2]) -> bool {
        if self.is_quiet(k) {
            return false;
        }
        let shape = square.shape;
        let own = self.of_cell(k, at);
        let irregular = square.is_at(square.irregular, k, at);
        if k + 1 == self.log {
            // What the next step adds is as much again at an irregular corner.
            let more = if irregular { 2.0 } else { 1.0 };
            return more * own.of(own.length) > 1.0;
        }
        let half = shape == Shape::Triangle && at[0] == at[1];
        let children = [[0, 0], [1, 0], [1, 1], [0, 1]];
        let children = children.iter().take(if half { 3 } else { 4 });
        let next = children.map(|c| self.of_cell(k + 1, [0, 1].map(|i| 2 * at[i] + c[i])));
        let next = next.fold(Added::default(), Added::max);
        own.is_far(next, if irregular { UNEVEN } else { 1.0 })
    }
}

/// Splits samples of `2 n + 1` rows, `stride` apart, of as many columns into those of even and odd columns of even rows, then of odd rows.
#[inline(always)]
fn split(n: usize, samples: &[f32], stride: usize, phases: [&mut Vec<f32>; 4]) {
    let row = n + 1;
    let [a, b, c, d] = phases.map(|p| {
        // What the last of a plane are split with lies beyond its end.
        p.resize((row * row).next_multiple_of(LANES) + n + 2, 0.0);
        &mut p[..row * row]
    });
    for y in 0..=2 * n {
        let at = y / 2 * row..(y / 2 + 1) * row;
        let (even, odd) = match y % 2 {
            0 => (&mut a[at.clone()], &mut b[at]),
            _ => (&mut c[at.clone()], &mut d[at]),
        };
        let samples = &samples[y * stride..][..2 * n + 1];
        even[n] = samples[2 * n];
        let pairs = samples.chunks_exact(2);
        for ((even, odd), pair) in even.iter_mut().zip(odd).zip(pairs) {
            (*even, *odd) = (pair[0], pair[1]);
        }
    }
}

/// Points as the eye sees them, in place.
#[inline(always)]
fn transform(seen: &Seen, n: usize, points: &mut Grid3) {
    for j in 0..=n {
        // Whole vectors; nothing beyond the last column is looked at.
        let columns = (n + 1).next_multiple_of(LANES).min(BLOCK_STRIDE);
        let row = j * BLOCK_STRIDE..j * BLOCK_STRIDE + columns;
        let (x, y) = (&mut points.x[row.clone()], &mut points.y[row.clone()]);
        let z = &mut points.z[row][..x.len()];
        let y = &mut y[..x.len()];
        for i in 0..x.len() {
            [x[i], y[i], z[i]] = seen.point([x[i], y[i], z[i]]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_split_by_the_parity_of_their_places() {
        for log in 1..=MAX_LOG {
            let (n, stride) = (1 << (log - 1), 50);
            let samples: Vec<f32> = (0..40 * stride).map(|k| k as f32).collect();
            let mut phases = [(); 4].map(|()| Vec::new());
            split(n, &samples, stride, phases.each_mut());
            for (k, phase) in phases.iter().enumerate() {
                let (right, down) = (k % 2, k / 2);
                for (y, x) in (0..=n - down).flat_map(|y| (0..=n - right).map(move |x| (y, x))) {
                    let place = (2 * y + down) * stride + 2 * x + right;
                    assert_eq!(phase[y * (n + 1) + x], place as f32);
                }
            }
        }
    }

    #[test]
    fn steps_lie_one_after_the_other() {
        assert_eq!(BEFORE[..4], [0, 48, 96, 192]);
    }
}
