//! Creased cages by the per-quad path: it agrees with whole-mesh refinement, and edges are shared bit for bit.

mod common;
#[path = "common/edges.rs"]
mod edges;
#[path = "common/oracle.rs"]
mod oracle;
mod support;

use earmark::dice::DiceFault;
use earmark::mesh::obj;
use earmark::mesh::resolver::NoFiles;
use earmark::scheme::{Boundary, CreaseMethod};
use earmark::{Cage, Scene, Surface, SurfaceOptions};
use std::fmt::Write;
use support::random_cages::{COUNT, random_cage, random_triangles};

/// A bent sheet of `n` by `n` quads, with tags.
fn sheet(n: u32, creases: &[(u32, u32, f32)], corners: &[(u32, f32)]) -> Cage {
    let m = n + 1;
    let mut text = String::new();
    for k in 0..m * m {
        let (x, y) = (f64::from(k % m), f64::from(k / m));
        let z = 0.4 * ((x * 1.7 + y).sin() + (y * 1.3 - x * 0.5).cos());
        writeln!(text, "v {x} {y} {z}\nvt {x} {}", y + 0.1 * z).unwrap();
    }
    for q in 0..n * n {
        let at = q / n * m + q % n + 1;
        let corner = |v: u32| format!("{v}/{v}");
        let [a, b, c, d] = [at, at + 1, at + m + 1, at + m].map(corner);
        writeln!(text, "f {a} {b} {c} {d}").unwrap();
    }
    for (a, b, s) in creases {
        writeln!(text, "t crease 2/1/0 {a} {b} {s}").unwrap();
    }
    for (v, s) in corners {
        writeln!(text, "t corner 1/1/0 {v} {s}").unwrap();
    }
    read(&text)
}

fn read(text: &str) -> Cage {
    obj::read(
        text.as_bytes(),
        "sheet.obj",
        &mut NoFiles,
        &obj::ReadOptions::default(),
    )
    .unwrap()
    .cage
}

/// Holds a surface against whole-mesh refinement, and its faces against each other.
fn check(name: &str, surface: &Surface, most: u32) -> oracle::Worst {
    let view = edges::view_of(&Scene::of(surface.clone()));
    let mut sum = oracle::Worst::default();
    for level in 1..=most {
        let worst = oracle::compare(surface, level);
        assert!(worst.point <= 2e-6, "{name} at level {level}: {worst:?}");
        assert!(worst.normal <= 0.05, "{name} at level {level}: {worst:?}");
        assert!(worst.uv <= 1e-5, "{name} at level {level}: {worst:?}");
        let (differ, compared) = edges::compare(surface, &view, level, DiceFault::None);
        assert_eq!(differ, 0, "{name} at level {level}: {differ} of {compared}");
        sum.add(worst);
    }
    sum
}

#[test]
fn sheets_with_every_kind_of_sharpness_agree_with_refinement() {
    let row = [(6, 7), (7, 8), (8, 9)];
    let with = |s: [f32; 3]| -> Vec<(u32, u32, f32)> {
        row.iter().zip(s).map(|(&(a, b), s)| (a, b, s)).collect()
    };
    let cases: Vec<(&str, Cage)> = vec![
        ("infinite dart", sheet(4, &with([10.0, 10.0, 0.0]), &[])),
        ("semi-sharp", sheet(4, &with([1.0, 2.0, 3.0]), &[])),
        ("fractional", sheet(4, &with([0.3, 1.6, 2.25]), &[])),
        ("one edge", sheet(4, &[(12, 13, 2.5)], &[])),
        ("corner", sheet(4, &[], &[(12, 1.5)])),
        ("sharp corner", sheet(4, &[], &[(12, 10.0)])),
        ("boundary corner", sheet(4, &[], &[(2, 2.5), (24, 0.5)])),
        (
            "to the boundary",
            sheet(
                4,
                &[
                    (10, 11, 10.0),
                    (11, 12, 10.0),
                    (12, 13, 10.0),
                    (13, 14, 10.0),
                ],
                &[],
            ),
        ),
        (
            "crossing",
            sheet(
                4,
                &[(11, 12, 10.0), (12, 13, 10.0), (7, 12, 2.0), (12, 17, 10.0)],
                &[],
            ),
        ),
        (
            "mixed",
            sheet(
                4,
                &[(11, 12, 10.0), (12, 13, 1.5), (7, 12, 0.75), (17, 18, 4.5)],
                &[(8, 3.0)],
            ),
        ),
    ];
    for (name, cage) in &cases {
        for method in [CreaseMethod::Uniform, CreaseMethod::Chaikin] {
            let options = SurfaceOptions {
                creases: Some(method),
                boundary: Some(Boundary::EdgeOnly),
                ..SurfaceOptions::default()
            };
            let surface = Surface::new(cage.clone(), &options);
            let plain = oracle::smooth(&surface, &options);
            let moved = (0..surface.quads().face_count() as u32)
                .any(|q| surface.dice(q, 3).points != plain.dice(q, 3).points);
            assert!(moved, "{name}: sharpness changes nothing");
            let sum = check(name, &surface, 5);
            println!("creases: {name} {sum:?}");
        }
    }
}

