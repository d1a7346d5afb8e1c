//! The tensor kernel: a regular patch is a bicubic B-spline, diced row by row with lanes along u.
//!
//! A row first blends the four rows of the net into four points, then every lane blends those four. Sums run as
//! `(w0 p0 + w3 p3) + (w1 p1 + w2 p2)` everywhere.

use super::basis::{Basis, Target};
use super::point::P4;
use crate::records::{BLOCK_STRIDE, Grid3};
use std::hint::select_unpredictable;

/// Points in one vector of the kernels.
pub(crate) const LANES: usize = 16;

/// A bicubic B-spline over a square of a face's grid.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    /// Control points, row by row; `net[1][1]` belongs to the corner at the origin.
    pub(crate) net: [[P4; 4]; 4],
    /// Grid column and row of the origin.
    pub(crate) origin: [u32; 2],
    /// Grid segments along each side; 0 for the origin alone.
    pub(crate) size: u32,
    /// Refinement steps that its own net has still to go.
    pub(crate) level: u32,
}

#[inline(always)]
fn blend(w: [f32; 4], p: [P4; 4]) -> P4 {
    (p[0] * w[0] + p[3] * w[3]) + (p[1] * w[1] + p[2] * w[2])
}

/// Points in a line of the kernels: a row of a block, rounded up to whole vectors.
pub(crate) const LINE: usize = BLOCK_STRIDE;

/// One component along a line.
pub(crate) type Line = [f32; LINE];

/// Component `c` of the points that the weights from `at` on make of `q`; `n` is a multiple of [`LANES`] at most [`LINE`].
///
/// The trip count is not a constant on purpose: loops of a small constant length are unrolled before they could be vectorised.
#[inline(always)]
pub(crate) fn weigh(w: &[Vec<f32>; 4], at: usize, n: usize, q: &[P4; 4], c: usize, out: &mut Line) {
    let (w0, w1, w2, w3) = (
        &w[0][at..at + n],
        &w[1][at..at + n],
        &w[2][at..at + n],
        &w[3][at..at + n],
    );
    let (q0, q1, q2, q3) = (q[0].0[c], q[1].0[c], q[2].0[c], q[3].0[c]);
    let out = &mut out[..n];
    for i in 0..n {
        out[i] = (w0[i] * q0 + w3[i] * q3) + (w1[i] * q1 + w2[i] * q2);
    }
}

/// All three components.
#[inline(always)]
pub(crate) fn weigh3(w: &[Vec<f32>; 4], at: usize, n: usize, q: &[P4; 4], out: &mut [Line; 3]) {
    let [x, y, z] = out;
    weigh(w, at, n, q, 0, x);
    weigh(w, at, n, q, 1, y);
    weigh(w, at, n, q, 2, z);
}

/// The four columns of a net, each blended by `w`.
#[inline(always)]
fn blend_rows(w: [f32; 4], net: &[[P4; 4]; 4]) -> [P4; 4] {
    [
        blend(w, [net[0][0], net[1][0], net[2][0], net[3][0]]),
        blend(w, [net[0][1], net[1][1], net[2][1], net[3][1]]),
        blend(w, [net[0][2], net[1][2], net[2][2], net[3][2]]),
        blend(w, [net[0][3], net[1][3], net[2][3], net[3][3]]),
    ]
}

/// The four weights at one place.
#[inline(always)]
fn weights(w: &[Vec<f32>; 4], at: usize) -> [f32; 4] {
    [w[0][at], w[1][at], w[2][at], w[3][at]]
}

/// Grid range of a block that a piece covers, in block and piece coordinates.
struct Overlap {
    block: usize,
    piece: usize,
    count: usize,
}

/// The grid points `low` to `high` of a piece that lie in the block that begins at `start`.
fn overlap(origin: u32, size: u32, start: u32, low: u32, high: u32) -> Option<Overlap> {
    let lo = origin.max(low);
    let hi = (origin + size).min(high);
    (lo <= hi).then(|| Overlap {
        block: (lo - start) as usize,
        piece: (lo - origin) as usize,
        count: (hi - lo + 1) as usize,
    })
}

