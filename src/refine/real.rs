//! Numbers that points are made of, and the few operations on tuples of them that the passes need.

use super::passes::Passes;
use std::ops::{Add, Mul, Sub};

/// `f32` for pictures and export, `f64` for the oracle.
pub trait Real:
    Copy
    + Default
    + PartialEq
    + Send
    + Sync
    + std::fmt::Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + 'static
    + Passes
{
    /// Rounds to this type.
    fn from_f64(x: f64) -> Self;
    /// Widens, exactly.
    fn to_f64(self) -> f64;
}

impl Real for f32 {
    #[inline]
    fn from_f64(x: f64) -> Self {
        x as Self
    }
    #[inline]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}

impl Real for f64 {
    #[inline]
    fn from_f64(x: f64) -> Self {
        x
    }
    #[inline]
    fn to_f64(self) -> f64 {
        self
    }
}

/// Adds `x` to `sum`.
#[inline]
pub(crate) fn add<T: Real, const N: usize>(sum: &mut [T; N], x: &[T; N]) {
    for (s, c) in sum.iter_mut().zip(x) {
        *s = *s + *c;
    }
}

/// Adds `weight * x` to `sum`.
#[inline]
pub(crate) fn add_scaled<T: Real, const N: usize>(sum: &mut [T; N], weight: f64, x: &[T; N]) {
    let w = T::from_f64(weight);
    for (s, c) in sum.iter_mut().zip(x) {
        *s = *s + w * *c;
    }
}

/// `weight * x`.
#[inline]
pub(crate) fn scaled<T: Real, const N: usize>(weight: f64, x: &[T; N]) -> [T; N] {
    let w = T::from_f64(weight);
    x.map(|c| w * c)
}

/// The point half way between `a` and `b`; the same bits in either order.
#[inline]
pub(crate) fn midpoint<T: Real, const N: usize>(a: &[T; N], b: &[T; N]) -> [T; N] {
    let mut m = *a;
    add(&mut m, b);
    scaled(0.5, &m)
}

/// `weight * a + (1 - weight) * b`; exactly `a` or `b` at the ends.
#[inline]
pub(crate) fn blend<T: Real, const N: usize>(weight: f64, a: &[T; N], b: &[T; N]) -> [T; N] {
    if weight == 1.0 {
        *a
    } else if weight == 0.0 {
        *b
    } else {
        let mut m = scaled(weight, a);
        add_scaled(&mut m, 1.0 - weight, b);
        m
    }
}
