//! Masks of the Modified Butterfly scheme: interpolating, on triangles; weights in `f64`.
//!
//! Zorin, Schröder, Sweldens, *Interpolating subdivision for meshes with arbitrary topology*, 1996. Vertices stay where they are, so a
//! vertex is its own limit. Of the ten-point stencils the one with tension 0 is used, which has eight points.
//!
//! A ring is numbered counter-clockwise from edge 0. The two rings of a vertex are listed as: ends of its edges, then the vertices beyond
//! the sides opposite it (side `i` joins ends `i` and `i + 1`), then those straight beyond the ends.

use std::f64::consts::PI;

/// Weight of each end of an edge between regular vertices.
pub const EDGE_END: f64 = 0.5;
/// Weight of each of the two vertices opposite the edge.
pub const EDGE_OPPOSITE: f64 = 0.125;
/// Weight of each of the four vertices beyond the other sides of the two triangles.
pub const EDGE_WING: f64 = -0.0625;

/// Weight of the two inner points of the four along a boundary or crease (also in Kobbelt's scheme).
pub const CURVE_NEAR: f64 = 0.5625;
/// Weight of the two outer points.
pub const CURVE_FAR: f64 = -0.0625;

/// Weight of the extraordinary vertex itself in the edge points around it.
pub const EXTRAORDINARY_VERTEX: f64 = 0.75;

/// Weights of the ends of the edges around an interior vertex of valence `k` other than 6, at least 3, in the point of edge 0.
#[must_use]
pub fn extraordinary(k: u32) -> Vec<f64> {
    match k {
        3 => vec![5.0 / 12.0, -1.0 / 12.0, -1.0 / 12.0],
        4 => vec![0.375, 0.0, -0.125, 0.0],
        _ => {
            let n = f64::from(k);
            (0..k)
                .map(|j| {
                    let angle = 2.0 * PI * f64::from(j) / n;
                    (0.25 + libm::cos(angle) + 0.5 * libm::cos(2.0 * angle)) / n
                })
                .collect()
        }
    }
}

/// Two tangents of an interior vertex of valence `k`, at least 3, as weights of its two rings; the first points along edge 0, the second
/// a right angle on. They hold where all neighbours are regular.
#[must_use]
pub fn tangents(k: u32) -> [Vec<f64>; 2] {
    let theta = 2.0 * PI / f64::from(k);
    // Other valences know one ring only: edge points there depend on nothing else.
    let [near, side, beyond] = match k {
        6 => [16.0, -8.0 / 3.0_f64.sqrt(), 1.0],
        _ => [1.0, 0.0, 0.0],
    };
    [libm::cos, libm::sin].map(|wave: fn(f64) -> f64| {
        let at = |weight: f64, shift: f64| {
            (0..k).map(move |j| match weight {
                0.0 => 0.0,
                w => w * wave((f64::from(j) + shift) * theta),
            })
        };
        at(near, 0.0)
            .chain(at(side, 0.5))
            .chain(at(beyond, 0.0))
            .collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one() {
        assert_eq!(2.0 * (EDGE_END + EDGE_OPPOSITE) + 4.0 * EDGE_WING, 1.0);
        assert_eq!(2.0 * (CURVE_NEAR + CURVE_FAR), 1.0);
        for k in (3..=64).filter(|&k| k != 6) {
            let sum = EXTRAORDINARY_VERTEX + extraordinary(k).iter().sum::<f64>();
            assert!((sum - 1.0).abs() < 1e-14, "valence {k}: {sum}");
        }
    }

    #[test]
    fn tangents_are_left_eigenvectors_of_one_half() {
        for k in (3..=64_u32).filter(|&k| k != 6) {
            let s = extraordinary(k);
            for t in tangents(k) {
                assert!(t.iter().sum::<f64>().abs() < 1e-12);
                // New end i gets s[j - i] of old end j.
                for j in 0..k as usize {
                    let n = k as usize;
                    let got: f64 = (0..n).map(|i| t[i] * s[(j + n - i) % n]).sum();
                    assert!((got - 0.5 * t[j]).abs() < 1e-14, "valence {k}");
                }
                assert!(t[k as usize..].iter().all(|&w| w == 0.0));
            }
        }
    }
}
