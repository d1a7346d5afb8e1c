//! earmark: subdivision surfaces without a GPU, from control cage to finished picture on CPU cores.

pub mod camera;
pub mod dice;
pub mod film;
pub mod math;
pub mod mesh;
pub mod raster;
pub mod records;
pub mod scheme;
pub mod shade;
pub mod simd;
pub mod texture;
pub mod topology;

pub use mesh::Cage;
