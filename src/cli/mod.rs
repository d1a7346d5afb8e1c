//! Arguments to verbs, and verbs to exit codes.

mod aov;
mod batch;
mod bench;
mod compare;
mod displace;
mod draw;
mod examples;
mod exit;
mod flags;
mod gpu;
mod info;
mod job;
mod machine;
mod messages;
mod outputs;
mod pn_tags;
mod refine;
mod render;
mod stats;
mod texts;
mod turntable;
mod view;
mod views;
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
    #[command(after_long_help = examples::RENDER)]
    Render(Box<render::Arguments>),
    /// Show models in a window
    View(Box<view::Arguments>),
    /// Draw a model that turns: numbered pictures, or one animated PNG
    #[command(after_long_help = examples::TURNTABLE)]
    Turntable(Box<turntable::Arguments>),
    /// Write the refined mesh as OBJ or PLY
    #[command(after_long_help = examples::REFINE)]
    Refine(refine::Arguments),
    /// Say what is in a model, and what was defaulted
    #[command(after_long_help = examples::INFO)]
    Info(info::Arguments),
    /// Compare pictures with golden ones, or folders of them
    #[command(after_long_help = examples::COMPARE)]
    Compare(compare::Arguments),
    /// Run many commands in one process
    #[command(after_long_help = examples::BATCH)]
    Batch(batch::Arguments),
    /// Measure on this machine, in process and without output files
    #[command(after_long_help = examples::BENCH)]
    Bench(Box<bench::Arguments>),
    /// Print a script that completes commands in a shell
    #[command(after_long_help = examples::COMPLETIONS)]
    Completions(texts::Completions),
    /// Print a manual page (roff)
    #[command(after_long_help = examples::MAN)]
    Man(texts::Manual),
}

impl Verb {
    /// Flags of verbs that do work; the others print a text.
    fn running(&self) -> Option<&RunningFlags> {
        match self {
            Self::Render(a) => Some(&a.running),
            Self::View(a) => Some(&a.running),
            Self::Turntable(a) => Some(&a.render.running),
            Self::Refine(a) => Some(&a.running),
            Self::Info(a) => Some(&a.running),
            Self::Compare(a) => Some(a.running()),
            Self::Batch(a) => Some(&a.running),
            Self::Bench(a) => Some(&a.running),
            Self::Completions(_) | Self::Man(_) => None,
        }
    }
    fn run(&self, job: &mut Job) -> Result<(), Failure> {
        match self {
            Self::Completions(a) => texts::completions(a, command()),
            Self::Man(a) => texts::manual(a, command()),
            Self::Render(a) => render::run(job, a),
            Self::View(a) => view::run(job, a),
            Self::Turntable(a) => turntable::run(job, a),
            Self::Refine(a) => refine::run(job, a),
            Self::Info(a) => info::run(job, a),
            Self::Compare(a) => compare::run(job, a),
            Self::Batch(a) => batch::run(job, a),
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
            if let Some(flags) = cli.verb.running() {
                messages::init(flags.quiet, flags.verbose, flags.color);
            }
            finish(guarded(|| run(start, &cli)))
        }
    };
    ExitCode::from(code.number())
}

/// The arguments with what clap's attributes cannot say.
fn command() -> clap::Command {
    let command = Cli::command().mut_subcommand("view", view::adapted);
    command.mut_subcommand("turntable", |turntable| {
        turntable
            .mut_arg("output", |output| {
                output
                    .value_name("F_####.png")
                    .help("Pictures to write (.png): # stand for the digits of the frame's number; without # one animated PNG, and - is standard output")
            })
            .mut_arg("aov", |a| a.hide(true))
            .mut_arg("views", |a| a.hide(true))
            .mut_arg("eye", |a| a.hide(true))
    })
}

/// One message and the code. Signals and the deadline have no say from here on.
fn finish(result: Result<(), Failure>) -> Code {
    messages::clear_progress();
    match result {
        Ok(()) => Code::Done,
        Err(failure) => {
            watch::settle_late();
            // Of a difference all was said on standard output.
            if !failure.message.is_empty() {
                messages::error(&failure.message);
            }
            failure.code
        }
    }
}

fn run(start: Instant, cli: &Cli) -> Result<(), Failure> {
    let mut running = cli.verb.running().cloned().unwrap_or_default();
    if matches!(cli.verb, Verb::View(_)) {
        // The window shows what goes on.
        running.progress = When::Never;
    }
    let mut job = Job::new(start, &running)?;
    job.watch();
    if let Verb::View(a) = &cli.verb {
        // A window belongs to the main thread; its pictures are drawn in a pool of their own.
        return view::run(&mut job, a);
    }
    let pool = job.pool()?;
    pool.install(|| cli.verb.run(&mut job))
}

/// What the last panic said, and where it was.
static PLACE: Mutex<String> = Mutex::new(String::new());

/// The failure that a panic is: a defect, with a message that can be reported.
fn internal() -> Failure {
    let place = PLACE.lock().map(|p| p.clone()).unwrap_or_default();
    Failure::new(
        Code::Internal,
        format!("earmark: internal error, please report it: {place}"),
    )
}

/// Turns a panic into a failure.
fn guarded(work: impl FnOnce() -> Result<(), Failure>) -> Result<(), Failure> {
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
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(work)).unwrap_or_else(|_| Err(internal()))
}

/// Arguments, or the code to end with after help or a usage error has been printed.
fn parse() -> Result<Cli, Code> {
    let arguments: Vec<OsString> = std::env::args_os().collect();
    let color = match asked_color(&arguments) {
        Some(When::Always) => clap::ColorChoice::Always,
        Some(When::Never) => clap::ColorChoice::Never,
        _ => clap::ColorChoice::Auto,
    };
    let error = match command().color(color).try_get_matches_from(arguments) {
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
        command().debug_assert();
    }
}
