//! Outputs beside the picture agree with it and with each other, pixel by pixel.

use super::harness::{Folder, assert_clean, asset, code, earmark, stderr, stdout};
use earmark::frame::{Aov, Drawing, Finished, Plane, Refinement};
use earmark::load::{LoadOptions, Loader};
use earmark::mesh::resolver::NoFiles;
use earmark::shade::ShadeMode;
use earmark::{Camera, Renderer, Scene};
use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;

fn scene(assets: &[&str]) -> Scene {
    let mut loader = Loader::new(LoadOptions::default());
    for name in assets {
        loader.add_file(&asset(name)).unwrap();
    }
    loader.finish().0
}

fn scene_of(text: &str) -> Scene {
    let mut loader = Loader::new(LoadOptions::default());
    let cage = loader
        .read(text.as_bytes(), "text", &mut NoFiles)
        .unwrap()
        .cage;
    loader.add_cage(cage, "text", &mut NoFiles).unwrap();
    loader.finish().0
}

fn renderer(samples: u32, aovs: &[Aov]) -> Renderer {
    let mut renderer = Renderer::new(150, 110);
    renderer.size.samples = samples;
    renderer.aovs = aovs.to_vec();
    renderer
}

fn plane(frame: &Finished, aov: Aov) -> &Plane {
    frame.planes.iter().find(|p| p.aov == aov).unwrap()
}

fn pixels(frame: &Finished) -> impl Iterator<Item = [u32; 2]> + use<> {
    let (width, height) = (frame.image.width, frame.image.height);
    (0..height).flat_map(move |y| (0..width).map(move |x| [x, y]))
}

#[test]
fn they_never_change_the_picture() {
    // With coordinates and no texture nothing of the picture looks at them.
    let creature = fs::read_to_string(asset("creature.obj")).unwrap();
    let scenes = [
        scene(&["creature.obj"]),
        scene(&["part_creased.obj"]),
        scene(&["torus.obj", "cube.obj"]),
        scene_of(&creature),
    ];
    assert!(scenes[3].textures.is_empty() && scenes[3].objects[0].surface.has_uvs());
    for (k, scene) in scenes.iter().enumerate() {
        for (samples, mode) in [
            (1, ShadeMode::Lit),
            (4, ShadeMode::Lit),
            (8, ShadeMode::Flat),
        ] {
            let mut with = renderer(samples, &Aov::ALL);
            let mut without = renderer(samples, &[]);
            (with.mode, without.mode) = (mode, mode);
            let camera = Camera::default();
            let a = with.render(scene, &camera).unwrap();
            let b = without.render(scene, &camera).unwrap();
            assert!(a.image == b.image, "scene {k}, {samples} samples");
            assert!(b.planes.is_empty() && a.planes.len() == Aov::ALL.len());
            // In any order, alone or together, on any number of threads.
            let mut alone = renderer(samples, &[Aov::Uv]);
            alone.mode = mode;
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(3)
                .build()
                .unwrap();
            let c = pool.install(|| alone.render(scene, &camera)).unwrap();
            assert!(c.image == a.image && c.planes[0] == *plane(&a, Aov::Uv));
        }
    }
}

#[test]
fn a_pixel_has_all_of_them_or_none() {
    for (assets, samples) in [("creature.obj", 1), ("creature.obj", 4), ("mobius.obj", 16)] {
        let frame = renderer(samples, &Aov::ALL)
            .render(&scene(&[assets]), &Camera::default().with_zoom(1.4))
            .unwrap();
        let codes = |aov, [x, y]: [u32; 2]| plane(&frame, aov).codes(x, y);
        let (mut shown, mut edges) = (0, 0);
        for at in pixels(&frame) {
            let alpha = frame.image.pixel(at[0], at[1])[3];
            // The background is transparent: alpha is coverage.
            assert_eq!(codes(Aov::Coverage, at), [u16::from(alpha)]);
            let seen = alpha > 0;
            assert_eq!(codes(Aov::Depth, at) != [65535], seen);
            assert_eq!(codes(Aov::Face, at) != [0; 3], seen);
            assert_eq!(codes(Aov::Level, at) != [0], seen);
            assert_eq!(codes(Aov::Position, at) != [0; 3], seen);
            let alphas = [Aov::Normal, Aov::Albedo].map(|a| codes(a, at)[3]);
            assert_eq!(alphas, [if seen { 255 } else { 0 }; 2]);
            shown += u32::from(seen);
            edges += u32::from(seen && alpha < 255);
        }
        assert!(
            shown > 2000 && (edges > 100) == (samples > 1),
            "{shown} {edges}"
        );
    }
}

