//! Small meshes with every kind of corner.

use super::Mesh;
use super::plain::{cross, dot};
use crate::scheme::Boundary;
use crate::topology::{ConnectOptions, Fan, FanRule, NONE, Ring, connect};

pub(super) fn triangles(points: Vec<[f32; 3]>, faces: &[[u32; 3]], boundary: Boundary) -> Mesh {
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
pub(super) fn field(n: u32, seed: u32, boundary: Boundary, cut: impl Fn(u32, u32) -> bool) -> Mesh {
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
pub(super) fn creased(mut mesh: Mesh, on: impl Fn([f32; 3], [f32; 3]) -> bool) -> Mesh {
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
pub(super) fn wheel(n: u32) -> Mesh {
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

pub(super) fn torus(n: u32, m: u32) -> Mesh {
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

pub(super) fn octahedron() -> Mesh {
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

pub(super) fn icosahedron() -> Mesh {
    let g = 1.618_034;
    let mut points: Vec<[f32; 3]> = Vec::new();
    for axis in 0..3 {
        for (s, u) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
            let mut p = [0.0; 3];
            p[(axis + 1) % 3] = s;
            p[(axis + 2) % 3] = u;
            points.push(p);
        }
    }
    let near = |a: usize, b: usize| {
        let d: f32 = (0..3).map(|c| (points[a][c] - points[b][c]).powi(2)).sum();
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

pub(super) fn all_meshes() -> Vec<(String, Mesh)> {
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
