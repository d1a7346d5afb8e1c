//! Which blocks of which faces are drawn: a uniform level, or what adaptive tessellation decided. Decided on the processor, once per view
//! where it follows the picture.

use super::error::GpuError;
use super::lists::{self, PlannedList};
use super::wgsl::BLOCK_BITS;
use crate::camera::View;
use crate::dice::FacePatch;
use crate::frame::{Drawing, Object, Renderer, Scene, leaf_triangles};
use crate::limits::Budget;
use crate::records::ScreenSize;
use crate::scheme::Scheme;
use crate::tessellate::{Flatness, Tessellation};
use crate::topology::NONE;
use std::collections::{HashMap, HashSet};

/// A block of a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlannedBlock {
    /// Of the cage as it is, a face.
    pub(super) quad: u32,
    /// First point, on the grid of `level`; of a cage's face, the number of its block.
    pub(super) start: [u32; 2],
    pub(super) level: u32,
    pub(super) log: u32,
    /// Level that it shows, of the cage.
    pub(super) shown: u32,
    /// Moved points, in [`ObjectPlan::moves`]; places of all points of a block that is no grid.
    pub(super) moves: [u32; 2],
    /// Whether it is no grid.
    pub(super) scattered: bool,
    /// The list of triangles that it is, of [`ObjectPlan::lists`], or [`NONE`].
    pub(super) list: u32,
}

/// What is drawn of an object: blocks in order of their faces.
#[derive(Clone, Debug, Default)]
pub(super) struct ObjectPlan {
    /// Per quad the level that places are given in, or [`NONE`] where it is not drawn.
    pub(super) reach: Vec<u32>,
    pub(super) blocks: Vec<PlannedBlock>,
    /// Point in the block, row by row, and where it is on the face's reach.
    pub(super) moves: Vec<[u32; 3]>,
    pub(super) lists: Vec<PlannedList>,
    /// Whether it is level 0 of a cage with other polygons than quads: quads are blocks of their corners, other polygons one for each
    /// corner, with their centre.
    pub(super) polygonal: bool,
    /// What blocks are decided by where that is the device: then none are listed, but which quads are left out of all pictures, and the
    /// size of those.
    pub(super) flatness: Option<Flatness>,
    pub(super) drawn: Vec<bool>,
    pub(super) size: Option<ScreenSize>,
}

/// What is drawn of a scene.
#[derive(Clone, Debug, Default)]
pub(super) struct Plan {
    pub(super) objects: Vec<ObjectPlan>,
    /// Level of every object; of tessellated ones, their deepest.
    pub(super) levels: Vec<u32>,
    pub(super) triangles: u64,
    /// Bits of rows and columns in ids.
    pub(super) id_bits: u32,
    /// Whether blocks follow the view.
    pub(super) tessellated: bool,
}

/// Refuses what this backend does not draw.
pub(super) fn check(renderer: &Renderer, scene: &Scene) -> Result<(), GpuError> {
    let refuse = |what| Err(GpuError::Unsupported { what });
    for object in &scene.objects {
        if renderer.drawing == Drawing::Cage {
            continue;
        }
        let displacement = object.surface.displacement();
        if displacement.is_some_and(|d| d.source().is_none()) {
            return refuse("displacement by a rule of the caller's");
        }
    }
    Ok(())
}

/// How much is drawn of an object, before there is room for it.
#[derive(Clone, Copy, Debug, Default)]
struct Extent {
    quads: u64,
    blocks: u64,
    moves: u64,
    triangles: u64,
    list_bytes: u64,
    /// Micro-quads along the longest block, as a power of two.
    log: u32,
}

impl Extent {
    /// Bytes of its plan.
    fn bytes(&self) -> u128 {
        let bytes = |count: u64, size: usize| u128::from(count) * size as u128;
        bytes(self.quads, size_of::<u32>())
            + bytes(self.blocks, size_of::<PlannedBlock>())
            + bytes(self.moves, size_of::<[u32; 3]>())
            + u128::from(self.list_bytes)
    }
}

