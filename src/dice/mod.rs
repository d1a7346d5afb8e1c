//! Dicing: points and unit normals of the limit surface (or of its control net after N steps) on the grid of each quad, straight from
//! the quad's ear stencil, at any level from 0 to 10, for any valence and boundary.

mod basis;
pub(crate) mod control;
mod edge;
pub(crate) mod evaluate;
pub(crate) mod face;
pub(crate) mod fan_points;
mod linear;
mod net;
mod plan;
mod point;
pub(crate) mod presplit;
mod regular;
mod sheet;
mod sides;
pub(crate) mod table;
pub(crate) mod tangent_masks;
#[cfg(test)]
mod tests;
pub(crate) mod triangle;
mod vectors;
mod window;

pub use basis::{MAX_LEVEL, Target};
#[doc(hidden)]
pub use face::DiceFault;
pub use face::FacePatch;
