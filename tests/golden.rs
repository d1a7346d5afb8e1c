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
use earmark::simd::Level;
use table::{Golden, goldens};

fn draw(g: &Golden, simd: Level) -> Image {
    let mut scene = g.scene();
    displaced::edit(&g.name, &mut scene);
    let mut renderer = g.renderer();
    renderer.simd = simd;
    renderer.render(&scene, &g.camera).unwrap().image
}

#[test]
fn pictures_equal_their_goldens() {
    let store = common::goldens();
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
    let mut dead = common::goldens()
        .dead(all.iter().map(|g| g.name.as_str()))
        .unwrap();
    // Those of line work are read by tests of their own.
    dead.retain(|name| !name.starts_with("overlay_"));
    assert_eq!(dead, Vec::<String>::new(), "goldens that no test reads");
    // One that is not asked for is found.
    let but_one = all[1..].iter().map(|g| g.name.as_str());
    let dead = common::goldens().dead(but_one).unwrap();
    assert!(dead.contains(&all[0].name), "{dead:?}");
}

#[test]
fn a_changed_picture_is_noticed() {
    let g = goldens(&displaced::ALL).remove(1);
    let mut image = draw(&g, Level::detect());
    image.data[4 * 128 * 257] ^= 1;
    let folder = std::env::temp_dir().join(format!("earmark-changed-{}", std::process::id()));
    let strict = common::goldens().blessing(false).leaving_in(&folder);
    let failure = strict.check(&g.name, &image.into()).unwrap_err();
    assert!(
        failure.to_string().contains("1 of 65536 pixels differ"),
        "{failure}"
    );
    std::fs::remove_dir_all(&folder).unwrap();
}
