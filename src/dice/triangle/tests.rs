//! Diced triangles against plain refinement of whole meshes in f64, on small meshes with every kind of corner.

use super::super::Target;
use super::super::face::{DiceFault, FacePatch, Sides};
use super::fans::{TriangleFans, TriangleMasks};
use super::patch::{TriangleChannel, TrianglePatch};
use crate::records::Grid3;
use crate::scheme::Boundary;
use crate::simd::Level;
use crate::topology::{NONE, Topology};

mod meshes;
mod plain;

use meshes::{all_meshes, field, octahedron, triangles, wheel};
use plain::{cross, dot, grid_vertices, limit, refine_once};

type Mesh = (Topology, Vec<[f32; 3]>);
type V3 = [f64; 3];

type Sample = ([f32; 3], [f32; 3]);

/// All faces, row by row; points above the diagonal are not a number. Checks on the way that blocks agree, that the rest is folded
/// onto the diagonal, and that the hulls hold everything.
fn diced(mesh: &Mesh, target: Target, level: u32, fault: DiceFault) -> Vec<Vec<Sample>> {
    let (t, points) = mesh;
    let fans = fans_of(mesh, target, level);
    let channel = TriangleChannel {
        topology: t,
        points,
        fans: &fans,
    };
    let mut patch = TrianglePatch::default();
    patch.fault = fault;
    patch.simd = Level::detect();
    (0..t.face_count() as u32)
        .map(|f| {
            patch.prepare(channel, f, target, level, Sides::Hull);
            let mut shallow = Vec::new();
            patch.hull(|p| shallow.push(p));
            patch.prepare(channel, f, target, level, Sides::Normals);
            let out = collect(&patch, level);
            let mut hull = Vec::new();
            patch.hull(|p| hull.push(p));
            for range in [box_of(&hull), box_of(&shallow)] {
                for &(p, _) in out.iter().filter(|s| !s.0[0].is_nan()) {
                    assert!(
                        (0..3).all(|c| range[c].contains(&p[c])),
                        "{level} {f} {p:?}"
                    );
                }
            }
            out
        })
        .collect()
}

fn box_of(points: &[[f32; 3]]) -> [std::ops::RangeInclusive<f32>; 3] {
    [0, 1, 2].map(|c| {
        let low = points.iter().fold(f32::MAX, |m, q| m.min(q[c]));
        let high = points.iter().fold(f32::MIN, |m, q| m.max(q[c]));
        low - 1e-5..=high + 1e-5
    })
}

fn fans_of((t, points): &Mesh, target: Target, level: u32) -> TriangleFans {
    let steps = (target == Target::Refined).then_some(level);
    TriangleFans::new(t, &TriangleMasks::new(t), points, steps, true)
}

fn collect(patch: &TrianglePatch, level: u32) -> Vec<Sample> {
    let (mut p, mut n) = (Grid3::boxed(), Grid3::boxed());
    let side = (1_usize << level) + 1;
    let mut out = vec![([f32::NAN; 3], [f32::NAN; 3]); side * side];
    let m = FacePatch::block_size(level).cols - 1;
    for bv in 0..FacePatch::blocks_per_side(level) as usize {
        for bu in bv..FacePatch::blocks_per_side(level) as usize {
            p.x.fill(f32::NAN);
            patch.dice(bu as u32, bv as u32, &mut p, Some(&mut n));
            let mut hull = Vec::new();
            patch.block_hull(bu as u32, bv as u32, |p| hull.push(p));
            let range = box_of(&hull);
            for j in 0..=m {
                for i in 0..=m {
                    let new = (p.get(i, j), n.get(i, j));
                    assert!(
                        new.0.iter().chain(&new.1).all(|c| c.is_finite()),
                        "{level} {i} {j}"
                    );
                    if bu == bv && j > i {
                        assert_eq!(new, (p.get(j, j), n.get(j, j)));
                        continue;
                    }
                    for c in 0..3 {
                        assert!(range[c].contains(&new.0[c]), "hull of {bu} {bv}");
                    }
                    let k = (bv * m + j) * side + bu * m + i;
                    if !out[k].0[0].is_nan() {
                        assert_eq!(out[k], new, "blocks disagree at {i} {j} of {bu} {bv}");
                    }
                    out[k] = new;
                }
            }
        }
    }
    out
}

fn extent(points: &[V3]) -> f64 {
    (0..3)
        .map(|c| {
            let low = points.iter().fold(f64::MAX, |m, p| m.min(p[c]));
            points.iter().fold(f64::MIN, |m, p| m.max(p[c])) - low
        })
        .fold(0.0, f64::max)
}

