//! A bound in closed form of how far a bicubic B-spline is from the two triangles of its corners: dense cages need no samples.
//!
//! A function over a right triangle of legs 1 is no further from its linear interpolation than
//! `(max |f_uu| + 2 max |f_uv| + max |f_vv|) / 8` (Filip, Magedson, Markot, *Surface algorithms using bounds on derivatives*, 1986), and the
//! second derivatives of a B-spline are averages of the second differences of its control points. Bunnell tests the same differences.

use super::screen::Metric;
use crate::math;
use crate::surface::Spline;

/// What is left of the tolerance for rounding.
pub(crate) const SHARE: f32 = 0.95;

type V = [f32; 3];

/// Control points of a bicubic B-spline, row by row.
type Net16 = [[V; 4]; 4];

/// Those of a box spline: rows of 3, 4, 3 and 2.
type Net12 = [V; 12];

/// Differences of rows of `n` by `m` vectors along a row, and from row to row.
fn along<const N: usize, const M: usize, const K: usize>(p: &[[V; N]; M]) -> [[V; K]; M] {
    std::array::from_fn(|j| std::array::from_fn(|i| math::sub(p[j][i + 1], p[j][i])))
}

fn across<const N: usize, const M: usize, const K: usize>(p: &[[V; N]; M]) -> [[V; N]; K] {
    std::array::from_fn(|j| std::array::from_fn(|i| math::sub(p[j + 1][i], p[j][i])))
}

/// Largest of what `size` says of vectors.
fn most<const N: usize, const M: usize>(p: &[[V; N]; M], size: impl Fn(V) -> f32) -> f32 {
    p.iter()
        .flatten()
        .fold(0.0_f32, |most, &v| most.max(size(v)))
}

/// First and second differences of a net.
struct Differences {
    u: [[V; 3]; 4],
    v: [[V; 4]; 3],
    uu: [[V; 2]; 4],
    uv: [[V; 3]; 3],
    vv: [[V; 4]; 2],
}

impl Differences {
    fn of(net: &[[V; 4]; 4]) -> Self {
        let (u, v) = (along(net), across(net));
        Self {
            uu: along(&u),
            uv: across(&u),
            vv: across(&v),
            u,
            v,
        }
    }

    /// The bound of distances, by what `size` says of vectors.
    fn distance(&self, size: impl Fn(V) -> f32) -> f32 {
        0.125 * (most(&self.uu, &size) + 2.0 * most(&self.uv, &size) + most(&self.vv, &size))
    }

    /// Bound of the angle in radians between normals and what interpolates those of the corners; above 1 where the bound says nothing.
    ///
    /// The normal N = f_u × f_v is compared with N₀, that of the means A of f_u and B of f_v. Seen on the plane at N₀ / |N₀|, unit normals lie
    /// at most r / (1 − r) off, where |N − N₀| ≤ r |N₀|; weights that differ by what lengths do (by r at most) shift a mean of them by 2 r² in
    /// a first approximation; and N itself is no further from what its corners interpolate than its second derivatives say, as above.
    fn angle(&self) -> f32 {
        let (a, b) = (mean(self.u.as_flattened()), mean(self.v.as_flattened()));
        let (du, dv) = (
            most(&self.u, |v| math::length(math::sub(v, a))),
            most(&self.v, |v| math::length(math::sub(v, b))),
        );
        let area = math::length(math::cross(a, b));
        let (a, b) = (math::length(a), math::length(b));
        let r = (a * dv + du * b + du * dv) / area;
        if r.is_nan() || r >= 0.3 {
            return f32::INFINITY;
        }
        let (u, v) = (a + du, b + dv);
        let [uu, uv, vv] = [
            most(&self.uu, math::length),
            most(&self.uv, math::length),
            most(&self.vv, math::length),
        ];
        let uuu = most::<1, 4>(&along(&self.uu), math::length);
        let uuv = most::<2, 3>(&across(&self.uu), math::length);
        let uvv = most::<3, 2>(&across(&self.uv), math::length);
        let vvv = most::<4, 1>(&across(&self.vv), math::length);
        let second = (uuu * v + 2.0 * uu * uv + u * uuv)
            + 2.0 * (uuv * v + uu * vv + u * uvv)
            + (uvv * v + 2.0 * uv * vv + u * vvv);
        let left = 1.0 - r;
        0.125 * second / area * (1.0 + r) / (left * left) + 2.0 * r * r / (left * left)
    }
}

/// What a bound tells of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Told {
    /// The two triangles of its corners are as close as wanted.
    Flat,
    /// They may be so many times as far as is allowed; infinite where the bound says nothing.
    Far(f32),
}

