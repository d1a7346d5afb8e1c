//! Which blocks of which faces are drawn: a uniform level, or what adaptive tessellation decided. Decided on the processor, once per view
//! where it follows the picture.

use super::error::GpuError;
use crate::camera::View;
use crate::dice::FacePatch;
use crate::frame::{Drawing, Object, Renderer, Scene};
use crate::patch::PatchKind;
use crate::tessellate::Tessellation;
use crate::topology::NONE;

/// A block of a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlannedBlock {
    pub(super) quad: u32,
    /// First point, on the grid of `level`.
    pub(super) start: [u32; 2],
    pub(super) level: u32,
    pub(super) log: u32,
    /// Level that it shows, of the cage.
    pub(super) shown: u32,
    /// Moved points, in [`ObjectPlan::moves`].
    pub(super) moves: [u32; 2],
}

/// What is drawn of an object: blocks in order of their faces.
#[derive(Clone, Debug, Default)]
pub(super) struct ObjectPlan {
    /// Per quad the level that places are given in, or [`NONE`] where it is not drawn.
    pub(super) reach: Vec<u32>,
    pub(super) blocks: Vec<PlannedBlock>,
    /// Point in the block, row by row, and where it is on the face's reach.
    pub(super) moves: Vec<[u32; 3]>,
    pub(super) triangles: u64,
}

/// Refuses what this backend does not draw.
fn check(renderer: &Renderer, scene: &Scene) -> Result<(), GpuError> {
    let refuse = |what| Err(GpuError::Unsupported { what });
    if renderer.drawing != Drawing::Limit {
        return refuse("refined control points or cages; --surface limit");
    }
    let materials = || scene.materials.iter().chain(&scene.default_material);
    if materials().any(|m| m.opacity_map.is_some() || m.relief.is_some()) {
        return refuse("opacity maps, normal maps or bump maps");
    }
    for object in &scene.objects {
        let surface = &object.surface;
        let colored = !surface.cage().colors().is_empty();
        match surface.patch_kind() {
            PatchKind::Pn => return refuse("curved PN triangles"),
            PatchKind::Qas if colored => return refuse("patches with colours of vertices"),
            _ => {}
        }
        if surface.displacement().is_some() {
            return refuse("displacement");
        }
    }
    Ok(())
}

/// What is drawn of every object of a scene, and whether it depends on the view.
pub(super) fn plan(
    renderer: &Renderer,
    scene: &Scene,
    view: &View,
) -> Result<Vec<ObjectPlan>, GpuError> {
    check(renderer, scene)?;
    let (levels, tessellations) = renderer.decide(scene, view)?;
    let mut out = Vec::new();
    for ((object, &level), found) in scene.objects.iter().zip(&levels).zip(&tessellations) {
        out.push(match found {
            Some(found) => tessellated(object, found)?,
            None => uniform(scene, object, level)?,
        });
    }
    let triangles: u64 = out.iter().map(|o| o.triangles).sum();
    renderer.limits.faces(u128::from(triangles) / 2)?;
    Ok(out)
}

fn is_drawn(scene: &Scene, object: &Object, face: u32) -> bool {
    let clear = scene.materials.get(object.material(face) as usize);
    !object.surface.topology().is_hole(face) && clear.is_none_or(|m| m.opacity >= 0.5)
}

fn uniform(scene: &Scene, object: &Object, level: u32) -> Result<ObjectPlan, GpuError> {
    let surface = &object.surface;
    let split = u32::from(surface.is_split());
    if level < split {
        return Err(GpuError::Unsupported {
            what: "polygons of other than four corners at level 0",
        });
    }
    let quad_level = level - split;
    let quads = surface.quads().face_count();
    let mut plan = ObjectPlan {
        reach: vec![NONE; quads],
        ..ObjectPlan::default()
    };
    let blocks = FacePatch::blocks_per_side(quad_level);
    let log = quad_level.min(5);
    for quad in 0..quads as u32 {
        if !is_drawn(scene, object, surface.cage_face(quad)) {
            continue;
        }
        plan.reach[quad as usize] = quad_level;
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
                });
            }
        }
        plan.triangles += (2 - u64::from(surface.is_triangular())) << (2 * quad_level);
    }
    Ok(plan)
}

fn tessellated(object: &Object, found: &Tessellation) -> Result<ObjectPlan, GpuError> {
    let surface = &object.surface;
    let split = u32::from(surface.is_split());
    let mut plan = ObjectPlan {
        reach: vec![NONE; surface.quads().face_count()],
        ..ObjectPlan::default()
    };
    for (k, leaf) in found.leaves.iter().enumerate() {
        if found.list(leaf).is_some() {
            return Err(GpuError::Unsupported {
                what: "refinement patterns",
            });
        }
        plan.reach[leaf.quad as usize] = u32::from(leaf.reach);
        let side = (1_u32 << leaf.log) + 1;
        let first = plan.moves.len() as u32;
        for m in found.moves(k) {
            let at = u32::from(m.at[1]) * side + u32::from(m.at[0]);
            plan.moves
                .push([at, u32::from(m.to[0]), u32::from(m.to[1])]);
        }
        plan.blocks.push(PlannedBlock {
            quad: leaf.quad,
            start: leaf.start.map(u32::from),
            level: u32::from(leaf.level),
            log: u32::from(leaf.log),
            shown: u32::from(leaf.level) + split,
            moves: [first, plan.moves.len() as u32],
        });
        let half = u64::from(found.triangular && leaf.is_diagonal());
        plan.triangles += (2 - half) << (2 * leaf.log);
    }
    plan.triangles -= found.move_count() as u64;
    Ok(plan)
}
