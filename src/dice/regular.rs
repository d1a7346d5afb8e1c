//! The tensor kernel: a regular patch is a bicubic B-spline, diced row by row with lanes along u.
//!
//! A row first blends the four rows of the net into four points, then every lane blends those four. Sums run as
//! `(w0 p0 + w3 p3) + (w1 p1 + w2 p2)` everywhere.

use super::basis::{Basis, Target};
use super::point::P4;
use crate::records::{BLOCK_STRIDE, Grid3};

/// Points in one vector of the kernels.
const LANES: usize = 16;

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

/// Four weight rows at 16 neighbouring columns.
#[inline(always)]
pub(crate) fn columns(w: &[Vec<f32>; 4], at: usize) -> [[f32; LANES]; 4] {
    std::array::from_fn(|k| {
        let mut out = [0.0; LANES];
        out.copy_from_slice(&w[k][at..at + LANES]);
        out
    })
}

#[inline(always)]
pub(crate) fn lanes(w: &[[f32; LANES]; 4], q: &[P4; 4], c: usize) -> [f32; LANES] {
    let mut out = [0.0; LANES];
    for i in 0..LANES {
        out[i] = (w[0][i] * q[0].0[c] + w[3][i] * q[3].0[c])
            + (w[1][i] * q[1].0[c] + w[2][i] * q[2].0[c]);
    }
    out
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

/// The block that pieces are diced into.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlockRange {
    /// Grid point at which the block begins.
    pub(crate) start: [u32; 2],
    /// First grid point wanted along u and v.
    pub(crate) low: [u32; 2],
    /// Last grid point wanted.
    pub(crate) high: [u32; 2],
}

/// Stores the first `n` lanes; what stands behind them stays. Written as a whole vector, which beats a copy of variable length.
#[inline(always)]
fn store(out: &mut [f32], at: usize, lanes: &[f32; LANES], n: usize) {
    let out = &mut out[at..at + LANES];
    let mut mixed = [0.0; LANES];
    for k in 0..LANES {
        mixed[k] = if k < n { lanes[k] } else { out[k] };
    }
    out.copy_from_slice(&mixed);
}

/// Dices the parts of all pieces inside a block, in their order.
#[inline(always)]
pub(crate) fn dice_pieces(
    pieces: &[Piece],
    target: Target,
    range: BlockRange,
    points: &mut Grid3,
    mut normals: Option<&mut Grid3>,
) {
    for piece in pieces {
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
    let Some(cols) = overlap(
        piece.origin[0],
        piece.size,
        range.start[0],
        range.low[0],
        range.high[0],
    ) else {
        return;
    };
    let Some(rows) = overlap(
        piece.origin[1],
        piece.size,
        range.start[1],
        range.low[1],
        range.high[1],
    ) else {
        return;
    };
    let basis = Basis::get(target, piece.level);
    for j in 0..rows.count {
        let v = rows.piece + j;
        let w: [f32; 4] = std::array::from_fn(|k| basis.point[k][v]);
        let q: [P4; 4] = std::array::from_fn(|c| {
            blend(
                w,
                [
                    piece.net[0][c],
                    piece.net[1][c],
                    piece.net[2][c],
                    piece.net[3][c],
                ],
            )
        });
        let row = (rows.block + j) * BLOCK_STRIDE + cols.block;
        let mut i = 0;
        while i < cols.count {
            let wu = columns(&basis.point, cols.piece + i);
            let n = (cols.count - i).min(LANES);
            store(&mut points.x, row + i, &lanes(&wu, &q, 0), n);
            store(&mut points.y, row + i, &lanes(&wu, &q, 1), n);
            store(&mut points.z, row + i, &lanes(&wu, &q, 2), n);
            i += LANES;
        }
    }
    if let Some(normals) = normals {
        dice_normals(piece, basis, &cols, &rows, normals);
    }
}

#[inline(always)]
fn dice_normals(piece: &Piece, basis: &Basis, cols: &Overlap, rows: &Overlap, normals: &mut Grid3) {
    let net = &piece.net;
    let spare = fallback(net);
    for j in 0..rows.count {
        let v = rows.piece + j;
        let w: [f32; 4] = std::array::from_fn(|k| basis.limit[k][v]);
        let s: [f32; 4] = std::array::from_fn(|k| basis.slope[k][v]);
        let q: [P4; 4] =
            std::array::from_fn(|c| blend(w, [net[0][c], net[1][c], net[2][c], net[3][c]]));
        let r: [P4; 4] =
            std::array::from_fn(|c| blend(s, [net[0][c], net[1][c], net[2][c], net[3][c]]));
        let row = (rows.block + j) * BLOCK_STRIDE + cols.block;
        let mut i = 0;
        while i < cols.count {
            let wu = columns(&basis.limit, cols.piece + i);
            let su = columns(&basis.slope, cols.piece + i);
            let du = [lanes(&su, &q, 0), lanes(&su, &q, 1), lanes(&su, &q, 2)];
            let dv = [lanes(&wu, &r, 0), lanes(&wu, &r, 1), lanes(&wu, &r, 2)];
            let n = (cols.count - i).min(LANES);
            let unit = unit_cross(&du, &dv, spare);
            store(&mut normals.x, row + i, &unit[0], n);
            store(&mut normals.y, row + i, &unit[1], n);
            store(&mut normals.z, row + i, &unit[2], n);
            i += LANES;
        }
    }
}

/// A normal for points where the tangents are parallel: that of the patch as a whole.
fn fallback(net: &[[P4; 4]; 4]) -> [f32; 3] {
    let n = (net[2][2] - net[1][1]).cross(net[2][1] - net[1][2]);
    n.unit().map_or([0.0, 0.0, 1.0], P4::xyz)
}

/// Unit cross products of 16 pairs of vectors; `spare` where there is none.
#[inline(always)]
pub(crate) fn unit_cross(
    a: &[[f32; LANES]; 3],
    b: &[[f32; LANES]; 3],
    spare: [f32; 3],
) -> [[f32; LANES]; 3] {
    let mut out = [[0.0; LANES]; 3];
    for i in 0..LANES {
        // Scale both by their largest component, so that squares stay inside f32 for cages of any size.
        let ma = a[0][i].abs().max(a[1][i].abs()).max(a[2][i].abs());
        let mb = b[0][i].abs().max(b[1][i].abs()).max(b[2][i].abs());
        let (ia, ib) = (
            1.0 / ma.max(f32::MIN_POSITIVE),
            1.0 / mb.max(f32::MIN_POSITIVE),
        );
        let (ax, ay, az) = (a[0][i] * ia, a[1][i] * ia, a[2][i] * ia);
        let (bx, by, bz) = (b[0][i] * ib, b[1][i] * ib, b[2][i] * ib);
        let x = ay * bz - az * by;
        let y = az * bx - ax * bz;
        let z = ax * by - ay * bx;
        let square = (x * x + y * y) + z * z;
        // Below this the cross product is rounding noise of the two unit-sized factors.
        let sound = square > 1e-12;
        let inverse = 1.0 / if sound { square } else { 1.0 }.sqrt();
        out[0][i] = if sound { x * inverse } else { spare[0] };
        out[1][i] = if sound { y * inverse } else { spare[1] };
        out[2][i] = if sound { z * inverse } else { spare[2] };
    }
    out
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
