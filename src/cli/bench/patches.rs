//! `earmark bench patches`: what patches cost against the limit surface, and how far they are from it.
//!
//! Distances are those of the model's faces, by the valence of their most irregular corner, and of caps of a sphere around one vertex of
//! valence 3 to 12; all as parts of the diagonal of the cage's bounding box.

use super::refine::dice_all;
use super::{Arguments, Outcome, push};
use crate::cli::exit::Failure;
use crate::cli::job::Job;
use crate::cli::stats::{Clock, Json};
use earmark::distance::{Summary, cap, limit_of, limit_points, of_face};
use earmark::patch::PatchKind;
use earmark::{Cage, Scene, Surface, SurfaceOptions, topology};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Level without `--level`.
const LEVEL: u32 = 4;

/// What is compared: name, patches, and whether the cage is moved to its limit points first.
const KINDS: [(&str, PatchKind, bool); 3] = [
    ("qas", PatchKind::Qas, false),
    ("pn", PatchKind::Pn, false),
    ("pn-limit", PatchKind::Pn, true),
];

/// Distances of one surface from another.
struct Found {
    surface: &'static str,
    cage: &'static str,
    /// Valence of the faces' most irregular corner; of all faces without.
    valence: Option<u32>,
    faces: u64,
    sum: Summary,
    diagonal: f64,
}

impl Found {
    fn figures(&self) -> [f64; 4] {
        let s = &self.sum;
        [s.max, s.rms(), s.max_same, s.rms_same()].map(|d| d / self.diagonal)
    }

    fn json(&self) -> Json {
        let [max, rms, max_same, rms_same] = self.figures();
        Json::object([
            ("surface", Json::text(self.surface)),
            ("cage", Json::text(self.cage)),
            (
                "valence",
                self.valence.map_or(Json::Null, |v| Json::Whole(v.into())),
            ),
            ("faces", Json::Whole(self.faces)),
            ("points", Json::Whole(self.sum.points)),
            ("max", Json::Number(max)),
            ("rms", Json::Number(rms)),
            ("max_same_parameters", Json::Number(max_same)),
            ("rms_same_parameters", Json::Number(rms_same)),
        ])
    }
}

/// Distances as lines of text.
fn table(found: &[Found]) -> String {
    let mut out = String::from(
        "distances from the limit surface, in millionths of the cage's diagonal\ncage  valence   faces surface       max       rms  max same  rms same parameters\n",
    );
    for f in found {
        let valence = f.valence.map_or("all".to_owned(), |v| v.to_string());
        let _ = write!(
            out,
            "{:<6}{:>7}{:>8} {:<9}",
            f.cage, valence, f.faces, f.surface
        );
        for d in f.figures() {
            let _ = write!(out, "{:>10.1}", d * 1e6);
        }
        out.push('\n');
    }
    out
}

fn diagonal(cage: &Cage) -> f64 {
    let [low, high] = cage.bounds();
    let squares = (0..3).map(|k| (f64::from(high[k]) - f64::from(low[k])).powi(2));
    squares.sum::<f64>().sqrt().max(f64::MIN_POSITIVE)
}

/// The valence furthest from the regular one among the corners of face `q`; borders are left out.
fn valence(surface: &Surface, q: u32) -> u32 {
    let t = surface.quads();
    let regular = if surface.is_triangular() { 6 } else { 4 };
    let inside = t.face_halves(q).filter_map(|h| {
        let fan = t.fans()[t.fan(h) as usize];
        (fan.closed && fan.first != topology::NONE).then_some(fan.faces)
    });
    inside.fold(regular, |far: u32, v| {
        let off = |v: u32| v.abs_diff(regular);
        if off(v) > off(far) { v } else { far }
    })
}

fn surface_of(cage: &Cage, options: &SurfaceOptions, patches: PatchKind) -> Surface {
    let options = SurfaceOptions {
        patches,
        ..*options
    };
    Surface::new(cage.clone(), &options)
}

