//! The control cage and the files it comes from.

mod cage;
mod mtl;
pub mod obj;
pub mod resolver;
pub mod write;

pub use cage::{Cage, CageError, Corner, Crease, Material, NONE, Tags};
pub use obj::{ReadError, ReadErrorKind, Warning, WarningKind};
pub use resolver::{MemoryFiles, NoFiles, ResolveError, Resolver};
