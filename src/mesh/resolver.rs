//! How readers get at the files that a model names, without ever seeing a path.
//!
//! A reader takes bytes and a [`Resolver`]. The program hands it a [`FolderResolver`](crate::files::FolderResolver), tests and fuzzers a
//! [`MemoryFiles`], and who wants no further files [`NoFiles`].

use std::collections::BTreeMap;

/// Why a named file was not handed out.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ResolveError {
    /// There is no such file.
    #[error("no such file")]
    NotFound,
    /// The name leads outside the model's folder, or is no name of a file at all.
    #[error("refused: {0}")]
    Refused(&'static str),
    /// The file is larger than the reader allows.
    #[error("larger than {limit} bytes")]
    TooLarge {
        /// What is allowed.
        limit: u64,
    },
    /// The system does not let us read it.
    #[error("cannot be read ({0})")]
    Io(std::io::ErrorKind),
}

/// Gives the bytes of files that a model names.
pub trait Resolver {
    /// The bytes of the file called `name`, at most `max_bytes` of them.
    ///
    /// # Errors
    /// [`ResolveError`] when there is no such file, or when it is not to be read.
    fn read(&mut self, name: &str, max_bytes: u64) -> Result<Vec<u8>, ResolveError>;
}

/// A resolver without any files.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl Resolver for NoFiles {
    fn read(&mut self, _name: &str, _max_bytes: u64) -> Result<Vec<u8>, ResolveError> {
        Err(ResolveError::NotFound)
    }
}

/// Files in memory, by name.
#[derive(Clone, Debug, Default)]
pub struct MemoryFiles {
    files: BTreeMap<String, Vec<u8>>,
    reads: Vec<String>,
}

impl MemoryFiles {
    /// No files.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }
    /// Adds a file.
    #[must_use]
    pub fn with(mut self, name: &str, bytes: impl Into<Vec<u8>>) -> Self {
        self.files.insert(name.to_owned(), bytes.into());
        self
    }
    /// The names that were asked for, in order.
    #[must_use]
    pub fn reads(&self) -> &[String] {
        &self.reads
    }
}

impl Resolver for MemoryFiles {
    fn read(&mut self, name: &str, max_bytes: u64) -> Result<Vec<u8>, ResolveError> {
        self.reads.push(name.to_owned());
        let bytes = self.files.get(name).ok_or(ResolveError::NotFound)?;
        if bytes.len() as u64 > max_bytes {
            return Err(ResolveError::TooLarge { limit: max_bytes });
        }
        Ok(bytes.clone())
    }
}
