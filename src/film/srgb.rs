//! The sRGB transfer function (IEC 61966-2-1), and an exactly rounded 8-bit encoder.
//!
//! The encoder does not evaluate a power per pixel. The 255 linear values where the rounded code steps up are made in double
//! precision with `libm`; the step is found by the leading bits of the number. An interval of equal leading bits holds at most one
//! step, so a table gives per interval the code at its start and how far the step is from its end: adding the low bits of the number
//! carries into the code from the step on. The result is the correctly rounded code for every `f32`, the same on every machine.

use crate::simd::LANES;
use std::sync::LazyLock;

/// Leading mantissa bits that select an interval. With 7, no interval holds two steps (asserted when the table is made); with
/// 6 some do.
const MANTISSA_BITS: u32 = 7;
const SHIFT: u32 = 23 - MANTISSA_BITS;
/// Numbers below 2^-13 encode to 0: the first step is at 1.5e-4, above 2^-12.7.
const SMALLEST: u32 = (127 - 13) << 23;
const ONE: u32 = 127 << 23;
const INTERVALS: usize = ((ONE - SMALLEST) >> SHIFT) as usize + 1;
/// Entries of the table: a power of two, for a mask to keep every index inside.
const ENTRIES: usize = INTERVALS.next_power_of_two();

/// The bits of an interval's numbers among themselves.
const LOW_BITS: u32 = (1 << SHIFT) - 1;

/// Distance of a number from [`SMALLEST`] in steps of f32, after it was brought into the range that has different codes.
#[inline(always)]
fn place(x: f32) -> u32 {
    let low = f32::from_bits(SMALLEST);
    // Written so that NaN goes to the lower end.
    let x = if x > low { x } else { low };
    let x = if x < 1.0 { x } else { 1.0 };
    x.to_bits() - SMALLEST
}

/// Linear light of an sRGB value, both 0 to 1.
#[must_use]
pub fn to_linear(s: f64) -> f64 {
    if s <= 0.040_45 {
        s / 12.92
    } else {
        libm::pow((s + 0.055) / 1.055, 2.4)
    }
}

/// The sRGB value of linear light, both 0 to 1.
#[must_use]
pub fn from_linear(l: f64) -> f64 {
    if l <= 0.003_130_8 {
        l * 12.92
    } else {
        1.055 * libm::pow(l, 1.0 / 2.4) - 0.055
    }
}

/// Tables of the encoder and decoder.
#[derive(Debug)]
pub struct Srgb {
    /// `steps[k]` is the smallest number that encodes to `k + 1`; the last entry is never reached.
    steps: [f32; 256],
    /// Per interval the code at its start above [`SHIFT`] bits, which hold the distance of the step from the interval's end.
    codes: [u32; ENTRIES],
    linear: [f32; 256],
}

static TABLES: LazyLock<Srgb> = LazyLock::new(Srgb::new);

