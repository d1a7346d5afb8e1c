//! The dicing code against plain refinement in f64, on small meshes with every kind of corner.

use super::face::{Channel, FacePatch, Sides};
use super::fan_points::FanPoints;
use super::tangent_masks::TangentMasks;
use super::*;
use crate::records::Grid3;
use crate::scheme::Boundary;
use crate::simd::Level;
use crate::topology::{ConnectOptions, FanRule, NONE, Ring, Topology, connect, split::split};

type Mesh = (Topology, Vec<[f32; 3]>);

fn quads(points: Vec<[f32; 3]>, faces: &[[u32; 4]], boundary: Boundary) -> Mesh {
    let offsets: Vec<u32> = (0..=faces.len() as u32).map(|f| 4 * f).collect();
    let options = ConnectOptions {
        boundary,
        ..ConnectOptions::default()
    };
    let (t, _) = connect(points.len(), &offsets, faces.concat(), &options);
    (t, points)
}

fn cube(boundary: Boundary) -> Mesh {
    let points = (0..8)
        .map(|i| {
            [
                (i & 1) as f32,
                (i >> 1 & 1) as f32 * 1.5,
                (i >> 2 & 1) as f32 * 0.7 + 0.1 * i as f32,
            ]
        })
        .collect();
    quads(
        points,
        &[
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ],
        boundary,
    )
}

/// A wavy sheet of n×n quads without those for which `cut` says so.
fn sheet(n: u32, boundary: Boundary, cut: impl Fn(u32, u32) -> bool) -> Mesh {
    let w = n + 1;
    let points = (0..w * w)
        .map(|k| {
            let (x, y) = ((k % w) as f32, (k / w) as f32);
            [x + 0.1 * y, y, (0.7 * x).sin() + 0.3 * (1.3 * y).cos() * x]
        })
        .collect();
    let faces: Vec<[u32; 4]> = (0..n * n)
        .filter(|k| !cut(k % n, k / n))
        .map(|k| {
            let v = k / n * w + k % n;
            [v, v + 1, v + w + 1, v + w]
        })
        .collect();
    quads(points, &faces, boundary)
}

/// n quads around a vertex, with a ring of quads outside so that the middle is interior on all sides.
fn fan(n: u32) -> Mesh {
    let mut points = vec![[0.0, 0.0, 0.3]];
    for ring in 1..=2 {
        for i in 0..2 * n {
            let a = std::f32::consts::PI * i as f32 / n as f32;
            let r = ring as f32 * if i % 2 == 0 { 1.0 } else { 1.3 };
            points.push([
                r * a.cos(),
                r * a.sin(),
                0.2 * (3.0 * a).sin() * ring as f32,
            ]);
        }
    }
    let at = |ring: u32, i: u32| 1 + (ring - 1) * 2 * n + i % (2 * n);
    let mut faces = Vec::new();
    for i in 0..n {
        faces.push([0, at(1, 2 * i), at(1, 2 * i + 1), at(1, 2 * i + 2)]);
        faces.push([
            at(1, 2 * i),
            at(2, 2 * i),
            at(2, 2 * i + 1),
            at(1, 2 * i + 1),
        ]);
        faces.push([
            at(1, 2 * i + 1),
            at(2, 2 * i + 1),
            at(2, 2 * i + 2),
            at(1, 2 * i + 2),
        ]);
    }
    quads(points, &faces, Boundary::EdgeAndCorner)
}

fn all_meshes() -> Vec<(String, Mesh)> {
    let mut out = Vec::new();
    for boundary in [Boundary::EdgeAndCorner, Boundary::EdgeOnly] {
        out.push((format!("cube {boundary:?}"), cube(boundary)));
        out.push((
            format!("sheet {boundary:?}"),
            sheet(3, boundary, |_, _| false),
        ));
        out.push((
            format!("one quad {boundary:?}"),
            sheet(1, boundary, |_, _| false),
        ));
        out.push((
            format!("notched {boundary:?}"),
            sheet(4, boundary, |x, y| x + 1 >= 3 && y == 2),
        ));
        out.push((
            format!("holed {boundary:?}"),
            sheet(5, boundary, |x, y| x == 2 && y == 2),
        ));
    }
    for n in [2, 3, 5, 6, 8, 24] {
        out.push((format!("fan {n}"), fan(n)));
    }
    out
}

