//! Displacement: points and normals against independent arithmetic, one owner for everything that is shared, and no crack anywhere.

#[cfg(feature = "cli")]
#[path = "displace/cli.rs"]
mod cli;
#[path = "displace/closed.rs"]
mod closed;
mod common;
#[path = "common/coverage.rs"]
mod coverage;
#[path = "displace/normals.rs"]
mod normals;
#[path = "displace/refined.rs"]
mod refined;
#[path = "displace/relief.rs"]
mod relief;
#[path = "displace/seams.rs"]
mod seams;

use earmark::displace::{Displacement, Function, HeightMap};
use earmark::scheme::Scheme;
use earmark::{Cage, Surface, SurfaceOptions};
use std::sync::Arc;

/// A map that has nothing to do with itself from one side of a seam to the other.
fn noise_map(side: u32, seed: u64) -> Arc<HeightMap> {
    let mut random = common::Random(seed);
    let texels = (0..side * side).map(|_| random.unit() as f32).collect();
    Arc::new(HeightMap::new(side, side, texels).unwrap())
}

fn noise(text: &str) -> Displacement {
    Displacement::function(text.parse::<Function>().unwrap())
}

/// A closed torus of `m` by `n` quads with texture coordinates, split by seams that the other way round have nothing in common.
fn torus(m: u32, n: u32, creased: bool, options: &SurfaceOptions) -> Surface {
    let turn = std::f32::consts::TAU;
    let at = |i: u32, j: u32| (i % m) * n + j % n;
    let mut cage = Cage::builder();
    cage = cage.points((0..m * n).map(|k| {
        let (a, b) = (
            turn * (k / n) as f32 / m as f32,
            turn * (k % n) as f32 / n as f32,
        );
        let r = 2.0 + 0.8 * b.cos() + 0.1 * (3.0 * a).sin();
        [r * a.cos(), 0.8 * b.sin() + 0.2 * a.cos(), r * a.sin()]
    }));
    let mut uvs = Vec::new();
    let mut corners = Vec::new();
    for (i, j) in (0..m).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let face = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        cage = cage.face(face);
        // Charts of two by two faces.
        let chart = (i / 2 * 7 + j / 2 * 13) % 29;
        for (a, b) in [(0, 0), (0, 1), (1, 1), (1, 0)] {
            let (s, t) = ((i % 2 + a) as f32, (j % 2 + b) as f32);
            let key = [
                s * 0.31 + chart as f32 * 0.037,
                t * 0.27 - chart as f32 * 0.051,
            ];
            let found = uvs.iter().position(|&uv| uv == key);
            corners.push(found.unwrap_or_else(|| {
                uvs.push(key);
                uvs.len() - 1
            }) as u32);
        }
    }
    if creased {
        for i in 0..m {
            cage = cage.crease(at(i, 0), at(i + 1, 0), 10.0);
            cage = cage.crease(at(i, n / 2), at(i + 1, n / 2), 0.4 * (i % 7) as f32);
        }
        for j in 0..n {
            cage = cage.crease(at(1, j), at(1, j + 1), 10.0);
        }
        cage = cage.crease(at(4, 1), at(4, 2), 10.0);
    }
    let cage = cage.build().unwrap().with_uvs(uvs, corners).unwrap();
    Surface::new(cage, options)
}

fn by(scheme: Scheme) -> SurfaceOptions {
    SurfaceOptions {
        scheme: Some(scheme),
        ..SurfaceOptions::default()
    }
}
