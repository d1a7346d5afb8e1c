//! Projection and snapping: from points in model space to the integer grid of 1/256 pixel, globally, before anything is made
//! relative to a block. Points with equal bits get equal positions whatever block or lane they stand in.
//!
//! Order of operations, nothing fused: `X = (x0*x + x1*y) + (x2*z + x3)`, likewise `Y`, `W` and (orthographic) the depth; then
//! `X/W`, `Y/W` and `1/W` by IEEE division; then rounding to the nearest integer, ties to even.

use super::edge::ScreenVertex;
use super::setup::{DEPTH_MARGIN, PixelBox};
use crate::dispatch;
use crate::records::{BLOCK_LEN, BLOCK_STRIDE, BlockSize, Grid3, Projection};
use crate::simd::{LANES, Lanes, Level};
use std::ops::Range;

/// Positions on the screen stay below this, in 1/256 pixel; what is farther out is clipped. Differences are then below 2^23, edge
/// functions below 2^47: exact in i64 and in f64.
pub const GUARD_BAND: i32 = 1 << 22;

/// 1.5 * 2^23: adding it leaves the nearest integer, ties to even, in the low bits of the sum. Right up to [`GUARD_BAND`].
const ROUND: f32 = 12_582_912.0;

/// A block of points on the screen.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct ProjectedBlock {
    pub(super) x: [i32; BLOCK_LEN],
    pub(super) y: [i32; BLOCK_LEN],
    pub(super) depth: [f32; BLOCK_LEN],
    /// Homogeneous X, Y, W and depth, and who is outside; written only where `clip`.
    pub(super) hx: [f32; BLOCK_LEN],
    pub(super) hy: [f32; BLOCK_LEN],
    pub(super) hw: [f32; BLOCK_LEN],
    pub(super) hd: [f32; BLOCK_LEN],
    pub(super) outside: [u32; BLOCK_LEN],
    pub(super) size: BlockSize,
    pub(super) clip: bool,
    pub(super) near: f32,
    pub(super) ortho: bool,
    pub(super) low: [i32; 2],
    pub(super) high: [i32; 2],
    pub(super) nearest: f32,
}

impl ProjectedBlock {
    /// An empty block, on the heap (50 KB, of which unclipped blocks touch 19).
    #[must_use]
    pub fn boxed() -> Box<Self> {
        Box::new(Self {
            x: [0; BLOCK_LEN],
            y: [0; BLOCK_LEN],
            depth: [0.0; BLOCK_LEN],
            hx: [0.0; BLOCK_LEN],
            hy: [0.0; BLOCK_LEN],
            hw: [0.0; BLOCK_LEN],
            hd: [0.0; BLOCK_LEN],
            outside: [0; BLOCK_LEN],
            size: BlockSize { cols: 0, rows: 0 },
            clip: false,
            near: 0.0,
            ortho: false,
            low: [0; 2],
            high: [0; 2],
            nearest: 0.0,
        })
    }

    /// Size in points.
    #[must_use]
    pub fn size(&self) -> BlockSize {
        self.size
    }

    /// A point lies before the near plane or outside the guard band, so that some micro-quads are clipped.
    #[must_use]
    pub fn is_clipped(&self) -> bool {
        self.clip
    }

    /// Screen box of the points in 1/256 pixel, least and greatest; the whole screen for clipped blocks.
    #[must_use]
    pub fn bounds(&self) -> [[i32; 2]; 2] {
        [self.low, self.high]
    }

    /// The pixels that the block may touch and its nearest depth, for asking whether it is hidden; `None` for clipped blocks.
    #[must_use]
    pub fn pixel_box(&self) -> Option<PixelBox> {
        if self.clip {
            return None;
        }
        let pixel = |v: i32, up: i32| (((v + up) >> 8).max(0)) as u32;
        Some(PixelBox {
            low: self.low.map(|v| pixel(v, 0)),
            high: self.high.map(|v| pixel(v, 255)),
            nearest: self.nearest * DEPTH_MARGIN,
        })
    }

    /// Screen position, 1/256 pixel, of the point in column `i` and row `j`; meaningless for a clipped one.
    #[must_use]
    pub fn position(&self, i: usize, j: usize) -> [i32; 2] {
        let k = j * BLOCK_STRIDE + i;
        [self.x[k], self.y[k]]
    }

