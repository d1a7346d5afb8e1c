//! Sides of patches: the same bits from both faces, at every level.

use super::*;
use std::collections::BTreeMap;

/// Indices of the points along side `c` of a face, in its direction.
fn side(surface: &Surface, n: usize, c: usize) -> Vec<usize> {
    let m = n - 1;
    (0..n)
        .map(|k| match (c, surface.is_triangular()) {
            (0, _) => k,
            (1, _) => k * n + m,
            (2, true) => (m - k) * n + (m - k),
            (2, false) => m * n + m - k,
            _ => (m - k) * n,
        })
        .collect()
}

/// What differs among the faces of every edge: points, and normals where the mesh is not cut.
fn differences(surface: &Surface, level: u32) -> [usize; 2] {
    let t = surface.quads();
    let corners = if surface.is_triangular() { 3 } else { 4 };
    let mut first: BTreeMap<[u32; 2], [Vec<[f32; 3]>; 2]> = BTreeMap::new();
    let mut out = [0; 2];
    let mut shared = 0;
    for q in 0..t.face_count() as u32 {
        let diced = surface.dice(q, level);
        for c in 0..corners {
            let h = corners * q + c;
            let (a, b) = (t.vertex(h), t.vertex(t.next(h)));
            let mut along = side(surface, diced.side, c as usize);
            if a > b {
                along.reverse();
            }
            let points: Vec<[f32; 3]> = along.iter().map(|&k| diced.points[k]).collect();
            let normals: Vec<[f32; 3]> = along.iter().map(|&k| diced.normals[k]).collect();
            match first.get(&[a.min(b), a.max(b)]) {
                None => drop(first.insert([a.min(b), a.max(b)], [points, normals])),
                Some([p, n]) => {
                    shared += 1;
                    out[0] += usize::from(*p != points);
                    // Ends tell whether the faces share normals; a bilinear limit has one per face inside of an edge.
                    let last = n.len() - 1;
                    let bilinear = surface.scheme() == Scheme::Bilinear;
                    let same = (!bilinear || surface.patch_kind() == PatchKind::Pn)
                        && t.twin(h) != earmark::topology::NONE
                        && n[0] == normals[0]
                        && n[last] == normals[last];
                    out[1] += usize::from(same && *n != normals);
                }
            }
        }
    }
    assert!(shared > 0);
    out
}

/// Two cubes joined at one edge, all of it quads.
fn two_cubes() -> Cage {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nv 2 1 0\nv 2 2 0\nv 1 2 0\nv 2 1 1\nv 2 2 1\nv 1 2 1\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nf 11 10 9 3\nf 7 12 13 14\nf 3 9 12 7\nf 9 10 13 12\nf 10 11 14 13\nf 11 3 7 14\n";
    read(text)
}

#[test]
fn both_faces_of_an_edge_see_the_same() {
    let creature = asset("creature");
    let part = asset("part_creased");
    // A sheet of triangles, quads and a pentagon with normals of the file that are parted here and there.
    let parted = read(
        "v 0 0 0\nv 1 0 .3\nv 2 0 0\nv 0 1 .2\nv 1 1 .5\nv 2 1 .1\nv .5 2 0\nv 1.5 2 .2\nvn 0 0 1\nvn .3 0 1\nvn 0 -.4 1\nf 1//1 2//1 5//1 4//1\nf 2//2 3//2 6//2 5//2\nf 4//1 5//3 7//1\nf 5//3 6//2 8//1 7//1\n",
    );
    for (name, cage, scheme) in [
        ("creature", &creature, Scheme::CatmullClark),
        ("creature", &creature, Scheme::Bilinear),
        ("part_creased", &part, Scheme::CatmullClark),
        ("two cubes", &two_cubes(), Scheme::CatmullClark),
        ("creased cube", &creased_cube(10.0), Scheme::CatmullClark),
        ("semi-sharp cube", &creased_cube(2.3), Scheme::CatmullClark),
        (
            "semi-sharp triangles",
            &creased_cube(2.3).triangulated(),
            Scheme::Loop,
        ),
        (
            "creased triangles",
            &creased_cube(10.0).triangulated(),
            Scheme::Butterfly,
        ),
        ("icosahedron", &icosahedron(), Scheme::Loop),
        ("mobius", &asset("mobius"), Scheme::CatmullClark),
        ("parted normals", &parted, Scheme::CatmullClark),
        ("parted normals", &parted.triangulated(), Scheme::Loop),
        ("cube", &asset("cube"), Scheme::Kobbelt),
    ] {
        for kind in [PatchKind::Qas, PatchKind::Pn] {
            let surface = surface(cage, scheme, kind);
            for level in [0, 1, 3] {
                let found = differences(&surface, level);
                assert_eq!(found, [0, 0], "{name} {scheme:?} {kind:?} at level {level}");
            }
        }
    }
}