/// The block that pieces are diced into, in points of a grid that has every `2^shift`-th point of the pieces' own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlockRange {
    /// Levels that the grid is coarser than the pieces'.
    pub(crate) shift: u32,
    /// Grid point at which the block begins.
    pub(crate) start: [u32; 2],
    /// First grid point wanted along u and v.
    pub(crate) low: [u32; 2],
    /// Last grid point wanted.
    pub(crate) high: [u32; 2],
}

/// Dices the parts of all pieces inside a block, the last ones first.
///
/// Pieces follow each other from the widest to those next to irregular corners, so where two meet the wider one is seen. Which that is does
/// not depend on how many follow: the points of a level are among those of the next, bit for bit.
#[inline(always)]
pub(crate) fn dice_pieces(
    pieces: &[Piece],
    target: Target,
    range: BlockRange,
    points: &mut Grid3,
    mut normals: Option<&mut Grid3>,
) {
    for piece in pieces.iter().rev() {
        dice_piece(piece, target, range, points, normals.as_deref_mut());
    }
}

/// Dices the part of `piece` inside the block that starts at grid point `start` and has `segments` segments along each side.
#[inline(always)]
fn dice_piece(
    piece: &Piece,
    target: Target,
    range: BlockRange,
    points: &mut Grid3,
    normals: Option<&mut Grid3>,
) {
    let size = piece.size >> range.shift;
    let between = (1 << range.shift) - 1;
    // The corners of a piece smaller than a cell of the grid belong to wider ones too.
    let skipped = match piece.size {
        0 => (piece.origin[0] | piece.origin[1]) & between != 0,
        _ => size == 0,
    };
    let along = |k: usize| {
        let origin = piece.origin[k] >> range.shift;
        overlap(origin, size, range.start[k], range.low[k], range.high[k])
    };
    let (false, Some(cols), Some(rows)) = (skipped, along(0), along(1)) else {
        return;
    };
    let basis = Basis::get(target, piece.level.saturating_sub(range.shift));
    let n = cols.count.next_multiple_of(LANES);
    let mut line = [[0.0; LINE]; 3];
    for j in 0..rows.count {
        let q = blend_rows(weights(&basis.point, rows.piece + j), &piece.net);
        weigh3(&basis.point, cols.piece, n, &q, &mut line);
        put(
            points,
            (rows.block + j) * BLOCK_STRIDE + cols.block,
            cols.count,
            &line,
        );
    }
    if let Some(normals) = normals {
        dice_normals(piece, basis, &cols, &rows, normals);
    }
}

/// Writes the first `n` points of a line.
#[inline(always)]
fn put(grid: &mut Grid3, at: usize, n: usize, line: &[Line; 3]) {
    grid.x[at..at + n].copy_from_slice(&line[0][..n]);
    grid.y[at..at + n].copy_from_slice(&line[1][..n]);
    grid.z[at..at + n].copy_from_slice(&line[2][..n]);
}

#[inline(always)]
fn dice_normals(piece: &Piece, basis: &Basis, cols: &Overlap, rows: &Overlap, normals: &mut Grid3) {
    let spare = fallback(&piece.net);
    let n = cols.count.next_multiple_of(LANES);
    let (mut du, mut dv, mut unit) = ([[0.0; LINE]; 3], [[0.0; LINE]; 3], [[0.0; LINE]; 3]);
    for j in 0..rows.count {
        let v = rows.piece + j;
        let q = blend_rows(weights(&basis.limit, v), &piece.net);
        let r = blend_rows(weights(&basis.slope, v), &piece.net);
        weigh3(&basis.slope, cols.piece, n, &q, &mut du);
        weigh3(&basis.limit, cols.piece, n, &r, &mut dv);
        unit_cross(&du, &dv, n, spare, &mut unit);
        put(
            normals,
            (rows.block + j) * BLOCK_STRIDE + cols.block,
            cols.count,
            &unit,
        );
    }
}

