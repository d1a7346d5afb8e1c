//! From surface point to pixel: camera, textures, shading and film through the public API.

use earmark::camera::{Camera, CameraError, Sphere, View};
use earmark::film::srgb::{Srgb, to_linear};
use earmark::film::{Encoding, Film, Image, png};
use earmark::records::ScreenSize;
use earmark::shade::{NO_MATERIAL, ShadeMode, Shader, SurfaceMaterial, SurfacePoint};
use earmark::texture::{LoadError, MAX_BYTES, Meaning, Texture};

const fn size(width: u32, height: u32) -> ScreenSize {
    ScreenSize {
        width,
        height,
        samples: 4,
    }
}

const UNIT: Sphere = Sphere {
    center: [0.0; 3],
    radius: 1.0,
};

/// A small generator of numbers from 0 to 1, the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
    fn within(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.next()
    }
    fn direction(&mut self) -> [f64; 3] {
        loop {
            let v = [0; 3].map(|_| self.within(-1.0, 1.0));
            let d = v.iter().map(|c| c * c).sum::<f64>();
            if (0.01..1.0).contains(&d) {
                return v.map(|c| c / d.sqrt());
            }
        }
    }
}

fn close(a: f32, b: f32, tolerance: f32) -> bool {
    (a - b).abs() <= tolerance
}

fn project(view: &View, p: [f32; 3]) -> [f32; 3] {
    view.project(p).expect("in front of the eye")
}

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

fn texture(width: u32, height: u32, at: impl Fn(u32, u32) -> [u8; 4]) -> Texture {
    let texels = (0..width * height)
        .map(|i| at(i % width, i / width))
        .collect();
    Texture::from_rgba8(width, height, texels, Meaning::Color).expect("allowed")
}

#[test]
fn a_constant_texture_is_constant() {
    let t = texture(37, 5, |_, _| [200, 100, 50, 128]);
    let exact = [200, 100, 50].map(|c| Srgb::tables().decode(c));
    let mut random = Random(5);
    for _ in 0..2000 {
        let lod = random.within(-1.0, 9.0) as f32;
        let s = t.sample(
            random.within(-3.0, 3.0) as f32,
            random.within(-3.0, 3.0) as f32,
            lod,
        );
        assert_eq!([s[0], s[1], s[2]], exact, "lod {lod}");
        assert_eq!(s[3], 128.0 / 255.0);
    }
}

#[test]
fn the_smallest_level_is_the_mean_light() {
    let mut random = Random(11);
    for (w, h) in [(16, 16), (7, 13), (100, 3), (1, 31), (63, 65)] {
        let texels: Vec<[u8; 4]> = (0..w * h)
            .map(|_| [0; 4].map(|_| (random.next() * 256.0) as u8))
            .collect();
        let t = texture(w, h, |x, y| texels[(y * w + x) as usize]);
        let last = t.texel(t.level_count() - 1, 0, 0);
        for (k, &got) in last.iter().enumerate().take(3) {
            let mean = texels
                .iter()
                .map(|t| to_linear(f64::from(t[k]) / 255.0))
                .sum::<f64>()
                / texels.len() as f64;
            // One rounding to 8 bits: half a code.
            let code = earmark::film::srgb::from_linear(mean) * 255.0;
            let got = earmark::film::srgb::from_linear(f64::from(got)) * 255.0;
            assert!((code - got).abs() < 0.55, "{w}x{h}: {code} {got}");
        }
    }
}

#[test]
fn a_far_checkerboard_is_half_the_light() {
    let t = texture(64, 64, |x, y| {
        let c = if (x + y) % 2 == 0 { 255 } else { 0 };
        [c, c, c, 255]
    });
    let lod = t.lod(0.25);
    assert!(close(lod, 4.0, 0.01));
    for i in 0..50 {
        let s = t.sample(i as f32 * 0.037, i as f32 * 0.011, lod);
        // Code 188 is the nearest to half the light; 128 would be a fifth.
        assert!(close(s[0], 0.5, 0.005), "{}", s[0]);
    }
}

