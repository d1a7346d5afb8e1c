//! Refinement against what is known without a reference: golden values, eigenvectors, invariances.
#![allow(missing_docs)]

mod support;

use earmark::refine::{
    Level, Options, RefineError, Timings, counts, limit, predicted_bytes, refine,
};
use earmark::scheme::{Boundary, CreaseMethod, FaceVaryingRule, Scheme};
use earmark::topology::{ConnectOptions, NONE, Ring, Topology, connect};
use support::{Noise, Shape, cube, cube_edges, distance, gem, grid, half_star, patch, star};

fn step(level: Level<f64>, levels: u32) -> Level<f64> {
    refined(level, levels, &Options::default())
}

fn refined(level: Level<f64>, levels: u32, options: &Options) -> Level<f64> {
    refine(level, options, levels, None, &mut Timings::default()).unwrap()
}

#[track_caller]
fn assert_close<const N: usize>(a: &[f64; N], b: &[f64; N], tolerance: f64) {
    let d = distance(a, b);
    assert!(d <= tolerance, "{a:?} and {b:?} are {d:.2e} apart");
}

#[track_caller]
fn assert_all_close<const N: usize>(a: &[[f64; N]], b: &[[f64; N]], tolerance: f64) {
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        assert_close(a, b, tolerance);
    }
}

#[test]
fn polynomials_on_a_grid() {
    let inner =
        |p: &[f64; 3], n: f64| (2.5..=n - 2.5).contains(&p[0]) && (2.5..=n - 2.5).contains(&p[1]);
    for (a, b) in [(1, 0), (2, 0), (3, 0), (2, 3), (3, 1), (0, 2), (3, 3)] {
        // After k steps u² carries (1 − 4^−k)/3 on top, u³ that many times u; products multiply.
        let term = |x: f64, power: i32, k: i32| {
            let rest = (1.0 - 4.0_f64.powi(-k)) / 3.0;
            match power {
                0 => 1.0,
                1 => x,
                2 => x * x + rest,
                _ => x.powi(3) + 3.0 * rest * x,
            }
        };
        let mut level = grid(8, |u, v| u.powi(a) * v.powi(b)).level(Boundary::EdgeAndCorner);
        for k in 0..=3 {
            let limits = limit(&level, &Options::default());
            let mut seen = 0;
            for (p, q) in level.points.iter().zip(&limits.positions) {
                if inner(p, 8.0) {
                    let want = term(p[0], a, k) * term(p[1], b, k);
                    assert!(
                        (p[2] - want).abs() < 1e-10,
                        "u^{a} v^{b} level {k} at {p:?}: {want}"
                    );
                    let want = term(p[0], a, 60) * term(p[1], b, 60);
                    assert!(
                        (q[2] - want).abs() < 1e-10,
                        "u^{a} v^{b} limit of level {k} at {q:?}: {want}"
                    );
                    seen += 1;
                }
            }
            assert!(seen >= 9);
            level = step(level, 1);
        }
    }
}

#[test]
fn cube_values() {
    let base = cube().level(Boundary::EdgeAndCorner);
    let limits = limit(&base, &Options::default());
    let level = step(base, 1);
    let corner = level.points[7];
    assert_close(&corner, &[5.0 / 9.0; 3], 1e-15);
    assert_close(&limits.positions[7], &[0.5; 3], 1e-15);
    assert_close(&limits.normals[7], &[1.0 / 3.0_f64.sqrt(); 3], 1e-15);
    // Children of faces follow those of vertices; face 1 is z = 1.
    assert_close(
        &limit(&level, &Options::default()).positions[8 + 1],
        &[0.0, 0.0, 68.0 / 81.0],
        1e-15,
    );
    assert!(
        level.points[14..]
            .iter()
            .any(|p| distance(p, &[0.75, 0.75, 0.0]) < 1e-15)
    );
}

#[test]
fn semi_sharp_cube() {
    let mut shape = cube();
    for [a, b] in cube_edges() {
        shape = shape.crease(a, b, 2.0);
    }
    let base = shape.level(Boundary::EdgeAndCorner);
    for k in 0..4 {
        let level = step(base.clone(), k);
        assert_close(
            &limit(&level, &Options::default()).positions[7],
            &[0.875; 3],
            1e-14,
        );
    }
}

