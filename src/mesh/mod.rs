//! The control cage and the files it comes from.

mod builder;
mod cage;
mod channel;
mod color;
mod error;
mod mtl;
pub mod obj;
pub mod resolver;
mod triangulate;
pub mod write;

pub use builder::CageBuilder;
pub use cage::{Cage, Corner, Crease, Material, NONE, Tags};
pub use channel::{CageChannels, FaceVaryingChannel, UniformChannel, UniformValues, VertexChannel};
pub use error::CageError;
pub use obj::{ReadError, ReadErrorKind, Warning, WarningKind};
pub use resolver::{MemoryFiles, NoFiles, ResolveError, Resolver};
pub(crate) use triangulate::fan_corners;
