//! Depth tags and refinement patterns.

mod common;
#[path = "common/coverage.rs"]
mod coverage;
#[path = "tags/patterns.rs"]
mod patterns;
#[path = "tags/pictures.rs"]
mod pictures;
