//! Comparison of pictures, for golden tests and `earmark compare`: exact counts, what of it can be seen, and a picture of where.

mod difference;

use crate::film::DeepImage;
use difference::distance;
use std::fmt;

pub use difference::{NOTICEABLE, difference};

/// Two pictures of different size cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}x{} pixels against {}x{}", a[0], a[1], b[0], b[1])]
pub struct SizeMismatch {
    /// Width and height of the first.
    pub a: [u32; 2],
    /// Width and height of the second.
    pub b: [u32; 2],
}

/// What still counts as equal. The default is nothing but equal pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tolerance {
    /// Largest delta of a pixel that is let pass, in codes: 0 to 255, or to 65535 where either picture has 16 bits.
    pub max_delta: u16,
    /// So many pixels may have a larger one.
    pub max_pixels: u64,
}

/// How two pictures of one size differ. The delta of a pixel is the largest difference of its four codes; colours under zero
/// alpha count like any others. Where one picture has 8 bits and the other 16, the codes of the first count 257-fold.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Deltas that there are, ascending, with the number of pixels that have each.
    deltas: Vec<(u16, u64)>,
    full_delta: u16,
    visible: u64,
    farthest: f32,
    worst: [u32; 2],
    bounds: Option<[u32; 4]>,
}

impl Comparison {
    /// Pixels of each picture.
    #[must_use]
    pub fn pixels(&self) -> u64 {
        self.deltas.iter().map(|&(_, n)| n).sum()
    }
    /// Pixels that are not equal in all channels.
    #[must_use]
    pub fn differing(&self) -> u64 {
        self.exceeding(0)
    }
    /// The largest delta.
    #[must_use]
    pub fn max_delta(&self) -> u16 {
        self.deltas.last().map_or(0, |&(delta, _)| delta)
    }
    /// The largest delta that there could be: 255 or 65535.
    #[must_use]
    pub fn full_delta(&self) -> u16 {
        self.full_delta
    }
    /// Pixels whose delta is above a threshold.
    #[must_use]
    pub fn exceeding(&self, threshold: u16) -> u64 {
        let first = self.deltas.partition_point(|&(d, _)| d <= threshold);
        self.deltas[first..].iter().map(|&(_, n)| n).sum()
    }
    /// Thresholds 0, 1, 2, 4, 8 and so on, with the pixels above each, up to the first that none is above.
    #[must_use]
    pub fn sweep(&self) -> Vec<(u16, u64)> {
        let mut out = Vec::new();
        let mut threshold = 0;
        loop {
            let count = self.exceeding(threshold);
            out.push((threshold, count));
            if count == 0 || threshold > self.full_delta() / 2 {
                return out;
            }
            threshold = (threshold * 2).max(1);
        }
    }
    /// Pixels that differ by more than a [just noticeable difference](NOTICEABLE) over black or over white.
    #[must_use]
    pub fn visible(&self) -> u64 {
        self.visible
    }
    /// The largest distance of two colours in Oklab, over black or over white, 0 to 1.
    #[must_use]
    pub fn farthest(&self) -> f32 {
        self.farthest
    }
    /// The first pixel with the largest delta: column and row.
    #[must_use]
    pub fn worst(&self) -> [u32; 2] {
        self.worst
    }
    /// First column, first row, width and height of the rectangle that holds all differing pixels.
    #[must_use]
    pub fn bounds(&self) -> Option<[u32; 4]> {
        self.bounds
    }
    /// Whether so much difference is let pass.
    #[must_use]
    pub fn within(&self, tolerance: &Tolerance) -> bool {
        self.exceeding(tolerance.max_delta) <= tolerance.max_pixels
    }
}

/// Two lines: counts with the place of the largest delta, and the sweep.
impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (differing, pixels) = (self.differing(), self.pixels());
        let Some([x, y, width, height]) = self.bounds else {
            return write!(f, "all {pixels} pixels are equal");
        };
        let percent = differing as f64 * 100.0 / pixels.max(1) as f64;
        write!(
            f,
            "{differing} of {pixels} pixels differ ({percent:.3} %), {} of them visibly; inside {width}x{height} pixels at {x},{y}\n\
             largest delta {} of {} at {},{}; pixels with a delta",
            self.visible,
            self.max_delta(),
            self.full_delta(),
            self.worst[0],
            self.worst[1],
        )?;
        for (k, (threshold, count)) in self.sweep().into_iter().enumerate() {
            let comma = if k > 0 { "," } else { "" };
            write!(f, "{comma} above {threshold}: {count}")?;
        }
        Ok(())
    }
}