/// A normal for points where the tangents are parallel: that of the patch as a whole.
fn fallback(net: &[[P4; 4]; 4]) -> [f32; 3] {
    let n = (net[2][2] - net[1][1]).cross(net[2][1] - net[1][2]);
    n.unit().map_or([0.0, 0.0, 1.0], P4::xyz)
}

/// Unit cross products along a line; `spare` where there is none.
#[inline(always)]
pub(crate) fn unit_cross(
    a: &[Line; 3],
    b: &[Line; 3],
    n: usize,
    spare: [f32; 3],
    out: &mut [Line; 3],
) {
    let (a0, a1, a2) = (&a[0][..n], &a[1][..n], &a[2][..n]);
    let (b0, b1, b2) = (&b[0][..n], &b[1][..n], &b[2][..n]);
    let [x, y, z] = out;
    let (x, y, z) = (&mut x[..n], &mut y[..n], &mut z[..n]);
    for i in 0..n {
        // Scale both by their largest component, so that squares stay inside f32 for cages of any size.
        let ma = a0[i].abs().max(a1[i].abs()).max(a2[i].abs());
        let mb = b0[i].abs().max(b1[i].abs()).max(b2[i].abs());
        let (ia, ib) = (
            1.0 / ma.max(f32::MIN_POSITIVE),
            1.0 / mb.max(f32::MIN_POSITIVE),
        );
        let (ax, ay, az) = (a0[i] * ia, a1[i] * ia, a2[i] * ia);
        let (bx, by, bz) = (b0[i] * ib, b1[i] * ib, b2[i] * ib);
        let nx = ay * bz - az * by;
        let ny = az * bx - ax * bz;
        let nz = ax * by - ay * bx;
        let square = (nx * nx + ny * ny) + nz * nz;
        // Below this the cross product is rounding noise of the two unit-sized factors.
        let sound = square > 1e-12;
        let inverse = 1.0 / select_unpredictable(sound, square, 1.0).sqrt();
        x[i] = select_unpredictable(sound, nx * inverse, spare[0]);
        y[i] = select_unpredictable(sound, ny * inverse, spare[1]);
        z[i] = select_unpredictable(sound, nz * inverse, spare[2]);
    }
}

impl Piece {
    /// Points whose convex hull holds the diced points between the given columns and rows (in units of the piece's size).
    pub(crate) fn hull(
        &self,
        target: Target,
        u: [f32; 2],
        v: [f32; 2],
        out: &mut impl FnMut([f32; 3]),
    ) {
        if target == Target::Refined {
            self.net.iter().flatten().for_each(|p| out(p.xyz()));
            return;
        }
        let along_u: [[P4; 4]; 4] = std::array::from_fn(|r| bezier(self.net[r], u));
        for c in 0..4 {
            let column = bezier(
                [along_u[0][c], along_u[1][c], along_u[2][c], along_u[3][c]],
                v,
            );
            column.iter().for_each(|p| out(p.xyz()));
        }
    }
}

/// Bézier points over `[a, b]` of the B-spline segment with control points `p`: its blossom at (a,a,a), (a,a,b), (a,b,b), (b,b,b).
fn bezier(p: [P4; 4], [a, b]: [f32; 2]) -> [P4; 4] {
    let mix = |p: P4, q: P4, t: f32| p + (q - p) * t;
    let blossom = |u: f32, v: f32, w: f32| {
        let q: [P4; 3] = std::array::from_fn(|i| mix(p[i], p[i + 1], (u + 2.0 - i as f32) / 3.0));
        let r: [P4; 2] = std::array::from_fn(|i| mix(q[i], q[i + 1], (v + 1.0 - i as f32) / 2.0));
        mix(r[0], r[1], w)
    };
    [
        blossom(a, a, a),
        blossom(a, a, b),
        blossom(a, b, b),
        blossom(b, b, b),
    ]
}
