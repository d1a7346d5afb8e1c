//! `earmark bench`: steady state in process. One run warms caches and memory up, then each repetition is measured whole; the stages of a
//! frame come from further repetitions, because reading clocks per block takes time itself.

mod calibrate;
mod cold;
mod evaluate;
mod frame;
#[cfg(feature = "gpu")]
mod gpu;
mod page;
mod paper;
mod patches;
mod refine;
mod report;
mod scale;

use super::exit::Failure;
use super::flags::{Backend, LevelFlags, ModelFlags, PictureFlags, RunningFlags};
#[cfg(not(feature = "gpu"))]
use super::gpu;
use super::job::Job;
use super::outputs::{commit_all, print_text};
use super::render::{check_picture, input_paths, stats_output};
use super::stats::{Json, Time};
use super::watch::{self, Phase};
use clap::{Args, ValueEnum};
use earmark::files::same_file;
use earmark::frame::Drawing;
use earmark::{Cage, Scene, Surface, SurfaceOptions};
use scale::Curve;
use std::path::{Path, PathBuf};

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Suite {
    /// Limit points of a uniform level, without a picture
    Refine,
    /// A frame of an animated cage: new points, then a picture
    Frame,
    /// The polygons as given
    Raster,
    /// Limit points and first derivatives anywhere: one place at a time, from prepared faces, in a batch, on grids of 17 by 17
    Evaluate,
    /// QAS and PN patches: time per point of a uniform level (default 4) against that of the limit surface, and distances from it
    Patches,
    /// Two fixed pieces of arithmetic and copying, by which milliseconds of machines can be compared
    Calibrate,
    /// `render` in a fresh process each time, from file to PNG; takes the flags of render
    Cold,
    /// Frames against triangles (uniform levels up to --level, default 9), threads and samples; --page FILE plots them
    Scale,
    /// Tables of the papers again, on cages of as many faces that are made here: frames of 1024 by 1024 with one sample, and what was
    /// published for a GPU
    Paper,
    /// With feature gpu: MODEL (or the torus) at levels 5 and 6, the papers' uniform rows and the cube's whole-mesh levels on a GPU
    Gpu,
}

#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// What is measured
    #[arg(value_enum, value_name = "SUITE")]
    pub(crate) suite: Suite,
    /// Model (OBJ); - is standard input [default: a torus of 4096 quads]
    #[arg(value_name = "MODEL")]
    pub(crate) model_path: Option<PathBuf>,
    /// Repetitions that are measured, 1 to 100000
    #[arg(long, value_name = "K", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=100_000), allow_hyphen_values = true)]
    pub(crate) repeat: u32,
    /// refine: unit limit normals too
    #[arg(long)]
    pub(crate) normals: bool,
    /// scale: write a page with plots (HTML)
    #[arg(long, value_name = "FILE")]
    pub(crate) page: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) model: ModelFlags,
    #[command(flatten)]
    pub(crate) level: LevelFlags,
    #[command(flatten)]
    pub(crate) picture: PictureFlags,
    #[command(flatten)]
    pub(crate) running: RunningFlags,
}

/// Times of one stage over the repetitions.
pub(super) struct Row {
    pub(super) stage: &'static str,
    pub(super) times: Vec<Time>,
    pub(super) items: u64,
    published: Option<Published>,
}

/// What a paper has in a row.
#[derive(Clone, Copy)]
pub(super) struct Published {
    pub(super) milliseconds: f64,
    /// Faces of the cage.
    pub(super) coarse: u64,
}

/// Notes what was published for a row.
pub(super) fn publish(rows: &mut [Row], stage: &'static str, published: Published) {
    for row in rows.iter_mut().filter(|r| r.stage == stage) {
        row.published = Some(published);
    }
}

/// What a suite found.
#[derive(Default)]
pub(super) struct Outcome {
    pub(super) rows: Vec<Row>,
    pub(super) faces: u64,
    pub(super) microtriangles: u64,
    pub(super) pixels: u64,
    /// Most memory held, where it is not that of this process.
    pub(super) peak_bytes: Option<u64>,
    /// More members of the report, and the same as lines below the table.
    pub(super) members: Vec<(String, Json)>,
    pub(super) lines: String,
    /// What a page of plots shows.
    pub(super) curves: Vec<Curve>,
}

