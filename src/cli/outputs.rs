//! Where results go: files that appear complete or not at all, and standard output.

use super::exit::{Code, Failure};
use super::watch;
use earmark::files::{self, AtomicFile};
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};

/// Where an output goes.
#[derive(Clone, Debug)]
pub(crate) enum Output {
    Stdout,
    File(PathBuf),
}

impl Output {
    /// Checks an output before any work is done for it: its ending, its place, and that it is none of the inputs.
    pub(crate) fn checked(
        path: &Path,
        endings: &[&str],
        inputs: &[&Path],
    ) -> Result<Self, Failure> {
        if path.as_os_str() == "-" {
            if io::stdout().is_terminal() && endings.contains(&"png") {
                return Err(Failure::usage(
                    "standard output is a terminal; a picture would only disturb it",
                ));
            }
            return Ok(Self::Stdout);
        }
        let ending = path
            .extension()
            .map(|e| e.to_string_lossy().to_ascii_lowercase());
        if !endings.is_empty() && !ending.is_some_and(|e| endings.contains(&e.as_str())) {
            let known: Vec<String> = endings.iter().map(|e| format!(".{e}")).collect();
            return Err(Failure::usage(format!(
                "{}: unknown ending; outputs end in {}",
                path.display(),
                known.join(" or ")
            )));
        }
        if inputs.iter().any(|i| files::same_file(i, path)) {
            let message = format!("{}: is an input, and is not written over", path.display());
            return Err(Failure::new(Code::Io, message));
        }
        files::check_output(path)?;
        Ok(Self::File(path.to_owned()))
    }

    /// [`Output::stage`] for outputs that are not held in memory as a whole.
    pub(crate) fn stage_with(
        &self,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<Staged, Failure> {
        let failure = |name: &str, e: &io::Error| {
            Failure::new(Code::Io, format!("{name}: {}", error_text(e)))
        };
        match self {
            Self::Stdout => {
                let mut out = io::BufWriter::new(io::stdout().lock());
                write(&mut out)
                    .and_then(|()| out.flush())
                    .map_err(|e| failure("standard output", &e))?;
                Ok(Staged(None))
            }
            Self::File(path) => {
                let mut file = AtomicFile::create(path)?;
                write(&mut file).map_err(|e| failure(&path.display().to_string(), &e))?;
                file.sync()?;
                Ok(Staged(Some(file)))
            }
        }
    }

    /// Puts the bytes where only [`Staged::commit`] is left to do; on standard output they are gone.
    pub(crate) fn stage(&self, bytes: &[u8]) -> Result<Staged, Failure> {
        self.stage_with(|out| out.write_all(bytes))
    }
}

/// An output that is complete and on disk, but not yet in its place.
pub(crate) struct Staged(Option<AtomicFile>);

impl Staged {
    /// An output that is complete and on disk.
    pub(crate) fn of(file: AtomicFile) -> Self {
        Self(Some(file))
    }
    pub(crate) fn commit(self) -> Result<(), Failure> {
        match self.0 {
            Some(file) => Ok(file.commit()?),
            None => Ok(()),
        }
    }
}

/// Outputs appear together, after the last moment at which a signal or the deadline can prevent it.
pub(crate) fn commit_all(outputs: Vec<Staged>) -> Result<(), Failure> {
    watch::settle();
    for output in outputs {
        output.commit()?;
    }
    Ok(())
}

/// An output that cannot be written to its end.
pub(crate) fn write_failure(e: &io::Error) -> Failure {
    Failure::new(Code::Io, format!("earmark: {}", error_text(e)))
}

/// A system error without numbers.
fn error_text(e: &io::Error) -> String {
    match e.kind() {
        io::ErrorKind::StorageFull => "no space left".to_owned(),
        io::ErrorKind::BrokenPipe => "nobody reads it".to_owned(),
        io::ErrorKind::FileTooLarge => "the system allows no file of this size".to_owned(),
        kind => kind.to_string(),
    }
}

/// Text to standard output. A reader that has seen enough, as `head`, is no failure.
pub(crate) fn print_text(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Err(Failure::new(
            Code::Io,
            format!("standard output: {}", error_text(&e)),
        )),
        _ => Ok(()),
    }
}
