//! Refined meshes carry the displacement of what is drawn.

use super::*;
use earmark::refine::{Level, limit};

#[test]
fn refined_meshes_hold_the_points_that_are_diced() {
    for (name, mut surface) in [
        ("quads", torus(6, 6, true, &SurfaceOptions::default())),
        (
            "polygons",
            common::load(&common::assets().join("part.obj")).objects[0]
                .surface
                .clone(),
        ),
        (
            "triangles",
            common::load(&common::assets().join("octahedron.obj")).objects[0]
                .surface
                .clone(),
        ),
    ] {
        surface.set_displacement(Some(noise("fbm:frequency=2").scaled(0.2)));
        let options = surface.refine_options();
        let cage = surface.cage();
        let base = Level::<f32>::of_cage(
            cage,
            surface.topology().clone(),
            surface.scheme(),
            surface.face_varying_rule(),
        );
        let mut level = base.unwrap();
        for _ in 0..3 {
            level = level.next(&options, &mut Default::default()).unwrap();
        }
        let mut found = limit(&level, &options);
        let before = found.positions.clone();
        surface.displace_limit(3, &level.topology, &mut found);
        let moved = (before.iter().zip(&found.positions))
            .filter(|(a, b)| a != b)
            .count();
        assert!(
            moved * 10 > before.len() * 9,
            "{name}: {moved} of {}",
            before.len()
        );
        // Every displaced point is one of the surface's.
        let mut all = std::collections::HashSet::new();
        let split = u32::from(surface.is_split());
        for q in 0..surface.quads().face_count() as u32 {
            all.extend(
                surface
                    .dice(q, 3 - split)
                    .points
                    .iter()
                    .map(|p| p.map(f32::to_bits)),
            );
        }
        let missing = found
            .positions
            .iter()
            .filter(|p| !all.contains(&p.map(f32::to_bits)))
            .count();
        assert_eq!(missing, 0, "{name}: {missing} of {}", before.len());
        assert!(
            found
                .normals
                .iter()
                .all(|n| n.iter().all(|x| x.is_finite()))
        );
    }
}
