//! Pictures of displacement: `cargo run --release --example displacement FOLDER [SIZE]`.
//!
//! * `terrain.png`: 98 triangles and a ridged function of space.
//! * `displaced_creature.png`: the creature of `assets/` under four octaves of noise.
//! * `normal_map.png`, `ball_displaced.png`, `ball_mapped.png`: a map baked from a displaced ball, the ball, and a smooth one with the map.

use earmark::displace::{Displacement, Function};
use earmark::film::{Image, png};
use earmark::frame::Refinement;
use earmark::load::{LoadOptions, Loader};
use earmark::shade::{Relief, SurfaceMaterial};
use earmark::{Cage, Camera, Renderer, Scene, Surface, bake, files};
use std::path::Path;

type Done = Result<(), Box<dyn std::error::Error>>;

fn main() -> Done {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, folder, rest @ ..] = arguments.as_slice() else {
        return Err("usage: displacement FOLDER [SIZE]".into());
    };
    let folder = Path::new(folder);
    let size = rest.first().map_or(Ok(512), |s| s.parse())?;
    std::fs::create_dir_all(folder)?;
    let save = |name: &str, image: &Image| -> Done {
        files::write_atomic(&folder.join(name), &png::encode(image)?)?;
        Ok(())
    };

    let mut terrain = Scene::of(Surface::new(coarse()?, &Default::default()));
    let ridges: Function = "ridged:frequency=0.3,octaves=7,gain=0.42,seed=4".parse()?;
    terrain.objects[0]
        .surface
        .set_displacement(Some(Displacement::function(ridges).scaled(0.8)));
    let camera = Camera::default().with_orbit(30.0, 30.0).with_zoom(1.45);
    save("terrain.png", &draw(&terrain, &camera, size, 6)?)?;

    let mut loader = Loader::new(LoadOptions::default());
    loader.add_file(Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/assets/creature.obj"
    )))?;
    let mut creature = loader.finish().0;
    let skin: Function = "fbm:frequency=6,octaves=4".parse()?;
    creature.objects[0]
        .surface
        .set_displacement(Some(Displacement::function(skin).scaled(0.045)));
    save(
        "displaced_creature.png",
        &draw(&creature, &Camera::default(), size, 5)?,
    )?;

    let mut displaced = Surface::new(ball()?, &Default::default());
    let mut mapped = Scene::of(displaced.clone());
    let bumps: Function = "fbm:frequency=4,octaves=3".parse()?;
    displaced.set_displacement(Some(Displacement::function(bumps).scaled(0.03)));
    let map = bake::normal_map(&displaced, 1024, 1024)?;
    let [width, height] = map.size();
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    let codes = texels.flat_map(|[x, y]| {
        let [r, g, b, _] = map.texel(0, x, y).map(|c| (c * 65535.0 + 0.5) as u16);
        [r, g, b]
    });
    let bytes = png::encode_rgb16(width, height, &codes.collect::<Vec<u16>>())?;
    files::write_atomic(&folder.join("normal_map.png"), &bytes)?;
    mapped.textures.push(map);
    mapped.default_material = Some(SurfaceMaterial {
        relief: Some(Relief::Normals(0)),
        ..SurfaceMaterial::CLAY
    });
    let camera = Camera::default();
    save("ball_mapped.png", &draw(&mapped, &camera, size, 6)?)?;
    save(
        "ball_displaced.png",
        &draw(&Scene::of(displaced), &camera, size, 6)?,
    )?;
    Ok(())
}

fn draw(
    scene: &Scene,
    camera: &Camera,
    size: u32,
    level: u32,
) -> Result<Image, Box<dyn std::error::Error>> {
    let mut renderer = Renderer::new(size, size);
    renderer.refinement = Refinement::Uniform(level);
    Ok(renderer.render(scene, camera)?.image)
}

/// A flat square of 7 by 7 cells, two triangles each, their diagonals in turns.
fn coarse() -> Result<Cage, earmark::mesh::CageError> {
    let points = (0..64)
        .map(|k| [(k % 8) as f32 - 3.5, 0.0, 3.5 - (k / 8) as f32])
        .collect();
    let mut corners = Vec::new();
    for k in 0..49 {
        let (i, j) = (k % 7, k / 7);
        let [a, b, c, d] = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[i, j]| j * 8 + i);
        corners.extend(match (i + j) % 2 {
            0 => [a, b, c, a, c, d],
            _ => [a, b, d, b, c, d],
        });
    }
    Cage::new(points, &[3; 98], corners)
}

/// A cube, whose limit is nearly a sphere, with a chart for each of its faces.
fn ball() -> Result<Cage, earmark::mesh::CageError> {
    let points = (0..8)
        .map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|b| 2.0 * b as f32 - 1.0))
        .collect();
    let corners = vec![
        0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5,
    ];
    let uvs = (0..24).map(|k| {
        let [u, v] = [[0.02, 0.02], [0.31, 0.02], [0.31, 0.48], [0.02, 0.48]][k % 4];
        let (column, row) = ((k / 4 % 3) as f32, (k / 12) as f32);
        [u + column / 3.0, v + row / 2.0]
    });
    Cage::new(points, &[4; 6], corners)?.with_uvs(uvs.collect(), (0..24).collect())
}
