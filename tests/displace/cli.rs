//! Bad input to the flags of displacement.

use std::path::PathBuf;
use std::process::Command;

fn folder() -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("displace");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Exit code and what was said.
fn render(flags: &[&str]) -> (Option<i32>, String) {
    let model = super::common::assets().join("octahedron.obj");
    let out = Command::new(env!("CARGO_BIN_EXE_earmark"))
        .arg("render")
        .arg(model)
        .args(["-o".into(), folder().join("out.png")])
        .args(["-s", "32x32", "-l", "1"])
        .args(flags)
        .output()
        .unwrap();
    (
        out.status.code(),
        String::from_utf8_lossy(&out.stderr).into_owned(),
    )
}

#[test]
fn what_cannot_be_is_refused_in_one_line() {
    let text = folder().join("text.png");
    std::fs::write(&text, "no picture").unwrap();
    let text = text.to_str().unwrap();
    // A header of 60000 by 60000 pixels, and nothing behind it: refused before anything is taken.
    let huge = folder().join("huge.png");
    let mut bytes = vec![0x89, b'P', b'N', b'G', 13, 10, 26, 10, 0, 0, 0, 13];
    let header = [
        &b"IHDR"[..],
        &60_000_u32.to_be_bytes(),
        &60_000_u32.to_be_bytes(),
        &[16, 6, 0, 0, 0],
    ]
    .concat();
    bytes.extend(&header);
    bytes.extend(crc(&header).to_be_bytes());
    std::fs::write(&huge, bytes).unwrap();
    let huge = huge.to_str().unwrap();
    for (flags, code, what) in [
        (&["--displace", "/nowhere.png"][..], 4, "/nowhere.png"),
        (&["--normal-map", "/nowhere.png"], 4, "/nowhere.png"),
        (&["--displace", text], 3, "text.png"),
        (&["--normal-map", text], 3, "text.png"),
        (&["--displace", huge], 3, "huge.png"),
        (&["--displace-noise", "wool"], 2, "perlin"),
        (&["--displace-noise", "fbm:octaves=99"], 2, "octaves=99"),
        (
            &["--displace-noise", "fbm:frequency=nan"],
            2,
            "frequency=nan",
        ),
        (&["--displace-noise", "fbm:colour=1"], 2, "colour"),
        (
            &["--displace-noise", "perlin", "--displace-scale", "inf"],
            2,
            "finite",
        ),
        (
            &["--displace-noise", "perlin", "--displace", text],
            2,
            "cannot be used with",
        ),
        (
            &["--displace-noise", "perlin", "--surface", "cage"],
            2,
            "cage",
        ),
        (&["--displace-per-pixel"], 2, "--displace"),
    ] {
        let (found, said) = render(flags);
        assert_eq!(found, Some(code), "{flags:?}: {said}");
        assert!(said.contains(what), "{flags:?}: {said}");
    }
}

#[test]
fn extremes_end_in_pictures() {
    for noise in [
        "perlin:frequency=1e6,seed=4294967295",
        "ridged:lacunarity=16,octaves=16",
        "ripples:t=-1e6",
    ] {
        for scale in ["0", "-0.1", "1e30", "1e-30"] {
            let (code, said) = render(&["--displace-noise", noise, "--displace-scale", scale]);
            assert_eq!(code, Some(0), "{noise} {scale}: {said}");
        }
    }
}

/// Checksum of a chunk of a PNG file.
fn crc(bytes: &[u8]) -> u32 {
    let step = |c: u32| {
        if c & 1 == 1 {
            0xedb8_8320 ^ (c >> 1)
        } else {
            c >> 1
        }
    };
    let all = bytes.iter().fold(u32::MAX, |c, &b| {
        (0..8).fold(c ^ u32::from(b), |c, _| step(c))
    });
    !all
}
