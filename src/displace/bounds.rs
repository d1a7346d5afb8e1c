//! What samples do not show of a displacement.
//!
//! Bunnell (*Adaptive Tessellation of Subdivision Surfaces with Displacement Mapping*, GPU Gems 2, 2005) keeps tables of the largest
//! displacement that each level leaves out. Here the bound is found when it is asked for, for the samples at hand: how much higher or lower
//! than the samples around it anything between them may be. It is in model units and follows the scale, which may change at run time.

use super::{Displacement, Function, HeightMap, Kind, Shape};
use crate::math;
use crate::records::{BLOCK_POINTS, Grid3};

impl Displacement {
    /// Bound of what a grid of `side` by `side` samples of the surface does not show, in model units. `points` are displaced; texture
    /// coordinates are read for maps alone. Of a caller's rule nothing is known, and 0 is said.
    pub(crate) fn hidden(&self, side: usize, points: &Grid3, uvs: &Grid3) -> f32 {
        let side = side.min(BLOCK_POINTS);
        if side < 2 {
            return 0.0;
        }
        match &self.kind {
            Kind::Map(map) => self.scale.abs() * of_map(map, side, uvs),
            Kind::Function(function) => {
                self.scale.abs() * of_function(function, spacing(side, points))
            }
            Kind::Vector { .. } => 0.0,
        }
    }
}

/// Longest distance between neighbours of a grid.
fn spacing(side: usize, points: &Grid3) -> f32 {
    let mut most = 0.0_f32;
    for j in 0..side {
        for i in 0..side {
            let p = points.get(i, j);
            for (a, b) in [(i + 1, j), (i, j + 1)] {
                if a < side && b < side {
                    most = most.max(math::length(math::sub(points.get(a, b), p)));
                }
            }
        }
    }
    most
}

/// A chord of length d misses a curve by its second derivative times d²/8, and by no more than twice the height of its waves.
fn of_function(function: &Function, spacing: f32) -> f32 {
    /// Largest second derivative of an octave of frequency 1: of noise, found by search, and of a cosine.
    const NOISE: f32 = 9.0;
    const WAVE: f32 = 39.5;
    let bend = if function.shape == Shape::Ripples {
        WAVE
    } else {
        NOISE
    };
    let octaves = function.octaves().map(|[frequency, weight]| {
        let d = frequency * spacing;
        (bend * d * d * 0.125).min(2.0) * weight
    });
    octaves.sum()
}

/// The highest rise of texels over the samples at the corners of their cell, or fall below.
fn of_map(map: &HeightMap, side: usize, uvs: &Grid3) -> f32 {
    let [w, h] = map.size().map(|n| n as f32);
    let mut most = 0.0_f32;
    for j in 0..side - 1 {
        for i in 0..side - 1 {
            let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| uvs.get(i + a, j + b));
            let bound = |k: usize, of: fn(f32, f32) -> f32| {
                corners[1..].iter().fold(corners[0][k], |x, c| of(x, c[k]))
            };
            let low = [0, 1].map(|k| bound(k, f32::min));
            let high = [0, 1].map(|k| bound(k, f32::max));
            // Between the middles of texels there is nothing that four samples do not show.
            if (high[0] - low[0]) * w <= 1.0 && (high[1] - low[1]) * h <= 1.0 {
                continue;
            }
            let found = corners.map(|[u, v, _]| map.at(u, v));
            let [lo, hi] = map.range_in(low, high);
            let top = found.iter().fold(f32::NEG_INFINITY, |x, &h| x.max(h));
            let bottom = found.iter().fold(f32::INFINITY, |x, &h| x.min(h));
            most = most.max(hi - top).max(bottom - lo);
        }
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn a_spike_between_samples_is_found_and_a_plain_is_not() {
        let mut texels = vec![0.25; 64 * 64];
        texels[20 * 64 + 21] = 1.0;
        let map = Arc::new(HeightMap::new(64, 64, texels).unwrap());
        let displacement = Displacement::map(map).scaled(-2.0);
        let grid = |from: f32, to: f32| {
            let mut uvs = Grid3::boxed();
            for j in 0..5 {
                for i in 0..5 {
                    let at = |k: usize| from + (to - from) * k as f32 / 4.0;
                    uvs.set(i, j, [at(i), at(j), 0.0]);
                }
            }
            uvs
        };
        let points = Grid3::boxed();
        assert!(displacement.hidden(5, &points, &grid(0.0, 1.0)) >= 1.5 - 1e-4);
        assert_eq!(displacement.hidden(5, &points, &grid(0.0, 0.25)), 0.0);
        // Cells of a texel's size.
        assert_eq!(displacement.hidden(5, &points, &grid(0.3, 0.36)), 0.0);
    }

    #[test]
    fn functions_are_shown_by_dense_samples() {
        let f: Function = "fbm:frequency=4".parse().unwrap();
        let steps = [1.0, 0.1, 0.01, 0.001].map(|d| of_function(&f, d));
        assert!(
            steps.windows(2).all(|w| w[1] < w[0]) && steps[3] < 0.005,
            "{steps:?}"
        );
        // The bound of second derivatives, by differences.
        let f: Function = "perlin".parse().unwrap();
        let mut most = 0.0_f32;
        for i in 0..20_000 {
            let p = [0.618, 0.414, 0.732].map(|k: f32| (k * i as f32).fract() * 16.0);
            let d = 1.0 / 64.0;
            let at = |t: f32| f.at([p[0] + t, p[1], p[2]]);
            most = most.max((at(d) - 2.0 * at(0.0) + at(-d)).abs() / (d * d));
        }
        assert!(most < 9.0, "{most}");
    }
}