/// What is drawn of every object of a scene. Faces, numbers and memory are counted before anything is listed.
pub(super) fn plan(
    renderer: &Renderer,
    scene: &Scene,
    view: &View,
    budget: &mut Budget<'_>,
) -> Result<Plan, GpuError> {
    check(renderer, scene)?;
    let (levels, tessellations) = renderer.decide(scene, view, budget)?;
    let mut extents = Vec::new();
    for ((object, &level), found) in scene.objects.iter().zip(&levels).zip(&tessellations) {
        extents.push(match found {
            Some(found) => tessellated_extent(object, found),
            None if renderer.drawing == Drawing::Cage => cage_extent(scene, object),
            None => uniform_extent(scene, object, level)?,
        });
    }
    let triangles: u64 = extents.iter().map(|e| e.triangles).sum();
    renderer.limits.faces(u128::from(triangles) / 2)?;
    let id_bits = id_bits(&extents)?;
    let bytes = extents.iter().map(Extent::bytes).sum();
    budget.take("the blocks of the GPU backend", bytes, 0)?;
    let mut objects = Vec::new();
    for ((object, &level), found) in scene.objects.iter().zip(&levels).zip(&tessellations) {
        objects.push(match found {
            Some(found) => tessellated(object, found),
            None if renderer.drawing == Drawing::Cage => polygons(scene, object, level),
            None => uniform(scene, object, level),
        });
    }
    Ok(Plan {
        objects,
        levels,
        triangles,
        id_bits,
        tessellated: tessellations.iter().any(Option::is_some),
    })
}

/// Bits of rows and columns in ids.
fn id_bits(extents: &[Extent]) -> Result<u32, GpuError> {
    let bits = extents.iter().map(|e| e.log).max().unwrap_or(0);
    let count: u64 = extents.iter().map(|e| e.blocks).sum();
    if u128::from(count) << (2 * bits + 1) > u128::from(u32::MAX) {
        return Err(GpuError::OutOfMemory {
            what: "the numbers of more than 4 thousand million micro-triangles: lower the level",
        });
    }
    Ok(bits)
}

/// Quads of an object that are drawn.
fn drawn_quads<'a>(scene: &'a Scene, object: &'a Object) -> impl Iterator<Item = u32> + 'a {
    let surface = &object.surface;
    let quads = 0..surface.quads().face_count() as u32;
    quads.filter(move |&q| scene.is_drawn(object, surface.cage_face(q)))
}

fn uniform_extent(scene: &Scene, object: &Object, level: u32) -> Result<Extent, GpuError> {
    let surface = &object.surface;
    if surface.is_polygonal(level) {
        if surface.scheme() == Scheme::Bilinear {
            return Err(GpuError::Unsupported {
                what: "polygons of other than four corners at level 0 of bilinear surfaces",
            });
        }
        let blocks = drawn_quads(scene, object).filter(|&q| surface.stands_for_face(q));
        let blocks = blocks.count() as u64;
        return Ok(Extent {
            quads: surface.quads().face_count() as u64,
            blocks,
            triangles: 2 * blocks,
            ..Extent::default()
        });
    }
    let quad_level = level.saturating_sub(u32::from(surface.is_split()));
    let side = u64::from(FacePatch::blocks_per_side(quad_level));
    let [blocks, triangles] = match surface.is_triangular() {
        true => [side * (side + 1) / 2, 1_u64 << (2 * quad_level)],
        false => [side * side, 2_u64 << (2 * quad_level)],
    };
    let drawn = drawn_quads(scene, object).count() as u64;
    Ok(Extent {
        quads: surface.quads().face_count() as u64,
        blocks: drawn * blocks,
        triangles: drawn * triangles,
        log: quad_level.min(BLOCK_BITS),
        ..Extent::default()
    })
}

fn uniform(scene: &Scene, object: &Object, level: u32) -> ObjectPlan {
    let surface = &object.surface;
    let quad_level = level.saturating_sub(u32::from(surface.is_split()));
    let mut plan = ObjectPlan {
        reach: vec![NONE; surface.quads().face_count()],
        polygonal: surface.is_polygonal(level),
        ..ObjectPlan::default()
    };
    let blocks = FacePatch::blocks_per_side(quad_level);
    let log = quad_level.min(BLOCK_BITS);
    for quad in drawn_quads(scene, object) {
        plan.reach[quad as usize] = quad_level;
        if plan.polygonal && !surface.stands_for_face(quad) {
            continue;
        }
        for bv in 0..blocks {
            for bu in 0..blocks {
                if surface.is_triangular() && bv > bu {
                    continue;
                }
                plan.blocks.push(PlannedBlock {
                    quad,
                    start: [bu << log, bv << log],
                    level: quad_level,
                    log,
                    shown: level,
                    moves: [0; 2],
                    scattered: false,
                    list: NONE,
                });
            }
        }
    }
    plan
}

