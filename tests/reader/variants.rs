//! The same text in other forms and cuts, against another reader and the standard library's numbers.

use super::{PLAIN, Random, library, parse, parse_with, random_file};
use earmark::mesh::NoFiles;
use earmark::mesh::obj::{ReadOptions, read};

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
