//! Indices, numbers, faces and tags.

use super::{Clean, Error, Render, V, Warn, check_all};
use earmark::mesh::WarningKind;

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
