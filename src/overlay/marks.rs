//! Vertices that are marked, letters, and where axes and the scale bar are.

use super::lens::{Lens, Spot};
use super::{Kind, Label, Layers, Mark, Polyline};
use crate::camera::{Sphere, View};
use crate::frame::{Block, Object, Scene};
use crate::math;
use crate::mesh::NONE;
use crate::sheet::text_width;

/// A vertex that a tile shows: object, vertex of the cage or [`NONE`], face in whose middle it is or [`NONE`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    key: [u32; 3],
    pub(super) spot: Spot,
}

/// The sphere that axes and scale are made for.
fn sphere(scene: &Scene) -> Sphere {
    let mut sphere = scene.bounding_sphere();
    if sphere.radius <= 0.0 {
        sphere.radius = 1.0;
    }
    sphere
}

/// Where the axes begin, and their tips: from the origin of the model, or from its middle where that is outside of the sphere around it, to
/// the sphere.
pub(super) fn axes(scene: &Scene) -> ([f32; 3], [[f32; 3]; 3]) {
    let Sphere { center, radius } = sphere(scene);
    let from_middle = |p: [f64; 3]| [0, 1, 2].map(|k| p[k] - center[k]);
    let square = |d: [f64; 3]| d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    let mut start = scene.origin().map(|c| -c);
    if square(from_middle(start)) > radius * radius {
        start = center;
    }
    let d = from_middle(start);
    let tips = [0, 1, 2].map(|k| {
        // Along axis k from `start`: |d + s·e| is the radius.
        let s = -d[k] + (d[k] * d[k] - square(d) + radius * radius).max(0.0).sqrt();
        let mut tip = start;
        tip[k] += s;
        tip.map(|c| c as f32)
    });
    (start.map(|c| c as f32), tips)
}

/// Adds the vertices of cages that a block has in a tile (first column and row, columns and rows).
pub(super) fn in_block(rect: [u32; 4], block: &Block<'_>, lens: &Lens, found: &mut Vec<Found>) {
    let [x, y, width, height] = rect.map(f64::from);
    for (k, vertex, centre) in block.corners() {
        let Some(spot) = lens.spot(block.points.at(k)) else {
            continue;
        };
        let inside = spot[0] >= x && spot[0] < x + width && spot[1] >= y && spot[1] < y + height;
        if inside {
            let key = [block.object, vertex, centre];
            found.push(Found { key, spot });
        }
    }
}

/// Leaves every vertex of a tile once.
pub(super) fn once(found: &mut Vec<Found>) {
    found.sort_by_key(|f| f.key);
    // A vertex that several surfaces meet in may have several places; the nearest is seen first.
    found.dedup_by(|b, a| a.key == b.key && a.spot == b.spot);
}

/// Valence of every vertex of a cage, and whether it is ordinary.
fn valences(object: &Object) -> Vec<(u32, bool)> {
    let surface = &object.surface;
    let t = surface.topology();
    let mut edges = vec![0_u32; t.vertex_count()];
    let mut faces = vec![0_u32; t.vertex_count()];
    for e in 0..t.edge_count() as u32 {
        let h = t.edge_half(e);
        for v in [t.vertex(h), t.vertex(t.next(h))] {
            edges[v as usize] += 1;
        }
    }
    for h in 0..t.half_count() as u32 {
        faces[t.vertex(h) as usize] += 1;
    }
    let [inner, outer] = match surface.is_triangular() {
        true => [6, 3],
        false => [4, 2],
    };
    let ordinary = |(edges, faces): (&u32, &u32)| match edges == faces {
        true => (*edges, *faces == inner),
        // A corner of one face is ordinary, too.
        false => (*edges, *faces == outer || (*faces == 1 && *edges == 2)),
    };
    edges.iter().zip(&faces).map(ordinary).collect()
}

/// What is marked of the vertices that are seen.
pub(super) fn marks(scene: &Scene, layers: Layers, mut found: Vec<Found>) -> Vec<Mark> {
    found.sort_by(|a, b| a.key.cmp(&b.key).then(b.spot[2].total_cmp(&a.spot[2])));
    found.dedup_by_key(|f| f.key);
    let mut valence_of = None;
    let mut out = Vec::new();
    for f in found {
        let [object, vertex, centre] = f.key;
        let is_new = valence_of.as_ref().is_none_or(|(o, _)| *o != object);
        if is_new {
            valence_of = Some((object, valences(&scene.objects[object as usize])));
        }
        let at = [f.spot[0] as f32, f.spot[1] as f32];
        let t = scene.objects[object as usize].surface.topology();
        let (valence, ordinary) = match (vertex, &valence_of) {
            (NONE, _) => (t.face_halves(centre).len() as u32, false),
            (v, Some((_, all))) => all[v as usize],
            _ => continue,
        };
        let mark = Mark {
            at,
            object,
            vertex: (vertex != NONE).then_some(vertex),
            valence,
            extraordinary: !ordinary,
        };
        let marked = layers.contains(Layers::VALENCES) && mark.extraordinary;
        if marked || (layers.contains(Layers::LABELS) && mark.vertex.is_some()) {
            out.push(mark);
        }
    }
    out
}

/// Height of letters in units.
const LETTERS: f32 = 9.0;

/// Side of the squares that letters take, in pixels.
const SQUARE: f32 = 4.0;

