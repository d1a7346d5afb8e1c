//! A bicubic patch and its derivatives at one parameter.

use crate::dice::point::P4;
use std::ops::{Add, Mul, Sub};

/// Four numbers in one register.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(16))]
pub(crate) struct F4(pub(crate) [f32; 4]);

impl F4 {
    #[inline(always)]
    pub(crate) fn new(a: [f32; 4]) -> Self {
        Self(a)
    }
    #[inline(always)]
    pub(crate) fn splat(a: f32) -> Self {
        Self([a; 4])
    }
    /// The first three.
    #[inline(always)]
    pub(crate) fn xyz(self) -> [f32; 3] {
        [self.0[0], self.0[1], self.0[2]]
    }
}

impl Add for F4 {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        let (a, b) = (self.0, o.0);
        Self([a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]])
    }
}
impl Sub for F4 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        let (a, b) = (self.0, o.0);
        Self([a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]])
    }
}
impl Mul for F4 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        let (a, b) = (self.0, o.0);
        Self([a[0] * b[0], a[1] * b[1], a[2] * b[2], a[3] * b[3]])
    }
}

/// Position and derivatives; those above the order asked for are zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Jet {
    pub(crate) position: F4,
    pub(crate) du: F4,
    pub(crate) dv: F4,
    pub(crate) duu: F4,
    pub(crate) duv: F4,
    pub(crate) dvv: F4,
}

impl Jet {
    #[inline(always)]
    pub(crate) fn at(position: F4) -> Self {
        let zero = F4::splat(0.0);
        Self {
            position,
            du: zero,
            dv: zero,
            duu: zero,
            duv: zero,
            dvv: zero,
        }
    }

    /// The same surface over a parameter `scale` times as fast.
    #[inline(always)]
    pub(crate) fn scaled<const ORDER: u32>(mut self, scale: f32) -> Self {
        if ORDER > 0 {
            let scale = F4::splat(scale);
            self.du = self.du * scale;
            self.dv = self.dv * scale;
        }
        if ORDER > 1 {
            let square = F4::splat(scale * scale);
            self.duu = self.duu * square;
            self.duv = self.duv * square;
            self.dvv = self.dvv * square;
        }
        self
    }

    /// From the view of corner `c` of a quad, where s runs along the side that leaves the corner, to the quad's own u and v.
    #[inline(always)]
    pub(crate) fn turned<const ORDER: u32>(self, c: usize) -> Self {
        let minus = |p: F4| F4::splat(0.0) - p;
        let (s, t) = (self.du, self.dv);
        let (du, dv) = match c {
            0 => return self,
            1 => (minus(t), s),
            2 => (minus(s), minus(t)),
            _ => (t, minus(s)),
        };
        let mut out = Self { du, dv, ..self };
        if ORDER > 1 && c % 2 == 1 {
            (out.duu, out.dvv) = (self.dvv, self.duu);
            out.duv = minus(self.duv);
        }
        out
    }
}

/// Value, first derivative and half the second one of a cubic at `t`, by Horner's rule.
#[inline(always)]
fn horner<const ORDER: u32>(c: [F4; 4], t: F4) -> [F4; 3] {
    let (mut p, mut d, mut e) = (c[3], c[3], c[3]);
    p = p * t + c[2];
    if ORDER > 0 {
        d = d * t + p;
    }
    if ORDER > 1 {
        e = e * t + d;
    }
    p = p * t + c[1];
    if ORDER > 0 {
        d = d * t + p;
    }
    [p * t + c[0], d, e]
}

/// Monomial coefficients of a cubic B-spline.
#[inline(always)]
fn monomials(p: [F4; 4]) -> [F4; 4] {
    let sixth = F4::splat(1.0 / 6.0);
    let half = F4::splat(0.5);
    let ends = p[0] + p[2];
    [
        (ends + p[1] * F4::splat(4.0)) * sixth,
        (p[2] - p[0]) * half,
        ends * half - p[1],
        ((p[3] - p[0]) + (p[1] - p[2]) * F4::splat(3.0)) * sixth,
    ]
}

#[inline(always)]
fn row(p: &[P4; 4]) -> [F4; 4] {
    monomials([F4(p[0].0), F4(p[1].0), F4(p[2].0), F4(p[3].0)])
}

/// One bicubic piece by its monomial coefficients, relative to an origin: a third of the work of its control points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    origin: F4,
    /// By powers of u, then of v.
    coefficients: [[F4; 4]; 4],
}

/// A line of constant v on a patch: coefficients by powers of u of value and derivatives by v (of the second, half).
#[derive(Clone, Copy, Debug)]
pub(super) struct Curve {
    pub(super) origin: F4,
    pub(super) value: [F4; 4],
    pub(super) slope: [F4; 4],
    pub(super) bend: [F4; 4],
}

impl Patch {
    /// The B-spline of control points relative to `origin`, row by row.
    #[inline(always)]
    pub(super) fn new(origin: P4, p: &[[P4; 4]; 4]) -> Self {
        let rows = [row(&p[0]), row(&p[1]), row(&p[2]), row(&p[3])];
        Self {
            origin: F4(origin.0),
            coefficients: [
                monomials([rows[0][0], rows[1][0], rows[2][0], rows[3][0]]),
                monomials([rows[0][1], rows[1][1], rows[2][1], rows[3][1]]),
                monomials([rows[0][2], rows[1][2], rows[2][2], rows[3][2]]),
                monomials([rows[0][3], rows[1][3], rows[2][3], rows[3][3]]),
            ],
        }
    }

    #[inline(always)]
    pub(super) fn curve<const ORDER: u32>(&self, v: f32) -> Curve {
        let v = F4::splat(v);
        let [a, b, c, d] = &self.coefficients;
        let (a, b) = (horner::<ORDER>(*a, v), horner::<ORDER>(*b, v));
        let (c, d) = (horner::<ORDER>(*c, v), horner::<ORDER>(*d, v));
        Curve {
            origin: self.origin,
            value: [a[0], b[0], c[0], d[0]],
            slope: [a[1], b[1], c[1], d[1]],
            bend: [a[2], b[2], c[2], d[2]],
        }
    }

    /// The patch at (`u`, `v`), by a parameter `scale` times as fast.
    ///
    /// Not inlined: a result whose four lanes are all stored stays in registers of four, while a caller who takes three of them makes
    /// the compiler do everything number by number.
    #[inline(never)]
    pub(super) fn jet<const ORDER: u32>(&self, u: f32, v: f32, scale: f32) -> Jet {
        self.jet_here::<ORDER>(u, v, scale)
    }

    /// The same inlined, with the vector instructions of the caller.
    #[inline(always)]
    pub(super) fn jet_here<const ORDER: u32>(&self, u: f32, v: f32, scale: f32) -> Jet {
        self.curve::<ORDER>(v).at::<ORDER>(u).scaled::<ORDER>(scale)
    }
}

impl Curve {
    #[inline(always)]
    pub(super) fn at<const ORDER: u32>(&self, u: f32) -> Jet {
        let u = F4::splat(u);
        let [value, du, duu] = horner::<ORDER>(self.value, u);
        let mut jet = Jet::at(self.origin + value);
        if ORDER > 0 {
            let [dv, duv, _] = if ORDER > 1 {
                horner::<1>(self.slope, u)
            } else {
                horner::<0>(self.slope, u)
            };
            (jet.du, jet.dv) = (du, dv);
            if ORDER > 1 {
                let [dvv, ..] = horner::<0>(self.bend, u);
                jet.duv = duv;
                (jet.duu, jet.dvv) = (duu + duu, dvv + dvv);
            }
        }
        jet
    }
}
