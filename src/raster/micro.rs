//! Micro-quads of up to a few pixels: lanes are 16 quads of a grid row, loaded without gathers. Each lane walks its own small window
//! of samples; all lanes walk together, so the time per quad hardly depends on where its samples are.
//!
//! Edge values are below 2^24 in this size class, so floats hold them exactly: the same integers as in the other paths, without
//! integer multiplications, which the weaker levels lack. After Fatahalian and others, *Data-parallel rasterization of
//! micropolygons with defocus and motion blur*, 2009: vectors must run across micropolygons, not within one.

use super::edge::{first_pixel, threshold};
use super::project::ProjectedBlock;
use super::samples::sample_positions;
use super::tile::{Cell, Tile};
use crate::math::positive;
use crate::records::BLOCK_STRIDE;
use crate::simd::{LANES, Lanes, bits, flag, word_bits};
use std::hint::select_unpredictable;

/// Largest extent, 1/256 pixel, of a micro-quad of this path; its window is then at most 6 by 6 samples. Larger makes vectors wait
/// for their largest lane; smaller sends quads to a path that costs more each. Exactness ends at 7 pixels: an extent times an
/// extent and the window's reach, twice, must stay below 2^24.
pub(super) const MICRO_EXTENT: i32 = 6 * 256;

/// More samples than any window has in a row or column.
const WINDOW: i32 = MICRO_EXTENT / 256 + 1;

/// Sixteen quads: the grid row `j`, columns from `i0`.
#[derive(Clone, Copy)]
pub(super) struct Chunk {
    pub(super) i0: usize,
    pub(super) j: usize,
    /// Lanes that are quads to be drawn here, bit by bit.
    pub(super) live: u32,
    /// Id of half 0 of the first quad.
    pub(super) id: u32,
    /// Send everything to the other paths.
    pub(super) refuse: bool,
}

type Floats = Lanes<f32>;
type Ints = Lanes<i32>;

/// The bit of each lane in a mask.
const LANE_BITS: [u32; LANES] = {
    let mut bits = [0; LANES];
    let mut l = 0;
    while l < LANES {
        bits[l] = 1 << l;
        l += 1;
    }
    bits
};

