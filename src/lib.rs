//! earmark: subdivision surfaces without a GPU, from control cage to finished picture on CPU cores.

pub mod camera;
pub mod dice;
pub mod files;
pub mod film;
pub mod frame;
pub mod limits;
pub mod load;
pub mod math;
pub mod mesh;
pub mod raster;
pub mod records;
pub mod scheme;
pub mod shade;
pub mod sheet;
pub mod simd;
pub mod stream;
pub mod surface;
pub mod texture;
pub mod topology;

pub use camera::Camera;
pub use frame::{Renderer, Scene};
pub use mesh::Cage;
pub use surface::{Surface, SurfaceOptions};
