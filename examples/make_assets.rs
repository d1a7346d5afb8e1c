//! Writes the project's own model assets: `cargo run --release --example make_assets [FOLDER]` (default `assets`).
//!
//! Every file in `assets` except its README is made here, from code alone and with deterministic mathematics, so a change to a
//! model is a change to code; `tests/assets.rs` holds the committed files against this generator.

#[path = "make_assets/generator.rs"]
mod generator;

use std::path::PathBuf;

fn main() -> std::io::Result<()> {
    let folder = std::env::args_os()
        .nth(1)
        .map_or_else(|| PathBuf::from("assets"), PathBuf::from);
    std::fs::create_dir_all(&folder)?;
    for (name, bytes) in generator::files() {
        std::fs::write(folder.join(name), bytes)?;
    }
    Ok(())
}
