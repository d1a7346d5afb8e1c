//! Film: from samples to pixels.
//!
//! Samples are linear, premultiplied RGBA; a sample that hits nothing is four zeros. The samples of a pixel are added in their
//! own order and divided by their number (box filter), laid over the background, and encoded in 8 bits: by the sRGB curve for
//! light, or without a curve for data such as normals ([`Encoding`]). Alpha has no curve and is straight in the result.

pub mod png;
pub mod srgb;

use crate::film::srgb::{Srgb, quantize};
use crate::math::positive;
use crate::simd::LANES;

/// Why bytes are no PNG picture.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not a readable PNG: {0}")]
pub struct ReadError(pub String);

/// Why a picture cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The number of values does not fit the size.
    #[error("{got} values given for a picture that needs {wanted}")]
    WrongLength {
        /// Values given.
        got: usize,
        /// Values the size needs.
        wanted: usize,
    },
    /// A picture without pixels, or one too large for the format.
    #[error("a picture of {width}x{height} pixels cannot be written as PNG")]
    Size {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// The encoder failed.
    #[error("PNG encoder: {0}")]
    Encoder(String),
}

/// A picture of 8-bit RGBA pixels, straight alpha, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Four bytes per pixel, `width * height * 4` in all.
    pub data: Vec<u8>,
}

impl Image {
    /// A picture of transparent black.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            data: vec![0; width as usize * height as usize * 4],
        }
    }

    /// A picture of one colour, pixels across and down; sRGB with straight alpha.
    #[must_use]
    pub fn filled([width, height]: [u32; 2], color: [u8; 4]) -> Self {
        Self {
            width,
            height,
            data: color.repeat(width as usize * height as usize),
        }
    }

    /// The pixel in column `x` and row `y`.
    ///
    /// # Panics
    /// Outside the picture.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        assert!(x < self.width && y < self.height, "pixel outside");
        let i = (y as usize * self.width as usize + x as usize) * 4;
        [0, 1, 2, 3].map(|k| self.data[i + k])
    }

    /// No pixel shows the background of a viewer through it.
    #[must_use]
    pub fn is_opaque(&self) -> bool {
        self.data.chunks_exact(4).all(|p| p[3] == 255)
    }
}

/// A picture of RGBA pixels with 8 or 16 bits a channel, straight alpha, rows from the top: what comparisons work on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeepImage {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// 8 or 16.
    pub bits: u32,
    /// Four codes per pixel, 0 to 255 or to 65535.
    pub data: Vec<u16>,
}

impl From<&Image> for DeepImage {
    fn from(image: &Image) -> Self {
        Self {
            width: image.width,
            height: image.height,
            bits: 8,
            data: image.data.iter().map(|&b| b.into()).collect(),
        }
    }
}

impl From<Image> for DeepImage {
    fn from(image: Image) -> Self {
        Self::from(&image)
    }
}

/// How numbers become bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// Light: linear, encoded by the sRGB curve.
    #[default]
    Srgb,
    /// Data from 0 to 1, encoded without a curve.
    Raw,
}

/// The samples of one pixel, being added up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelSum {
    sum: [f32; 4],
}

impl PixelSum {
    /// Adds a sample; linear, premultiplied.
    #[inline]
    pub fn add(&mut self, sample: [f32; 4]) {
        for (s, c) in self.sum.iter_mut().zip(sample) {
            *s += c;
        }
    }

    /// Adds a colour that `count` samples share.
    #[inline]
    pub fn add_times(&mut self, sample: [f32; 4], count: u32) {
        let n = count as f32;
        for (s, c) in self.sum.iter_mut().zip(sample) {
            *s += c * n;
        }
    }

    /// The mean over `samples` samples; those never added count as transparent.
    #[must_use]
    #[inline]
    pub fn mean(self, samples: u32) -> [f32; 4] {
        let k = 1.0 / samples as f32;
        self.sum.map(|s| s * k)
    }
}

/// What pixels are laid over, and how they are encoded. Copied freely; holds no picture.
#[derive(Clone, Copy, Debug)]
pub struct Film {
    encoding: Encoding,
    /// Premultiplied; linear for light.
    background: [f32; 4],
    /// The background, encoded.
    empty: [u8; 4],
    srgb: &'static Srgb,
}

impl Film {
    /// A film over a background as the user writes it: 8-bit sRGB with straight alpha, `[0; 4]` for transparent.
    #[must_use]
    pub fn new(encoding: Encoding, background: [u8; 4]) -> Self {
        let srgb = Srgb::tables();
        let alpha = f32::from(background[3]) / 255.0;
        let channel = |c: u8| match encoding {
            Encoding::Srgb => srgb.decode(c) * alpha,
            Encoding::Raw => f32::from(c) / 255.0 * alpha,
        };
        let [r, g, b, _] = background;
        let mut film = Self {
            encoding,
            background: [channel(r), channel(g), channel(b), alpha],
            empty: [0; 4],
            srgb,
        };
        film.empty = film.encode_over(film.background);
        film
    }

    /// The pixel of a colour; linear, premultiplied.
    #[must_use]
    #[inline]
    pub fn pixel(&self, color: [f32; 4]) -> [u8; 4] {
        if color[3] <= 0.0 {
            return self.empty;
        }
        let rest = positive(1.0 - color[3]);
        let mut over = color;
        for (c, b) in over.iter_mut().zip(self.background) {
            *c += b * rest;
        }
        self.encode_over(over)
    }

