//! How far the triangles of a grid cell are from the surface: samples against the interpolation of the cell's corners.

use super::screen::{Excess, Metric};
use crate::records::Grid3;
use crate::tessellate::quadtree::Shape;

/// Samples of a square of a face, `2^log` and one more along each side.
pub(super) struct Samples<'a> {
    pub(super) points: &'a Grid3,
    pub(super) normals: &'a Grid3,
    pub(super) log: u32,
    /// Of a triangle, only what is not above the diagonal counts.
    pub(super) shape: Shape,
    /// Whether each corner of the square is one of the face's.
    pub(super) corners: [bool; 4],
}

/// What a step of the grid below the samples is expected to leave of a distance: a quarter where the surface has second derivatives.
const LEFT: f32 = 0.4 * 0.4;

impl Samples<'_> {
    /// Excess of cell (`x`, `y`) of the `2^depth` by `2^depth` cells that the samples are cut into.
    pub(super) fn excess(&self, metric: &Metric<'_>, depth: u32, x: u32, y: u32) -> Excess {
        if depth + 1 > self.log {
            // No samples inside: what the cell twice as large leaves. At an irregular vertex, where parameters run unevenly, that is nearly
            // all of it at a high valence.
            let last = (1 << depth) - 1;
            let ends = [[0, 0], [last, 0], [last, last], [0, last]];
            let at = ends.iter().position(|&end| end == [x, y]);
            let left = match at.is_some_and(|c| self.corners[c]) {
                true => 1.0,
                false => LEFT,
            };
            return self.excess(metric, depth - 1, x / 2, y / 2) * left;
        }
        let step = 1_usize << (self.log - depth);
        let (i, j) = (x as usize * step, y as usize * step);
        let corners = [(0, 0), (step, 0), (step, step), (0, step)];
        let p = corners.map(|(a, b)| self.points.get(i + a, j + b));
        let n = corners.map(|(a, b)| self.normals.get(i + a, j + b));
        let between = (step / 4).max(1);
        let half = self.shape == Shape::Triangle && x == y;
        let bent = !metric.is_dot(&p)
            || !metric.is_dot(&[p[0], self.points.get(i + step / 2, j + step / 2)]);
        let samples = || {
            let lines = (0..=step).step_by(between);
            lines.flat_map(move |b| {
                let from = if half { b } else { 0 };
                (from..=step).step_by(between).map(move |a| (a, b))
            })
        };
        let depths = samples().map(|(a, b)| metric.depth(self.points.get(i + a, j + b)));
        let nearest = depths.fold(f32::INFINITY, f32::min);
        let mut worst = 0.0_f32;
        for b in (0..=step).step_by(between) {
            for a in (if half { b } else { 0 }..=step).step_by(between) {
                if (a == 0 || a == step) && (b == 0 || b == step) {
                    continue;
                }
                let w = weights(a as f32 / step as f32, b as f32 / step as f32);
                let at = |c: [[f32; 3]; 4]| {
                    [0, 1, 2].map(|k| {
                        (c[0][k] * w[0] + c[1][k] * w[1]) + (c[2][k] * w[2] + c[3][k] * w[3])
                    })
                };
                worst = worst.max(metric.point(self.points.get(i + a, j + b), at(p), nearest));
                if bent {
                    worst = worst.max(metric.normal(self.normals.get(i + a, j + b), at(n)));
                }
            }
            // How much too far is asked only of the last cells with samples inside.
            if worst > 1.0 && step > 2 {
                break;
            }
        }
        worst
    }
}

/// Weights of a cell's corners at (`u`, `v`) in the triangle that holds it; the diagonal runs from corner 0 to corner 2.
fn weights(u: f32, v: f32) -> [f32; 4] {
    if v <= u {
        [1.0 - u, u - v, v, 0.0]
    } else {
        [1.0 - v, 0.0, u, v - u]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_those_of_two_triangles() {
        assert_eq!(weights(0.5, 0.5), [0.5, 0.0, 0.5, 0.0]);
        assert_eq!(weights(0.75, 0.25), [0.25, 0.5, 0.25, 0.0]);
        assert_eq!(weights(0.25, 0.75), [0.25, 0.0, 0.25, 0.5]);
    }
}
