//! Two folders of pictures, one of goldens and one of new pictures, held against each other by name.

use super::report::{Page, Pictures, Shown};
use super::{Verdict, judge};
use crate::compare::{Tolerance, difference};
use crate::files::{self, AtomicFile, FileError, FileErrorKind};
use crate::film::{DeepImage, ReadError, png};
use crate::limits::{LimitError, Limits};
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Bytes per pixel of a comparison: two pictures of four 16-bit codes, one of them decoded once more, and the difference.
const PIXEL_BYTES: u128 = 28;

/// Why folders cannot be compared or accepted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FoldersError {
    /// A file or folder.
    #[error(transparent)]
    File(#[from] FileError),
    /// Memory or time.
    #[error(transparent)]
    Limit(#[from] LimitError),
}

/// A picture that is in one of two folders, or in both.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Path relative to its folder.
    pub path: PathBuf,
    /// What was found.
    pub verdict: Verdict,
}

impl Found {
    /// The path as a name, with `/` between folders.
    #[must_use]
    pub fn name(&self) -> String {
        let parts = self
            .path
            .components()
            .map(|c| c.as_os_str().to_string_lossy());
        parts.collect::<Vec<_>>().join("/")
    }
}

/// A folder of goldens and a folder of new pictures, compared.
#[derive(Clone, Debug)]
pub struct Folders {
    golden: PathBuf,
    new: PathBuf,
    found: Vec<Found>,
}

impl Folders {
    /// Compares all PNG files of two folders and of the folders in them, by name.
    ///
    /// # Errors
    /// [`FoldersError`] when a folder cannot be read or a limit is reached. A picture that cannot be read is a
    /// [verdict](Verdict::Unreadable).
    pub fn compare(
        golden: &Path,
        new: &Path,
        tolerance: &Tolerance,
        limits: &Limits,
    ) -> Result<Self, FoldersError> {
        let mut names: BTreeMap<PathBuf, [bool; 2]> = BTreeMap::new();
        for (side, folder) in [golden, new].into_iter().enumerate() {
            for path in files::files_below(folder, "png")? {
                names.entry(path).or_default()[side] = true;
            }
        }
        limits.progress.begin(names.len() as u64);
        let mut found = Vec::with_capacity(names.len());
        for (path, present) in names {
            limits.check()?;
            let verdict = match present {
                [true, false] => Verdict::Dead,
                // One that cannot be read could not be accepted either.
                [false, _] => match read_picture(&new.join(&path), limits) {
                    Ok(_) => Verdict::New,
                    Err(e) => e.verdict()?,
                },
                [true, true] => {
                    compare_files(&golden.join(&path), &new.join(&path), tolerance, limits)?
                }
            };
            found.push(Found { path, verdict });
            limits.progress.step();
        }
        Ok(Self {
            golden: golden.to_owned(),
            new: new.to_owned(),
            found,
        })
    }

    /// All pictures by name.
    #[must_use]
    pub fn found(&self) -> &[Found] {
        &self.found
    }

    /// Whether nothing differs, nothing is missing, and no golden is dead.
    #[must_use]
    pub fn passes(&self) -> bool {
        self.found.iter().all(|f| f.verdict.passes())
    }

    /// How many there are of each kind, in words.
    #[must_use]
    pub fn summary(&self) -> String {
        let mut counts: Vec<(&str, usize)> = Vec::new();
        for f in &self.found {
            let word = f.verdict.word();
            match counts.iter_mut().find(|(w, _)| *w == word) {
                Some((_, n)) => *n += 1,
                None => counts.push((word, 1)),
            }
        }
        let parts = counts.iter().map(|(word, n)| format!("{n} {word}"));
        let text = parts.collect::<Vec<_>>().join(", ");
        match text.is_empty() {
            true => "no pictures".into(),
            false => text,
        }
    }

    /// Writes the page with all that does not pass, pictures embedded.
    ///
    /// # Errors
    /// Those of `out`, and those of reading the pictures once more.
    pub fn report(&self, out: &mut dyn Write) -> io::Result<()> {
        let title = format!("{} against {}", self.new.display(), self.golden.display());
        let mut page = Page::begin(out, &title, &self.summary())?;
        let (shown, passed): (Vec<&Found>, Vec<&Found>) =
            self.found.iter().partition(|f| !f.verdict.passes());
        for f in shown {
            let read = |folder: &Path| files::read_model(&folder.join(&f.path), u64::MAX).ok();
            let (golden, new) = (read(&self.golden), read(&self.new));
            let difference = match (&f.verdict, &golden, &new) {
                (Verdict::Different(_), Some(a), Some(b)) => difference_of(a, b),
                _ => None,
            };
            let pictures = Pictures {
                golden: golden.as_deref().map(Shown::Embedded),
                new: new.as_deref().map(Shown::Embedded),
                difference: difference.as_deref().map(Shown::Embedded),
            };
            page.entry(&f.name(), &f.verdict, &f.verdict.figures(), pictures)?;
        }
        let names: Vec<String> = passed.iter().map(|f| f.name()).collect();
        page.end("pictures pass", &names)
    }

