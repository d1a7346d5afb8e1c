//! Patches and interpolating surfaces that are displaced or have relief, against the processor.

use crate::pictures::{check, draw};
use crate::points::{ANGLE, DISTANCE, assert_shared, blocks, compare, straight_corners};
use crate::{asset, displaced, gpu, gpu_with, plain};
use earmark::frame::Refinement;
use earmark::gpu::DeviceOptions;
use earmark::patch::PatchKind;
use earmark::scheme::Scheme;
use earmark::shade::{Relief, ShadeMode, SurfaceMaterial};
use earmark::tessellate::DepthTags;
use earmark::{Camera, Renderer, Scene, SurfaceOptions};

fn options(scheme: Scheme, patches: PatchKind) -> SurfaceOptions {
    SurfaceOptions {
        scheme: Some(scheme),
        patches,
        ..SurfaceOptions::default()
    }
}

use PatchKind::{None as Limit, Pn, Qas};
use Scheme::{Bilinear, Butterfly, CatmullClark, Kobbelt, Loop};

/// Asset, scheme, patches and displacement.
const DISPLACED: [(&str, Scheme, PatchKind, &str); 16] = [
    ("creature", CatmullClark, Qas, "map"),
    ("creature", CatmullClark, Qas, "noise"),
    ("part_creased", CatmullClark, Qas, "noise"),
    ("cube", Bilinear, Qas, "ripples"),
    ("part_creased", Bilinear, Qas, "noise"),
    ("part_creased", Bilinear, Pn, "noise"),
    ("octahedron", Loop, Qas, "noise"),
    ("creature", CatmullClark, Pn, "map"),
    ("part", CatmullClark, Pn, "moving"),
    ("part_creased", CatmullClark, Pn, "noise"),
    ("octahedron", Loop, Pn, "ridges"),
    ("torus", Kobbelt, Limit, "map"),
    ("torus", Kobbelt, Limit, "noise"),
    ("octahedron", Butterfly, Limit, "noise"),
    ("torus", Kobbelt, Qas, "noise"),
    ("octahedron", Butterfly, Pn, "noise"),
];

fn lifted(name: &str, options: SurfaceOptions, by: &str) -> Scene {
    let mut scene = plain(asset(name, options));
    let surface = &mut scene.objects[0].surface;
    surface.set_displacement(Some(displaced::by(by)));
    scene
}

/// The deepest level of a test: weights of texture coordinates of interpolating surfaces take long to make.
fn deepest(scene: &Scene, level: u32) -> u32 {
    let surface = &scene.objects[0].surface;
    let slow = surface.scheme().is_interpolating() && surface.has_uvs();
    if slow { 2 } else { level }
}

#[test]
fn displaced_points_of_patches_are_the_processors() {
    let Some(gpu) = gpu("displaced patches") else {
        return;
    };
    // Small chunks: sides between chunks are evaluated in both.
    let small = DeviceOptions {
        max_binding: 4_000_000,
        ..DeviceOptions::default()
    };
    let Some(chunked) = gpu_with("displaced patches", &small) else {
        return;
    };
    let (mut far, mut run) = (0.0_f64, 0);
    for (name, scheme, patches, by) in DISPLACED {
        let scene = lifted(name, options(scheme, patches), by);
        let surface = &scene.objects[0].surface;
        let deep = deepest(&scene, 4);
        for (gpu, level) in [(&gpu, deep - 1), (&chunked, deep)] {
            let found = blocks(gpu, &scene, level);
            let got = compare(surface, &found, level);
            let turned = got.angles.iter().filter(|&&a| a > ANGLE).count();
            println!(
                "gpu displaced {name} {scheme:?} {patches:?} {by} {level}: {:.1e} of the model, {:.4} degrees, {turned} beyond, {} points, {} without a normal",
                got.distance,
                got.angle(),
                got.points,
                got.bare
            );
            let what = format!("{name} {scheme:?} {patches:?} {by} {level}");
            let few = got.points / 1000 + straight_corners(surface);
            assert!(got.distance <= DISTANCE, "{what}: {}", got.distance);
            assert!(turned <= few, "{what}: {turned} normals of {}", got.points);
            assert!(got.bare <= few, "{what}: {} have none", got.bare);
            if !surface.is_triangular() {
                assert_shared(surface, &found, &what);
            }
            far = far.max(got.distance);
            run += 1;
        }
    }
    println!("gpu displaced patches: {run} cases, off by at most {far:.1e} of the model");
}