pub(crate) fn run(job: &mut Job, a: &Arguments) -> Result<(), Failure> {
    let models: Vec<PathBuf> = a.model_path.iter().cloned().collect();
    let stats = match &a.running.stats {
        Some(stats) => Some(stats_output(stats, Path::new(""), &input_paths(&models))?),
        None => None,
    };
    check_picture(&a.picture, &job.limits(), 8)?;
    if a.picture.backend == Backend::Gpu || a.suite == Suite::Gpu {
        if !matches!(a.suite, Suite::Frame | Suite::Cold | Suite::Gpu) {
            return Err(Failure::usage(
                "--backend gpu belongs to bench frame, cold and gpu; the other suites measure the processor",
            ));
        }
        super::gpu::check()?;
    }
    let modelless = match a.suite {
        Suite::Paper => Some("paper"),
        Suite::Calibrate => Some("calibrate"),
        _ => None,
    };
    if let Some(suite) = modelless.filter(|_| !models.is_empty()) {
        return Err(Failure::usage(format!("bench {suite} takes no model")));
    }
    // Processes of their own draw what they are asked.
    if a.picture.line_work().is_some() && a.suite != Suite::Cold {
        return Err(Failure::usage(
            "bench draws no lines: leave --overlay and --shade wireframe to render",
        ));
    }
    if a.page.is_some() && a.suite != Suite::Scale {
        return Err(Failure::usage("--page belongs to bench scale"));
    }
    if let (Some(page), Some(stats)) = (&a.page, &a.running.stats)
        && (page == stats || same_file(page, stats))
    {
        return Err(Failure::usage("--page and --stats are the same"));
    }
    let page = match &a.page {
        Some(page) => Some(stats_output(page, Path::new(""), &input_paths(&models))?),
        None => None,
    };
    let mut scene = scene(job, a, &models)?;
    watch::phase(Phase::Measuring);
    let outcome = match a.suite {
        Suite::Refine => refine::refine(job, a, &mut scene)?,
        Suite::Frame if a.picture.backend == Backend::Gpu => gpu::frame(job, a, &scene)?,
        Suite::Frame => frame::frame(job, a, &mut scene, a.level.drawing(), true)?,
        Suite::Raster => frame::frame(job, a, &mut scene, Drawing::Cage, false)?,
        Suite::Patches => patches::patches(job, a, &scene)?,
        Suite::Evaluate => evaluate::evaluate(job, a, &mut scene)?,
        Suite::Scale => scale::scale(job, a, &scene)?,
        Suite::Gpu => gpu::suite(job, a, &scene)?,
        Suite::Cold => cold::cold(job, a, &torus()?)?,
        Suite::Paper => paper::paper(job, a)?,
        Suite::Calibrate => calibrate::calibrate(job, a)?,
    };
    let built_in = match a.suite {
        Suite::Paper => "paper",
        Suite::Calibrate => "none",
        _ => "torus",
    };
    let name = a
        .model_path
        .as_ref()
        .map_or_else(|| built_in.to_owned(), |p| p.display().to_string());
    let text = match (a.json, &stats) {
        (false, None) => String::new(),
        _ => format!("{}\n", report::report(job, a, Json::text(&*name), &outcome)),
    };
    let mut staged = Vec::new();
    if let Some(page) = page {
        let title = format!("earmark bench scale: {name}");
        staged.push(page.stage(page::page(&title, &outcome.curves).as_bytes())?);
    }
    if let Some(stats) = stats {
        staged.push(stats.stage(text.as_bytes())?);
    }
    match a.json {
        true => print_text(&text)?,
        false => print_text(&(report::table(job, a, &outcome) + &outcome.lines))?,
    }
    commit_all(staged)
}

/// What is measured; empty for suites that make or read their own.
fn scene(job: &mut Job, a: &Arguments, models: &[PathBuf]) -> Result<Scene, Failure> {
    if matches!(a.suite, Suite::Paper | Suite::Calibrate | Suite::Cold) {
        return Ok(Scene::default());
    }
    let mut scene = if models.is_empty() {
        let options = SurfaceOptions {
            patches: a.level.patches(),
            ..a.model.surface()
        };
        Scene::of(Surface::new(torus()?, &options))
    } else {
        job.load(models, &a.model, &a.level)?
    };
    job.read_depth_tags(&mut scene, &a.level)?;
    Ok(scene)
}

/// The built-in model: 64 by 64 quads.
fn torus() -> Result<Cage, Failure> {
    const N: u32 = 64;
    let angle = |k: u32| f64::from(k) / f64::from(N) * std::f64::consts::TAU;
    let points = (0..N * N).map(|i| {
        let (a, b) = (angle(i / N), angle(i % N));
        let r = 1.0 + 0.4 * libm::cos(b);
        [r * libm::sin(a), 0.4 * libm::sin(b), r * libm::cos(a)].map(|c| c as f32)
    });
    let at = |i: u32, j: u32| i % N * N + j % N;
    let corners = (0..N * N).flat_map(|k| {
        let (i, j) = (k / N, k % N);
        [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
    });
    Cage::new(points.collect(), &[4; (N * N) as usize], corners.collect())
        .map_err(|e| Failure::usage(e.to_string()))
}

pub(super) fn push(
    rows: &mut Vec<Row>,
    stage: &'static str,
    time: Time,
    items: &impl Fn(&'static str) -> u64,
) {
    match rows.iter_mut().find(|r| r.stage == stage) {
        Some(row) => row.times.push(time),
        None => rows.push(Row {
            stage,
            times: vec![time],
            items: items(stage),
            published: None,
        }),
    }
}

/// Smallest and middle value.
pub(super) fn summary(times: &[Time], of: fn(&Time) -> f64) -> [f64; 2] {
    let mut values: Vec<f64> = times.iter().map(of).collect();
    values.sort_by(f64::total_cmp);
    match values.as_slice() {
        [] => [0.0; 2],
        v if v.len() % 2 == 1 => [v[0], v[v.len() / 2]],
        v => [v[0], (v[v.len() / 2 - 1] + v[v.len() / 2]) * 0.5],
    }
}