fn refine_once(t: &Topology, points: &[[f64; 3]]) -> (Topology, Vec<[f64; 3]>) {
    let s = split(t);
    let at = |h: u32| points[t.fan(h) as usize];
    let sum = |list: &[[f64; 3]]| {
        list.iter()
            .fold([0.0; 3], |a, p| [a[0] + p[0], a[1] + p[1], a[2] + p[2]])
    };
    let mix = |terms: &[(f64, [f64; 3])]| {
        std::array::from_fn(|c| terms.iter().map(|(w, p)| w * p[c]).sum::<f64>())
    };
    let face = |f: u32| {
        let c: Vec<_> = t.face_halves(f).map(at).collect();
        mix(&[(1.0 / c.len() as f64, sum(&c))])
    };
    let mut out = Vec::new();
    for (id, fan) in t.fans().iter().enumerate() {
        let v = points[id];
        if fan.first == NONE || fan.rule == FanRule::Corner {
            out.push(v);
            continue;
        }
        let ring: Vec<u32> = Ring::of_fan(t, id as u32).collect();
        let n = ring.len() as f64;
        out.push(if fan.closed {
            let e = sum(&ring.iter().map(|&h| at(t.next(h))).collect::<Vec<_>>());
            let f = sum(&ring.iter().map(|&h| face(t.face_of(h))).collect::<Vec<_>>());
            mix(&[((n - 2.0) / n, v), (1.0 / (n * n), e), (1.0 / (n * n), f)])
        } else {
            mix(&[
                (0.75, v),
                (0.125, at(t.next(ring[0]))),
                (0.125, at(t.prev(*ring.last().unwrap()))),
            ])
        });
    }
    out.extend((0..t.face_count() as u32).map(face));
    for &h in &s.edge_vertex_halves {
        let (a, b) = (at(h), at(t.next(h)));
        let twin = t.twin(h);
        out.push(if twin == NONE {
            mix(&[(0.5, a), (0.5, b)])
        } else {
            mix(&[
                (0.25, a),
                (0.25, b),
                (0.25, face(t.face_of(h))),
                (0.25, face(t.face_of(twin))),
            ])
        });
    }
    (s.topology, out)
}