/// What the bound tells of a face.
pub(super) fn tell(metric: &Metric<'_>, spline: &Spline) -> Told {
    match spline {
        Spline::Quad(net) => {
            let Some((eye, factor, spread)) = sheared::<16>(metric, net.as_flattened()) else {
                return Told::Far(f32::INFINITY);
            };
            let eye: Net16 = std::array::from_fn(|j| std::array::from_fn(|i| eye[4 * j + i]));
            let size = |v: V| (v[0] * v[0] + v[1] * v[1]).sqrt() + spread * v[2].abs();
            let seen = Differences::of(&eye);
            let sides = most(&seen.u, size) + most(&seen.v, size);
            metric.told(seen.distance(size) * factor, sides * factor, || {
                Differences::of(net).angle()
            })
        }
        Spline::Triangle(net) => {
            let Some((eye, factor, spread)) = sheared(metric, net) else {
                return Told::Far(f32::INFINITY);
            };
            let size = |v: V| (v[0] * v[0] + v[1] * v[1]).sqrt() + spread * v[2].abs();
            let largest = |p: &[V]| p.iter().fold(0.0_f32, |most, &v| most.max(size(v)));
            let [u, v] = firsts(&eye);
            let [uu, uv, vv] = seconds(&eye).map(|d| largest(&d));
            let far = 0.125 * (uu + 2.0 * uv + vv);
            metric.told(far * factor, (largest(&u) + largest(&v)) * factor, || {
                let [u, v] = firsts(net);
                // Both normals are in the cone of all.
                2.0 * libm::asinf(ratio(&u, &v).min(1.0))
            })
        }
    }
}

impl Metric<'_> {
    /// Of triangles up to `far` pixels away and `sides` long, with normals up to `angle` radians off.
    fn told(&self, far: f32, sides: f32, angle: impl FnOnce() -> f32) -> Told {
        let [pixels, radians] = self.tolerances();
        let times = far / (pixels * SHARE);
        // What is smaller than a pixel has no normals of its own to be seen.
        if times <= 1.0 && (sides <= 1.0 || angle() <= radians * SHARE) {
            Told::Flat
        } else {
            Told::Far(times)
        }
    }
}

/// Points as the eye sees them, sheared so that the direction to their middle is the axis: a vector along the axis hardly moves on the screen.
/// With pixels per unit at the nearest of them, and how far off the axis they may be, per depth. `None` where one is at the near plane.
fn sheared<const N: usize>(metric: &Metric<'_>, net: &[V]) -> Option<([V; N], f32, f32)> {
    let seen = metric.seen();
    let (near, scale, ortho) = metric.projection();
    let mut eye: [V; N] = std::array::from_fn(|k| seen.point(net[k]));
    if ortho {
        return Some((eye, scale, 0.0));
    }
    let nearest = eye.iter().fold(f32::INFINITY, |z, p| z.min(p[2]));
    if nearest.is_nan() || nearest <= near {
        return None;
    }
    let sum = eye.iter().fold([0.0; 3], |s, p| math::add(s, *p));
    let (tx, ty) = (sum[0] / sum[2], sum[1] / sum[2]);
    let mut off = 0.0_f32;
    for p in &mut eye {
        p[0] -= tx * p[2];
        p[1] -= ty * p[2];
        off = off.max(p[0] * p[0] + p[1] * p[1]);
    }
    Some((eye, scale / nearest, off.sqrt() / nearest))
}

/// Mean of vectors.
fn mean(p: &[V]) -> V {
    let sum = p.iter().fold([0.0; 3], |s, v| math::add(s, *v));
    math::scale(sum, 1.0 / p.len() as f32)
}

/// How far cross products of averages of `u` and `v` are from that of their means, by its length.
fn ratio(u: &[V], v: &[V]) -> f32 {
    let (a, b) = (mean(u), mean(v));
    let off = |p: &[V], m: V| {
        p.iter()
            .fold(0.0_f32, |most, &v| most.max(math::length(math::sub(v, m))))
    };
    let (du, dv) = (off(u, a), off(v, b));
    let area = math::length(math::cross(a, b));
    (math::length(a) * dv + du * math::length(b) + du * dv) / area
}

/// Differences of a box spline's points along u and along v; its derivatives are averages of them.
fn firsts(p: &Net12) -> [[V; 8]; 2] {
    let d = |pairs: [(usize, usize); 8]| pairs.map(|(a, b)| math::sub(p[b], p[a]));
    [
        d([
            (0, 1),
            (1, 2),
            (3, 4),
            (4, 5),
            (5, 6),
            (7, 8),
            (8, 9),
            (10, 11),
        ]),
        d([
            (0, 3),
            (1, 4),
            (2, 5),
            (4, 7),
            (5, 8),
            (6, 9),
            (8, 10),
            (9, 11),
        ]),
    ]
}

