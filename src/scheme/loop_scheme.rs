//! Masks of Loop's scheme on triangles, for refinement and for the limit; weights in `f64`.
//!
//! C. Loop, *Smooth subdivision surfaces based on triangles*, 1987. The limit masks are left eigenvectors of the local subdivision matrix,
//! for interior vertices in closed form; the second tangent of a boundary or crease side solves the two equations that the usual formula
//! leaves out, so it holds for any number of faces. Curves along creases are those of Catmull-Clark: both are cubic B-splines.
//!
//! A ring is numbered counter-clockwise from edge 0; masks have no weights of faces.

use super::limit::RingMask;
use std::f64::consts::PI;

/// Weight of each end in a smooth edge point.
pub const EDGE_END: f64 = 0.375;
/// Weight of each of the two vertices opposite a smooth edge.
pub const EDGE_OPPOSITE: f64 = 0.125;

/// Weight of each neighbour in a smooth vertex point of valence `n`; the vertex has `1 - n` times that.
#[must_use]
#[inline]
pub fn neighbour(n: u32) -> f64 {
    match n {
        // The commonest, without rounding.
        6 => 0.0625,
        3 => 0.1875,
        _ => {
            let valence = f64::from(n);
            let c = 0.375 + 0.25 * libm::cos(2.0 * PI / valence);
            (0.625 - c * c) / valence
        }
    }
}

/// Limit position of a smooth vertex of valence `n`: weights of the vertex and of each neighbour.
#[must_use]
pub fn position(n: u32) -> [f64; 2] {
    let valence = f64::from(n);
    let w = 1.0 / (valence + 0.375 / neighbour(n));
    [1.0 - valence * w, w]
}

/// Eigenvalue of the tangents around an angle of `theta` per face.
#[must_use]
pub fn eigenvalue(theta: f64) -> f64 {
    0.375 + 0.25 * libm::cos(theta)
}

/// Two tangents of a smooth vertex of valence `n`; the first points along edge 0, the second a right angle on. With `n` 2 the second is 0.
#[must_use]
pub fn smooth_tangents(n: u32) -> [RingMask; 2] {
    if n == 2 {
        return [vec![1.0, -1.0], vec![0.0; 2]].map(|edges| RingMask {
            edges,
            ..RingMask::default()
        });
    }
    let theta = 2.0 * PI / f64::from(n);
    [libm::cos, libm::sin].map(|wave: fn(f64) -> f64| RingMask {
        vertex: 0.0,
        edges: (0..n).map(|i| wave(f64::from(i) * theta)).collect(),
        faces: Vec::new(),
    })
}

