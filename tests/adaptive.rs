//! Adaptive tessellation: no cracks at unequal levels, triangles as close to the surface as asked for.

mod common;
#[path = "common/coverage.rs"]
mod coverage;

#[path = "adaptive/measured.rs"]
mod measured;

use earmark::frame::Refinement;
use earmark::frame::coverage::CoverageFault;
use earmark::frame::deviation::DrawnBlock;
use earmark::scheme::Scheme;
use earmark::simd::Level;
use earmark::tessellate::Flatness;
use earmark::{Cage, Camera, Renderer, Scene, Surface, SurfaceOptions};
use std::cmp::Ordering;
use std::collections::HashMap;

/// A closed torus of `4 n` by `n` quads, or twice as many triangles, one side flat. With infinite creases around, a dart, and some that fade
/// if `creased`.
fn torus(n: u32, scheme: Scheme, creased: bool) -> Scene {
    let (m, turn) = (4 * n, std::f32::consts::TAU);
    let at = |i: u32, j: u32| (i % m) * n + j % n;
    let mut cage = Cage::builder();
    let points = (0..m * n).map(|k| {
        let (i, j) = (k / n, k % n);
        let (a, b) = (turn * i as f32 / m as f32, turn * j as f32 / n as f32);
        let r = 2.0 + b.cos() * (0.7 + 0.2 * (3.0 * a).sin());
        [r * a.cos(), (b.sin() * 0.7).max(-0.4), r * a.sin()]
    });
    cage = cage.points(points);
    for (i, j) in (0..m).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let quad = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        // Diagonals both ways, so that valences are unequal.
        match (scheme.is_triangular(), (i * j) % 3) {
            (false, _) => cage = cage.face(quad),
            (true, 0) => {
                cage = cage.face([quad[0], quad[1], quad[2]]);
                cage = cage.face([quad[0], quad[2], quad[3]]);
            }
            (true, _) => {
                cage = cage.face([quad[1], quad[2], quad[3]]);
                cage = cage.face([quad[3], quad[0], quad[1]]);
            }
        }
    }
    for i in (0..m).filter(|_| creased) {
        cage = cage.crease(at(i, 0), at(i + 1, 0), 10.0);
        cage = cage.crease(at(i, n / 2), at(i + 1, n / 2), 0.3 * (i % 9) as f32);
    }
    for j in (1..3).filter(|_| creased) {
        cage = cage.crease(at(2, j), at(2, j + 1), 10.0);
    }
    let options = SurfaceOptions {
        scheme: Some(scheme),
        ..SurfaceOptions::default()
    };
    Scene::of(Surface::new(cage.build().unwrap(), &options))
}

/// Tori under all schemes, with and without creases where the scheme has fading ones.
fn tori() -> Vec<(String, Scene)> {
    let all = [
        (Scheme::CatmullClark, true),
        (Scheme::Bilinear, false),
        (Scheme::Loop, false),
        (Scheme::Loop, true),
        (Scheme::Butterfly, false),
        (Scheme::Kobbelt, false),
        (Scheme::Kobbelt, true),
    ];
    let name = |scheme: Scheme, creased: bool| format!("{scheme:?} torus, creased: {creased}");
    all.map(|(scheme, creased)| (name(scheme, creased), torus(6, scheme, creased)))
        .into()
}

fn adaptive(side: u32, pixels: f32, degrees: f32) -> Renderer {
    let mut renderer = coverage::renderer(side, 0);
    renderer.refinement = Refinement::Adaptive(Flatness {
        pixels,
        degrees,
        ..Flatness::default()
    });
    renderer
}

/// Edges of micro-triangles that are not run through as often one way as the other, ends told by their bits.
fn open_edges(blocks: &[DrawnBlock]) -> usize {
    let mut sums: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
    for block in blocks {
        let bits = |k: usize| block.points[k].map(|c| (c + 0.0).to_bits());
        for t in block.triangles() {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                let (a, b) = (bits(a), bits(b));
                match a.cmp(&b) {
                    Ordering::Less => *sums.entry([a, b]).or_default() += 1,
                    Ordering::Greater => *sums.entry([b, a]).or_default() -= 1,
                    Ordering::Equal => {}
                }
            }
        }
    }
    sums.values().filter(|&&sum| sum != 0).count()
}

