//! Time per micro-quad of projecting and drawing one block, by quad size and vector level. One thread, one sample per pixel.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use earmark::raster::{Key, ProjectedBlock, Tile, draw_block, project};
use earmark::records::{BlockSize, Grid3, Projection};
use earmark::simd::Level;
use std::hint::black_box;
use std::time::Duration;

/// A gently bumpy sheet of `points` by `points`, its quads `size` pixels wide, turned by some 17 degrees about pixel (128, 128).
fn sheet(points: usize, size: f32) -> (Box<Grid3>, BlockSize, Projection) {
    let mut grid = Grid3::boxed();
    let half = (points - 1) as f32 / 2.0;
    for j in 0..points {
        for i in 0..points {
            let (u, v) = ((i as f32 - half) * size, (j as f32 - half) * size);
            let bump = libm::sinf(u * 0.05) * libm::cosf(v * 0.04) * 0.1;
            let p = [u * 0.955 - v * 0.296, u * 0.296 + v * 0.955, 4.0 + bump];
            grid.set(i, j, p);
        }
    }
    let projection = Projection {
        x: [1024.0, 0.0, 128.0 * 256.0, 0.0],
        y: [0.0, 1024.0, 128.0 * 256.0, 0.0],
        w: [0.0, 0.0, 1.0, 0.0],
        d: [0.0; 4],
        near: 0.1,
        ortho: false,
    };
    let size = BlockSize {
        cols: points,
        rows: points,
    };
    (grid, size, projection)
}

fn draw(c: &mut Criterion) {
    let mut block = ProjectedBlock::boxed();
    let mut tile = Tile::<Key>::new(0, 0, 256, 256, 1);
    for (points, pixels) in [(33, 0.5), (33, 1.0), (33, 3.0), (17, 10.0), (5, 40.0)] {
        let mut group = c.benchmark_group(format!("draw_{pixels}px"));
        group.throughput(Throughput::Elements(((points - 1) * (points - 1)) as u64));
        let (grid, size, projection) = sheet(points, pixels);
        for level in Level::available() {
            project(level, &grid, size, &projection, &mut block);
            group.bench_function(level.name(), |b| {
                b.iter(|| draw_block(level, &mut tile, black_box(&block), 1));
            });
        }
    }
}

fn projecting(c: &mut Criterion) {
    let mut block = ProjectedBlock::boxed();
    let (grid, size, projection) = sheet(33, 1.0);
    let mut group = c.benchmark_group("project");
    group.throughput(Throughput::Elements((size.cols * size.rows) as u64));
    for level in Level::available() {
        group.bench_function(level.name(), |b| {
            b.iter(|| project(level, black_box(&grid), size, &projection, &mut block));
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(600));
    targets = draw, projecting
}
criterion_main!(benches);
