//! A face of one channel of a surface: whatever dices it.

use super::{PatchCage, RefinedFans, Surface};
use crate::control::{Fans, Kind};
use crate::dice::Target;
use crate::dice::face::{FacePatch, Part, Sides};
use crate::dice::table::TablePatch;
use crate::dice::triangle::TrianglePatch;
use crate::patch::FacePatches;
use crate::records::Grid3;
use crate::simd::Level;
use std::sync::Arc;

/// What dices a face.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum By {
    #[default]
    Quad,
    Triangle,
    Table,
    Patches,
}

/// A face of one channel: quad or triangle, of an interpolating scheme, or by patches in place of the limit surface.
#[derive(Clone, Debug, Default)]
pub(super) struct ChannelPatch {
    pub(super) quad: FacePatch,
    pub(super) triangle: TrianglePatch,
    pub(super) table: TablePatch,
    pub(super) patches: FacePatches,
    pub(super) by: By,
}

/// Control points of a face that is one spline.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Spline {
    /// A bicubic B-spline, row by row.
    Quad([[[f32; 3]; 4]; 4]),
    /// A quartic box spline: rows of 3, 4, 3 and 2, the first one beyond side 0, each row's begin one to the right of where the row before
    /// has a neighbour in the direction of side 2.
    Triangle([[f32; 3]; 12]),
}

impl Spline {
    /// The control points; their hull holds the face.
    pub(crate) fn points(&self) -> &[[f32; 3]] {
        match self {
            Self::Quad(net) => net.as_flattened(),
            Self::Triangle(net) => net,
        }
    }
}

/// What is asked of a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    pub(super) target: Target,
    pub(super) level: u32,
    pub(super) sides: Sides,
}

impl ChannelPatch {
    pub(super) fn set_simd(&mut self, simd: Level) {
        self.quad.simd = simd;
        self.triangle.simd = simd;
        self.table.simd = simd;
        self.patches.simd = simd;
    }

    /// Prepares face `q` of a channel; false when the surface has no such channel.
    pub(super) fn prepare(
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
    pub(super) fn prepare_patches(
        &mut self,
        surface: &Surface,
        q: u32,
        level: u32,
        sides: Sides,
    ) -> bool {
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

    pub(super) fn dice_part(&self, part: Part, points: &mut Grid3, normals: Option<&mut Grid3>) {
        match self.by {
            By::Quad => self.quad.dice_part(part, points, normals),
            By::Triangle => self.triangle.dice_part(part, points, normals),
            By::Table => self.table.dice_part(part, points, normals),
            By::Patches => self.patches.dice_part(part, points, normals),
        }
    }

    pub(super) fn side(&self, c: usize, points: &mut Vec<[f32; 3]>, normals: &mut Vec<[f32; 3]>) {
        match self.by {
            By::Quad => self.quad.side(c, points, normals),
            By::Triangle => self.triangle.side(c, points, normals),
            By::Table => self.table.side(c, points, normals),
            By::Patches => self.patches.side(c, points, normals),
        }
    }

    pub(super) fn part_hull(&self, part: Part, out: impl FnMut([f32; 3])) {
        match self.by {
            By::Quad => self.quad.part_hull(part, out),
            By::Triangle => self.triangle.part_hull(part, out),
            By::Table => self.table.part_hull(part, out),
            By::Patches => self.patches.part_hull(part, out),
        }
    }

    pub(super) fn dice(&self, bu: u32, bv: u32, points: &mut Grid3, normals: Option<&mut Grid3>) {
        match self.by {
            By::Quad => self.quad.dice(bu, bv, points, normals),
            By::Triangle => self.triangle.dice(bu, bv, points, normals),
            By::Table => self.table.dice(bu, bv, points, normals),
            By::Patches => self.patches.dice(bu, bv, points, normals),
        }
    }

    pub(super) fn dice_rows(
        &self,
        [bu, bv]: [u32; 2],
        rows: [u32; 2],
        points: &mut Grid3,
        normals: &mut Grid3,
    ) {
        match self.by {
            By::Quad => self.quad.dice_rows([bu, bv], rows, points, normals),
            _ => self.dice(bu, bv, points, Some(normals)),
        }
    }

    pub(super) fn spline(&self) -> Option<Spline> {
        match self.by {
            By::Quad => self.quad.spline().map(Spline::Quad),
            By::Triangle => self.triangle.spline().map(Spline::Triangle),
            By::Table | By::Patches => None,
        }
    }

    /// Prepares a face for [`ChannelPatch::side_samples`].
    pub(super) fn prepare_side(
        &mut self,
        surface: &Surface,
        kind: Kind,
        q: u32,
        level: u32,
        sides: Sides,
    ) {
        let wanted = Wanted {
            target: Target::Limit,
            level,
            sides,
        };
        self.prepare(surface, kind, q, None, wanted);
    }

    /// The same of what is drawn of the points: of patches, where the surface has any.
    pub(super) fn prepare_drawn_side(&mut self, surface: &Surface, q: u32, level: u32) {
        if !self.prepare_patches(surface, q, level, Sides::Normals) {
            self.prepare_side(surface, Kind::Points, q, level, Sides::Normals);
        }
    }

    /// Points and normals along side `c`, ends included, at the level that was prepared.
    pub(super) fn side_samples(&self, c: usize) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
        let (mut points, mut normals) = (Vec::new(), Vec::new());
        self.side(c, &mut points, &mut normals);
        (points, normals)
    }

    pub(super) fn hull(&self, out: impl FnMut([f32; 3])) {
        match self.by {
            By::Quad => self.quad.hull(out),
            By::Triangle => self.triangle.hull(out),
            By::Table => self.table.hull(out),
            By::Patches => self.patches.hull(out),
        }
    }

    pub(super) fn block_hull(&self, bu: u32, bv: u32, out: impl FnMut([f32; 3])) {
        match self.by {
            By::Quad => self.quad.block_hull(bu, bv, out),
            By::Triangle => self.triangle.block_hull(bu, bv, out),
            By::Table => self.table.block_hull(bu, bv, out),
            By::Patches => self.patches.block_hull(bu, bv, out),
        }
    }
}
