//! Pictures of line work against `golden/`, pixel by pixel, as `tests/golden.rs` has it.

use super::asset;
use super::common::goldens;
use earmark::film::Image;
use earmark::frame::Refinement;
use earmark::overlay::{self, Layers, Options};
use earmark::scheme::Scheme;
use earmark::simd::Level;
use earmark::tessellate::{DepthTags, Pattern};
use earmark::{Camera, Renderer, Scene, Surface, SurfaceOptions};

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
    let store = goldens();
    let strict = store.clone().blessing(false);
    let mut failures = Vec::new();
    let mut written = 0;
    for (k, (name, ..)) in ALL.iter().enumerate() {
        let actual = draw(k, Level::detect());
        let Err(failure) = strict.check(name, &actual.into()) else {
            continue;
        };
        if !store.is_blessing() {
            failures.push(failure.to_string());
            continue;
        }
        let image = draw(k, Level::SCALAR);
        store.write(name, &image.into()).unwrap();
        written += 1;
    }
    assert_eq!(
        written, 0,
        "{written} goldens written; look at them, then run again without EARMARK_BLESS"
    );
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn every_golden_of_lines_is_read() {
    let mut dead = goldens().dead(ALL.iter().map(|(name, ..)| *name)).unwrap();
    // The others are read by tests of their own.
    dead.retain(|name| name.starts_with("overlay_"));
    assert_eq!(dead, Vec::<String>::new(), "goldens that no test reads");
    // One that is not asked for is found.
    let dead = goldens().dead(ALL[1..].iter().map(|(name, ..)| *name));
    assert!(dead.unwrap().iter().any(|name| name == ALL[0].0));
}
