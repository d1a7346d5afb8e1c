//! A level that was written, read and refined on is the level that the cage itself would have reached.
#![allow(missing_docs, clippy::print_stdout)]

mod support;

use earmark::Cage;
use earmark::mesh::obj;
use earmark::mesh::resolver::NoFiles;
use earmark::mesh::write::{self, MeshTags, PlyFormat, WriteOptions};
use earmark::refine::face_varying::SiblingKind;
use earmark::refine::{Level, Options, Timings, limit, refine};
use earmark::topology::{ConnectOptions, connect};
use support::random_cages::{COUNT, RandomCage, random_cage};
use support::{distance, extent};

/// Level 0 of a cage with the rules that its tags name, and these rules.
fn level_of(cage: &Cage) -> (Level<f32>, Options, MeshTags) {
    let tags = cage.tags();
    let boundary = tags.boundary.unwrap_or_default();
    let connect_options = ConnectOptions {
        boundary,
        creases: &tags.creases,
        corners: &tags.corners,
        holes: &tags.holes,
    };
    let corners = cage.corner_vertices().to_vec();
    let (topology, warnings) = connect(
        cage.points().len(),
        cage.face_offsets(),
        corners,
        &connect_options,
    );
    assert!(warnings.is_empty(), "{warnings:?}");
    let options = Options {
        creases: tags.crease_method.unwrap_or_default(),
        triangles: tags.triangles.unwrap_or_default(),
        ..Options::default()
    };
    let rule = tags.face_varying.unwrap_or_default();
    let level = Level::of_cage(cage, topology, options.scheme, rule).unwrap();
    let tags = MeshTags {
        boundary,
        creases: options.creases,
        face_varying: rule,
        triangles: options.triangles,
    };
    (level, options, tags)
}

fn read(text: &[u8]) -> Cage {
    let read = obj::read(text, "test.obj", &mut NoFiles, &obj::ReadOptions::default()).unwrap();
    assert!(read.warnings.is_empty(), "{:?}", read.warnings);
    read.cage
}

/// The cage with tags for its rules, and colours.
fn cage_of(random: &RandomCage) -> Cage {
    let shape = &random.shape;
    let mut b = Cage::builder()
        .points(shape.points.iter().map(|p| p.map(|c| c as f32)))
        .faces(
            shape.face_offsets.windows(2).map(|w| w[1] - w[0]),
            shape.corners.iter().copied(),
        )
        .creases(shape.creases.iter().copied())
        .uvs(
            shape.uvs.iter().map(|p| p.map(|c| c as f32)),
            shape.corner_uvs.iter().copied(),
        )
        .colors((0..shape.points.len()).map(|i| [0.2, 0.5, 0.8].map(|c| c / (1 + i % 7) as f32)))
        .boundary(random.case.boundary)
        .face_varying_rule(random.case.fvar)
        .crease_method(random.case.options.creases)
        .triangle_rule(random.case.options.triangles);
    for c in &shape.sharp_vertices {
        b = b.corner(c.vertex, c.sharpness);
    }
    for &f in &shape.holes {
        b = b.hole(f);
    }
    b.build().unwrap()
}

fn wide(p: &[f32; 3]) -> [f64; 3] {
    p.map(f64::from)
}

/// Largest errors of points, texture coordinates and colours over all corners, and whether holes are the same.
fn compare(a: &Level<f32>, b: &Level<f32>) -> [f64; 3] {
    let (t, u) = (&a.topology, &b.topology);
    assert_eq!(t.half_count(), u.half_count());
    let mut worst = [0.0_f64; 3];
    let (auv, buv) = (a.uvs.as_ref().unwrap(), b.uvs.as_ref().unwrap());
    assert_eq!(auv.values.len(), buv.values.len());
    let colors = [a, b].map(|l| l.channels.vertex_named("color").unwrap());
    for h in 0..t.half_count() as u32 {
        let (v, w) = (t.vertex(h) as usize, u.vertex(h) as usize);
        assert_eq!(
            t.is_hole(t.face_of(h)),
            u.is_hole(u.face_of(h)),
            "corner {h}"
        );
        let i = h as usize;
        let (p, q) = (
            auv.values[auv.corners[i] as usize],
            buv.values[buv.corners[i] as usize],
        );
        let [c, d]: [Vec<f32>; 2] = [colors[0].value(v).collect(), colors[1].value(w).collect()];
        let errors = [
            distance(&wide(&a.points[v]), &wide(&b.points[w])),
            distance(&p.map(f64::from), &q.map(f64::from)),
            (0..3)
                .map(|k| f64::from((c[k] - d[k]).abs()))
                .fold(0.0, f64::max),
        ];
        for (w, e) in worst.iter_mut().zip(errors) {
            *w = w.max(e);
        }
    }
    worst
}

fn refined(level: Level<f32>, levels: u32, options: &Options) -> Level<f32> {
    refine(level, options, levels, None, &mut Timings::default()).unwrap()
}

/// How values at seams go on, by their first corner.
fn kinds(level: &Level<f32>) -> Vec<(u32, SiblingKind)> {
    let siblings = level.uvs.as_ref().unwrap().siblings();
    let mut kinds: Vec<_> = siblings.iter().map(|s| (s.first, s.kind)).collect();
    kinds.sort_unstable_by_key(|k| k.0);
    kinds
}