#[test]
fn of_one_sample_they_are_what_the_picture_shows() {
    let scene = scene(&["creature.obj"]);
    let camera = Camera::default();
    let frame = renderer(1, &Aov::ALL).render(&scene, &camera).unwrap();
    let shown = |mode| {
        let mut renderer = renderer(1, &[]);
        renderer.mode = mode;
        renderer.render(&scene, &camera).unwrap().image
    };
    assert_eq!(
        plane(&frame, Aov::Normal).data,
        shown(ShadeMode::Normals).data
    );
    let (depth, uv) = (shown(ShadeMode::Depth), shown(ShadeMode::Uv));
    let uv_plane = plane(&frame, Aov::Uv);
    assert_eq!((uv_plane.low, uv_plane.high), ([0.0; 3], [1.0; 3]));
    for [x, y] in pixels(&frame) {
        let codes = plane(&frame, Aov::Depth).codes(x, y);
        let [grey, .., alpha] = depth.pixel(x, y).map(f64::from);
        if alpha > 0.0 {
            let apart = 1.0 - f64::from(codes[0]) / 65535.0 - grey / 255.0;
            assert!(apart.abs() <= 0.5 / 255.0 + 2.0 / 65535.0, "{x},{y}");
            let [u, v, _] = uv_plane.value(x, y).unwrap();
            let [r, g, ..] = uv.pixel(x, y).map(|c| f64::from(c) / 255.0);
            let most = 0.5 / 255.0 + 1.0 / 65535.0;
            assert!((u - r).abs() <= most && (v - g).abs() <= most, "{x},{y}");
        }
    }
}

#[test]
fn depth_gives_back_the_position() {
    let mut worst = 0.0_f64;
    for (assets, camera) in [
        ("creature.obj", Camera::default()),
        (
            "part.obj",
            Camera::default().with_orbit(200.0, -30.0).with_zoom(3.0),
        ),
        ("torus.obj", Camera::default().with_ortho()),
        (
            "cube.obj",
            Camera::default().with_eye_target([0.0, 0.3, 2.0], [0.1, 0.0, 0.0]),
        ),
    ] {
        let scene = scene(&[assets]);
        let radius = scene.bounding_sphere().radius;
        let frame = renderer(1, &[Aov::Depth, Aov::Position])
            .render(&scene, &camera)
            .unwrap();
        let (view, mut seen) = (frame.view, 0);
        assert_eq!(frame.planes[0].low[0], f64::from(view.near));
        for [x, y] in pixels(&frame) {
            let (Some([z, ..]), Some(position)) =
                (frame.planes[0].value(x, y), frame.planes[1].value(x, y))
            else {
                continue;
            };
            let (from, along) = view.ray(x as f32 + 0.5, y as f32 + 0.5);
            let wide = |v: [f32; 3]| v.map(f64::from);
            let (from, along, forward) = (wide(from), wide(along), wide(view.forward));
            let cosine: f64 = (0..3).map(|k| along[k] * forward[k]).sum();
            let apart = (0..3).map(|k| (from[k] + along[k] * z / cosine - position[k]).powi(2));
            let apart = apart.sum::<f64>().sqrt() / radius;
            assert!(apart <= 1e-4, "{assets} {x},{y}: {apart:e}");
            worst = worst.max(apart);
            seen += 1;
        }
        assert!(seen > 2000, "{assets}: {seen}");
    }
    println!("position from depth: off by at most {worst:.2e} of the bounding radius");
}

/// The number in a face output, less 1.
fn face(frame: &Finished, [x, y]: [u32; 2]) -> Option<u32> {
    let codes = plane(frame, Aov::Face).codes(x, y);
    let number = codes.iter().fold(0, |n, &c| n << 8 | u32::from(c));
    number.checked_sub(1)
}

