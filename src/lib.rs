//! earmark: subdivision surfaces without a GPU, from control cage to finished picture on CPU cores.

pub mod dice;
pub mod mesh;
pub mod raster;
pub mod records;
pub mod scheme;
pub mod simd;
pub mod topology;

pub use mesh::Cage;
