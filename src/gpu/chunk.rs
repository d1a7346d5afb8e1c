//! Chunks of blocks: as many as fit one binding of the device, each with all that dicing them takes, so that no chunk reads from another.
//! A side between two chunks is in both, by the same sums of the same numbers in the same pipeline.

use super::error::GpuError;
use super::plan::ObjectPlan;
use super::records::{Block, Chunk, Face, Move, POINT_FLOATS, Record, Spot, Stencil, words};
use super::surroundings::{Finder, Surroundings};
use super::tables::{self, Table, UvTable};
use crate::frame::{Object, Scene};
use crate::limits::Limits;
use crate::patch::PatchKind;
use crate::scheme::Scheme;
use crate::surface::Surface;
use crate::topology::NONE;
use std::collections::HashMap;

/// An object with the tables of its faces.
pub(super) struct Dicer<'a> {
    object: &'a Object,
    surface: &'a Surface,
    /// First of its control points among those of the scene.
    first_point: u32,
    first_face: u32,
    /// Per cage face with a table: its surroundings, and the number of its shape.
    faces: HashMap<u32, (Surroundings, u32)>,
    tables: Vec<Table>,
    /// Per face of the cage the number of its shape with texture coordinates; empty without.
    uv_shapes: HashMap<u32, u32>,
    uv_tables: Vec<UvTable>,
    /// First of the object's texture coordinates among the control numbers.
    first_uv: u32,
    /// See [`Face::colors`].
    colors: u32,
    /// Whether faces are quadratic patches: nothing of the surface itself is known beyond level 1 then.
    patches: bool,
    /// Per face of the cage that is drawn, its deepest level.
    drawn_levels: HashMap<u32, u32>,
    /// Per edge of the whole quads, the level of the points on it; [`NONE`] where nothing is drawn.
    edge_levels: Vec<u32>,
}

/// The half-edges whose faces give a side its points, and its normals.
#[derive(Clone, Copy)]
struct Owners {
    position: u32,
    normal: u32,
}

impl<'a> Dicer<'a> {
    pub(super) fn new(
        object: &'a Object,
        plan: &ObjectPlan,
        [first_point, first_face, first_uv, first_color]: [u32; 4],
        wants_uvs: bool,
        limits: &Limits,
    ) -> Result<Self, GpuError> {
        let surface = &object.surface;
        let mut dicer = Self {
            object,
            surface,
            first_point,
            first_face,
            faces: HashMap::new(),
            tables: Vec::new(),
            uv_shapes: HashMap::new(),
            uv_tables: Vec::new(),
            first_uv,
            patches: surface.patch_kind() == PatchKind::Qas,
            drawn_levels: HashMap::new(),
            // Control points come first, so a place after them is above this product.
            colors: match surface.cage().colors().is_empty() {
                true => 0,
                false => first_color - 3 * first_point,
            },
            edge_levels: vec![NONE; surface.whole_quads().edge_count()],
        };
        dicer.check()?;
        let needs = dicer.needs(plan);
        dicer.make_tables(&needs, limits)?;
        if wants_uvs && surface.has_uvs() {
            dicer.make_uv_tables(limits)?;
        }
        Ok(dicer)
    }

    /// Tables grow with the faces around a vertex, and with the corners of a face.
    fn check(&self) -> Result<(), GpuError> {
        let t = self.surface.topology();
        let most = t.fans().iter().map(|f| f.faces).max().unwrap_or(0);
        let corners = (0..t.face_count() as u32).map(|f| t.face_halves(f).len() as u32);
        if most.max(corners.max().unwrap_or(0)) > MOST_AROUND {
            return Err(GpuError::Unsupported {
                what: "vertices of more than 512 faces, or faces of as many corners",
            });
        }
        Ok(())
    }

