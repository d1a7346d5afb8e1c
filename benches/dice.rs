//! Build and dice: criterion groups `connect`, `ears` and `dice`, on a closed torus with a few irregular vertices.
#![allow(missing_docs)]

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use earmark::stream::BlockStream;
use earmark::topology::{ConnectOptions, connect};
use earmark::{Cage, Surface, records::Grid3};

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

fn build(c: &mut Criterion) {
    let cage = cage();
    c.benchmark_group("connect")
        .bench_function("creature", |b| {
            b.iter(|| {
                connect(
                    cage.points().len(),
                    cage.face_offsets(),
                    cage.corner_vertices().to_vec(),
                    &ConnectOptions::default(),
                )
            });
        });
    let surface = Surface::new(cage, &Default::default());
    c.benchmark_group("ears")
        .bench_function("creature", |b| b.iter(|| surface.ears()));
}

fn dice(c: &mut Criterion) {
    let surface = Surface::new(cage(), &Default::default());
    let (mut points, mut normals) = (Grid3::boxed(), Grid3::boxed());
    let mut group = c.benchmark_group("dice");
    for level in 1..=6 {
        let mut stream = BlockStream::new(&surface, level);
        group.bench_function(BenchmarkId::new("creature", level), |b| {
            b.iter(|| {
                for q in 0..surface.quads().face_count() as u32 {
                    stream.quad(q, |stream, u, v| {
                        stream.dice(u, v, &mut points, Some(&mut normals))
                    });
                }
            });
        });
    }
    group.finish();
}

criterion_group!(benches, build, dice);
criterion_main!(benches);
