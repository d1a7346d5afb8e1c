//! Patches in place of the limit surface: one low polynomial per face, known at any parameter without refinement.
//!
//! * [`PatchKind::Qas`]: quadratic patches through points and normals of the limit surface (Boubekeur, Schlick, *QAS: Real-time Quadratic
//!   Approximation of Subdivision Surfaces*, 2007): corners and middles of edges; of quads, which the paper does not have, the middle of the
//!   face too (`qas`).
//! * [`PatchKind::Pn`]: curved PN triangles, cubic through the cage's own vertices (Vlachos, Peters, Boyd, Mitchell, *Curved PN Triangles*,
//!   2001), with a tension per vertex (Boubekeur, Reuter, Schlick, *Scalar Tagged PN Triangles*, 2005) (`pn`).
//!
//! # Watertight by construction
//!
//! On a side of a patch only the control points of that side have weights other than zero, and adding zeros changes no bit. What is left is
//! a sum that is the same from either end: first the two corners, then what lies between. So a side looks the same from both faces,
//! whichever way they run along it, if its control points do; and these are made of what belongs to the edge alone.

mod bezier;
mod face;
mod normals;
mod pn;
mod qas;

pub(crate) use face::{FacePatches, NET_LEN};
pub(crate) use pn::PnCage;

/// What of a surface is diced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PatchKind {
    /// The limit surface itself.
    #[default]
    None,
    /// Quadratic patches through points of the limit surface.
    Qas,
    /// Curved PN triangles over the cage.
    Pn,
}