/// Its second differences along u, along u and v, and along v; some of them twice.
fn seconds(p: &Net12) -> [[V; 5]; 3] {
    let line = |t: [[usize; 3]; 4]| {
        let d = t.map(|[a, b, c]| math::sub(math::add(p[a], p[c]), math::scale(p[b], 2.0)));
        [d[0], d[1], d[2], d[3], d[3]]
    };
    // Low ends first: along u, then the same one row on.
    let square = |[a, b, c, d]: [usize; 4]| math::sub(math::add(p[a], p[d]), math::add(p[b], p[c]));
    let squares = [
        [0, 1, 3, 4],
        [1, 2, 4, 5],
        [4, 5, 7, 8],
        [5, 6, 8, 9],
        [8, 9, 10, 11],
    ];
    [
        line([[0, 1, 2], [3, 4, 5], [4, 5, 6], [7, 8, 9]]),
        squares.map(square),
        line([[1, 4, 7], [2, 5, 8], [5, 8, 10], [6, 9, 11]]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers from -1 to 1.
    struct Random(u32);

    impl Random {
        fn next(&mut self) -> f32 {
            self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (self.0 >> 8) as f32 / (1 << 23) as f32 - 1.0
        }
    }

    fn weights(t: f32) -> ([f32; 4], [f32; 4]) {
        let s = 1.0 - t;
        let point = [
            s * s * s / 6.0,
            2.0 / 3.0 - 0.5 * t * t * (2.0 - t),
            2.0 / 3.0 - 0.5 * s * s * (2.0 - s),
            t * t * t / 6.0,
        ];
        let slope = [
            -0.5 * s * s,
            1.5 * t * t - 2.0 * t,
            2.0 * s - 1.5 * s * s,
            0.5 * t * t,
        ];
        (point, slope)
    }

    fn at(net: &Net16, [u, v]: [f32; 2]) -> (V, V) {
        let ((pu, su), (pv, sv)) = (weights(u), weights(v));
        let sum = |a: [f32; 4], b: [f32; 4]| {
            let mut out = [0.0; 3];
            for (j, i) in (0..16).map(|k| (k / 4, k % 4)) {
                out = math::add(out, math::scale(net[j][i], a[i] * b[j]));
            }
            out
        };
        let normal = math::cross(sum(su, pv), sum(pu, sv));
        (sum(pu, pv), math::normalize(normal).unwrap())
    }

    /// Largest distance and angle of triangles of the corners, over a lattice of samples.
    fn measured(net: &Net16) -> [f32; 2] {
        const STEPS: usize = 8;
        let corner = |i: usize, j: usize| at(net, [i as f32, j as f32]);
        let mut most = [0.0_f32; 2];
        for half in [
            [corner(0, 0), corner(1, 0), corner(1, 1)],
            [corner(0, 0), corner(0, 1), corner(1, 1)],
        ] {
            let end = [[0.0; 2], half_end(half[1].0 == corner(1, 0).0), [1.0; 2]];
            for (a, b) in (0..=STEPS).flat_map(|a| (0..=STEPS - a).map(move |b| (a, b))) {
                let w = [a, b, STEPS - a - b].map(|k| k as f32 / STEPS as f32);
                let place = [0, 1].map(|k| (0..3).map(|c| w[c] * end[c][k]).sum());
                let mix = |v: [V; 3]| [0, 1, 2].map(|k| (0..3).map(|c| w[c] * v[c][k]).sum());
                let (p, n) = at(net, place);
                let far: V = math::sub(p, mix(half.map(|h| h.0)));
                let m = math::normalize(mix(half.map(|h| h.1))).unwrap();
                let angle = math::length(math::cross(n, m)).atan2(math::dot(n, m));
                most = [most[0].max(math::length(far)), most[1].max(angle)];
            }
        }
        most
    }

    fn half_end(first: bool) -> [f32; 2] {
        if first { [1.0, 0.0] } else { [0.0, 1.0] }
    }

    #[test]
    fn bounds_are_never_below_what_is_measured() {
        let mut random = Random(7);
        let mut told = [0; 2];
        for k in 0..2000 {
            let rough = [0.01, 0.03, 0.1, 0.3][k % 4];
            let bend = 0.1 * random.next();
            let net: Net16 = std::array::from_fn(|j| {
                std::array::from_fn(|i| {
                    let (x, y) = (i as f32 - 1.5, j as f32 - 1.5);
                    let mut p = [x, y * (1.0 + 0.5 * rough * x), bend * x * x];
                    p.iter_mut().for_each(|c| *c += rough * random.next());
                    p
                })
            });
            let differences = Differences::of(&net);
            let (distance, angle) = (differences.distance(math::length), differences.angle());
            let [far, bent] = measured(&net);
            assert!(far <= distance * 1.0001 + 1e-6, "{far} above {distance}");
            assert!(bent <= angle * 1.0001 + 1e-5, "{bent} above {angle}");
            told[0] += usize::from(distance < 6.0 * far);
            told[1] += usize::from(angle < 0.1);
        }
        // Bounds that say nothing are never below anything.
        assert!(told[0] > 1000 && told[1] > 100, "{told:?}");
    }
}