/// Draws the micro-quads of a chunk; returns the lanes that touch the tile and are left to other paths, being too large or folded
/// along the diagonal (where both halves may cover a sample).
#[inline(always)]
pub(super) fn chunk<C: Cell>(
    tile: &mut Tile<C>,
    block: &ProjectedBlock,
    chunk: Chunk,
    tie: i32,
) -> u32 {
    let k = chunk.j * BLOCK_STRIDE + chunk.i0;
    let (upper, lower) = (k..k + LANES, k + BLOCK_STRIDE..k + BLOCK_STRIDE + LANES);
    let (upper1, lower1) = (
        k + 1..k + 1 + LANES,
        k + 1 + BLOCK_STRIDE..k + 1 + BLOCK_STRIDE + LANES,
    );
    let (ax, ay) = (&block.x[upper.clone()], &block.y[upper.clone()]);
    let (bx, by) = (&block.x[upper1.clone()], &block.y[upper1.clone()]);
    let (cx, cy) = (&block.x[lower1.clone()], &block.y[lower1.clone()]);
    let (dx, dy) = (&block.x[lower.clone()], &block.y[lower.clone()]);

    // Boxes, and who is of this path.
    let (left, top) = (tile.x0 * 256, tile.y0 * 256);
    let (right, bottom) = (left + tile.width * 256, top + tile.height * 256);
    let mut x_low: Ints = Lanes([0; LANES]);
    let mut x_high: Ints = Lanes([0; LANES]);
    let mut y_low: Ints = Lanes([0; LANES]);
    let mut y_high: Ints = Lanes([0; LANES]);
    // Lanes of this path, and lanes that touch the tile.
    let mut fits = [0; LANES];
    let mut touching = [0; LANES];
    for l in 0..LANES {
        let x0 = ax[l].min(bx[l]).min(cx[l].min(dx[l]));
        let x1 = ax[l].max(bx[l]).max(cx[l].max(dx[l]));
        let y0 = ay[l].min(by[l]).min(cy[l].min(dy[l]));
        let y1 = ay[l].max(by[l]).max(cy[l].max(dy[l]));
        (x_low[l], x_high[l], y_low[l], y_high[l]) = (x0, x1, y0, y1);
        touching[l] = flag((x1 > left) & (x0 < right) & (y1 > top) & (y0 < bottom));
        fits[l] = flag((x1 - x0 <= MICRO_EXTENT) & (y1 - y0 <= MICRO_EXTENT));
    }
    let touching = bits(&touching) & chunk.live;
    let fits = bits(&fits) & touching;
    if chunk.refuse || fits == 0 {
        return touching;
    }

    // Edges ab, bc, dc, ad, ac: directions, and thresholds of their signs.
    let mut ex: [Floats; 5] = [Lanes([0.0; LANES]); 5];
    let mut ey: [Floats; 5] = [Lanes([0.0; LANES]); 5];
    let mut et: [Floats; 5] = [Lanes([0.0; LANES]); 5];
    let mut inverse0: Floats = Lanes([0.0; LANES]);
    let mut inverse1: Floats = Lanes([0.0; LANES]);
    let mut front: Ints = Lanes([0; LANES]);
    let mut folded = [0; LANES];
    for l in 0..LANES {
        let x = [
            bx[l] - ax[l],
            cx[l] - bx[l],
            cx[l] - dx[l],
            dx[l] - ax[l],
            cx[l] - ax[l],
        ];
        let y = [
            by[l] - ay[l],
            cy[l] - by[l],
            cy[l] - dy[l],
            dy[l] - ay[l],
            cy[l] - ay[l],
        ];
        for e in 0..5 {
            ex[e][l] = x[e] as f32;
            ey[e][l] = y[e] as f32;
            et[e][l] = threshold(x[e], y[e], tie) as f32;
        }
        let area0 = ex[0][l] * ey[4][l] - ey[0][l] * ex[4][l];
        let area1 = ex[4][l] * ey[3][l] - ey[4][l] * ex[3][l];
        // The selection changes nothing, but keeps the division out of the loop over samples, where the compiler would merge two.
        inverse0[l] = positive(1.0 / area0.abs());
        inverse1[l] = positive(1.0 / area1.abs());
        front[l] = i32::from((area0 < 0.0) | (area1 < 0.0));
        folded[l] = flag(((area0 < 0.0) & (area1 > 0.0)) | ((area0 > 0.0) & (area1 < 0.0)));
    }
    let fits = fits & !bits(&folded);
    let left_over = touching & !fits;

    let (za, zb) = (&block.depth[upper], &block.depth[upper1]);
    let (zc, zd) = (&block.depth[lower1], &block.depth[lower]);
    let (tile_right, tile_bottom) = (tile.x0 + tile.width, tile.y0 + tile.height);
    let stride = tile.stride as i32;
    let mut ids = Lanes([0; LANES]);
    let mut across_step = ey;
    for l in 0..LANES {
        ids[l] = chunk.id + 2 * l as u32;
        for e in 0..5 {
            across_step[e][l] *= 256.0;
        }
    }
    let mut batch = Batch::<C>::new();
    for (s, &[ox, oy]) in sample_positions(tile.samples()).iter().enumerate() {
        // Windows, and the edge values at their first samples.
        let mut across: Ints = Lanes([0; LANES]);
        let mut down: Ints = Lanes([0; LANES]);
        let mut base: Ints = Lanes([0; LANES]);
        let mut row: [Floats; 5] = [Lanes([0.0; LANES]); 5];
        for l in 0..LANES {
            let px = first_pixel(x_low[l], ox).max(tile.x0);
            let py = first_pixel(y_low[l], oy).max(tile.y0);
            let live = fits & LANE_BITS[l] != 0;
            let mut nx = first_pixel(x_high[l], ox).min(tile_right) - px;
            let mut ny = first_pixel(y_high[l], oy).min(tile_bottom) - py;
            let some = live & (nx > 0) & (ny > 0);
            nx = if some { nx } else { 0 };
            ny = if some { ny } else { 0 };
            (across[l], down[l]) = (nx, ny);
            base[l] = (py - tile.y0) * stride + (px - tile.x0);
            let (x, y) = (px * 256 + ox, py * 256 + oy);
            let (xa, ya) = ((x - ax[l]) as f32, (y - ay[l]) as f32);
            let (xb, yb) = ((x - bx[l]) as f32, (y - by[l]) as f32);
            let (xd, yd) = ((x - dx[l]) as f32, (y - dy[l]) as f32);
            row[0][l] = ex[0][l] * ya - ey[0][l] * xa;
            row[1][l] = ex[1][l] * yb - ey[1][l] * xb;
            row[2][l] = ex[2][l] * yd - ey[2][l] * xd;
            row[3][l] = ex[3][l] * ya - ey[3][l] * xa;
            row[4][l] = ex[4][l] * ya - ey[4][l] * xa;
        }
        let plane_at = tile.plane(s);
        let plane_end = tile.plane(s + 1);
        'slots: for slot_y in 0..WINDOW {
            let mut at = row;
            for slot_x in 0..WINDOW {
                let mut here = [0; LANES];
                for l in 0..LANES {
                    here[l] = flag((slot_x < across[l]) & (slot_y < down[l]));
                }
                let here = bits(&here);
                if here == 0 {
                    if slot_x == 0 {
                        break 'slots;
                    }
                    break;
                }
                let mut hit: Ints = Lanes([0; LANES]);
                let mut depth: Floats = Lanes([0.0; LANES]);
                let mut id = Lanes([0; LANES]);
                for l in 0..LANES {
                    let [ab, bc, dc, ad, ac] = [0, 1, 2, 3, 4].map(|e| at[e][l]);
                    let p_ab = ab >= et[0][l];
                    let p_dc = dc >= et[2][l];
                    let p_ac = ac >= et[4][l];
                    let half0 = (p_ab == (bc >= et[1][l])) & (p_ab != p_ac);
                    let half1 = (p_dc == (ad >= et[3][l])) & (p_dc != p_ac);
                    hit[l] = -i32::from(half0 | half1);
                    // An `if` here may become a choice of addresses, and a gather.
                    let w0 = select_unpredictable(half0, bc, dc).abs();
                    let w2 = select_unpredictable(half0, ab, ad).abs();
                    let z1 = select_unpredictable(half0, zb[l], zd[l]);
                    let inverse = select_unpredictable(half0, inverse0[l], inverse1[l]);
                    depth[l] = ((w0 * za[l] + ac.abs() * z1) + w2 * zc[l]) * inverse;
                    id[l] = ids[l] + u32::from(!half0);
                }
                for e in 0..5 {
                    for l in 0..LANES {
                        at[e][l] -= across_step[e][l];
                    }
                }
                let cells = &mut batch.cells[batch.len];
                for l in 0..LANES {
                    cells[l] = base[l] + (slot_y * stride + slot_x);
                }
                let values = &mut batch.values[batch.len];
                for l in 0..LANES {
                    values[l] = C::pack(depth[l], id[l], front[l] != 0);
                }
                batch.hits |= u64::from(word_bits(&hit) & here) << (LANES * batch.len);
                batch.len += 1;
                if batch.len == SLOTS {
                    let plane = &mut tile.cells[plane_at..plane_end];
                    batch.put(plane);
                }
            }
            for l in 0..LANES {
                for e in 0..5 {
                    row[e][l] += ex[e][l] * 256.0;
                }
            }
        }
        let plane = &mut tile.cells[plane_at..plane_end];
        batch.put(plane);
    }
    left_over
}

