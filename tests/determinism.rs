//! One input, one picture: for any number of threads, any level of vector instructions, and every time again.

mod common;

use earmark::frame::Refinement;
use earmark::simd::Level;
use earmark::{Camera, Renderer, Scene, film};

fn png(scene: &Scene, side: u32, samples: u32, threads: usize, simd: Level) -> Vec<u8> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap();
    let mut renderer = Renderer::new(side, side);
    renderer.size.samples = samples;
    renderer.simd = simd;
    renderer.refinement = Refinement::Uniform(3);
    let frame = pool
        .install(|| renderer.render(scene, &Camera::default()))
        .unwrap();
    film::png::encode(&frame.image).unwrap()
}

#[test]
fn threads_do_not_change_a_byte() {
    let mut compared = 0;
    for path in common::models(&common::assets()) {
        let scene = common::load(&path);
        for (side, samples) in [(64, 1), (64, 16), (300, 4)] {
            let first = png(&scene, side, samples, 1, Level::detect());
            for threads in [2, 3, 8] {
                assert!(
                    first == png(&scene, side, samples, threads, Level::detect()),
                    "{} on {threads} threads",
                    path.display()
                );
                compared += 1;
            }
            assert!(
                first == png(&scene, side, samples, 2, Level::detect()),
                "{} again",
                path.display()
            );
        }
    }
    println!("determinism: {compared} pictures equal");
}

#[test]
fn vector_levels_do_not_change_a_byte() {
    let scene = common::load(&common::assets().join("creature.obj"));
    let first = png(&scene, 256, 4, 2, Level::SCALAR);
    for level in Level::available() {
        assert!(first == png(&scene, 256, 4, 2, level), "{}", level.name());
    }
}
