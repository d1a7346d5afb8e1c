//! Line work: what is seen of lines against rays through all triangles, lines without gaps, valences, SVG, and pictures.

mod common;
#[path = "overlay/golden.rs"]
mod golden;
#[path = "overlay/rays.rs"]
mod rays;

use common::{assets, load};
use earmark::film::Image;
use earmark::frame::{Drawing, Refinement};
use earmark::overlay::{self, Kind, Layers, LineArt, Options, Polyline};
use earmark::scheme::Scheme;
use earmark::simd::Level;
use earmark::{Camera, Renderer, Scene, Surface, SurfaceOptions};
use rays::Oracle;

fn asset(name: &str) -> Scene {
    load(&assets().join(format!("{name}.obj")))
}

fn renderer(side: u32, level: u32) -> Renderer {
    let mut renderer = Renderer::new(side, side);
    renderer.refinement = Refinement::Uniform(level);
    renderer
}

fn trace(renderer: &Renderer, scene: &Scene, camera: &Camera, layers: Layers) -> LineArt {
    let view = renderer.view(scene, camera).unwrap();
    overlay::trace(renderer, scene, &view, &Options::overlay(layers)).unwrap()
}

/// What both ways of being wrong come to, over a model.
fn faults(scene: &Scene, level: u32, camera: &Camera, spoil: impl Fn(&mut LineArt)) -> [usize; 3] {
    let renderer = renderer(400, level);
    let view = renderer.view(scene, camera).unwrap();
    let mut art = trace(&renderer, scene, camera, Layers::WIREFRAME);
    spoil(&mut art);
    let oracle = Oracle::new(&scene.objects[0].surface, &view, level);
    let (shown, looked_at) = oracle.hidden_but_drawn(&art.polylines);
    let missing = oracle.seen_but_not_drawn(&art.polylines);
    [shown, missing, looked_at]
}

#[test]
fn hidden_lines_do_not_show_and_visible_ones_are_whole() {
    for (name, level, camera) in [
        ("torus", 3, Camera::default()),
        ("creature", 1, Camera::default().with_orbit(200.0, 10.0)),
        ("part_creased", 1, Camera::default()),
        ("mobius", 3, Camera::default()),
        (
            "mobius",
            2,
            Camera::default().with_orbit(100.0, -20.0).with_ortho(),
        ),
        // The near plane cuts the model.
        (
            "torus",
            3,
            Camera::default().with_eye_target([0.3, 0.4, 0.9], [0.0, 0.0, -1.0]),
        ),
    ] {
        let [shown, missing, looked_at] = faults(&asset(name), level, &camera, |_| ());
        assert!(looked_at > 1000, "{name}: {looked_at} places");
        assert_eq!(
            [shown, missing],
            [0, 0],
            "{name}: shown, missing of {looked_at}"
        );
    }
}

#[test]
fn reference_models_are_drawn_without_hidden_lines() {
    let Some(folder) = common::shared() else {
        return;
    };
    for name in ["Bigguy", "Monsterfrog", "suzanne"] {
        let scene = load(&folder.join(format!("models/{name}.obj")));
        let [shown, missing, looked_at] = faults(&scene, 1, &Camera::default(), |_| ());
        assert!(looked_at > 1000, "{name}: {looked_at} places");
        assert_eq!(
            [shown, missing],
            [0, 0],
            "{name}: shown, missing of {looked_at}"
        );
    }
}

#[test]
fn the_oracle_notices() {
    let torus = asset("torus");
    let camera = Camera::default();
    // A line of the far side, which is where one of the near side would be in a mirrored view.
    let [shown, ..] = faults(&torus, 3, &camera, |art| {
        for line in &mut art.polylines {
            line.points.iter_mut().for_each(|p| p[0] += 1.5);
        }
    });
    assert!(shown > 100, "{shown}");
    let [_, missing, _] = faults(&torus, 3, &camera, |art| {
        for line in &mut art.polylines {
            let kept = line.points.len() * 9 / 10;
            line.points.truncate(kept);
        }
    });
    assert!(missing > 20, "{missing}");
}