    /// The pixels of opaque light, in lanes of red, green and blue: [`Film::pixel`] of each, for [`Encoding::Srgb`], with the first byte
    /// lowest.
    #[must_use]
    #[inline(always)]
    pub fn opaque_lanes(&self, light: &[[f32; LANES]; 3]) -> [u32; LANES] {
        let mut codes = [[0_u32; LANES]; 3];
        for k in 0..3 {
            codes[k] = self.srgb.encode_lanes(&light[k]);
        }
        let mut out = [0; LANES];
        for l in 0..LANES {
            let code = |k: usize| codes[k][l];
            out[l] = code(0) | code(1) << 8 | code(2) << 16 | 255 << 24;
        }
        out
    }

    /// The pixel of a group of samples, in their order.
    #[must_use]
    #[inline]
    pub fn pixel_of(&self, samples: &[[f32; 4]]) -> [u8; 4] {
        let mut sum = PixelSum::default();
        for &s in samples {
            sum.add(s);
        }
        self.pixel(sum.mean(samples.len().max(1) as u32))
    }

    /// Resolves a row: `samples` holds `per_pixel` samples of each pixel one after the other, `out` gets four bytes per pixel.
    ///
    /// # Panics
    /// When the lengths do not agree or `per_pixel` is 0.
    pub fn resolve(&self, samples: &[[f32; 4]], per_pixel: usize, out: &mut [u8]) {
        assert!(per_pixel > 0, "no samples per pixel");
        assert_eq!(samples.len() / per_pixel * 4, out.len(), "row length");
        for (s, o) in samples.chunks_exact(per_pixel).zip(out.chunks_exact_mut(4)) {
            o.copy_from_slice(&self.pixel_of(s));
        }
    }

    /// The background as pixels are laid over it: premultiplied, linear for light.
    #[cfg(feature = "gpu")]
    pub(crate) fn background(&self) -> [f32; 4] {
        self.background
    }

    /// The pixel where nothing is drawn.
    #[must_use]
    pub fn empty(&self) -> [u8; 4] {
        self.empty
    }

    /// Encodes a premultiplied colour as it stands.
    #[inline]
    fn encode_over(&self, color: [f32; 4]) -> [u8; 4] {
        let alpha = color[3];
        if alpha.is_nan() || alpha <= 0.0 {
            return [0; 4];
        }
        let k = if alpha >= 1.0 { 1.0 } else { 1.0 / alpha };
        let [r, g, b] = [color[0] * k, color[1] * k, color[2] * k];
        let code = |c: f32| match self.encoding {
            Encoding::Srgb => self.srgb.encode(c),
            Encoding::Raw => quantize(c),
        };
        [code(r), code(g), code(b), quantize(alpha)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opaque_samples_hide_the_background() {
        let film = Film::new(Encoding::Srgb, [9, 8, 7, 255]);
        assert_eq!(film.pixel([1.0, 0.0, 0.0, 1.0]), [255, 0, 0, 255]);
        assert_eq!(film.pixel([0.0; 4]), [9, 8, 7, 255]);
        assert_eq!(film.empty(), [9, 8, 7, 255]);
    }

    #[test]
    fn half_covered_pixels_mix_in_linear_light() {
        let white = [1.0; 4];
        let film = Film::new(Encoding::Srgb, [0, 0, 0, 255]);
        // Half of the light, not half of the code: 188, not 128.
        assert_eq!(film.pixel_of(&[white, [0.0; 4]]), [188, 188, 188, 255]);
        let raw = Film::new(Encoding::Raw, [0, 0, 0, 255]);
        assert_eq!(raw.pixel_of(&[white, [0.0; 4]]), [128, 128, 128, 255]);
    }

    #[test]
    fn transparent_pictures_keep_straight_colour() {
        let film = Film::new(Encoding::Srgb, [0; 4]);
        let grey = Srgb::tables().decode(100);
        let sample = [grey, grey, grey, 1.0];
        for covered in 1..=4 {
            let mut samples = [[0.0; 4]; 4];
            samples[..covered].fill(sample);
            let [r, g, b, a] = film.pixel_of(&samples);
            assert_eq!([r, g, b], [100; 3]);
            assert_eq!(usize::from(a), (covered * 255 + 2) / 4);
        }
        assert_eq!(film.pixel_of(&[[0.0; 4]; 4]), [0; 4]);
    }

    #[test]
    fn translucent_background_and_sample_add_their_alpha() {
        let film = Film::new(Encoding::Raw, [0, 0, 255, 128]);
        // Half red over half blue (128/255): alpha 191.5/255, two thirds red.
        let p = film.pixel([0.5, 0.0, 0.0, 0.5]);
        assert_eq!(p, [170, 0, 85, 192]);
        assert_eq!(film.empty(), [0, 0, 255, 128]);
    }

    #[test]
    fn rows_and_shared_colours_agree_with_single_pixels() {
        let film = Film::new(Encoding::Srgb, [20, 40, 60, 255]);
        let a = [0.2, 0.3, 0.4, 1.0];
        let b = [0.1, 0.1, 0.1, 0.5];
        let samples = [a, a, b, [0.0; 4], b, b, b, b];
        let mut row = [0; 8];
        film.resolve(&samples, 4, &mut row);
        assert_eq!(row[..4], film.pixel_of(&samples[..4]));
        let mut sum = PixelSum::default();
        sum.add_times(b, 4);
        assert_eq!(row[4..], film.pixel(sum.mean(4)));
    }

    #[test]
    fn numbers_out_of_range_stay_pixels() {
        let film = Film::new(Encoding::Srgb, [0; 4]);
        assert_eq!(film.pixel([9.0, -9.0, f32::NAN, 1.0]), [255, 0, 0, 255]);
        assert_eq!(film.pixel([f32::NAN; 4]), [0; 4]);
    }
}
