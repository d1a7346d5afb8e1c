//! Tables of weights of texture coordinates: for every point of a face's grid, how much of each is in the value there and in its derivatives.

use super::error::GpuError;
use super::surroundings::Surroundings;
use super::tables::{NO_WEIGHTS, Wanted, of_each, quarter, rim_len, rims, subs};
use crate::limits::Budget;
use crate::surface::{PlaceJets, Surface};

/// The weights of texture coordinates of a shape of surroundings.
#[derive(Clone, Debug, Default)]
pub(super) struct UvTable {
    pub(super) level: u32,
    /// Columns: local texture coordinates.
    pub(super) count: u32,
    /// Weights of a column at a point.
    pub(super) width: u32,
    /// The same of the points on the sides alone, by [`rim_index`].
    pub(super) rim: Vec<f32>,
    /// Points of a rim.
    pub(super) rim_stride: u32,
    /// The value, and where there are three du and dv; by quad of the face where it is split, by column, by point of the grid.
    pub(super) weights: Vec<f32>,
}

impl UvTable {
    /// First weight of quad `sub` in the rim.
    pub(super) fn rim_offset(&self, sub: u32) -> u32 {
        sub * self.count * self.rim_stride * self.width
    }

    /// First weight of quad `sub`.
    pub(super) fn offset(&self, sub: u32) -> u32 {
        let side = (1 << self.level) + 1;
        sub * self.count * side * side * self.width
    }

    pub(super) fn bytes(&self) -> u64 {
        4 * self.weights.len() as u64
    }

    pub(super) fn rim_bytes(&self) -> u64 {
        4 * self.rim.len() as u64
    }
}

/// Makes the tables of texture coordinates of `shapes` at their levels.
pub(super) fn make_uvs(
    surface: &Surface,
    shapes: &[Wanted<'_>],
    width: u32,
    budget: &mut Budget<'_>,
) -> Result<Vec<UvTable>, GpuError> {
    let values = |shape: &Surroundings| width as usize * shape.uvs.len();
    of_each(surface, shapes, values, budget, |shape, level| {
        one_uvs(surface, shape, level, width)
    })
}

fn one_uvs(
    whole: &Surface,
    shape: &Surroundings,
    level: u32,
    width: u32,
) -> Result<UvTable, GpuError> {
    let split = whole.is_split();
    // A face without any among faces that have some has zeros.
    let is_known = shape.has_own_uvs();
    let count = shape.uvs.len();
    let n = 1_usize << level;
    let side = n + 1;
    let place = |i: usize, j: usize| [i, j].map(|k| k as f32 / n as f32);
    let subs = subs(whole, shape);
    let mut weights = vec![0.0_f32; subs * count * side * side * width as usize];
    for first in (0..count).step_by(2) {
        let mut values = vec![[0.0_f32; 2]; count];
        values[first][0] = 1.0;
        if let Some(second) = values.get_mut(first + 1) {
            second[1] = 1.0;
        }
        let mut surface = shape.surface_with(whole, &values);
        if width > 1 {
            // Any, if only they differ: at flat corners they say which ways derivatives run.
            let vertices = 0..surface.control_base().len();
            let points: Vec<[f32; 3]> = vertices.map(|k| [k as f32, 0.0, 0.0]).collect();
            surface.update_points(&points).map_err(|_| NO_WEIGHTS)?;
        }
        let mut face = surface.face_evaluator(0).ok_or(NO_WEIGHTS)?;
        let mut jets = (width > 1).then(|| PlaceJets::new(&surface));
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
                    let by = match &mut jets {
                        Some(jets) => Some(jets.uvs(sub as u32, place(i, j)).ok_or(NO_WEIGHTS)?),
                        None => None,
                    };
                    for k in first..count.min(first + 2) {
                        let at = ((sub * count + k) * side + j) * side + i;
                        let out = &mut weights[at * width as usize..][..width as usize];
                        out[0] = found[k - first];
                        if let Some(by) = by {
                            out[1..].copy_from_slice(&by.map(|d| d[k - first]));
                        }
                    }
                }
            }
        }
    }
    Ok(UvTable {
        level,
        count: count as u32,
        width,
        rim: rims(&weights, subs * count, width, level, whole.is_triangular()),
        rim_stride: rim_len(level, whole.is_triangular()),
        weights,
    })
}
