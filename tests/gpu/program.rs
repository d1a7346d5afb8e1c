//! The command line: refusal of software, exit codes, statistics.

use std::process::{Command, Output};

fn earmark(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_earmark"));
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    command.args(arguments).output().unwrap()
}

#[test]
fn software_is_refused_unless_allowed() {
    let Some(gpu) = crate::gpu("program") else {
        return;
    };
    let out = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("gpu_program.png");
    let _ = std::fs::remove_file(&out);
    let out = out.to_str().unwrap();
    let mut arguments = vec![
        "render",
        "assets/creature.obj",
        "-o",
        out,
        "-s",
        "128x96",
        "-l",
        "2",
        "--backend",
        "gpu",
        "--stats",
        "-",
    ];
    if gpu.adapter().kind == earmark::gpu::AdapterKind::Software {
        let refused = earmark(&arguments);
        let text = String::from_utf8_lossy(&refused.stderr);
        assert_eq!(refused.status.code(), Some(6), "{text}");
        assert!(text.contains("--allow-software-gpu"), "{text}");
        assert!(!std::path::Path::new(out).exists());
    }
    arguments.extend(["--allow-software-gpu", "--verbose"]);
    let drawn = earmark(&arguments);
    assert_eq!(
        drawn.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&drawn.stderr)
    );
    assert!(std::path::Path::new(out).exists());
    let stats: serde_json::Value = serde_json::from_slice(&drawn.stdout).unwrap();
    assert_eq!(stats["read_backs"], 1);
    assert_eq!(stats["bytes_down"], 4 * 128 * 96);
    assert!(stats["bytes_up"].as_u64().unwrap() > 0);
    // Said of it is the level that it was drawn at.
    let said = String::from_utf8_lossy(&drawn.stderr);
    assert!(said.contains("levels [2]"), "{said}");
    // With what is beside the picture.
    let faces = out.replace("program.png", "program_faces.png");
    let of_faces = format!("face={faces}");
    let with = earmark(&[&arguments[..], &["--aov", &of_faces]].concat());
    let said = String::from_utf8_lossy(&with.stderr);
    assert_eq!(with.status.code(), Some(0), "{said}");
    let stats: serde_json::Value = serde_json::from_slice(&with.stdout).unwrap();
    assert_eq!(stats["bytes_down"], 2 * 4 * 128 * 96);
    let faces = image::open(faces).unwrap().into_rgb8();
    assert_eq!(faces.dimensions(), (128, 96));
    assert!(faces.pixels().any(|p| p.0 != [0; 3]));
    // What it cannot draw it does not draw otherwise.
    arguments[1] = "assets/part_creased.obj";
    arguments.extend(["--scheme", "bilinear", "-l", "0"]);
    arguments.drain(6..8);
    let refused = earmark(&arguments);
    assert_eq!(refused.status.code(), Some(6));
    let listed = earmark(&["info", "--gpu", "--json"]);
    let list: serde_json::Value = serde_json::from_slice(&listed.stdout).unwrap();
    let names = list["adapters"].as_array().unwrap();
    assert!(
        names
            .iter()
            .any(|a| a["name"] == gpu.adapter().name.as_str())
    );
    println!("gpu program: 5 cases");
}

#[test]
fn benchmarks_of_frames_run_on_the_device() {
    let Some(gpu) = crate::gpu("benchmark") else {
        return;
    };
    let out = earmark(&[
        "bench",
        "frame",
        "assets/cube.obj",
        "--json",
        "--repeat",
        "2",
        "-s",
        "64x64",
        "-l",
        "3",
        "--backend",
        "gpu",
        "--allow-software-gpu",
    ]);
    let said = String::from_utf8_lossy(&out.stderr);
    assert_eq!(out.status.code(), Some(0), "{said}");
    let report: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    let rows = report["rows"].as_array().unwrap();
    let names: Vec<&str> = rows.iter().map(|r| r["stage"].as_str().unwrap()).collect();
    let timed = gpu.adapter().timestamps;
    let all = ["total", "dice", "tile", "shade", "film"];
    assert_eq!(names, all[..if timed { 5 } else { 1 }]);
    assert_eq!(rows[0]["items"], 6 * 64 * 2);
    assert!(
        rows.iter()
            .all(|r| r["wall_ms_min"].as_f64().unwrap() > 0.0)
    );
    println!("gpu benchmark: 1 case");
}
