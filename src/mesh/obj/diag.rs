//! What the reader has to say: errors that name file, line and the offending text, and warnings summed by kind.
//!
//! Bytes of the file reach a message only through [`escape`], so a message holds no control characters and stays short. Warnings are
//! one per kind, with the first line and a count; their number, and so the size of all messages, is bounded by construction.

use std::fmt;

/// Most characters of a file's text that a message quotes.
pub const QUOTE_LIMIT: usize = 80;
/// Most characters of a file name that a message repeats.
const NAME_LIMIT: usize = 1024;

/// Bytes as printable text: control characters, line and direction marks and invalid UTF-8 as escapes, cut to `limit` characters.
#[must_use]
pub fn escape(bytes: &[u8], limit: usize) -> String {
    // Every character takes at least one byte of the source, so a longer prefix is never needed.
    let prefix = &bytes[..bytes.len().min(limit.saturating_mul(4).saturating_add(4))];
    let mut out = String::new();
    let mut used = 0;
    let mut push = |piece: &str| {
        used += piece.chars().count();
        let fits = used <= limit;
        if fits {
            out.push_str(piece);
        }
        fits
    };
    let mut whole = prefix.len() == bytes.len();
    'chunks: for chunk in prefix.utf8_chunks() {
        for c in chunk.valid().chars() {
            let fits = if is_plain(c) {
                push(c.encode_utf8(&mut [0; 4]))
            } else {
                push(&c.escape_default().to_string())
            };
            if !fits {
                whole = false;
                break 'chunks;
            }
        }
        for b in chunk.invalid() {
            if !push(&format!("\\x{b:02x}")) {
                whole = false;
                break 'chunks;
            }
        }
    }
    if !whole {
        out.push('…');
    }
    out
}

/// Printable, and neither a line separator nor a mark that changes the direction or position of other text.
fn is_plain(c: char) -> bool {
    !(c.is_control()
        || matches!(c, '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}')
        || matches!(c, '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}'))
}

/// Who can do something about a [`ReadError`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ReadErrorKind {
    /// The file holds what no cage can be made of.
    Data,
    /// The system refuses the file.
    Io,
    /// A budget or the reach of 32-bit indices is exceeded.
    Limit,
}

/// Why a file did not become a cage.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadError {
    file: String,
    line: Option<usize>,
    kind: ReadErrorKind,
    what: String,
}

impl ReadError {
    pub(crate) fn new(
        file: &str,
        line: Option<usize>,
        kind: ReadErrorKind,
        what: impl Into<String>,
    ) -> Self {
        Self {
            file: file.to_owned(),
            line,
            kind,
            what: what.into(),
        }
    }
    /// The file, as it was named by the caller.
    #[must_use]
    pub fn file(&self) -> &str {
        &self.file
    }
    /// The line, counted from 1, where there is one.
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        self.line
    }
    /// Who can do something about it.
    #[must_use]
    pub fn kind(&self) -> ReadErrorKind {
        self.kind
    }
    /// What is wrong, without file and line.
    #[must_use]
    pub fn what(&self) -> &str {
        &self.what
    }
}

fn place(f: &mut fmt::Formatter<'_>, file: &str, line: Option<usize>) -> fmt::Result {
    f.write_str(&escape(file.as_bytes(), NAME_LIMIT))?;
    match line {
        Some(line) => write!(f, ":{line}: "),
        None => f.write_str(": "),
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        place(f, &self.file, self.line)?;
        f.write_str(&self.what)
    }
}

impl std::error::Error for ReadError {}

