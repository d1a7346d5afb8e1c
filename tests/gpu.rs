//! The GPU backend against the processor, on whatever adapter there is: in CI Mesa's lavapipe, which is software Vulkan.
//!
//! Runs when EARMARK_GPU=1; then a machine without an adapter fails. Without it every test says that it was not run. Reference models take
//! part when EARMARK_SHARED names their folder.

#![allow(clippy::print_stdout)]

mod common;
#[path = "gpu/corners.rs"]
mod corners;
#[path = "golden/displaced.rs"]
mod displaced;
#[path = "gpu/flatness.rs"]
mod flatness;
#[path = "gpu/levels.rs"]
mod levels;
#[path = "gpu/outputs.rs"]
mod outputs;
#[path = "gpu/parity.rs"]
mod parity;
#[path = "gpu/patches.rs"]
mod patches;
#[path = "gpu/patterns.rs"]
mod patterns;
#[path = "gpu/pictures.rs"]
mod pictures;
#[path = "gpu/points.rs"]
mod points;
#[path = "gpu/program.rs"]
mod program;
#[path = "gpu/raster.rs"]
mod raster;
#[path = "gpu/refusals.rs"]
mod refusals;
mod support;
#[path = "golden/table.rs"]
mod table;

use earmark::frame::Refinement;
use earmark::gpu::{DeviceOptions, Gpu};
use earmark::load::{LoadOptions, Loader};
use earmark::mesh::resolver::NoFiles;
use earmark::{Renderer, Scene, SurfaceOptions};

/// A device, or nothing where the suite is not run.
fn gpu(what: &str) -> Option<Gpu> {
    gpu_with(what, &DeviceOptions::default())
}

fn gpu_with(what: &str, options: &DeviceOptions) -> Option<Gpu> {
    if std::env::var_os("EARMARK_GPU").is_none_or(|v| v != "1") {
        println!("gpu {what}: not run, EARMARK_GPU is not 1");
        return None;
    }
    let options = DeviceOptions {
        allow_software: true,
        ..options.clone()
    };
    match Gpu::open(&options) {
        Ok(gpu) => Some(gpu),
        Err(e) => panic!("EARMARK_GPU is 1, and there is no device: {e}"),
    }
}

fn asset(name: &str, options: SurfaceOptions) -> Scene {
    let mut loader = Loader::new(LoadOptions {
        surface: options,
        ..LoadOptions::default()
    });
    let path = common::assets().join(format!("{name}.obj"));
    loader.add_file(&path).unwrap();
    loader.finish().0
}

/// The scene without its textures, which have to fit a binding whole.
fn plain(mut scene: Scene) -> Scene {
    scene.textures.clear();
    for material in &mut scene.materials {
        material.diffuse_map = None;
    }
    scene
}

fn uniform(width: u32, height: u32, level: u32) -> Renderer {
    let mut renderer = Renderer::new(width, height);
    renderer.refinement = Refinement::Uniform(level);
    renderer
}

/// A cube, red below and blue above, with `first` for one of its faces: that of vertices 4, 3, 2 and 1.
fn colored(surface: SurfaceOptions, first: &str) -> Scene {
    let rest = "v -1 -1 -1 1 0 0\nv 1 -1 -1 1 0 0\nv 1 1 -1 0 0 1\nv -1 1 -1 0 0 1\nv -1 -1 1 1 0 0\nv 1 -1 1 1 0 0\nv 1 1 1 0 0 1\nv -1 1 1 0 0 1\n\
                f 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 4 1 5 8\n";
    let text = format!("{rest}{first}\n");
    let mut loader = Loader::new(LoadOptions {
        surface,
        ..LoadOptions::default()
    });
    let nothing = &mut NoFiles;
    let cage = loader
        .read(text.as_bytes(), "cube.obj", nothing)
        .unwrap()
        .cage;
    loader.add_cage(cage, "cube.obj", nothing).unwrap();
    loader.finish().0
}

/// A torus of `m` by `n` quads: all of them regular.
fn torus(m: u32, n: u32) -> Scene {
    let angle = |k: u32, n: u32| k as f32 / n as f32 * std::f32::consts::TAU;
    let points = (0..m * n).map(|i| {
        let (a, b) = (angle(i / n, m), angle(i % n, n));
        let r = 1.0 + 0.4 * b.cos();
        [r * a.sin(), 0.4 * b.sin(), r * a.cos()]
    });
    let at = |i: u32, j: u32| i % m * n + j % n;
    let corners = (0..m * n).flat_map(|k| {
        let (i, j) = (k / n, k % n);
        [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
    });
    let sizes = vec![4; (m * n) as usize];
    let cage = earmark::Cage::new(points.collect(), &sizes, corners.collect()).unwrap();
    Scene::of(earmark::Surface::new(cage, &SurfaceOptions::default()))
}
