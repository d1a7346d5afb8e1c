//! Figures of adaptive tessellation: distances and triangles against uniform levels, pictures against deep ones, and a slow zoom. A few
//! cases on the project's own models; many, on those that EARMARK_SHARED names, if EARMARK_THOROUGH is set as well.

use super::common::{self, Random};
use super::{adaptive, open_edges};
use earmark::camera::View;
use earmark::displace::{Displacement, Function};
use earmark::film::Image;
use earmark::frame::Refinement;
use earmark::frame::coverage::CoverageFault;
use earmark::frame::deviation::DrawnBlock;
use earmark::shade::ShadeMode;
use earmark::{Cage, Camera, Renderer, Scene, Surface, SurfaceOptions};
use std::collections::HashMap;
use std::time::Instant;

/// Whether there is time for many cases.
fn is_thorough() -> bool {
    std::env::var_os("EARMARK_THOROUGH").is_some()
}

/// The creature, and all models of the shared folder when there is time.
fn models() -> Vec<(String, Scene)> {
    let mut paths = vec![common::assets().join("creature.obj")];
    if let Some(shared) = common::shared() {
        // The teapot has what the creature lacks: borders, poles, and patches that only touch.
        let all = common::models(&shared.join("models"));
        let one = |p: &std::path::PathBuf| is_thorough() || common::name(p) == "teapot";
        paths.extend(all.into_iter().filter(one));
    }
    let load = |p: &std::path::PathBuf| (common::name(p), common::load(p));
    paths.iter().map(load).collect()
}

/// Views that hold the whole model, from all sides, near and far.
fn views(scene: &Scene, renderer: &Renderer, count: u32) -> Vec<View> {
    let mut random = Random(5);
    let sphere = scene.bounding_sphere();
    let camera = |_| {
        Camera::default()
            .with_orbit(random.range(0.0, 360.0), random.range(-60.0, 80.0))
            .with_zoom(random.range(0.2, 1.0))
            .with_fov(random.range(10.0, 70.0))
            .framing(&sphere, renderer.size)
            .unwrap()
    };
    (0..count).map(camera).collect()
}

fn count(blocks: &[DrawnBlock]) -> usize {
    blocks.iter().map(|b| b.triangles().count()).sum()
}

/// How far triangles of a uniform level are from the points that the next one adds, in pixels, within the picture.
fn uniform_error(scene: &Scene, view: &View, level: u32) -> f32 {
    let mut renderer = Renderer::new(view.size.width, view.size.height);
    renderer.refinement = Refinement::Uniform(level + 1);
    let size = [view.size.width, view.size.height];
    let is_seen = |p: [f32; 3]| (0..2).all(|k| p[k] >= 0.0 && p[k] <= size[k] as f32);
    let mut most = 0.0_f32;
    for block in renderer.drawn_blocks(scene, view).unwrap() {
        let n = block.columns;
        let at = |i: usize, j: usize| block.points[j * n + i];
        let half = block.columns > 1 && block.places[n] == block.places[n + 1];
        let places = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
        for (i, j) in places.filter(|&(i, j)| (i | j) & 1 == 1 && !(half && j > i)) {
            let (p, q) = (at(i & !1, j & !1), at((i + 1) & !1, (j + 1) & !1));
            let middle = [0, 1, 2].map(|k| 0.5 * (p[k] + q[k]));
            if let (Some(x), Some(y)) = (view.project(at(i, j)), view.project(middle)) {
                let far = ((x[0] - y[0]).powi(2) + (x[1] - y[1]).powi(2)).sqrt();
                most = if is_seen(y) { most.max(far) } else { most };
            }
        }
    }
    most
}

/// What uniform levels come to in one view, found once for each that is asked for.
struct Uniform<'a> {
    scene: &'a Scene,
    view: &'a View,
    /// Largest distance in pixels, and angle in degrees, by level above that of the quads.
    pixels: [Option<f32>; 9],
    degrees: [Option<f32>; 9],
}

