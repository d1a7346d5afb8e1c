//! Help, versions, and what flags say of themselves.

use crate::harness::{VERBS, assert_clean, asset, code, earmark, run, stdout};
use std::fs;
use std::path::Path;

#[test]
fn help_texts_are_as_agreed() {
    let mut wrong = Vec::new();
    for verb in std::iter::once("").chain(VERBS) {
        let arguments: Vec<&str> = [verb, "--help"]
            .into_iter()
            .filter(|a| !a.is_empty())
            .collect();
        let out = run(&arguments);
        assert_eq!(code(&out), 0);
        let text = stdout(&out);
        let name = if verb.is_empty() { "earmark" } else { verb };
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/cli/help_{name}.txt"));
        if std::env::var_os("EARMARK_BLESS").is_some_and(|v| v == "1") {
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
    // The last two take nothing but a word.
    for verb in &VERBS[..VERBS.len() - 2] {
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

#[cfg(not(feature = "gpu"))]
#[test]
fn a_gpu_is_not_there_without_its_feature() {
    use crate::harness::{Folder, stderr};
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
