//! The program as scripts see it: help texts, exit codes, messages, outputs that appear whole or not at all.

#[path = "cli/bench.rs"]
mod bench;
#[path = "cli/documented.rs"]
mod documented;
#[path = "cli/harness.rs"]
mod harness;

use harness::{Folder, assert_clean, asset, code, earmark, kept, run, stderr, stdout};
use std::fs;
use std::path::Path;

#[test]
fn help_texts_are_as_agreed() {
    let mut wrong = Vec::new();
    for verb in [
        "",
        "render",
        "view",
        "turntable",
        "refine",
        "info",
        "compare",
        "batch",
        "bench",
        "completions",
        "man",
    ] {
        let arguments: Vec<&str> = [verb, "--help"]
            .into_iter()
            .filter(|a| !a.is_empty())
            .collect();
        let out = run(&arguments);
        assert_eq!(code(&out), 0);
        let text = stdout(&out);
        let name = if verb.is_empty() { "earmark" } else { verb };
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/cli/help_{name}.txt"));
        if std::env::var_os("EARMARK_BLESS").is_some() {
            fs::write(&file, &text).unwrap();
            wrong.push(name);
        } else if fs::read_to_string(&file).unwrap_or_default() != text {
            wrong.push(name);
        }
    }
    // Blessing fails too, so that nobody blesses by accident.
    assert!(
        wrong.is_empty(),
        "help texts of {wrong:?} changed: look at them, set EARMARK_BLESS=1 once, and run again"
    );
}

#[test]
fn every_flag_says_its_default_or_takes_no_value() {
    for verb in [
        "render",
        "view",
        "turntable",
        "refine",
        "info",
        "compare",
        "batch",
        "bench",
    ] {
        let out = run(&[verb, "-h"]);
        let text = stdout(&out);
        for line in text.lines().filter(|l| l.contains(" --")) {
            let takes_value = line.contains(" <");
            let optional_file = [
                "--stats",
                "--stencils",
                "--color-map",
                "--normal-map",
                "--displace <",
                "--displace-noise",
                "--output",
                "--format",
                "--timeout",
                "--depth-tags",
                "--page",
                "--aov",
                "--views",
                "--diff",
                "--report",
            ];
            if takes_value && !optional_file.iter().any(|f| line.contains(f)) {
                let at = text.find(line).unwrap();
                let entry: String = text[at..].lines().take(4).collect();
                assert!(entry.contains("[default"), "{verb}: {line}");
            }
        }
    }
}

#[test]
fn version_and_no_verb() {
    let out = run(&["--version"]);
    assert_eq!(code(&out), 0);
    assert!(stdout(&out).starts_with("earmark "));
    assert_eq!(code(&run(&[])), 2);
    assert_eq!(code(&run(&["show", "a.obj"])), 2);
}

/// Without a display there is no window, and without the feature neither: the message says what to do.
#[test]
fn without_a_window_the_message_says_what_to_do() {
    let mut command = earmark();
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    let out = command.arg("view").arg(asset("cube.obj")).output().unwrap();
    let message = assert_clean(&out);
    assert_eq!(code(&out), 6, "{message}");
    assert!(message.contains("earmark render MODEL"), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");
}

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
fn outputs_are_checked() {
    let folder = Folder::new("outputs");
    let model = folder.path("cube.obj");
    fs::copy(asset("cube.obj"), &model).unwrap();
    fs::create_dir(folder.path("folder.png")).unwrap();
    let mut cases = vec![
        (folder.path("folder.png"), 4),
        (folder.path("missing/out.png"), 4),
        (folder.path("picture.bmp"), 2),
        (folder.path("picture"), 2),
        (model.clone(), 2),
    ];
    // An input by another name.
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&model, folder.path("link.png")).unwrap();
        cases.push((folder.path("link.png"), 4));
        std::os::unix::fs::symlink("/dev/null", folder.path("null.png")).unwrap();
        cases.push((folder.path("null.png"), 4));
    }
    let before = folder.names();
    for (out, want) in cases {
        let result = earmark()
            .arg("render")
            .arg(&model)
            .arg("-o")
            .arg(&out)
            .output()
            .unwrap();
        let message = assert_clean(&result);
        assert_eq!(code(&result), want, "{}: {message}", out.display());
        assert_eq!(folder.names(), before);
    }
    assert_eq!(kept(&model), kept(&asset("cube.obj")));
    let same = folder.path("same.png");
    let result = earmark()
        .arg("render")
        .arg(&model)
        .arg("-o")
        .arg(&same)
        .arg("--stats")
        .arg(&same)
        .output()
        .unwrap();
    assert_eq!(code(&result), 2);
    assert_eq!(folder.names(), before);
}

