//! Exit codes, and the one way by which errors become one. Queues act on the codes: 3 is not worth another try, 4 may be, 5 is with more
//! time or memory.

use earmark::camera::CameraError;
use earmark::files::{FileError, FileErrorKind};
use earmark::film::WriteError;
use earmark::frame::RenderError;
use earmark::limits::LimitError;
use earmark::load::LoadError;
use earmark::mesh::{ReadError, ReadErrorKind};
use earmark::simd::LevelError;
use earmark::texture;
use std::path::Path;

/// How the program ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Code {
    Done,
    /// A comparison found a difference.
    Different,
    Usage,
    Data,
    Io,
    Limit,
    Unavailable,
    /// A defect of this program; as `EX_SOFTWARE` of sysexits.
    Internal,
    /// Ended by a signal.
    Signal(u8),
}

impl Code {
    /// The code that a run of this program ended with, as another one's.
    pub(crate) fn of_child(status: std::process::ExitStatus) -> Self {
        let all = [
            Self::Usage,
            Self::Data,
            Self::Io,
            Self::Limit,
            Self::Unavailable,
        ];
        let found = all
            .into_iter()
            .find(|c| status.code() == Some(c.number().into()));
        found.unwrap_or(Self::Internal)
    }

    pub(crate) fn number(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::Different => 1,
            Self::Usage => 2,
            Self::Data => 3,
            Self::Io => 4,
            Self::Limit => 5,
            Self::Unavailable => 6,
            Self::Internal => 70,
            Self::Signal(n) => 128 + n,
        }
    }
}

/// What `--help` says about exit codes.
pub(crate) const HELP: &str = "\
Exit codes: 0 done; 1 compare found a difference, or jobs of a batch failed; 2 usage; 3 bad input data; 4 input or output; 5 a limit was \
reached (time, memory, faces); 6 SIMD level, GPU or display not available; 70 internal error, a defect; 128+N ended by signal N. On any code \
but 0 and 1 no output file appears and existing ones stay; numbered frames that are done stay, and of compared folders reports and accepted pictures.";

/// Why the program ends without having done its work.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) code: Code,
    pub(crate) message: String,
}

impl Failure {
    pub(crate) fn new(code: Code, message: impl Into<String>) -> Self {
        Self {
            code,
            message: message.into(),
        }
    }
    pub(crate) fn usage(message: impl Into<String>) -> Self {
        Self::new(Code::Usage, format!("earmark: {}", message.into()))
    }
    /// Of a texture that the user named.
    pub(crate) fn texture(path: &Path, e: &texture::LoadError) -> Self {
        let code = match e {
            texture::LoadError::TooLarge { .. } | texture::LoadError::Budget { .. } => Code::Limit,
            _ => Code::Data,
        };
        Self::new(code, format!("{}: {e}", path.display()))
    }
}

impl From<FileError> for Failure {
    fn from(e: FileError) -> Self {
        let code = match e.kind() {
            FileErrorKind::Limit => Code::Limit,
            _ => Code::Io,
        };
        Self::new(code, e.to_string())
    }
}

impl From<ReadError> for Failure {
    fn from(e: ReadError) -> Self {
        let code = match e.kind() {
            ReadErrorKind::Io => Code::Io,
            ReadErrorKind::Limit => Code::Limit,
            _ => Code::Data,
        };
        Self::new(code, e.to_string())
    }
}

impl From<LimitError> for Failure {
    fn from(e: LimitError) -> Self {
        match (e, super::watch::signal()) {
            (LimitError::Cancelled, Some(n)) => Self::signal(n),
            (e, _) => Self::new(Code::Limit, format!("earmark: {e}")),
        }
    }
}

impl Failure {
    pub(crate) fn signal(n: u8) -> Self {
        Self::new(Code::Signal(n), format!("earmark: ended by signal {n}"))
    }
}

impl From<LoadError> for Failure {
    fn from(e: LoadError) -> Self {
        match e {
            LoadError::File(e) => e.into(),
            LoadError::Read(e) => e.into(),
            LoadError::Limit(e) => e.into(),
            other => Self::new(Code::Data, other.to_string()),
        }
    }
}

impl From<CameraError> for Failure {
    fn from(e: CameraError) -> Self {
        Self::usage(e.to_string())
    }
}

impl From<RenderError> for Failure {
    fn from(e: RenderError) -> Self {
        match e {
            RenderError::Limit(e) => e.into(),
            other => Self::usage(other.to_string()),
        }
    }
}

impl From<WriteError> for Failure {
    fn from(e: WriteError) -> Self {
        Self::new(Code::Io, format!("earmark: {e}"))
    }
}

impl From<LevelError> for Failure {
    fn from(e: LevelError) -> Self {
        Self::new(Code::Unavailable, format!("earmark: {e}"))
    }
}
