//! Chunks of blocks: as many as fit one binding of the device, each with all that dicing them takes, so that no chunk reads from another.
//! A side between two chunks is in both, by the same sums of the same numbers in the same pipeline.

use super::dicer::{Dicer, FaceTable, Look, Shown};
use super::error::GpuError;
use super::plan::{ObjectPlan, PlannedBlock};
use super::records::{Block, Chunk, Face, Lift, Move, POINT_FLOATS, Record, Spot, Stencil, words};
use super::wgsl::{BLOCK_BITS, PN, QAS};
use crate::limits::Budget;
use std::collections::HashMap;

/// Where a block is: in an object's quad, and among the points of its chunk behind the spots.
#[derive(Clone, Copy, Debug)]
pub(super) struct NamedBlock {
    pub(super) quad: u32,
    pub(super) start: [u32; 2],
    pub(super) log: u32,
    pub(super) base: u32,
}

/// A chunk as it goes to the device.
#[derive(Clone, Debug, Default)]
pub(super) struct ChunkData {
    pub(super) stencils: Vec<Stencil>,
    pub(super) gathers: Vec<u32>,
    pub(super) weights: Vec<f32>,
    pub(super) spots: Vec<Spot>,
    pub(super) faces: Vec<Face>,
    pub(super) blocks: Vec<Block>,
    pub(super) moves: Vec<Move>,
    /// Which blocks these are.
    pub(super) named: Vec<NamedBlock>,
    /// Points of blocks alone.
    pub(super) block_points: u32,
    pub(super) quads: u32,
    pub(super) first_rank: u32,
    pub(super) triangles: bool,
    pub(super) shown: Option<Shown>,
    /// What they are drawn with.
    pub(super) look: Look,
    /// See [`Chunk`].
    pub(super) color_width: u32,
    /// Of each spot of a displaced surface.
    pub(super) lifts: Vec<Lift>,
}

impl ChunkData {
    /// Points that it takes: spots, then those of blocks.
    pub(super) fn points(&self) -> u32 {
        self.spots.len() as u32 + self.block_points
    }

    /// Bytes of what is listed here beside weights and gathers.
    fn record_bytes(&self) -> u128 {
        let records = self.spots.len() * Spot::SIZE
            + self.faces.len() * Face::SIZE
            + self.blocks.len() * (Block::SIZE + size_of::<NamedBlock>())
            + self.moves.len() * Move::SIZE
            + self.lifts.len() * Lift::SIZE
            + self.stencils.len() * Stencil::SIZE;
        records as u128
    }

    /// Bytes of all.
    pub(super) fn bytes(&self) -> u128 {
        4 * (self.weights.len() + self.gathers.len()) as u128 + self.record_bytes()
    }

    pub(super) fn record(&self, phase: u32) -> Chunk {
        Chunk {
            first_rank: self.first_rank,
            blocks: self.blocks.len() as u32,
            spots: self.spots.len() as u32,
            phase,
            triangles: u32::from(self.triangles),
            large: self.quads,
            patches: match self.shown {
                Some(Shown::Qas) => QAS,
                Some(Shown::Pn) => PN,
                Some(Shown::Points | Shown::Polygons) | None => 0,
            },
            width: self.look.width,
            uv_width: self.look.uv_width,
            textured: u32::from(self.look.textured),
            tangents: u32::from(self.look.tilted),
            cut: u32::from(self.look.cut),
            color_width: self.color_width,
            shaded: u32::from(self.look.shaded),
            more_padding: [0; 2],
        }
    }

    /// Words of its blocks, which stand behind the spots.
    pub(super) fn block_words(&self) -> Vec<u32> {
        let spots = self.spots.len() as u32;
        let placed = self.blocks.iter().map(|b| Block {
            base: b.base + spots,
            ..*b
        });
        words(&placed.collect::<Vec<_>>())
    }
}

/// Stencils that are listed, by quad, and where their tables begin, by numbers.
#[derive(Default)]
pub(super) struct Listed {
    pub(super) stencils: HashMap<u32, u32>,
    pub(super) tables: HashMap<u32, u32>,
}

