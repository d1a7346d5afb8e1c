//! From a visibility sample back to its place on the micro-quad: weights of the four grid points, perspective-correct. They are
//! computed again from the projected points, so that the samples themselves carry an id only.

use super::draw::SoupVertex;
use super::edge::ScreenVertex;
use super::project::ProjectedBlock;
use super::samples::sample_positions;
use crate::records::{BLOCK_STRIDE, SampleId};

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
