//! Refinement patterns against the processor: blocks that are lists of triangles.

use crate::pictures::{check, draw, stripes};
use crate::{asset, displaced, gpu, gpu_with};
use earmark::frame::{Aov, Refinement};
use earmark::gpu::{DeviceOptions, GpuScene};
use earmark::scheme::Scheme;
use earmark::shade::ShadeMode;
use earmark::tessellate::{DepthTags, Pattern};
use earmark::{Camera, Renderer, Scene, SurfaceOptions};

pub(crate) fn patterned(pattern: Pattern) -> Refinement {
    Refinement::DepthTags(DepthTags {
        pattern: Some(pattern),
        ..DepthTags::by_distance()
    })
}

/// A textured model that is cut out, as opacity and colours ask for the size of pixels.
pub(crate) fn cut() -> Scene {
    let mut scene = asset("creature", SurfaceOptions::default());
    scene.textures.push(stripes(64));
    let map = Some(scene.textures.len() as u32 - 1);
    for m in &mut scene.materials {
        (m.diffuse_map, m.opacity_map) = (map, map);
    }
    scene
}

#[test]
fn patterns_are_the_processors() {
    let Some(gpu) = gpu("patterns") else { return };
    let two_pass = DeviceOptions {
        two_pass: true,
        ..DeviceOptions::default()
    };
    let Some(two_pass) = gpu_with("patterns", &two_pass) else {
        return;
    };
    let of = |name: &str, scheme: Scheme| {
        let options = SurfaceOptions {
            scheme: Some(scheme),
            ..SurfaceOptions::default()
        };
        asset(name, options)
    };
    let mut lifted = of("creature", Scheme::CatmullClark);
    let surface = &mut lifted.objects[0].surface;
    surface.set_displacement(Some(displaced::by("noise")));
    let mut rough = of("torus", Scheme::Kobbelt);
    let surface = &mut rough.objects[0].surface;
    surface.set_displacement(Some(displaced::by("noise")));
    let mut run = 0;
    for (name, scene) in [
        ("creature", of("creature", Scheme::CatmullClark)),
        ("creased", of("part_creased", Scheme::CatmullClark)),
        ("loop", of("octahedron", Scheme::Loop)),
        ("cut", cut()),
        ("displaced", lifted),
        ("interpolating", rough),
    ] {
        for (pattern, zoom, mode) in [
            (Pattern::Split, 1.0, ShadeMode::Lit),
            (Pattern::Equilateral, 8.0, ShadeMode::Flat),
        ] {
            let mut renderer = Renderer::new(240, 180);
            renderer.refinement = patterned(pattern);
            renderer.mode = mode;
            let camera = Camera::default().with_zoom(zoom);
            let want = renderer.render(&scene, &camera).unwrap();
            // Kinds of keys have nothing to do with where triangles come from.
            let both = pattern == Pattern::Split;
            for gpu in [&gpu, &two_pass].into_iter().take(1 + usize::from(both)) {
                let mut ready = GpuScene::new(gpu, &renderer, &scene, &camera).unwrap();
                let got = ready.draw().unwrap();
                assert_eq!(got.stats.microtriangles, want.stats.microtriangles);
                let what = format!("pattern_{name}_{pattern:?}_{zoom}");
                check(&what, &got.image, &want.image);
                run += 1;
            }
            // Triangles of a grid are others.
            renderer.refinement = Refinement::DepthTags(DepthTags::by_distance());
            let grids = draw(&gpu, &renderer, &scene, &camera);
            assert!(mode != ShadeMode::Flat || grids.data != want.image.data);
        }
    }
    println!("gpu patterns: {run} cases");
}

#[test]
fn patterns_in_parts_are_the_same() {
    let Some(whole) = gpu("patterns in parts") else {
        return;
    };
    let small = DeviceOptions {
        max_binding: 1_000_000,
        ..DeviceOptions::default()
    };
    let Some(small) = gpu_with("patterns in parts", &small) else {
        return;
    };
    let scene = crate::plain(asset("creature", SurfaceOptions::default()));
    let camera = Camera::default().with_zoom(3.0);
    for pattern in [Pattern::Split, Pattern::Equilateral] {
        let mut renderer = Renderer::new(240, 180);
        renderer.refinement = patterned(pattern);
        renderer.aovs = vec![Aov::Face, Aov::Level];
        let draw = |gpu| {
            let mut ready = GpuScene::new(gpu, &renderer, &scene, &camera).unwrap();
            ready.draw().unwrap()
        };
        let (got, want) = (draw(&small), draw(&whole));
        assert!(got.stats.chunks > 1, "{}", got.stats.chunks);
        assert_eq!(got.image.data, want.image.data);
        assert!(got.planes == want.planes);
        let own = renderer.render(&scene, &camera).unwrap();
        for (got, want) in want.planes.iter().zip(&own.planes) {
            let size = got.aov.pixel_bytes();
            let pixels = got.data.chunks(size).zip(want.data.chunks(size));
            let differ = pixels.filter(|(a, b)| a != b).count();
            assert!(differ * 1000 <= 240 * 180, "{differ}");
        }
    }
    println!("gpu patterns in parts: 2 cases");
}
