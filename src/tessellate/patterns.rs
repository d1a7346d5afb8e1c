//! Refinement patterns: one face cut into triangles so that each of its sides has a depth of its own.
//!
//! After Boubekeur and Schlick, *Generic Adaptive Mesh Refinement* (GPU Gems 3, 2007). A pattern is named by the depths of its sides and
//! knows no face: its points are places in the parameters, so that one pattern serves every face with these depths, whatever is
//! interpolated there (`refine`). A side of depth `d` has `2^d + 1` points, evenly spaced; faces that share an edge of one depth therefore
//! share its points, whatever their patterns are.
//!
//! All patterns of triangles share one set of points, [`vertices`], in an order in which every depth is a beginning of the next. A
//! pattern itself is a list of triangles, made on demand and never stored: even at depth 10 an iterator takes a few hundred bytes. An
//! engine uploads [`vertices`] once and the [`TrianglePattern::indices`] of the patterns that it meets.
//!
//! Places of triangles count from corner 0: `[x, y]` has the weights `x` of corner 1, `y` of corner 2 and the rest of corner 0, in units
//! of `1 / 2^depth`. Side `k` runs from corner `k` to corner `k + 1`. Places of quads are `[u, v]`, corners and sides as everywhere.

mod pool;
mod refine;
mod vertices;
mod walk;

pub(crate) use pool::{List, Pool};
pub use refine::{Attribute, Order, RefinedFace, refine};
pub use vertices::{vertex_index, vertices};
pub use walk::Triangles;

use super::depth_tags::MAX_DEPTH;
use walk::Shape;

/// How a pattern joins sides of unequal depths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Pattern {
    /// The inside is uniform, as deep as the least of the sides, and triangles beside deeper sides are split as they are. The simplest and
    /// the smallest; its triangles may be as slender as a side is deep.
    Split,
    /// The inside is as deep as the deepest of the sides and becomes coarser towards coarse ones over a distance, half a triangle at a time,
    /// so that triangles are as nearly equilateral as their sides allow.
    Equilateral,
}

/// A place of a pattern's point, in units of one over two to the depth.
pub type Place = [u16; 2];

/// The pattern {i, j, k} of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TrianglePattern {
    pattern: Pattern,
    depths: [u8; 3],
}

/// The pattern {i, j, k, l} of a quad. Unlike those of triangles it is symmetric under half turns only: diagonals run from corner 0 to
/// corner 2 wherever it is uniform.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct QuadPattern {
    pattern: Pattern,
    depths: [u8; 4],
}

impl TrianglePattern {
    /// The pattern whose sides have these depths, from 0 to 10; `None` if one is above.
    #[must_use]
    pub fn new(pattern: Pattern, depths: [u8; 3]) -> Option<Self> {
        let fits = depths.iter().all(|&d| u32::from(d) <= MAX_DEPTH);
        fits.then_some(Self { pattern, depths })
    }
    /// Depth of the deepest side, whose points its places are.
    #[must_use]
    pub fn depth(&self) -> u32 {
        self.depths.into_iter().max().unwrap_or(0).into()
    }
    /// Its triangles, counter-clockwise like the face, at places of [`TrianglePattern::depth`].
    #[must_use]
    pub fn triangles(&self) -> Triangles {
        let [i, j, k] = self.depths;
        Triangles::new(self.pattern, Shape::Triangle, [i, j, k, 0], self.depth())
    }
    /// Its triangles as indices into [`vertices`] of any depth that is not less than its own.
    pub fn indices(&self) -> impl Iterator<Item = [u32; 3]> + use<> {
        let depth = self.depth();
        self.triangles()
            .map(move |t| t.map(|place| vertex_index(depth, place)))
    }
}

impl QuadPattern {
    /// The pattern whose sides have these depths, from 0 to 10; `None` if one is above.
    #[must_use]
    pub fn new(pattern: Pattern, depths: [u8; 4]) -> Option<Self> {
        let fits = depths.iter().all(|&d| u32::from(d) <= MAX_DEPTH);
        fits.then_some(Self { pattern, depths })
    }
    /// Depth of the deepest side, whose points its places are.
    #[must_use]
    pub fn depth(&self) -> u32 {
        self.depths.into_iter().max().unwrap_or(0).into()
    }
    /// Its triangles, counter-clockwise like the face, at places of [`QuadPattern::depth`].
    #[must_use]
    pub fn triangles(&self) -> Triangles {
        Triangles::new(self.pattern, Shape::Quad, self.depths, self.depth())
    }
    /// Its triangles as indices into the points of [`QuadPattern::depth`], row by row: `v * (2^depth + 1) + u`.
    pub fn indices(&self) -> impl Iterator<Item = [u32; 3]> + use<> {
        let row = (1_u32 << self.depth()) + 1;
        let index = move |[u, v]: Place| u32::from(v) * row + u32::from(u);
        self.triangles().map(move |t| t.map(index))
    }
}