#[test]
fn closed_models_are_closed_bit_for_bit() {
    let mut scenes = tori();
    for path in common::models(&common::assets()) {
        scenes.push((common::name(&path), common::load(&path)));
    }
    scenes.retain(|(_, scene)| common::is_closed(&scene.objects[0].surface));
    let (mut triangles, mut levels) = (0, [0; 11]);
    for (name, scene) in &scenes {
        for pixels in [0.1, 0.5, 2.0, 10.0] {
            let renderer = adaptive(200, pixels, 30.0 * pixels);
            // Nearer on one side than on the other.
            let camera = Camera::default().with_fov(60.0);
            let view = camera
                .framing(&scene.bounding_sphere(), renderer.size)
                .unwrap();
            let blocks = renderer.drawn_blocks(scene, &view).unwrap();
            assert_eq!(open_edges(&blocks), 0, "{name} at {pixels} pixels");
            triangles += blocks.iter().map(|b| b.triangles().count()).sum::<usize>();
            blocks.iter().for_each(|b| levels[b.level as usize] += 1);
        }
    }
    println!("adaptive: closed, {triangles} triangles, blocks by level {levels:?}");
    assert!(levels.iter().filter(|&&n| n > 20).count() > 4);
}

#[test]
fn threads_and_vectors_do_not_change_a_byte() {
    let scenes = [
        common::load(&common::assets().join("creature.obj")),
        torus(6, Scheme::Loop, true),
        torus(6, Scheme::Butterfly, false),
    ];
    for (k, scene) in scenes.iter().enumerate() {
        let draw = |threads: usize, simd: Level| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let mut renderer = Renderer::new(300, 300);
            renderer.refinement = Refinement::Adaptive(Flatness::default());
            renderer.simd = simd;
            let frame = || renderer.render(scene, &Camera::default()).unwrap();
            pool.build().unwrap().install(frame).image
        };
        let first = draw(1, Level::SCALAR);
        for threads in [2, 8] {
            assert!(
                first == draw(threads, Level::detect()),
                "scene {k} on {threads} threads"
            );
        }
        for simd in Level::available() {
            assert!(first == draw(2, simd), "scene {k} by {}", simd.name());
        }
    }
}

#[test]
fn closed_models_have_as_many_fronts_as_backs_at_every_tolerance() {
    let (mut samples, mut covered, mut triangles) = (0, 0, 0);
    let mut scenes = tori();
    for path in common::models(&common::assets()) {
        scenes.push((path.display().to_string(), common::load(&path)));
    }
    scenes.retain(|(_, scene)| common::is_closed(&scene.objects[0].surface));
    for (name, scene) in &scenes {
        for pixels in [0.05, 0.25, 1.0, 4.0, 30.0] {
            let renderer = adaptive(160, pixels, 20.0 * pixels);
            for view in coverage::views(scene, &renderer, 6, 7) {
                let c = renderer
                    .signed_coverage(scene, &view, CoverageFault::None)
                    .unwrap();
                assert_eq!(
                    c.unequal, 0,
                    "{name} at {pixels} pixels: {} of {} samples",
                    c.unequal, c.samples
                );
                samples += c.samples;
                covered += c.covered;
                let drawn = renderer.render_view(scene, &view).unwrap();
                triangles += drawn.stats.microtriangles;
            }
        }
    }
    println!("adaptive: 0 of {samples} samples unequal, {covered} covered, {triangles} triangles");
    assert!(covered > 100_000);
}

#[test]
fn triangles_are_as_close_to_the_surface_as_asked_for() {
    let (mut worst, mut bent, mut views) = (0.0_f32, 0.0_f32, 0);
    let mut scenes = tori();
    for path in common::models(&common::assets()) {
        scenes.push((common::name(&path), common::load(&path)));
    }
    for (name, scene) in &scenes {
        for pixels in [0.25, 1.0] {
            let renderer = adaptive(512, pixels, 3.0);
            for view in coverage::views(scene, &renderer, 2, 11) {
                let d = renderer.deviation(scene, &view, 2).unwrap();
                let what = format!("{name} at {pixels} pixels: {d:?}");
                assert!(d.pixels <= pixels, "{what}");
                // Folds of a pixel's width, and corners where the surface has no tangent plane, bend as they like.
                let bends = ["creature", "part_creased", "torus, creased: true"];
                let smooth = !bends.iter().any(|bend| name.ends_with(bend));
                assert!(!smooth || d.degrees <= 3.0, "{what}");
                worst = worst.max(d.pixels / pixels);
                bent = bent.max(d.degrees);
                views += 1;
            }
        }
    }
    println!("adaptive: {worst} of the tolerance at most in {views} views, {bent} degrees");
    assert!(worst > 0.3, "nothing was measured");
}