    /// Depth of the point in column `i` and row `j`: larger is nearer.
    #[must_use]
    pub fn depth(&self, i: usize, j: usize) -> f32 {
        self.depth[j * BLOCK_STRIDE + i]
    }

    /// Moves a point by `dx`, so that a test may break a shared edge.
    #[doc(hidden)]
    pub fn nudge(&mut self, i: usize, j: usize, dx: i32) {
        self.x[j * BLOCK_STRIDE + i] += dx;
    }

    #[inline(always)]
    pub(super) fn vertex(&self, k: usize) -> ScreenVertex {
        ScreenVertex {
            x: self.x[k],
            y: self.y[k],
            depth: self.depth[k],
        }
    }
}

/// Projects the points of `grid` into `out`.
///
/// # Panics
/// `size` is not within 2 to 33 points.
pub fn project(
    level: Level,
    grid: &Grid3,
    size: BlockSize,
    projection: &Projection,
    out: &mut ProjectedBlock,
) {
    project_rows(level, grid, (size, 0..size.rows), projection, out);
}

/// The same for some rows of points. The others mean nothing then, and what is said of the block as a whole is said of these rows.
///
/// # Panics
/// `size` is not within 2 to 33 points, or has fewer rows.
pub fn project_rows(
    level: Level,
    grid: &Grid3,
    (size, rows): (BlockSize, Range<usize>),
    projection: &Projection,
    out: &mut ProjectedBlock,
) {
    assert!(rows.end <= size.rows, "no such rows");
    assert!(
        (2..=33).contains(&size.cols) && (2..=33).contains(&size.rows),
        "blocks have 2 to 33 points a side, not {} by {}",
        size.cols,
        size.rows
    );
    out.size = size;
    out.near = projection.near;
    out.ortho = projection.ortho;
    if projection.ortho {
        dispatch!(level, rows_kernel::<true>(grid, rows, projection, out));
    } else {
        dispatch!(level, rows_kernel::<false>(grid, rows, projection, out));
    }
    if out.clip {
        keep_homogeneous(grid, projection, out);
        out.low = [-GUARD_BAND; 2];
        out.high = [GUARD_BAND; 2];
    }
}

/// `r . (x, y, z, 1)` in the documented order.
#[inline(always)]
pub(super) fn dot(r: &[f32; 4], x: f32, y: f32, z: f32) -> f32 {
    (r[0] * x + r[1] * y) + (r[2] * z + r[3])
}

/// One point on the screen: x, y, depth, and whether it is inside.
#[inline(always)]
pub(super) fn snap<const ORTHO: bool>(
    hx: f32,
    hy: f32,
    hw: f32,
    hd: f32,
    near: f32,
) -> (i32, i32, f32, bool) {
    let guard = GUARD_BAND as f32;
    let before = if ORTHO { hd <= 2.0 } else { hw >= near };
    let w = if before { hw } else { 1.0 };
    let (x, y) = (hx / w, hy / w);
    // Comparisons with NaN fail: such a point is outside.
    let inside = before & (x.abs() < guard) & (y.abs() < guard);
    let depth = if ORTHO {
        if hd > f32::MIN_POSITIVE {
            hd
        } else {
            f32::MIN_POSITIVE
        }
    } else {
        1.0 / w
    };
    let round = |v: f32| {
        let v = if inside { v } else { 0.0 };
        (v + ROUND).to_bits() as i32 - ROUND.to_bits() as i32
    };
    (round(x), round(y), depth, inside)
}

/// Least and greatest position, nearest depth, and whether any point is outside, of the points of each lane.
struct Extent {
    low: [Lanes<i32>; 2],
    high: [Lanes<i32>; 2],
    outside: Lanes<u32>,
    nearest: Lanes<f32>,
}

/// Sixteen points on the screen.
struct Snapped {
    x: Lanes<i32>,
    y: Lanes<i32>,
    depth: Lanes<f32>,
}

