//! Small vectors: plain `[f32; 3]` helpers for the stages, and glam's double-precision types for set-up work.
//!
//! This is the only file that names glam, so that a change of its API touches one place. Its SIMD types are not used: their
//! sums differ between instruction sets. Every sum here runs from left to right and nothing is fused.

pub(crate) use glam::DVec3;

/// Sum of two vectors.
#[must_use]
#[inline]
pub fn add(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Difference `a - b`.
#[must_use]
#[inline]
pub fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The vector times a number.
#[must_use]
#[inline]
pub fn scale(a: [f32; 3], s: f32) -> [f32; 3] {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// Scalar product.
#[must_use]
#[inline]
pub fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
#[must_use]
#[inline]
pub fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Euclidean length.
#[must_use]
#[inline]
pub fn length(a: [f32; 3]) -> f32 {
    dot(a, a).sqrt()
}

/// The vector at length 1, or `None` where it is zero, not finite, or so short or long that its square leaves the normal range.
#[must_use]
#[inline]
pub fn normalize(a: [f32; 3]) -> Option<[f32; 3]> {
    let d = dot(a, a);
    (f32::MIN_POSITIVE..=f32::MAX)
        .contains(&d)
        .then(|| scale(a, 1.0 / d.sqrt()))
}

/// The number, or 0 where it is negative or NaN. One instruction where `f32::max` takes three.
#[must_use]
#[inline(always)]
pub fn positive(x: f32) -> f32 {
    if x > 0.0 { x } else { 0.0 }
}

/// The number brought to the range from 0 to 1; NaN gives 0.
#[must_use]
#[inline(always)]
pub fn saturate(x: f32) -> f32 {
    let x = positive(x);
    if x < 1.0 { x } else { 1.0 }
}

/// The integer nearest to a number from 0 to 2^23. In lanes, where `as` would go through them one by one.
#[must_use]
#[inline(always)]
pub fn nearest(x: f32) -> i32 {
    // From 2^23 to 2^24 floats are the integers.
    const BASE: f32 = 8_388_608.0;
    (x + BASE).to_bits() as i32 - BASE.to_bits() as i32
}

/// The integer below a number of a magnitude below 2^23.
#[must_use]
#[inline(always)]
pub fn floor(x: f32) -> i32 {
    let i = nearest(x.abs());
    let i = if x < 0.0 { -i } else { i };
    i - i32::from((i as f32) > x)
}

/// Binary logarithm of a positive normal number, within 0.01, from the bits and a parabola: the same on every machine, and a
/// tenth of the cost of an exact one. Zero, subnormal and negative numbers give the value at the smallest normal number.
#[must_use]
#[inline]
pub fn log2_rough(x: f32) -> f32 {
    let bits = x.max(f32::MIN_POSITIVE).to_bits();
    let exponent = (bits >> 23) as i32 - 127;
    let m = f32::from_bits(bits & 0x007f_ffff | 0x3f80_0000) - 1.0;
    // log2(1 + m) on [0, 1), exact at both ends.
    exponent as f32 + m * (1.346 - 0.346 * m)
}

/// Rounds a double-precision vector to single precision.
pub(crate) fn round3(v: DVec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

/// Corners of a box.
pub(crate) fn box_corners(low: [f32; 3], high: [f32; 3]) -> impl Iterator<Item = [f32; 3]> {
    (0..8).map(move |c: u32| [0, 1, 2].map(|k| if c >> k & 1 == 0 { low[k] } else { high[k] }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products() {
        assert_eq!(cross([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
        assert_eq!(dot([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]), 32.0);
        assert_eq!(length([2.0, 3.0, 6.0]), 7.0);
        assert_eq!(add(sub([1.0; 3], [2.0; 3]), scale([1.0; 3], 3.0)), [2.0; 3]);
    }

    #[test]
    fn normalize_refuses_what_has_no_direction() {
        assert_eq!(normalize([0.0, 3.0, 4.0]), Some([0.0, 0.6, 0.8]));
        for bad in [0.0, 1e-30, 1e30, f32::NAN, f32::INFINITY] {
            assert_eq!(normalize([bad, 0.0, 0.0]), None, "{bad}");
        }
    }

    #[test]
    fn saturate_brings_everything_into_range() {
        for (x, y) in [
            (-1.0, 0.0),
            (0.25, 0.25),
            (2.0, 1.0),
            (f32::NAN, 0.0),
            (f32::INFINITY, 1.0),
            (f32::NEG_INFINITY, 0.0),
        ] {
            assert_eq!(saturate(x), y, "{x}");
        }
        assert_eq!(positive(f32::NAN), 0.0);
        assert_eq!(positive(3.0), 3.0);
    }

    #[test]
    fn floors_are_those_of_floats() {
        let all = [
            0.0, -0.0, 0.5, -0.5, 1.5, -1.5, 2.5, 0.1, -0.1, 1e-30, -1e-30,
        ];
        for x in all
            .into_iter()
            .chain([8_388_607.0, 8_388_607.5, 8_388_606.5, 4_194_304.5])
        {
            for x in [x, -x, f32::next_up(x), f32::next_down(x)] {
                if x.abs() < 8_388_608.0 {
                    assert_eq!(floor(x), x.floor() as i32, "{x}");
                }
            }
        }
        for k in 0..200_000_u32 {
            let x = f32::from_bits(k.wrapping_mul(0x9e37_79b9));
            if x.abs() < 8_388_608.0 {
                assert_eq!(floor(x), x.floor() as i32, "{x}");
            }
        }
    }

    #[test]
    fn log2_is_close_and_monotone() {
        let mut last = f32::NEG_INFINITY;
        for i in 1..20_000 {
            let x = i as f32 * 0.01;
            let l = log2_rough(x);
            assert!(
                (f64::from(l) - libm::log2(f64::from(x))).abs() < 0.01,
                "{x}"
            );
            assert!(l >= last);
            last = l;
        }
        assert_eq!(log2_rough(8.0), 3.0);
        assert!(log2_rough(0.0).is_finite() && log2_rough(-1.0).is_finite());
        assert!(log2_rough(f32::NAN).is_finite());
    }
}