#[test]
fn what_was_written_refines_on() {
    let mut worst = [0.0_f64; 3];
    let (mut holes, mut past) = (0, 0);
    for index in 0..COUNT {
        let random = random_cage(index);
        let cage = cage_of(&random);
        let (base, options, tags) = level_of(&cage);
        for (first, then) in [(0, 2), (1, 2), (2, 1)] {
            let level = refined(base.clone(), first, &options);
            let mut text = Vec::new();
            let how = WriteOptions {
                tags: Some(tags),
                holes: true,
                ..WriteOptions::default()
            };
            write::obj(&mut text, &level, &how).unwrap();
            let back = read(&text);
            let (again, back_options, _) = level_of(&back);
            assert_eq!(back_options, options);
            let written = kinds(&level);
            let direct = refined(level, then, &options);
            let back = refined(again.clone(), then, &options);
            holes += (0..direct.topology.face_count() as u32)
                .filter(|&f| direct.topology.is_hole(f))
                .count();
            let size = extent(&random.shape.points);
            let [p, uv, color] = compare(&direct, &back);
            let what = format!("{} levels {first}+{then}", random.case.name);
            assert!(p / size < 1e-6, "{what}: points {p:.2e}");
            if kinds(&again) != written {
                past += 1;
            } else {
                assert!(uv < 2e-6, "{what}: uvs {uv:.2e}");
                worst[1] = worst[1].max(uv);
            }
            assert!(color < 2e-6, "{what}: colours {color:.2e}");
            worst[0] = worst[0].max(p / size);
            worst[2] = worst[2].max(color);
        }
    }
    println!(
        "{} files, worst: points {:.2e}, uvs {:.2e}, colours {:.2e}",
        3 * COUNT,
        worst[0],
        worst[1],
        worst[2]
    );
    // Of two charts that meet at a semi-sharp vertex, the one that was done first does not know so from the file alone.
    assert!(past <= 2, "{past}");
    assert!(holes > 1000);
}

#[test]
fn limits_are_written_with_limit_texture_coordinates_and_colors() {
    let random = random_cage(22);
    let cage = cage_of(&random);
    let (base, options, tags) = level_of(&cage);
    let level = refined(base, 1, &options);
    let limits = limit(&level, &options);
    let how = WriteOptions {
        limit: Some(&limits),
        tags: Some(tags),
        holes: true,
        ..WriteOptions::default()
    };
    let mut text = Vec::new();
    write::obj(&mut text, &level, &how).unwrap();
    let back = read(&text);
    assert_eq!(back.points(), limits.positions);
    assert_eq!(back.uvs(), limits.uvs);
    assert_eq!(back.normals(), limits.normals);
    assert_ne!(limits.uvs, level.uvs.as_ref().unwrap().values);
    let color = limits.channels.vertex_named("color").unwrap();
    for (v, c) in back.colors().iter().enumerate() {
        for (got, want) in c.iter().zip(color.value(v)) {
            assert!((got - want).abs() < 1e-6, "{got} {want}");
        }
    }

    let mut ascii = Vec::new();
    write::ply(&mut ascii, &level, &how, PlyFormat::Ascii).unwrap();
    let ascii = String::from_utf8(ascii).unwrap();
    let (head, body) = ascii.split_once("end_header\n").unwrap();
    assert!(head.contains(
        "property float nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    ));
    let line: Vec<&str> = body.lines().next().unwrap().split(' ').collect();
    assert_eq!(line.len(), 9);
    // Linear light of a code is that of the vertex to half a step.
    for (code, want) in line[6..].iter().zip(color.value(0)) {
        let code: f64 = code.parse().unwrap();
        let encoded = earmark::film::srgb::from_linear(f64::from(want).clamp(0.0, 1.0)) * 255.0;
        assert!((code - encoded).abs() <= 0.501, "{code} {encoded}");
    }
    let mut binary = Vec::new();
    write::ply(&mut binary, &level, &how, PlyFormat::Binary).unwrap();
    let start = binary
        .windows(11)
        .position(|w| w == b"end_header\n")
        .unwrap()
        + 11;
    let codes: Vec<String> = binary[start + 24..start + 27]
        .iter()
        .map(u8::to_string)
        .collect();
    assert_eq!(codes, line[6..]);
}

/// Faces that are left out are counted out in the tags too.
#[test]
fn triangulated_holes_keep_their_numbers() {
    let random = (0..COUNT)
        .map(random_cage)
        .find(|c| !c.shape.holes.is_empty() && c.shape.faces() > 6)
        .unwrap();
    let cage = cage_of(&random);
    let (level, _, tags) = level_of(&cage);
    let how = WriteOptions {
        tags: Some(tags),
        triangulate: true,
        holes: true,
        ..WriteOptions::default()
    };
    let mut text = Vec::new();
    write::obj(&mut text, &level, &how).unwrap();
    let text = String::from_utf8(text).unwrap();
    // Diagonals of the triangles are no edges of the mesh, but creases still name edges.
    let back = read(text.as_bytes());
    let t = &level.topology;
    let mut wanted = Vec::new();
    let mut number = 0;
    for f in 0..t.face_count() as u32 {
        for _ in 0..t.face_halves(f).len() - 2 {
            if t.is_hole(f) {
                wanted.push(number);
            }
            number += 1;
        }
    }
    assert!(!wanted.is_empty());
    assert_eq!(back.tags().holes, wanted);
}
