//! `earmark bench paper`: the tables of the papers that earmark follows, run again. Their models are not to be had; cages of as many
//! faces stand for them, made here, drawn with as many micro-triangles by the same kind of depth tags. A row is one steady frame of an
//! animated cage: new points, tags, picture (1024², one sample, lit), in process.
//!
//! * Boubekeur and Schlick, *Generic Adaptive Mesh Refinement* (GPU Gems 3, 2007), table 5-1 and the text below it: `gamer-…`
//! * Boubekeur and Schlick, *QAS: Real-time Quadratic Approximation of Subdivision Surfaces* (2007), figures 1, 3 and 5: `qas-…`
//! * Antal and Szirmay-Kalos on Catmull-Clark in geometry shaders, 1,300 quads at levels 0 to 2: `antal-…`
//! * Sachdev on Catmull-Clark in compute shaders, a cube after 5 and 6 iterations: `sachdev-…`, the refined mesh without a picture

use super::{Arguments, Outcome, Published, publish, push};
use crate::cli::exit::Failure;
use crate::cli::job::Job;
use crate::cli::stats::{Clock, Time};
use Depth::{Both, Curvature, Distance, Uniform};
use Kind::{Function as Noise, Limit, Map, Pn, Qas};
use Model::{Ground, Odd, Quads, Torus};
use earmark::displace::{Displacement, Function, HeightMap, Shape};
use earmark::frame::{FrameStats, Refinement, Renderer};
use earmark::patch::PatchKind;
use earmark::refine::{Level, Options, Timings};
use earmark::scheme::{FaceVaryingRule, Scheme};
use earmark::tessellate::DepthTags;
use earmark::topology::{ConnectOptions, connect};
use earmark::{Cage, Camera, Scene, Surface, SurfaceOptions};
use std::hint::black_box;
use std::sync::Arc;

/// The cage of a row.
#[derive(Clone, Copy)]
enum Model {
    /// A torus with bumps, of so many quads along and around, or twice as many triangles.
    Torus(u32, u32),
    Quads(u32, u32),
    /// Hilly ground of so many squares of two triangles.
    Ground(u32, u32),
    /// The same with one triangle more.
    Odd(u32, u32),
}

/// How deep it is cut.
#[derive(Clone, Copy)]
enum Depth {
    Uniform(u32),
    /// Tags from distance, curvature, or both, tuned to so many micro-triangles.
    Distance(u64),
    Curvature(u64),
    Both(u64),
}

/// What is cut: the limit surface, patches in its place, or either displaced.
#[derive(Clone, Copy)]
enum Kind {
    Limit,
    Qas,
    Pn,
    /// The limit surface displaced by a function of space.
    Function,
    /// The limit surface displaced by a map.
    Map,
}

struct Frame {
    name: &'static str,
    model: Model,
    kind: Kind,
    depth: Depth,
    /// Frames in a second as published, on a GPU.
    fps: f64,
}

const fn frame(name: &'static str, model: Model, kind: Kind, depth: Depth, fps: f64) -> Frame {
    Frame {
        name,
        model,
        kind,
        depth,
        fps,
    }
}

const FRAMES: [Frame; 14] = [
    frame("gamer-robot", Torus(89, 7), Pn, Both(1_100_000), 263.0),
    frame(
        "gamer-hand",
        Torus(21, 13),
        Noise,
        Distance(2_100_000),
        155.0,
    ),
    frame("gamer-face", Torus(33, 29), Map, Curvature(4_000_000), 58.0),
    frame(
        "gamer-terrain",
        Ground(7, 7),
        Map,
        Distance(6_400_000),
        44.0,
    ),
    frame("gamer-65000", Torus(250, 130), Limit, Uniform(2), 38.0),
    frame("gamer-4000", Torus(50, 40), Limit, Uniform(4), 279.0),
    frame("qas-2720", Torus(40, 34), Qas, Uniform(5), 113.0),
    frame("qas-2516", Torus(37, 34), Qas, Uniform(5), 128.0),
    frame("qas-1246", Torus(89, 7), Qas, Distance(2_600_000), 132.0),
    frame("qas-546", Torus(21, 13), Qas, Uniform(5), 527.0),
    frame("qas-703", Odd(27, 13), Qas, Distance(620_000), 499.0),
    frame("antal-0", Quads(50, 26), Limit, Uniform(0), 1073.0),
    frame("antal-1", Quads(50, 26), Limit, Uniform(1), 306.0),
    frame("antal-2", Quads(50, 26), Limit, Uniform(2), 18.8),
];

