//! Limit masks of Catmull-Clark: where a vertex of a quad mesh ends up, and two tangents there. Weights in `f64`.
//!
//! All are left eigenvectors of the local subdivision matrix, so they are the limit of the refinement rules themselves: also at interior
//! vertices with two faces, and for the second tangent of boundary sides with any number of faces. The analysis is that of Halstead, Kass,
//! DeRose, *Efficient, fair interpolation using Catmull-Clark surfaces*, 1993. Angles go through `libm`, for the same bits everywhere.
//!
//! A ring is numbered counter-clockwise: edge `i`, then face `i` between edges `i` and `i + 1`, whose point is the opposite corner.

use std::f64::consts::PI;

/// Weights over the ring of a vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RingMask {
    /// Weight of the vertex itself.
    pub vertex: f64,
    /// Weights of the ends of the ring's edges.
    pub edges: Vec<f64>,
    /// Weights of the opposite corners of the ring's faces.
    pub faces: Vec<f64>,
}

/// Limit position of a smooth vertex of valence `n`: weights of the vertex, of each edge end, of each opposite corner.
#[must_use]
#[inline]
pub fn position(n: u32) -> [f64; 3] {
    let n = f64::from(n);
    [n / (n + 5.0), 4.0 / (n * (n + 5.0)), 1.0 / (n * (n + 5.0))]
}

/// Weight of the vertex in its limit position on a crease or boundary.
pub const CREASE_VERTEX: f64 = 2.0 / 3.0;
/// Weight of each of the two neighbours along a crease or boundary.
pub const CREASE_END: f64 = 1.0 / 6.0;

/// Eigenvalue of the tangents around an angle of `theta` per face.
#[must_use]
pub fn eigenvalue(theta: f64) -> f64 {
    let c = libm::cos(theta);
    5.0 / 16.0 + (c + libm::cos(0.5 * theta) * (2.0 * (9.0 + c)).sqrt()) / 16.0
}

/// Two tangents of a smooth vertex of valence `n`; the first points along edge 0, the second a right angle on.
///
/// With `n` 2 no tangent plane exists in general; the second tangent is then the difference of the opposite corners.
#[must_use]
pub fn smooth_tangents(n: u32) -> [RingMask; 2] {
    if n == 2 {
        let along = RingMask {
            vertex: 0.0,
            edges: vec![4.0, -4.0],
            faces: vec![0.0; 2],
        };
        let across = RingMask {
            vertex: 0.0,
            edges: vec![0.0; 2],
            faces: vec![1.0, -1.0],
        };
        return [along, across];
    }
    let theta = 2.0 * PI / f64::from(n);
    let c = 1.0 / (4.0 * eigenvalue(theta) - 1.0);
    [libm::cos, libm::sin].map(|wave: fn(f64) -> f64| {
        let at = |i: u32| wave(f64::from(i % n) * theta);
        RingMask {
            vertex: 0.0,
            edges: (0..n).map(|i| 4.0 * at(i)).collect(),
            faces: (0..n).map(|i| c * (at(i) + at(i + 1))).collect(),
        }
    })
}

/// The tangent across a crease or boundary, into a side of `k` faces between sharp edges 0 and `k`; all `k + 1` edges are given.
///
/// The other tangent is the difference of the ends of edges 0 and `k`. With one face the eigenvalue is defective: the normal is the limit,
/// but refined faces approach it slowly. From four faces on, the rules have no single tangent plane and this is a convention.
#[must_use]
pub fn side_tangent(k: u32) -> RingMask {
    if k <= 1 {
        return RingMask {
            vertex: -2.0,
            edges: vec![1.0; 2],
            faces: vec![0.0],
        };
    }
    let theta = PI / f64::from(k);
    let lambda = eigenvalue(theta);
    let c = 1.0 / (4.0 * lambda - 1.0);
    let sine = |i: u32| {
        if i == 0 || i == k {
            0.0
        } else {
            libm::sin(f64::from(i) * theta)
        }
    };
    let mut edges: Vec<f64> = (0..=k).map(|i| 4.0 * sine(i)).collect();
    let faces: Vec<f64> = (0..k).map(|i| c * (sine(i) + sine(i + 1))).collect();
    // The columns of the two ends and of the vertex in "mask times matrix is lambda times mask".
    let end = -(0.25 * faces[0] + edges[1] / 16.0);
    let middle = -(0.375 * edges.iter().sum::<f64>() + 0.25 * faces.iter().sum::<f64>());
    let (a, b, d) = (0.5 - lambda, 0.125, 0.75 - lambda);
    let det = a * d - b;
    let ends = (end * d - b * middle) / det;
    edges[0] = ends;
    edges[k as usize] = ends;
    RingMask {
        vertex: (a * middle - end) / det,
        edges,
        faces,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one_and_zero() {
        for n in 2..=64 {
            let [x, e, f] = position(n);
            assert!((x + f64::from(n) * (e + f) - 1.0).abs() < 1e-14);
            for t in smooth_tangents(n).iter().chain([&side_tangent(n - 1)]) {
                let sum: f64 = t.vertex + t.edges.iter().sum::<f64>() + t.faces.iter().sum::<f64>();
                assert!(sum.abs() < 1e-12, "valence {n}: {sum}");
            }
        }
    }

    #[test]
    fn known_values() {
        assert_eq!(position(2), [2.0 / 7.0, 2.0 / 7.0, 1.0 / 14.0]);
        let [t, _] = smooth_tangents(4);
        for (got, want) in t
            .edges
            .iter()
            .chain(&t.faces)
            .zip([4.0, 0.0, -4.0, 0.0, 1.0, -1.0, -1.0, 1.0])
        {
            assert!((got - want).abs() < 1e-14);
        }
        // Two faces on the side: (−4, −1, 4, −1, 1, 1)/6 of a regular boundary, up to scale.
        let t = side_tangent(2);
        let scale = t.edges[1] / 4.0;
        assert!((t.vertex / scale + 4.0).abs() < 1e-13);
        assert!((t.edges[0] / scale + 1.0).abs() < 1e-13);
        assert!((t.faces[0] / scale - 1.0).abs() < 1e-13);
    }
}
