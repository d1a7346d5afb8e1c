//! Contact sheets: pictures in a grid with a caption below each, which tiny-skia draws.
//!
//! The letters are strokes of our own on a grid of 4 by 6 steps, so no font has to be found on the machine and a sheet is the same
//! everywhere. Captions hold printable ASCII; other characters are drawn as question marks.

use crate::film::Image;
use tiny_skia::{LineCap, LineJoin, Paint, PathBuilder, Pixmap, PixmapMut, Stroke, Transform};

/// One picture of a sheet.
#[derive(Clone, Debug)]
pub struct Picture {
    /// The picture.
    pub image: Image,
    /// What stands below it.
    pub caption: String,
}

/// Layout and colours of a sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheetStyle {
    /// Pictures in a row.
    pub columns: u32,
    /// Pixels around and between the pictures.
    pub margin: u32,
    /// Height of capital letters in pixels; 0 for no captions.
    pub text_height: u32,
    /// Colour of the sheet, sRGB with straight alpha.
    pub background: [u8; 4],
    /// Colour of the captions.
    pub ink: [u8; 4],
}

impl Default for SheetStyle {
    fn default() -> Self {
        Self {
            columns: 4,
            margin: 16,
            text_height: 14,
            background: [255; 4],
            ink: [40, 40, 44, 255],
        }
    }
}

/// Why there is no sheet.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SheetError {
    /// No pictures, or no columns.
    #[error("a sheet needs at least one picture and one column")]
    Empty,
    /// A side longer than 65,535 pixels, or not enough memory.
    #[error("a sheet of {width}x{height} pixels is too large")]
    TooLarge {
        /// Pixels across.
        width: u64,
        /// Pixels down.
        height: u64,
    },
}

/// Lays pictures out row by row. Every cell has the size of the largest picture; smaller ones stand in its middle.
///
/// ```
/// use earmark::{film::Image, sheet::{Picture, SheetStyle, contact_sheet}};
///
/// let picture = |name: &str| Picture { image: Image::new(64, 48), caption: name.into() };
/// let sheet = contact_sheet(&[picture("cube"), picture("torus")], &SheetStyle { columns: 2, ..SheetStyle::default() })?;
/// assert_eq!(sheet.width, 16 + 64 + 16 + 64 + 16);
/// # Ok::<(), earmark::sheet::SheetError>(())
/// ```
///
/// # Errors
/// [`SheetError`].
pub fn contact_sheet(pictures: &[Picture], style: &SheetStyle) -> Result<Image, SheetError> {
    if pictures.is_empty() || style.columns == 0 {
        return Err(SheetError::Empty);
    }
    let columns = u64::from(style.columns).min(pictures.len() as u64);
    let rows = (pictures.len() as u64).div_ceil(columns);
    let largest = |side: fn(&Image) -> u32| pictures.iter().map(|p| side(&p.image)).max();
    let cell = [
        u64::from(largest(|i| i.width).unwrap_or(0)),
        u64::from(largest(|i| i.height).unwrap_or(0)),
    ];
    let margin = u64::from(style.margin);
    // Descenders reach a third of a capital below the line, and the same is left free above.
    let text = u64::from(style.text_height) * 5 / 3;
    let width = margin + columns * (cell[0] + margin);
    let height = margin + rows * (cell[1] + text + margin);
    let too_large = SheetError::TooLarge { width, height };
    if width > 65_535 || height > 65_535 {
        return Err(too_large);
    }
    let mut sheet = Pixmap::new(width as u32, height as u32).ok_or(too_large)?;
    let [r, g, b, a] = style.background;
    sheet.fill(tiny_skia::Color::from_rgba8(r, g, b, a));
    for (k, picture) in pictures.iter().enumerate() {
        let (column, row) = (k as u64 % columns, k as u64 / columns);
        let x = margin + column * (cell[0] + margin);
        let y = margin + row * (cell[1] + text + margin);
        let image = &picture.image;
        let inset = [
            (cell[0] - u64::from(image.width)) / 2,
            (cell[1] - u64::from(image.height)) / 2,
        ];
        paste(&mut sheet, image, x + inset[0], y + inset[1]);
        if style.text_height > 0 {
            let baseline = (y + cell[1] + text) as f32 - style.text_height as f32 / 3.0;
            let caption = fitting(&picture.caption, cell[0] as f32, style.text_height as f32);
            let wide = text_width(&caption, style.text_height as f32);
            draw_text(
                &mut sheet.as_mut(),
                &caption,
                [x as f32 + (cell[0] as f32 - wide) * 0.5, baseline],
                style.text_height as f32,
                style.ink,
            );
        }
    }
    let mut out = Image::new(width as u32, height as u32);
    for (to, from) in out.data.chunks_exact_mut(4).zip(sheet.pixels()) {
        let c = from.demultiply();
        to.copy_from_slice(&[c.red(), c.green(), c.blue(), c.alpha()]);
    }
    Ok(out)
}

