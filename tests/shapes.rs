//! Conformance with OpenSubdiv on its regression shapes.
//!
//! The data is not in the repository: `EARMARK_SHARED` names the folder that holds `opensubdiv/`. Without it nothing is tested; with it, a
//! missing file is a failure.
#![allow(missing_docs, clippy::print_stdout)]

mod support;

use earmark::refine::{Level, Limit, Timings, limit};
use std::path::Path;
use support::{
    Case, PointSet, Shape, base_level, cases, corner_set, distance, extent, read, set_distance,
};

/// Refined points: of the bounding box.
const POINT_TOLERANCE: f64 = 2e-6;
/// Limit positions: of the bounding box.
const LIMIT_TOLERANCE: f64 = 1e-5;
/// Limit normals, in degrees.
const NORMAL_TOLERANCE: f64 = 0.01;

/// Tally of one category.
#[derive(Default)]
struct Tally {
    name: &'static str,
    good: usize,
    all: usize,
    worst: f64,
    worst_at: String,
    bad: Vec<String>,
}

impl Tally {
    fn new(name: &'static str) -> Self {
        Self {
            name,
            ..Self::default()
        }
    }
    fn note(&mut self, what: &str, error: f64, tolerance: f64) {
        self.all += 1;
        if error > self.worst {
            self.worst = error;
            self.worst_at = what.into();
        }
        if error <= tolerance {
            self.good += 1;
        } else {
            self.bad.push(format!("{what} ({error:.2e})"));
        }
    }
    fn finish(self) {
        println!(
            "{}: {} of {}, worst {:.2e} ({})",
            self.name, self.good, self.all, self.worst, self.worst_at
        );
        assert!(self.all > 0, "{}: nothing compared", self.name);
        assert!(
            self.bad.is_empty(),
            "{}: {}",
            self.name,
            self.bad.join(", ")
        );
    }
}

fn with_shared(test: impl FnOnce(&Path)) {
    match support::shared() {
        Some(path) => test(&path),
        None => println!("skipped: EARMARK_SHARED is not set"),
    }
}

fn shape(shared: &Path, case: &Case) -> Shape {
    Shape::read(&read(
        &shared.join(format!("opensubdiv/shapes/{}.obj", case.name)),
    ))
}

fn expected(shared: &Path, case: &Case, what: &str) -> String {
    read(&shared.join(format!("opensubdiv/expected/{}.{what}", case.name)))
}

fn is_ours(case: &Case) -> bool {
    case.scheme != "loop"
}

fn plain(shared: &Path) -> Vec<Case> {
    let plain: Vec<Case> = cases(shared)
        .into_iter()
        .filter(|c| c.kind == "plain" && is_ours(c))
        .collect();
    assert_eq!(plain.len(), 77);
    plain
}

fn refined(shape: &Shape, case: &Case, level: u32) -> Level<f64> {
    let base = base_level(shape, case);
    earmark::refine::refine(base, &case.options, level, None, &mut Timings::default()).unwrap()
}

/// Centres of the faces that are no holes: equal sets of them mean that the same points are joined.
fn centres(points: &[[f64; 3]], corners: &[u32]) -> Vec<[f64; 3]> {
    corners
        .chunks_exact(4)
        .map(|c| {
            std::array::from_fn(|k| c.iter().map(|&v| points[v as usize][k]).sum::<f64>() / 4.0)
        })
        .collect()
}

#[test]
fn control_points() {
    with_shared(|shared| {
        let mut points = Tally::new("control points");
        let mut faces = Tally::new("faces");
        for case in plain(shared) {
            let shape = shape(shared, &case);
            for &n in &case.levels {
                let what = format!("{} level {n}", case.name);
                let want = Shape::read(&expected(shared, &case, &format!("L{n}.obj")));
                let got = refined(&shape, &case, n);
                let size = extent(&shape.points);
                assert_eq!(got.points.len(), want.points.len(), "{what}: vertices");
                let error = set_distance(&got.points, &want.points, 1e-2 * size) / size;
                points.note(&what, error, POINT_TOLERANCE);
                let t = &got.topology;
                let drawn: Vec<u32> = (0..t.half_count() as u32)
                    .filter(|&h| !t.is_hole(t.face_of(h)))
                    .map(|h| t.vertex(h))
                    .collect();
                assert_eq!(drawn.len(), want.corners.len(), "{what}: corners");
                let error = set_distance(
                    &centres(&got.points, &drawn),
                    &centres(&want.points, &want.corners),
                    1e-2 * size,
                );
                faces.note(&what, error / size, POINT_TOLERANCE);
            }
        }
        points.finish();
        faces.finish();
    });
}

