//! `earmark batch`: many commands in one process.

use super::exit::{Code, Failure};
use super::flags::RunningFlags;
use super::job::Job;
use super::messages::{error, note};
use super::outputs::{Output, commit_all};
use super::stats::Json;
use super::{Cli, Verb, command, guarded, watch};
use clap::{Args, FromArgMatches};
use earmark::files;
use earmark::mesh::obj::escape;
use std::io;
use std::path::{Path, PathBuf};

#[derive(Args, Debug)]
#[group(skip)]
pub(crate) struct Arguments {
    /// Jobs, a JSON line each: the arguments of a command, as ["render", "a.obj", "-o", "a.png"]; empty lines are left out, and - is
    /// standard input
    #[arg(value_name = "JOBS.jsonl")]
    jobs: PathBuf,
    #[command(flatten)]
    batch: BatchFlags,
    #[command(flatten)]
    pub(crate) running: RunningFlags,
}

#[derive(Args, Debug)]
#[command(next_help_heading = "Batch")]
struct BatchFlags {
    /// Run the I-th of N shares of the jobs only, I from 1 on: every N-th job [default: 1/1]
    #[arg(long, value_name = "I/N", value_parser = shard, allow_hyphen_values = true)]
    shard: Option<[usize; 2]>,
    /// Leave jobs out whose output is there already
    #[arg(long)]
    skip_existing: bool,
    /// End at the first job that fails
    #[arg(long)]
    fail_fast: bool,
}

fn shard(text: &str) -> Result<[usize; 2], String> {
    let number = |s: &str| match s.bytes().all(|b| b.is_ascii_digit()) {
        true => s.parse::<usize>().ok(),
        false => None,
    };
    match text.split_once('/').map(|(i, n)| (number(i), number(n))) {
        Some((Some(i), Some(n))) if (1..=n).contains(&i) => Ok([i, n]),
        _ => Err("not I/N with I from 1 to N".into()),
    }
}

/// A line of the file.
struct Line {
    number: usize,
    arguments: Vec<String>,
}

/// Reads all lines before any is run.
fn read(job: &Job, path: &Path) -> Result<Vec<Line>, Failure> {
    let most = job.memory_left().unwrap_or(u64::MAX) / 8;
    let (bytes, name) = match path.as_os_str() == "-" {
        true => {
            let name = "standard input".to_owned();
            (files::read_stream(&name, io::stdin().lock(), most)?, name)
        }
        false => {
            let name = escape(path.as_os_str().as_encoded_bytes(), 1024);
            (files::read_model(path, most)?, name)
        }
    };
    let mut out = Vec::new();
    for (k, line) in bytes.split(|&b| b == b'\n').enumerate() {
        let line = line.trim_ascii();
        if line.is_empty() {
            continue;
        }
        let wrong = |why: String| Failure::new(Code::Data, format!("{name}:{}: {why}", k + 1));
        let arguments: Vec<String> = serde_json::from_slice(line)
            .map_err(|e| wrong(format!("not a list of texts in JSON: {e}")))?;
        if arguments.first().is_some_and(|a| a == "batch") {
            return Err(wrong("a batch in a batch".into()));
        }
        if arguments.first().is_some_and(|a| a == "view") {
            return Err(wrong("a window in a batch".into()));
        }
        // It starts processes with the arguments of its own.
        if arguments.iter().take(2).eq(["bench", "cold"]) {
            return Err(wrong(
                "bench cold in a batch: it is a program's start that it measures".into(),
            ));
        }
        out.push(Line {
            number: k + 1,
            arguments,
        });
    }
    Ok(out)
}

/// How a job ended.
enum End {
    Done,
    Skipped,
    Failed(Failure),
}

