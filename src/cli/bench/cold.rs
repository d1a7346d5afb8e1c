//! `earmark bench cold`: `earmark render` as its users start it, a fresh process each time, from the model's file to the PNG's.

use super::{Arguments, Outcome, push};
use crate::cli::exit::{Code, Failure};
use crate::cli::job::Job;
use crate::cli::stats::Time;
use earmark::Cage;
use std::ffi::OsString;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

/// A folder that is gone with this value.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Result<Self, Failure> {
        let name = format!("earmark-bench-{}", std::process::id());
        let path = std::env::temp_dir().join(name);
        let failed = |e: std::io::Error| Failure::new(Code::Io, format!("{}: {e}", path.display()));
        std::fs::create_dir(&path).map_err(failed)?;
        Ok(Self(path))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What cannot be removed is the system's to clean up.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// What this process was asked, less what only `bench` knows: the arguments of `render` but for model and outputs.
fn passed_on(model: Option<&Path>) -> Vec<OsString> {
    let mut rest = std::env::args_os().skip(1).collect::<Vec<_>>().into_iter();
    let mut out = Vec::new();
    let mut verbs = ["bench", "cold"].into_iter().peekable();
    let mut model = model.map(Path::as_os_str);
    while let Some(argument) = rest.next() {
        if verbs.peek().is_some_and(|v| argument == *v) {
            verbs.next();
        } else if argument == "--json" || argument == "--normals" {
            // Ours.
        } else if ["--repeat", "--stats", "--page"]
            .iter()
            .any(|f| argument == *f)
        {
            rest.next();
        } else if ["--repeat=", "--stats=", "--page="]
            .iter()
            .any(|f| argument.as_encoded_bytes().starts_with(f.as_bytes()))
        {
            // Ours with its value.
        } else if model.is_some_and(|m| argument == m) {
            model = None;
        } else {
            out.push(argument);
        }
    }
    out
}

/// A cage as a file.
fn obj_text(cage: &Cage) -> String {
    let mut text = String::new();
    for [x, y, z] in cage.points() {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for face in 0..cage.face_count() {
        text.push('f');
        for v in cage.face(face) {
            let _ = write!(text, " {}", v + 1);
        }
        text.push('\n');
    }
    text
}

/// A number of a report.
fn number(report: &serde_json::Value, key: &str) -> u64 {
    report[key].as_u64().unwrap_or(0)
}

pub(super) fn cold(job: &Job, a: &Arguments, built_in: &Cage) -> Result<Outcome, Failure> {
    if a.model_path.as_deref() == Some(Path::new("-")) {
        return Err(Failure::usage(
            "bench cold reads its model again and again: it needs a file",
        ));
    }
    let limits = job.limits();
    let folder = Folder::new()?;
    let own = folder.0.join("torus.obj");
    let model = match &a.model_path {
        Some(path) => path.as_path(),
        None => {
            let text = obj_text(built_in);
            std::fs::write(&own, text)
                .map_err(|e| Failure::new(Code::Io, format!("{}: {e}", own.display())))?;
            own.as_path()
        }
    };
    let failed = |e: std::io::Error| Failure::new(Code::Io, format!("cannot start: {e}"));
    let program = std::env::current_exe().map_err(failed)?;
    let (picture, stats) = (folder.0.join("out.png"), folder.0.join("stats.json"));
    let (mut rows, mut peak) = (Vec::new(), 0);
    let mut last = serde_json::Value::Null;
    for _ in 0..a.repeat {
        limits.check()?;
        let clock = Instant::now();
        let out = Command::new(&program)
            .arg("render")
            .arg(model)
            .arg("-o")
            .arg(&picture)
            .arg("--stats")
            .arg(&stats)
            .args(passed_on(a.model_path.as_deref()))
            .stdin(Stdio::null())
            .output()
            .map_err(failed)?;
        let wall = clock.elapsed().as_secs_f64() * 1e3;
        if !out.status.success() {
            let said = String::from_utf8_lossy(&out.stderr).trim().to_owned();
            let said = said.strip_prefix("earmark: ").unwrap_or(&said);
            let code = Code::of_child(out.status);
            return Err(Failure::new(
                code,
                format!("earmark: render failed: {said}"),
            ));
        }
        let text = std::fs::read(&stats).map_err(failed)?;
        last = serde_json::from_slice(&text)
            .map_err(|e| Failure::new(Code::Data, format!("render's statistics: {e}")))?;
        let cpu = last["cpu_ms"].as_f64().unwrap_or(0.0);
        let items = |_: &str| 1;
        push(&mut rows, "total", Time { wall, cpu }, &items);
        peak = peak.max(number(&last, "peak_bytes"));
    }
    Ok(Outcome {
        rows,
        faces: number(&last, "faces"),
        microtriangles: number(&last, "microtriangles"),
        pixels: number(&last, "pixels_covered"),
        peak_bytes: Some(peak),
        lines: format!("peak {:.1} MB\n", peak as f64 / 1e6),
        ..Outcome::default()
    })
}
