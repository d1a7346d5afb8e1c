//! Camera: what the user asks for ([`Camera`]), and what the stages need ([`View`]).
//!
//! A camera is either automatic (azimuth and elevation around the model, framed on its bounding sphere) or explicit (eye and
//! target). [`Camera::framing`] turns it into a view. All of this is computed in double precision with `libm` and rounded to
//! single precision once, so the same camera gives the same bits on every machine.
//!
//! Screen conventions are those of [`Projection`]: x right, y down, 1/256 pixel, depth larger when nearer.

mod sphere;
mod view;

use crate::math::{DVec3, round3};
use crate::records::{Projection, ScreenSize};
pub use sphere::Sphere;
pub use view::View;

/// Sub-pixel steps per pixel.
const SUBPIXELS: f64 = 256.0;
/// Radius of the framed sphere over that of the model's. Trades a tight picture against a rim of free pixels: at 1.0 the
/// silhouette of a sphere touches the border and loses its anti-aliased edge.
const MARGIN: f64 = 1.03;
/// Slack of the automatic near and far planes, relative to the radius. Covers the rounding of points on the sphere itself.
const DEPTH_SLACK: f64 = 0.01;
/// Smallest automatic near distance, relative to the radius; it counts when the eye is inside the sphere. Smaller lets the eye
/// come closer to a surface, larger keeps projected coordinates of points beside the eye small.
const NEAR_FLOOR: f64 = 1e-3;

/// What the user asks for, in the units of the command line. Plain data; invalid values are found by [`Camera::framing`].
///
/// ```
/// use earmark::{camera::{Camera, Sphere}, records::ScreenSize};
/// let size = ScreenSize { width: 640, height: 480, samples: 4 };
/// let sphere = Sphere::of_box([[-1.0; 3], [1.0; 3]]);
/// let view = Camera::default().with_orbit(30.0, 10.0).framing(&sphere, size)?;
/// let [x, y, _] = view.project([0.0; 3]).expect("the middle of the model is in front of the eye");
/// assert!((x - 320.0).abs() < 0.01 && (y - 240.0).abs() < 0.01);
/// # Ok::<(), earmark::camera::CameraError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Angle around the up axis in degrees: 0 looks from the front (+z for y up, -y for z up), 90 from the right.
    pub azimuth: f64,
    /// Angle above the horizon in degrees; 90 looks straight down.
    pub elevation: f64,
    /// Magnification, by a longer lens: the perspective stays.
    pub zoom: f64,
    /// Vertical field of view in degrees at zoom 1; not used by orthographic views.
    pub fov: f64,
    /// Parallel projection.
    pub ortho: bool,
    /// Position of the eye; `None` frames the model automatically.
    pub eye: Option<[f64; 3]>,
    /// The point looked at; `None` is the middle of the model.
    pub target: Option<[f64; 3]>,
    /// The direction that points up in the picture.
    pub up: [f64; 3],
    /// Distance of the near plane; `None` keeps the whole bounding sphere.
    pub near: Option<f64>,
    /// Distance where the depth range ends; `None` is just behind the bounding sphere. Nothing is clipped there.
    pub far: Option<f64>,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            azimuth: 45.0,
            elevation: 25.0,
            zoom: 1.0,
            fov: 35.0,
            ortho: false,
            eye: None,
            target: None,
            up: [0.0, 1.0, 0.0],
            near: None,
            far: None,
        }
    }
}

/// Why a camera gives no picture.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CameraError {
    /// There is no direction of view.
    #[error("eye and target are the same point")]
    EyeAtTarget,
    /// The up vector is zero.
    #[error("the up vector is zero")]
    ZeroUp,
    /// A near distance that is not above 0.
    #[error("near is {near}; it must be above 0")]
    Near {
        /// The distance given.
        near: f64,
    },
    /// An empty depth range.
    #[error("near {near} is not below far {far}")]
    Range {
        /// Near distance.
        near: f64,
        /// Far distance.
        far: f64,
    },
    /// A field of view outside 0 to 180 degrees.
    #[error("the field of view is {fov} degrees; it must be above 0 and below 180")]
    Fov {
        /// The angle given.
        fov: f64,
    },
    /// A zoom that is not above 0.
    #[error("zoom is {zoom}; it must be above 0")]
    Zoom {
        /// The factor given.
        zoom: f64,
    },
    /// A number that is not finite, or a result that leaves single precision.
    #[error("{what} is not finite or too large")]
    NotFinite {
        /// Which number.
        what: &'static str,
    },
    /// A picture without pixels.
    #[error("the picture has no pixels")]
    EmptyPicture,
}

