//! Closed models have as many fronts as backs at every sample: no crack, no overlap, from dicing to coverage.

mod common;
#[path = "common/coverage.rs"]
mod coverage;

use earmark::frame::coverage::CoverageFault;

#[test]
fn closed_models_have_as_many_fronts_as_backs_at_every_sample() {
    let (mut samples, mut covered) = (0, 0);
    for path in common::models(&common::assets()) {
        let scene = common::load(&path);
        if !common::is_closed(&scene.objects[0].surface) {
            continue;
        }
        for level in 0..=5 {
            let c = coverage::count(&scene, 160, level, 6, CoverageFault::None);
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
        }
    }
    println!("watertight: 0 of {samples} samples unequal, {covered} covered");
    assert!(covered > 100_000);
}

#[test]
fn broken_rules_are_noticed() {
    let scene = common::load(&common::assets().join("creature.obj"));
    let tie = coverage::count(&scene, 256, 6, 10, CoverageFault::NoTieRule);
    let moved = coverage::count(&scene, 256, 2, 10, CoverageFault::MovedCorner);
    println!(
        "watertight: {} samples unequal without the tie rule, {} with moved corners",
        tie.unequal, moved.unequal
    );
    assert!(tie.unequal > 0 && moved.unequal > 0);
}
