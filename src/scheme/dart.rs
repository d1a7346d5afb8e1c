//! Limit masks of a dart: an interior vertex with one infinitely sharp edge, edge 0 of its ring, for Catmull-Clark and for Loop.
//!
//! The sharp edge's point is its midpoint, everything else is smooth. That breaks the rotational symmetry of the smooth vertex, so no closed
//! formula is known for all valences; the masks are left eigenvectors of the local matrix, computed once per valence. A mirror symmetry
//! about the sharp edge is left: position and first tangent are even, the second tangent is odd and is that of the smooth vertex.

use super::limit::{RingMask, smooth_tangents};
use super::loop_scheme;

/// Largest valence with masks; beyond, refine the ring some times and use the smooth masks.
pub const MAX_VALENCE: u32 = 64;

/// Limit masks of a dart.
#[derive(Clone, Debug, PartialEq)]
pub struct DartMasks {
    /// Limit position, weights sum to 1.
    pub position: RingMask,
    /// Along the sharp edge, and across it to the left.
    pub tangents: [RingMask; 2],
}

pub(crate) type Matrix = Vec<Vec<f64>>;

/// The local matrix on vectors that are symmetric about edge 0: the vertex, edges 0 to n/2, faces 0 to (n − 1)/2.
fn even_matrix(n: usize) -> Matrix {
    let edges = n / 2 + 1;
    let size = 1 + edges + n.div_ceil(2);
    let edge = |i: usize| {
        let i = i % n;
        1 + i.min(n - i)
    };
    let face = |i: usize| {
        let i = i % n;
        1 + edges + i.min(n - 1 - i)
    };
    let new_face = |row: &mut [f64], i: usize, weight: f64| {
        for at in [0, edge(i), face(i), edge(i + 1)] {
            row[at] += 0.25 * weight;
        }
    };
    let mut m = vec![vec![0.0; size]; size];
    let square = (n * n) as f64;
    m[0][0] = (n as f64 - 2.0) / n as f64;
    for i in 0..n {
        m[0][edge(i)] += 1.0 / square;
        new_face(&mut m[0], i, 1.0 / square);
    }
    m[1][0] = 0.5;
    m[1][1] = 0.5;
    for i in 1..edges {
        let row = &mut m[edge(i)];
        row[0] += 0.25;
        row[edge(i)] += 0.25;
        new_face(row, i, 0.25);
        new_face(row, i - 1, 0.25);
    }
    for i in 0..n.div_ceil(2) {
        new_face(&mut m[face(i)], i, 1.0);
    }
    m
}

/// The same for Loop: the vertex, edges 0 to n/2.
fn even_loop_matrix(n: usize) -> Matrix {
    let edges = n / 2 + 1;
    let edge = |i: usize| {
        let i = i % n;
        1 + i.min(n - i)
    };
    let mut m = vec![vec![0.0; 1 + edges]; 1 + edges];
    let near = loop_scheme::neighbour(n as u32);
    m[0][0] = 1.0 - n as f64 * near;
    for i in 0..n {
        m[0][edge(i)] += near;
    }
    m[1][0] = 0.5;
    m[1][1] = 0.5;
    for i in 1..edges {
        let row = &mut m[edge(i)];
        row[0] += loop_scheme::EDGE_END;
        row[edge(i)] += loop_scheme::EDGE_END;
        row[edge(i + 1)] += loop_scheme::EDGE_OPPOSITE;
        row[edge(i + n - 1)] += loop_scheme::EDGE_OPPOSITE;
    }
    m
}

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    a.iter()
        .map(|row| {
            let mut out = vec![0.0; row.len()];
            for (w, line) in row.iter().zip(b) {
                for (o, x) in out.iter_mut().zip(line) {
                    *o += w * x;
                }
            }
            out
        })
        .collect()
}

/// The left eigenvector of the eigenvalue of largest magnitude, by repeated squaring.
pub(crate) fn dominant_left(mut m: Matrix) -> Vec<f64> {
    for _ in 0..28 {
        m = times(&m, &m);
        let largest = m.iter().flatten().fold(0.0_f64, |a, x| a.max(x.abs()));
        if largest > 0.0 {
            m.iter_mut().flatten().for_each(|x| *x /= largest);
        }
    }
    // All rows are multiples of it now; take the longest.
    let length = |r: &Vec<f64>| r.iter().map(|x| x * x).sum::<f64>();
    m.into_iter()
        .reduce(|a, b| if length(&b) > length(&a) { b } else { a })
        .unwrap_or_default()
}

