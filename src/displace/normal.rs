//! The normal of a displaced surface.
//!
//! With limit point `p`, unit normal `n` and height `h`, the displaced surface is `p + h n`. Its tangents are `p_u + h_u n + h n_u` and the
//! like by v, where `n_u` and `n_v` follow from the second derivatives of the limit surface (the equations of Weingarten). So the normal is
//! exact wherever the limit surface has second derivatives; where it has none, at irregular vertices, it counts as flat there.

use crate::math;

/// First and second derivatives of the limit surface.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bend {
    pub(crate) du: [f32; 3],
    pub(crate) dv: [f32; 3],
    /// By u twice, by u and v, by v twice; zeros where there are none.
    pub(crate) second: [[f32; 3]; 3],
}

impl Bend {
    /// Derivatives of the unit normal `n`.
    #[inline(always)]
    pub(crate) fn normals_of(&self, n: [f32; 3]) -> [[f32; 3]; 2] {
        let (du, dv) = (self.du, self.dv);
        let (e, f, g) = (math::dot(du, du), math::dot(du, dv), math::dot(dv, dv));
        let [l, m, k] = self.second.map(|d| math::dot(d, n));
        let det = e * g - f * f;
        // Of parallel tangents nothing follows.
        if det.is_nan() || det <= 1e-10 * e * g {
            return [[0.0; 3]; 2];
        }
        let mix = |a: f32, b: f32| {
            math::scale(math::add(math::scale(du, a), math::scale(dv, b)), 1.0 / det)
        };
        [
            mix(f * m - g * l, f * l - e * m),
            mix(f * k - g * m, f * m - e * k),
        ]
    }

    /// Unit normal of the displaced surface; `slope` are the derivatives of the height by u and v. `n` where there is none.
    #[inline(always)]
    pub(crate) fn displaced(&self, n: [f32; 3], height: f32, slope: [f32; 2]) -> [f32; 3] {
        let [nu, nv] = self.normals_of(n);
        let along = |d: [f32; 3], nd: [f32; 3], s: f32| {
            [0, 1, 2].map(|k| (d[k] + nd[k] * height) + n[k] * s)
        };
        unit(along(self.du, nu, slope[0]), along(self.dv, nv, slope[1])).unwrap_or(n)
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
#[inline(always)]
pub(crate) fn unit(a: [f32; 3], b: [f32; 3]) -> Option<[f32; 3]> {
    let size = |v: [f32; 3]| v[0].abs().max(v[1].abs()).max(v[2].abs());
    let (ma, mb) = (size(a), size(b));
    if !(ma > 0.0 && mb > 0.0 && ma.is_finite() && mb.is_finite()) {
        return None;
    }
    let c = math::cross(a.map(|x| x / ma), b.map(|x| x / mb));
    (math::dot(c, c) > 1e-12)
        .then(|| math::normalize(c))
        .flatten()
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
