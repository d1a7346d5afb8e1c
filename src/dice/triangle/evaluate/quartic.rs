//! A quartic piece and its derivatives at one parameter, after the pattern of the bicubic one for quads.
//!
//! A triangle of the box spline is one polynomial of degree 4 in the barycentric coordinates u and v of its corners 1 and 2. Of its
//! fifteen monomial coefficients one is always zero, and two are twice another one. They are found in double precision, relative to
//! control point 0, from sums of the twelve control points: this is the table of [`BEZIER`](crate::dice::triangle) points, multiplied out.

use crate::dice::evaluate::{F4, Jet};
use crate::dice::point::D4;
use std::ops::{Add, Mul};

/// One piece by its monomial coefficients, relative to an origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    origin: F4,
    /// Without a power of u, by powers of v; and so on.
    c0: [F4; 5],
    c1: [F4; 4],
    c2: [F4; 2],
    c3: [F4; 2],
    c4: F4,
}

/// A line of constant v on a patch: coefficients by powers of u of value and derivatives by v.
#[derive(Clone, Copy, Debug)]
pub(super) struct Curve {
    origin: F4,
    value: [F4; 5],
    slope: [F4; 4],
    bend: [F4; 2],
}

/// Value, first derivative and half the second one of a polynomial at `x`, by Horner's rule: of points, or of one component in lanes.
#[inline(always)]
fn horner<const ORDER: u32, const N: usize, T>(c: &[T; N], x: T, zero: T) -> [T; 3]
where
    T: Copy + Add<Output = T> + Mul<Output = T>,
{
    let (mut p, mut d, mut e) = (c[N - 1], zero, zero);
    for k in (0..N - 1).rev() {
        if ORDER > 1 && k + 3 == N {
            e = d;
        } else if ORDER > 1 && k + 3 < N {
            e = e * x + d;
        }
        if ORDER > 0 && k + 2 == N {
            d = p;
        } else if ORDER > 0 {
            d = d * x + p;
        }
        p = p * x + c[k];
    }
    [p, d, e]
}

impl Patch {
    /// The box spline of twelve control points in the order of [`OFFSETS`](super::super::basis::OFFSETS), which are relative to `base`.
    pub(super) fn new(base: D4, net: &[D4; 12]) -> Self {
        let v = net[4];
        let q = |k: usize| net[k] - v;
        // The ring of corner 0 from corner 1 on, and the points beyond.
        let (e0, e1, e2) = (q(5), q(8), q(7));
        let (e3, e4, e5) = (q(3), q(0), q(1));
        let (far0, far1, far2, far3, far4) = (q(2), q(6), q(9), q(10), q(11));
        let (x, y, z) = (e0 - e3, e1 - e4, e2 - e5);
        let (xx, yy, zz) = (e0 + e3, e1 + e4, e2 + e5);
        let (a, b, c, d) = (e4 + far0, e2 + far2, e5 + far2, e3 + far3);
        let sixth = 1.0 / 6.0;
        let twice = |p: D4| p + p;
        let c40 = (twice(e5 + e1) + (e3 + far1) - (a + b) - e0).times(0.5 * sixth);
        let c04 = (twice(e0 + e2) + (e4 + far4) - (c + d) - e1).times(0.5 * sixth);
        let thin = |p: D4| F4::new(p.narrow().0);
        Self {
            origin: thin(base + v),
            c0: [
                thin(((xx + yy) + zz).times(0.5 * sixth)),
                thin((twice(y) + (x + z)).times(sixth)),
                thin(yy.times(0.5)),
                thin((c + d - twice((e0 + e4) + (e1 + e2))).times(sixth)),
                thin(c04),
            ],
            c1: [
                thin((twice(x) + (y - z)).times(sixth)),
                thin((xx + yy - zz).times(0.5)),
                thin((c - yy - twice(e0)).times(0.5)),
                thin(twice(c04)),
            ],
            c2: [thin(xx.times(0.5)), thin((b - xx - twice(e1)).times(0.5))],
            c3: [
                thin((a + b - twice((e0 + e3) + (e1 + e5))).times(sixth)),
                thin(twice(c40)),
            ],
            c4: thin(c40),
        }
    }