/// Distances of some faces of a cage, by kind of patch.
fn measure(
    cage: &Cage,
    options: &SurfaceOptions,
    level: u32,
    faces: u32,
    mut each: impl FnMut(&'static str, u32, Summary),
) -> Result<(), Failure> {
    for (name, kind, moved) in KINDS {
        let mut surface = surface_of(cage, options, kind);
        let limit = limit_of(&surface, options);
        if moved {
            surface
                .update_points(&limit_points(&limit))
                .map_err(|e| Failure::usage(e.to_string()))?;
        }
        let level = level.saturating_sub(u32::from(surface.is_split()));
        let quads = surface.quads();
        let count = (quads.face_count() as u32).min(faces);
        let found: Vec<(u32, Summary)> = (0..count)
            .into_par_iter()
            .filter(|&q| !quads.is_hole(q))
            .map(|q| {
                let mut sum = Summary::default();
                sum.add(&of_face(&surface, &limit, q, level));
                (valence(&limit, q), sum)
            })
            .collect();
        for (valence, sum) in found {
            each(name, valence, sum);
        }
    }
    Ok(())
}

pub(super) fn patches(job: &Job, a: &Arguments, scene: &Scene) -> Result<Outcome, Failure> {
    let level = a.level.level.unwrap_or(LEVEL);
    let limits = job.limits();
    let options = a.model.surface();
    let cages: Vec<&Cage> = scene.objects.iter().map(|o| o.surface.cage()).collect();
    let (mut rows, mut distances) = (Vec::new(), Vec::new());
    let (mut points, mut faces) = (0_u64, 0_u64);
    for (name, kind) in [
        ("limit", PatchKind::None),
        ("qas", PatchKind::Qas),
        ("pn", PatchKind::Pn),
    ] {
        let mut one = Scene::default();
        for cage in &cages {
            one.add(surface_of(cage, &options, kind), |_| (None, None));
        }
        let count = |s: &Surface| {
            let n = 1_u64 << level.saturating_sub(u32::from(s.is_split()));
            let per_face = match s.is_triangular() {
                true => (n + 1) * (n + 2) / 2,
                false => (n + 1) * (n + 1),
            };
            (s.quads().face_count() as u64, per_face)
        };
        let counts = one.objects.iter().map(|o| count(&o.surface));
        (faces, points) = counts.fold((0, 0), |(f, p), (n, per)| (f + n, p + n * per));
        limits.faces(u128::from(points))?;
        dice_all(&one, level, true, job.simd, &limits)?;
        for _ in 0..a.repeat {
            let clock = Clock::now();
            dice_all(&one, level, true, job.simd, &limits)?;
            push(&mut rows, name, clock.elapsed(), &|_| points);
        }
    }
    for cage in cages {
        limits.check()?;
        let mut sums: BTreeMap<(&str, Option<u32>), (u64, Summary)> = BTreeMap::new();
        measure(
            cage,
            &options,
            level.min(4),
            u32::MAX,
            |name, valence, sum| {
                for key in [None, Some(valence)] {
                    let (faces, all) = sums.entry((name, key)).or_default();
                    *faces += 1;
                    all.merge(&sum);
                }
            },
        )?;
        let mut keys: Vec<_> = sums.into_iter().collect();
        keys.sort_by_key(|((_, valence), _)| *valence);
        let diagonal = diagonal(cage);
        distances.extend(
            keys.into_iter()
                .map(|((surface, valence), (faces, sum))| Found {
                    surface,
                    cage: "model",
                    valence,
                    faces,
                    sum,
                    diagonal,
                }),
        );
    }
    let triangular = scene
        .objects
        .first()
        .is_some_and(|o| o.surface.is_triangular());
    for valence in 3..=12 {
        let cage = cap(valence, triangular).map_err(|e| Failure::usage(e.to_string()))?;
        let mut sums: BTreeMap<&str, (u64, Summary)> = BTreeMap::new();
        measure(&cage, &options, LEVEL, valence, |name, _, sum| {
            let (faces, all) = sums.entry(name).or_default();
            *faces += 1;
            all.merge(&sum);
        })?;
        let diagonal = diagonal(&cage);
        distances.extend(sums.into_iter().map(|(surface, (faces, sum))| Found {
            surface,
            cage: "cap",
            valence: Some(valence),
            faces,
            sum,
            diagonal,
        }));
    }
    let all = Json::List(distances.iter().map(Found::json).collect());
    Ok(Outcome {
        rows,
        faces,
        microtriangles: points,
        members: vec![("distances".to_owned(), all)],
        lines: table(&distances),
        ..Outcome::default()
    })
}
