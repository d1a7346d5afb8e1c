//! The OBJ reader against variants of the same text, against itself under other cuts, against another reader, and against the
//! standard library's numbers; and the files that it and others read and write.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use earmark::Cage;
use earmark::files::{self, AtomicFile, FileErrorKind, FolderResolver};
use earmark::mesh::obj::{Read, ReadOptions, UpAxis, line_of_face, read};
use earmark::mesh::{MemoryFiles, NONE, NoFiles, ResolveError, Resolver, WarningKind};

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
fn variants_of_the_text_give_the_same_cage() {
    let want = parse(PLAIN.as_bytes());
    let lines: Vec<&str> = PLAIN.lines().collect();
    let join = |end: &str| {
        lines
            .iter()
            .map(|l| format!("{l}{end}"))
            .collect::<String>()
    };
    let mut variants = vec![
        ("crlf", join("\r\n").into_bytes()),
        ("cr", join("\r").into_bytes()),
        ("blank lines", join("\n\n \t\n").into_bytes()),
        ("trailing blanks", join(" \t \n").into_bytes()),
        ("comments", join(" # f 9 9 9 \\\n").into_bytes()),
        ("comment lines", join("\n# v 1 2 3 \\\n").into_bytes()),
        ("tabs", PLAIN.replace(' ', "\t \t").into_bytes()),
        ("no last newline", PLAIN.trim_end().as_bytes().to_vec()),
        ("indented", join("\n  \t ").into_bytes()),
        (
            "bom",
            [b"\xef\xbb\xbf".as_slice(), PLAIN.as_bytes()].concat(),
        ),
        (
            "plus signs",
            PLAIN
                .replace("v 1", "v +1")
                .replace("f 1", "f +1")
                .into_bytes(),
        ),
        (
            "empty slots",
            PLAIN.replace("f 4 3 5", "f 4/ 3// 5//").into_bytes(),
        ),
        (
            "zeros",
            PLAIN
                .replace("f 4 3 5", "f 0000000000000000000000004 3 05")
                .into_bytes(),
        ),
        (
            "weights",
            PLAIN.replace("v 1 0 0\n", "v 1 0 0 2.5\n").into_bytes(),
        ),
        (
            "third uv",
            PLAIN.replace("vt 1 0\n", "vt 1 0 0\n").into_bytes(),
        ),
        (
            "ignored",
            PLAIN
                .replace("usemtl blue", "s 1\ng a b c\ns off\nlod 3\nusemtl blue")
                .into_bytes(),
        ),
    ];
    let mut latin = PLAIN.as_bytes().to_vec();
    latin.splice(0..0, *b"# \xe9\xff\xfe\x80 C:\\models\\\n");
    variants.push(("latin-1 comment", latin));
    // A continuation in place of every blank that is not part of a name.
    for end in ["\n", "\r\n", "\r"] {
        variants.push((
            "continued",
            join("\n").replace(' ', &format!(" \\{end}")).into_bytes(),
        ));
        variants.push((
            "continued, all ends",
            join(end)
                .replace(' ', &format!("\\{end}\\{end} "))
                .into_bytes(),
        ));
    }
    // Relative indices: at the faces there are 5 positions, 3 uvs and 1 normal.
    let relative = PLAIN
        .replace("f 1/1/1 2/2/1 3/3/1", "f -5/-3/-1 -4/-2/1 -3/-1/-1")
        .replace("f 1/1 3/3 4", "f -5/-3 3/-1 -2")
        .replace("f 4 3 5", "f -2 -3 -1");
    assert_ne!(relative, PLAIN);
    variants.push(("relative", relative.into_bytes()));
    // Faces first: indices may point ahead.
    let (faces, others): (Vec<&str>, Vec<&str>) = lines
        .iter()
        .partition(|l| l.starts_with('f') || l.starts_with("use") || l.starts_with("mtl"));
    variants.push((
        "faces first",
        [faces, others].concat().join("\n").into_bytes(),
    ));
    for (what, bytes) in variants {
        assert!(bytes != PLAIN.as_bytes(), "{what} changed nothing");
        for chunk in [1, 7, 64, 1 << 20] {
            assert_eq!(
                parse_with(&bytes, chunk).cage,
                want,
                "{what}, pieces of {chunk}"
            );
        }
    }
}

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
fn the_cuts_do_not_change_the_result() {
    for seed in 1..20 {
        let bytes = random_file(seed, 300);
        let want = parse_with(&bytes, usize::MAX);
        assert!(want.cage.face_count() > 50 && !want.warnings.is_empty());
        for chunk in (1..40).chain([64, 100, 1000, 4096]) {
            let got = parse_with(&bytes, chunk);
            assert_eq!(got.cage, want.cage, "seed {seed}, pieces of {chunk}");
            assert_eq!(
                got.warnings, want.warnings,
                "seed {seed}, pieces of {chunk}"
            );
            assert_eq!(got.report, want.report, "seed {seed}, pieces of {chunk}");
        }
    }
}