/// Seconds of the whole-mesh refinement of a cube, as published: on a CPU, on a GPU.
pub(crate) const CUBES: [(&str, u32, [f64; 2]); 2] = [
    ("sachdev-5", 5, [6.39, 5.58]),
    ("sachdev-6", 6, [99.21, 86.01]),
];

impl Model {
    fn cage(self) -> Result<Cage, Failure> {
        let cage = match self {
            Self::Torus(m, n) => torus(m, n, true),
            Self::Quads(m, n) => torus(m, n, false),
            Self::Ground(m, n) => ground(m, n, false),
            Self::Odd(m, n) => ground(m, n, true),
        };
        cage.map_err(|e| Failure::usage(e.to_string()))
    }
}

/// Corners of a face, as quad or as two triangles.
fn face(quad: [u32; 4], triangles: bool, counts: &mut Vec<u32>, corners: &mut Vec<u32>) {
    let [a, b, c, d] = quad;
    if triangles {
        counts.extend([3, 3]);
        corners.extend([a, b, c, a, c, d]);
    } else {
        counts.push(4);
        corners.extend(quad);
    }
}

fn torus(m: u32, n: u32, triangles: bool) -> Result<Cage, earmark::mesh::CageError> {
    let turn = std::f64::consts::TAU;
    let points = (0..m * n).map(|k| {
        let (a, b) = (
            f64::from(k / n) / f64::from(m),
            f64::from(k % n) / f64::from(n),
        );
        let (a, b) = (a * turn, b * turn);
        let bumps = 0.12 * libm::sin(5.0 * a) * libm::sin(2.0 * b + a);
        let r = 1.0 + (0.45 + bumps) * libm::cos(b);
        [
            r * libm::sin(a),
            (0.45 + bumps) * libm::sin(b),
            r * libm::cos(a),
        ]
        .map(|c| c as f32)
    });
    let at = |i: u32, j: u32| i % m * n + j % n;
    let (mut counts, mut corners) = (Vec::new(), Vec::new());
    for (i, j) in (0..m).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        face(quad, triangles, &mut counts, &mut corners);
    }
    let uvs = (0..=m).flat_map(|i| (0..=n).map(move |j| [unit(i, m), unit(j, n)]));
    let (mut uv_counts, mut uv_corners) = (Vec::new(), Vec::new());
    let at = |i: u32, j: u32| i * (n + 1) + j;
    for (i, j) in (0..m).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        face(quad, triangles, &mut uv_counts, &mut uv_corners);
    }
    Cage::new(points.collect(), &counts, corners)?.with_uvs(uvs.collect(), uv_corners)
}

/// A step as a texture coordinate.
fn unit(k: u32, of: u32) -> f32 {
    k as f32 / of as f32
}

fn ground(m: u32, n: u32, odd: bool) -> Result<Cage, earmark::mesh::CageError> {
    let hill = |x: f64, z: f64| {
        0.12 * libm::sin(7.0 * x) * libm::cos(5.0 * z) + 0.05 * libm::sin(19.0 * (x + z))
    };
    let point = |i: f64, j: f64| {
        let (x, z) = (2.0 * i / f64::from(m) - 1.0, 2.0 * j / f64::from(n) - 1.0);
        [x, hill(x, z), z].map(|c| c as f32)
    };
    let mut points: Vec<[f32; 3]> = (0..(m + 1) * (n + 1))
        .map(|k| point(f64::from(k / (n + 1)), f64::from(k % (n + 1))))
        .collect();
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let (mut counts, mut corners) = (Vec::new(), Vec::new());
    for (i, j) in (0..m).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let quad = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        face(quad, true, &mut counts, &mut corners);
    }
    if odd {
        let last = points.len() as u32;
        points.push(point(0.5, -1.0));
        counts.push(3);
        corners.extend([at(0, 0), at(1, 0), last]);
    }
    let uvs = points.iter().map(|p| [0.5 + 0.5 * p[0], 0.5 + 0.5 * p[2]]);
    let (uvs, uv_corners) = (uvs.collect(), corners.clone());
    Cage::new(points, &counts, corners)?.with_uvs(uvs, uv_corners)
}

