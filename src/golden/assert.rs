//! The assertion of tests: a picture against the golden of its name, and what is left behind when it differs.

use super::folders::difference_of;
use super::report::{Page, Pictures, Shown};
use super::{Verdict, judge};
use crate::compare::Tolerance;
use crate::files::{self, FileError, FileErrorKind};
use crate::film::{DeepImage, png};
use std::fmt;
use std::fs::File;
use std::path::{Path, PathBuf};

/// Largest file of a golden.
const LARGEST: u64 = 1 << 30;

/// Environment variable that accepts pictures, when it is `1`.
const BLESS: &str = "EARMARK_BLESS";

/// Asserts that a picture equals the golden of its name, pixel by pixel: `assert_image!("cube", image)`, or with a
/// [tolerance](crate::compare::Tolerance): `assert_image!("cube", image, max_delta = 2, max_pixels = 10)`.
///
/// The golden is `tests/golden/NAME.png` in the crate that asserts; folders in the name are made by `/`. The picture is a
/// [`film::Image`](crate::film::Image) or a [`film::DeepImage`](crate::film::DeepImage), or a reference to the first. See
/// [`golden`](crate::golden).
///
/// # Panics
/// When the picture differs, has another size, or has no golden; and when files cannot be read or written.
#[macro_export]
macro_rules! assert_image {
    ($name:expr, $image:expr $(, $field:ident = $value:expr)* $(,)?) => {{
        #[allow(unused_mut)]
        let mut tolerance = $crate::compare::Tolerance::default();
        $(tolerance.$field = $value;)*
        $crate::golden::assert_image_at(
            env!("CARGO_MANIFEST_DIR"),
            env!("CARGO_PKG_NAME"),
            ($name).as_ref(),
            &$crate::film::DeepImage::from($image),
            tolerance,
        );
    }};
}

/// What [`assert_image!`](crate::assert_image) does, in the crate of a folder and a name.
///
/// # Panics
/// See there.
#[track_caller]
pub fn assert_image_at(
    manifest: &str,
    package: &str,
    name: &str,
    image: &DeepImage,
    tolerance: Tolerance,
) {
    let goldens = Goldens::of(Path::new(manifest), package).tolerating(tolerance);
    if let Err(failure) = goldens.check(name, image) {
        panic!("{failure}");
    }
}

/// A folder of goldens, for tests that hold many pictures against it.
///
/// ```no_run
/// use earmark::{film::Image, golden::Goldens};
/// use std::path::Path;
///
/// let goldens = Goldens::of(Path::new(env!("CARGO_MANIFEST_DIR")), "mine").in_folder("pictures".as_ref());
/// if let Err(failure) = goldens.check("cube", &Image::new(8, 8).into()) {
///     panic!("{failure}");
/// }
/// assert_eq!(goldens.dead(["cube"])?, Vec::<String>::new());
/// # Ok::<(), earmark::files::FileError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Goldens {
    folder: PathBuf,
    output: PathBuf,
    tolerance: Tolerance,
    bless: bool,
}

/// How a check ended well.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The same pixels.
    Equal,
    /// Different, but let pass.
    Within,
    /// Accepted: the golden is written.
    Written,
}

/// Why a picture did not pass; what it prints names all files and figures.
#[derive(Debug)]
pub struct Failure(Box<Parts>);

#[derive(Debug)]
struct Parts {
    name: String,
    golden: PathBuf,
    output: PathBuf,
    /// What was found, unless files are in the way.
    verdict: Result<Verdict, FileError>,
    note: Option<&'static str>,
}

impl Failure {
    /// What was found; nothing where files could not be read or written.
    #[must_use]
    pub fn verdict(&self) -> Option<&Verdict> {
        self.0.verdict.as_ref().ok()
    }
    /// The page that shows it.
    #[must_use]
    pub fn report(&self) -> PathBuf {
        self.0.output.join("index.html")
    }
}

impl std::error::Error for Failure {}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, golden) = (&self.0.name, self.0.golden.display());
        let verdict = match &self.0.verdict {
            Ok(verdict) => verdict,
            Err(e) => return write!(f, "picture \"{name}\": {e}"),
        };
        let file = |kind: &str| self.0.output.join(kind).join(format!("{name}.png"));
        writeln!(f, "picture \"{name}\": {}", verdict.word())?;
        for line in verdict.figures().lines() {
            writeln!(f, "  {line}")?;
        }
        if *verdict != Verdict::New {
            writeln!(f, "  golden:     {golden}")?;
        }
        writeln!(f, "  new:        {}", file("new").display())?;
        if matches!(verdict, Verdict::Different(_)) {
            writeln!(f, "  difference: {}", file("difference").display())?;
        }
        writeln!(f, "  report:     {}", self.report().display())?;
        match self.0.note {
            Some(note) => write!(f, "  {note}"),
            None => write!(
                f,
                "  look at it; to accept it, run the test again with {BLESS}=1, which writes {golden}"
            ),
        }
    }
}

