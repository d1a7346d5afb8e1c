//! The table of a shape: what becomes of values that are 1 at one control point and 0 at all others.
//!
//! The surroundings of the face are refined with all such values as columns, by the code that refines meshes. After every step only the
//! rings around what descends from the face are kept; what the rim does wrong never comes nearer.

use super::shape::Shape;
use crate::dice::table::{Rows, Table, places};
use crate::refine::interpolating::{Linear, Sheets};
use crate::refine::limit::Tangents;
use crate::refine::sharpness::Step;
use crate::refine::{Level, Options, connectivity};
use crate::scheme::{INFINITE_SHARPNESS, Scheme};
use crate::topology::channel::number_edges;
use crate::topology::connect::rebuild_fans;
use crate::topology::{Ring, Topology};

/// Columns that are refined at a time.
const WIDTH: usize = 16;
/// Weights below this are rounding.
const NOTHING: f64 = 1e-13;

type Columns = Vec<[f64; WIDTH]>;

/// Rings of faces that the points of a face are made of: what refinement itself looks at.
pub(super) fn rings(scheme: Scheme) -> usize {
    // Kobbelt's face points ask for the valence of vertices two rings away.
    if scheme == Scheme::Kobbelt { 3 } else { 2 }
}

fn topology(shape: &Shape) -> Topology {
    let mut t = Topology {
        vertex_count: shape.ends.len(),
        corner_vertices: shape.corners.clone(),
        twins: shape.twins.clone(),
        ..Topology::default()
    };
    if shape.sides != 4 {
        let corners = shape.corners.len() as u32;
        t.face_offsets = (0..=corners / shape.sides)
            .map(|f| f * shape.sides)
            .collect();
        t.corner_faces = (0..corners).map(|h| h / shape.sides).collect();
    }
    if shape.ends.contains(&true) {
        let sharpness = |&end: &bool| if end { INFINITE_SHARPNESS } else { 0.0 };
        t.vertex_sharpness = shape.ends.iter().map(sharpness).collect();
    }
    number_edges(&mut t);
    rebuild_fans(&mut t);
    t
}

/// Sheets of columns.
fn sheets<'a>(
    step: &'a Step<'a>,
    tangents: &'a Tangents,
    values: &'a Columns,
    linear: Linear,
) -> Sheets<'a, f64, f64, WIDTH> {
    let index = &step.topology.corner_vertices;
    Sheets::of_corners(step, tangents.masks(), index, values, &[], linear)
}

fn refined(step: &Step<'_>, tangents: &Tangents, values: &Columns, linear: Linear) -> Columns {
    let t = step.topology;
    let s = sheets(step, tangents, values, linear);
    let edges: Columns = (0..t.edge_count() as u32)
        .map(|e| s.edge_point(s.side(e)))
        .collect();
    let mut out = values.clone();
    let edge_point = |h: u32| edges[t.edge(h) as usize];
    let faces = (0..step.face_points() as u32).map(|f| s.face_point(4 * f, edge_point));
    out.extend(faces);
    out.extend_from_slice(&edges);
    out
}

/// The first `own` faces of `t` and some rings around them.
fn surroundings(t: &Topology, own: usize, rings: usize) -> Vec<(u32, u32)> {
    let mut faces: Vec<u32> = (0..own as u32).collect();
    let mut has_face = vec![false; t.face_count()];
    has_face[..own].fill(true);
    let mut has_fan = vec![false; t.fans().len()];
    let mut done = 0;
    for _ in 0..rings {
        let end = faces.len();
        for i in done..end {
            for h in t.face_halves(faces[i]) {
                if std::mem::replace(&mut has_fan[t.fan(h) as usize], true) {
                    continue;
                }
                for g in Ring::of_fan(t, t.fan(h)) {
                    let f = t.face_of(g);
                    if !std::mem::replace(&mut has_face[f as usize], true) {
                        faces.push(f);
                    }
                }
            }
        }
        done = end;
    }
    faces.into_iter().map(|f| (f, 0)).collect()
}

/// Weights of one point: position and two tangents, by control point.
type Weights = [Vec<f64>; 3];

