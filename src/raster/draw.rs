//! Drawing of blocks and of plain triangles: chooses the path of each micro-quad. The choice is one of speed only: coverage comes
//! from the same exact integers, and depth from the same formula in the same order, in all of them.
//!
//! Depth in a triangle `(v0, v1, v2)` is `((w0*z0 + w1*z1) + w2*z2) * (1/area)`, where `wk` is the size of the edge value opposite of
//! `vk`, rounded to f32. No term is negative, so nothing cancels. The vertices are in the order (i, j), the corner off the diagonal,
//! (i+1, j+1).

use super::clip::{ClipVertex, clip};
use super::edge::{Fault, ScreenVertex};
use super::project::{GUARD_BAND, ProjectedBlock, dot, snap};
use super::tile::{Cell, Tile};
use super::{medium, micro, span};
use crate::dispatch;
use crate::records::{BLOCK_STRIDE, Projection, SampleId};
use crate::simd::{LANES, Level};

/// The ways to draw a micro-quad.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[doc(hidden)]
pub enum Path {
    /// By size.
    #[default]
    Auto,
    /// Without vectors across quads: medium or span.
    Medium,
    /// As two triangles each.
    Span,
}

/// Draws the micro-quads of a block that touch the tile, with ids of the given `rank`.
pub fn draw_block<C: Cell>(level: Level, tile: &mut Tile<C>, block: &ProjectedBlock, rank: u32) {
    draw_block_with(level, tile, block, rank, Path::Auto, Fault::None);
}

/// [`draw_block`] with a path forced or a rule broken, for tests.
#[doc(hidden)]
pub fn draw_block_with<C: Cell>(
    level: Level,
    tile: &mut Tile<C>,
    block: &ProjectedBlock,
    rank: u32,
    path: Path,
    fault: Fault,
) {
    debug_assert!(rank < SampleId::MAX_BLOCKS);
    if !touches(tile, block) {
        return;
    }
    let tie = fault.tie();
    dispatch!(level, block_kernel::<C>(tile, block, rank, 1, path, tie));
}

/// Draws every second micro-quad of a block in both directions, from the first on.
pub fn draw_apart<C: Cell>(level: Level, tile: &mut Tile<C>, block: &ProjectedBlock, rank: u32) {
    draw_apart_with(level, tile, block, rank, Fault::None);
}

/// [`draw_apart`] with a rule broken, for tests.
#[doc(hidden)]
pub fn draw_apart_with<C: Cell>(
    level: Level,
    tile: &mut Tile<C>,
    block: &ProjectedBlock,
    rank: u32,
    fault: Fault,
) {
    debug_assert!(rank < SampleId::MAX_BLOCKS);
    if touches(tile, block) {
        let tie = fault.tie();
        dispatch!(
            level,
            block_kernel::<C>(tile, block, rank, 2, Path::Auto, tie)
        );
    }
}

/// Whether anything of a block may be in the tile.
fn touches<C: Cell>(tile: &Tile<C>, block: &ProjectedBlock) -> bool {
    let [low, high] = block.bounds();
    let (left, top) = (tile.x0 * 256, tile.y0 * 256);
    let (right, bottom) = (left + tile.width * 256, top + tile.height * 256);
    high[0] >= left && high[1] >= top && low[0] < right && low[1] < bottom
}

#[inline(always)]
fn block_kernel<C: Cell>(
    tile: &mut Tile<C>,
    block: &ProjectedBlock,
    rank: u32,
    step: usize,
    path: Path,
    tie: i32,
) {
    let size = block.size;
    let chosen = if step == 2 { 0x5555 } else { u32::MAX };
    for j in (0..size.rows - 1).step_by(step) {
        for i0 in (0..size.cols - 1).step_by(LANES) {
            let lanes = (size.cols - 1 - i0).min(LANES);
            let all = ((1_u32 << lanes) - 1) & chosen;
            let id = SampleId::new(rank, i0 as u32, j as u32, 0).0;
            let clipped = if block.clip {
                clipped_lanes(block, i0, j) & all
            } else {
                0
            };
            let chunk = micro::Chunk {
                i0,
                j,
                live: all & !clipped,
                id,
                refuse: path != Path::Auto,
            };
            let mut left = micro::chunk(tile, block, chunk, tie);
            while left != 0 {
                let l = left.trailing_zeros();
                left &= left - 1;
                let k = j * BLOCK_STRIDE + i0 + l as usize;
                quad(tile, block, k, id + 2 * l, path, tie);
            }
            if clipped != 0 {
                clipped_quads(tile, block, clipped, i0, j, id, tie);
            }
        }
    }
}

/// Draws a list of triangles over the points of a block, by their indices in it; triangle `k` has the id `rank << 11 | k`.
///
/// # Panics
/// There are more than 2048, or one refers to a point beyond the block's arrays.
pub fn draw_list<C: Cell>(
    level: Level,
    tile: &mut Tile<C>,
    block: &ProjectedBlock,
    triangles: &[[u16; 3]],
    rank: u32,
) {
    draw_list_with(level, tile, block, triangles, rank, Fault::None);
}