    /// Levels that faces of the cage have to be known at: their own blocks', and those of sides and corners that they own.
    fn needs(&mut self, plan: &ObjectPlan) -> Vec<u32> {
        let whole = self.surface.whole_quads();
        for (quad, &reach) in plan.reach.iter().enumerate() {
            if reach == NONE {
                continue;
            }
            let face = self.surface.cage_face(quad as u32);
            let deepest = self.drawn_levels.entry(face).or_insert(reach);
            *deepest = reach.max(*deepest);
            let reach = if self.patches { 1 } else { reach };
            for h in whole.face_halves(quad as u32) {
                let level = &mut self.edge_levels[whole.edge(h) as usize];
                *level = if *level == NONE {
                    reach
                } else {
                    reach.max(*level)
                };
            }
        }
        let mut needs = vec![NONE; self.surface.topology().face_count()];
        let mut ask = |quad: u32, level: u32| {
            let need = &mut needs[self.surface.cage_face(quad) as usize];
            *need = if *need == NONE {
                level
            } else {
                level.max(*need)
            };
        };
        for (quad, &reach) in plan.reach.iter().enumerate() {
            if reach == NONE {
                continue;
            }
            ask(quad as u32, if self.patches { 1 } else { reach });
            for h in whole.face_halves(quad as u32) {
                let level = self.edge_levels[whole.edge(h) as usize];
                for owners in [self.side_owners(h), self.corner_owners(h)] {
                    ask(whole.face_of(owners.position), level);
                    ask(whole.face_of(owners.normal), level);
                }
            }
        }
        needs
    }

    fn make_tables(&mut self, needs: &[u32], limits: &Limits) -> Result<(), GpuError> {
        let finder = Finder::new(self.surface);
        let mut numbers: HashMap<Vec<u32>, u32> = HashMap::new();
        let mut shapes: Vec<(Surroundings, u32)> = Vec::new();
        for (face, &need) in needs.iter().enumerate() {
            if need == NONE {
                continue;
            }
            if face % 1024 == 0 {
                limits.check()?;
            }
            let found = finder.find(face as u32);
            let next = shapes.len() as u32;
            let number = *numbers.entry(found.key()).or_insert(next);
            if number == next {
                shapes.push((found.clone(), need));
            } else {
                let level = &mut shapes[number as usize].1;
                *level = need.max(*level);
            }
            self.faces.insert(face as u32, (found, number));
        }
        self.tables = tables::make(self.surface, &shapes, limits)?;
        Ok(())
    }

    /// Tables of texture coordinates, as fine as those of points.
    fn make_uv_tables(&mut self, limits: &Limits) -> Result<(), GpuError> {
        let mut numbers: HashMap<(Vec<u32>, u32), u32> = HashMap::new();
        let mut shapes: Vec<(Surroundings, u32)> = Vec::new();
        let mut faces: Vec<u32> = self.drawn_levels.keys().copied().collect();
        faces.sort_unstable();
        for face in faces {
            let Some((shape, number)) = self.faces.get(&face) else {
                continue;
            };
            let level = match self.patches {
                true => self.drawn_levels[&face],
                false => self.tables[*number as usize].level,
            };
            let next = shapes.len() as u32;
            let number = *numbers.entry((shape.uv_key(), level)).or_insert(next);
            if number == next {
                shapes.push((shape.clone(), level));
            }
            self.uv_shapes.insert(face, number);
        }
        self.uv_tables = tables::make_uvs(self.surface, &shapes, limits)?;
        Ok(())
    }

    /// Whose points a side has: those of the edge's first half-edge; normals are one's own along creases and borders.
    fn side_owners(&self, h: u32) -> Owners {
        let (whole, cut) = (self.surface.whole_quads(), self.surface.quads());
        let twin = cut.twin(h);
        let own = twin == NONE || self.is_faceted();
        Owners {
            position: whole.edge_half(whole.edge(h)),
            normal: if own { h } else { h.min(twin) },
        }
    }

    /// The same of a corner: the first half-edge around.
    fn corner_owners(&self, h: u32) -> Owners {
        let (whole, cut) = (self.surface.whole_quads(), self.surface.quads());
        let first = |found: u32| if found == NONE { h } else { found };
        Owners {
            position: first(whole.fans()[whole.fan(h) as usize].first),
            normal: match self.is_faceted() {
                true => h,
                false => first(cut.fans()[cut.fan(h) as usize].first),
            },
        }
    }

    /// Whether every face has normals of its own all around.
    fn is_faceted(&self) -> bool {
        self.surface.scheme() == Scheme::Bilinear
    }

    fn table(&self, quad: u32) -> Option<(&Surroundings, u32, &Table)> {
        let (shape, number) = self.faces.get(&self.surface.cage_face(quad))?;
        Some((shape, *number, &self.tables[*number as usize]))
    }

