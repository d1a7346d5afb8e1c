//! What every step of refinement adds: a point that is new in a step lies off the middle of the edge that it splits, by its *surplus*.
//!
//! Triangles of one level are as far from the surface as all later surpluses say: at the middle of an edge by the edge's own, a quarter
//! along it by half of that and by one of the next step (Yserentant, *On the multi-level splitting of finite element spaces*, 1986). So a
//! grid is measured once for all of its levels, every point once, and curves that an edge cuts in the middle are not missed.

use super::screen::{Metric, Seen};
use crate::dispatch;
use crate::records::{BLOCK_STRIDE, Grid3};
use crate::simd::{LANES, Level};
use crate::tessellate::quadtree::{MAX_LOG, Shape};
use std::sync::OnceLock;

/// Most samples along a line, as a power of two.
const LINE_LOG: usize = crate::dice::MAX_LEVEL as usize;

/// What a step of the grid below the samples is expected to leave: a quarter where the surface has second derivatives.
const LEFT: f32 = 0.4;

/// Points and the two ends of the edges that they split, by their places in the samples.
type Splits = Vec<[u16; 3]>;

/// Points along a line of `2^log` segments, step by step.
fn line_splits(log: usize) -> &'static Splits {
    static TABLES: [OnceLock<Splits>; LINE_LOG + 1] = [const { OnceLock::new() }; LINE_LOG + 1];
    TABLES[log].get_or_init(|| {
        let step = |k: usize| {
            let h = 1_u16 << (log - k - 1);
            (0..1_u16 << k).map(move |i| [2 * i * h + h, 2 * i * h, 2 * (i + 1) * h])
        };
        (0..log).flat_map(step).collect()
    })
}

/// Points of a square of `2^log` segments a side, step by step: first those on edges along u, then along v, then on diagonals.
fn square_splits(log: usize) -> &'static Splits {
    static TABLES: [OnceLock<Splits>; MAX_LOG as usize + 1] =
        [const { OnceLock::new() }; MAX_LOG as usize + 1];
    TABLES[log].get_or_init(|| {
        let mut out = Splits::new();
        for k in 0..log {
            let (n, h) = (1_usize << k, 1_usize << (log - k - 1));
            let mut push = |p: [usize; 2], d: [usize; 2]| {
                let at = |[i, j]: [usize; 2]| (j * BLOCK_STRIDE + i) as u16;
                let [low, high] = [[p[0] - d[0], p[1] - d[1]], [p[0] + d[0], p[1] + d[1]]];
                out.push([at(p), at(low), at(high)]);
            };
            let each = |i: usize, j: usize| {
                (0..j).flat_map(move |y| (0..i).map(move |x| [2 * h * x, 2 * h * y]))
            };
            each(n, n + 1).for_each(|[x, y]| push([x + h, y], [h, 0]));
            each(n + 1, n).for_each(|[x, y]| push([x, y + h], [0, h]));
            each(n, n).for_each(|[x, y]| push([x + h, y + h], [h, h]));
        }
        out
    })
}

/// Points before step `k` of [`square_splits`]: all but the corners.
fn before(k: u32) -> usize {
    ((1 << k) + 1) * ((1 << k) + 1) - 4
}

/// Measures surpluses; buffers of one thread.
#[derive(Debug)]
pub(super) struct Surplus {
    simd: Level,
    log: u32,
    /// Six components of points, and of the ends of their edges.
    fields: [[Vec<f32>; 6]; 3],
    /// Distances, and distances of normals, by what is allowed; and lengths of the edges in pixels.
    found: [Vec<f32>; 3],
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
}

impl Surplus {
    pub(super) fn new(simd: Level) -> Self {
        Self {
            simd,
            log: 0,
            fields: Default::default(),
            found: Default::default(),
        }
    }

    fn measure(&mut self, metric: &Metric<'_>, splits: &Splits, samples: [&[f32]; 6]) {
        let n = splits.len().next_multiple_of(LANES);
        for (k, fields) in self.fields.iter_mut().enumerate() {
            for (field, samples) in fields.iter_mut().zip(samples) {
                field.clear();
                field.extend(splits.iter().map(|s| samples[usize::from(s[k])]));
                field.resize(n, 0.0);
            }
        }
        self.found.iter_mut().for_each(|f| f.resize(n, 0.0));
        let Self { fields, found, .. } = self;
        dispatch!(self.simd, metric.surpluses(n, fields, found));
    }

    /// Measures the points of a grid of `2^log` segments a side. `points` becomes what the eye sees.
    pub(super) fn grid(
        &mut self,
        metric: &Metric<'_>,
        log: u32,
        points: &mut Grid3,
        normals: &Grid3,
    ) {
        let (n, seen) = (1_usize << log, metric.seen());
        dispatch!(self.simd, transform(&seen, n, points));
        let samples = [
            &points.x[..],
            &points.y,
            &points.z,
            &normals.x,
            &normals.y,
            &normals.z,
        ];
        self.log = log;
        self.measure(metric, square_splits(log as usize), samples);
    }

