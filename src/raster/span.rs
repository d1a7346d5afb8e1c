//! Triangles of any size, one at a time. Per row the covered run of pixels follows from the three edges by integer division, so the
//! inner loop has no tests: depths and keys only. Edge values are below 2^47 and therefore exact in f64, whose conversion to f32
//! rounds once, as that of an integer does: the same bits as the other paths.

use super::edge::{ScreenVertex, first_pixel, threshold};
use super::samples::sample_positions;
use super::tile::{Cell, Tile};
use crate::simd::LANES;

/// An edge with its sign turned so that the inside is where `e >= threshold`.
#[derive(Clone, Copy)]
struct Side {
    /// Value at the first sample of the window.
    e: i64,
    threshold: i64,
    /// Change from pixel to pixel, and from row to row.
    step_x: i64,
    step_y: i64,
}

/// Draws the triangle `v`. Depths are summed in the order of `v`. `flip`: `v` runs against the orientation that counts for `front`.
#[inline(always)]
pub(super) fn triangle<C: Cell>(
    tile: &mut Tile<C>,
    v: &[ScreenVertex; 3],
    id: u32,
    flip: bool,
    tie: i32,
) {
    let [x_low, x_high] = bounds(v[0].x, v[1].x, v[2].x);
    let [y_low, y_high] = bounds(v[0].y, v[1].y, v[2].y);
    let (tx, ty) = (tile.x0, tile.y0);
    if x_high <= tx * 256
        || y_high <= ty * 256
        || x_low >= (tx + tile.width) * 256
        || y_low >= (ty + tile.height) * 256
    {
        return;
    }
    let cross = |a: &ScreenVertex, b: &ScreenVertex, px: i32, py: i32| {
        i64::from(b.x - a.x) * i64::from(py - a.y) - i64::from(b.y - a.y) * i64::from(px - a.x)
    };
    let area = cross(&v[0], &v[1], v[2].x, v[2].y);
    if area == 0 {
        return;
    }
    let front = (area < 0) != flip;
    let inverse = 1.0 / area.unsigned_abs() as f32;
    let z = [v[0].depth, v[1].depth, v[2].depth];
    for (s, &[ox, oy]) in sample_positions(tile.samples()).iter().enumerate() {
        let px0 = first_pixel(x_low, ox).max(tx);
        let px1 = first_pixel(x_high, ox).min(tx + tile.width);
        let py0 = first_pixel(y_low, oy).max(ty);
        let py1 = first_pixel(y_high, oy).min(ty + tile.height);
        if px0 >= px1 || py0 >= py1 {
            continue;
        }
        let side = |a: &ScreenVertex, b: &ScreenVertex| {
            let (dx, dy) = (b.x - a.x, b.y - a.y);
            let e = cross(a, b, px0 * 256 + ox, py0 * 256 + oy);
            let t = i64::from(threshold(dx, dy, tie));
            let (step_x, step_y) = (i64::from(dy) * -256, i64::from(dx) * 256);
            if area > 0 {
                Side {
                    e,
                    threshold: t,
                    step_x,
                    step_y,
                }
            } else {
                // Inside where e < t, which among integers is -e >= 1 - t.
                Side {
                    e: -e,
                    threshold: 1 - t,
                    step_x: -step_x,
                    step_y: -step_y,
                }
            }
        };
        // In the order of the vertices that they weigh: the edge opposite of each.
        let mut sides = [side(&v[1], &v[2]), side(&v[2], &v[0]), side(&v[0], &v[1])];
        let steps = sides.map(|side| side.step_x as f64);
        let mut at = tile.plane(s) + (py0 - ty) as usize * tile.stride + (px0 - tx) as usize;
        for _ in py0..py1 {
            let (mut from, mut to) = (0_i64, i64::from(px1 - px0));
            for side in &sides {
                let missing = side.threshold - side.e;
                if side.step_x > 0 {
                    if missing > 0 {
                        from = from.max((missing + side.step_x - 1) / side.step_x);
                    }
                } else if missing > 0 {
                    to = 0;
                } else if side.step_x < 0 {
                    to = to.min(missing / side.step_x + 1);
                }
            }
            let mut x = from;
            while x < to {
                let e = sides.map(|side| (side.e + x * side.step_x) as f64);
                let run = &mut tile.cells[at + x as usize..at + x as usize + LANES];
                fill(run, (to - x) as i32, &e, &steps, &z, inverse, id, front);
                x += LANES as i64;
            }
            for side in &mut sides {
                side.e += side.step_y;
            }
            at += tile.stride;
        }
    }
}

/// Depths along a covered run: its next 16 cells, of which `count` are covered. Conversions first and updates last, through local
/// arrays, for each loop to have lanes of one width.
#[inline(always)]
#[expect(
    clippy::too_many_arguments,
    reason = "everything that is constant along the run"
)]
fn fill<C: Cell>(
    run: &mut [C],
    count: i32,
    e: &[f64; 3],
    steps: &[f64; 3],
    z: &[f32; 3],
    inverse: f32,
    id: u32,
    front: bool,
) {
    let mut depth = [0.0_f32; LANES];
    for (l, depth) in depth.iter_mut().enumerate() {
        let l = f64::from(l as i32);
        let w0 = (e[0] + l * steps[0]) as f32;
        let w1 = (e[1] + l * steps[1]) as f32;
        let w2 = (e[2] + l * steps[2]) as f32;
        *depth = ((w0 * z[0] + w1 * z[1]) + w2 * z[2]) * inverse;
    }
    for l in 0..LANES {
        run[l].put((l as i32) < count, depth[l], id, front);
    }
}

#[inline(always)]
fn bounds(a: i32, b: i32, c: i32) -> [i32; 2] {
    [a.min(b).min(c), a.max(b).max(c)]
}