#[test]
fn the_cuts_do_not_change_errors() {
    for seed in 1..40 {
        let mut r = Random(seed);
        let mut bytes = random_file(seed, 200);
        for _ in 0..3 {
            let at = 60 + r.below(bytes.len() as u64 - 60) as usize;
            bytes[at] = [b'x', b'/', b'-', b'9', b'.', b'\n', b'\\', 0xff][r.below(8) as usize];
        }
        let run = |chunk_bytes| {
            let options = ReadOptions {
                chunk_bytes,
                ..ReadOptions::default()
            };
            read(&bytes, "a.obj", &mut library(), &options).map(|r| (r.cage, r.warnings))
        };
        let want = run(usize::MAX);
        for chunk in [1, 3, 17, 100, 999] {
            assert_eq!(run(chunk), want, "seed {seed}, pieces of {chunk}");
        }
    }
}

#[test]
fn the_number_of_threads_does_not_change_the_result() {
    let bytes = random_file(99, 5000);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| parse_with(&bytes, 512).cage)
    };
    let want = on(1);
    assert_eq!(on(2), want);
    assert_eq!(on(7), want);
}

/// Plain OBJ read by another reader, face by face as positions and texture coordinates.
#[test]
fn agrees_with_another_reader_on_plain_files() {
    for seed in 1..60 {
        let mut r = Random(seed * 77 + 5);
        let (v, t) = (4 + r.below(200), 1 + r.below(100));
        let with_uv = r.below(2) == 0;
        let mut text = String::from("o one\n");
        for i in 0..v {
            // The number makes every position its own.
            text += &format!(
                "v {}.{:06} {} -{}e-3\n",
                i,
                r.below(1_000_000),
                i as f64 / 64.0,
                r.below(5000)
            );
        }
        for i in 0..t {
            text += &format!("vt 0.{:04} {}\n", r.below(10_000), i as f64 / 128.0);
        }
        for _ in 0..1 + r.below(300) {
            let start = r.below(v);
            text += "f";
            for k in 0..(3 + r.below(6)).min(v) {
                let index = (start + k) % v + 1;
                let index = if r.below(3) == 0 {
                    index as i64 - v as i64 - 1
                } else {
                    index as i64
                };
                text += &format!(" {index}");
                if with_uv {
                    text += &format!("/{}", 1 + r.below(t));
                }
            }
            text += "\n";
        }
        let cage = parse(text.as_bytes());
        let origin = cage.origin();
        assert_eq!(origin, [0.0; 3]);
        let options = tobj::LoadOptions {
            single_index: false,
            triangulate: false,
            ..Default::default()
        };
        let (models, _) =
            tobj::load_obj_buf(&mut text.as_bytes(), &options, |_| unreachable!()).unwrap();
        assert_eq!(models.len(), 1);
        let mesh = &models[0].mesh;
        let faces = if mesh.face_arities.is_empty() {
            vec![3; mesh.indices.len() / 3]
        } else {
            mesh.face_arities.clone()
        };
        assert_eq!(faces.len(), cage.face_count());
        let mut corner = 0;
        for (f, &n) in faces.iter().enumerate() {
            assert_eq!(cage.face(f).len(), n as usize);
            for &vertex in cage.face(f) {
                let i = mesh.indices[corner] as usize * 3;
                let want: Vec<u32> = mesh.positions[i..i + 3]
                    .iter()
                    .map(|c| c.to_bits())
                    .collect();
                let got: Vec<u32> = cage.points()[vertex as usize]
                    .iter()
                    .map(|c| c.to_bits())
                    .collect();
                assert_eq!(got, want, "seed {seed}, face {f}");
                if with_uv {
                    let i = mesh.texcoord_indices[corner] as usize * 2;
                    assert_eq!(
                        cage.uvs()[cage.corner_uvs()[corner] as usize][..],
                        mesh.texcoords[i..i + 2]
                    );
                }
                corner += 1;
            }
        }
        assert_eq!(corner, cage.corner_vertices().len());
    }
}

