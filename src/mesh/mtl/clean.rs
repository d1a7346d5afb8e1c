//! Lines of a material library in the form that the parser takes.
//!
//! A one-number colour is grey, as the format says. Words and numbers that are not finite cost their line; values out of range are
//! clamped; keys that nobody here uses are left out.

use crate::mesh::obj::{QUOTE_LIMIT, WarningKind, escape};

/// Words with their places.
pub(super) fn words(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.split_whitespace()
        .map(move |word| (word.as_ptr() as usize - text.as_ptr() as usize, word))
}

/// Key and arguments of a line without its comment; `None` for empty lines.
pub(super) fn split_key(line: &str) -> Option<(&str, &str)> {
    let mut line = line.trim();
    if line.starts_with('#') {
        return None;
    }
    // A mark inside a word belongs to a name, as in OBJ files.
    let comment = words(line).find(|(_, word)| *word == "#");
    if let Some((at, _)) = comment {
        line = line[..at].trim_end();
    }
    let key = line.split_whitespace().next()?;
    Some((key, line[key.len()..].trim()))
}

/// Appends the line to `out` in a form that the parser takes, or drops it with a warning.
pub(super) fn clean(
    key: &str,
    rest: &str,
    out: &mut String,
    say: &mut impl FnMut(WarningKind, String),
) {
    let mut drop_line = |why: &str| {
        let quoted = escape(key.as_bytes(), QUOTE_LIMIT);
        say(
            WarningKind::MaterialLine,
            format!("'{quoted}' {why}; line dropped"),
        );
    };
    let lower = key.to_ascii_lowercase();
    match lower.as_str() {
        "kd" | "ka" | "ks" | "ke" | "tf" => {
            let Some(mut color) = color(rest) else {
                return drop_line("without three finite numbers");
            };
            if lower == "kd" {
                clamp(&mut color, key, say);
                let [r, g, b] = color;
                out.push_str(&format!("Kd {r} {g} {b}\n"));
            }
        }
        "d" | "tr" | "ns" | "ni" | "illum" => {
            let value = rest.strip_prefix("-halo").unwrap_or(rest);
            let Some(value) = value.split_whitespace().next().and_then(finite) else {
                return drop_line("without a finite number");
            };
            let mut value = [value];
            if lower == "d" || lower == "tr" {
                clamp(&mut value, key, say);
                let key = if lower == "d" { "d" } else { "Tr" };
                out.push_str(&format!("{key} {}\n", value[0]));
            }
        }
        _ => {
            let Some(&(_, canonical)) = MAPS.iter().find(|m| m.0 == lower) else {
                return;
            };
            let (name, options) = split_options(rest);
            if name.is_empty() {
                return drop_line("without a file name");
            }
            if options && canonical.starts_with("map_") {
                say(
                    WarningKind::MapOptions,
                    "options of texture maps are ignored".into(),
                );
            }
            // With its options: they are split off again behind the parser, which takes the rest of the line as it is.
            out.push_str(&format!("{canonical} {rest}\n"));
        }
    }
}

/// Keys of texture maps in small letters, and how the parser wants them.
const MAPS: &[(&str, &str)] = &[
    ("map_kd", "map_Kd"),
    ("map_d", "map_d"),
    ("map_bump", "map_Bump"),
    ("bump", "bump"),
    ("norm", "norm"),
    ("map_norm", "norm"),
    ("disp", "disp"),
    ("map_disp", "disp"),
];

pub(super) fn finite(word: &str) -> Option<f32> {
    word.parse().ok().filter(|v: &f32| v.is_finite())
}

/// Three numbers, or one for grey.
fn color(rest: &str) -> Option<[f32; 3]> {
    let mut values = [0.0; 3];
    let mut n = 0;
    for word in rest.split_whitespace().take(3) {
        // A comment may touch the last number.
        let word = word.split('#').next().unwrap_or_default();
        if word.is_empty() {
            break;
        }
        values[n] = finite(word)?;
        n += 1;
    }
    match n {
        1 => Some([values[0]; 3]),
        3 => Some(values),
        _ => None,
    }
}

fn clamp(values: &mut [f32], key: &str, say: &mut impl FnMut(WarningKind, String)) {
    let before: Vec<f32> = values.to_vec();
    for v in values.iter_mut() {
        *v = v.clamp(0.0, 1.0);
    }
    if *values != before[..] {
        let quoted = escape(key.as_bytes(), QUOTE_LIMIT);
        say(
            WarningKind::MaterialRange,
            format!("'{quoted}' clamped to 0 to 1"),
        );
    }
}

/// The file name of a map behind its options, and whether there were any.
pub(super) fn split_options(rest: &str) -> (&str, bool) {
    let mut list = words(rest).peekable();
    let mut options = false;
    while let Some(&(at, word)) = list.peek() {
        let (least, most) = match word {
            "-blendu" | "-blendv" | "-bm" | "-boost" | "-cc" | "-clamp" | "-imfchan"
            | "-texres" | "-type" | "-colorspace" => (1, 1),
            "-mm" => (2, 2),
            "-o" | "-s" | "-t" => (1, 3),
            _ => return (rest[at..].trim_matches('"'), options),
        };
        options = true;
        list.next();
        for i in 0..most {
            let Some(&(_, word)) = list.peek() else {
                break;
            };
            if i >= least && finite(word).is_none() {
                break;
            }
            list.next();
        }
    }
    ("", options)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn map_options_are_split_off() {
        for (rest, name) in [
            ("-s 1 1 1 a b.png", "a b.png"),
            ("-s 2 a.png", "a.png"),
            ("-s 2 2 -clamp on -bm 0.5 a.png", "a.png"),
            ("-o 1 2 3 4.png", "4.png"),
            ("-mm 0 1 a.png", "a.png"),
            ("-unknown.png", "-unknown.png"),
            ("-s", ""),
        ] {
            assert_eq!(split_options(rest).0, name, "{rest}");
        }
    }
}