    /// Quad `quad` among those of its cage face.
    fn sub(&self, quad: u32) -> u32 {
        if self.surface.is_split() {
            let face = self.surface.cage_face(quad);
            quad - self.surface.topology().face_halves(face).start
        } else {
            0
        }
    }

    fn corner_count(&self) -> u32 {
        if self.surface.is_triangular() { 3 } else { 4 }
    }

    /// Column and row of the point `k` of `n` along side `c`.
    fn along(&self, c: u32, k: u32, n: u32) -> [u32; 2] {
        if self.surface.is_triangular() {
            return [[k, 0], [n, k], [n - k, n - k]][c as usize];
        }
        [[k, 0], [n, k], [n - k, n], [0, n - k]][c as usize]
    }

    /// Number of shapes, and bytes of their tables.
    pub(super) fn table_size(&self) -> (usize, u64) {
        let bytes = self.tables.iter().map(Table::bytes).sum();
        (self.tables.len(), bytes)
    }
}

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

    /// Bytes that it takes here.
    fn bytes(&self) -> u128 {
        let words = self.weights.len() + self.gathers.len();
        let records = self.spots.len() * Spot::SIZE
            + self.faces.len() * Face::SIZE
            + self.blocks.len() * (Block::SIZE + size_of::<NamedBlock>())
            + self.moves.len() * Move::SIZE
            + self.stencils.len() * Stencil::SIZE;
        (4 * words + records) as u128
    }

    pub(super) fn record(&self, phase: u32, groups: u32) -> Chunk {
        Chunk {
            first_rank: self.first_rank,
            blocks: self.blocks.len() as u32,
            spots: self.spots.len() as u32,
            phase,
            groups,
            triangles: u32::from(self.triangles),
            large: self.quads,
            patches: u32::from(self.patches),
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
    /// Of all chunks that are done.
    bytes: u128,
    stencils: HashMap<u32, u32>,
    tables: HashMap<u32, u32>,
    uv_tables: HashMap<u32, u32>,
    corners: HashMap<u32, u32>,
    sides: HashMap<u32, u32>,
    done: Vec<ChunkData>,
}

/// Most faces around a vertex, and corners of a face.
const MOST_AROUND: u32 = 512;
/// Blocks of a chunk that an entry of the list of large quads can name.
const MOST_BLOCKS: usize = 1 << 22;

/// Chunks of all objects. `limit` is the size of the largest binding in bytes.
pub(super) fn chunks(
    scene: &Scene,
    dicers: &[Dicer<'_>],
    plans: &[ObjectPlan],
    limit: u64,
    limits: &Limits,
) -> Result<Vec<ChunkData>, GpuError> {
    let mut builder = Builder {
        limit,
        data: ChunkData::default(),
        bytes: 0,
        stencils: HashMap::new(),
        tables: HashMap::new(),
        uv_tables: HashMap::new(),
        corners: HashMap::new(),
        sides: HashMap::new(),
        done: Vec::new(),
    };
    for ((dicer, plan), _) in dicers.iter().zip(plans).zip(&scene.objects) {
        builder.close(limits)?;
        for blocks in plan.blocks.chunk_by(|a, b| a.quad == b.quad) {
            builder.add(dicer, plan, blocks, limits)?;
        }
    }
    builder.close(limits)?;
    Ok(builder.done)
}

impl Builder {
    fn close(&mut self, limits: &Limits) -> Result<(), GpuError> {
        limits.check()?;
        self.bytes += self.data.bytes();
        limits.memory("the chunks of the GPU backend", self.bytes)?;
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
        Ok(())
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

    /// Bytes of points and weights with one more face.
    fn bytes_with(&self, dicer: &Dicer<'_>, blocks: &[super::plan::PlannedBlock]) -> [u64; 3] {
        let whole = dicer.surface.whole_quads();
        let points: u64 = blocks.iter().map(|b| ((1_u64 << b.log) + 1).pow(2)).sum();
        let sides = whole.face_halves(blocks[0].quad).map(|h| {
            let level = dicer.edge_levels[whole.edge(h) as usize];
            1_u64 << level.min(31)
        });
        let points = u64::from(self.data.points()) + points + sides.sum::<u64>();
        let mut weights = 4 * self.data.weights.len() as u64;
        let mut gathers = 4 * self.data.gathers.len() as u64;
        let mut seen = Vec::new();
        for quad in Self::quads_of(dicer, blocks[0].quad) {
            if let Some((_, number, table)) = dicer.table(quad) {
                gathers += 4 * table.columns.len() as u64;
                if !self.tables.contains_key(&number) && !seen.contains(&number) {
                    weights += table.bytes();
                    seen.push(number);
                }
            }
        }
        let face = dicer.surface.cage_face(blocks[0].quad);
        if let Some(&number) = dicer.uv_shapes.get(&face) {
            let table = &dicer.uv_tables[number as usize];
            gathers += 4 * u64::from(table.count);
            if !self.uv_tables.contains_key(&number) {
                // Tables of points begin at multiples of three.
                weights += table.bytes() + 12;
            }
        }
        [points * 4 * u64::from(POINT_FLOATS), weights, gathers]
    }

    fn add(
        &mut self,
        dicer: &Dicer<'_>,
        plan: &ObjectPlan,
        blocks: &[super::plan::PlannedBlock],
        limits: &Limits,
    ) -> Result<(), GpuError> {
        let too_large = |bytes: &[u64; 3]| bytes.iter().any(|&b| b > self.limit);
        if too_large(&self.bytes_with(dicer, blocks))
            || self.data.blocks.len() + blocks.len() > MOST_BLOCKS
        {
            self.close(limits)?;
            let bytes = self.bytes_with(dicer, blocks);
            if bytes.iter().any(|&b| b > self.limit) {
                return Err(GpuError::OutOfMemory {
                    what: "the points and weights of a face: lower the level",
                });
            }
        }
        self.data.triangles = dicer.surface.is_triangular();
        self.data.patches = dicer.patches;
        let quad = blocks[0].quad;
        let face = self.face(dicer, quad, plan.reach[quad as usize]);
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
                first_quad: self.data.quads,
                padding: [0; 2],
            });
            self.data.block_points += ((1 << b.log) + 1) * ((1 << b.log) + 1);
            self.data.quads += 1 << (2 * b.log);
        }
        Ok(())
    }

    fn face(&mut self, dicer: &Dicer<'_>, quad: u32, reach: u32) -> Face {
        let whole = dicer.surface.whole_quads();
        let (mut corners, mut sides, mut turns) = ([0; 4], [0; 4], 0);
        for (c, h) in whole.face_halves(quad).enumerate() {
            corners[c] = self.corner(dicer, h);
            let owners = dicer.side_owners(h);
            let level = dicer.edge_levels[whole.edge(h) as usize];
            sides[c] = self.side(dicer, owners, level);
            let turned = |owner: u32| owner != h && whole.vertex(owner) != whole.vertex(h);
            let finer = if dicer.patches { 0 } else { level - reach };
            let ways =
                u32::from(turned(owners.normal)) << 7 | u32::from(turned(owners.position)) << 6;
            turns |= (finer | ways) << (8 * c);
        }
        let cage_face = dicer.surface.cage_face(quad);
        let level = match dicer.patches {
            true => dicer.drawn_levels.get(&cage_face).copied(),
            false => dicer.table(quad).map(|(_, _, t)| t.level),
        };
        let level = level.unwrap_or(reach);
        let middle = self.middle(dicer, quad);
        let (uv_gather, uv_count, uv_table) = self.uv_stencil(dicer, quad);
        Face {
            corners,
            sides,
            turns,
            stencil: self.stencil(dicer, quad),
            row: (1 << level) + 1,
            shift: level - reach,
            reach,
            number: dicer.first_face + cage_face,
            // The last material is that of faces without one.
            material: dicer.object.material(cage_face),
            uv_gather,
            uv_count,
            uv_table,
            colors: dicer.colors,
            middle,
        }
    }

    /// The spot in the middle of a quad, where patches need it.
    fn middle(&mut self, dicer: &Dicer<'_>, quad: u32) -> u32 {
        if !dicer.patches || dicer.surface.is_triangular() {
            return 0;
        }
        let [stencil, index] = self.place(dicer, quad, [1, 1], 1);
        self.data.spots.push(Spot {
            stencil,
            index,
            normal_stencil: stencil,
            normal_index: index,
        });
        self.data.spots.len() as u32 - 1
    }

    /// First gather, count and first weight of a quad's texture coordinates; zeros without.
    fn uv_stencil(&mut self, dicer: &Dicer<'_>, quad: u32) -> (u32, u32, u32) {
        let face = dicer.surface.cage_face(quad);
        let Some(&number) = dicer.uv_shapes.get(&face) else {
            return (0, 0, 0);
        };
        let Some((shape, _)) = dicer.faces.get(&face) else {
            return (0, 0, 0);
        };
        let table = &dicer.uv_tables[number as usize];
        let weights = &mut self.data.weights;
        let base = *self.uv_tables.entry(number).or_insert_with(|| {
            let base = weights.len() as u32;
            weights.extend_from_slice(&table.weights);
            weights.resize(weights.len().next_multiple_of(3), 0.0);
            base
        });
        let gather = self.data.gathers.len() as u32;
        let own = shape.uvs.iter().map(|&k| dicer.first_uv + 2 * k);
        self.data.gathers.extend(own);
        (gather, table.count, base + table.offset(dicer.sub(quad)))
    }

    fn stencil(&mut self, dicer: &Dicer<'_>, quad: u32) -> u32 {
        if let Some(&found) = self.stencils.get(&quad) {
            return found;
        }
        let mut stencil = Stencil::default();
        if let Some((shape, number, table)) = dicer.table(quad) {
            let weights = &mut self.data.weights;
            let base = *self.tables.entry(number).or_insert_with(|| {
                let base = weights.len() as u32 / 3;
                weights.extend_from_slice(&table.weights);
                base
            });
            stencil = Stencil {
                gather: self.data.gathers.len() as u32,
                count: table.columns.len() as u32,
                table: base + table.offset(dicer.sub(quad)),
                stride: table.stride(),
            };
            let own = table.columns.iter().map(|&k| shape.vertices[k as usize]);
            self.data.gathers.extend(own.map(|v| v + dicer.first_point));
        }
        let next = self.data.stencils.len() as u32;
        self.data.stencils.push(stencil);
        self.stencils.insert(quad, next);
        next
    }

    /// Stencil and point of a place of a quad, given on the grid of `level`.
    fn place(&mut self, dicer: &Dicer<'_>, quad: u32, [x, y]: [u32; 2], level: u32) -> [u32; 2] {
        let deep = dicer.table(quad).map_or(level, |(_, _, t)| t.level);
        let up = deep - level;
        let index = (y << up) * ((1 << deep) + 1) + (x << up);
        [self.stencil(dicer, quad), index]
    }

    fn corner(&mut self, dicer: &Dicer<'_>, h: u32) -> u32 {
        let owners = dicer.corner_owners(h);
        if let Some(&found) = self.corners.get(&owners.normal) {
            return found;
        }
        let count = dicer.corner_count();
        let [p, n] = [owners.position, owners.normal].map(|h| {
            let at = dicer.along(h % count, 0, 1);
            self.place(dicer, h / count, at, 0)
        });
        let at = self.data.spots.len() as u32;
        self.data.spots.push(Spot {
            stencil: p[0],
            index: p[1],
            normal_stencil: n[0],
            normal_index: n[1],
        });
        self.corners.insert(owners.normal, at);
        at
    }

    fn side(&mut self, dicer: &Dicer<'_>, owners: Owners, level: u32) -> u32 {
        if let Some(&found) = self.sides.get(&owners.normal) {
            return found;
        }
        let (count, n) = (dicer.corner_count(), 1_u32 << level);
        let whole = dicer.surface.whole_quads();
        let same = owners.position == owners.normal
            || whole.vertex(owners.position) == whole.vertex(owners.normal);
        let first = self.data.spots.len() as u32;
        for k in 1..n {
            let turned = if same { k } else { n - k };
            let at = dicer.along(owners.position % count, turned, n);
            let p = self.place(dicer, owners.position / count, at, level);
            let at = dicer.along(owners.normal % count, k, n);
            let own = self.place(dicer, owners.normal / count, at, level);
            self.data.spots.push(Spot {
                stencil: p[0],
                index: p[1],
                normal_stencil: own[0],
                normal_index: own[1],
            });
        }
        self.sides.insert(owners.normal, first);
        first
    }
}