impl Goldens {
    /// The goldens of the crate in a folder: `tests/golden` there. What is left behind of failures is in `golden/PACKAGE` in the
    /// target folder. `EARMARK_BLESS=1` accepts.
    #[must_use]
    pub fn of(manifest: &Path, package: &str) -> Self {
        Self {
            folder: manifest.join("tests").join("golden"),
            output: target_folder(manifest).join("golden").join(package),
            tolerance: Tolerance::default(),
            bless: std::env::var_os(BLESS).is_some_and(|v| v == "1"),
        }
    }
    /// The same with goldens in another folder.
    #[must_use]
    pub fn in_folder(mut self, folder: &Path) -> Self {
        self.folder = folder.to_owned();
        self
    }
    /// The same with another folder for what is left behind.
    #[must_use]
    pub fn leaving_in(mut self, folder: &Path) -> Self {
        self.output = folder.to_owned();
        self
    }
    /// The same with a tolerance.
    #[must_use]
    pub fn tolerating(mut self, tolerance: Tolerance) -> Self {
        self.tolerance = tolerance;
        self
    }
    /// Whether pictures are accepted, whatever the environment says.
    #[must_use]
    pub fn blessing(mut self, bless: bool) -> Self {
        self.bless = bless;
        self
    }
    /// Whether pictures are accepted.
    #[must_use]
    pub fn is_blessing(&self) -> bool {
        self.bless
    }

    /// The file of a golden.
    #[must_use]
    pub fn file(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.png"))
    }

    /// Holds a picture against the golden of a name. A picture that does not pass is left in the output folder with its golden, the
    /// difference and the figures, and a page shows all that are there; one that passes takes its own away.
    ///
    /// # Errors
    /// [`Failure`]. Where pictures are accepted, only if files cannot be written, or under continuous integration (the variable `CI`
    /// is set): nobody looks at pictures there.
    pub fn check(&self, name: &str, image: &DeepImage) -> Result<Outcome, Failure> {
        let failure = |verdict, note| self.failure(name, verdict, note);
        if !is_name(name) {
            let unreadable = Verdict::Unreadable(
                "names are parts of a path: a-z, 0-9 and the like, with / between".into(),
            );
            return Err(failure(Ok(unreadable), Some("nothing was written")));
        }
        let new = self.encoded(name, image)?;
        let file_error = |e| failure(Err(e), None);
        let golden = match files::read_model(&self.file(name), LARGEST) {
            Ok(bytes) => Some(bytes),
            Err(_) if !self.file(name).exists() => None,
            Err(e) if e.kind() == FileErrorKind::Io && self.bless => None,
            Err(e) => return Err(file_error(e)),
        };
        let verdict = match golden.as_deref().map(png::decode_deep) {
            None => Verdict::New,
            Some(Ok(golden)) => judge(&golden, image, &self.tolerance),
            Some(Err(e)) => Verdict::Unreadable(format!("{}: {e}", self.file(name).display())),
        };
        let outcome = match verdict {
            Verdict::Equal => Outcome::Equal,
            Verdict::Within(_) => Outcome::Within,
            _ if self.bless && std::env::var_os("CI").is_none() => {
                write(&self.file(name), &new).map_err(file_error)?;
                Outcome::Written
            }
            verdict => {
                let left = self.leave(name, &verdict, golden.as_deref(), &new);
                left.map_err(file_error)?;
                let note = (self.bless).then_some("EARMARK_BLESS means nothing where CI is set");
                return Err(failure(Ok(verdict), note));
            }
        };
        self.take_away(name).map_err(file_error)?;
        Ok(outcome)
    }

    /// Writes a golden, whole or not at all.
    ///
    /// # Errors
    /// [`Failure`] when it is no picture or cannot be written.
    pub fn write(&self, name: &str, image: &DeepImage) -> Result<(), Failure> {
        let new = self.encoded(name, image)?;
        write(&self.file(name), &new).map_err(|e| self.failure(name, Err(e), None))
    }

    /// Bytes of a picture; one without pixels, or with other data than its size says, has none.
    fn encoded(&self, name: &str, image: &DeepImage) -> Result<Vec<u8>, Failure> {
        png::encode_deep(image).map_err(|e| {
            let verdict = Verdict::Unreadable(format!("the new picture: {e}"));
            self.failure(name, Ok(verdict), Some("nothing was written"))
        })
    }

    fn failure(
        &self,
        name: &str,
        verdict: Result<Verdict, FileError>,
        note: Option<&'static str>,
    ) -> Failure {
        Failure(Box::new(Parts {
            name: name.to_owned(),
            golden: self.file(name),
            output: self.output.clone(),
            verdict,
            note,
        }))
    }

