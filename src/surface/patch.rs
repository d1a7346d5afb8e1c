//! A quad of a surface with all of its channels, prepared for dicing.

use super::displaced::{DisplacedPatch, linear_at};
use super::{PatchCage, RefinedFans, Surface};
use crate::control::{Fans, Kind};
use crate::dice::face::{FacePatch, Part, Sides};
use crate::dice::table::TablePatch;
use crate::dice::triangle::TrianglePatch;
use crate::dice::{DiceFault, Target};
use crate::patch::FacePatches;
use crate::records::Grid3;
use crate::simd::Level;
use std::cell::{Cell, RefCell};
use std::sync::Arc;
use std::time::{Duration, Instant};

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
pub(super) struct ChannelPatch {
    quad: FacePatch,
    triangle: TrianglePatch,
    table: TablePatch,
    patches: FacePatches,
    by: By,
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
struct Wanted {
    target: Target,
    level: u32,
    sides: Sides,
}

impl ChannelPatch {
    pub(super) fn set_simd(&mut self, simd: Level) {
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

    fn dice_part(&self, part: Part, points: &mut Grid3, normals: Option<&mut Grid3>) {
        match self.by {
            By::Quad => self.quad.dice_part(part, points, normals),
            By::Triangle => self.triangle.dice_part(part, points, normals),
            By::Table => self.table.dice_part(part, points, normals),
            By::Patches => self.patches.dice_part(part, points, normals),
        }
    }

    fn side(&self, c: usize, points: &mut Vec<[f32; 3]>, normals: &mut Vec<[f32; 3]>) {
        match self.by {
            By::Quad => self.quad.side(c, points, normals),
            By::Triangle => self.triangle.side(c, points, normals),
            By::Table => self.table.side(c, points, normals),
            By::Patches => self.patches.side(c, points, normals),
        }
    }

    fn part_hull(&self, part: Part, out: impl FnMut([f32; 3])) {
        match self.by {
            By::Quad => self.quad.part_hull(part, out),
            By::Triangle => self.triangle.part_hull(part, out),
            By::Table => self.table.part_hull(part, out),
            By::Patches => self.patches.part_hull(part, out),
        }
    }

    fn dice(&self, bu: u32, bv: u32, points: &mut Grid3, normals: Option<&mut Grid3>) {
        match self.by {
            By::Quad => self.quad.dice(bu, bv, points, normals),
            By::Triangle => self.triangle.dice(bu, bv, points, normals),
            By::Table => self.table.dice(bu, bv, points, normals),
            By::Patches => self.patches.dice(bu, bv, points, normals),
        }
    }

    fn dice_rows(
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

    fn spline(&self) -> Option<Spline> {
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

    /// Points and normals along side `c`, ends included, at the level that was prepared.
    pub(super) fn side_samples(&self, c: usize) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
        let (mut points, mut normals) = (Vec::new(), Vec::new());
        self.side(c, &mut points, &mut normals);
        (points, normals)
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
    face: u32,
    simd: Option<Level>,
    /// Made with the first displaced face.
    displaced: RefCell<Option<Box<DisplacedPatch>>>,
    is_displaced: bool,
    /// How far it reaches beyond hulls.
    reach: f32,
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

    /// Corners of a box that holds a part wherever it is displaced, which must be prepared for that.
    pub(crate) fn displaced_hull(
        &self,
        surface: &Surface,
        part: Part,
        mut out: impl FnMut([f32; 3]),
    ) {
        let [mut low, mut high] = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        self.points.part_hull(part, |p| {
            low = [0, 1, 2].map(|k| low[k].min(p[k]));
            high = [0, 1, 2].map(|k| high[k].max(p[k]));
        });
        let far = [[-self.reach; 3], [self.reach; 3]];
        let [down, up] = self.moves(surface, part).unwrap_or(far);
        let slack = 1e-4 * self.reach;
        low = [0, 1, 2].map(|k| low[k] + down[k] - slack);
        high = [0, 1, 2].map(|k| high[k] + up[k] + slack);
        for c in 0..8 {
            out([0, 1, 2].map(|k| if c >> k & 1 == 0 { low[k] } else { high[k] }));
        }
    }

    /// Bounds of the vectors by which the points of a part move, if more is known than how long they are at most.
    fn moves(&self, surface: &Surface, part: Part) -> Option<[[f32; 3]; 2]> {
        let displacement = surface.displacement()?;
        let kept = self.displaced.borrow();
        let patch = kept.as_deref()?;
        let elsewhere = patch.plain_corners(surface, part)?;
        let normals = match self.points.by {
            By::Triangle => self.points.triangle.part_normals(part)?,
            By::Quad | By::Table | By::Patches => return None,
        };
        let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        let mut hold = |uv: [f32; 3]| {
            low = [0, 1].map(|k| low[k].min(uv[k]));
            high = [0, 1].map(|k| high[k].max(uv[k]));
        };
        if patch.reads_uvs() {
            match &self.linear {
                Some(of) => of.iter().for_each(|&uv| hold(uv)),
                None => self.uvs.part_hull(part, &mut hold),
            }
            elsewhere.into_iter().for_each(hold);
        }
        let heights = displacement.heights_in([low, high])?;
        let mut out = [[0.0; 3]; 2];
        for k in 0..3 {
            let all = [0, 1, 2, 3].map(|c| heights[c & 1] * normals[c >> 1][k]);
            out[0][k] = all[1..].iter().fold(all[0], |x, &y| x.min(y));
            out[1][k] = all[1..].iter().fold(all[0], |x, &y| x.max(y));
        }
        Some(out)
    }

    /// Points whose convex hull holds a part.
    pub(crate) fn part_hull(&self, part: Part, mut out: impl FnMut([f32; 3])) {
        let mut hull = Hull::new(self.reach);
        self.points.part_hull(part, |p| hull.add(p, &mut out));
        hull.finish(&mut out);
    }

    /// The same of the whole quad.
    pub(crate) fn hull(&self, mut out: impl FnMut([f32; 3])) {
        let mut hull = Hull::new(self.reach);
        self.points.hull(|p| hull.add(p, &mut out));
        hull.finish(&mut out);
    }
    /// The same of a block.
    pub(crate) fn block_hull(&self, bu: u32, bv: u32, mut out: impl FnMut([f32; 3])) {
        let mut hull = Hull::new(self.reach);
        self.points.block_hull(bu, bv, |p| hull.add(p, &mut out));
        hull.finish(&mut out);
    }
}

/// Points of a hull as they are, or of displaced ones the corners of their box, grown by as far as points move.
struct Hull {
    reach: f32,
    low: [f32; 3],
    high: [f32; 3],
}

impl Hull {
    fn new(reach: f32) -> Self {
        Self {
            reach,
            low: [f32::INFINITY; 3],
            high: [f32::NEG_INFINITY; 3],
        }
    }

    fn add(&mut self, p: [f32; 3], out: &mut impl FnMut([f32; 3])) {
        if self.reach == 0.0 {
            return out(p);
        }
        self.low = [0, 1, 2].map(|k| self.low[k].min(p[k] - self.reach));
        self.high = [0, 1, 2].map(|k| self.high[k].max(p[k] + self.reach));
    }

    fn finish(&self, out: &mut impl FnMut([f32; 3])) {
        if self.reach == 0.0 || self.low[0] > self.high[0] {
            return;
        }
        for c in 0..8 {
            out([0, 1, 2].map(|k| {
                if c >> k & 1 == 0 {
                    self.low[k]
                } else {
                    self.high[k]
                }
            }));
        }
    }
}