/// On a convex model every visible curve of an edge runs from vertex to vertex or to the silhouette, in one piece.
#[test]
fn lines_of_a_convex_model_have_no_gaps() {
    for (azimuth, side) in [(45.0, 512), (10.0, 700), (77.0, 2048), (31.0, 1030)] {
        let scene = asset("cube");
        let renderer = renderer(side, 4);
        let camera = Camera::default().with_orbit(azimuth, 25.0);
        let view = renderer.view(&scene, &camera).unwrap();
        let art = trace(
            &renderer,
            &scene,
            &camera,
            Layers::PATCHES | Layers::SILHOUETTES,
        );
        let surface = &scene.objects[0].surface;
        let corners = (0..surface.quads().half_count() as u32)
            .map(|h| surface.fan_limit(surface.quads().fan(h)).0);
        let corners: Vec<[f32; 2]> = corners
            .map(|p| view.project(p).map(|[x, y, _]| [x, y]).unwrap())
            .collect();
        let of = |kind: Kind| art.polylines.iter().filter(move |l| l.kind == kind);
        let mut ends = 0;
        for line in of(Kind::Patch) {
            for end in [line.points[0], line.points[line.points.len() - 1]] {
                let at_corner = corners.iter().any(|&c| rays::distance(c, end) < 0.1);
                let on_rim =
                    of(Kind::Silhouette).any(|s| rays::from_polyline(end, &s.points) < 0.1);
                assert!(
                    at_corner || on_rim,
                    "{azimuth} {side}: a line ends at {end:?}"
                );
                ends += 1;
            }
        }
        assert!((4..60).contains(&ends), "{ends} ends");
        // The outline is closed: as many pieces as it takes, but no loose end.
        for line in of(Kind::Silhouette) {
            for end in [line.points[0], line.points[line.points.len() - 1]] {
                let goes_on = of(Kind::Silhouette)
                    .filter(|s| !std::ptr::eq(*s, line))
                    .any(|s| rays::from_polyline(end, &s.points) < 0.1);
                let closed = line.points[0] == line.points[line.points.len() - 1];
                assert!(
                    goes_on || closed,
                    "{azimuth} {side}: the outline ends at {end:?}"
                );
            }
        }
    }
}

#[test]
fn threads_and_vectors_change_nothing() {
    let scene = asset("creature");
    let layers = Layers::names().filter_map(Layers::from_name);
    let layers = layers.fold(Layers::NONE, |all, l| all | l);
    let mut results = Vec::new();
    for (threads, simd) in [
        (1, Level::SCALAR),
        (1, Level::detect()),
        (3, Level::detect()),
    ] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let result = pool.build().unwrap().install(|| {
            let mut renderer = Renderer::new(600, 300);
            renderer.simd = simd;
            let view = renderer.view(&scene, &Camera::default()).unwrap();
            let mut image = Image::filled([600, 300], [255; 4]);
            let options = Options::overlay(layers);
            let art = overlay::draw(&mut image, &renderer, &scene, &view, &options).unwrap();
            (
                image,
                art.to_svg(None),
                art.polylines,
                art.marks,
                art.labels,
            )
        });
        results.push(result);
    }
    assert!(results.windows(2).all(|r| r[0] == r[1]));
}

/// What is hidden as a whole is left out before lines are traced. Leaving nothing out comes to the same but for silhouettes that run along the
/// border of a tile, of which a few pixels are still lost; without the tiles' aprons it is three times as much.
#[test]
fn leaving_out_what_is_hidden_takes_no_line_away() {
    for (name, level, azimuth) in [
        ("creature", 3, 45.0),
        ("creature", 3, 200.0),
        ("torus", 5, 45.0),
    ] {
        let scene = asset(name);
        let camera = Camera::default().with_orbit(azimuth, 25.0);
        for (layer, allowed) in [(Layers::PATCHES, 1e-4), (Layers::SILHOUETTES, 1e-4)] {
            let lengths = [true, false].map(|leave_out| {
                let mut renderer = renderer(1024, level);
                renderer.leave_out = leave_out;
                let art = trace(&renderer, &scene, &camera, layer);
                let all = art.polylines.iter().flat_map(|l| l.points.windows(2));
                let each = all.map(|p| f64::from(rays::distance(p[0], p[1])));
                each.sum::<f64>()
            });
            let lost = (lengths[0] - lengths[1]).abs();
            assert!(
                lost < allowed * lengths[1],
                "{name} {azimuth}: {lengths:?} pixels of {}",
                layer.to_names()
            );
        }
    }
}

