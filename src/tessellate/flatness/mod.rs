//! Flatness: where the surface needs points, decided in pixels.
//!
//! After Bunnell, *Adaptive Tessellation of Subdivision Surfaces with Displacement Mapping* (GPU Gems 2, 2005): an edge is split until its
//! chords are as close to the limit curve as wanted on the screen, a face until its triangles are. Other than there, nothing is passed on:
//!
//! 1. `faces`: every face gets a quadtree whose leaves are blocks of at most 32×32 micro-quads, of the level that the surface inside of
//!    it needs (`cells`).
//! 2. `edges`: every cage edge gets a binary tree of splits, once: from its own curve, and from both faces, whose triangles beside it
//!    should not be drawn out.

mod cells;
mod edges;
mod faces;
mod screen;

use super::{Tessellation, blocks};
use crate::camera::View;
use crate::limits::{Budget, LimitError, Limits};
use crate::surface::Surface;
use screen::Metric;

/// How close triangles have to come to the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flatness {
    /// Largest distance on the screen between a point of the surface and the point of its triangle with the same parameters.
    pub pixels: f32,
    /// Largest angle in degrees between the normal of the surface and the one interpolated in its triangle.
    pub degrees: f32,
    /// Deepest level.
    pub max_level: u32,
}

impl Default for Flatness {
    /// Half a pixel, 3 degrees, level 8.
    fn default() -> Self {
        Self {
            pixels: 0.5,
            degrees: 3.0,
            max_level: 8,
        }
    }
}

/// Tessellates a surface of quads. `is_drawn` says of a quad, and points whose hull holds it, whether it is wanted at all.
///
/// # Errors
/// A budget was reached.
pub(crate) fn tessellate(
    surface: &Surface,
    view: &View,
    flatness: &Flatness,
    limits: &Limits,
    budget: &mut Budget<'_>,
    is_drawn: impl Fn(u32, &mut Vec<[f32; 3]>) -> bool + Sync,
) -> Result<Tessellation, LimitError> {
    surface.try_ensure(crate::dice::MAX_LEVEL, budget)?;
    let metric = Metric::new(view, flatness);
    let needs = faces::needs(surface, &metric, limits, is_drawn)?;
    let trees = edges::trees(surface, &metric, &needs, limits)?;
    let mut out = blocks::blocks(surface, &needs, &trees, limits)?;
    out.tree_bytes = trees.bytes();
    Ok(out)
}
