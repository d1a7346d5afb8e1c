//! Distances in pixels, and whether they are small enough.

use super::Flatness;
use crate::camera::View;
use crate::math;
use crate::tessellate::Reach;

/// What the tests leave of the tolerance to what they do not see: samples are a quarter of a cell apart, and a moved point stretches a triangle.
const SHARE: f32 = 0.65;
/// The same of the tolerance of normals.
const NORMAL_SHARE: f32 = 0.85;

/// Measures distances as a view sees them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Metric<'a> {
    view: &'a View,
    /// Square of the tolerance.
    pixels: f32,
    /// Square of the largest chord between unit normals.
    chord: f32,
    pub(super) max_level: u32,
    pub(super) reach: Reach,
}

/// How far something is from what is allowed: above 1 it is too far.
pub(super) type Excess = f32;

impl<'a> Metric<'a> {
    pub(super) fn new(view: &'a View, flatness: &Flatness, reach: Reach) -> Self {
        let pixels = (flatness.pixels * SHARE).max(1e-3);
        let chord =
            2.0 * libm::sinf(flatness.degrees.clamp(0.01, 180.0).to_radians() * 0.5 * NORMAL_SHARE);
        Self {
            view,
            pixels: pixels * pixels,
            chord: chord * chord,
            max_level: flatness.max_level.min(reach.level),
            reach,
        }
    }

    /// Distance along the view axis; what is nearer than the near plane is as far behind it (Bunnell), so that surfaces through the plane
    /// are refined and not for ever.
    #[inline(always)]
    pub(super) fn depth(&self, p: [f32; 3]) -> f32 {
        let near = self.view.near;
        near + (self.view.distance(p) - near).abs()
    }

    /// Square of the distance in pixels between `p`, and `q` close to it.
    #[inline(always)]
    pub(super) fn square(&self, p: [f32; 3], q: [f32; 3]) -> f32 {
        let v = self.view;
        let e = math::sub(p, q);
        let (x, y) = (math::dot(v.right, e), math::dot(v.up, e));
        if v.projection.ortho {
            return (x * x + y * y) * (v.scale * v.scale);
        }
        let (zp, zq) = (self.depth(p), self.depth(q));
        // (xp / zp − xq / zq) = (e − xq / zq · (zp − zq)) / zp, without the difference of two large numbers.
        let from = math::sub(q, v.eye);
        let step = (zp - zq) / zq;
        let (x, y) = (
            x - math::dot(v.right, from) * step,
            y - math::dot(v.up, from) * step,
        );
        let scale = v.scale / zp;
        (x * x + y * y) * (scale * scale)
    }

    /// Of a point of the surface and its triangle's, in a cell whose nearest point is at depth `nearest`: between its samples it may come as
    /// near as that.
    #[inline(always)]
    pub(super) fn point(&self, p: [f32; 3], q: [f32; 3], nearest: f32) -> Excess {
        let closer = if self.view.projection.ortho {
            1.0
        } else {
            self.depth(p) / nearest
        };
        self.square(p, q) * (closer * closer) / self.pixels
    }

    /// Of a height that may stand anywhere on a surface whose nearest point is at depth `nearest`.
    pub(super) fn height(&self, height: f32, nearest: f32) -> Excess {
        let pixels = match self.view.projection.ortho {
            true => height * self.view.scale,
            false => height * self.view.scale / nearest,
        };
        pixels * pixels / self.pixels
    }

    /// Of a unit normal of the surface, and the sum of its triangle's.
    #[inline(always)]
    pub(super) fn normal(&self, n: [f32; 3], sum: [f32; 3]) -> Excess {
        let length = math::dot(sum, sum);
        if length < 1e-12 {
            return 2.0;
        }
        let m = math::scale(sum, 1.0 / length.sqrt());
        let e = math::sub(n, m);
        math::dot(e, e) / self.chord
    }

    /// Whether something between these points is too small to have normals of its own.
    #[inline(always)]
    pub(super) fn is_dot(&self, corners: &[[f32; 3]]) -> bool {
        /// Square of the size in pixels.
        const DOT: f32 = 1.0;
        corners.iter().all(|&p| self.square(p, corners[0]) <= DOT)
    }
}
