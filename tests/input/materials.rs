//! Material libraries and what they name.

use super::{Clean, Render, V, Want, Warn, check, none};
use earmark::mesh::{MemoryFiles, WarningKind};

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
