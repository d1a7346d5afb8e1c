//! Tables of weights: for every point of a face's grid, how much of each control point is in its position and in its two derivatives.
//!
//! The processor's own evaluation makes them: control points that are unit vectors, three at a time, give the weights of three control
//! points as coordinates.

use super::error::GpuError;
use super::surroundings::Surroundings;
use crate::evaluate::Tangents;
use crate::frame::Drawing;
use crate::limits::Budget;
use crate::surface::{DicedQuad, PlaceJets, Surface};
use rayon::prelude::*;

/// The weights of a shape of surroundings at one level.
#[derive(Clone, Debug, Default)]
pub(super) struct Table {
    /// Level of the grids.
    pub(super) level: u32,
    /// Local vertices that have weights.
    pub(super) columns: Vec<u32>,
    /// Weights of a column at a point.
    pub(super) width: u32,
    /// Position; where there are three du and dv, and where there are six duu, duv and dvv; by quad of the face where it is split, by column, by point of the grid.
    pub(super) weights: Vec<f32>,
    /// The same of the points on the sides alone, by [`rim_index`].
    pub(super) rim: Vec<f32>,
    /// Points of a rim.
    pub(super) rim_stride: u32,
}

impl Table {
    /// First group of quad `sub` in the rim.
    pub(super) fn rim_offset(&self, sub: u32) -> u32 {
        sub * self.columns.len() as u32 * self.rim_stride
    }

    /// Points of a grid.
    pub(super) fn stride(&self) -> u32 {
        ((1 << self.level) + 1) * ((1 << self.level) + 1)
    }

    /// First group of quad `sub`.
    pub(super) fn offset(&self, sub: u32) -> u32 {
        sub * self.columns.len() as u32 * self.stride()
    }

    pub(super) fn bytes(&self) -> u64 {
        4 * self.weights.len() as u64
    }

    pub(super) fn rim_bytes(&self) -> u64 {
        4 * self.rim.len() as u64
    }
}

/// The number of a point on a side of a grid of `n` segments, counted along the sides.
pub(super) fn rim_index([x, y]: [u32; 2], n: u32, triangles: bool) -> u32 {
    match (x, y) {
        (x, 0) => x,
        (x, y) if x == n => n + y,
        (x, _) if triangles => 3 * n - x,
        (x, y) if y == n => 3 * n - x,
        (_, y) => 4 * n - y,
    }
}

/// The points on the sides of grids of `groups` columns each.
pub(super) fn rims(
    weights: &[f32],
    groups: usize,
    width: u32,
    level: u32,
    triangles: bool,
) -> Vec<f32> {
    let (n, width) = (1_u32 << level, width as usize);
    let side = n + 1;
    let stride = rim_len(level, triangles) as usize;
    let grid = (side * side) as usize;
    let mut out = vec![0.0; groups * stride * width];
    let on_side = |x: u32, y: u32| match triangles {
        true => y <= x && (y == 0 || x == n || x == y),
        false => x == 0 || y == 0 || x == n || y == n,
    };
    for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
        if !on_side(x, y) {
            continue;
        }
        let to = rim_index([x, y], n, triangles) as usize;
        let from = (y * side + x) as usize;
        for group in 0..groups {
            let (from, to) = ((group * grid + from) * width, (group * stride + to) * width);
            out[to..to + width].copy_from_slice(&weights[from..from + width]);
        }
    }
    out
}

/// Points of a rim.
pub(super) fn rim_len(level: u32, triangles: bool) -> u32 {
    (if triangles { 3 } else { 4 }) << level
}

/// Most bytes of all tables of a surface.
const MOST_BYTES: u128 = 4 << 30;

/// A shape of surroundings, and the level that it is wanted at.
pub(super) type Wanted<'a> = (&'a Surroundings, u32);

