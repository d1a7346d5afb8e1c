//! Renders a model with the library: `cargo run --release --example render -- MODEL OUT.png [LEVEL]`.

use earmark::frame::Refinement;
use earmark::load::{LoadOptions, Loader};
use earmark::{Camera, Renderer, film};
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, model, out, rest @ ..] = arguments.as_slice() else {
        return Err("usage: render MODEL OUT.png [LEVEL]".into());
    };
    let mut loader = Loader::new(LoadOptions::default());
    loader.add_file(Path::new(model))?;
    let (scene, _) = loader.finish();
    let mut renderer = Renderer::new(1024, 1024);
    if let Some(level) = rest.first() {
        renderer.refinement = Refinement::Uniform(level.parse()?);
    }
    let frame = renderer.render(&scene, &Camera::default())?;
    earmark::files::write_atomic(Path::new(out), &film::png::encode(&frame.image)?)?;
    Ok(())
}