#[test]
fn texture_coordinates() {
    with_shared(|shared| {
        let mut tally = Tally::new("texture coordinates");
        for case in plain(shared) {
            let shape = shape(shared, &case);
            for &n in case.levels.iter().filter(|&&n| n < 3) {
                let want = Shape::read(&expected(shared, &case, &format!("L{n}.obj")));
                assert_eq!(
                    shape.corner_uvs.is_empty(),
                    want.corner_uvs.is_empty(),
                    "{}",
                    case.name
                );
                if shape.corner_uvs.is_empty() {
                    continue;
                }
                let got = corner_set(&refined(&shape, &case, n), false);
                let wanted: Vec<[f64; 5]> = (want.corners.iter().zip(&want.corner_uvs))
                    .map(|(&v, &u)| {
                        let (p, uv) = (want.points[v as usize], want.uvs[u as usize]);
                        [p[0], p[1], p[2], uv[0], uv[1]]
                    })
                    .collect();
                assert_eq!(got.len(), wanted.len(), "{} level {n}", case.name);
                let size = extent(&shape.points).max(1.0);
                let error = set_distance(&got, &wanted, 1e-2 * size) / size;
                tally.note(&format!("{} level {n}", case.name), error, POINT_TOLERANCE);
            }
        }
        tally.finish();
    });
}

/// The normal of a vertex, where it has but one.
fn single_normal(level: &Level<f64>, limit: &Limit<f64>, v: usize) -> Option<[f64; 3]> {
    let t = &level.topology;
    let several = earmark::topology::Ring::of_fan(t, v as u32)
        .any(|h| limit.normal_index(t, h) as usize != v);
    (!several).then(|| limit.normals[v])
}

fn angle(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    2.0 * (0.5 * distance(a, b)).clamp(0.0, 1.0).asin().to_degrees()
}

#[test]
fn limits() {
    with_shared(|shared| {
        let mut positions = Tally::new("limit positions");
        let mut normals = Tally::new("limit normals");
        let mut unit = Tally::new("unit normals");
        for case in plain(shared).iter().filter(|c| c.levels.contains(&2)) {
            let shape = shape(shared, case);
            let level = refined(&shape, case, 2);
            let ours = limit(&level, &case.options);
            for n in &ours.normals {
                unit.note(&case.name, (distance(n, &[0.0; 3]) - 1.0).abs(), 1e-12);
            }
            let size = extent(&shape.points);
            let control = Shape::read(&expected(shared, case, "L2.obj")).points;
            let set = PointSet::new(&level.points);
            let text = expected(shared, case, "limit2.txt");
            let lines: Vec<Vec<f64>> = text
                .lines()
                .filter(|l| !l.starts_with('#'))
                .map(|l| l.split_whitespace().map(|w| w.parse().unwrap()).collect())
                .collect();
            assert_eq!(lines.len(), control.len(), "{}", case.name);
            for (i, (line, p)) in lines.iter().zip(&control).enumerate() {
                let flags = line[6] as u32;
                let wanted = [line[0], line[1], line[2]];
                let normal = [line[3], line[4], line[5]];
                let what = format!("{} vertex {i}", case.name);
                // Several vertices may share a place; the best match counts.
                let found = set.near(p, POINT_TOLERANCE * size);
                assert!(!found.is_empty(), "{what} is not at level 2");
                let position = |v: usize| distance(&ours.positions[v], &wanted) / size;
                if flags & (1 | 2 | 16 | 32) == 0 {
                    let error = found
                        .iter()
                        .map(|&v| position(v))
                        .fold(f64::INFINITY, f64::min);
                    positions.note(&what, error, LIMIT_TOLERANCE);
                }
                if flags == 0 {
                    // Two coinciding sheets: at their rim the library's tangents are parallel but for rounding, and the sign is noise.
                    let either_side = case.name == "catmark_val2_back2back";
                    let opposite = normal.map(|c| -c);
                    let error = found
                        .iter()
                        .filter(|&&v| position(v) <= LIMIT_TOLERANCE)
                        .filter_map(|&v| single_normal(&level, &ours, v))
                        .map(|n| match angle(&n, &normal) {
                            a if either_side => a.min(angle(&n, &opposite)),
                            a => a,
                        })
                        .fold(180.0, f64::min);
                    normals.note(&what, error, NORMAL_TOLERANCE);
                }
            }
        }
        positions.finish();
        normals.finish();
        unit.finish();
    });
}

