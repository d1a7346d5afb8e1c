//! What of a difference can be seen, and a picture that says so.
//!
//! Colours are compared in Oklab (Björn Ottosson, *A perceptual color space for image processing*, 2020), laid over black and over
//! white: a change of alpha shows on one of them. [`NOTICEABLE`] is the just noticeable difference that CSS Color 4 takes for it.

use super::{SizeMismatch, delta, pairs};
use crate::film::srgb::Srgb;
use crate::film::{DeepImage, Image};

/// Distance in Oklab below which two colours side by side look alike.
pub const NOTICEABLE: f32 = 0.02;

/// A picture of the differences: the first picture dimmed and grey under the pixels that differ. Violet is a difference that cannot be
/// seen, however small; one that can goes from red by orange and yellow to white, for a distance of a half and more in Oklab, where
/// black and white are 1 apart.
///
/// # Errors
/// [`SizeMismatch`].
pub fn difference(a: &DeepImage, b: &DeepImage) -> Result<Image, SizeMismatch> {
    let codes = if a.bits.max(b.bits) > 8 { 65536 } else { 256 };
    let mut data = Vec::with_capacity(a.data.len());
    for (p, q) in pairs(a, b)? {
        data.extend(match delta(p, q) {
            0 => {
                let dim = dimmed(p, codes);
                [dim, dim, dim, 255]
            }
            _ => color(distance(p, q, codes)),
        });
    }
    Ok(Image {
        width: a.width,
        height: a.height,
        data,
    })
}

/// A third of the brightness over black.
fn dimmed(p: [u16; 4], codes: usize) -> u8 {
    let [r, g, b, a] = p.map(u64::from);
    let full = codes as u64 - 1;
    ((r * 2 + g * 5 + b) * a * 255 / (8 * 3 * full * full)) as u8
}

/// The colour of a distance.
fn color(distance: f32) -> [u8; 4] {
    const SEEN: [[f32; 3]; 4] = [
        [210.0, 25.0, 45.0],
        [240.0, 120.0, 20.0],
        [255.0, 225.0, 60.0],
        [255.0, 255.0, 255.0],
    ];
    if distance <= NOTICEABLE {
        return [150, 70, 255, 255];
    }
    // Equal steps for equal factors.
    let t = libm::logf(distance / NOTICEABLE) / libm::logf(0.5 / NOTICEABLE);
    let t = t.clamp(0.0, 1.0) * 3.0;
    let k = (t as usize).min(2);
    let part = t - k as f32;
    let [r, g, b] =
        [0, 1, 2].map(|c| (SEEN[k][c] + (SEEN[k + 1][c] - SEEN[k][c]) * part + 0.5) as u8);
    [r, g, b, 255]
}

/// Distance of two pixels, over black or over white, whichever is larger.
pub(super) fn distance(p: [u16; 4], q: [u16; 4], codes: usize) -> f32 {
    let over = |p, ground| oklab(over(p, ground, codes));
    let apart = |ground| {
        let (a, b) = (over(p, ground), over(q, ground));
        let d = [0, 1, 2].map(|k| a[k] - b[k]);
        (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
    };
    let dark: f32 = apart(0.0);
    dark.max(apart(1.0))
}

/// Linear colour of a pixel over grey of a brightness.
fn over(p: [u16; 4], ground: f32, codes: usize) -> [f32; 3] {
    let srgb = Srgb::tables();
    let linear = |c: u16| match codes {
        256 => srgb.decode(c as u8),
        _ => {
            // Between two codes of 8 bits the curve is straight for the eye.
            let (low, part) = (c / 257, f32::from(c % 257) / 257.0);
            let at = srgb.decode(low as u8);
            at + (srgb.decode((low + 1).min(255) as u8) - at) * part
        }
    };
    let alpha = f32::from(p[3]) / (codes - 1) as f32;
    [0, 1, 2].map(|k| linear(p[k]) * alpha + ground * (1.0 - alpha))
}

/// Oklab of linear sRGB.
fn oklab([r, g, b]: [f32; 3]) -> [f32; 3] {
    let l = libm::cbrtf(0.412_221_47 * r + 0.536_332_55 * g + 0.051_445_995 * b);
    let m = libm::cbrtf(0.211_903_5 * r + 0.680_699_5 * g + 0.107_396_96 * b);
    let s = libm::cbrtf(0.088_302_46 * r + 0.281_718_85 * g + 0.629_978_7 * b);
    [
        0.210_454_26 * l + 0.793_617_8 * m - 0.004_072_047 * s,
        1.977_998_5 * l - 2.428_592_2 * m + 0.450_593_7 * s,
        0.025_904_037 * l + 0.782_771_77 * m - 0.808_675_77 * s,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oklab_is_as_published() {
        // The pairs of the publication: white, and the XYZ axes' neighbours by their sRGB values.
        let white = oklab([1.0; 3]);
        assert!((white[0] - 1.0).abs() < 1e-5 && white[1].abs() < 1e-4 && white[2].abs() < 1e-4);
        let red = oklab([1.0, 0.0, 0.0]);
        for (got, want) in red.iter().zip([0.627_955, 0.224_863, 0.125_846]) {
            assert!((got - want).abs() < 1e-4, "{red:?}");
        }
    }

    #[test]
    fn the_picture_tells_what_can_be_seen() {
        let line = |pixels: &[[u8; 4]]| {
            DeepImage::from(Image {
                width: pixels.len() as u32,
                height: 1,
                data: pixels.concat(),
            })
        };
        let grey = [90, 90, 90, 255];
        let a = line(&[grey, grey, grey, grey, [0, 0, 0, 255]]);
        let b = line(&[
            grey,
            [90, 90, 91, 255],
            [110, 90, 90, 255],
            [90, 90, 90, 128],
            [255; 4],
        ]);
        let d = difference(&a, &b).expect("same size");
        assert_eq!(d.pixel(0, 0), [30, 30, 30, 255]);
        assert_eq!(d.pixel(1, 0), [150, 70, 255, 255]);
        let [r, g, ..] = d.pixel(2, 0);
        assert!(r > 200 && g < 130);
        assert!(d.pixel(3, 0)[1] > 100, "alpha shows over white");
        assert_eq!(d.pixel(4, 0), [255; 4]);
        let same = difference(&a, &a).expect("same size");
        assert_eq!(same.pixel(1, 0), [30, 30, 30, 255]);
    }
}
