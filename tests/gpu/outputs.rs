//! Outputs beside the picture against the processor's, pixel by pixel, in the codes of their files.

use crate::pictures::draw;
use crate::{asset, colored, displaced, gpu, gpu_with, plain, uniform};
use earmark::film::Image;
use earmark::frame::{Aov, Drawing, Plane, Refinement};
use earmark::gpu::{DeviceOptions, Gpu, GpuError, GpuFrame, GpuScene};
use earmark::scheme::Scheme;
use earmark::shade::Relief;
use earmark::texture::{Meaning, Texture};
use earmark::{Camera, Renderer, Scene, SurfaceOptions};

/// Words of a pixel of all outputs.
const ALL_WORDS: u64 = 10;

/// All outputs, in another order than they are numbered in.
fn all() -> Vec<Aov> {
    Aov::ALL.into_iter().rev().collect()
}

/// Of the processor's blocks, so that there is something to compare with.
fn outputs(gpu: &Gpu, renderer: &Renderer, scene: &Scene, camera: &Camera) -> GpuFrame {
    let view = renderer.view(scene, camera).unwrap();
    let mut ready = GpuScene::decided_by_processor(gpu, renderer, scene, view).unwrap();
    ready.draw().unwrap()
}

/// How far codes of two planes are apart.
#[derive(Default)]
struct Found {
    /// Pixels that show anything in either.
    pixels: usize,
    /// Of these, where codes are not the same.
    differ: usize,
    /// Of these, where some code differs by more than rounding explains.
    off: usize,
    /// Sum of the largest differences of pixels that are not off.
    sum: f64,
}

impl Found {
    fn mean(&self) -> f64 {
        self.sum / (self.pixels.max(1) as f64)
    }
}

fn compare(got: &Plane, want: &Plane) -> Found {
    assert_eq!(
        (got.aov, got.width, got.height, got.low, got.high),
        (want.aov, want.width, want.height, want.low, want.high)
    );
    let size = got.aov.pixel_bytes();
    let nothing = got.aov == Aov::Depth;
    let is_nothing = |p: &[u8]| p.iter().all(|&b| b == if nothing { 255 } else { 0 });
    let codes = |p: &[u8]| -> Vec<i32> {
        match got.aov.bits() {
            16 => p
                .chunks_exact(2)
                .map(|b| i32::from(u16::from_be_bytes([b[0], b[1]])))
                .collect(),
            _ => p.iter().map(|&b| b.into()).collect(),
        }
    };
    // Corners that rounding snaps elsewhere move a sample by 1/256 pixel along the surface.
    let explained = match got.aov {
        Aov::Position | Aov::Uv => 8,
        _ => 1,
    };
    let mut found = Found::default();
    let pixels = got
        .data
        .chunks_exact(size)
        .zip(want.data.chunks_exact(size));
    for (a, b) in pixels.filter(|(a, b)| !is_nothing(a) || !is_nothing(b)) {
        found.pixels += 1;
        // A normal's component of nothing lies between two codes, and rounding decides.
        let between = |a: i32, b: i32| got.aov == Aov::Normal && a.min(b) == 127 && a.max(b) == 128;
        let codes = codes(a).into_iter().zip(codes(b));
        let apart = codes.map(|(a, b)| if between(a, b) { 0 } else { (a - b).abs() });
        let most = apart.max().unwrap_or(0);
        found.differ += usize::from(most > 0);
        match most <= explained {
            true => found.sum += f64::from(most),
            false => found.off += 1,
        }
    }
    found
}

/// Holds all planes against the processor's. Ids are equal but for samples at edges; so are all numbers within a code or a few, and on
/// average within what rounding of the numbers themselves explains.
fn check(what: &str, got: &GpuFrame, want: &[Plane]) {
    assert_eq!(got.planes.len(), want.len(), "{what}");
    for (got, want) in got.planes.iter().zip(want) {
        let found = compare(got, want);
        let name = got.aov.name();
        println!(
            "gpu output {what} {name}: {} of {} pixels differ, {} by more than rounding, {:.4} codes in the mean",
            found.differ,
            found.pixels,
            found.off,
            found.mean()
        );
        let is_id = matches!(got.aov, Aov::Face | Aov::Level | Aov::Coverage);
        let odd = if is_id { found.differ } else { found.off };
        assert!(
            odd * 1000 <= found.pixels,
            "{what}, {name}: {odd} of {} pixels",
            found.pixels
        );
        let most = match got.aov {
            // 0.05 degrees are 0.11 of a code.
            Aov::Normal => 0.11,
            // A code is at most 1.6e-5 of the distance.
            Aov::Depth => 0.5,
            _ => 1.0,
        };
        assert!(found.mean() <= most, "{what}, {name}: {}", found.mean());
    }
}

/// A picture of all colours and slopes.
fn texture(side: u32) -> Texture {
    let texel = |i: u32| [(i * 3 % 256) as u8, (i / side * 5 % 256) as u8, 200, 255];
    let all = (0..side * side).map(texel).collect();
    Texture::from_rgba8(side, side, all, Meaning::Color).unwrap()
}