#[test]
fn points_have_the_same_bits_at_every_level() {
    for (cage, scheme) in [
        (asset("part_creased"), Scheme::CatmullClark),
        (asset("cube"), Scheme::CatmullClark),
        (icosahedron(), Scheme::Loop),
    ] {
        for kind in [PatchKind::Qas, PatchKind::Pn] {
            let surface = surface(&cage, scheme, kind);
            for q in (0..surface.quads().face_count() as u32).step_by(17) {
                let fine = surface.dice(q, 6);
                for level in [0, 2, 5] {
                    let coarse = surface.dice(q, level);
                    let (n, step) = (coarse.side, 1 << (6 - level));
                    for k in drawn(&surface, n) {
                        let at = k / n * step * fine.side + k % n * step;
                        assert_eq!(coarse.points[k], fine.points[at], "{scheme:?} {kind:?}");
                        assert_eq!(coarse.normals[k], fine.normals[at]);
                        let [u, v] = [k % n, k / n].map(|i| i as f32 / (n - 1) as f32);
                        let single = surface.patch_point(q, u, v);
                        assert_eq!(single, Some((coarse.points[k], coarse.normals[k])));
                    }
                }
            }
        }
    }
}

#[test]
fn any_cage_has_patches() {
    // Faces without area, doubled faces, a fan of opposite windings, huge and tiny numbers.
    let text = "v 0 0 0\nv 0 0 0\nv 1e30 0 0\nv 0 -1e30 1\nv 1e-30 1e-30 0\nv 1 1 1\nf 1 2 3 4\nf 1 2 3 4\nf 2 1 5\nf 1 2 5\nf 1 2 6\nf 3 4 5 6 1\nvn 0 0 0\nf 1//1 3//1 6//1\nt crease 2/1/0 0 1 10\nt corner 1/1/0 5 3\n";
    let cage = read(text);
    for kind in [PatchKind::Qas, PatchKind::Pn] {
        for (cage, scheme) in [
            (cage.clone(), Scheme::CatmullClark),
            (cage.triangulated(), Scheme::Loop),
            (cage.triangulated(), Scheme::Butterfly),
            (cage.clone(), Scheme::Kobbelt),
            (Cage::default(), Scheme::CatmullClark),
        ] {
            let surface = surface(&cage, scheme, kind);
            for q in 0..surface.quads().face_count() as u32 {
                for n in surface.dice(q, 2).normals {
                    assert!(
                        n.iter().all(|c| c.is_finite()),
                        "{scheme:?} {kind:?}: {n:?}"
                    );
                }
            }
        }
    }
}

/// Models outside of the project.
#[test]
fn real_models_agree_on_every_edge() {
    let Some(folder) = common::shared() else {
        return;
    };
    for path in common::models(&folder.join("models")) {
        let cage = read(&std::fs::read_to_string(&path).unwrap());
        let triangles = cage.first_polygon().is_none();
        let schemes = match triangles {
            true => [Scheme::Loop, Scheme::Butterfly],
            false => [Scheme::CatmullClark, Scheme::Bilinear],
        };
        for scheme in schemes {
            for kind in [PatchKind::Qas, PatchKind::Pn] {
                let surface = surface(&cage, scheme, kind);
                let found = differences(&surface, 2);
                assert_eq!(found, [0, 0], "{} {scheme:?} {kind:?}", path.display());
            }
        }
        println!("{}: the same on every edge", common::name(&path));
    }
}
