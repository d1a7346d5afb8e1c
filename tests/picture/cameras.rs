//! Cameras and their views.

use super::{Random, UNIT, close, project, size};
use earmark::camera::{Camera, CameraError, Sphere};

#[test]
fn known_points_fall_on_known_pixels() {
    // 90 degrees from (0, 0, 2): the plane z = 0 shows y from -2 to 2 over 200 pixels.
    let camera = Camera::default()
        .with_eye_target([0.0, 0.0, 2.0], [0.0; 3])
        .with_fov(90.0);
    let view = camera.framing(&UNIT, size(400, 200)).expect("valid");
    for (p, x, y) in [
        ([0.0, 0.0, 0.0], 200.0, 100.0),
        ([4.0, 2.0, 0.0], 400.0, 0.0),
        ([-4.0, -2.0, 0.0], 0.0, 200.0),
        ([1.0, 0.0, 0.0], 250.0, 100.0),
        ([0.0, 0.5, 1.0], 200.0, 50.0),
    ] {
        let [sx, sy, depth] = project(&view, p);
        assert!(
            close(sx, x, 0.002) && close(sy, y, 0.002),
            "{p:?}: {sx} {sy}"
        );
        assert!(close(depth, 1.0 / (2.0 - p[2]), 1e-6));
    }
    assert!(view.project([0.0, 0.0, 2.5]).is_none(), "behind the eye");
    assert_eq!(view.pixel_scale(2.0), 50.0);
    assert_eq!(view.distance([0.0, 0.0, -3.0]), 5.0);
}

