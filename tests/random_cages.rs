//! Conformance with OpenSubdiv on random cages of every combination of rules.
//!
//! `EARMARK_OSDREF` names the reference program; without it only the generator is tested.
#![allow(missing_docs, clippy::print_stdout)]

mod support;

use earmark::refine::{Level, Limit, limit};
use earmark::topology::Ring;
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use support::random_cages::{COUNT, RandomCage, random_cage, random_triangles};
use support::{
    PointSet, Shape, base_level, corner_set, distance, extent, read, refined, set_distance,
};

const POINT_TOLERANCE: f64 = 2e-6;
const UV_TOLERANCE: f64 = 2e-6;
const LIMIT_TOLERANCE: f64 = 1e-5;
const NORMAL_TOLERANCE: f64 = 0.01;
/// Further steps of the reference before it takes limits: no tag below 10 outlives them.
const DEEP: &str = "2";

/// Errors of one kind.
#[derive(Default)]
struct Tally {
    all: usize,
    worst: f64,
    worst_at: String,
    bad: Vec<String>,
}

impl Tally {
    fn note(&mut self, what: &str, error: f64, tolerance: f64) {
        self.all += 1;
        if error > self.worst {
            self.worst = error;
            self.worst_at = what.into();
        }
        if error.is_nan() || error > tolerance {
            self.bad.push(format!("{what} ({error:.2e})"));
        }
    }
}

struct Temporary(PathBuf);