#[test]
fn pictures_replace_files_and_follow_links() {
    let folder = Folder::new("replace");
    let out = folder.path("out.png");
    fs::write(&out, "old").unwrap();
    let draw = |out: &Path| {
        let result = earmark()
            .args(["render", "-s", "64x48"])
            .arg(asset("cube.obj"))
            .arg("-o")
            .arg(out)
            .output()
            .unwrap();
        assert_eq!(code(&result), 0, "{}", stderr(&result));
        assert_eq!(stderr(&result), "");
    };
    draw(&out);
    let picture = fs::read(&out).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
    assert_eq!(&picture[16..24], &[0, 0, 0, 64, 0, 0, 0, 48]);
    #[cfg(unix)]
    {
        let link = folder.path("link.png");
        std::os::unix::fs::symlink("out.png", &link).unwrap();
        fs::write(&out, "old").unwrap();
        draw(&link);
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&out).unwrap(), picture);
    }
}

#[test]
fn the_same_bytes_whatever_the_threads_and_instructions() {
    let draw = |arguments: &[&str], variables: &[(&str, &str)]| {
        let out = earmark()
            .args(["render", "-o", "-", "-s", "96x96", "--level", "3"])
            .arg(asset("creature.obj"))
            .args(arguments)
            .envs(variables.iter().copied())
            .output()
            .unwrap();
        assert_eq!(code(&out), 0, "{}", stderr(&out));
        out.stdout
    };
    let picture = draw(&[], &[]);
    assert!(picture.starts_with(b"\x89PNG"));
    for arguments in [&["-j", "1"][..], &["-j", "3"], &["--simd", "scalar"]] {
        assert_eq!(draw(arguments, &[]), picture, "{arguments:?}");
    }
    let variables = [("EARMARK_THREADS", "2"), ("EARMARK_SIMD", "scalar")];
    assert_eq!(draw(&[], &variables), picture);
    assert_eq!(draw(&[], &[("RAYON_NUM_THREADS", "2")]), picture);
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
fn what_looks_like_a_mistake_is_warned_of() {
    let folder = Folder::new("warnings");
    let out = folder.path("out.png");
    let cases: &[(&[&str], &str)] = &[
        (
            &["--eye", "0,0,9", "--target", "0,0,20"],
            "no pixel is covered",
        ),
        (&["--eye", "0,9,0", "--target", "0,0,0"], "parallel"),
        (&["--shade", "uv"], "texture coordinates"),
        (&["-j", "100000"], "threads"),
    ];
    for (arguments, part) in cases {
        let draw = |more: &[&str]| {
            earmark()
                .args(["render", "-s", "32x32"])
                .arg(asset("cube.obj"))
                .arg("-o")
                .arg(&out)
                .args(*arguments)
                .args(more)
                .output()
                .unwrap()
        };
        let result = draw(&[]);
        assert_eq!(code(&result), 0);
        let message = stderr(&result);
        assert!(
            message.starts_with("warning: ") && message.contains(part),
            "{message}"
        );
        assert_eq!(message.lines().count(), 1, "{message}");
        assert_eq!(stderr(&draw(&["-q"])), "");
        let colored = stderr(&draw(&["--color", "always"]));
        assert!(colored.starts_with("\u{1b}["), "{colored:?}");
    }
}

#[test]
fn odd_edges_are_warned_of_with_their_lines() {
    let folder = Folder::new("odd-edges");
    let (model, out) = (folder.path("odd.obj"), folder.path("out.png"));
    // A third quad at the edge 1-2, and one wound the other way at 3-4; before them a face that is left out.
    let text = "\u{feff}v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 -1 0\nv 0 -1 0\nv 1 0 1\nv 0 0 1\nv 1 2 0\nv 0 2 0\n\
        f 1 1 2\nf 1 2 3 4\nf 2 1 6 5\n# a comment\n\nf 1 2 7 8\nf 3 4 10 9\n";
    fs::write(&model, text).unwrap();
    let refined = folder.path("fine.obj");
    let verbs: [&[&str]; 3] = [
        &["render", "-s", "32x32", "-o"],
        &["refine", "-l", "1", "-o"],
        &["info"],
    ];
    for verb in verbs {
        let mut command = earmark();
        command.args(verb);
        if verb.len() > 1 {
            command.arg(if verb[0] == "render" { &out } else { &refined });
        }
        let result = command.arg(&model).output().unwrap();
        assert_eq!(code(&result), 0, "{}", stderr(&result));
        let message = stderr(&result);
        for wanted in [
            "odd.obj:16: 1 edges with three",
            "odd.obj:17: 1 edges between",
        ] {
            assert!(message.contains(wanted), "{message}");
        }
    }
    // From standard input there is nothing to be read again.
    fs::write(
        &model,
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 2 3 4 1\n",
    )
    .unwrap();
    let result = earmark()
        .args(["info", "--triangulate", "--scheme", "loop"])
        .arg(&model)
        .output();
    assert_eq!(code(&result.unwrap()), 0);
}

#[test]
fn messages_stay_below_64_kilobytes() {
    let folder = Folder::new("flood");
    let mut command = earmark();
    command
        .args(["render", "-s", "16x16", "-v", "-o"])
        .arg(folder.path("out.png"));
    for k in 0..400 {
        let model = folder.path(&format!("{}{k}.obj", "long".repeat(40)));
        fs::write(
            &model,
            "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\nl 1 2\nbogus\nmtllib none.mtl\n",
        )
        .unwrap();
        command.arg(model);
    }
    let result = command.output().unwrap();
    assert_eq!(code(&result), 0);
    assert!(result.stderr.len() < 64 << 10, "{}", result.stderr.len());
    assert!(stderr(&result).contains("left out"));
}

#[test]
fn statistics_are_json_with_the_agreed_names() {
    let folder = Folder::new("stats");
    let (out, stats) = (folder.path("out.png"), folder.path("stats.json"));
    let result = earmark()
        .args(["render", "-s", "64x64", "-l", "2", "-j", "2"])
        .arg(asset("cube.obj"))
        .arg("-o")
        .arg(&out)
        .arg("--stats")
        .arg(&stats)
        .output()
        .unwrap();
    assert_eq!(code(&result), 0, "{}", stderr(&result));
    let json: serde_json::Value = serde_json::from_str(&kept(&stats)).unwrap();
    assert_eq!(json["faces"], 6);
    assert_eq!(json["microtriangles"], 6 * 16 * 2);
    assert_eq!(json["threads"], 2);
    assert!(json["pixels_covered"].as_u64().unwrap() > 500);
    for key in ["version", "model", "simd"] {
        assert!(json[key].is_string(), "{key}");
    }
    for key in ["wall_ms", "cpu_ms"] {
        assert!(json[key].is_number(), "{key}");
    }
    for stage in [
        "read", "connect", "setup", "bin", "dice", "tile", "shade", "film", "write",
    ] {
        for unit in ["ms", "cpu_ms"] {
            let key = format!("{stage}_{unit}");
            assert!(json["stages"][&key].is_number(), "{key} of {json}");
        }
    }
    if cfg!(target_os = "linux") {
        assert!(json["peak_bytes"].as_u64().unwrap() > 1 << 20);
    }
}

#[test]
fn schemes_of_refine() {
    let folder = Folder::new("schemes");
    let model = |name: &str, text: &str| {
        let path = folder.path(name);
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let tetrahedron = model(
        "tetrahedron.obj",
        "v 1 1 1\nv 1 -1 -1\nv -1 1 -1\nv -1 -1 1\nf 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n",
    );
    let mixed = model(
        "mixed.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nf 2 5 3\nf 1 2 3 4\nt crease 2/1/0 1 2 0.5\n",
    );
    let refine = |flags: &[&str], model: &str| {
        let mut all = vec!["refine", "-l", "1", "-o", "-"];
        all.extend(flags);
        all.push(model);
        run(&all)
    };
    let lines = |out: &std::process::Output, key: &str| -> Vec<String> {
        assert_eq!(code(out), 0, "{}", stderr(out));
        let text = stdout(out);
        let of_key = text.lines().filter(|l| l.starts_with(key));
        of_key.map(str::to_owned).collect()
    };
    let corners = |face: &String| face.split_whitespace().count() - 1;

    // Loop is for cages of triangles alone, and then it is the default.
    let out = refine(&[], &tetrahedron);
    assert_eq!((lines(&out, "v ").len(), lines(&out, "f ").len()), (10, 16));
    assert!(lines(&out, "f ").iter().all(|f| corners(f) == 3));
    assert_eq!(
        out.stdout,
        refine(&["--scheme", "loop"], &tetrahedron).stdout
    );
    let out = refine(&["--scheme", "catmull-clark"], &tetrahedron);
    assert!(lines(&out, "f ").iter().all(|f| corners(f) == 4));
    let out = refine(&[], &mixed);
    assert_eq!(lines(&out, "f ").len(), 7);

    // Butterfly, Kobbelt and bilinear keep the vertices.
    for scheme in ["butterfly", "kobbelt", "bilinear"] {
        let out = refine(&["--scheme", scheme], &tetrahedron);
        assert_eq!(
            lines(&out, "v ")[..4],
            ["v 1 1 1", "v 1 -1 -1", "v -1 1 -1", "v -1 -1 1"]
        );
    }

    // Other faces are refused by line, or made triangles.
    for scheme in ["loop", "butterfly"] {
        let out = refine(&["--scheme", scheme], &mixed);
        assert_eq!(code(&out), 3);
        let message = assert_clean(&out);
        assert!(
            message.contains("mixed.obj:7:") && message.contains("4 corners"),
            "{message}"
        );
        let out = refine(&["--scheme", scheme, "--triangulate"], &mixed);
        assert_eq!(lines(&out, "f ").len(), 12);
    }

    // Semi-sharp creases mean nothing to interpolating schemes, which say so.
    let out = refine(&["--scheme", "kobbelt"], &mixed);
    assert!(stderr(&out).contains("semi-sharp"), "{}", stderr(&out));
    assert!(!stderr(&refine(&["--scheme", "bilinear"], &mixed)).contains("semi-sharp"));

    let rule = |flags: &[&str], model: &str| {
        let mut all = vec!["info", "--json"];
        all.extend(flags);
        all.push(model);
        let json: serde_json::Value = serde_json::from_str(&stdout(&run(&all))).unwrap();
        let of = |key: &str| json["rules"]["scheme"][key].as_str().unwrap().to_owned();
        (of("value"), of("from"))
    };
    let is = |value: &str, from: &str| (value.to_owned(), from.to_owned());
    assert_eq!(rule(&[], &tetrahedron), is("loop", "default"));
    assert_eq!(rule(&[], &mixed), is("catmull-clark", "default"));
    assert_eq!(
        rule(&["--scheme", "kobbelt"], &mixed),
        is("kobbelt", "flag")
    );
}

#[test]
fn info_says_what_is_there_and_what_was_defaulted() {
    let out = run(&["info", "--json", asset("part.obj").to_str().unwrap()]);
    assert_eq!(code(&out), 0, "{}", stderr(&out));
    let json: serde_json::Value = serde_json::from_str(&stdout(&out)).unwrap();
    let arities = json["faces_by_arity"].as_object().unwrap();
    let faces: u64 = arities.values().map(|n| n.as_u64().unwrap()).sum();
    assert_eq!(json["faces"], faces);
    assert_eq!(json["rules"]["boundary"]["from"], "default");
    assert_eq!(json["rules"]["scheme"]["value"], "catmull-clark");
    assert!(json["boundary_edges"].as_u64().unwrap() > 0);
    assert_eq!(json["materials"][0]["name"], "steel");

    let folder = Folder::new("info");
    let model = folder.path("tagged.obj");
    let mut text = kept(&asset("cube.obj"));
    text.push_str("\nt crease 2/1/0 0 1 2.5\nt corner 1/1/0 0 10\nt hole 1/0/0 3\nt interpolateboundary 1/0/0 1\n");
    fs::write(&model, text).unwrap();
    let path = model.to_str().unwrap();
    let json: serde_json::Value =
        serde_json::from_str(&stdout(&run(&["info", "--json", path]))).unwrap();
    assert_eq!(json["creases"]["semi_sharp"], 1);
    assert_eq!(json["corners"]["sharp"], 1);
    assert_eq!(json["holes"], 1);
    assert_eq!(json["rules"]["boundary"]["from"], "file");
    let json = stdout(&run(&["info", "--json", "--boundary", "none", path]));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["rules"]["boundary"]["from"], "flag");
    assert_eq!(json["rules"]["boundary"]["value"], "none");
    let text = stdout(&run(&["info", path]));
    assert!(
        text.contains("6 quads") && text.contains("1 semi-sharp"),
        "{text}"
    );
}

#[test]
fn refine_writes_meshes_that_can_be_read_again() {
    let folder = Folder::new("refine");
    let out = folder.path("out.obj");
    let result = earmark()
        .args(["refine", "--level", "3"])
        .arg(asset("cube.obj"))
        .arg("-o")
        .arg(&out)
        .output()
        .unwrap();
    assert_eq!(code(&result), 0, "{}", stderr(&result));
    let json = stdout(&run(&["info", "--json", out.to_str().unwrap()]));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["faces"], 6 * 64);
    assert_eq!(json["vertices"], 6 * 64 + 2);

    // Limit points of the cube's corners; holes are left out.
    let model = folder.path("hole.obj");
    fs::write(&model, kept(&asset("cube.obj")) + "\nt hole 1/0/0 5\n").unwrap();
    let result = earmark()
        .args(["refine", "-l", "1", "--limit", "-o", "-"])
        .arg(&model)
        .output()
        .unwrap();
    assert_eq!(code(&result), 0, "{}", stderr(&result));
    let text = stdout(&result);
    let count = |key: &str| text.lines().filter(|l| l.starts_with(key)).count();
    assert_eq!((count("f "), count("vn ")), (5 * 4, 26));

    let ply = folder.path("out.ply");
    let result = earmark()
        .args(["refine", "-l", "1"])
        .arg(asset("creature.obj"))
        .arg("-o")
        .arg(&ply)
        .output()
        .unwrap();
    assert_eq!(code(&result), 0, "{}", stderr(&result));
    assert!(fs::read(&ply).unwrap().starts_with(b"ply\n"));

    // A thousand million faces are refused at once.
    let result = earmark()
        .args(["refine", "-l", "10"])
        .arg(asset("creature.obj"))
        .arg("-o")
        .arg(&out)
        .output()
        .unwrap();
    assert_eq!(code(&result), 5, "{}", stderr(&result));
    assert_eq!(folder.names(), ["hole.obj", "out.obj", "out.ply"]);
}

