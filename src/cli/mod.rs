//! Arguments to verbs, and verbs to exit codes.

mod bench;
mod bench_evaluate;
mod bench_paper;
mod bench_patches;
mod displace;
mod exit;
mod flags;
mod gpu;
mod info;
mod job;
mod messages;
mod pn_tags;
mod refine;
mod render;
mod stats;
mod watch;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use exit::{Code, Failure};
use flags::{RunningFlags, When};
use job::Job;
use std::ffi::OsString;
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::Instant;

/// Subdivision surfaces without a GPU: from control cage to finished picture on CPU cores.
#[derive(Parser, Debug)]
#[command(
    name = "earmark",
    version,
    max_term_width = 110,
    after_help = exit::HELP,
    subcommand_required = true,
    arg_required_else_help = true
)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand, Debug)]
enum Verb {
    /// Draw models into a PNG picture
    Render(render::Arguments),
    /// Write the refined mesh as OBJ or PLY
    Refine(refine::Arguments),
    /// Say what is in a model, and what was defaulted
    Info(info::Arguments),
    /// Measure on this machine, in process and without output files
    Bench(bench::Arguments),
}

impl Verb {
    fn running(&self) -> &RunningFlags {
        match self {
            Self::Render(a) => &a.running,
            Self::Refine(a) => &a.running,
            Self::Info(a) => &a.running,
            Self::Bench(a) => &a.running,
        }
    }
    fn run(&self, job: &mut Job) -> Result<(), Failure> {
        match self {
            Self::Render(a) => render::run(job, a),
            Self::Refine(a) => refine::run(job, a),
            Self::Info(a) => info::run(job, a),
            Self::Bench(a) => bench::run(job, a),
        }
    }
}

/// Runs the program.
pub(crate) fn main() -> ExitCode {
    let start = Instant::now();
    let code = match parse() {
        Err(code) => code,
        Ok(cli) => {
            let flags = cli.verb.running();
            messages::init(flags.quiet, flags.verbose, flags.color);
            finish(guarded(|| run(start, &cli)))
        }
    };
    ExitCode::from(code.number())
}

/// One message and the code. Signals and the deadline have no say from here on.
fn finish(result: Result<(), Failure>) -> Code {
    messages::clear_progress();
    match result {
        Ok(()) => Code::Done,
        Err(failure) => {
            watch::settle_late();
            messages::error(&failure.message);
            failure.code
        }
    }
}

fn run(start: Instant, cli: &Cli) -> Result<(), Failure> {
    let mut job = Job::new(start, cli.verb.running())?;
    job.watch();
    let pool = job.pool()?;
    pool.install(|| cli.verb.run(&mut job))
}

/// Turns a panic, which is a defect, into a failure with a message that can be reported.
fn guarded(work: impl FnOnce() -> Result<(), Failure>) -> Result<(), Failure> {
    static PLACE: Mutex<String> = Mutex::new(String::new());
    std::panic::set_hook(Box::new(|info| {
        if let Ok(mut place) = PLACE.lock() {
            let what = info.payload();
            let what = what
                .downcast_ref::<&str>()
                .map(|s| (*s).to_owned())
                .or_else(|| what.downcast_ref::<String>().cloned());
            let at = info
                .location()
                .map(|l| format!(" ({}:{})", l.file(), l.line()));
            *place = what.unwrap_or_default() + &at.unwrap_or_default();
        }
    }));
    match std::panic::catch_unwind(std::panic::AssertUnwindSafe(work)) {
        Ok(result) => result,
        Err(_) => {
            let place = PLACE.lock().map(|p| p.clone()).unwrap_or_default();
            Err(Failure::new(
                Code::Internal,
                format!("earmark: internal error, please report it: {place}"),
            ))
        }
    }
}

/// Arguments, or the code to end with after help or a usage error has been printed.
fn parse() -> Result<Cli, Code> {
    let arguments: Vec<OsString> = std::env::args_os().collect();
    let color = match asked_color(&arguments) {
        Some(When::Always) => clap::ColorChoice::Always,
        Some(When::Never) => clap::ColorChoice::Never,
        _ => clap::ColorChoice::Auto,
    };
    let error = match Cli::command().color(color).try_get_matches_from(arguments) {
        Ok(matches) => match Cli::from_arg_matches(&matches) {
            Ok(cli) => return Ok(cli),
            Err(e) => e,
        },
        Err(e) => e,
    };
    if error.use_stderr() {
        messages::error_text(&error.render().to_string());
        return Err(Code::Usage);
    }
    // Help or version; whoever does not want to read it to the end need not.
    match error.print() {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Code::Io),
        _ => Err(Code::Done),
    }
}

/// `--color` is wanted before the arguments are understood.
fn asked_color(arguments: &[OsString]) -> Option<When> {
    let mut rest = arguments.iter().map(|a| a.to_string_lossy());
    while let Some(argument) = rest.next() {
        let value = match argument.strip_prefix("--color") {
            Some("") => rest.next()?.into_owned(),
            Some(value) => value.strip_prefix('=')?.to_owned(),
            None => continue,
        };
        return match value.as_str() {
            "always" => Some(When::Always),
            "never" => Some(When::Never),
            _ => None,
        };
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_is_consistent() {
        Cli::command().debug_assert();
    }
}
