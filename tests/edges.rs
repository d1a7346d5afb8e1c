//! Shared edges: both faces give the rasteriser the same bits, and the test would notice if they did not.

mod common;
#[path = "common/edges.rs"]
mod edges;

use earmark::dice::DiceFault;

#[test]
fn both_faces_of_every_edge_give_the_same_bits() {
    let (mut differ, mut compared) = (0, 0);
    for path in common::models(&common::assets()) {
        let scene = common::load(&path);
        let view = edges::view_of(&scene);
        for level in 1..=5 {
            let (d, n) = edges::compare(&scene.objects[0].surface, &view, level, DiceFault::None);
            assert_eq!(
                d,
                0,
                "{} at level {level}: {d} of {n} points differ",
                path.display()
            );
            (differ, compared) = (differ + d, compared + n);
        }
    }
    println!("edges: {differ} of {compared} points differ");
    assert!(compared > 100_000);
}

#[test]
fn faces_that_walk_edges_their_own_way_are_noticed() {
    let scene = common::load(&common::assets().join("creature.obj"));
    let view = edges::view_of(&scene);
    let (differ, compared) =
        edges::compare(&scene.objects[0].surface, &view, 4, DiceFault::OwnDirection);
    println!("edges: {differ} of {compared} points differ without the canonical direction");
    assert!(differ > 0);
}
