//! The state of the view as the flags of the command line that draws it: what a key changes is a flag, and the picture is drawn from the
//! flags. So the command that is printed cannot say anything else than what is seen.

use crate::camera::Camera;
use std::ffi::{OsStr, OsString};

/// Flags with their values, each once, in the order in which they were first given.
///
/// ```
/// use earmark::window::Flags;
/// let mut flags = Flags::default();
/// flags.set("level", "3");
/// flags.switch("ortho", true);
/// assert_eq!(flags.tokens(), ["--level", "3", "--ortho"]);
/// flags.set("level", "-1");
/// assert_eq!(flags.tokens(), ["--level=-1", "--ortho"]);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Flags(Vec<(String, Option<OsString>)>);

/// Flags that a loaded model does not depend on, beside those of the camera.
const PICTURE: &[&str] = &[
    "size",
    "samples",
    "background",
    "shade",
    "level",
    "adaptive",
    "max-level",
    "light-turn",
    "overlay",
];

impl Flags {
    /// The value of a flag; empty for one that takes none.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&OsStr> {
        let (_, value) = self.0.iter().find(|(n, _)| n == name)?;
        Some(value.as_deref().unwrap_or_default())
    }
    /// The same as text, where it is text.
    #[must_use]
    pub fn text(&self, name: &str) -> Option<&str> {
        self.get(name)?.to_str()
    }
    /// The same as a number.
    #[must_use]
    pub fn number(&self, name: &str) -> Option<f64> {
        self.text(name)?.parse().ok()
    }
    /// Gives a flag a value.
    pub fn set(&mut self, name: &str, value: impl Into<OsString>) {
        self.put(name, Some(value.into()));
    }
    /// Takes a flag away.
    pub fn unset(&mut self, name: &str) {
        self.0.retain(|(n, _)| n != name);
    }
    /// Sets a flag that takes no value, or takes it away.
    pub fn switch(&mut self, name: &str, on: bool) {
        match on {
            true => self.put(name, None),
            false => self.unset(name),
        }
    }
    /// Gives a flag a value, or takes it away where that is what holds without it.
    pub fn set_unless(&mut self, name: &str, value: &str, default: &str) {
        match value == default {
            true => self.unset(name),
            false => self.set(name, value),
        }
    }
    fn put(&mut self, name: &str, value: Option<OsString>) {
        match self.0.iter_mut().find(|(n, _)| n == name) {
            Some(flag) => flag.1 = value,
            None => self.0.push((name.to_owned(), value)),
        }
    }

    /// The flags of a camera in place of those that were there; what is the default is not said.
    pub fn set_camera(&mut self, camera: &Camera) {
        let plain = Camera::default();
        let mut number = |name: &str, value: f64, default: f64| match value == default {
            true => self.unset(name),
            false => self.set(name, value.to_string()),
        };
        // With an eye the angles mean nothing.
        let (azimuth, elevation) = match camera.eye {
            Some(_) => (plain.azimuth, plain.elevation),
            None => (camera.azimuth, camera.elevation),
        };
        number("azimuth", azimuth, plain.azimuth);
        number("elevation", elevation, plain.elevation);
        number("zoom", camera.zoom, plain.zoom);
        number("fov", camera.fov, plain.fov);
        self.switch("ortho", camera.ortho);
        let vector = |v: [f64; 3]| v.map(|x| x.to_string()).join(",");
        let up = (camera.up != plain.up).then_some(camera.up);
        for (name, v) in [("eye", camera.eye), ("target", camera.target), ("up", up)] {
            match v {
                Some(v) => self.set(name, vector(v)),
                None => self.unset(name),
            }
        }
        for (name, x) in [("near", camera.near), ("far", camera.far)] {
            match x {
                Some(x) => self.set(name, x.to_string()),
                None => self.unset(name),
            }
        }
    }

    /// The flags that a loaded model depends on. How the limit surface, its control points and the polygons are told apart is not among
    /// them: a model is loaded once for the three.
    #[must_use]
    pub fn of_model(&self) -> Self {
        let mut out = self.clone();
        out.set_camera(&Camera::default());
        out.0.retain(|(name, _)| !PICTURE.contains(&name.as_str()));
        if matches!(out.text("surface"), Some("limit" | "refined" | "cage")) {
            out.unset("surface");
        }
        out
    }

    /// As arguments of a command.
    #[must_use]
    pub fn tokens(&self) -> Vec<OsString> {
        let mut out = Vec::new();
        for (name, value) in &self.0 {
            let name = format!("--{name}");
            match value {
                None => out.push(name.into()),
                Some(value) if value.as_encoded_bytes().first() == Some(&b'-') => {
                    let mut joined = OsString::from(name + "=");
                    joined.push(value);
                    out.push(joined);
                }
                Some(value) => out.extend([name.into(), value.clone()]),
            }
        }
        out
    }
}

/// A line for a shell that runs a command with these arguments.
#[must_use]
pub fn shell_line(tokens: &[OsString]) -> String {
    let words: Vec<String> = tokens.iter().map(|t| quoted(t)).collect();
    words.join(" ")
}

/// A word in single quotes where a shell would see more in it than a word.
fn quoted(word: &OsStr) -> String {
    let text = word.to_string_lossy();
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_=+,./:@%".contains(c);
    match !text.is_empty() && text.chars().all(plain) {
        true => text.into_owned(),
        false => format!("'{}'", text.replace('\'', r"'\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_are_said_as_far_as_they_are_not_the_default() {
        let mut flags = Flags::default();
        flags.set_camera(&Camera::default());
        assert_eq!(flags, Flags::default());
        flags.set("shade", "flat");
        let camera = Camera::default().with_orbit(-30.5, 25.0).with_zoom(2.0);
        flags.set_camera(&camera);
        let want = ["--shade", "flat", "--azimuth=-30.5", "--zoom", "2"];
        assert_eq!(flags.tokens(), want);
        let eye = camera.with_eye_target([1.0, -2.0, 0.1], [0.0; 3]);
        flags.set_camera(&eye);
        assert_eq!(
            shell_line(&flags.tokens()),
            "--shade flat --zoom 2 --eye 1,-2,0.1 --target 0,0,0"
        );
        flags.set_camera(&Camera::default());
        assert_eq!(flags.tokens(), ["--shade", "flat"]);
    }

    #[test]
    fn models_depend_on_few_flags() {
        let mut flags = Flags::default();
        flags.set("scheme", "loop");
        flags.set("surface", "refined");
        flags.set("level", "3");
        flags.set("displace", "a b.png");
        assert_eq!(
            flags.of_model().tokens(),
            ["--scheme", "loop", "--displace", "a b.png"]
        );
        flags.set("surface", "qas");
        assert!(flags.of_model().get("surface").is_some());
    }

    #[test]
    fn words_are_quoted_for_the_shell() {
        let line = |words: &[&str]| {
            let words: Vec<OsString> = words.iter().map(Into::into).collect();
            shell_line(&words)
        };
        assert_eq!(line(&["a.obj", "--size=3x4"]), "a.obj --size=3x4");
        assert_eq!(line(&["a b", "", "it's", "$x"]), r"'a b' '' 'it'\''s' '$x'");
    }
}