/// [`draw_list`] with a rule broken, for tests.
#[doc(hidden)]
pub fn draw_list_with<C: Cell>(
    level: Level,
    tile: &mut Tile<C>,
    block: &ProjectedBlock,
    triangles: &[[u16; 3]],
    rank: u32,
    fault: Fault,
) {
    assert!(triangles.len() <= LIST, "{} triangles", triangles.len());
    if !touches(tile, block) {
        return;
    }
    let tie = fault.tie();
    dispatch!(level, list_kernel::<C>(tile, block, triangles, rank, tie));
}

/// Most triangles of a list.
const LIST: usize = 2048;

#[inline(always)]
fn list_kernel<C: Cell>(
    tile: &mut Tile<C>,
    block: &ProjectedBlock,
    triangles: &[[u16; 3]],
    rank: u32,
    tie: i32,
) {
    for (id, t) in (rank << 11..).zip(triangles) {
        let at = t.map(usize::from);
        if block.clip && at.iter().any(|&k| block.outside[k] != 0) {
            let triangle = at.map(|k| block_vertex(block, k));
            fan(tile, &triangle, id, false, block.near, block.ortho, tie);
        } else {
            span::triangle(tile, &at.map(|k| block.vertex(k)), id, false, tie);
        }
    }
}

/// A point of a clipped block.
fn block_vertex(block: &ProjectedBlock, k: usize) -> ClipVertex {
    let h = [block.hx[k], block.hy[k], block.hw[k], block.hd[k]];
    clip_vertex(h, (block.outside[k] == 0).then(|| block.vertex(k)))
}

/// Corners (i, j), (i+1, j), (i+1, j+1), (i, j+1) of the micro-quad at index `k`.
const CORNERS: [usize; 4] = [0, 1, BLOCK_STRIDE + 1, BLOCK_STRIDE];

/// Vertices of the halves, as corners in the order of the depth formula; half 1 runs backwards.
const HALVES: [[usize; 3]; 2] = [[0, 1, 2], [0, 3, 2]];

#[inline(always)]
fn quad<C: Cell>(
    tile: &mut Tile<C>,
    block: &ProjectedBlock,
    k: usize,
    id: u32,
    path: Path,
    tie: i32,
) {
    let v = CORNERS.map(|c| block.vertex(k + c));
    let extent = |c: [i32; 4]| c.iter().max().unwrap_or(&0) - c.iter().min().unwrap_or(&0);
    let fits = extent(v.map(|v| v.x)).max(extent(v.map(|v| v.y))) <= medium::MEDIUM_EXTENT;
    if fits && path != Path::Span && !is_folded(&v) {
        medium::quad(tile, &v, id, tie);
        return;
    }
    for (half, corners) in HALVES.iter().enumerate() {
        let triangle = corners.map(|c| v[c]);
        span::triangle(tile, &triangle, id | half as u32, half == 1, tie);
    }
}

/// The halves are seen from different sides, so that both may cover a sample.
#[inline(always)]
fn is_folded(v: &[ScreenVertex; 4]) -> bool {
    let [a, b, c, d] = v;
    let cross = |p: &ScreenVertex, q: &ScreenVertex| {
        i64::from(p.x - a.x) * i64::from(q.y - a.y) - i64::from(p.y - a.y) * i64::from(q.x - a.x)
    };
    cross(b, c).signum() * cross(c, d).signum() < 0
}

/// Lanes of a chunk with a corner outside.
fn clipped_lanes(block: &ProjectedBlock, i0: usize, j: usize) -> u32 {
    let k = j * BLOCK_STRIDE + i0;
    let mut lanes = 0;
    for l in 0..LANES {
        let outside = CORNERS.iter().any(|c| block.outside[k + l + c] != 0);
        lanes |= u32::from(outside) << l;
    }
    lanes
}

fn clipped_quads<C: Cell>(
    tile: &mut Tile<C>,
    block: &ProjectedBlock,
    mut lanes: u32,
    i0: usize,
    j: usize,
    id: u32,
    tie: i32,
) {
    while lanes != 0 {
        let l = lanes.trailing_zeros();
        lanes &= lanes - 1;
        let k = j * BLOCK_STRIDE + i0 + l as usize;
        for (half, corners) in HALVES.iter().enumerate() {
            let triangle = corners.map(|c| block_vertex(block, k + CORNERS[c]));
            let id = id + 2 * l + half as u32;
            fan(tile, &triangle, id, half == 1, block.near, block.ortho, tie);
        }
    }
}

fn clip_vertex(h: [f32; 4], snapped: Option<ScreenVertex>) -> ClipVertex {
    ClipVertex {
        h: h.map(f64::from),
        snapped,
    }
}

/// Clips a triangle and draws what is left as a fan, all with one id.
fn fan<C: Cell>(
    tile: &mut Tile<C>,
    triangle: &[ClipVertex; 3],
    id: u32,
    flip: bool,
    near: f32,
    ortho: bool,
    tie: i32,
) {
    let polygon = clip(triangle, near, ortho);
    if let [first, rest @ ..] = polygon.vertices() {
        for pair in rest.windows(2) {
            span::triangle(tile, &[*first, pair[0], pair[1]], id, flip, tie);
        }
    }
}

