//! A guide for whoever uses earmark, by what they come from.
//!
//! * [`getting_started`]: from a model to a picture, and the flags that matter first.
//! * [`from_blender`]: cages with creases out of Blender.
//! * [`on_servers`]: no display, bounded memory and time, exit codes.
//! * [`in_ci`]: pictures as tests.
//! * [`in_an_engine`]: the library, from points to moving cages.
//! * [`line_work`]: wireframes, cages, creases, valences; illustrations as PNG and SVG.
//! * [`where_others_are_better`]: OpenSubdiv, Embree, f3d.
//!
//! Every command here runs in a test. `model.obj` is a model of yours; any of `assets/` will do.
//! `cargo run --release --example gallery` makes a page of pictures with the commands that draw them.

#[doc = include_str!("getting_started.md")]
pub mod getting_started {}

#[doc = include_str!("from_blender.md")]
#[doc = "```python"]
#[doc = include_str!("../../examples/blender_export.py")]
#[doc = "```"]
pub mod from_blender {}

#[doc = include_str!("on_servers.md")]
pub mod on_servers {}

#[doc = include_str!("in_ci.md")]
pub mod in_ci {}

#[doc = include_str!("in_an_engine.md")]
pub mod in_an_engine {}

#[doc = include_str!("line_work.md")]
pub mod line_work {}

#[doc = include_str!("where_others_are_better.md")]
pub mod where_others_are_better {}