#[test]
fn textures_repeat_and_stand_upright() {
    // Top left red, top right green, bottom left blue, bottom right white.
    let t = texture(2, 2, |x, y| match (x, y) {
        (0, 0) => [255, 0, 0, 255],
        (1, 0) => [0, 255, 0, 255],
        (0, 1) => [0, 0, 255, 255],
        _ => [255, 255, 255, 255],
    });
    let at = |u, v| t.sample(u, v, 0.0);
    assert_eq!(at(0.25, 0.75), [1.0, 0.0, 0.0, 1.0]);
    assert_eq!(at(0.75, 0.75), [0.0, 1.0, 0.0, 1.0]);
    assert_eq!(at(0.25, 0.25), [0.0, 0.0, 1.0, 1.0]);
    assert_eq!(at(0.75, 0.25), [1.0, 1.0, 1.0, 1.0]);
    for (u, v) in [(0.25, 0.75), (0.6, 0.1), (0.0, 0.0), (0.99, 0.5)] {
        for (du, dv) in [(1.0, 0.0), (-2.0, 3.0), (8.0, -8.0)] {
            let (a, b) = (at(u, v), at(u + du, v + dv));
            assert!(a.iter().zip(b).all(|(a, b)| close(*a, b, 1e-5)));
        }
    }
    // The border blends with the opposite side.
    assert!(close(at(0.0, 0.75)[1], 0.5, 1e-6));
    for bad in [f32::NAN, f32::INFINITY, -1e30] {
        assert!(t.sample(bad, bad, bad).iter().all(|c| c.is_finite()));
    }
}

/// A PNG file of one colour, by colour type.
fn png_of(color: image::ExtendedColorType, pixel: &[u8]) -> Vec<u8> {
    use image::ImageEncoder;
    let mut out = Vec::new();
    image::codecs::png::PngEncoder::new(&mut out)
        .write_image(&pixel.repeat(6), 3, 2, color)
        .expect("encodes");
    out
}

#[test]
fn every_colour_type_decodes() {
    use image::ExtendedColorType as C;
    let word = |v: u16| v.to_ne_bytes();
    let words = |v: &[u16]| v.iter().flat_map(|&v| word(v)).collect::<Vec<u8>>();
    let l = |c: u8| Srgb::tables().decode(c);
    let (a, b, c) = (l(100), l(150), l(200));
    let half = 128.0 / 255.0;
    for (file, expected, alpha) in [
        (png_of(C::L8, &[100]), [a, a, a, 1.0], false),
        (png_of(C::La8, &[100, 128]), [a, a, a, half], true),
        (png_of(C::Rgb8, &[100, 150, 200]), [a, b, c, 1.0], false),
        (
            png_of(C::Rgba8, &[100, 150, 200, 128]),
            [a, b, c, half],
            true,
        ),
        (png_of(C::L16, &words(&[100 * 257])), [a, a, a, 1.0], false),
        (
            png_of(C::La16, &words(&[100 * 257, 128 * 257])),
            [a, a, a, half],
            true,
        ),
        (
            png_of(C::Rgb16, &words(&[100 * 257, 150 * 257, 200 * 257])),
            [a, b, c, 1.0],
            false,
        ),
        (
            png_of(
                C::Rgba16,
                &words(&[100 * 257, 150 * 257, 200 * 257, 128 * 257]),
            ),
            [a, b, c, half],
            true,
        ),
    ] {
        let mut budget = 10_000;
        let t = Texture::decode(&file, Meaning::Color, &mut budget).expect("decodes");
        assert_eq!(t.size(), [3, 2]);
        assert_eq!(t.has_alpha(), alpha);
        assert_eq!(10_000 - budget, t.bytes() as u64);
        let s = t.sample(0.4, 0.6, 0.0);
        for (s, e) in s.iter().zip(expected) {
            assert!(close(*s, e, 1e-5), "{s} for {e}");
        }
    }
    let data = Texture::decode(&png_of(C::L8, &[100]), Meaning::Data, &mut 1000).expect("decodes");
    assert!(close(data.opacity(0.5, 0.5, 0.0), 100.0 / 255.0, 1e-6));
    let masked =
        Texture::decode(&png_of(C::La8, &[9, 128]), Meaning::Data, &mut 1000).expect("decodes");
    assert!(close(masked.opacity(0.5, 0.5, 0.0), half, 1e-6));
}

