//! Diced triangles against plain refinement of whole meshes in f64, on small meshes with every kind of corner.

use super::super::Target;
use super::super::face::{DiceFault, FacePatch, Sides};
use super::fans::{TriangleFans, TriangleMasks, beta};
use super::patch::{TriangleChannel, TrianglePatch};
use crate::records::Grid3;
use crate::scheme::Boundary;
use crate::simd::Level;
use crate::topology::{ConnectOptions, Fan, FanRule, NONE, Ring, Topology, connect};

type Mesh = (Topology, Vec<[f32; 3]>);
type V3 = [f64; 3];

fn triangles(points: Vec<[f32; 3]>, faces: &[[u32; 3]], boundary: Boundary) -> Mesh {
    let offsets: Vec<u32> = (0..=faces.len() as u32).map(|f| 3 * f).collect();
    let options = ConnectOptions {
        boundary,
        ..ConnectOptions::default()
    };
    let (t, _) = connect(points.len(), &offsets, faces.concat(), &options);
    (t, points)
}

/// Small random numbers, −1 to 1.
struct Dice(u32);

impl Dice {
    fn roll(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / 8_388_608.0 - 1.0
    }
}

/// A random heightfield of n×n squares cut along random diagonals, without those for which `cut` says so.
fn field(n: u32, seed: u32, boundary: Boundary, cut: impl Fn(u32, u32) -> bool) -> Mesh {
    let mut dice = Dice(seed);
    let w = n + 1;
    let points = (0..w * w)
        .map(|k| {
            [
                (k % w) as f32 + 0.2 * dice.roll(),
                (k / w) as f32 + 0.2 * dice.roll(),
                0.5 * dice.roll(),
            ]
        })
        .collect();
    let mut faces = Vec::new();
    for k in (0..n * n).filter(|k| !cut(k % n, k / n)) {
        let v = k / n * w + k % n;
        let [a, b, c, d] = [v, v + 1, v + w + 1, v + w];
        // Corners begin anywhere in a face.
        let mut turn = |f: [u32; 3]| {
            let r = (dice.roll() * 1.5 + 1.5) as usize % 3;
            [f[r], f[(r + 1) % 3], f[(r + 2) % 3]]
        };
        let both = [
            turn([a, b, c]),
            turn([a, c, d]),
            turn([a, b, d]),
            turn([b, c, d]),
        ];
        let first = if dice.roll() < 0.3 { 2 } else { 0 };
        faces.extend([both[first], both[first + 1]]);
    }
    triangles(points, &faces, boundary)
}

/// Makes edges between vertices for which `on` says so two boundaries, as infinitely sharp creases are.
fn creased(mut mesh: Mesh, on: impl Fn([f32; 3], [f32; 3]) -> bool) -> Mesh {
    let (t, points) = &mut mesh;
    for h in 0..t.half_count() as u32 {
        let at = |g: u32| points[t.vertex(g) as usize];
        if t.twin(h) != NONE && on(at(h), at(t.next(h))) {
            let g = t.twin(h);
            t.twins[h as usize] = NONE;
            t.twins[g as usize] = NONE;
        }
    }
    let old = t.fans.clone();
    let mut fans = vec![NONE; t.half_count()];
    t.fans.truncate(t.vertex_count);
    t.extra_fan_vertices.clear();
    let mut taken = vec![false; t.vertex_count];
    for h in 0..t.half_count() as u32 {
        if fans[h as usize] != NONE {
            continue;
        }
        let v = t.vertex(h);
        let mut first = h;
        let mut closed = false;
        while t.rotate_back(first) != NONE {
            first = t.rotate_back(first);
            if first == h {
                closed = true;
                break;
            }
        }
        let ring: Vec<u32> = Ring::from_half(t, first).collect();
        let whole = old[t.fan(h) as usize];
        let fan = Fan {
            first: if closed {
                *ring.iter().min().unwrap()
            } else {
                first
            },
            faces: ring.len() as u32,
            closed,
            rule: match (whole.faces == ring.len() as u32, whole.rule) {
                (true, rule) => rule,
                (false, FanRule::Smooth) => FanRule::Crease,
                (false, _) => FanRule::Corner,
            },
        };
        let id = if taken[v as usize] {
            t.fans.push(fan);
            t.extra_fan_vertices.push(v);
            t.fans.len() as u32 - 1
        } else {
            taken[v as usize] = true;
            t.fans[v as usize] = fan;
            v
        };
        ring.iter().for_each(|&g| fans[g as usize] = id);
    }
    t.corner_fans = fans;
    mesh
}