#[test]
fn refined_materials_are_found_from_the_output() {
    let folder = Folder::new("library");
    fs::create_dir(folder.path("in")).unwrap();
    for name in ["part.obj", "part.mtl"] {
        fs::copy(asset(name), folder.path("in").join(name)).unwrap();
    }
    for out in ["in/out.obj", "out.obj"] {
        let result = earmark()
            .args(["refine", "-l", "1"])
            .arg(folder.path("in/part.obj"))
            .arg("-o")
            .arg(folder.path(out))
            .output()
            .unwrap();
        assert_eq!(code(&result), 0, "{}", stderr(&result));
    }
    let json = stdout(&run(&[
        "info",
        "--json",
        folder.path("in/out.obj").to_str().unwrap(),
    ]));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["materials"].as_array().unwrap().len(), 2);
    assert_eq!(json["warnings"].as_array().unwrap().len(), 0, "{json}");
    assert!(kept(&folder.path("out.obj")).starts_with("mtllib in/part.mtl\n"));
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
fn patches_are_drawn_and_tensions_read() {
    let folder = Folder::new("patches");
    let (out, tags) = (folder.path("out.png"), folder.path("tags.txt"));
    let cube = asset("cube.obj");
    let draw = |more: &[&str]| {
        let mut arguments = vec![
            "render",
            cube.to_str().unwrap(),
            "-o",
            out.to_str().unwrap(),
        ];
        arguments.extend(["-s", "32x32", "-l", "3", "-q"]);
        arguments.extend(more);
        run(&arguments)
    };
    let tags_flag = ["--surface", "pn", "--pn-tags", tags.to_str().unwrap()];
    let mut pictures = Vec::new();
    let mut good = |more: &[&str]| {
        let done = draw(more);
        assert_eq!(code(&done), 0, "{}", stderr(&done));
        pictures.push(fs::read(&out).unwrap());
    };
    good(&["--surface", "limit"]);
    good(&["--surface", "qas"]);
    good(&["--surface", "pn"]);
    fs::write(&tags, "0 0 0 0\n0 0 0 0 # flat\n").unwrap();
    good(&tags_flag);
    fs::write(&tags, "1\n".repeat(8)).unwrap();
    good(&tags_flag);
    assert!(pictures[4] == pictures[2]);
    assert!((0..4).all(|i| (0..i).all(|k| pictures[i] != pictures[k])));
    for (text, line, part) in [
        ("1\n1 2\n", 2, "\"2\""),
        ("1\n1\n", 2, "2 numbers"),
        ("1 1 1 1 1 1 1 1\n1", 2, "more numbers"),
        ("1\nx\n", 2, "\"x\""),
    ] {
        fs::write(&tags, text).unwrap();
        let failed = draw(&tags_flag);
        let message = assert_clean(&failed);
        assert_eq!(code(&failed), 3, "{message}");
        assert!(
            message.contains(&format!("tags.txt:{line}: ")) && message.contains(part),
            "{message}"
        );
    }
    fs::remove_file(&tags).unwrap();
    assert_eq!(code(&draw(&tags_flag)), 4);
    assert_eq!(code(&draw(&["--pn-tags", tags.to_str().unwrap()])), 2);
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

#[test]
fn line_work_is_written_as_pixels_and_as_svg() {
    let folder = Folder::new("lines");
    let render = |out: &str, more: &[&str]| {
        let mut command = earmark();
        command.args(["render", "-s", "96x64", "-l", "2", "-o"]);
        command.arg(folder.path(out)).arg(asset("cube.obj"));
        command.args(more).output().unwrap()
    };
    assert_eq!(code(&render("plain.png", &[])), 0);
    let stats = folder.path("stats.json");
    let more = ["--overlay", "wireframe,cage,patches,axes", "--stats"];
    let more = [&more[..], &[stats.to_str().unwrap()]].concat();
    assert_eq!(code(&render("lines.png", &more)), 0);
    assert!(kept(&stats).contains("\"overlay_ms\":"));
    let bytes = |name: &str| fs::read(folder.path(name)).unwrap();
    assert_ne!(bytes("plain.png"), bytes("lines.png"));
    let alone = ["--shade", "wireframe", "--background", "ffffff"];
    for name in ["alone.png", "alone.svg"] {
        assert_eq!(code(&render(name, &alone)), 0, "{name}");
    }
    let text = kept(&folder.path("alone.svg"));
    assert!(text.starts_with("<svg xmlns") && text.contains("class=\"silhouettes\""));
    // A shaded picture is no line work, and layers have names.
    let shaded = render("x.svg", &[]);
    assert_eq!(code(&shaded), 2);
    assert!(assert_clean(&shaded).contains("--shade wireframe"));
    assert_eq!(code(&render("x.png", &["--overlay", "wires"])), 2);
    assert!(!folder.names().iter().any(|n| n.starts_with("x.")));
    let model = asset("cube.obj");
    let bench = run(&[
        "bench",
        "frame",
        model.to_str().unwrap(),
        "--overlay",
        "cage",
    ]);
    assert_eq!(code(&bench), 2);
    // Finer than lines can be.
    let mut command = earmark();
    command.args([
        "render",
        "-s",
        "96x64",
        "-l",
        "10",
        "--shade",
        "wireframe",
        "-v",
        "-o",
    ]);
    let out = command
        .arg(folder.path("deep.png"))
        .arg(asset("cube.obj"))
        .output()
        .unwrap();
    assert_eq!(code(&out), 0);
    assert!(
        stderr(&out).contains("lines are those of level"),
        "{}",
        stderr(&out)
    );
}

#[cfg(not(feature = "gpu"))]
#[test]
fn a_gpu_is_not_there_without_its_feature() {
    let folder = Folder::new("no_gpu");
    let out = folder.path("a.png");
    let model = asset("cube.obj");
    let mut command = earmark();
    command.arg("render").arg(&model).arg("-o").arg(&out);
    let drawn = command.args(["--backend", "gpu"]).output().unwrap();
    assert_eq!(code(&drawn), 6, "{}", stderr(&drawn));
    assert!(stderr(&drawn).contains("there is: cpu"));
    assert!(!out.exists());
    assert_eq!(code(&run(&["info", "--gpu"])), 6);
}
