//! `earmark bench refine`: limit points of a uniform level, without a picture.

use super::frame::update;
use super::{Arguments, Outcome, push};
use crate::cli::exit::Failure;
use crate::cli::job::Job;
use crate::cli::stats::{Clock, Time};
use earmark::limits::Limits;
use earmark::records::Grid3;
use earmark::simd::Level;
use earmark::stream::BlockStream;
use earmark::{Scene, Surface};
use rayon::prelude::*;
use std::hint::black_box;

/// Level of `bench refine` without `--level`.
const REFINE_LEVEL: u32 = 4;

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

/// Points of all faces, after new points of the cage.
pub(super) fn refine(job: &Job, a: &Arguments, scene: &mut Scene) -> Result<Outcome, Failure> {
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
        ..Outcome::default()
    })
}
