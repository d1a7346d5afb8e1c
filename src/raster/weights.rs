//! From a visibility sample back to its place on the micro-quad: weights of the four grid points, perspective-correct. They are
//! computed again from the projected points, so that the samples themselves carry an id only.

use super::draw::SoupVertex;
use super::edge::ScreenVertex;
use super::project::ProjectedBlock;
use super::samples::sample_positions;
use crate::records::{BLOCK_STRIDE, Grid3, SampleId};
use crate::simd::LANES;

/// Weights of the grid points (i, j), (i+1, j), (i+1, j+1) and (i, j+1) at a sample that shows `id`, a micro-quad of `block`. They
/// are not negative and sum to 1 but for rounding; the corner off the sample's half has weight 0. `x` and `y` are the pixel on the
/// screen (not in the tile).
#[must_use]
#[inline]
pub fn barycentrics(
    block: &ProjectedBlock,
    id: SampleId,
    x: u32,
    y: u32,
    sample: u32,
    samples: u32,
) -> [f32; 4] {
    let k = id.row() as usize * BLOCK_STRIDE + id.col() as usize;
    let off = if id.half() == 0 {
        k + 1
    } else {
        k + BLOCK_STRIDE
    };
    let corners = [k, off, k + BLOCK_STRIDE + 1];
    let w = list_weights(block, corners, x, y, sample, samples);
    if id.half() == 0 {
        [w[0], w[1], w[2], 0.0]
    } else {
        [w[0], 0.0, w[2], w[1]]
    }
}

/// Samples of one block, in lanes: the corners of their micro-triangles with their weights, and the side that is seen.
#[derive(Clone, Copy, Debug)]
pub struct SampleLanes {
    ids: [u32; LANES],
    weights: [[f32; LANES]; 3],
    /// 1 where the front is seen, -1 where the back is, 0 where the triangle is so thin that snapping may have turned it over.
    pub side: [f32; LANES],
}

/// Where the corners of a sample's micro-triangle stand in the block's arrays, in the order in which they are added up: the one off
/// the diagonal stands in the middle, and of the other two the one first that is in its row, as in
/// `(w0 a0 + w1 a1) + (w2 a2 + w3 a3)` where one term is missing.
#[inline(always)]
fn corners(id: u32) -> [usize; 3] {
    let (row, col) = ((id >> 6 & 31) as usize, (id >> 1 & 31) as usize);
    let second = (id & 1) as usize;
    let first = second ^ 1;
    let at = |row: usize, col: usize| row * BLOCK_STRIDE + col;
    [
        at(row + second, col + second),
        at(row + second, col + first),
        at(row + first, col + first),
    ]
}

impl SampleLanes {
    /// Samples of a block that is not clipped: [`barycentrics`] for sixteen of them, to the same bits. `x` and `y` are their
    /// positions on the screen, 1/256 pixel. Edge values are products and differences of integers below 2^47, which f64 holds.
    #[must_use]
    #[inline(always)]
    pub fn new(
        block: &ProjectedBlock,
        ids: &[u32; LANES],
        x: &[i32; LANES],
        y: &[i32; LANES],
    ) -> Self {
        let mut px = [[0_i32; LANES]; 3];
        let mut py = [[0_i32; LANES]; 3];
        let mut depth = [[0.0_f32; LANES]; 3];
        for l in 0..LANES {
            for (c, k) in corners(ids[l]).into_iter().enumerate() {
                px[c][l] = block.x[k];
                py[c][l] = block.y[k];
                depth[c][l] = block.depth[k];
            }
        }
        let mut weights = [[0.0_f32; LANES]; 3];
        let mut side = [0.0_f32; LANES];
        let ortho = block.ortho;
        for l in 0..LANES {
            let at = |c: usize| {
                let (dx, dy) = (x[l] - px[c][l], y[l] - py[c][l]);
                (f64::from(dx), f64::from(dy))
            };
            // Corners as the sample sees them: edge values are cross products of these.
            let (a, m, b) = (at(0), at(1), at(2));
            let cross = |p: (f64, f64), q: (f64, f64)| p.0 * q.1 - p.1 * q.0;
            let e = [cross(m, b), cross(b, a), cross(a, m)];
            // Twice the area. Snapping moves it by less than the size of two sides.
            let area = (e[0] + e[1]) + e[2];
            let size = |p: (f64, f64)| (p.0 - a.0).abs() + (p.1 - a.1).abs();
            let thin = area.abs() <= size(m) + size(b) + 2.0;
            let sign = if area < 0.0 { 1.0 } else { -1.0 };
            side[l] = if thin { 0.0 } else { sign };
            let mut w = [0.0_f32; 3];
            for c in 0..3 {
                w[c] = e[c].abs() as f32;
                w[c] = if ortho { w[c] } else { w[c] * depth[c][l] };
            }
            let second = ids[l] & 1 != 0;
            let (first, last) = if second { (w[2], w[0]) } else { (w[0], w[2]) };
            let sum = (first + w[1]) + last;
            let good = (sum > 0.0) & (sum <= f32::MAX);
            let inverse = 1.0 / if good { sum } else { 1.0 };
            let corner = |is: bool| if is { 1.0 } else { 0.0 };
            weights[0][l] = if good {
                w[0] * inverse
            } else {
                corner(!second)
            };
            weights[1][l] = if good { w[1] * inverse } else { 0.0 };
            weights[2][l] = if good { w[2] * inverse } else { corner(second) };
        }
        Self {
            ids: *ids,
            weights,
            side,
        }
    }

