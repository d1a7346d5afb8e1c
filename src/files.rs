//! The only place that opens files: models, the files they name, and outputs that appear whole or not at all.
//!
//! Reading: regular files only. What a path is, is asked before it is opened, and it is opened without blocking and asked again, so that
//! neither a named pipe nor a device can hang or feed the program. Sizes are known and checked before a byte is read.
//!
//! Files that a model names are confined to the model's folder ([`FolderResolver`]): a name that leads outside, by itself or through a
//! link, is refused without being opened.
//!
//! Writing ([`AtomicFile`]): a temporary file in the same folder, created exclusively, flushed to disk, renamed onto nothing or onto a
//! regular file. An output that is a link to a regular file is followed: the file is replaced, the link stays.

mod atomic;
mod walk;

use std::fmt;
use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, ErrorKind, Read};
use std::path::{Component, Path, PathBuf};

use crate::mesh::obj::escape;
use crate::mesh::{ResolveError, Resolver};
pub use atomic::{AtomicFile, abandon_outputs, check_output, make_folder, remove, write_atomic};
pub use walk::files_below;

/// Why a file was not read or written.
#[derive(Debug)]
pub struct FileError {
    path: PathBuf,
    what: What,
}

/// Who can do something about a [`FileError`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FileErrorKind {
    /// The file is missing, of the wrong kind, or the system refuses it.
    Io,
    /// The file is larger than allowed.
    Limit,
}

#[derive(Debug)]
enum What {
    System(io::Error),
    Wrong(&'static str),
    TooLarge { limit: u64 },
    Memory,
}

impl FileError {
    fn new(path: &Path, what: What) -> Self {
        Self {
            path: path.to_owned(),
            what,
        }
    }
    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }
    /// Who can do something about it.
    #[must_use]
    pub fn kind(&self) -> FileErrorKind {
        match self.what {
            What::System(_) | What::Wrong(_) => FileErrorKind::Io,
            What::TooLarge { .. } | What::Memory => FileErrorKind::Limit,
        }
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = self.path.as_os_str().as_encoded_bytes();
        write!(f, "{}: ", escape(path, 1024))?;
        match &self.what {
            What::System(e) => f.write_str(&plain(e)),
            What::Wrong(what) => f.write_str(what),
            What::TooLarge { limit } => write!(f, "larger than {limit} bytes"),
            What::Memory => f.write_str("not enough memory to read it"),
        }
    }
}

/// A system error without numbers, the same on every machine where it is one of the usual ones.
fn plain(e: &io::Error) -> String {
    let what = match e.kind() {
        ErrorKind::NotFound => "no such file or folder",
        ErrorKind::AlreadyExists => "exists already",
        ErrorKind::IsADirectory => "is a folder",
        ErrorKind::NotADirectory => "a part of the path is not a folder",
        ErrorKind::StorageFull => "no space left",
        ErrorKind::FileTooLarge => "the system allows no file of this size",
        ErrorKind::InvalidFilename => "the system does not take this name",
        ErrorKind::InvalidInput => "not a name of a file",
        kind => return kind.to_string(),
    };
    what.to_owned()
}

impl std::error::Error for FileError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match &self.what {
            What::System(e) => Some(e),
            _ => None,
        }
    }
}

/// The folder that holds a file.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// What is wrong with a thing that is not a regular file.
fn kind_of(meta: &Metadata) -> &'static str {
    if meta.is_dir() {
        return "is a folder";
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kind = meta.file_type();
        if kind.is_fifo() {
            return "is a named pipe";
        }
        if kind.is_char_device() || kind.is_block_device() {
            return "is a device";
        }
        if kind.is_socket() {
            return "is a socket";
        }
    }
    "is not a regular file"
}

/// Flag of `open` that keeps a pipe or device from blocking.
#[cfg(unix)]
const NONBLOCK: i32 = if cfg!(any(target_os = "linux", target_os = "android")) {
    if cfg!(any(target_arch = "mips", target_arch = "mips64")) {
        0x80
    } else if cfg!(any(target_arch = "sparc", target_arch = "sparc64")) {
        0x4000
    } else {
        0x800
    }
} else {
    // The BSDs and macOS.
    4
};

/// Opens a regular file of at most `max_bytes` without ever blocking, and says how long it is.
fn open_regular(path: &Path, max_bytes: u64) -> Result<(File, u64), What> {
    let check = |meta: &Metadata| {
        if !meta.is_file() {
            return Err(What::Wrong(kind_of(meta)));
        }
        if meta.len() > max_bytes {
            return Err(What::TooLarge { limit: max_bytes });
        }
        Ok(meta.len())
    };
    check(&fs::metadata(path).map_err(What::System)?)?;
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, NONBLOCK);
    let file = options.open(path).map_err(What::System)?;
    // It may have been exchanged in between.
    let len = check(&file.metadata().map_err(What::System)?)?;
    Ok((file, len))
}

fn read_regular(path: &Path, max_bytes: u64) -> Result<Vec<u8>, What> {
    let (file, len) = open_regular(path, max_bytes)?;
    let mut bytes = Vec::new();
    let capacity = usize::try_from(len).map_err(|_| What::Memory)?;
    bytes
        .try_reserve_exact(capacity)
        .map_err(|_| What::Memory)?;
    // Never more than was announced: pseudo-files announce nothing and may have no end.
    file.take(len)
        .read_to_end(&mut bytes)
        .map_err(What::System)?;
    Ok(bytes)
}