impl Extent {
    #[inline(always)]
    fn add<const ORTHO: bool>(&mut self, p: &Projection, points: &[Lanes<f32>; 3]) -> Snapped {
        let mut out = Snapped {
            x: Lanes([0; LANES]),
            y: Lanes([0; LANES]),
            depth: Lanes([0.0; LANES]),
        };
        for l in 0..LANES {
            let (x, y, z) = (points[0][l], points[1][l], points[2][l]);
            let hw = if ORTHO { 1.0 } else { dot(&p.w, x, y, z) };
            let hd = if ORTHO { dot(&p.d, x, y, z) } else { 0.0 };
            let (sx, sy, depth, inside) =
                snap::<ORTHO>(dot(&p.x, x, y, z), dot(&p.y, x, y, z), hw, hd, p.near);
            (out.x[l], out.y[l], out.depth[l]) = (sx, sy, depth);
            self.outside[l] |= u32::from(!inside);
            let nearest = self.nearest[l];
            self.nearest[l] = if depth > nearest { depth } else { nearest };
            self.low[0][l] = self.low[0][l].min(sx);
            self.low[1][l] = self.low[1][l].min(sy);
            self.high[0][l] = self.high[0][l].max(sx);
            self.high[1][l] = self.high[1][l].max(sy);
        }
        out
    }
}

#[inline(always)]
fn rows_kernel<const ORTHO: bool>(
    grid: &Grid3,
    rows: Range<usize>,
    p: &Projection,
    out: &mut ProjectedBlock,
) {
    let cols = out.size.cols;
    let mut all = Extent {
        low: [Lanes([i32::MAX; LANES]); 2],
        high: [Lanes([i32::MIN; LANES]); 2],
        outside: Lanes([0; LANES]),
        nearest: Lanes([0.0; LANES]),
    };
    let components = [&grid.x, &grid.y, &grid.z];
    let mut points = [Lanes([0.0; LANES]); 3];
    // A column beyond whole vectors goes in lanes of its own.
    let whole = cols - usize::from(cols % LANES == 1);
    for j in rows.clone() {
        for i0 in (0..whole).step_by(LANES) {
            let range = j * BLOCK_STRIDE + i0..j * BLOCK_STRIDE + i0 + LANES;
            let real = whole - i0;
            // Points beyond the last column must not widen the box: they are the first once more.
            for (lanes, values) in points.iter_mut().zip(components) {
                let values = &values[range.clone()];
                lanes.copy_from_slice(values);
                if real < LANES {
                    lanes[real..].fill(values[0]);
                }
            }
            let at = all.add::<ORTHO>(p, &points);
            out.x[range.clone()].copy_from_slice(&at.x.0);
            out.y[range.clone()].copy_from_slice(&at.y.0);
            out.depth[range].copy_from_slice(&at.depth.0);
        }
    }
    if whole < cols {
        for j0 in rows.clone().step_by(LANES) {
            let place = |l: usize| (j0 + l).min(rows.end - 1) * BLOCK_STRIDE + whole;
            for (lanes, values) in points.iter_mut().zip(components) {
                for l in 0..LANES {
                    lanes[l] = values[place(l)];
                }
            }
            let at = all.add::<ORTHO>(p, &points);
            for l in 0..LANES {
                let k = place(l);
                (out.x[k], out.y[k], out.depth[k]) = (at.x[l], at.y[l], at.depth[l]);
            }
        }
    }
    let least = |lanes: &Lanes<i32>| lanes.iter().copied().fold(i32::MAX, i32::min);
    let most = |lanes: &Lanes<i32>| lanes.iter().copied().fold(i32::MIN, i32::max);
    out.clip = all.outside.iter().any(|&o| o != 0);
    out.low = [least(&all.low[0]), least(&all.low[1])];
    out.high = [most(&all.high[0]), most(&all.high[1])];
    out.nearest = all.nearest.iter().copied().fold(0.0, f32::max);
}

/// Second pass over the few blocks that are clipped.
fn keep_homogeneous(grid: &Grid3, p: &Projection, out: &mut ProjectedBlock) {
    for j in 0..out.size.rows {
        for i in 0..out.size.cols {
            let k = j * BLOCK_STRIDE + i;
            let (x, y, z) = (grid.x[k], grid.y[k], grid.z[k]);
            out.hx[k] = dot(&p.x, x, y, z);
            out.hy[k] = dot(&p.y, x, y, z);
            out.hw[k] = if p.ortho { 1.0 } else { dot(&p.w, x, y, z) };
            out.hd[k] = if p.ortho { dot(&p.d, x, y, z) } else { 0.0 };
            let (hx, hy, hw, hd) = (out.hx[k], out.hy[k], out.hw[k], out.hd[k]);
            let inside = if p.ortho {
                snap::<true>(hx, hy, hw, hd, p.near).3
            } else {
                snap::<false>(hx, hy, hw, hd, p.near).3
            };
            out.outside[k] = u32::from(!inside);
        }
    }
}