/// The limit of a level and of the next one agree: masks are eigenvectors of the rules. Normals where `plane` says so.
fn limit_is_an_eigenvector(
    shape: &Shape,
    options: &Options,
    vertex: usize,
    plane: bool,
    what: &str,
) {
    let base = shape.level(Boundary::EdgeAndCorner);
    let first = limit(&base, options);
    let level = refined(base.clone(), 1, options);
    let second = limit(&level, options);
    assert_close(&first.positions[vertex], &second.positions[vertex], 1e-13);
    if plane {
        let normals = |level: &Level<f64>, limit: &earmark::refine::Limit<f64>| -> Vec<[f64; 3]> {
            Ring::of_fan(&level.topology, vertex as u32)
                .map(|h| limit.normals[limit.normal_index(&level.topology, h) as usize])
                .collect()
        };
        let (a, b) = (normals(&base, &first), normals(&level, &second));
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(&b) {
            assert!(distance(a, b) < 1e-9, "{what}: normals {a:?} and {b:?}");
        }
    }
}

#[test]
fn limit_masks_are_eigenvectors() {
    let options = Options::default();
    for n in 2..=64 {
        limit_is_an_eigenvector(&star(n, 3), &options, 0, n > 2, &format!("valence {n}"));
        let dart = star(n, 5).crease(0, 1, 10.0);
        limit_is_an_eigenvector(&dart, &options, 0, n > 2, &format!("dart of valence {n}"));
        limit_is_an_eigenvector(
            &half_star(n - 1, 8),
            &options,
            0,
            true,
            &format!("boundary of {} faces", n - 1),
        );
        for across in [2, n / 2, n - 1] {
            if (2..n).contains(&across) {
                let crease = star(n, 9)
                    .crease(0, 1, 10.0)
                    .crease(0, 1 + 2 * across, 10.0);
                limit_is_an_eigenvector(
                    &crease,
                    &options,
                    0,
                    true,
                    &format!("crease, {across} of {n}"),
                );
            }
        }
    }
    // Beyond the tables.
    for n in [65, 200] {
        limit_is_an_eigenvector(&star(n, 3), &options, 0, true, "high valence");
        let dart = star(n, 5).crease(0, 1, 10.0);
        limit_is_an_eigenvector(&dart, &options, 0, false, "dart of high valence");
    }
}

#[test]
fn limit_does_not_depend_on_the_level() {
    let chaikin = Options {
        creases: CreaseMethod::Chaikin,
        ..Options::default()
    };
    let smooth_triangles = Options {
        triangles: earmark::scheme::TriangleRule::Smooth,
        ..Options::default()
    };
    for shape in [gem(), patch()] {
        for options in [Options::default(), chaikin, smooth_triangles] {
            for boundary in [Boundary::EdgeOnly, Boundary::EdgeAndCorner] {
                let mut level = shape.level(boundary);
                let first = limit(&level, &options).positions;
                for k in 1..=5 {
                    level = refined(level, 1, &options);
                    let later = limit(&level, &options).positions;
                    for (v, (a, b)) in first.iter().zip(&later).enumerate() {
                        let d = distance(a, b);
                        assert!(d < 1e-12, "{options:?} vertex {v} level {k}: {d:.2e}");
                    }
                }
            }
        }
    }
}

/// Directions to neighbours at depth are perpendicular to the limit normal, and faces there look the same way.
#[test]
fn normals_are_those_of_deep_refinement() {
    let check = |shape: &Shape, tolerance: f64, what: &str| {
        let base = shape.level(Boundary::EdgeAndCorner);
        let limits = limit(&base, &Options::default());
        let deep = step(base.clone(), 6);
        let t = &deep.topology;
        let x = limits.positions[0];
        let positions = limit(&deep, &Options::default()).positions;
        for (h, base_half) in Ring::of_fan(t, 0).zip(Ring::of_fan(&base.topology, 0)) {
            let normal = limits.normals[limits.normal_index(&base.topology, base_half) as usize];
            let ends = [t.next(h), t.prev(h)].map(|h| {
                let p = positions[t.vertex(h) as usize];
                let d: [f64; 3] = std::array::from_fn(|k| p[k] - x[k]);
                let length = distance(&d, &[0.0; 3]);
                d.map(|c| c / length)
            });
            for d in ends {
                let dot: f64 = (0..3).map(|k| d[k] * normal[k]).sum();
                assert!(dot.abs() < tolerance, "{what}: {dot:.1e}");
            }
            let [a, b] = ends;
            let cross = [
                a[1] * b[2] - a[2] * b[1],
                a[2] * b[0] - a[0] * b[2],
                a[0] * b[1] - a[1] * b[0],
            ];
            let side: f64 = (0..3).map(|k| cross[k] * normal[k]).sum();
            assert!(side > 0.0, "{what}: the normal points to the wrong side");
        }
    };
    for n in 3..=8 {
        check(&star(n, 21), 0.06, &format!("valence {n}"));
    }
    for n in 3..=6 {
        let dart = star(n, 22).crease(0, 1, 10.0);
        check(&dart, 0.1, &format!("dart of valence {n}"));
    }
    for k in 2..=3 {
        check(&half_star(k, 23), 0.06, &format!("boundary of {k} faces"));
    }
    check(
        &star(5, 24).crease(0, 1, 10.0).crease(0, 5, 10.0),
        0.06,
        "crease",
    );
}

