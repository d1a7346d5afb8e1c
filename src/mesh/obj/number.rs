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

/// The number that starts at `start`, and where it ends; `None` when no number starts there. May be infinite when it overflows.
#[inline]
pub(super) fn float(s: &[u8], start: usize) -> Option<(f64, usize)> {
    let byte = |i: usize| s.get(i).copied().unwrap_or(0);
    let mut at = start;
    let negative = byte(at) == b'-';
    if negative || byte(at) == b'+' {
        at += 1;
    }
    let mut mantissa = 0_u64;
    let first = at;
    loop {
        let d = byte(at).wrapping_sub(b'0');
        if d > 9 {
            break;
        }
        mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(d));
        at += 1;
    }
    let mut digits = at - first;
    let mut exponent = 0_i32;
    if byte(at) == b'.' {
        at += 1;
        let point = at;
        loop {
            let d = byte(at).wrapping_sub(b'0');
            if d > 9 {
                break;
            }
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(d));
            at += 1;
        }
        let decimals = at - point;
        digits += decimals;
        // Beyond 19 digits the slow path reads the text again, so a clamped exponent does no harm.
        exponent = -(decimals.min(1000) as i32);
    }
    if digits == 0 {
        return None;
    }
    if byte(at) | 0x20 == b'e' {
        let (value, end) = exponent_part(s, at + 1)?;
        exponent = exponent.saturating_add(value);
        at = end;
    }
    if digits <= 19 && mantissa <= 1 << 53 && exponent.unsigned_abs() <= 22 {
        let power = POWERS[exponent.unsigned_abs() as usize];
        let value = mantissa as f64;
        let value = if exponent < 0 {
            value / power
        } else {
            value * power
        };
        return Some((if negative { -value } else { value }, at));
    }
    let text = std::str::from_utf8(&s[start..at]).ok()?;
    Some((text.parse().ok()?, at))
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
#[inline]
pub(super) fn integer(s: &[u8], start: usize) -> Option<(i64, usize)> {
    let byte = |i: usize| s.get(i).copied().unwrap_or(0);
    let mut at = start;
    let negative = byte(at) == b'-';
    if negative || byte(at) == b'+' {
        at += 1;
    }
    let first = at;
    let mut value = 0_u64;
    loop {
        let d = byte(at).wrapping_sub(b'0');
        if d > 9 {
            break;
        }
        value = value.wrapping_mul(10).wrapping_add(u64::from(d));
        at += 1;
    }
    if at == first {
        return None;
    }
    let value = if at - first > 18 {
        // May have wrapped. Leading zeros are no reason to refuse, so count again.
        s[first..at].iter().fold(0_i64, |v, b| {
            v.saturating_mul(10).saturating_add(i64::from(b - b'0'))
        })
    } else {
        value as i64
    };
    Some((if negative { -value } else { value }, at))
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