    /// Goldens that no test reads: files in the folder whose names are not among `known`.
    ///
    /// # Errors
    /// [`FileError`] when the folder cannot be read.
    pub fn dead<'a>(
        &self,
        known: impl IntoIterator<Item = &'a str>,
    ) -> Result<Vec<String>, FileError> {
        let known: std::collections::BTreeSet<&str> = known.into_iter().collect();
        let names = names_below(&self.folder, "png")?;
        Ok(names
            .into_iter()
            .filter(|n| !known.contains(n.as_str()))
            .collect())
    }

    /// Leaves a picture that did not pass.
    fn leave(
        &self,
        name: &str,
        verdict: &Verdict,
        golden: Option<&[u8]>,
        new: &[u8],
    ) -> Result<(), FileError> {
        let lock = self.lock()?;
        self.remove_all(name)?;
        let place =
            |kind: &str, ending: &str| self.output.join(kind).join(format!("{name}.{ending}"));
        write(&place("new", "png"), new)?;
        if let Some(golden) = golden {
            write(&place("golden", "png"), golden)?;
            if let Some(difference) = difference_of(golden, new) {
                write(&place("difference", "png"), &difference)?;
            }
        }
        let text = format!("{}\n{}\n", verdict.class(), verdict.figures());
        write(&place("figures", "txt"), text.as_bytes())?;
        self.index()?;
        drop(lock);
        Ok(())
    }

    /// Removes what an earlier run left of a picture.
    fn take_away(&self, name: &str) -> Result<(), FileError> {
        let figures = self.output.join("figures").join(format!("{name}.txt"));
        if !figures.exists() {
            return Ok(());
        }
        let lock = self.lock()?;
        self.remove_all(name)?;
        self.index()?;
        drop(lock);
        Ok(())
    }

    fn remove_all(&self, name: &str) -> Result<(), FileError> {
        for kind in ["new", "golden", "difference"] {
            files::remove(&self.output.join(kind).join(format!("{name}.png")))?;
        }
        files::remove(&self.output.join("figures").join(format!("{name}.txt")))?;
        Ok(())
    }

    /// Tests run in threads and in processes; the page is written by one at a time.
    fn lock(&self) -> Result<Option<File>, FileError> {
        files::make_folder(&self.output)?;
        // Where files cannot be locked the page may miss an entry that another process writes at the same moment.
        let file = File::create(self.output.join(".lock")).ok();
        Ok(file.filter(|f| f.lock().is_ok()))
    }

    /// Writes the page of all that is left, or removes it.
    fn index(&self) -> Result<(), FileError> {
        let page = self.output.join("index.html");
        let names = names_below(&self.output.join("figures"), "txt")?;
        if names.is_empty() {
            files::remove(&page)?;
            return Ok(());
        }
        let mut out = Vec::new();
        let summary = match names.len() {
            1 => "1 picture does not pass".into(),
            n => format!("{n} pictures do not pass"),
        };
        // Writing to memory cannot fail.
        let _ = self.entries(&mut out, &summary, &names);
        files::write_atomic(&page, &out)
    }

    fn entries(&self, out: &mut Vec<u8>, summary: &str, names: &[String]) -> std::io::Result<()> {
        let title = format!("Golden pictures: {}", self.folder.display());
        let mut page = Page::begin(out, &title, summary)?;
        for name in names {
            let link = |kind: &str| {
                let path = format!("{kind}/{name}.png");
                self.output.join(&path).exists().then_some(path)
            };
            let [golden, new, difference] = ["golden", "new", "difference"].map(link);
            let figures = self.output.join("figures").join(format!("{name}.txt"));
            let text = files::read_model(&figures, 1 << 20).unwrap_or_default();
            let text = String::from_utf8_lossy(&text);
            let (class, figures) = text.split_once('\n').unwrap_or_default();
            let (class, word) = match (class, golden.is_some(), difference.is_some()) {
                ("new", ..) => ("new", Verdict::New.word()),
                (_, true, true) => ("bad", "different"),
                _ => ("bad", "cannot be compared"),
            };
            let pictures = Pictures {
                golden: golden.as_deref().map(Shown::Linked),
                new: new.as_deref().map(Shown::Linked),
                difference: difference.as_deref().map(Shown::Linked),
            };
            page.entry_of(name, class, word, figures.trim_end(), pictures)?;
        }
        page.end("", &[])
    }
}

/// Whether a name stays in its folder.
fn is_name(name: &str) -> bool {
    let part = |p: &str| {
        !p.is_empty()
            && !p.starts_with('.')
            && !p.contains(['\\', ':'])
            && !p.contains(char::is_control)
    };
    name.split('/').all(part)
}

/// Names of files with an ending in a folder, without it, `/` between folders; none where there is no folder.
fn names_below(folder: &Path, ending: &str) -> Result<Vec<String>, FileError> {
    if !folder.exists() {
        return Ok(Vec::new());
    }
    let paths = files::files_below(folder, ending)?;
    let name = |path: PathBuf| {
        let stem = path.with_extension("");
        let parts = stem.components().map(|c| c.as_os_str().to_string_lossy());
        parts.collect::<Vec<_>>().join("/")
    };
    Ok(paths.into_iter().map(name).collect())
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    if let Some(folder) = path.parent() {
        files::make_folder(folder)?;
    }
    files::write_atomic(path, bytes)
}

/// Cargo's target folder: where the running test was built, by the tag that marks such folders.
fn target_folder(manifest: &Path) -> PathBuf {
    let test = std::env::current_exe().unwrap_or_default();
    let mut folders = test.ancestors().skip(1);
    let tagged = folders.find(|f| f.join("CACHEDIR.TAG").is_file());
    tagged.map_or_else(|| manifest.join("target"), Path::to_owned)
}
