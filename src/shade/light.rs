//! The studio: three lights and a soft surround, fixed to the camera, and how a matt surface answers them.
//!
//! A key light from the upper left models the form, a weak cool fill from the right opens the shadow, a rim light from behind
//! separates the silhouette from any background; above and below a surround of two colours. The diffuse answer is wrapped
//! around the terminator, so that form shadows have no hard line, the highlight is a broad Blinn lobe, and a shoulder keeps
//! everything below white. All light is linear.
//!
//! The arithmetic is one straight line without branches, in [`LightRig::light`]: the loop over many points in
//! [`super::Shader::shade_all`] becomes vector code, and gives the same bits as one point at a time.

use crate::camera::View;
use crate::math::{DVec3, dot, positive, round3};

/// A lamp: where its light comes from and what it adds.
#[derive(Clone, Copy, Debug)]
struct Lamp {
    /// Unit vector to the lamp, model space.
    toward: [f32; 3],
    /// Linear colour times strength.
    color: [f32; 3],
}

/// Directions are in camera axes: right, up, towards the eye.
const KEY: ([f64; 3], [f32; 3]) = ([-0.55, 0.66, 0.52], [1.16, 1.10, 1.01]);
const FILL: ([f64; 3], [f32; 3]) = ([0.88, -0.05, 0.48], [0.085, 0.105, 0.135]);
const RIM: ([f64; 3], [f32; 3]) = ([0.62, 0.42, -0.66], [1.30, 1.34, 1.40]);
const SKY: [f32; 3] = [0.125, 0.135, 0.155];
const GROUND: [f32; 3] = [0.052, 0.046, 0.040];
/// How far light reaches around the terminator: 0 is Lambert's hard one, 1 leaves no dark side.
const WRAP: f32 = 0.22;
/// Strength of the highlight facing the eye; larger looks like plastic.
const GLOSS: f32 = 0.18;
/// What it gains towards the silhouette.
const RISE: f32 = 0.9;
/// Where the shoulder begins: below, light is shown as it is; above, it approaches 1 and never arrives.
const KNEE: f32 = 0.62;

/// The lights of a view, in model space.
#[derive(Clone, Copy, Debug)]
pub struct LightRig {
    key: Lamp,
    fill: Lamp,
    rim: Lamp,
    up: [f32; 3],
}

impl LightRig {
    /// The lights for a camera.
    #[must_use]
    pub fn new(view: &View) -> Self {
        Self::turned(view, 0.0)
    }

    /// The same, turned by `degrees` around the direction that points up in the picture: above 0, the key light comes from further right.
    #[must_use]
    pub fn turned(view: &View, degrees: f64) -> Self {
        let axis = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let (mut right, up, mut back) = (axis(view.right), axis(view.up), -axis(view.forward));
        if degrees != 0.0 {
            let (sine, cosine) = (
                libm::sin(degrees.to_radians()),
                libm::cos(degrees.to_radians()),
            );
            (right, back) = (right * cosine - back * sine, back * cosine + right * sine);
        }
        let lamp = |(d, color): ([f64; 3], [f32; 3])| {
            let v = right * d[0] + up * d[1] + back * d[2];
            Lamp {
                toward: round3(v / v.length()),
                color,
            }
        };
        Self {
            key: lamp(KEY),
            fill: lamp(FILL),
            rim: lamp(RIM),
            up: view.up,
        }
    }

    /// All numbers of the studio, for shading elsewhere: unit vectors to key, fill and rim light, their colours, up, surround from above and
    /// below, and wrap, gloss, rise and knee.
    #[cfg(feature = "gpu")]
    pub(crate) fn numbers(&self) -> ([[f32; 3]; 9], [f32; 4]) {
        let lamps = [self.key, self.fill, self.rim];
        let [a, b, c] = lamps.map(|l| l.toward);
        let [d, e, f] = lamps.map(|l| l.color);
        (
            [a, b, c, d, e, f, self.up, SKY, GROUND],
            [WRAP, GLOSS, RISE, KNEE],
        )
    }

    /// Light that a surface sends to the eye. `normal` and the vector `v` to the eye have length 1; `side` is 1 where the front is seen and -1
    /// where the back is, which is lit as well. Every channel of the result is from 0 to 1.
    #[must_use]
    #[inline(always)]
    pub fn light(&self, normal: [f32; 3], side: f32, v: [f32; 3], albedo: [f32; 3]) -> [f32; 3] {
        let n = [normal[0] * side, normal[1] * side, normal[2] * side];
        let key = wrapped(dot(n, self.key.toward));
        let fill = wrapped(dot(n, self.fill.toward));
        // The rim light shows where the surface turns away.
        let edge = 1.0 - positive(dot(n, v));
        let edge2 = edge * edge;
        let rim = positive(dot(n, self.rim.toward)) * edge2;
        let height = 0.5 + 0.5 * dot(n, self.up);

        // Blinn's lobe with exponent 32, from the square of its cosine, with Schlick's rise towards the silhouette.
        let l = self.key.toward;
        let h = [l[0] + v[0], l[1] + v[1], l[2] + v[2]];
        let nh = positive(dot(n, h));
        let s2 = nh * nh / (dot(h, h) + 1e-6);
        let s4 = s2 * s2;
        let s8 = s4 * s4;
        let s16 = s8 * s8;
        let fresnel = GLOSS + RISE * edge2 * edge2 * edge;
        let gloss = s16 * s16 * fresnel * key;

        let channel = |k: usize| {
            let surround = GROUND[k] + (SKY[k] - GROUND[k]) * height;
            let diffuse = key * self.key.color[k] + fill * self.fill.color[k] + surround;
            let rim = rim * self.rim.color[k] * (0.35 + 0.65 * albedo[k]);
            shoulder(albedo[k] * diffuse + rim + gloss * self.key.color[k])
        };
        [channel(0), channel(1), channel(2)]
    }
}