#[test]
fn faces_are_those_that_are_nearest_when_each_is_drawn_alone() {
    let text = fs::read_to_string(asset("torus.obj")).unwrap();
    let aovs = [Aov::Face, Aov::Depth];
    let draw = |text: &str| {
        let mut renderer = renderer(1, &aovs);
        renderer.refinement = Refinement::Uniform(3);
        // The frame of the whole, whatever is drawn.
        let camera = Camera::default()
            .with_eye_target([2.0, 3.0, 3.5], [0.0; 3])
            .with_near_far(0.5, 20.0);
        renderer.render(&scene_of(text), &camera).unwrap()
    };
    let whole = draw(&text);
    let faces = text.lines().filter(|l| l.starts_with("f ")).count();
    let holes = |but: usize| {
        let others = (0..faces).filter(|&f| f != but);
        let numbers: Vec<String> = others.map(|f| f.to_string()).collect();
        format!(
            "{text}\nt hole {}/0/0 {}\n",
            numbers.len(),
            numbers.join(" ")
        )
    };
    // Nearest depth and its face, pixel by pixel.
    let mut nearest = vec![(65535, None); 150 * 110];
    for f in 0..faces {
        let alone = draw(&holes(f));
        for ([x, y], best) in pixels(&alone).zip(&mut nearest) {
            let depth = plane(&alone, Aov::Depth).codes(x, y)[0];
            if depth < best.0 {
                *best = (depth, Some(f as u32));
            }
            let own = face(&alone, [x, y]);
            assert!(own.is_none() || own == Some(f as u32));
        }
    }
    let (mut seen, mut kinds) = (0, std::collections::BTreeSet::new());
    for (at, (depth, f)) in pixels(&whole).zip(nearest) {
        assert_eq!(plane(&whole, Aov::Depth).codes(at[0], at[1]), [depth]);
        let found = face(&whole, at);
        // Where two are equally near after rounding, either may be in front.
        let alone = found == f || found.is_some_and(|_| f.is_some());
        assert!(alone, "{at:?}");
        seen += u32::from(found == f && f.is_some());
        kinds.extend(found);
    }
    let all = plane(&whole, Aov::Depth).data.as_chunks::<2>().0.iter();
    let covered = all.filter(|c| **c != [255; 2]).count();
    assert!(seen as usize * 1000 >= covered * 999, "{seen} of {covered}");
    assert!(
        kinds.len() * 3 > faces,
        "{} of {faces} faces are seen",
        kinds.len()
    );
}

#[test]
fn faces_of_a_box_are_where_its_planes_are() {
    let scene = scene(&["cube.obj"]);
    let text = fs::read_to_string(asset("cube.obj")).unwrap();
    // The side of every face: axis and sign.
    let points: Vec<[f32; 3]> = (text.lines().filter_map(|l| l.strip_prefix("v ")))
        .map(|l| {
            let mut numbers = l.split_whitespace().map(|n| n.parse().unwrap());
            [0; 3].map(|_| numbers.next().unwrap())
        })
        .collect();
    let corners = |line: &str| -> Vec<usize> {
        let parts = line.split_whitespace();
        parts
            .map(|p| p.split('/').next().unwrap().parse::<usize>().unwrap() - 1)
            .collect()
    };
    let middle = |line: &str| {
        let own = corners(line);
        [0, 1, 2].map(|k| own.iter().map(|&c| points[c][k]).sum::<f32>() / own.len() as f32)
    };
    let sides: Vec<[f32; 3]> = text
        .lines()
        .filter_map(|l| l.strip_prefix("f "))
        .map(middle)
        .collect();
    assert_eq!(sides.len(), 6);
    for drawing in [Drawing::Cage, Drawing::Limit] {
        let mut renderer = renderer(1, &[Aov::Face, Aov::Position]);
        renderer.drawing = drawing;
        let frame = renderer.render(&scene, &Camera::default()).unwrap();
        let mut seen = 0;
        for at in pixels(&frame) {
            let Some(p) = plane(&frame, Aov::Position).value(at[0], at[1]) else {
                continue;
            };
            // The limit surface of a cube has its faces where its planes would be, seen from the middle.
            let along = |s: &[f32; 3]| (0..3).map(|k| f64::from(s[k]) * p[k]).sum::<f64>();
            let mut order: Vec<usize> = (0..6).collect();
            order.sort_by(|&a, &b| along(&sides[b]).total_cmp(&along(&sides[a])));
            if along(&sides[order[0]]) - along(&sides[order[1]]) > 1e-3 {
                assert_eq!(
                    face(&frame, at),
                    Some(order[0] as u32),
                    "{drawing:?} {at:?}"
                );
                seen += 1;
            }
        }
        assert!(seen > 3000);
    }
}

