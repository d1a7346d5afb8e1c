//! Evaluation anywhere: criterion group `evaluate`, position and first derivatives on the creature, by each way in. Times are per 4096
//! points.
#![allow(missing_docs)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use earmark::evaluate::{FaceEvaluator, Place, Tangents};
use earmark::{Cage, Surface};

const POINTS: u32 = 4096;

fn cage() -> Cage {
    let text = include_bytes!("../assets/creature.obj");
    earmark::mesh::obj::read(
        text,
        "creature.obj",
        &mut earmark::mesh::resolver::NoFiles,
        &Default::default(),
    )
    .unwrap()
    .cage
}

/// Places at random; those on polygons of other than four corners lie in their first quad.
fn places(surface: &Surface) -> Vec<Place> {
    let mut state = 1_u64;
    let mut unit = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1_u32 << 24) as f32
    };
    let faces = surface.topology().face_count() as f32;
    (0..POINTS)
        .map(|_| Place {
            face: (unit() * faces) as u32,
            u: unit(),
            v: unit(),
        })
        .collect()
}

fn evaluate(c: &mut Criterion) {
    let surface = Surface::new(cage(), &Default::default());
    let places = places(&surface);
    let mut out = vec![Tangents::default(); places.len()];
    let mut group = c.benchmark_group("evaluate");
    group.throughput(Throughput::Elements(u64::from(POINTS)));
    group.bench_function("single", |b| {
        b.iter(|| {
            for (p, out) in places.iter().zip(&mut out) {
                *out = surface.evaluate_as(p.face, p.u, p.v).unwrap_or_default();
            }
        });
    });
    let faces = 0..surface.topology().face_count() as u32;
    let mut ready: Vec<FaceEvaluator<'_>> =
        faces.filter_map(|f| surface.face_evaluator(f)).collect();
    group.bench_function("prepared", |b| {
        b.iter(|| {
            for (p, out) in places.iter().zip(&mut out) {
                *out = ready[p.face as usize].at_as(p.u, p.v).unwrap_or_default();
            }
        });
    });
    group.bench_function("batch", |b| {
        b.iter(|| surface.evaluate_many(&places, &mut out));
    });
    group.bench_function("grid", |b| {
        let mut grid = Vec::new();
        b.iter(|| {
            // 16 faces of 16 by 16 points.
            for face in &mut ready[..16] {
                grid.resize(face.grid_len(15), Tangents::default());
                face.grid(15, &mut grid).unwrap();
            }
        });
    });
    group.finish();
}

criterion_group!(benches, evaluate);
criterion_main!(benches);
