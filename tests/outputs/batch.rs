//! `earmark batch`: many commands in one process, each as if it ran alone.

use super::harness::{Folder, asset, code, earmark, stderr, stdout};
use std::fs;
use std::process::Output;

/// A line with the arguments of `render` for a model and an output.
fn line(folder: &Folder, model: &str, output: &str, more: &[&str]) -> String {
    let mut words = vec!["render".to_owned(), asset(model).display().to_string()];
    words.extend(["-s".into(), "48x40".into(), "-o".into()]);
    words.push(folder.path(output).display().to_string());
    words.extend(more.iter().map(|m| (*m).to_owned()));
    serde_json::to_string(&words).unwrap()
}

fn batch(folder: &Folder, lines: &[String], more: &[&str]) -> Output {
    let jobs = folder.path("jobs.jsonl");
    fs::write(&jobs, lines.join("\n")).unwrap();
    let out = earmark()
        .arg("batch")
        .arg(&jobs)
        .args(more)
        .output()
        .unwrap();
    fs::remove_file(jobs).unwrap();
    out
}

#[test]
fn jobs_are_the_commands_themselves() {
    let folder = Folder::new("batch");
    let models = ["cube.obj", "torus.obj", "creature.obj"];
    let name = |m: &str| m.replace("obj", "png");
    let lines: Vec<String> = models
        .iter()
        .map(|m| line(&folder, m, &name(m), &[]))
        .collect();
    let out = batch(&folder, &lines, &["--stats", "-"]);
    assert_eq!(code(&out), 0, "{}", stderr(&out));
    let json: serde_json::Value = serde_json::from_str(&stdout(&out)).unwrap();
    assert_eq!(
        (&json["jobs"], &json["done"], &json["failed"]),
        (&3.into(), &3.into(), &0.into())
    );
    for model in models {
        let alone = folder.path("alone.png");
        let render = earmark()
            .arg("render")
            .arg(asset(model))
            .args(["-s", "48x40", "-o"])
            .arg(&alone)
            .output();
        assert_eq!(code(&render.unwrap()), 0);
        assert_eq!(
            fs::read(folder.path(&name(model))).unwrap(),
            fs::read(&alone).unwrap()
        );
    }
}

#[test]
fn a_failed_job_ends_nothing_but_itself() {
    let folder = Folder::new("batch-fails");
    let lines = [
        line(&folder, "cube.obj", "a.png", &[]),
        line(&folder, "none.obj", "b.png", &[]),
        String::new(),
        line(&folder, "cube.obj", "c.png", &["--level", "99"]),
        line(&folder, "cube.obj", "d.png", &["--timeout", "0.000001"]),
        r#"["paint"]"#.to_owned(),
        line(&folder, "cube.obj", "e.png", &[]),
    ];
    let out = batch(&folder, &lines, &[]);
    assert_eq!(code(&out), 1);
    assert_eq!(folder.names(), ["a.png", "e.png"]);
    let text = stderr(&out);
    for part in [
        "jobs.jsonl:2: ",
        "none.obj",
        "jobs.jsonl:4: ",
        "--level",
        "jobs.jsonl:5: not done after",
        "jobs.jsonl:6: ",
        "4 of 6 jobs failed",
    ] {
        assert!(text.contains(part), "{part} in {text}");
    }
    fs::remove_file(folder.path("e.png")).unwrap();
    let out = batch(&folder, &lines, &["--fail-fast"]);
    assert_eq!((code(&out), folder.names()), (1, vec!["a.png".to_owned()]));
}

#[test]
fn shares_and_what_is_there_are_left_out() {
    let folder = Folder::new("batch-shares");
    let lines: Vec<String> = (0..5)
        .map(|k| line(&folder, "cube.obj", &format!("{k}.png"), &[]))
        .collect();
    assert_eq!(code(&batch(&folder, &lines, &["--shard", "2/3"])), 0);
    assert_eq!(folder.names(), ["1.png", "4.png"]);
    fs::write(folder.path("1.png"), "old").unwrap();
    let out = batch(&folder, &lines, &["--skip-existing", "--stats", "-"]);
    assert_eq!(code(&out), 0);
    let json: serde_json::Value = serde_json::from_str(&stdout(&out)).unwrap();
    assert_eq!((&json["done"], &json["skipped"]), (&3.into(), &2.into()));
    assert_eq!(fs::read(folder.path("1.png")).unwrap(), b"old");
}

#[test]
fn lines_that_are_no_jobs_are_named_before_any_work() {
    let folder = Folder::new("batch-lines");
    let good = line(&folder, "cube.obj", "a.png", &[]);
    for bad in [
        "render a.obj",
        "{\"a\": 1}",
        "[1, 2]",
        "[\"batch\", \"x\"]",
        "[\"view\", \"x\"]",
        "[\"bench\", \"cold\"]",
        "[\"render\"",
    ] {
        let out = batch(&folder, &[good.clone(), bad.to_owned()], &[]);
        assert_eq!(code(&out), 3, "{bad}");
        assert!(stderr(&out).contains("jobs.jsonl:2: "), "{}", stderr(&out));
        assert_eq!(folder.names(), Vec::<String>::new());
    }
    assert_eq!(code(&batch(&folder, &[], &[])), 0);
    assert_eq!(code(&batch(&folder, &[good], &["--shard", "3/2"])), 2);
    assert_eq!(code(&batch(&folder, &[], &["--timeout", "0"])), 2);
}