/// A vertex of a polygon soup on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoupVertex {
    screen: ScreenVertex,
    outside: bool,
    h: [f32; 4],
}

impl SoupVertex {
    /// Screen position, 1/256 pixel; meaningless if clipped.
    #[must_use]
    pub fn position(&self) -> [i32; 2] {
        [self.screen.x, self.screen.y]
    }

    /// A vertex at a given place of the screen, for tests.
    #[doc(hidden)]
    #[must_use]
    pub fn at(x: i32, y: i32, depth: f32) -> Self {
        debug_assert!(x.abs() < GUARD_BAND && y.abs() < GUARD_BAND);
        Self {
            screen: ScreenVertex { x, y, depth },
            outside: false,
            h: [0.0; 4],
        }
    }

    #[inline]
    pub(super) fn homogeneous(&self) -> [f32; 4] {
        self.h
    }
    #[inline]
    pub(super) fn screen(&self) -> Option<ScreenVertex> {
        (!self.outside).then_some(self.screen)
    }
}

/// Projects the vertices of a polygon soup, by the same operations as [`project`](super::project()).
#[must_use]
pub fn project_vertices(points: &[[f32; 3]], p: &Projection) -> Vec<SoupVertex> {
    let project = |&[x, y, z]: &[f32; 3]| {
        let w = if p.ortho { 1.0 } else { dot(&p.w, x, y, z) };
        let d = if p.ortho { dot(&p.d, x, y, z) } else { 0.0 };
        let h = [dot(&p.x, x, y, z), dot(&p.y, x, y, z), w, d];
        let (x, y, depth, inside) = if p.ortho {
            snap::<true>(h[0], h[1], h[2], h[3], p.near)
        } else {
            snap::<false>(h[0], h[1], h[2], h[3], p.near)
        };
        SoupVertex {
            screen: ScreenVertex { x, y, depth },
            outside: !inside,
            h,
        }
    };
    points.iter().map(project).collect()
}

/// Triangles of a soup that share a rank.
pub const SOUP_CHUNK: usize = 1024;

/// Id of triangle `k` of a soup that begins at `first_rank`: its rank counts chunks of [`SOUP_CHUNK`] triangles, its row and column
/// say which one of the chunk, its half is 0.
#[must_use]
#[inline]
pub fn soup_id(first_rank: u32, k: usize) -> SampleId {
    SampleId((first_rank + (k / SOUP_CHUNK) as u32) << 11 | ((k % SOUP_CHUNK) as u32) << 1)
}

/// Number of a triangle of a soup that begins at `first_rank`.
#[must_use]
#[inline]
pub fn soup_triangle(first_rank: u32, id: SampleId) -> usize {
    (id.rank() - first_rank) as usize * SOUP_CHUNK + ((id.0 >> 1) & 1023) as usize
}

/// Draws `triangles` over `vertices`, triangle `k` with the id [`soup_id`]`(first_rank, first + k)`, where `first` counts the
/// triangles of the soup before these.
///
/// # Panics
/// A triangle refers to a vertex that is not there.
pub fn draw_triangles<C: Cell>(
    level: Level,
    tile: &mut Tile<C>,
    vertices: &[SoupVertex],
    triangles: &[[u32; 3]],
    projection: &Projection,
    first_rank: u32,
    first: usize,
) {
    let soup = Soup {
        vertices,
        triangles,
        near: projection.near,
        ortho: projection.ortho,
        first_rank,
        first,
    };
    dispatch!(level, soup_kernel::<C>(tile, &soup, 1));
}

/// [`draw_triangles`] with a rule broken, for tests.
#[doc(hidden)]
pub fn draw_triangles_with<C: Cell>(
    level: Level,
    tile: &mut Tile<C>,
    vertices: &[SoupVertex],
    triangles: &[[u32; 3]],
    fault: Fault,
) {
    let soup = Soup {
        vertices,
        triangles,
        near: 1.0,
        ortho: false,
        first_rank: 0,
        first: 0,
    };
    dispatch!(level, soup_kernel::<C>(tile, &soup, fault.tie()));
}

struct Soup<'a> {
    vertices: &'a [SoupVertex],
    triangles: &'a [[u32; 3]],
    near: f32,
    ortho: bool,
    first_rank: u32,
    first: usize,
}

#[inline(always)]
fn soup_kernel<C: Cell>(tile: &mut Tile<C>, soup: &Soup<'_>, tie: i32) {
    for (k, triangle) in soup.triangles.iter().enumerate() {
        let v = triangle.map(|i| soup.vertices[i as usize]);
        let id = soup_id(soup.first_rank, soup.first + k).0;
        if v.iter().any(|v| v.outside) {
            let triangle = v.map(|v| clip_vertex(v.homogeneous(), v.screen()));
            fan(tile, &triangle, id, false, soup.near, soup.ortho, tie);
        } else {
            span::triangle(tile, &v.map(|v| v.screen), id, false, tie);
        }
    }
}
