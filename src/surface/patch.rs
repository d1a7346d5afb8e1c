//! A quad of a surface with all of its channels, prepared for dicing.

use super::{PatchCage, RefinedFans, Surface};
use crate::control::{Fans, Kind};
use crate::dice::face::{FacePatch, Part, Sides};
use crate::dice::table::TablePatch;
use crate::dice::triangle::TrianglePatch;
use crate::dice::{DiceFault, Target};
use crate::patch::FacePatches;
use crate::records::Grid3;
use crate::simd::Level;
use std::sync::Arc;

/// What dices a face.
#[derive(Clone, Copy, Debug, Default)]
enum By {
    #[default]
    Quad,
    Triangle,
    Table,
    Patches,
}

/// A face of one channel: quad or triangle, of an interpolating scheme, or by patches in place of the limit surface.
#[derive(Clone, Debug, Default)]
struct ChannelPatch {
    quad: FacePatch,
    triangle: TrianglePatch,
    table: TablePatch,
    patches: FacePatches,
    by: By,
}

/// What is asked of a face.
#[derive(Clone, Copy, Debug)]
struct Wanted {
    target: Target,
    level: u32,
    sides: Sides,
}

impl ChannelPatch {
    fn set_simd(&mut self, simd: Level) {
        self.quad.simd = simd;
        self.triangle.simd = simd;
        self.table.simd = simd;
        self.patches.simd = simd;
    }

    /// Prepares face `q` of a channel; false when the surface has no such channel.
    fn prepare(
        &mut self,
        surface: &Surface,
        kind: Kind,
        q: u32,
        refined: Option<&RefinedFans>,
        wanted: Wanted,
    ) -> bool {
        let Wanted {
            target,
            level,
            sides,
        } = wanted;
        if let Some(tables) = &surface.tables {
            self.by = By::Table;
            let Some(channel) = tables.channel(kind, level) else {
                return false;
            };
            self.table.prepare(Arc::clone(channel), q, level, sides);
            return true;
        }
        self.by = match surface.triangles {
            true => By::Triangle,
            false => By::Quad,
        };
        let below = surface.below(kind, level, refined);
        if surface.triangles {
            if let Some(below) = below.as_ref().filter(|_| surface.has(kind)) {
                self.triangle.prepare_below(below, q, target, level, sides);
                return true;
            }
            return false;
        }
        let Some(mut channel) = surface.channel(kind, below.as_ref()) else {
            return false;
        };
        if let Some(Fans::Quads(_, fans)) = refined.and_then(|r| r.0.first()) {
            channel.fans = fans;
        }
        self.quad.prepare(channel, q, target, level, sides);
        true
    }

    /// Prepares the patches of face `q`; false when the limit surface itself is wanted.
    fn prepare_patches(&mut self, surface: &Surface, q: u32, level: u32, sides: Sides) -> bool {
        match &surface.patches {
            None => return false,
            Some(PatchCage::Pn(cage)) => {
                let split = surface.is_split();
                let (t, points) = (&surface.mesh.base, &surface.cage.points);
                self.patches.take(cage, t, points, q, split, level);
            }
            Some(PatchCage::Qas) => {
                let wanted = Wanted {
                    target: Target::Limit,
                    level: 1,
                    sides: sides.max(Sides::Points),
                };
                self.prepare(surface, Kind::Points, q, None, wanted);
                let mut samples = self.patches.samples.take().unwrap_or_default();
                let normals = (sides == Sides::Normals).then_some(&mut *samples.normals);
                self.dice(0, 0, &mut samples.points, normals);
                self.patches.samples = Some(samples);
                self.patches.fit(surface.triangles, level);
            }
        }
        self.by = By::Patches;
        true
    }

    fn dice(&self, bu: u32, bv: u32, points: &mut Grid3, normals: Option<&mut Grid3>) {
        match self.by {
            By::Quad => self.quad.dice(bu, bv, points, normals),
            By::Triangle => self.triangle.dice(bu, bv, points, normals),
            By::Table => self.table.dice(bu, bv, points, normals),
            By::Patches => self.patches.dice(bu, bv, points, normals),
        }
    }

