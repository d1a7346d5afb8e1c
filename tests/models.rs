//! Reference models and shapes from outside the project: shared edges, signed coverage, per-quad against whole-mesh refinement.
//!
//! Runs when EARMARK_SHARED names the folder of reference data; then a missing input fails. Without it every test says that it was
//! skipped. EARMARK_THOROUGH=1 runs the full numbers of levels and cameras; EARMARK_CAMERAS sets the latter.

mod common;
#[path = "common/coverage.rs"]
mod coverage;
#[path = "common/edges.rs"]
mod edges;

#[path = "common/oracle.rs"]
mod oracle;
#[allow(dead_code, unreachable_pub)]
#[path = "support/points.rs"]
mod points;

use earmark::dice::DiceFault;
use earmark::frame::coverage::CoverageFault;
use earmark::scheme::Boundary;
use earmark::{Surface, SurfaceOptions};
use std::path::{Path, PathBuf};

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

/// The Catmull-Clark shapes of the reference data that are smooth: no crease, corner or hole. Path and boundary rule.
fn smooth_shapes(shared: &Path) -> Vec<(PathBuf, Boundary)> {
    let table = std::fs::read_to_string(shared.join("opensubdiv/cases.tsv")).unwrap();
    let mut out = Vec::new();
    for line in table.lines().skip(1) {
        let columns: Vec<&str> = line.split('\t').collect();
        let boundary = match columns[2] {
            "edge-only" => Boundary::EdgeOnly,
            "edge-and-corner" => Boundary::EdgeAndCorner,
            _ => continue,
        };
        if columns[1] != "catmull-clark" || columns[5] != "catmark" || columns[6] != "plain" {
            continue;
        }
        let path = shared
            .join("opensubdiv/shapes")
            .join(format!("{}.obj", columns[0]));
        let text = std::fs::read_to_string(&path).unwrap();
        if !["t crease ", "t corner ", "t hole "]
            .iter()
            .any(|tag| text.contains(tag))
        {
            out.push((path, boundary));
        }
    }
    out
}

fn surface_of(path: &Path, boundary: Boundary) -> Surface {
    let options = SurfaceOptions {
        boundary: Some(boundary),
        ..SurfaceOptions::default()
    };
    oracle::smooth(&common::load(path).objects[0].surface, &options)
}

#[test]
fn smooth_shapes_agree_with_whole_mesh_refinement() {
    let Some(shared) = common::shared() else {
        println!("oracle: skipped, EARMARK_SHARED is not set");
        return;
    };
    let shapes = smooth_shapes(&shared);
    let levels = if thorough() { 6 } else { 4 };
    let mut sum = oracle::Worst::default();
    for (path, boundary) in &shapes {
        for level in 1..=levels {
            let mut worst = oracle::compare(&surface_of(path, *boundary), level);
            assert!(
                worst.point <= 1e-5,
                "{} at level {level}: {worst:?}",
                path.display()
            );
            // Folded sheets have no normal at the fold; what stands there is free.
            let folded = common::name(path).starts_with("catmark_val2");
            // Micro-edges halve per level while the rounding of single precision stays: the deepest levels get twice the room.
            let bound = if level <= 4 { 0.05 } else { 0.1 };
            assert!(
                folded || worst.normal <= bound,
                "{} at level {level}: {worst:?}",
                path.display()
            );
            if folded {
                worst.normal = 0.0;
            }
            sum.add(worst);
        }
    }
    println!(
        "oracle: {} shapes, levels 1 to {levels}: {sum:?}",
        shapes.len()
    );
    assert!(shapes.len() >= 30);
}

/// Numbers of the lines that begin with `key`.
fn numbers(text: &str, key: &str) -> Vec<Vec<f64>> {
    let lines = text.lines().filter_map(|l| l.strip_prefix(key));
    lines
        .map(|l| {
            l.split_whitespace()
                .filter_map(|w| w.parse().ok())
                .collect()
        })
        .collect()
}