/// A shape of everything at once.
fn all_shapes() -> Vec<Shape> {
    let mut semi = gem();
    semi.holes = vec![2];
    vec![gem(), patch(), semi, star(7, 1), half_star(3, 2)]
}

#[test]
fn affine_maps_commute() {
    let map = |p: &[f64; 3]| {
        [
            3.0 * p[0] - p[1] + 0.5 * p[2] + 7.0,
            0.2 * p[0] + p[1] - 11.0,
            p[0] - 0.3 * p[1] - 2.0 * p[2] + 0.1,
        ]
    };
    for shape in all_shapes() {
        let mut moved = shape.clone();
        moved.points = shape.points.iter().map(map).collect();
        for scheme in [Scheme::CatmullClark, Scheme::Bilinear] {
            let options = Options {
                scheme,
                ..Options::default()
            };
            let a = refined(shape.level(Boundary::EdgeAndCorner), 3, &options);
            let b = refined(moved.level(Boundary::EdgeAndCorner), 3, &options);
            let image: Vec<[f64; 3]> = a.points.iter().map(map).collect();
            assert_all_close(&image, &b.points, 1e-12);
            let (a, b) = (limit(&a, &options), limit(&b, &options));
            let image: Vec<[f64; 3]> = a.positions.iter().map(map).collect();
            assert_all_close(&image, &b.positions, 1e-12);
        }
    }
}

/// Renames vertices, reorders faces, rotates corners; with `mirror` also turns every face over.
fn renumbered(shape: &Shape, mirror: bool) -> (Shape, Vec<u32>) {
    let n = shape.points.len();
    let mut noise = Noise(99);
    let mut new_name: Vec<u32> = (0..n as u32).collect();
    for i in (1..n).rev() {
        let j = ((noise.number() + 0.5) * (i + 1) as f64) as usize;
        new_name.swap(i, j);
    }
    let mut points = vec![[0.0; 3]; n];
    for (v, p) in shape.points.iter().enumerate() {
        points[new_name[v] as usize] = *p;
    }
    let mut faces: Vec<Vec<u32>> = shape
        .face_offsets
        .windows(2)
        .map(|w| {
            shape.corners[w[0] as usize..w[1] as usize]
                .iter()
                .map(|&v| new_name[v as usize])
                .collect()
        })
        .collect();
    for (i, f) in faces.iter_mut().enumerate() {
        let turn = i % f.len();
        f.rotate_left(turn);
        if mirror {
            f.reverse();
        }
    }
    faces.reverse();
    let slices: Vec<&[u32]> = faces.iter().map(Vec::as_slice).collect();
    let mut out = Shape::new(&points, &slices);
    for c in &shape.creases {
        let [a, b] = c.vertices.map(|v| new_name[v as usize]);
        out = out.crease(b, a, c.sharpness);
    }
    for c in &shape.sharp_vertices {
        out = out.corner(new_name[c.vertex as usize], c.sharpness);
    }
    (out, new_name)
}

#[test]
fn numbering_and_orientation_do_not_matter() {
    for shape in all_shapes() {
        for mirror in [false, true] {
            for creases in [CreaseMethod::Uniform, CreaseMethod::Chaikin] {
                let options = Options {
                    creases,
                    ..Options::default()
                };
                let (other, new_name) = renumbered(&shape, mirror);
                let a = refined(shape.level(Boundary::EdgeOnly), 2, &options);
                let b = refined(other.level(Boundary::EdgeOnly), 2, &options);
                assert!(support::set_distance(&a.points, &b.points, 1e-3) < 1e-7);
                let (la, lb) = (limit(&a, &options), limit(&b, &options));
                for (v, &w) in new_name.iter().enumerate() {
                    let w = w as usize;
                    assert_close(&a.points[v], &b.points[w], 1e-7);
                    assert_close(&la.positions[v], &lb.positions[w], 1e-7);
                    if la.corner_normals.is_empty() {
                        let flipped = lb.normals[w].map(|c| if mirror { -c } else { c });
                        assert_close(&la.normals[v], &flipped, 1e-6);
                    }
                }
            }
        }
    }
}