/// Runs one line.
fn run_line(outer: &Job, a: &Arguments, line: &Line) -> End {
    let words = std::iter::once("earmark").chain(line.arguments.iter().map(String::as_str));
    let parsed = command()
        .color(clap::ColorChoice::Never)
        .try_get_matches_from(words)
        .and_then(|m| Cli::from_arg_matches(&m));
    let cli = match parsed {
        Ok(cli) => cli,
        Err(e) => {
            let text = e.to_string();
            let first = text.lines().next().unwrap_or_default();
            let first = first.strip_prefix("error: ").unwrap_or(first);
            return End::Failed(Failure::new(Code::Usage, first));
        }
    };
    if a.batch.skip_existing && cli.verb.output().is_some_and(|p| p.exists()) {
        return End::Skipped;
    }
    let done = guarded(|| {
        let mut job = outer.inner(cli.verb.running())?;
        cli.verb.run(&mut job)
    });
    match done {
        Ok(()) => End::Done,
        Err(failure) => End::Failed(failure),
    }
}

pub(crate) fn run(job: &mut Job, a: &Arguments) -> Result<(), Failure> {
    let stats = match &a.running.stats {
        Some(stats) => Some(Output::checked(stats, &[], &[&a.jobs])?),
        None => None,
    };
    let lines = job.time("read", |job| read(job, &a.jobs))?;
    let [share, shares] = a.batch.shard.unwrap_or([1, 1]);
    let own: Vec<&Line> = lines.iter().skip(share - 1).step_by(shares).collect();
    let counts = run_lines(job, a, &own);
    watch::end_jobs();
    let [done, skipped, failed] = counts?;
    note(&format!(
        "{done} jobs done, {skipped} left out, {failed} failed"
    ));
    finish(job, a, stats, own.len(), [done, skipped, failed])
}

/// Runs lines one after the other: how many were done, left out, and failed.
fn run_lines(job: &Job, a: &Arguments, own: &[&Line]) -> Result<[usize; 3], Failure> {
    let (mut done, mut skipped, mut failed) = (0, 0, 0);
    for (k, line) in own.iter().enumerate() {
        watch::begin_job(k + 1, own.len());
        // A signal, or the time of the whole, ends all; the time of a job ends that job.
        job.limits().check()?;
        match run_line(job, a, line) {
            End::Done => done += 1,
            End::Skipped => skipped += 1,
            End::Failed(failure) => {
                job.limits().check()?;
                failed += 1;
                let name = escape(a.jobs.as_os_str().as_encoded_bytes(), 1024);
                let why = match (failure.code, failure.message.as_str()) {
                    (Code::Different, _) => "pictures differ",
                    (_, why) => why.strip_prefix("earmark: ").unwrap_or(why),
                };
                error(&format!("{name}:{}: {why}", line.number));
                if a.batch.fail_fast {
                    break;
                }
            }
        }
    }
    Ok([done, skipped, failed])
}

/// Writes the statistics; the code says whether a job failed.
fn finish(
    job: &Job,
    a: &Arguments,
    stats: Option<Output>,
    jobs: usize,
    [done, skipped, failed]: [usize; 3],
) -> Result<(), Failure> {
    let mut staged = Vec::new();
    if let Some(stats) = stats {
        let middle = vec![
            ("jobs", Json::count(jobs)),
            ("done", Json::count(done)),
            ("skipped", Json::count(skipped)),
            ("failed", Json::count(failed)),
        ];
        let name = Json::text(a.jobs.display().to_string());
        let report = Json::Object(job.report(name, middle));
        staged.push(stats.stage(format!("{report}\n").as_bytes())?);
    }
    commit_all(staged)?;
    match failed {
        0 => Ok(()),
        n => Err(Failure::new(
            Code::Different,
            format!("earmark: {n} of {jobs} jobs failed"),
        )),
    }
}

impl Verb {
    /// The output by which a job is known to be done.
    fn output(&self) -> Option<PathBuf> {
        match self {
            Self::Render(a) => Some(a.output.clone()),
            Self::Refine(a) => Some(a.output.clone()),
            Self::Turntable(a) => Some(a.last_output()),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_read_or_refused() {
        assert_eq!(shard("2/3"), Ok([2, 3]));
        for text in ["", "0/3", "4/3", "1", "1/0", "a/b", "-1/3", "1/2/3"] {
            assert!(shard(text).is_err(), "{text}");
        }
    }
}
