//! Signals, the deadline and the progress line.
//!
//! The work itself looks at the flag and the deadline in its [`Limits`] and fails cleanly. Where it cannot (blocked in a pipe, in one long
//! step), a thread of its own ends the process a little later, after removing temporary files. The two agree on who ends it: whoever
//! [`claim`]s first.

use super::exit::Code;
use super::flags::When;
use super::messages;
use earmark::limits::Progress;
use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// How often the thread looks around.
const TICK: Duration = Duration::from_millis(20);
/// How long after a signal the work may still end by itself.
const GRACE: Duration = Duration::from_millis(700);
/// How long after the deadline.
const SLACK: Duration = Duration::from_millis(60);
/// When `--progress auto` begins to show something.
const PATIENCE: Duration = Duration::from_millis(1000);

/// What the program does now.
#[derive(Clone, Copy, Debug)]
#[repr(u8)]
pub(crate) enum Phase {
    Reading,
    Rendering,
    Refining,
    Writing,
    Measuring,
    Comparing,
    Turning,
}

const PHASES: [&str; 7] = [
    "reading",
    "rendering",
    "refining",
    "writing",
    "measuring",
    "comparing",
    "frame",
];

static ENDED: AtomicBool = AtomicBool::new(false);
/// It was the work that ended it.
static SETTLED: AtomicBool = AtomicBool::new(false);
static SIGNAL: AtomicUsize = AtomicUsize::new(0);
static PHASE: AtomicU8 = AtomicU8::new(0);

/// Which job of how many runs now; none of 0 outside of a batch.
static JOBS: [AtomicUsize; 2] = [AtomicUsize::new(0), AtomicUsize::new(0)];

/// A job of a batch begins: its outputs appear as they are done, and signals and the deadline are heard all the same.
pub(crate) fn begin_job(number: usize, of: usize) {
    JOBS[0].store(number, Ordering::Relaxed);
    JOBS[1].store(of, Ordering::SeqCst);
}

/// The last job has ended.
pub(crate) fn end_jobs() {
    begin_job(0, 0);
}

pub(crate) fn phase(phase: Phase) {
    PHASE.store(phase as u8, Ordering::Relaxed);
}

/// The signal that asked the program to end.
pub(crate) fn signal() -> Option<u8> {
    match SIGNAL.load(Ordering::Relaxed) {
        0 => None,
        n => u8::try_from(n).ok(),
    }
}

/// Takes the right to end the process; false if it is taken.
fn claim() -> bool {
    !ENDED.swap(true, Ordering::SeqCst)
}

/// From here on the work ends as it ends: no signal and no deadline changes it any more. Does not return if they were first.
pub(crate) fn settle() {
    if JOBS[1].load(Ordering::SeqCst) > 0 {
        return;
    }
    if !claim() {
        loop {
            std::thread::park();
        }
    }
    SETTLED.store(true, Ordering::SeqCst);
}

/// The same at the end of a run that failed, and that may have settled before.
pub(crate) fn settle_late() {
    if !SETTLED.load(Ordering::SeqCst) {
        settle();
    }
}

/// What the thread needs to know.
pub(crate) struct Watch {
    pub(crate) cancelled: Arc<AtomicBool>,
    pub(crate) progress: Arc<Progress>,
    pub(crate) start: Instant,
    pub(crate) deadline: Option<(Instant, Duration)>,
    pub(crate) show: When,
    pub(crate) quiet: bool,
}

impl Watch {
    /// Installs the handlers and starts the thread. Without either the work still goes on.
    pub(crate) fn start(self) {
        install(&self.cancelled);
        let _ = std::thread::Builder::new()
            .name("watch".into())
            .stack_size(128 << 10)
            .spawn(move || self.run());
    }

    fn run(&self) {
        let show = match self.show {
            When::Always => true,
            When::Never => false,
            When::Auto => !self.quiet && std::io::stderr().is_terminal(),
        };
        let patience = if self.show == When::Always {
            Duration::ZERO
        } else {
            PATIENCE
        };
        let mut asked: Option<Instant> = None;
        let mut shown = self.start + patience;
        while !ENDED.load(Ordering::SeqCst) {
            let now = Instant::now();
            if let Some(n) = signal() {
                let asked = *asked.get_or_insert(now);
                if now >= asked + GRACE {
                    end(Code::Signal(n), &format!("earmark: ended by signal {n}"));
                }
            }
            if let Some((deadline, time)) = self.deadline
                && now >= deadline + SLACK
            {
                let seconds = time.as_secs_f64();
                end(
                    Code::Limit,
                    &format!("earmark: not done after {seconds} seconds"),
                );
            }
            if show && now >= shown {
                let every = if std::io::stderr().is_terminal() {
                    200
                } else {
                    1000
                };
                shown = now + Duration::from_millis(every);
                messages::progress(&self.line(now));
            }
            std::thread::sleep(TICK);
        }
    }

    fn line(&self, now: Instant) -> String {
        let phase = PHASES[usize::from(PHASE.load(Ordering::Relaxed)) % PHASES.len()];
        let seconds = (now - self.start).as_secs_f64();
        let [job, jobs] = [0, 1].map(|k| JOBS[k].load(Ordering::Relaxed));
        if jobs > 0 {
            return format!("job {job} of {jobs}: {phase}, {seconds:.1} s");
        }
        match self.progress.get() {
            (done, total) if matches!(phase, "rendering" | "comparing") && total > 0 => {
                format!("{phase} {} %, {seconds:.1} s", 100 * done / total)
            }
            (done, total) if phase == "frame" && total > 0 => {
                let frame = (done + 1).min(total);
                format!("{phase} {frame} of {total}, {seconds:.1} s")
            }
            _ => format!("{phase}, {seconds:.1} s"),
        }
    }
}

/// Ends the process from beside, unless the work is just ending by itself.
fn end(code: Code, message: &str) {
    if claim() {
        earmark::files::abandon_outputs();
        messages::last_error(message);
        std::process::exit(i32::from(code.number()));
    }
}

fn install(cancelled: &Arc<AtomicBool>) {
    use signal_hook::consts::{SIGINT, SIGTERM};
    let mut signals = vec![SIGINT, SIGTERM];
    #[cfg(unix)]
    {
        use signal_hook::consts::{SIGHUP, SIGXCPU, SIGXFSZ};
        signals.push(SIGXCPU);
        // Under nohup it stays ignored.
        if !is_ignored(SIGHUP) {
            signals.push(SIGHUP);
        }
        // Writing beyond the limit of file sizes then fails in place of ending the process.
        let _ = signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
    }
    for signal in signals {
        // The cause first, so that who sees the flag finds it. Signals are delivered in this order.
        let _ = signal_hook::flag::register_usize(signal, &SIGNAL, signal as usize);
        let _ = signal_hook::flag::register(signal, Arc::clone(cancelled));
    }
}

/// Whether the process was started with a signal ignored, where the system says so.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let Ok(status) = std::fs::read_to_string("/proc/self/status") else {
        return false;
    };
    let mask = status
        .lines()
        .find_map(|l| l.strip_prefix("SigIgn:"))
        .and_then(|m| u64::from_str_radix(m.trim(), 16).ok());
    mask.is_some_and(|m| m >> (signal - 1) & 1 == 1)
}
