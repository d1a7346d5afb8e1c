//! `bench gpu`, and `bench frame` on a device.

use super::paper::{CUBES, cube_cage, uniform_rows};
use super::{Arguments, Outcome, Published, Row, publish, push};
use crate::cli::exit::Failure;
use crate::cli::gpu::{ms, open};
use crate::cli::job::Job;
use crate::cli::stats::{Clock, Time};
use earmark::frame::Refinement;
use earmark::gpu::{Gpu, GpuScene, GpuStats, Raster, Refiner};
use earmark::{Camera, Renderer, Scene, Surface};

/// Times of steady frames: points up, all stages, picture down; then those of the stages, because keeping them takes time itself.
fn measure(
    (gpu, raster): (&Gpu, Raster),
    renderer: &mut Renderer,
    scene: &Scene,
    camera: &Camera,
    repeat: u32,
    mut found: impl FnMut(&'static str, Time, &GpuStats),
) -> Result<GpuStats, Failure> {
    renderer.measure = false;
    let points: Vec<[f32; 3]> = scene
        .objects
        .iter()
        .flat_map(|o| o.surface.cage().points().iter().copied())
        .collect();
    let mut ready = GpuScene::new(gpu, renderer, scene, camera)?;
    ready.raster_by(raster)?;
    let warm = ready.draw()?;
    for _ in 0..repeat {
        renderer.limits.check()?;
        let clock = Clock::now();
        ready.move_points(&points)?;
        let drawn = ready.draw()?;
        found("total", clock.elapsed(), &drawn.stats);
    }
    ready.measuring(true)?;
    for _ in 0..repeat {
        renderer.limits.check()?;
        ready.move_points(&points)?;
        let drawn = ready.draw()?;
        for &(name, time) in &drawn.stats.stages {
            found(name, ms(time), &drawn.stats);
        }
    }
    Ok(warm.stats)
}

fn renderer(job: &Job, a: &Arguments) -> Renderer {
    let mut renderer = a.picture.renderer(&a.level);
    renderer.simd = job.simd;
    renderer.limits = job.limits();
    renderer
}

/// `bench frame --backend gpu`.
pub(super) fn frame(job: &Job, a: &Arguments, scene: &Scene) -> Result<Outcome, Failure> {
    let gpu = open(&a.picture)?;
    let mut rows: Vec<Row> = Vec::new();
    let mut camera = a.picture.camera();
    if let Some(first) = scene.objects.first() {
        camera = camera.relative_to(first.surface.cage().origin());
    }
    let mut renderer = renderer(job, a);
    let stats = measure(
        (&gpu, Raster::default()),
        &mut renderer,
        scene,
        &camera,
        a.repeat,
        |name, time, s| {
            push(&mut rows, name, time, &|_| s.microtriangles);
        },
    )?;
    Ok(Outcome {
        rows,
        faces: stats.faces,
        microtriangles: stats.microtriangles,
        pixels: stats.pixels_covered,
        ..Outcome::default()
    })
}

/// A level, what draws keys, and the names of its rows by stage.
type LevelRows = (u32, Raster, &'static [(&'static str, &'static str)]);

/// Rows of a model.
const LEVELS: [LevelRows; 4] = [
    (
        5,
        Raster::Compute,
        &[
            ("total", "l5-total"),
            ("dice", "l5-dice"),
            ("tile", "l5-tile"),
            ("shade", "l5-shade"),
            ("film", "l5-film"),
        ],
    ),
    (
        5,
        Raster::Hardware,
        &[("total", "l5-raster-total"), ("raster", "l5-raster")],
    ),
    (
        6,
        Raster::Compute,
        &[
            ("total", "l6-total"),
            ("dice", "l6-dice"),
            ("tile", "l6-tile"),
            ("shade", "l6-shade"),
            ("film", "l6-film"),
        ],
    ),
    (
        6,
        Raster::Hardware,
        &[("total", "l6-raster-total"), ("raster", "l6-raster")],
    ),
];

/// Names of the papers' rows where the device's own rasteriser draws.
const PAPERS_BY_HARDWARE: [(&str, &str); 8] = [
    ("gamer-65000", "gamer-65000-raster"),
    ("gamer-4000", "gamer-4000-raster"),
    ("qas-2720", "qas-2720-raster"),
    ("qas-2516", "qas-2516-raster"),
    ("qas-546", "qas-546-raster"),
    ("antal-0", "antal-0-raster"),
    ("antal-1", "antal-1-raster"),
    ("antal-2", "antal-2-raster"),
];

/// `bench gpu`: everything that is compared with figures from elsewhere, in one run.
pub(super) fn suite(job: &Job, a: &Arguments, scene: &Scene) -> Result<Outcome, Failure> {
    let gpu = open(&a.picture)?;
    let mut rows: Vec<Row> = Vec::new();
    let mut last = GpuStats::default();
    let mut plain = renderer(job, a);
    for (level, raster, names) in LEVELS {
        plain.refinement = Refinement::Uniform(level);
        let camera = a.picture.camera();
        last = measure(
            (&gpu, raster),
            &mut plain,
            scene,
            &camera,
            a.repeat,
            |name, time, s| {
                if let Some(&(_, row)) = names.iter().find(|n| n.0 == name) {
                    push(&mut rows, row, time, &|_| s.microtriangles);
                }
            },
        )?;
    }
    plain.size.samples = 1;
    for row in uniform_rows() {
        plain.refinement = Refinement::Uniform(row.level);
        let scene = Scene::of(Surface::new(row.cage?, &row.options));
        let by_hardware = PAPERS_BY_HARDWARE.iter().find(|n| n.0 == row.name);
        let by_hardware = by_hardware.map(|n| (n.1, Raster::Hardware));
        for (own, raster) in [(row.name, Raster::Compute)].into_iter().chain(by_hardware) {
            let stats = measure(
                (&gpu, raster),
                &mut plain,
                &scene,
                &Camera::default(),
                a.repeat,
                |name, time, s| {
                    if name == "total" {
                        push(&mut rows, own, time, &|_| s.microtriangles);
                    }
                },
            )?;
            let published = Published {
                milliseconds: row.published_ms,
                coarse: stats.faces,
            };
            publish(&mut rows, own, published);
        }
    }
    for (name, iterations, [_, published]) in CUBES {
        let surface = Surface::new(cube_cage()?, &earmark::SurfaceOptions::default());
        let refiner = Refiner::new(&gpu, &surface, iterations)?;
        // The first one warms up.
        refiner.timed(&gpu)?;
        for _ in 0..a.repeat {
            let time = ms(refiner.timed(&gpu)?);
            let faces = u64::from(refiner.face_count());
            push(&mut rows, name, time, &|_| 2 * faces);
        }
        let published = Published {
            milliseconds: published * 1e3,
            coarse: 6,
        };
        publish(&mut rows, name, published);
    }
    Ok(Outcome {
        rows,
        faces: last.faces,
        microtriangles: last.microtriangles,
        pixels: last.pixels_covered,
        ..Outcome::default()
    })
}
