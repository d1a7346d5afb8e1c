//! Pictures of every asset against `golden/`, pixel by pixel.
//!
//! A new or changed picture is accepted by `EARMARK_BLESS=1 cargo test --test golden`, which writes it and then fails, so that no run
//! that writes can pass. Only the scalar code on one thread may write. A mismatch leaves the golden, the new and the difference
//! picture, figures, and a page to look at them under `target/golden/earmark/`: see `earmark::golden`, which is tested here too.

#[path = "golden/adopter.rs"]
mod adopter;
#[path = "golden/assertions.rs"]
mod assertions;
mod common;
#[path = "golden/displaced.rs"]
mod displaced;
#[path = "golden/table.rs"]
mod table;

use earmark::film::Image;
use earmark::frame::Refinement;
use earmark::golden::Goldens;
use earmark::load::{LoadOptions, Loader};
use earmark::mesh::resolver::NoFiles;
use earmark::simd::Level;
use earmark::{Renderer, SurfaceOptions};
use std::path::Path;
use table::{Golden, goldens};

const ICOSAHEDRON: &str = "v -1 1.618034 0
v 1 1.618034 0
v -1 -1.618034 0
v 1 -1.618034 0
v 0 -1 1.618034
v 0 1 1.618034
v 0 -1 -1.618034
v 0 1 -1.618034
v 1.618034 0 -1
v 1.618034 0 1
v -1.618034 0 -1
v -1.618034 0 1
f 1 12 6
f 1 6 2
f 1 2 8
f 1 8 11
f 1 11 12
f 2 6 10
f 6 12 5
f 12 11 3
f 11 8 7
f 8 2 9
f 4 10 5
f 4 5 3
f 4 3 7
f 4 7 9
f 4 9 10
f 5 10 6
f 3 5 12
f 7 3 11
f 9 7 8
f 10 9 2
";

fn draw(g: &Golden, simd: Level) -> Image {
    let mut loader = Loader::new(LoadOptions {
        surface: SurfaceOptions {
            scheme: Some(g.scheme),
            patches: g.patches,
            ..SurfaceOptions::default()
        },
        ..LoadOptions::default()
    });
    if g.asset == "icosahedron" {
        let read = loader.read(ICOSAHEDRON.as_bytes(), g.asset, &mut NoFiles);
        let cage = read.unwrap().cage;
        loader.add_cage(cage, g.asset, &mut NoFiles).unwrap();
    } else {
        let path = common::assets().join(format!("{}.obj", g.asset));
        loader.add_file(&path).unwrap();
    }
    let mut scene = loader.finish().0;
    displaced::edit(&g.name, &mut scene);
    let mut renderer = Renderer::new(256, 256);
    renderer.size.samples = g.samples;
    renderer.refinement = Refinement::Uniform(g.level);
    if let Some((tags, random)) = g.tags {
        renderer.refinement = Refinement::DepthTags(tags);
        let mut numbers = common::Random(11);
        let count = scene.objects[0].surface.cage().points().len();
        // Few vertices have tags that differ.
        const FEW: [u8; 8] = [5, 0, 4, 1, 5, 2, 3, 0];
        let tags = (0..count).map(|k| match count <= FEW.len() {
            true => FEW[k],
            false => (numbers.next() % 6) as u8,
        });
        scene.objects[0].depth_tags = if random { tags.collect() } else { Vec::new() };
    }
    renderer.drawing = g.drawing;
    renderer.mode = g.mode;
    renderer.simd = simd;
    renderer.render(&scene, &g.camera).unwrap().image
}

/// The golden pictures of this package stand beside its sources.
fn store() -> Goldens {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    Goldens::of(manifest, "earmark").in_folder(&manifest.join("golden"))
}

#[test]
fn pictures_equal_their_goldens() {
    let store = store();
    let strict = store.clone().blessing(false);
    let mut failures = Vec::new();
    let mut written = 0;
    for g in goldens(&displaced::ALL) {
        let actual = draw(&g, Level::detect());
        let Err(failure) = strict.check(&g.name, &actual.into()) else {
            continue;
        };
        if !store.is_blessing() {
            failures.push(failure.to_string());
            continue;
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1);
        let image = pool.build().unwrap().install(|| draw(&g, Level::SCALAR));
        store.write(&g.name, &image.into()).unwrap();
        written += 1;
    }
    assert_eq!(
        written, 0,
        "{written} goldens written; look at them, then run again without EARMARK_BLESS"
    );
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn every_golden_is_read_by_a_test() {
    let all = goldens(&displaced::ALL);
    let mut dead = store().dead(all.iter().map(|g| g.name.as_str())).unwrap();
    // Those of line work are read by tests of their own.
    dead.retain(|name| !name.starts_with("overlay_"));
    assert_eq!(dead, Vec::<String>::new(), "goldens that no test reads");
    // One that is not asked for is found.
    let but_one = all[1..].iter().map(|g| g.name.as_str());
    let dead = store().dead(but_one).unwrap();
    assert!(dead.contains(&all[0].name), "{dead:?}");
}

#[test]
fn a_changed_picture_is_noticed() {
    let g = goldens(&displaced::ALL).remove(1);
    let mut image = draw(&g, Level::detect());
    image.data[4 * 128 * 257] ^= 1;
    let folder = std::env::temp_dir().join(format!("earmark-changed-{}", std::process::id()));
    let strict = store().blessing(false).leaving_in(&folder);
    let failure = strict.check(&g.name, &image.into()).unwrap_err();
    assert!(
        failure.to_string().contains("1 of 65536 pixels differ"),
        "{failure}"
    );
    std::fs::remove_dir_all(&folder).unwrap();
}
