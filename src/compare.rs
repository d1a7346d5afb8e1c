//! Comparison of pictures, for golden tests and `earmark compare`: exact counts, and a picture of where the differences are.

use crate::film::Image;

/// Thresholds of the sweep that is shown when pictures differ.
pub const SWEEP: [u8; 9] = [0, 1, 2, 4, 8, 16, 32, 64, 128];

/// Two pictures of different size cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}x{} pixels against {}x{}", a[0], a[1], b[0], b[1])]
pub struct SizeMismatch {
    /// Width and height of the first.
    pub a: [u32; 2],
    /// Width and height of the second.
    pub b: [u32; 2],
}

/// How two pictures of one size differ. The delta of a pixel is the largest difference of its four bytes; colours under zero
/// alpha count like any others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Comparison {
    /// `histogram[d]` pixels have delta `d`.
    histogram: Box<[u64; 256]>,
}

impl Comparison {
    /// Pixels of each picture.
    #[must_use]
    pub fn pixels(&self) -> u64 {
        self.histogram.iter().sum()
    }
    /// Pixels that are not equal in all bytes.
    #[must_use]
    pub fn differing(&self) -> u64 {
        self.exceeding(0)
    }
    /// The largest delta.
    #[must_use]
    pub fn max_delta(&self) -> u8 {
        self.histogram.iter().rposition(|&n| n > 0).unwrap_or(0) as u8
    }
    /// Pixels whose delta is above a threshold.
    #[must_use]
    pub fn exceeding(&self, threshold: u8) -> u64 {
        self.histogram[usize::from(threshold) + 1..].iter().sum()
    }
    /// Counts above each threshold of [`SWEEP`].
    #[must_use]
    pub fn sweep(&self) -> [(u8, u64); SWEEP.len()] {
        SWEEP.map(|t| (t, self.exceeding(t)))
    }
    /// At most `pixels` pixels have a delta above `delta`.
    #[must_use]
    pub fn within(&self, delta: u8, pixels: u64) -> bool {
        self.exceeding(delta) <= pixels
    }
}

/// Compares two pictures byte by byte.
///
/// # Errors
/// [`SizeMismatch`].
pub fn compare(a: &Image, b: &Image) -> Result<Comparison, SizeMismatch> {
    let mut histogram = Box::new([0; 256]);
    for (p, q) in pairs(a, b)? {
        histogram[usize::from(delta(p, q))] += 1;
    }
    Ok(Comparison { histogram })
}

/// A picture of the differences: the first picture dimmed and grey, with every differing pixel in red, brighter for a larger
/// delta but never faint, so that a difference of one level can be seen.
///
/// # Errors
/// [`SizeMismatch`].
pub fn difference(a: &Image, b: &Image) -> Result<Image, SizeMismatch> {
    let mut data = Vec::with_capacity(a.data.len());
    for (p, q) in pairs(a, b)? {
        let d = u32::from(delta(p, q));
        let grey = (u32::from(p[0]) * 2 + u32::from(p[1]) * 5 + u32::from(p[2])) / 8;
        let dim = grey * u32::from(p[3]) / 255 / 3;
        data.extend(if d == 0 {
            [dim as u8, dim as u8, dim as u8, 255]
        } else {
            let dark = dim as u8 / 2;
            [(120 + d * 135 / 255) as u8, dark, dark, 255]
        });
    }
    Ok(Image {
        width: a.width,
        height: a.height,
        data,
    })
}

fn delta(p: &[u8], q: &[u8]) -> u8 {
    let deltas = p.iter().zip(q).map(|(a, b)| a.abs_diff(*b));
    deltas.max().unwrap_or(0)
}

/// Pixels of both pictures side by side.
fn pairs<'a>(
    a: &'a Image,
    b: &'a Image,
) -> Result<impl Iterator<Item = (&'a [u8], &'a [u8])>, SizeMismatch> {
    let size = |i: &Image| [i.width, i.height];
    if size(a) != size(b) || a.data.len() != b.data.len() {
        return Err(SizeMismatch {
            a: size(a),
            b: size(b),
        });
    }
    Ok(a.data.chunks_exact(4).zip(b.data.chunks_exact(4)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(pixels: &[[u8; 4]]) -> Image {
        Image {
            width: pixels.len() as u32,
            height: 1,
            data: pixels.concat(),
        }
    }

    #[test]
    fn counts_are_exact() {
        let a = picture(&[[10, 10, 10, 255]; 4]);
        let b = picture(&[
            [10, 10, 10, 255],
            [10, 11, 10, 255],
            [10, 10, 10, 253],
            [210, 9, 10, 255],
        ]);
        let c = compare(&a, &b).expect("same size");
        assert_eq!((c.pixels(), c.differing(), c.max_delta()), (4, 3, 200));
        assert_eq!([0, 1, 2, 199, 200].map(|t| c.exceeding(t)), [3, 2, 1, 1, 0]);
        assert_eq!(c.exceeding(255), 0);
        assert_eq!(c.sweep()[1], (1, 2));
        assert!(c.within(2, 1) && !c.within(2, 0) && c.within(200, 0));
        let same = compare(&a, &a).expect("same size");
        assert_eq!((same.differing(), same.max_delta()), (0, 0));
    }

    #[test]
    fn the_difference_picture_shows_a_single_level() {
        let a = picture(&[[90, 90, 90, 255]; 2]);
        let b = picture(&[[90, 90, 90, 255], [90, 90, 91, 255]]);
        let d = difference(&a, &b).expect("same size");
        assert_eq!(d.pixel(0, 0), [30, 30, 30, 255]);
        let [r, g, b, alpha] = d.pixel(1, 0);
        assert!(r >= 120 && g < 30 && b < 30 && alpha == 255);
    }

    #[test]
    fn sizes_must_agree() {
        let e = compare(&Image::new(2, 3), &Image::new(3, 2)).expect_err("different sizes");
        assert_eq!(e.to_string(), "2x3 pixels against 3x2");
        assert!(difference(&Image::new(1, 1), &Image::new(1, 2)).is_err());
    }
}
