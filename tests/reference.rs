//! Reference shapes from outside the project by the per-quad path: every rule, tag and option.
//!
//! Runs when EARMARK_SHARED names the folder of reference data; then a missing input fails. Without it every test says that it was
//! skipped. EARMARK_THOROUGH=1 runs two more levels.

mod common;
#[path = "common/edges.rs"]
mod edges;
#[path = "common/oracle.rs"]
mod oracle;
#[allow(dead_code, unreachable_pub)]
#[path = "support/points.rs"]
mod points;

use earmark::dice::DiceFault;
use earmark::load::{LoadOptions, Loader};
use earmark::scheme::{Boundary, CreaseMethod, FaceVaryingRule, Scheme, TriangleRule};
use earmark::{Scene, Surface, SurfaceOptions};
use std::path::{Path, PathBuf};

fn thorough() -> bool {
    std::env::var_os("EARMARK_THOROUGH").is_some_and(|v| v == "1")
}

/// A shape of the reference data, with the options of its expected results.
struct Shape {
    name: String,
    path: PathBuf,
    options: SurfaceOptions,
}

impl Shape {
    fn surface(&self) -> Surface {
        let mut loader = Loader::new(LoadOptions {
            surface: self.options,
            ..LoadOptions::default()
        });
        loader
            .add_file(&self.path)
            .unwrap_or_else(|e| panic!("{}: {e}", self.path.display()));
        loader.finish().0.objects.remove(0).surface
    }
}

/// The manifold shapes without edits.
fn shapes(shared: &Path) -> Vec<Shape> {
    let table = std::fs::read_to_string(shared.join("opensubdiv/cases.tsv")).unwrap();
    let mut out = Vec::new();
    for line in table.lines().skip(1) {
        let columns: Vec<&str> = line.split('\t').collect();
        let options = SurfaceOptions {
            scheme: Some(match columns[1] {
                "catmull-clark" => Scheme::CatmullClark,
                "bilinear" => Scheme::Bilinear,
                "loop" => Scheme::Loop,
                other => panic!("scheme {other}"),
            }),
            boundary: Some(match columns[2] {
                "none" => Boundary::None,
                "edge-only" => Boundary::EdgeOnly,
                _ => Boundary::EdgeAndCorner,
            }),
            creases: Some(match columns[3] {
                "chaikin" => CreaseMethod::Chaikin,
                _ => CreaseMethod::Uniform,
            }),
            face_varying: Some(match columns[4] {
                "none" => FaceVaryingRule::None,
                "corners-only" => FaceVaryingRule::CornersOnly,
                "corners-plus2" => FaceVaryingRule::CornersPlus2,
                "boundaries" => FaceVaryingRule::Boundaries,
                "all" => FaceVaryingRule::All,
                _ => FaceVaryingRule::CornersPlus1,
            }),
            triangles: Some(match columns[5] {
                "smooth" => TriangleRule::Smooth,
                _ => TriangleRule::Catmark,
            }),
            ..SurfaceOptions::default()
        };
        if columns[6] == "plain" {
            let name = columns[0].to_owned();
            let path = shared.join("opensubdiv/shapes").join(format!("{name}.obj"));
            out.push(Shape {
                name,
                path,
                options,
            });
        }
    }
    out
}

#[test]
fn shapes_agree_with_whole_mesh_refinement_and_share_their_edges() {
    let Some(shared) = common::shared() else {
        println!("oracle: skipped, EARMARK_SHARED is not set");
        return;
    };
    let shapes = shapes(&shared);
    let levels = if thorough() { 6 } else { 4 };
    let mut sum = oracle::Worst::default();
    let mut edge_points = 0;
    let mut bad = Vec::new();
    for shape in &shapes {
        let surface = shape.surface();
        let view = edges::view_of(&Scene::of(surface.clone()));
        for level in 1..=levels {
            let mut worst = oracle::compare(&surface, level);
            // Folded sheets have no normal at the fold; what stands there is free.
            let folded = shape.name.starts_with("catmark_val2");
            // Micro-edges halve per level while the rounding of single precision stays: the deepest levels get twice the room.
            let bound = if level <= 4 { 0.05 } else { 0.1 };
            if worst.point > 1e-5 || (!folded && worst.normal > bound) {
                bad.push(format!("{} at level {level}: {worst:?}", shape.name));
            }
            if folded {
                worst.normal = 0.0;
            }
            sum.add(worst);
            // Bilinear surfaces are creased along all edges: each face has its own normals.
            if shape.options.scheme == Some(Scheme::Bilinear) {
                continue;
            }
            let (differ, compared) = edges::compare(&surface, &view, level, DiceFault::None);
            if differ > 0 {
                bad.push(format!(
                    "{} at level {level}: {differ} of {compared} points of edges differ",
                    shape.name
                ));
            }
            edge_points += compared;
        }
    }
    println!(
        "oracle: {} shapes, levels 1 to {levels}: {sum:?}; 0 of {edge_points} points of edges differ",
        shapes.len()
    );
    assert!(bad.is_empty(), "{}", bad.join("\n"));
    assert_eq!(shapes.len(), 104);
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
fn shapes_agree_with_the_expected_results() {
    let Some(shared) = common::shared() else {
        println!("expected: skipped, EARMARK_SHARED is not set");
        return;
    };
    let (mut levels, mut limits, mut normals) = (0, 0, 0);
    let (mut worst_point, mut worst_limit, mut worst_normal) = (0.0_f64, 0.0_f64, 0.0_f64);
    for shape in shapes(&shared) {
        let surface = shape.surface();
        let (name, size) = (shape.name.as_str(), oracle::size(&surface));
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
            let drawn = |q: &u32| !surface.quads().is_hole(*q);
            let got: Vec<[f64; 3]> = (surface.refine_quads(level - split).enumerate())
                .filter(|(q, _)| drawn(&(*q as u32)))
                .flat_map(|(_, q)| q.points)
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
            if flags == 0.0 && name != "catmark_val2_back2back" {
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
