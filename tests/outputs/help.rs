//! Texts of the program about itself: every example of `--help` runs, scripts and pages are whole.

use super::harness::{Folder, VERBS, code, earmark, run, stderr, stdout};
use std::fs;
use std::process::Command;

/// Those with examples in their help: a window cannot be opened by a test.
fn verbs() -> impl Iterator<Item = &'static str> {
    VERBS.into_iter().filter(|v| *v != "view")
}

/// Commands among the examples of a help text.
fn examples(text: &str) -> Vec<String> {
    let Some(begin) = text.find("\nExamples:") else {
        return Vec::new();
    };
    let lines = text[begin..].lines();
    let commands = lines.filter(|l| l.trim_start().starts_with("earmark "));
    // One that is wrapped could not be copied.
    let whole = |l: &str| {
        assert!(l.chars().count() <= 80, "{l}");
        l.trim().to_owned()
    };
    commands.map(whole).collect()
}

#[test]
fn every_example_runs() {
    let folder = Folder::with_assets("examples");
    // What examples of comparisons take as given.
    let first = earmark()
        .args(["render", "cube.obj", "-o", "cube.png", "-s", "64x64"])
        .current_dir(folder.path(""))
        .status()
        .unwrap();
    assert!(first.success());
    for name in ["goldens", "new"] {
        fs::create_dir(folder.path(name)).unwrap();
        fs::copy(folder.path("cube.png"), folder.path(name).join("cube.png")).unwrap();
    }
    let job = r#"["render", "cube.obj", "-o", "a.png", "-s", "64x64"]"#;
    fs::write(folder.path("jobs.jsonl"), format!("{job}\n{job}\n")).unwrap();
    let program = earmark().get_program().to_owned();
    let program = fs::canonicalize(program).unwrap();
    let mut count = 0;
    for verb in verbs() {
        let text = stdout(&run(&[verb, "--help"]));
        let lines = examples(&text);
        assert!(!lines.is_empty(), "{verb} has no example");
        for line in lines {
            let command = line.replacen("earmark", "\"$EARMARK\"", 1);
            let out = Command::new("sh")
                .args(["-ec", &command])
                .env("EARMARK", &program)
                .env_remove("EARMARK_THREADS")
                .current_dir(folder.path(""))
                .output()
                .unwrap();
            assert_eq!(code(&out), 0, "{line}: {}", stderr(&out));
            count += 1;
        }
    }
    assert!(count >= 18, "{count} examples");
}

#[test]
fn completions_know_every_verb() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let out = run(&["completions", shell]);
        assert_eq!(code(&out), 0, "{}", stderr(&out));
        let text = stdout(&out);
        for word in VERBS
            .iter()
            .copied()
            .chain(["--azimuth", "--max-delta", "--count"])
        {
            let word = if shell == "fish" {
                word.trim_start_matches('-')
            } else {
                word
            };
            // As a word of its own: "man" is in "command".
            let part = |c: char| c.is_alphanumeric() || c == '-';
            let whole = |at: usize| {
                let (before, after) = (&text[..at], &text[at + word.len()..]);
                !before.ends_with(part) && !after.starts_with(part)
            };
            assert!(
                text.match_indices(word).any(|(at, _)| whole(at)),
                "{shell}: {word}"
            );
        }
        if shell == "bash" {
            let folder = Folder::new("completions");
            let script = folder.path("earmark.bash");
            fs::write(&script, &text).unwrap();
            if let Ok(checked) = Command::new("bash").arg("-n").arg(&script).output() {
                assert!(checked.status.success(), "{}", stderr(&checked));
            }
        }
    }
    assert_eq!(code(&run(&["completions", "dos"])), 2);
}

#[test]
fn manual_pages_are_roff() {
    let whole = run(&["man"]);
    assert_eq!(code(&whole), 0);
    let text = stdout(&whole);
    assert!(
        text.contains(".TH earmark 1") && VERBS.iter().all(|v| text.contains(v)),
        "{text}"
    );
    for verb in verbs() {
        let page = stdout(&run(&["man", verb]));
        assert!(page.contains(&format!(".TH earmark-{verb} 1")), "{page}");
        assert!(
            page.contains(".SH EXTRA") || page.contains("Examples"),
            "{verb}"
        );
    }
    assert_eq!(code(&run(&["man", "no-verb"])), 2);
}
