//! Adaptive tessellation: how far each part of the surface is cut up, decided before anything is drawn.
//!
//! Who decides is a stage of its own: [`flatness`], in pixels, or [`depth_tags`], per vertex of the cage. What comes of it is the same
//! whoever decided: every face has a quadtree of blocks (`quadtree`), every cage edge a binary tree of splits (`tree`), and `blocks` makes
//! of both what is drawn. Blocks at every line get the points that both of its sides have; what is finer on one side is *moved*: a point
//! that the coarser side does not have goes to the nearest that it has (Bunnell's T-vertices). So a block is a grid still, triangles
//! beside the line become a fan, and no crack can open.
//!
//! Dicing gives a point the same bits at every level (`dice::face`), so an edge needs no more than its tree to look the same from both
//! faces, whatever their levels.

pub(crate) mod blocks;
pub mod depth_tags;
pub mod flatness;
pub mod patterns;
mod quadtree;
mod tree;

pub use depth_tags::DepthTags;
pub use flatness::Flatness;
pub(crate) use patterns::List;
pub use patterns::Pattern;

use std::sync::Arc;
use std::time::Duration;

/// Faces that one thread looks at, at a time.
const CHUNK: usize = 256;

/// What faces can be prepared for.
#[derive(Clone, Copy, Debug)]
struct Reach {
    /// Deepest level.
    level: u32,
    /// Whether faces are prepared for that level alone: those of tables.
    always: bool,
    /// Depth of the smallest squares that a face is diced in.
    squares: u32,
}

impl Reach {
    /// The level to prepare a face for if points of `level` are wanted.
    fn prepared(self, level: u32) -> u32 {
        if self.always { self.level } else { level }
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
    /// Number of the list of triangles that is drawn in place of the grid, or [`NO_LIST`].
    pub(crate) list: u32,
}

/// Leaves that are drawn as grids.
const NO_LIST: u32 = u32::MAX;

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
    /// Whether faces are triangles, whose blocks on the diagonal are half.
    pub(crate) triangular: bool,
    /// Lists of triangles of leaves that are no grids.
    lists: Vec<Arc<List>>,
    /// Time that patterns took.
    pub(crate) pattern_time: Duration,
    /// Bytes of the edges' trees, for comparison.
    pub(crate) tree_bytes: usize,
}

impl Leaf {
    /// Whether it is the lower half of its square, in a tessellation of triangles.
    pub(crate) fn is_diagonal(&self) -> bool {
        self.start[0] == self.start[1]
    }
}

impl Tessellation {
    /// Moved points of a leaf.
    pub(crate) fn moves(&self, leaf: usize) -> &[Move] {
        let first = match leaf {
            0 => 0,
            _ => self.leaves[leaf - 1].moves_end as usize,
        };
        &self.moves[first..self.leaves[leaf].moves_end as usize]
    }

    /// The list of triangles of a leaf that is no grid.
    pub(crate) fn list(&self, leaf: &Leaf) -> Option<&List> {
        self.lists.get(leaf.list as usize).map(|l| &**l)
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
