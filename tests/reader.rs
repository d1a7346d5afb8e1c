//! The OBJ reader against variants of the same text, against itself under other cuts, against another reader, and against the
//! standard library's numbers; and the files that it and others read and write.

#[path = "common/folder.rs"]
mod folder;
#[path = "reader/paths.rs"]
mod paths;
#[path = "reader/variants.rs"]
mod variants;

use std::io::Write;

use earmark::Cage;
use earmark::mesh::obj::{Read, ReadOptions, UpAxis, line_of_face, read};
use earmark::mesh::{MemoryFiles, NONE, NoFiles, WarningKind};

/// A small generator of numbers (Marsaglia's xorshift), so that every run tests the same.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }
    fn below(&mut self, n: u64) -> u64 {
        (self.next() >> 16) % n
    }
}

fn library() -> MemoryFiles {
    MemoryFiles::new().with(
        "a.mtl",
        "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\nmap_Kd -s 2 2 b c.png\n",
    )
}

fn parse_with(bytes: &[u8], chunk_bytes: usize) -> Read {
    let options = ReadOptions {
        chunk_bytes,
        ..ReadOptions::default()
    };
    match read(bytes, "test.obj", &mut library(), &options) {
        Ok(found) => found,
        Err(e) => panic!("{e}\n{}", String::from_utf8_lossy(bytes)),
    }
}

fn parse(bytes: &[u8]) -> Cage {
    parse_with(bytes, 1 << 20).cage
}

const PLAIN: &str = "mtllib a.mtl
o thing
v 0 0 0
v 1 0 0
v 1 1 0.5
v 0 1 0
v 0.5 2e0 -1
vt 0 0
vt 1 0
vt 1 1
vn 0 0 1
usemtl red
f 1/1/1 2/2/1 3/3/1
usemtl blue
f 1/1 3/3 4
f 4 3 5
t crease 2/1/0 0 2 2.5
t corner 1/1/0 4 10
t hole 1/0/0 1
t interpolateboundary 1/0/0 2
t facevaryinginterpolateboundary 1/0/0 5
t creasemethod 0/0/1 chaikin
t smoothtriangles 0/0/1 smooth
";

/// A file with everything in it, and some oddities.
fn random_file(seed: u64, statements: usize) -> Vec<u8> {
    let mut r = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let mut out = b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n".to_vec();
    let (mut v, mut t, mut n, mut f) = (3, 1, 1, 0);
    for _ in 0..statements {
        match r.below(16) {
            0..4 => {
                v += 1;
                let c = |r: &mut Random| r.below(2_000_000) as f64 / 1e5 - 10.0;
                write!(out, "v {} {} {}", c(&mut r), c(&mut r), c(&mut r)).unwrap();
                if r.below(5) == 0 {
                    write!(out, " 0.5 0.{} 1", r.below(99)).unwrap();
                }
            }
            4 => {
                t += 1;
                write!(out, "vt 0.{} 0.{}", r.below(1000), r.below(1000)).unwrap();
            }
            5 => {
                n += 1;
                write!(out, "vn 0 {} 1", r.below(10)).unwrap();
            }
            6..12 => {
                f += 1;
                write!(out, "f").unwrap();
                let style = r.below(4);
                for _ in 0..2 + r.below(6) {
                    if r.below(12) == 0 {
                        out.extend(b" \\\r\n");
                    }
                    let pick = |r: &mut Random, n: u64| {
                        if r.below(2) == 0 {
                            1 + r.below(n) as i64
                        } else {
                            -1 - r.below(n) as i64
                        }
                    };
                    write!(out, " {}", pick(&mut r, v)).unwrap();
                    match style {
                        1 => write!(out, "/{}", pick(&mut r, t)).unwrap(),
                        2 => write!(out, "//{}", pick(&mut r, n)).unwrap(),
                        3 => write!(out, "/{}/{}", pick(&mut r, t), pick(&mut r, n)).unwrap(),
                        _ => {}
                    }
                }
            }
            12 => write!(
                out,
                "usemtl {}",
                ["red", "blue", "", "green"][r.below(4) as usize]
            )
            .unwrap(),
            13 if f > 0 => match r.below(3) {
                0 => write!(out, "t crease 2/1/0 {} {} 1.5", r.below(v), r.below(v)).unwrap(),
                1 => write!(out, "t corner 1/1/0 {} 2", r.below(v)).unwrap(),
                _ => write!(out, "t hole 1/0/0 {}", r.below(f)).unwrap(),
            },
            14 => out.extend(b"# \\"),
            _ => out.extend(
                [
                    &b"l 1 2"[..],
                    b"p 1",
                    b"nonsense \\\nv v v",
                    b"g x y",
                    b"curv 0 1",
                ][r.below(5) as usize],
            ),
        }
        out.extend([&b"\n"[..], b"\r\n", b"\r", b"\n\n"][r.below(4) as usize]);
    }
    out.extend(b"f 1 2 3\n");
    out
}