#[test]
fn levels_and_colours_are_those_of_the_surface() {
    let scene = scene(&["part.obj"]);
    let mut uniform = renderer(4, &[Aov::Level]);
    uniform.refinement = Refinement::Uniform(3);
    let frame = uniform.render(&scene, &Camera::default()).unwrap();
    assert!(frame.planes[0].data.iter().all(|&c| c == 0 || c == 4));
    let adaptive = renderer(4, &[Aov::Level])
        .render(&scene, &Camera::default())
        .unwrap();
    let kinds: std::collections::BTreeSet<u8> = adaptive.planes[0].data.iter().copied().collect();
    assert!(
        kinds.len() > 2 && kinds.iter().all(|&c| c <= 9),
        "{kinds:?}"
    );
    // Every material of a strip of quads comes back byte for byte.
    let strip = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nf 1 2 5 4\nf 2 3 6 5\n";
    let mut scene = scene_of(strip);
    let clay = earmark::shade::SurfaceMaterial::CLAY;
    scene.default_material = Some(earmark::shade::SurfaceMaterial {
        diffuse: [1.0, 0.5, 0.0],
        ..clay
    });
    let front = Camera::default().with_orbit(0.0, 0.0);
    let frame = renderer(4, &[Aov::Albedo]).render(&scene, &front).unwrap();
    let codes = frame.planes[0].codes(75, 55);
    assert_eq!(codes, [255, 188, 0, 255]);
}

#[test]
fn the_sample_nearest_to_the_centre_counts() {
    // Two squares beside each other; where they meet is put at any place of a column of pixels.
    let scene = scene_of(
        "v -1 -1 0\nv 0 -1 0\nv 1 -1 0\nv -1 1 0\nv 0 1 0\nv 1 1 0\nf 1 2 5 4\nf 2 3 6 5\n",
    );
    for (samples, sixteenths, left) in [
        (1, 1, true),
        (1, -1, false),
        // All four are equally near: the first, at -2/16, counts.
        (4, -1, true),
        (4, -3, false),
        // Those at 1/16 and -1/16 are equally near: the first counts, though more are on the other side.
        (8, 2, true),
        (8, 0, false),
        (16, 2, true),
        (16, 0, false),
    ] {
        let mut renderer = renderer(samples, &[Aov::Face]);
        renderer.drawing = Drawing::Cage;
        let at = |x: f64| {
            let camera = Camera::default()
                .with_ortho()
                .with_eye_target([x, 0.0, 5.0], [x, 0.0, 0.0]);
            renderer.render(&scene, &camera).unwrap()
        };
        let scale = f64::from(at(0.0).view.scale);
        let frame = at(-(0.5 + f64::from(sixteenths) / 16.0) / scale);
        let [x, ..] = frame.view.project([0.0; 3]).unwrap();
        assert!((x - 75.5 - sixteenths as f32 / 16.0).abs() < 1e-3);
        for y in 40..70 {
            let want = if left { 0 } else { 1 };
            assert_eq!(
                face(&frame, [75, y]),
                Some(want),
                "{samples} samples, {sixteenths}/16"
            );
        }
    }
}

/// Size, colour type, bits, and texts of a PNG.
fn head(path: &Path) -> (String, std::collections::BTreeMap<String, String>) {
    let decoder = png::Decoder::new(BufReader::new(File::open(path).unwrap()));
    let reader = decoder.read_info().unwrap();
    let info = reader.info();
    let texts = info.uncompressed_latin1_text.iter();
    let texts = texts.map(|t| (t.keyword.clone(), t.text.clone())).collect();
    let kind = format!(
        "{}x{} {:?} {:?}",
        info.width, info.height, info.color_type, info.bit_depth
    );
    (kind, texts)
}

