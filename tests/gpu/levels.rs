//! Whole-mesh levels and their limits: connectivity number by number, points and normals against the processor's.

use crate::support::{Case, cases};
use crate::{asset, gpu};
use earmark::gpu::{Gpu, GpuError, Refiner};
use earmark::load::{LoadOptions, Loader};
use earmark::refine::limit::limit;
use earmark::refine::{Level, Limit, Timings};
use earmark::scheme::{CreaseMethod, FaceVaryingRule, Scheme, TriangleRule};
use earmark::{Scene, Surface, SurfaceOptions};
use std::path::Path;

/// Of the length of the box.
const DISTANCE: f64 = 2e-6;
/// Degrees.
const ANGLE: f64 = 0.05;

/// How far a device's levels are from the processor's.
#[derive(Clone, Copy, Default)]
struct Found {
    /// Points, of the length of the box.
    far: f64,
    /// Limit normals, in degrees.
    turned: f64,
    points: usize,
    normals: usize,
    /// Normals that are further off than [`ANGLE`].
    beyond: usize,
}

impl Found {
    fn and(self, other: Self) -> Self {
        Self {
            far: self.far.max(other.far),
            turned: self.turned.max(other.turned),
            points: self.points + other.points,
            normals: self.normals + other.normals,
            beyond: self.beyond + other.beyond,
        }
    }

    fn note_points(&mut self, got: &[f32], want: &[[f32; 3]], size: f64) {
        for (got, want) in got.chunks_exact(3).zip(want) {
            let off = (0..3)
                .map(|c| f64::from(got[c] - want[c]).powi(2))
                .sum::<f64>();
            self.far = self.far.max(off.sqrt() / size);
            self.points += 1;
        }
    }

    fn note_normals(&mut self, got: &[f32], level: &Level<f32>, limit: &Limit<f32>) {
        let t = &level.topology;
        for (h, got) in (0..t.half_count() as u32).zip(got.chunks_exact(3)) {
            let want = limit.normals[limit.normal_index(t, h) as usize].map(f64::from);
            let got: [f64; 3] = std::array::from_fn(|c| f64::from(got[c]));
            let dot: f64 = (0..3).map(|c| got[c] * want[c]).sum();
            let cross = (0..3).map(|c| {
                let (a, b) = ((c + 1) % 3, (c + 2) % 3);
                (got[a] * want[b] - got[b] * want[a]).powi(2)
            });
            let angle = cross.sum::<f64>().sqrt().atan2(dot).to_degrees();
            self.turned = self.turned.max(angle);
            self.normals += 1;
            self.beyond += usize::from(angle > ANGLE);
        }
    }

    fn check(&self, what: &str) {
        assert!(
            self.far <= DISTANCE,
            "{what}: points are off by {}",
            self.far
        );
        assert!(
            self.turned <= ANGLE,
            "{what}: normals are off by {}",
            self.turned
        );
    }
}

/// Levels 1 to the last, and its limit unless creases still fade there.
fn compare(gpu: &Gpu, name: &str, surface: &Surface, levels: u32) -> Found {
    let (refiner, has_limit) = match Refiner::with_limit(gpu, surface, levels) {
        Ok(refiner) => (refiner, true),
        Err(GpuError::Unsupported { .. }) => (Refiner::new(gpu, surface, levels).unwrap(), false),
        Err(e) => panic!("{name}: {e}"),
    };
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    refiner.encode(&mut encoder);
    gpu.queue().submit([encoder.finish()]);
    let options = surface.refine_options();
    let topology = surface.topology().clone();
    let rule = FaceVaryingRule::default();
    let mut level = Level::<f32>::of_cage(surface.cage(), topology, options.scheme, rule).unwrap();
    let [low, high] = surface.cage().bounds();
    let size = (0..3)
        .map(|k| f64::from(high[k] - low[k]).powi(2))
        .sum::<f64>()
        .sqrt();
    let mut found = Found::default();
    for k in 1..=levels as usize {
        level = level.next(&options, &mut Timings::default()).unwrap();
        let (points, corners) = refiner.read(gpu, k).unwrap();
        let t = &level.topology;
        let want: Vec<u32> = (0..t.half_count() as u32).map(|h| t.vertex(h)).collect();
        assert_eq!(corners, want, "{name}: corners of level {k}");
        assert_eq!(points.len(), 3 * level.points.len(), "{name}: level {k}");
        found.note_points(&points, &level.points, size);
    }
    if has_limit {
        let [points, normals] = refiner.read_limit(gpu).unwrap().unwrap();
        let want = limit(&level, &options);
        found.note_points(&points, &want.positions, size);
        found.note_normals(&normals, &level, &want);
    }
    found
}

