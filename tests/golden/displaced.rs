//! Scenes of the displaced goldens: assets with a displacement or a normal map.

use earmark::Scene;
use earmark::displace::{Displacement, Function, HeightMap};
use earmark::shade::{Relief, SurfaceMaterial};
use earmark::texture::{Meaning, Texture};
use std::sync::Arc;

/// Asset, level, and the name behind a blank.
pub(crate) const ALL: [(&str, u32, &str); 4] = [
    ("creature", 4, " displace_seam"),
    ("creature", 4, " displace_noise"),
    ("grid", 7, " displace_terrain"),
    ("creature", 3, " normal_map"),
];

fn function(text: &str) -> Displacement {
    Displacement::function(text.parse::<Function>().unwrap())
}

/// Heights without any order, so that the two sides of a seam differ as much as they can.
fn rough(side: u32) -> Arc<HeightMap> {
    let hash = |i: u32| (i.wrapping_mul(0x9e37_79b9) >> 16).wrapping_mul(0x85eb_ca6b) >> 8;
    let heights = (0..side * side).map(|i| (hash(i) & 255) as f32 / 255.0);
    Arc::new(HeightMap::new(side, side, heights.collect()).unwrap())
}

/// Round bumps in rows.
fn studs(side: u32) -> Texture {
    let code = |x: f32| (127.5 + 127.5 * x + 0.5) as u8;
    let texel = |i: u32| {
        let at = |k: u32| (k % 16) as f32 / 8.0 - 1.0 + 1.0 / 16.0;
        let (x, y) = (at(i % side), -at(i / side));
        let r2 = x * x + y * y;
        let [x, y] = if r2 < 0.64 { [x, y] } else { [0.0; 2] };
        [code(x), code(y), code((1.0 - x * x - y * y).sqrt()), 255]
    };
    Texture::from_rgba8(
        side,
        side,
        (0..side * side).map(texel).collect(),
        Meaning::Data,
    )
    .unwrap()
}

/// Displacements that have no goldens of their own.
#[allow(dead_code, reason = "of one of the suites that this belongs to")]
pub(crate) fn by(name: &str) -> Displacement {
    match name {
        "map" => Displacement::map(rough(64)).scaled(0.06),
        "pixels" => Displacement::map(rough(64))
            .scaled(0.02)
            .with_slopes_per_pixel(true),
        "ripples" => function("ripples:frequency=3,t=0.3,x=0.2").scaled(0.03),
        "ridges" => function("ridged:frequency=2,octaves=3").scaled(0.04),
        "moving" => function("perlin:frequency=3,t=1.4,seed=5").scaled(0.05),
        _ => function("fbm:frequency=4,octaves=4,seed=3")
            .scaled(0.05)
            .biased(0.01),
    }
}

pub(crate) fn edit(name: &str, scene: &mut Scene) {
    let displacement = match name {
        "displace_seam" => Displacement::map(rough(64)).scaled(0.06),
        "displace_noise" => function("fbm:frequency=5,octaves=4,seed=3").scaled(0.05),
        "displace_terrain" => function("ridged:frequency=0.9,octaves=6,seed=4").scaled(0.25),
        "normal_map" => {
            scene.textures.push(studs(512));
            let relief = Some(Relief::Normals(scene.textures.len() as u32 - 1));
            for m in &mut scene.materials {
                *m = SurfaceMaterial { relief, ..*m };
            }
            return;
        }
        _ => return,
    };
    scene.objects[0]
        .surface
        .set_displacement(Some(displacement));
}