#[test]
fn the_plain_file_is_understood() {
    let cage = parse(PLAIN.as_bytes());
    assert_eq!(cage.points().len(), 5);
    assert_eq!(cage.points()[4], [0.5, 2.0, -1.0]);
    assert_eq!(cage.origin(), [0.0; 3]);
    assert_eq!(cage.corner_vertices(), [0, 1, 2, 0, 2, 3, 3, 2, 4]);
    assert_eq!(cage.corner_uvs(), [0, 1, 2, 0, 2, NONE, NONE, NONE, NONE]);
    assert_eq!(&cage.corner_normals()[..4], [0, 0, 0, NONE]);
    let names: Vec<_> = (0..3)
        .map(|f| cage.face_material(f).unwrap().name.as_str())
        .collect();
    assert_eq!(names, ["red", "blue", "blue"]);
    assert_eq!(cage.materials()[1].diffuse, [0.0, 0.0, 1.0]);
    assert_eq!(cage.materials()[1].diffuse_map.as_deref(), Some("b c.png"));
    let tags = cage.tags();
    assert_eq!(tags.creases.len(), 1);
    assert_eq!(
        (tags.creases[0].vertices, tags.creases[0].sharpness),
        ([0, 2], 2.5)
    );
    assert_eq!(
        (tags.corners[0].vertex, tags.corners[0].sharpness),
        (4, 10.0)
    );
    assert_eq!(tags.holes, [1]);
    use earmark::scheme::{Boundary, CreaseMethod, FaceVaryingRule, TriangleRule};
    assert_eq!(tags.boundary, Some(Boundary::EdgeOnly));
    assert_eq!(tags.face_varying, Some(FaceVaryingRule::All));
    assert_eq!(tags.crease_method, Some(CreaseMethod::Chaikin));
    assert_eq!(tags.triangles, Some(TriangleRule::Smooth));
}

#[test]
fn the_options_of_tags_have_their_own_order() {
    use earmark::scheme::{Boundary, FaceVaryingRule};
    let rules = [Boundary::None, Boundary::EdgeAndCorner, Boundary::EdgeOnly];
    for (k, rule) in rules.into_iter().enumerate() {
        let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nt interpolateboundary 1/0/0 {k}\n");
        assert_eq!(parse(text.as_bytes()).tags().boundary, Some(rule));
    }
    let rules = [
        FaceVaryingRule::None,
        FaceVaryingRule::CornersOnly,
        FaceVaryingRule::CornersPlus1,
        FaceVaryingRule::CornersPlus2,
        FaceVaryingRule::Boundaries,
        FaceVaryingRule::All,
    ];
    for (k, rule) in rules.into_iter().enumerate() {
        let text = format!(
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nt facevaryinginterpolateboundary 1/0/0 {k}\n"
        );
        assert_eq!(parse(text.as_bytes()).tags().face_varying, Some(rule));
    }
}

#[test]
fn crease_lists_take_one_sharpness_or_one_each() {
    let cage = parse(
        b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nt crease 4/1/0 0 1 1 2 3\nt crease 4/2/0 2 3 3 0 25 inf\nt corner 2/1/0 0 1 4\n",
    );
    let got: Vec<_> = cage
        .tags()
        .creases
        .iter()
        .map(|c| (c.vertices, c.sharpness))
        .collect();
    assert_eq!(
        got,
        [([0, 1], 3.0), ([1, 2], 3.0), ([2, 3], 25.0), ([3, 0], 10.0)]
    );
    let got: Vec<_> = cage
        .tags()
        .corners
        .iter()
        .map(|c| (c.vertex, c.sharpness))
        .collect();
    assert_eq!(got, [(0, 4.0), (1, 4.0)]);
}