/// The side that is seen: 1 the front, -1 the back. `side` is that of the triangle, or 0 where it has none to tell; `normal` and the vector
/// `v` to the eye have length 1. From the cosine `decided` on the normal is believed against the triangle.
#[inline(always)]
pub(super) fn side_seen(normal: [f32; 3], side: f32, v: [f32; 3], decided: f32) -> f32 {
    let facing = dot(normal, v);
    let turned = if facing < 0.0 { -1.0 } else { 1.0 };
    // One choice after the other: with both in one condition the compiler gives up lanes of 8.
    let side = if side == 0.0 { turned } else { side };
    if facing * side < -decided {
        turned
    } else {
        side
    }
}

/// Wrapped diffuse light: 1 facing the lamp, smoothly 0 at `-WRAP`.
#[inline(always)]
fn wrapped(cosine: f32) -> f32 {
    let w = positive((cosine + WRAP) * (1.0 / (1.0 + WRAP)));
    // Between Lambert (linear) and a square: the square alone darkens the middle tones.
    w * (0.45 + 0.55 * w)
}

/// The identity up to the knee, then a hyperbola of the same slope that approaches 1. NaN gives 0.
#[inline(always)]
fn shoulder(x: f32) -> f32 {
    let x = positive(x);
    let x = if x < 1e4 { x } else { 1e4 };
    let over = positive(x - KNEE) * (1.0 / (1.0 - KNEE));
    let below = if x < KNEE { x } else { KNEE };
    below + (1.0 - KNEE) * (over / (1.0 + over))
}

/// Length 1, without asking whether there is a direction.
#[inline(always)]
pub(super) fn unit(v: [f32; 3]) -> [f32; 3] {
    let d = dot(v, v);
    let d = if d > f32::MIN_POSITIVE {
        d
    } else {
        f32::MIN_POSITIVE
    };
    let k = 1.0 / d.sqrt();
    [v[0] * k, v[1] * k, v[2] * k]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shoulder_is_smooth_and_below_one() {
        let mut last = -1.0;
        for i in 0..4000 {
            let y = shoulder(i as f32 * 0.005);
            assert!(y > last && y < 1.0);
            last = y;
        }
        assert_eq!(shoulder(0.3), 0.3);
        assert!((shoulder(KNEE + 1e-3) - KNEE - 1e-3).abs() < 1e-5);
        assert_eq!(shoulder(f32::NAN), 0.0);
        assert!(shoulder(f32::INFINITY) <= 1.0);
    }

    #[test]
    fn lights_turn_around_the_picture() {
        let sphere = crate::camera::Sphere {
            center: [0.0; 3],
            radius: 1.0,
        };
        let size = crate::records::ScreenSize {
            width: 8,
            height: 8,
            samples: 1,
        };
        let camera = crate::Camera::default().with_orbit(30.0, 40.0);
        let view = camera.framing(&sphere, size).unwrap();
        let sides = |degrees: f64| {
            let key = LightRig::turned(&view, degrees).key.toward;
            [view.right, view.up, view.forward.map(|c| -c)].map(|axis| dot(axis, key))
        };
        let plain = sides(0.0);
        assert_eq!(
            LightRig::new(&view).key.toward,
            LightRig::turned(&view, 0.0).key.toward
        );
        assert!(plain[0] < 0.0 && plain[2] > 0.0, "from the left, in front");
        let near = |a: [f32; 3], b: [f32; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-5);
        // A quarter turn takes what comes from the front to the right, and what comes from the left to the front.
        assert!(near(sides(90.0), [plain[2], plain[1], -plain[0]]));
        assert!(near(sides(180.0), [-plain[0], plain[1], -plain[2]]));
        assert!(near(sides(360.0), plain));
    }

    #[test]
    fn normals_are_believed_against_triangles_where_they_are_decided() {
        let v = [0.0, 0.0, 1.0];
        let seen = |cosine: f32, side: f32, decided: f32| {
            let leaning = [(1.0 - cosine * cosine).sqrt(), 0.0, cosine];
            side_seen(leaning, side, v, decided)
        };
        for side in [1.0, -1.0] {
            assert_eq!(seen(0.9, side, 0.25), 1.0);
            assert_eq!(seen(-0.9, side, 0.25), -1.0);
            // Near a silhouette the triangle knows.
            assert_eq!(seen(0.2, side, 0.25), side);
            assert_eq!(seen(-0.2, side, 0.25), side);
            assert_eq!(seen(-0.9, side, 2.0), side);
        }
        assert_eq!(seen(0.2, 0.0, 2.0), 1.0);
        assert_eq!(seen(-0.2, 0.0, 2.0), -1.0);
    }

    #[test]
    fn wrapped_light_ends_behind_the_terminator() {
        assert!((wrapped(1.0) - 1.0).abs() < 1e-6);
        assert!(wrapped(0.0) > 0.05);
        assert_eq!(wrapped(-WRAP - 0.01), 0.0);
    }
}
