//! What is refused, with which code and message: arguments, models, inputs, limits.

use crate::harness::{Folder, assert_clean, asset, code, earmark, kept, run, stderr, stdout};
use std::fs;

/// Arguments behind a model and an output, and the code and a part of the message that they give.
const REFUSED: &[(&[&str], i32, &str)] = &[
    (&["--level", "11"], 2, "--level"),
    (&["--level", "-1"], 2, "--level"),
    (&["--level", "two"], 2, "--level"),
    (&["--max-level", "11"], 2, "--max-level"),
    (&["--size", "0x5"], 2, "--size"),
    (&["--size", "70000x5"], 2, "--size"),
    (&["--size", "100"], 2, "--size"),
    (&["--samples", "3"], 2, "--samples"),
    (&["--fov", "0"], 2, "--fov"),
    (&["--fov", "180"], 2, "--fov"),
    (&["--zoom", "-1"], 2, "--zoom"),
    (&["--zoom", "nan"], 2, "--zoom"),
    (&["--azimuth", "inf"], 2, "--azimuth"),
    (&["--near", "0"], 2, "--near"),
    (&["--near", "5", "--far", "5"], 2, "--near 5"),
    (&["--eye", "1,2"], 2, "--eye"),
    (&["--eye", "1,2,3", "--target", "1,2,3"], 2, "same point"),
    (&["--up", "0,0,0"], 2, "up vector"),
    (&["--background", "12345"], 2, "--background"),
    (&["--threads", "0"], 2, "--threads"),
    (&["--threads", "-3"], 2, "--threads"),
    (&["--timeout", "0"], 2, "--timeout"),
    (&["--max-memory", "lots"], 2, "--max-memory"),
    (&["--simd", "avx1024"], 2, "--simd"),
    (&["--shade", "toon"], 2, "--shade"),
    (
        &["--scheme", "loop"],
        3,
        "cube.obj:10: this face has 4 corners",
    ),
    (&["--scheme", "sqrt3"], 2, "--scheme"),
    (&["--no-such-flag"], 2, "--no-such-flag"),
    (&["-q", "-v"], 2, "--verbose"),
    (
        &["--size", "16383x16383", "--max-memory", "64M"],
        5,
        "limit",
    ),
    (&["--max-memory", "1K"], 5, "limit"),
    (&["--max-faces", "3", "--level", "2"], 5, "micro-faces"),
    (
        &["--color-map", "no-such-picture.png"],
        4,
        "no-such-picture.png",
    ),
];

/// Adapters are no part of a model, nor of its statistics.
#[test]
fn adapters_are_listed_alone() {
    for more in [&["cube.obj"][..], &["--stats", "-"]] {
        let out = run(&[&["info", "--gpu"][..], more].concat());
        assert_eq!(code(&out), 2, "{more:?}");
        assert!(stderr(&out).contains("--gpu"), "{more:?}");
    }
}

#[test]
fn bad_arguments_are_refused_before_any_work() {
    let folder = Folder::new("arguments");
    let out = folder.path("out.png");
    for (arguments, want, part) in REFUSED {
        let mut command = earmark();
        command
            .arg("render")
            .arg(asset("cube.obj"))
            .arg("-o")
            .arg(&out);
        let result = command.args(*arguments).output().unwrap();
        let message = assert_clean(&result);
        assert_eq!(code(&result), *want, "{arguments:?}: {message}");
        assert!(message.contains(part), "{arguments:?}: {message}");
        assert_eq!(folder.names(), Vec::<String>::new(), "{arguments:?}");
    }
}