impl<'a> Uniform<'a> {
    fn new(scene: &'a Scene, view: &'a View) -> Self {
        Self {
            scene,
            view,
            pixels: [None; 9],
            degrees: [None; 9],
        }
    }

    /// Micro-triangles of the first level that comes as close as `pixels`, and has normals as near as `degrees`.
    fn triangles(&mut self, pixels: f32, degrees: f32) -> usize {
        let surface = &self.scene.objects[0].surface;
        let faces = surface.quads().face_count();
        let each = if surface.is_triangular() { 1 } else { 2 };
        let split = u32::from(surface.is_split());
        let mut depth = 0;
        while (faces << (2 * (depth + 1))) < 3 << 20 && self.pixels(depth, split) > pixels {
            depth += 1;
        }
        while depth + split < 8 && degrees < 180.0 && self.degrees(depth, split) > degrees {
            depth += 1;
        }
        (each * faces) << (2 * depth)
    }

    fn pixels(&mut self, depth: u32, split: u32) -> f32 {
        let find = || uniform_error(self.scene, self.view, depth + split);
        *self.pixels[depth as usize].get_or_insert_with(find)
    }

    fn degrees(&mut self, depth: u32, split: u32) -> f32 {
        *self.degrees[depth as usize].get_or_insert_with(|| {
            let size = self.view.size;
            let mut renderer = Renderer::new(size.width, size.height);
            renderer.refinement = Refinement::Uniform(depth + split);
            // Of many, a part: what is not seen there asks for no deeper level.
            let faces = self.scene.objects[0].surface.quads().face_count();
            let every = ((faces as u32) << (2 * depth + 4)) / 100_000;
            let d = renderer.deviation_of(self.scene, self.view, 2, every.max(1));
            d.unwrap().degrees
        })
    }
}

#[test]
fn few_triangles_come_as_close_as_many() {
    let (cameras, compared) = if is_thorough() { (20, 5) } else { (2, 1) };
    let (mut ratios, mut worst, mut capped, mut cases) = ([vec![], vec![]], 0.0_f32, 0, 0);
    let mut bytes = [0_u64; 2];
    for (name, scene) in models() {
        let (mut of_model, mut bent) = (0.0_f32, 0.0_f32);
        let all = views(&scene, &adaptive(1024, 1.0, 3.0), cameras);
        for (k, view) in all.iter().enumerate() {
            let mut uniform = Uniform::new(&scene, view);
            for pixels in [0.25, 0.5, 1.0, 2.0] {
                let renderer = adaptive(1024, pixels, 3.0);
                let triangles = count(&renderer.drawn_blocks(&scene, view).unwrap());
                // Quads enough for some 100,000 samples.
                let every = (triangles as u32 * 15 / 100_000).max(1);
                let d = renderer.deviation_of(&scene, view, 4, every).unwrap();
                assert!(d.pixels <= pixels, "{name} at {pixels} pixels: {d:?}");
                let frame = renderer.render_view(&scene, view).unwrap();
                // Sixteen points per face, as patches are sent to hardware.
                let patches = scene.objects[0].surface.quads().face_count() * 16 * 12;
                bytes[0] += frame.stats.flatness_bytes;
                bytes[1] += patches as u64;
                of_model = of_model.max(d.pixels / pixels);
                bent = bent.max(d.degrees);
                capped += usize::from(d.capped > pixels);
                cases += 1;
                if k < compared {
                    let same = uniform.triangles(d.pixels.max(d.capped), d.degrees);
                    ratios[0].push(same as f64 / triangles as f64);
                    // By distances alone.
                    let loose = adaptive(1024, pixels, 180.0);
                    let triangles = count(&loose.drawn_blocks(&scene, view).unwrap());
                    let d = loose.deviation_of(&scene, view, 4, every).unwrap();
                    let same = uniform.triangles(d.pixels.max(d.capped), 180.0);
                    ratios[1].push(same as f64 / triangles as f64);
                }
            }
        }
        println!("{name}: {of_model:.2} of the tolerance at most, {bent:.1} degrees");
        worst = worst.max(of_model);
    }
    println!(
        "adaptive: {worst:.2} of the tolerance at most in {cases} cases, {capped} held back by the deepest level"
    );
    println!(
        "adaptive: {} bytes of flatness data in a frame, {} of patches",
        bytes[0] / cases as u64,
        bytes[1] / cases as u64
    );
    let [both, distance] = ratios.map(|mut r| {
        r.sort_by(f64::total_cmp);
        let more = r.iter().filter(|&&r| r < 1.0 / 1.2).count();
        println!(
            "adaptive: {more} of {} cases take more than 1.2 times as many as a uniform level",
            r.len()
        );
        [r[0], r[r.len() / 2]]
    });
    println!(
        "adaptive: triangles of uniform levels of the same distance and angle: {both:.2?} times as many, least and median; of the same \
         distance: {distance:.2?} times"
    );
    let median = distance[1];
    assert!(worst > 0.3 && median > 1.5);
}

