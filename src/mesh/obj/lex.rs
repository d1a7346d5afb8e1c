//! Bytes to statements: line ends, blanks, comments, continuation, and where a file may be cut into chunks.
//!
//! A line ends at LF, CR or CR LF. A backslash right before a line end joins the next line, as if it were a blank; not inside a
//! comment, because comments hold Windows paths. Blanks are space, tab, vertical tab and form feed. A `#` starts a comment anywhere
//! in a statement of numbers, and in a statement of names where it stands alone (`usemtl red#2` is a name).
//!
//! Everything is linear: each byte is looked at a constant number of times, whatever the file holds.

use std::borrow::Cow;

const ONES: u64 = 0x0101_0101_0101_0101;
const HIGHS: u64 = 0x8080_8080_8080_8080;

/// Index of the first CR or LF at or after `at`, or the length of `s`. Eight bytes at a time.
#[inline]
pub(super) fn find_line_end(s: &[u8], mut at: usize) -> usize {
    while let Some(eight) = s.get(at..at + 8) {
        let mut word = [0; 8];
        word.copy_from_slice(eight);
        let word = u64::from_le_bytes(word);
        let lf = word ^ (ONES * b'\n' as u64);
        let cr = word ^ (ONES * b'\r' as u64);
        // The lowest set bit marks the first zero byte; bits above it may be false.
        let hit = ((lf.wrapping_sub(ONES) & !lf) | (cr.wrapping_sub(ONES) & !cr)) & HIGHS;
        if hit != 0 {
            return at + (hit.trailing_zeros() / 8) as usize;
        }
        at += 8;
    }
    while at < s.len() && !is_line_end(s[at]) {
        at += 1;
    }
    at
}

#[inline]
const fn is_line_end(b: u8) -> bool {
    b == b'\n' || b == b'\r'
}

/// The start of the line after the line end at `end`; the length of `s` when there is none.
#[inline]
fn after_line_end(s: &[u8], end: usize) -> usize {
    match (s.get(end), s.get(end + 1)) {
        (Some(b'\r'), Some(b'\n')) => end + 2,
        (Some(_), _) => end + 1,
        (None, _) => s.len(),
    }
}

/// Length of a backslash with its line end at `at`; 0 when there is none.
#[inline]
fn continuation(s: &[u8], at: usize) -> usize {
    match (s.get(at), s.get(at + 1)) {
        (Some(b'\\'), Some(&b)) if is_line_end(b) => after_line_end(s, at + 1) - at,
        _ => 0,
    }
}

/// Start of the next statement, from a place in this one that is not inside a comment.
#[inline]
pub(super) fn next_statement(s: &[u8], mut at: usize) -> usize {
    if s.get(at) == Some(&b'\n') {
        return at + 1;
    }
    loop {
        let end = find_line_end(s, at);
        if end < s.len() && end > at && s[end - 1] == b'\\' && !s[at..end].contains(&b'#') {
            at = after_line_end(s, end);
            continue;
        }
        return after_line_end(s, end);
    }
}

/// Cuts the bytes into pieces of about `size`, each a whole number of statements. Returns the boundaries, first 0, last the length.
///
/// A cut is made only behind a line end that no backslash precedes, so it never falls into a continued line.
pub(super) fn cut(s: &[u8], size: usize) -> Vec<usize> {
    let size = size.max(1);
    let mut cuts = vec![0];
    let mut last = 0;
    while s.len() - last > size {
        let mut at = last + size;
        // Between CR and LF is the middle of a line end.
        if s[at] == b'\n' && s[at - 1] == b'\r' {
            at -= 1;
        }
        loop {
            let end = find_line_end(s, at);
            at = after_line_end(s, end);
            if end >= s.len() || end == 0 || s[end - 1] != b'\\' {
                break;
            }
        }
        if at >= s.len() {
            break;
        }
        cuts.push(at);
        last = at;
    }
    cuts.push(s.len());
    cuts
}

/// Turns byte offsets into line numbers, walking the file once; ask in ascending order.
pub(super) struct LineCounter<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> LineCounter<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            at: 0,
            line: 1,
        }
    }

    /// Line of the byte at `offset`, counted from 1.
    pub(super) fn line(&mut self, offset: usize) -> usize {
        let offset = offset.min(self.bytes.len());
        if offset < self.at {
            *self = Self::new(self.bytes);
        }
        loop {
            let end = find_line_end(self.bytes, self.at);
            if end >= offset {
                return self.line;
            }
            self.at = after_line_end(self.bytes, end);
            self.line += 1;
        }
    }
}

/// A place in a piece of the file.
pub(super) struct Cursor<'a> {
    pub(super) s: &'a [u8],
    pub(super) at: usize,
}

impl<'a> Cursor<'a> {
    /// The byte here; 0 at the end.
    #[inline]
    pub(super) fn peek(&self) -> u8 {
        self.s.get(self.at).copied().unwrap_or(0)
    }

    /// Skips blanks and continuations.
    #[inline]
    pub(super) fn blanks(&mut self) {
        loop {
            match self.s.get(self.at) {
                Some(b' ') => self.at += 1,
                Some(b'\n') => return,
                Some(&b) if b > b' ' && b != b'\\' => return,
                _ => return self.rare_blanks(),
            }
        }
    }