/// Faces of an object's cage that are drawn, and the blocks of each: a quad is one, other polygons are fans of triangles.
fn drawn_faces<'a>(scene: &'a Scene, object: &'a Object) -> impl Iterator<Item = (u32, u32)> + 'a {
    let cage = object.surface.cage();
    let drawn = (0..cage.face_count() as u32).filter(move |&f| scene.is_drawn(object, f));
    drawn.map(move |f| match cage.face(f as usize).len() as u32 {
        4 => (f, 1),
        corners => (f, corners.saturating_sub(2)),
    })
}

fn cage_extent(scene: &Scene, object: &Object) -> Extent {
    let cage = object.surface.cage();
    let mut out = Extent::default();
    for (face, blocks) in drawn_faces(scene, object) {
        out.blocks += u64::from(blocks);
        out.triangles += cage.face(face as usize).len() as u64 - 2;
    }
    out
}

fn polygons(scene: &Scene, object: &Object, level: u32) -> ObjectPlan {
    let mut plan = ObjectPlan::default();
    for (face, blocks) in drawn_faces(scene, object) {
        plan.blocks.extend((0..blocks).map(|block| PlannedBlock {
            quad: face,
            start: [block, 0],
            level: 0,
            log: 0,
            shown: level,
            moves: [0; 2],
            scattered: false,
            list: NONE,
        }));
    }
    plan
}

fn tessellated_extent(object: &Object, found: &Tessellation) -> Extent {
    let mut out = Extent {
        quads: object.surface.quads().face_count() as u64,
        blocks: found.leaves.len() as u64,
        moves: found.move_count() as u64,
        triangles: leaf_triangles(found),
        ..Extent::default()
    };
    let mut seen = HashSet::new();
    for leaf in &found.leaves {
        let Some(list) = found.list(leaf) else {
            out.log = out.log.max(u32::from(leaf.log));
            continue;
        };
        out.log = out.log.max(lists::log(leaf, list)).max(lists::id_log(list));
        out.moves += list.points.len() as u64;
        if seen.insert(leaf.list) {
            out.list_bytes += lists::bytes(leaf, list) as u64;
        }
    }
    out
}

fn tessellated(object: &Object, found: &Tessellation) -> ObjectPlan {
    let surface = &object.surface;
    let split = u32::from(surface.is_split());
    let mut plan = ObjectPlan {
        reach: vec![NONE; surface.quads().face_count()],
        ..ObjectPlan::default()
    };
    let mut numbers = HashMap::new();
    for (k, leaf) in found.leaves.iter().enumerate() {
        plan.reach[leaf.quad as usize] = u32::from(leaf.reach);
        let list = found.list(leaf);
        let scattered = list.filter(|list| !list.points.is_empty());
        let side = (1_u32 << leaf.log) + 1;
        let first = plan.moves.len() as u32;
        for m in found.moves(k) {
            let at = u32::from(m.at[1]) * side + u32::from(m.at[0]);
            plan.moves
                .push([at, u32::from(m.to[0]), u32::from(m.to[1])]);
        }
        for (at, place) in (0..).zip(scattered.iter().flat_map(|list| &list.points)) {
            let [x, y] = place.map(|k| u32::from(k) << (leaf.reach - leaf.level));
            plan.moves.push([at, x, y]);
        }
        let all = &mut plan.lists;
        let number = list.map(|list| {
            *numbers.entry(leaf.list).or_insert_with(|| {
                all.push(PlannedList::new(leaf, list));
                all.len() as u32 - 1
            })
        });
        plan.blocks.push(PlannedBlock {
            quad: leaf.quad,
            start: leaf.start.map(u32::from),
            level: u32::from(leaf.level),
            log: list.map_or(u32::from(leaf.log), |list| lists::log(leaf, list)),
            scattered: scattered.is_some(),
            list: number.unwrap_or(NONE),
            shown: u32::from(leaf.level) + split,
            moves: [first, plan.moves.len() as u32],
        });
    }
    plan
}