impl Srgb {
    /// The tables, made at the first call (a few microseconds).
    #[must_use]
    pub fn tables() -> &'static Self {
        &TABLES
    }

    fn new() -> Self {
        let mut steps = [f32::INFINITY; 256];
        for (k, step) in steps.iter_mut().take(255).enumerate() {
            let exact = to_linear((k as f64 + 0.5) / 255.0);
            let mut x = exact as f32;
            // The smallest f32 not below the exact value.
            if f64::from(x) < exact {
                x = x.next_up();
            }
            *step = x;
        }
        let mut codes = [0; ENTRIES];
        for (i, code) in codes.iter_mut().enumerate().take(INTERVALS) {
            let start = f32::from_bits(SMALLEST + ((i as u32) << SHIFT));
            let end = f32::from_bits(SMALLEST + ((i as u32 + 1) << SHIFT)).next_down();
            let below = |x: f32| steps.partition_point(|&s| s <= x);
            assert!(below(end) <= below(start) + 1, "two steps in an interval");
            // Beginning with a step is having the code from there on, so the distance is below the interval's length.
            let past = match steps.get(below(start)) {
                Some(s) if *s <= end => end.to_bits() + 1 - s.to_bits(),
                _ => 0,
            };
            *code = (below(start) as u32) << SHIFT | past;
        }
        Self {
            steps,
            codes,
            linear: std::array::from_fn(|k| to_linear(k as f64 / 255.0) as f32),
        }
    }

    /// The code nearest to the sRGB value of `x`. Below 0 and NaN give 0, above 1 gives 255.
    #[must_use]
    #[inline]
    pub fn encode(&self, x: f32) -> u8 {
        let bits = place(x);
        let code = self.codes[(bits >> SHIFT) as usize & (ENTRIES - 1)];
        ((code + (bits & LOW_BITS)) >> SHIFT) as u8
    }

    /// [`Srgb::encode`] of sixteen numbers.
    #[must_use]
    #[inline(always)]
    pub fn encode_lanes(&self, x: &[f32; LANES]) -> [u32; LANES] {
        let mut bits = [0; LANES];
        for l in 0..LANES {
            bits[l] = place(x[l]);
        }
        let mut codes = [0; LANES];
        for l in 0..LANES {
            codes[l] = self.codes[(bits[l] >> SHIFT) as usize & (ENTRIES - 1)];
        }
        for l in 0..LANES {
            codes[l] = (codes[l] + (bits[l] & LOW_BITS)) >> SHIFT;
        }
        codes
    }

    /// Linear light of a code.
    #[must_use]
    #[inline]
    pub fn decode(&self, code: u8) -> f32 {
        self.linear[usize::from(code)]
    }

    /// The smallest number that encodes to `code`; 0 for code 0.
    #[must_use]
    pub fn smallest(&self, code: u8) -> f32 {
        match code {
            0 => 0.0,
            c => self.steps[usize::from(c) - 1],
        }
    }
}

/// The nearest 8-bit code of a number from 0 to 1, without a curve. Below 0 and NaN give 0, above 1 gives 255.
#[must_use]
#[inline]
pub fn quantize(x: f32) -> u8 {
    (crate::math::saturate(x) * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The slow way: the code from the transfer function in double precision.
    fn reference(x: f32) -> u8 {
        (from_linear(f64::from(x.clamp(0.0, 1.0))) * 255.0).round() as u8
    }

    #[test]
    fn every_code_survives_the_round_trip() {
        let t = Srgb::tables();
        for code in 0..=255 {
            assert_eq!(t.encode(t.decode(code)), code);
        }
    }

    #[test]
    fn every_threshold_is_exact() {
        let t = Srgb::tables();
        for code in 1..=255 {
            let s = t.smallest(code);
            assert_eq!(t.encode(s), code);
            assert_eq!(t.encode(s.next_down()), code - 1);
            // Exactness of the threshold itself, in double precision.
            let exact = to_linear((f64::from(code) - 0.5) / 255.0);
            assert!(f64::from(s) >= exact && f64::from(s.next_down()) < exact);
        }
    }

    #[test]
    fn encoding_is_the_rounded_function_everywhere() {
        let t = Srgb::tables();
        let mut last = 0;
        for bits in (0..=ONE).step_by(4999) {
            let x = f32::from_bits(bits);
            let code = t.encode(x);
            assert_eq!(code, reference(x), "{x}");
            assert!(code >= last);
            last = code;
        }
        assert_eq!(last, 255);
    }

    #[test]
    fn strange_numbers_have_a_code() {
        let t = Srgb::tables();
        for (x, code) in [
            (-1.0, 0),
            (f32::NAN, 0),
            (f32::NEG_INFINITY, 0),
            (0.0, 0),
            (1e-40, 0),
            (1.0, 255),
            (7.0, 255),
            (f32::INFINITY, 255),
        ] {
            assert_eq!(t.encode(x), code, "{x}");
            assert_eq!(t.encode_lanes(&[x; LANES]), [code.into(); LANES], "{x}");
            assert_eq!(quantize(x), code, "{x}");
        }
        assert_eq!(quantize(0.5), 128);
        assert_eq!(quantize(0.499 / 255.0), 0);
        assert_eq!(quantize(0.501 / 255.0), 1);
    }
}
