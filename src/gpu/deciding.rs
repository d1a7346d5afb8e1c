//! Objects whose blocks are decided on the device: what stays from view to view. Stage `flatness` works on it (`flatness.rs`).

use super::chunk::{ALIGNED, Builder};
use super::dicer::Dicer;
use super::error::GpuError;
use super::plan::{ObjectPlan, Plan, check};
use super::records::{Block, Edge, Move, POINT_FLOATS, Patch, Record, Room, Spot};
use super::surroundings::Surroundings;
use super::tables::Table;
use super::wgsl::{
    BLOCK_BITS, EDGE_BACK, NODE_WORDS, PART, PATCH_DRAWN, PATCH_PLAIN, PATCH_SPLIT, TREE_DEPTH,
};
use crate::dice::MAX_LEVEL;
use crate::dice::face::Sides;
use crate::frame::{Renderer, Scene};
use crate::limits::Budget;
use crate::records::ScreenSize;
use crate::surface::{QuadPatch, Spline, Surface};
use crate::tessellate::Flatness;
use crate::tessellate::blocks::runs_back;
use crate::topology::NONE;

/// Level of all of its places: that of the deepest blocks that the device decides on.
pub(super) const REACH: u32 = BLOCK_BITS;

/// Most blocks of a face: of the smallest.
const MOST_BLOCKS: u64 = 1 << (2 * TREE_DEPTH);

/// Points of such a block.
const BLOCK_POINTS: u64 = ((1 << (REACH - TREE_DEPTH)) + 1) * ((1 << (REACH - TREE_DEPTH)) + 1);

/// Bytes that a face takes beside its weights, roughly.
const FACE_BYTES: u128 = 512;

/// What the faces of a chunk are decided by.
#[derive(Clone, Debug)]
pub(super) struct Deciding {
    pub(super) flatness: Flatness,
    /// 1 where its cage's faces are split into quads, whose levels are one less.
    pub(super) split: u32,
    pub(super) patches: Vec<Patch>,
    pub(super) edges: Vec<Edge>,
    pub(super) room: Room,
}

impl Deciding {
    /// Bytes of its buffers on the device and of its lists here.
    pub(super) fn bytes(&self) -> u128 {
        let records = self.patches.len() * Patch::SIZE + self.edges.len() * Edge::SIZE;
        let own = self.patches.len() * 4 * (NODE_WORDS as usize + 8) + 4 * self.edges.len();
        (2 * records + own) as u128
    }
}

/// A plan of objects whose blocks the device decides, of these flatnesses.
pub(super) fn plan(
    renderer: &Renderer,
    scene: &Scene,
    flatness: Vec<Flatness>,
    budget: &mut Budget<'_>,
) -> Result<Plan, GpuError> {
    check(renderer, scene)?;
    renderer.check_size()?;
    let mut objects = Vec::new();
    for (object, flatness) in scene.objects.iter().zip(flatness) {
        let surface = &object.surface;
        surface.try_ensure(MAX_LEVEL, budget)?;
        let quads = surface.quads().face_count();
        budget.take("the blocks of the GPU backend", 5 * quads as u128, 0)?;
        let is_drawn = |q: u32| scene.is_drawn(object, surface.cage_face(q));
        objects.push(ObjectPlan {
            reach: vec![REACH; quads],
            flatness: Some(flatness),
            drawn: (0..quads as u32).map(is_drawn).collect(),
            size: Some(renderer.size),
            ..ObjectPlan::default()
        });
    }
    Ok(Plan {
        levels: vec![0; objects.len()],
        objects,
        triangles: 0,
        id_bits: BLOCK_BITS,
        tessellated: true,
    })
}