    fn dice_part(&self, part: Part, points: &mut Grid3, normals: Option<&mut Grid3>) {
        match self.by {
            By::Patches => self.patches.dice_part(part, points, normals),
            _ => self.quad.dice_part(part, points, normals),
        }
    }

    fn side(&self, c: usize, points: &mut Vec<[f32; 3]>, normals: &mut Vec<[f32; 3]>) {
        match self.by {
            By::Patches => self.patches.side(c, points, normals),
            _ => self.quad.side(c, points, normals),
        }
    }

    fn part_hull(&self, part: Part, out: impl FnMut([f32; 3])) {
        match self.by {
            By::Patches => self.patches.part_hull(part, out),
            _ => self.quad.part_hull(part, out),
        }
    }

    fn hull(&self, out: impl FnMut([f32; 3])) {
        match self.by {
            By::Quad => self.quad.hull(out),
            By::Triangle => self.triangle.hull(out),
            By::Table => self.table.hull(out),
            By::Patches => self.patches.hull(out),
        }
    }

    fn block_hull(&self, bu: u32, bv: u32, out: impl FnMut([f32; 3])) {
        match self.by {
            By::Quad => self.quad.block_hull(bu, bv, out),
            By::Triangle => self.triangle.block_hull(bu, bv, out),
            By::Table => self.table.block_hull(bu, bv, out),
            By::Patches => self.patches.block_hull(bu, bv, out),
        }
    }
}

/// A quad of a surface prepared for dicing: its points and its texture coordinates.
#[derive(Clone, Debug, Default)]
pub(crate) struct QuadPatch {
    points: ChannelPatch,
    uvs: ChannelPatch,
    colors: ChannelPatch,
    triangle: bool,
    uv_ready: bool,
    color_ready: bool,
    linear: Option<[[f32; 3]; 4]>,
    level: u32,
}

impl QuadPatch {
    /// A patch that uses these vector instructions.
    pub(crate) fn for_level(simd: Level) -> Self {
        let mut patch = Self::default();
        patch.set_simd(simd);
        patch
    }

    /// Chooses the vector instructions; never changes a bit.
    pub(crate) fn set_simd(&mut self, simd: Level) {
        self.points.set_simd(simd);
        self.uvs.set_simd(simd);
        self.colors.set_simd(simd);
    }

    /// Breaks a rule, for tests.
    pub(crate) fn set_fault(&mut self, fault: DiceFault) {
        self.points.quad.fault = fault;
        self.points.triangle.fault = fault;
        self.points.table.fault = fault;
    }

    /// Prepares quad `q`. `refined` holds the fans of [`Surface::refined_fans`] if control points are wanted.
    pub(crate) fn prepare(
        &mut self,
        surface: &Surface,
        q: u32,
        level: u32,
        refined: Option<&RefinedFans>,
    ) {
        self.prepare_points(surface, q, level, refined, Sides::Normals);
        self.prepare_uvs(surface, q);
    }

    /// Only the points; without `sides` enough for a hull.
    pub(crate) fn prepare_points(
        &mut self,
        surface: &Surface,
        q: u32,
        level: u32,
        refined: Option<&RefinedFans>,
        sides: Sides,
    ) {
        self.level = level;
        self.uv_ready = false;
        self.color_ready = false;
        self.triangle = surface.triangles;
        if refined.is_none() && self.points.prepare_patches(surface, q, level, sides) {
            return;
        }
        let target = match refined {
            Some(_) if !surface.linear => Target::Refined,
            _ => Target::Limit,
        };
        let wanted = Wanted {
            target,
            level,
            sides,
        };
        self.points
            .prepare(surface, Kind::Points, q, refined, wanted);
    }

    pub(crate) fn prepare_uvs(&mut self, surface: &Surface, q: u32) {
        if !surface.has_uvs() {
            return;
        }
        self.uv_ready = true;
        self.linear = None;
        if surface.linear_uv {
            self.linear = surface.linear_corners(q);
            return;
        }
        let wanted = self.values();
        self.uvs.prepare(surface, Kind::Uvs, q, None, wanted);
    }