#[test]
fn ten_is_infinite() {
    let sharp = |s: f32| {
        let mut shape = gem();
        for c in &mut shape.creases {
            if c.sharpness >= 10.0 {
                c.sharpness = s;
            }
        }
        shape.corner(3, s)
    };
    let points = |s: f32| {
        let level = step(sharp(s).level(Boundary::EdgeAndCorner), 3);
        let limits = limit(&level, &Options::default());
        (level.points, limits.positions, limits.normals)
    };
    let ten = points(10.0);
    assert!(ten == points(25.0), "10 and 25 differ");
    assert!(ten == points(f32::INFINITY), "10 and infinity differ");
    assert!(ten != points(9.0), "9 is infinite too");
}

#[test]
fn zero_is_no_tag_and_sharpness_is_continuous() {
    let ring = |s: f32| {
        let shape = cube()
            .crease(0, 1, s)
            .crease(1, 3, s)
            .crease(3, 2, s)
            .crease(2, 0, s)
            .corner(7, s);
        step(shape.level(Boundary::EdgeAndCorner), 4).points
    };
    assert_all_close(
        &step(cube().level(Boundary::EdgeAndCorner), 4).points,
        &ring(0.0),
        0.0,
    );
    for s in [0.0, 1.0, 2.0, 3.0_f32] {
        let below = (s - 1e-4).max(0.0);
        assert_all_close(&ring(below), &ring(s), 1e-3);
        assert_all_close(&ring(s), &ring(s + 1e-4), 1e-3);
    }
    assert!(distance(&ring(1.0)[0], &ring(2.0)[0]) > 0.05);
}

#[test]
fn steps_add_up() {
    for shape in all_shapes() {
        for creases in [CreaseMethod::Uniform, CreaseMethod::Chaikin] {
            let options = Options {
                creases,
                ..Options::default()
            };
            let base = shape.level(Boundary::EdgeAndCorner);
            let once = refined(base.clone(), 3, &options);
            let twice = refined(refined(base, 1, &options), 2, &options);
            assert_eq!(once.points, twice.points);
            assert_eq!(once.depth(), 3);
        }
    }
}

/// A refined level connected anew from its faces: the same neighbours, so tags and holes are all that is carried on.
#[test]
fn child_topology_is_that_of_its_faces() {
    for shape in all_shapes() {
        let mut level = shape.level(Boundary::EdgeAndCorner);
        for _ in 0..3 {
            level = step(level, 1);
            let t = &level.topology;
            let offsets: Vec<u32> = (0..=t.face_count() as u32).map(|f| 4 * f).collect();
            let corners: Vec<u32> = (0..t.half_count() as u32).map(|h| t.vertex(h)).collect();
            let (fresh, warnings) = connect(
                level.points.len(),
                &offsets,
                corners,
                &ConnectOptions::default(),
            );
            assert!(warnings.is_empty(), "{warnings:?}");
            assert_eq!(fresh.edge_count(), t.edge_count());
            for h in 0..t.half_count() as u32 {
                assert_eq!(fresh.twin(h), t.twin(h));
                assert_eq!(t.edge(h) == t.edge(t.edge_half(t.edge(h))), true);
            }
            for (a, b) in fresh.fans().iter().zip(t.fans()) {
                assert_eq!((a.first, a.faces, a.closed), (b.first, b.faces, b.closed));
            }
            assert_sane(t);
        }
    }
}

fn assert_sane(t: &Topology) {
    for e in 0..t.edge_count() as u32 {
        assert_eq!(t.edge(t.edge_half(e)), e);
    }
    for h in 0..t.half_count() as u32 {
        let twin = t.twin(h);
        assert!(twin == NONE || (t.twin(twin) == h && t.edge(twin) == t.edge(h)));
        assert!(t.edge_half(t.edge(h)) <= h);
    }
}