/// Reads a model: a regular file, or a link to one, of at most `max_bytes`.
///
/// # Errors
/// [`FileError`] when it is missing, no regular file, too large, or cannot be read. Named pipes and devices are refused at once.
pub fn read_model(path: &Path, max_bytes: u64) -> Result<Vec<u8>, FileError> {
    read_regular(path, max_bytes).map_err(|what| FileError::new(path, what))
}

/// Reads a stream of unknown length, as standard input is, up to `max_bytes`. `name` is what messages call it.
///
/// # Errors
/// [`FileError`] when there is more, or when it cannot be read.
pub fn read_stream(name: &str, input: impl Read, max_bytes: u64) -> Result<Vec<u8>, FileError> {
    let error = |what| FileError::new(Path::new(name), what);
    let mut bytes = Vec::new();
    let mut input = input.take(max_bytes.saturating_add(1));
    let mut part = vec![0; 1 << 16];
    loop {
        let n = match input.read(&mut part) {
            Ok(0) => return Ok(bytes),
            Ok(n) => n,
            Err(e) if e.kind() == ErrorKind::Interrupted => continue,
            Err(e) => return Err(error(What::System(e))),
        };
        if (bytes.len() + n) as u64 > max_bytes {
            return Err(error(What::TooLarge { limit: max_bytes }));
        }
        bytes.try_reserve(n).map_err(|_| error(What::Memory))?;
        bytes.extend_from_slice(&part[..n]);
    }
}

/// Whether two paths lead to the same file. Paths that lead nowhere are no file.
#[must_use]
pub fn same_file(a: &Path, b: &Path) -> bool {
    #[cfg(unix)]
    if let (Ok(a), Ok(b)) = (fs::metadata(a), fs::metadata(b)) {
        use std::os::unix::fs::MetadataExt;
        return a.dev() == b.dev() && a.ino() == b.ino();
    }
    match (fs::canonicalize(a), fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}

/// Hands out files next to a model, and nothing outside the model's folder.
///
/// Refused without opening anything: absolute names, drive letters, URLs, NUL, `..` that leads outside, links that lead outside, folders,
/// pipes, devices, and files that are too large.
#[derive(Clone, Debug)]
pub struct FolderResolver {
    /// Names are relative to this folder.
    folder: PathBuf,
    /// Nothing outside this one is opened.
    root: PathBuf,
}

impl FolderResolver {
    /// A resolver for the folder of a model.
    ///
    /// # Errors
    /// [`FileError`] when the folder is not there.
    pub fn beside(model: &Path) -> Result<Self, FileError> {
        Self::new(folder_of(model))
    }

    /// A resolver for a folder.
    ///
    /// # Errors
    /// [`FileError`] when the folder is not there.
    pub fn new(folder: &Path) -> Result<Self, FileError> {
        let folder =
            fs::canonicalize(folder).map_err(|e| FileError::new(folder, What::System(e)))?;
        Ok(Self {
            root: folder.clone(),
            folder,
        })
    }

    /// Widens the reach to everything under `root`; names stay relative to the model's folder.
    ///
    /// # Errors
    /// [`FileError`] when `root` is not there.
    pub fn with_root(mut self, root: &Path) -> Result<Self, FileError> {
        self.root = fs::canonicalize(root).map_err(|e| FileError::new(root, What::System(e)))?;
        Ok(self)
    }

    /// Where a name leads.
    fn locate(&self, name: &str) -> Result<PathBuf, ResolveError> {
        let refused = |why| Err(ResolveError::Refused(why));
        if name.is_empty() {
            return refused("empty name");
        }
        if name.contains('\0') {
            return refused("a name with NUL");
        }
        if name.contains("://")
            || name
                .get(..5)
                .is_some_and(|s| s.eq_ignore_ascii_case("data:"))
        {
            return refused("a URL, not a file");
        }
        // Files made on Windows name folders with backslashes.
        let name = name.replace('\\', "/");
        let bytes = name.as_bytes();
        let drive = bytes.len() > 1 && bytes[1] == b':' && bytes[0].is_ascii_alphabetic();
        if bytes[0] == b'/' || drive {
            return refused("an absolute path");
        }
        // Without looking at the disk first: a name that leads outside is not even asked for.
        let mut path = self.folder.clone();
        for part in Path::new(&name).components() {
            match part {
                Component::Normal(part) => path.push(part),
                Component::CurDir => {}
                Component::ParentDir => {
                    path.pop();
                }
                Component::RootDir | Component::Prefix(_) => return refused("an absolute path"),
            }
        }
        if !path.starts_with(&self.root) {
            return refused("outside the model's folder");
        }
        let path = fs::canonicalize(path).map_err(system)?;
        if !path.starts_with(&self.root) {
            return refused("a link that leads outside the model's folder");
        }
        Ok(path)
    }
}

fn system(e: io::Error) -> ResolveError {
    match e.kind() {
        ErrorKind::NotFound | ErrorKind::NotADirectory => ResolveError::NotFound,
        kind => ResolveError::Io(kind),
    }
}

impl Resolver for FolderResolver {
    fn read(&mut self, name: &str, max_bytes: u64) -> Result<Vec<u8>, ResolveError> {
        let path = self.locate(name)?;
        read_regular(&path, max_bytes).map_err(|what| match what {
            What::System(e) => system(e),
            What::Wrong(what) => ResolveError::Refused(what),
            What::TooLarge { limit } => ResolveError::TooLarge { limit },
            What::Memory => ResolveError::Io(ErrorKind::OutOfMemory),
        })
    }
}