#[test]
fn jpeg_decodes_and_limits_hold() {
    let mut jpeg = Vec::new();
    image::codecs::jpeg::JpegEncoder::new(&mut jpeg)
        .encode(&[128; 48], 4, 4, image::ExtendedColorType::Rgb8)
        .expect("encodes");
    let ask = |bytes: &[u8], mut budget: u64| {
        Texture::decode(bytes, Meaning::Color, &mut budget).map(|t| t.size())
    };
    assert_eq!(ask(&jpeg, 1 << 20), Ok([4, 4]));
    // 16 + 4 + 1 texels of 4 bytes.
    assert_eq!(ask(&jpeg, 84), Ok([4, 4]));
    assert!(matches!(
        ask(&jpeg, 83),
        Err(LoadError::Budget {
            wanted: 84,
            allowed: 83,
            ..
        })
    ));
    assert_eq!(ask(b"GIF89a", 1 << 20), Err(LoadError::Unsupported));
    assert_eq!(ask(b"", 1 << 20), Err(LoadError::Unsupported));
    // A header that promises 60000x60000 pixels is refused although the file has no data for them.
    let mut bomb = png_of(image::ExtendedColorType::Rgb8, &[1, 2, 3]);
    bomb[16..20].copy_from_slice(&60_000_u32.to_be_bytes());
    bomb[20..24].copy_from_slice(&60_000_u32.to_be_bytes());
    let crc = crc32(&bomb[12..29]);
    bomb[29..33].copy_from_slice(&crc.to_be_bytes());
    assert!(matches!(
        ask(&bomb, u64::MAX),
        Err(LoadError::Budget {
            width: 60_000,
            allowed: MAX_BYTES,
            ..
        })
    ));
    // Cut and damaged files are errors or pictures, never a panic.
    let file = png_of(image::ExtendedColorType::Rgba8, &[1, 2, 3, 4]);
    for file in [&file, &jpeg] {
        for n in 0..file.len() {
            let _ = ask(&file[..n], 1 << 20);
            let mut damaged = file.clone();
            damaged[n] ^= 0x55;
            let _ = ask(&damaged, 1 << 20);
        }
    }
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, &b| {
        (0..8).fold(crc ^ u32::from(b), |c, _| {
            (c >> 1) ^ (0xedb8_8320 & (c & 1).wrapping_neg())
        })
    })
}

/// The unit sphere by ray casting: per pixel the point seen, or none.
fn cast(view: &View) -> Vec<Option<SurfacePoint>> {
    let mut points = Vec::new();
    for y in 0..view.size.height {
        for x in 0..view.size.width {
            let (o, d) = view.ray(x as f32 + 0.5, y as f32 + 0.5);
            let b = o[0] * d[0] + o[1] * d[1] + o[2] * d[2];
            let c = o[0] * o[0] + o[1] * o[1] + o[2] * o[2] - 1.0;
            let disc = b * b - c;
            points.push((disc > 0.0).then(|| {
                let t = -b - disc.sqrt();
                let p = [0, 1, 2].map(|k| o[k] + d[k] * t);
                SurfacePoint {
                    position: p,
                    normal: p,
                    geometric: p,
                    uv: Some([p[0], p[1]]),
                    uv_footprint: 0.01,
                    depth01: view.depth01(view.distance(p)),
                    ..SurfacePoint::default()
                }
            }));
        }
    }
    points
}

#[test]
fn the_default_picture_models_the_form() {
    let view = Camera::default()
        .framing(&UNIT, size(96, 96))
        .expect("valid");
    let shader = Shader::new(ShadeMode::Lit, &view, &[], &[]);
    let film = Film::new(Encoding::Srgb, [0; 4]);
    let points = cast(&view);
    let pixels: Vec<[u8; 4]> = points
        .iter()
        .map(|p| film.pixel(p.as_ref().map_or([0.0; 4], |p| shader.shade(p))))
        .collect();
    let seen: Vec<_> = pixels.iter().filter(|p| p[3] == 255).collect();
    assert!(seen.len() > 6000 && seen.len() < 96 * 96 * 79 / 100);
    let brightest = seen.iter().map(|p| p[1]).max();
    let darkest = seen.iter().map(|p| p[1]).min();
    assert!(
        (195..245).contains(&brightest.expect("seen")),
        "{brightest:?}"
    );
    assert!((30..90).contains(&darkest.expect("seen")), "{darkest:?}");
    // Light from the upper left, shadow at the lower right, a rim at the right edge brighter than what is beside it.
    let at = |x: usize, y: usize| i32::from(pixels[y * 96 + x][1]);
    assert!(at(30, 25) > at(60, 65) + 60);
    let row: Vec<_> = (48..96)
        .filter(|&x| pixels[40 * 96 + x][3] == 255)
        .collect();
    let edge = *row.last().expect("seen");
    let darkest_right = row.iter().map(|&x| at(x, 40)).min().expect("seen");
    assert!(at(edge, 40) > darkest_right + 15);
    // A white surface keeps its shape: no channel is burnt out.
    let white =
        Shader::new(ShadeMode::Lit, &view, &[], &[]).with_default_material(SurfaceMaterial::WHITE);
    let burnt = points
        .iter()
        .flatten()
        .filter(|p| film.pixel(white.shade(p))[..3].contains(&255));
    assert_eq!(burnt.count(), 0);
}

