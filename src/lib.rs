//! earmark: subdivision surfaces without a GPU, from control cage to finished picture on CPU cores.

pub mod files;
pub mod mesh;
pub mod records;
pub mod scheme;

pub use mesh::Cage;