#[test]
fn outputs_are_the_processors() {
    let Some(gpu) = gpu("outputs") else { return };
    let limit = SurfaceOptions::default();
    let mut textured = asset("creature", limit);
    textured.textures.push(texture(64));
    let map = Some(textured.textures.len() as u32 - 1);
    for m in &mut textured.materials {
        m.diffuse_map = map;
    }
    let mut bumpy = textured.clone();
    for m in &mut bumpy.materials {
        m.relief = map.map(|map| Relief::Heights {
            map,
            strength: 0.02,
        });
    }
    let mut by_pixels = asset("creature", limit);
    let surface = &mut by_pixels.objects[0].surface;
    surface.set_displacement(Some(displaced::by("pixels")));
    let mut two = asset("cube", limit);
    two.objects.extend(asset("torus", limit).objects);
    let bilinear = SurfaceOptions {
        scheme: Some(Scheme::Bilinear),
        ..limit
    };
    let near = Camera::default().with_zoom(5.0);
    let ortho = Camera::default().with_ortho();
    let adaptive = Refinement::Default { max_level: 6 };
    let level = Refinement::Uniform;
    let mut run = 0;
    for (what, scene, refinement, drawing, camera) in [
        (
            "textured",
            &textured,
            level(3),
            Drawing::Limit,
            Camera::default(),
        ),
        ("bumpy", &bumpy, level(3), Drawing::Limit, ortho),
        (
            "by_pixels",
            &by_pixels,
            level(3),
            Drawing::Limit,
            Camera::default(),
        ),
        (
            "coordinates",
            &plain(asset("creature", limit)),
            adaptive,
            Drawing::Limit,
            near,
        ),
        (
            "creased",
            &asset("part_creased", limit),
            adaptive,
            Drawing::Limit,
            Camera::default(),
        ),
        ("two", &two, level(4), Drawing::Limit, Camera::default()),
        (
            "colours",
            &colored(limit, "f 4 3 2 1"),
            level(2),
            Drawing::Refined,
            Camera::default(),
        ),
        (
            "cage",
            &asset("part", limit),
            level(0),
            Drawing::Cage,
            Camera::default(),
        ),
        (
            "bilinear",
            &asset("cube", bilinear),
            level(2),
            Drawing::Limit,
            Camera::default(),
        ),
    ] {
        for samples in [1, 8] {
            let mut renderer = Renderer::new(200, 150);
            (renderer.refinement, renderer.drawing) = (refinement, drawing);
            renderer.size.samples = samples;
            let alone = outputs(&gpu, &renderer, scene, &camera);
            renderer.aovs = all();
            let want = renderer.render(scene, &camera).unwrap();
            let got = outputs(&gpu, &renderer, scene, &camera);
            check(&format!("{what}_{samples}"), &got, &want.planes);
            assert_eq!(got.image.data, alone.image.data, "{what}: another picture");
            let pixels = 200 * 150;
            assert_eq!(got.stats.bytes_down, 4 * (1 + ALL_WORDS) * pixels);
            assert_eq!(got.stats.read_backs, 1);
            run += 1;
        }
    }
    println!("gpu outputs: {run} cases");
}

#[test]
fn outputs_beside_blocks_of_the_device_change_no_pixel() {
    let Some(gpu) = gpu("outputs of blocks of the device") else {
        return;
    };
    let scene = plain(asset("torus", SurfaceOptions::default()));
    let camera = Camera::default();
    let mut renderer = Renderer::new(200, 150);
    let mut alone = GpuScene::new(&gpu, &renderer, &scene, &camera).unwrap();
    assert!(alone.decides());
    let alone = alone.draw().unwrap();
    renderer.aovs = all();
    let mut both = GpuScene::new(&gpu, &renderer, &scene, &camera).unwrap();
    let got = both.draw().unwrap();
    assert_eq!(got.image.data, alone.image.data);
    let beside = 4 * ALL_WORDS * 200 * 150;
    assert_eq!(got.stats.bytes_down, alone.stats.bytes_down + beside);
    // The range of positions is that of the points before.
    let points: Vec<[f32; 3]> = scene.objects[0].surface.control_base().to_vec();
    let moved = both.move_points(&points);
    assert!(matches!(moved, Err(GpuError::Unsupported { .. })));
}

#[test]
fn one_output_is_that_of_all() {
    let Some(whole) = gpu("one output") else {
        return;
    };
    let small = DeviceOptions {
        max_binding: 1_000_000,
        ..DeviceOptions::default()
    };
    let Some(small) = gpu_with("one output", &small) else {
        return;
    };
    let scene = plain(asset("creature", SurfaceOptions::default()));
    let camera = Camera::default();
    let mut renderer = uniform(200, 150, 4);
    renderer.aovs = all();
    let want = outputs(&whole, &renderer, &scene, &camera);
    // In many chunks and bands they are the same.
    let parts = outputs(&small, &renderer, &scene, &camera);
    assert!(parts.stats.chunks > 1 && parts.stats.bands > 1);
    assert!(parts.planes == want.planes);
    for (k, aov) in all().into_iter().enumerate() {
        renderer.aovs = vec![aov];
        let got = outputs(&whole, &renderer, &scene, &camera);
        assert!(got.planes == want.planes[k..=k], "{}", aov.name());
        let words = aov.pixel_bytes().div_ceil(4) as u64;
        assert_eq!(got.stats.bytes_down, 4 * (1 + words) * 200 * 150);
    }
    // Another view has ranges of its own; what shows nothing has none.
    renderer.aovs = all();
    let mut ready = GpuScene::new(&whole, &renderer, &scene, &camera).unwrap();
    let view = renderer.view(&scene, &Camera::default().with_zoom(2.0));
    let view = view.unwrap();
    let moved = ready.draw_view(&view).unwrap();
    let want = renderer.render_view(&scene, &view).unwrap();
    check("moved", &moved, &want.planes);
    let mut hidden = scene;
    for m in &mut hidden.materials {
        m.opacity = 0.0;
    }
    let empty: Image = draw(&whole, &renderer, &hidden, &camera);
    let got = outputs(&whole, &renderer, &hidden, &camera);
    let want = renderer.render(&hidden, &camera).unwrap();
    assert_eq!(got.image.data, empty.data);
    assert!(got.planes == want.planes);
    println!("gpu one output: 11 cases");
}
