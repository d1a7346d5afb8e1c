//! Diced points and normals, read back for the test: against the processor's, and among faces that share them.

use crate::{asset, gpu, gpu_with, plain, torus, uniform};
use earmark::frame::Drawing;
use earmark::gpu::{DeviceOptions, Gpu, GpuScene, ReadBlock};
use earmark::patch::PatchKind;
use earmark::scheme::Scheme;
use earmark::surface::DicedQuad;
use earmark::{Camera, Renderer, Scene, Surface, SurfaceOptions};
use std::ops::RangeInclusive;

/// Blocks of a scene at a uniform level.
pub(crate) fn blocks(gpu: &Gpu, scene: &Scene, level: u32) -> Vec<ReadBlock> {
    read(gpu, &uniform(32, 32, level), scene)
}

fn read(gpu: &Gpu, renderer: &Renderer, scene: &Scene) -> Vec<ReadBlock> {
    let mut ready = GpuScene::new(gpu, renderer, scene, &Camera::default()).unwrap();
    ready.draw().unwrap();
    ready.read_blocks().unwrap()
}

/// Length of the box of a surface's control points.
fn size(surface: &Surface) -> f64 {
    let [low, high] = surface.cage().bounds();
    let square = |k: usize| f64::from(high[k] - low[k]).powi(2);
    (0..3).map(square).sum::<f64>().sqrt()
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f64 {
    (0..3).map(|k| f64::from(a[k]) * f64::from(b[k])).sum()
}

/// Most that points differ by, relative to the surface, and normals in degrees.
pub(crate) const DISTANCE: f64 = 2e-6;
pub(crate) const ANGLE: f64 = 0.05;

/// Last places of control points that points of narrow faces may be off by: a few roundings, and what derivatives near a corner where sides
/// nearly meet make of them. On the reference models 26 were seen.
const LAST_PLACES: f64 = 32.0;

/// What rounding does around a quad: the processor splits polygons and rounds their points, the device has those of the cage.
#[derive(Clone, Copy, Default)]
struct Rounding {
    /// How far it turns normals, in radians: the last place of coordinates over the width or the shortest side of the narrowest face at a corner.
    turn: f64,
    /// How much further that turns the normals of a displaced surface: its reach over the same width.
    more: f64,
}

impl Rounding {
    /// Of all quads.
    fn of(surface: &Surface) -> Vec<Self> {
        let mut limit = surface.clone();
        limit.set_displacement(None);
        let t = surface.quads();
        let mut at_corners = vec![Self::default(); t.vertex_count()];
        let corners = |q: usize| t.face_halves(q as u32).map(|h| t.vertex(h) as usize);
        for q in 0..t.face_count() {
            let p = limit.dice(q as u32, 0).points;
            let side = |a: [f32; 3], b: [f32; 3]| std::array::from_fn(|k| b[k] - a[k]);
            let ends: &[[usize; 2]] = match surface.is_triangular() {
                true => &[[0, 1], [1, 3], [3, 0]],
                false => &[[0, 1], [1, 3], [3, 2], [2, 0]],
            };
            let lengths = ends.iter().map(|&[a, b]| side(p[a], p[b]));
            let lengths: Vec<f64> = lengths.map(|s: [f32; 3]| dot(s, s).sqrt()).collect();
            let longest = lengths.iter().copied().fold(0.0, f64::max);
            let shortest = lengths.iter().copied().fold(f64::INFINITY, f64::min);
            let (a, b): ([f32; 3], [f32; 3]) = (side(p[0], p[3]), side(p[1], p[2]));
            let area = (dot(a, a) * dot(b, b) - dot(a, b).powi(2)).max(0.0).sqrt() / 2.0;
            let largest = p.iter().flatten().fold(0.0_f32, |m, c| m.max(c.abs()));
            let width = shortest.min(area / longest);
            let found = Self {
                turn: f64::from(f32::EPSILON) * f64::from(largest) / width,
                more: f64::from(surface.displacement_reach()) / width,
            };
            for v in corners(q) {
                let own = &mut at_corners[v];
                own.turn = own.turn.max(found.turn);
                own.more = own.more.max(found.more);
            }
        }
        let most = |q: usize| {
            corners(q)
                .map(|v| at_corners[v])
                .fold(Self::default(), |a, b| Self {
                    turn: a.turn.max(b.turn),
                    more: a.more.max(b.more),
                })
        };
        (0..t.face_count()).map(most).collect()
    }
}

/// How far a device's points are from the processor's.
#[derive(Default)]
pub(crate) struct Compared {
    /// Largest distance of points, relative to the surface.
    pub(crate) distance: f64,
    /// Angles between normals in degrees.
    pub(crate) angles: Vec<f64>,
    /// Points where the processor has a normal and the device none.
    pub(crate) bare: usize,
    /// Largest difference of a normal's length from 1.
    length: f64,
    pub(crate) points: usize,
    /// Points that are further off than [`DISTANCE`], and normals than [`ANGLE`].
    pub(crate) beyond: [usize; 2],
    /// Those among them that are further off than rounding explains.
    pub(crate) unexplained: [usize; 2],
}

impl Compared {
    pub(crate) fn angle(&self) -> f64 {
        self.angles.iter().copied().fold(0.0, f64::max)
    }

    /// Points are the same to single precision, and normals have length 1 but at as many points as have none.
    fn check(&self, what: &str, bare: RangeInclusive<usize>) {
        assert!(self.points > 0, "{what}");
        assert!(self.distance <= 2e-6, "{what}: {}", self.distance);
        assert!(
            bare.contains(&self.bare),
            "{what}: {} have no normal",
            self.bare
        );
        assert!(self.length <= 1e-5, "{what}: off by {}", self.length);
        assert_eq!(self.angles.len() + self.bare, self.points, "{what}");
    }
}

pub(crate) fn compare(surface: &Surface, blocks: &[ReadBlock], level: u32) -> Compared {
    let quad_level = level - u32::from(surface.is_split());
    compare_with(surface, blocks, |q| surface.dice(q, quad_level))
}

/// The same with quads that are to be found.
fn compare_with(
    surface: &Surface,
    blocks: &[ReadBlock],
    of: impl Fn(u32) -> DicedQuad,
) -> Compared {
    let mut out = Compared::default();
    let size = size(surface);
    let roundings = Rounding::of(surface);
    let reach = f64::from(surface.displacement_reach()) / size;
    for block in blocks {
        let want = of(block.quad);
        let rounding = roundings[block.quad as usize];
        for (k, got) in block.points.iter().enumerate() {
            let (i, j) = (k % block.side, k / block.side);
            let at = (block.start[1] as usize + j) * want.side + block.start[0] as usize + i;
            let p = want.points[at];
            let off = (0..3)
                .map(|c| f64::from(got[c] - p[c]).powi(2))
                .sum::<f64>();
            let off = off.sqrt() / size;
            out.distance = out.distance.max(off);
            out.points += 1;
            if off > DISTANCE {
                out.beyond[0] += 1;
                let explained = LAST_PLACES * reach * rounding.turn;
                out.unexplained[0] += usize::from(off > DISTANCE + explained);
            }
            let (n, m) = ([got[3], got[4], got[5]], want.normals[at]);
            // Where a surface has no normal, the processor says something defined, the device nothing.
            if n == [0.0; 3] {
                out.bare += 1;
            } else {
                out.length = out.length.max((dot(n, n).sqrt() - 1.0).abs());
                let cross: [f64; 3] = std::array::from_fn(|c| {
                    let (a, b) = ((c + 1) % 3, (c + 2) % 3);
                    f64::from(n[a]) * f64::from(m[b]) - f64::from(n[b]) * f64::from(m[a])
                });
                let sine = cross.iter().map(|c| c * c).sum::<f64>().sqrt();
                let angle = sine.atan2(dot(n, m)).to_degrees();
                out.angles.push(angle);
                if angle > ANGLE {
                    out.beyond[1] += 1;
                    let turn = LAST_PLACES * rounding.turn * (1.0 + rounding.more);
                    let explained = turn.to_degrees();
                    out.unexplained[1] += usize::from(angle > ANGLE + explained);
                }
            }
        }
    }
    out
}

/// Corners of bilinear faces where sides run on straight: there the surface has no normal.
pub(crate) fn straight_corners(surface: &Surface) -> usize {
    if surface.scheme() != Scheme::Bilinear {
        return 0;
    }
    let t = surface.topology();
    let points = surface.cage().points();
    let is_straight = |h: &u32| {
        let at = |h: u32| points[t.vertex(h) as usize];
        let [a, o, b] = [t.prev(*h), *h, t.next(*h)].map(at);
        let side = |p: [f32; 3]| std::array::from_fn(|k| p[k] - o[k]);
        let [a, b]: [[f32; 3]; 2] = [side(a), side(b)];
        dot(a, b) < -(1.0 - 1e-10) * (dot(a, a) * dot(b, b)).sqrt()
    };
    (0..t.half_count() as u32).filter(is_straight).count()
}

/// The comparison notices a point that is elsewhere, a normal that is missing and one that is turned.
fn check_comparison(surface: &Surface, blocks: &[ReadBlock], level: u32) {
    let changed = |change: fn(&mut [f32; 6])| {
        let mut blocks = blocks.to_vec();
        change(&mut blocks[0].points[0]);
        compare(surface, &blocks, level)
    };
    let moved = changed(|p| p[0] += 0.01);
    assert!(moved.distance > 1e-4, "{}", moved.distance);
    assert_eq!(changed(|p| p[3..].fill(0.0)).bare, 1);
    assert!(changed(|p| p[3..].iter_mut().for_each(|c| *c = -*c)).angle() > 179.0);
    assert!(changed(|p| p[3..].iter_mut().for_each(|c| *c *= 1.1)).length > 0.09);
}

/// What is compared: asset, scheme and levels.
fn cases() -> Vec<(&'static str, Scheme, &'static [u32])> {
    use Scheme::{Bilinear, Butterfly, CatmullClark, Kobbelt, Loop};
    vec![
        ("cube", CatmullClark, &[1, 2, 3, 4, 5, 6]),
        ("fan3", CatmullClark, &[1, 3]),
        ("fan5", CatmullClark, &[1, 4]),
        ("fan24", CatmullClark, &[3]),
        ("corner", CatmullClark, &[2, 4]),
        ("mobius", CatmullClark, &[3]),
        ("octahedron", CatmullClark, &[1, 3, 5]),
        ("part", CatmullClark, &[1, 2, 3, 4]),
        ("part_creased", CatmullClark, &[1, 2, 4]),
        ("part_creased", Bilinear, &[2]),
        ("creature", CatmullClark, &[1, 3, 5]),
        ("octahedron", Loop, &[1, 3, 5]),
        ("tetrahedron", Loop, &[2, 6]),
        ("octahedron", Butterfly, &[1, 3]),
        ("cube", Kobbelt, &[1, 3]),
    ]
}

#[test]
fn points_are_the_processors() {
    let Some(gpu) = gpu("points") else { return };
    let (mut far, mut turned, mut total, mut run) = (0.0_f64, 0.0_f64, 0, 0);
    for (name, scheme, levels) in cases() {
        let options = SurfaceOptions {
            scheme: Some(scheme),
            ..SurfaceOptions::default()
        };
        let scene = asset(name, options);
        let surface = &scene.objects[0].surface;
        for &level in levels {
            let what = format!("{name} {scheme:?} at level {level}");
            let found = blocks(&gpu, &scene, level);
            let got = compare(surface, &found, level);
            let (distance, angle) = (got.distance, got.angle());
            println!(
                "gpu points {what}: {distance:.1e} of the model, {angle:.4} degrees, {} points, {} without a normal",
                got.points, got.bare
            );
            let straight = straight_corners(surface);
            got.check(&what, straight..=straight);
            assert!(angle <= 0.05, "{what}: {angle} degrees");
            if run == 0 {
                check_comparison(surface, &found, level);
            }
            (far, turned) = (far.max(distance), turned.max(angle));
            total += got.points;
            run += 1;
        }
    }
    println!(
        "gpu points: {run} cases, {total} points, off by at most {far:.1e} of the model and {turned:.4} degrees"
    );
}

#[test]
fn quadratic_patches_are_the_processors() {
    let Some(gpu) = gpu("patches") else { return };
    let (mut far, mut turned, mut run) = (0.0_f64, 0.0_f64, 0);
    for (name, scheme) in [
        ("creature", Scheme::CatmullClark),
        ("part_creased", Scheme::CatmullClark),
        ("cube", Scheme::CatmullClark),
        ("octahedron", Scheme::Loop),
    ] {
        let options = SurfaceOptions {
            scheme: Some(scheme),
            patches: PatchKind::Qas,
            ..SurfaceOptions::default()
        };
        let scene = plain(asset(name, options));
        let surface = &scene.objects[0].surface;
        for level in [2, 4] {
            let found = blocks(&gpu, &scene, level);
            let got = compare(surface, &found, level);
            let distance = got.distance;
            // Between opposite normals of a thin part the fitted one vanishes, and has no direction.
            let most = got.points / 5000;
            let far_off = got.angles.iter().filter(|&&a| a > 0.05).count();
            assert!(far_off <= most, "{name}: {far_off} of {}", got.points);
            let within = got.angles.iter().copied().filter(|&a| a <= 0.05);
            let angle = within.fold(0.0, f64::max);
            println!(
                "gpu patches {name} {level}: {distance:.1e} of the model, {angle:.4} degrees but at {far_off}, {} points, {} without a normal",
                got.points, got.bare
            );
            got.check(&format!("{name} at level {level}"), 0..=most);
            if scheme == Scheme::CatmullClark {
                assert_shared(surface, &found, &format!("{name} at level {level}"));
            }
            (far, turned) = (far.max(distance), turned.max(angle));
            run += 1;
        }
    }
    println!(
        "gpu patches: {run} cases, off by at most {far:.1e} of the model and {turned:.4} degrees"
    );
}

#[test]
fn pn_triangles_are_the_processors() {
    let Some(gpu) = gpu("PN triangles") else {
        return;
    };
    let (mut far, mut turned, mut run) = (0.0_f64, 0.0_f64, 0);
    for (name, scheme) in [
        ("creature", Scheme::CatmullClark),
        ("part", Scheme::CatmullClark),
        ("part_creased", Scheme::CatmullClark),
        ("cube", Scheme::CatmullClark),
        ("octahedron", Scheme::Loop),
    ] {
        let options = SurfaceOptions {
            scheme: Some(scheme),
            patches: PatchKind::Pn,
            ..SurfaceOptions::default()
        };
        let mut scene = plain(asset(name, options));
        let vertices = scene.objects[0].surface.cage().points().len();
        for (level, tension) in [(1, 1.0), (4, 0.5)] {
            let surface = &mut scene.objects[0].surface;
            surface.set_tension(&vec![tension; vertices]).unwrap();
            let surface = &scene.objects[0].surface;
            let found = blocks(&gpu, &scene, level);
            let got = compare(surface, &found, level);
            let (distance, angle) = (got.distance, got.angle());
            println!(
                "gpu PN triangles {name} {level}: {distance:.1e} of the model, {angle:.4} degrees, {} points",
                got.points
            );
            got.check(&format!("{name} at level {level}"), 0..=0);
            assert!(angle <= 0.05, "{name} at level {level}: {angle} degrees");
            if scheme == Scheme::CatmullClark && level < 6 {
                assert_shared(surface, &found, &format!("{name} at level {level}"));
            }
            (far, turned) = (far.max(distance), turned.max(angle));
            run += 1;
        }
        // Points move, and the triangles with them.
        let camera = Camera::default();
        let renderer = uniform(32, 32, 2);
        let mut ready = GpuScene::new(&gpu, &renderer, &scene, &camera).unwrap();
        let still = ready.draw().unwrap();
        let surface = &mut scene.objects[0].surface;
        let moved: Vec<[f32; 3]> = (surface.cage().points().iter())
            .map(|p| [p[0] + 0.1 * p[1], p[1] * 0.9, p[2] - 0.05])
            .collect();
        surface.update_points(&moved).unwrap();
        ready.move_points(&moved).unwrap();
        let drawn = ready.draw().unwrap();
        assert!(drawn.stats.bytes_up > still.stats.bytes_up + 12 * moved.len() as u64);
        let got = compare(&scene.objects[0].surface, &ready.read_blocks().unwrap(), 2);
        got.check(&format!("{name} moved"), 0..=0);
        assert!(got.angle() <= 0.05, "{name} moved: {} degrees", got.angle());
        run += 1;
    }
    println!(
        "gpu PN triangles: {run} cases, off by at most {far:.1e} of the model and {turned:.4} degrees"
    );
}

#[test]
fn displaced_points_are_the_processors() {
    let Some(gpu) = gpu("displaced points") else {
        return;
    };
    // Small chunks: sides between chunks are evaluated in both.
    let small = DeviceOptions {
        max_binding: 4_000_000,
        ..DeviceOptions::default()
    };
    let Some(chunked) = gpu_with("displaced points", &small) else {
        return;
    };
    use Scheme::{Bilinear, CatmullClark, Loop};
    let (mut far, mut turned, mut run) = (0.0_f64, 0.0_f64, 0);
    for (name, scheme, by, level) in [
        ("creature", CatmullClark, "map", 4),
        ("creature", CatmullClark, "noise", 3),
        ("creature", CatmullClark, "ridges", 3),
        ("part", CatmullClark, "noise", 3),
        ("part", CatmullClark, "ripples", 2),
        ("part_creased", CatmullClark, "noise", 3),
        ("part_creased", CatmullClark, "moving", 3),
        ("part_creased", Bilinear, "noise", 2),
        ("mobius", CatmullClark, "noise", 3),
        ("fan5", CatmullClark, "noise", 3),
        ("octahedron", Loop, "noise", 4),
        ("tetrahedron", Loop, "moving", 3),
    ] {
        let options = SurfaceOptions {
            scheme: Some(scheme),
            ..SurfaceOptions::default()
        };
        let mut scene = plain(asset(name, options));
        let surface = &mut scene.objects[0].surface;
        surface.set_displacement(Some(crate::displaced::by(by)));
        let surface = &scene.objects[0].surface;
        for gpu in [&gpu, &chunked] {
            let found = blocks(gpu, &scene, level);
            let got = compare(surface, &found, level);
            let (distance, angle) = (got.distance, got.angle());
            let far_off = got.angles.iter().filter(|&&a| a > 0.05).count();
            println!(
                "gpu displaced points {name} {scheme:?} {by} {level}: {distance:.1e} of the model, {angle:.4} degrees, {far_off} beyond 0.05, {} points, {} without a normal",
                got.points, got.bare
            );
            let straight = straight_corners(surface);
            assert!(got.bare <= straight, "{name} {by}: {}", got.bare);
            // Points move along normals, which one in 100,000 may have turned by a hundredth of a degree.
            let turned_off = got.beyond[0];
            assert!(distance <= 2.0 * DISTANCE, "{name} {by}: {distance}");
            assert!(
                turned_off <= got.points / 100_000,
                "{name} {by}: {turned_off}"
            );
            // Where texels meet; bilinear faces have corners without an angle.
            let odd = straight + got.points / 20_000;
            assert!(far_off <= odd, "{name} {by}: {far_off} of {odd}");
            if scheme != Loop {
                assert_shared(surface, &found, &format!("{name} at level {level}"));
            }
            (far, turned) = (far.max(distance), turned.max(angle));
            run += 1;
        }
    }
    println!(
        "gpu displaced points: {run} cases, off by at most {far:.1e} of the model and {turned:.4} degrees"
    );
}

#[test]
fn control_points_are_the_processors() {
    let Some(gpu) = gpu("control points") else {
        return;
    };
    let mut run = 0;
    for (name, scheme) in [
        ("creature", Scheme::CatmullClark),
        ("part_creased", Scheme::CatmullClark),
        ("corner", Scheme::CatmullClark),
        ("octahedron", Scheme::Loop),
    ] {
        let scene = plain(asset(
            name,
            SurfaceOptions {
                scheme: Some(scheme),
                ..SurfaceOptions::default()
            },
        ));
        let surface = &scene.objects[0].surface;
        for level in [1, 3] {
            let mut renderer = uniform(32, 32, level);
            renderer.drawing = Drawing::Refined;
            let found = read(&gpu, &renderer, &scene);
            let quads: Vec<_> = surface
                .refine_quads(level - u32::from(surface.is_split()))
                .collect();
            let got = compare_with(surface, &found, |q| quads[q as usize].clone());
            let (distance, angle) = (got.distance, got.angle());
            println!(
                "gpu control points {name} {level}: {distance:.1e} of the model, {angle:.4} degrees"
            );
            got.check(&format!("{name} at level {level}"), 0..=0);
            assert!(angle <= 0.05, "{name} at level {level}: {angle} degrees");
            run += 1;
        }
    }
    println!("gpu control points: {run} cases");
}

#[test]
fn reference_models_have_the_processors_points() {
    let Some(shared) = crate::common::shared() else {
        println!("gpu reference points: not run, EARMARK_SHARED is not set");
        return;
    };
    let Some(gpu) = gpu("reference points") else {
        return;
    };
    let mut run = 0;
    for model in ["Bigguy", "Monsterfrog", "spot", "suzanne", "ArmorGuy"] {
        let scene = crate::common::load(&shared.join("models").join(format!("{model}.obj")));
        let surface = &scene.objects[0].surface;
        let levels: &[u32] = if model == "ArmorGuy" { &[1] } else { &[1, 3] };
        for &level in levels {
            let got = compare(surface, &blocks(&gpu, &scene, level), level);
            let (distance, angle) = (got.distance, got.angle());
            println!(
                "gpu points {model} {level}: {distance:.1e} of the model, {angle:.4} degrees, {} points, {} without a normal",
                got.points, got.bare
            );
            // Models may have some where derivatives happen to be parallel.
            got.check(&format!("{model} at level {level}"), 0..=4);
            assert!(angle <= 0.05, "{model} at level {level}: {angle} degrees");
            run += 1;
        }
    }
    println!("gpu reference points: {run} cases");
}

/// Points and normals along side `c` of a face's only block, from its first corner on; of points alone the first three.
fn side(block: &ReadBlock, c: usize, numbers: usize) -> Vec<Vec<u32>> {
    let n = block.side - 1;
    (0..=n)
        .map(|k| {
            let (i, j) = [(k, 0), (n, k), (n - k, n), (0, n - k)][c];
            let p = block.points[j * block.side + i];
            p[..numbers].iter().map(|x| x.to_bits()).collect()
        })
        .collect()
}

/// Points of shared sides that have other bits in the second face, or other normals unless those are each face's own, and how many were
/// compared.
fn differing(surface: &Surface, blocks: &[ReadBlock]) -> (usize, usize) {
    let t = surface.quads();
    let (mut differ, mut compared) = (0, 0);
    // Normals from differences are each face's own, too.
    let interpolates = [Scheme::Kobbelt, Scheme::Butterfly].contains(&surface.scheme());
    let is_faceted = surface.scheme() == Scheme::Bilinear
        || surface.patch_kind() == PatchKind::Pn
        || interpolates && surface.displacement().is_some();
    let numbers = if is_faceted { 3 } else { 6 };
    let of = |quad: u32| blocks.iter().find(|b| b.quad == quad);
    for h in 0..t.half_count() as u32 {
        let twin = t.twin(h);
        if twin == u32::MAX || twin < h {
            continue;
        }
        let (Some(a), Some(b)) = (of(h / 4), of(twin / 4)) else {
            continue;
        };
        let of = |block: &ReadBlock, h: u32| side(block, h as usize % 4, numbers);
        let (a, mut b) = (of(a, h), of(b, twin));
        b.reverse();
        compared += a.len();
        differ += a.iter().zip(&b).filter(|(a, b)| a != b).count();
    }
    assert!(compared > 0, "no points are shared");
    (differ, compared)
}

/// Points that faces share have the same bits; returns how many there are.
pub(crate) fn assert_shared(surface: &Surface, blocks: &[ReadBlock], what: &str) -> usize {
    let (differ, compared) = differing(surface, blocks);
    assert_eq!(differ, 0, "{what}: {differ} of {compared}");
    compared
}

#[test]
fn shared_points_have_the_same_bits() {
    let Some(gpu) = gpu("shared points") else {
        return;
    };
    // Small chunks: sides between chunks are evaluated in both.
    let small = DeviceOptions {
        max_binding: 1_500_000,
        ..DeviceOptions::default()
    };
    let Some(chunked) = gpu_with("shared points", &small) else {
        return;
    };
    let (mut total, mut run) = (0, 0);
    for name in ["cube", "fan5", "creature", "part", "part_creased", "torus"] {
        let scene = plain(asset(name, SurfaceOptions::default()));
        for gpu in [&gpu, &chunked] {
            for level in [2, 4] {
                let found = blocks(gpu, &scene, level);
                let what = format!("{name} at level {level}");
                total += assert_shared(&scene.objects[0].surface, &found, &what);
                run += 1;
            }
        }
    }
    // The test notices a bit, of a point or of a normal.
    let scene = torus(6, 5);
    let whole = blocks(&gpu, &scene, 2);
    for number in [1, 4] {
        let mut found = whole.clone();
        let p = &mut found[3].points[2][number];
        *p = f32::from_bits(p.to_bits() ^ 1);
        assert_eq!(differing(&scene.objects[0].surface, &found).0, 1);
    }
    println!("gpu shared points: {run} cases, 0 of {total} differ");
}
