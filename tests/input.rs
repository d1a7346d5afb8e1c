//! Bad and odd inputs, over all classes that files can fall into, each with the outcome that is promised for it.
//!
//! Every case is made here, in memory or in a folder that goes away. What is never allowed, whatever the case: a panic, an error
//! without a message, a wrong line, control characters or much text in a message.

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use earmark::camera::Camera;
use earmark::files::{self, FileErrorKind, FolderResolver};
use earmark::frame::{Refinement, RenderError, Renderer, Scene};
use earmark::limits::LimitError;
use earmark::mesh::obj::{Read, ReadOptions, read};
use earmark::mesh::{MemoryFiles, ReadError, ReadErrorKind, ResolveError, Resolver, WarningKind};
use earmark::scheme::Scheme;
use earmark::{Cage, Surface, SurfaceOptions};

/// Four vertices, so that cases can be short.
const V: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// What must come of a case.
#[derive(Debug)]
enum Want {
    /// An error at this line (0: without line) whose text holds this.
    Error(usize, &'static str),
    /// A cage, and exactly one warning: of this kind, at this line (0: without line).
    Warn(WarningKind, usize),
    /// A cage with so many faces and no warning.
    Render(usize),
    /// A cage or a clean error: anything but a fault.
    Clean,
}
use Want::{Clean, Error, Render, Warn};

fn run(bytes: &[u8], files: &mut dyn Resolver) -> Result<Read, ReadError> {
    let options = ReadOptions {
        max_bytes: 1 << 30,
        ..ReadOptions::default()
    };
    catch_unwind(AssertUnwindSafe(|| {
        read(bytes, "case.obj", files, &options)
    }))
    .unwrap_or_else(|_| panic!("panicked on {}", excerpt(bytes)))
}

fn excerpt(bytes: &[u8]) -> String {
    String::from_utf8_lossy(&bytes[..bytes.len().min(200)]).into_owned()
}

/// What a program would print, checked for what no output may hold.
fn printed(result: &Result<Read, ReadError>) -> String {
    let text: String = match result {
        Ok(found) => found.warnings.iter().map(|w| format!("{w}\n")).collect(),
        Err(e) => format!("{e}\n"),
    };
    assert!(text.len() <= 64 << 10, "{} bytes of messages", text.len());
    for line in text.lines() {
        assert!(!line.chars().any(char::is_control), "{line:?}");
        assert!(
            !line.contains(['\u{2028}', '\u{2029}', '\u{202e}']),
            "{line:?}"
        );
        assert!(line.len() < 1000, "{line}");
        let rest = line.split_once(": ").expect("a place before the message").1;
        assert!(rest.len() > 8, "says nothing: {line}");
    }
    text
}

fn check(name: &str, bytes: &[u8], files: &mut dyn Resolver, want: &Want) {
    let result = run(bytes, files);
    let text = printed(&result);
    let what = format!("{name}: {} gave {text}", excerpt(bytes));
    match (want, &result) {
        (Clean, _) => {}
        (Error(line, holds), Err(e)) => {
            assert_eq!(e.kind(), ReadErrorKind::Data, "{what}");
            assert_eq!(e.line().unwrap_or(0), *line, "{what}");
            let place = match line {
                0 => "case.obj: ".to_owned(),
                n => format!("case.obj:{n}: "),
            };
            assert!(text.starts_with(&place) && text.contains(holds), "{what}");
        }
        (Warn(kind, line), Ok(found)) => {
            assert_eq!(found.warnings.len(), 1, "{what}");
            assert_eq!(found.warnings[0].kind(), *kind, "{what}");
            assert_eq!(found.warnings[0].line().unwrap_or(0), *line, "{what}");
            sound(found);
        }
        (Render(faces), Ok(found)) => {
            assert_eq!(found.cage.face_count(), *faces, "{what}");
            assert!(found.warnings.is_empty(), "{what}");
            sound(found);
        }
        _ => panic!("{what}, wanted {want:?}"),
    }
    // A cage of any outcome keeps its promises.
    if let Ok(found) = &result {
        sound(found);
    }
}

fn sound(found: &Read) {
    let cage = &found.cage;
    let n = cage.points().len() as u32;
    assert!(cage.face_count() > 0);
    assert!(cage.points().iter().flatten().all(|c| c.is_finite()));
    assert!(cage.uvs().iter().flatten().all(|c| c.is_finite()));
    assert!(cage.corner_vertices().iter().all(|&v| v < n));
    for f in 0..cage.face_count() {
        assert!(cage.face(f).len() >= 3);
    }
    assert_eq!(
        *cage.face_offsets().last().unwrap() as usize,
        cage.corner_vertices().len()
    );
    for list in [cage.corner_uvs(), cage.corner_normals()] {
        assert!(list.is_empty() || list.len() == cage.corner_vertices().len());
    }
    let tags = cage.tags();
    assert!(
        tags.creases
            .iter()
            .all(|c| c.vertices.iter().all(|&v| v < n) && c.sharpness >= 0.0)
    );
    assert!(tags.holes.iter().all(|&f| (f as usize) < cage.face_count()));
}

fn none() -> MemoryFiles {
    MemoryFiles::new()
}

/// Cases of text alone.
fn check_all(cases: Vec<(&str, Vec<u8>, Want)>) {
    for (name, bytes, want) in cases {
        check(name, &bytes, &mut none(), &want);
    }
}

#[test]
fn whole_files() {
    let utf16 = |big: bool| -> Vec<u8> {
        let units = "\u{feff}v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".encode_utf16();
        units
            .flat_map(|u| {
                if big {
                    u.to_be_bytes()
                } else {
                    u.to_le_bytes()
                }
            })
            .collect()
    };
    let utf32: Vec<u8> = "\u{feff}v 0 0 0\n"
        .chars()
        .flat_map(|c| (c as u32).to_le_bytes())
        .collect();
    let mut stl = vec![b' '; 84 + 50];
    stl[..80].fill(0);
    stl[80..84].copy_from_slice(&1_u32.to_le_bytes());
    let noise: Vec<u8> = (0..5000_u64)
        .map(|i| (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as u8)
        .collect();
    let text = |s: &str| s.as_bytes().to_vec();
    check_all(vec![
        ("empty", vec![], Error(0, "empty")),
        ("one byte", text("v"), Error(0, "no faces")),
        ("a line end", text("\n"), Error(0, "no vertices")),
        ("comments", text("# a\n# b\n"), Error(0, "no vertices")),
        ("no faces", text(V), Error(0, "no faces")),
        ("no vertices", text("f 1 2 3\n"), Error(0, "no vertices")),
        (
            "curves only",
            text("v 0 0 0\nvp 0\ncstype bezier\ncurv 0 1 1\nend\n"),
            Error(0, "no faces"),
        ),
        (
            "lines only",
            text("v 0 0 0\nv 1 0 0\nl 1 2\n"),
            Error(0, "no faces"),
        ),
        ("zeros", vec![0; 4096], Error(0, "binary")),
        ("noise", noise, Error(0, "binary")),
        ("gzip", b"\x1f\x8b\x08\0\0\0".to_vec(), Error(0, "gzip")),
        ("zip", b"PK\x03\x04\x14\0".to_vec(), Error(0, "zip")),
        (
            "ply",
            text("ply\nformat ascii 1.0\nelement vertex 3\n"),
            Error(0, "PLY"),
        ),
        (
            "ascii stl",
            text("solid a\n facet normal 0 0 1\n"),
            Error(0, "STL"),
        ),
        ("binary stl", stl, Error(0, "STL")),
        ("off", text("OFF\n3 1 0\n"), Error(0, "OFF")),
        (
            "gltf",
            text("{\"asset\": {\"version\": \"2.0\"}}"),
            Error(0, "glTF"),
        ),
        ("glb", b"glTF\x02\0\0\0".to_vec(), Error(0, "glTF")),
        ("fbx", b"Kaydara FBX Binary  \0".to_vec(), Error(0, "FBX")),
        ("usd", text("#usda 1.0\n"), Error(0, "USD")),
        ("png", b"\x89PNG\r\n\x1a\n".to_vec(), Error(0, "PNG")),
        (
            "html",
            text("<!DOCTYPE html>\n<html><body>404</body></html>"),
            Error(0, "web page"),
        ),
        ("xml", text("<?xml version=\"1.0\"?><a/>"), Error(0, "XML")),
        (
            "lfs",
            text("version https://git-lfs.github.com/spec/v1\n"),
            Error(0, "LFS"),
        ),
        ("utf-16 le", utf16(false), Error(0, "UTF-16")),
        ("utf-16 be", utf16(true), Error(0, "UTF-16")),
        (
            "utf-16 without mark",
            utf16(false)[2..].to_vec(),
            Error(0, "UTF-16"),
        ),
        ("utf-32", utf32, Error(0, "UTF-32")),
        (
            "prose",
            text("Dear reader,\nthis is no model.\n"),
            Error(0, "no vertices"),
        ),
    ]);
}

#[test]
fn text_of_all_kinds() {
    let with = |tail: &str| format!("{V}{tail}").into_bytes();
    let mut latin = with("# caf\u{e9}\nf 1 2 3\n");
    latin.retain(|&b| b != 0xc3);
    let long_comment = with(&format!("#{}\nf 1 2 3\n", "x".repeat(3 << 20)));
    let long_chain = with(&format!("f 1 2 3{}\n", " \\\n".repeat(300_000)));
    let comment_chain = with(&format!("f 1 2 3\n{}", "# \\\n".repeat(300_000)));
    let many_groups: String = (0..200_000)
        .map(|i| format!("g g{i}\no o{i}\ns {i}\n"))
        .collect();
    let unknown: String = (0..100_000)
        .map(|i| format!("word{i} \u{1b}[31m\n"))
        .collect();
    check_all(vec![
        ("latin-1", latin, Render(1)),
        ("nul in a comment", with("# \0\nf 1 2 3"), Render(1)),
        (
            "end mark of old editors",
            with("f 1 2 3\n\x1a"),
            Warn(WarningKind::Unknown, 6),
        ),
        ("long comment", long_comment, Render(1)),
        ("long chain", long_chain, Render(1)),
        ("comments that end in backslashes", comment_chain, Render(1)),
        (
            "backslash at the end",
            with("f 1 2 3 \\"),
            Error(5, "not a vertex index"),
        ),
        (
            "backslash and line end at the end",
            with("f 1 2 3\\\n"),
            Render(1),
        ),
        ("many groups", with(&(many_groups + "f 1 2 3\n")), Render(1)),
        (
            "unknown statements",
            with(&(unknown + "f 1 2 3\n")),
            Warn(WarningKind::Unknown, 5),
        ),
        (
            "capital keywords",
            with("F 1 2 3\nf 1 2 3\n"),
            Warn(WarningKind::Unknown, 5),
        ),
        (
            "commands",
            with("call other.obj\ncsh rm -rf /\nf 1 2 3\n"),
            Warn(WarningKind::Command, 5),
        ),
        (
            "lines",
            with("f 1 2 3\nl 1 2 3 4\nl 1 2\n"),
            Warn(WarningKind::Lines, 6),
        ),
        (
            "points",
            with("p 1\nf 1 2 3\n"),
            Warn(WarningKind::Points, 5),
        ),
        (
            "free form",
            with("vp 0 0\ncstype bspline\ndeg 3\nf 1 2 3\n"),
            Warn(WarningKind::FreeForm, 5),
        ),
        (
            "cut in a number",
            with("f 1 2 3\nv 1 2 -"),
            Error(6, "'-' is not a number"),
        ),
        (
            "cut in a face",
            with("f 1 2 3\nf 1 2"),
            Warn(WarningKind::ShortFace, 6),
        ),
        (
            "render attributes",
            with("s off\nmg 0\nlod 1\nbevel on\nf 1 2 3\n"),
            Render(1),
        ),
        (
            "long token",
            with(&format!("f 1 2 3\nv {} 0 0\n", "9".repeat(1 << 20))),
            Error(6, "out of range"),
        ),
        (
            "long word",
            with(&format!("v {} 0 0\nf 1 2 3\n", "z".repeat(1 << 20))),
            Error(5, "not a number"),
        ),
        (
            "escapes in a token",
            with("v \x1b[2J\x07 0 0\nf 1 2 3\n"),
            Error(5, "\\u{1b}[2J"),
        ),
        (
            "line separators in a token",
            with("v \u{2028}\u{202e} 0 0\nf 1 2 3\n"),
            Error(5, "\\u{2028}"),
        ),
    ]);
}

#[test]
fn indices() {
    let with = |tail: &str| format!("{V}vt 0 0\nvt 1 0\nvn 0 0 1\n{tail}\n").into_bytes();
    check_all(vec![
        ("zero", with("f 0 1 2"), Error(8, "index 0")),
        (
            "one past",
            with("f 1 2 5"),
            Error(8, "vertex index 5, but the file has 4"),
        ),
        (
            "relative before the first",
            with("f -1 -2 -5"),
            Error(8, "index -5, but only 4"),
        ),
        ("minus zero", with("f -0 1 2"), Error(8, "index 0")),
        (
            "over 32 bits",
            with("f 1 2 4294967297"),
            Error(8, "4294967297"),
        ),
        (
            "over 64 bits",
            with("f 1 2 18446744073709551617"),
            Error(8, "18446744073709551617"),
        ),
        (
            "under 64 bits",
            with("f 1 2 -18446744073709551617"),
            Error(8, "relative"),
        ),
        ("fraction", with("f 1 2 3.0"), Error(8, "not a corner")),
        ("exponent", with("f 1 2 3e0"), Error(8, "not a corner")),
        (
            "word",
            with("f 1 2 three"),
            Error(8, "'three' is not a vertex index"),
        ),
        ("hex", with("f 1 2 0x3"), Error(8, "")),
        ("comma", with("f 1,2,3"), Error(8, "not a corner")),
        (
            "other digits",
            with("f 1 2 \u{663}"),
            Error(8, "not a vertex index"),
        ),
        (
            "sign alone",
            with("f 1 2 -"),
            Error(8, "not a vertex index"),
        ),
        (
            "slash alone",
            with("f 1 2 /"),
            Error(8, "not a vertex index"),
        ),
        (
            "no vertex",
            with("f /1 /2 /1"),
            Error(8, "not a vertex index"),
        ),
        (
            "four slots",
            with("f 1/1/1/1 2 3"),
            Error(8, "not a corner"),
        ),
        (
            "uv zero",
            with("f 1/0 2/1 3/1"),
            Error(8, "texture coordinate index 0"),
        ),
        (
            "uv out of range",
            with("f 1/1 2/2 3/3"),
            Error(8, "texture coordinate index 3"),
        ),
        (
            "uv relative out of range",
            with("f 1/-1 2/-2 3/-3"),
            Error(8, "texture coordinate"),
        ),
        (
            "normal out of range",
            with("f 1//1 2//2 3//1"),
            Error(8, "normal index 2"),
        ),
        (
            "normal word",
            with("f 1//x 2//1 3//1"),
            Error(8, "'x' is not a normal index"),
        ),
        (
            "several lines on",
            with("f 1 2 3\n\n\n# c\nf 1 2 9"),
            Error(12, "index 9"),
        ),
        ("continued", with("f 1 \\\n2 \\\n9"), Error(10, "index 9")),
        (
            "ahead",
            b"v 0 0 0\nf 1 2 3\nv 1 0 0\nv 0 1 0\n".to_vec(),
            Render(1),
        ),
        (
            "relative ahead",
            b"v 0 0 0\nf 1 -1 -2\nv 1 0 0\nv 0 1 0\n".to_vec(),
            Error(2, "only 1 come before"),
        ),
        ("empty slots", with("f 1/ 2// 3/"), Render(1)),
        (
            "some uvs",
            with("f 1/1 2 3/2"),
            Warn(WarningKind::MissingUvs, 0),
        ),
        (
            "two corners",
            with("f 1 2\nf 1 2 3"),
            Warn(WarningKind::ShortFace, 8),
        ),
        (
            "no corners",
            with("f\nf 1 2 3\nf # none"),
            Warn(WarningKind::ShortFace, 8),
        ),
        (
            "only short faces",
            with("f 1 2\nf 3"),
            Error(0, "no face with three"),
        ),
    ]);
}

#[test]
fn numbers() {
    let with = |line: &str| format!("{V}{line}\nvt 0.5 0.5\nf 1 2 3\n").into_bytes();
    let mut cases = Vec::new();
    for (word, holds) in [
        ("nan", "not a finite"),
        ("NaN", "not a finite"),
        ("-nan(ind)", "not a finite"),
        ("inf", "not a finite"),
        ("-Infinity", "not a finite"),
        ("1.#QNAN", "not a number"),
        ("1.#INF", "not a number"),
        ("1e39", "out of range"),
        ("-1e400", "out of range"),
        ("1e99999999999999999999", "out of range"),
        ("one", "not a number"),
        ("1,5", "not a number"),
        ("0x1p3", "not a number"),
        ("1.2.3", "not a number"),
        ("--1", "not a number"),
        ("1e", "not a number"),
        ("1d5", "not a number"),
        (".", "not a number"),
        ("\u{2212}1", "not a number"),
    ] {
        for line in [
            format!("v 0 {word} 0"),
            format!("vt {word} 0"),
            format!("vn 0 0 {word}"),
            format!("v 1 2 3 {word}"),
        ] {
            if line.starts_with("v 0") && word.ends_with("QNAN") {
                // A `#` begins a comment anywhere, so too few numbers are left.
                cases.push(("number", with(&line), Error(5, "too few")));
            } else if word.contains('#') {
                cases.push(("number", with(&line), Clean));
            } else {
                cases.push(("number", with(&line), Error(5, holds)));
            }
        }
    }
    for line in ["v", "v 1", "v 1 2", "v # 1 2 3", "vt", "vn 1 2"] {
        cases.push(("too few", with(line), Error(5, "too few numbers")));
    }
    for line in [
        "v 1 2 3 1",
        "v +1 -0 1E-40",
        "v 1e-400 .5 5.",
        "vt 0.5",
        "vt 0 0 0",
        "v 1 2 3 .1 .2 .3 1",
        "v 00001 2 3",
        "v 0.10000000000000000000000000000000000001 1e0 0e99999999999",
    ] {
        cases.push(("legal", with(line), Render(1)));
    }
    for line in [
        "v 1 2 3 4 5",
        "v 1 2 3 4 5 6 7 8",
        "vn 0 0 1 1",
        "vt 0 0 0 0",
    ] {
        cases.push(("too many", with(line), Warn(WarningKind::ExtraNumbers, 5)));
    }
    cases.push((
        "colours of 255",
        with("v 1 2 3 255 0 128"),
        Warn(WarningKind::ColorRange, 5),
    ));
    check_all(cases);
}

#[test]
fn geometry() {
    let with = |tail: &str| format!("{V}{tail}\n").into_bytes();
    let fan = |n: usize| -> Vec<u8> {
        let v: String = (0..n).map(|i| format!("v {i} {} 0\n", i * i % 7)).collect();
        let f: String = (1..=n).map(|i| format!(" {i}")).collect();
        format!("{v}f{f}\n").into_bytes()
    };
    let hub: String = (2..=70_000)
        .map(|i| format!("f 1 {} {}\n", i, i + 1))
        .collect();
    let spokes: String = (0..70_001).map(|i| format!("v {i} 1 0\n")).collect();
    let scaled = |s: f64| format!("v 0 0 0\nv {s:e} 0 0\nv 0 {s:e} 0\nf 1 2 3\n").into_bytes();
    check_all(vec![
        (
            "twice",
            with("f 1 2 2 3"),
            Warn(WarningKind::RepeatedVertex, 5),
        ),
        (
            "twice, apart",
            with("f 1 2 3 1 4"),
            Warn(WarningKind::RepeatedVertex, 5),
        ),
        (
            "two different",
            with("f 1 2 3\nf 1 2 1 2"),
            Warn(WarningKind::CollapsedFace, 6),
        ),
        (
            "one different",
            with("f 1 2 3\nf 1 1 1"),
            Warn(WarningKind::CollapsedFace, 6),
        ),
        (
            "all collapsed",
            with("f 1 1 1"),
            Error(0, "no face with three different"),
        ),
        (
            "coincident",
            b"v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n".to_vec(),
            Render(1),
        ),
        (
            "a point far out",
            b"v 5 5 5\nv 5 5 5\nv 5 5 5\nf 1 2 3\n".to_vec(),
            Render(1),
        ),
        (
            "collinear",
            b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n".to_vec(),
            Render(1),
        ),
        ("crossing", with("f 1 3 2 4"), Render(1)),
        ("large polygon", fan(65_535), Render(1)),
        (
            "large valence",
            format!("{spokes}{hub}").into_bytes(),
            Render(69_999),
        ),
        ("tiny", scaled(1e-12), Render(1)),
        ("huge", scaled(1e12), Render(1)),
        ("smallest numbers", scaled(1e-40), Render(1)),
        ("largest numbers", scaled(3e38), Render(1)),
        ("isolated vertices", with("v 1e30 0 0\nf 1 2 3"), Render(1)),
        (
            "duplicate and opposite faces",
            with("f 1 2 3\nf 1 2 3\nf 3 2 1"),
            Render(3),
        ),
        (
            "far away",
            b"v 1e7 0 0\nv 10000001 0 0\nv 1e7 1 0\nf 1 2 3\n".to_vec(),
            Render(1),
        ),
        (
            "too far away",
            b"v 1e17 0 0\nv 1e17 1 0\nv 1e17 1 1\nf 1 2 3\n".to_vec(),
            Warn(WarningKind::Precision, 0),
        ),
    ]);
}

#[test]
fn tags() {
    let with = |tail: &str| format!("{V}f 1 2 3 4\n{tail}\n").into_bytes();
    let t = |name, tag: &str, want| (name, with(tag), want);
    check_all(vec![
        t(
            "vertex out of range",
            "t crease 2/1/0 0 4 1",
            Error(6, "vertex 4 in a tag"),
        ),
        t(
            "negative vertex",
            "t crease 2/1/0 -1 1 1",
            Error(6, "vertex -1"),
        ),
        t(
            "face out of range",
            "t hole 1/0/0 1",
            Error(6, "face 1 in a tag"),
        ),
        t(
            "corner out of range",
            "t corner 1/1/0 99999999999999999999 1",
            Error(6, "in a tag"),
        ),
        t(
            "fraction",
            "t corner 1/1/0 1.5 1",
            Error(6, "not a whole number"),
        ),
        t("nan", "t crease 2/1/0 0 1 nan", Error(6, "not a sharpness")),
        t(
            "word",
            "t crease 2/1/0 0 1 sharp",
            Error(6, "not a sharpness"),
        ),
        t(
            "negative",
            "t crease 2/1/0 0 1 -2",
            Warn(WarningKind::NegativeSharpness, 6),
        ),
        t("zero", "t crease 2/1/0 0 1 0", Render(1)),
        t("hundred", "t crease 2/1/0 0 1 100", Render(1)),
        t("infinite", "t crease 2/1/0 0 1 inf", Render(1)),
        t("overflow", "t crease 2/1/0 0 1 1e99", Render(1)),
        t(
            "same end",
            "t crease 2/1/0 1 1 2",
            Warn(WarningKind::CollapsedCrease, 6),
        ),
        t("odd", "t crease 3/1/0 0 1 2 1", Error(6, "pairs")),
        t(
            "no sharpness declared",
            "t crease 2/0/0 0 1",
            Error(6, "one sharpness"),
        ),
        t("too few", "t crease 2/1/0 0 1", Error(6, "fewer arguments")),
        t("nothing", "t crease", Error(6, "count")),
        t("huge counts", "t crease 4000000000/1/0 0 1 1", Error(6, "")),
        t(
            "huge holes",
            "t hole 99999999999999999999/0/0 0",
            Error(6, "fewer arguments"),
        ),
        t(
            "huge corners",
            "t corner 18446744073709551615/1/0 0 1",
            Error(6, ""),
        ),
        t(
            "negative counts",
            "t crease -2/1/0 0 1 1",
            Error(6, "count"),
        ),
        t("words as counts", "t crease a/b/c 0 1 1", Error(6, "count")),
        t("four counts", "t crease 2/1/0/0 0 1 1", Error(6, "count")),
        t(
            "too many",
            "t corner 1/1/0 0 1 2 3",
            Warn(WarningKind::ExtraTagArguments, 6),
        ),
        t(
            "unknown tag",
            "t sparkle 1/0/0 7",
            Warn(WarningKind::UnknownTag, 6),
        ),
        t("tag without name", "t", Warn(WarningKind::UnknownTag, 6)),
        t(
            "unknown method",
            "t creasemethod 0/0/1 zigzag",
            Warn(WarningKind::UnknownTag, 6),
        ),
        t(
            "boundary out of range",
            "t interpolateboundary 1/0/0 3",
            Error(6, "not one of 0 to 2"),
        ),
        t(
            "face-varying out of range",
            "t facevaryinginterpolateboundary 1/0/0 6",
            Error(6, "0 to 5"),
        ),
        t(
            "edit",
            "t vertexedit 4/3/3 0 0 0 0 1 1 1 P value set",
            Warn(WarningKind::HierarchicalEdit, 6),
        ),
        t("all holes", "t hole 1/0/0 0", Render(1)),
        t("empty tags", "t hole 0/0/0\nt crease 0/0/0", Render(1)),
        t("many", &"t corner 1/1/0 0 1\n".repeat(100_000), Render(1)),
    ]);
}

#[test]
fn materials() {
    let obj = |lib: &str, name: &str| format!("{lib}\n{V}usemtl {name}\nf 1 2 3\n").into_bytes();
    let simple = || obj("mtllib a.mtl", "m");
    let lib = |text: &[u8]| none().with("a.mtl", text);
    let mut cases: Vec<(&str, Vec<u8>, MemoryFiles, Want)> = vec![
        ("good", simple(), lib(b"newmtl m\nKd 1 0 0\n"), Render(1)),
        (
            "crlf",
            simple(),
            lib(b"\xef\xbb\xbfnewmtl m\r\nKd 1 0 0\r\n"),
            Render(1),
        ),
        (
            "blanks in names",
            obj("mtllib my lib.mtl", "my material"),
            none().with("my lib.mtl", "newmtl my material"),
            Render(1),
        ),
        (
            "latin-1 names",
            {
                let mut b = simple();
                let at = b.windows(8).position(|w| w == b"usemtl m").unwrap() + 7;
                b[at] = 0xe9;
                b
            },
            lib(b"newmtl \xe9\n"),
            Render(1),
        ),
        (
            "two libraries in one line",
            obj("mtllib b.mtl a.mtl", "m"),
            lib(b"newmtl m\n").with("b.mtl", "newmtl n"),
            Render(1),
        ),
        (
            "no library named",
            obj("", "m"),
            none(),
            Warn(WarningKind::MissingMaterial, 0),
        ),
        (
            "empty library name",
            obj("mtllib", ""),
            none(),
            Warn(WarningKind::Library, 1),
        ),
        (
            "library missing",
            obj("mtllib none.mtl", ""),
            none(),
            Warn(WarningKind::Library, 1),
        ),
        (
            "empty library",
            simple(),
            lib(b""),
            Warn(WarningKind::MissingMaterial, 0),
        ),
        ("binary library", simple(), lib(&[0xff; 1000]), Clean),
        (
            "lines before a material",
            simple(),
            lib(b"Kd 1 0 0\nnewmtl m\n"),
            Warn(WarningKind::MaterialLine, 1),
        ),
        (
            "huge numbers",
            simple(),
            lib(b"newmtl m\nKd 1e99 0 0\n"),
            Warn(WarningKind::MaterialLine, 2),
        ),
        (
            "two numbers",
            simple(),
            lib(b"newmtl m\nKd 1 0\n"),
            Warn(WarningKind::MaterialLine, 2),
        ),
        (
            "one number",
            simple(),
            lib(b"newmtl m\nKd 0.5\n"),
            Render(1),
        ),
        (
            "spectral",
            simple(),
            lib(b"newmtl m\nKd spectral a.rfl 1\n"),
            Warn(WarningKind::MaterialLine, 2),
        ),
        (
            "out of range",
            simple(),
            lib(b"newmtl m\nKd -1 0 9\nd 3\n"),
            Warn(WarningKind::MaterialRange, 2),
        ),
        (
            "map without name",
            simple(),
            lib(b"newmtl m\nmap_Kd\n"),
            Warn(WarningKind::MaterialLine, 2),
        ),
        (
            "map options",
            simple(),
            lib(b"newmtl m\nmap_Kd -s 1 1 1 a.png\n"),
            Warn(WarningKind::MapOptions, 2),
        ),
        (
            "duplicates",
            simple(),
            lib(b"newmtl m\nnewmtl m\n"),
            Warn(WarningKind::DuplicateMaterial, 2),
        ),
        (
            "unknown keys",
            simple(),
            lib(b"newmtl m\nPr 0.5\naniso 1\nrefl -type sphere a.png\n"),
            Render(1),
        ),
    ];
    let many: String = (0..100_000)
        .map(|i| format!("usemtl m{i}\nf 1 2 3\n"))
        .collect();
    let library: String = (0..100_000)
        .map(|i| format!("newmtl m{i}\nKd 0 0 1\n"))
        .collect();
    cases.push((
        "many materials",
        format!("mtllib a.mtl\n{V}{many}").into_bytes(),
        none().with("a.mtl", library),
        Render(100_000),
    ));
    let libraries: String = (0..5000).map(|i| format!("mtllib l{i}.mtl\n")).collect();
    cases.push((
        "many libraries",
        format!("{libraries}{V}f 1 2 3\n").into_bytes(),
        none(),
        Clean,
    ));
    cases.push((
        "the same library often",
        format!("{}{V}usemtl m\nf 1 2 3\n", "mtllib a.mtl\n".repeat(10_000)).into_bytes(),
        lib(b"newmtl m\n"),
        Render(1),
    ));
    for (name, bytes, mut files, want) in cases {
        check(name, &bytes, &mut files, &want);
        let mut asked = files.reads().to_vec();
        let n = asked.len();
        asked.sort();
        asked.dedup();
        assert_eq!(asked.len(), n, "{name}: a library was read twice");
        assert!(n <= 1000, "{name}: {n} libraries");
    }
}

#[test]
fn names_in_messages_are_escaped_and_cut() {
    let name = format!("\x1b]0;{}\x07\u{202e}", "n".repeat(100_000));
    let bytes = format!("mtllib {name}\nusemtl {name}\n{name}\n{V}f 1 2 3\n");
    let options = ReadOptions::default();
    let result = read(bytes.as_bytes(), &name, &mut none(), &options);
    let text: String = result
        .unwrap()
        .warnings
        .iter()
        .map(|w| format!("{w}\n"))
        .collect();
    assert!(
        text.len() < 64 << 10 && text.lines().count() == 3,
        "{}",
        text.len()
    );
    assert!(!text.contains(['\x1b', '\x07', '\u{202e}']));
}

#[test]
fn budgets_refuse_before_they_allocate() {
    let faces = "f 1 2 3\n".repeat(100_000);
    let bytes = format!("{V}{faces}").into_bytes();
    let options = ReadOptions {
        max_bytes: 1 << 20,
        ..ReadOptions::default()
    };
    let result = read(&bytes, "case.obj", &mut none(), &options);
    assert!(printed(&result).contains("allowed"));
    assert_eq!(result.unwrap_err().kind(), ReadErrorKind::Limit);
    check(
        "a budget that is enough",
        &bytes,
        &mut none(),
        &Render(100_000),
    );
}

/// Seeded damage to a good file: cut, exchanged and repeated bytes.
#[test]
fn damaged_files_never_fault() {
    let good = format!(
        "mtllib a.mtl\n{V}v 0.5 -1.25e-1 3\nvt 0 0\nvt 1 0.5\nvn 0 0 1\nusemtl m\nf 1/1/1 2/2/1 3/1/1\nf 3//1 -1 1 \\\n 2\n\
         t crease 2/1/0 0 1 2.5\nt hole 1/0/0 0\nt interpolateboundary 1/0/0 1\n"
    );
    let library = b"newmtl m\nKd 1 0 0\nmap_Kd -s 1 1 a.png\nd 0.5\nTr 0.5\nillum 2\n";
    let mut state = 0x1234_5678_9abc_def1_u64;
    let mut next = move |n: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 20) as usize % n
    };
    let pieces: [&[u8]; 14] = [
        b"nan",
        b"-",
        b"/",
        b"\\\n",
        b"\0",
        b"99999999999999999999",
        b"#",
        b"\r",
        b"f",
        b"t ",
        b"1e999",
        b" ",
        b"\xff",
        b"v ",
    ];
    for _ in 0..20_000 {
        let mut obj = good.as_bytes().to_vec();
        let mut mtl = library.to_vec();
        for _ in 0..1 + next(4) {
            let bytes = if next(4) == 0 { &mut mtl } else { &mut obj };
            let at = next(bytes.len());
            match next(4) {
                0 => bytes.truncate(at.max(1)),
                1 => bytes[at] = next(256) as u8,
                2 => {
                    bytes.splice(at..at, pieces[next(pieces.len())].iter().copied());
                }
                _ => {
                    let end = (at + next(30)).min(bytes.len());
                    let part = bytes[at..end].to_vec();
                    let to = next(bytes.len());
                    bytes.splice(to..to, part);
                }
            }
        }
        check("damaged", &obj, &mut none().with("a.mtl", mtl), &Clean);
    }
}

