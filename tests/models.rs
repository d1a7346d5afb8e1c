//! Reference models and shapes from outside the project: shared edges and signed coverage.
//!
//! Runs when EARMARK_SHARED names the folder of reference data; then a missing input fails. Without it every test says that it was
//! skipped. EARMARK_THOROUGH=1 runs the full numbers of levels and cameras; EARMARK_CAMERAS sets the latter.

mod common;
#[path = "common/coverage.rs"]
mod coverage;
#[path = "common/edges.rs"]
mod edges;

use earmark::dice::DiceFault;
use earmark::frame::coverage::CoverageFault;

fn thorough() -> bool {
    std::env::var_os("EARMARK_THOROUGH").is_some_and(|v| v == "1")
}

#[test]
fn both_faces_of_every_edge_give_the_same_bits() {
    let Some(shared) = common::shared() else {
        println!("edges: skipped, EARMARK_SHARED is not set");
        return;
    };
    let levels = if thorough() { 8 } else { 4 };
    let mut total = 0;
    let mut cases = 0;
    for model in ["Bigguy", "Monsterfrog", "spot", "suzanne", "ArmorGuy"] {
        let scene = common::load(&shared.join("models").join(format!("{model}.obj")));
        let view = edges::view_of(&scene);
        for level in 1..=levels {
            let (differ, compared) =
                edges::compare(&scene.objects[0].surface, &view, level, DiceFault::None);
            assert_eq!(
                differ, 0,
                "{model} at level {level}: {differ} of {compared} points differ"
            );
            total += compared;
            cases += 1;
        }
    }
    println!("edges: 0 of {total} points differ in {cases} cases");
}

#[test]
fn closed_models_have_as_many_fronts_as_backs_at_every_sample() {
    let Some(shared) = common::shared() else {
        println!("coverage: skipped, EARMARK_SHARED is not set");
        return;
    };
    let asked = std::env::var("EARMARK_CAMERAS")
        .ok()
        .and_then(|n| n.parse().ok());
    let cameras = asked.unwrap_or(if thorough() { 100 } else { 4 });
    let (mut samples, mut covered, mut cases) = (0, 0, 0);
    let mut paths = common::models(&shared.join("models"));
    paths.extend(common::models(&shared.join("opensubdiv/shapes")));
    for path in paths {
        // Loop and bilinear shapes are cages like others; here they are drawn by Catmull-Clark.
        let scene = common::load(&path);
        let surface = &scene.objects[0].surface;
        let t = surface.topology();
        let hole = (0..t.face_count() as u32).any(|f| t.is_hole(f));
        if !common::is_closed(surface) || t.face_count() == 0 || hole {
            continue;
        }
        // Large cages at high levels take long and show nothing that small ones do not.
        let most = if surface.quads().face_count() > 20_000 {
            2
        } else {
            6
        };
        for level in 0..=most {
            let c = coverage::count(&scene, 128, level, cameras, CoverageFault::None);
            assert_eq!(
                c.unequal,
                0,
                "{} at level {level}: {} of {} samples",
                path.display(),
                c.unequal,
                c.samples
            );
            samples += c.samples;
            covered += c.covered;
            cases += 1;
        }
    }
    println!("coverage: 0 of {samples} samples unequal ({covered} covered) in {cases} cases");
}
