//! Spheres around models.

use crate::math::DVec3;

/// A bounding sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Its centre.
    pub center: [f64; 3],
    /// Its radius, 0 for a point or an empty model.
    pub radius: f64,
}

impl Sphere {
    /// The sphere through the corners of a box given by its smallest and largest coordinates.
    #[must_use]
    pub fn of_box(bounds: [[f32; 3]; 2]) -> Self {
        let lo = DVec3::from_array(bounds[0].map(f64::from));
        let hi = DVec3::from_array(bounds[1].map(f64::from));
        Self {
            center: ((lo + hi) * 0.5).to_array(),
            radius: ((hi - lo) * 0.5).length(),
        }
    }

    /// The sphere around the middle of the points' box that reaches the farthest point: never larger than
    /// [`Sphere::of_box`], and up to 1.7 times smaller. No points give the zero sphere.
    #[must_use]
    pub fn of_points<I>(points: I) -> Self
    where
        I: IntoIterator<Item = [f32; 3]>,
        I::IntoIter: Clone,
    {
        let points = points.into_iter();
        let mut lo = [f32::INFINITY; 3];
        let mut hi = [f32::NEG_INFINITY; 3];
        for p in points.clone() {
            for k in 0..3 {
                lo[k] = lo[k].min(p[k]);
                hi[k] = hi[k].max(p[k]);
            }
        }
        if lo[0] > hi[0] {
            return Self {
                center: [0.0; 3],
                radius: 0.0,
            };
        }
        let mut sphere = Self::of_box([lo, hi]);
        let center = DVec3::from_array(sphere.center);
        let mut farthest = 0.0_f64;
        for p in points {
            farthest =
                farthest.max((DVec3::from_array(p.map(f64::from)) - center).length_squared());
        }
        sphere.radius = farthest.sqrt();
        sphere
    }

    /// The sphere with a radius larger by `by` model units: for surfaces displaced by at most that much.
    #[must_use]
    pub fn inflated(mut self, by: f64) -> Self {
        self.radius += by;
        self
    }
}