/// A folder that goes away with this value.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path =
            std::env::temp_dir().join(format!("earmark-input-{}-{name}", std::process::id()));
        fs::create_dir_all(path.join("models/sub")).unwrap();
        Self(fs::canonicalize(path).unwrap())
    }
    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn names_of_other_files_stay_in_the_folder() {
    let folder = Folder::new("names");
    fs::write(folder.path("secret.mtl"), b"newmtl m\nKd 1 0 0\n").unwrap();
    fs::write(folder.path("models/sub/in.mtl"), b"newmtl m\nKd 0 1 0\n").unwrap();
    fs::write(folder.path("models/big.mtl"), vec![b'#'; 100]).unwrap();
    let model = folder.path("models/m.obj");
    let mut resolver = FolderResolver::beside(&model).unwrap();
    let absolute = folder.path("secret.mtl");
    for bad in [
        "../secret.mtl",
        "sub/../../secret.mtl",
        "..\\secret.mtl",
        absolute.to_str().unwrap(),
        "/etc/passwd",
        "C:\\secret.mtl",
        "c:secret.mtl",
        "\\\\server\\share\\a.mtl",
        "http://example.org/a.mtl",
        "file:///etc/passwd",
        "a\0.mtl",
        "",
        ".",
        "..",
        "sub",
        "data:,x",
    ] {
        assert!(
            matches!(resolver.read(bad, 1000), Err(ResolveError::Refused(_))),
            "{bad}"
        );
        // Through the reader: a warning that names no content, and the mesh is there.
        let bytes = format!("mtllib {bad}\n{V}usemtl m\nf 1 2 3\n");
        let found = run(bytes.as_bytes(), &mut resolver).unwrap();
        assert_eq!(found.cage.materials()[0].diffuse, [0.8; 3], "{bad}");
        assert_eq!(found.warnings[0].kind(), WarningKind::Library, "{bad}");
        assert!(!printed(&Ok(found)).contains("root:"));
    }
    assert_eq!(resolver.read("none.mtl", 1000), Err(ResolveError::NotFound));
    assert_eq!(
        resolver.read("sub/in.mtl/x", 1000),
        Err(ResolveError::NotFound)
    );
    assert_eq!(
        resolver.read("big.mtl", 99),
        Err(ResolveError::TooLarge { limit: 99 })
    );
    for good in [
        "sub/in.mtl",
        "./sub/in.mtl",
        "sub\\in.mtl",
        "sub/../sub/in.mtl",
    ] {
        let bytes = format!("mtllib {good}\n{V}usemtl m\nf 1 2 3\n");
        let found = run(bytes.as_bytes(), &mut resolver).unwrap();
        assert_eq!(found.cage.materials()[0].diffuse, [0.0, 1.0, 0.0], "{good}");
        assert!(found.warnings.is_empty());
    }
    assert!(resolver.read(&"x/".repeat(5000), 1000).is_err());
    assert!(resolver.read(&"y".repeat(5000), 1000).is_err());
}

