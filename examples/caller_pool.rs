//! Several pictures at once from a pool of one's own: `cargo run --example caller_pool`.
#![allow(clippy::print_stdout)]

use earmark::load::{LoadOptions, Loader};
use earmark::{Camera, Renderer};
use rayon::prelude::*;
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut loader = Loader::new(LoadOptions::default());
    loader.add_file(&Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/cube.obj"))?;
    let (scene, _) = loader.finish();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build()?;
    let frames: Vec<_> = pool.install(|| {
        (0..8_u32)
            .into_par_iter()
            .map(|k| {
                Renderer::new(128, 128).render(
                    &scene,
                    &Camera::default().with_orbit(45.0 * f64::from(k), 20.0),
                )
            })
            .collect::<Result<_, _>>()
    })?;
    for (k, frame) in frames.iter().enumerate() {
        println!("view {k}: {} pixels", frame.stats.pixels_covered);
    }
    Ok(())
}
