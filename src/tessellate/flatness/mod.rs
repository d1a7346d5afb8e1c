//! Flatness: where the surface needs points, decided in pixels.
//!
//! After Bunnell, *Adaptive Tessellation of Subdivision Surfaces with Displacement Mapping* (GPU Gems 2, 2005): an edge is split until its
//! chords are as close to the limit curve as wanted on the screen, a face until its triangles are. Other than there, nothing is passed on:
//!
//! 1. `faces`: every face gets a quadtree whose leaves are blocks of at most 32×32 micro-quads, of the level that the surface inside of
//!    it needs: none where a bound says that it is flat (`closed`), else as deep as the points of the next steps lie off its triangles
//!    (`surplus`).
//! 2. `edges`: every cage edge gets a binary tree of splits, once: from what both faces need along it, so that triangles beside it are not
//!    drawn out, and from its own curve where samples of the faces do not show that.

mod closed;
mod edges;
mod faces;
mod levels;
mod screen;
mod surplus;

use super::{Reach, Tessellation, blocks};
use crate::camera::View;
use crate::dice::MAX_LEVEL;
use crate::limits::{Budget, LimitError, Limits};
use crate::simd::Level;
use crate::surface::Surface;
use screen::Metric;
#[cfg(feature = "gpu")]
pub(crate) use screen::Numbers;

/// Numbers of the tests, for who makes them elsewhere.
pub(crate) mod numbers {
    pub(crate) use super::closed::SHARE as BOUND_SHARE;
    pub(crate) use super::faces::{ROUGH, TRUSTED, UNEVEN as UNEVEN_STEPS};
    pub(crate) use super::levels::{DEEPER, OVERHEAD, RESAMPLED};
    pub(crate) use super::surplus::{DOT, LEFT, UNEVEN};
}

/// Level that tables are made for at first.
const FIRST_TABLES: u32 = 4;

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

/// Tessellates a surface. `is_drawn` says of a quad, and points whose hull holds it, whether it is wanted at all.
///
/// # Errors
/// A budget was reached.
pub(crate) fn tessellate(
    surface: &Surface,
    (view, flatness): (&View, &Flatness),
    simd: Level,
    limits: &Limits,
    budget: &mut Budget<'_>,
    is_drawn: impl Fn(u32, &mut Vec<[f32; 3]>) -> bool + Sync,
) -> Result<Tessellation, LimitError> {
    let most = flatness.max_level.min(MAX_LEVEL);
    let mut level = match surface.has_tables() {
        true => most.min(FIRST_TABLES),
        false => MAX_LEVEL,
    };
    loop {
        surface.try_ensure(level, budget)?;
        let reach = Reach {
            level,
            always: surface.has_tables(),
            squares: surface.table_depth(level).unwrap_or(MAX_LEVEL),
        };
        let metric = Metric::new(view, flatness, reach);
        let (needs, own) = faces::needs(surface, &metric, limits, simd, &is_drawn)?;
        let trees = edges::trees(surface, &needs, own, limits)?;
        // What is needed is measured on the tables, two levels deeper.
        let deepest = needs.deepest().max(trees.deepest());
        if reach.always && level < most && deepest + 1 >= level {
            level = most.min(level + 2);
            continue;
        }
        let mut out = blocks::blocks(surface, &needs, &trees, reach, limits)?;
        out.tree_bytes = trees.bytes();
        return Ok(out);
    }
}