    /// Stages the new pictures that differ from their goldens, or have none, in the place of goldens. Nothing is written before the
    /// files are [committed](AtomicFile::commit). Pictures that cannot be read are never accepted.
    ///
    /// # Errors
    /// [`FoldersError`]; nothing is accepted then.
    pub fn accept(&self, limits: &Limits) -> Result<Vec<(&Found, AtomicFile)>, FoldersError> {
        let mut staged = Vec::new();
        for f in self.found.iter().filter(|f| f.verdict.is_acceptable()) {
            limits.check()?;
            // That of a damaged golden may be damaged as well.
            match read_picture(&self.new.join(&f.path), limits) {
                Ok((bytes, _)) => staged.push((f, stage(&self.golden.join(&f.path), &bytes)?)),
                Err(e) => drop(e.verdict()?),
            }
        }
        Ok(staged)
    }

    /// Goldens without a counterpart.
    pub fn dead(&self) -> impl Iterator<Item = PathBuf> + '_ {
        let dead = |f: &&Found| f.verdict == Verdict::Dead;
        (self.found.iter().filter(dead)).map(|f| self.golden.join(&f.path))
    }
}

/// Puts bytes beside their place, whose folder is made where it is missing.
///
/// # Errors
/// [`FileError`].
pub fn stage(path: &Path, bytes: &[u8]) -> Result<AtomicFile, FileError> {
    if let Some(folder) = path.parent() {
        files::make_folder(folder)?;
    }
    let mut file = AtomicFile::create(path)?;
    file.store(bytes)?;
    Ok(file)
}

/// The difference picture of two PNG files of one size, as PNG.
pub(super) fn difference_of(golden: &[u8], new: &[u8]) -> Option<Vec<u8>> {
    let (a, b) = (png::decode_deep(golden).ok()?, png::decode_deep(new).ok()?);
    png::encode_rgb(&difference(&a, &b).ok()?).ok()
}

/// Why a picture cannot be compared.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// The file.
    #[error(transparent)]
    File(#[from] FileError),
    /// What is in it, after its name.
    #[error("{0}")]
    Damaged(String),
    /// Memory or time.
    #[error(transparent)]
    Limit(#[from] LimitError),
}

impl PictureError {
    /// What is found of the picture then, unless the limits of the comparison are the reason.
    fn verdict(self) -> Result<Verdict, FoldersError> {
        match self {
            Self::Limit(e) => Err(e.into()),
            Self::File(e) if e.kind() == FileErrorKind::Limit => Err(e.into()),
            // Both name the file.
            e => Ok(Verdict::Unreadable(e.to_string())),
        }
    }
}

/// Bytes and pixels of a PNG file that is small enough to be compared.
///
/// # Errors
/// [`PictureError`].
pub fn read_picture(path: &Path, limits: &Limits) -> Result<(Vec<u8>, DeepImage), PictureError> {
    let damaged = |e: ReadError| PictureError::Damaged(format!("{}: {e}", path.display()));
    let bytes = files::read_model(path, limits.max_memory.unwrap_or(u64::MAX))?;
    let [width, height] = png::size(&bytes).map_err(damaged)?;
    let pixels = u128::from(width) * u128::from(height);
    limits.memory("comparing pictures of this size", pixels * PIXEL_BYTES)?;
    let picture = png::decode_deep(&bytes).map_err(damaged)?;
    Ok((bytes, picture))
}

/// Compares two PNG files.
///
/// # Errors
/// [`FoldersError`] for a limit. What is wrong with the files is the verdict.
pub fn compare_files(
    golden: &Path,
    new: &Path,
    tolerance: &Tolerance,
    limits: &Limits,
) -> Result<Verdict, FoldersError> {
    let (bytes, a) = match read_picture(golden, limits) {
        Ok(picture) => picture,
        Err(e) => return e.verdict(),
    };
    // Most are the same file.
    if files::read_model(new, bytes.len() as u64).is_ok_and(|b| b == bytes) {
        return Ok(Verdict::Equal);
    }
    match read_picture(new, limits) {
        Ok((_, b)) => Ok(judge(&a, &b, tolerance)),
        Err(e) => e.verdict(),
    }
}