    /// Measures the points of a line of `2^log` segments.
    pub(super) fn line(
        &mut self,
        metric: &Metric<'_>,
        log: u32,
        points: &[[f32; 3]],
        normals: &[[f32; 3]],
        buffers: &mut [Vec<f32>; 6],
    ) {
        let seen = metric.seen();
        for k in 0..3 {
            buffers[k].clear();
            buffers[3 + k].clear();
            buffers[3 + k].extend(normals.iter().map(|n| n[k]));
        }
        for &p in points {
            let p = seen.point(p);
            (0..3).for_each(|k| buffers[k].push(p[k]));
        }
        let [a, b, c, d, e, f] = buffers;
        self.log = log;
        self.measure(metric, line_splits(log as usize), [a, b, c, d, e, f]);
    }

    /// What a set of edges adds: distances, or also of normals unless all edges are dots.
    fn worst(&self, edges: impl Iterator<Item = usize>) -> f32 {
        let [far, bend, length] = &self.found;
        let (mut f, mut b, mut l) = (0.0_f32, 0.0_f32, 0.0_f32);
        for k in edges {
            f = f.max(far[k]);
            b = b.max(bend[k]);
            l = l.max(length[k]);
        }
        // What is smaller than a pixel has no normals of its own to be seen.
        if l > 1.0 { f.max(b) } else { f }
    }

    /// What step `k` adds to segment `i` of the `2^k` of a line.
    fn of_segment(&self, k: u32, i: usize) -> f32 {
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
            false => [0.0; 2],
        };
        Some(own > 1.0 || 0.5 * own + next[0].max(next[1]) > 1.0)
    }

    /// What step `k` adds to cell (`x`, `y`) of the `2^k` by `2^k` of a square.
    fn of_cell(&self, shape: Shape, k: u32, [x, y]: [u32; 2]) -> f32 {
        let n = 1_usize << k;
        let (x, y) = (x as usize, y as usize);
        let (us, vs) = (before(k), before(k) + n * (n + 1));
        let ds = vs + n * (n + 1);
        let (u, v) = (us + y * n + x, vs + y * (n + 1) + x);
        let d = ds + y * n + x;
        if shape == Shape::Triangle && x == y {
            self.worst([u, v + 1, d].into_iter())
        } else {
            self.worst([u, u + n, v, v + 1, d].into_iter())
        }
    }

    /// Whether cell (`x`, `y`) of the `2^k` by `2^k` of a square is too far from the surface.
    pub(super) fn is_far(&self, square: &Square, k: u32, at: [u32; 2]) -> bool {
        let shape = square.shape;
        if k >= self.log {
            // No samples inside: what the cell twice as large leaves. At an irregular vertex, where parameters run unevenly, that is nearly
            // all of it at a high valence.
            let last = (1 << k) - 1;
            let ends = [[0, 0], [last, 0], [last, last], [0, last]];
            let corner = ends.iter().position(|&end| end == at);
            let left = match corner.is_some_and(|c| square.corners[c]) {
                true => 1.0,
                false => LEFT,
            };
            return k > 0 && self.of_cell(shape, k - 1, at.map(|c| c / 2)) * left > 1.0;
        }
        let own = self.of_cell(shape, k, at);
        if own > 1.0 {
            return true;
        }
        if k + 1 == self.log {
            return false;
        }
        let half = shape == Shape::Triangle && at[0] == at[1];
        let children = [[0, 0], [1, 0], [1, 1], [0, 1]];
        let children = children.iter().take(if half { 3 } else { 4 });
        let next = children.map(|c| self.of_cell(shape, k + 1, [0, 1].map(|i| 2 * at[i] + c[i])));
        0.5 * own + next.fold(0.0, f32::max) > 1.0
    }
}

/// Points as the eye sees them, in place.
#[inline(always)]
fn transform(seen: &Seen, n: usize, points: &mut Grid3) {
    for j in 0..=n {
        let row = j * BLOCK_STRIDE..j * BLOCK_STRIDE + n + 1;
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
    fn every_point_but_the_corners_splits_one_edge() {
        for log in 0..=MAX_LOG as usize {
            let n = (1 << log) + 1;
            let mut seen: Vec<u16> = square_splits(log).iter().map(|s| s[0]).collect();
            seen.sort_unstable();
            seen.dedup();
            assert_eq!(seen.len(), n * n - 4);
            assert_eq!(square_splits(log).len(), before(log as u32));
            for [p, a, b] in square_splits(log) {
                assert_eq!(2 * p, a + b);
            }
        }
        assert_eq!(line_splits(2), &[[2, 0, 4], [1, 0, 2], [3, 2, 4]]);
    }
}
