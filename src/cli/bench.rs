//! `earmark bench`: steady state in process. One run warms caches and memory up, then each repetition is measured whole; the stages of a
//! frame come from further repetitions, because reading clocks per block takes time itself.

use super::bench_patches::{self, Found};
use super::exit::Failure;
use super::flags::{Backend, LevelFlags, ModelFlags, PictureFlags, RunningFlags};
use super::job::{Job, commit_all, print_text};
use super::render::{check_picture, input_paths, stats_output};
use super::stats::{Clock, Json, Stages, Time, frame_stages};
use super::watch::{self, Phase};
use super::{bench_calibrate, bench_cold, bench_page, bench_scale};
use clap::{Args, ValueEnum};
use earmark::frame::{Drawing, Finished, FrameStats, Renderer};
use earmark::limits::Limits;
use earmark::records::Grid3;
use earmark::simd::Level;
use earmark::stream::BlockStream;
use earmark::{Cage, Scene, Surface, SurfaceOptions};
use rayon::prelude::*;
use std::fmt::Write;
use std::hint::black_box;
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

/// Level of `bench refine` without `--level`.
const REFINE_LEVEL: u32 = 4;

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
pub(super) struct Outcome {
    pub(super) rows: Vec<Row>,
    pub(super) faces: u64,
    pub(super) microtriangles: u64,
    pub(super) pixels: u64,
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
    let page = match &a.page {
        Some(page) => Some(stats_output(page, Path::new(""), &input_paths(&models))?),
        None => None,
    };
    let mut scene = if models.is_empty() {
        let options = SurfaceOptions {
            patches: a.level.patches(),
            ..a.model.surface()
        };
        Scene::of(Surface::new(torus()?, &options))
    } else {
        job.load(&models, &a.model, &a.level)?
    };
    job.read_depth_tags(&mut scene, &a.level)?;
    watch::phase(Phase::Measuring);
    let mut distances = Vec::new();
    let mut curves = Vec::new();
    let mut factor = None;
    let mut child_peak = None;
    let outcome = match a.suite {
        Suite::Refine => refine(job, a, &mut scene)?,
        Suite::Frame if a.picture.backend == Backend::Gpu => super::gpu::frame(job, a, &scene)?,
        Suite::Frame => frame(job, a, &mut scene, a.level.drawing(), true)?,
        Suite::Patches => bench_patches::patches(job, a, &scene, &mut distances)?,
        Suite::Evaluate => super::bench_evaluate::evaluate(job, a, &mut scene)?,
        Suite::Paper => super::bench_paper::paper(job, a)?,
        Suite::Calibrate => bench_calibrate::calibrate(job, a, factor.insert(1.0))?,
        Suite::Cold => bench_cold::cold(job, a, &torus()?, child_peak.insert(0))?,
        Suite::Scale => bench_scale::scale(job, a, &scene, &mut curves)?,
        Suite::Raster => frame(job, a, &mut scene, Drawing::Cage, false)?,
        Suite::Gpu => super::gpu::suite(job, a, &scene)?,
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
    let mut report = report(job, a, Json::text(&*name), &outcome);
    if let (Json::Object(members), false) = (&mut report, distances.is_empty()) {
        let all = distances.iter().map(Found::json).collect();
        members.push(("distances".to_owned(), Json::List(all)));
    }
    if let Json::Object(members) = &mut report {
        members.extend(factor.map(bench_calibrate::member));
        let peak = members.iter_mut().find(|(name, _)| name == "peak_bytes");
        if let (Some((_, value)), Some(bytes)) = (peak, child_peak) {
            *value = Json::Whole(bytes);
        }
    }
    let mut staged = Vec::new();
    if let Some(page) = page {
        let title = format!("earmark bench scale: {name}");
        staged.push(page.stage(bench_page::page(&title, &curves).as_bytes())?);
    }
    if let Some(stats) = stats {
        staged.push(stats.stage(format!("{report}\n").as_bytes())?);
    }
    if a.json {
        print_text(&format!("{report}\n"))?;
    } else {
        print_text(&table(job, a, &outcome))?;
        if let Some(factor) = factor {
            print_text(&bench_calibrate::line(factor))?;
        }
        if let Some(bytes) = child_peak {
            print_text(&format!("peak {:.1} MB\n", bytes as f64 / 1e6))?;
        }
        if !distances.is_empty() {
            print_text(&bench_patches::table(&distances))?;
        }
    }
    commit_all(staged)
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

/// Puts the cages' own points in again, as an animation would put new ones.
fn update(scene: &mut Scene, points: &[Vec<[f32; 3]>]) -> Result<(), Failure> {
    for (object, points) in scene.objects.iter_mut().zip(points) {
        object
            .surface
            .update_points(points)
            .map_err(|e| Failure::usage(e.to_string()))?;
    }
    Ok(())
}

fn frame(
    job: &Job,
    a: &Arguments,
    scene: &mut Scene,
    drawing: Drawing,
    animated: bool,
) -> Result<Outcome, Failure> {
    let mut renderer = a.picture.renderer(&a.level);
    renderer.simd = job.simd;
    renderer.drawing = drawing;
    renderer.limits = job.limits();
    let mut camera = a.picture.camera();
    if let Some(first) = scene.objects.first() {
        camera = camera.relative_to(first.surface.cage().origin());
    }
    let points: Vec<Vec<[f32; 3]>> = scene
        .objects
        .iter()
        .map(|o| o.surface.cage().points().to_vec())
        .collect();
    let warm = renderer.render(scene, &camera)?;
    let view = warm.view;
    let mut once = |renderer: &Renderer| -> Result<(Time, Time, Finished), Failure> {
        let clock = Clock::now();
        if animated {
            update(scene, &points)?;
        }
        let updated = clock.elapsed();
        let finished = renderer.render_view(scene, &view)?;
        Ok((clock.elapsed(), updated, finished))
    };
    let items = items_of(&warm.stats, points.iter().map(|p| p.len() as u64).sum(), a);
    let mut rows = Vec::new();
    for _ in 0..a.repeat {
        let (total, _, _) = once(&renderer)?;
        push(&mut rows, "total", total, &items);
    }
    renderer.measure = true;
    for _ in 0..a.repeat {
        let (total, updated, finished) = once(&renderer)?;
        let mut stages = Stages::default();
        if animated {
            stages.add("update", updated);
        }
        stages
            .0
            .extend(frame_stages(&finished.stats, total.cpu - updated.cpu).0);
        for (name, time) in stages.0 {
            push(&mut rows, name, time, &items);
        }
    }
    Ok(Outcome {
        rows,
        faces: warm.stats.faces,
        microtriangles: warm.stats.microtriangles,
        pixels: warm.stats.pixels_covered,
    })
}

/// What a stage's time is divided by.
fn items_of(
    stats: &FrameStats,
    vertices: u64,
    a: &Arguments,
) -> impl Fn(&'static str) -> u64 + use<> {
    let (faces, triangles) = (stats.faces, stats.microtriangles);
    let samples = stats.pixels_covered * u64::from(a.picture.samples);
    let pixels = u64::from(a.picture.size[0]) * u64::from(a.picture.size[1]);
    move |stage| match stage {
        "update" => vertices,
        "setup" | "bin" => faces,
        "shade" => samples,
        "film" => pixels,
        _ => triangles,
    }
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

/// Dices everything and keeps nothing.
pub(super) fn dice_all(
    scene: &Scene,
    level: u32,
    normals: bool,
    simd: Level,
    limits: &Limits,
) -> Result<(), Failure> {
    /// Quads between two looks at the limits.
    const CHUNK: u32 = 64;
    for object in &scene.objects {
        let surface = &object.surface;
        let quads = surface.quads().face_count() as u32;
        let level = level.saturating_sub(u32::from(surface.is_split()));
        (0..quads.div_ceil(CHUNK))
            .into_par_iter()
            .try_for_each_init(
                || {
                    let stream = BlockStream::new(surface, level).with_simd(simd);
                    (stream, Grid3::boxed(), Grid3::boxed())
                },
                |(stream, points, unit), chunk| {
                    limits.check()?;
                    for q in chunk * CHUNK..((chunk + 1) * CHUNK).min(quads) {
                        if surface.quads().is_hole(q) {
                            continue;
                        }
                        stream.quad(q, |stream, u, v| {
                            let unit = if normals { Some(&mut **unit) } else { None };
                            stream.dice(u, v, points, unit);
                            black_box(&mut *points);
                        });
                        black_box(&mut *unit);
                    }
                    Ok::<_, earmark::limits::LimitError>(())
                },
            )?;
    }
    Ok(())
}

/// Vertices of the refined mesh, each counted once.
fn unique_vertices(surface: &Surface, level: u32) -> u64 {
    let t = surface.quads();
    let n = 1_u64 << level.saturating_sub(u32::from(surface.is_split()));
    t.vertex_count() as u64
        + t.edge_count() as u64 * (n - 1)
        + t.face_count() as u64 * (n - 1) * (n - 1)
}

fn refine(job: &Job, a: &Arguments, scene: &mut Scene) -> Result<Outcome, Failure> {
    let level = a.level.level.unwrap_or(REFINE_LEVEL);
    let limits = job.limits();
    let points: Vec<Vec<[f32; 3]>> = scene
        .objects
        .iter()
        .map(|o| o.surface.cage().points().to_vec())
        .collect();
    let vertices = scene
        .objects
        .iter()
        .map(|o| unique_vertices(&o.surface, level))
        .sum();
    let faces: u64 = scene
        .objects
        .iter()
        .map(|o| {
            let level = level.saturating_sub(u32::from(o.surface.is_split()));
            (o.surface.quads().face_count() as u64) << (2 * level)
        })
        .sum();
    limits.faces(u128::from(faces))?;
    let cage_vertices = points.iter().map(|p| p.len() as u64).sum();
    let items = |stage: &str| match stage {
        "update" => cage_vertices,
        _ => vertices,
    };
    let mut rows = Vec::new();
    dice_all(scene, level, a.normals, job.simd, &limits)?;
    for _ in 0..a.repeat {
        let clock = Clock::now();
        update(scene, &points)?;
        let updated = clock.elapsed();
        dice_all(scene, level, a.normals, job.simd, &limits)?;
        let total = clock.elapsed();
        push(&mut rows, "total", total, &items);
        push(&mut rows, "update", updated, &items);
        let dice = Time {
            wall: total.wall - updated.wall,
            cpu: total.cpu - updated.cpu,
        };
        push(&mut rows, "dice", dice, &items);
    }
    Ok(Outcome {
        rows,
        faces: scene.face_count() as u64,
        microtriangles: 2 * faces,
        pixels: 0,
    })
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

impl Row {
    fn ns_per_item(&self) -> f64 {
        let [wall, _] = summary(&self.times, |t| t.wall);
        if self.items == 0 {
            0.0
        } else {
            wall * 1e6 / self.items as f64
        }
    }
}

fn report(job: &Job, a: &Arguments, model: Json, outcome: &Outcome) -> Json {
    let mut stages = Stages::default();
    for row in outcome.rows.iter().filter(|r| r.stage != "total") {
        let [wall, cpu] = [
            summary(&row.times, |t| t.wall)[0],
            summary(&row.times, |t| t.cpu)[0],
        ];
        stages.add(row.stage, Time { wall, cpu });
    }
    let middle = vec![
        ("faces", Json::Whole(outcome.faces)),
        ("microtriangles", Json::Whole(outcome.microtriangles)),
        ("pixels_covered", Json::Whole(outcome.pixels)),
    ];
    let mut members = job.report(model, middle);
    for (name, value) in &mut members {
        if name == "stages" {
            *value = stages.json();
        }
    }
    let rows = outcome.rows.iter().map(|row| {
        let [wall, cpu] = [
            summary(&row.times, |t| t.wall),
            summary(&row.times, |t| t.cpu),
        ];
        Json::object([
            ("stage", Json::text(row.stage)),
            ("wall_ms_min", Json::Number(wall[0])),
            ("wall_ms_median", Json::Number(wall[1])),
            ("cpu_ms_min", Json::Number(cpu[0])),
            ("cpu_ms_median", Json::Number(cpu[1])),
            ("items", Json::Whole(row.items)),
            ("ns_per_item_min", Json::Number(row.ns_per_item())),
        ])
    });
    let rows = rows
        .zip(&outcome.rows)
        .map(|(json, row)| match (json, row.published) {
            (Json::Object(mut members), Some(p)) => {
                let [wall, _] = summary(&row.times, |t| t.wall);
                members.extend([
                    ("coarse_faces".to_owned(), Json::Whole(p.coarse)),
                    ("published_ms".to_owned(), Json::Number(p.milliseconds)),
                    (
                        "times_published".to_owned(),
                        Json::Exact(wall / p.milliseconds),
                    ),
                ]);
                Json::Object(members)
            }
            (json, _) => json,
        });
    members.push(("repeat".to_owned(), Json::Whole(u64::from(a.repeat))));
    members.push(("rows".to_owned(), Json::List(rows.collect())));
    Json::Object(members)
}

fn table(job: &Job, a: &Arguments, outcome: &Outcome) -> String {
    let longest = outcome.rows.iter().map(|r| r.stage.len()).max();
    let width = longest.unwrap_or(0).max(8);
    let named = outcome.rows.iter().any(|r| r.published.is_some());
    let mut out = format!(
        "{} faces, {} micro-triangles, {} threads, {}, best and median of {}\n{:<width$}{:>12}{:>12}{:>12}{:>12}{:>12}{:>10}{}\n",
        outcome.faces,
        outcome.microtriangles,
        job.threads,
        job.simd.name(),
        a.repeat,
        "stage",
        "wall ms",
        "median",
        "cpu ms",
        "median",
        "items",
        "ns/item",
        if named {
            "   faces published ms  times"
        } else {
            ""
        },
    );
    for row in &outcome.rows {
        let [wall, cpu] = [
            summary(&row.times, |t| t.wall),
            summary(&row.times, |t| t.cpu),
        ];
        let published = row.published.map_or_else(String::new, |p| {
            let (ms, times) = (p.milliseconds, wall[0] / p.milliseconds);
            format!("{:>8}{ms:>13.3}{times:>7.2}", p.coarse)
        });
        let _ = writeln!(
            out,
            "{:<width$}{:>12.3}{:>12.3}{:>12.3}{:>12.3}{:>12}{:>10.2}{}",
            row.stage,
            wall[0],
            wall[1],
            cpu[0],
            cpu[1],
            row.items,
            row.ns_per_item(),
            published,
        );
    }
    out
}
