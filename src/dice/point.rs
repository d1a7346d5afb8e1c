//! The point types of the dicing code: three coordinates in four lanes, so that one SSE register holds a point; and the same in `f64`,
//! for evaluation close to irregular vertices.

use std::ops::{Add, Mul, Sub};

/// What masks need of a point.
pub(crate) trait Point:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f32, Output = Self>
{
    /// The origin.
    const ZERO: Self;
    /// A point of a mesh.
    fn of(p: [f32; 3]) -> Self;
    /// `2a − b`: the phantom point beyond a boundary, which keeps the boundary curve free of what lies inside.
    #[inline(always)]
    fn beyond(a: Self, b: Self) -> Self {
        (a + a) - b
    }
}

/// A point or vector; the fourth lane is zero and takes part in nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(16))]
pub(crate) struct P4(pub(crate) [f32; 4]);

impl P4 {
    pub(crate) const ZERO: Self = Self([0.0; 4]);

    #[inline(always)]
    pub(crate) fn new(p: [f32; 3]) -> Self {
        Self([p[0], p[1], p[2], 0.0])
    }
    #[inline(always)]
    pub(crate) fn xyz(self) -> [f32; 3] {
        [self.0[0], self.0[1], self.0[2]]
    }
    /// `2a − b`, as [`Point::beyond`].
    #[inline(always)]
    pub(crate) fn beyond(a: Self, b: Self) -> Self {
        Point::beyond(a, b)
    }
    #[inline(always)]
    pub(crate) fn cross(self, o: Self) -> Self {
        let (a, b) = (self.0, o.0);
        Self([
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
            0.0,
        ])
    }
    #[inline(always)]
    pub(crate) fn dot(self, o: Self) -> f32 {
        (self.0[0] * o.0[0] + self.0[1] * o.0[1]) + self.0[2] * o.0[2]
    }
    /// Unit vector along `self`, or `None` if there is no direction.
    #[inline(always)]
    pub(crate) fn unit(self) -> Option<Self> {
        // Scale by the largest component first: cages may be 1e-12 or 1e12 across, and squares must not leave f32.
        let m = self.0[0].abs().max(self.0[1].abs()).max(self.0[2].abs());
        if !(m > 0.0 && m.is_finite()) {
            return None;
        }
        let s = Self([self.0[0] / m, self.0[1] / m, self.0[2] / m, 0.0]);
        let l = s.dot(s).sqrt();
        Some(Self([s.0[0] / l, s.0[1] / l, s.0[2] / l, 0.0]))
    }
}

impl Point for P4 {
    const ZERO: Self = Self([0.0; 4]);
    #[inline(always)]
    fn of(p: [f32; 3]) -> Self {
        Self::new(p)
    }
}

impl Add for P4 {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self([
            self.0[0] + o.0[0],
            self.0[1] + o.0[1],
            self.0[2] + o.0[2],
            self.0[3] + o.0[3],
        ])
    }
}
impl Sub for P4 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self([
            self.0[0] - o.0[0],
            self.0[1] - o.0[1],
            self.0[2] - o.0[2],
            self.0[3] - o.0[3],
        ])
    }
}
impl Mul<f32> for P4 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, k: f32) -> Self {
        Self([self.0[0] * k, self.0[1] * k, self.0[2] * k, self.0[3] * k])
    }
}

/// A point in double precision.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct D4(pub(crate) [f64; 4]);

impl D4 {
    #[inline(always)]
    pub(crate) fn new(p: [f64; 3]) -> Self {
        Self([p[0], p[1], p[2], 0.0])
    }
    /// The point of a mesh.
    #[inline(always)]
    pub(crate) fn wide(p: [f32; 3]) -> Self {
        Self([f64::from(p[0]), f64::from(p[1]), f64::from(p[2]), 0.0])
    }
    #[inline(always)]
    pub(crate) fn narrow(self) -> P4 {
        let a = self.0;
        P4([a[0] as f32, a[1] as f32, a[2] as f32, a[3] as f32])
    }
    #[inline(always)]
    pub(crate) fn times(self, k: f64) -> Self {
        let a = self.0;
        Self([a[0] * k, a[1] * k, a[2] * k, a[3] * k])
    }
}

impl Point for D4 {
    const ZERO: Self = Self([0.0; 4]);
    #[inline(always)]
    fn of(p: [f32; 3]) -> Self {
        Self::wide(p)
    }
}

impl Add for D4 {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        let (a, b) = (self.0, o.0);
        Self([a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]])
    }
}
impl Sub for D4 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        let (a, b) = (self.0, o.0);
        Self([a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]])
    }
}
impl Mul<f32> for D4 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, k: f32) -> Self {
        self.times(f64::from(k))
    }
}
