//! Pictures by depth tags: no cracks whatever the tags, the same bytes for any number of threads, uniform tags as uniform levels.

use super::common::{self, Random};
use super::coverage;
use earmark::film::Image;
use earmark::frame::coverage::CoverageFault;
use earmark::frame::{Refinement, Renderer};
use earmark::load::{LoadOptions, Loader};
use earmark::scheme::Scheme;
use earmark::simd::Level;
use earmark::tessellate::{DepthTags, Pattern};
use earmark::{Cage, Camera, Scene, Surface, SurfaceOptions};

const PATTERNS: [Option<Pattern>; 3] = [None, Some(Pattern::Split), Some(Pattern::Equilateral)];

fn given(pattern: Option<Pattern>) -> Refinement {
    Refinement::DepthTags(DepthTags {
        pattern,
        ..DepthTags::GIVEN
    })
}

fn load(asset: &str, scheme: Scheme) -> Scene {
    let mut loader = Loader::new(LoadOptions {
        surface: SurfaceOptions {
            scheme: Some(scheme),
            ..SurfaceOptions::default()
        },
        ..LoadOptions::default()
    });
    let path = common::assets().join(format!("{asset}.obj"));
    loader.add_file(&path).unwrap();
    loader.finish().0
}

/// Gives every vertex one of `tags`.
fn tag(scene: &mut Scene, tags: &[u8], seed: u64) {
    let mut random = Random(seed);
    for object in &mut scene.objects {
        let count = object.surface.cage().points().len();
        let pick = |_| tags[random.next() as usize % tags.len()];
        object.depth_tags = (0..count).map(pick).collect();
    }
}

/// Checks a closed scene from many sides; returns covered samples.
fn check(what: &str, scene: &Scene, pattern: Option<Pattern>, views: u32) -> u64 {
    let mut covered = 0;
    let mut renderer = coverage::renderer(128, 0);
    renderer.refinement = given(pattern);
    for view in coverage::views(scene, &renderer, views, 3) {
        let none = CoverageFault::None;
        let c = renderer.signed_coverage(scene, &view, none).unwrap();
        assert_eq!(
            c.unequal, 0,
            "{what} {pattern:?}: {} of {}",
            c.unequal, c.samples
        );
        covered += c.covered;
    }
    covered
}

#[test]
fn closed_models_stay_closed_under_random_tags() {
    let mut covered = 0;
    let (mut closed, mut split, mut triangles) = (0, 0, 0);
    let mut paths = common::models(&common::assets());
    if let Some(shared) = common::shared() {
        paths.extend(common::models(&shared.join("models")));
    }
    for path in paths {
        let mut scene = common::load(&path);
        let surface = &scene.objects[0].surface;
        if !common::is_closed(surface) {
            continue;
        }
        closed += 1;
        split += u32::from(surface.is_split());
        triangles += u32::from(surface.is_triangular());
        for (k, tags) in [&[0, 5][..], &[0, 1, 2, 3, 4, 5, 6], &[3, 4], &[0, 0, 0, 8]]
            .into_iter()
            .enumerate()
        {
            tag(&mut scene, tags, k as u64);
            for pattern in PATTERNS {
                let what = format!("{} {tags:?}", path.display());
                covered += check(&what, &scene, pattern, 2);
            }
        }
    }
    println!(
        "tags: 0 samples unequal, {covered} covered, on {closed} closed models, {split} of them split, {triangles} of triangles"
    );
    assert!(
        closed > 3 && triangles > 0 && covered > 50_000,
        "{closed} {split} {triangles}"
    );
}

#[test]
fn every_scheme_takes_tags() {
    for (asset, scheme) in [
        ("tetrahedron", Scheme::Loop),
        ("octahedron", Scheme::Butterfly),
        ("octahedron", Scheme::Kobbelt),
        ("cube", Scheme::Kobbelt),
        ("tetrahedron", Scheme::CatmullClark),
        ("cube", Scheme::Bilinear),
    ] {
        let mut scene = load(asset, scheme);
        for seed in 0..3 {
            tag(&mut scene, &[0, 1, 3, 7], seed);
            for pattern in PATTERNS {
                check(&format!("{asset} {scheme:?} {seed}"), &scene, pattern, 2);
            }
        }
    }
}

/// A cube with an infinite crease, one that fades, and a sharp corner.
fn creased() -> Scene {
    let points = (0..8_u8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|b| 2.0 * f32::from(b) - 1.0));
    let mut cage = Cage::builder().points(points);
    for face in [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ] {
        cage = cage.face(face);
    }
    let cage = cage.crease(0, 1, 10.0).crease(1, 3, 10.0).crease(4, 6, 1.5);
    Scene::of(Surface::new(
        cage.build().unwrap(),
        &SurfaceOptions::default(),
    ))
}

#[test]
fn creases_take_tags() {
    let mut scene = creased();
    for seed in 0..4 {
        tag(&mut scene, &[0, 1, 3, 7], seed);
        for pattern in PATTERNS {
            check(&format!("creased cube {seed}"), &scene, pattern, 3);
        }
    }
}

#[test]
fn neighbours_differ_by_ten_levels() {
    let mut scene = load("cube", Scheme::CatmullClark);
    let mut tags = vec![0; 8];
    // The ends of one edge.
    let corners = scene.objects[0].surface.cage().corner_vertices();
    for k in 0..2 {
        tags[corners[k] as usize] = 10;
    }
    scene.objects[0].depth_tags = tags;
    for pattern in PATTERNS {
        assert!(check("cube", &scene, pattern, 2) > 1000);
    }
}

