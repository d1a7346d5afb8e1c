//! Free-form deformation: `cargo run --release --example lattice FOLDER [FRAMES] [SIZE] [MODEL]`.
//!
//! The points of the cage live in a lattice of 4 by 4 by 4 control points around the model; each frame bends the lattice, the cage follows by
//! trivariate Bernstein polynomials (Sederberg, Parry, *Free-form deformation of solid geometric models*, 1986), and the surface follows
//! the cage.

use earmark::film::png;
use earmark::frame::Refinement;
use earmark::load::{LoadOptions, Loader};
use earmark::{Camera, Renderer, files};
use std::path::Path;

/// Cubic Bernstein polynomials.
fn bernstein(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
}

/// The lattice: where its 64 points are, by their places from 0 to 1 in the box of the model.
fn twisted(turn: f32, bend: f32) -> Vec<[f32; 3]> {
    let places = (0..64).map(|k| [k % 4, k / 4 % 4, k / 16].map(|i| i as f32 / 3.0));
    places
        .map(|[x, y, z]| {
            // The higher, the further round and to the side.
            let (sin, cos) = (turn * y).sin_cos();
            let (a, b) = (x - 0.5, z - 0.5);
            [
                0.5 + a * cos - b * sin + bend * y * y,
                y,
                0.5 + a * sin + b * cos,
            ]
        })
        .collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, folder, rest @ ..] = arguments.as_slice() else {
        return Err("usage: lattice FOLDER [FRAMES] [SIZE] [MODEL]".into());
    };
    let folder = Path::new(folder);
    let number = |k: usize, default: u32| rest.get(k).map_or(Ok(default), |s| s.parse());
    let (frames, size) = (number(0, 8)?, number(1, 320)?);
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/creature.obj");
    let model = rest.get(2).map_or(model, String::as_str);
    std::fs::create_dir_all(folder)?;
    let mut loader = Loader::new(LoadOptions::default());
    loader.add_file(Path::new(model))?;
    let (mut scene, _) = loader.finish();
    let mut renderer = Renderer::new(size, size);
    renderer.refinement = Refinement::Uniform(3);
    let view = Camera::default()
        .with_zoom(0.8)
        .framing(&scene.bounding_sphere(), renderer.size)?;
    let cage = scene.objects[0].surface.cage();
    let [low, high] = cage.bounds();
    let side = [0, 1, 2].map(|k| (high[k] - low[k]).max(1e-6));
    let places: Vec<[f32; 3]> = (cage.points().iter())
        .map(|p| [0, 1, 2].map(|k| (p[k] - low[k]) / side[k]))
        .collect();
    for frame in 0..frames {
        let swing = (frame as f32 / frames as f32 * std::f32::consts::TAU).sin();
        let lattice = twisted(0.9 * swing, 0.25 * swing);
        let moved: Vec<[f32; 3]> = places
            .iter()
            .map(|place| {
                let [u, v, w] = place.map(bernstein);
                let mut p = [0.0; 3];
                for (k, at) in lattice.iter().enumerate() {
                    let weight = u[k % 4] * v[k / 4 % 4] * w[k / 16];
                    (0..3).for_each(|c| p[c] += weight * at[c]);
                }
                [0, 1, 2].map(|c| low[c] + p[c] * side[c])
            })
            .collect();
        scene.objects[0].surface.update_points(&moved)?;
        let image = renderer.render_view(&scene, &view)?.image;
        let name = format!("lattice_{frame:04}.png");
        files::write_atomic(&folder.join(name), &png::encode(&image)?)?;
    }
    Ok(())
}
