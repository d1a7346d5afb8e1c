//! Values of flags from their text.

use earmark::raster::MAX_SCREEN;
use std::time::Duration;

/// A finite number.
pub(super) fn number(s: &str) -> Result<f64, String> {
    match s.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err("not a finite number".into()),
    }
}

pub(super) fn positive(s: &str) -> Result<f64, String> {
    match number(s)? {
        x if x > 0.0 => Ok(x),
        _ => Err("must be above 0".into()),
    }
}

pub(super) fn fov(s: &str) -> Result<f64, String> {
    match number(s)? {
        x if x > 0.0 && x < 180.0 => Ok(x),
        _ => Err("must be above 0 and below 180".into()),
    }
}

pub(super) fn vector(s: &str) -> Result<[f64; 3], String> {
    let parts: Vec<f64> = s
        .split(',')
        .map(|p| number(p.trim()))
        .collect::<Result<_, _>>()
        .map_err(|_| "not three finite numbers with commas between them")?;
    parts
        .try_into()
        .map_err(|_| "not three finite numbers with commas between them".into())
}

pub(super) fn size(s: &str) -> Result<[u32; 2], String> {
    let wrong = "not two numbers from 1 to 16383 with an x between them";
    let (w, h) = s.split_once(['x', 'X']).ok_or(wrong)?;
    let side = |s: &str| {
        let digits = !s.is_empty() && s.bytes().all(|b| b.is_ascii_digit());
        match s.parse::<u32>() {
            Ok(n) if digits && (1..=MAX_SCREEN).contains(&n) => Ok(n),
            _ => Err(wrong),
        }
    };
    Ok([side(w)?, side(h)?])
}

pub(super) fn samples(s: &str) -> Result<u32, String> {
    match s.parse() {
        Ok(n @ (1 | 4 | 8 | 16)) => Ok(n),
        _ => Err("must be 1, 4, 8 or 16".into()),
    }
}

pub(super) fn color(s: &str) -> Result<[u8; 4], String> {
    let wrong = || "not 6 or 8 hexadecimal digits".to_owned();
    let digits = s.strip_prefix('#').unwrap_or(s);
    if !matches!(digits.len(), 6 | 8) || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return Err(wrong());
    }
    let n = u32::from_str_radix(digits, 16).map_err(|_| wrong())?;
    Ok(match digits.len() {
        6 => (n << 8 | 0xff).to_be_bytes(),
        _ => n.to_be_bytes(),
    })
}

pub(super) fn seconds(s: &str) -> Result<Duration, String> {
    Duration::try_from_secs_f64(positive(s)?).map_err(|_| "too many seconds".into())
}

/// Bytes, with K, M, G or T for powers of 1024.
pub(super) fn bytes(s: &str) -> Result<u64, String> {
    let wrong = "not a size such as 800000000, 512M or 1.5G";
    let text = s.trim_end_matches(['B', 'b']).trim_end_matches('i');
    let (digits, shift) = match text.char_indices().next_back() {
        Some((at, c)) if c.is_ascii_alphabetic() => {
            let shift = match c.to_ascii_uppercase() {
                'K' => 10,
                'M' => 20,
                'G' => 30,
                'T' => 40,
                _ => return Err(wrong.into()),
            };
            (&text[..at], shift)
        }
        _ => (text, 0),
    };
    let n = positive(digits).map_err(|_| wrong)?;
    let total = n * (1_u64 << shift) as f64;
    // Everything that large is more than any machine has.
    if total >= 1.0 {
        Ok(total as u64)
    } else {
        Err(wrong.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read_or_refused() {
        assert_eq!(size("640x480"), Ok([640, 480]));
        for s in [
            "", "640", "0x1", "1x0", "16384x1", "-1x5", "+1x5", "1x1x1", "1.5x2", "x",
        ] {
            assert!(size(s).is_err(), "{s}");
        }
        assert_eq!(color("ff8000"), Ok([255, 128, 0, 255]));
        assert_eq!(color("#01020304"), Ok([1, 2, 3, 4]));
        for s in ["", "fff", "gg0000", "+12345", "1234567"] {
            assert!(color(s).is_err(), "{s}");
        }
        assert_eq!(vector("-1, 2.5,3e2"), Ok([-1.0, 2.5, 300.0]));
        for s in ["", "1,2", "1,2,3,4", "1,nan,2", "1,inf,2", "a,b,c"] {
            assert!(vector(s).is_err(), "{s}");
        }
        assert_eq!(bytes("1024"), Ok(1024));
        assert_eq!(bytes("1.5K"), Ok(1536));
        assert_eq!(bytes("2GiB"), Ok(2 << 30));
        assert_eq!(bytes("3mb"), Ok(3 << 20));
        for s in ["", "M", "-1", "0", "1X", "nan", "1e999", "0.5"] {
            assert!(bytes(s).is_err(), "{s}");
        }
        assert_eq!(seconds("0.25"), Ok(Duration::from_millis(250)));
        for s in ["0", "-1", "1e300", "inf"] {
            assert!(seconds(s).is_err(), "{s}");
        }
        assert!(fov("180").is_err() && fov("0").is_err() && fov("179.9").is_ok());
        assert!(samples("2").is_err() && samples("16").is_ok());
    }
}