/// Spreads weights of symmetric pairs evenly over the ring.
fn unfold(n: usize, even: &[f64]) -> RingMask {
    let edges = n / 2 + 1;
    let share = |alone: bool, weight: f64| if alone { weight } else { 0.5 * weight };
    RingMask {
        vertex: even[0],
        edges: (0..n)
            .map(|i| {
                let j = i.min(n - i);
                share(j == 0 || 2 * j == n, even[1 + j])
            })
            .collect(),
        // Loop has none.
        faces: (0..n)
            .filter_map(|i| {
                let j = i.min(n - 1 - i);
                Some(share(2 * j == n - 1, *even.get(1 + edges + j)?))
            })
            .collect(),
    }
}

impl DartMasks {
    /// Masks of Catmull-Clark for valence `n`, from 2 to [`MAX_VALENCE`].
    #[must_use]
    pub fn new(n: u32) -> Self {
        let [_, across] = smooth_tangents(n);
        Self::from_even(n as usize, even_matrix(n as usize), across)
    }

    /// Masks of Loop for valence `n`, from 2 to [`MAX_VALENCE`].
    #[must_use]
    pub fn of_loop(n: u32) -> Self {
        let [_, across] = loop_scheme::smooth_tangents(n);
        Self::from_even(n as usize, even_loop_matrix(n as usize), across)
    }

    /// Masks from the local matrix of even vectors; the odd tangent is given.
    fn from_even(size: usize, mut m: Matrix, across: RingMask) -> Self {
        let mut position = dominant_left(m.clone());
        let sum: f64 = position.iter().sum();
        position.iter_mut().for_each(|x| *x /= sum);
        // Take the eigenvalue 1 away (its right eigenvector is all ones); the largest that is left belongs to the tangent.
        for row in &mut m {
            for (x, p) in row.iter_mut().zip(&position) {
                *x -= p;
            }
        }
        let mut tangent = dominant_left(m);
        let scale = if tangent[1] == 0.0 {
            1.0
        } else {
            8.0 / tangent[1]
        };
        tangent.iter_mut().for_each(|x| *x *= scale);
        Self {
            position: unfold(size, &position),
            tangents: [unfold(size, &tangent), across],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(got: &[f64], want: &[f64]) {
        for (g, w) in got.iter().zip(want) {
            assert!((g - w).abs() < 1e-13, "{got:?} instead of {want:?}");
        }
    }

    #[test]
    fn valence_four_as_fractions() {
        let d = DartMasks::new(4);
        assert!((d.position.vertex - 94.0 / 201.0).abs() < 1e-14);
        close(
            &d.position.edges,
            &[35.0 / 268.0, 20.0 / 201.0, 15.0 / 134.0, 20.0 / 201.0],
        );
        close(
            &d.position.faces,
            &[29.0 / 1608.0, 11.0 / 402.0, 11.0 / 402.0, 29.0 / 1608.0],
        );
        let t = &d.tangents[0];
        let s = 28.0 / t.edges[0];
        let scaled: Vec<f64> = t.edges.iter().chain(&t.faces).map(|x| x * s).collect();
        assert!((t.vertex * s - 16.0).abs() < 1e-12);
        close(&scaled, &[28.0, -8.0, -16.0, -8.0, -1.0, -5.0, -5.0, -1.0]);
    }

    #[test]
    fn valence_three_as_fractions() {
        let d = DartMasks::new(3);
        assert!((d.position.vertex - 81.0 / 200.0).abs() < 1e-14);
        close(&d.position.edges, &[0.2, 0.15, 0.15]);
        close(&d.position.faces, &[11.0 / 400.0, 1.0 / 25.0, 11.0 / 400.0]);
    }

    #[test]
    fn loop_of_valence_six_as_fractions() {
        let d = DartMasks::of_loop(6);
        assert!((d.position.vertex - 110.0 / 213.0).abs() < 1e-14);
        let (near, far) = (29.0 / 426.0, 35.0 / 426.0);
        close(
            &d.position.edges,
            &[7.0 / 71.0, near, far, 6.0 / 71.0, far, near],
        );
        let t = &d.tangents[0];
        close(&t.edges, &[8.0, -1.0, -3.0, -4.0, -3.0, -1.0]);
        assert!((t.vertex - 4.0).abs() < 1e-12);
        assert!(d.position.faces.is_empty() && t.faces.is_empty());
    }
}
