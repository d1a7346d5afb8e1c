//! Outputs that appear whole or not at all.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::{FileError, What, folder_of, kind_of};

/// An output file that appears whole, on [`AtomicFile::commit`], or not at all.
///
/// Until then its bytes are in a temporary file beside it, which is removed when this value is dropped.
#[derive(Debug)]
pub struct AtomicFile {
    /// `None` once it is committed.
    temporary: Option<PathBuf>,
    target: PathBuf,
    /// The path as the caller gave it.
    named: PathBuf,
    /// `None` once its bytes are stored: many outputs may wait for their renaming, and open files are few.
    file: Option<io::BufWriter<File>>,
}

impl AtomicFile {
    /// Starts an output.
    ///
    /// # Errors
    /// [`FileError`] when the folder is missing or not writable, or when `path` is a folder, a device, anything else that is no regular
    /// file, or a file that is write-protected.
    pub fn create(path: &Path) -> Result<Self, FileError> {
        let error = |what| FileError::new(path, what);
        let (target, existing) = target_of(path).map_err(error)?;
        let (temporary, file) = create_temporary(folder_of(&target)).map_err(error)?;
        // From here on the temporary file goes away with this value.
        let mut output = Self {
            temporary: Some(temporary),
            target,
            named: path.to_owned(),
            file: None,
        };
        if let Some(existing) = existing {
            file.set_permissions(existing.permissions())
                .map_err(|e| error(What::System(e)))?;
        }
        output.file = Some(io::BufWriter::new(file));
        Ok(output)
    }

    /// Puts all bytes on disk, so that [`AtomicFile::commit`] has nothing left to do but the renaming.
    ///
    /// # Errors
    /// [`FileError`] when they cannot be stored.
    pub fn sync(&mut self) -> Result<(), FileError> {
        let stored = self.put_on_disk();
        stored.map_err(|e| FileError::new(&self.named, What::System(e)))
    }

    fn put_on_disk(&mut self) -> io::Result<()> {
        match &mut self.file {
            Some(file) => {
                file.flush()?;
                file.get_ref().sync_all()
            }
            None => Ok(()),
        }
    }

    /// Writes the last bytes, puts all on disk and closes the file; nothing can be written any more.
    ///
    /// # Errors
    /// [`FileError`] when they cannot be stored.
    pub fn store(&mut self, bytes: &[u8]) -> Result<(), FileError> {
        let written = self.write_all(bytes);
        written.map_err(|e| FileError::new(&self.named, What::System(e)))?;
        self.sync()?;
        self.file = None;
        Ok(())
    }

    /// Makes the output appear, complete and on disk.
    ///
    /// # Errors
    /// [`FileError`] when the bytes cannot be stored or something else has taken the place; what was there before stays.
    pub fn commit(mut self) -> Result<(), FileError> {
        let named = self.named.clone();
        self.finish().map_err(|what| FileError::new(&named, what))
    }

    fn finish(&mut self) -> Result<(), What> {
        self.put_on_disk().map_err(What::System)?;
        // Something may have taken its place since; a rename would replace a device node, for those who may.
        target_of(&self.target)?;
        if let Some(temporary) = self.temporary.take() {
            let mut under_way = under_way();
            if under_way.abandoned {
                return Err(What::Wrong(ABANDONED));
            }
            under_way.files.retain(|f| *f != temporary);
            if let Err(e) = fs::rename(&temporary, &self.target) {
                let _ = fs::remove_file(&temporary);
                return Err(What::System(e));
            }
        }
        // The rename itself is on disk when the folder is; not every file system can do that.
        #[cfg(unix)]
        if let Some(folder) = self.target.parent().filter(|f| !f.as_os_str().is_empty()) {
            let _ = File::open(folder).and_then(|f| f.sync_all());
        }
        Ok(())
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.file {
            Some(file) => file.write(bytes),
            None => Err(io::Error::other("the output is stored already")),
        }
    }
    fn flush(&mut self) -> io::Result<()> {
        self.file.as_mut().map_or(Ok(()), Write::flush)
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        if let Some(temporary) = &self.temporary {
            under_way().files.retain(|f| f != temporary);
            let _ = fs::remove_file(temporary);
        }
    }
}

/// Temporary files of all outputs under way.
struct UnderWay {
    files: Vec<PathBuf>,
    abandoned: bool,
}