#[test]
fn both_sides_are_lit_alike() {
    let view = Camera::default().framing(&UNIT, size(8, 8)).expect("valid");
    let shader = Shader::new(ShadeMode::Lit, &view, &[], &[]);
    for p in cast(&view).iter().flatten() {
        let turned = SurfacePoint {
            normal: p.normal.map(|c| -c),
            geometric: p.geometric.map(|c| -c),
            ..*p
        };
        assert_eq!(shader.shade(p), shader.shade(&turned));
    }
}

#[test]
fn many_points_at_once_give_the_same_bits() {
    let texture = texture(8, 8, |x, y| [(x * 30) as u8, (y * 30) as u8, 90, 255]);
    let textures = [texture];
    let materials = [SurfaceMaterial::from_mtl([0.7; 3], 0.6, Some(0), None)];
    for mode in [
        ShadeMode::Lit,
        ShadeMode::Flat,
        ShadeMode::Normals,
        ShadeMode::Level,
    ] {
        for ortho in [false, true] {
            let camera = Camera {
                ortho,
                ..Camera::default()
            };
            let view = camera.framing(&UNIT, size(33, 31)).expect("valid");
            let shader = Shader::new(mode, &view, &materials, &textures);
            let mut points: Vec<_> = cast(&view).into_iter().flatten().collect();
            for (i, p) in points.iter_mut().enumerate() {
                p.material = if i % 3 == 0 { 0 } else { NO_MATERIAL };
                p.normal = p.normal.map(|c| c * (1.0 + i as f32 * 0.01));
            }
            let mut colors = vec![[9.0; 4]; points.len()];
            shader.shade_all(&points, &mut colors);
            for (p, c) in points.iter().zip(&colors) {
                assert_eq!(shader.shade(p).map(f32::to_bits), c.map(f32::to_bits));
            }
        }
    }
}

#[test]
fn data_modes_show_their_numbers() {
    let view = Camera::default().framing(&UNIT, size(8, 8)).expect("valid");
    let pixel = |mode: ShadeMode, p: &SurfacePoint| {
        let shader = Shader::new(mode, &view, &[], &[]);
        Film::new(mode.encoding(), [0; 4]).pixel(shader.shade(p))
    };
    let p = SurfacePoint {
        normal: [0.0, -2.0, 0.0],
        uv: Some([0.2, 1.6]),
        depth01: 0.2,
        ..SurfacePoint::default()
    };
    assert_eq!(pixel(ShadeMode::Normals, &p), [128, 0, 128, 255]);
    assert_eq!(pixel(ShadeMode::Uv, &p), [51, 153, 0, 255]);
    assert_eq!(pixel(ShadeMode::Depth, &p), [204, 204, 204, 255]);
    let without = SurfacePoint { uv: None, ..p };
    assert_eq!(pixel(ShadeMode::Uv, &without), [0, 0, 0, 255]);
    let levels: Vec<_> = (0..11)
        .map(|level| pixel(ShadeMode::Level, &SurfacePoint { level, ..p }))
        .collect();
    for (i, a) in levels.iter().enumerate() {
        assert!(levels[..i].iter().all(|b| b != a), "level {i}");
    }
    let odd = pixel(ShadeMode::Level, &SurfacePoint { face: 1, ..p });
    assert!(odd[0] < levels[0][0]);
    assert!(pixel(ShadeMode::Level, &SurfacePoint { level: 900, ..p })[3] == 255);
}

