//! A quad of a surface with all of its channels, prepared for dicing.

use super::channel_patch::{By, ChannelPatch, Spline, Wanted};
use super::displaced::{DisplacedPatch, linear_at};
use super::{RefinedFans, Surface};
use crate::control::Kind;
use crate::dice::face::{Part, Sides};
use crate::dice::{DiceFault, Target};
use crate::records::Grid3;
use crate::simd::Level;
use std::cell::{Cell, RefCell};
use std::time::{Duration, Instant};

/// A quad of a surface prepared for dicing: its points and its texture coordinates.
#[derive(Clone, Debug, Default)]
pub(crate) struct QuadPatch {
    pub(super) points: ChannelPatch,
    pub(super) uvs: ChannelPatch,
    colors: ChannelPatch,
    triangle: bool,
    uv_ready: bool,
    color_ready: bool,
    pub(super) linear: Option<[[f32; 3]; 4]>,
    level: u32,
    face: u32,
    simd: Option<Level>,
    /// Made with the first displaced face.
    pub(super) displaced: RefCell<Option<Box<DisplacedPatch>>>,
    is_displaced: bool,
    /// How far it reaches beyond hulls.
    pub(super) reach: f32,
    /// Time spent displacing since it was taken last, if that is measured.
    pub(crate) clock: Cell<Option<Duration>>,
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
        self.simd = Some(simd);
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
        self.face = q;
        self.uv_ready = false;
        self.color_ready = false;
        self.triangle = surface.triangles;
        let target = match refined {
            Some(_) if !surface.linear => Target::Refined,
            _ => Target::Limit,
        };
        self.prepare_displaced(surface, q, level, sides);
        let sides = match self.is_displaced && sides > Sides::Hull {
            // Points move along their normals.
            true => Sides::Normals,
            false => sides,
        };
        self.prepare_limit(
            surface,
            q,
            refined,
            Wanted {
                target,
                level,
                sides,
            },
        );
    }

    /// Prepares quad `q` for hulls of its parts alone.
    pub(crate) fn prepare_part_hulls(&mut self, surface: &Surface, q: u32, level: u32) {
        self.level = level;
        self.face = q;
        self.uv_ready = false;
        self.color_ready = false;
        self.triangle = surface.triangles;
        self.prepare_displaced(surface, q, level, Sides::Hull);
        let wanted = Wanted {
            target: Target::Limit,
            level,
            sides: Sides::None,
        };
        self.prepare_limit(surface, q, None, wanted);
        let reads_uvs = |d: &mut Box<DisplacedPatch>| d.reads_uvs();
        if self.displaced.get_mut().as_mut().is_some_and(reads_uvs) {
            self.linear = surface.linear_corners(q).filter(|_| surface.linear_uv);
            if self.linear.is_none() {
                self.uvs.prepare(surface, Kind::Uvs, q, None, wanted);
            }
        }
    }

    fn prepare_limit(
        &mut self,
        surface: &Surface,
        q: u32,
        refined: Option<&RefinedFans>,
        wanted: Wanted,
    ) {
        let Wanted { level, sides, .. } = wanted;
        if refined.is_none() && self.points.prepare_patches(surface, q, level, sides) {
            return;
        }
        self.points
            .prepare(surface, Kind::Points, q, refined, wanted);
    }

    fn prepare_displaced(&mut self, surface: &Surface, q: u32, level: u32, sides: Sides) {
        self.is_displaced = surface.displacement().is_some();
        self.reach = surface.displacement_reach();
        if !self.is_displaced {
            return;
        }
        let patch = self.displaced.get_mut().get_or_insert_default();
        patch.set_simd(self.simd.unwrap_or(Level::SCALAR));
        patch.prepare(surface, q, level, sides);
        if patch.reads_uvs() && sides > Sides::Hull {
            self.prepare_uvs(surface, q);
        }
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
            // What moves points has to be the same in both faces.
            sides: match self.is_displaced {
                true => Sides::Points,
                false => Sides::None,
            },
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

    /// Dices a block of the level that was prepared; `surface` is what it was prepared from, here and below.
    pub(crate) fn dice(
        &self,
        surface: &Surface,
        bu: u32,
        bv: u32,
        points: &mut Grid3,
        normals: Option<&mut Grid3>,
    ) {
        if self.is_displaced {
            return self.dice_displaced(
                surface,
                Part::block(self.level, [bu, bv]),
                points,
                normals,
            );
        }
        self.points.dice(bu, bv, points, normals);
    }

    /// The same with normals, of a surface that is not displaced, where only rows from the first to the last of `rows` are wanted. The others
    /// mean nothing.
    pub(crate) fn dice_rows(
        &self,
        block: [u32; 2],
        rows: [u32; 2],
        points: &mut Grid3,
        normals: &mut Grid3,
    ) {
        self.points.dice_rows(block, rows, points, normals);
    }

    fn dice_displaced(
        &self,
        surface: &Surface,
        part: Part,
        points: &mut Grid3,
        normals: Option<&mut Grid3>,
    ) {
        let mut displaced = self.displaced.borrow_mut();
        let Some(displaced) = displaced.as_deref_mut() else {
            return;
        };
        let mut spare = displaced.take_spare();
        let [limit, uvs] = &mut spare;
        let wants_normals = normals.is_some();
        let normals = normals.unwrap_or(limit);
        self.points.dice_part(part, points, Some(normals));
        let uvs = displaced.reads_uvs().then(|| {
            self.dice_part_uvs(part, uvs);
            &**uvs
        });
        let begin = self.clock.get().map(|_| Instant::now());
        displaced.displace(surface, part, points, normals, uvs, wants_normals);
        if let (Some(begin), Some(before)) = (begin, self.clock.get()) {
            self.clock.set(Some(before + begin.elapsed()));
        }
        displaced.give_spare(spare);
    }

    pub(crate) fn dice_uvs(&self, bu: u32, bv: u32, out: &mut Grid3) {
        match self.linear {
            Some(_) => self.linear_uvs(Part::block(self.level, [bu, bv]), out),
            None => self.uvs.dice(bu, bv, out, None),
        }
    }

    fn linear_uvs(&self, part: Part, out: &mut Grid3) {
        let Some(c) = &self.linear else { return };
        let side = part.segments as usize + 1;
        let scale = 1.0 / (1_u32 << part.level) as f32;
        for j in 0..side {
            let t = (part.start[1] as usize + j) as f32 * scale;
            for i in 0..side {
                let s = (part.start[0] as usize + i) as f32 * scale;
                out.set(i, j, linear_at(c, self.triangle, [s, t]));
            }
        }
    }

    /// Dices a part of a quad, of the level that was prepared or a coarser one.
    pub(crate) fn dice_part(
        &self,
        surface: &Surface,
        part: Part,
        points: &mut Grid3,
        normals: Option<&mut Grid3>,
    ) {
        if self.is_displaced {
            return self.dice_displaced(surface, part, points, normals);
        }
        self.points.dice_part(part, points, normals);
    }

    /// Bound of what the diced samples of a part do not show of its displacement, in model units; 0 without.
    pub(crate) fn hidden(&self, surface: &Surface, part: Part, points: &Grid3) -> f32 {
        let Some(displacement) = surface.displacement() else {
            return 0.0;
        };
        let mut kept = self.displaced.borrow_mut();
        let Some(patch) = kept.as_deref_mut() else {
            return 0.0;
        };
        let mut spare = patch.take_spare();
        let [uvs, _] = &mut spare;
        if patch.reads_uvs() {
            self.dice_part_uvs(part, uvs);
        }
        let hidden = displacement.hidden(part.segments as usize + 1, points, uvs);
        patch.give_spare(spare);
        hidden
    }

    /// For relief, what of a part's limit surface tilts normals: under slopes by pixel the vectors for the slopes of the displacement's map,
    /// else the derivatives by the texture coordinates, which must be prepared.
    pub(crate) fn dice_tangents(
        &self,
        surface: &Surface,
        part: Part,
        first: &mut Grid3,
        second: &mut Grid3,
    ) {
        let mut kept = self.displaced.borrow_mut();
        let patch = kept.get_or_insert_default();
        if !self.is_displaced {
            patch.set_simd(self.simd.unwrap_or(Level::SCALAR));
            patch.prepare(surface, self.face, self.level, Sides::Hull);
        }
        let mut grids = patch.take_relief();
        let [points, normals, uvs] = &mut grids;
        self.points.dice_part(part, points, Some(normals));
        self.dice_part_uvs(part, uvs);
        let by_pixel = surface
            .displacement()
            .is_some_and(|d| d.pixel_map().is_some());
        let out = [first, second];
        match by_pixel {
            true => patch.tilts(surface, part, [points, normals, uvs], out),
            false => patch.tangents(surface, part, [points, normals, uvs], out),
        }
        patch.give_relief(grids);
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

    /// Control points of a face that is one spline and drawn where that is.
    pub(crate) fn spline(&self) -> Option<Spline> {
        match self.is_displaced {
            true => None,
            false => self.points.spline(),
        }
    }

    /// Whether samples inside of the face tell what is to be known of its sides.
    pub(crate) fn has_plain_sides(&self) -> bool {
        !self.is_displaced
            && match self.points.by {
                By::Quad => self.points.quad.has_plain_sides(),
                By::Triangle => self.points.triangle.has_plain_sides(),
                By::Table => false,
                By::Patches => true,
            }
    }

    /// Point and unit normal at (`u`, `v`) of the patches that were prepared.
    pub(crate) fn patch_at(&self, u: f32, v: f32) -> ([f32; 3], [f32; 3]) {
        self.points.patches.at(u, v)
    }

    /// Samples of side `c` of a quad, at the level that was prepared.
    pub(crate) fn side(
        &self,
        surface: &Surface,
        c: usize,
        points: &mut Vec<[f32; 3]>,
        normals: &mut Vec<[f32; 3]>,
    ) {
        self.points.side(c, points, normals);
        if !self.is_displaced {
            return;
        }
        let mut displaced = self.displaced.borrow_mut();
        let Some(displaced) = displaced.as_deref_mut() else {
            return;
        };
        let uvs = match (displaced.reads_uvs(), &self.linear) {
            (false, _) => Vec::new(),
            (true, Some(corners)) => displaced.linear_side(corners, c),
            (true, None) => self.uvs.side_samples(c).0,
        };
        displaced.displace_side(surface, c, points, normals, &uvs);
    }
}