/// A vertex of valence n with two rings around it.
fn wheel(n: u32) -> Mesh {
    let mut points = vec![[0.0, 0.0, 0.3]];
    for ring in 1..=2 {
        for i in 0..n {
            let a = 2.0 * std::f32::consts::PI * (i as f32 + 0.5 * ring as f32) / n as f32;
            let r = [1.0, 2.6][ring as usize - 1];
            points.push([r * a.cos(), r * a.sin(), 0.2 * (3.0 * a).sin() * r]);
        }
    }
    let at = |ring: u32, i: u32| 1 + (ring - 1) * n + i % n;
    let mut faces = Vec::new();
    for i in 0..n {
        faces.push([0, at(1, i), at(1, i + 1)]);
        faces.push([at(1, i), at(2, i), at(1, i + 1)]);
        faces.push([at(2, i), at(2, i + 1), at(1, i + 1)]);
    }
    triangles(points, &faces, Boundary::EdgeAndCorner)
}

fn torus(n: u32, m: u32) -> Mesh {
    let tau = 2.0 * std::f32::consts::PI;
    let mut points = Vec::new();
    for k in 0..n * m {
        let (a, b) = (
            tau * (k % n) as f32 / n as f32,
            tau * (k / n) as f32 / m as f32,
        );
        let r = 2.0 + 0.7 * b.cos();
        points.push([r * a.cos(), r * a.sin(), 0.7 * b.sin()]);
    }
    let at = |i: u32, j: u32| j % m * n + i % n;
    let faces: Vec<[u32; 3]> = (0..n * m)
        .flat_map(|k| {
            let (i, j) = (k % n, k / n);
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [c, d, a]]
        })
        .collect();
    triangles(points, &faces, Boundary::EdgeAndCorner)
}

fn octahedron() -> Mesh {
    let points = (0..6)
        .map(|i| std::array::from_fn(|c| [0.0, 1.0, -1.0][usize::from(i / 2 == c) * (1 + i % 2)]))
        .collect();
    let mut faces = Vec::new();
    for x in 0..2 {
        for y in 2..4 {
            for z in 4..6 {
                let even = (x + y + z) % 2 == 0;
                faces.push(if even { [x, y, z] } else { [y, x, z] });
            }
        }
    }
    triangles(points, &faces, Boundary::EdgeAndCorner)
}

fn icosahedron() -> Mesh {
    let g = 1.618_034;
    let mut points = Vec::new();
    for axis in 0..3 {
        for (s, u) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
            let mut p = [0.0; 3];
            p[(axis + 1) % 3] = s;
            p[(axis + 2) % 3] = u;
            points.push(p);
        }
    }
    let near = |a: usize, b: usize| {
        let d: f32 = (0..3)
            .map(|c| (points[a][c] - points[b][c] as f32).powi(2))
            .sum();
        d < 4.1
    };
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(a, c) {
                    let [p, q, r] = [a, b, c].map(|k| points[k].map(f64::from));
                    let outside = dot(cross(p, q), r) > 0.0;
                    let (a, b, c) = (a as u32, b as u32, c as u32);
                    faces.push(if outside { [a, b, c] } else { [b, a, c] });
                }
            }
        }
    }
    assert_eq!(faces.len(), 20);
    triangles(points, &faces, Boundary::EdgeAndCorner)
}

