//! What is in a folder and the folders below it.

use std::fs;
use std::path::{Path, PathBuf};

use super::{FileError, What};

/// Most files that [`files_below`] lists: more are no folder of pictures.
const MOST: usize = 1 << 20;

/// Regular files with an ending below a folder, as paths relative to it, sorted. Links to folders are not followed; hidden files and
/// folders are left out.
///
/// # Errors
/// [`FileError`] when a folder is missing or cannot be read, or holds more than a million files.
pub fn files_below(folder: &Path, ending: &str) -> Result<Vec<PathBuf>, FileError> {
    let mut out = Vec::new();
    let mut waiting = vec![PathBuf::new()];
    while let Some(below) = waiting.pop() {
        let here = folder.join(&below);
        let error = |e| FileError::new(&here, What::System(e));
        for entry in fs::read_dir(&here).map_err(error)? {
            let entry = entry.map_err(error)?;
            let name = entry.file_name();
            if name.as_encoded_bytes().starts_with(b".") {
                continue;
            }
            let path = below.join(name);
            if entry.file_type().map_err(error)?.is_dir() {
                waiting.push(path);
            } else if path
                .extension()
                .is_some_and(|e| e.eq_ignore_ascii_case(ending))
            {
                out.push(path);
            }
            if out.len() + waiting.len() > MOST {
                return Err(FileError::new(&here, What::Wrong("holds too many files")));
            }
        }
    }
    out.sort();
    Ok(out)
}