#[test]
fn orthographic_pixels_and_depth() {
    let camera = Camera::default().with_orbit(0.0, 0.0).with_ortho();
    let view = camera.framing(&UNIT, size(300, 200)).expect("valid");
    let scale = view.pixel_scale(7.0);
    assert_eq!(scale, view.pixel_scale(1.0));
    assert!(scale < 100.0 && scale > 93.0, "tight: {scale}");
    let [x, y, depth] = project(&view, [0.5, 0.25, 0.0]);
    assert!(close(x, 150.0 + 0.5 * scale, 0.01) && close(y, 100.0 - 0.25 * scale, 0.01));
    assert!(close(depth, 1.5, 1e-5));
    let near = project(&view, [0.0, 0.0, 1.0])[2];
    let far = project(&view, [0.0, 0.0, -1.0])[2];
    assert!(near > 1.98 && near <= 2.0 && (1.0..1.02).contains(&far));
    assert!(
        view.project([0.0, 0.0, 1.2]).is_none(),
        "before the near plane"
    );
    assert_eq!(view.projection.w, [0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn azimuth_elevation_and_up_axis() {
    let eye = |camera: Camera| {
        let view = camera.framing(&UNIT, size(64, 64)).expect("valid");
        let d = view.eye.iter().map(|c| c * c).sum::<f32>().sqrt();
        (view.eye.map(|c| c / d), view.up)
    };
    let is = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| close(*a, b, 1e-6));
    let camera = Camera::default();
    assert!(is(eye(camera.with_orbit(0.0, 0.0)).0, [0.0, 0.0, 1.0]));
    assert!(is(eye(camera.with_orbit(90.0, 0.0)).0, [1.0, 0.0, 0.0]));
    let (top, up) = eye(camera.with_orbit(0.0, 90.0));
    assert!(is(top, [0.0, 1.0, 0.0]) && is(up, [0.0, 0.0, -1.0]));
    let z_up = camera.with_up([0.0, 0.0, 3.0]);
    let (front, up) = eye(z_up.with_orbit(0.0, 0.0));
    assert!(is(front, [0.0, -1.0, 0.0]) && is(up, [0.0, 0.0, 1.0]));
    assert!(is(eye(z_up.with_orbit(90.0, 0.0)).0, [1.0, 0.0, 0.0]));
    let (_, up) = eye(camera.with_up([0.0, -1.0, 0.0]).with_orbit(30.0, 0.0));
    assert!(is(up, [0.0, -1.0, 0.0]));
}

#[test]
fn automatic_views_hold_the_sphere_and_are_tight() {
    let mut random = Random(7);
    for _ in 0..1000 {
        let sphere = Sphere {
            center: [0; 3].map(|_| random.within(-5.0, 5.0)),
            radius: random.within(0.1, 10.0),
        };
        let mut camera = Camera::default()
            .with_orbit(random.within(-400.0, 400.0), random.within(-90.0, 90.0))
            .with_fov(random.within(5.0, 120.0));
        camera.ortho = random.next() < 0.3;
        let (w, h) = (random.within(50.0, 900.0), random.within(50.0, 900.0));
        let view = camera
            .framing(&sphere, size(w as u32, h as u32))
            .expect("valid");
        let (w, h) = (view.size.width as f32, view.size.height as f32);
        let mut lo = [f32::MAX; 2];
        let mut hi = [f32::MIN; 2];
        for i in 0..400 {
            // Half of the points on the silhouette as the eye sees it, so that the extremes are met.
            let d = if i % 2 == 0 {
                random.direction()
            } else {
                let a = f64::from(i) * std::f64::consts::TAU / 400.0;
                let sin = if camera.ortho {
                    0.0
                } else {
                    let e = [0, 1, 2].map(|k| f64::from(view.eye[k]) - sphere.center[k]);
                    sphere.radius / e.iter().map(|c| c * c).sum::<f64>().sqrt()
                };
                let cos = (1.0 - sin * sin).sqrt();
                [0, 1, 2].map(|k| {
                    (f64::from(view.right[k]) * a.cos() + f64::from(view.up[k]) * a.sin()) * cos
                        - f64::from(view.forward[k]) * sin
                })
            };
            let p = [0, 1, 2].map(|k| (sphere.center[k] + d[k] * sphere.radius) as f32);
            let [x, y, _] = project(&view, p);
            for (k, c) in [x, y].into_iter().enumerate() {
                lo[k] = lo[k].min(c);
                hi[k] = hi[k].max(c);
            }
            let depth = view.depth01(view.distance(p));
            assert!(depth > 0.0 && depth < 1.0);
        }
        assert!(lo[0] > 0.0 && lo[1] > 0.0 && hi[0] < w && hi[1] < h);
        let fill = (hi[0] - lo[0]).max(hi[1] - lo[1]) / w.min(h);
        assert!(fill > 0.85, "only {fill} of the picture used");
    }
}

#[test]
fn rays_undo_projection() {
    let mut random = Random(3);
    for ortho in [false, true] {
        let camera = Camera {
            ortho,
            ..Camera::default()
        };
        let view = camera.framing(&UNIT, size(640, 480)).expect("valid");
        for _ in 0..100 {
            let p = random.direction().map(|c| c as f32);
            let [x, y, _] = project(&view, p);
            let (o, d) = view.ray(x, y);
            let op = [0, 1, 2].map(|k| p[k] - o[k]);
            let along = op[0] * d[0] + op[1] * d[1] + op[2] * d[2];
            for k in 0..3 {
                assert!(close(op[k], d[k] * along, 2e-5));
            }
        }
    }
}

#[test]
fn zoom_magnifies_about_the_centre() {
    let one = Camera::default()
        .framing(&UNIT, size(500, 500))
        .expect("valid");
    let two = Camera::default()
        .with_zoom(2.0)
        .framing(&UNIT, size(500, 500))
        .expect("valid");
    let p = [0.2, -0.1, 0.3];
    let (a, b) = (project(&one, p), project(&two, p));
    assert!(close((b[0] - 250.0) / (a[0] - 250.0), 2.0, 1e-4));
    assert_eq!(one.eye, two.eye);
}

#[test]
fn bad_cameras_are_named() {
    let ask = |c: Camera| c.framing(&UNIT, size(64, 64)).expect_err("refused");
    let camera = Camera::default();
    let at = camera.with_eye_target([0.0, 0.0, 3.0], [0.0; 3]);
    assert_eq!(
        ask(camera.with_eye_target([1.0; 3], [1.0; 3])),
        CameraError::EyeAtTarget
    );
    assert_eq!(ask(camera.with_up([0.0; 3])), CameraError::ZeroUp);
    assert_eq!(
        ask(at.with_near_far(0.0, 5.0)),
        CameraError::Near { near: 0.0 }
    );
    assert!(matches!(
        ask(at.with_near_far(5.0, 5.0)),
        CameraError::Range { .. }
    ));
    for fov in [0.0, -3.0, 180.0, 400.0] {
        assert_eq!(ask(camera.with_fov(fov)), CameraError::Fov { fov });
    }
    assert!(matches!(
        ask(camera.with_zoom(0.0)),
        CameraError::Zoom { .. }
    ));
    for bad in [f64::NAN, f64::INFINITY] {
        for c in [
            camera.with_orbit(bad, 0.0),
            camera.with_fov(bad),
            camera.with_zoom(bad),
            camera.with_up([bad, 0.0, 0.0]),
            camera.with_eye_target([bad; 3], [0.0; 3]),
            at.with_near_far(0.1, bad),
        ] {
            assert!(matches!(ask(c), CameraError::NotFinite { .. }));
        }
    }
    assert_eq!(
        camera.framing(&UNIT, size(0, 64)),
        Err(CameraError::EmptyPicture)
    );
    let huge = Sphere {
        center: [0.0; 3],
        radius: 1e38,
    };
    assert!(camera.framing(&huge, size(64, 64)).is_err());
}

#[test]
fn unusual_cameras_still_give_a_view() {
    let sz = size(64, 64);
    let point = Sphere::of_box([[2.0; 3]; 2]);
    let view = Camera::default().framing(&point, sz).expect("valid");
    assert!(close(project(&view, [2.0; 3])[0], 32.0, 0.01));
    // Inside the sphere, looking away from it, and along the up vector.
    for (eye, target, replaced) in [
        ([0.2, 0.0, 0.1], [0.0, 0.0, 0.0], false),
        ([0.0, 0.0, 5.0], [0.0, 0.0, 9.0], false),
        ([0.0, 4.0, 0.0], [0.0, 0.0, 0.0], true),
        ([0.0, -4.0, 0.0], [0.0, 0.0, 0.0], true),
    ] {
        let view = Camera::default()
            .with_eye_target(eye, target)
            .framing(&UNIT, sz)
            .expect("valid");
        assert!(view.near > 0.0 && view.near < view.far);
        assert_eq!(view.up_replaced, replaced);
        let axes = [view.right, view.up, view.forward];
        for (i, a) in axes.iter().enumerate() {
            for (j, b) in axes.iter().enumerate() {
                let dot = a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>();
                assert!(close(dot, f32::from(u8::from(i == j)), 1e-6));
            }
        }
    }
}

#[test]
fn spheres_around_points() {
    let corners = [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
    ];
    assert_eq!(Sphere::of_points(corners).radius, 1.0);
    assert!(Sphere::of_box([[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]]).radius > 1.41);
    assert_eq!(Sphere::of_points([]).radius, 0.0);
    assert_eq!(UNIT.inflated(0.5).radius, 1.5);
}