    #[inline(never)]
    fn rare_blanks(&mut self) {
        loop {
            match self.s.get(self.at) {
                Some(b' ' | b'\t' | 0x0b | 0x0c) => self.at += 1,
                Some(b'\\') => match continuation(self.s, self.at) {
                    0 => return,
                    n => self.at += n,
                },
                _ => return,
            }
        }
    }

    /// Whether a word of numbers ends here: blank, line end, comment, continuation or end of file.
    #[inline]
    pub(super) fn at_separator(&self) -> bool {
        matches!(self.s.get(self.at), Some(b' ' | b'\n')) || self.at_rare_separator()
    }

    #[inline(never)]
    fn at_rare_separator(&self) -> bool {
        match self.s.get(self.at) {
            None | Some(b' ' | b'\n' | b'\r' | b'\t' | b'#' | 0x0b | 0x0c) => true,
            Some(b'\\') => continuation(self.s, self.at) != 0,
            _ => false,
        }
    }

    /// Skips blanks; true when nothing but a comment is left of the statement.
    #[inline]
    pub(super) fn at_end(&mut self) -> bool {
        self.blanks();
        matches!(self.s.get(self.at), None | Some(b'\n' | b'\r' | b'#'))
    }

    /// The bytes up to the next separator.
    pub(super) fn word(&mut self) -> &'a [u8] {
        let start = self.at;
        while !self.at_separator() {
            self.at += 1;
        }
        &self.s[start..self.at]
    }
}

/// The rest of a statement of names from `at`, without comment and outer blanks, continued lines joined by one blank.
pub(super) fn names(s: &[u8], at: usize) -> Cow<'_, [u8]> {
    let stop = next_statement(s, at);
    let raw = &s[at..stop];
    let mut joined: Cow<'_, [u8]> = Cow::Borrowed(raw);
    if raw.contains(&b'\\') {
        let mut i = 0;
        let mut out = Vec::with_capacity(raw.len());
        while i < raw.len() {
            match continuation(raw, i) {
                0 => {
                    out.push(raw[i]);
                    i += 1;
                }
                n => {
                    out.push(b' ');
                    i += n;
                }
            }
        }
        joined = Cow::Owned(out);
    }
    let (start, end) = without_comment(&joined);
    match joined {
        Cow::Borrowed(b) => Cow::Borrowed(&b[start..end]),
        Cow::Owned(b) => Cow::Owned(b[start..end].to_vec()),
    }
}

/// Range of a line of names without outer blanks and without a comment: a `#` at its start, or one alone between blanks.
fn without_comment(line: &[u8]) -> (usize, usize) {
    let blank = |i: usize| line.get(i).is_none_or(u8::is_ascii_whitespace);
    let comment = |(i, &b): (usize, &u8)| b == b'#' && (i == 0 || blank(i - 1) && blank(i + 1));
    let end = line
        .iter()
        .enumerate()
        .position(comment)
        .unwrap_or(line.len());
    let kept = &line[..end];
    let start = kept
        .iter()
        .position(|b| !b.is_ascii_whitespace())
        .unwrap_or(end);
    let stop = kept
        .iter()
        .rposition(|b| !b.is_ascii_whitespace())
        .map_or(start, |i| i + 1);
    (start, stop)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn line_ends_are_found_at_every_offset() {
        for n in 0..40 {
            for end in [b'\n', b'\r'] {
                let mut s = vec![0x8b_u8; 40];
                s[n] = end;
                s[39] = b'\n';
                for at in 0..=n {
                    assert_eq!(find_line_end(&s, at), n);
                }
            }
        }
        assert_eq!(find_line_end(b"abc", 1), 3);
    }

    #[test]
    fn statements_join_continued_lines_but_not_comments() {
        assert_eq!(next_statement(b"f 1 2 \\\n3\nv", 0), 10);
        assert_eq!(next_statement(b"f 1 2 \\\r\n3\r\nv", 0), 12);
        assert_eq!(next_statement(b"# C:\\\nv", 0), 6);
        assert_eq!(next_statement(b"f \\", 0), 3);
    }

    #[test]
    fn cuts_keep_continued_lines_whole() {
        let s = b"a\\\nb\\\r\nc\r\nd\re\n";
        for size in 1..20 {
            let cuts = cut(s, size);
            assert_eq!((cuts[0], *cuts.last().unwrap()), (0, s.len()));
            for &c in &cuts {
                assert!(
                    [0, 10, 12, s.len()].contains(&c),
                    "cut at {c} for size {size}"
                );
            }
        }
        assert_eq!(cut(s, 1), [0, 10, 12, 14]);
    }

    #[test]
    fn lines_are_counted_for_every_kind_of_end() {
        let mut lines = LineCounter::new(b"a\nb\r\nc\rd");
        let got: Vec<_> = [0, 2, 5, 7].iter().map(|&o| lines.line(o)).collect();
        assert_eq!(got, [1, 2, 3, 4]);
        assert_eq!(lines.line(0), 1);
    }

    #[test]
    fn names_lose_comments_but_keep_marks_inside() {
        assert_eq!(&*names(b" red#2 # note\nv", 0), b"red#2");
        assert_eq!(&*names(b" red #2\n", 0), b"red #2");
        assert_eq!(&*names(b" two \\\n words\n", 0), b"two   words");
        assert_eq!(&*names(b"", 0), b"");
    }
}