/// Hills up to `high` over a grid of `n` by `n` quads on `[-side, side]²`.
fn terrain(n: u32, [side, high]: [f32; 2], triangles: bool) -> Scene {
    let at = |i: u32, j: u32| j * (n + 1) + i;
    let mut random = Random(3);
    let points = (0..(n + 1) * (n + 1)).map(|k| {
        let [x, z] = [k % (n + 1), k / (n + 1)].map(|c| 2.0 * c as f32 / n as f32 - 1.0);
        [x * side, high * random.unit() as f32, z * side]
    });
    let points: Vec<[f32; 3]> = points.collect();
    let mut cage = Cage::builder().points(points);
    for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let quad = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        if triangles {
            cage = cage.face([quad[0], quad[1], quad[2]]);
            cage = cage.face([quad[0], quad[2], quad[3]]);
        } else {
            cage = cage.face(quad);
        }
    }
    Scene::of(Surface::new(
        cage.build().unwrap(),
        &SurfaceOptions::default(),
    ))
}

/// One face, 2,000 by 2,000, of a valley 100 deep; the faces around it are holes.
fn valley() -> Scene {
    let points = (0..16).map(|k| {
        let [x, z] = [k % 4, k / 4].map(|c| 2000.0 * c as f32 - 3000.0);
        [x, 1e-4 * x * x + 5e-5 * z * z, z]
    });
    let mut cage = Cage::builder().points(points);
    for k in (0..9).map(|k| k / 3 * 4 + k % 3) {
        cage = cage.face([k, k + 1, k + 5, k + 4]);
    }
    for k in (0..9).filter(|&k| k != 4) {
        cage = cage.hole(k);
    }
    Scene::of(Surface::new(
        cage.build().unwrap(),
        &SurfaceOptions::default(),
    ))
}

/// From a height above the ground near its border, towards the horizon.
fn standing(scene: &Scene, renderer: &Renderer, height: f64) -> View {
    const PLACE: f32 = 900.0;
    let above = Camera::default()
        .with_eye_target([0.0, 5000.0, 0.0], [0.0; 3])
        .with_fov(50.0)
        .framing(&scene.bounding_sphere(), renderer.size);
    let mut fine = Renderer::new(renderer.size.width, renderer.size.height);
    fine.refinement = Refinement::Uniform(7);
    let blocks = fine.drawn_blocks(scene, &above.unwrap()).unwrap();
    let points = blocks.iter().flat_map(|b| &b.points);
    let far = |p: &[f32; 3]| p[0].powi(2) + (p[2] - PLACE).powi(2);
    let ground = points.min_by(|a, b| far(a).total_cmp(&far(b))).unwrap()[1];
    let eye = f64::from(ground) + height;
    let camera = Camera::default()
        .with_eye_target([0.0, eye, f64::from(PLACE)], [0.0, eye, -2000.0])
        .with_fov(50.0)
        .with_near_far(0.1, 5000.0);
    camera
        .framing(&scene.bounding_sphere(), renderer.size)
        .unwrap()
}