    /// Values without sides of their own, at the level of the points.
    fn values(&self) -> Wanted {
        Wanted {
            target: Target::Limit,
            level: self.level,
            sides: Sides::None,
        }
    }

    pub(crate) fn has_uvs(&self) -> bool {
        self.uv_ready
    }

    /// Prepares the vertex colours of quad `q`; says whether there are any.
    pub(crate) fn prepare_colors(&mut self, surface: &Surface, q: u32) -> bool {
        if !self.color_ready {
            let wanted = self.values();
            self.color_ready = self.colors.prepare(surface, Kind::Colors, q, None, wanted);
        }
        self.color_ready
    }

    pub(crate) fn dice_colors(&self, bu: u32, bv: u32, out: &mut Grid3) {
        self.colors.dice(bu, bv, out, None);
    }

    pub(crate) fn dice(&self, bu: u32, bv: u32, points: &mut Grid3, normals: Option<&mut Grid3>) {
        self.points.dice(bu, bv, points, normals);
    }

    pub(crate) fn dice_uvs(&self, bu: u32, bv: u32, out: &mut Grid3) {
        match self.linear {
            Some(_) => self.linear_uvs(Part::block(self.level, [bu, bv]), out),
            None => self.uvs.dice(bu, bv, out, None),
        }
    }

    fn linear_uvs(&self, part: Part, out: &mut Grid3) {
        let Some(c) = self.linear else { return };
        let side = part.segments as usize + 1;
        let scale = 1.0 / (1_u32 << part.level) as f32;
        for j in 0..side {
            let t = (part.start[1] as usize + j) as f32 * scale;
            for i in 0..side {
                let s = (part.start[0] as usize + i) as f32 * scale;
                let at = |k: usize| {
                    if self.triangle {
                        // Above the diagonal, everything is folded onto it.
                        let t = t.min(s);
                        return (c[0][k] * (1.0 - s) + c[1][k] * (s - t)) + c[2][k] * t;
                    }
                    (c[0][k] * (1.0 - s) + c[1][k] * s) * (1.0 - t)
                        + (c[3][k] * (1.0 - s) + c[2][k] * s) * t
                };
                out.set(i, j, [at(0), at(1), 0.0]);
            }
        }
    }

    /// Dices a part of a quad, of the level that was prepared or a coarser one.
    pub(crate) fn dice_part(&self, part: Part, points: &mut Grid3, normals: Option<&mut Grid3>) {
        self.points.dice_part(part, points, normals);
    }

    /// Texture coordinates of a part.
    pub(crate) fn dice_part_uvs(&self, part: Part, out: &mut Grid3) {
        match self.linear {
            Some(_) => self.linear_uvs(part, out),
            None => self.uvs.dice_part(part, out, None),
        }
    }

    /// Colours of a part.
    pub(crate) fn dice_part_colors(&self, part: Part, out: &mut Grid3) {
        self.colors.dice_part(part, out, None);
    }

    /// Point and unit normal at (`u`, `v`) of the patches that were prepared.
    pub(crate) fn patch_at(&self, u: f32, v: f32) -> ([f32; 3], [f32; 3]) {
        self.points.patches.at(u, v)
    }

    /// Samples of side `c` of a quad, at the level that was prepared.
    pub(crate) fn side(&self, c: usize, points: &mut Vec<[f32; 3]>, normals: &mut Vec<[f32; 3]>) {
        self.points.side(c, points, normals);
    }

    /// Points whose convex hull holds a part.
    pub(crate) fn part_hull(&self, part: Part, out: impl FnMut([f32; 3])) {
        self.points.part_hull(part, out);
    }

    pub(crate) fn hull(&self, out: impl FnMut([f32; 3])) {
        self.points.hull(out);
    }
    pub(crate) fn block_hull(&self, bu: u32, bv: u32, out: impl FnMut([f32; 3])) {
        self.points.block_hull(bu, bv, out);
    }
}
