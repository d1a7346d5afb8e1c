//! Decimal numbers, correctly rounded, straight from bytes.
//!
//! Nearly all numbers of a mesh have at most 15 digits and a small exponent: the digits fit a `f64` exactly, so does the power of ten,
//! and one multiplication or division rounds once (Clinger, *How to read floating point numbers accurately*, 1990). All others go to
//! `str::parse`. Either way the result equals `str::parse::<f64>`, bit for bit; `f32` values are that result rounded once more.
//! Words (`nan`, `inf`), hexadecimal and decimal commas are no numbers here.

/// Powers of ten that a `f64` holds exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// Powers of ten by which up to eight further digits move a whole number.
const STEPS: [u64; 9] = [
    1,
    10,
    100,
    1_000,
    10_000,
    100_000,
    1_000_000,
    10_000_000,
    100_000_000,
];

/// Appends the digits at `at` to `value`, which wraps beyond 19 digits, and returns where they end.
///
/// Eight bytes at a time: find how many of them are digits, shift the others out, and add neighbours, pairs and quadruples up with
/// three multiplications (Lemire, *Number parsing at a gigabyte per second*, 2021).
#[inline(always)]
fn digits(s: &[u8], mut at: usize, value: &mut u64) -> usize {
    while let Some(eight) = s.get(at..at + 8) {
        let mut word = [0; 8];
        word.copy_from_slice(eight);
        // Digits become 0 to 9; of all others the high bit of the sum, or their own, is set.
        let word = u64::from_le_bytes(word) ^ 0x3030_3030_3030_3030;
        let others = (((word & 0x7f7f_7f7f_7f7f_7f7f) + 0x7676_7676_7676_7676) | word)
            & 0x8080_8080_8080_8080;
        let n = (others.trailing_zeros() / 8) as usize;
        if n == 0 {
            return at;
        }
        // The first digit is the lowest byte: moved up, it stands behind zeros.
        let word = word << (64 - 8 * n);
        let pairs = word.wrapping_mul(10).wrapping_add(word >> 8);
        let high = (pairs & 0x0000_00ff_0000_00ff).wrapping_mul(100 + (1_000_000 << 32));
        let low = ((pairs >> 16) & 0x0000_00ff_0000_00ff).wrapping_mul(1 + (10_000 << 32));
        let sum = high.wrapping_add(low) >> 32;
        *value = value.wrapping_mul(STEPS[n]).wrapping_add(sum);
        at += n;
        if n < 8 {
            return at;
        }
    }
    few_digits(s, at, value)
}

/// As [`digits`], one at a time: for what is short most often, and for the last bytes of a piece.
#[inline(always)]
fn few_digits(s: &[u8], mut at: usize, value: &mut u64) -> usize {
    while let Some(d) = s.get(at).map(|b| b.wrapping_sub(b'0')).filter(|&d| d <= 9) {
        *value = value.wrapping_mul(10).wrapping_add(u64::from(d));
        at += 1;
    }
    at
}

/// The number that starts at `start`, and where it ends; `None` when no number starts there. May be infinite when it overflows.
#[inline(always)]
pub(super) fn float(s: &[u8], start: usize) -> Option<(f64, usize)> {
    let byte = |i: usize| s.get(i).copied().unwrap_or(0);
    let negative = byte(start) == b'-';
    let first = start + usize::from(negative || byte(start) == b'+');
    let mut mantissa = 0_u64;
    let mut at = few_digits(s, first, &mut mantissa);
    let mut count = at - first;
    let mut exponent = 0_i32;
    if byte(at) == b'.' {
        let end = digits(s, at + 1, &mut mantissa);
        let decimals = end - at - 1;
        at = end;
        count += decimals;
        // Beyond 19 digits the slow path reads the text again, so a clamped exponent does no harm.
        exponent = -(decimals.min(1000) as i32);
    }
    if count == 0 {
        return None;
    }
    if byte(at) | 0x20 == b'e' {
        let (value, end) = exponent_part(s, at + 1)?;
        exponent = exponent.saturating_add(value);
        at = end;
    }
    if count > 19 || mantissa > 1 << 53 || exponent.unsigned_abs() > 22 {
        return slow(s, start, at);
    }
    let power = POWERS[exponent.unsigned_abs() as usize];
    let value = mantissa as f64;
    let value = if exponent <= 0 {
        value / power
    } else {
        value * power
    };
    Some((if negative { -value } else { value }, at))
}

