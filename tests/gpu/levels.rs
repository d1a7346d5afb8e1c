//! Whole-mesh levels: connectivity number by number, points against the processor's.

use crate::{asset, gpu};
use earmark::gpu::{Gpu, GpuError, Refiner};
use earmark::refine::{Level, Timings};
use earmark::scheme::{FaceVaryingRule, Scheme};
use earmark::{Scene, SurfaceOptions};

fn compare(gpu: &Gpu, name: &str, scene: &Scene, levels: u32) -> (f64, usize) {
    let surface = &scene.objects[0].surface;
    let refiner = Refiner::new(gpu, surface, levels).unwrap();
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    refiner.encode(&mut encoder);
    gpu.queue().submit([encoder.finish()]);
    let options = surface.refine_options();
    let topology = surface.topology().clone();
    let rule = FaceVaryingRule::default();
    let mut level =
        Level::<f32>::of_cage(surface.cage(), topology, Scheme::CatmullClark, rule).unwrap();
    let [low, high] = surface.cage().bounds();
    let size = (0..3)
        .map(|k| f64::from(high[k] - low[k]).powi(2))
        .sum::<f64>()
        .sqrt();
    let (mut far, mut count) = (0.0_f64, 0);
    for k in 1..=levels as usize {
        level = level.next(&options, &mut Timings::default()).unwrap();
        let (points, corners) = refiner.read(gpu, k).unwrap();
        let t = &level.topology;
        let want: Vec<u32> = (0..t.half_count() as u32).map(|h| t.vertex(h)).collect();
        assert_eq!(corners, want, "{name}: corners of level {k}");
        assert_eq!(points.len(), 3 * level.points.len(), "{name}: level {k}");
        for (got, want) in points.chunks_exact(3).zip(&level.points) {
            let off = (0..3)
                .map(|c| f64::from(got[c] - want[c]).powi(2))
                .sum::<f64>();
            far = far.max(off.sqrt() / size);
            count += 1;
        }
    }
    (far, count)
}

/// An open cube with edges that are sharp, fading and fading within a step, a dart, and a corner.
fn creased_cube() -> Scene {
    let points = (0..8_u8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|b| 2.0 * f32::from(b) - 1.0));
    let cage = earmark::Cage::builder()
        .points(points)
        .face([0, 2, 3, 1])
        .face([4, 5, 7, 6])
        .face([0, 1, 5, 4])
        .face([2, 6, 7, 3])
        .face([0, 4, 6, 2])
        .crease(4, 5, 10.0)
        .crease(5, 7, 2.5)
        .crease(7, 6, 2.5)
        .crease(6, 4, 0.4)
        .crease(0, 2, 1.3)
        .corner(6, 1.5)
        .build()
        .unwrap();
    let options = SurfaceOptions {
        scheme: Some(Scheme::CatmullClark),
        ..SurfaceOptions::default()
    };
    Scene::of(earmark::Surface::new(cage, &options))
}

#[test]
fn levels_are_the_processors() {
    let Some(gpu) = gpu("levels") else { return };
    let (mut most, mut total, mut run) = (0.0_f64, 0, 0);
    for (name, levels) in [
        ("cube", 6),
        ("corner", 4),
        ("fan5", 4),
        ("fan24", 3),
        ("torus", 4),
        ("creature", 4),
        ("part_creased", 4),
    ] {
        let scene = asset(name, SurfaceOptions::default());
        if !scene.objects[0].surface.topology().all_quads() {
            let refused = Refiner::new(&gpu, &scene.objects[0].surface, 1);
            assert!(
                matches!(refused, Err(GpuError::Unsupported { .. })),
                "{name}"
            );
            continue;
        }
        let (far, count) = compare(&gpu, name, &scene, levels);
        println!("gpu levels {name} {levels}: {far:.1e} of the model, {count} points");
        assert!(far <= 2e-6, "{name}: {far}");
        most = most.max(far);
        total += count;
        run += 1;
    }
    let creased = creased_cube();
    let (far, count) = compare(&gpu, "creased cube", &creased, 5);
    println!("gpu levels creased cube 5: {far:.1e} of the model, {count} points");
    assert!(far <= 2e-6, "creased cube: {far}");
    (most, total, run) = (most.max(far), total + count, run + 1);
    assert!(run >= 4);
    println!("gpu levels: {run} cases, {total} points, off by at most {most:.1e} of the model");
}