    /// The components of a block's grid at the samples.
    #[must_use]
    #[inline(always)]
    pub fn interpolate(&self, grid: &Grid3) -> [[f32; LANES]; 3] {
        let mut corner = [[[0.0_f32; LANES]; 3]; 3];
        for l in 0..LANES {
            for (c, k) in corners(self.ids[l]).into_iter().enumerate() {
                corner[0][c][l] = grid.x[k];
                corner[1][c][l] = grid.y[k];
                corner[2][c][l] = grid.z[k];
            }
        }
        let mut out = [[0.0; LANES]; 3];
        for i in 0..3 {
            for l in 0..LANES {
                let w = |c: usize| self.weights[c][l] * corner[i][c][l];
                out[i][l] = (w(0) + w(1)) + w(2);
            }
        }
        out
    }
}

/// Weights of three points of a block, by their indices in it, at a sample that their triangle covers.
#[must_use]
#[inline]
pub fn list_weights(
    block: &ProjectedBlock,
    corners: [usize; 3],
    x: u32,
    y: u32,
    sample: u32,
    samples: u32,
) -> [f32; 3] {
    let at = sample_at(x, y, sample, samples);
    if block.clip && corners.iter().any(|&k| block.outside[k] != 0) {
        homogeneous(corners.map(|k| [block.hx[k], block.hy[k], block.hw[k]]), at)
    } else {
        on_screen(corners.map(|k| block.vertex(k)), at, block.ortho)
    }
}

/// Weights of the three vertices of a triangle of a soup at a sample that it covers.
#[must_use]
pub fn triangle_weights(
    vertices: &[SoupVertex; 3],
    ortho: bool,
    x: u32,
    y: u32,
    sample: u32,
    samples: u32,
) -> [f32; 3] {
    let at = sample_at(x, y, sample, samples);
    match vertices.map(|v| v.screen()) {
        [Some(a), Some(b), Some(c)] => on_screen([a, b, c], at, ortho),
        _ => homogeneous(vertices.map(|v| [0, 1, 2].map(|k| v.homogeneous()[k])), at),
    }
}

#[inline]
fn sample_at(x: u32, y: u32, sample: u32, samples: u32) -> [i32; 2] {
    let [ox, oy] = sample_positions(samples)[sample as usize];
    [x as i32 * 256 + ox, y as i32 * 256 + oy]
}

/// From the exact edge values of the snapped triangle, each times the depth of the vertex that it weighs (which is 1/W).
#[inline]
fn on_screen(v: [ScreenVertex; 3], at: [i32; 2], ortho: bool) -> [f32; 3] {
    let edge = |a: &ScreenVertex, b: &ScreenVertex| {
        i64::from(b.x - a.x) * i64::from(at[1] - a.y)
            - i64::from(b.y - a.y) * i64::from(at[0] - a.x)
    };
    let e = [edge(&v[1], &v[2]), edge(&v[2], &v[0]), edge(&v[0], &v[1])];
    let mut w = e.map(|e| e.abs() as f32);
    if !ortho {
        for k in 0..3 {
            w[k] *= v[k].depth;
        }
    }
    normalised(w)
}

/// From X, Y, W before division: the determinant of the sample's ray with each edge. Right for triangles that reach behind the eye,
/// too; f64, because those have no bound on their size.
fn homogeneous(v: [[f32; 3]; 3], at: [i32; 2]) -> [f32; 3] {
    let v = v.map(|p| p.map(f64::from));
    let (x, y) = (f64::from(at[0]), f64::from(at[1]));
    let det = |p: &[f64; 3], q: &[f64; 3]| {
        (x * (p[1] * q[2] - p[2] * q[1]) + y * (p[2] * q[0] - p[0] * q[2]))
            + (p[0] * q[1] - p[1] * q[0])
    };
    let w = [det(&v[1], &v[2]), det(&v[2], &v[0]), det(&v[0], &v[1])];
    let sum = (w[0] + w[1]) + w[2];
    // Snapping may put a sample just outside of the triangle before snapping.
    normalised(w.map(|w| (w / sum).max(0.0) as f32))
}

#[inline]
fn normalised(w: [f32; 3]) -> [f32; 3] {
    let sum = (w[0] + w[1]) + w[2];
    if sum > 0.0 && sum.is_finite() {
        let inverse = 1.0 / sum;
        w.map(|w| w * inverse)
    } else {
        [1.0, 0.0, 0.0]
    }
}

#[cfg(test)]
mod tests {
    use super::super::project::project;
    use super::*;
    use crate::records::{BlockSize, Projection};
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
            let (mut fronts, mut lanes) = (0, 0);
            for k in 0..64_u32 {
                let ids: [u32; LANES] =
                    std::array::from_fn(|l| SampleId::new(3, k % 8, k / 8, l as u32 & 1).0);
                // Any place serves: weights come from sizes of edge values.
                let x: [i32; LANES] = std::array::from_fn(|l| (k as i32 * 7 + l as i32) % 64);
                let y: [i32; LANES] = std::array::from_fn(|l| (k as i32 * 5 + 3 * l as i32) % 64);
                let at = SampleLanes::new(
                    &block,
                    &ids,
                    &x.map(|x| x * 256 + 128),
                    &y.map(|y| y * 256 + 128),
                );
                let z = at.interpolate(&grid)[2];
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
