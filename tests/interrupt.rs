//! The program when things end early: signals, deadlines, pipes that nobody reads, devices that are full.
#![cfg(unix)]
#![allow(dead_code)]

#[path = "cli/harness.rs"]
mod harness;

use harness::{Folder, asset, code, earmark, stderr};
use std::io::{Read, Write};
use std::process::{Child, Command, Output, Stdio};

/// A picture that takes far longer than any of these tests.
fn slow(folder: &Folder) -> Command {
    let mut command = earmark();
    command
        .args([
            "render",
            "-s",
            "8192x8192",
            "--samples",
            "16",
            "-l",
            "10",
            "-o",
        ])
        .arg(folder.path("out.png"))
        .arg(asset("creature.obj"));
    command
}

fn signal(child: &Child, name: &str) {
    let status = Command::new("kill")
        .args(["-s", name, &child.id().to_string()])
        .status()
        .unwrap();
    assert!(status.success());
}

/// Waits until the program says something, which it does once its handlers are in place.
fn wait_for_output(child: &mut Child) {
    let mut byte = [0];
    child
        .stderr
        .as_mut()
        .unwrap()
        .read_exact(&mut byte)
        .unwrap();
}

#[test]
fn signals_end_the_work_and_leave_nothing() {
    for (name, number) in [("TERM", 15), ("INT", 2)] {
        let folder = Folder::new("signal");
        let mut child = slow(&folder)
            .arg("-v")
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        wait_for_output(&mut child);
        signal(&child, name);
        let out = child.wait_with_output().unwrap();
        assert_eq!(code(&out), 128 + number, "{}", stderr(&out));
        assert!(
            stderr(&out).contains(&format!("signal {number}")),
            "{}",
            stderr(&out)
        );
        assert_eq!(folder.names(), Vec::<String>::new());
    }
}