#[test]
fn numbers_are_those_of_the_standard_library() {
    let mut r = Random(4242);
    let mut texts = Vec::new();
    for _ in 0..60_000 {
        let digits = |r: &mut Random, n: u64| {
            (0..r.below(n))
                .map(|_| char::from(b'0' + r.below(10) as u8))
                .collect::<String>()
        };
        let mut text = String::from(["", "-", "+"][r.below(3) as usize]);
        let long = [4, 9, 18, 22, 60][r.below(5) as usize];
        text += &digits(&mut r, long);
        if r.below(3) > 0 {
            text.push('.');
            text += &digits(&mut r, long);
        }
        if r.below(3) == 0 {
            text += ["e", "E"][r.below(2) as usize];
            text += ["", "-", "+"][r.below(3) as usize];
            let range = [5, 30, 60, 400][r.below(4) as usize];
            text += &format!("{}", r.below(range));
        }
        texts.push(text);
    }
    // Numbers as programs print them, and ties between neighbouring values.
    for _ in 0..60_000 {
        let single = f32::from_bits(r.next() as u32);
        let double = f64::from(single) + f64::from(f32::from_bits(single.to_bits() ^ 1));
        texts.extend([
            format!("{single}"),
            format!("{single:e}"),
            format!("{:e}", double / 2.0),
        ]);
    }
    let sound = |t: &str| {
        t.bytes()
            .all(|b| b.is_ascii_digit() || b"+-.eE".contains(&b))
            && t.parse::<f64>().is_ok_and(|v| (v as f32).is_finite())
    };
    let (good, bad): (Vec<String>, Vec<String>) = texts.into_iter().partition(|t| sound(t));
    assert!(good.len() > 100_000 && bad.len() > 1000);
    // Faces use the first three vertices only, so the cage stays where it is.
    let mut text = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for t in &good {
        text += &format!("v {t} {t} {t}\n");
    }
    let cage = parse(text.as_bytes());
    for (t, p) in good.iter().zip(&cage.points()[3..]) {
        let want = (t.parse::<f64>().unwrap() as f32).to_bits();
        assert_eq!(p.map(f32::to_bits), [want; 3], "{t}");
    }
    for t in bad.iter().filter(|t| !t.is_empty()).take(3000) {
        let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 {t}\nf 1 2 3\n");
        let error = read(
            text.as_bytes(),
            "n.obj",
            &mut NoFiles,
            &ReadOptions::default(),
        )
        .unwrap_err();
        assert_eq!(error.line(), Some(3), "{t}");
    }
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

/// A folder that goes away with this value.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path =
            std::env::temp_dir().join(format!("earmark-reader-{}-{name}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }
    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
    fn names(&self) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(&self.0)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn outputs_appear_whole_or_not_at_all() {
    let folder = Folder::new("atomic");
    let out = folder.path("out.png");
    files::write_atomic(&out, b"first").unwrap();
    assert_eq!(fs::read(&out).unwrap(), b"first");
    // Dropped before it is done: the old file stays, and nothing else.
    let mut file = AtomicFile::create(&out).unwrap();
    file.write_all(&[7; 100_000]).unwrap();
    assert_eq!(folder.names().len(), 2);
    assert_eq!(fs::read(&out).unwrap(), b"first");
    drop(file);
    assert_eq!(fs::read(&out).unwrap(), b"first");
    assert_eq!(folder.names(), ["out.png"]);
    let mut file = AtomicFile::create(&out).unwrap();
    file.write_all(b"second").unwrap();
    file.commit().unwrap();
    assert_eq!(fs::read(&out).unwrap(), b"second");
    // A target that turns into a folder meanwhile.
    let late = folder.path("late");
    let file = AtomicFile::create(&late).unwrap();
    fs::create_dir(&late).unwrap();
    let error = file.commit().unwrap_err();
    assert!(error.to_string().ends_with("is a folder"), "{error}");
    assert_eq!(folder.names(), ["late", "out.png"]);
}

#[test]
fn outputs_go_only_where_a_file_may_be() {
    let folder = Folder::new("targets");
    fs::create_dir(folder.path("dir")).unwrap();
    let long = "x".repeat(300);
    for bad in [
        "dir",
        "dir/",
        "missing/out.png",
        "..",
        "nofile/",
        long.as_str(),
        "a\0b",
    ] {
        let error = files::write_atomic(&folder.path(bad), b"x").unwrap_err();
        assert_eq!(error.kind(), FileErrorKind::Io, "{error}");
        assert!(!error.to_string().contains('\0'));
        assert_eq!(folder.names(), ["dir"], "{bad}");
    }
    let error = files::write_atomic(Path::new(""), b"x").unwrap_err();
    assert_eq!(error.kind(), FileErrorKind::Io);
    let fixed = folder.path("fixed");
    fs::write(&fixed, b"keep").unwrap();
    let mut permissions = fs::metadata(&fixed).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&fixed, permissions).unwrap();
    assert!(
        files::write_atomic(&fixed, b"x")
            .unwrap_err()
            .to_string()
            .contains("write-protected")
    );
    assert_eq!(fs::read(&fixed).unwrap(), b"keep");
}

#[cfg(unix)]
#[test]
fn links_are_followed_to_files_and_nowhere_else() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new("links");
    fs::write(folder.path("real"), b"old").unwrap();
    symlink(folder.path("real"), folder.path("link")).unwrap();
    files::write_atomic(&folder.path("link"), b"new").unwrap();
    assert_eq!(fs::read(folder.path("real")).unwrap(), b"new");
    assert!(
        fs::symlink_metadata(folder.path("link"))
            .unwrap()
            .is_symlink()
    );
    symlink(folder.path("none"), folder.path("dangling")).unwrap();
    symlink("/dev/null", folder.path("device")).unwrap();
    symlink(folder.path("loop"), folder.path("loop")).unwrap();
    for bad in ["dangling", "device", "loop"] {
        files::write_atomic(&folder.path(bad), b"x").unwrap_err();
        assert!(fs::symlink_metadata(folder.path(bad)).unwrap().is_symlink());
    }
    files::write_atomic(Path::new("/dev/null"), b"x").unwrap_err();
    use std::os::unix::fs::FileTypeExt;
    assert!(
        fs::metadata("/dev/null")
            .unwrap()
            .file_type()
            .is_char_device()
    );
    assert_eq!(
        folder.names(),
        ["dangling", "device", "link", "loop", "real"]
    );
}

#[test]
fn streams_and_files_keep_their_limits() {
    assert_eq!(files::read_stream("-", &b"12345"[..], 5).unwrap(), b"12345");
    let error = files::read_stream("-", &b"123456"[..], 5).unwrap_err();
    assert_eq!(error.kind(), FileErrorKind::Limit);
    let endless = std::io::repeat(b'v');
    assert_eq!(
        files::read_stream("-", endless, 1 << 20)
            .unwrap_err()
            .kind(),
        FileErrorKind::Limit
    );
    let folder = Folder::new("sizes");
    fs::write(folder.path("a"), b"12345").unwrap();
    assert_eq!(files::read_model(&folder.path("a"), 5).unwrap(), b"12345");
    assert_eq!(
        files::read_model(&folder.path("a"), 4).unwrap_err().kind(),
        FileErrorKind::Limit
    );
    assert!(files::same_file(
        &folder.path("a"),
        &folder
            .path("../")
            .join(folder.0.file_name().unwrap())
            .join("a")
    ));
    assert!(!files::same_file(&folder.path("a"), &folder.path("b")));
}

#[test]
fn the_reach_of_a_model_can_be_widened() {
    let folder = Folder::new("reach");
    fs::create_dir_all(folder.path("models")).unwrap();
    fs::create_dir_all(folder.path("textures")).unwrap();
    fs::write(folder.path("textures/a.png"), b"a").unwrap();
    fs::write(folder.path("models/m.obj"), b"m").unwrap();
    let mut narrow = FolderResolver::beside(&folder.path("models/m.obj")).unwrap();
    assert_eq!(narrow.read("./m.obj", 10).unwrap(), b"m");
    assert_eq!(narrow.read("../models/m.obj", 10).unwrap(), b"m");
    assert!(matches!(
        narrow.read("../textures/a.png", 10),
        Err(ResolveError::Refused(_))
    ));
    let mut wide = narrow.with_root(&folder.0).unwrap();
    assert_eq!(wide.read("..\\textures\\a.png", 10).unwrap(), b"a");
    assert!(matches!(
        wide.read("../../a.png", 10),
        Err(ResolveError::Refused(_))
    ));
    assert!(matches!(
        wide.read("../textures/a.png", 0),
        Err(ResolveError::TooLarge { limit: 0 })
    ));
}