/// Heights about 0, of several sizes.
fn heights() -> Result<HeightMap, Failure> {
    const N: u32 = 512;
    let wave =
        |k: u32, turns: f64| libm::sin(f64::from(k) / f64::from(N) * turns * std::f64::consts::TAU);
    let table: Vec<[f64; 4]> = (0..N)
        .map(|k| [wave(k, 3.0), wave(k, 7.0), wave(k, 17.0), wave(k, 41.0)])
        .collect();
    let height = |k: u32| {
        let (x, y) = (table[(k % N) as usize], table[(k / N) as usize]);
        (x[0] * y[1] + 0.5 * x[1] * y[2] + 0.25 * x[2] * y[0] + 0.12 * x[3] * y[3]) as f32
    };
    HeightMap::new(N, N, (0..N * N).map(height).collect())
        .map_err(|e| Failure::usage(e.to_string()))
}

impl Kind {
    fn surface(self, cage: Cage) -> Result<Surface, Failure> {
        let patches = match self {
            Self::Qas => PatchKind::Qas,
            Self::Pn => PatchKind::Pn,
            Self::Limit | Self::Function | Self::Map => PatchKind::None,
        };
        let options = SurfaceOptions {
            patches,
            ..SurfaceOptions::default()
        };
        let mut surface = Surface::new(cage, &options);
        let displacement = match self {
            Self::Function => Displacement::function(Function {
                frequency: 4.0,
                ..Function::new(Shape::Fbm)
            }),
            Self::Map => Displacement::map(Arc::new(heights()?)),
            _ => return Ok(surface),
        };
        surface.set_displacement(Some(displacement.scaled(0.04)));
        Ok(surface)
    }
}

impl Depth {
    /// Tags with pieces `scale` times as large as by default.
    fn refinement(self, scale: f32) -> Refinement {
        let scaled = |tags: DepthTags| {
            Refinement::DepthTags(DepthTags {
                distance: tags.distance.map(|d| d * scale),
                curvature: tags.curvature.map(|d| d * scale),
                ..tags
            })
        };
        match self {
            Self::Uniform(level) => Refinement::Uniform(level),
            Self::Distance(_) => scaled(DepthTags::by_distance()),
            Self::Curvature(_) => scaled(DepthTags::by_curvature()),
            Self::Both(_) => scaled(DepthTags::by_distance_and_curvature()),
        }
    }
    fn wanted(self) -> Option<u64> {
        match self {
            Self::Uniform(_) => None,
            Self::Distance(n) | Self::Curvature(n) | Self::Both(n) => Some(n),
        }
    }
}

/// A row ready to be measured.
struct Ready {
    scene: Scene,
    points: Vec<[f32; 3]>,
    renderer: Renderer,
    view: earmark::camera::View,
    stats: FrameStats,
}

impl Ready {
    fn new(job: &Job, a: &Arguments, row: &Frame) -> Result<Self, Failure> {
        let cage = row.model.cage()?;
        let points = cage.points().to_vec();
        // Tags do not know of displacement, so their number is found without.
        let plain = Scene::of(Surface::new(cage.clone(), &SurfaceOptions::default()));
        let scene = Scene::of(row.kind.surface(cage)?);
        let mut renderer = a.picture.renderer(&a.level);
        renderer.size.samples = 1;
        renderer.simd = job.simd;
        renderer.limits = job.limits();
        let mut camera = Camera::default();
        if matches!(row.model, Model::Ground(..)) {
            // Over the ground, towards the far end of it.
            camera = camera.with_eye_target([0.0, 0.45, 1.6], [0.0, 0.0, 0.0]);
        }
        renderer.refinement = row.depth.refinement(1.0);
        let warm = renderer.render(&scene, &camera)?;
        let (view, mut stats) = (warm.view, warm.stats);
        if let Some(wanted) = row.depth.wanted() {
            // Counts fall with the size of the pieces, in steps, vertex by vertex; the nearest that is met.
            let off = |n: u64| (n.max(1) as f64 / wanted as f64).ln().abs();
            let (mut scale, mut best) = (1.0_f32, (f64::INFINITY, renderer.refinement));
            let [mut many, mut few] = [None, None];
            for _ in 0..14 {
                renderer.refinement = row.depth.refinement(scale);
                let found = renderer.render_view(&plain, &view)?;
                let count = found.stats.microtriangles;
                if off(count) < best.0 {
                    best = (off(count), renderer.refinement);
                }
                let side = if count > wanted { &mut many } else { &mut few };
                *side = Some(scale);
                scale = match (many, few) {
                    (Some(low), Some(high)) => (low * high).sqrt(),
                    _ => scale * (count as f32 / wanted as f32).sqrt().clamp(0.5, 2.0),
                };
            }
            renderer.refinement = best.1;
            stats = renderer.render_view(&scene, &view)?.stats;
        }
        Ok(Self {
            scene,
            points,
            renderer,
            view,
            stats,
        })
    }

