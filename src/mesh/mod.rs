//! The control cage and the files it comes from.

mod cage;

pub use cage::{Cage, CageError, Corner, Crease, Material, NONE, Tags};