/// Why there are no outputs any more.
const ABANDONED: &str = "given up, the program is ending";

fn under_way() -> MutexGuard<'static, UnderWay> {
    static UNDER_WAY: Mutex<UnderWay> = Mutex::new(UnderWay {
        files: Vec::new(),
        abandoned: false,
    });
    // A list of names stays good whatever happened to another thread.
    UNDER_WAY.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the temporary files of all outputs under way and lets no output appear from now on: for a program that is about to end
/// while other threads still work.
pub fn abandon_outputs() {
    let mut under_way = under_way();
    under_way.abandoned = true;
    for file in under_way.files.drain(..) {
        let _ = fs::remove_file(file);
    }
}

/// Finds out, before any work is done for it, whether an output can be placed at `path`. Nothing is written.
///
/// # Errors
/// As [`AtomicFile::create`], as far as it can be told without writing.
pub fn check_output(path: &Path) -> Result<(), FileError> {
    let error = |what| FileError::new(path, what);
    let (target, _) = target_of(path).map_err(error)?;
    let meta = fs::metadata(folder_of(&target)).map_err(|e| error(What::System(e)))?;
    if !meta.is_dir() {
        return Err(error(What::Wrong("a part of the path is not a folder")));
    }
    Ok(())
}

/// Makes a folder and those it is in, where they are missing.
///
/// # Errors
/// [`FileError`] when that is not possible.
pub fn make_folder(path: &Path) -> Result<(), FileError> {
    fs::create_dir_all(path).map_err(|e| FileError::new(path, What::System(e)))
}

/// Removes a file, if it is there. Whether it was.
///
/// # Errors
/// [`FileError`] when it is there and cannot be removed.
pub fn remove(path: &Path) -> Result<bool, FileError> {
    match fs::remove_file(path) {
        Ok(()) => Ok(true),
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(false),
        Err(e) => Err(FileError::new(path, What::System(e))),
    }
}

/// Writes an output file whole or not at all.
///
/// # Errors
/// As [`AtomicFile::create`] and [`AtomicFile::commit`].
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let mut file = AtomicFile::create(path)?;
    file.write_all(bytes)
        .map_err(|e| FileError::new(path, What::System(e)))?;
    file.commit()
}

/// The file that is to be replaced or made, links followed, and what is there now.
fn target_of(path: &Path) -> Result<(PathBuf, Option<Metadata>), What> {
    let meta = match fs::symlink_metadata(path) {
        Ok(meta) => meta,
        Err(e) if e.kind() == ErrorKind::NotFound => {
            if path.file_name().is_none() || path.as_os_str().as_encoded_bytes().ends_with(b"/") {
                return Err(What::Wrong("not a name of a file"));
            }
            return Ok((path.to_owned(), None));
        }
        Err(e) => return Err(What::System(e)),
    };
    let (target, meta) = if meta.is_symlink() {
        let target = match fs::canonicalize(path) {
            Ok(target) => target,
            Err(e) if e.kind() == ErrorKind::NotFound => {
                return Err(What::Wrong("is a link that leads nowhere"));
            }
            Err(e) => return Err(What::System(e)),
        };
        let meta = fs::metadata(&target).map_err(What::System)?;
        (target, meta)
    } else {
        (path.to_owned(), meta)
    };
    if !meta.is_file() {
        return Err(What::Wrong(kind_of(&meta)));
    }
    if meta.permissions().readonly() {
        return Err(What::Wrong("is write-protected"));
    }
    Ok((target, Some(meta)))
}

/// Makes a new file in the folder. Its name does not depend on the output's, which may be as long as the system takes.
fn create_temporary(folder: &Path) -> Result<(PathBuf, File), What> {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    let process = std::process::id();
    let mut tries = 0;
    let mut under_way = under_way();
    if under_way.abandoned {
        return Err(What::Wrong(ABANDONED));
    }
    loop {
        let n = NEXT.fetch_add(1, Ordering::Relaxed);
        let path = folder.join(format!(".earmark-{process}-{n}.tmp"));
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(file) => {
                under_way.files.push(path.clone());
                return Ok((path, file));
            }
            // Left by a process that was killed and had our number.
            Err(e) if e.kind() == ErrorKind::AlreadyExists && tries < 1000 => tries += 1,
            Err(e) => return Err(What::System(e)),
        }
    }
}
