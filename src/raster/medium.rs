//! Micro-quads of a few to some dozen pixels: lanes are 8 by 2 pixels, both halves at once from five edges in i32. The diagonal's sign is
//! taken once for both halves.

use super::edge::{ScreenVertex, first_pixel, threshold};
use super::samples::sample_positions;
use super::tile::{Cell, Tile};
use crate::simd::{LANES, Lanes};

/// Largest extent, 1/256 pixel. Bound by time, not exactness (edge values stay below 2^30): beyond, computing only the covered
/// runs of a row pays for its divisions.
pub(super) const MEDIUM_EXTENT: i32 = 48 * 256;

/// Pixels of a row among the lanes.
const COLS: usize = 8;

/// Draws the quad with corners `a` (i, j), `b` (i+1, j), `c` (i+1, j+1), `d` (i, j+1), of extent up to [`MEDIUM_EXTENT`] and not
/// folded along its diagonal. `id` is that of half 0.
#[inline(always)]
pub(super) fn quad<C: Cell>(tile: &mut Tile<C>, corners: &[ScreenVertex; 4], id: u32, tie: i32) {
    let [a, b, c, d] = corners;
    let x_low = a.x.min(b.x).min(c.x).min(d.x);
    let x_high = a.x.max(b.x).max(c.x).max(d.x);
    let y_low = a.y.min(b.y).min(c.y).min(d.y);
    let y_high = a.y.max(b.y).max(c.y).max(d.y);
    let (tx, ty) = (tile.x0, tile.y0);
    let edges = [(a, b), (b, c), (d, c), (a, d), (a, c)];
    let dx = edges.map(|(p, q)| q.x - p.x);
    let dy = edges.map(|(p, q)| q.y - p.y);
    let [t_ab, t_bc, t_dc, t_ad, t_ac] = std::array::from_fn(|k| threshold(dx[k], dy[k], tie));
    let area0 = dx[0] * dy[4] - dy[0] * dx[4];
    let area1 = dx[4] * dy[3] - dy[4] * dx[3];
    let front = area0 < 0 || area1 < 0;
    let (za, zb, zc, zd) = (a.depth, b.depth, c.depth, d.depth);
    let inverse0 = 1.0 / area0.unsigned_abs() as f32;
    let inverse1 = 1.0 / area1.unsigned_abs() as f32;

    let mut steps = [Lanes([0; LANES]); 5];
    for k in 0..5 {
        for l in 0..LANES {
            let [x, y] = [l % COLS, l / COLS].map(|n| 256 * n as i32);
            steps[k][l] = dx[k] * y - dy[k] * x;
        }
    }
    for (s, &[ox, oy]) in sample_positions(tile.samples()).iter().enumerate() {
        let px0 = first_pixel(x_low, ox).max(tx);
        let px1 = first_pixel(x_high, ox).min(tx + tile.width);
        let py0 = first_pixel(y_low, oy).max(ty);
        let py1 = first_pixel(y_high, oy).min(ty + tile.height);
        let mut px = px0;
        while px < px1 {
            let (x, y) = (px * 256 + ox, py0 * 256 + oy);
            let mut e: [i32; 5] = std::array::from_fn(|k| {
                let p = edges[k].0;
                dx[k] * (y - p.y) - dy[k] * (x - p.x)
            });
            let across = px1 - px;
            let mut at = tile.plane(s) + (py0 - ty) as usize * tile.stride + (px - tx) as usize;
            for py in (py0..py1).step_by(LANES / COLS) {
                let down = py1 - py;
                let mut depth = Lanes([0.0; LANES]);
                // 0 no hit, 1 half 0, 2 half 1.
                let mut halves = Lanes([0_u32; LANES]);
                for l in 0..LANES {
                    let ab = e[0] + steps[0][l];
                    let bc = e[1] + steps[1][l];
                    let dc = e[2] + steps[2][l];
                    let ad = e[3] + steps[3][l];
                    let ac = e[4] + steps[4][l];
                    let p_ab = ab >= t_ab;
                    let p_dc = dc >= t_dc;
                    let p_ac = ac >= t_ac;
                    let half0 = (p_ab == (bc >= t_bc)) & (p_ab != p_ac);
                    let half1 = (p_dc == (ad >= t_ad)) & (p_dc != p_ac);
                    let live = (((l % COLS) as i32) < across) & (((l / COLS) as i32) < down);
                    let hit = (half0 | half1) & live;
                    halves[l] = if hit { 1 + u32::from(!half0) } else { 0 };
                    let w0 = (if half0 { bc } else { dc }).abs() as f32;
                    let w1 = ac.abs() as f32;
                    let w2 = (if half0 { ab } else { ad }).abs() as f32;
                    let z1 = if half0 { zb } else { zd };
                    let inverse = if half0 { inverse0 } else { inverse1 };
                    depth[l] = ((w0 * za + w1 * z1) + w2 * zc) * inverse;
                }
                let rows = halves.chunks_exact(COLS).zip(depth.chunks_exact(COLS));
                for (row, (halves, depth)) in rows.enumerate().take(down as usize) {
                    let at = at + row * tile.stride;
                    let cells = &mut tile.cells[at..at + COLS];
                    for l in 0..COLS {
                        let half = halves[l];
                        cells[l].put(half != 0, depth[l], id | (half >> 1), front);
                    }
                }
                for k in 0..5 {
                    e[k] += dx[k] * (256 * (LANES / COLS) as i32);
                }
                at += LANES / COLS * tile.stride;
            }
            px += COLS as i32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edge_values_fit() {
        // A vector overruns the box by less than its columns, and by less than its rows.
        let extent = i64::from(MEDIUM_EXTENT);
        let reach = extent + 256 * COLS.max(LANES / COLS) as i64;
        assert!(2 * extent * reach < 1 << 31);
    }
}