/// An open cube with edges that are sharp, fading and fading within a step, a dart, and a corner.
fn creased_cube(creases: CreaseMethod) -> Scene {
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
        creases: Some(creases),
        ..SurfaceOptions::default()
    };
    Scene::of(Surface::new(cage, &options))
}

fn options(scheme: Scheme) -> SurfaceOptions {
    SurfaceOptions {
        scheme: Some(scheme),
        ..SurfaceOptions::default()
    }
}

#[test]
fn levels_are_the_processors() {
    let Some(gpu) = gpu("levels") else { return };
    let mut all = Found::default();
    let mut run = 0;
    let mut note = |name: &str, scene: &Scene, levels: u32, has_limit: bool| {
        let found = compare(&gpu, name, &scene.objects[0].surface, levels);
        assert_eq!(found.normals > 0, has_limit, "{name}");
        println!(
            "gpu levels {name} {levels}: {:.1e} of the model, {} points; {:.4} degrees, {} normals",
            found.far, found.points, found.turned, found.normals
        );
        found.check(name);
        all = all.and(found);
        run += 1;
    };
    let smooth_triangles = SurfaceOptions {
        triangles: Some(TriangleRule::Smooth),
        ..options(Scheme::CatmullClark)
    };
    for (name, options, levels) in [
        ("cube", SurfaceOptions::default(), 0),
        ("octahedron", options(Scheme::Loop), 0),
        ("cube", SurfaceOptions::default(), 6),
        ("corner", SurfaceOptions::default(), 4),
        ("fan5", SurfaceOptions::default(), 4),
        ("fan24", SurfaceOptions::default(), 3),
        ("torus", SurfaceOptions::default(), 4),
        ("creature", SurfaceOptions::default(), 4),
        ("part", SurfaceOptions::default(), 4),
        ("part_creased", SurfaceOptions::default(), 4),
        ("octahedron", options(Scheme::Loop), 5),
        ("tetrahedron", options(Scheme::Loop), 5),
        ("octahedron", smooth_triangles, 4),
        ("tetrahedron", options(Scheme::CatmullClark), 4),
        ("part", options(Scheme::Bilinear), 3),
        ("octahedron", options(Scheme::Bilinear), 3),
    ] {
        note(name, &asset(name, options), levels, true);
    }
    for creases in [CreaseMethod::Uniform, CreaseMethod::Chaikin] {
        note("creased cube", &creased_cube(creases), 5, true);
        // Creases fade at the last level.
        note("creased cube", &creased_cube(creases), 1, false);
    }
    println!(
        "gpu levels: {run} cases, {} points, off by at most {:.1e} of the model, {} normals by {:.4} degrees",
        all.points, all.far, all.normals, all.turned
    );
}

#[test]
fn moved_points_make_other_levels() {
    let Some(gpu) = gpu("moved levels") else {
        return;
    };
    let mut surface = asset("part", SurfaceOptions::default()).objects[0]
        .surface
        .clone();
    let refiner = Refiner::with_limit(&gpu, &surface, 2).unwrap();
    let run = |refiner: &Refiner| {
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        refiner.encode(&mut encoder);
        gpu.queue().submit([encoder.finish()]);
        (
            refiner.read(&gpu, 2).unwrap(),
            refiner.read_limit(&gpu).unwrap(),
        )
    };
    let before = run(&refiner);
    let points = surface.cage().points().iter();
    let moved: Vec<[f32; 3]> = points
        .map(|p| [p[0], 0.5 * p[1] + 0.2 * p[0], p[2]])
        .collect();
    refiner.move_points(gpu.queue(), &moved).unwrap();
    surface.update_points(&moved).unwrap();
    let after = run(&refiner);
    assert!(after != before);
    // As if they had been there from the beginning.
    assert!(after == run(&Refiner::with_limit(&gpu, &surface, 2).unwrap()));
    assert!(refiner.move_points(gpu.queue(), &moved[1..]).is_err());
}