/// Slots whose hits are put together.
const SLOTS: usize = 4;

/// Hits of a few slots. How many there are is hard to foresee for a processor: one loop over those of all slots is wrong about its
/// end once, where a loop per slot is for each. What the loop needs of a hit was made in lanes.
#[repr(C, align(64))]
struct Batch<C: Cell> {
    /// Of the plane.
    cells: [[i32; LANES]; SLOTS],
    values: [[C::Packed; LANES]; SLOTS],
    /// Lanes of all slots, bit by bit: those that are hit.
    hits: u64,
    len: usize,
}

impl<C: Cell> Batch<C> {
    #[inline(always)]
    fn new() -> Self {
        Self {
            cells: [[0; LANES]; SLOTS],
            values: [[C::Packed::default(); LANES]; SLOTS],
            hits: 0,
            len: 0,
        }
    }

    #[inline(always)]
    fn put(&mut self, plane: &mut [C]) {
        let (cells, values) = (self.cells.as_flattened(), self.values.as_flattened());
        while self.hits != 0 {
            let k = self.hits.trailing_zeros() as usize & (SLOTS * LANES - 1);
            self.hits &= self.hits - 1;
            plane[cells[k] as usize].put_packed(values[k]);
        }
        self.len = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_are_exact() {
        // A lane's samples reach five pixels beyond the first of its own window.
        let extent = i64::from(MICRO_EXTENT);
        let reach = extent + 5 * 256;
        assert!(2 * extent * reach < 1 << 24);
    }
}