#[test]
fn shading_survives_anything() {
    let textures = [texture(4, 4, |x, y| [x as u8, y as u8, 0, 255])];
    let materials = [SurfaceMaterial {
        diffuse: [f32::NAN, -1.0, 1e30],
        opacity: f32::NAN,
        diffuse_map: Some(0),
        opacity_map: Some(77),
        relief: None,
    }];
    let view = Camera::default().framing(&UNIT, size(8, 8)).expect("valid");
    let values = [0.0, 1.0, -1e-30, 1e30, f32::NAN, f32::NEG_INFINITY];
    let mut random = Random(1);
    let mut pick = || values[(random.next() * 6.0) as usize];
    for i in 0..4000 {
        let mut three = || [pick(), pick(), pick()];
        let p = SurfacePoint {
            position: if i % 5 == 0 { view.eye } else { three() },
            normal: three(),
            geometric: three(),
            color: three(),
            uv: (i % 2 == 0).then(|| [pick(), pick()]),
            tangents: None,
            uv_footprint: pick(),
            depth01: pick(),
            face: i,
            level: u32::MAX - i,
            material: i % 3,
        };
        for mode in [
            ShadeMode::Lit,
            ShadeMode::Flat,
            ShadeMode::Normals,
            ShadeMode::Uv,
            ShadeMode::Depth,
            ShadeMode::Level,
        ] {
            let shader = Shader::new(mode, &view, &materials, &textures);
            for c in shader.shade(&p) {
                assert!((0.0..=1.0).contains(&c), "{mode:?} {p:?}");
            }
        }
    }
    // Without any direction the surface is shaded as if it faced the eye.
    let p = SurfacePoint::default();
    let shader = Shader::new(ShadeMode::Lit, &view, &[], &[]);
    assert!(shader.shade(&p)[1] > 0.2);
}

#[test]
fn opacity_premultiplies_and_kd_is_srgb() {
    let view = Camera::default().framing(&UNIT, size(8, 8)).expect("valid");
    let solid = SurfaceMaterial::from_mtl([0.5; 3], 1.0, None, None);
    assert!(close(solid.diffuse[0], to_linear(0.5) as f32, 1e-6));
    let glass = SurfaceMaterial {
        opacity: 0.25,
        ..solid
    };
    let materials = [solid, glass];
    let shader = Shader::new(ShadeMode::Lit, &view, &materials, &[]);
    let p = SurfacePoint {
        normal: view.forward.map(|c| -c),
        material: 0,
        ..SurfacePoint::default()
    };
    let a = shader.shade(&p);
    let b = shader.shade(&SurfacePoint { material: 1, ..p });
    assert_eq!((a[3], b[3]), (1.0, 0.25));
    assert!((0..3).all(|k| close(b[k], a[k] * 0.25, 1e-6)));
    assert_eq!(
        SurfaceMaterial::from_mtl([0.0; 3], 1.0, Some(0), None).diffuse,
        [1.0; 3]
    );
    assert_eq!(
        SurfaceMaterial::from_mtl([0.0; 3], 1.0, None, None).diffuse,
        [0.0; 3]
    );
}

#[test]
fn a_picture_survives_its_file() {
    let view = Camera::default()
        .framing(&UNIT, size(40, 30))
        .expect("valid");
    let shader = Shader::new(ShadeMode::Normals, &view, &[], &[]);
    let film = Film::new(Encoding::Raw, [10, 20, 30, 255]);
    let mut image = Image::new(40, 30);
    for (p, o) in cast(&view).iter().zip(image.data.chunks_exact_mut(4)) {
        o.copy_from_slice(&film.pixel(p.as_ref().map_or([0.0; 4], |p| shader.shade(p))));
    }
    assert!(image.is_opaque());
    let back = png::decode(&png::encode(&image).expect("encodes")).expect("decodes");
    let same = earmark::compare::compare(&(&image).into(), &back.into()).expect("same size");
    assert_eq!(same.differing(), 0);
    assert_eq!(image.pixel(0, 0), [10, 20, 30, 255]);
    assert_ne!(image.pixel(20, 15), [10, 20, 30, 255]);
}