/// What a [`Warning`] is about; at most one warning of each kind is given for a file and its libraries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum WarningKind {
    /// A face with fewer than three corners was left out.
    ShortFace,
    /// A face with fewer than three different corners was left out.
    CollapsedFace,
    /// A face names a vertex twice.
    RepeatedVertex,
    /// Line elements were skipped.
    Lines,
    /// Point elements were skipped.
    Points,
    /// Free-form curves and surfaces were skipped.
    FreeForm,
    /// Statements that would read a file or run a command were not followed.
    Command,
    /// Statements that are not known were skipped.
    Unknown,
    /// Numbers after the last one that has a meaning were ignored.
    ExtraNumbers,
    /// Vertex colours outside 0 to 1 were clamped.
    ColorRange,
    /// Texture coordinates are missing on some corners.
    MissingUvs,
    /// Hierarchical edits were ignored.
    HierarchicalEdit,
    /// Tags that are not known were ignored.
    UnknownTag,
    /// A tag has more arguments than it declares.
    ExtraTagArguments,
    /// Negative sharpness was taken as 0.
    NegativeSharpness,
    /// A crease from a vertex to itself was ignored.
    CollapsedCrease,
    /// So far from the origin that the text does not hold the shape any more.
    Precision,
    /// A material library is missing or cannot be read.
    Library,
    /// Too many material libraries.
    TooManyLibraries,
    /// A material is used but not defined.
    MissingMaterial,
    /// A material is defined more than once; the first one counts.
    DuplicateMaterial,
    /// Lines of a material library were dropped.
    MaterialLine,
    /// Values of a material were clamped.
    MaterialRange,
    /// Options of a texture map were ignored.
    MapOptions,
}

/// Something odd that did not keep the file from being read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    kind: WarningKind,
    file: String,
    line: Option<usize>,
    count: usize,
    what: String,
}

impl Warning {
    pub(crate) fn new(
        kind: WarningKind,
        file: &str,
        line: Option<usize>,
        what: impl Into<String>,
    ) -> Self {
        Self {
            kind,
            file: file.to_owned(),
            line,
            count: 1,
            what: what.into(),
        }
    }
    /// What it is about.
    #[must_use]
    pub fn kind(&self) -> WarningKind {
        self.kind
    }
    /// The file that it is about.
    #[must_use]
    pub fn file(&self) -> &str {
        &self.file
    }
    /// The first line, counted from 1, where there is one.
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        self.line
    }
    /// How often it was met.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }
    /// Adds this warning to the one of its kind in `list`.
    pub(crate) fn add_to(self, list: &mut Vec<Self>) {
        match list.iter_mut().find(|w| w.kind == self.kind) {
            Some(w) => w.count += self.count,
            None => list.push(self),
        }
    }
    pub(crate) fn times(mut self, count: usize) -> Self {
        self.count = count;
        self
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        place(f, &self.file, self.line)?;
        f.write_str(&self.what)?;
        if self.count > 1 {
            write!(f, " (and {} more like this)", self.count - 1)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_leave_nothing_raw_and_stay_short() {
        assert_eq!(escape(b"plain", 80), "plain");
        assert_eq!(escape("größe".as_bytes(), 80), "größe");
        assert_eq!(escape(b"\x1b[31m\xff\x00", 80), "\\u{1b}[31m\\xff\\u{0}");
        assert_eq!(
            escape("a\u{2028}\u{202e}b".as_bytes(), 80),
            "a\\u{2028}\\u{202e}b"
        );
        assert_eq!(escape(&[b'x'; 5000], 10), "xxxxxxxxxx…");
        for n in 0..90 {
            let cut = escape(&vec![0xfe; n], QUOTE_LIMIT);
            assert!(cut.chars().count() <= QUOTE_LIMIT + 1);
            assert!(cut.chars().all(is_plain));
        }
    }

    #[test]
    fn places_are_printed_where_there_are_any() {
        let e = ReadError::new("a\nb.obj", Some(7), ReadErrorKind::Data, "bad");
        assert_eq!(e.to_string(), "a\\nb.obj:7: bad");
        let mut list = Vec::new();
        for line in 3..6 {
            Warning::new(WarningKind::Lines, "m.obj", Some(line), "skipped").add_to(&mut list);
        }
        assert_eq!(list.len(), 1);
        assert_eq!(
            list[0].to_string(),
            "m.obj:3: skipped (and 2 more like this)"
        );
    }
}
