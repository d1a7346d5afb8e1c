//! The flags that verbs share, and how their values are read. Every value is checked here, before any work is done.

mod level;
mod model;
mod picture;
mod running;
mod values;

pub(crate) use level::LevelFlags;
pub(crate) use model::{ModelFlags, scheme_name};
pub(crate) use picture::{Backend, PictureFlags, Shade};
pub(crate) use running::{RunningFlags, Simd, When};