    fn once(&mut self) -> Result<Time, Failure> {
        let clock = Clock::now();
        self.scene.objects[0]
            .surface
            .update_points(&self.points)
            .map_err(|e| Failure::usage(e.to_string()))?;
        black_box(self.renderer.render_view(&self.scene, &self.view)?);
        Ok(clock.elapsed())
    }
}

/// The cube of two units.
pub(crate) fn cube_cage() -> Result<Cage, Failure> {
    let points: Vec<[f32; 3]> = (0..8_u8)
        .map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|b| 2.0 * f32::from(b) - 1.0))
        .collect();
    let corners = vec![
        0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5,
    ];
    Cage::new(points, &[4; 6], corners).map_err(|e| Failure::usage(e.to_string()))
}

/// A row that is a limit surface, or its quadratic patches, at one level.
#[cfg(feature = "gpu")]
pub(crate) struct UniformRow {
    pub(crate) name: &'static str,
    pub(crate) cage: Result<Cage, Failure>,
    pub(crate) options: SurfaceOptions,
    pub(crate) level: u32,
    pub(crate) published_ms: f64,
}

/// The rows that are limit surfaces, or their quadratic patches, at one level.
#[cfg(feature = "gpu")]
pub(crate) fn uniform_rows() -> Vec<UniformRow> {
    let rows = FRAMES.iter().filter_map(|row| match (row.kind, row.depth) {
        (kind @ (Limit | Qas), Uniform(level)) => Some(UniformRow {
            name: row.name,
            cage: row.model.cage(),
            options: SurfaceOptions {
                patches: match kind {
                    Qas => PatchKind::Qas,
                    _ => PatchKind::None,
                },
                ..SurfaceOptions::default()
            },
            level,
            published_ms: 1e3 / row.fps,
        }),
        _ => None,
    });
    rows.collect()
}

/// Refines a cube whole.
fn cube(iterations: u32) -> Result<(Time, u64), Failure> {
    let cage = cube_cage()?;
    let clock = Clock::now();
    let corners = cage.corner_vertices().to_vec();
    let topology = connect(
        cage.points().len(),
        cage.face_offsets(),
        corners,
        &ConnectOptions::default(),
    )
    .0;
    let options = Options {
        scheme: Scheme::CatmullClark,
        ..Options::default()
    };
    let mut timings = Timings::default();
    let mut level =
        Level::<f32>::of_cage(&cage, topology, options.scheme, FaceVaryingRule::default())?;
    for _ in 0..iterations {
        level = level.next(&options, &mut timings)?;
    }
    let faces = level.topology.face_count() as u64;
    black_box(level);
    Ok((clock.elapsed(), faces))
}

pub(super) fn paper(job: &Job, a: &Arguments) -> Result<Outcome, Failure> {
    let mut rows = Vec::new();
    let mut sums = vec![Time::default(); a.repeat as usize];
    let (mut faces, mut triangles, mut pixels) = (0, 0, 0);
    push(&mut rows, "total", Time::default(), &|_| 0);
    rows[0].times.clear();
    for row in &FRAMES {
        job.limits().check()?;
        let mut ready = Ready::new(job, a, row)?;
        let count = ready.stats.microtriangles;
        for sum in &mut sums {
            let time = ready.once()?;
            sum.wall += time.wall;
            sum.cpu += time.cpu;
            push(&mut rows, row.name, time, &|_| count);
        }
        let published = Published {
            milliseconds: 1e3 / row.fps,
            coarse: ready.stats.faces,
        };
        publish(&mut rows, row.name, published);
        faces += ready.stats.faces;
        triangles += count;
        pixels += ready.stats.pixels_covered;
    }
    for (name, iterations, [_, gpu]) in CUBES {
        for sum in &mut sums {
            let (time, count) = cube(iterations)?;
            sum.wall += time.wall;
            sum.cpu += time.cpu;
            push(&mut rows, name, time, &|_| 2 * count);
        }
        let published = Published {
            milliseconds: gpu * 1e3,
            coarse: 6,
        };
        publish(&mut rows, name, published);
    }
    rows[0].times = sums;
    rows[0].items = triangles;
    Ok(Outcome {
        rows,
        faces,
        microtriangles: triangles,
        pixels,
        ..Outcome::default()
    })
}
