//! A scene on its way to a device: what is drawn of it, and the numbers of all objects one after the other.

use super::chunk::{ChunkData, chunks};
use super::dicer::{Dicer, Firsts, Look};
use super::error::GpuError;
use super::further::Further;
use super::outputs::Outputs;
use super::plan::{ObjectPlan, Plan};
use super::records::Rise;
use super::rise::Maps;
use super::stats::GpuStats;
use super::view::Drawn;
use crate::camera::View;
use crate::displace::Displacement;
use crate::frame::{Aov, Drawing, Object, Renderer, Scene};
use crate::limits::Budget;
use crate::load::surface_bytes;
use crate::mesh::Cage;
use crate::patch::PatchKind;
use crate::shade::ShadeMode;
use crate::surface::Surface;

/// A scene that is ready to go to the device.
pub(super) struct Ready {
    pub(super) chunks: Vec<ChunkData>,
    /// Control points of all objects.
    pub(super) points: Vec<[f32; 3]>,
    pub(super) further: Further,
    /// Texels of all maps that displace.
    pub(super) heights: Vec<f32>,
    /// What stands behind all of these: texture coordinates, then colours.
    pub(super) values: Vec<u32>,
    /// What is written beside the picture.
    pub(super) outputs: Outputs,
    pub(super) stats: GpuStats,
}

/// Who reads texture coordinates.
#[derive(Clone, Copy)]
struct UvUse {
    shading: bool,
    outputs: bool,
}

/// What an object is drawn with; its map is put among `heights`.
fn look<'a>(
    renderer: &Renderer,
    scene: &Scene,
    (object, plan): (&'a Object, &ObjectPlan),
    wants_uvs: UvUse,
    heights: &mut Maps<'a>,
    budget: &mut Budget<'_>,
) -> Result<Look, GpuError> {
    let surface = &object.surface;
    let is_cage = renderer.drawing == Drawing::Cage;
    let displacement = surface.displacement().filter(|_| !is_cage);
    let rise = Rise::of(displacement, heights, budget)?.ok_or(GpuError::Missing {
        what: "displacement of the device",
    })?;
    let shaded = wants_uvs.shading && surface.has_uvs();
    let has_tangents = !is_cage && !plan.polygonal;
    let tilted = shaded && has_tangents && (scene.has_relief() || object.is_shaded_by_map());
    let interpolates = surface.scheme().is_interpolating();
    let by_map = displacement.is_some_and(Displacement::needs_uvs);
    Ok(Look {
        // Interpolating surfaces have no formula for derivatives.
        width: match displacement.is_some() && !interpolates {
            true => 6,
            false => 3,
        },
        uv_width: match (tilted || by_map) && !interpolates {
            true => 3,
            false => 1,
        },
        differences: interpolates && !plan.polygonal && (tilted || displacement.is_some()),
        textured: shaded || wants_uvs.outputs && surface.has_uvs(),
        shaded,
        tilted,
        cut: shaded && scene.materials.iter().any(|m| m.opacity_map.is_some()),
        rise,
    })
}

impl Ready {
    /// What `renderer` draws of `scene`, by a plan of its blocks. `limit` is the size of the largest binding in bytes.
    pub(super) fn of(
        renderer: &Renderer,
        (scene, view): (&Scene, &View),
        plan: Plan,
        limit: u64,
        budget: &mut Budget<'_>,
    ) -> Result<(Self, Drawn), GpuError> {
        let wanted = renderer.wanted(scene, view)?;
        let wants_uvs = UvUse {
            shading: renderer.mode == ShadeMode::Uv
                || !scene.textures.is_empty()
                || scene.objects.iter().any(Object::is_shaded_by_map),
            outputs: wanted.wants(Aov::Uv),
        };
        let mut heights = Maps::default();
        let cages = || scene.objects.iter().map(|o| o.surface.cage());
        let extras = |s: &Surface| match (renderer.drawing, s.patch_kind()) {
            (Drawing::Cage, _) => s.cage().normals().len(),
            (Drawing::Limit, PatchKind::Pn) => s.quads().face_count() * s.pn_net_len() as usize,
            _ => 0,
        };
        let surfaces = || scene.objects.iter().map(|o| &o.surface);
        let own_points: usize = cages().map(|c| c.points().len()).sum();
        let all_points = own_points + surfaces().map(extras).sum::<usize>();
        // Those of PN triangles are kept, to be moved.
        let patched: u128 = surfaces()
            .filter(|s| extras(s) > 0 && s.patch_kind() == PatchKind::Pn)
            .map(|s| surface_bytes(s.cage(), PatchKind::Pn))
            .sum();
        budget.take("the control points of the GPU backend", patched, 0)?;
        let numbers = |c: &Cage| 2 * c.uvs().len() + 3 * c.colors().len();
        let all_values: usize = cages().map(numbers).sum();
        // Kept here, and put together for the device.
        let bytes = 4 * (3 * all_points as u128 + all_values as u128);
        budget.take("the control points of the GPU backend", 2 * bytes, bytes)?;
        let uvs = cages().flat_map(|c| c.uvs().iter().flatten());
        let mut values: Vec<u32> = uvs.map(|c| c.to_bits()).collect();
        let mut first = Firsts {
            extra: own_points as u32,
            uv: 3 * all_points as u32,
            color: (3 * all_points + values.len()) as u32,
            ..Firsts::default()
        };
        let colors = cages().flat_map(|c| c.colors().iter().flatten());
        values.extend(colors.map(|c| c.to_bits()));
        let mut dicers = Vec::new();
        let mut control_points = Vec::new();
        for (object, plan) in scene.objects.iter().zip(&plan.objects) {
            dicers.push(Dicer::new(
                object,
                plan,
                first,
                renderer.drawing,
                look(
                    renderer,
                    scene,
                    (object, plan),
                    wants_uvs,
                    &mut heights,
                    budget,
                )?,
                budget,
            )?);
            let points = object.surface.control_base();
            control_points.extend_from_slice(points);
            let cage = object.surface.cage();
            first.point += points.len() as u32;
            first.extra += extras(&object.surface) as u32;
            first.uv += 2 * cage.uvs().len() as u32;
            first.color += 3 * cage.colors().len() as u32;
            first.face += cage.face_count() as u32;
        }
        let further = match renderer.drawing {
            Drawing::Cage => Further::Normals(cages().flat_map(Cage::normals).copied().collect()),
            Drawing::Limit => Further::nets(scene),
            Drawing::Refined => Further::default(),
        };
        let data = chunks(&dicers, &plan.objects, limit, budget)?;
        let shapes: usize = dicers.iter().map(|d| d.tables.len()).sum();
        drop(dicers);
        let stats = GpuStats {
            faces: scene.face_count() as u64,
            microtriangles: plan.triangles,
            levels: plan.levels,
            shapes: shapes as u32,
            ..GpuStats::default()
        };
        let drawn = Drawn {
            size: renderer.size,
            mode: renderer.mode,
            background: renderer.background,
            light_turn: renderer.light_turn,
            has_folds: renderer.is_flat(scene),
            id_bits: plan.id_bits,
            tessellated: plan.tessellated,
        };
        let ready = Self {
            chunks: data,
            points: control_points,
            further,
            heights: heights.texels,
            values,
            outputs: Outputs::new(wanted),
            stats,
        };
        Ok((ready, drawn))
    }
}
