//! Projection and snapping: from points in model space to the integer grid of 1/256 pixel, globally, before anything is made
//! relative to a block. Points with equal bits get equal positions whatever block or lane they stand in.
//!
//! Order of operations, nothing fused: `X = (x0*x + x1*y) + (x2*z + x3)`, likewise `Y`, `W` and (orthographic) the depth; then
//! `X/W`, `Y/W` and `1/W` by IEEE division; then rounding to the nearest integer, ties to even.

use super::edge::ScreenVertex;
use super::setup::{DEPTH_MARGIN, PixelBox};
use crate::dispatch;
use crate::records::{BLOCK_LEN, BLOCK_STRIDE, BlockSize, Grid3, Projection};
use crate::simd::{LANES, Level};

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
        dispatch!(level, project_rows::<true>(grid, projection, out));
    } else {
        dispatch!(level, project_rows::<false>(grid, projection, out));
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

#[inline(always)]
fn project_rows<const ORTHO: bool>(grid: &Grid3, p: &Projection, out: &mut ProjectedBlock) {
    let BlockSize { cols, rows } = out.size;
    // Whole vectors: the points beyond the last column are finite and only cost time, but they must not widen the box.
    let mut low_x = [i32::MAX; LANES];
    let mut low_y = [i32::MAX; LANES];
    let mut high_x = [i32::MIN; LANES];
    let mut high_y = [i32::MIN; LANES];
    let mut outside = [0_u32; LANES];
    let mut nearest = [0.0_f32; LANES];
    for j in 0..rows {
        for i0 in (0..cols).step_by(LANES) {
            let range = j * BLOCK_STRIDE + i0..j * BLOCK_STRIDE + i0 + LANES;
            let (gx, gy, gz) = (
                &grid.x[range.clone()],
                &grid.y[range.clone()],
                &grid.z[range.clone()],
            );
            let real = (cols - i0) as i32;
            // Results go through local arrays: the compiler cannot know that `out` and `grid` do not overlap.
            let mut ox = [0; LANES];
            let mut oy = [0; LANES];
            let mut od = [0.0; LANES];
            for l in 0..LANES {
                let (x, y, z) = (gx[l], gy[l], gz[l]);
                let hw = if ORTHO { 1.0 } else { dot(&p.w, x, y, z) };
                let hd = if ORTHO { dot(&p.d, x, y, z) } else { 0.0 };
                let (sx, sy, depth, inside) =
                    snap::<ORTHO>(dot(&p.x, x, y, z), dot(&p.y, x, y, z), hw, hd, p.near);
                (ox[l], oy[l], od[l]) = (sx, sy, depth);
                let real = (l as i32) < real;
                outside[l] |= u32::from(real & !inside);
                let near = if real { depth } else { 0.0 };
                nearest[l] = if near > nearest[l] { near } else { nearest[l] };
                low_x[l] = low_x[l].min(if real { sx } else { i32::MAX });
                low_y[l] = low_y[l].min(if real { sy } else { i32::MAX });
                high_x[l] = high_x[l].max(if real { sx } else { i32::MIN });
                high_y[l] = high_y[l].max(if real { sy } else { i32::MIN });
            }
            out.x[range.clone()].copy_from_slice(&ox);
            out.y[range.clone()].copy_from_slice(&oy);
            out.depth[range].copy_from_slice(&od);
        }
    }
    let least = |lanes: [i32; LANES]| lanes.into_iter().fold(i32::MAX, i32::min);
    let most = |lanes: [i32; LANES]| lanes.into_iter().fold(i32::MIN, i32::max);
    out.clip = outside.iter().any(|&o| o != 0);
    out.low = [least(low_x), least(low_y)];
    out.high = [most(high_x), most(high_y)];
    out.nearest = nearest.into_iter().fold(0.0, f32::max);
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