fn distance(a: [f32; 3], b: V3) -> f64 {
    (0..3).fold(0.0, |d: f64, c| d.max((f64::from(a[c]) - b[c]).abs()))
}

#[test]
fn everything_agrees_with_plain_refinement() {
    for (name, mesh) in all_meshes() {
        let (t, p) = &mesh;
        let mut points: Vec<V3> = (0..t.fans().len() as u32)
            .map(|fan| p[t.fan_vertex(fan) as usize].map(f64::from))
            .collect();
        let size = extent(&points);
        let mut levels = vec![t.clone()];
        for level in 1..=6 {
            let (t, p) = refine_once(levels.last().unwrap(), &points);
            levels.push(t);
            points = p;
            let top = levels.last().unwrap();
            let limits: Vec<_> = (0..points.len() as u32)
                .map(|v| limit(top, &points, v))
                .collect();
            let refined = diced(&mesh, Target::Refined, level, DiceFault::None);
            let limit = diced(&mesh, Target::Limit, level, DiceFault::None);
            for f in 0..mesh.0.face_count() {
                for (k, v) in grid_vertices(&levels, f as u32).into_iter().enumerate() {
                    if v == NONE {
                        continue;
                    }
                    let (point, normal) = limits[v as usize];
                    let off = [
                        distance(refined[f][k].0, points[v as usize]) / size,
                        distance(limit[f][k].0, point) / size,
                    ];
                    assert!(
                        off.iter().all(|&d| d <= 1e-6),
                        "{name} level {level} face {f} point {k}: off by {off:?}"
                    );
                    assert_eq!(
                        refined[f][k].1, limit[f][k].1,
                        "normals are those of the limit"
                    );
                    if let Some(normal) = normal {
                        let sine = cross(limit[f][k].1.map(f64::from), normal);
                        let sine = dot(sine, sine).sqrt();
                        let cos = dot(limit[f][k].1.map(f64::from), normal);
                        assert!(
                            cos > 0.0 && sine < 0.05_f64.to_radians(),
                            "{name} level {level} face {f} point {k}: normal off by {sine}, {cos}"
                        );
                    }
                }
            }
        }
    }
}

/// Sample `k` of side `c` in a grid of n segments.
fn side_place(c: usize, k: usize, n: usize) -> usize {
    let [i, j] = [[k, 0], [n, k], [n - k, n - k]][c];
    j * (n + 1) + i
}

/// Samples on edges of two faces that differ in any bit: points, and normals where the edge is no crease; and the number compared.
fn differing(mesh: &Mesh, target: Target, level: u32, fault: DiceFault) -> [usize; 2] {
    let t = &mesh.0;
    let n = 1_usize << level;
    let got = diced(mesh, target, level, fault);
    let mut out = [0; 2];
    for h in 0..t.half_count() as u32 {
        let opposite =
            |g: &u32| t.vertex(*g) == t.vertex(t.next(h)) && t.vertex(t.next(*g)) == t.vertex(h);
        // A crease is two half-edges between the same vertices, without twins.
        let g = match t.twin(h) {
            NONE => (0..t.half_count() as u32).find(opposite).unwrap_or(NONE),
            g => g,
        };
        if g == NONE || g < h {
            continue;
        }
        for k in 0..=n {
            let a = got[h as usize / 3][side_place(h as usize % 3, k, n)];
            let b = got[g as usize / 3][side_place(g as usize % 3, n - k, n)];
            let bits = |p: [f32; 3]| p.map(f32::to_bits);
            let crease = t.twin(h) == NONE;
            let same = bits(a.0) == bits(b.0) && (crease || bits(a.1) == bits(b.1));
            out[0] += usize::from(!same);
            out[1] += 1;
        }
    }
    out
}

#[test]
fn shared_edges_have_the_same_bits_from_both_sides() {
    let mut compared = 0;
    for (name, mesh) in all_meshes() {
        for target in [Target::Limit, Target::Refined] {
            for level in 0..=6 {
                let [differ, n] = differing(&mesh, target, level, DiceFault::None);
                assert_eq!(differ, 0, "{name} {target:?} level {level}");
                compared += n;
            }
        }
    }
    assert!(compared > 100_000);
}

#[test]
fn without_a_common_direction_edges_differ() {
    let mesh = field(6, 3, Boundary::EdgeAndCorner, |_, _| false);
    let [differ, n] = differing(&mesh, Target::Limit, 5, DiceFault::OwnDirection);
    assert!(differ > n / 20, "{differ} of {n}");
}