#[test]
fn non_manifold_meshes_stay_welded() {
    // Three quads at one edge, a bow-tie, an edge between faces of opposite winding.
    let points: Vec<[f64; 3]> = (0..14)
        .map(|i| [f64::from(i % 4), f64::from(i / 4), f64::from(i * i % 5)])
        .collect();
    let shape = Shape::new(
        &points,
        &[
            &[0, 1, 2, 3],
            &[1, 0, 4, 5],
            &[0, 1, 6, 7],
            &[2, 8, 9],
            &[2, 10, 11],
            &[10, 11, 12, 13],
        ],
    );
    let mut level = shape.level(Boundary::EdgeAndCorner);
    for k in 0..3 {
        assert_sane(&level.topology);
        assert_close(&level.points[0], &points[0], 0.0);
        assert_close(&level.points[2], &points[2], 0.0);
        let limits = limit(&level, &Options::default());
        assert_close(&limits.positions[2], &points[2], 0.0);
        let c = counts(&level.topology, 1);
        level = step(level, 1);
        assert_eq!(level.points.len() as u128, c.vertices);
        // One midpoint on the edge that three quads share.
        let middle = [0.5, 0.0, 0.5];
        let found = level
            .points
            .iter()
            .filter(|p| distance(p, &middle) < 1e-12)
            .count();
        assert_eq!(found, 1, "level {}", k + 1);
    }
}

#[test]
fn texture_coordinates_follow_points_where_indices_agree() {
    use FaceVaryingRule as R;
    for (shape, closed) in [(gem(), true), (cube(), true), (star(5, 3), false)] {
        for rule in [
            R::None,
            R::CornersOnly,
            R::CornersPlus1,
            R::CornersPlus2,
            R::Boundaries,
        ] {
            if rule == R::Boundaries && !closed {
                continue;
            }
            let values: Vec<[f64; 2]> = shape.points.iter().map(|p| [p[0], p[2]]).collect();
            let base = shape
                .level(Boundary::EdgeAndCorner)
                .with_uvs(&values, &shape.corners, Scheme::CatmullClark, rule)
                .unwrap();
            let level = step(base, 3);
            let uvs = level.uvs.as_ref().unwrap();
            for h in 0..level.topology.half_count() as u32 {
                let p = level.points[level.topology.vertex(h) as usize];
                let uv = uvs.values[uvs.corners[h as usize] as usize];
                assert_close(&uv, &[p[0], p[2]], 1e-13);
            }
        }
    }
}

#[test]
fn linear_texture_coordinates() {
    let shape = gem();
    let values: Vec<[f64; 2]> = shape.points.iter().map(|p| [p[0], p[2]]).collect();
    let base = shape
        .level(Boundary::EdgeAndCorner)
        .with_uvs(
            &values,
            &shape.corners,
            Scheme::CatmullClark,
            FaceVaryingRule::All,
        )
        .unwrap();
    let bilinear = Options {
        scheme: Scheme::Bilinear,
        ..Options::default()
    };
    let want = refined(shape.level(Boundary::EdgeAndCorner), 2, &bilinear);
    let level = step(base, 2);
    let uvs = level.uvs.as_ref().unwrap();
    for h in 0..level.topology.half_count() as u32 {
        let p = want.points[want.topology.vertex(h) as usize];
        assert_close(
            &uvs.values[uvs.corners[h as usize] as usize],
            &[p[0], p[2]],
            1e-15,
        );
    }
}

#[test]
fn corners_without_texture_coordinates() {
    let shape = cube();
    let values = vec![[0.5, 0.5]; 8];
    let mut corners = shape.corners.clone();
    corners[5] = NONE;
    let base = shape
        .level(Boundary::EdgeAndCorner)
        .with_uvs(
            &values,
            &corners,
            Scheme::CatmullClark,
            FaceVaryingRule::CornersPlus1,
        )
        .unwrap();
    let level = step(base, 2);
    let uvs = level.uvs.as_ref().unwrap();
    for f in 0..level.topology.face_count() as u32 {
        let base = level.base_face(f);
        assert_eq!(base, f / 16);
        assert_eq!(uvs.is_complete(base), base != 1);
        if base == 0 {
            let uv = uvs.values[uvs.corners[4 * f as usize] as usize];
            assert_close(&uv, &[0.5, 0.5], 1e-15);
        }
    }
    let wrong = shape.level(Boundary::EdgeAndCorner).with_uvs(
        &values[..4],
        &shape.corners,
        Scheme::CatmullClark,
        FaceVaryingRule::All,
    );
    assert!(matches!(wrong, Err(RefineError::WrongCount { .. })));
}