#[test]
fn valences_are_those_of_the_cage() {
    for (name, valence) in [("fan3", 3), ("fan5", 5), ("fan8", 8), ("fan24", 24)] {
        let camera = Camera::default().with_orbit(0.0, 90.0);
        let (scene, renderer) = (asset(name), renderer(256, 2));
        let art = trace(&renderer, &scene, &camera, Layers::VALENCES);
        let inner: Vec<_> = art.marks.iter().filter(|m| m.vertex == Some(0)).collect();
        assert_eq!(inner.len(), 1, "{name}");
        assert_eq!((inner[0].valence, inner[0].extraordinary), (valence, true));
        assert!(art.labels.iter().any(|l| l.text == valence.to_string()));
        let surface = &scene.objects[0].surface;
        let view = renderer.view(&scene, &camera).unwrap();
        let [x, y, _] = view.project(surface.fan_limit(0).0).unwrap();
        assert!(
            rays::distance(inner[0].at, [x, y]) < 0.01,
            "{:?}",
            inner[0].at
        );
    }
    // Of a cube, which is a ball by now, the corners on this side; triangles are ordinary with six.
    let cube = trace(
        &renderer(256, 2),
        &asset("cube"),
        &Camera::default(),
        Layers::VALENCES,
    );
    assert_eq!(cube.marks.len(), 4);
    let octahedron = asset("octahedron").objects[0].surface.cage().clone();
    let options = SurfaceOptions {
        scheme: Some(Scheme::Loop),
        ..SurfaceOptions::default()
    };
    let scene = Scene::of(Surface::new(octahedron, &options));
    let art = trace(
        &renderer(256, 3),
        &scene,
        &Camera::default(),
        Layers::VALENCES,
    );
    assert!(art.marks.iter().all(|m| m.valence == 4));
    assert!((3..6).contains(&art.marks.len()), "{}", art.marks.len());
    // Numbers count as tags do.
    let art = trace(
        &renderer(512, 2),
        &asset("grid"),
        &Camera::default(),
        Layers::LABELS,
    );
    assert_eq!(art.marks.len(), 25);
    let corner = art.marks.iter().find(|m| m.vertex == Some(24)).unwrap();
    assert_eq!((corner.valence, corner.extraordinary), (2, false));
}

/// Subpaths of the paths of a class, from the text of an SVG.
fn paths_of(svg: &str, class: &str) -> Vec<Vec<[i64; 2]>> {
    let mut out = Vec::new();
    for element in svg
        .split('<')
        .filter(|e| e.starts_with(&format!("path class=\"{class}\"")))
    {
        let data = element.split(" d=\"").nth(1).unwrap();
        let data = &data[..data.find('"').unwrap()];
        for sub in data.split('M').skip(1) {
            let spaced = sub.replace('l', " ").replace('-', " -");
            let numbers: Vec<i64> = spaced
                .split(' ')
                .filter(|n| !n.is_empty())
                .map(|n| (n.parse::<f64>().unwrap() * 100.0).round() as i64)
                .collect();
            let mut at = [0, 0];
            let points = numbers.chunks_exact(2).map(|d| {
                at = [at[0] + d[0], at[1] + d[1]];
                at
            });
            out.push(points.collect());
        }
    }
    out
}

