//! Draws every model of a folder into one picture: `cargo run --release --example contact_sheet -- FOLDER OUT.png [SIDE]`.
//!
//! `SIDE` is the side of one model's picture in pixels, 320 by default.
#![allow(missing_docs)]

use earmark::load::{LoadOptions, Loader};
use earmark::sheet::{Picture, SheetStyle, contact_sheet};
use earmark::{Camera, Renderer, files, film};
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, folder, out, rest @ ..] = arguments.as_slice() else {
        return Err("usage: contact_sheet FOLDER OUT.png [SIDE]".into());
    };
    let side = rest.first().map_or(Ok(320), |s| s.parse())?;
    let mut models: Vec<PathBuf> = std::fs::read_dir(folder)?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "obj"))
        .collect();
    models.sort();

    let renderer = Renderer::new(side, side);
    let mut pictures = Vec::new();
    for model in &models {
        let mut loader = Loader::new(LoadOptions::default());
        loader.add_file(model)?;
        let (scene, _) = loader.finish();
        let caption = model.file_stem().map(|s| s.to_string_lossy().into_owned());
        pictures.push(Picture {
            image: renderer.render(&scene, &Camera::default())?.image,
            caption: caption.unwrap_or_default(),
        });
    }
    // As wide as high, or a little wider.
    let columns = (1..).find(|c| c * c >= pictures.len() as u32).unwrap_or(1);
    let style = SheetStyle {
        columns,
        text_height: (side / 20).max(8),
        ..SheetStyle::default()
    };
    let sheet = contact_sheet(&pictures, &style)?;
    files::write_atomic(Path::new(out), &film::png::encode(&sheet)?)?;
    Ok(())
}
