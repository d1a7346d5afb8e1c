//! How much room a chunk needs with one more face: no less than what it takes, before anything is listed.

use super::chunk::{ALIGNED, Builder, Listed};
use super::dicer::{Dicer, FaceTable, Shown};
use super::error::GpuError;
use super::plan::{ObjectPlan, PlannedBlock};
use super::records::{Lift, POINT_FLOATS, Record};
use super::tables::Table;
use crate::topology::NONE;
use std::collections::HashSet;

/// Most bytes that alignment takes for a table.
const SLACK: u64 = 4 * ALIGNED as u64;

impl Builder {
    /// Bytes of weights and gathers of the sides of more quads.
    pub(super) fn rim_bytes(&self, dicer: &Dicer<'_>, quads: &[u32]) -> Result<[u64; 2], GpuError> {
        let (mut weights, mut gathers) = (0, 0);
        let mut add = |rims: &Listed, of: &dyn Fn(u32) -> Result<_, GpuError>| {
            let mut seen = Vec::new();
            for &quad in quads.iter().filter(|q| !rims.stencils.contains_key(q)) {
                let FaceTable { number, table, .. }: FaceTable<'_, Table> = of(quad)?;
                gathers += 4 * table.columns.len() as u64;
                if !rims.tables.contains_key(&number) && !seen.contains(&number) {
                    weights += table.rim_bytes() + SLACK;
                    seen.push(number);
                }
            }
            Ok::<_, GpuError>(())
        };
        if !dicer.is_apart() {
            add(&self.there.rims, &|quad| dicer.table(quad))?;
        }
        if dicer.shown == Shown::Qas {
            add(&self.there.base_rims, &|quad| dicer.base_table(quad))?;
        }
        Ok([weights, gathers])
    }

    /// Bytes of the lists of triangles with those of more blocks.
    pub(super) fn list_bytes(&self, plan: &ObjectPlan, blocks: &[PlannedBlock]) -> u64 {
        let mut seen = HashSet::new();
        let is_new = |b: &&PlannedBlock| {
            b.list != NONE && !self.there.lists.contains_key(&b.list) && seen.insert(b.list)
        };
        let new = blocks.iter().filter(is_new);
        let words: usize = new.map(|b| plan.lists[b.list as usize].words.len()).sum();
        4 * (self.data.lists.len() + words) as u64
    }

    /// Bytes of points, weights, gathers, and what spots take from elsewhere, with one more face; points are not kept here.
    pub(super) fn bytes_with(
        &self,
        dicer: &Dicer<'_>,
        blocks: &[PlannedBlock],
    ) -> Result<[u64; 4], GpuError> {
        if dicer.shown == Shown::Polygons {
            return Ok(self.polygon_bytes(dicer, blocks));
        }
        if dicer.polygonal {
            return self.sector_bytes(dicer, blocks[0].quad);
        }
        let whole = dicer.surface.whole_quads();
        let points: u64 = blocks.iter().map(|b| ((1_u64 << b.log) + 1).pow(2)).sum();
        let mut points = u64::from(self.data.points()) + points;
        let mut spots = 0;
        for h in whole.face_halves(blocks[0].quad) {
            spots += 1_u64 << dicer.side_level(h)?;
            if dicer.shown == Shown::Qas {
                // Corners and middles that curves run through, of both sides of a crease and of all around a corner.
                spots += 8 + dicer.mitred(h)[1];
            }
        }
        points += spots;
        let mut weights = 4 * self.data.weights.len() as u64;
        let mut gathers = 4 * self.data.gathers.len() as u64;
        let own = blocks[0].quad;
        let mut whole_tables = Vec::new();
        if !dicer.is_apart() {
            whole_tables.push((&self.there.points, dicer.table(own)?));
        }
        if dicer.shown == Shown::Qas {
            whole_tables.push((&self.there.base, dicer.base_table(own)?));
        }
        for (there, FaceTable { number, table, .. }) in whole_tables {
            gathers += 4 * table.columns.len() as u64;
            if !there.tables.contains_key(&number) {
                weights += table.bytes() + SLACK;
            }
        }
        let rims = self.rim_bytes(dicer, &Self::quads_of(dicer, own))?;
        weights += rims[0];
        gathers += rims[1];
        if let Some(FaceTable { number, table, .. }) = dicer.color_table(own) {
            gathers += 4 * table.columns.len() as u64;
            if !self.there.colors.tables.contains_key(&number) {
                weights += table.bytes() + SLACK;
            }
        }
        if let Some(FaceTable { number, table, .. }) = dicer.uv_table(own) {
            gathers += 4 * u64::from(table.count);
            if !self.there.uv_tables.contains_key(&number) {
                weights += table.bytes() + SLACK;
            }
        }
        if dicer.lifts_by_uvs() {
            let mut seen = Vec::new();
            for quad in Self::quads_of(dicer, own) {
                let Some(FaceTable { number, table, .. }) = dicer.uv_table(quad) else {
                    continue;
                };
                if self.there.uvs.contains_key(&(quad, true)) {
                    continue;
                }
                gathers += 4 * u64::from(table.count);
                if !self.there.uv_rims.contains_key(&number) && !seen.contains(&number) {
                    weights += table.rim_bytes() + SLACK;
                    seen.push(number);
                }
            }
        }
        for h in whole.face_halves(blocks[0].quad) {
            gathers += 4 * dicer.ring_words(h);
            // Mitres, a stencil and a place for each, or a curve.
            let around = dicer.mitred(h);
            let points = 1_u64 << dicer.side_level(h)?;
            gathers += 16 * around.iter().sum::<u64>() * points;
        }
        let lifts = match dicer.is_displaced() {
            true => (self.data.lifts.len() as u64 + spots) * Lift::SIZE as u64,
            false => 0,
        };
        let points = points * 4 * u64::from(POINT_FLOATS);
        Ok([points, weights, gathers, lifts])
    }
}