/// Compares two pictures code by code.
///
/// ```
/// use earmark::{compare::{Tolerance, compare}, film::Image};
///
/// let a = Image::new(4, 4);
/// let mut b = a.clone();
/// b.data[5] = 3;
/// let found = compare(&(&a).into(), &(&b).into())?;
/// assert_eq!((found.differing(), found.max_delta()), (1, 3));
/// assert!(!found.within(&Tolerance::default()) && found.within(&Tolerance { max_delta: 3, max_pixels: 0 }));
/// # Ok::<(), earmark::compare::SizeMismatch>(())
/// ```
///
/// # Errors
/// [`SizeMismatch`].
pub fn compare(a: &DeepImage, b: &DeepImage) -> Result<Comparison, SizeMismatch> {
    let codes = if a.bits.max(b.bits) > 8 { 65536 } else { 256 };
    let mut histogram = vec![0; codes];
    let mut out = Comparison {
        deltas: Vec::new(),
        full_delta: (codes - 1) as u16,
        visible: 0,
        farthest: 0.0,
        worst: [0; 2],
        bounds: None,
    };
    let mut largest = 0;
    let width = a.width.max(1) as usize;
    for (k, (p, q)) in pairs(a, b)?.enumerate() {
        let delta = delta(p, q);
        histogram[usize::from(delta)] += 1;
        if delta == 0 {
            continue;
        }
        let at = [(k % width) as u32, (k / width) as u32];
        if delta > largest {
            (largest, out.worst) = (delta, at);
        }
        let [x0, y0, w, h] = out.bounds.unwrap_or([at[0], at[1], 1, 1]);
        let (left, top) = (x0.min(at[0]), y0.min(at[1]));
        let (right, bottom) = ((x0 + w).max(at[0] + 1), (y0 + h).max(at[1] + 1));
        out.bounds = Some([left, top, right - left, bottom - top]);
        let seen = distance(p, q, codes);
        out.farthest = out.farthest.max(seen);
        out.visible += u64::from(seen > NOTICEABLE);
    }
    let counted = (0..=out.full_delta).zip(histogram);
    out.deltas = counted.filter(|&(_, n)| n > 0).collect();
    Ok(out)
}

fn delta(p: [u16; 4], q: [u16; 4]) -> u16 {
    let deltas = p.iter().zip(q).map(|(a, b)| a.abs_diff(b));
    deltas.max().unwrap_or(0)
}

/// Pixels of both pictures side by side, in codes of the one with more bits.
fn pairs(
    a: &DeepImage,
    b: &DeepImage,
) -> Result<impl Iterator<Item = ([u16; 4], [u16; 4])>, SizeMismatch> {
    let size = |i: &DeepImage| [i.width, i.height];
    if size(a) != size(b) || a.data.len() != b.data.len() {
        return Err(SizeMismatch {
            a: size(a),
            b: size(b),
        });
    }
    let bits = a.bits.max(b.bits);
    // Codes above those of its bits count as the largest, as they do in files.
    let scale = |i: &DeepImage| {
        let most = if i.bits > 8 { u16::MAX } else { 255 };
        (most, if i.bits < bits { 257 } else { 1 })
    };
    let ((ma, ka), (mb, kb)) = (scale(a), scale(b));
    let (a, b) = (a.data.as_chunks::<4>().0, b.data.as_chunks::<4>().0);
    let both = a.iter().zip(b);
    Ok(both.map(move |(p, q)| (p.map(|c| c.min(ma) * ka), q.map(|c| c.min(mb) * kb))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Image;

    fn picture(pixels: &[[u8; 4]]) -> DeepImage {
        DeepImage::from(Image {
            width: pixels.len() as u32,
            height: 1,
            data: pixels.concat(),
        })
    }

    fn tolerance(max_delta: u16, max_pixels: u64) -> Tolerance {
        Tolerance {
            max_delta,
            max_pixels,
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
        assert_eq!(c.sweep().last(), Some(&(128, 1)));
        assert_eq!((c.worst(), c.bounds()), ([3, 0], Some([1, 0, 3, 1])));
        // A little alpha shows on white under a dark colour.
        assert_eq!(c.visible(), 2);
        let lets = |d, n| c.within(&tolerance(d, n));
        assert!(lets(2, 1) && !lets(2, 0) && lets(200, 0) && lets(0, 3) && !lets(0, 2));
        let same = compare(&a, &a).expect("same size");
        assert_eq!((same.differing(), same.max_delta()), (0, 0));
        assert_eq!(same.to_string(), "all 4 pixels are equal");
        let text = c.to_string();
        assert!(text.contains("3 of 4 pixels differ (75.000 %), 2 of them visibly"));
        assert!(
            text.contains("delta 200 of 255 at 3,0") && text.contains("above 2: 1,"),
            "{text}"
        );
    }

    #[test]
    fn sixteen_bits_count_in_their_own_codes() {
        let shallow = picture(&[[0, 128, 255, 255]; 2]);
        let mut deep = DeepImage {
            bits: 16,
            data: shallow.data.iter().map(|c| c * 257).collect(),
            ..shallow.clone()
        };
        let same = compare(&shallow, &deep).expect("same size");
        assert_eq!((same.differing(), same.full_delta()), (0, 65535));
        deep.data[5] -= 300;
        let c = compare(&shallow, &deep).expect("same size");
        assert_eq!((c.differing(), c.max_delta(), c.worst()), (1, 300, [1, 0]));
        assert_eq!(c.sweep().last(), Some(&(512, 0)));
        deep.data[7] = 0;
        let c = compare(&deep, &shallow).expect("same size");
        assert_eq!(c.max_delta(), 65535);
        assert_eq!(c.sweep().last(), Some(&(32768, 1)));
    }

    #[test]
    fn codes_beyond_the_bits_are_the_largest() {
        let white = picture(&[[255; 4]]);
        let beyond = DeepImage {
            data: vec![999; 4],
            ..white.clone()
        };
        let same = compare(&white, &beyond).expect("same size");
        assert_eq!(same.differing(), 0);
    }

    #[test]
    fn sizes_must_agree() {
        let image = |w, h| DeepImage::from(Image::new(w, h));
        let e = compare(&image(2, 3), &image(3, 2)).expect_err("different sizes");
        assert_eq!(e.to_string(), "2x3 pixels against 3x2");
        assert!(difference(&image(1, 1), &image(1, 2)).is_err());
    }
}