#[test]
fn models_are_regular_files() {
    let folder = Folder::new("models");
    let missing = files::read_model(&folder.path("none.obj"), 1000).unwrap_err();
    assert!(
        missing
            .to_string()
            .ends_with("none.obj: no such file or folder"),
        "{missing}"
    );
    assert_eq!(missing.kind(), FileErrorKind::Io);
    let directory = files::read_model(&folder.path("models"), 1000).unwrap_err();
    assert!(
        directory.to_string().ends_with("is a folder"),
        "{directory}"
    );
    fs::write(folder.path("a.obj"), b"").unwrap();
    assert_eq!(files::read_model(&folder.path("a.obj"), 1000).unwrap(), b"");
    assert!(files::read_model(&folder.path("a.obj/x"), 1000).is_err());
    assert!(files::read_model(Path::new(""), 1000).is_err());
    assert!(files::read_model(Path::new("a\0b"), 1000).is_err());
    // Sparse: large without taking space.
    let sparse = fs::File::create(folder.path("sparse.obj")).unwrap();
    sparse.set_len(1 << 40).unwrap();
    let error = files::read_model(&folder.path("sparse.obj"), 1 << 30).unwrap_err();
    assert_eq!(error.kind(), FileErrorKind::Limit);
}

#[cfg(unix)]
#[test]
fn links_pipes_and_devices() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new("links");
    fs::write(folder.path("secret.mtl"), b"newmtl m\n").unwrap();
    fs::write(folder.path("models/in.mtl"), b"newmtl m\n").unwrap();
    symlink(folder.path("secret.mtl"), folder.path("models/out.mtl")).unwrap();
    symlink("../secret.mtl", folder.path("models/relative.mtl")).unwrap();
    symlink("in.mtl", folder.path("models/inside.mtl")).unwrap();
    symlink(&folder.0, folder.path("models/up")).unwrap();
    symlink("/dev/zero", folder.path("models/zero.mtl")).unwrap();
    symlink("loop.mtl", folder.path("models/loop.mtl")).unwrap();
    let socket = std::os::unix::net::UnixListener::bind(folder.path("models/s.mtl"));
    let mut resolver = FolderResolver::beside(&folder.path("models/m.obj")).unwrap();
    for bad in ["out.mtl", "relative.mtl", "up/secret.mtl", "zero.mtl"] {
        assert!(
            matches!(resolver.read(bad, 1000), Err(ResolveError::Refused(_))),
            "{bad}"
        );
    }
    assert!(matches!(
        resolver.read("loop.mtl", 1000),
        Err(ResolveError::Io(_))
    ));
    assert_eq!(resolver.read("inside.mtl", 1000).unwrap(), b"newmtl m\n");
    if socket.is_ok() {
        assert_eq!(
            resolver.read("s.mtl", 1000),
            Err(ResolveError::Refused("is a socket"))
        );
    }
    let pipe = folder.path("models/pipe.mtl");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    if made.is_ok_and(|s| s.success()) {
        // Opening it the usual way would wait for a writer for ever.
        assert_eq!(
            resolver.read("pipe.mtl", 1000),
            Err(ResolveError::Refused("is a named pipe"))
        );
        let error = files::read_model(&pipe, 1000).unwrap_err();
        assert!(error.to_string().ends_with("is a named pipe"), "{error}");
        assert!(files::write_atomic(&pipe, b"x").is_err());
    }
    for device in ["/dev/null", "/dev/zero"] {
        let error = files::read_model(Path::new(device), 1000).unwrap_err();
        assert!(error.to_string().ends_with("is a device"), "{error}");
    }
    assert!(files::read_model(&folder.path("models/loop.mtl"), 1000).is_err());
    assert_eq!(
        files::read_model(&folder.path("models/out.mtl"), 1000).unwrap(),
        b"newmtl m\n"
    );
    if Path::new("/proc/kmsg").exists() {
        // Pseudo-files announce no bytes; nothing is read from them.
        assert!(
            files::read_model(Path::new("/proc/self/status"), 1000).is_ok_and(|b| b.is_empty())
        );
    }
}

