//! Line work as an SVG document: a path per kind of line, in relative steps of 1/100 pixel.

use super::chain::STEPS;
use super::paint::{Path, Shape};
use crate::records::ScreenSize;
use std::fmt::Write as _;

/// A number of hundredths, as short as it can be written.
fn number(out: &mut String, hundredths: i64, separate: bool) {
    if separate && hundredths >= 0 {
        out.push(' ');
    }
    if hundredths < 0 {
        out.push('-');
    }
    let n = hundredths.unsigned_abs();
    let (whole, rest) = (n / 100, n % 100);
    // Writing to a string cannot fail.
    let _ = match (whole, rest) {
        (0, 0) => write!(out, "0"),
        (whole, 0) => write!(out, "{whole}"),
        (0, rest) if rest % 10 == 0 => write!(out, ".{}", rest / 10),
        (0, rest) => write!(out, ".{rest:02}"),
        (whole, rest) if rest % 10 == 0 => write!(out, "{whole}.{}", rest / 10),
        (whole, rest) => write!(out, "{whole}.{rest:02}"),
    };
}

fn path_data(out: &mut String, paths: &[Path]) {
    for path in paths {
        let mut last = [0_i64; 2];
        for (k, point) in path.iter().enumerate() {
            let at = point.map(|c| (f64::from(c) * STEPS).round() as i64);
            match k {
                0 => out.push('M'),
                1 => out.push('l'),
                _ => {}
            }
            let from = if k == 0 { [0; 2] } else { last };
            number(out, at[0] - from[0], k > 1);
            number(out, at[1] - from[1], true);
            last = at;
        }
    }
}

/// `#rrggbb`, with an opacity of its own where it is not opaque.
fn color(out: &mut String, attribute: &str, [r, g, b, a]: [u8; 4]) {
    let _ = write!(out, " {attribute}=\"#{r:02x}{g:02x}{b:02x}\"");
    if a < 255 {
        let _ = write!(out, " {attribute}-opacity=\"{:.3}\"", f32::from(a) / 255.0);
    }
}

/// The document.
pub(super) fn document(size: ScreenSize, shapes: &[Shape], background: Option<[u8; 4]>) -> String {
    let ScreenSize { width, height, .. } = size;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">\n"
    );
    if let Some(background) = background.filter(|b| b[3] > 0) {
        let _ = write!(out, "<rect width=\"{width}\" height=\"{height}\"");
        color(&mut out, "fill", background);
        out.push_str("/>\n");
    }
    out.push_str("<g fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n");
    for shape in shapes {
        match shape {
            Shape::Strokes {
                class,
                color: ink,
                width,
                paths,
            } => {
                let _ = write!(out, "<path class=\"{class}\" stroke-width=\"{width:.3}\"");
                color(&mut out, "stroke", *ink);
                out.push_str(" d=\"");
                path_data(&mut out, paths);
                out.push_str("\"/>\n");
            }
            Shape::Discs {
                class,
                color: ink,
                radius,
                middles,
            } => {
                // A disc is a point drawn with a round pen.
                let _ = write!(
                    out,
                    "<path class=\"{class}\" stroke-width=\"{:.3}\"",
                    radius * 2.0
                );
                color(&mut out, "stroke", *ink);
                out.push_str(" d=\"");
                let points: Vec<Path> = middles.iter().map(|&m| vec![m, m]).collect();
                path_data(&mut out, &points);
                out.push_str("\"/>\n");
            }
        }
    }
    out.push_str("</g>\n</svg>\n");
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let written = |n: i64, separate: bool| {
            let mut out = String::new();
            number(&mut out, n, separate);
            out
        };
        for (n, text) in [
            (0, "0"),
            (100, "1"),
            (150, "1.5"),
            (-5, "-.05"),
            (-1234, "-12.34"),
            (20, ".2"),
        ] {
            assert_eq!(written(n, false), text);
        }
        assert_eq!(
            (written(5, true), written(-5, true)),
            (" .05".into(), "-.05".into())
        );
        let mut out = String::new();
        path_data(&mut out, &[vec![[1.0, 2.0], [2.5, 1.0], [2.5, 3.0]]]);
        assert_eq!(out, "M1 2l1.5-1 0 2");
    }
}
