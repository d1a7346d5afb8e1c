//! `earmark bench evaluate`: position and first derivatives of the limit surface at random places and on regular grids.
//!
//! The four ways in are measured one after the other, each over the same number of points. All but `batch` run on one thread.

use super::{Arguments, Outcome, push};
use crate::cli::exit::Failure;
use crate::cli::job::Job;
use crate::cli::stats::{Clock, Time};
use earmark::evaluate::{FaceEvaluator, Place, Tangents};
use earmark::{Scene, Surface};
use std::hint::black_box;

/// Segments of the grid of a face.
const GRID: u32 = 16;

/// Random places; the same in every run.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as u32
    }
    fn unit(&mut self) -> f32 {
        (self.bits() >> 7) as f32 / (1_u32 << 24) as f32
    }
    fn place(&mut self, surface: &Surface) -> Place {
        let t = surface.topology();
        let face = ((u64::from(self.bits()) * t.face_count() as u64) >> 31) as u32;
        let corners = t.face_halves(face).len();
        let (u, v) = (self.unit(), self.unit());
        if surface.is_triangular() {
            // The other half of the square is the triangle once more.
            let (u, v) = if u + v > 1.0 {
                (1.0 - u, 1.0 - v)
            } else {
                (u, v)
            };
            return Place { face, u, v };
        }
        let width = if corners == 4 { 1.0 } else { corners as f32 };
        Place {
            face,
            u: u * width,
            v,
        }
    }
}

/// The nearest place below that interpolating surfaces know.
fn known(surface: &Surface, place: Place) -> Place {
    if !surface.scheme().is_interpolating() {
        return place;
    }
    let [mut u, mut v] = [place.u, place.v].map(|x| (x * 1024.0).floor() / 1024.0);
    if surface.is_triangular() {
        u = u.fract();
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
    }
    Place { u, v, ..place }
}

pub(super) fn evaluate(job: &Job, a: &Arguments, scene: &mut Scene) -> Result<Outcome, Failure> {
    let limits = job.limits();
    let mut rows = Vec::new();
    let grid_points = |s: &Surface| {
        let faces = 0..s.topology().face_count() as u32;
        faces
            .filter_map(|f| s.face_evaluator(f))
            .map(|f| f.grid_len(GRID) as u64)
            .sum::<u64>()
    };
    let points: u64 = scene.objects.iter().map(|o| grid_points(&o.surface)).sum();
    // Buffers of the random suites hold at most so many places; more points are more rounds.
    let places = points.clamp(1, 1 << 20);
    let items = |stage: &str| match stage {
        "grid" => points,
        "total" => points + 3 * places,
        _ => places,
    };
    let mut random = Random(1);
    for repeat in 0..=a.repeat {
        let start = Clock::now();
        let mut stages: Vec<(&'static str, Time)> = Vec::new();
        let mut add = |name, time: Time| match stages.iter_mut().find(|s| s.0 == name) {
            Some((_, t)) => {
                t.wall += time.wall;
                t.cpu += time.cpu;
            }
            None => stages.push((name, time)),
        };
        for object in &scene.objects {
            limits.check()?;
            let surface = &object.surface;
            let share = places * grid_points(surface) / points.max(1);
            let list: Vec<Place> = (0..share)
                .map(|_| known(surface, random.place(surface)))
                .collect();
            let mut out = vec![Tangents::default(); list.len()];

            let clock = Clock::now();
            for p in &list {
                black_box(surface.evaluate_as::<Tangents>(p.face, p.u, p.v));
            }
            add("single", clock.elapsed());

            let faces = 0..surface.topology().face_count() as u32;
            let mut ready: Vec<Option<FaceEvaluator<'_>>> =
                faces.map(|f| surface.face_evaluator(f)).collect();
            let mut once = || {
                for p in &list {
                    if let Some(face) = &mut ready[p.face as usize] {
                        black_box(face.at_as::<Tangents>(p.u, p.v));
                    }
                }
            };
            once();
            let clock = Clock::now();
            once();
            add("prepared", clock.elapsed());

            let clock = Clock::now();
            surface
                .evaluate_many(&list, &mut out)
                .map_err(|e| Failure::usage(e.to_string()))?;
            add("batch", clock.elapsed());
            black_box(&mut out);

            let mut grid = Vec::new();
            let clock = Clock::now();
            for f in 0..surface.topology().face_count() as u32 {
                if let Some(mut face) = surface.face_evaluator(f) {
                    grid.resize(face.grid_len(GRID), Tangents::default());
                    face.grid(GRID, &mut grid)
                        .map_err(|e| Failure::usage(e.to_string()))?;
                    black_box(&mut grid);
                }
            }
            add("grid", clock.elapsed());
        }
        // The first round warms up.
        if repeat > 0 {
            push(&mut rows, "total", start.elapsed(), &items);
            for (name, time) in stages {
                push(&mut rows, name, time, &items);
            }
        }
    }
    Ok(Outcome {
        rows,
        faces: scene.face_count() as u64,
        microtriangles: 0,
        pixels: 0,
        ..Outcome::default()
    })
}