/// A sheet of `n` by `n` squares, or twice as many triangles, all of whose inner edges have a sharpness.
fn sheet(n: u32, triangles: bool, sharpness: f32) -> Cage {
    let side = n + 1;
    let points = (0..side * side).map(|k| {
        let height = (k * 7 % 5) as f32 * 0.2;
        [(k % side) as f32, (k / side) as f32, height]
    });
    let mut builder = Cage::builder().points(points);
    for k in (0..side * n).filter(|k| k % side < n) {
        let [a, b, c, d] = [k, k + 1, k + side + 1, k + side];
        builder = match triangles {
            true => builder.face([a, b, c]).face([a, c, d]),
            false => builder.face([a, b, c, d]),
        };
        if sharpness > 0.0 {
            builder = builder.crease(a, b, sharpness).crease(d, a, sharpness);
        }
    }
    builder.build().unwrap()
}

/// Draws on one thread, whose tiles take a known share of the budget.
fn draw(scene: &Scene, refinement: Refinement, bytes: Option<u64>) -> Result<u64, RenderError> {
    let mut renderer = Renderer::new(48, 48);
    renderer.refinement = refinement;
    renderer.limits.max_memory = bytes;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let frame = pool
        .unwrap()
        .install(|| renderer.render(scene, &Camera::default()))?;
    Ok(frame.stats.pixels_covered)
}