/// The tangent across a crease or boundary, into a side of `k` faces between sharp edges 0 and `k`; all `k + 1` edges are given.
///
/// The other tangent is the difference of the ends of edges 0 and `k`. From six faces on, the rules have no single tangent plane and this
/// is a convention.
#[must_use]
pub fn side_tangent(k: u32) -> RingMask {
    if k <= 1 {
        return RingMask {
            vertex: -2.0,
            edges: vec![1.0; 2],
            faces: Vec::new(),
        };
    }
    let theta = PI / f64::from(k);
    let lambda = eigenvalue(theta);
    let mut edges: Vec<f64> = (0..=k)
        .map(|i| match i {
            0 => 0.0,
            i if i == k => 0.0,
            i => libm::sin(f64::from(i) * theta),
        })
        .collect();
    // The columns of the two ends and of the vertex in "mask times matrix is lambda times mask".
    let end = -0.125 * edges[1];
    let middle = -0.375 * edges.iter().sum::<f64>();
    let (a, b, d) = (0.5 - lambda, 0.125, 0.75 - lambda);
    let det = a * d - b;
    let ends = (end * d - b * middle) / det;
    edges[0] = ends;
    edges[k as usize] = ends;
    RingMask {
        vertex: (a * middle - end) / det,
        edges,
        faces: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One step on the ring of an interior vertex: row by row, the vertex first.
    fn closed_matrix(n: usize) -> Vec<Vec<f64>> {
        let mut m = vec![vec![0.0; n + 1]; n + 1];
        let b = neighbour(n as u32);
        m[0][0] = 1.0 - n as f64 * b;
        for i in 0..n {
            m[0][1 + i] += b;
            m[1 + i][0] += EDGE_END;
            m[1 + i][1 + i] += EDGE_END;
            m[1 + i][1 + (i + 1) % n] += EDGE_OPPOSITE;
            m[1 + i][1 + (i + n - 1) % n] += EDGE_OPPOSITE;
        }
        m
    }

    /// The same on a side of `k` faces.
    fn open_matrix(k: usize) -> Vec<Vec<f64>> {
        let mut m = vec![vec![0.0; k + 2]; k + 2];
        m[0][0] = 0.75;
        m[0][1] = 0.125;
        m[0][1 + k] = 0.125;
        for i in 0..=k {
            if i == 0 || i == k {
                m[1 + i][0] = 0.5;
                m[1 + i][1 + i] = 0.5;
            } else {
                m[1 + i][0] = EDGE_END;
                m[1 + i][1 + i] = EDGE_END;
                m[1 + i][i] = EDGE_OPPOSITE;
                m[1 + i][2 + i] = EDGE_OPPOSITE;
            }
        }
        m
    }

    fn assert_eigenvector(mask: &RingMask, m: &[Vec<f64>], lambda: f64, what: &str) {
        let row: Vec<f64> = std::iter::once(mask.vertex)
            .chain(mask.edges.iter().copied())
            .collect();
        for c in 0..row.len() {
            let got: f64 = (0..row.len()).map(|r| row[r] * m[r][c]).sum();
            assert!(
                (got - lambda * row[c]).abs() < 1e-13,
                "{what}, column {c}: {got} instead of {}",
                lambda * row[c]
            );
        }
    }

    #[test]
    fn known_weights() {
        assert!((neighbour(4) - 31.0 / 256.0).abs() < 1e-16);
        for n in [3_u32, 6] {
            let c = 0.375 + 0.25 * (2.0 * PI / f64::from(n)).cos();
            assert!((neighbour(n) - (0.625 - c * c) / f64::from(n)).abs() < 1e-16);
        }
        let [x, e] = position(6);
        assert!((x - 0.5).abs() < 1e-16 && (e - 1.0 / 12.0).abs() < 1e-16);
        assert_eq!(2.0 * (EDGE_END + EDGE_OPPOSITE), 1.0);
    }

    #[test]
    fn interior_masks_are_left_eigenvectors() {
        for n in 2..=64_u32 {
            let m = closed_matrix(n as usize);
            for row in &m {
                assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            }
            let [x, e] = position(n);
            let mask = RingMask {
                vertex: x,
                edges: vec![e; n as usize],
                faces: Vec::new(),
            };
            assert_eigenvector(&mask, &m, 1.0, &format!("position of valence {n}"));
            let lambda = eigenvalue(2.0 * PI / f64::from(n));
            for t in smooth_tangents(n) {
                assert_eigenvector(&t, &m, lambda, &format!("tangent of valence {n}"));
                assert!(t.edges.iter().sum::<f64>().abs() < 1e-13);
            }
        }
    }

    #[test]
    fn side_tangents_are_left_eigenvectors() {
        for k in 1..=64_u32 {
            let t = side_tangent(k);
            let lambda = if k == 1 {
                0.25
            } else {
                eigenvalue(PI / f64::from(k))
            };
            assert_eigenvector(&t, &open_matrix(k as usize), lambda, &format!("{k} faces"));
            assert!((t.vertex + t.edges.iter().sum::<f64>()).abs() < 1e-12);
        }
        // Two faces: the far end of the inner edge less the vertex; three: the usual mask.
        let t = side_tangent(2);
        assert!((t.vertex + t.edges[1]).abs() < 1e-15 && t.edges[0].abs() < 1e-15);
        let t = side_tangent(3);
        let scale = 3.0_f64.sqrt() / t.edges[1];
        assert!((t.edges[0] * scale + 3.0_f64.sqrt() / 2.0).abs() < 1e-13);
        assert!((t.vertex * scale + 3.0_f64.sqrt()).abs() < 1e-13);
    }
}
