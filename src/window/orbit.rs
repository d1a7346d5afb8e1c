//! The camera under the mouse. What a drag does depends on where it begins and ends, never on how many events came between; only what would
//! have gone beyond a limit, as over a pole, is lost on the way.
//!
//! * Orbit: a drag over the smaller side of the window turns by 180 degrees.
//! * Pan: the point under the pointer, in the plane of the target, stays under it.
//! * Zoom: the same, by a longer or shorter lens.
//!
//! The state is a [`Camera`], in the units of the command line; its numbers are rounded so that they print short, and the picture is drawn
//! from the rounded ones.

use crate::camera::{Camera, CameraError, Sphere};
use crate::math::DVec3;
use crate::records::ScreenSize;

/// Degrees of a drag over the smaller side of the window.
const TURN: f64 = 180.0;
/// Magnification of one notch of the wheel.
const NOTCH: f64 = 1.1;
/// Least and largest zoom; beyond it single precision shows.
const ZOOM: [f64; 2] = [0.01, 1000.0];
/// Highest elevation of a camera with an eye, whose up direction has to differ from its own.
const STEEPEST: f64 = 89.9;

/// How the window shows the plane through the target that faces the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pose {
    /// Unit vector to the right of the window.
    right: DVec3,
    /// Unit vector to its top.
    up: DVec3,
    /// The point in the middle of the window, in model units.
    target: DVec3,
    /// Position of the eye.
    eye: DVec3,
    /// Model units per pixel at the target.
    unit: f64,
    /// Pixels across and down.
    size: [f64; 2],
}

impl Pose {
    /// The pose of a camera before a model inside `sphere` whose coordinates are relative to `origin`, in a window of `size` pixels.
    ///
    /// # Errors
    /// [`CameraError`] where the camera gives no picture.
    pub(super) fn new(
        camera: &Camera,
        sphere: &Sphere,
        origin: [f64; 3],
        size: [u32; 2],
    ) -> Result<Self, CameraError> {
        let [width, height] = size;
        let samples = 1;
        let screen = ScreenSize {
            width,
            height,
            samples,
        };
        let view = camera.relative_to(origin).framing(sphere, screen)?;
        let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let origin = DVec3::from_array(origin);
        let center = DVec3::from_array(sphere.center) + origin;
        let target = camera.target.map_or(center, DVec3::from_array);
        let eye = wide(view.eye) + origin;
        let scale = f64::from(view.scale);
        let unit = match camera.ortho {
            true => 1.0 / scale,
            false => (target - eye).dot(wide(view.forward)) / scale,
        };
        Ok(Self {
            right: wide(view.right),
            up: wide(view.up),
            target,
            eye,
            unit,
            size: size.map(f64::from),
        })
    }

    /// The vector between two pixels of the plane through the target.
    fn across(&self, pixels: [f64; 2]) -> DVec3 {
        (self.right * pixels[0] - self.up * pixels[1]) * self.unit
    }
}

/// The camera of the window, and the one to come back to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Orbit {
    camera: Camera,
    home: Camera,
}

/// The step to which azimuth and elevation, in degrees, and zoom are rounded.
const FINE: f64 = 1e-4;

fn rounded(x: f64, step: f64) -> f64 {
    // The step as a power of ten the other way: x / 1e-4 * 1e-4 has a tail.
    let per_unit = libm::round(1.0 / step);
    match per_unit >= 1.0 && per_unit.is_finite() {
        true => libm::round(x * per_unit) / per_unit,
        false => x,
    }
}

impl Orbit {
    /// Begins with a camera.
    #[must_use]
    pub(super) fn new(camera: Camera) -> Self {
        Self {
            camera,
            home: camera,
        }
    }

    /// The camera of the picture.
    #[must_use]
    pub(super) fn camera(&self) -> Camera {
        let mut c = self.camera;
        if c != self.home {
            c.azimuth = rounded(c.azimuth, FINE);
            c.elevation = rounded(c.elevation, FINE);
            c.zoom = rounded(c.zoom, FINE);
        }
        c
    }

    /// Back to where it began.
    pub(super) fn reset(&mut self) {
        self.camera = self.home;
    }

    /// Perspective to parallel projection, and back.
    pub(super) fn toggle_ortho(&mut self) {
        self.camera.ortho = !self.camera.ortho;
    }

    /// Looks from an azimuth and elevation in degrees, at the middle of the model.
    pub(super) fn look_from(&mut self, azimuth: f64, elevation: f64) {
        self.camera = Camera {
            eye: None,
            target: None,
            zoom: 1.0,
            ..self.camera.with_orbit(azimuth, elevation)
        };
    }