/// Lays an image over the sheet, in encoded values as other programs do it.
fn paste(sheet: &mut Pixmap, image: &Image, x: u64, y: u64) {
    let across = sheet.width() as usize * 4;
    let row_bytes = image.width as usize * 4;
    if row_bytes == 0 {
        return;
    }
    for (j, row) in image.data.chunks_exact(row_bytes).enumerate() {
        let start = (y as usize + j) * across + x as usize * 4;
        let line = &mut sheet.data_mut()[start..start + row_bytes];
        for (to, from) in line.chunks_exact_mut(4).zip(row.chunks_exact(4)) {
            let alpha = u32::from(from[3]);
            for k in 0..4 {
                let source = if k == 3 { 255 } else { u32::from(from[k]) };
                // Both terms are premultiplied; rounded once.
                to[k] = ((source * alpha + u32::from(to[k]) * (255 - alpha) + 127) / 255) as u8;
            }
        }
    }
}

/// The caption, cut so that it fits.
fn fitting(caption: &str, width: f32, height: f32) -> String {
    if text_width(caption, height) <= width {
        return caption.to_owned();
    }
    let mut kept: Vec<char> = caption.chars().collect();
    loop {
        let text: String = kept.iter().collect::<String>() + "..";
        if kept.is_empty() || text_width(&text, height) <= width {
            return text;
        }
        kept.pop();
    }
}

/// Steps of the grid from one letter to the next, beside the letter's own width.
const SPACING: f32 = 1.6;
/// Width of a blank in steps.
const BLANK: f32 = 1.4;

/// Width of a line of text whose capitals are `height` pixels high.
#[must_use]
pub fn text_width(text: &str, height: f32) -> f32 {
    let steps: f32 = text.chars().map(|c| glyph_width(glyph(c)) + SPACING).sum();
    (steps - SPACING).max(0.0) * height / 6.0
}

/// Strokes of a line of text from `at`, the left end of its base line; a dot has its point twice, a little apart.
pub(crate) fn text_strokes(text: &str, at: [f32; 2], height: f32) -> Vec<Vec<[f32; 2]>> {
    let step = height / 6.0;
    let mut out = Vec::new();
    let mut x = at[0];
    for c in text.chars() {
        let strokes = glyph(c);
        for stroke in strokes.split(' ').filter(|s| !s.is_empty()) {
            let points = stroke.as_bytes().chunks_exact(2).map(|p| {
                let [px, py] = [p[0], p[1]].map(|d| f32::from(d - b'0'));
                [x + px * step, at[1] + (py - 6.0) * step]
            });
            let mut points: Vec<[f32; 2]> = points.collect();
            if let [[x, y]] = points[..] {
                // Its round caps are all there is to see.
                points.push([x + 0.01 * step, y]);
            }
            out.push(points);
        }
        x += (glyph_width(strokes) + SPACING) * step;
    }
    out
}

/// Draws a line of text from `at`, the left end of its base line.
pub(crate) fn draw_text(
    sheet: &mut PixmapMut<'_>,
    text: &str,
    at: [f32; 2],
    height: f32,
    ink: [u8; 4],
) {
    let mut builder = PathBuilder::new();
    for stroke in text_strokes(text, at, height) {
        for (k, &[x, y]) in stroke.iter().enumerate() {
            match k {
                0 => builder.move_to(x, y),
                _ => builder.line_to(x, y),
            }
        }
    }
    let Some(path) = builder.finish() else {
        return;
    };
    let mut paint = Paint::default();
    let [r, g, b, a] = ink;
    paint.set_color_rgba8(r, g, b, a);
    let stroke = Stroke {
        width: (height * 0.13).max(1.0),
        line_cap: LineCap::Round,
        line_join: LineJoin::Round,
        ..Stroke::default()
    };
    sheet.stroke_path(&path, &paint, &stroke, Transform::identity(), None);
}

/// Steps from the left of a letter to its right.
fn glyph_width(strokes: &str) -> f32 {
    let points = strokes
        .split(' ')
        .flat_map(|s| s.as_bytes().chunks_exact(2));
    points
        .map(|p| f32::from(p[0] - b'0'))
        .fold(if strokes.is_empty() { BLANK } else { 0.0 }, f32::max)
}

fn glyph(c: char) -> &'static str {
    match (c as u32).checked_sub(0x20) {
        Some(k) if (k as usize) < GLYPHS.len() => GLYPHS[k as usize],
        _ => GLYPHS['?' as usize - 0x20],
    }
}

