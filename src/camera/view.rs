//! What the stages need of a camera.

use super::{CameraError, SUBPIXELS};
use crate::records::{Projection, ScreenSize};

/// A camera resolved for one model and one picture size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Position of the eye. Of orthographic views, a point on the view axis.
    pub eye: [f32; 3],
    /// Unit vector to the right of the picture.
    pub right: [f32; 3],
    /// Unit vector to the top of the picture.
    pub up: [f32; 3],
    /// Unit vector into the picture.
    pub forward: [f32; 3],
    /// Where the depth range begins, in model units along the view axis; what is nearer is not drawn.
    pub near: f32,
    /// Where the depth range ends.
    pub far: f32,
    /// Pixels per model unit: at distance 1 in perspective, at any distance otherwise.
    pub scale: f32,
    /// The map to the screen.
    pub projection: Projection,
    /// The picture it is made for.
    pub size: ScreenSize,
    /// The up vector given is parallel to the direction of view and was replaced: worth a warning.
    pub up_replaced: bool,
}

impl View {
    /// Distance of a point from the eye along the view axis.
    #[must_use]
    #[inline]
    pub fn distance(&self, p: [f32; 3]) -> f32 {
        let f = self.forward;
        (f[0] * (p[0] - self.eye[0]) + f[1] * (p[1] - self.eye[1])) + f[2] * (p[2] - self.eye[2])
    }

    /// Pixels per model unit at a distance along the view axis. Nearer than the near plane, the value at the near plane.
    #[must_use]
    #[inline]
    pub fn pixel_scale(&self, distance: f32) -> f32 {
        if self.projection.ortho {
            self.scale
        } else {
            self.scale / distance.max(self.near)
        }
    }

    /// Position of a distance in the depth range: 0 at near, 1 at far and beyond.
    #[must_use]
    #[inline]
    pub fn depth01(&self, distance: f32) -> f32 {
        ((distance - self.near) / (self.far - self.near)).clamp(0.0, 1.0)
    }

    /// Unit vector from a point to the eye.
    #[must_use]
    #[inline]
    pub fn toward_eye(&self, p: [f32; 3]) -> [f32; 3] {
        let back = self.forward.map(|c| -c);
        if self.projection.ortho {
            return back;
        }
        crate::math::normalize(crate::math::sub(self.eye, p)).unwrap_or(back)
    }

    /// Screen position in pixels and depth of a point, or `None` where it is nearer than the near plane.
    #[must_use]
    pub fn project(&self, p: [f32; 3]) -> Option<[f32; 3]> {
        let m = &self.projection;
        let row = |r: &[f32; 4]| (r[0] * p[0] + r[1] * p[1]) + (r[2] * p[2] + r[3]);
        let w = row(&m.w);
        let (depth, seen) = if m.ortho {
            let d = row(&m.d);
            (d, d <= 2.0)
        } else {
            (1.0 / w, w >= m.near)
        };
        let unit = 1.0 / SUBPIXELS as f32;
        seen.then(|| [row(&m.x) / w * unit, row(&m.y) / w * unit, depth])
    }

    /// The line of sight through a screen position in pixels: a point on it and its unit direction.
    #[must_use]
    pub fn ray(&self, x: f32, y: f32) -> ([f32; 3], [f32; 3]) {
        let dx = (x - self.size.width as f32 * 0.5) / self.scale;
        let dy = (self.size.height as f32 * 0.5 - y) / self.scale;
        let side = [0, 1, 2].map(|k| self.right[k] * dx + self.up[k] * dy);
        if self.projection.ortho {
            (crate::math::add(self.eye, side), self.forward)
        } else {
            let d = crate::math::add(self.forward, side);
            (self.eye, crate::math::normalize(d).unwrap_or(self.forward))
        }
    }

    /// Rounded to single precision, everything is still finite and near is still a distance.
    pub(super) fn check(&self) -> Result<(), CameraError> {
        let m = &self.projection;
        let finite = |v: &[f32]| v.iter().all(|c| c.is_finite());
        let rows = [m.x, m.y, m.w, m.d];
        if !rows.iter().all(|r| finite(r))
            || !finite(&self.eye)
            || !finite(&[self.near, self.far, self.scale])
            || self.scale <= 0.0
        {
            return Err(CameraError::NotFinite {
                what: "the projection",
            });
        }
        if (!m.ortho && self.near < f32::MIN_POSITIVE) || self.near >= self.far {
            return Err(CameraError::Range {
                near: f64::from(self.near),
                far: f64::from(self.far),
            });
        }
        Ok(())
    }
}
