//! `earmark bench scale`: what a frame costs against triangles, threads and samples.

use super::{Arguments, Outcome, Row, push, summary};
use crate::cli::draw;
use crate::cli::exit::Failure;
use crate::cli::job::Job;
use crate::cli::machine::pool_of;
use crate::cli::stats::{Clock, Time};
use earmark::dice::MAX_LEVEL;
use earmark::frame::{Refinement, Renderer};
use earmark::{Scene, camera::View};

/// Names of rows: triangles by level, then threads, then samples, at [`LEVEL`].
const LEVELS: [&str; 11] = [
    "level_0", "level_1", "level_2", "level_3", "level_4", "level_5", "level_6", "level_7",
    "level_8", "level_9", "level_10",
];
const THREADS: [(usize, &str); 7] = [
    (1, "threads_1"),
    (2, "threads_2"),
    (4, "threads_4"),
    (8, "threads_8"),
    (16, "threads_16"),
    (32, "threads_32"),
    (64, "threads_64"),
];
const SAMPLES: [(u32, &str); 4] = [
    (1, "samples_1"),
    (4, "samples_4"),
    (8, "samples_8"),
    (16, "samples_16"),
];

/// Level at which threads and samples vary.
const LEVEL: u32 = 5;

/// A level whose frame takes longer is the last, milliseconds.
const LONGEST: f64 = 4000.0;

/// One of the three curves: what varies, and what each value took.
pub(crate) struct Curve {
    pub(super) of: &'static str,
    pub(super) points: Vec<(f64, Time)>,
}

struct Suite<'a> {
    job: &'a Job,
    a: &'a Arguments,
    scene: &'a Scene,
    view: View,
    rows: Vec<Row>,
}

impl Suite<'_> {
    fn renderer(&self, level: u32, samples: u32) -> Renderer {
        let mut renderer = self.a.picture.renderer(&self.a.level);
        renderer.simd = self.job.simd;
        renderer.limits = self.job.limits();
        renderer.refinement = Refinement::Uniform(level);
        renderer.size.samples = samples;
        renderer
    }

    /// Measures frames of one kind in `pool`; the number of their triangles, and the best time.
    fn measure(
        &mut self,
        name: &'static str,
        renderer: &Renderer,
        pool: &rayon::ThreadPool,
    ) -> Result<(u64, Time), Failure> {
        let (scene, view) = (self.scene, &self.view);
        let frame = || pool.install(|| renderer.render_view(scene, view));
        let clock = Clock::now();
        let triangles = frame()?.stats.microtriangles;
        // A frame that takes long is its own measurement.
        let long = clock.elapsed();
        let items = |_: &str| triangles;
        if long.wall > 1000.0 {
            push(&mut self.rows, name, long, &items);
        } else {
            for _ in 0..self.a.repeat {
                let clock = Clock::now();
                frame()?;
                push(&mut self.rows, name, clock.elapsed(), &items);
            }
        }
        let best = self.rows.last().map_or(long, |row| Time {
            wall: summary(&row.times, |t| t.wall)[0],
            cpu: summary(&row.times, |t| t.cpu)[0],
        });
        Ok((triangles, best))
    }
}

/// Measures all three; levels end at `--level` (default 9), or where a frame takes seconds.
pub(super) fn scale(job: &Job, a: &Arguments, scene: &Scene) -> Result<Outcome, Failure> {
    let camera = a.picture.camera().relative_to(draw::origin(scene));
    let mut renderer = a.picture.renderer(&a.level);
    renderer.limits = job.limits();
    renderer.refinement = Refinement::Uniform(0);
    let warm = renderer.render(scene, &camera)?;
    let mut curves = Vec::new();
    let mut suite = Suite {
        job,
        a,
        scene,
        view: warm.view,
        rows: Vec::new(),
    };
    let all = pool_of(job.threads)?;
    let highest = a.level.level.unwrap_or(9).min(MAX_LEVEL);
    let mut points = Vec::new();
    let mut triangles = 0;
    for (level, name) in (0..=highest).zip(LEVELS) {
        let renderer = suite.renderer(level, a.picture.samples);
        let (count, best) = suite.measure(name, &renderer, &all)?;
        points.push((count as f64, best));
        triangles = count;
        if best.wall > LONGEST {
            break;
        }
    }
    curves.push(Curve {
        of: "triangles",
        points,
    });
    let mut points = Vec::new();
    // One step beyond the processors that there are shows what too many threads cost.
    let renderer = suite.renderer(LEVEL.min(highest), a.picture.samples);
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    for (threads, name) in THREADS.into_iter().filter(|t| t.0 <= 2 * processors) {
        let (_, best) = suite.measure(name, &renderer, &pool_of(threads)?)?;
        points.push((threads as f64, best));
    }
    curves.push(Curve {
        of: "threads",
        points,
    });
    let mut points = Vec::new();
    for (samples, name) in SAMPLES {
        let renderer = suite.renderer(LEVEL.min(highest), samples);
        let (_, best) = suite.measure(name, &renderer, &all)?;
        points.push((f64::from(samples), best));
    }
    curves.push(Curve {
        of: "samples",
        points,
    });
    Ok(Outcome {
        rows: suite.rows,
        faces: scene.face_count() as u64,
        microtriangles: triangles,
        pixels: warm.stats.pixels_covered,
        curves,
        ..Outcome::default()
    })
}
