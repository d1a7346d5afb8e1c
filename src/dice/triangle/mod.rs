//! Dicing of Loop surfaces: points and unit normals of the limit (or of the control net after N steps) of single triangles, straight
//! from the rings of their three corners, at any level from 0 to 10, for any valence and boundary.
//!
//! The twin of the code for quads beside it. A triangle fills half of a square grid: corner 0 at grid point (0, 0), corner 1 at (n, 0),
//! corner 2 at (n, n), so that its micro-triangles are the halves 0 and 1 of micro-quads; what lies above the diagonal is folded onto it.
//! The three directions of the lattice are then (1, 0), (0, 1) and (1, 1). Scheme: Loop, *Smooth subdivision surfaces based on
//! triangles*, 1987; the way towards irregular corners is that of Stam, *Evaluation of Loop subdivision surfaces*, 1998, with the
//! refinement itself in place of its eigenvectors.

mod basis;
mod control;
mod evaluate;
mod fans;
mod lattice;
mod patch;
mod piece;
mod place;
mod ring;
mod side;
mod small;
mod tensor;
#[cfg(test)]
mod tests;
mod wide;

#[cfg(feature = "gpu")]
pub(crate) use self::fans::has_no_plane;
pub(crate) use self::{
    control::{DescendTriangles, TriangleView},
    evaluate::{JetLines, TriangleEvaluator, TriangleRow, leaf},
    fans::{TriangleFans, TriangleMasks},
    patch::{TriangleChannel, TrianglePatch},
    ring::is_regular,
};
