//! Line work to pixels, by tiny-skia: first as simple shapes, which an SVG file shares.

use super::{Kind, Layers, LineArt, Polyline};
use crate::film::Image;
use crate::sheet::text_strokes;
use rayon::prelude::*;
use tiny_skia::{
    FillRule, LineCap, LineJoin, Paint, PathBuilder, Pixmap, PixmapMut, Stroke, Transform,
};

/// Rows that are drawn at a time, each band on its own: independent of the number of threads.
const BAND: u32 = 256;

/// Rows that are drawn beyond a band on either side and thrown away: at the border of its picture tiny-skia adds what was clipped there to
/// the last row.
const SPARE: u32 = 4;

/// A path in pixels.
pub(super) type Path = Vec<[f32; 2]>;

/// Something of one colour.
pub(super) enum Shape {
    /// Lines with round ends and joints; where they cross, they are drawn once.
    Strokes {
        class: &'static str,
        color: [u8; 4],
        width: f32,
        paths: Vec<Path>,
    },
    /// Discs of one radius.
    Discs {
        class: &'static str,
        color: [u8; 4],
        radius: f32,
        middles: Vec<[f32; 2]>,
    },
}

/// Colours of valences, from 0 on; the last is for all beyond.
const VALENCE_COLORS: [u32; 9] = [
    0x868e96, 0x868e96, 0x0c8599, 0x1c7ed6, 0x37b24d, 0xe8590c, 0xc2255c, 0x862e9c, 0x5f3dc4,
];

fn opaque(rgb: u32) -> [u8; 4] {
    let [_, r, g, b] = rgb.to_be_bytes();
    [r, g, b, 255]
}

/// Line work as shapes, in the order in which they are drawn.
pub(super) fn shapes(art: &LineArt) -> Vec<Shape> {
    let (style, unit) = (&art.options.style, art.options.style.unit_of(art.size));
    let mut out = Vec::new();
    for kind in Kind::ALL {
        let of_kind = art.polylines.iter().filter(|l| l.kind == kind);
        let paths: Vec<Path> = of_kind.map(|l: &Polyline| l.points.clone()).collect();
        if !paths.is_empty() {
            let ink = style.ink(kind);
            out.push(Shape::Strokes {
                class: kind.name(),
                color: ink.color,
                width: ink.width * unit,
                paths,
            });
        }
    }
    if art.options.layers.contains(Layers::VALENCES) {
        let marked = || art.marks.iter().filter(|m| m.extraordinary);
        let discs = |class, color, radius: f32, middles: Vec<[f32; 2]>| Shape::Discs {
            class,
            color,
            radius: radius * unit,
            middles,
        };
        if marked().next().is_some() {
            let all = marked().map(|m| m.at).collect();
            out.push(discs("valence-rim", style.halo, 4.4, all));
        }
        for (k, &color) in VALENCE_COLORS.iter().enumerate() {
            let last = VALENCE_COLORS.len() - 1;
            let of = marked().filter(|m| (m.valence as usize).min(last) == k);
            let middles: Vec<_> = of.map(|m| m.at).collect();
            if !middles.is_empty() {
                out.push(discs("valence", opaque(color), 3.2, middles));
            }
        }
    }
    if art.options.layers.contains(Layers::LABELS) {
        let middles: Vec<_> = art.marks.iter().map(|m| m.at).collect();
        if !middles.is_empty() {
            out.push(Shape::Discs {
                class: "vertex",
                color: style.text,
                radius: 1.4 * unit,
                middles,
            });
        }
    }
    letters(art, &mut out);
    out
}

/// Letters with a rim that sets them off.
fn letters(art: &LineArt, out: &mut Vec<Shape>) {
    let Some(first) = art.labels.first() else {
        return;
    };
    let style = &art.options.style;
    let paths: Vec<Path> = art
        .labels
        .iter()
        .flat_map(|l| text_strokes(&l.text, l.at, l.height))
        .collect();
    let width = (first.height * 0.14).max(1.0);
    for (class, color, width) in [
        ("text-rim", style.halo, width + first.height * 0.35),
        ("text", style.text, width),
    ] {
        let paths = paths.clone();
        out.push(Shape::Strokes {
            class,
            color,
            width,
            paths,
        });
    }
}

