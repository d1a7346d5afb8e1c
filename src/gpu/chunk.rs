//! Chunks of blocks: as many as fit one binding of the device, each with all that dicing them takes, so that no chunk reads from another.
//! A side between two chunks is in both, by the same sums of the same numbers in the same pipeline.

use super::deciding::Deciding;
use super::dicer::{Dicer, Look, Shown};
use super::error::GpuError;
use super::lists::PlannedList;
use super::plan::{ObjectPlan, PlannedBlock};
use super::records::{Block, Chunk, Face, Lift, Move, Record, Spot, Stencil, words};
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
    /// What its blocks are decided by, where that is the device; none are listed then, and there is room for as many as it says.
    pub(super) deciding: Option<Deciding>,
    /// Of each spot of a displaced surface.
    pub(super) lifts: Vec<Lift>,
    /// Triangles of blocks that are lists, as [`PlannedList`](super::lists::PlannedList) has them.
    pub(super) lists: Vec<u32>,
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
        4 * (self.weights.len() + self.gathers.len() + self.lists.len()) as u128
            + self.record_bytes()
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
            differences: u32::from(self.look.differences),
            padding: 0,
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
    /// The same of what quadratic patches run through.
    pub(super) base: Listed,
    pub(super) base_rims: Listed,
    pub(super) colors: Listed,
    /// By quad, and whether they are those of its sides alone.
    pub(super) uvs: HashMap<(u32, bool), [u32; 3]>,
    pub(super) uv_tables: HashMap<u32, u32>,
    pub(super) uv_rims: HashMap<u32, u32>,
    /// First weights of faces' control points as B-splines, by the number of their table and that of the quad.
    pub(super) nets: HashMap<[u32; 2], u32>,
    /// Spots, by the half-edge that owns their normals.
    pub(super) corners: HashMap<u32, u32>,
    pub(super) sides: HashMap<u32, u32>,
    /// The same of what quadratic patches run through.
    pub(super) base_corners: HashMap<u32, u32>,
    pub(super) base_sides: HashMap<u32, u32>,
    /// Where lists begin, by their numbers.
    pub(super) lists: HashMap<u32, u32>,
}

/// Makes the chunks of a scene.
pub(super) struct Builder {
    /// Bytes of the largest buffer.
    pub(super) limit: u64,
    pub(super) data: ChunkData,
    pub(super) there: There,
    done: Vec<ChunkData>,
}

/// Tables of points begin at multiples of this many words, whatever their width.
pub(super) const ALIGNED: u32 = 6;

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
        if plan.flatness.is_some() {
            builder.add_deciding(dicer, plan, budget)?;
        }
        for blocks in plan.blocks.chunk_by(|a, b| a.quad == b.quad) {
            builder.add(dicer, plan, blocks, budget)?;
        }
    }
    builder.close();
    Ok(builder.done)
}

impl Builder {
    fn close(&mut self) {
        let room = self.data.deciding.as_ref().map_or(0, |d| d.room.blocks);
        let next = self.data.first_rank + self.data.blocks.len() as u32 + room;
        let data = std::mem::take(&mut self.data);
        if !data.blocks.is_empty() || room > 0 {
            self.done.push(data);
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
        let too_large =
            |bytes: &[u64; 4], lists: u64| bytes.iter().chain([&lists]).any(|&b| b > limit);
        let mut bytes = self.bytes_with(dicer, blocks)?;
        let mut lists = self.list_bytes(plan, blocks);
        if too_large(&bytes, lists) || self.data.blocks.len() + blocks.len() > MOST_BLOCKS {
            self.close();
            bytes = self.bytes_with(dicer, blocks)?;
            lists = self.list_bytes(plan, blocks);
            if too_large(&bytes, lists) {
                return Err(GpuError::OutOfMemory {
                    what: "the points and weights of a face: lower the level",
                });
            }
        }
        let [_, weights, gathers, _] = bytes;
        let data = &self.data;
        let had = 4 * (data.weights.len() + data.gathers.len() + data.lists.len()) as u64;
        budget.take(WHAT, (weights + gathers + lists - had).into(), 0)?;
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
            let listed =
                (plan.lists.get(b.list as usize)).map(|list| (self.list(b.list, list), list));
            let list_count = listed.map_or(0, |(_, list)| list.count);
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
                step: if b.scattered { 0 } else { 1 << up },
                log: b.log,
                base: self.data.block_points,
                moves: first,
                move_count: b.moves[1] - b.moves[0],
                level: b.shown,
                list: listed.map_or(0, |(first, _)| first),
                list_count,
                around: listed.map_or(0, |(first, list)| first + list.around()),
            });
            self.data.block_points += ((1 << b.log) + 1) * ((1 << b.log) + 1);
            self.data.quads += (1 << (2 * b.log)).max(list_count.div_ceil(2));
        }
        Ok(())
    }

    /// Where a list begins, which is added unless it is there.
    fn list(&mut self, number: u32, list: &PlannedList) -> u32 {
        let words = &mut self.data.lists;
        *self.there.lists.entry(number).or_insert_with(|| {
            let first = words.len() as u32;
            words.extend_from_slice(&list.words);
            first
        })
    }
}
