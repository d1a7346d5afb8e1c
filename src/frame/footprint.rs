//! Footprints of pixels in texture coordinates, by which textures are averaged.

use super::spot::Shape;
use crate::raster::ProjectedBlock;
use crate::records::{BLOCK_STRIDE, BlockSize, Grid3};

/// Per grid point the side of the square in texture coordinates that covers the area of a pixel, from differences along the grid.
pub(super) fn footprints(
    block: &ProjectedBlock,
    uvs: &Grid3,
    shape: Shape<'_>,
    size: BlockSize,
    out: &mut Vec<f32>,
) {
    if let Some(list) = shape.list() {
        return list_footprints(block, uvs, list, size, out);
    }
    out.clear();
    out.resize((size.rows + 1) * BLOCK_STRIDE, 0.0);
    let step = |k: usize, n: usize| match shape {
        Shape::Apart => (k & !1, k | 1),
        Shape::Grid | Shape::List(_) => (k.saturating_sub(1), (k + 1).min(n - 1)),
    };
    for j in 0..size.rows {
        let (j0, j1) = step(j, size.rows);
        for i in 0..size.cols {
            let (i0, i1) = step(i, size.cols);
            // A triangle repeats its last corner: the row beside tells then.
            let is_short =
                block.position(i0, j) == block.position(i1, j) && uvs.get(i0, j) == uvs.get(i1, j);
            let row = if is_short { j0 + j1 - j } else { j };
            let screen = |a: [i32; 2], b: [i32; 2]| {
                [(b[0] - a[0]) as f32 / 256.0, (b[1] - a[1]) as f32 / 256.0]
            };
            let su = screen(block.position(i0, row), block.position(i1, row));
            let sv = screen(block.position(i, j0), block.position(i, j1));
            let uv = |a: [f32; 3], b: [f32; 3]| [b[0] - a[0], b[1] - a[1]];
            let tu = uv(uvs.get(i0, row), uvs.get(i1, row));
            let tv = uv(uvs.get(i, j0), uvs.get(i, j1));
            let pixels = (su[0] * sv[1] - su[1] * sv[0]).abs();
            let texture = (tu[0] * tv[1] - tu[1] * tv[0]).abs();
            // A grid cell seen edge-on has no area: do not let its footprint run away.
            out[j * BLOCK_STRIDE + i] = (texture / pixels.max(1.0 / 256.0)).sqrt();
        }
    }
}

/// The same at the points of a list of triangles: from the areas of those around each.
fn list_footprints(
    block: &ProjectedBlock,
    uvs: &Grid3,
    list: &[[u16; 3]],
    size: BlockSize,
    out: &mut Vec<f32>,
) {
    let count = (size.rows + 1) * BLOCK_STRIDE;
    let mut areas = vec![[0.0_f32; 2]; count];
    for t in list {
        let at = t.map(|k| [usize::from(k) % BLOCK_STRIDE, usize::from(k) / BLOCK_STRIDE]);
        let p = at.map(|[i, j]| block.position(i, j).map(|c| c as f32 / 256.0));
        let uv = at.map(|[i, j]| uvs.get(i, j)).map(|[u, v, _]| [u, v]);
        let area = |p: [[f32; 2]; 3]| {
            let (a, b) = (
                [p[1][0] - p[0][0], p[1][1] - p[0][1]],
                [p[2][0] - p[0][0], p[2][1] - p[0][1]],
            );
            (a[0] * b[1] - a[1] * b[0]).abs()
        };
        let [texture, pixels] = [area(uv), area(p)];
        for &k in t {
            areas[usize::from(k)][0] += texture;
            areas[usize::from(k)][1] += pixels;
        }
    }
    out.clear();
    let side = |[texture, pixels]: [f32; 2]| (texture / pixels.max(1.0 / 256.0)).sqrt();
    out.extend(areas.into_iter().map(side));
}
