//! Costs of the end of the pipeline, by stage name: `shade` per point, texture look-ups, `film` per pixel, `write` per picture.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use earmark::camera::{Camera, Sphere};
use earmark::film::{Encoding, Film, Image, png};
use earmark::records::ScreenSize;
use earmark::shade::{ShadeMode, Shader, SurfaceMaterial, SurfacePoint};
use earmark::texture::{Meaning, Texture};

const SIZE: ScreenSize = ScreenSize {
    width: 256,
    height: 256,
    samples: 4,
};

/// Points of the unit sphere as a tile would see them: neighbours lie side by side.
fn points() -> Vec<SurfacePoint> {
    let n = 128;
    let mut points = Vec::new();
    for j in 0..n {
        for i in 0..n {
            let x = (i as f32 + 0.5) / n as f32 * 1.4 - 0.7;
            let y = (j as f32 + 0.5) / n as f32 * 1.4 - 0.7;
            let p = [x, y, (1.0 - x * x - y * y).max(0.0).sqrt()];
            points.push(SurfacePoint {
                position: p,
                normal: p,
                geometric: p,
                uv: Some([x, y]),
                uv_footprint: 1.4 / n as f32,
                ..SurfacePoint::default()
            });
        }
    }
    points
}

/// A texture of noise without structure, so that nothing compresses or repeats.
fn noise(side: u32) -> Texture {
    let mut state = 1_u32;
    let texels = (0..side * side)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state.to_be_bytes()
        })
        .collect();
    Texture::from_rgba8(side, side, texels, Meaning::Color).expect("a size that is allowed")
}

/// The same with 16 bits per channel.
fn noise_wide(side: u32) -> Texture {
    let values: Vec<u16> = (0..side * side * 3)
        .map(|i| (i.wrapping_mul(2_654_435_761) >> 16) as u16)
        .collect();
    let file = png::encode_rgb16(side, side, &values).expect("encodes");
    let mut budget = u64::MAX;
    Texture::decode(&file, Meaning::Color, &mut budget).expect("decodes")
}

fn shade(c: &mut Criterion) {
    let sphere = Sphere {
        center: [0.0; 3],
        radius: 1.0,
    };
    let view = Camera::default()
        .framing(&sphere, SIZE)
        .expect("a valid camera");
    let points = points();
    let mut colors = vec![[0.0; 4]; points.len()];
    let textures = [noise(1024)];
    let materials = [SurfaceMaterial {
        diffuse_map: Some(0),
        ..SurfaceMaterial::WHITE
    }];
    let textured: Vec<_> = points
        .iter()
        .map(|p| SurfacePoint { material: 0, ..*p })
        .collect();

    let mut group = c.benchmark_group("shade");
    group.throughput(Throughput::Elements(points.len() as u64));
    for (name, mode) in [
        ("lit", ShadeMode::Lit),
        ("normals", ShadeMode::Normals),
        ("level", ShadeMode::Level),
    ] {
        let shader = Shader::new(mode, &view, &materials, &textures);
        group.bench_function(format!("{name}/each"), |b| {
            b.iter(|| {
                for (p, o) in points.iter().zip(&mut colors) {
                    *o = shader.shade(black_box(p));
                }
            });
        });
        group.bench_function(format!("{name}/all"), |b| {
            b.iter(|| shader.shade_all(black_box(&points), &mut colors));
        });
    }
    let shader = Shader::new(ShadeMode::Lit, &view, &materials, &textures);
    group.bench_function("lit textured/all", |b| {
        b.iter(|| shader.shade_all(black_box(&textured), &mut colors));
    });
    group.finish();

    let mut group = c.benchmark_group("texture");
    group.throughput(Throughput::Elements(points.len() as u64));
    for (name, texture) in [("8 bit", noise(2048)), ("16 bit", noise_wide(2048))] {
        for (access, scale) in [("near", 1.0 / 16.0), ("far", 977.0)] {
            group.bench_function(format!("{name}/{access}"), |b| {
                b.iter(|| {
                    let mut sum = 0.0;
                    for p in &points {
                        let uv = p.uv.unwrap_or_default();
                        sum += texture.sample(uv[0] * scale, uv[1] * scale, 0.4)[1];
                    }
                    black_box(sum)
                });
            });
        }
    }
    group.finish();
}

fn film(c: &mut Criterion) {
    let pixels = 64 * 64;
    let samples: Vec<[f32; 4]> = (0..pixels * 4)
        .map(|i| [0.1, 0.2, i as f32 / (pixels * 4) as f32, 1.0])
        .collect();
    let mut out = vec![0; pixels * 4];
    let mut group = c.benchmark_group("film");
    group.throughput(Throughput::Elements(pixels as u64));
    for (name, background) in [("transparent", [0; 4]), ("opaque", [30, 40, 50, 255])] {
        let film = Film::new(Encoding::Srgb, background);
        group.bench_function(name, |b| {
            b.iter(|| film.resolve(black_box(&samples), 4, &mut out));
        });
    }
    group.finish();
}

fn write(c: &mut Criterion) {
    let mut image = Image::new(1024, 1024);
    for y in 0..1024_usize {
        for x in 0..1024_usize {
            let (dx, dy) = (x as f32 - 511.5, y as f32 - 511.5);
            let d = (dx * dx + dy * dy).sqrt() / 480.0;
            if d < 1.0 {
                let z = (1.0 - d * d).sqrt();
                let v = |k: f32| ((z * 0.7 - dx / 2000.0 - dy / 1500.0) * k) as u8;
                let i = (y * 1024 + x) * 4;
                image.data[i..i + 4].copy_from_slice(&[v(250.0), v(240.0), v(225.0), 255]);
            }
        }
    }
    let mut group = c.benchmark_group("write");
    group.sample_size(10);
    group.bench_function("png 1024x1024 rgba", |b| {
        b.iter(|| png::encode(black_box(&image)));
    });
    group.bench_function("png 1024x1024 rgb", |b| {
        b.iter(|| png::encode_rgb(black_box(&image)));
    });
    group.finish();
}

criterion_group!(benches, shade, film, write);
criterion_main!(benches);
