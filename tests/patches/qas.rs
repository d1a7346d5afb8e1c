//! Quadratic patches.

use super::*;
use earmark::distance::{Summary, cap, limit_of, limit_points, of_face};

#[test]
fn patches_pass_through_what_they_are_fitted_to() {
    for (name, cage, scheme) in [
        ("creature", asset("creature"), Scheme::CatmullClark),
        ("part_creased", asset("part_creased"), Scheme::CatmullClark),
        ("creature", asset("creature"), Scheme::Kobbelt),
        ("icosahedron", icosahedron(), Scheme::Loop),
        ("icosahedron", icosahedron(), Scheme::Butterfly),
        ("semi-sharp cube", creased_cube(1.5), Scheme::CatmullClark),
    ] {
        let limit = surface(&cage, scheme, PatchKind::None);
        let qas = surface(&cage, scheme, PatchKind::Qas);
        let (mut point, mut normal) = (0.0_f32, 0.0_f32);
        for q in 0..limit.quads().face_count() as u32 {
            let (a, b) = (limit.dice(q, 1), qas.dice(q, 1));
            for k in drawn(&limit, 3) {
                point = point.max(distance(a.points[k], b.points[k]));
                normal = normal.max(angle(a.normals[k], b.normals[k]));
            }
        }
        println!("{name} {scheme:?}: off by {point:e}, {normal:e} degrees");
        assert!(point < 3e-7 * size(&cage), "{name} {scheme:?}: {point:e}");
        assert!(normal < 1e-3, "{name} {scheme:?}: {normal} degrees");
    }
}

/// Largest distance between patches and limit surface over the faces far from the border.
fn inner_error(cage: &Cage, scheme: Scheme, is_inner: impl Fn([f32; 3]) -> bool) -> f32 {
    let limit = surface(cage, scheme, PatchKind::None);
    let qas = surface(cage, scheme, PatchKind::Qas);
    let (mut worst, mut faces) = (0.0_f32, 0);
    for q in 0..limit.quads().face_count() as u32 {
        let (a, b) = (limit.dice(q, 3), qas.dice(q, 3));
        if !drawn(&limit, a.side).iter().all(|&k| is_inner(a.points[k])) {
            continue;
        }
        faces += 1;
        for k in drawn(&limit, a.side) {
            worst = worst.max(distance(a.points[k], b.points[k]));
        }
    }
    assert!(faces > 7, "{faces} faces are inside");
    worst
}

#[test]
fn quadratics_on_regular_triangles_are_loops_limit() {
    let n = 9_u32;
    let quadratic = |x: f32, y: f32| [x, y, 0.3 * x * x - 0.4 * x * y + 0.2 * y * y + 0.1 * x];
    let points = (0..n * n).map(|k| {
        let (i, j) = ((k % n) as f32 - 4.0, (k / n) as f32 - 4.0);
        quadratic(i - 0.5 * j, j * 0.75_f32.sqrt())
    });
    let faces = (0..(n - 1) * (n - 1)).flat_map(|k| {
        let a = k / (n - 1) * n + k % (n - 1);
        [[a, a + 1, a + n + 1], [a, a + n + 1, a + n]]
    });
    let cage = build(points, faces).build().unwrap();
    let inner = |p: [f32; 3]| p[0] * p[0] + p[1] * p[1] < 6.0;
    let error = inner_error(&cage, Scheme::Loop, inner);
    println!("quadratic on triangles: {error:e}");
    assert!(error < 2e-6, "{error:e}");
}

#[test]
fn biquadratics_on_a_grid_are_catmull_clarks_limit() {
    let n = 9_u32;
    let points = (0..n * n).map(|k| {
        let (x, y) = ((k % n) as f32 - 4.0, (k / n) as f32 - 4.0);
        [
            x,
            y,
            0.05 * x * x * y * y - 0.2 * x * y * y + 0.3 * x * x - y,
        ]
    });
    let faces = (0..(n - 1) * (n - 1)).map(|k| {
        let a = k / (n - 1) * n + k % (n - 1);
        [a, a + 1, a + n + 1, a + n]
    });
    let cage = build(points, faces).build().unwrap();
    let inner = |p: [f32; 3]| p[0].abs() < 2.1 && p[1].abs() < 2.1;
    let error = inner_error(&cage, Scheme::CatmullClark, inner);
    println!("biquadratic on a grid: {error:e}");
    assert!(error < 2e-6, "{error:e}");
}

