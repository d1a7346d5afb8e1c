//! Samples of a block in lanes: what [`barycentrics`](super::barycentrics) and a mix over the corners' normals give one by one, for
//! sixteen at a time and to the same bits.
//!
//! Lanes fetch the corners of their micro-triangles from anywhere in the block, and a fetch costs the same for 4 bytes as for 8. So
//! components stand in pairs here, and a corner takes three fetches where it would take six.

use super::project::ProjectedBlock;
use crate::dispatch;
use crate::records::{BLOCK_LEN, BLOCK_STRIDE, Grid3};
use crate::simd::{LANES, Level, bits, fetch_pairs, flag};
use std::hint::select_unpredictable;
use std::ops::Range;

/// Length of the arrays: a power of two, for a mask to keep every place inside.
const PLACES: usize = BLOCK_LEN.next_power_of_two();

/// A projected block with its normals, two components to a word.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct PairedBlock {
    /// Screen x below, y above.
    position: [u64; PLACES],
    /// Bits of the depth below, of the normal's z above.
    depth_z: [u64; PLACES],
    /// Bits of the normal's x below, of its y above.
    normal: [u64; PLACES],
    ortho: bool,
}

#[inline(always)]
fn pair(low: u32, high: u32) -> u64 {
    u64::from(low) | u64::from(high) << 32
}

impl PairedBlock {
    /// An empty one, on the heap (48 KB, of which blocks of 33 by 33 points touch 38).
    #[must_use]
    pub fn boxed() -> Box<Self> {
        Box::new(Self {
            position: [0; PLACES],
            depth_z: [0; PLACES],
            normal: [0; PLACES],
            ortho: false,
        })
    }

    /// Takes over some rows of points of a block that is not clipped, and their normals.
    pub fn fill(
        &mut self,
        level: Level,
        block: &ProjectedBlock,
        normals: &Grid3,
        rows: Range<usize>,
    ) {
        self.ortho = block.ortho;
        dispatch!(level, self.fill_rows(block, normals, rows));
    }

    #[inline(always)]
    fn fill_rows(&mut self, block: &ProjectedBlock, normals: &Grid3, rows: Range<usize>) {
        // Small blocks stand at the start of few rows.
        for j in rows {
            for i in (0..block.size.cols).step_by(LANES) {
                let range = j * BLOCK_STRIDE + i..j * BLOCK_STRIDE + i + LANES;
                let (x, y) = (&block.x[range.clone()], &block.y[range.clone()]);
                let depth = &block.depth[range.clone()];
                let (nx, ny) = (&normals.x[range.clone()], &normals.y[range.clone()]);
                let nz = &normals.z[range.clone()];
                let position = &mut self.position[range.clone()];
                let depth_z = &mut self.depth_z[range.clone()];
                let normal = &mut self.normal[range];
                for l in 0..LANES {
                    position[l] = pair(x[l] as u32, y[l] as u32);
                    depth_z[l] = pair(depth[l].to_bits(), nz[l].to_bits());
                    normal[l] = pair(nx[l].to_bits(), ny[l].to_bits());
                }
            }
        }
    }
}

/// Where the corners of a sample's micro-triangle stand in the block's arrays, in the order in which they are added up: the one off
/// the diagonal stands in the middle, and of the other two the one first that is in its row, as in
/// `(w0 a0 + w1 a1) + (w2 a2 + w3 a3)` where one term is missing.
#[inline(always)]
fn corners(id: u32) -> [u32; 3] {
    let (row, col) = (id >> 6 & 31, id >> 1 & 31);
    let second = id & 1;
    let first = second ^ 1;
    let at = |row: u32, col: u32| row * BLOCK_STRIDE as u32 + col;
    [
        at(row + second, col + second),
        at(row + second, col + first),
        at(row + first, col + first),
    ]
}

/// [`corners`] of sixteen samples.
#[inline(always)]
fn corner_lanes(ids: &[u32; LANES]) -> [[u32; LANES]; 3] {
    let mut at = [[0; LANES]; 3];
    for l in 0..LANES {
        let corners = corners(ids[l]);
        for c in 0..3 {
            at[c][l] = corners[c];
        }
    }
    at
}

/// What stands at the corners of the micro-triangles of sixteen samples, in the corners' order.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub struct CornerLanes {
    position: [[[u32; LANES]; 2]; 3],
    depth_z: [[[u32; LANES]; 2]; 3],
    normal: [[[u32; LANES]; 2]; 3],
}

impl CornerLanes {
    /// Fetches the corners of samples by their ids, in the block that they are of.
    #[inline(always)]
    pub fn fetch(&mut self, block: &PairedBlock, ids: &[u32; LANES]) {
        let mut other = [0; LANES];
        for l in 0..LANES {
            other[l] = flag(ids[l] != ids[0]);
        }
        if bits(&other) == 0 {
            return self.fetch_one(block, ids[0]);
        }
        let at = corner_lanes(ids);
        for c in 0..3 {
            fetch_pairs(&block.position, &at[c], &mut self.position[c]);
            fetch_pairs(&block.depth_z, &at[c], &mut self.depth_z[c]);
            fetch_pairs(&block.normal, &at[c], &mut self.normal[c]);
        }
    }

