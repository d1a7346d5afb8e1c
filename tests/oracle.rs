//! The per-quad path agrees with whole-mesh refinement: two ways to the same surface that share the rules and nothing else.

mod common;
#[path = "common/oracle.rs"]
mod oracle;

use common::Random;

#[test]
fn every_asset_agrees_at_every_level() {
    let mut sum = oracle::Worst::default();
    for path in common::models(&common::assets()) {
        let surface = common::load(&path).objects.remove(0).surface;
        let most = if surface.quads().face_count() > 1000 {
            3
        } else {
            6
        };
        for level in 1..=most {
            let worst = oracle::compare(&surface, level);
            assert!(
                worst.point <= 1e-5 && worst.normal <= 0.02,
                "{} at level {level}: {worst:?}",
                path.display()
            );
            sum.add(worst);
        }
    }
    println!("oracle: assets {sum:?}");
}

#[test]
fn faces_of_every_valence_agree_at_level_ten() {
    for asset in ["fan3", "fan5", "fan8", "fan24"] {
        let surface = common::load(&common::assets().join(format!("{asset}.obj")))
            .objects
            .remove(0)
            .surface;
        let mut random = Random(5);
        let mut sum = oracle::Worst::default();
        let faces = surface.topology().face_count() as u32;
        for q in (0..faces).take(20) {
            // The corners, where the surface is hardest, and some places between.
            let mut picks = vec![[0, 0], [1023, 0], [1023, 1023], [0, 1023], [1, 1], [31, 32]];
            picks.extend((0..4).map(|_| [random.next() % 1024, random.next() % 1024]));
            sum.add(oracle::compare_deep(&surface, q, 10, &picks));
        }
        println!("oracle: {asset} at level 10 {sum:?}");
        assert!(sum.point <= 1e-5, "{asset}: {sum:?}");
    }
}