/// The weights of the control points of a face's quads where they are B-splines, row by row for each local vertex; nothing of others.
pub(super) fn nets(
    whole: &Surface,
    shape: &Surroundings,
) -> Result<Vec<Option<Vec<f32>>>, GpuError> {
    let mut surface = shape.surface(whole);
    let count = shape.vertices.len();
    let subs = if whole.is_split() { shape.size() } else { 1 };
    let mut out = vec![Some(vec![0.0; 16 * count]); subs as usize];
    let mut patch = QuadPatch::default();
    let mut points = vec![[0.0_f32; 3]; surface.control_base().len()];
    for first in (0..count).step_by(3) {
        points.fill([0.0; 3]);
        for k in first..count.min(first + 3) {
            points[k][k - first] = 1.0;
        }
        surface
            .update_points(&points)
            .map_err(|_| GpuError::Missing {
                what: "control points of a face",
            })?;
        for (sub, out) in (0..).zip(&mut out) {
            patch.prepare_points(&surface, sub, 1, None, Sides::Hull);
            match (patch.spline(), &mut *out) {
                (Some(Spline::Quad(net)), Some(weights)) => {
                    for k in first..count.min(first + 3) {
                        for (w, p) in weights[16 * k..].iter_mut().zip(net.as_flattened()) {
                            *w = p[k - first];
                        }
                    }
                }
                _ => *out = None,
            }
        }
    }
    Ok(out)
}

/// What there is room for, in buffers of at most `limit` bytes.
fn room(size: ScreenSize, faces: u64, edges: u64, spots: u64, limit: u64) -> Room {
    let point_bytes = 4 * u64::from(POINT_FLOATS);
    let pixels = u64::from(size.width) * u64::from(size.height);
    let fit = |count: u64, bytes: usize| count.min(limit / bytes as u64) as u32;
    // All that the deepest blocks of all faces take, if that is little; else what pictures ask for, and as much again.
    let points = (MOST_BLOCKS * BLOCK_POINTS * faces).min(64 * faces + 4 * pixels + (1 << 20));
    let points = points.min((limit / point_bytes).saturating_sub(spots));
    let moves = (16 * MOST_BLOCKS * faces).min(32 * faces + 8 * edges + (1 << 16));
    Room {
        blocks: fit(
            (MOST_BLOCKS * faces).min(8 * faces + (1 << 16)),
            Block::SIZE,
        ),
        points: points as u32,
        moves: fit(moves, Move::SIZE),
        quads: fit(points, size_of::<u32>()),
        spots: spots as u32,
        faces: faces as u32,
        parts: faces.div_ceil(PART.into()) as u32,
        padding: 0,
    }
}

