//! What is shared has one position and one normal, bit for bit.

use super::*;
use earmark::patch::PatchKind;
use earmark::surface::DicedQuad;
use earmark::topology::NONE;
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

/// Normals along side `c` of a diced quad, its corners left out, with the points there.
fn along(grid: &DicedQuad, c: usize) -> Vec<[[f32; 3]; 2]> {
    let n = grid.side - 1;
    let at = |k: usize| {
        let [i, j] = [[k, 0], [n, k], [n - k, n], [0, n - k]][c];
        let at = j * grid.side + i;
        [grid.points[at], grid.normals[at]]
    };
    (1..n).map(at).collect()
}

#[test]
fn creases_of_patches_move_along_the_normals_of_what_is_drawn() {
    const HEIGHT: f32 = 0.01;
    let mut compared = 0;
    for (scheme, patches) in [
        (Scheme::CatmullClark, PatchKind::None),
        (Scheme::CatmullClark, PatchKind::Qas),
        (Scheme::CatmullClark, PatchKind::Pn),
        (Scheme::Bilinear, PatchKind::Qas),
        (Scheme::Bilinear, PatchKind::Pn),
    ] {
        let options = SurfaceOptions {
            patches,
            ..by(scheme)
        };
        // Both are closed: sides without another are creases, and under the bilinear rule all are.
        let cage = match scheme {
            Scheme::Bilinear => torus(8, 6, false, &options).cage().clone(),
            _ => {
                let part = common::load(&common::assets().join("part_creased.obj"));
                part.objects[0].surface.cage().clone()
            }
        };
        let plain = Surface::new(cage, &options);
        let mut displaced = plain.clone();
        displaced.set_displacement(Some(noise("perlin").scaled(0.0).biased(HEIGHT)));
        let t = plain.quads();
        for q in 0..t.face_count() as u32 {
            let (a, b) = (plain.dice(q, 3), displaced.dice(q, 3));
            for (c, h) in t.face_halves(q).enumerate() {
                if scheme != Scheme::Bilinear && t.twin(h) != NONE {
                    continue;
                }
                for ([p, n], [to, _]) in along(&a, c).into_iter().zip(along(&b, c)) {
                    let moved: f32 = (0..3).map(|k| (to[k] - p[k]) * n[k]).sum();
                    assert!(
                        (moved - HEIGHT).abs() < 2e-4 * HEIGHT,
                        "{scheme:?} {patches:?} {q} {c}: {moved} along {n:?}"
                    );
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 1000, "{compared}");
}
