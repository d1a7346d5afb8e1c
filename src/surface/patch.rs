//! A quad of a surface with all of its channels, prepared for dicing.

use super::{RefinedFans, Surface};
use crate::control::Kind;
use crate::dice::face::{FacePatch, Sides};
use crate::dice::{DiceFault, Target};
use crate::records::Grid3;
use crate::simd::Level;

/// A quad of a surface prepared for dicing: its points and its texture coordinates.
#[derive(Clone, Debug, Default)]
pub(crate) struct QuadPatch {
    points: FacePatch,
    uvs: FacePatch,
    colors: FacePatch,
    uv_ready: bool,
    color_ready: bool,
    linear: Option<[[f32; 3]; 4]>,
    level: u32,
}

impl QuadPatch {
    /// Chooses the vector instructions; never changes a bit.
    pub(crate) fn set_simd(&mut self, simd: Level) {
        self.points.simd = simd;
        self.uvs.simd = simd;
        self.colors.simd = simd;
    }

    /// Breaks a rule, for tests.
    pub(crate) fn set_fault(&mut self, fault: DiceFault) {
        self.points.fault = fault;
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
        let target = match refined {
            Some(_) if !surface.linear => Target::Refined,
            _ => Target::Limit,
        };
        let below = surface.below(Kind::Points, level, refined);
        let Some(mut channel) = surface.channel(Kind::Points, below.as_ref()) else {
            return;
        };
        if let Some(fans) = refined.and_then(|r| r.0.first()) {
            channel.fans = fans;
        }
        self.points.prepare(channel, q, target, level, sides);
    }

    pub(crate) fn prepare_uvs(&mut self, surface: &Surface, q: u32) {
        let below = surface.below(Kind::Uvs, self.level, None);
        let Some(channel) = surface.channel(Kind::Uvs, below.as_ref()) else {
            return;
        };
        self.uv_ready = true;
        self.linear = None;
        if surface.linear_uv {
            let corner = |c: u32| channel.points[channel.topology.vertex(4 * q + c) as usize];
            self.linear = Some([corner(0), corner(1), corner(2), corner(3)]);
            return;
        }
        self.uvs
            .prepare(channel, q, Target::Limit, self.level, Sides::None);
    }

    pub(crate) fn has_uvs(&self) -> bool {
        self.uv_ready
    }

    /// Prepares the vertex colours of quad `q`; says whether there are any.
    pub(crate) fn prepare_colors(&mut self, surface: &Surface, q: u32) -> bool {
        if self.color_ready {
            return true;
        }
        let below = surface.below(Kind::Colors, self.level, None);
        if let Some(channel) = surface.channel(Kind::Colors, below.as_ref()) {
            self.colors
                .prepare(channel, q, Target::Limit, self.level, Sides::None);
            self.color_ready = true;
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
        let Some(c) = self.linear else {
            self.uvs.dice(bu, bv, out, None);
            return;
        };
        let size = FacePatch::block_size(self.level);
        let scale = 1.0 / (1_u32 << self.level) as f32;
        for j in 0..size.rows {
            let t = (bv as usize * (size.rows - 1) + j) as f32 * scale;
            for i in 0..size.cols {
                let s = (bu as usize * (size.cols - 1) + i) as f32 * scale;
                let at = |k: usize| {
                    (c[0][k] * (1.0 - s) + c[1][k] * s) * (1.0 - t)
                        + (c[3][k] * (1.0 - s) + c[2][k] * s) * t
                };
                out.set(i, j, [at(0), at(1), 0.0]);
            }
        }
    }

    pub(crate) fn hull(&self, out: impl FnMut([f32; 3])) {
        self.points.hull(out);
    }
    pub(crate) fn block_hull(&self, bu: u32, bv: u32, out: impl FnMut([f32; 3])) {
        self.points.block_hull(bu, bv, out);
    }
}