#[test]
fn files_say_what_their_numbers_mean() {
    let folder = Folder::new("aov");
    let mut command = earmark();
    command
        .arg("render")
        .arg(asset("creature.obj"))
        .args(["-s", "64x48", "--stats", "-", "-o"]);
    command.arg(folder.path("p.png"));
    for aov in Aov::ALL {
        let path = folder.path(&format!("{}.png", aov.name()));
        command
            .arg("--aov")
            .arg(format!("{}={}", aov.name(), path.display()));
    }
    let out = command.output().unwrap();
    assert_eq!(code(&out), 0, "{}", stderr(&out));
    let stats: serde_json::Value = serde_json::from_str(&stdout(&out)).unwrap();
    let read = |name: &str| head(&folder.path(name));
    for (name, kind) in [
        ("depth", "Grayscale Sixteen"),
        ("normal", "Rgba Eight"),
        ("position", "Rgb Sixteen"),
        ("albedo", "Rgba Eight"),
        ("uv", "Rgb Sixteen"),
        ("face", "Rgb Eight"),
        ("level", "Grayscale Eight"),
        ("coverage", "Grayscale Eight"),
    ] {
        let (found, texts) = read(&format!("{name}.png"));
        assert_eq!(found, format!("64x48 {kind}"));
        assert_eq!(texts["aov"], name);
    }
    let (_, depth) = read("depth.png");
    for key in ["near", "far"] {
        assert_eq!(
            depth[key].parse::<f64>().unwrap(),
            stats[key].as_f64().unwrap()
        );
    }
    assert_eq!(depth["projection"], "perspective");
    let eye = stats["view"]["eye"].as_array().unwrap();
    let text: Vec<String> = eye
        .iter()
        .map(|c| c.as_f64().unwrap().to_string())
        .collect();
    assert_eq!(depth["eye"], text.join(" "));
    let (_, position) = read("position.png");
    assert_eq!(position["low"].split(' ').count(), 3);
    assert_eq!(read("uv.png").1["high"], "1 1");
    // Positions are those of the file, wherever its origin is.
    let far = folder.path("far.obj");
    let text = "v 100000 0 0\nv 100001 0 0\nv 100001 1 0\nv 100000 1 0\nf 1 2 3 4\n";
    fs::write(&far, text).unwrap();
    let flag = format!("position={}", folder.path("far.png").display());
    let out = earmark()
        .args(["render", "-s", "32x32", "--aov", &flag, "-o"])
        .arg(folder.path("p.png"))
        .arg(&far)
        .output()
        .unwrap();
    assert_eq!(code(&out), 0, "{}", stderr(&out));
    let low = read("far.png").1["low"].clone();
    let x: f64 = low.split(' ').next().unwrap().parse().unwrap();
    assert!((99_999.0..100_000.5).contains(&x), "{low}");
}

#[test]
fn wrong_outputs_are_refused_before_any_work() {
    let folder = Folder::new("aov-wrong");
    let at = |name: &str| folder.path(name).display().to_string();
    for (flags, want, part) in [
        (vec!["normals=x.png".to_owned()], 2, "depth, normal"),
        (vec!["depth".to_owned()], 2, "NAME=PATH"),
        (vec!["depth=".to_owned()], 2, "needs a file"),
        (vec!["depth=-".to_owned()], 2, "needs a file"),
        (vec![format!("depth={}", at("d.jpg"))], 2, "ending"),
        (
            vec![format!("depth={}", at("p.png"))],
            2,
            "where another output is",
        ),
        (
            vec![
                format!("depth={}", at("d.png")),
                format!("face={}", at("d.png")),
            ],
            2,
            "where another output is",
        ),
        (
            vec![
                format!("depth={}", at("d.png")),
                format!("depth={}", at("e.png")),
            ],
            2,
            "twice",
        ),
        (
            vec![format!("depth={}", at("none/d.png"))],
            4,
            "no such file",
        ),
    ] {
        let mut command = earmark();
        command
            .arg("render")
            .arg(asset("cube.obj"))
            .arg("-o")
            .arg(folder.path("p.png"));
        for flag in &flags {
            command.arg("--aov").arg(flag);
        }
        let out = command.output().unwrap();
        let message = assert_clean(&out);
        assert_eq!(code(&out), want, "{flags:?}: {message}");
        assert!(message.contains(part), "{flags:?}: {message}");
        assert_eq!(folder.names(), Vec::<String>::new());
    }
}
