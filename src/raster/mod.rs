//! The rasteriser: blocks of points and plain triangles in, visibility keys per sample out. It knows nothing of subdivision.
//!
//! Coordinates are integers of 1/256 pixel, x to the right, y down, pixel (0, 0) covers [0, 256)². Points are snapped to them once,
//! globally ([`project()`]); from there on coverage is exact integer arithmetic: every sample inside a watertight sheet is covered
//! exactly once, whichever of three paths draws a micro-quad (many small quads at once, one medium quad, one large triangle), and
//! whichever vector level runs it. Depth is larger when nearer, `1/W` or a linear code; see [`Key`] for what stands at a sample.
//!
//! Both sides of a triangle are visible; none is culled. A triangle whose vertices run counter-clockwise in the picture is seen from
//! its front. Degenerate quads and triangles cover nothing and take nothing from their neighbours.

mod bin;
mod clip;
mod draw;
mod edge;
mod lanes;
mod medium;
mod micro;
mod project;
mod samples;
mod setup;
mod span;
mod tile;
mod weights;

pub use bin::{Bins, TileGrid};
#[doc(hidden)]
pub use draw::{Path, draw_apart_with, draw_block_with, draw_list_with, draw_triangles_with};
pub use draw::{
    SOUP_CHUNK, SoupVertex, draw_apart, draw_block, draw_list, draw_triangles, project_vertices,
    soup_id, soup_triangle,
};
#[doc(hidden)]
pub use edge::Fault;
pub use lanes::{CornerLanes, PairedBlock, SampleLanes};
pub use project::{GUARD_BAND, ProjectedBlock, project, project_rows};
pub use samples::sample_positions;
pub use setup::{PixelBox, SCREEN_MARGIN, bounds};
pub use tile::{Cell, Coverage, Key, Tile, tile_side};
pub use weights::{barycentrics, list_weights, triangle_weights};

/// Pictures are at most this many pixels wide and high, for all of them to lie inside the [`GUARD_BAND`].
pub const MAX_SCREEN: u32 = (GUARD_BAND / 256 - 1) as u32;
