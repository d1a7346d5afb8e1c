//! Build and dice: criterion groups `connect`, `ears` and `dice`, on a closed torus with a few irregular vertices.
#![allow(missing_docs)]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
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

/// Time per point of the quads with regular corners only, and of the others; points alone, and with normals.
fn dice(c: &mut Criterion) {
    let surface = Surface::new(cage(), &Default::default());
    let (mut points, mut normals) = (Grid3::boxed(), Grid3::boxed());
    let t = surface.quads();
    let is_regular = |&q: &u32| (0..4).all(|c| t.fans()[t.fan(4 * q + c) as usize].is_regular());
    let (regular, irregular): (Vec<u32>, Vec<u32>) =
        (0..t.face_count() as u32).partition(is_regular);
    for (name, quads) in [("dice/regular", regular), ("dice/irregular", irregular)] {
        let mut group = c.benchmark_group(name);
        for level in 1..=6 {
            let mut stream = BlockStream::new(&surface, level);
            group.throughput(Throughput::Elements((quads.len() as u64) << (2 * level)));
            for with_normals in [false, true] {
                let what = if with_normals { "normals" } else { "points" };
                group.bench_function(BenchmarkId::new(what, level), |b| {
                    b.iter(|| {
                        for &q in &quads {
                            stream.quad(q, |stream, u, v| {
                                let normals = with_normals.then_some(&mut *normals);
                                stream.dice(u, v, &mut points, normals);
                            });
                        }
                    });
                });
            }
        }
        group.finish();
    }
}

criterion_group!(benches, build, dice);
criterion_main!(benches);
