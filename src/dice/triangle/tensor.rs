//! Nets of twelve control points, their Bernstein form, and the sums along rows and lanes that dice it.

use super::super::point::P4;
use super::super::regular::Line;
use super::basis::Expansion;

/// Twelve control points, in the order of [`OFFSETS`](super::basis::OFFSETS).
pub(super) type Net12 = [P4; 12];

/// The net seen from corner 1: entry `k` of the turned net is entry `TURN[k]`.
pub(super) const TURN: [usize; 12] = [6, 9, 11, 2, 5, 8, 10, 1, 4, 7, 0, 3];

/// The net with corner 1 as its corner 0.
pub(super) fn turn<P: Copy>(net: &[P; 12]) -> [P; 12] {
    TURN.map(|k| net[k])
}

/// 25 points in Bernstein form over the square of which the triangle is one half.
pub(super) type Tensor = [[P4; 5]; 5];

/// Row `r` of the Bernstein form. Loops, here and below, where closures would not be inlined into the kernels and so compiled without
/// their instructions.
#[inline(always)]
pub(super) fn expand_row(net: &Net12, weights: &Expansion, r: usize) -> [P4; 5] {
    let mut out = [P4::ZERO; 5];
    for c in 0..5 {
        let w = &weights[5 * r + c];
        let low = (net[0] * w[0] + net[1] * w[1]) + (net[2] * w[2] + net[3] * w[3]);
        let mid = (net[4] * w[4] + net[5] * w[5]) + (net[6] * w[6] + net[7] * w[7]);
        let top = (net[8] * w[8] + net[9] * w[9]) + (net[10] * w[10] + net[11] * w[11]);
        out[c] = ((low + top) + mid) * (1.0 / 24.0);
    }
    out
}

#[inline(always)]
pub(super) fn expand(net: &Net12, weights: &Expansion) -> Tensor {
    let mut out = [[P4::ZERO; 5]; 5];
    for r in 0..5 {
        out[r] = expand_row(net, weights, r);
    }
    out
}

/// Cubic coefficients of what is a cubic given as a quartic.
#[inline(always)]
pub(super) fn reduced(q: [P4; 5]) -> [P4; 4] {
    let third = 1.0 / 3.0;
    [
        q[0],
        (q[1] * 4.0 - q[0]) * third,
        (q[3] * 4.0 - q[4]) * third,
        q[4],
    ]
}

/// Differences of neighbours: the derivative, up to the degree.
#[inline(always)]
pub(super) fn differences(q: &[P4; 5]) -> [P4; 4] {
    [q[1] - q[0], q[2] - q[1], q[3] - q[2], q[4] - q[3]]
}

/// From row `a` to row `b`, as cubics.
#[inline(always)]
pub(super) fn step_across(a: &[P4; 5], b: &[P4; 5]) -> [P4; 4] {
    reduced([
        b[0] - a[0],
        b[1] - a[1],
        b[2] - a[2],
        b[3] - a[3],
        b[4] - a[4],
    ])
}

/// Five rows blended by quartic weights.
#[inline(always)]
pub(super) fn blend5<const N: usize>(w: &[Vec<f32>; 5], at: usize, rows: &[[P4; N]; 5]) -> [P4; N] {
    let w = [w[0][at], w[1][at], w[2][at], w[3][at], w[4][at]];
    let mut out = [P4::ZERO; N];
    for c in 0..N {
        let ends = rows[0][c] * w[0] + rows[4][c] * w[4];
        let inner = rows[1][c] * w[1] + rows[3][c] * w[3];
        out[c] = (ends + inner) + rows[2][c] * w[2];
    }
    out
}

/// Four rows blended by cubic weights.
#[inline(always)]
pub(super) fn blend4(w: &[Vec<f32>; 4], at: usize, rows: &[[P4; 4]; 4]) -> [P4; 4] {
    let w = [w[0][at], w[1][at], w[2][at], w[3][at]];
    let mut out = [P4::ZERO; 4];
    for c in 0..4 {
        let ends = rows[0][c] * w[0] + rows[3][c] * w[3];
        out[c] = ends + (rows[1][c] * w[1] + rows[2][c] * w[2]);
    }
    out
}

/// One component of the points that the weights from `at` on make of `q`; see [`weigh3`].
#[inline(always)]
fn weigh5_one(w: &[Vec<f32>; 5], at: usize, n: usize, q: &[P4; 5], c: usize, out: &mut Line) {
    let (w0, w1, w2) = (&w[0][at..at + n], &w[1][at..at + n], &w[2][at..at + n]);
    let (w3, w4) = (&w[3][at..at + n], &w[4][at..at + n]);
    let (q0, q1, q2, q3, q4) = (q[0].0[c], q[1].0[c], q[2].0[c], q[3].0[c], q[4].0[c]);
    let out = &mut out[..n];
    for i in 0..n {
        out[i] = ((w0[i] * q0 + w4[i] * q4) + (w1[i] * q1 + w3[i] * q3)) + w2[i] * q2;
    }
}

/// A quartic along a line.
#[inline(always)]
pub(super) fn weigh5(w: &[Vec<f32>; 5], at: usize, n: usize, q: &[P4; 5], out: &mut [Line; 3]) {
    let [x, y, z] = out;
    weigh5_one(w, at, n, q, 0, x);
    weigh5_one(w, at, n, q, 1, y);
    weigh5_one(w, at, n, q, 2, z);
}

/// Bézier points over `[a, b]` of a quartic over `[0, 1]`.
pub(super) fn restricted(q: [P4; 5], [a, b]: [f32; 2]) -> [P4; 5] {
    std::array::from_fn(|i| {
        let mut row = q;
        for step in 0..4 {
            let x = if step < i { b } else { a };
            for k in 0..4 - step {
                row[k] = row[k] + (row[k + 1] - row[k]) * x;
            }
        }
        row[0]
    })
}

/// A normal for points where the tangents are parallel: that of the control triangle.
pub(super) fn fallback(net: &Net12) -> [f32; 3] {
    let n = (net[5] - net[4]).cross(net[8] - net[4]);
    n.unit().map_or([0.0, 0.0, 1.0], P4::xyz)
}