#[test]
fn svg_holds_the_same_lines() {
    let scene = asset("part_creased");
    let renderer = renderer(512, 2);
    let view = renderer.view(&scene, &Camera::default()).unwrap();
    let options = Options::illustration(Layers::CAGE | Layers::AXES);
    let art = overlay::trace(&renderer, &scene, &view, &options).unwrap();
    let svg = art.to_svg(Some([255, 255, 255, 255]));
    assert!(svg.contains("viewBox=\"0 0 512 512\"") && svg.contains("<rect width=\"512\""));
    assert!(!art.to_svg(None).contains("<rect"));
    let mut kinds = 0;
    for kind in Kind::ALL {
        let hundredths = |l: &Polyline| -> Vec<[i64; 2]> {
            let point = |p: &[f32; 2]| p.map(|c| (f64::from(c) * 100.0).round() as i64);
            l.points.iter().map(point).collect()
        };
        let own: Vec<_> = art
            .polylines
            .iter()
            .filter(|l| l.kind == kind)
            .map(hundredths)
            .collect();
        assert_eq!(own, paths_of(&svg, kind.name()), "{kind:?}");
        kinds += usize::from(!own.is_empty());
    }
    assert!(kinds >= 7, "{kinds} kinds of lines");
    // Small: no more than a few bytes per point.
    let points: usize = art.polylines.iter().map(|l| l.points.len()).sum();
    assert!(
        svg.len() < 1000 + points * 12,
        "{} bytes, {points} points",
        svg.len()
    );
}

#[test]
fn lines_of_deep_levels_are_those_of_pixels() {
    let scene = asset("creature");
    let coarse = trace(
        &renderer(256, 4),
        &scene,
        &Camera::default(),
        Layers::PATCHES,
    );
    let mut deep = renderer(256, 10);
    // Much less than a mesh of that level.
    deep.limits.max_memory = Some(256 << 20);
    let deep = trace(&deep, &scene, &Camera::default(), Layers::PATCHES);
    assert!(deep.stats.levels[0] <= 4, "{:?}", deep.stats.levels);
    assert!(!deep.polylines.is_empty() && deep.polylines.len() <= coarse.polylines.len() * 2);
}

#[test]
fn limits_stop_lines_before_memory_is_taken() {
    let scene = asset("creature");
    let mut small = Renderer::new(1024, 1024);
    small.refinement = Refinement::Uniform(6);
    // More than the picture takes on one thread, less than its lines.
    small.limits.max_memory = Some(32 << 20);
    let view = small.view(&scene, &Camera::default()).unwrap();
    let options = Options::overlay(Layers::WIREFRAME);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1);
    let trace = || overlay::trace(&small, &scene, &view, &options).map(|_| ());
    let error = one.build().unwrap().install(trace).unwrap_err();
    assert!(error.to_string().contains("the lines of"), "{error}");
    // Those of the cage before any of them is there.
    small.limits.max_memory = Some(10_000);
    let options = Options::overlay(Layers::CAGE);
    let error = overlay::trace(&small, &scene, &view, &options).unwrap_err();
    let said = "the lines of the cage would take about ";
    assert!(error.to_string().starts_with(said), "{error}");
    let options = Options::overlay(Layers::WIREFRAME);
    small.limits.max_memory = None;
    small
        .limits
        .cancelled
        .store(true, std::sync::atomic::Ordering::Relaxed);
    let error = overlay::trace(&small, &scene, &view, &options).unwrap_err();
    assert_eq!(error.to_string(), "cancelled");
}

/// Whatever is drawn, a layer finds its lines, and an empty scene has none.
#[test]
fn every_drawing_has_its_lines() {
    let scene = asset("part");
    for drawing in [Drawing::Limit, Drawing::Refined, Drawing::Cage] {
        for level in [0, 1] {
            let mut renderer = renderer(256, level);
            renderer.drawing = drawing;
            let art = trace(
                &renderer,
                &scene,
                &Camera::default(),
                Layers::PATCHES | Layers::VALENCES,
            );
            assert!(art.polylines.len() > 50, "{drawing:?} {level}");
            assert!(
                art.marks.iter().any(|m| m.valence == 3),
                "{drawing:?} {level}"
            );
        }
    }
    let all = Layers::names()
        .filter_map(Layers::from_name)
        .fold(Layers::NONE, |a, l| a | l);
    let art = trace(
        &Renderer::new(64, 64),
        &Scene::default(),
        &Camera::default(),
        all,
    );
    assert!(art.marks.is_empty());
    assert!(art.polylines.iter().all(|l| l.kind >= Kind::AxisX));
}