#[test]
fn grazing_ground_needs_few_triangles() {
    let hills = |n: u32, triangles: bool| terrain(n, [1000.0, 60.0], triangles);
    for (name, scene, height, times) in [
        ("98 triangles", hills(7, true), 1.7, 4),
        ("98 triangles", hills(7, true), 0.4, 4),
        ("9 quads", hills(3, false), 0.4, 0),
        ("one quad", valley(), 1.7, 10),
    ] {
        let renderer = adaptive(512, 0.5, 180.0);
        let view = standing(&scene, &renderer, height);
        let drawn = renderer.drawn_blocks(&scene, &view).unwrap();
        let d = renderer.deviation(&scene, &view, 4).unwrap();
        let wanted = d.pixels.max(d.capped);
        // The level that each face would need as a whole, for what is drawn of the cage.
        let mut missing: Vec<u32> = drawn.iter().map(|b| b.quad.1).collect();
        missing.sort_unstable();
        missing.dedup();
        let (faces, mut whole, mut capped) = (missing.len(), 0, 0);
        let mut uniform = Renderer::new(512, 512);
        for level in 0..9 {
            uniform.refinement = Refinement::Uniform(level);
            let all = uniform.deviations(&scene, &view, 4, 1).unwrap();
            let mut by_face: HashMap<u32, (f32, u64)> = HashMap::new();
            for block in all {
                let face = by_face.entry(block.quad.1).or_default();
                let d = block.deviation;
                *face = (face.0.max(d.pixels), face.1 + d.triangles);
            }
            missing.retain(|q| {
                let Some(&(far, triangles)) = by_face.get(q) else {
                    return true;
                };
                let enough = far <= wanted || level == 8;
                whole += if enough { triangles } else { 0 };
                capped += usize::from(far > wanted && level == 8);
                !enough
            });
            if missing.is_empty() {
                break;
            }
        }
        let own = count(&drawn);
        println!(
            "adaptive: {name}, {faces} drawn, from {height} above 2,000: {own} micro-triangles within {:.2} pixels ({:.2} at the deepest level); \
             one level per face as close: {whole} ({capped} faces at level 8 are not), {:.1} times as many",
            d.pixels,
            d.capped,
            whole as f64 / own as f64
        );
        assert!(d.pixels <= 0.5 && whole > times * own as u64);
    }
}

/// Largest difference of a channel in each pixel, as pictures are shown: colours by as much as they cover.
fn differences(a: &Image, b: &Image) -> Vec<u8> {
    let pairs = a.data.chunks_exact(4).zip(b.data.chunks_exact(4));
    let shown = |p: &[u8], k: usize| match k {
        3 => p[3],
        _ => ((u32::from(p[k]) * u32::from(p[3]) + 127) / 255) as u8,
    };
    let channel = |(p, q): (&[u8], &[u8]), k: usize| shown(p, k).abs_diff(shown(q, k));
    let largest = |pair| (0..4).map(|k| channel(pair, k)).max().unwrap_or(0);
    pairs.map(largest).collect()
}

/// Pixels of the 5 by 5 around one.
fn around(image: &Image, k: usize) -> impl Iterator<Item = usize> {
    let (w, h) = (image.width as i64, image.height as i64);
    let (x, y) = (k as i64 % w, k as i64 / w);
    let rows = (y - 2).max(0)..=(y + 2).min(h - 1);
    rows.flat_map(move |j| ((x - 2).max(0)..=(x + 2).min(w - 1)).map(move |i| (j * w + i) as usize))
}

/// Pixels within two of which the picture changes by more than `much`.
fn changes(image: &Image, k: usize, much: u8) -> bool {
    let (mut low, mut high) = ([255_u8; 4], [0_u8; 4]);
    for at in around(image, k) {
        for c in 0..4 {
            low[c] = low[c].min(image.data[4 * at + c]);
            high[c] = high[c].max(image.data[4 * at + c]);
        }
    }
    (0..4).any(|c| high[c] - low[c] > much)
}