/// Letters that do not stand in each other's way.
struct Layout<'a> {
    /// Squares that are taken, row by row.
    taken: Vec<bool>,
    cols: usize,
    labels: &'a mut Vec<Label>,
    size: [f32; 2],
}

impl<'a> Layout<'a> {
    fn new(size: [f32; 2], labels: &'a mut Vec<Label>) -> Self {
        let [cols, rows] = size.map(|s| (s / SQUARE) as usize + 1);
        Self {
            taken: vec![false; cols * rows],
            cols,
            labels,
            size,
        }
    }

    fn place(&mut self, at: [f32; 2], height: f32, text: String) {
        let width = text_width(&text, height);
        let (low, high) = (
            [at[0] - 1.0, at[1] - height - 1.0],
            [at[0] + width + 1.0, at[1] + 1.0],
        );
        let inside = |k: usize| low[k] >= 0.0 && high[k] < self.size[k];
        if !(inside(0) && inside(1)) {
            return;
        }
        let square = |v: f32| (v / SQUARE) as usize;
        let rows = square(low[1])..=square(high[1]);
        let cols = square(low[0])..=square(high[0]);
        let all = rows.flat_map(|y| cols.clone().map(move |x| [x, y]));
        let squares: Vec<usize> = all.map(|[x, y]| y * self.cols + x).collect();
        if squares.iter().all(|&k| !self.taken[k]) {
            squares.iter().for_each(|&k| self.taken[k] = true);
            self.labels.push(Label { at, height, text });
        }
    }
}

/// Adds letters, and the scale bar.
pub(super) fn annotate(
    scene: &Scene,
    view: &View,
    layers: Layers,
    unit: f32,
    marks: &[Mark],
    polylines: &mut Vec<Polyline>,
    labels: &mut Vec<Label>,
) {
    let size = [view.size.width as f32, view.size.height as f32];
    let mut layout = Layout::new(size, labels);
    let height = LETTERS * unit;
    if layers.contains(Layers::AXES) {
        let (start, tips) = axes(scene);
        let start = view.project(start);
        for (tip, name) in tips.into_iter().zip(["x", "y", "z"]) {
            if let (Some([x, y, _]), Some([x0, y0, _])) = (view.project(tip), start) {
                let d = [x - x0, y - y0];
                let length = (d[0] * d[0] + d[1] * d[1]).sqrt().max(1.0);
                // Beyond the tip, with the letter's middle on the line.
                let out = d.map(|c| c / length * 9.0 * unit);
                let width = text_width(name, height);
                let at = [x + out[0] - width * 0.5, y + out[1] + height * 0.4];
                layout.place(at, height, name.into());
            }
        }
    }
    if layers.contains(Layers::SCALE) {
        scale(scene, view, unit, polylines, &mut layout);
    }
    for mark in marks {
        let [x, y] = mark.at;
        if layers.contains(Layers::VALENCES) && mark.extraordinary {
            let at = [x + 5.0 * unit, y - 3.0 * unit];
            layout.place(at, height, mark.valence.to_string());
        }
    }
    for mark in marks {
        let [x, y] = mark.at;
        if let (true, Some(vertex)) = (layers.contains(Layers::LABELS), mark.vertex) {
            let height = height * 0.85;
            let at = [x + 4.0 * unit, y + 4.0 * unit + height];
            layout.place(at, height, vertex.to_string());
        }
    }
}

/// The largest of 1, 2 and 5 times a power of ten that is not above `x`, and the decimals it takes.
fn round_length(x: f64) -> (f64, usize) {
    let power = libm::floor(libm::log10(x));
    let ten = libm::pow(10.0, power);
    let digit = [5.0, 2.0].into_iter().find(|d| d * ten <= x).unwrap_or(1.0);
    (digit * ten, (-power).max(0.0) as usize)
}

/// A bar of a round length, in the lower left corner.
fn scale(
    scene: &Scene,
    view: &View,
    unit: f32,
    polylines: &mut Vec<Polyline>,
    layout: &mut Layout<'_>,
) {
    let middle = math::round3(math::DVec3::from_array(sphere(scene).center));
    let pixels = f64::from(view.pixel_scale(view.distance(middle)));
    let longest = f64::from(layout.size[0]) * 0.25 / pixels;
    if !(longest.is_finite() && longest > 1e-30 && longest < 1e30) {
        return;
    }
    let (length, decimals) = round_length(longest);
    let text = match decimals {
        0..=6 if length < 1e7 => format!("{length:.decimals$}"),
        _ => format!("{length:e}"),
    };
    let (x, y) = (16.0 * unit, layout.size[1] - 16.0 * unit);
    let end = x + (length * pixels) as f32;
    let tick = 4.0 * unit;
    polylines.push(Polyline {
        kind: Kind::Scale,
        points: vec![[x, y - tick], [x, y], [end, y], [end, y - tick]],
    });
    let height = LETTERS * unit;
    let at = [(x + end - text_width(&text, height)) * 0.5, y - 6.0 * unit];
    layout.place(at, height, text);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_round() {
        for (x, want, text) in [
            (1.0, 1.0, "1"),
            (0.99, 0.5, "0.5"),
            (0.21, 0.2, "0.2"),
            (4.9, 2.0, "2"),
            (730.0, 500.0, "500"),
            (0.0123, 0.01, "0.01"),
        ] {
            let (length, decimals) = round_length(x);
            assert!((length - want).abs() < 1e-12 * want, "{x}");
            assert_eq!(format!("{length:.decimals$}"), text);
        }
    }
}