#[test]
fn far_cages_are_moved_before_rounding() {
    let shape = |dx: f64| {
        let v = |x: f64, y: f64, z: f64| format!("v {} {y} {z}\n", x + dx);
        v(0.0, 0.0, 0.0)
            + &v(1.0, 0.0, 0.0)
            + &v(1.0, 1.0, 0.0)
            + &v(0.0, 1.0, 0.125)
            + "f 1 2 3 4\n"
    };
    let near = parse(shape(2.0).as_bytes());
    assert_eq!((near.origin(), near.points()[1][0]), ([0.0; 3], 3.0));
    let far = parse(shape(1e9).as_bytes());
    assert_eq!(far.origin(), [1e9 + 0.5, 0.5, 0.0625]);
    assert_eq!(far.points()[0], [-0.5, -0.5, -0.0625]);
    assert_eq!(far.points()[3], [-0.5, 0.5, 0.0625]);
    // Vertices of no face neither cause this nor prevent it.
    let stray = parse((shape(2.0) + "v 1e20 0 0\n").as_bytes());
    assert_eq!(stray.origin(), [0.0; 3]);
    let stray = parse((shape(1e9) + "v 0 0 0\n").as_bytes());
    assert_eq!(stray.origin(), [1e9 + 0.5, 0.5, 0.0625]);
    assert_eq!(stray.points()[..4], far.points()[..4]);
    // Digits that do not hold the shape any more.
    let lost = parse_with(shape(1e15).as_bytes(), 10);
    assert_eq!(lost.warnings[0].kind(), WarningKind::Precision);
}

#[test]
fn z_up_files_are_turned() {
    let options = ReadOptions {
        up: UpAxis::Z,
        ..ReadOptions::default()
    };
    let text = b"v 1 2 3\nv 0 0 0\nv 1 0 0\nvn 0 0 1\nf 1//1 2//1 3//1\n";
    let cage = read(text, "z.obj", &mut NoFiles, &options).unwrap().cage;
    assert_eq!(cage.points()[0], [1.0, 3.0, -2.0]);
    assert_eq!(cage.normals()[0], [0.0, 1.0, 0.0]);
}

#[test]
fn vertex_colours_become_linear_and_missing_ones_white() {
    let cage = parse(b"v 0 0 0\nv 1 0 0 0 1 0.5\nv 0 1 0 1 0.25 0.25 0.25 1\nv 0 0 1\nf 1 2 3\n");
    let half = cage.colors()[1][2];
    assert!((half - 0.21404).abs() < 1e-4, "{half}");
    assert_eq!((cage.colors()[0], cage.colors()[3]), ([1.0; 3], [1.0; 3]));
    assert_eq!(cage.colors()[1][..2], [0.0, 1.0]);
    assert_eq!(cage.colors().len(), 4);
}

#[test]
fn dropped_faces_keep_holes_and_lines_right() {
    let text = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2\nf 1 2 3\nf 1 1 2\nf 3 2 1\nt hole 2/0/0 2 3\n";
    let found = parse_with(text, 1 << 20);
    assert_eq!(found.cage.face_count(), 2);
    assert_eq!(found.cage.tags().holes, [1]);
    assert_eq!(found.report.dropped_faces, [0, 2]);
    assert_eq!(line_of_face(text, &found.report, 0), Some(5));
    assert_eq!(line_of_face(text, &found.report, 1), Some(7));
    assert_eq!(line_of_face(text, &found.report, 2), None);
}

#[test]
fn budgets_are_kept() {
    let bytes = random_file(7, 2000);
    let run = |max_bytes| {
        read(
            &bytes,
            "a.obj",
            &mut NoFiles,
            &ReadOptions {
                max_bytes,
                ..ReadOptions::default()
            },
        )
    };
    assert!(run(1 << 20).is_ok());
    for few in [0, 100, 5000, 30_000] {
        let error = run(few).unwrap_err();
        assert_eq!(error.kind(), earmark::mesh::ReadErrorKind::Limit, "{error}");
    }
}