    /// The same where all samples are of one micro-triangle.
    #[inline(always)]
    fn fetch_one(&mut self, block: &PairedBlock, id: u32) {
        for (c, at) in corners(id).into_iter().enumerate() {
            let parts = [
                (&block.position, &mut self.position[c]),
                (&block.depth_z, &mut self.depth_z[c]),
                (&block.normal, &mut self.normal[c]),
            ];
            for (table, [low, high]) in parts {
                let word = table[at as usize & (PLACES - 1)];
                *low = [word as u32; LANES];
                *high = [(word >> 32) as u32; LANES];
            }
        }
    }
}

/// Samples of one block: the corners of their micro-triangles with their weights, and the side that is seen.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct SampleLanes {
    ids: [u32; LANES],
    weights: [[f32; LANES]; 3],
    /// The normals of the block at the samples, of any length.
    pub normals: [[f32; LANES]; 3],
    /// 1 where the front is seen, -1 where the back is, 0 where the triangle is so thin that snapping may have turned it over.
    pub side: [f32; LANES],
}

/// Largest distance in either direction, 1/256 pixel, between a sample and the corners of its micro-triangle for which edge values,
/// the area and the size of two sides are below 2^24: floats hold them.
const NEAR: i32 = 6 * 256;

/// Sizes of edge values, and sides, from where the corners stand as the sample sees them.
macro_rules! edges {
    ($float:ty, $dx:expr, $dy:expr, $edges:expr, $side:expr) => {
        for l in 0..LANES {
            let at = |c: usize| ($dx[c][l] as $float, $dy[c][l] as $float);
            let (a, m, b) = (at(0), at(1), at(2));
            let cross = |p: ($float, $float), q: ($float, $float)| p.0 * q.1 - p.1 * q.0;
            let e = [cross(m, b), cross(b, a), cross(a, m)];
            // Twice the area. Snapping moves it by less than the size of two sides.
            let area = (e[0] + e[1]) + e[2];
            let size = |p: ($float, $float)| (p.0 - a.0).abs() + (p.1 - a.1).abs();
            let thin = area.abs() <= size(m) + size(b) + 2.0;
            let sign = if area < 0.0 { 1.0 } else { -1.0 };
            $side[l] = if thin { 0.0 } else { sign };
            for c in 0..3 {
                $edges[c][l] = e[c].abs() as f32;
            }
        }
    };
}

impl SampleLanes {
    /// Samples by their ids, with their corners in the block that they are of. `x` and `y` are their positions on the screen, 1/256 pixel.
    /// Edge values are products and differences of integers below 2^47: f64 holds them, and f32 where all corners are near.
    #[must_use]
    #[inline(always)]
    pub fn new(
        block: &PairedBlock,
        corners: &CornerLanes,
        ids: &[u32; LANES],
        x: &[i32; LANES],
        y: &[i32; LANES],
    ) -> Self {
        let mut dx = [[0_i32; LANES]; 3];
        let mut dy = [[0_i32; LANES]; 3];
        let mut depth = [[0.0_f32; LANES]; 3];
        for c in 0..3 {
            let [px, py] = &corners.position[c];
            let [d, _] = &corners.depth_z[c];
            for l in 0..LANES {
                dx[c][l] = x[l] - px[l] as i32;
                dy[c][l] = y[l] - py[l] as i32;
                depth[c][l] = f32::from_bits(d[l]);
            }
        }
        let mut far = [0; LANES];
        for l in 0..LANES {
            let of = |c: usize| dx[c][l].abs().max(dy[c][l].abs());
            far[l] = flag(of(0).max(of(1)).max(of(2)) > NEAR);
        }
        let mut edges = [[0.0_f32; LANES]; 3];
        let mut side = [0.0_f32; LANES];
        if bits(&far) == 0 {
            edges!(f32, dx, dy, edges, side);
        } else {
            edges!(f64, dx, dy, edges, side);
        }
        let mut weights = [[0.0_f32; LANES]; 3];
        let ortho = block.ortho;
        for l in 0..LANES {
            let mut w = [0.0_f32; 3];
            for c in 0..3 {
                let e = edges[c][l];
                w[c] = if ortho { e } else { e * depth[c][l] };
            }
            let second = ids[l] & 1 != 0;
            let (first, last) = if second { (w[2], w[0]) } else { (w[0], w[2]) };
            let sum = (first + w[1]) + last;
            let good = (sum > 0.0) & (sum <= f32::MAX);
            let inverse = 1.0 / select_unpredictable(good, sum, 1.0);
            // As `if` these would be stores under a mask.
            let corner = |is: bool| select_unpredictable(is, 1.0, 0.0);
            weights[0][l] = select_unpredictable(good, w[0] * inverse, corner(!second));
            weights[1][l] = select_unpredictable(good, w[1] * inverse, 0.0);
            weights[2][l] = select_unpredictable(good, w[2] * inverse, corner(second));
        }
        let mut normals = [[0.0; LANES]; 3];
        for i in 0..3 {
            let of = |c: usize| match i {
                0 => &corners.normal[c][0],
                1 => &corners.normal[c][1],
                _ => &corners.depth_z[c][1],
            };
            normals[i] = mix(&weights, [of(0), of(1), of(2)], |bits| {
                f32::from_bits(*bits)
            });
        }
        Self {
            ids: *ids,
            weights,
            normals,
            side,
        }
    }