/// Pixels within two of which the picture changes by more than a little: silhouettes against the ground, and edges of textures.
fn is_near_edge(image: &Image, k: usize) -> bool {
    changes(image, k, 40)
}

/// Pixels at which the surface turns away from the eye: silhouettes in front of other parts of the model too, which a picture under light
/// need not show. `normals` is a picture of them.
fn silhouettes(normals: &Image, view: &View) -> Vec<bool> {
    let (w, h) = (normals.width as usize, normals.height as usize);
    let turned = |k: usize| {
        let p = &normals.data[4 * k..4 * k + 4];
        if p[3] < 255 {
            return true;
        }
        let (x, y) = ((k % w) as f32 + 0.5, (k / w) as f32 + 0.5);
        let (x, y) = (
            (x - w as f32 / 2.0) / view.scale,
            (h as f32 / 2.0 - y) / view.scale,
        );
        let ray = [0, 1, 2].map(|c| view.forward[c] + x * view.right[c] + y * view.up[c]);
        let n = [0, 1, 2].map(|c| f32::from(p[c]) / 127.5 - 1.0);
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        dot(n, ray) > -0.35 * dot(ray, ray).sqrt()
    };
    let all: Vec<bool> = (0..w * h).map(turned).collect();
    (0..w * h)
        .map(|k| around(normals, k).any(|at| all[at]))
        .collect()
}

#[test]
fn default_pictures_are_those_of_deep_levels() {
    let (cameras, side) = if is_thorough() { (5, 512) } else { (1, 256) };
    let (mut worst, mut inside, mut times) = (0.0_f64, 0_u8, [0.0; 2]);
    for (name, scene) in models() {
        let mut renderer = Renderer::new(side, side);
        renderer.size.samples = 16;
        let faces = scene.objects[0].surface.quads().face_count();
        // Level 8, or what there is time for.
        let most = if is_thorough() { 1 << 30 } else { 1 << 24 };
        let level = (4..8).find(|l| faces << (2 * (l + 1)) > most).unwrap_or(8);
        for view in views(&scene, &renderer, cameras) {
            let mut draw = |refinement: Option<Refinement>, k: usize| {
                renderer.refinement = refinement.unwrap_or(Renderer::new(1, 1).refinement);
                let begin = Instant::now();
                let image = renderer.render_view(&scene, &view).unwrap().image;
                times[k] += begin.elapsed().as_secs_f64() * 1e3;
                image
            };
            let (own, deep) = (draw(None, 0), draw(Some(Refinement::Uniform(level)), 1));
            renderer.mode = ShadeMode::Normals;
            let normals = renderer.render_view(&scene, &view).unwrap().image;
            renderer.mode = ShadeMode::Lit;
            let turned = silhouettes(&normals, &view);
            // Where parts of a model cut through each other, normals jump.
            let is_edge =
                |k: usize| turned[k] || is_near_edge(&deep, k) || changes(&normals, k, 90);
            let d = differences(&own, &deep);
            let mean = d.iter().map(|&d| f64::from(d)).sum::<f64>() / d.len() as f64;
            let inner: Vec<usize> = (0..d.len()).filter(|&k| !is_edge(k)).collect();
            let far = inner.iter().filter(|&&k| d[k] > 4).count();
            let most = inner.iter().map(|&k| d[k]).max();
            println!(
                "{name} against level {level}: mean {mean:.3}, {most:?} at most in {} pixels away from edges, {far} above 4",
                inner.len()
            );
            assert!(mean <= 0.3, "{name}");
            worst = worst.max(mean);
            inside = inside.max(most.unwrap_or(0));
        }
    }
    println!(
        "adaptive: default against deep levels: mean {worst:.3} at most, {inside} away from edges, {times:.0?} ms"
    );
}

