//! How many bytes meshes and tables will take, from counts: asked before anything is made.

use super::{Shapes, TableTree};
use crate::limits::{Budget, LimitError};
use crate::refine::counts;

/// Bytes that a mesh keeps of a corner, an edge and a vertex: the level, its sheet, the mesh that is diced, and its normals.
const POINTS: [u128; 3] = [80, 20, 150];
/// The same of texture coordinates, or of colours.
const CHANNEL: [u128; 3] = [40, 10, 80];
/// Vertices around a face by which it finds its control points, with room to grow: for every face and sheet.
const SHAPES: u128 = 8 * 40;

impl Shapes {
    /// Bytes of all tables of `steps` levels; shapes that points and texture coordinates share count twice.
    pub(super) fn table_bytes(&self, steps: u32) -> usize {
        let side = (1_usize << steps) + 1;
        let all = self.shapes.iter().flatten();
        all.map(|s| 12 * s.inner * side * side).sum()
    }

    /// Bytes of the largest table.
    fn largest(&self, steps: u32) -> usize {
        let side = (1_usize << steps) + 1;
        let all = self.shapes.iter().flatten();
        let sizes = all.map(|s| 12 * s.inner * side * side);
        sizes.max().unwrap_or(0)
    }
}

/// Bytes in `f64` that making a table takes, per byte of the table: columns of two levels with the rings around, and weights.
const MAKING: u128 = 8;

impl TableTree {
    /// Asks for the meshes from below `from` to `to`; shapes of the last are counted with it.
    pub(super) fn take_meshes(
        &self,
        from: u32,
        to: u32,
        budget: &mut Budget<'_>,
    ) -> Result<(), LimitError> {
        let level = &self.root.level;
        let channels = u128::from(level.uvs.is_some()) + u128::from(!self.root.colors.is_empty());
        for depth in from + 1..=to {
            let c = counts(&level.topology, self.options.scheme, depth);
            let of = |[corner, edge, vertex]: [u128; 3]| {
                (c.corners.saturating_mul(corner))
                    .saturating_add(c.edges.saturating_mul(edge))
                    .saturating_add(c.vertices.saturating_mul(vertex))
            };
            let kept = of(POINTS).saturating_add(of(CHANNEL).saturating_mul(channels));
            let sheets = 1 + u128::from(level.uvs.is_some());
            let shapes = c.faces.saturating_mul(SHAPES * sheets);
            budget.take("the refined mesh of an interpolating surface", kept, shapes)?;
        }
        Ok(())
    }

    /// Asks for the tables of a level over the mesh of `depth`.
    pub(super) fn take_tables(
        &self,
        level: u32,
        depth: u32,
        budget: &mut Budget<'_>,
    ) -> Result<(), LimitError> {
        let steps = level - depth;
        let Some(shapes) = (steps > 0).then(|| self.shapes(depth)).flatten() else {
            return Ok(());
        };
        let tables = shapes.table_bytes(steps) as u128;
        let threads = rayon::current_num_threads() as u128;
        let making = threads * MAKING * shapes.largest(steps) as u128;
        budget.take("the tables of an interpolating surface", tables, making)
    }
}
