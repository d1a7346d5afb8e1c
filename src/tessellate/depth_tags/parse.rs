//! Depth tags of a file: text with one integer per vertex of the cage.

use super::MAX_DEPTH;

/// What is wrong with a file of depth tags. Its text begins with the file's name, and the line where there is one.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DepthTagsError {
    /// A word is no tag.
    #[error("{file}:{line}: {word:?} is no integer from 0 to {MAX_DEPTH}")]
    Word {
        /// What the file is called.
        file: String,
        /// Line, from 1 on.
        line: usize,
        /// The word, or its beginning.
        word: String,
    },
    /// There are more tags than vertices.
    #[error("{file}:{line}: more than {vertices} depth tags; the cage has {vertices} vertices")]
    TooMany {
        /// What the file is called.
        file: String,
        /// Line of the first that is too many.
        line: usize,
        /// Vertices of the cage.
        vertices: usize,
    },
    /// There are fewer tags than vertices.
    #[error("{file}:{line}: {found} depth tags at the end; the cage has {vertices} vertices")]
    TooFew {
        /// What the file is called.
        file: String,
        /// The last line.
        line: usize,
        /// Tags in the file.
        found: usize,
        /// Vertices of the cage.
        vertices: usize,
    },
}

/// Most characters of a word that messages show.
const SHOWN: usize = 32;

/// Reads depth tags: integers from 0 to 10 with white space between them, in the order of the cage's vertices. From `#` to the end of the line
/// is a comment. `name` is what messages call the file.
///
/// # Errors
/// [`DepthTagsError`]: a word that is no tag, or not as many tags as `vertices`.
pub fn parse(text: &[u8], name: &str, vertices: usize) -> Result<Vec<u8>, DepthTagsError> {
    let file = || name.to_owned();
    let mut tags = Vec::new();
    let mut last = 1;
    for (k, line) in text.split(|&b| b == b'\n').enumerate() {
        let line_number = k + 1;
        let line = line.split(|&b| b == b'#').next().unwrap_or_default();
        for word in line
            .split(u8::is_ascii_whitespace)
            .filter(|w| !w.is_empty())
        {
            last = line_number;
            let Some(tag) = tag(word) else {
                let shown = String::from_utf8_lossy(word);
                return Err(DepthTagsError::Word {
                    file: file(),
                    line: line_number,
                    word: shown.chars().take(SHOWN).collect(),
                });
            };
            if tags.len() == vertices {
                return Err(DepthTagsError::TooMany {
                    file: file(),
                    line: line_number,
                    vertices,
                });
            }
            tags.push(tag);
        }
    }
    if tags.len() < vertices {
        return Err(DepthTagsError::TooFew {
            file: file(),
            line: last,
            found: tags.len(),
            vertices,
        });
    }
    Ok(tags)
}

/// Digits alone: no sign, no fraction.
fn tag(word: &[u8]) -> Option<u8> {
    if word.len() > 3 || !word.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let value = word.iter().fold(0_u32, |n, d| 10 * n + u32::from(d - b'0'));
    (value <= MAX_DEPTH).then_some(value as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_are_read_in_order() {
        let text = b"# three\n0 10\r\n\n\t7 # last\n";
        assert_eq!(parse(text, "t", 3), Ok(vec![0, 10, 7]));
        assert_eq!(parse(b"", "t", 0), Ok(vec![]));
        assert_eq!(parse(b"5", "t", 1), Ok(vec![5]));
        assert_eq!(parse(b"05 000", "t", 2), Ok(vec![5, 0]));
    }

    #[test]
    fn errors_name_file_and_line() {
        let error = |text: &[u8]| parse(text, "tags.txt", 2).unwrap_err().to_string();
        for word in [
            "11",
            "-1",
            "+1",
            "1.0",
            "x",
            "1e0",
            "9999999999999999999",
            "\u{664}",
        ] {
            let text = format!("3\n{word}\n");
            let message = error(text.as_bytes());
            assert!(message.starts_with("tags.txt:2: "), "{message}");
            assert!(message.contains("is no integer from 0 to 10"), "{message}");
        }
        assert_eq!(
            error(b"1\n\n2 3"),
            "tags.txt:3: more than 2 depth tags; the cage has 2 vertices"
        );
        assert_eq!(
            error(b"1\n# end\n"),
            "tags.txt:1: 1 depth tags at the end; the cage has 2 vertices"
        );
        assert_eq!(error(b"\xff\n").lines().count(), 1);
        assert!(error(&[b'9'; 100_000]).len() < 100);
        assert_eq!(error(b"\x1b[2J 1").lines().count(), 1);
    }
}
