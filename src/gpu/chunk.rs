//! Chunks of blocks: as many as fit one binding of the device, each with all that dicing them takes, so that no chunk reads from another.
//! A side between two chunks is in both, by the same sums of the same numbers in the same pipeline.

use super::dicer::{Dicer, FaceTable, Owners};
use super::error::GpuError;
use super::plan::{ObjectPlan, PlannedBlock};
use super::records::{Block, Chunk, Face, Move, POINT_FLOATS, Record, Spot, Stencil, words};
use super::wgsl::BLOCK_BITS;
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
    pub(super) patches: bool,
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
            patches: u32::from(self.patches),
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

/// Makes the chunks of a scene.
struct Builder {
    /// Bytes of the largest buffer.
    limit: u64,
    data: ChunkData,
    stencils: HashMap<u32, u32>,
    tables: HashMap<u32, u32>,
    uv_tables: HashMap<u32, u32>,
    corners: HashMap<u32, u32>,
    sides: HashMap<u32, u32>,
    done: Vec<ChunkData>,
}

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
        stencils: HashMap::new(),
        tables: HashMap::new(),
        uv_tables: HashMap::new(),
        corners: HashMap::new(),
        sides: HashMap::new(),
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
        self.stencils.clear();
        self.tables.clear();
        self.uv_tables.clear();
        self.corners.clear();
        self.sides.clear();
    }

    /// Faces that a quad's points come from.
    fn quads_of(dicer: &Dicer<'_>, quad: u32) -> Vec<u32> {
        let whole = dicer.surface.whole_quads();
        let mut all = vec![quad];
        for h in whole.face_halves(quad) {
            for o in [dicer.side_owners(h), dicer.corner_owners(h)] {
                all.extend([whole.face_of(o.position), whole.face_of(o.normal)]);
            }
        }
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Bytes of points, weights and gathers with one more face; the last two alone are kept here.
    fn bytes_with(&self, dicer: &Dicer<'_>, blocks: &[PlannedBlock]) -> Result<[u64; 3], GpuError> {
        let whole = dicer.surface.whole_quads();
        let points: u64 = blocks.iter().map(|b| ((1_u64 << b.log) + 1).pow(2)).sum();
        let mut points = u64::from(self.data.points()) + points;
        for h in whole.face_halves(blocks[0].quad) {
            points += 1_u64 << dicer.side_level(h)?;
        }
        let mut weights = 4 * self.data.weights.len() as u64;
        let mut gathers = 4 * self.data.gathers.len() as u64;
        let mut seen = Vec::new();
        for quad in Self::quads_of(dicer, blocks[0].quad) {
            if self.stencils.contains_key(&quad) {
                continue;
            }
            let FaceTable { number, table, .. } = dicer.table(quad)?;
            gathers += 4 * table.columns.len() as u64;
            if !self.tables.contains_key(&number) && !seen.contains(&number) {
                weights += table.bytes();
                seen.push(number);
            }
        }
        if let Some(FaceTable { number, table, .. }) = dicer.uv_table(blocks[0].quad) {
            gathers += 4 * u64::from(table.count);
            if !self.uv_tables.contains_key(&number) {
                // Tables of points begin at multiples of three.
                weights += table.bytes() + 12;
            }
        }
        Ok([points * 4 * u64::from(POINT_FLOATS), weights, gathers])
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
        let too_large = |bytes: &[u64; 3]| bytes.iter().any(|&b| b > limit);
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
        let [_, weights, gathers] = bytes;
        let had = 4 * (self.data.weights.len() + self.data.gathers.len()) as u64;
        budget.take(WHAT, (weights + gathers - had).into(), 0)?;
        let had = self.data.record_bytes();
        self.add_face(dicer, plan, blocks)?;
        Ok(budget.take(WHAT, self.data.record_bytes() - had, 0)?)
    }

    fn add_face(
        &mut self,
        dicer: &Dicer<'_>,
        plan: &ObjectPlan,
        blocks: &[PlannedBlock],
    ) -> Result<(), GpuError> {
        self.data.triangles = dicer.surface.is_triangular();
        self.data.patches = dicer.patches;
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

    fn face(&mut self, dicer: &Dicer<'_>, quad: u32, reach: u32) -> Result<Face, GpuError> {
        let whole = dicer.surface.whole_quads();
        let (mut corners, mut sides, mut turns) = ([0; 4], [0; 4], 0);
        for (c, h) in whole.face_halves(quad).enumerate() {
            corners[c] = self.corner(dicer, h)?;
            let owners = dicer.side_owners(h);
            let level = dicer.side_level(h)?;
            sides[c] = self.side(dicer, owners, level)?;
            let turned = |owner: u32| owner != h && whole.vertex(owner) != whole.vertex(h);
            let finer = match dicer.patches {
                true => 0,
                false => finer(level, reach)?,
            };
            let ways =
                u32::from(turned(owners.normal)) << 7 | u32::from(turned(owners.position)) << 6;
            turns |= (finer | ways) << (8 * c);
        }
        let cage_face = dicer.surface.cage_face(quad);
        let level = match dicer.patches {
            true => (dicer.drawn_levels.get(&cage_face).copied()).ok_or(GpuError::Missing {
                what: "level of a face",
            })?,
            false => dicer.table(quad)?.table.level,
        };
        let middle = self.middle(dicer, quad)?;
        let (uv_gather, uv_count, uv_table) = self.uv_stencil(dicer, quad);
        Ok(Face {
            corners,
            sides,
            turns,
            stencil: self.stencil(dicer, quad)?,
            row: (1 << level) + 1,
            shift: finer(level, reach)?,
            reach,
            number: dicer.first_face + cage_face,
            // The last material is that of faces without one.
            material: dicer.object.material(cage_face),
            uv_gather,
            uv_count,
            uv_table,
            colors: dicer.colors,
            middle,
        })
    }

    /// The spot in the middle of a quad, where patches need it.
    fn middle(&mut self, dicer: &Dicer<'_>, quad: u32) -> Result<u32, GpuError> {
        if !dicer.patches || dicer.surface.is_triangular() {
            return Ok(0);
        }
        let [stencil, index] = self.place(dicer, quad, [1, 1], 1)?;
        self.data.spots.push(Spot {
            stencil,
            index,
            normal_stencil: stencil,
            normal_index: index,
        });
        Ok(self.data.spots.len() as u32 - 1)
    }

    /// First gather, count and first weight of a quad's texture coordinates; zeros without.
    fn uv_stencil(&mut self, dicer: &Dicer<'_>, quad: u32) -> (u32, u32, u32) {
        let Some(of) = dicer.uv_table(quad) else {
            return (0, 0, 0);
        };
        let (number, table) = (of.number, of.table);
        let weights = &mut self.data.weights;
        let base = *self.uv_tables.entry(number).or_insert_with(|| {
            let base = weights.len() as u32;
            weights.extend_from_slice(&table.weights);
            weights.resize(weights.len().next_multiple_of(3), 0.0);
            base
        });
        let gather = self.data.gathers.len() as u32;
        let own = of.places.uvs.iter().map(|&k| dicer.first_uv + 2 * k);
        self.data.gathers.extend(own);
        (gather, table.count, base + table.offset(dicer.sub(quad)))
    }

    fn stencil(&mut self, dicer: &Dicer<'_>, quad: u32) -> Result<u32, GpuError> {
        if let Some(&found) = self.stencils.get(&quad) {
            return Ok(found);
        }
        let of = dicer.table(quad)?;
        let table = of.table;
        let weights = &mut self.data.weights;
        let base = *self.tables.entry(of.number).or_insert_with(|| {
            let base = weights.len() as u32 / 3;
            weights.extend_from_slice(&table.weights);
            base
        });
        let next = self.data.stencils.len() as u32;
        self.data.stencils.push(Stencil {
            gather: self.data.gathers.len() as u32,
            count: table.columns.len() as u32,
            table: base + table.offset(dicer.sub(quad)),
            stride: table.stride(),
        });
        let own = table
            .columns
            .iter()
            .map(|&k| of.places.vertices[k as usize]);
        self.data.gathers.extend(own.map(|v| v + dicer.first_point));
        self.stencils.insert(quad, next);
        Ok(next)
    }

    /// Stencil and point of a place of a quad, given on the grid of `level`.
    fn place(
        &mut self,
        dicer: &Dicer<'_>,
        quad: u32,
        [x, y]: [u32; 2],
        level: u32,
    ) -> Result<[u32; 2], GpuError> {
        let deep = dicer.table(quad)?.table.level;
        let up = finer(deep, level)?;
        let index = (y << up) * ((1 << deep) + 1) + (x << up);
        Ok([self.stencil(dicer, quad)?, index])
    }

    fn corner(&mut self, dicer: &Dicer<'_>, h: u32) -> Result<u32, GpuError> {
        let owners = dicer.corner_owners(h);
        if let Some(&found) = self.corners.get(&owners.normal) {
            return Ok(found);
        }
        let count = dicer.corner_count();
        let mut of = |h: u32| {
            let at = dicer.along(h % count, 0, 1);
            self.place(dicer, h / count, at, 0)
        };
        let (p, n) = (of(owners.position)?, of(owners.normal)?);
        let at = self.data.spots.len() as u32;
        self.data.spots.push(Spot {
            stencil: p[0],
            index: p[1],
            normal_stencil: n[0],
            normal_index: n[1],
        });
        self.corners.insert(owners.normal, at);
        Ok(at)
    }

    fn side(&mut self, dicer: &Dicer<'_>, owners: Owners, level: u32) -> Result<u32, GpuError> {
        if let Some(&found) = self.sides.get(&owners.normal) {
            return Ok(found);
        }
        let (count, n) = (dicer.corner_count(), 1_u32 << level);
        let whole = dicer.surface.whole_quads();
        let same = owners.position == owners.normal
            || whole.vertex(owners.position) == whole.vertex(owners.normal);
        let first = self.data.spots.len() as u32;
        for k in 1..n {
            let turned = if same { k } else { n - k };
            let at = dicer.along(owners.position % count, turned, n);
            let p = self.place(dicer, owners.position / count, at, level)?;
            let at = dicer.along(owners.normal % count, k, n);
            let own = self.place(dicer, owners.normal / count, at, level)?;
            self.data.spots.push(Spot {
                stencil: p[0],
                index: p[1],
                normal_stencil: own[0],
                normal_index: own[1],
            });
        }
        self.sides.insert(owners.normal, first);
        Ok(first)
    }
}

/// By how many levels `deep` is finer than `level`.
fn finer(deep: u32, level: u32) -> Result<u32, GpuError> {
    deep.checked_sub(level).ok_or(GpuError::Missing {
        what: "table as fine as its face",
    })
}