#[test]
fn a_slow_zoom_does_not_pop() {
    let scene = common::load(&common::assets().join("creature.obj"));
    let mut renderer = Renderer::new(256, 256);
    renderer.size.samples = 16;
    let sphere = scene.bounding_sphere();
    let frames = if is_thorough() { 60 } else { 12 };
    let view = |k: u32| {
        let camera = Camera::default().with_zoom(1.0 + 0.005 * f64::from(k));
        camera.framing(&sphere, renderer.size).unwrap()
    };
    let views: Vec<View> = (0..=frames).map(view).collect();
    let (mut most, mut inside, mut pixels) = (0, 0, [0_u64; 256]);
    for pair in views.windows(2) {
        renderer.decided_by = None;
        let own = renderer.render_view(&scene, &pair[0]).unwrap().image;
        renderer.decided_by = Some(pair[1]);
        let next = renderer.render_view(&scene, &pair[0]).unwrap().image;
        for (k, d) in differences(&own, &next).into_iter().enumerate() {
            most = most.max(d);
            pixels[usize::from(d)] += 1;
            if d > inside && !is_near_edge(&own, k) {
                inside = d;
            }
        }
    }
    let all: u64 = pixels.iter().sum();
    let above = |d: usize| pixels[d + 1..].iter().sum::<u64>();
    let share = (0..256).find(|&d| above(d) * 1000 <= all).unwrap_or(255);
    println!(
        "adaptive: zoom of {frames} frames: {most} at most, {inside} away from edges, 99.9 in 100 pixels within {share}; {} of {all} pixels \
         by more than one sample",
        above(16)
    );
    // A sample that changes sides at a silhouette is 16 of 255: of those few, and of few pixels more than one.
    assert!(inside <= 8 && above(16) * 100_000 <= all);
    assert!(share <= 2, "{share}");
}

#[test]
fn displaced_blocks_are_diced_about_once() {
    let mut scene = terrain(7, [1.0, 0.12], true);
    let noise: Function = "fbm:frequency=3".parse().unwrap();
    let displacement = Displacement::function(noise).scaled(0.1);
    scene.objects[0]
        .surface
        .set_displacement(Some(displacement));
    let camera = Camera::default()
        .with_eye_target([0.0, 0.45, 1.6], [0.0; 3])
        .with_fov(50.0);
    let mut renderer = Renderer::new(1024, 1024);
    for samples in [1, 4] {
        renderer.size.samples = samples;
        let stats = renderer.render(&scene, &camera).unwrap().stats;
        let distinct = stats.microtriangles as f64 / 2.0;
        println!(
            "adaptive: displaced terrain of {} micro-triangles at {samples} samples: points diced {:.2} times to be drawn and shaded, \
             {:.2} times for boxes",
            stats.microtriangles,
            stats.diced as f64 / distinct,
            stats.diced_in_setup as f64 / distinct
        );
        let all = (stats.diced + stats.diced_in_setup) as f64;
        assert!(all <= 2.5 * distinct);
    }
}

#[test]
fn shared_models_have_no_cracks() {
    if !is_thorough() {
        return;
    }
    let (mut samples, mut closed) = (0, 0);
    for (name, scene) in models() {
        if !common::is_closed(&scene.objects[0].surface) {
            continue;
        }
        for pixels in [0.25, 0.5, 1.0, 2.0] {
            let mut renderer = adaptive(1024, pixels, 3.0);
            renderer.size.samples = 4;
            for view in views(&scene, &renderer, 2) {
                let blocks = renderer.drawn_blocks(&scene, &view).unwrap();
                assert_eq!(open_edges(&blocks), 0, "{name} at {pixels} pixels");
                closed += count(&blocks);
                let c = renderer
                    .signed_coverage(&scene, &view, CoverageFault::None)
                    .unwrap();
                assert_eq!(c.unequal, 0, "{name} at {pixels} pixels");
                samples += c.samples;
            }
        }
    }
    println!("adaptive: 0 of {samples} samples unequal, {closed} triangles closed bit for bit");
}
