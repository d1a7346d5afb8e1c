//! Blocks of polygonal levels (`surface::polygons`).

use super::chunk::{ALIGNED, Builder};
use super::dicer::{Dicer, FaceTable};
use super::error::GpuError;
use super::plan::PlannedBlock;
use super::polygon::CORNERS;
use super::records::{Face, POINT_FLOATS, Stencil};

/// Values of a face's columns at the corners of a block.
struct Rows {
    /// By column and place.
    weights: Vec<f32>,
    gathers: Vec<u32>,
}

impl Dicer<'_> {
    /// The weights at the corners of a block, of tables on grids of `level` with `count` columns of `width` numbers, of which the first
    /// `kept` are.
    fn at_corners(
        &self,
        quad: u32,
        weights: &[f32],
        [level, count, width, kept]: [u32; 4],
    ) -> Vec<f32> {
        let (n, side) = (1 << level, (1 << level) + 1);
        let corners = self.surface.polygon_block(quad);
        let mut out = Vec::with_capacity((count * 4 * kept) as usize);
        for k in 0..count {
            for h in CORNERS.map(|c| corners[c]) {
                let [x, y] = self.along(h % 4, 0, n);
                let group = (self.sub(h / 4) * count + k) * side * side + y * side + x;
                let at = (group * width) as usize;
                out.extend_from_slice(&weights[at..at + kept as usize]);
            }
        }
        out
    }

    fn uv_rows(&self, quad: u32) -> Option<Rows> {
        let FaceTable { places, table, .. } = self.uv_table(quad)?;
        let of = [table.level, table.count, table.width, table.width];
        Some(Rows {
            weights: self.at_corners(quad, &table.weights, of),
            gathers: places.uvs.iter().map(|&k| self.first_uv + 2 * k).collect(),
        })
    }

    fn color_rows(&self, quad: u32) -> Result<Option<Rows>, GpuError> {
        if self.colors == 0 {
            return Ok(None);
        }
        let own = self.color_table(quad);
        let FaceTable { places, table, .. } = match own {
            Some(own) => own,
            None => self.table(quad)?,
        };
        let of = [table.level, table.columns.len() as u32, table.width, 1];
        let vertices = table.columns.iter().map(|&k| places.vertices[k as usize]);
        Ok(Some(Rows {
            weights: self.at_corners(quad, &table.weights, of),
            gathers: vertices.map(|v| self.first_point + v).collect(),
        }))
    }
}

impl Builder {
    /// Bytes of points, weights and gathers with one more block: no less than what they take.
    pub(super) fn sector_bytes(&self, dicer: &Dicer<'_>, quad: u32) -> Result<[u64; 4], GpuError> {
        let mut quads: Vec<u32> = (dicer.surface.polygon_block(quad).into_iter())
            .flat_map(|h| Self::quads_of(dicer, h / 4))
            .collect();
        quads.sort_unstable();
        quads.dedup();
        let [mut weights, mut gathers] = self.rim_bytes(dicer, &quads)?;
        for rows in [dicer.uv_rows(quad), dicer.color_rows(quad)?] {
            let Some(rows) = rows else { continue };
            weights += 4 * rows.weights.len().next_multiple_of(ALIGNED as usize) as u64;
            gathers += 4 * rows.gathers.len() as u64;
        }
        // Four places, and as many corners.
        let points = u64::from(self.data.points()) + 8;
        Ok([
            points * 4 * u64::from(POINT_FLOATS),
            4 * self.data.weights.len() as u64 + weights,
            4 * self.data.gathers.len() as u64 + gathers,
            0,
        ])
    }

    /// Adds a block.
    pub(super) fn add_sector(
        &mut self,
        dicer: &Dicer<'_>,
        block: &PlannedBlock,
    ) -> Result<(), GpuError> {
        let face = dicer.surface.cage_face(block.quad);
        let mut out = Face {
            row: 2,
            number: dicer.first_face + face,
            material: dicer.object.material(face),
            colors: dicer.colors,
            ..Face::default()
        };
        for (corner, h) in out
            .corners
            .iter_mut()
            .zip(dicer.surface.polygon_block(block.quad))
        {
            *corner = self.corner(dicer, h)?;
        }
        if let Some(rows) = dicer.uv_rows(block.quad) {
            out.uv_count = rows.gathers.len() as u32;
            [out.uv_gather, out.uv_table] = self.add_rows(&rows);
        }
        if let Some(rows) = dicer.color_rows(block.quad)? {
            let count = rows.gathers.len() as u32;
            let [gather, table] = self.add_rows(&rows);
            out.color_stencil = self.data.stencils.len() as u32;
            self.data.stencils.push(Stencil {
                gather,
                count,
                table,
                stride: 4,
            });
        }
        self.add_single(out, block);
        Ok(())
    }

    /// Where the gathers and the weights of rows begin.
    fn add_rows(&mut self, rows: &Rows) -> [u32; 2] {
        let data = &mut self.data;
        let begin = [data.gathers.len(), data.weights.len()].map(|k| k as u32);
        data.gathers.extend_from_slice(&rows.gathers);
        data.weights.extend_from_slice(&rows.weights);
        let aligned = data.weights.len().next_multiple_of(ALIGNED as usize);
        data.weights.resize(aligned, 0.0);
        begin
    }
}
