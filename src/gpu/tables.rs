//! Tables of weights: for every point of a face's grid, how much of each control point is in its position and in its two derivatives.
//!
//! The processor's own evaluation makes them: control points that are unit vectors, three at a time, give the weights of three control
//! points as coordinates.

use super::error::GpuError;
use super::surroundings::Surroundings;
use crate::evaluate::Tangents;
use crate::limits::Budget;
use crate::surface::Surface;
use rayon::prelude::*;

/// The weights of a shape of surroundings at one level.
#[derive(Clone, Debug, Default)]
pub(super) struct Table {
    /// Level of the grids.
    pub(super) level: u32,
    /// Local vertices that have weights.
    pub(super) columns: Vec<u32>,
    /// Position, du and dv; by quad of the face where it is split, by column, by point of the grid.
    pub(super) weights: Vec<f32>,
}

impl Table {
    /// Points of a grid.
    pub(super) fn stride(&self) -> u32 {
        ((1 << self.level) + 1) * ((1 << self.level) + 1)
    }

    /// First triple of quad `sub`.
    pub(super) fn offset(&self, sub: u32) -> u32 {
        sub * self.columns.len() as u32 * self.stride()
    }

    pub(super) fn bytes(&self) -> u64 {
        4 * self.weights.len() as u64
    }
}

/// Most bytes of all tables of a surface.
const MOST_BYTES: u128 = 4 << 30;

/// A shape of surroundings, and the level that it is wanted at.
pub(super) type Wanted<'a> = (&'a Surroundings, u32);

/// Takes the memory of tables of `shapes`, of which each has a number of values per point.
fn take(
    surface: &Surface,
    shapes: &[Wanted<'_>],
    values: impl Fn(&Surroundings) -> usize,
    budget: &mut Budget<'_>,
) -> Result<(), GpuError> {
    let bytes = shapes.iter().map(|&(shape, level)| {
        let side = (1_u128 << level) + 1;
        4 * side * side * subs(surface, shape) as u128 * values(shape) as u128
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
fn subs(surface: &Surface, shape: &Surroundings) -> usize {
    match surface.is_split() {
        true => shape.size() as usize,
        false => 1,
    }
}

/// Where the processor's evaluation gives no weights, a face would silently be drawn as a point.
const NO_WEIGHTS: GpuError = GpuError::Missing {
    what: "weights of a face",
};

/// Makes the tables of `shapes` at their levels.
pub(super) fn make(
    surface: &Surface,
    shapes: &[Wanted<'_>],
    budget: &mut Budget<'_>,
) -> Result<Vec<Table>, GpuError> {
    take(surface, shapes, |shape| 3 * shape.vertices.len(), budget)?;
    let limits = budget.limits();
    shapes
        .par_iter()
        .map(|&(shape, level)| {
            limits.check()?;
            one(surface, shape, level)
        })
        .collect()
}

fn one(whole: &Surface, shape: &Surroundings, level: u32) -> Result<Table, GpuError> {
    let (split, triangles) = (whole.is_split(), whole.is_triangular());
    let mut surface = shape.surface(whole);
    let count = shape.vertices.len();
    let n = 1_u32 << level;
    let side = n as usize + 1;
    let subs = subs(whole, shape);
    // A face of four corners among others is evaluated as a whole, its quads being quarters.
    let quarters = split && shape.size() == 4;
    let asked = if quarters { 2 * n } else { n };
    let mut weights = vec![0.0_f32; subs * count * side * side * 3];
    let mut samples = Vec::new();
    let mut points = vec![[0.0_f32; 3]; count];
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
                    for k in first..count.min(first + 3) {
                        let at = ((sub * count + k) * side * side + j * side + i) * 3;
                        let c = k - first;
                        weights[at..at + 3].copy_from_slice(&[s.position[c], s.du[c], s.dv[c]]);
                    }
                }
            }
        }
    }
    let table = Table {
        level,
        columns: (0..count as u32).collect(),
        weights,
    };
    Ok(compact(table, subs))
}

/// Where in a grid of `n` segments over a face of four corners point (i, j) of its quad at corner `sub` is.
fn quarter(sub: usize, i: usize, j: usize, n: usize) -> usize {
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
    let size = table.stride() as usize * 3;
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
        weights,
    }
}

/// The weights of texture coordinates of a shape of surroundings.
#[derive(Clone, Debug, Default)]
pub(super) struct UvTable {
    pub(super) level: u32,
    /// Columns: local texture coordinates.
    pub(super) count: u32,
    /// By quad of the face where it is split, by column, by point of the grid.
    pub(super) weights: Vec<f32>,
}

impl UvTable {
    /// First weight of quad `sub`.
    pub(super) fn offset(&self, sub: u32) -> u32 {
        let side = (1 << self.level) + 1;
        sub * self.count * side * side
    }

    pub(super) fn bytes(&self) -> u64 {
        4 * self.weights.len() as u64
    }
}

/// Makes the tables of texture coordinates of `shapes` at their levels.
pub(super) fn make_uvs(
    surface: &Surface,
    shapes: &[Wanted<'_>],
    budget: &mut Budget<'_>,
) -> Result<Vec<UvTable>, GpuError> {
    take(surface, shapes, |shape| shape.uvs.len(), budget)?;
    let limits = budget.limits();
    shapes
        .par_iter()
        .map(|&(shape, level)| {
            limits.check()?;
            one_uvs(surface, shape, level)
        })
        .collect()
}

fn one_uvs(whole: &Surface, shape: &Surroundings, level: u32) -> Result<UvTable, GpuError> {
    let split = whole.is_split();
    // A face without any among faces that have some has zeros.
    let is_known = shape.has_own_uvs();
    let count = shape.uvs.len();
    let n = 1_usize << level;
    let side = n + 1;
    let subs = subs(whole, shape);
    let mut weights = vec![0.0_f32; subs * count * side * side];
    for first in (0..count).step_by(2) {
        let mut values = vec![[0.0_f32; 2]; count];
        values[first][0] = 1.0;
        if let Some(second) = values.get_mut(first + 1) {
            second[1] = 1.0;
        }
        let surface = shape.surface_with(whole, &values);
        let mut face = surface.face_evaluator(0).ok_or(NO_WEIGHTS)?;
        for sub in 0..subs {
            for j in 0..side {
                for i in 0..side {
                    let at = match (whole.is_triangular(), split, shape.size()) {
                        (true, ..) if j > i => continue,
                        (true, ..) => [(i - j) as f32 / n as f32, j as f32 / n as f32],
                        (_, true, 4) => {
                            let k = quarter(sub, i, j, 2 * n);
                            let [x, y] = [k % (2 * n + 1), k / (2 * n + 1)];
                            [x, y].map(|x| x as f32 / (2 * n) as f32)
                        }
                        // Where a polygon's quad ends its next one begins, elsewhere: the last place before.
                        (_, true, _) if i == n => {
                            [(sub as f32 + 1.0).next_down(), j as f32 / n as f32]
                        }
                        _ => [sub as f32 + i as f32 / n as f32, j as f32 / n as f32],
                    };
                    let found = match face.uv(at[0], at[1]) {
                        None if is_known => return Err(NO_WEIGHTS),
                        found => found.unwrap_or_default(),
                    };
                    for k in first..count.min(first + 2) {
                        weights[((sub * count + k) * side + j) * side + i] = found[k - first];
                    }
                }
            }
        }
    }
    Ok(UvTable {
        level,
        count: count as u32,
        weights,
    })
}
