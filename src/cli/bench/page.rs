//! The page of `bench scale --page`: a plot of each curve, both axes logarithmic, with the slope between its points.

use super::scale::Curve;
use std::fmt::Write;

const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 360.0;
const LEFT: f64 = 64.0;
const BOTTOM: f64 = 44.0;
const MARGIN: f64 = 20.0;

/// How a curve is to be read.
fn meaning(of: &str) -> &'static str {
    match of {
        "triangles" => {
            "Flat at first: few triangles, each of many pixels, so that pixels cost and triangles do not. Beyond about two \
             triangles to a pixel time grows with the triangles, a slope near 1; where most samples show nothing of a \
             triangle it stays just below."
        }
        "threads" => {
            "Wall time falls by the number of threads (slope -1) up to the processors that there are; beyond, threads take turns."
        }
        _ => {
            "Visibility is decided for every sample, but light once per pixel and surface, so that the slope stays below 1."
        }
    }
}

/// Powers of ten, or of two for short ranges, that hold `low` to `high`.
fn ticks(low: f64, high: f64) -> Vec<f64> {
    let base: f64 = if high / low > 100.0 { 10.0 } else { 2.0 };
    let first = (low.ln() / base.ln() + 1e-9).floor() as i32;
    let last = (high.ln() / base.ln() - 1e-9).ceil() as i32;
    (first..=last).map(|e| base.powi(e)).collect()
}

fn short(x: f64) -> String {
    match x {
        x if x >= 1e9 => format!("{} G", x / 1e9),
        x if x >= 1e6 => format!("{} M", x / 1e6),
        x if x >= 1e3 => format!("{} k", x / 1e3),
        x if x < 0.1 => format!("{x:.3}"),
        x => format!("{x}"),
    }
}

/// One curve as an SVG picture.
fn plot(curve: &Curve) -> String {
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold([f64::INFINITY, 0.0_f64], |[low, high], v| {
            [low.min(v), high.max(v)]
        })
    };
    let [x_low, x_high] = range(&mut curve.points.iter().map(|p| p.0));
    let walls = curve.points.iter().flat_map(|p| [p.1.wall, p.1.cpu]);
    let [y_low, y_high] = range(&mut walls.filter(|&v| v > 0.0));
    let (xs, ys) = (ticks(x_low, x_high), ticks(y_low, y_high));
    let of = |v: f64, ticks: &[f64], from: f64, to: f64| {
        let (low, high) = (ticks[0].ln(), ticks[ticks.len() - 1].ln());
        from + (v.max(1e-9).ln() - low) / (high - low).max(1e-9) * (to - from)
    };
    let x = |v: f64| of(v, &xs, LEFT, WIDTH - MARGIN);
    let y = |v: f64| of(v, &ys, HEIGHT - BOTTOM, MARGIN);
    let mut out = format!("<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\">\n");
    for &t in &xs {
        let at = x(t);
        let _ = writeln!(
            out,
            "<line class=\"grid\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{MARGIN}\" y2=\"{:.1}\"/><text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            HEIGHT - BOTTOM,
            HEIGHT - BOTTOM + 16.0,
            short(t)
        );
    }
    for &t in &ys {
        let at = y(t);
        let _ = writeln!(
            out,
            "<line class=\"grid\" x1=\"{LEFT}\" x2=\"{:.1}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            WIDTH - MARGIN,
            LEFT - 6.0,
            at + 4.0,
            short(t)
        );
    }
    let _ = writeln!(
        out,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text><text x=\"12\" y=\"{:.1}\" transform=\"rotate(-90 12 {:.1})\" text-anchor=\"middle\">milliseconds</text>",
        (LEFT + WIDTH - MARGIN) / 2.0,
        HEIGHT - 8.0,
        curve.of,
        HEIGHT / 2.0,
        HEIGHT / 2.0
    );
    for (class, wall) in [("cpu", false), ("wall", true)] {
        let mut points = String::new();
        let mut dots = String::new();
        for (v, t) in &curve.points {
            let t = if wall { t.wall } else { t.cpu };
            if t > 0.0 {
                let _ = write!(points, "{:.1},{:.1} ", x(*v), y(t));
                let _ = write!(
                    dots,
                    "<circle class=\"{class}\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\"/>",
                    x(*v),
                    y(t)
                );
            }
        }
        let _ = writeln!(
            out,
            "<polyline class=\"{class}\" points=\"{points}\"/>{dots}"
        );
    }
    out.push_str("</svg>\n");
    out
}