/// The table of `shape` for a grid of `2^level` segments.
pub(super) fn table(shape: &Shape, options: &Options, tangents: &Tangents, level: u32) -> Table {
    let linear = if shape.straight {
        Linear::Cuts
    } else {
        Linear::Never
    };
    let mut t = topology(shape);
    let mut columns: Vec<Columns> = (0..shape.inner.div_ceil(WIDTH))
        .map(|group| {
            let unit =
                |v: usize| std::array::from_fn(|k| f64::from(u8::from(v == group * WIDTH + k)));
            (0..t.vertex_count()).map(unit).collect()
        })
        .collect();
    let rings = rings(options.scheme);
    // Tangents in Kobbelt's scheme want regular neighbours, which they have one step further.
    let extra = u32::from({
        let step = Step::new(&t, options);
        let s = sheets(&step, tangents, &columns[0], linear);
        options.scheme == Scheme::Kobbelt && t.face_halves(0).any(|h| s.is_irregular(h))
    });
    for depth in 1..=level + extra {
        let step = Step::new(&t, options);
        columns = (columns.iter())
            .map(|c| refined(&step, tangents, c, linear))
            .collect();
        let child = connectivity::child(&step);
        let own = 1_usize << (2 * depth);
        let faces = surroundings(&child, own, rings);
        let blank = vec![[0.0; 3]; child.vertex_count()];
        // There is one point per vertex, so this does not fail.
        let Ok(whole) = Level::new(child, blank) else {
            return Table::default();
        };
        let part = whole.part(&faces);
        for c in &mut columns {
            *c = part.vertices.iter().map(|&v| c[v as usize]).collect();
        }
        t = part.level.topology;
    }
    let step = Step::new(&t, options);
    let groups: Vec<_> = (columns.iter())
        .map(|c| sheets(&step, tangents, c, linear))
        .collect();
    // A corner of a face at every point of the grid.
    let n = 1_i32 << level;
    let side = (n + 1) as usize;
    let mut corners = vec![0_u32; side * side];
    let square = [[0, 0], [1, 0], [1, 1], [0, 1]];
    for (f, place) in places(shape.sides == 3, level + extra)
        .into_iter()
        .enumerate()
    {
        for (h, [i, j]) in t.face_halves(f as u32).zip(square) {
            let [i, j] = place.at(1, i, j);
            if extra == 0 || (i | j) & 1 == 0 {
                let [i, j] = [i, j].map(|c| (c >> extra) as usize);
                corners[j * side + i] = h;
            }
        }
    }
    let weights = |[i, j]: [i32; 2]| -> Weights {
        let h = corners[j as usize * side + i as usize];
        let mut out = [const { Vec::new() }; 3];
        for s in &groups {
            let [a, b] = s_tangents(tangents, &t, s, h);
            out[0].extend(s.at(h));
            out[1].extend(a);
            out[2].extend(b);
        }
        out
    };
    let inside: Vec<Weights> = (1..n)
        .flat_map(|j| {
            let low = if shape.sides == 3 { j + 1 } else { 1 };
            (low..n).map(move |i| [i, j])
        })
        .map(weights)
        .collect();
    let ends: &[[i32; 2]] = match shape.sides {
        3 => &[[0, 0], [n, 0], [n, n]],
        _ => &[[0, 0], [n, 0], [n, n], [0, n]],
    };
    let along = |c: usize| -> Vec<Weights> {
        let (a, b) = (ends[c], ends[(c + 1) % ends.len()]);
        (1..n)
            .map(|k| weights([0, 1].map(|x| a[x] + (b[x] - a[x]) / n * k)))
            .collect()
    };
    let sides: Vec<Vec<Weights>> = (0..ends.len()).map(along).collect();
    let all = || inside.iter().chain(sides.iter().flatten());
    // Everything is relative to vertex 0, so its own weights are not needed.
    let controls: Vec<u32> = (1..shape.inner as u32)
        .filter(|&v| all().any(|w| w.iter().any(|layer| layer[v as usize].abs() > NOTHING)))
        .collect();
    let rows = |points: &[Weights]| {
        Rows::new(points.len(), controls.len(), |layer, point, control| {
            let v = controls.get(control);
            v.map_or(0.0, |&v| points[point][layer][v as usize] as f32)
        })
    };
    let (inside, sides) = (rows(&inside), sides.iter().map(|s| rows(s)).collect());
    Table::new(controls, inside, sides)
}

fn s_tangents(
    tangents: &Tangents,
    t: &Topology,
    sheets: &Sheets<'_, f64, f64, WIDTH>,
    h: u32,
) -> [[f64; WIDTH]; 2] {
    tangents.at(t, sheets, h).unwrap_or([[0.0; WIDTH]; 2])
}