    /// A drag by so many pixels to the right and down, which takes the model along.
    pub(super) fn drag(&mut self, pixels: [f64; 2], pose: &Pose) {
        let per_pixel = TURN / pose.size[0].min(pose.size[1]).max(1.0);
        self.turn([-pixels[0] * per_pixel, pixels[1] * per_pixel], pose);
    }

    /// Turns the camera around the target, by degrees to the right and upwards.
    pub(super) fn turn(&mut self, degrees: [f64; 2], pose: &Pose) {
        let camera = &mut self.camera;
        if camera.eye.is_none() {
            let azimuth = camera.azimuth + degrees[0];
            camera.azimuth = azimuth - 360.0 * libm::round(azimuth / 360.0);
            camera.elevation = (camera.elevation + degrees[1]).clamp(-90.0, 90.0);
            return;
        }
        let up = DVec3::from_array(camera.up);
        let up = up / up.length();
        let back = pose.eye - pose.target;
        let height = libm::asin((back.dot(up) / back.length()).clamp(-1.0, 1.0)).to_degrees();
        let wanted = (height + degrees[1]).clamp(-STEEPEST, STEEPEST);
        let back = rotated(back, pose.right, height - wanted);
        let back = rotated(back, up, degrees[0]);
        camera.eye = Some((pose.target + back).to_array());
        camera.target = Some(pose.target.to_array());
    }

    /// Moves the model by so many pixels to the right and down.
    pub(super) fn pan(&mut self, pixels: [f64; 2], pose: &Pose) {
        self.shift(-pose.across(pixels), pose);
    }

    /// Turns the wheel by so many notches, away from the user to come nearer, with the pointer at a pixel.
    pub(super) fn zoom(&mut self, notches: f64, at: [f64; 2], pose: &Pose) {
        let before = self.camera.zoom;
        let zoom = (before * libm::pow(NOTCH, notches)).clamp(ZOOM[0], ZOOM[1]);
        self.camera.zoom = zoom;
        let middle = pose.size.map(|side| side * 0.5);
        // What is under the pointer comes nearer to the middle by the part that the lens gains.
        let gain = 1.0 - before / zoom;
        let off = [(at[0] - middle[0]) * gain, (at[1] - middle[1]) * gain];
        if off != [0.0; 2] {
            self.shift(pose.across(off), pose);
        }
    }

    /// Moves target and eye, to numbers a thousandth of a pixel apart.
    fn shift(&mut self, by: DVec3, pose: &Pose) {
        // A power of ten below a thousandth of a pixel.
        let step = libm::pow(10.0, libm::floor(libm::log10(pose.unit * 1e-3)));
        let place = |p: DVec3| Some(p.to_array().map(|x| rounded(x, step)));
        self.camera.target = place(pose.target + by);
        if self.camera.eye.is_some() {
            self.camera.eye = place(pose.eye + by);
        }
    }
}

