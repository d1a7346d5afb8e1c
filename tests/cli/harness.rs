//! Running the program, and folders that go away.

#[path = "../common/folder.rs"]
mod folder;

pub(crate) use folder::Folder;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The program in a plain environment.
pub(crate) fn earmark() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_earmark"));
    let variables = [
        "EARMARK_THREADS",
        "EARMARK_SIMD",
        "RAYON_NUM_THREADS",
        "NO_COLOR",
        "COLUMNS",
        "CLICOLOR_FORCE",
    ];
    for variable in variables {
        command.env_remove(variable);
    }
    command
}

/// Verbs that print help of their own.
pub(crate) const VERBS: [&str; 10] = [
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
];

pub(crate) fn run(arguments: &[&str]) -> Output {
    earmark().args(arguments).output().unwrap()
}

/// The exit code; a program ended by a signal has none.
pub(crate) fn code(out: &Output) -> i32 {
    out.status.code().unwrap_or(-1)
}

pub(crate) fn stdout(out: &Output) -> String {
    String::from_utf8(out.stdout.clone()).unwrap()
}

pub(crate) fn stderr(out: &Output) -> String {
    String::from_utf8(out.stderr.clone()).unwrap()
}

/// A failure says why, in printable text, and is no panic. Returns the message.
pub(crate) fn assert_clean(out: &Output) -> String {
    let message = stderr(out);
    assert!(![0, -1, 70, 101].contains(&code(out)), "{message}");
    assert!(out.stdout.is_empty());
    assert!(message.len() > 10 && message.len() < 64 << 10, "{message}");
    assert!(!message.contains("panicked"), "{message}");
    let raw = |c: char| c.is_control() && c != '\n';
    assert!(!message.contains(raw), "{message:?}");
    message
}

pub(crate) fn asset(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("assets")
        .join(name)
}

pub(crate) fn kept(path: &Path) -> String {
    fs::read_to_string(path).unwrap()
}
