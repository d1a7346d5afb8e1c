//! earmark: subdivision surfaces without a GPU, from control cage to finished picture on CPU cores.

pub mod camera;
pub mod film;
pub mod math;
pub mod mesh;
pub mod records;
pub mod scheme;
pub mod shade;
pub mod texture;

pub use mesh::Cage;