impl Camera {
    /// The same camera at another azimuth and elevation, in degrees.
    #[must_use]
    pub fn with_orbit(mut self, azimuth: f64, elevation: f64) -> Self {
        (self.azimuth, self.elevation) = (azimuth, elevation);
        self
    }
    /// The same camera with another magnification.
    #[must_use]
    pub fn with_zoom(mut self, zoom: f64) -> Self {
        self.zoom = zoom;
        self
    }
    /// The same camera with another vertical field of view, in degrees.
    #[must_use]
    pub fn with_fov(mut self, fov: f64) -> Self {
        self.fov = fov;
        self
    }
    /// The same camera in parallel projection.
    #[must_use]
    pub fn with_ortho(mut self) -> Self {
        self.ortho = true;
        self
    }
    /// The same camera at a given place, looking at a given point.
    #[must_use]
    pub fn with_eye_target(mut self, eye: [f64; 3], target: [f64; 3]) -> Self {
        (self.eye, self.target) = (Some(eye), Some(target));
        self
    }
    /// The same camera with another up direction. Automatic views orbit around it.
    #[must_use]
    pub fn with_up(mut self, up: [f64; 3]) -> Self {
        self.up = up;
        self
    }
    /// The same camera with a given depth range.
    #[must_use]
    pub fn with_near_far(mut self, near: f64, far: f64) -> Self {
        (self.near, self.far) = (Some(near), Some(far));
        self
    }
    /// The same camera in coordinates relative to `origin`, for cages that are stored so
    /// ([`Cage::origin`](crate::Cage::origin)).
    #[must_use]
    pub fn relative_to(mut self, origin: [f64; 3]) -> Self {
        let shift = |p: [f64; 3]| [p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]];
        (self.eye, self.target) = (self.eye.map(shift), self.target.map(shift));
        self
    }

    /// Resolves the camera for a model inside `sphere` and a picture of `size`.
    ///
    /// An automatic view shows the whole sphere with a small margin in the smaller side of the picture. An empty model is
    /// framed as a sphere of radius 1.
    ///
    /// # Errors
    /// [`CameraError`] for values that give no picture.
    pub fn framing(&self, sphere: &Sphere, size: ScreenSize) -> Result<View, CameraError> {
        self.check(sphere, size)?;
        let center = DVec3::from_array(sphere.center);
        let radius = if sphere.radius > 0.0 {
            sphere.radius
        } else {
            1.0
        };
        let up = DVec3::from_array(self.up);
        let up = up / up.length();
        let target = self.target.map_or(center, DVec3::from_array);

        let (width, height) = (f64::from(size.width), f64::from(size.height));
        // Tangent of half the angle over the smaller side: what the sphere must fit into.
        let tan_vertical = libm::tan(self.fov.to_radians() * 0.5);
        let tan_smaller = tan_vertical * (width / height).min(1.0);
        let sin_smaller = tan_smaller / (1.0 + tan_smaller * tan_smaller).sqrt();

        let mut up_replaced = false;
        let (eye, right, up, forward) = match self.eye {
            None => {
                let (right, up, forward) = self.orbit_axes(up);
                let distance = radius * MARGIN / sin_smaller;
                (target - forward * distance, right, up, forward)
            }
            Some(eye) => {
                let eye = DVec3::from_array(eye);
                let forward = target - eye;
                let length = forward.length();
                if length.is_nan() || length <= 0.0 {
                    return Err(CameraError::EyeAtTarget);
                }
                let forward = forward / length;
                let mut right = forward.cross(up);
                if right.length() < 1e-6 {
                    // Looking along the up vector: the axis farthest from it serves instead.
                    up_replaced = true;
                    right = forward.cross(if forward.y.abs() > 0.9 {
                        DVec3::new(0.0, 0.0, -forward.y.signum())
                    } else {
                        DVec3::Y
                    });
                }
                let right = right / right.length();
                (eye, right, right.cross(forward), forward)
            }
        };

        // Pixels per model unit at distance 1 (perspective) or everywhere (orthographic).
        let scale = self.zoom
            * if self.ortho {
                width.min(height) * 0.5 / (radius * MARGIN)
            } else {
                height * 0.5 / tan_vertical
            };
        let (near, far) = self.depth_range((center - eye).dot(forward), radius)?;

        let row = |v: DVec3| [v.x, v.y, v.z, -v.dot(eye)];
        let combine = |axis: [f64; 4], s: f64, w: [f64; 4], c: f64| {
            [0, 1, 2, 3].map(|k| (axis[k] * s + w[k] * c) as f32)
        };
        let z = row(forward);
        let w = if self.ortho { [0.0, 0.0, 0.0, 1.0] } else { z };
        let s = scale * SUBPIXELS;
        let projection = Projection {
            x: combine(row(right), s, w, width * 0.5 * SUBPIXELS),
            y: combine(row(up), -s, w, height * 0.5 * SUBPIXELS),
            w: w.map(|c| c as f32),
            d: if self.ortho {
                let k = 1.0 / (far - near);
                combine(z, -k, [0.0, 0.0, 0.0, 1.0], 1.0 + far * k)
            } else {
                [0.0; 4]
            },
            near: near as f32,
            ortho: self.ortho,
        };
        let view = View {
            eye: round3(eye),
            right: round3(right),
            up: round3(up),
            forward: round3(forward),
            near: near as f32,
            far: far as f32,
            scale: scale as f32,
            projection,
            size,
            up_replaced,
        };
        view.check()?;
        Ok(view)
    }

    /// Refuses numbers that are not finite or out of range.
    fn check(&self, sphere: &Sphere, size: ScreenSize) -> Result<(), CameraError> {
        let all = |v: &[f64]| v.iter().all(|c| c.is_finite());
        for (what, ok) in [
            ("azimuth", self.azimuth.is_finite()),
            ("elevation", self.elevation.is_finite()),
            ("zoom", self.zoom.is_finite()),
            ("the field of view", self.fov.is_finite()),
            ("eye", self.eye.is_none_or(|v| all(&v))),
            ("target", self.target.is_none_or(|v| all(&v))),
            ("up", all(&self.up)),
            ("near", self.near.is_none_or(f64::is_finite)),
            ("far", self.far.is_none_or(f64::is_finite)),
            (
                "the size of the model",
                all(&sphere.center) && sphere.radius.is_finite(),
            ),
        ] {
            if !ok {
                return Err(CameraError::NotFinite { what });
            }
        }
        if self.fov <= 0.0 || self.fov >= 180.0 {
            return Err(CameraError::Fov { fov: self.fov });
        }
        if self.zoom <= 0.0 {
            return Err(CameraError::Zoom { zoom: self.zoom });
        }
        if size.width == 0 || size.height == 0 {
            return Err(CameraError::EmptyPicture);
        }
        if self.up.iter().map(|c| c * c).sum::<f64>() <= 0.0 {
            return Err(CameraError::ZeroUp);
        }
        Ok(())
    }

    /// Right, up and forward of an automatic view around the unit vector `up`. Made from the angles directly, so that looking
    /// straight down is no special case.
    fn orbit_axes(&self, up: DVec3) -> (DVec3, DVec3, DVec3) {
        let (az, el) = (self.azimuth.to_radians(), self.elevation.to_radians());
        let (sa, ca) = (libm::sin(az), libm::cos(az));
        let (se, ce) = (libm::sin(el), libm::cos(el));
        let right = DVec3::new(ca, 0.0, -sa);
        let back = DVec3::new(sa * ce, se, ca * ce);
        // The shortest turn from y to `up`: z up then has its front at -y, and keeps x.
        let axis = DVec3::Y.cross(up);
        let cosine = up.y;
        let turn = |v: DVec3| {
            if cosine < -0.999_999_999 {
                DVec3::new(v.x, -v.y, -v.z)
            } else {
                v + axis.cross(v) + axis.cross(axis.cross(v)) / (1.0 + cosine)
            }
        };
        let (right, back) = (turn(right), turn(back));
        (right, back.cross(right), -back)
    }

    /// Near and far for a sphere whose middle is `distance` along the view axis.
    fn depth_range(&self, distance: f64, radius: f64) -> Result<(f64, f64), CameraError> {
        let reach = radius * (1.0 + DEPTH_SLACK);
        let floor = radius * NEAR_FLOOR;
        if let Some(near) = self.near
            && near <= 0.0
        {
            return Err(CameraError::Near { near });
        }
        let near = self.near.unwrap_or_else(|| {
            let auto = if self.ortho {
                distance - reach
            } else {
                (distance - reach).max(floor)
            };
            // A far plane given in front of the model must leave room for a near plane.
            match self.far {
                Some(far) if far > 0.0 => auto.min(far * 0.5),
                _ => auto,
            }
        });
        let far = self.far.unwrap_or_else(|| {
            (distance + reach).max(near + if self.ortho { floor } else { near.max(floor) })
        });
        if near >= far {
            return Err(CameraError::Range { near, far });
        }
        Ok((near, far))
    }
}