#[test]
fn displaced_pictures_of_patches_are_the_processors() {
    let Some(gpu) = gpu("pictures of displaced patches") else {
        return;
    };
    let mut run = 0;
    for (name, scheme, patches, by) in DISPLACED {
        let scene = lifted(name, options(scheme, patches), by);
        for (what, refinement) in [
            ("uniform", Refinement::Uniform(deepest(&scene, 3))),
            (
                "adaptive",
                Refinement::Default {
                    max_level: deepest(&scene, 4),
                },
            ),
        ] {
            let mut renderer = Renderer::new(200, 150);
            renderer.refinement = refinement;
            let camera = Camera::default();
            let want = renderer.render(&scene, &camera).unwrap().image;
            let got = draw(&gpu, &renderer, &scene, &camera);
            let what = format!("displaced_{name}_{scheme:?}_{patches:?}_{by}_{what}");
            check(&what, &got, &want);
            run += 1;
        }
    }
    println!("gpu pictures of displaced patches: {run} cases");
}

#[test]
fn relief_of_patches_is_the_processors() {
    let Some(gpu) = gpu("relief of patches") else {
        return;
    };
    let mut run = 0;
    let relief = |map: u32, normals: bool| match normals {
        true => Relief::Normals(map),
        false => Relief::Heights {
            map,
            strength: 0.02,
        },
    };
    for (name, scheme, patches) in [
        ("creature", CatmullClark, Qas),
        ("creature", CatmullClark, Pn),
        ("torus", Kobbelt, Limit),
        ("torus", Kobbelt, Pn),
    ] {
        for (normals, by_pixel, refinement, mode) in [
            (false, false, Refinement::Uniform(3), ShadeMode::Lit),
            (true, false, Refinement::Uniform(2), ShadeMode::Normals),
            (
                true,
                false,
                Refinement::DepthTags(DepthTags::by_distance()),
                ShadeMode::Lit,
            ),
            (false, true, Refinement::Uniform(3), ShadeMode::Lit),
        ] {
            let mut scene = asset(name, options(scheme, patches));
            let deepest = deepest(&scene, 3);
            let refinement = match refinement {
                Refinement::Uniform(level) => Refinement::Uniform(level.min(deepest)),
                // As above.
                _ if deepest < 3 => continue,
                other => other,
            };
            if by_pixel {
                let surface = &mut scene.objects[0].surface;
                surface.set_displacement(Some(displaced::by("pixels")));
            } else {
                scene.textures.push(crate::pictures::stripes(64));
                let map = scene.textures.len() as u32 - 1;
                let relief = Some(relief(map, normals));
                let default = SurfaceMaterial::CLAY;
                scene.default_material = Some(SurfaceMaterial { relief, ..default });
                for m in &mut scene.materials {
                    m.relief = relief;
                }
            }
            let mut renderer = Renderer::new(200, 150);
            (renderer.refinement, renderer.mode) = (refinement, mode);
            let camera = Camera::default();
            let want = renderer.render(&scene, &camera).unwrap().image;
            let got = draw(&gpu, &renderer, &scene, &camera);
            let what = format!("relief_{name}_{scheme:?}_{patches:?}_{run}");
            check(&what, &got, &want);
            // There is relief to be seen.
            let bare = plain(asset(name, options(scheme, patches)));
            let smooth = renderer.render(&bare, &camera).unwrap().image;
            assert_ne!(smooth.data, want.data, "{what}");
            run += 1;
        }
    }
    println!("gpu relief of patches: {run} cases");
}
