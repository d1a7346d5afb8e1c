//! Whole-mesh refinement: one step, many steps, limits, on a mesh of regular and extraordinary vertices.
#![allow(missing_docs)]

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use earmark::mesh::Crease;
use earmark::refine::{Level, Options, Timings, limit, refine};
use earmark::scheme::Boundary;
use earmark::topology::{ConnectOptions, connect};
use std::hint::black_box;

/// Surface of a cube of `n`³ cells: quads, eight vertices of valence 3.
fn box_mesh(n: u32, creases: bool) -> Level<f32> {
    let mut names = std::collections::BTreeMap::new();
    let mut points = Vec::new();
    let mut corners = Vec::new();
    for axis in 0..3 {
        for side in [0, n] {
            for cell in 0..n * n {
                let (i, j) = (cell % n, cell / n);
                let mut quad: Vec<u32> = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
                    .into_iter()
                    .map(|(a, b)| {
                        let mut p = [0; 3];
                        p[axis] = side;
                        p[(axis + 1) % 3] = a;
                        p[(axis + 2) % 3] = b;
                        *names.entry(p).or_insert_with(|| {
                            points.push(p.map(|c| c as f32));
                            points.len() as u32 - 1
                        })
                    })
                    .collect();
                if side == 0 {
                    quad.reverse();
                }
                corners.extend(quad);
            }
        }
    }
    let offsets: Vec<u32> = (0..=6 * n * n).map(|f| 4 * f).collect();
    let tags: Vec<Crease> = (0..n)
        .filter(|_| creases)
        .map(|i| Crease {
            vertices: [names[&[i, 0, 0]], names[&[i + 1, 0, 0]]],
            sharpness: 2.5,
        })
        .collect();
    let options = ConnectOptions {
        boundary: Boundary::EdgeAndCorner,
        creases: &tags,
        ..ConnectOptions::default()
    };
    let topology = connect(points.len(), &offsets, corners, &options).0;
    match Level::new(topology, points) {
        Ok(level) => level,
        Err(e) => unreachable!("{e}"),
    }
}

fn steps(c: &mut Criterion) {
    let mut group = c.benchmark_group("refine");
    group.sample_size(10);
    for (name, n, levels, creases) in [
        ("one step", 64, 1, false),
        ("four steps", 16, 4, false),
        ("four steps, semi-sharp", 16, 4, true),
    ] {
        let base = box_mesh(n, creases);
        let quads = (6 * u64::from(n * n)) << (2 * levels);
        group.throughput(Throughput::Elements(quads));
        group.bench_function(name, |b| {
            b.iter_batched(
                || base.clone(),
                |level| {
                    black_box(refine(
                        level,
                        &Options::default(),
                        levels,
                        None,
                        &mut Timings::default(),
                    ))
                },
                BatchSize::LargeInput,
            );
        });
    }
    group.finish();
}

fn limits(c: &mut Criterion) {
    let level = box_mesh(64, false);
    let mut group = c.benchmark_group("limit");
    group.sample_size(10);
    group.throughput(Throughput::Elements(level.points.len() as u64));
    group.bench_function("positions and normals", |b| {
        b.iter(|| black_box(limit(&level, &Options::default())));
    });
    group.finish();
}

criterion_group!(benches, steps, limits);
criterion_main!(benches);