#[test]
fn odd_shapes_stay_finite() {
    with_shared(|shared| {
        let mut tally = Tally::new("shapes that are no manifold or have edits");
        for case in cases(shared)
            .iter()
            .filter(|c| c.kind != "plain" && is_ours(c))
        {
            let shape = shape(shared, case);
            for n in 0..=3 {
                let level = refined(&shape, case, n);
                let limits = limit(&level, &case.options);
                let uvs = level.uvs.iter().flat_map(|u| u.values.iter().flatten());
                let finite = (level.points.iter().flatten())
                    .chain(limits.positions.iter().flatten())
                    .chain(uvs)
                    .all(|c| c.is_finite());
                let unit =
                    (limits.normals.iter()).all(|n| (distance(n, &[0.0; 3]) - 1.0).abs() < 1e-12);
                let error = if finite && unit { 0.0 } else { 1.0 };
                tally.note(&format!("{} level {n}", case.name), error, 0.0);
            }
        }
        tally.finish();
    });
}

/// All combinations of options against the reference program itself, which `EARMARK_OSDREF` names.
#[test]
fn option_combinations() {
    let Some(program) = std::env::var_os("EARMARK_OSDREF") else {
        println!("skipped: EARMARK_OSDREF is not set");
        return;
    };
    with_shared(|shared| {
        let mut points = Tally::new("options: control points");
        let mut uvs = Tally::new("options: texture coordinates");
        let out = std::env::temp_dir().join(format!("earmark-options-{}.obj", std::process::id()));
        let mut turn = 0;
        for case in plain(shared) {
            let shape = shape(shared, &case);
            if shape.points.len() > 110 || shape.corner_uvs.is_empty() {
                continue;
            }
            for fvar in [
                "none",
                "corners-only",
                "corners-plus1",
                "corners-plus2",
                "boundaries",
                "all",
            ] {
                // The other options take turns, so that every pair occurs.
                turn += 1;
                let mut case = case.clone();
                case.fvar = support::fvar_rule(fvar);
                let boundary = ["none", "edge-only", "edge-and-corner"][turn % 3];
                case.boundary = support::boundary(boundary);
                let creases = ["uniform", "chaikin"][turn / 3 % 2];
                case.options.creases = support::crease_method(creases);
                let triangles = ["catmark", "smooth"][turn / 6 % 2];
                case.options.triangles = support::triangle_rule(triangles);
                let what = format!("{} {fvar} {boundary} {creases} {triangles}", case.name);
                let status = std::process::Command::new(&program)
                    .arg(shared.join(format!("opensubdiv/shapes/{}.obj", case.name)))
                    .args([
                        "-scheme",
                        &case.scheme,
                        "-fvar",
                        fvar,
                        "-boundary",
                        boundary,
                    ])
                    .args([
                        "-creases",
                        creases,
                        "-triangles",
                        triangles,
                        "-level",
                        "2",
                        "-digits",
                        "12",
                    ])
                    .args(["-keepholes", "-o"])
                    .arg(&out)
                    .stdout(std::process::Stdio::null())
                    .status()
                    .unwrap();
                assert!(status.success(), "{what}: the reference program failed");
                let want = Shape::read(&read(&out));
                let level = refined(&shape, &case, 2);
                let size = extent(&shape.points).max(1.0);
                let error = set_distance(&level.points, &want.points, 1e-2 * size) / size;
                points.note(&what, error, POINT_TOLERANCE);
                let got = corner_set(&level, true);
                let wanted: Vec<[f64; 5]> = (want.corners.iter().zip(&want.corner_uvs))
                    .map(|(&v, &u)| {
                        let (p, uv) = (want.points[v as usize], want.uvs[u as usize]);
                        [p[0], p[1], p[2], uv[0], uv[1]]
                    })
                    .collect();
                assert_eq!(got.len(), wanted.len(), "{what}");
                uvs.note(
                    &what,
                    set_distance(&got, &wanted, 1e-2 * size) / size,
                    POINT_TOLERANCE,
                );
            }
        }
        let _ = std::fs::remove_file(&out);
        points.finish();
        uvs.finish();
    });
}
