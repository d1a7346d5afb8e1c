//! Speed of the OBJ reader on a generated file: a grid of quads with positions and texture coordinates.
//!
//! `EARMARK_BENCH_SIDE` sets the quads along one side of the grid; 1000 gives a file of about 70 MB.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use earmark::mesh::NoFiles;
use earmark::mesh::obj::{ReadOptions, read};
use std::fmt::Write;
use std::hint::black_box;

/// A grid of `side` × `side` quads as OBJ text, with six decimals as most programs write them.
fn grid(side: usize) -> String {
    let mut text = String::from("# a grid\no grid\n");
    let step = |i: usize| i as f64 / side as f64;
    for j in 0..=side {
        for i in 0..=side {
            let (x, y) = (step(i), step(j));
            let z = 0.1 * (x * 3.0 - y) * (y - 0.3);
            let _ = writeln!(text, "v {:.6} {z:.6} {:.6}", 10.0 * x - 5.0, 10.0 * y - 5.0);
        }
    }
    for j in 0..=side {
        for i in 0..=side {
            let _ = writeln!(text, "vt {:.6} {:.6}", step(i), step(j));
        }
    }
    for j in 0..side {
        for i in 0..side {
            let a = j * (side + 1) + i + 1;
            let (b, c, d) = (a + 1, a + side + 2, a + side + 1);
            let _ = writeln!(text, "f {a}/{a} {b}/{b} {c}/{c} {d}/{d}");
        }
    }
    text
}

fn reading(c: &mut Criterion) {
    let side = std::env::var("EARMARK_BENCH_SIDE")
        .ok()
        .and_then(|s| s.parse().ok());
    let text = grid(side.unwrap_or(400));
    let mut group = c.benchmark_group("read");
    group.sample_size(10);
    group.throughput(Throughput::Bytes(text.len() as u64));
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let Ok(pool) = pool else { continue };
        group.bench_function(format!("grid/{threads}"), |b| {
            b.iter(|| {
                let options = ReadOptions::default();
                pool.install(|| {
                    read(
                        black_box(text.as_bytes()),
                        "grid.obj",
                        &mut NoFiles,
                        &options,
                    )
                })
            });
        });
    }
    group.finish();
}

criterion_group!(benches, reading);
criterion_main!(benches);