/// `v` turned around the unit vector `axis`, counter-clockwise seen from its tip.
fn rotated(v: DVec3, axis: DVec3, degrees: f64) -> DVec3 {
    let angle = degrees.to_radians();
    let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
    v * cosine + axis.cross(v) * sine + axis * (axis.dot(v) * (1.0 - cosine))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [1280, 720];
    const ORIGIN: [f64; 3] = [10.0, -20.0, 5.0];

    fn sphere() -> Sphere {
        Sphere {
            center: [0.5, -0.25, 0.125],
            radius: 2.0,
        }
    }

    fn pose(orbit: &Orbit) -> Pose {
        Pose::new(&orbit.camera(), &sphere(), ORIGIN, SIZE).unwrap()
    }

    /// Where a point in model units is seen.
    fn seen(orbit: &Orbit, p: DVec3) -> [f64; 2] {
        let [width, height] = SIZE;
        let screen = ScreenSize {
            width,
            height,
            samples: 1,
        };
        let camera = orbit.camera().relative_to(ORIGIN);
        let view = camera.framing(&sphere(), screen).unwrap();
        let p = (p - DVec3::from_array(ORIGIN)).to_array();
        let [x, y, _] = view.project(p.map(|c| c as f32)).unwrap();
        [f64::from(x), f64::from(y)]
    }

    fn starts() -> Vec<Orbit> {
        let plain = Camera::default();
        let mut out = Vec::new();
        for camera in [
            plain,
            plain.with_ortho(),
            plain.with_zoom(7.0).with_orbit(-120.0, 80.0),
            plain.with_up([0.0, 0.0, 1.0]),
            plain.with_eye_target([14.0, -17.0, 9.0], [10.0, -20.0, 5.5]),
        ] {
            out.push(Orbit::new(camera));
        }
        out
    }

    fn close(a: [f64; 2], b: [f64; 2], pixels: f64) {
        let far = (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
        assert!(far < pixels, "{a:?} is not {b:?}");
    }

    #[test]
    fn what_is_under_the_pointer_is_moved_with_it() {
        for start in starts() {
            for from in [[640.0, 360.0], [100.0, 650.0], [1279.0, 3.0]] {
                let mut orbit = start;
                let p = pose(&orbit);
                let point = p.target + p.across([from[0] - 640.0, from[1] - 360.0]);
                close(seen(&orbit, point), from, 0.02);
                orbit.pan([123.0, -57.0], &p);
                close(seen(&orbit, point), [from[0] + 123.0, from[1] - 57.0], 0.05);
            }
        }
    }

    #[test]
    fn zoom_keeps_the_point_under_the_pointer() {
        for start in starts() {
            for notches in [1.0, -4.0, 12.5] {
                let mut orbit = start;
                let p = pose(&orbit);
                let at = [900.0, 200.0];
                let point = p.target + p.across([at[0] - 640.0, at[1] - 360.0]);
                let zoom = orbit.camera().zoom;
                orbit.zoom(notches, at, &p);
                close(seen(&orbit, point), at, 0.1);
                let gained = orbit.camera().zoom / zoom;
                assert!((gained / NOTCH.powf(notches) - 1.0).abs() < 1e-3);
            }
        }
        // In the middle nothing but the lens changes.
        let mut orbit = Orbit::new(Camera::default());
        let p = pose(&orbit);
        orbit.zoom(3.0, [640.0, 360.0], &p);
        assert_eq!(orbit.camera().target, None);
    }

    #[test]
    fn many_small_drags_are_one_large_one() {
        for start in starts() {
            let (mut one, mut many) = (start, start);
            one.drag([300.0, -20.0], &pose(&one));
            for _ in 0..100 {
                let p = pose(&many);
                many.drag([3.0, -0.2], &p);
            }
            let (a, b) = (pose(&one), pose(&many));
            assert!((a.right - b.right).length() < 2e-4, "{start:?}");
            assert!((a.eye - b.eye).length() < 2e-3, "{start:?}");
            assert!((a.target - b.target).length() < 1e-9);
        }
    }

    #[test]
    fn a_drag_over_the_window_turns_by_half() {
        let mut orbit = Orbit::new(Camera::default());
        let p = pose(&orbit);
        orbit.drag([100.0, 40.0], &p);
        assert_eq!(orbit.camera().azimuth, 20.0);
        assert_eq!(orbit.camera().elevation, 35.0);
        orbit.drag([720.0 * 3.0, 720.0 * 9.0], &p);
        assert_eq!(orbit.camera().azimuth, -160.0);
        assert_eq!(orbit.camera().elevation, 90.0);
        orbit.reset();
        assert_eq!(orbit.camera(), Camera::default());
    }

    #[test]
    fn the_model_follows_the_pointer_for_both_kinds_of_camera() {
        for start in starts() {
            let mut orbit = start;
            let p = pose(&orbit);
            // A point in front of the target moves to the right and down.
            let near = p.target + (p.eye - p.target) / (p.eye - p.target).length();
            orbit.drag([20.0, 10.0], &p);
            let [x, y] = seen(&orbit, near);
            assert!(x > 641.0, "{start:?}: {x}");
            assert!(y > 360.5, "{start:?}: {y}");
        }
    }

    #[test]
    fn eyes_stay_off_the_pole() {
        let mut orbit = starts()[4];
        for _ in 0..50 {
            let p = pose(&orbit);
            orbit.drag([5.0, 700.0], &p);
            assert!(orbit.camera().eye.unwrap().iter().all(|c| c.is_finite()));
        }
        let p = pose(&orbit);
        let back = (p.eye - p.target) / (p.eye - p.target).length();
        assert!(back.y > 0.999 && back.y < 0.999_999_9);
    }

    #[test]
    fn numbers_print_short() {
        let mut orbit = Orbit::new(Camera::default());
        let p = pose(&orbit);
        orbit.drag([1.0, 1.0], &p);
        orbit.pan([1.0 / 3.0, 0.7], &p);
        orbit.zoom(0.3, [1.0, 2.0], &p);
        let c = orbit.camera();
        for x in [c.azimuth, c.elevation, c.zoom] {
            assert!(x.to_string().len() <= 9, "{x}");
        }
        for x in c.target.unwrap() {
            assert!(x.to_string().len() <= 11, "{x}");
        }
    }
}
