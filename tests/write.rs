//! Written levels read back as what they were.
#![allow(missing_docs)]

mod support;

use earmark::mesh::write::{MeshTags, PlyFormat, WriteOptions, obj, ply};
use earmark::mesh::{Material, NONE};
use earmark::refine::{Level, Options, Timings, limit, refine};
use earmark::scheme::{Boundary, FaceVaryingRule, Scheme};
use support::{Shape, cube, distance, gem, patch};

fn single(shape: &Shape, boundary: Boundary, uvs: bool) -> Level<f32> {
    let points: Vec<[f32; 3]> = shape.points.iter().map(|p| p.map(|c| c as f32)).collect();
    let level = Level::new(shape.topology(boundary), points.clone()).unwrap();
    if !uvs {
        return level;
    }
    let values: Vec<[f32; 2]> = points.iter().map(|p| [p[0], p[2]]).collect();
    level
        .with_uvs(
            &values,
            &shape.corners,
            Scheme::CatmullClark,
            FaceVaryingRule::CornersPlus1,
        )
        .unwrap()
}

fn refined(level: Level<f32>, levels: u32) -> Level<f32> {
    refine(
        level,
        &Options::default(),
        levels,
        None,
        &mut Timings::default(),
    )
    .unwrap()
}

fn text(level: &Level<f32>, options: &WriteOptions<'_>) -> String {
    let mut out = Vec::new();
    obj(&mut out, level, options).unwrap();
    String::from_utf8(out).unwrap()
}

#[test]
fn obj_reads_back_bit_for_bit() {
    for shape in [gem(), patch()] {
        let level = refined(single(&shape, Boundary::EdgeAndCorner, true), 2);
        let back = Shape::read(&text(&level, &WriteOptions::default()));
        let narrow: Vec<[f32; 3]> = back.points.iter().map(|p| p.map(|c| c as f32)).collect();
        assert_eq!(narrow, level.points);
        let corners: Vec<u32> = (0..level.topology.half_count() as u32)
            .map(|h| level.topology.vertex(h))
            .collect();
        assert_eq!(back.corners, corners);
        let uvs = level.uvs.as_ref().unwrap();
        assert_eq!(back.corner_uvs, uvs.corners);
        assert_eq!(back.uvs.len(), uvs.values.len());
    }
}

/// Refining what was written goes on where the level stopped.
#[test]
fn tags_are_carried() {
    for shape in [gem(), patch()] {
        for boundary in [Boundary::EdgeOnly, Boundary::EdgeAndCorner] {
            let level = refined(single(&shape, boundary, false), 1);
            let options = WriteOptions {
                tags: Some(MeshTags {
                    boundary,
                    ..MeshTags::default()
                }),
                ..WriteOptions::default()
            };
            let written = text(&level, &options);
            let back = refined(single(&Shape::read(&written), boundary, false), 2);
            let direct = refined(level, 2);
            // The order of edges, hence of edge points, is another one.
            let widen = |l: &Level<f32>| -> Vec<[f64; 3]> {
                l.points.iter().map(|p| p.map(f64::from)).collect()
            };
            assert!(support::set_distance(&widen(&back), &widen(&direct), 0.1) < 2e-6);
        }
    }
}

#[test]
fn holes_materials_and_missing_texture_coordinates() {
    let mut shape = cube();
    shape.holes = vec![1];
    let mut corners = shape.corners.clone();
    corners[8] = NONE;
    let values = [[0.25, 0.5]; 8];
    let level = single(&shape, Boundary::EdgeAndCorner, false)
        .with_uvs(
            &values,
            &corners,
            Scheme::CatmullClark,
            FaceVaryingRule::All,
        )
        .unwrap();
    let level = refined(level, 1);
    let named = |name: &str| Material {
        name: name.into(),
        ..Material::default()
    };
    let materials = [named("red"), named("blue")];
    let options = WriteOptions {
        materials: Some((&materials, &[0, 1, 0, 0, 1, 0])),
        material_library: Some("m.mtl"),
        ..WriteOptions::default()
    };
    let written = text(&level, &options);
    let lines: Vec<&str> = written.lines().collect();
    assert_eq!(lines[0], "mtllib m.mtl");
    let names: Vec<&str> = lines
        .iter()
        .filter_map(|l| l.strip_prefix("usemtl "))
        .collect();
    assert_eq!(names, ["red", "blue", "red"]);
    let faces: Vec<&&str> = lines.iter().filter(|l| l.starts_with("f ")).collect();
    assert_eq!(faces.len(), 20);
    assert_eq!(faces.iter().filter(|l| !l.contains('/')).count(), 4);
}