/// Slopes of wall time between neighbouring points, on logarithmic axes.
pub(super) fn slopes(curve: &Curve) -> Vec<f64> {
    let slope = |w: &[(f64, crate::cli::stats::Time)]| {
        (w[1].1.wall / w[0].1.wall).ln() / (w[1].0 / w[0].0).ln()
    };
    curve.points.windows(2).map(slope).collect()
}

/// The whole page; it refers to nothing outside.
pub(super) fn page(title: &str, curves: &[Curve]) -> String {
    let title = title.replace('&', "&amp;").replace('<', "&lt;");
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>{title}</title>\n<style>\n\
         :root {{ color-scheme: light dark }}\n\
         body {{ font: 15px/1.5 system-ui, sans-serif; max-width: 46em; margin: 2em auto; padding: 0 1em }}\n\
         svg {{ width: 100%; height: auto }} svg text {{ font: 11px system-ui, sans-serif; fill: currentColor }}\n\
         .grid {{ stroke: currentColor; opacity: .15 }} polyline {{ fill: none; stroke-width: 2 }}\n\
         polyline.wall {{ stroke: #c4501b }} circle.wall {{ fill: #c4501b }}\n\
         polyline.cpu {{ stroke: #2f6fb0; stroke-dasharray: 5 4 }} circle.cpu {{ fill: #2f6fb0 }}\n\
         table {{ border-collapse: collapse; font-variant-numeric: tabular-nums }} td, th {{ text-align: right; padding: 0 .8em }}\n\
         </style>\n<h1>{title}</h1>\n\
         <p>Best times of a steady frame. Solid: on the clock. Dashed: of all processors together.</p>\n"
    );
    for curve in curves {
        let _ = writeln!(
            out,
            "<h2>Time against {}</h2>\n{}<p>{}</p>",
            curve.of,
            plot(curve),
            meaning(curve.of)
        );
        let _ = writeln!(
            out,
            "<table><tr><th>{}</th><th>wall ms</th><th>cpu ms</th><th>slope</th></tr>",
            curve.of
        );
        let slopes = slopes(curve);
        for (k, (v, t)) in curve.points.iter().enumerate() {
            let slope = k.checked_sub(1).map(|k| format!("{:.2}", slopes[k]));
            let _ = writeln!(
                out,
                "<tr><td>{v}</td><td>{:.3}</td><td>{:.3}</td><td>{}</td></tr>",
                t.wall,
                t.cpu,
                slope.unwrap_or_default()
            );
        }
        out.push_str("</table>\n");
    }
    out.push_str("</html>\n");
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::stats::Time;

    #[test]
    fn a_page_holds_every_point_and_its_slope() {
        let time = |wall| Time { wall, cpu: wall };
        let curve = Curve {
            of: "threads",
            points: vec![(1.0, time(8.0)), (2.0, time(4.0)), (4.0, time(2.0))],
        };
        assert!(slopes(&curve).iter().all(|s| (s + 1.0).abs() < 1e-9));
        let page = page("a < b & c", &[curve]);
        assert!(page.contains("a &lt; b &amp; c") && !page.contains("NaN"));
        assert_eq!(page.matches("<circle").count(), 6);
        assert_eq!(page.matches("-1.00").count(), 2);
    }

    #[test]
    fn ticks_hold_the_range() {
        assert_eq!(ticks(1.0, 8.0), [1.0, 2.0, 4.0, 8.0]);
        assert_eq!(ticks(3.0, 4000.0), [1.0, 10.0, 100.0, 1000.0, 10000.0]);
    }
}
