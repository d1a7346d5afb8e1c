//! What is shared has one position and one normal, bit for bit.

use super::*;
use std::collections::HashMap;

type Bits = [u32; 3];

fn bits(p: [f32; 3]) -> Bits {
    p.map(f32::to_bits)
}

/// Counts points of `plain` that are shared but go to different places in `displaced`, and those with different normals.
fn torn(plain: &Surface, displaced: &Surface, level: u32) -> [usize; 3] {
    let mut places: HashMap<Bits, (u32, Bits)> = HashMap::new();
    let mut normals: HashMap<(Bits, Bits), (u32, Bits)> = HashMap::new();
    let [mut shared, mut cracks, mut kinks] = [0, 0, 0];
    for q in 0..plain.quads().face_count() as u32 {
        let (a, b) = (plain.dice(q, level), displaced.dice(q, level));
        for k in 0..a.points.len() {
            assert!(
                b.points[k]
                    .iter()
                    .chain(&b.normals[k])
                    .all(|x| x.is_finite())
            );
            let (p, n) = (bits(a.points[k]), bits(a.normals[k]));
            let place = places.entry(p).or_insert((q, bits(b.points[k])));
            shared += usize::from(place.0 != q);
            cracks += usize::from(place.1 != bits(b.points[k]));
            let normal = normals.entry((p, n)).or_insert((q, bits(b.normals[k])));
            kinks += usize::from(normal.1 != bits(b.normals[k]));
        }
    }
    [shared, cracks, kinks]
}

fn displacements() -> Vec<(&'static str, Displacement)> {
    vec![
        (
            "map",
            Displacement::map(noise_map(32, 3)).scaled(0.4).biased(-0.1),
        ),
        ("fbm", noise("fbm:frequency=2").scaled(0.3)),
        (
            "vector",
            Displacement::vector(0.5, |s| {
                [s.uv[0].sin() * 0.2, s.normal[0] * 0.1, s.position[1] * 0.1]
            }),
        ),
    ]
}

fn surfaces() -> Vec<(&'static str, Surface)> {
    let mut out = Vec::new();
    for (name, scheme) in [
        ("catmull-clark", Scheme::CatmullClark),
        ("bilinear", Scheme::Bilinear),
        ("kobbelt", Scheme::Kobbelt),
    ] {
        out.push((name, torus(8, 6, false, &by(scheme))));
    }
    out.push(("creased", torus(8, 6, true, &by(Scheme::CatmullClark))));
    for (name, scheme) in [("loop", Scheme::Loop), ("butterfly", Scheme::Butterfly)] {
        let cage = torus(8, 6, false, &SurfaceOptions::default())
            .cage()
            .triangulated();
        out.push((name, Surface::new(cage, &by(scheme))));
    }
    let cage = torus(8, 6, true, &SurfaceOptions::default())
        .cage()
        .triangulated();
    out.push(("creased loop", Surface::new(cage, &by(Scheme::Loop))));
    for asset in ["creature", "part", "octahedron", "part_creased"] {
        let scene = common::load(&common::assets().join(format!("{asset}.obj")));
        out.push((asset, scene.objects[0].surface.clone()));
    }
    out
}

#[test]
fn shared_points_and_normals_have_one_owner() {
    for (name, plain) in surfaces() {
        for (what, displacement) in displacements() {
            let mut displaced = plain.clone();
            displaced.set_displacement(Some(displacement));
            for level in [0, 1, 3] {
                let [shared, cracks, kinks] = torn(&plain, &displaced, level);
                assert!(shared > 0, "{name}");
                assert_eq!(
                    cracks, 0,
                    "{name} {what} level {level}: {cracks} of {shared} torn"
                );
                // Interpolating surfaces have normals from differences of each face.
                let exact = !plain.scheme().is_interpolating();
                assert!(
                    kinks == 0 || !exact,
                    "{name} {what} level {level}: {kinks} normals of {shared}"
                );
            }
        }
    }
}