impl Builder {
    /// Adds all faces of an object whose blocks the device decides: one chunk.
    pub(super) fn add_deciding(
        &mut self,
        dicer: &Dicer<'_>,
        plan: &ObjectPlan,
        budget: &mut Budget<'_>,
    ) -> Result<(), GpuError> {
        const TOO_LARGE: GpuError = GpuError::OutOfMemory {
            what: "a model whose blocks are decided on the device",
        };
        let (Some(flatness), Some(size)) = (plan.flatness, plan.size) else {
            return Err(GpuError::Missing {
                what: "flatness of an object",
            });
        };
        let surface = dicer.surface;
        let whole = surface.whole_quads();
        let (faces, edges) = (whole.face_count(), whole.edge_count());
        let weights = |t: &Table| t.bytes() + t.rim_bytes();
        let weights = dicer.tables.iter().map(weights).sum::<u64>()
            + (dicer.uv_tables.iter().map(|t| t.bytes()).sum::<u64>())
            + (dicer.color_tables.iter().map(Table::bytes).sum::<u64>());
        // Both sides of an edge may have spots of their own.
        let spots = (2 * edges as u64) << REACH;
        // Sums of what faces ask for are of 32 bits.
        let sums = MOST_BLOCKS * BLOCK_POINTS * faces as u64;
        if weights.max(spots * Spot::SIZE as u64) > self.limit || sums > u32::MAX.into() {
            return Err(TOO_LARGE);
        }
        let spot_bytes = u128::from(spots) * Spot::SIZE as u128;
        budget.take(
            "the chunks of the GPU backend",
            u128::from(weights) + spot_bytes + FACE_BYTES * faces as u128,
            0,
        )?;
        self.data.shown = Some(dicer.shown);
        self.data.look = dicer.look;
        self.data.color_width = dicer.color_width();
        let mut patches = Vec::with_capacity(faces);
        let mut patch = QuadPatch::default();
        let split = u32::from(surface.is_split());
        for q in 0..faces as u32 {
            if q % 1024 == 0 {
                budget.limits().check()?;
            }
            let face = self.face(dicer, q, REACH)?;
            self.data.faces.push(face);
            patch.prepare_points(surface, q, 1, None, Sides::Hull);
            let net = match patch.spline() {
                Some(_) => self.net(dicer, q)?,
                None => NONE,
            };
            let is_plain = patch.has_plain_sides();
            let irregular = match is_plain {
                true => surface.irregular_corners(q),
                // What control levels below hold is not known before.
                false => [true; 4],
            };
            let mut marks = (0..4).fold(0, |m, c| m | u32::from(irregular[c]) << c);
            for (is, mark) in [
                (is_plain, PATCH_PLAIN),
                (plan.drawn[q as usize], PATCH_DRAWN),
                (split > 0, PATCH_SPLIT),
            ] {
                marks |= if is { mark } else { 0 };
            }
            let mut sides = [0; 4];
            for (side, h) in sides.iter_mut().zip(whole.face_halves(q)) {
                *side = 2 * whole.edge(h) + u32::from(runs_back(whole, h));
            }
            patches.push(Patch {
                edges: sides,
                net,
                marks,
                padding: [0; 2],
            });
        }
        let edge = |e: u32| {
            let first = whole.edge_half(e);
            let twin = whole.twin(first);
            let mut edge = Edge {
                first: whole.face_of(first),
                second: NONE,
                marks: first % 4,
                padding: 0,
            };
            if twin != NONE {
                edge.second = whole.face_of(twin);
                edge.marks |= (twin % 4) << 2;
                edge.marks |= if runs_back(whole, twin) { EDGE_BACK } else { 0 };
            }
            edge
        };
        let edges: Vec<Edge> = (0..edges as u32).map(edge).collect();
        let spots = self.data.spots.len() as u64;
        let mut room = room(size, faces as u64, edges.len() as u64, spots, self.limit);
        // Ids number blocks, and a row, a column and a half of each.
        let most = (u32::MAX >> (2 * BLOCK_BITS + 1)).saturating_sub(self.data.first_rank);
        room.blocks = room.blocks.min(most);
        if room.blocks == 0 && faces > 0 {
            return Err(TOO_LARGE);
        }
        if let Some(most) = budget.limits().max_faces {
            room.quads = u64::from(room.quads).min(most) as u32;
        }
        let deciding = Deciding {
            flatness,
            split,
            patches,
            edges,
            room,
        };
        let largest = [
            4 * u64::from(POINT_FLOATS) * spots,
            4 * self.data.weights.len() as u64,
            4 * self.data.gathers.len() as u64,
            4 * u64::from(NODE_WORDS) * faces as u64,
        ];
        if largest.iter().any(|&bytes| bytes > self.limit) {
            return Err(TOO_LARGE);
        }
        budget.take("the chunks of the GPU backend", deciding.bytes(), 0)?;
        self.data.block_points = room.points;
        self.data.quads = room.quads;
        self.data.deciding = Some(deciding);
        Ok(())
    }

    /// First weight of a quad's control points as a B-spline.
    fn net(&mut self, dicer: &Dicer<'_>, quad: u32) -> Result<u32, GpuError> {
        let of = dicer.table(quad)?;
        let sub = dicer.sub(quad);
        let found = dicer
            .nets
            .get(of.number as usize)
            .and_then(|n| n.get(sub as usize));
        let Some(Some(net)) = found else {
            return Ok(NONE);
        };
        let weights = &mut self.data.weights;
        let first = *self.there.nets.entry([of.number, sub]).or_insert_with(|| {
            let first = weights.len() as u32;
            for &k in &of.table.columns {
                weights.extend_from_slice(&net[16 * k as usize..16 * (k as usize + 1)]);
            }
            weights.resize(weights.len().next_multiple_of(ALIGNED as usize), 0.0);
            first
        });
        Ok(first)
    }
}
