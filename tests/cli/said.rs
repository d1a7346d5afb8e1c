//! What is said of a model and a run: warnings, statistics, `info`.

use crate::harness::{Folder, asset, code, earmark, kept, run, stderr, stdout};
use std::fs;

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