#[test]
fn sectors_have_their_own_normals() {
    let mut shape = cube();
    for [a, b] in cube_edges() {
        shape = shape.crease(a, b, 10.0);
    }
    let level = step(shape.level(Boundary::EdgeAndCorner), 2);
    let limits = limit(&level, &Options::default());
    let t = &level.topology;
    for h in 0..t.half_count() as u32 {
        // Faces of the cube stay flat: face by face the normal is an axis.
        let axis = [
            [0.0, 0.0, -1.0],
            [0.0, 0.0, 1.0],
            [0.0, -1.0, 0.0],
            [0.0, 1.0, 0.0],
            [-1.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
        ][level.base_face(t.face_of(h)) as usize];
        let n = limits.normals[limits.normal_index(t, h) as usize];
        assert_close(&n, &axis, 1e-12);
    }
    // 8 corners with three normals each, 36 vertices inside edges with two, 54 inside faces.
    assert_eq!(limits.normals.len(), 8 * 3 + 36 * 2 + 54);
}

#[test]
fn bilinear_keeps_points() {
    let options = Options {
        scheme: Scheme::Bilinear,
        ..Options::default()
    };
    let shape = patch();
    let level = refined(shape.level(Boundary::EdgeOnly), 3, &options);
    assert_all_close(&level.points[..shape.points.len()], &shape.points, 0.0);
    let limits = limit(&level, &options);
    assert_all_close(&limits.positions, &level.points, 0.0);
    let edge: [f64; 3] = std::array::from_fn(|k| 0.5 * (shape.points[0][k] + shape.points[1][k]));
    assert!(level.points.iter().any(|p| distance(p, &edge) < 1e-15));
}

#[test]
fn collapsed_meshes_have_unit_normals() {
    for shape in [gem(), patch(), star(2, 1), half_star(1, 1)] {
        for scale in [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1e-30; 3]] {
            let mut flat = shape.clone();
            for p in &mut flat.points {
                *p = std::array::from_fn(|k| scale[k] * p[k]);
            }
            let level = step(flat.level(Boundary::EdgeAndCorner), 1);
            for n in limit(&level, &Options::default()).normals {
                assert!((distance(&n, &[0.0; 3]) - 1.0).abs() < 1e-12, "{n:?}");
            }
        }
    }
}

#[test]
fn single_precision_follows_double() {
    let shape = gem();
    let topology = shape.topology(Boundary::EdgeAndCorner);
    let points = shape.points.iter().map(|p| p.map(|c| c as f32)).collect();
    let single = Level::<f32>::new(topology, points).unwrap();
    let options = Options::default();
    let single = refine(single, &options, 4, None, &mut Timings::default()).unwrap();
    let double = step(shape.level(Boundary::EdgeAndCorner), 4);
    let widen = |p: &[[f32; 3]]| -> Vec<[f64; 3]> { p.iter().map(|p| p.map(f64::from)).collect() };
    assert_all_close(&widen(&single.points), &double.points, 2e-6);
    let (a, b) = (limit(&single, &options), limit(&double, &options));
    assert_all_close(&widen(&a.positions), &b.positions, 2e-6);
}

#[test]
fn threads_do_not_change_bits() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let level = step(patch().level(Boundary::EdgeAndCorner), 5);
            let limits = limit(&level, &Options::default());
            (
                level.points,
                limits.positions,
                limits.normals,
                limits.corner_normals,
            )
        })
    };
    assert!(run(1) == run(5));
}

#[test]
fn budgets_are_known_ahead() {
    for shape in all_shapes() {
        let base = shape.level(Boundary::EdgeAndCorner);
        let mut level = base.clone();
        for k in 1..=3 {
            level = step(level, 1);
            let c = counts(&base.topology, k);
            assert_eq!(c.vertices, level.points.len() as u128);
            assert_eq!(c.faces, level.topology.face_count() as u128);
            assert_eq!(c.edges, level.topology.edge_count() as u128);
            assert_eq!(c.corners, level.topology.half_count() as u128);
        }
    }
    let level = || cube().level(Boundary::EdgeAndCorner);
    let needed = level().predicted_bytes(5);
    let go = |max: u64| {
        refine(
            level(),
            &Options::default(),
            5,
            Some(max),
            &mut Timings::default(),
        )
    };
    assert!(go(needed as u64).is_ok());
    assert!(matches!(
        go(needed as u64 - 1),
        Err(RefineError::TooMuchMemory { .. })
    ));
    let far = refine(
        level(),
        &Options::default(),
        15,
        None,
        &mut Timings::default(),
    );
    assert!(matches!(far, Err(RefineError::TooManyCorners { .. })));
    assert_eq!(predicted_bytes(&level().topology, u32::MAX), u128::MAX);
}
