//! `--backend gpu`, `info --gpu` and the measurements of it. Without feature `gpu` all of them say so, with the exit code of what is not
//! available.

use super::stats::Json;
use earmark::frame::Finished;

#[cfg(all(feature = "gpu", feature = "window"))]
pub(super) use with::{Kept, draw_kept, ready};
#[cfg(feature = "gpu")]
pub(super) use with::{check, draw, frame, list, suite};
#[cfg(all(not(feature = "gpu"), feature = "window"))]
pub(super) use without::{Kept, draw_kept, ready};
#[cfg(not(feature = "gpu"))]
pub(super) use without::{check, draw, frame, list, suite};

/// What statistics say of a picture beside what every picture has.
pub(super) type Said = Vec<(&'static str, Json)>;

/// A picture, and what is said of it.
pub(super) type Drawn = (Finished, Said);

#[cfg(not(feature = "gpu"))]
mod without {
    use super::Drawn;
    use crate::cli::bench::{Arguments, Outcome};
    use crate::cli::exit::{Code, Failure};
    use crate::cli::flags::PictureFlags;
    use crate::cli::job::Job;
    use earmark::{Camera, Renderer, Scene};

    fn missing<T>() -> Result<T, Failure> {
        let message = "earmark: this earmark was built without feature gpu; there is: cpu";
        Err(Failure::new(Code::Unavailable, message))
    }

    pub(in crate::cli) fn check() -> Result<(), Failure> {
        missing()
    }
    pub(in crate::cli) fn list(_: bool) -> Result<(), Failure> {
        missing()
    }

    /// What a window keeps from picture to picture.
    #[cfg(feature = "window")]
    #[derive(Default)]
    pub(in crate::cli) struct Kept;

    #[cfg(feature = "window")]
    pub(in crate::cli) fn ready(_: &PictureFlags) -> Result<(), Failure> {
        missing()
    }
    #[cfg(feature = "window")]
    pub(in crate::cli) fn draw_kept(
        _: &mut Kept,
        _: &PictureFlags,
        _: &Renderer,
        _: &Scene,
        _: earmark::camera::View,
    ) -> Result<earmark::frame::Finished, Failure> {
        missing()
    }
    pub(in crate::cli) fn draw(
        _: &mut Job,
        _: &PictureFlags,
        _: &Renderer,
        _: &Scene,
        _: &Camera,
    ) -> Result<Drawn, Failure> {
        missing()
    }
    pub(in crate::cli) fn frame(_: &Job, _: &Arguments, _: &Scene) -> Result<Outcome, Failure> {
        missing()
    }
    pub(in crate::cli) fn suite(_: &Job, _: &Arguments, _: &Scene) -> Result<Outcome, Failure> {
        missing()
    }
}

#[cfg(feature = "gpu")]
mod with {
    use super::Drawn;
    use crate::cli::bench::paper::{CUBES, cube_cage, uniform_rows};
    use crate::cli::bench::{Arguments, Outcome, Published, Row, publish, push};
    use crate::cli::exit::{Code, Failure};
    use crate::cli::flags::PictureFlags;
    use crate::cli::job::Job;
    use crate::cli::outputs::print_text;
    use crate::cli::stats::{Clock, Json, Time};
    use earmark::frame::{Finished, FrameStats, Refinement};
    use earmark::gpu::{
        DeviceOptions, Gpu, GpuError, GpuScene, GpuStats, Raster, Refiner, adapters,
    };
    use earmark::{Camera, Renderer, Scene, Surface};
    use std::fmt::Write;
    use std::time::Duration;

    impl From<GpuError> for Failure {
        fn from(e: GpuError) -> Self {
            match e {
                GpuError::Limit(e) => e.into(),
                GpuError::Render(e) => e.into(),
                e @ GpuError::OutOfMemory { .. } => Self::new(Code::Limit, format!("earmark: {e}")),
                e => Self::new(Code::Unavailable, format!("earmark: {e}")),
            }
        }
    }

    pub(in crate::cli) fn check() -> Result<(), Failure> {
        Ok(())
    }

    fn open(picture: &PictureFlags) -> Result<Gpu, Failure> {
        Ok(Gpu::open(&DeviceOptions {
            allow_software: picture.allow_software_gpu,
            ..DeviceOptions::default()
        })?)
    }

    /// The device that a window draws on, for as long as the program runs.
    #[cfg(feature = "window")]
    static DEVICE: std::sync::Mutex<Option<&'static Gpu>> = std::sync::Mutex::new(None);

    /// What a window keeps from picture to picture: the last scene on the device, with what it was made by.
    #[cfg(feature = "window")]
    #[derive(Default)]
    pub(in crate::cli) struct Kept {
        last: Option<(String, GpuScene<'static>)>,
        /// Scenes since the device was last asked to decide on blocks.
        since: u32,
    }

    /// As many scenes have their blocks from the processor before the device is asked again.
    #[cfg(feature = "window")]
    const PATIENCE: u32 = 16;

    #[cfg(feature = "window")]
    fn device(picture: &PictureFlags) -> Result<&'static Gpu, Failure> {
        let mut kept = DEVICE
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        match *kept {
            Some(gpu) => Ok(gpu),
            // One for the program: scenes of it are kept beside.
            None => Ok(kept.insert(Box::leak(Box::new(open(picture)?)))),
        }
    }

    /// Whether there is a device to draw on.
    #[cfg(feature = "window")]
    pub(in crate::cli) fn ready(picture: &PictureFlags) -> Result<(), Failure> {
        device(picture).map(|_| ())
    }

    /// Draws a scene, which stays on the device for the next picture: of the same scene, or `kept` is made anew.
    #[cfg(feature = "window")]
    pub(in crate::cli) fn draw_kept(
        kept: &mut Kept,
        picture: &PictureFlags,
        renderer: &Renderer,
        scene: &Scene,
        view: earmark::camera::View,
    ) -> Result<Finished, Failure> {
        let made_by = format!(
            "{:?} {:?} {:?} {:?} {:?} {:?}",
            renderer.size,
            renderer.refinement,
            renderer.drawing,
            renderer.mode,
            renderer.background,
            renderer.light_turn
        );
        let serves = match &kept.last {
            Some((by, ready)) if *by == made_by => ready.serves(renderer, scene, &view)?,
            _ => false,
        };
        if !serves {
            // Views near the last one ask for as much. Its memory first.
            let again = kept
                .last
                .take()
                .is_some_and(|(by, last)| by == made_by && !last.decides());
            kept.since = if again {
                (kept.since + 1) % PATIENCE
            } else {
                0
            };
            let make = match kept.since {
                0 => GpuScene::for_view,
                _ => GpuScene::decided_by_processor,
            };
            let ready = make(device(picture)?, renderer, scene, view)?;
            kept.last = Some((made_by, ready));
        }
        let Some((_, ready)) = &mut kept.last else {
            return Err(GpuError::Missing { what: "scene" }.into());
        };
        let drawn = match ready.draw_view(&view) {
            Ok(drawn) if !drawn.stats.falls_short => drawn,
            // Made for this view, it is another.
            Ok(_) | Err(GpuError::OutOfMemory { .. }) if serves => {
                kept.last = None;
                return draw_kept(kept, picture, renderer, scene, view);
            }
            Ok(drawn) => drawn,
            Err(e) => {
                kept.last = None;
                return Err(e.into());
            }
        };
        Ok(Finished {
            stats: frame_stats(&drawn.stats),
            image: drawn.image,
            planes: drawn.planes,
            view: drawn.view,
        })
    }

    /// `info --gpu`.
    pub(in crate::cli) fn list(json: bool) -> Result<(), Failure> {
        let all = adapters();
        if json {
            let list = all.iter().map(|a| {
                Json::object([
                    ("name", Json::text(&*a.name)),
                    ("kind", Json::text(a.kind.name())),
                    ("backend", Json::text(&*a.backend)),
                    ("driver", Json::text(&*a.driver)),
                    ("max_binding_bytes", Json::Whole(a.max_binding)),
                    ("wide_atomics", Json::Bool(a.wide_atomics)),
                    ("timestamps", Json::Bool(a.timestamps)),
                ])
            });
            let adapters = Json::object([("adapters", Json::List(list.collect()))]);
            return print_text(&format!("{adapters}\n"));
        }
        let mut out = String::new();
        if all.is_empty() {
            out.push_str("no GPU adapter\n");
        }
        for a in &all {
            let _ = writeln!(
                out,
                "{} ({}, {}, {}): bindings up to {} MiB, keys in {}, {}",
                a.name,
                a.kind.name(),
                a.backend,
                a.driver,
                a.max_binding >> 20,
                if a.wide_atomics {
                    "one pass"
                } else {
                    "two passes"
                },
                if a.timestamps {
                    "stages timed"
                } else {
                    "no times by stage"
                },
            );
        }
        print_text(&out)
    }

    fn ms(d: Duration) -> Time {
        Time {
            wall: d.as_secs_f64() * 1e3,
            cpu: 0.0,
        }
    }

    fn frame_stats(stats: &GpuStats) -> FrameStats {
        FrameStats {
            faces: stats.faces,
            microtriangles: stats.microtriangles,
            pixels_covered: stats.pixels_covered,
            levels: stats.levels.clone(),
            ..FrameStats::default()
        }
    }

    pub(in crate::cli) fn draw(
        job: &mut Job,
        picture: &PictureFlags,
        renderer: &Renderer,
        scene: &Scene,
        camera: &Camera,
    ) -> Result<Drawn, Failure> {
        let gpu = open(picture)?;
        let mut ready = job.time("tables", |_| {
            Ok::<_, Failure>(GpuScene::new(&gpu, renderer, scene, camera)?)
        })?;
        let drawn = ready.draw()?;
        for &(name, time) in &drawn.stats.stages {
            job.stages.add(name, ms(time));
        }
        let s = &drawn.stats;
        let more = vec![
            ("gpu", Json::text(&*gpu.adapter().name)),
            ("bytes_up", Json::Whole(s.bytes_up)),
            ("bytes_down", Json::Whole(s.bytes_down)),
            ("read_backs", Json::Whole(s.read_backs.into())),
            ("decided_on_device", Json::Bool(s.decides)),
            ("coarse", Json::Whole(s.coarse)),
            ("chunks", Json::Whole(s.chunks.into())),
            ("scene_bytes", Json::Whole(s.scene_bytes)),
            ("shapes", Json::Whole(s.shapes.into())),
        ];
        let finished = Finished {
            stats: frame_stats(&drawn.stats),
            image: drawn.image,
            planes: drawn.planes,
            view: drawn.view,
        };
        Ok((finished, more))
    }

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
    pub(in crate::cli) fn frame(
        job: &Job,
        a: &Arguments,
        scene: &Scene,
    ) -> Result<Outcome, Failure> {
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
    pub(in crate::cli) fn suite(
        job: &Job,
        a: &Arguments,
        scene: &Scene,
    ) -> Result<Outcome, Failure> {
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
}
