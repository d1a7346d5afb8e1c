//! Levels: topology, texture coordinates and sizes.
#![allow(missing_docs)]

mod support;

use earmark::refine::{Options, RefineError, Timings, counts, limit, predicted_bytes, refine};
use earmark::scheme::{Boundary, FaceVaryingRule, Scheme};
use earmark::topology::{ConnectOptions, NONE, Topology, connect};
use support::*;

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
        let c = counts(&level.topology, Scheme::CatmullClark, 1);
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
fn budgets_are_known_ahead() {
    for shape in all_shapes() {
        let base = shape.level(Boundary::EdgeAndCorner);
        let mut level = base.clone();
        for k in 1..=3 {
            level = step(level, 1);
            let c = counts(&base.topology, Scheme::CatmullClark, k);
            assert_eq!(c.vertices, level.points.len() as u128);
            assert_eq!(c.faces, level.topology.face_count() as u128);
            assert_eq!(c.edges, level.topology.edge_count() as u128);
            assert_eq!(c.corners, level.topology.half_count() as u128);
        }
    }
    let level = || cube().level(Boundary::EdgeAndCorner);
    let needed = level().predicted_bytes(Scheme::CatmullClark, 5);
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
    assert_eq!(
        predicted_bytes(&level().topology, Scheme::CatmullClark, u32::MAX),
        u128::MAX
    );
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

/// In children of quads the vertex stands where it stands in the parent, so u and v keep their directions; else it comes first.
#[test]
fn children_keep_their_parameter_directions() {
    for shape in [cube(), gem(), patch()] {
        let base = shape.level(Boundary::EdgeAndCorner);
        let child = step(base.clone(), 1);
        let t = &base.topology;
        for h in 0..t.half_count() as u32 {
            let face = t.face_halves(t.face_of(h));
            let at = if face.len() == 4 { h - face.start } else { 0 };
            assert_eq!(child.topology.vertex(4 * h + at), t.vertex(h));
            let middle = t.vertex_count() as u32 + t.face_of(h);
            assert_eq!(child.topology.vertex(4 * h + (at + 2) % 4), middle);
        }
    }
}
