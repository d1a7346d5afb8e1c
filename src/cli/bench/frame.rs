//! `earmark bench frame` and `raster`: frames of an animated cage, and of its polygons.

use super::{Arguments, Outcome, push};
use crate::cli::exit::Failure;
use crate::cli::job::Job;
use crate::cli::stats::{Clock, Stages, Time, frame_stages};
use earmark::Scene;
use earmark::frame::{Drawing, Finished, FrameStats, Renderer};

/// Puts the cages' own points in again, as an animation would put new ones.
pub(super) fn update(scene: &mut Scene, points: &[Vec<[f32; 3]>]) -> Result<(), Failure> {
    for (object, points) in scene.objects.iter_mut().zip(points) {
        object
            .surface
            .update_points(points)
            .map_err(|e| Failure::usage(e.to_string()))?;
    }
    Ok(())
}

/// Frames that show a drawing; with new points each if `animated`.
pub(super) fn frame(
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
        ..Outcome::default()
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