/// Distances of all faces, or of the first.
fn distances(cage: &Cage, scheme: Scheme, kind: PatchKind, moved: bool, faces: u32) -> Summary {
    let options = options(scheme, kind);
    let mut patches = Surface::new(cage.clone(), &options);
    let limit = limit_of(&patches, &options);
    if moved {
        patches.update_points(&limit_points(&limit)).unwrap();
    }
    // Of large models every tenth face.
    let step = if patches.quads().face_count() > 2000 {
        10
    } else {
        1
    };
    let mut sum = Summary::default();
    let all = 0..patches.quads().face_count() as u32;
    for q in all.step_by(step).take(faces as usize) {
        sum.add(&of_face(&patches, &limit, q, 3));
    }
    sum
}

#[test]
fn quadratic_patches_are_far_closer_than_pn_triangles() {
    for (name, cage, scheme, worst) in [
        ("creature", asset("creature"), Scheme::CatmullClark, 0.25),
        ("icosahedron", icosahedron(), Scheme::Loop, 0.2),
    ] {
        let d = f64::from(size(&cage));
        let [qas, pn, moved] = [
            (PatchKind::Qas, false),
            (PatchKind::Pn, false),
            (PatchKind::Pn, true),
        ]
        .map(|(kind, moved)| distances(&cage, scheme, kind, moved, u32::MAX));
        for (what, s) in [("qas", qas), ("pn", pn), ("pn at limit points", moved)] {
            println!(
                "{name} {what}: max {:.2e} rms {:.2e}, at the same parameters max {:.2e} rms {:.2e}",
                s.max / d,
                s.rms() / d,
                s.max_same / d,
                s.rms_same() / d
            );
        }
        assert!(
            qas.max < worst * pn.max && qas.rms() < worst * pn.rms(),
            "{name}"
        );
        assert!(qas.max < moved.max && qas.rms() < moved.rms(), "{name}");
    }
}

#[test]
fn valences_three_to_twelve() {
    for (scheme, triangles) in [(Scheme::CatmullClark, false), (Scheme::Loop, true)] {
        for n in 3..=12 {
            let cage = cap(n, triangles).unwrap();
            let d = f64::from(size(&cage));
            let [qas, pn, moved] = [
                (PatchKind::Qas, false),
                (PatchKind::Pn, false),
                (PatchKind::Pn, true),
            ]
            .map(|(kind, moved)| distances(&cage, scheme, kind, moved, n));
            println!(
                "{scheme:?} valence {n}: qas {:.1e} rms {:.1e}, pn {:.1e} rms {:.1e}, pn at limit points {:.1e} rms {:.1e}",
                qas.max / d,
                qas.rms() / d,
                pn.max / d,
                pn.rms() / d,
                moved.max / d,
                moved.rms() / d
            );
            assert_eq!(qas.points, u64::from(n) * 81);
            assert!(qas.rms() < pn.rms() / 3.0, "{scheme:?} valence {n}");
            assert!(qas.max < 5e-3 * d, "{scheme:?} valence {n}");
        }
    }
}

#[test]
fn points_on_the_limit_have_no_distance() {
    let cage = asset("part");
    let options = options(Scheme::CatmullClark, PatchKind::None);
    let limit = Surface::new(cage.clone(), &options);
    let mut sum = Summary::default();
    for q in 0..limit.quads().face_count() as u32 {
        sum.add(&of_face(&limit, &limit, q, 2));
    }
    assert!(sum.max_same < f64::from(2e-6 * size(&cage)), "{sum:?}");
    assert!(sum.max <= sum.max_same && sum.points > 10_000);
}

/// Models outside of the project.
#[test]
fn quadratic_patches_of_real_models_are_closer_than_pn_triangles() {
    let Some(folder) = common::shared() else {
        return;
    };
    for path in common::models(&folder.join("models")) {
        let cage = read(&std::fs::read_to_string(&path).unwrap());
        let scheme = match cage.first_polygon() {
            None => Scheme::Loop,
            Some(_) => Scheme::CatmullClark,
        };
        let d = f64::from(size(&cage));
        let [qas, pn, moved] = [
            (PatchKind::Qas, false),
            (PatchKind::Pn, false),
            (PatchKind::Pn, true),
        ]
        .map(|(kind, moved)| distances(&cage, scheme, kind, moved, u32::MAX));
        println!(
            "{} {scheme:?}: qas {:.2e} rms {:.2e}, pn {:.2e} rms {:.2e}, pn at limit points {:.2e} rms {:.2e}",
            common::name(&path),
            qas.max / d,
            qas.rms() / d,
            pn.max / d,
            pn.rms() / d,
            moved.max / d,
            moved.rms() / d
        );
        assert!(
            qas.rms() < pn.rms() && qas.rms() < moved.rms(),
            "{}",
            path.display()
        );
    }
}
