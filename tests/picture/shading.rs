//! Shading and film.

use super::{Random, UNIT, close, size, texture};
use earmark::camera::{Camera, View};
use earmark::film::srgb::to_linear;
use earmark::film::{Encoding, Film, Image, png};
use earmark::shade::{NO_MATERIAL, ShadeMode, Shader, SurfaceMaterial, SurfacePoint};

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
