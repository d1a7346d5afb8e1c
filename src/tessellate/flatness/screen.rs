//! Distances in pixels, and whether they are small enough.

use super::Flatness;
use super::surplus::Six;
use crate::camera::View;
#[cfg(feature = "gpu")]
use crate::dice::MAX_LEVEL;
use crate::tessellate::Reach;

/// What the tests leave of the tolerance to what they do not see: inside of a triangle it may be a third further away than along its
/// sides, and a moved point stretches a triangle (measured: 0.62 leaves a fifth, 0.75 goes beyond the tolerance where blocks are small).
const SHARE: f32 = 0.62;
/// The same of the tolerance of normals.
const NORMAL_SHARE: f32 = 0.75;

/// Measures distances as a view sees them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Metric<'a> {
    view: &'a View,
    /// Pixels and radians that are allowed.
    whole: [f32; 2],
    /// Per pixel that is allowed.
    pixels: f32,
    /// Per largest chord between unit normals.
    chord: f32,
    pub(super) max_level: u32,
    pub(super) reach: Reach,
}

/// Where points are for the eye: to the right, up, and away from it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    eye: [f32; 3],
    axes: [[f32; 3]; 3],
}

impl Seen {
    #[inline(always)]
    pub(super) fn point(&self, p: [f32; 3]) -> [f32; 3] {
        let (x, y, z) = (p[0] - self.eye[0], p[1] - self.eye[1], p[2] - self.eye[2]);
        let along = |a: [f32; 3]| (a[0] * x + a[1] * y) + a[2] * z;
        [
            along(self.axes[0]),
            along(self.axes[1]),
            along(self.axes[2]),
        ]
    }
}

/// What a metric allows, for who measures elsewhere.
#[cfg(feature = "gpu")]
pub(crate) struct Numbers {
    /// Per pixel that the tests allow.
    pub(crate) pixels: f32,
    /// Per largest chord between unit normals.
    pub(crate) chord: f32,
    /// Pixels and radians that are allowed as a whole.
    pub(crate) whole: [f32; 2],
    /// Deepest level.
    pub(crate) max_level: u32,
}

#[cfg(feature = "gpu")]
impl Numbers {
    /// Of splines, which can be prepared for any level.
    pub(crate) fn new(view: &View, flatness: &Flatness) -> Self {
        let reach = Reach {
            level: MAX_LEVEL,
            always: false,
            squares: MAX_LEVEL,
        };
        let metric = Metric::new(view, flatness, reach);
        Self {
            pixels: metric.pixels,
            chord: metric.chord,
            whole: metric.whole,
            max_level: metric.max_level,
        }
    }
}

impl<'a> Metric<'a> {
    pub(super) fn new(view: &'a View, flatness: &Flatness, reach: Reach) -> Self {
        let pixels = (flatness.pixels * SHARE).max(1e-3);
        let chord =
            2.0 * libm::sinf(flatness.degrees.clamp(0.01, 180.0).to_radians() * 0.5 * NORMAL_SHARE);
        Self {
            view,
            whole: [
                flatness.pixels.max(1e-3),
                flatness.degrees.clamp(0.01, 180.0).to_radians(),
            ],
            pixels: 1.0 / pixels,
            chord: 1.0 / chord,
            max_level: flatness.max_level.min(reach.level),
            reach,
        }
    }

    /// The near plane, pixels per model unit (in perspective at distance 1), and whether there is no perspective.
    pub(super) fn projection(&self) -> (f32, f32, bool) {
        let v = self.view;
        (v.near, v.scale, v.projection.ortho)
    }

    /// What is allowed as a whole: pixels, and radians between normals.
    pub(super) fn tolerances(&self) -> [f32; 2] {
        self.whole
    }

    pub(super) fn seen(&self) -> Seen {
        let v = self.view;
        Seen {
            eye: v.eye,
            axes: [v.right, v.up, v.forward],
        }
    }

    /// Distance along the view axis; what is nearer than the near plane is as far behind it.
    #[inline(always)]
    pub(super) fn depth(&self, p: [f32; 3]) -> f32 {
        let near = self.view.near;
        near + (self.view.distance(p) - near).abs()
    }

