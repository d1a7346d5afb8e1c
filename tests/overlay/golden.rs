//! Pictures of line work against `golden/`, pixel by pixel, as `tests/golden.rs` has it.

use super::asset;
use earmark::film::{self, Image};
use earmark::frame::Refinement;
use earmark::overlay::{self, Layers, Options};
use earmark::scheme::Scheme;
use earmark::simd::Level;
use earmark::tessellate::{DepthTags, Pattern};
use earmark::{Camera, Renderer, Scene, Surface, SurfaceOptions};
use std::path::{Path, PathBuf};

/// Name, asset, level (none is adaptive), what is drawn, and whether on paper alone.
const ALL: [(&str, &str, Option<u32>, &str, bool); 9] = [
    (
        "overlay_creature_wireframe",
        "creature",
        Some(1),
        "wireframe,patches,valences",
        false,
    ),
    (
        "overlay_creature_adaptive",
        "creature",
        None,
        "wireframe",
        false,
    ),
    (
        "overlay_creature_illustration",
        "creature",
        Some(1),
        "",
        true,
    ),
    (
        "overlay_part_creased",
        "part_creased",
        Some(2),
        "wireframe,creases,boundaries",
        false,
    ),
    (
        "overlay_part_illustration",
        "part_creased",
        Some(2),
        "valences",
        true,
    ),
    (
        "overlay_mobius",
        "mobius",
        Some(3),
        "patches,boundaries,silhouettes",
        false,
    ),
    (
        "overlay_grid_cage",
        "grid",
        Some(3),
        "cage,axes,scale,labels",
        false,
    ),
    (
        "overlay_octahedron_loop",
        "octahedron",
        Some(3),
        "wireframe,patches,cage",
        false,
    ),
    ("overlay_pattern", "cube", None, "wireframe,patches", false),
];

fn path(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden");
    folder.join(format!("{name}.png"))
}

fn scene_of(name: &str, model: &str) -> Scene {
    if model != "octahedron" {
        return asset(model);
    }
    let cage = asset(model).objects[0].surface.cage().clone();
    let options = SurfaceOptions {
        scheme: Some(Scheme::Loop),
        ..SurfaceOptions::default()
    };
    assert!(name.ends_with("loop"));
    Scene::of(Surface::new(cage, &options))
}

fn draw(k: usize, simd: Level) -> Image {
    let (name, model, level, layers, alone) = ALL[k];
    let mut scene = scene_of(name, model);
    let mut renderer = Renderer::new(256, 256);
    renderer.simd = simd;
    if let Some(level) = level {
        renderer.refinement = Refinement::Uniform(level);
    } else if name == "overlay_pattern" {
        renderer.refinement = Refinement::DepthTags(DepthTags {
            pattern: Some(Pattern::Equilateral),
            ..DepthTags::GIVEN
        });
        scene.objects[0].depth_tags = vec![5, 0, 4, 1, 5, 2, 3, 0];
    }
    let layers = layers.split(',').filter_map(Layers::from_name);
    let layers = layers.fold(Layers::NONE, |all, l| all | l);
    let view = renderer.view(&scene, &Camera::default()).unwrap();
    let (mut image, options) = match alone {
        true => (
            Image::filled([256; 2], [255; 4]),
            Options::illustration(layers),
        ),
        false => {
            renderer.background = [255; 4];
            let frame = renderer.render_view(&scene, &view).unwrap();
            (frame.image, Options::overlay(layers))
        }
    };
    overlay::draw(&mut image, &renderer, &scene, &view, &options).unwrap();
    image
}

#[test]
fn pictures_equal_their_goldens() {
    let bless = std::env::var_os("EARMARK_BLESS").is_some_and(|v| v == "1");
    let mut wrong = Vec::new();
    for (k, (name, ..)) in ALL.iter().enumerate() {
        let expected = std::fs::read(path(name)).ok().map(|bytes| {
            let picture = image::load_from_memory(&bytes).unwrap().into_rgba8();
            Image {
                width: picture.width(),
                height: picture.height(),
                data: picture.into_raw(),
            }
        });
        let actual = draw(k, Level::detect());
        if expected.as_ref() == Some(&actual) {
            continue;
        }
        wrong.push(*name);
        let (image, to) = match bless {
            true => (draw(k, Level::SCALAR), path(name)),
            false => {
                let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("overlay");
                std::fs::create_dir_all(&folder).unwrap();
                (actual, folder.join(format!("{name}.actual.png")))
            }
        };
        std::fs::write(to, film::png::encode(&image).unwrap()).unwrap();
    }
    assert!(
        wrong.is_empty(),
        "{wrong:?} differ or are new; actual pictures are in the target folder's tmp/overlay, or written to golden/ by EARMARK_BLESS=1"
    );
}

#[test]
fn every_golden_of_lines_is_read() {
    for entry in std::fs::read_dir(path("x").parent().unwrap()).unwrap() {
        let name = entry.unwrap().file_name().to_string_lossy().into_owned();
        let known = ALL.iter().any(|(n, ..)| format!("{n}.png") == name);
        assert!(
            known || !name.starts_with("overlay_"),
            "golden/{name} is read by no test"
        );
    }
}
