//! What stands over the picture: figures, the sheet of keys, messages, progress. Drawn by tiny-skia with the strokes of the contact sheets'
//! letters, at the size of the window, so it is sharp whatever the size of the picture.

use super::canvas::Canvas;
use super::keys;
use crate::sheet::{draw_text, text_width};
use tiny_skia::{Color, FillRule, Paint, PathBuilder, Pixmap, Rect, Transform};

/// Colours of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Theme {
    /// Behind the model, where the command line gives no background.
    pub(super) backdrop: [u8; 4],
    /// Of panels.
    pub(super) panel: [u8; 4],
    /// Of text.
    pub(super) ink: [u8; 4],
    /// Of headings, keys and the bar of progress.
    pub(super) accent: [u8; 4],
    /// Of messages about what went wrong.
    pub(super) fault: [u8; 4],
}

impl Theme {
    /// Light on dark.
    pub(super) const DARK: Self = Self {
        backdrop: [43, 45, 49, 255],
        panel: [18, 19, 22, 200],
        ink: [226, 228, 232, 255],
        accent: [130, 190, 255, 255],
        fault: [255, 132, 118, 255],
    };
    /// Dark on light.
    pub(super) const LIGHT: Self = Self {
        backdrop: [226, 228, 232, 255],
        panel: [250, 250, 252, 215],
        ink: [38, 40, 46, 255],
        accent: [16, 92, 176, 255],
        fault: [176, 28, 20, 255],
    };
}

/// Which colour a piece of text has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tone {
    /// Plain.
    Ink,
    /// Set off.
    Accent,
    /// Something went wrong.
    Fault,
}

/// A line of a panel: pieces of text, each from a column of its own.
pub(super) type Line = Vec<(Tone, String)>;

/// What a panel shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Content {
    /// Its lines; a line without pieces is a gap.
    pub(super) lines: Vec<Line>,
    /// How far something is, from 0 to 1, as a bar below the lines.
    pub(super) bar: Option<f32>,
}

impl Content {
    /// Lines of one piece and tone.
    #[must_use]
    pub(super) fn text(tone: Tone, lines: impl IntoIterator<Item = String>) -> Self {
        Self {
            lines: lines.into_iter().map(|l| vec![(tone, l)]).collect(),
            bar: None,
        }
    }
}

/// Where a panel stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// The upper left corner.
    TopLeft,
    /// The lower left corner.
    BottomLeft,
    /// The middle.
    Middle,
    /// The middle of the lower border.
    BottomMiddle,
}

/// A panel, drawn when what it shows changes.
#[derive(Clone, Debug, Default)]
pub(super) struct Panel {
    shown: Option<(Content, Theme, u32)>,
    picture: Option<Pixmap>,
}

impl Panel {
    /// Lays the panel over a canvas; `scale` times as large as on an ordinary screen.
    pub(super) fn show(
        &mut self,
        canvas: &mut Canvas,
        content: &Content,
        place: Place,
        theme: &Theme,
        scale: u32,
    ) {
        if content.lines.is_empty() {
            return;
        }
        let wanted = (content.clone(), *theme, scale);
        if self.shown.as_ref() != Some(&wanted) {
            self.picture = draw(content, theme, scale as f32);
            self.shown = Some(wanted);
        }
        let Some(picture) = &self.picture else {
            return;
        };
        let [width, height] = canvas.size.map(i64::from);
        let (wide, high) = (i64::from(picture.width()), i64::from(picture.height()));
        let margin = i64::from(MARGIN * scale);
        let at = match place {
            Place::TopLeft => [margin, margin],
            Place::BottomLeft => [margin, height - margin - high],
            Place::BottomMiddle => [((width - wide) / 2).max(0), height - margin - high],
            Place::Middle => [((width - wide) / 2).max(0), ((height - high) / 2).max(0)],
        };
        canvas.lay_over(picture.data(), picture.width(), at);
    }
}

/// Pixels between a panel and the border of the window.
const MARGIN: u32 = 10;
/// Pixels between a panel's border and its text.
const INSET: f32 = 9.0;
/// Height of capital letters.
const CAPITAL: f32 = 9.0;
/// From one line to the next.
const LEADING: f32 = 17.0;
/// Between columns.
const GUTTER: f32 = 14.0;
/// Height of the bar of progress.
const BAR: f32 = 5.0;
/// Least width of a panel with a bar.
const BAR_WIDTH: f32 = 220.0;
/// Longest side of a panel.
const LARGEST: f32 = 8192.0;