/// Vertex of the level-N mesh at each grid point of every cage quad.
fn grid_vertices(levels: &[Topology], q: u32) -> Vec<u32> {
    let n = 1_i32 << (levels.len() - 1);
    let mut grid = vec![NONE; ((n + 1) * (n + 1)) as usize];
    let mut stack = vec![(0_usize, q, [[0, 0], [n, 0], [n, n], [0, n]])];
    while let Some((depth, quad, p)) = stack.pop() {
        if depth + 1 == levels.len() {
            for c in 0..4 {
                grid[(p[c][1] * (n + 1) + p[c][0]) as usize] =
                    levels[depth].fan(4 * quad + c as u32);
            }
            continue;
        }
        let mid = |a: [i32; 2], b: [i32; 2]| [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
        for c in 0..4 {
            stack.push((
                depth + 1,
                4 * quad + c as u32,
                [
                    p[c],
                    mid(p[c], p[(c + 1) % 4]),
                    mid(p[0], p[2]),
                    mid(p[c], p[(c + 3) % 4]),
                ],
            ));
        }
    }
    grid
}

fn diced(mesh: &Mesh, target: Target, level: u32) -> Vec<Vec<([f32; 3], [f32; 3])>> {
    let (t, points) = mesh;
    let masks = TangentMasks::new(t);
    let fans = FanPoints::new(
        t,
        &masks,
        points,
        (target == Target::Refined).then_some(level),
        true,
    );
    let channel = Channel {
        topology: t,
        points,
        fans: &fans,
        below: None,
        linear: false,
    };
    let mut patch = FacePatch::default();
    let (mut p, mut n) = (Grid3::boxed(), Grid3::boxed());
    let side = (1_usize << level) + 1;
    (0..t.face_count() as u32)
        .map(|q| {
            patch.prepare(channel, q, target, level, Sides::Normals);
            let mut out = vec![([f32::NAN; 3], [f32::NAN; 3]); side * side];
            let size = FacePatch::block_size(level);
            let m = size.cols - 1;
            for bv in 0..FacePatch::blocks_per_side(level) as usize {
                for bu in 0..FacePatch::blocks_per_side(level) as usize {
                    patch.dice(bu as u32, bv as u32, &mut p, Some(&mut n));
                    for j in 0..=m {
                        for i in 0..=m {
                            let k = (bv * m + j) * side + bu * m + i;
                            let new = (p.get(i, j), n.get(i, j));
                            if !out[k].0[0].is_nan() {
                                assert_eq!(out[k], new, "blocks disagree at {i} {j} of {bu} {bv}");
                            }
                            out[k] = new;
                        }
                    }
                }
            }
            out
        })
        .collect()
}

fn close(a: [f32; 3], b: [f64; 3], tolerance: f64) -> bool {
    (0..3).all(|c| (f64::from(a[c]) - b[c]).abs() <= tolerance)
}

#[test]
fn control_points_agree_with_plain_refinement() {
    for (name, mesh) in all_meshes() {
        let mut levels = vec![mesh.0.clone()];
        let mut points: Vec<[f64; 3]> = mesh.1.iter().map(|p| p.map(f64::from)).collect();
        for level in 1..=5 {
            let (t, p) = refine_once(levels.last().unwrap(), &points);
            levels.push(t);
            points = p;
            let got = diced(&mesh, Target::Refined, level);
            for (q, grid) in got.iter().enumerate() {
                for (k, v) in grid_vertices(&levels, q as u32).into_iter().enumerate() {
                    let want = points[v as usize];
                    assert!(
                        close(grid[k].0, want, 2e-6),
                        "{name} level {level} quad {q} point {k}: {:?} is not {want:?}",
                        grid[k].0
                    );
                }
            }
        }
    }
}

#[test]
fn limit_points_and_normals_agree_with_limits_of_refined_vertices() {
    for (name, mesh) in all_meshes() {
        let mut levels = vec![mesh.0.clone()];
        let mut points: Vec<[f64; 3]> = mesh.1.iter().map(|p| p.map(f64::from)).collect();
        for level in 1..=4 {
            let (t, p) = refine_once(levels.last().unwrap(), &points);
            levels.push(t);
            points = p;
            let top = levels.last().unwrap();
            let rounded: Vec<[f32; 3]> = points.iter().map(|p| p.map(|c| c as f32)).collect();
            let want = FanPoints::new(top, &TangentMasks::new(top), &rounded, None, true);
            let got = diced(&mesh, Target::Limit, level);
            for (q, grid) in got.iter().enumerate() {
                for (k, v) in grid_vertices(&levels, q as u32).into_iter().enumerate() {
                    let (p, n) = (
                        want.limits[v as usize].map(f64::from),
                        want.normals[v as usize],
                    );
                    assert!(
                        close(grid[k].0, p, 2e-6),
                        "{name} level {level} quad {q} point {k}: {:?} is not {p:?}",
                        grid[k].0
                    );
                    let cos: f32 = (0..3).map(|c| n[c] * grid[k].1[c]).sum();
                    let valence2 = name == "fan 2";
                    assert!(
                        cos > 0.99999 || valence2,
                        "{name} level {level} quad {q} point {k}: normal {:?} is not {n:?}",
                        grid[k].1
                    );
                }
            }
        }
    }
}

#[test]
fn shared_edges_have_the_same_bits_from_both_sides() {
    let mut compared = 0;
    for (name, mesh) in all_meshes() {
        let t = &mesh.0;
        for target in [Target::Limit, Target::Refined] {
            for level in 0..=8 {
                let n = 1_usize << level;
                let got = diced(&mesh, target, level);
                let place = |c: usize, k: usize| match c {
                    0 => k,
                    1 => k * (n + 1) + n,
                    2 => n * (n + 1) + n - k,
                    _ => (n - k) * (n + 1),
                };
                for h in 0..t.half_count() as u32 {
                    let g = t.twin(h);
                    if g == NONE || g < h {
                        continue;
                    }
                    for k in 0..=n {
                        let a = got[h as usize / 4][place(h as usize % 4, k)];
                        let b = got[g as usize / 4][place(g as usize % 4, n - k)];
                        assert_eq!(
                            a, b,
                            "{name} {target:?} level {level}: half-edges {h} and {g} at {k}"
                        );
                        compared += 1;
                    }
                }
            }
        }
    }
    assert!(compared > 100_000);
}

#[test]
fn points_do_not_depend_on_instructions_or_normals_and_are_all_written() {
    let (mut p, mut n) = (Grid3::boxed(), Grid3::boxed());
    for (name, (t, points)) in all_meshes() {
        let fans = FanPoints::new(&t, &TangentMasks::new(&t), &points, None, true);
        let channel = Channel {
            topology: &t,
            points: &points,
            fans: &fans,
            below: None,
            linear: false,
        };
        for level in 1..=6 {
            let m = FacePatch::block_size(level).cols;
            let blocks = FacePatch::blocks_per_side(level);
            for sides in [Sides::None, Sides::Points, Sides::Normals] {
                let mut want: Option<Vec<[u32; 6]>> = None;
                for simd in Level::available() {
                    let mut patch = FacePatch::default();
                    patch.simd = simd;
                    for with_normals in [true, false] {
                        let mut got = Vec::new();
                        for q in 0..t.face_count() as u32 {
                            patch.prepare(channel, q, Target::Limit, level, sides);
                            for block in 0..blocks * blocks {
                                // What was there before must not matter.
                                for grid in [&mut p, &mut n] {
                                    grid.x.fill(f32::NAN);
                                    grid.y.fill(f32::NAN);
                                    grid.z.fill(f32::NAN);
                                }
                                let normals = with_normals.then_some(&mut *n);
                                patch.dice(block % blocks, block / blocks, &mut p, normals);
                                for k in 0..m * m {
                                    let (a, b) = (p.get(k % m, k / m), n.get(k % m, k / m));
                                    // Zeros have a sign that depends on the direction of an edge.
                                    got.push(
                                        [a[0], a[1], a[2], b[0], b[1], b[2]]
                                            .map(|c| (c + 0.0).to_bits()),
                                    );
                                }
                            }
                        }
                        let want = want.get_or_insert_with(|| got.clone());
                        for (k, (got, want)) in got.iter().zip(want.iter()).enumerate() {
                            let compared = if with_normals { 6 } else { 3 };
                            assert_eq!(
                                got[..compared],
                                want[..compared],
                                "{name} level {level} {sides:?} {} point {k}",
                                simd.name()
                            );
                            assert!(
                                !f32::from_bits(got[0]).is_nan(),
                                "{name} point {k} is missing"
                            );
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn rows_are_those_of_the_whole_block() {
    let (mut p, mut n) = (Grid3::boxed(), Grid3::boxed());
    let (mut some_p, mut some_n) = (Grid3::boxed(), Grid3::boxed());
    let mut compared = 0;
    for (name, (t, points)) in all_meshes() {
        let fans = FanPoints::new(&t, &TangentMasks::new(&t), &points, None, true);
        let channel = Channel {
            topology: &t,
            points: &points,
            fans: &fans,
            below: None,
            linear: false,
        };
        let mut patch = FacePatch::default();
        for level in 1..=6 {
            let size = FacePatch::block_size(level);
            let last = size.rows as u32 - 1;
            let blocks = FacePatch::blocks_per_side(level);
            for q in 0..t.face_count() as u32 {
                patch.prepare(channel, q, Target::Limit, level, Sides::Normals);
                for (k, rows) in [[0, 1], [last / 3, last / 2 + 1], [last - 1, last]]
                    .into_iter()
                    .enumerate()
                {
                    let block = k as u32 % (blocks * blocks);
                    let block = [block % blocks, block / blocks];
                    patch.dice(block[0], block[1], &mut p, Some(&mut n));
                    for grid in [&mut some_p, &mut some_n] {
                        grid.x.fill(f32::NAN);
                        grid.y.fill(f32::NAN);
                        grid.z.fill(f32::NAN);
                    }
                    patch.dice_rows(block, rows, &mut some_p, &mut some_n);
                    for j in rows[0] as usize..=rows[1] as usize {
                        for i in 0..size.cols {
                            let bits = |grid: &Grid3| grid.get(i, j).map(f32::to_bits);
                            let at =
                                format!("{name} level {level} face {q} rows {rows:?}: {i} {j}");
                            assert_eq!(bits(&some_p), bits(&p), "{at}");
                            assert_eq!(bits(&some_n), bits(&n), "{at}");
                            compared += 1;
                        }
                    }
                }
            }
        }
    }
    assert!(compared > 10_000);
}