#[test]
fn random_cages_agree_with_refinement_under_every_combination_of_rules() {
    for make in [random_cage, random_triangles] {
        let mut sum = oracle::Worst::default();
        for i in 0..COUNT {
            let random = make(i);
            let case = &random.case;
            let options = SurfaceOptions {
                patches: Default::default(),
                scheme: Some(case.options.scheme),
                boundary: Some(case.boundary),
                creases: Some(case.options.creases),
                triangles: Some(case.options.triangles),
                face_varying: Some(case.fvar),
            };
            let surface = Surface::new(read(&random.obj), &options);
            let name = format!("random cage {i} under {:?}", case.options.scheme);
            sum.add(check(&name, &surface, 3));
        }
        println!("creases: {COUNT} random cages {sum:?}");
    }
}

#[test]
fn moved_points_leave_nothing_of_the_old_ones() {
    for i in (0..COUNT).step_by(5) {
        for random in [random_cage(i), random_triangles(i)] {
            let case = &random.case;
            let options = SurfaceOptions {
                scheme: Some(case.options.scheme),
                boundary: Some(case.boundary),
                creases: Some(case.options.creases),
                ..SurfaceOptions::default()
            };
            let mut moved = Surface::new(read(&random.obj), &options);
            let first: Vec<_> = (0..moved.quads().face_count() as u32)
                .map(|q| moved.dice(q, 3))
                .collect();
            let points: Vec<[f32; 3]> = (moved.cage().points().iter())
                .map(|&[x, y, z]| [x + 0.25 * z, y - x * y, z * z + 0.5 * x])
                .collect();
            moved.update_points(&points).unwrap();
            let text = random.obj.lines().filter(|l| !l.starts_with("v "));
            let mut obj: String = (points.iter())
                .map(|[x, y, z]| format!("v {x:?} {y:?} {z:?}\n"))
                .collect();
            text.for_each(|l| writeln!(obj, "{l}").unwrap());
            let fresh = Surface::new(read(&obj), &options);
            for (q, first) in first.iter().enumerate() {
                let (a, b) = (moved.dice(q as u32, 3), fresh.dice(q as u32, 3));
                assert_eq!(a, b, "random cage {i}, quad {q}");
                assert_ne!(a.points, first.points, "random cage {i}, quad {q}");
            }
        }
    }
}

/// Points of a level among those of the next: faces at an edge may then be diced at levels of their own, and still share the edge's bits.
/// Of quads that holds for all points, of triangles for their sides; not for texture coordinates, which no two faces share.
#[test]
fn points_of_a_level_are_among_those_of_the_next() {
    let mut compared = 0;
    for make in [random_cage, random_triangles] {
        for i in 0..COUNT / 4 {
            let random = make(i);
            let case = &random.case;
            let options = SurfaceOptions {
                patches: Default::default(),
                scheme: Some(case.options.scheme),
                boundary: Some(case.boundary),
                creases: Some(case.options.creases),
                triangles: Some(case.options.triangles),
                face_varying: Some(case.fvar),
            };
            let surface = Surface::new(read(&random.obj), &options);
            let faces = surface.quads().face_count() as u32;
            for q in (0..faces).step_by(3) {
                let mut coarse = surface.dice(q, 1);
                for level in 2..7 {
                    let fine = surface.dice(q, level);
                    let n = coarse.side;
                    for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
                        let on_side = j == 0 || i + 1 == n || i == j;
                        if surface.is_triangular() && !(on_side && j <= i) {
                            continue;
                        }
                        let (a, b) = (j * n + i, 2 * j * fine.side + 2 * i);
                        let at = format!("cage {i} face {q} level {level} at {i}, {j} of {n}");
                        assert_eq!(coarse.points[a], fine.points[b], "{at}");
                        assert_eq!(coarse.normals[a], fine.normals[b], "{at}, normals");
                        compared += 1;
                    }
                    coarse = fine;
                }
            }
        }
    }
    println!("creases: {compared} points are the same at the next level");
    assert!(compared > 1_000_000);
}