    #[inline(always)]
    pub(super) fn curve<const ORDER: u32>(&self, v: f32) -> Curve {
        let (v, zero) = (F4::splat(v), F4::splat(0.0));
        let [a, da, dda] = horner::<ORDER, 5, F4>(&self.c0, v, zero);
        let [b, db, ddb] = horner::<ORDER, 4, F4>(&self.c1, v, zero);
        Curve {
            origin: self.origin,
            value: [
                a,
                b,
                self.c2[1] * v + self.c2[0],
                self.c3[1] * v + self.c3[0],
                self.c4,
            ],
            slope: [da, db, self.c2[1], self.c3[1]],
            bend: [dda, ddb],
        }
    }

    /// The patch at (`u`, `v`), by a parameter `scale` times as fast. Not inlined, for the reason of the bicubic one.
    #[inline(never)]
    pub(super) fn jet<const ORDER: u32>(&self, u: f32, v: f32, scale: f32) -> Jet {
        self.curve::<ORDER>(v).at::<ORDER>(u).scaled::<ORDER>(scale)
    }
}

impl Curve {
    /// The line at `u`, by a parameter `scale` times as fast; not inlined as [`Patch::jet`].
    #[inline(never)]
    pub(super) fn jet<const ORDER: u32>(&self, u: f32, scale: f32) -> Jet {
        self.at::<ORDER>(u).scaled::<ORDER>(scale)
    }

    #[inline(always)]
    fn at<const ORDER: u32>(&self, u: f32) -> Jet {
        let (u, zero) = (F4::splat(u), F4::splat(0.0));
        let [value, du, duu] = horner::<ORDER, 5, F4>(&self.value, u, zero);
        let mut jet = Jet::at(self.origin + value);
        if ORDER > 0 {
            let [dv, duv, _] = if ORDER > 1 {
                horner::<1, 4, F4>(&self.slope, u, zero)
            } else {
                horner::<0, 4, F4>(&self.slope, u, zero)
            };
            (jet.du, jet.dv) = (du, dv);
            if ORDER > 1 {
                let [dvv, ..] = horner::<0, 2, F4>(&self.bend, u, zero);
                jet.duv = duv;
                (jet.duu, jet.dvv) = (duu + duu, dvv + dvv);
            }
        }
        jet
    }
}

/// Component `c` of coefficients.
#[inline(always)]
fn component<const N: usize>(of: &[F4; N], c: usize) -> [f32; N] {
    let mut out = [0.0; N];
    for k in 0..N {
        out[k] = of[k].0[c];
    }
    out
}

impl Curve {
    /// Component `c` of the first derivatives at the places `u`, by parameters twice scaled: the sums of [`Curve::jet`], in lanes.
    #[inline(always)]
    pub(super) fn first(
        &self,
        c: usize,
        u: &[f32],
        scales: [f32; 2],
        du: &mut [f32],
        dv: &mut [f32],
    ) {
        let (value, slope) = (component(&self.value, c), component(&self.slope, c));
        let n = u.len();
        let (du, dv) = (&mut du[..n], &mut dv[..n]);
        for i in 0..n {
            let [_, a, _] = horner::<1, 5, f32>(&value, u[i], 0.0);
            let [b, ..] = horner::<0, 4, f32>(&slope, u[i], 0.0);
            du[i] = (a * scales[0]) * scales[1];
            dv[i] = (b * scales[0]) * scales[1];
        }
    }

    /// The same of the second ones: by u twice, by both, by v twice.
    #[inline(always)]
    pub(super) fn second(
        &self,
        c: usize,
        u: &[f32],
        scales: [f32; 2],
        duu: &mut [f32],
        duv: &mut [f32],
        dvv: &mut [f32],
    ) {
        let (value, slope) = (component(&self.value, c), component(&self.slope, c));
        let bend = component(&self.bend, c);
        let (first, last) = (scales[0] * scales[0], scales[1] * scales[1]);
        let n = u.len();
        let (duu, duv, dvv) = (&mut duu[..n], &mut duv[..n], &mut dvv[..n]);
        for i in 0..n {
            let [_, _, a] = horner::<2, 5, f32>(&value, u[i], 0.0);
            let [_, b, _] = horner::<1, 4, f32>(&slope, u[i], 0.0);
            let [d, ..] = horner::<0, 2, f32>(&bend, u[i], 0.0);
            duu[i] = ((a + a) * first) * last;
            duv[i] = (b * first) * last;
            dvv[i] = ((d + d) * first) * last;
        }
    }
}
