//! What goes to standard error: errors, warnings, notes and the progress line. Whatever happens to standard error, the program goes on;
//! whatever a message holds, the terminal sees printable text, and less than 64 KB of it.

use super::flags::When;
use earmark::mesh::obj::escape;
use std::io::{self, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Most bytes of warnings, notes and progress. Leaves room for the error that ends the program.
const BUDGET: usize = 56 << 10;
/// Most characters of one message.
const LONGEST: usize = 2000;

/// 0 errors only, 1 warnings, 2 and more notes.
static LEVEL: AtomicU8 = AtomicU8::new(1);
static COLOR: AtomicBool = AtomicBool::new(false);
static SPENT: AtomicUsize = AtomicUsize::new(0);
/// Whether a progress line stands at the end of what was written.
static LINE: Mutex<bool> = Mutex::new(false);

pub(crate) fn init(quiet: bool, verbose: u8, color: When) {
    let level = if quiet { 0 } else { verbose.saturating_add(1) };
    LEVEL.store(level, Ordering::Relaxed);
    COLOR.store(wants_color(color), Ordering::Relaxed);
}

/// `NO_COLOR` and a stream that is no terminal turn `auto` off.
fn wants_color(when: When) -> bool {
    match when {
        When::Always => true,
        When::Never => false,
        When::Auto => {
            std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty()) && io::stderr().is_terminal()
        }
    }
}

pub(crate) fn is_verbose() -> bool {
    LEVEL.load(Ordering::Relaxed) >= 2
}

fn line() -> MutexGuard<'static, bool> {
    LINE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Writes without minding whether anybody listens.
fn write(text: &str, line: &mut bool) {
    let mut out = io::stderr().lock();
    if std::mem::take(line) {
        let _ = out.write_all(b"\r\x1b[K");
    }
    let _ = out.write_all(text.as_bytes());
    let _ = out.flush();
}

fn colored(color: &str, text: &str) -> String {
    if COLOR.load(Ordering::Relaxed) {
        format!("\x1b[{color}m{text}\x1b[0m")
    } else {
        text.to_owned()
    }
}

fn put(text: String) {
    let before = SPENT.fetch_add(text.len(), Ordering::Relaxed);
    if before >= BUDGET {
        return;
    }
    let mut text = text;
    if before + text.len() >= BUDGET {
        text = "earmark: further messages are left out\n".into();
    }
    write(&text, &mut line());
}

/// The message of a failure; the last one.
pub(crate) fn error(message: &str) {
    let text = colored("1;31", &escape(message.as_bytes(), LONGEST)) + "\n";
    write(&text, &mut line());
}

/// The same from the thread that ends a program which hangs: not printed if another thread hangs in printing.
pub(crate) fn last_error(message: &str) {
    if let Ok(mut line) = LINE.try_lock() {
        write(&(escape(message.as_bytes(), LONGEST) + "\n"), &mut line);
    }
}

/// Several lines, for usage errors.
pub(crate) fn error_text(text: &str) {
    let lines: Vec<String> = text
        .lines()
        .take(40)
        .map(|l| escape(l.as_bytes(), 1000) + "\n")
        .collect();
    write(&lines.concat(), &mut line());
}

pub(crate) fn warning(message: &str) {
    if LEVEL.load(Ordering::Relaxed) >= 1 {
        let message = escape(message.as_bytes(), LONGEST);
        put(format!("{} {message}\n", colored("1;33", "warning:")));
    }
}

/// Said with `-v` only.
pub(crate) fn note(message: &str) {
    if is_verbose() {
        put(escape(message.as_bytes(), LONGEST) + "\n");
    }
}

/// Shows how far the work is: in place on a terminal, line by line otherwise.
pub(crate) fn progress(message: &str) {
    let Ok(mut line) = LINE.try_lock() else {
        return;
    };
    if io::stderr().is_terminal() {
        write(&format!("\r\x1b[K{message}"), &mut false);
        *line = true;
    } else {
        drop(line);
        put(format!("{message}\n"));
    }
}

pub(crate) fn clear_progress() {
    write("", &mut line());
}
