//! Pictures by a device, and a list of devices.

use super::Drawn;
use crate::cli::exit::{Code, Failure};
use crate::cli::flags::PictureFlags;
use crate::cli::job::Job;
use crate::cli::outputs::print_text;
use crate::cli::stats::{Json, Time};
use earmark::frame::{Finished, FrameStats};
use earmark::gpu::{DeviceOptions, Gpu, GpuError, GpuScene, GpuStats, adapters};
use earmark::{Camera, Renderer, Scene};
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

pub(in crate::cli) fn open(picture: &PictureFlags) -> Result<Gpu, Failure> {
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

pub(in crate::cli) fn ms(d: Duration) -> Time {
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