/// Makes the table of each of `shapes` at its level by `one`, once there is memory for all: each has a number of values per point.
pub(super) fn of_each<T: Send>(
    surface: &Surface,
    shapes: &[Wanted<'_>],
    values: impl Fn(&Surroundings) -> usize,
    budget: &mut Budget<'_>,
    one: impl Fn(&Surroundings, u32) -> Result<T, GpuError> + Sync,
) -> Result<Vec<T>, GpuError> {
    take(surface, shapes, values, budget)?;
    let limits = budget.limits();
    shapes
        .par_iter()
        .map(|&(shape, level)| {
            limits.check()?;
            one(shape, level)
        })
        .collect()
}

/// Takes the memory of tables.
fn take(
    surface: &Surface,
    shapes: &[Wanted<'_>],
    values: impl Fn(&Surroundings) -> usize,
    budget: &mut Budget<'_>,
) -> Result<(), GpuError> {
    let bytes = shapes.iter().map(|&(shape, level)| {
        let side = (1_u128 << level) + 1;
        4 * side * (side + 4) * subs(surface, shape) as u128 * values(shape) as u128
    });
    let bytes = bytes.sum();
    if bytes > MOST_BYTES {
        return Err(GpuError::OutOfMemory {
            what: "the tables of weights: lower the level",
        });
    }
    Ok(budget.take("the tables of the GPU backend", bytes, 0)?)
}

/// Quads of a face that have a grid each.
pub(super) fn subs(surface: &Surface, shape: &Surroundings) -> usize {
    match surface.is_split() {
        true => shape.size() as usize,
        false => 1,
    }
}

/// Where the processor's evaluation gives no weights, a face would silently be drawn as a point.
pub(super) const NO_WEIGHTS: GpuError = GpuError::Missing {
    what: "weights of a face",
};

/// Makes the tables of `shapes` at their levels.
///
/// Where control points are drawn, positions are those after as many steps as the level says; derivatives stay those of the limit.
pub(super) fn make(
    surface: &Surface,
    shapes: &[Wanted<'_>],
    drawing: Drawing,
    width: u32,
    budget: &mut Budget<'_>,
) -> Result<Vec<Table>, GpuError> {
    let values = |shape: &Surroundings| width as usize * shape.vertices.len();
    of_each(surface, shapes, values, budget, |shape, level| {
        one(surface, shape, level, drawing, width)
    })
}

/// Makes tables of the limit surface at level 1, which quadratic patches run through.
pub(super) fn make_base(
    surface: &Surface,
    shapes: &[Wanted<'_>],
    width: u32,
    budget: &mut Budget<'_>,
) -> Result<Vec<Table>, GpuError> {
    let base: Vec<Wanted<'_>> = shapes.iter().map(|&(shape, _)| (shape, 1)).collect();
    make(surface, &base, Drawing::Limit, width, budget)
}

fn one(
    whole: &Surface,
    shape: &Surroundings,
    level: u32,
    drawing: Drawing,
    width: u32,
) -> Result<Table, GpuError> {
    let (split, triangles) = (whole.is_split(), whole.is_triangular());
    let mut surface = shape.surface(whole);
    let count = shape.vertices.len();
    let n = 1_u32 << level;
    let side = n as usize + 1;
    let place = |i: usize, j: usize| [i, j].map(|k| k as f32 / n as f32);
    let subs = subs(whole, shape);
    // A face of four corners among others is evaluated as a whole, its quads being quarters.
    let quarters = split && shape.size() == 4;
    let asked = if quarters { 2 * n } else { n };
    let mut weights = vec![0.0_f32; subs * count * side * side * width as usize];
    let mut samples = Vec::new();
    let mut points = vec![[0.0_f32; 3]; surface.control_base().len()];
    for first in (0..count).step_by(3) {
        points.fill([0.0; 3]);
        for k in first..count.min(first + 3) {
            points[k][k - first] = 1.0;
        }
        surface.update_points(&points).map_err(|_| NO_WEIGHTS)?;
        let mut face = surface.face_evaluator(0).ok_or(NO_WEIGHTS)?;
        samples.clear();
        samples.resize(face.grid_len(asked), Tangents::default());
        face.grid(asked, &mut samples).map_err(|_| NO_WEIGHTS)?;
        let refined: Vec<DicedQuad> = match drawing {
            Drawing::Refined => surface.refine_quads(level).take(subs).collect(),
            Drawing::Limit | Drawing::Cage => Vec::new(),
        };
        let mut jets = PlaceJets::new(&surface);
        for sub in 0..subs {
            for j in 0..side {
                for i in 0..side {
                    let found = match (triangles, quarters) {
                        (true, _) if j > i => continue,
                        // Rows of barycentric grids are one shorter each.
                        (true, _) => j * (n as usize + 1) - j * (j.max(1) - 1) / 2 + (i - j),
                        (_, true) => quarter(sub, i, j, asked as usize),
                        _ => (sub * side + j) * side + i,
                    };
                    let s = &samples[found];
                    let refined = refined.get(sub).map(|q| q.points[j * side + i]);
                    let position = refined.unwrap_or(s.position);
                    let (sub, at) = (sub as u32, place(i, j));
                    let by = match width > 3 {
                        true => jets.points(sub, at).ok_or(NO_WEIGHTS)?,
                        false => {
                            let [du, dv] = jets.flat(sub, at).unwrap_or([s.du, s.dv]);
                            [du, dv, [0.0; 3], [0.0; 3], [0.0; 3]]
                        }
                    };
                    for k in first..count.min(first + 3) {
                        let at = (sub as usize * count + k) * side * side + j * side + i;
                        let out = &mut weights[at * width as usize..][..width as usize];
                        let c = k - first;
                        out[0] = position[c];
                        for (out, d) in out[1..].iter_mut().zip(by) {
                            *out = d[c];
                        }
                    }
                }
            }
        }
    }
    let table = Table {
        level,
        columns: (0..count as u32).collect(),
        width,
        weights,
        ..Table::default()
    };
    let mut table = compact(table, subs);
    let groups = subs * table.columns.len();
    table.rim = rims(&table.weights, groups, width, level, triangles);
    table.rim_stride = rim_len(level, triangles);
    Ok(table)
}

/// Where in a grid of `n` segments over a face of four corners point (i, j) of its quad at corner `sub` is.
pub(super) fn quarter(sub: usize, i: usize, j: usize, n: usize) -> usize {
    let [x, y] = match sub {
        0 => [i, j],
        1 => [n - j, i],
        2 => [n - i, n - j],
        _ => [j, n - i],
    };
    y * (n + 1) + x
}

/// Leaves out columns without weights. The first stays: points are summed up relative to it.
fn compact(table: Table, subs: usize) -> Table {
    let size = (table.stride() * table.width) as usize;
    let count = table.columns.len();
    let column = |sub: usize, k: usize| {
        let at = (sub * count + k) * size;
        &table.weights[at..at + size]
    };
    let used = |k: usize| (0..subs).any(|sub| column(sub, k).iter().any(|&w| w != 0.0));
    let kept: Vec<usize> = (0..count).filter(|&k| k == 0 || used(k)).collect();
    if kept.len() == count {
        return table;
    }
    let mut weights = Vec::with_capacity(subs * kept.len() * size);
    for sub in 0..subs {
        for &k in &kept {
            weights.extend_from_slice(column(sub, k));
        }
    }
    Table {
        level: table.level,
        columns: kept.iter().map(|&k| table.columns[k]).collect(),
        width: table.width,
        weights,
        ..Table::default()
    }
}
