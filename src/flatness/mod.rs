//! Adaptive tessellation: where the surface needs points, decided in pixels, before anything is drawn.
//!
//! After Bunnell, *Adaptive Tessellation of Subdivision Surfaces with Displacement Mapping* (GPU Gems 2, 2005): an edge is split until its
//! chords are as close to the limit curve as wanted on the screen, a face until its triangles are. Other than there, nothing is passed on:
//!
//! 1. `faces`: every face gets a quadtree whose leaves are blocks of at most 32×32 micro-quads, of the level that the surface inside of
//!    it needs (`cells`).
//! 2. `edges`: every cage edge gets a binary tree of splits (`tree`), once: from its own curve, and from both faces, whose triangles
//!    beside it should not be drawn out.
//! 3. Blocks get the points of the edges at their sides. What is finer on one side of a line than on the other is *moved*: a point that the coarser side does not have goes to the nearest
//!    that it has (Bunnell's T-vertices). So a block is a grid still, triangles beside the line become a fan, and no crack can open.
//!
//! Dicing gives a point the same bits at every level (`dice::face`), so an edge needs no more than its tree to look the same from both
//! faces, whatever their levels.

mod cells;
mod edges;
mod faces;
mod quadtree;
mod screen;
mod tree;

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

/// A block of a face: `2^log` by `2^log` micro-quads of level `level`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Leaf {
    /// Quad of the surface.
    pub(crate) quad: u32,
    /// Level that the quad is prepared for: that of its deepest leaf or edge.
    pub(crate) reach: u8,
    pub(crate) level: u8,
    pub(crate) log: u8,
    /// First point on the grid of `level`.
    pub(crate) start: [u16; 2],
    /// Its moves end here in the list, and begin where those of the leaf before end.
    pub(crate) moves_end: u32,
}

/// A point of a block's rim that is not where the grid has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Move {
    /// Column and row in the block.
    pub(crate) at: [u8; 2],
    /// Point of the face's grid at the level it is prepared for.
    pub(crate) to: [u16; 2],
}

/// The blocks that a surface is drawn by.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tessellation {
    pub(crate) leaves: Vec<Leaf>,
    moves: Vec<Move>,
    /// Bytes of the edges' trees, for comparison.
    pub(crate) tree_bytes: usize,
}

impl Tessellation {
    /// Tessellates a surface of quads. `is_drawn` says of a quad, and points whose hull holds it, whether it is wanted at all.
    ///
    /// # Errors
    /// A budget was reached.
    pub(crate) fn new(
        surface: &Surface,
        view: &View,
        flatness: &Flatness,
        limits: &Limits,
        budget: &mut Budget<'_>,
        is_drawn: impl Fn(u32, &mut Vec<[f32; 3]>) -> bool + Sync,
    ) -> Result<Self, LimitError> {
        surface.try_ensure(crate::dice::MAX_LEVEL, budget)?;
        let metric = Metric::new(view, flatness);
        let needs = faces::needs(surface, &metric, limits, is_drawn)?;
        let trees = edges::trees(surface, &metric, &needs, limits)?;
        let mut out = faces::blocks(surface, &needs, &trees, limits)?;
        out.tree_bytes = trees.bytes();
        Ok(out)
    }

    /// Moved points of a leaf.
    pub(crate) fn moves(&self, leaf: usize) -> &[Move] {
        let first = match leaf {
            0 => 0,
            _ => self.leaves[leaf - 1].moves_end as usize,
        };
        &self.moves[first..self.leaves[leaf].moves_end as usize]
    }

    /// Number of moved points.
    pub(crate) fn move_count(&self) -> usize {
        self.moves.len()
    }

    /// Bytes that it takes.
    pub(crate) fn bytes(&self) -> usize {
        self.leaves.len() * size_of::<Leaf>() + self.moves.len() * size_of::<Move>()
    }

    /// Appends `other`, which belongs to quads that follow.
    fn append(&mut self, other: &Self) {
        let base = self.moves.len() as u32;
        self.leaves.extend(other.leaves.iter().map(|l| Leaf {
            moves_end: l.moves_end + base,
            ..*l
        }));
        self.moves.extend_from_slice(&other.moves);
    }
}