    /// Sides of the picture that a point is beyond, as the eye sees it: one bit for each, and one for the near plane.
    #[inline(always)]
    pub(super) fn outside(&self, [x, y, z]: [f32; 3]) -> u8 {
        let v = self.view;
        let half = [v.size.width, v.size.height].map(|n| 0.5 * n as f32 / v.scale);
        let z = if v.projection.ortho { 1.0 } else { z };
        let [w, h] = half.map(|k| k * z);
        u8::from(x > w)
            | u8::from(x < -w) << 1
            | u8::from(y > h) << 2
            | u8::from(y < -h) << 3
            | u8::from(z < v.near) << 4
    }

    /// Of a height that may stand anywhere on a surface whose nearest point is at depth `nearest`, by what is allowed.
    pub(super) fn height(&self, height: f32, nearest: f32) -> f32 {
        let pixels = match self.view.projection.ortho {
            true => height * self.view.scale,
            false => height * self.view.scale / nearest,
        };
        pixels * self.pixels
    }

    /// Of points `p` and the ends of their edges, which are `ends[i]` and `ends[i + next]` of point `i`, each as the eye sees it and with its
    /// unit normal: how far the point is from the edge's middle, and its normal from what the ends' make there, by what is allowed; and the
    /// edge's length in pixels.
    ///
    /// What is nearer than the near plane is as far behind it (Bunnell), so that surfaces through the plane are refined and not for ever.
    #[inline(always)]
    pub(super) fn surpluses(&self, p: &Six, ends: &Six, next: usize, found: [&mut [f32]; 3]) {
        let (near, scale, ortho) = (self.view.near, self.view.scale, self.view.projection.ortho);
        let [far, bend, length] = found;
        let n = far.len();
        let (bend, length) = (&mut bend[..n], &mut length[..n]);
        let (px, py, pz) = (&p[0][..n], &p[1][..n], &p[2][..n]);
        let a = |k: usize| &ends[k][..n];
        let b = |k: usize| &ends[k][next..next + n];
        let (ax, ay, az) = (a(0), a(1), a(2));
        let (bx, by, bz) = (b(0), b(1), b(2));
        for i in 0..n {
            let (mx, my) = ((ax[i] + bx[i]) * 0.5, (ay[i] + by[i]) * 0.5);
            let (ex, ey) = (px[i] - mx, py[i] - my);
            let (lx, ly) = (bx[i] - ax[i], by[i] - ay[i]);
            let depth = |z: f32| near + (z - near).abs();
            let (zp, za, zb) = (depth(pz[i]), depth(az[i]), depth(bz[i]));
            let zm = depth((az[i] + bz[i]) * 0.5);
            // (xp / zp − xm / zm) = (e − xm / zm · (zp − zm)) / zp, without the difference of two large numbers.
            let (off, run) = ((zp - zm) / zm, (zb - za) / za);
            let (off, run) = if ortho { (0.0, 0.0) } else { (off, run) };
            // Between samples the surface may come as near as its nearest one.
            let close = if ortho {
                scale
            } else {
                scale / zp.min(za).min(zb)
            };
            let (ex, ey) = (ex - mx * off, ey - my * off);
            let (lx, ly) = (lx - ax[i] * run, ly - ay[i] * run);
            far[i] = (ex * ex + ey * ey).sqrt() * (close * self.pixels);
            length[i] = (lx * lx + ly * ly).sqrt() * close;
        }
        let (px, py, pz) = (&p[3][..n], &p[4][..n], &p[5][..n]);
        let (ax, ay, az) = (a(3), a(4), a(5));
        let (bx, by, bz) = (b(3), b(4), b(5));
        for i in 0..n {
            let (x, y, z) = (ax[i] + bx[i], ay[i] + by[i], az[i] + bz[i]);
            let square = (x * x + y * y) + z * z;
            // Where opposite normals meet, all is too far.
            let inverse = if square < 1e-12 {
                0.0
            } else {
                1.0 / square.sqrt()
            };
            let (x, y, z) = (
                px[i] - x * inverse,
                py[i] - y * inverse,
                pz[i] - z * inverse,
            );
            bend[i] = ((x * x + y * y) + z * z).sqrt() * self.chord;
        }
    }
}