/// A patch of the unit equilateral lattice, in lattice coordinates 0 to n both ways, with heights of a polynomial in x and y.
fn lattice(n: u32, height: impl Fn(f64, f64) -> f64) -> Mesh {
    let w = n + 1;
    let mut points = Vec::new();
    for k in 0..w * w {
        let (i, j) = (f64::from(k % w) - 3.0, f64::from(k / w) - 3.0);
        let (x, y) = (i - 0.5 * j, 0.75_f64.sqrt() * j);
        points.push([x as f32, y as f32, height(x, y) as f32]);
    }
    let faces: Vec<[u32; 3]> = (0..n * n)
        .flat_map(|k| {
            let v = k / n * w + k % n;
            [[v, v + 1, v + w + 1], [v + w + 1, v + w, v]]
        })
        .collect();
    triangles(points, &faces, Boundary::EdgeAndCorner)
}

#[test]
fn polynomials_have_their_known_limits() {
    type Height = fn(f64, f64) -> f64;
    let cases: [(Height, Height); 3] = [
        (|x, _| x * x, |x, _| x * x + 0.25),
        (|x, y| x * y, |x, y| x * y),
        (|x, _| x * x * x, |x, _| x * x * x + 0.75 * x),
    ];
    for (cage, want) in cases {
        let mesh = lattice(6, cage);
        let level = 4;
        let got = diced(&mesh, Target::Limit, level, DiceFault::None);
        let refined = diced(&mesh, Target::Refined, level, DiceFault::None);
        let rest = 0.25_f64.powi(level as i32);
        let mut inner = 0;
        for (f, grid) in got.iter().enumerate() {
            let ring = mesh.0.face_halves(f as u32).map(|h| mesh.0.fan(h));
            if !ring.into_iter().all(|v| mesh.0.fans()[v as usize].closed) {
                continue;
            }
            for (sample, refined) in grid.iter().zip(&refined[f]) {
                let [x, y, z] = sample.0.map(f64::from);
                if x.is_nan() {
                    continue;
                }
                inner += 1;
                assert!((z - want(x, y)).abs() < 2e-5, "{x} {y} {z}");
                let left = want(x, y) + (cage(x, y) - want(x, y)) * rest;
                assert!((f64::from(refined.0[2]) - left).abs() < 2e-5, "{x} {y}");
            }
        }
        assert!(inner > 1000);
    }
}

#[test]
fn octahedron_has_its_known_limit() {
    let mesh = octahedron();
    let fans = fans_of(&mesh, Target::Limit, 0);
    for (limit, p) in fans.limits.iter().zip(&mesh.1) {
        for c in 0..3 {
            assert!((limit[c] - p[c] * 24.0 / 55.0).abs() < 1e-7, "{limit:?}");
        }
    }
}

#[test]
fn normals_stay_right_at_the_deepest_level() {
    // Rings of valence 3 shrink by four in every step: at level 10 to a millionth.
    for n in [3, 5, 9] {
        let mut mesh = wheel(n);
        for p in &mut mesh.1 {
            *p = [p[0] + 5.0, p[1] - 3.0, p[2] + 2.0];
        }
        let fans = fans_of(&mesh, Target::Limit, 10);
        let channel = TriangleChannel {
            topology: &mesh.0,
            points: &mesh.1,
            fans: &fans,
        };
        let mut patch = TrianglePatch::default();
        patch.prepare(channel, 0, Target::Limit, 10, Sides::Normals);
        let got = collect(&patch, 10);
        let at = fans.normals[0].map(f64::from);
        let side = 1025;
        for (i, j) in [(1, 0), (1, 1), (2, 1)] {
            let normal = got[j * side + i].1.map(f64::from);
            let sine = cross(at, normal);
            let bend = dot(sine, sine).sqrt().to_degrees();
            assert!(bend < 0.4, "valence {n}: {bend}° at {i} {j}");
        }
    }
}

#[test]
fn pieces_do_not_depend_on_the_valence() {
    // Every piece gives fifteen points of a hull, every corner one.
    let count = |n: u32| {
        let mesh = wheel(n);
        let fans = fans_of(&mesh, Target::Limit, 6);
        let channel = TriangleChannel {
            topology: &mesh.0,
            points: &mesh.1,
            fans: &fans,
        };
        let mut patch = TrianglePatch::default();
        patch.prepare(channel, 0, Target::Limit, 6, Sides::Normals);
        let mut points = 0;
        patch.hull(|_| points += 1);
        points
    };
    assert_eq!(count(7), count(5000));
    assert_eq!((count(7) - 3) % 15, 0);
}
