//! `earmark bench`: what its suites report, not how long they take.

use crate::harness::{Folder, asset, code, earmark, run, stderr, stdout};
use std::fs;
use std::path::Path;

#[test]
fn bench_reports_rows_with_the_total_first() {
    let stages = [
        ("refine", &["total", "update", "dice"][..]),
        (
            "frame",
            &[
                "total", "update", "flatness", "setup", "bin", "dice", "tile", "shade", "film",
            ],
        ),
        (
            "raster",
            &[
                "total", "flatness", "setup", "bin", "dice", "tile", "shade", "film",
            ],
        ),
        (
            "evaluate",
            &["total", "single", "prepared", "batch", "grid"],
        ),
    ];
    for (suite, stages) in stages {
        let out = earmark()
            .args([
                "bench", suite, "--json", "--repeat", "2", "-l", "1", "-s", "32x32",
            ])
            .arg(asset("torus.obj"))
            .output()
            .unwrap();
        assert_eq!(code(&out), 0, "{}", stderr(&out));
        let json: serde_json::Value = serde_json::from_str(&stdout(&out)).unwrap();
        assert_eq!(json["repeat"], 2);
        let rows = json["rows"].as_array().unwrap();
        let names: Vec<&str> = rows.iter().map(|r| r["stage"].as_str().unwrap()).collect();
        assert_eq!(names, stages, "{suite}");
        for row in rows {
            for key in ["wall_ms", "cpu_ms"] {
                let min = row[format!("{key}_min")].as_f64().unwrap();
                assert!(min <= row[format!("{key}_median")].as_f64().unwrap());
            }
            assert!(row["items"].as_u64().unwrap() > 0, "{row}");
            assert!(row["ns_per_item_min"].is_number());
        }
    }
    // A torus has as many vertices as faces, and edges twice as many, at every level.
    let out = earmark()
        .args([
            "bench",
            "refine",
            "--json",
            "--repeat",
            "1",
            "-l",
            "2",
            "--normals",
        ])
        .output()
        .unwrap();
    let json: serde_json::Value = serde_json::from_str(&stdout(&out)).unwrap();
    assert_eq!(json["rows"][0]["items"], 4096 * 16);
}

#[test]
fn suites_with_their_own_work_take_no_model() {
    for suite in ["paper", "calibrate"] {
        let out = run(&["bench", suite, "cube.obj"]);
        assert_eq!(code(&out), 2);
    }
    let out = run(&["bench", "frame", "--page", "page.html"]);
    assert_eq!(code(&out), 2);
    let out = run(&["bench", "scale", "--page", "same", "--stats", "same"]);
    assert_eq!(code(&out), 2);
    assert!(stderr(&out).contains("--page and --stats are the same"));
    assert!(!Path::new("same").exists());
}

/// They would measure the processor and say nothing of it.
#[test]
fn suites_of_the_processor_refuse_a_gpu() {
    for suite in ["refine", "patches", "evaluate", "paper", "scale", "raster"] {
        let out = run(&["bench", suite, "--backend", "gpu"]);
        assert_eq!(code(&out), 2, "{suite}");
        let message = stderr(&out);
        assert!(message.contains("bench frame, cold and gpu"), "{message}");
    }
}

#[test]
fn cold_starts_processes_of_its_own() {
    let model = asset("cube.obj");
    let cold = |arguments: &[&str]| {
        let bench = ["bench", "cold", "--json", "--repeat", "2"];
        let own = ["-l", "2", "-s", "32x32", "--samples", "1"];
        earmark()
            .args(bench)
            .args(own)
            .args(arguments)
            .output()
            .unwrap()
    };
    let out = cold(&[model.to_str().unwrap()]);
    assert_eq!(code(&out), 0, "{}", stderr(&out));
    let json: serde_json::Value = serde_json::from_str(&stdout(&out)).unwrap();
    // The level went through to `render`.
    assert_eq!(json["microtriangles"], 6 * 16 * 2);
    assert_eq!(json["rows"].as_array().unwrap().len(), 1);
    assert!(json["rows"][0]["wall_ms_min"].as_f64().unwrap() > 0.0);
    assert!(json["peak_bytes"].as_u64().unwrap() > 0);
    assert_eq!(code(&cold(&["-"])), 2);
    let out = cold(&[model.to_str().unwrap(), "--background", "nonsense"]);
    assert_eq!(code(&out), 2);
}

#[test]
fn calibration_and_curves_say_what_they_measured() {
    let out = run(&["bench", "calibrate", "--json", "--repeat", "1"]);
    assert_eq!(code(&out), 0, "{}", stderr(&out));
    let json: serde_json::Value = serde_json::from_str(&stdout(&out)).unwrap();
    assert!(json["factor"].as_f64().unwrap() > 0.0);

    let folder = Folder::new("scale");
    let page = folder.path("page.html");
    let out = earmark()
        .args(["bench", "scale", "--repeat", "1", "-l", "2", "-s", "32x32"])
        .arg("--page")
        .arg(&page)
        .arg(asset("cube.obj"))
        .output()
        .unwrap();
    assert_eq!(code(&out), 0, "{}", stderr(&out));
    let text = stdout(&out);
    for row in ["level_0", "level_2", "threads_1", "samples_16"] {
        assert!(text.contains(row), "{text}");
    }
    let page = fs::read_to_string(page).unwrap();
    assert_eq!(page.matches("<svg").count(), 3);
    assert!(!page.contains("http"));
}