#[cold]
fn slow(s: &[u8], start: usize, end: usize) -> Option<(f64, usize)> {
    let text = std::str::from_utf8(&s[start..end]).ok()?;
    Some((text.parse().ok()?, end))
}

/// The exponent that starts at `at` (behind the `e`), and where it ends.
fn exponent_part(s: &[u8], mut at: usize) -> Option<(i32, usize)> {
    let negative = s.get(at) == Some(&b'-');
    if negative || s.get(at) == Some(&b'+') {
        at += 1;
    }
    let first = at;
    let mut value = 0_i32;
    while let Some(d) = s.get(at).map(|b| b.wrapping_sub(b'0')).filter(|&d| d <= 9) {
        value = value.saturating_mul(10).saturating_add(i32::from(d));
        at += 1;
    }
    (at > first).then_some((if negative { -value } else { value }, at))
}

/// The signed whole number that starts at `start`, and where it ends; `None` when none does. Saturates.
#[inline(always)]
pub(super) fn integer(s: &[u8], start: usize) -> Option<(i64, usize)> {
    let byte = s.get(start).copied().unwrap_or(0);
    let negative = byte == b'-';
    let first = start + usize::from(negative || byte == b'+');
    let mut value = 0_u64;
    let at = digits(s, first, &mut value);
    if at == first {
        return None;
    }
    let value = if at - first > 18 {
        saturating(&s[first..at])
    } else {
        value as i64
    };
    Some((if negative { -value } else { value }, at))
}

/// Many digits: leading zeros are no reason to refuse a number, so they are counted again.
#[cold]
fn saturating(digits: &[u8]) -> i64 {
    digits.iter().fold(0_i64, |v, b| {
        v.saturating_mul(10).saturating_add(i64::from(b - b'0'))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odd_but_legal_forms() {
        for text in [
            "0",
            "-0",
            "+1",
            "1.",
            ".5",
            "-.5e1",
            "1e5",
            "1E-5",
            "1e+5",
            "007",
            "1e400",
            "1e-400",
            "5e-324",
            "9007199254740993",
            "0.1234567890123456789012345678901234567890",
            "1e99999999999999999999",
            "0.0000000000000000000000000000000000000000000000000000000000000000000001",
            "123456789012345678901234567890",
            "1.7976931348623157e308",
            "4.35",
            "179769313486231580793e289",
        ] {
            let want: f64 = text.parse().unwrap();
            let (got, end) = float(text.as_bytes(), 0).unwrap();
            assert_eq!(got.to_bits(), want.to_bits(), "{text}");
            assert_eq!(end, text.len(), "{text}");
        }
    }

    #[test]
    fn eight_digits_at_a_time_miss_none() {
        for text in [
            "1",
            "12",
            "1234567",
            "12345678",
            "123456789",
            "9999999999999999",
            "00000001",
        ] {
            // Every byte that may follow, with and without more bytes behind it.
            for next in (0..=255_u8).filter(|b| !b.is_ascii_digit()) {
                for more in ["", "99999999"] {
                    let s = [text.as_bytes(), &[next], more.as_bytes()].concat();
                    let mut value = 0;
                    assert_eq!(digits(&s, 0, &mut value), text.len(), "{s:?}");
                    assert_eq!(value, text.parse::<u64>().unwrap(), "{s:?}");
                }
            }
        }
    }

    #[test]
    fn no_numbers() {
        for text in [
            "", ".", "-", "e5", "1e", "1e+", "nan", "inf", "-inf", "x", "+-1",
        ] {
            assert_eq!(float(text.as_bytes(), 0), None, "{text}");
        }
        // Read up to the byte that does not belong; the caller sees that no separator follows.
        assert_eq!(float(b"0x10", 0), Some((0.0, 1)));
        assert_eq!(float(b"1,5", 0), Some((1.0, 1)));
    }

    #[test]
    fn integers_saturate() {
        assert_eq!(integer(b"12/3", 0), Some((12, 2)));
        assert_eq!(integer(b"-7", 0), Some((-7, 2)));
        assert_eq!(integer(b"00000000000000000000000000003", 0), Some((3, 29)));
        assert_eq!(integer(b"18446744073709551617", 0), Some((i64::MAX, 20)));
        assert_eq!(integer(b"-99999999999999999999", 0), Some((-i64::MAX, 21)));
        assert_eq!(integer(b"/", 0), None);
        assert_eq!(integer("１".as_bytes(), 0), None);
    }
}
