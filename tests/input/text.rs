//! Files as a whole, and text of all kinds.

use super::{Error, Render, V, Warn, check_all};
use earmark::mesh::WarningKind;

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