#[test]
fn limit_normals_and_triangles() {
    let shape = cube()
        .crease(0, 1, 10.0)
        .crease(1, 3, 10.0)
        .crease(3, 2, 10.0)
        .crease(2, 0, 10.0);
    let level = refined(single(&shape, Boundary::EdgeAndCorner, false), 1);
    let limits = limit(&level, &Options::default());
    assert!(!limits.corner_normals.is_empty());
    let options = WriteOptions {
        limit: Some(&limits),
        triangulate: true,
        origin: [1e6, 0.0, 0.0],
        ..WriteOptions::default()
    };
    let written = text(&level, &options);
    let normals = written.lines().filter(|l| l.starts_with("vn ")).count();
    assert_eq!(normals, limits.normals.len());
    assert!(normals > level.points.len());
    assert_eq!(written.lines().filter(|l| l.starts_with("f ")).count(), 48);
    let back = Shape::read(&written);
    for (p, q) in back.points.iter().zip(&limits.positions) {
        let q = [f64::from(q[0]) + 1e6, f64::from(q[1]), f64::from(q[2])];
        assert!(distance(p, &q) == 0.0);
    }
}

#[test]
fn ply_of_both_formats() {
    let shape = gem();
    let level = refined(single(&shape, Boundary::EdgeAndCorner, true), 1);
    let limits = limit(&level, &Options::default());
    let options = WriteOptions {
        limit: Some(&limits),
        ..WriteOptions::default()
    };
    let mut ascii = Vec::new();
    ply(&mut ascii, &level, &options, PlyFormat::Ascii).unwrap();
    let ascii = String::from_utf8(ascii).unwrap();
    let (head, body) = ascii.split_once("end_header\n").unwrap();
    let (vertices, faces) = (limits.normals.len(), level.topology.face_count());
    assert!(head.starts_with("ply\nformat ascii 1.0\n"));
    assert!(head.contains(&format!("element vertex {vertices}\n")));
    assert!(head.contains(&format!("element face {faces}\n")));
    let lines: Vec<Vec<f32>> = body
        .lines()
        .map(|l| l.split_whitespace().map(|w| w.parse().unwrap()).collect())
        .collect();
    assert_eq!(lines.len(), vertices + faces);
    assert!(lines[..vertices].iter().all(|l| l.len() == 6));
    for (i, line) in lines[..level.points.len()].iter().enumerate() {
        assert_eq!(line[..3], limits.positions[i]);
        assert_eq!(line[3..], limits.normals[i]);
    }
    for (f, line) in lines[vertices..].iter().enumerate() {
        assert_eq!((line.len(), line[0], line[5]), (14, 4.0, 8.0));
        for k in 0..4 {
            // The copy of the vertex that the corner names stands where the corner's vertex stands.
            let v = level.topology.vertex(4 * f as u32 + k as u32) as usize;
            assert_eq!(lines[line[1 + k] as usize][..3], limits.positions[v]);
        }
    }
    let mut binary = Vec::new();
    ply(&mut binary, &level, &options, PlyFormat::Binary).unwrap();
    let end = binary
        .windows(11)
        .position(|w| w == b"end_header\n")
        .unwrap()
        + 11;
    assert_eq!(
        binary.len() - end,
        vertices * 24 + faces * (1 + 16 + 1 + 32)
    );
    let first: [u8; 4] = binary[end..end + 4].try_into().unwrap();
    assert_eq!(f32::from_le_bytes(first), limits.positions[0][0]);
}

#[test]
fn ply_lists_are_short() {
    let points: Vec<[f64; 3]> = (0..300)
        .map(|i| [f64::from(i), f64::from(i * i), 0.0])
        .collect();
    let corners: Vec<u32> = (0..300).collect();
    let level = single(
        &Shape::new(&points, &[&corners]),
        Boundary::EdgeAndCorner,
        false,
    );
    let go = |triangulate| {
        let options = WriteOptions {
            triangulate,
            ..WriteOptions::default()
        };
        ply(&mut Vec::new(), &level, &options, PlyFormat::Binary)
    };
    assert!(go(false).is_err());
    assert!(go(true).is_ok());
}