    /// The components of a grid of the block at the samples.
    #[must_use]
    #[inline(always)]
    pub fn interpolate(&self, grid: &Grid3) -> [[f32; LANES]; 3] {
        let at = corner_lanes(&self.ids);
        let mut out = [[0.0; LANES]; 3];
        for (out, values) in out.iter_mut().zip([&grid.x, &grid.y, &grid.z]) {
            let mut corner = [[0.0_f32; LANES]; 3];
            for c in 0..3 {
                for l in 0..LANES {
                    corner[c][l] = values[(at[c][l] as usize).min(BLOCK_LEN - 1)];
                }
            }
            let [a, b, c] = &corner;
            *out = mix(&self.weights, [a, b, c], |value| *value);
        }
        out
    }
}

#[inline(always)]
fn mix<T>(
    weights: &[[f32; LANES]; 3],
    corner: [&[T; LANES]; 3],
    value: impl Fn(&T) -> f32,
) -> [f32; LANES] {
    let mut out = [0.0; LANES];
    for l in 0..LANES {
        let w = |c: usize| weights[c][l] * value(&corner[c][l]);
        out[l] = (w(0) + w(1)) + w(2);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::project::project;
    use super::super::weights::barycentrics;
    use super::*;
    use crate::records::{BlockSize, Projection, SampleId};
    use crate::simd::Level;

    #[test]
    fn lanes_have_the_bits_of_single_samples() {
        let mut grid = Grid3::boxed();
        let mut state = 1_u32;
        let mut random = move || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        for j in 0..9 {
            for i in 0..9 {
                let p = [
                    i as f32 + 0.7 * random(),
                    j as f32 + 0.7 * random(),
                    8.0 + random(),
                ];
                grid.set(i, j, p);
            }
        }
        let size = BlockSize { cols: 9, rows: 9 };
        for ortho in [false, true] {
            let projection = Projection {
                x: [2048.0, 0.0, 0.0, 0.0],
                y: [0.0, -2048.0, 16384.0, 0.0],
                w: if ortho {
                    [0.0, 0.0, 0.0, 1.0]
                } else {
                    [0.0, 0.0, 1.0, 0.0]
                },
                d: [0.0, 0.0, -0.1, 2.0],
                near: 0.1,
                ortho,
            };
            let mut block = ProjectedBlock::boxed();
            project(Level::SCALAR, &grid, size, &projection, &mut block);
            assert!(!block.is_clipped());
            let mut paired = PairedBlock::boxed();
            paired.fill(Level::SCALAR, &block, &grid, 0..size.rows);
            let (mut fronts, mut lanes) = (0, 0);
            for k in 0..64_u32 {
                let ids: [u32; LANES] =
                    std::array::from_fn(|l| SampleId::new(3, k % 8, k / 8, l as u32 & 1).0);
                // Any place serves: weights come from sizes of edge values.
                let x: [i32; LANES] = std::array::from_fn(|l| (k as i32 * 7 + l as i32) % 64);
                let y: [i32; LANES] = std::array::from_fn(|l| (k as i32 * 5 + 3 * l as i32) % 64);
                let mut corners = CornerLanes::default();
                corners.fetch(&paired, &ids);
                let at = SampleLanes::new(
                    &paired,
                    &corners,
                    &ids,
                    &x.map(|x| x * 256 + 128),
                    &y.map(|y| y * 256 + 128),
                );
                let z = at.interpolate(&grid)[2];
                assert_eq!(z, at.normals[2]);
                for l in 0..LANES {
                    let id = SampleId(ids[l]);
                    let w = barycentrics(&block, id, x[l] as u32, y[l] as u32, 0, 1);
                    let k = id.row() as usize * BLOCK_STRIDE + id.col() as usize;
                    let a = &grid.z[k..];
                    let want = (w[0] * a[0] + w[1] * a[1])
                        + (w[2] * a[BLOCK_STRIDE + 1] + w[3] * a[BLOCK_STRIDE]);
                    assert_eq!(z[l].to_bits(), want.to_bits());
                    fronts += i32::from(at.side[l] > 0.0);
                    lanes += 1;
                }
            }
            // Rows go up on the screen, so most of the sheet is seen counter-clockwise.
            assert!(fronts > lanes / 2, "{fronts} of {lanes}");
        }
    }
}