/// What a chunk has already.
#[derive(Default)]
pub(super) struct There {
    /// Of a cage's points, by vertex.
    pub(super) points: Listed,
    /// Those of sides alone.
    pub(super) rims: Listed,
    pub(super) colors: Listed,
    /// By quad, and whether they are those of its sides alone.
    pub(super) uvs: HashMap<(u32, bool), [u32; 3]>,
    pub(super) uv_tables: HashMap<u32, u32>,
    pub(super) uv_rims: HashMap<u32, u32>,
    /// Spots, by the half-edge that owns their normals.
    pub(super) corners: HashMap<u32, u32>,
    pub(super) sides: HashMap<u32, u32>,
}

/// Makes the chunks of a scene.
pub(super) struct Builder {
    /// Bytes of the largest buffer.
    limit: u64,
    pub(super) data: ChunkData,
    pub(super) there: There,
    done: Vec<ChunkData>,
}

/// Tables of points begin at multiples of this many words, whatever their width.
pub(super) const ALIGNED: u32 = 6;

/// Most bytes that alignment takes for a table.
const SLACK: u64 = 4 * ALIGNED as u64;

/// Blocks of a chunk that an entry of the list of large quads can name.
const MOST_BLOCKS: usize = 1 << (u32::BITS - 2 * BLOCK_BITS);

