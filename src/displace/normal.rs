//! The normal of a displaced surface.
//!
//! With limit point `p`, unit normal `n` and height `h`, the displaced surface is `p + h n`. Its tangents are `p_u + h_u n + h n_u` and the
//! like by v, where `n_u` and `n_v` follow from the second derivatives of the limit surface (the equations of Weingarten). So the normal is
//! exact wherever the limit surface has second derivatives; where it has none, at irregular vertices, it counts as flat there. Where both
//! tangents have one direction nothing follows; corners of that kind have others (`surface::displaced`).

use crate::math;

/// First and second derivatives of the limit surface.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bend {
    pub(crate) du: [f32; 3],
    pub(crate) dv: [f32; 3],
    /// By u twice, by u and v, by v twice; zeros where there are none.
    pub(crate) second: [[f32; 3]; 3],
}

// Without branches, and without closures, which would be compiled without the caller's vector instructions: most points are done in lanes.

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `(a s + b t) f`, or zeros.
#[inline(always)]
fn mix(a: [f32; 3], s: f32, b: [f32; 3], t: f32, f: f32, sound: bool) -> [f32; 3] {
    let mut out = [0.0; 3];
    for k in 0..3 {
        let x = (a[k] * s + b[k] * t) * f;
        out[k] = if sound { x } else { 0.0 };
    }
    out
}

impl Bend {
    /// Derivatives of the unit normal `n`.
    #[inline(always)]
    pub(crate) fn normals_of(&self, n: [f32; 3]) -> [[f32; 3]; 2] {
        let (du, dv) = (self.du, self.dv);
        let (e, f, g) = (dot(du, du), dot(du, dv), dot(dv, dv));
        let (l, m, k) = (
            dot(self.second[0], n),
            dot(self.second[1], n),
            dot(self.second[2], n),
        );
        let det = e * g - f * f;
        // Of parallel tangents nothing follows.
        let sound = det > 1e-10 * e * g;
        let inverse = 1.0 / det;
        [
            mix(du, f * m - g * l, dv, f * l - e * m, inverse, sound),
            mix(du, f * k - g * m, dv, f * m - e * k, inverse, sound),
        ]
    }

    /// Unit normal of the displaced surface; `slope` are the derivatives of the height by u and v. `n` where there is none.
    #[inline(always)]
    pub(crate) fn displaced(&self, n: [f32; 3], height: f32, slope: [f32; 2]) -> [f32; 3] {
        let [nu, nv] = self.normals_of(n);
        let (mut along, mut across) = ([0.0; 3], [0.0; 3]);
        for k in 0..3 {
            along[k] = (self.du[k] + nu[k] * height) + n[k] * slope[0];
            across[k] = (self.dv[k] + nv[k] * height) + n[k] * slope[1];
        }
        unit_or(along, across, n).1
    }
}

impl Bend {
    /// Derivatives of the surface by texture coordinates, whose derivatives by the parameters are given. Zeros where there are none.
    pub(crate) fn by_uv(&self, [[uu, vu], [uv, vv]]: [[f32; 2]; 2]) -> [[f32; 3]; 2] {
        let factor = 1.0 / (uu * vv - uv * vu);
        if !factor.is_finite() {
            return [[0.0; 3]; 2];
        }
        let mix = |a: f32, b: f32| {
            math::scale(
                math::sub(math::scale(self.du, a), math::scale(self.dv, b)),
                factor,
            )
        };
        [mix(vv, vu), math::scale(mix(uv, uu), -1.0)]
    }
}

/// Unit vector along the cross product of vectors of any size.
#[inline]
pub(crate) fn unit(a: [f32; 3], b: [f32; 3]) -> Option<[f32; 3]> {
    let (found, unit) = unit_or(a, b, [0.0; 3]);
    found.then_some(unit)
}

#[inline(always)]
fn largest(v: [f32; 3]) -> f32 {
    v[0].abs().max(v[1].abs()).max(v[2].abs())
}

/// The same, or `spare`; and whether there is one.
#[inline(always)]
fn unit_or(a: [f32; 3], b: [f32; 3], spare: [f32; 3]) -> (bool, [f32; 3]) {
    let (ma, mb) = (largest(a), largest(b));
    let fits = (ma > 0.0) & (mb > 0.0) & (ma < f32::INFINITY) & (mb < f32::INFINITY);
    let a = [a[0] / ma, a[1] / ma, a[2] / ma];
    let b = [b[0] / mb, b[1] / mb, b[2] / mb];
    let c = [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ];
    let square = dot(c, c);
    // Below this it is rounding noise of two factors of unit size. Above, none of its squares leaves the range.
    let found = fits & (square > 1e-12);
    let inverse = 1.0 / square.sqrt();
    let mut out = spare;
    for k in 0..3 {
        let x = c[k] * inverse;
        out[k] = if found { x } else { spare[k] };
    }
    (found, out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_displaced_by_a_constant_keeps_its_normals() {
        // Geographic coordinates on a sphere of radius 2.
        for (a, b) in [(0.3_f32, 0.4_f32), (1.0, -0.7), (2.0, 0.1)] {
            let (sa, ca, sb, cb) = (libm::sinf(a), libm::cosf(a), libm::sinf(b), libm::cosf(b));
            let n = [ca * cb, sa * cb, sb];
            let bend = Bend {
                du: [-2.0 * sa * cb, 2.0 * ca * cb, 0.0],
                dv: [-2.0 * ca * sb, -2.0 * sa * sb, 2.0 * cb],
                second: [
                    [-2.0 * ca * cb, -2.0 * sa * cb, 0.0],
                    [2.0 * sa * sb, -2.0 * ca * sb, 0.0],
                    n.map(|x| -2.0 * x),
                ],
            };
            let [nu, _] = bend.normals_of(n);
            for k in 0..3 {
                assert!((nu[k] - bend.du[k] / 2.0).abs() < 1e-6);
            }
            let found = bend.displaced(n, 1.5, [0.0, 0.0]);
            assert!(math::dot(found, n) > 1.0 - 1e-6);
        }
    }

    #[test]
    fn what_has_no_derivatives_keeps_its_normal() {
        let n = [0.0, 0.0, 1.0];
        assert_eq!(Bend::default().displaced(n, 1.0, [1.0, 1.0]), n);
        let nan = Bend {
            du: [f32::NAN; 3],
            ..Bend::default()
        };
        assert_eq!(nan.displaced(n, 1.0, [0.0; 2]), n);
        let huge = Bend {
            du: [1e30, 0.0, 0.0],
            dv: [0.0, 1e30, 0.0],
            second: [[0.0; 3]; 3],
        };
        assert_eq!(huge.displaced(n, 0.0, [0.0; 2]), n);
    }
}