impl Temporary {
    fn new(name: &str) -> Self {
        let name = format!("earmark-random-{}-{name}", std::process::id());
        Self(std::env::temp_dir().join(name))
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn run(program: &OsStr, cage: &RandomCage, path: &Path, more: &[&OsStr]) {
    let status = std::process::Command::new(program)
        .arg(path)
        .args(cage.flags())
        .args(["-digits", "12", "-keepholes"])
        .args(more)
        .stdout(std::process::Stdio::null())
        .status()
        .unwrap();
    assert!(status.success(), "{} is refused", cage.case.name);
}

/// Points, texture coordinates, limits and normals.
type Tallies = [Tally; 4];

fn compare(program: &OsStr, cage: &RandomCage, tallies: &mut Tallies) {
    let name = &cage.case.name;
    let [path, out, limits] = ["cage", "level", "limit"]
        .map(|part| Temporary::new(&format!("{}-{name}-{part}", cage.case.scheme)));
    std::fs::write(&path.0, &cage.obj).unwrap();
    let size = extent(&cage.shape.points);
    let uv_size = cage
        .shape
        .uvs
        .iter()
        .flatten()
        .fold(1.0, |m: f64, c| m.max(c.abs()));
    for n in 1..=3_u32 {
        let what = format!("{name} {} level {n}", cage.rules.join(" "));
        let number = n.to_string();
        let mut more: Vec<&OsStr> = vec!["-level".as_ref(), number.as_ref()];
        more.extend::<[&OsStr; 2]>(["-o".as_ref(), out.0.as_os_str()]);
        if n == 2 {
            more.extend::<[&OsStr; 4]>([
                "-deep".as_ref(),
                DEEP.as_ref(),
                "-limit".as_ref(),
                limits.0.as_os_str(),
            ]);
        }
        run(program, cage, &path.0, &more);
        let want = Shape::read(&read(&out.0));
        let level = refined(base_level(&cage.shape, &cage.case), n, &cage.case.options);
        assert_eq!(level.points.len(), want.points.len(), "{what}");
        let error = set_distance(&level.points, &want.points, 1e-2 * size) / size;
        tallies[0].note(&what, error, POINT_TOLERANCE);
        let ours = corner_set(&level, true);
        let theirs: Vec<[f64; 5]> = (want.corners.iter().zip(&want.corner_uvs))
            .map(|(&v, &u)| {
                let (p, uv) = (want.points[v as usize], want.uvs[u as usize]);
                [p[0], p[1], p[2], uv[0], uv[1]]
            })
            .collect();
        assert_eq!(ours.len(), theirs.len(), "{what}");
        let error = set_distance(&ours, &theirs, 1e-2 * size) / uv_size;
        tallies[1].note(&what, error, UV_TOLERANCE);
        if n == 2 {
            let ours = limit(&level, &cage.case.options);
            compare_limits(
                &what,
                &level,
                &ours,
                &want,
                &read(&limits.0),
                size,
                &mut tallies[2..],
            );
        }
    }
}

fn compare_limits(
    what: &str,
    level: &Level<f64>,
    ours: &Limit<f64>,
    control: &Shape,
    text: &str,
    size: f64,
    tallies: &mut [Tally],
) {
    let set = PointSet::new(&level.points);
    let lines: Vec<Vec<f64>> = text
        .lines()
        .filter(|l| !l.starts_with('#'))
        .map(|l| l.split_whitespace().map(|w| w.parse().unwrap()).collect())
        .collect();
    assert_eq!(lines.len(), control.points.len(), "{what}");
    let t = &level.topology;
    for (i, (line, p)) in lines.iter().zip(&control.points).enumerate() {
        let flags = line[6] as u32;
        let what = format!("{what} vertex {i}");
        let found = set.near(p, POINT_TOLERANCE * size);
        assert!(!found.is_empty(), "{what} is not there");
        let nearest = |error: &dyn Fn(usize) -> f64| {
            (found.iter().map(|&v| error(v))).fold(f64::INFINITY, f64::min)
        };
        if flags & (1 | 2 | 16 | 32) == 0 {
            let wanted = [line[0], line[1], line[2]];
            let error = nearest(&|v| distance(&ours.positions[v], &wanted) / size);
            tallies[0].note(&what, error, LIMIT_TOLERANCE);
        }
        if flags == 0 {
            let wanted = [line[3], line[4], line[5]];
            let error = nearest(&|v| {
                Ring::of_fan(t, v as u32)
                    .map(|h| distance(&ours.normals[ours.normal_index(t, h) as usize], &wanted))
                    .fold(0.0, f64::max)
                    .to_degrees()
            });
            tallies[1].note(&what, error, NORMAL_TOLERANCE);
        }
    }
}

/// All cages that `cage` makes.
fn agree(scheme: &str, cage: impl Fn(u64) -> RandomCage) {
    let Some(program) = std::env::var_os("EARMARK_OSDREF") else {
        println!("skipped: EARMARK_OSDREF is not set");
        return;
    };
    let mut tallies = Tallies::default();
    for index in 0..COUNT {
        compare(&program, &cage(index), &mut tallies);
    }
    let names = ["points", "texture coordinates", "limits", "normals"];
    for (name, t) in names.iter().zip(&tallies) {
        println!(
            "{scheme}, {name}: {} of {}, worst {:.2e} ({})",
            t.all - t.bad.len(),
            t.all,
            t.worst,
            t.worst_at
        );
    }
    for (name, t) in names.iter().zip(&tallies) {
        assert!(t.all >= 3 * COUNT as usize, "{name}: {} compared", t.all);
        assert!(
            t.bad.is_empty(),
            "{name}: {}",
            t.bad[..t.bad.len().min(20)].join("\n")
        );
    }
}

#[test]
fn random_cages_agree_with_the_reference() {
    agree("Catmull-Clark", random_cage);
}

#[test]
fn random_triangles_agree_with_the_reference() {
    agree("Loop", random_triangles);
}

/// The cages are what they are meant to be, all together.
#[test]
fn cages_cover_what_they_should() {
    let mut valences = BTreeSet::new();
    let mut arities = BTreeSet::new();
    let mut rules = std::collections::BTreeMap::new();
    let (mut open, mut semi, mut infinite, mut corners, mut holes) = (0, 0, 0, 0, 0);
    let (mut darts, mut seams, mut uv_darts) = (0, 0, 0);
    for index in 0..COUNT {
        let cage = random_cage(index);
        let [fvar, boundary, creases, _] = cage.rules;
        *rules.entry((fvar, boundary, creases)).or_insert(0) += 1;
        let level = base_level(&cage.shape, &cage.case);
        let t = &level.topology;
        assert_eq!(t.fans().len(), t.vertex_count(), "{}", cage.case.name);
        valences.extend(t.fans().iter().filter(|f| f.closed).map(|f| f.faces));
        arities.extend((0..t.face_count() as u32).map(|f| t.face_halves(f).len()));
        open += usize::from(t.fans().iter().any(|f| !f.closed));
        let is_semi = |s: f32| s > 0.0 && s < 10.0;
        semi += usize::from(cage.shape.creases.iter().any(|c| is_semi(c.sharpness)));
        infinite += usize::from(cage.shape.creases.iter().any(|c| !is_semi(c.sharpness)));
        corners += usize::from(!cage.shape.sharp_vertices.is_empty());
        holes += usize::from(!cage.shape.holes.is_empty());
        let sharp_edges = |v: u32| {
            (cage.shape.creases.iter())
                .filter(|c| c.vertices.contains(&v))
                .count()
        };
        darts += usize::from(
            (0..t.vertex_count() as u32)
                .any(|v| t.fans()[v as usize].closed && sharp_edges(v) == 1),
        );
        let uvs = level.uvs.as_ref().unwrap();
        let seam = |h: u32| {
            let g = t.twin(h);
            g != u32::MAX
                && (uvs.corners[h as usize] != uvs.corners[t.next(g) as usize]
                    || uvs.corners[t.next(h) as usize] != uvs.corners[g as usize])
        };
        seams += usize::from((0..t.half_count() as u32).any(seam));
        uv_darts += usize::from((0..t.vertex_count() as u32).any(|v| {
            let around: Vec<u32> = Ring::of_fan(t, v).collect();
            let first = uvs.corners[around[0] as usize];
            t.fans()[v as usize].closed
                && around.iter().all(|&h| uvs.corners[h as usize] == first)
                && around.iter().any(|&h| seam(h))
        }));
    }
    println!(
        "{COUNT} cages: valences {valences:?}, arities {arities:?}; open {open}, semi-sharp {semi}, infinite {infinite}, \
         corners {corners}, holes {holes}, darts {darts}, seams {seams}, darts of seams {uv_darts}"
    );
    assert!((3..=12).all(|n| valences.contains(&n)));
    assert!((3..=9).all(|n| arities.contains(&n)));
    assert_eq!(rules.len(), 36);
    assert!(rules.values().all(|&n| n >= 6));
    for count in [open, semi, infinite, corners, holes, darts, seams, uv_darts] {
        assert!(count >= 30, "{count}");
    }
}
