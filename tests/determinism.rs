//! One input, one picture: for any number of threads, any level of vector instructions, and every time again.

mod common;

use earmark::frame::{Drawing, Refinement};
use earmark::load::{LoadOptions, Loader};
use earmark::scheme::Scheme;
use earmark::shade::ShadeMode;
use earmark::simd::Level;
use earmark::tessellate::Flatness;
use earmark::{Camera, Renderer, Scene, SurfaceOptions, film};

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

/// One picture of every kind: model, scheme, level (none: adaptive), drawing, mode, samples, and whether the view is orthographic.
type Kind = (
    &'static str,
    Scheme,
    Option<u32>,
    Drawing,
    ShadeMode,
    u32,
    bool,
);

const KINDS: [Kind; 13] = {
    use Drawing::{Cage, Limit, Refined};
    use Scheme::{Bilinear, Butterfly, CatmullClark, Kobbelt, Loop};
    use ShadeMode::{Depth, Flat, Level, Lit, Normals, Uv};
    [
        ("creature", CatmullClark, Some(4), Limit, Lit, 1, false),
        ("creature", CatmullClark, Some(3), Limit, Lit, 4, true),
        ("creature", CatmullClark, None, Limit, Lit, 1, false),
        ("creature", CatmullClark, Some(2), Refined, Flat, 8, false),
        ("creature", CatmullClark, Some(2), Limit, Uv, 1, false),
        ("creature", CatmullClark, Some(0), Cage, Lit, 4, false),
        ("part_creased", CatmullClark, Some(6), Limit, Lit, 1, false),
        ("part", CatmullClark, Some(3), Limit, Depth, 16, true),
        ("part_creased", Bilinear, Some(2), Limit, Normals, 4, false),
        ("tetrahedron", Loop, Some(6), Limit, Lit, 4, false),
        ("octahedron", Butterfly, Some(4), Limit, Lit, 1, false),
        ("octahedron", Loop, Some(0), Cage, Lit, 1, false),
        ("torus", Kobbelt, Some(3), Limit, Level, 1, false),
    ]
};

fn kind(k: &Kind) -> (Scene, Renderer, Camera) {
    let &(model, scheme, level, drawing, mode, samples, ortho) = k;
    let mut loader = Loader::new(LoadOptions {
        surface: SurfaceOptions {
            scheme: Some(scheme),
            ..SurfaceOptions::default()
        },
        ..LoadOptions::default()
    });
    let path = common::assets().join(format!("{model}.obj"));
    loader.add_file(&path).unwrap();
    let mut renderer = Renderer::new(300, 280);
    renderer.size.samples = samples;
    renderer.refinement = level.map_or(
        Refinement::Adaptive(Flatness::default()),
        Refinement::Uniform,
    );
    renderer.drawing = drawing;
    renderer.mode = mode;
    let camera = Camera::default();
    let camera = if ortho { camera.with_ortho() } else { camera };
    (loader.finish().0, renderer, camera)
}

#[test]
fn pictures_of_all_kinds_are_the_same_everywhere() {
    for name in ["scalar", "sse2", "avx2", "avx512", "neon"] {
        if Level::from_name(name).is_err() {
            println!("determinism: {name} not run, this machine lacks it");
        }
    }
    let pools = [1, 2, 8].map(|threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap()
    });
    for k in &KINDS {
        let (scene, mut renderer, camera) = kind(k);
        let mut draw = |simd: Level, leave_out: bool, pool: &rayon::ThreadPool| {
            renderer.simd = simd;
            renderer.leave_out = leave_out;
            let frame = pool.install(|| renderer.render(&scene, &camera)).unwrap();
            film::png::encode(&frame.image).unwrap()
        };
        // The first one draws everything, also what cannot be seen.
        let first = draw(Level::SCALAR, false, &pools[0]);
        for simd in Level::available() {
            for (pool, threads) in pools.iter().zip([1, 2, 8]) {
                assert!(
                    first == draw(simd, true, pool),
                    "{k:?} at {} on {threads} threads",
                    simd.name()
                );
            }
        }
    }
}