/// Chunks of all objects. `limit` is the size of the largest binding in bytes.
pub(super) fn chunks(
    dicers: &[Dicer<'_>],
    plans: &[ObjectPlan],
    limit: u64,
    budget: &mut Budget<'_>,
) -> Result<Vec<ChunkData>, GpuError> {
    let mut builder = Builder {
        limit,
        data: ChunkData::default(),
        there: There::default(),
        done: Vec::new(),
    };
    for (dicer, plan) in dicers.iter().zip(plans) {
        builder.close();
        for blocks in plan.blocks.chunk_by(|a, b| a.quad == b.quad) {
            builder.add(dicer, plan, blocks, budget)?;
        }
    }
    builder.close();
    Ok(builder.done)
}

impl Builder {
    fn close(&mut self) {
        let next = self.data.first_rank + self.data.blocks.len() as u32;
        if !self.data.blocks.is_empty() {
            self.done.push(std::mem::take(&mut self.data));
        }
        self.data.first_rank = next;
        self.there = There::default();
    }

    /// Faces that a quad's points come from.
    pub(super) fn quads_of(dicer: &Dicer<'_>, quad: u32) -> Vec<u32> {
        let whole = dicer.surface.whole_quads();
        let mut all = vec![quad];
        for h in whole.face_halves(quad) {
            all.extend(dicer.sources(h).map(|h| whole.face_of(h)));
        }
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Bytes of weights and gathers of the sides of more quads.
    pub(super) fn rim_bytes(&self, dicer: &Dicer<'_>, quads: &[u32]) -> Result<[u64; 2], GpuError> {
        let (mut weights, mut gathers, mut seen) = (0, 0, Vec::new());
        for &quad in quads {
            if self.there.rims.stencils.contains_key(&quad) {
                continue;
            }
            let FaceTable { number, table, .. } = dicer.table(quad)?;
            gathers += 4 * table.columns.len() as u64;
            if !self.there.rims.tables.contains_key(&number) && !seen.contains(&number) {
                weights += table.rim_bytes() + SLACK;
                seen.push(number);
            }
        }
        Ok([weights, gathers])
    }

    /// Bytes of points, weights, gathers, and what spots take from elsewhere, with one more face; points are not kept here.
    fn bytes_with(&self, dicer: &Dicer<'_>, blocks: &[PlannedBlock]) -> Result<[u64; 4], GpuError> {
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
        }
        points += spots;
        let mut weights = 4 * self.data.weights.len() as u64;
        let mut gathers = 4 * self.data.gathers.len() as u64;
        let own = blocks[0].quad;
        if dicer.shown != Shown::Pn {
            let FaceTable { number, table, .. } = dicer.table(own)?;
            gathers += 4 * table.columns.len() as u64;
            if !self.there.points.tables.contains_key(&number) {
                weights += table.bytes() + SLACK;
            }
            let rims = self.rim_bytes(dicer, &Self::quads_of(dicer, own))?;
            weights += rims[0];
            gathers += rims[1];
        }
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
            // Mitres, a stencil and a place for each.
            let around = dicer.mitred(h);
            let points = 1_u64 << dicer.side_level(h)?;
            gathers += 8 * around.iter().sum::<u64>() * points;
        }
        let lifts = match dicer.is_displaced() {
            true => (self.data.lifts.len() as u64 + spots) * Lift::SIZE as u64,
            false => 0,
        };
        let points = points * 4 * u64::from(POINT_FLOATS);
        Ok([points, weights, gathers, lifts])
    }

    fn add(
        &mut self,
        dicer: &Dicer<'_>,
        plan: &ObjectPlan,
        blocks: &[PlannedBlock],
        budget: &mut Budget<'_>,
    ) -> Result<(), GpuError> {
        /// What memory is taken for.
        const WHAT: &str = "the chunks of the GPU backend";
        let limit = self.limit;
        let too_large = |bytes: &[u64; 4]| bytes.iter().any(|&b| b > limit);
        let mut bytes = self.bytes_with(dicer, blocks)?;
        if too_large(&bytes) || self.data.blocks.len() + blocks.len() > MOST_BLOCKS {
            self.close();
            bytes = self.bytes_with(dicer, blocks)?;
            if too_large(&bytes) {
                return Err(GpuError::OutOfMemory {
                    what: "the points and weights of a face: lower the level",
                });
            }
        }
        let [_, weights, gathers, _] = bytes;
        let had = 4 * (self.data.weights.len() + self.data.gathers.len()) as u64;
        budget.take(WHAT, (weights + gathers - had).into(), 0)?;
        let had = self.data.record_bytes();
        self.data.shown = Some(dicer.shown);
        self.data.look = dicer.look;
        self.data.color_width = dicer.color_width();
        match dicer.shown {
            Shown::Polygons => self.add_polygon(dicer, blocks),
            _ if dicer.polygonal => {
                for block in blocks {
                    self.add_sector(dicer, block)?;
                }
            }
            Shown::Points | Shown::Qas | Shown::Pn => self.add_face(dicer, plan, blocks)?,
        }
        Ok(budget.take(WHAT, self.data.record_bytes() - had, 0)?)
    }

    fn add_face(
        &mut self,
        dicer: &Dicer<'_>,
        plan: &ObjectPlan,
        blocks: &[PlannedBlock],
    ) -> Result<(), GpuError> {
        self.data.triangles = dicer.surface.is_triangular();
        let quad = blocks[0].quad;
        let face = self.face(dicer, quad, plan.reach[quad as usize])?;
        let number = self.data.faces.len() as u32;
        self.data.faces.push(face);
        for b in blocks {
            let up = face.reach - b.level;
            let first = self.data.moves.len() as u32;
            for &[at, x, y] in &plan.moves[b.moves[0] as usize..b.moves[1] as usize] {
                self.data.moves.push(Move {
                    at,
                    x,
                    y,
                    padding: 0,
                });
            }
            self.data.named.push(NamedBlock {
                quad,
                start: b.start,
                log: b.log,
                base: self.data.block_points,
            });
            self.data.blocks.push(Block {
                face: number,
                start_x: b.start[0] << up,
                start_y: b.start[1] << up,
                step: 1 << up,
                log: b.log,
                base: self.data.block_points,
                moves: first,
                move_count: b.moves[1] - b.moves[0],
                level: b.shown,
                padding: [0; 3],
            });
            self.data.block_points += ((1 << b.log) + 1) * ((1 << b.log) + 1);
            self.data.quads += 1 << (2 * b.log);
        }
        Ok(())
    }
}