/// With a small budget drawing fails for `wanted`, before much more than the budget is asked for, now and after the picture was drawn
/// with a large one; surfaces are made anew for each.
fn assert_bounded(scene: impl Fn() -> Scene, refinement: Refinement, small: u64, wanted: &str) {
    let fails = |scene: &Scene| match draw(scene, refinement, Some(small)) {
        Err(RenderError::Limit(LimitError::Memory {
            what,
            wanted: bytes,
            allowed,
        })) => {
            assert!(what.contains(wanted), "{what}");
            assert_eq!(allowed, small);
            assert!(bytes > small, "{bytes}");
            bytes
        }
        other => panic!("{other:?}"),
    };
    let fresh = scene();
    let bytes = fails(&fresh);
    assert!(bytes < 40 * small, "{bytes}");
    // Nothing was gained by trying.
    assert_eq!(fails(&fresh), bytes);
    assert!(draw(&fresh, refinement, Some(1 << 30)).unwrap() > 100);
    assert_eq!(fails(&fresh), bytes);
}

#[test]
fn control_faces_of_deep_sharpness_count_as_memory() {
    for triangles in [false, true] {
        let scene = || Scene::of(Surface::new(sheet(4, triangles, 9.0), &Default::default()));
        assert_bounded(scene, Refinement::Uniform(8), 4 << 20, "control faces");
        if !triangles {
            let adaptive = Refinement::Adaptive(Default::default());
            assert_bounded(scene, adaptive, 4 << 20, "control faces");
        }
    }
    // Without creases there is nothing to count but the picture.
    let plain = Scene::of(Surface::new(sheet(4, false, 0.0), &Default::default()));
    let refused = draw(&plain, Refinement::Uniform(8), Some(4 << 20)).unwrap_err();
    assert!(refused.to_string().contains("the picture"), "{refused}");
}

#[test]
fn meshes_and_tables_of_interpolating_surfaces_count_as_memory() {
    for (scheme, triangles) in [(Scheme::Kobbelt, false), (Scheme::Butterfly, true)] {
        let options = SurfaceOptions {
            scheme: Some(scheme),
            ..SurfaceOptions::default()
        };
        let scene = || Scene::of(Surface::new(sheet(4, triangles, 0.0), &options));
        assert_bounded(scene, Refinement::Uniform(9), 1 << 20, "refined mesh");
        assert_bounded(scene, Refinement::Uniform(5), 1 << 20, "tables");
    }
}