/// Strokes of the characters from blank to tilde: points as two digits, column from the left and row from the top. Row 0 is the top of
/// capitals, 2 that of small letters, 6 the base line, 8 the end of descenders.
const GLYPHS: [&str; 95] = [
    "",
    "0004 06",
    "0002 2022",
    "1016 3036 0242 0444",
    "413010010213334445361605 2026",
    "0010110100 3545463635 4006",
    "4612112031320405162644",
    "0002",
    "10020416",
    "00121406",
    "2125 0244 0442",
    "2125 0343",
    "1607",
    "0333",
    "06",
    "3006",
    "103041453616050110",
    "011016 0626",
    "01103041420646",
    "0110304142334445361605 1333",
    "36300444",
    "400003334445361605",
    "4130100105163645443303",
    "004016",
    "103041423344453616050413020110 1333",
    "0516364541301001021343",
    "02 06",
    "12 1607",
    "310335",
    "0242 0444",
    "013305",
    "01103041422324 26",
    "322213143432 344441301001051636",
    "062046 1434",
    "00063645443303 3342413000",
    "4130100105163645",
    "00062644422000",
    "40000646 0333",
    "400006 0333",
    "41301001051636454323",
    "0006 4046 0343",
    "0006",
    "3035261605",
    "0006 4004 1346",
    "000646",
    "0600234046",
    "06004640",
    "103041453616050110",
    "06003041423303",
    "103041453616050110 2446",
    "06003041423303 2346",
    "413010010213334445361605",
    "0040 2026",
    "000516364540",
    "002640",
    "0016233640",
    "0046 4006",
    "002340 2326",
    "00400646",
    "10000616",
    "0036",
    "00101606",
    "022042",
    "0747",
    "0011",
    "3236 3322120305162635",
    "0006 0312223335261605",
    "3322120305162635",
    "3036 3322120305162635",
    "043433221203051636",
    "201116 0222",
    "3237281807 3322120305162635",
    "0006 0312223336",
    "0206 00",
    "121708 10",
    "0006 3205 1436",
    "000516",
    "0206 03122326 23324346",
    "0206 0312223336",
    "122233352616050312",
    "0208 0312223335261605",
    "3238 3322120305162635",
    "0206 031222",
    "3212031424352606",
    "101526 0222",
    "0205162635 3236",
    "022642",
    "0216243642",
    "0236 3206",
    "0226 4218",
    "02320636",
    "20111203141526",
    "0007",
    "00111223141506",
    "04133443",
];

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: u32, height: u32, color: [u8; 4], caption: &str) -> Picture {
        let mut image = Image::new(width, height);
        for p in image.data.chunks_exact_mut(4) {
            p.copy_from_slice(&color);
        }
        Picture {
            image,
            caption: caption.into(),
        }
    }

    #[test]
    fn strokes_are_well_formed_and_letters_differ() {
        let mut seen = std::collections::BTreeMap::new();
        for (k, strokes) in GLYPHS.iter().enumerate() {
            let c = (0x20 + k as u8) as char;
            for stroke in strokes.split(' ') {
                assert_eq!(stroke.len() % 2, 0, "{c:?}");
                for p in stroke.as_bytes().chunks_exact(2) {
                    assert!((b'0'..=b'4').contains(&p[0]), "{c:?}");
                    assert!((b'0'..=b'8').contains(&p[1]), "{c:?}");
                }
            }
            if let Some(other) = seen.insert(*strokes, c) {
                assert_eq!((other, c), ('0', 'O'), "two characters look the same");
            }
        }
    }

    #[test]
    fn pictures_stand_in_their_cells() {
        let style = SheetStyle {
            columns: 2,
            margin: 4,
            text_height: 0,
            background: [0, 0, 0, 255],
            ..SheetStyle::default()
        };
        let red = picture(10, 6, [255, 0, 0, 255], "");
        let clear = picture(10, 6, [0, 255, 0, 51], "");
        let small = picture(2, 2, [0, 0, 255, 255], "");
        let sheet = contact_sheet(&[red, clear, small], &style).unwrap();
        assert_eq!((sheet.width, sheet.height), (32, 24));
        assert_eq!(sheet.pixel(3, 4), [0, 0, 0, 255]);
        assert_eq!(sheet.pixel(4, 4), [255, 0, 0, 255]);
        assert_eq!(sheet.pixel(13, 9), [255, 0, 0, 255]);
        assert_eq!(sheet.pixel(18, 4), [0, 51, 0, 255]);
        assert_eq!(sheet.pixel(8, 16), [0, 0, 255, 255]);
        assert_eq!(sheet.pixel(7, 16), [0, 0, 0, 255]);
    }

    #[test]
    fn captions_are_drawn_below_and_cut_to_fit() {
        let style = SheetStyle {
            columns: 1,
            background: [255; 4],
            ink: [0, 0, 0, 255],
            ..SheetStyle::default()
        };
        let dark = |caption: &str| {
            let sheet = contact_sheet(&[picture(100, 10, [255; 4], caption)], &style).unwrap();
            let dark = |y: u32| (0..sheet.width).any(|x| sheet.pixel(x, y)[0] < 128);
            ((0..26).any(dark), (26..sheet.height).any(dark))
        };
        assert_eq!(dark(""), (false, false));
        assert_eq!(dark("torus.obj"), (false, true));
        let long = "a".repeat(200);
        assert_eq!(dark(&long), (false, true));
        assert!(text_width(&fitting(&long, 100.0, 14.0), 14.0) <= 100.0);
        assert_eq!(fitting("cube", 100.0, 14.0), "cube");
    }

    #[test]
    fn impossible_sheets_are_refused() {
        let style = SheetStyle::default();
        assert_eq!(contact_sheet(&[], &style), Err(SheetError::Empty));
        let wide = vec![picture(20_000, 1, [0; 4], ""); 4];
        assert!(matches!(
            contact_sheet(&wide, &style),
            Err(SheetError::TooLarge { .. })
        ));
    }
}
