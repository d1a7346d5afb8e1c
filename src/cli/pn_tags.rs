//! `--pn-tags`: a tension for every vertex of the model.

use super::exit::{Code, Failure};
use super::flags::LevelFlags;
use earmark::patch::PatchKind;
use earmark::{Scene, files};
use std::path::PathBuf;

/// Largest file of tensions.
const TAGS: u64 = 1 << 30;

/// The file of the flag.
pub(crate) struct PnTags(PathBuf);

impl PnTags {
    /// The flag's value, checked against the other flags and the number of models.
    pub(crate) fn of(flags: &LevelFlags, models: usize) -> Result<Option<Self>, Failure> {
        let Some(path) = &flags.pn_tags else {
            return Ok(None);
        };
        if flags.patches() != PatchKind::Pn {
            return Err(Failure::usage("--pn-tags is for --surface pn"));
        }
        if models != 1 {
            return Err(Failure::usage("--pn-tags is for one model"));
        }
        Ok(Some(Self(path.clone())))
    }

    /// Reads the file and gives its numbers to the scene's one model.
    pub(crate) fn apply(&self, scene: &mut Scene, memory: Option<u64>) -> Result<(), Failure> {
        let most = memory.unwrap_or(TAGS).min(TAGS);
        let bytes = files::read_model(&self.0, most)?;
        let fault = |line: usize, what: String| {
            Failure::new(Code::Data, format!("{}:{line}: {what}", self.0.display()))
        };
        for object in &mut scene.objects {
            let vertices = object.surface.cage().points().len();
            let values = tensions(&bytes, vertices).map_err(|(line, what)| fault(line, what))?;
            let set = object.surface.set_tension(&values);
            set.map_err(|e| Failure::new(Code::Internal, format!("earmark: {e}")))?;
        }
        Ok(())
    }
}

/// The numbers of a file, as many as there are vertices; else a line and what is wrong with it.
fn tensions(bytes: &[u8], vertices: usize) -> Result<Vec<f32>, (usize, String)> {
    let mut out = Vec::new();
    let mut line = 1;
    for (k, text) in bytes.split(|&b| b == b'\n').enumerate() {
        let text = text.split(|&b| b == b'#').next().unwrap_or_default();
        for word in text
            .split(u8::is_ascii_whitespace)
            .filter(|w| !w.is_empty())
        {
            line = k + 1;
            let shown = String::from_utf8_lossy(&word[..word.len().min(32)]);
            let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
            match number {
                Some(t) if (0.0..=1.0).contains(&t) => out.push(t),
                _ => {
                    let what = format!("{shown:?} is no tension; tensions are numbers from 0 to 1");
                    return Err((line, what));
                }
            }
            if out.len() > vertices {
                let what = format!("more numbers than the model has vertices, {vertices}");
                return Err((line, what));
            }
        }
    }
    match out.len() == vertices {
        true => Ok(out),
        false => {
            let what = format!(
                "{} numbers, but the model has {vertices} vertices",
                out.len()
            );
            Err((line, what))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_have_their_line() {
        assert_eq!(tensions(b"0 .5 # one\n\n1\r\n", 3), Ok(vec![0.0, 0.5, 1.0]));
        let line = |text: &str, n| tensions(text.as_bytes(), n).map_err(|e| e.0);
        assert_eq!(line("0\n1.5\n", 2), Err(2));
        assert_eq!(line("0\n\nnan", 2), Err(3));
        assert_eq!(line("0\n\u{e9}", 2), Err(2));
        assert_eq!(line("0\n1\n1\n", 2), Err(3));
        assert_eq!(line("0\n1\n# 1\n", 3), Err(2));
        assert_eq!(line("", 1), Err(1));
    }
}