fn all_meshes() -> Vec<(String, Mesh)> {
    let mut out = vec![
        ("octahedron".to_owned(), octahedron()),
        ("icosahedron".to_owned(), icosahedron()),
        ("torus".to_owned(), torus(5, 4)),
        (
            "tetrahedron".to_owned(),
            triangles(
                vec![[0.0; 3], [1.0, 0.1, 0.0], [0.2, 1.0, 0.1], [0.3, 0.2, 1.0]],
                &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
                Boundary::EdgeAndCorner,
            ),
        ),
    ];
    for boundary in [Boundary::EdgeAndCorner, Boundary::EdgeOnly] {
        let one = vec![[0.0; 3], [1.0, 0.1, 0.0], [0.2, 1.0, 0.3]];
        out.push((
            format!("one triangle {boundary:?}"),
            triangles(one, &[[0, 1, 2]], boundary),
        ));
        for seed in 0..3 {
            out.push((
                format!("field {seed} {boundary:?}"),
                field(5, seed, boundary, |_, _| false),
            ));
        }
        out.push((
            format!("notched {boundary:?}"),
            field(5, 7, boundary, |x, y| x >= 2 && y == 2),
        ));
        out.push((
            format!("holed {boundary:?}"),
            field(5, 8, boundary, |x, y| x == 2 && y == 2),
        ));
        let straight = |k: usize, at: f32| {
            move |a: [f32; 3], b: [f32; 3]| (a[k] - at).abs() < 0.3 && (b[k] - at).abs() < 0.3
        };
        let sheet = field(6, 9, boundary, |_, _| false);
        out.push((
            format!("creased {boundary:?}"),
            creased(sheet.clone(), straight(0, 3.0)),
        ));
        out.push((
            format!("crossed {boundary:?}"),
            creased(creased(sheet, straight(0, 3.0)), straight(1, 2.0)),
        ));
    }
    for n in [3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 24] {
        out.push((format!("wheel {n}"), wheel(n)));
    }
    out
}

fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn cross(a: V3, b: V3) -> V3 {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
fn mix(terms: &[(f64, V3)]) -> V3 {
    std::array::from_fn(|c| terms.iter().map(|(w, p)| w * p[c]).sum())
}

/// The neighbours of a fan, counter-clockwise.
fn ring(t: &Topology, id: u32) -> Vec<u32> {
    let halves: Vec<u32> = Ring::of_fan(t, id).collect();
    let mut out: Vec<u32> = halves.iter().map(|&h| t.fan(t.next(h))).collect();
    if !t.fans()[id as usize].closed {
        out.push(t.fan(t.prev(*halves.last().unwrap())));
    }
    out
}

/// Points by fan after one step, and the connectivity with a vertex per fan.
fn refine_once(t: &Topology, points: &[V3]) -> (Topology, Vec<V3>) {
    let at = |h: u32| points[t.fan(h) as usize];
    let mut out = Vec::new();
    for (id, fan) in t.fans().iter().enumerate() {
        let v = points[id];
        if fan.first == NONE || fan.rule == FanRule::Corner {
            out.push(v);
            continue;
        }
        let ring: Vec<V3> = ring(t, id as u32)
            .iter()
            .map(|&f| points[f as usize])
            .collect();
        let n = ring.len() as f64;
        out.push(if fan.closed {
            let c = 0.375 + 0.25 * (2.0 * std::f64::consts::PI / n).cos();
            let b = (0.625 - c * c) / n;
            let mut terms = vec![(1.0 - n * b, v)];
            terms.extend(ring.iter().map(|&p| (b, p)));
            mix(&terms)
        } else {
            mix(&[(0.75, v), (0.125, ring[0]), (0.125, *ring.last().unwrap())])
        });
    }
    let halves = t.half_count() as u32;
    let mut edges = vec![NONE; halves as usize];
    let mut middles = Vec::new();
    for h in 0..halves {
        let g = t.twin(h);
        if g != NONE && g < h {
            edges[h as usize] = edges[g as usize];
            continue;
        }
        edges[h as usize] = out.len() as u32;
        middles.push(h);
        let (a, b) = (at(h), at(t.next(h)));
        out.push(if g == NONE {
            mix(&[(0.5, a), (0.5, b)])
        } else {
            let (c, d) = (at(t.prev(h)), at(t.prev(g)));
            mix(&[(0.375, a), (0.375, b), (0.125, c), (0.125, d)])
        });
    }
    let mut s = Topology {
        vertex_count: out.len(),
        twins: vec![NONE; 4 * halves as usize],
        ..Topology::default()
    };
    let child = |h: u32, second: bool| {
        4 * (h - h % 3) + [[0, 3], [4, 7], [8, 2]][h as usize % 3][usize::from(second)]
    };
    for f in 0..halves / 3 {
        let v = [0, 1, 2].map(|c| t.fan(3 * f + c));
        let e = [0, 1, 2].map(|c| edges[(3 * f + c) as usize]);
        s.corner_vertices.extend([
            v[0], e[0], e[2], e[0], v[1], e[1], e[2], e[1], v[2], e[1], e[2], e[0],
        ]);
        for (a, b) in [(1, 10), (5, 11), (6, 9)] {
            s.twins[(12 * f + a) as usize] = 12 * f + b;
            s.twins[(12 * f + b) as usize] = 12 * f + a;
        }
    }
    for h in 0..halves {
        let g = t.twin(h);
        if g != NONE {
            for second in [false, true] {
                s.twins[child(h, second) as usize] = child(g, !second);
            }
        }
    }
    s.face_offsets = (0..=4 * halves / 3).map(|f| 3 * f).collect();
    s.corner_faces = (0..4 * halves).map(|h| h / 3).collect();
    for fan in t.fans() {
        let first = match fan.first {
            NONE => NONE,
            h => child(h, false),
        };
        s.fans.push(Fan { first, ..*fan });
    }
    for h in middles {
        let closed = t.twin(h) != NONE;
        s.fans.push(Fan {
            first: child(h, true),
            faces: if closed { 6 } else { 3 },
            closed,
            rule: if closed {
                FanRule::Smooth
            } else {
                FanRule::Crease
            },
        });
    }
    (s, out)
}

/// Limit point of a fan, and its unit normal where the rules have a tangent plane and we know it by heart.
fn limit(t: &Topology, points: &[V3], id: u32) -> (V3, Option<V3>) {
    let fan = t.fans()[id as usize];
    let v = points[id as usize];
    let e: Vec<V3> = ring(t, id).iter().map(|&f| points[f as usize]).collect();
    let n = e.len() as f64;
    let (a, b) = (e[0], *e.last().unwrap());
    let (point, tangents) = match (fan.rule, fan.closed, fan.faces) {
        (FanRule::Corner, _, k) => {
            let t = (k <= 1).then(|| [mix(&[(1.0, a), (-1.0, v)]), mix(&[(1.0, b), (-1.0, v)])]);
            (v, t)
        }
        (_, true, k) => {
            let w = 1.0 / (n + 0.375 / beta(k));
            let mut terms = vec![(1.0 - n * w, v)];
            terms.extend(e.iter().map(|&p| (w, p)));
            let wave = |f: fn(f64) -> f64| {
                let angle = |i: usize| 2.0 * std::f64::consts::PI * i as f64 / n;
                let terms: Vec<_> = e
                    .iter()
                    .enumerate()
                    .map(|(i, &p)| (f(angle(i)), p))
                    .collect();
                mix(&terms)
            };
            (mix(&terms), Some([wave(f64::cos), wave(f64::sin)]))
        }
        (_, false, k) => {
            let point = mix(&[(2.0 / 3.0, v), (1.0 / 6.0, a), (1.0 / 6.0, b)]);
            let along = mix(&[(1.0, a), (-1.0, b)]);
            let across = match k {
                1 => Some(mix(&[(1.0, a), (1.0, b), (-2.0, v)])),
                2 => Some(mix(&[(1.0, e[1]), (-1.0, v)])),
                3 => Some(mix(&[
                    (1.0, e[1]),
                    (1.0, e[2]),
                    (-1.0, v),
                    (-0.5, a),
                    (-0.5, b),
                ])),
                _ => None,
            };
            (point, across.map(|across| [along, across]))
        }
    };
    let normal = tangents.map(|[a, b]| {
        let n = cross(a, b);
        let l = dot(n, n).sqrt();
        n.map(|c| c / l)
    });
    (point, normal)
}

/// Vertex of the finest mesh at each grid point (row by row) of a triangle of the coarsest; [`NONE`] above the diagonal.
fn grid_vertices(levels: &[Topology], face: u32) -> Vec<u32> {
    let n = 1_i32 << (levels.len() - 1);
    let mut grid = vec![NONE; ((n + 1) * (n + 1)) as usize];
    let mut stack = vec![(0_usize, face, [[0, 0], [n, 0], [n, n]])];
    while let Some((depth, f, p)) = stack.pop() {
        if depth + 1 == levels.len() {
            for c in 0..3 {
                let v = levels[depth].fan(3 * f + c as u32);
                grid[(p[c][1] * (n + 1) + p[c][0]) as usize] = v;
            }
            continue;
        }
        let mid = |a: [i32; 2], b: [i32; 2]| [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
        let e = [0, 1, 2].map(|c| mid(p[c], p[(c + 1) % 3]));
        let children = [
            [p[0], e[0], e[2]],
            [e[0], p[1], e[1]],
            [e[2], e[1], p[2]],
            [e[1], e[2], e[0]],
        ];
        for (k, child) in children.into_iter().enumerate() {
            stack.push((depth + 1, 4 * f + k as u32, child));
        }
    }
    grid
}

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
    for bv in 0..TrianglePatch::blocks_per_side(level) as usize {
        for bu in bv..TrianglePatch::blocks_per_side(level) as usize {
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
    let (mut worst, mut steepest): ([f64; 2], f64) = ([0.0; 2], 1.0);
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
                    worst = [0, 1].map(|i: usize| worst[i].max(off[i]));
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
                        steepest = steepest.min(cos);
                    }
                }
            }
        }
    }
    eprintln!("worst {worst:?}, cosine {steepest}");
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