#[test]
fn smooth_shapes_agree_with_the_expected_results() {
    let Some(shared) = common::shared() else {
        println!("expected: skipped, EARMARK_SHARED is not set");
        return;
    };
    let (mut levels, mut limits, mut normals) = (0, 0, 0);
    let (mut worst_point, mut worst_limit, mut worst_normal) = (0.0_f64, 0.0_f64, 0.0_f64);
    for (path, boundary) in smooth_shapes(&shared) {
        let surface = surface_of(&path, boundary);
        let (name, size) = (common::name(&path), oracle::size(&surface));
        let expected = |suffix: &str| {
            std::fs::read_to_string(
                shared
                    .join("opensubdiv/expected")
                    .join(format!("{name}.{suffix}")),
            )
            .ok()
        };
        let split = u32::from(surface.is_split());
        for level in 1..=3 {
            let Some(text) = expected(&format!("L{level}.obj")) else {
                continue;
            };
            let faces = numbers(&text.replace('/', " "), "f ");
            assert!(!faces.is_empty(), "{name} level {level}");
            let used: std::collections::BTreeSet<usize> = text
                .lines()
                .filter_map(|l| l.strip_prefix("f "))
                .flat_map(|l| {
                    l.split_whitespace()
                        .map(|w| w.split('/').next().unwrap().parse::<usize>().unwrap() - 1)
                        .collect::<Vec<_>>()
                })
                .collect();
            let all = numbers(&text, "v ");
            let want: Vec<[f64; 3]> = used
                .iter()
                .map(|&v| [all[v][0], all[v][1], all[v][2]])
                .collect();
            let got: Vec<[f64; 3]> = surface
                .refine_quads(level - split)
                .flat_map(|q| q.points)
                .map(|p| p.map(f64::from))
                .collect();
            let off = points::set_distance(&got, &want, 1e-3 * size) / size;
            assert!(
                off <= 2e-6,
                "{name} level {level}: control points {off:e} of the bounding box away"
            );
            worst_point = worst_point.max(off);
            levels += 1;
        }
        let (Some(text), Some(level)) = (expected("limit2.txt"), expected("L2.obj")) else {
            continue;
        };
        assert!(level.contains("v "));
        let diced: Vec<_> = (0..surface.quads().face_count() as u32)
            .map(|q| surface.dice(q, 2 - split))
            .collect();
        let got: Vec<[f64; 3]> = diced
            .iter()
            .flat_map(|q| &q.points)
            .map(|p| p.map(f64::from))
            .collect();
        let got_normals: Vec<[f32; 3]> = diced.iter().flat_map(|q| q.normals.clone()).collect();
        let set = points::PointSet::new(&got);
        for line in text.lines().filter(|l| !l.starts_with('#')) {
            let n: Vec<f64> = line
                .split_whitespace()
                .map(|w| w.parse().unwrap())
                .collect();
            let [x, y, z, a, b, c, flags] = n[..] else {
                panic!("{name}: {line}")
            };
            if flags as u32 & (1 | 2 | 16 | 32) != 0 {
                continue;
            }
            let near = set.near(&[x, y, z], 1e-5 * size);
            assert!(
                !near.is_empty(),
                "{name}: no limit point within 1e-5 of {line}"
            );
            worst_limit = worst_limit.max(set.nearest(&[x, y, z], 1e-5 * size) / size);
            limits += 1;
            // Flat double sheets: at the fold both tangents across cancel, and the library's normal is the sign of a rounding error.
            if flags == 0.0 && !name.starts_with("catmark_val2_back2back") {
                let angle = near
                    .iter()
                    .map(|&k| oracle::angle(got_normals[k], [a, b, c]))
                    .fold(f64::MAX, f64::min);
                assert!(
                    angle <= 0.01,
                    "{name}: normal {angle} degrees away at {line}"
                );
                worst_normal = worst_normal.max(angle);
                normals += 1;
            }
        }
    }
    println!(
        "expected: {levels} of {levels} levels (worst {worst_point:.1e}), {limits} of {limits} limit points (worst {worst_limit:.1e}), \
         {normals} of {normals} normals (worst {worst_normal:.4} degrees)"
    );
    assert!(levels > 60 && limits > 3000 && normals > 3000);
}