fn of_shape(shared: &Path, case: &Case) -> Scene {
    let mut loader = Loader::new(LoadOptions {
        surface: SurfaceOptions {
            creases: Some(case.options.creases),
            triangles: Some(case.options.triangles),
            boundary: Some(case.boundary),
            ..options(case.options.scheme)
        },
        ..LoadOptions::default()
    });
    let path = shared.join(format!("opensubdiv/shapes/{}.obj", case.name));
    loader
        .add_file(&path)
        .unwrap_or_else(|e| panic!("{}: {e}", case.name));
    loader.finish().0
}

#[test]
fn levels_of_reference_shapes_are_the_processors() {
    let Some(gpu) = gpu("levels of reference shapes") else {
        return;
    };
    let Some(shared) = crate::common::shared() else {
        println!("gpu levels of reference shapes: not run, EARMARK_SHARED is not set");
        return;
    };
    let mut all = Found::default();
    let (mut run, mut limits, mut refused) = (0, 0, 0);
    for case in cases(&shared) {
        let scene = of_shape(&shared, &case);
        let surface = &scene.objects[0].surface;
        if matches!(
            Refiner::new(&gpu, surface, 1),
            Err(GpuError::Unsupported { .. })
        ) {
            refused += 1;
            continue;
        }
        // As deep as creases fade.
        let has_limit = |&levels: &u32| Refiner::with_limit(&gpu, surface, levels).is_ok();
        let levels = (3..=5).find(has_limit).unwrap_or(3);
        let found = compare(&gpu, &case.name, surface, levels);
        limits += usize::from(found.normals > 0);
        // Where faces lie back to back there is no tangent plane.
        let bare = match &*case.name {
            "catmark_val2_back2back" => 60,
            _ => 0,
        };
        assert!(
            found.far <= DISTANCE && found.beyond <= bare,
            "{}: points are off by {}, {} normals by up to {}",
            case.name,
            found.far,
            found.beyond,
            found.turned
        );
        all = all.and(found);
        run += 1;
    }
    println!(
        "gpu levels of reference shapes: {run} cases, {limits} with limits, {refused} refused, {} points, off by at most {:.1e} of the model, {} normals, {} beyond the bar",
        all.points, all.far, all.normals, all.beyond
    );
    assert!(run > 100 && limits > 90);
}

#[test]
fn what_has_no_levels_is_refused() {
    let Some(gpu) = gpu("refused levels") else {
        return;
    };
    let refused = |scene: &Scene, levels, limit| {
        let surface = &scene.objects[0].surface;
        let made = match limit {
            true => Refiner::with_limit(&gpu, surface, levels),
            false => Refiner::new(&gpu, surface, levels),
        };
        match made {
            Err(GpuError::Unsupported { what }) => what,
            other => panic!("not refused: {other:?}"),
        }
    };
    let butterfly = asset("octahedron", options(Scheme::Butterfly));
    assert!(refused(&butterfly, 1, false).contains("interpolating"));
    let cube = asset("cube", SurfaceOptions::default());
    assert!(refused(&cube, 11, false).contains("above 10"));
    let part = asset("octahedron", options(Scheme::CatmullClark));
    assert!(refused(&part, 0, true).contains("polygons"));
    let fan = |n: u32| {
        let at = |k: u32| (k as f32 / n as f32 * std::f32::consts::TAU).sin_cos();
        let rim = (0..n).map(|k| [at(k).1, at(k).0, 0.0]);
        let points: Vec<[f32; 3]> = rim.chain([[0.0; 3]]).collect();
        let corners = (0..n).flat_map(|k| [n, k, (k + 1) % n]).collect();
        let chaikin = SurfaceOptions {
            creases: Some(CreaseMethod::Chaikin),
            ..options(Scheme::CatmullClark)
        };
        let cage = earmark::Cage::new(points, &vec![3; n as usize], corners).unwrap();
        Scene::of(Surface::new(cage, &chaikin))
    };
    assert!(refused(&fan(513), 1, false).contains("512"));
    let polygon = earmark::Cage::new(
        fan(513).objects[0].surface.cage().points()[..513].to_vec(),
        &[513],
        (0..513).collect(),
    );
    let polygon = Surface::new(polygon.unwrap(), &options(Scheme::CatmullClark));
    assert!(Refiner::new(&gpu, &polygon, 1).is_ok());
    assert!(refused(&Scene::of(polygon), 1, true).contains("512"));
    let creased = creased_cube(CreaseMethod::Uniform);
    assert!(refused(&creased, 2, true).contains("fade"));
    assert!(Refiner::with_limit(&gpu, &creased.objects[0].surface, 3).is_ok());
}