/// Draws shapes over a picture.
pub(super) fn paint(shapes: &[Shape], image: &mut Image) {
    let (width, line) = (image.width, image.width as usize * 4);
    if line == 0 {
        return;
    }
    image
        .data
        .par_chunks_mut(line * BAND as usize)
        .enumerate()
        .for_each(|(k, rows)| {
            let height = (rows.len() / line) as u32 + 2 * SPARE;
            let Some(mut band) = Pixmap::new(width, height) else {
                return;
            };
            let top = k as f32 * BAND as f32 - SPARE as f32;
            for shape in shapes {
                draw(shape, &mut band.as_mut(), top);
            }
            let drawn = &band.pixels()[(SPARE * width) as usize..];
            for (to, from) in rows.chunks_exact_mut(4).zip(drawn) {
                if from.alpha() > 0 {
                    let over = [from.red(), from.green(), from.blue(), from.alpha()];
                    lay(to, over);
                }
            }
        });
}

/// Lays a premultiplied colour over a straight one, in encoded values.
fn lay(to: &mut [u8], over: [u8; 4]) {
    let rest = 255 - u32::from(over[3]);
    // The picture's share of the alpha, times 255.
    let below = u32::from(to[3]) * rest;
    let alpha = u32::from(over[3]) * 255 + below;
    for k in 0..3 {
        let sum = u32::from(over[k]) * 255 * 255 + u32::from(to[k]) * below;
        to[k] = ((sum + alpha / 2) / alpha).min(255) as u8;
    }
    to[3] = ((alpha + 127) / 255) as u8;
}

/// Draws a shape into the rows from `top` on.
fn draw(shape: &Shape, band: &mut PixmapMut<'_>, top: f32) {
    let bottom = top + band.height() as f32;
    let mut builder = PathBuilder::new();
    let mut paint = Paint::default();
    let set = |paint: &mut Paint<'_>, [r, g, b, a]: [u8; 4]| paint.set_color_rgba8(r, g, b, a);
    match shape {
        Shape::Strokes {
            color,
            width,
            paths,
            ..
        } => {
            for path in paths {
                let reach = |y: &[f32; 2]| y[1] + width >= top && y[1] - width <= bottom;
                let above = path.iter().all(|p| p[1] < top);
                let below = path.iter().all(|p| p[1] > bottom);
                if (above || below) && !path.iter().any(reach) {
                    continue;
                }
                let mut points = path.iter();
                if let Some(&[x, y]) = points.next() {
                    builder.move_to(x, y - top);
                }
                for &[x, y] in points {
                    builder.line_to(x, y - top);
                }
            }
            let Some(path) = builder.finish() else { return };
            set(&mut paint, *color);
            let stroke = Stroke {
                width: *width,
                line_cap: LineCap::Round,
                line_join: LineJoin::Round,
                ..Stroke::default()
            };
            band.stroke_path(&path, &paint, &stroke, Transform::identity(), None);
        }
        Shape::Discs {
            color,
            radius,
            middles,
            ..
        } => {
            for &[x, y] in middles {
                if y + radius >= top && y - radius <= bottom {
                    builder.push_circle(x, y - top, *radius);
                }
            }
            let Some(path) = builder.finish() else { return };
            set(&mut paint, *color);
            band.fill_path(
                &path,
                &paint,
                FillRule::Winding,
                Transform::identity(),
                None,
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laying_over_keeps_what_shows_through() {
        let over = |to: [u8; 4], over: [u8; 4]| {
            let mut to = to;
            lay(&mut to, over);
            to
        };
        assert_eq!(over([10, 20, 30, 255], [0, 0, 0, 255]), [0, 0, 0, 255]);
        assert_eq!(over([200, 100, 0, 255], [0, 0, 0, 51]), [160, 80, 0, 255]);
        // On nothing the colour itself, as transparent as it is.
        assert_eq!(over([0; 4], [51, 0, 0, 51]), [255, 0, 0, 51]);
        let [_, _, _, a] = over([255, 255, 255, 128], [0, 0, 0, 128]);
        assert_eq!(a, 192);
    }
}
