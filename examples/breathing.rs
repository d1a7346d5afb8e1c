//! A creature that breathes: `cargo run --release --example breathing FOLDER [FRAMES] [SIZE]`.
//!
//! Every frame moves the points of the cage and nothing else; the topology of the surface, and its displacement, stay. Ripples run over
//! the skin as time goes on.

use earmark::displace::{Displacement, Function};
use earmark::film::png;
use earmark::frame::Refinement;
use earmark::load::{LoadOptions, Loader};
use earmark::{Camera, Renderer, files};
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, folder, rest @ ..] = arguments.as_slice() else {
        return Err("usage: breathing FOLDER [FRAMES] [SIZE]".into());
    };
    let folder = Path::new(folder);
    let number = |k: usize, default: u32| rest.get(k).map_or(Ok(default), |s| s.parse());
    let (frames, size) = (number(0, 8)?, number(1, 320)?);
    std::fs::create_dir_all(folder)?;
    let mut loader = Loader::new(LoadOptions::default());
    loader.add_file(Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/assets/creature.obj"
    )))?;
    let (mut scene, _) = loader.finish();
    let mut renderer = Renderer::new(size, size);
    renderer.refinement = Refinement::Uniform(3);
    // One camera for all frames.
    let view = Camera::default().framing(&scene.bounding_sphere(), renderer.size)?;
    let rest_points = scene.objects[0].surface.cage().points().to_vec();
    let skin: Function = "ripples:frequency=3".parse()?;
    for frame in 0..frames {
        let phase = frame as f32 / frames as f32;
        let breath = 0.5 - 0.5 * (phase * std::f32::consts::TAU).cos();
        let surface = &mut scene.objects[0].surface;
        // The body swells sideways and upwards, most in its middle.
        let moved: Vec<[f32; 3]> = rest_points
            .iter()
            .map(|&[x, y, z]| {
                let swell = 1.0 + 0.12 * breath * (-2.0 * z * z).exp();
                [x * swell, y * (1.0 + 0.5 * (swell - 1.0)), z]
            })
            .collect();
        surface.update_points(&moved)?;
        let ripples = Function {
            time: phase,
            ..skin
        };
        surface.set_displacement(Some(Displacement::function(ripples).scaled(0.012)));
        let image = renderer.render_view(&scene, &view)?.image;
        let name = format!("breathing_{frame:04}.png");
        files::write_atomic(&folder.join(name), &png::encode(&image)?)?;
    }
    Ok(())
}