#[test]
fn a_broken_rule_is_noticed() {
    let mut scene = load("torus", Scheme::CatmullClark);
    tag(&mut scene, &[3, 5, 6], 1);
    for pattern in PATTERNS {
        let mut renderer = coverage::renderer(384, 0);
        renderer.refinement = given(pattern);
        let views = coverage::views(&scene, &renderer, 6, 3);
        let fault = CoverageFault::NoTieRule;
        let counts = views
            .iter()
            .map(|v| renderer.signed_coverage(&scene, v, fault));
        let unequal: u64 = counts.map(|c| c.unwrap().unequal).sum();
        assert!(unequal > 0, "{pattern:?}");
    }
}

fn draw(scene: &Scene, refinement: Refinement, simd: Level, samples: u32) -> (Image, u64) {
    let mut renderer = Renderer::new(96, 96);
    renderer.size.samples = samples;
    renderer.refinement = refinement;
    renderer.simd = simd;
    let frame = renderer.render(scene, &Camera::default()).unwrap();
    (frame.image, frame.stats.microtriangles)
}

#[test]
fn threads_and_vectors_change_nothing() {
    for (asset, scheme) in [
        ("creature", Scheme::CatmullClark),
        ("octahedron", Scheme::Loop),
    ] {
        let mut scene = load(asset, scheme);
        tag(&mut scene, &[0, 2, 4, 6], 9);
        for pattern in PATTERNS {
            let mut first = None;
            for threads in [1, 2, 8] {
                for simd in [Level::SCALAR, Level::detect()] {
                    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
                    let pool = pool.build().unwrap();
                    let drawn = pool.install(|| draw(&scene, given(pattern), simd, 4));
                    let same = first.get_or_insert(drawn.clone()) == &drawn;
                    assert!(same, "{asset} {pattern:?}: {threads} threads, {simd:?}");
                }
            }
        }
    }
}

#[test]
fn uniform_tags_are_uniform_levels() {
    for (asset, scheme) in [
        ("creature", Scheme::CatmullClark),
        ("part", Scheme::CatmullClark),
        ("tetrahedron", Scheme::Loop),
        ("octahedron", Scheme::Butterfly),
    ] {
        let mut scene = load(asset, scheme);
        for depth in [1, 3, 6] {
            tag(&mut scene, &[depth], 0);
            let uniform = draw(
                &scene,
                Refinement::Uniform(depth.into()),
                Level::detect(),
                1,
            );
            for pattern in PATTERNS {
                let tagged = draw(&scene, given(pattern), Level::detect(), 1);
                assert!(tagged == uniform, "{asset} {depth} {pattern:?}");
            }
        }
    }
}

#[test]
fn cages_with_other_polygons_have_at_least_depth_one() {
    let mut scene = load("tetrahedron", Scheme::CatmullClark);
    assert!(scene.objects[0].surface.is_split());
    let zero = draw(&scene, given(None), Level::detect(), 1);
    tag(&mut scene, &[1], 0);
    assert!(zero == draw(&scene, given(None), Level::detect(), 1));
}

#[test]
fn edges_of_depth_d_have_as_many_pieces() {
    // One face of a sheet: micro-triangles tell the depths of its sides.
    let mut scene = load("cube", Scheme::CatmullClark);
    for (tags, grid) in [([0_u8; 8], 2_u64), ([2; 8], 32), ([5; 8], 2048)] {
        scene.objects[0].depth_tags = tags.to_vec();
        assert_eq!(draw(&scene, given(None), Level::detect(), 1).1, 6 * grid);
    }
    // Too few and too many tags: the rest are 0, the surplus is not read, what is too deep is as deep as can be.
    scene.objects[0].depth_tags = vec![2; 3];
    let short = draw(&scene, given(None), Level::detect(), 1).1;
    scene.objects[0].depth_tags = vec![2, 2, 2, 0, 0, 0, 0, 0, 9, 9];
    assert_eq!(draw(&scene, given(None), Level::detect(), 1).1, short);
}

#[test]
fn near_and_bent_places_are_deeper() {
    let scene = load("creature", Scheme::CatmullClark);
    let count = |tags: DepthTags, zoom: f64| {
        let mut renderer = Renderer::new(256, 256);
        renderer.refinement = Refinement::DepthTags(tags);
        let camera = Camera::default().with_zoom(zoom);
        renderer
            .render(&scene, &camera)
            .unwrap()
            .stats
            .microtriangles
    };
    let [near, far] = [1.0, 0.1].map(|zoom| count(DepthTags::by_distance(), zoom));
    assert!(near > 4 * far, "{near} {far}");
    let [near, far] = [1.0, 0.1].map(|zoom| count(DepthTags::by_curvature(), zoom));
    assert_eq!(near, far);
    let both = count(DepthTags::by_distance_and_curvature(), 1.0);
    assert!(both <= near && both <= count(DepthTags::by_distance(), 1.0));
    let coarse = DepthTags {
        curvature: Some(30.0),
        ..DepthTags::by_curvature()
    };
    assert!(count(coarse, 1.0) * 4 < near);
}