/// Nanoseconds per point of dicing the faces of a mesh for which `of` says so, with and without preparation.
fn time(mesh: &Mesh, level: u32, of: impl Fn(u32) -> bool) -> [f64; 2] {
    let fans = fans_of(mesh, Target::Limit, level);
    let channel = TriangleChannel {
        topology: &mesh.0,
        points: &mesh.1,
        fans: &fans,
    };
    let faces: Vec<u32> = (0..mesh.0.face_count() as u32).filter(|&f| of(f)).collect();
    let mut patch = TrianglePatch::default();
    patch.simd = Level::detect();
    let (mut p, mut n) = (Grid3::boxed(), Grid3::boxed());
    let mut out = [f64::MAX; 2];
    for _ in 0..20 {
        for (k, prepare) in [(0, true), (1, false)] {
            let rounds = (2000 / faces.len()).max(1);
            patch.prepare(channel, faces[0], Target::Limit, level, Sides::Normals);
            let start = std::time::Instant::now();
            for _ in 0..rounds {
                for &f in &faces {
                    if prepare {
                        patch.prepare(channel, f, Target::Limit, level, Sides::Normals);
                    }
                    patch.dice(0, 0, &mut p, Some(&mut n));
                    std::hint::black_box((&p, &n));
                }
            }
            let m = (1_usize << level) + 1;
            let points = rounds * faces.len() * m * (m + 1) / 2;
            out[k] = out[k].min(start.elapsed().as_nanos() as f64 / points as f64);
        }
    }
    out
}

#[test]
#[ignore = "prints times"]
fn times() {
    for level in [2, 3, 4, 5] {
        let regular = time(&torus(20, 20), level, |_| true);
        let ico = time(&icosahedron(), level, |_| true);
        let one = time(&wheel(7), level, |f| f % 3 == 0);
        let many = time(&wheel(5000), level, |f| f % 3 == 0);
        println!(
            "level {level}, ns per point with and without preparing: regular {regular:.2?}, three irregular corners {ico:.2?}, \
             one of valence 7 {one:.2?}, of valence 5000 {many:.2?}"
        );
    }
}