#[test]
fn signals_end_a_wait_for_input() {
    let folder = Folder::new("wait");
    let mut child = earmark()
        .args([
            "render",
            "-",
            "--format",
            "obj",
            "--progress",
            "always",
            "-o",
        ])
        .arg(folder.path("out.png"))
        .stdin(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let input = child.stdin.take();
    wait_for_output(&mut child);
    signal(&child, "TERM");
    let out = child.wait_with_output().unwrap();
    assert_eq!(code(&out), 143, "{}", stderr(&out));
    drop(input);
    assert_eq!(folder.names(), Vec::<String>::new());
}

#[test]
fn deadlines_end_the_work() {
    let folder = Folder::new("deadline");
    let out = slow(&folder).args(["--timeout", "0.3"]).output().unwrap();
    assert_eq!(code(&out), 5, "{}", stderr(&out));
    assert!(stderr(&out).contains("0.3 seconds"), "{}", stderr(&out));
    assert_eq!(folder.names(), Vec::<String>::new());
}

#[test]
fn deadlines_end_a_wait_for_input() {
    let folder = Folder::new("late");
    let mut child = earmark()
        .args(["render", "-", "--format", "obj", "--timeout", "0.2", "-o"])
        .arg(folder.path("out.png"))
        .stdin(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let input = child.stdin.take();
    let out = child.wait_with_output().unwrap();
    drop(input);
    assert_eq!(code(&out), 5, "{}", stderr(&out));
}

#[test]
fn standard_input_is_a_model_with_a_format() {
    let render = |arguments: &[&str]| -> Output {
        let mut child = earmark()
            .args(["render", "-", "-s", "32x32", "-o", "-"])
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let text = std::fs::read(asset("cube.obj")).unwrap();
        // Who refuses to read it closes the pipe.
        let _ = child.stdin.take().unwrap().write_all(&text);
        child.wait_with_output().unwrap()
    };
    let out = render(&["--format", "obj"]);
    assert_eq!(code(&out), 0, "{}", stderr(&out));
    assert!(out.stdout.starts_with(b"\x89PNG"));
    let out = render(&[]);
    assert_eq!(code(&out), 2);
    assert!(stderr(&out).contains("--format"));
    let out = render(&["--format", "obj", "-"]);
    assert_eq!(code(&out), 2);
}

#[test]
fn pipes_that_nobody_reads() {
    let closed = |arguments: &[&str]| {
        let mut child = earmark()
            .args(arguments)
            .arg(asset("creature.obj"))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        child.wait_with_output().unwrap()
    };
    // A picture is lost then, a text was read as far as somebody wanted to.
    let out = closed(&["render", "-s", "256x256", "-o", "-"]);
    assert_eq!(code(&out), 4, "{}", stderr(&out));
    assert!(stderr(&out).starts_with("standard output: "));
    let out = closed(&["info"]);
    assert_eq!((code(&out), stderr(&out)), (0, String::new()));
}

/// Runs the program in a shell with redirections behind its arguments.
fn in_shell(arguments: &str, redirections: &str) -> Output {
    let program = env!("CARGO_BIN_EXE_earmark");
    Command::new("sh")
        .args(["-c", &format!("'{program}' {arguments} {redirections}")])
        .output()
        .unwrap()
}

#[test]
fn closed_and_full_streams() {
    let folder = Folder::new("streams");
    let cube = asset("cube.obj").display().to_string();
    let out = folder.path("out.png").display().to_string();
    let render = format!("render '{cube}' -s 32x32 -o '{out}'");
    for redirections in ["<&-", ">&-", "2>&-", "<&- >&- 2>&-", "2>/dev/full"] {
        let result = in_shell(&render, redirections);
        assert_eq!(code(&result), 0, "{redirections}: {}", stderr(&result));
        assert_eq!(folder.names(), ["out.png"], "{redirections}");
        std::fs::remove_file(&out).unwrap();
        // Nor does a message that is lost change the code.
        let result = in_shell(&format!("{render} --level 11"), redirections);
        assert_eq!(code(&result), 2, "{redirections}");
        let result = in_shell(&format!("render missing.obj -o '{out}'"), redirections);
        assert_eq!(code(&result), 4, "{redirections}");
    }
    let result = in_shell(&format!("render '{cube}' -s 32x32 -o -"), ">/dev/full");
    assert_eq!(code(&result), 4, "{}", stderr(&result));
    let result = in_shell(&format!("info '{cube}'"), ">/dev/full");
    assert_eq!(code(&result), 4, "{}", stderr(&result));
}

#[test]
fn a_limit_of_file_sizes_is_an_error_and_leaves_the_old_file() {
    let folder = Folder::new("limit");
    let out = folder.path("out.obj");
    std::fs::write(&out, "old").unwrap();
    let program = env!("CARGO_BIN_EXE_earmark");
    let creature = asset("creature.obj").display().to_string();
    let command = format!(
        "ulimit -f 8; '{program}' refine '{creature}' -o '{}'",
        out.display()
    );
    let result = Command::new("sh").args(["-c", &command]).output().unwrap();
    assert_eq!(code(&result), 4, "{}", stderr(&result));
    assert_eq!(std::fs::read_to_string(&out).unwrap(), "old");
    assert_eq!(folder.names(), ["out.obj"]);
}

/// More pictures are accepted at once than files may be open.
#[test]
fn accepted_pictures_do_not_stay_open() {
    let folder = Folder::new("many");
    let (goldens, new) = (folder.path("goldens"), folder.path("new"));
    for path in [&goldens, &new] {
        std::fs::create_dir(path).unwrap();
    }
    let png = earmark::film::png::encode(&earmark::film::Image::new(2, 2)).unwrap();
    for k in 0..100 {
        std::fs::write(new.join(format!("{k}.png")), &png).unwrap();
    }
    let command = format!(
        "ulimit -n 40; '{}' compare '{}' '{}' --accept",
        env!("CARGO_BIN_EXE_earmark"),
        goldens.display(),
        new.display()
    );
    let result = Command::new("sh").args(["-c", &command]).output().unwrap();
    assert_eq!(code(&result), 0, "{}", stderr(&result));
    assert_eq!(std::fs::read_dir(&goldens).unwrap().count(), 100);
}