fn draw(content: &Content, theme: &Theme, scale: f32) -> Option<Pixmap> {
    let capital = CAPITAL * scale;
    let columns = columns(content, capital, scale);
    let inset = INSET * scale;
    let text = columns.last().copied().unwrap_or(0.0);
    let bar = if content.bar.is_some() {
        BAR * scale
    } else {
        0.0
    };
    let least = if content.bar.is_some() {
        BAR_WIDTH
    } else {
        0.0
    };
    let width = (text.max(least * scale) + 2.0 * inset).min(LARGEST);
    let high = content.lines.len() as f32 * LEADING * scale + bar * 2.0;
    let height = (high - (LEADING - CAPITAL) * scale + 2.0 * inset).min(LARGEST);
    let mut picture = Pixmap::new(width.ceil() as u32, height.ceil() as u32)?;
    let color = |c: [u8; 4]| Color::from_rgba8(c[0], c[1], c[2], c[3]);
    picture.fill(color(theme.panel));
    for (j, line) in content.lines.iter().enumerate() {
        let base = inset + capital + j as f32 * LEADING * scale;
        for (k, (tone, text)) in line.iter().enumerate() {
            let left = if k == 0 {
                0.0
            } else {
                columns[k - 1] + GUTTER * scale
            };
            let ink = match tone {
                Tone::Ink => theme.ink,
                Tone::Accent => theme.accent,
                Tone::Fault => theme.fault,
            };
            draw_text(
                &mut picture.as_mut(),
                text,
                [inset + left, base],
                capital,
                ink,
            );
        }
    }
    if let Some(part) = content.bar {
        let top = height - inset - bar * 0.5;
        let whole = width - 2.0 * inset;
        let mut paint = Paint::default();
        for (color, wide) in [
            (theme.ink, whole),
            (theme.accent, whole * part.clamp(0.0, 1.0)),
        ] {
            let alpha = if color == theme.accent { 255 } else { 60 };
            paint.set_color_rgba8(color[0], color[1], color[2], alpha);
            let rect = Rect::from_xywh(inset, top, wide.max(0.01), bar)?;
            let path = PathBuilder::from_rect(rect);
            picture.fill_path(
                &path,
                &paint,
                FillRule::Winding,
                Transform::identity(),
                None,
            );
        }
    }
    Some(picture)
}

/// Right ends of the columns. A line's last piece reaches over the columns behind it.
fn columns(content: &Content, capital: f32, scale: f32) -> Vec<f32> {
    let most = content.lines.iter().map(Vec::len).max().unwrap_or(0);
    let mut ends: Vec<f32> = Vec::new();
    let mut widest = 0.0_f32;
    for k in 0..most {
        let left = ends.last().map_or(0.0, |end| end + GUTTER * scale);
        let mut end = left;
        for line in content.lines.iter().filter(|l| l.len() > k) {
            let right = left + text_width(&line[k].1, capital);
            if line.len() > k + 1 {
                end = end.max(right);
            } else {
                widest = widest.max(right);
            }
        }
        ends.push(end);
    }
    if let Some(last) = ends.last_mut() {
        *last = last.max(widest);
    }
    ends
}

/// The sheet of keys.
#[must_use]
pub(super) fn help() -> Content {
    let mut lines: Vec<Line> = Vec::new();
    for (heading, rows) in keys::TABLE {
        if !lines.is_empty() {
            lines.push(Vec::new());
        }
        lines.push(vec![(Tone::Accent, (*heading).to_owned())]);
        for row in *rows {
            lines.push(vec![
                (Tone::Accent, row.keys.to_owned()),
                (Tone::Ink, row.does.to_owned()),
            ]);
        }
    }
    Content { lines, bar: None }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(content: &Content, place: Place) -> Canvas {
        let mut canvas = Canvas::default();
        canvas.fill([900, 700], 0x404040);
        Panel::default().show(&mut canvas, content, place, &Theme::DARK, 1);
        canvas
    }

    fn changed(canvas: &Canvas) -> usize {
        canvas.pixels.iter().filter(|p| **p != 0x404040).count()
    }

    #[test]
    fn panels_show_their_text_in_their_place() {
        let text = Content::text(Tone::Fault, ["file.obj:3: wrong".to_owned()]);
        let canvas = shown(&text, Place::BottomLeft);
        let count = changed(&canvas);
        assert!((2000..20_000).contains(&count), "{count}");
        let red = |p: &&u32| **p >> 16 > 200 && **p & 255 < 150;
        assert!(canvas.pixels.iter().filter(red).count() > 100);
        // Nothing above the lower part.
        assert!(canvas.pixels[..600 * 900].iter().all(|p| *p == 0x404040));
        assert_eq!(changed(&shown(&Content::default(), Place::Middle)), 0);
    }

    #[test]
    fn the_sheet_fits_into_a_small_window() {
        let mut canvas = Canvas::default();
        canvas.fill([640, 640], 0x404040);
        Panel::default().show(&mut canvas, &help(), Place::Middle, &Theme::LIGHT, 1);
        let at = |x: usize, y: usize| canvas.pixels[y * 640 + x];
        for k in 0..640 {
            for p in [at(k, 0), at(k, 639), at(0, k), at(639, k)] {
                assert_eq!(p, 0x404040, "the sheet reaches the border");
            }
        }
        assert!(changed(&canvas) > 100_000);
    }

    #[test]
    fn bars_grow() {
        let bright = |part: f32| {
            let mut content = Content::text(Tone::Ink, ["loading".to_owned()]);
            content.bar = Some(part);
            let canvas = shown(&content, Place::Middle);
            let accent = |p: &&u32| **p == 0x82beff;
            canvas.pixels.iter().filter(accent).count()
        };
        assert!(bright(0.1) > 50 && bright(0.9) > 5 * bright(0.1));
    }
}