/// Files that are no models, and how the message begins behind the file's name.
const BAD_MODELS: &[(&str, &str, i32)] = &[
    ("", ": ", 3),
    ("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 9\n", ":4: ", 3),
    ("v 0 0 0\nv 1 x 0\nv 1 1 0\nf 1 2 3\n", ":2: ", 3),
    ("v 0 0 nan\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", ":1: ", 3),
    (
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n\u{1b}[31m 1 1\nf 1 2 \u{1b}[0m\n",
        ":6: ",
        3,
    ),
];

#[test]
fn bad_models_name_file_and_line() {
    let folder = Folder::new("models");
    let out = folder.path("out.png");
    fs::write(&out, "old").unwrap();
    for (text, place, want) in BAD_MODELS {
        let model = folder.path("model.obj");
        fs::write(&model, text).unwrap();
        for verb in ["render", "refine"] {
            let out = if verb == "render" {
                out.clone()
            } else {
                folder.path("out.obj")
            };
            let result = earmark()
                .arg(verb)
                .arg(&model)
                .arg("-o")
                .arg(&out)
                .output()
                .unwrap();
            let message = assert_clean(&result);
            assert_eq!(code(&result), *want, "{text:?}: {message}");
            let begin = format!("{}{place}", model.display());
            assert!(message.lines().any(|l| l.starts_with(&begin)), "{message}");
            assert!(!message.contains('\u{1b}'), "{message:?}");
        }
        assert_eq!(kept(&out), "old");
        fs::remove_file(&model).unwrap();
        assert_eq!(folder.names(), ["out.png"]);
    }
}

#[test]
fn inputs_that_are_no_regular_files_are_refused() {
    let folder = Folder::new("inputs");
    let out = folder.path("out.png");
    let mut inputs = vec![folder.path("missing.obj"), folder.path("")];
    if cfg!(unix) {
        inputs.push("/dev/zero".into());
    }
    for input in inputs {
        let result = earmark()
            .arg("render")
            .arg(&input)
            .arg("-o")
            .arg(&out)
            .output()
            .unwrap();
        assert_clean(&result);
        assert_eq!(code(&result), 4, "{}", input.display());
        assert_eq!(folder.names(), Vec::<String>::new());
    }
}

#[test]
fn negative_numbers_are_values() {
    let folder = Folder::new("negative");
    let out = folder.path("out.png");
    let result = earmark()
        .args([
            "render",
            "-s",
            "32x32",
            "--azimuth",
            "-30",
            "--elevation",
            "-5.5",
        ])
        .args([
            "--eye", "-3,-2,-4", "--target", "-0.1,0,0", "--up", "0,-1,0",
        ])
        .arg(asset("cube.obj"))
        .arg("-o")
        .arg(&out)
        .output()
        .unwrap();
    assert_eq!(code(&result), 0, "{}", stderr(&result));
}

#[test]
fn missing_instructions_are_code_6_with_a_list() {
    let lacking = if cfg!(target_arch = "x86_64") {
        "neon"
    } else {
        "avx2"
    };
    let folder = Folder::new("simd");
    let result = earmark()
        .args(["render", "--simd", lacking, "-o"])
        .arg(folder.path("out.png"))
        .arg(asset("cube.obj"))
        .output()
        .unwrap();
    assert_eq!(code(&result), 6);
    assert!(stderr(&result).contains("scalar"), "{}", stderr(&result));
}

#[test]
fn control_faces_beyond_the_memory_are_code_5() {
    let folder = Folder::new("control");
    let model = folder.path("sharp.obj");
    let n = 8;
    let mut text = String::new();
    for k in 0..(n + 1) * (n + 1) {
        text += &format!("v {} {} {}\n", k % (n + 1), k / (n + 1), k % 3);
    }
    for k in (0..(n + 1) * n).filter(|k| k % (n + 1) < n) {
        let (a, b, c, d) = (k, k + 1, k + n + 2, k + n + 1);
        text += &format!("f {} {} {} {}\n", a + 1, b + 1, c + 1, d + 1);
        text += &format!("t crease 2/1/0 {a} {b} 9\nt crease 2/1/0 {a} {d} 9\n");
    }
    fs::write(&model, text).unwrap();
    let picture = folder.path("out.png");
    let [model, to] = [&model, &picture].map(|p| p.to_str().unwrap());
    let render = |memory: &str| {
        let sizes = ["--size", "32x32", "--threads", "1", "--max-memory", memory];
        run(&[&["render", model, "-o", to, "--level", "8"][..], &sizes].concat())
    };
    let refused = render("60M");
    let message = assert_clean(&refused);
    assert_eq!(code(&refused), 5, "{message}");
    assert!(message.contains("control faces"), "{message}");
    assert!(!picture.exists());
    let drawn = render("2G");
    assert_eq!(code(&drawn), 0, "{}", stderr(&drawn));
}

#[test]
fn depth_tags_are_read_or_refused() {
    let folder = Folder::new("depth-tags");
    let (file, out) = (folder.path("tags.txt"), folder.path("out.png"));
    let render = |tags: &std::ffi::OsStr, more: &[&str]| {
        let _ = fs::remove_file(&out);
        let run = earmark()
            .args(["render", "-s", "32x32", "--stats", "-", "--depth-tags"])
            .arg(tags)
            .args(more)
            .arg(asset("cube.obj"))
            .arg("-o")
            .arg(&out)
            .output()
            .unwrap();
        assert_eq!(out.exists(), code(&run) == 0);
        run
    };
    let write = |text: &str| fs::write(&file, text).unwrap();
    write("# a cube\n3 3 3 3\n3 3 3 3\n");
    for pattern in [
        &[][..],
        &["--pattern", "split"],
        &["--pattern", "equilateral"],
    ] {
        let run = render(file.as_os_str(), pattern);
        assert_eq!(code(&run), 0, "{}", stderr(&run));
        let json: serde_json::Value = serde_json::from_str(&stdout(&run)).unwrap();
        assert_eq!(json["microtriangles"], 6 * 128);
        assert!(json["stages"]["depth_tags_ms"].is_number());
        assert_eq!(
            json["stages"]["patterns_ms"].is_number(),
            !pattern.is_empty()
        );
    }
    for (text, message) in [
        (
            "1\n2\n11\n",
            "tags.txt:3: \"11\" is no integer from 0 to 10",
        ),
        (
            "1 2 3 4\n-5",
            "tags.txt:2: \"-5\" is no integer from 0 to 10",
        ),
        (
            "1 2 3\n4 5\n",
            "tags.txt:2: 5 depth tags at the end; the cage has 8 vertices",
        ),
        (
            "1 1 1 1 1 1 1 1\n1\n",
            "tags.txt:2: more than 8 depth tags; the cage has 8 vertices",
        ),
        (
            "",
            "tags.txt:1: 0 depth tags at the end; the cage has 8 vertices",
        ),
    ] {
        write(text);
        let run = render(file.as_os_str(), &[]);
        assert_eq!(code(&run), 3, "{text:?}");
        assert!(
            stderr(&run).trim_end().ends_with(message),
            "{}",
            stderr(&run)
        );
    }
    fs::remove_file(&file).unwrap();
    assert_eq!(code(&render(file.as_os_str(), &[])), 4);
    assert_eq!(code(&render(folder.path("").as_os_str(), &[])), 4);
    for source in ["distance", "curvature", "distance+curvature"] {
        assert_eq!(code(&render(source.as_ref(), &[])), 0);
    }
    for more in [
        ["--level", "3"],
        ["--adaptive", "1"],
        ["--pattern", "other"],
    ] {
        assert_eq!(code(&render("distance".as_ref(), &more)), 2, "{more:?}");
    }
    let lone = earmark()
        .args(["render", "--pattern", "split", "-o", "x.png"])
        .arg(asset("cube.obj"))
        .output()
        .unwrap();
    assert_eq!(code(&lone), 2);
}
