//! Textures from the bytes of pictures, within limits.

use super::levels::{build_levels, level_sizes};
use super::{MAX_BYTES, MAX_SIDE, Meaning, Texels, Texture};
use crate::film::srgb::Srgb;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::io::Cursor;

/// Why bytes are no texture, by who can help.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// Neither PNG nor JPEG.
    #[error("not a PNG or JPEG picture")]
    Unsupported,
    /// Damaged or unusual contents.
    #[error("damaged picture: {0}")]
    Damaged(String),
    /// A picture without texels.
    #[error("the picture has no pixels")]
    Empty,
    /// A side above [`MAX_SIDE`].
    #[error("{width}x{height} pixels; a side may have {MAX_SIDE}")]
    TooLarge {
        /// Texels across.
        width: u32,
        /// Texels down.
        height: u32,
    },
    /// More bytes than one texture, or all of them together, may take.
    #[error("{width}x{height} pixels need {wanted} bytes of memory, {allowed} are allowed")]
    Budget {
        /// Texels across.
        width: u32,
        /// Texels down.
        height: u32,
        /// Bytes needed.
        wanted: u64,
        /// Bytes left.
        allowed: u64,
    },
}

impl Texture {
    /// Decodes a PNG or JPEG file. `budget` is the number of bytes that textures may still take together; it is lowered by
    /// what this one takes. Sizes are checked from the header, before anything is decoded.
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn decode(bytes: &[u8], meaning: Meaning, budget: &mut u64) -> Result<Self, LoadError> {
        let damaged = |e: image::ImageError| LoadError::Damaged(e.to_string());
        let mut reader = ImageReader::new(Cursor::new(bytes))
            .with_guessed_format()
            .map_err(|e| LoadError::Damaged(e.to_string()))?;
        if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg)) {
            return Err(LoadError::Unsupported);
        }
        let mut limits = Limits::no_limits();
        limits.max_alloc = Some(MAX_BYTES);
        reader.limits(limits);
        let decoder = reader.into_decoder().map_err(damaged)?;
        let (width, height) = decoder.dimensions();
        let color = decoder.color_type();
        let wide = color.bytes_per_pixel() > color.channel_count();
        let wanted = check_size(width, height, if wide { 8 } else { 4 }, *budget)?;
        let has_alpha = color.has_alpha();
        let picture = DynamicImage::from_decoder(decoder).map_err(damaged)?;
        let texture = if wide {
            let texels = with_room(width, height, picture.into_rgba16().as_raw());
            Self::from_words(width, height, texels, meaning, has_alpha)
        } else {
            let texels = with_room(width, height, picture.into_rgba8().as_raw());
            Self::from_bytes(width, height, texels, meaning, has_alpha)
        };
        *budget -= wanted;
        Ok(texture)
    }

    /// A texture from RGBA texels, rows from the top.
    ///
    /// # Errors
    /// [`LoadError`] when the size is not allowed or there are not `width * height` texels.
    pub fn from_rgba8(
        width: u32,
        height: u32,
        texels: Vec<[u8; 4]>,
        meaning: Meaning,
    ) -> Result<Self, LoadError> {
        check_given(width, height, 4, texels.len())?;
        let has_alpha = texels.iter().any(|t| t[3] != 255);
        Ok(Self::from_bytes(width, height, texels, meaning, has_alpha))
    }

    /// A texture from RGBA texels of 16 bits, rows from the top.
    ///
    /// # Errors
    /// As [`Texture::from_rgba8`].
    pub fn from_rgba16(
        width: u32,
        height: u32,
        texels: Vec<[u16; 4]>,
        meaning: Meaning,
    ) -> Result<Self, LoadError> {
        check_given(width, height, 8, texels.len())?;
        let has_alpha = texels.iter().any(|t| t[3] != u16::MAX);
        Ok(Self::from_words(width, height, texels, meaning, has_alpha))
    }

    fn from_bytes(
        width: u32,
        height: u32,
        texels: Vec<[u8; 4]>,
        meaning: Meaning,
        has_alpha: bool,
    ) -> Self {
        let srgb = Srgb::tables();
        let curve = meaning == Meaning::Color;
        // 16-bit linear numbers of the codes, for averaging.
        let wide: [u16; 256] = std::array::from_fn(|c| {
            if curve {
                (srgb.decode(c as u8) * 65_535.0 + 0.5) as u16
            } else {
                c as u16 * 257
            }
        });
        let mut all = texels;
        let levels = build_levels(
            width,
            height,
            &mut all,
            |t: [u8; 4]| {
                [
                    wide[usize::from(t[0])],
                    wide[usize::from(t[1])],
                    wide[usize::from(t[2])],
                    u16::from(t[3]) * 257,
                ]
            },
            |w: [u16; 4]| {
                let plain = |x: u16| ((u32::from(x) + 128) / 257) as u8;
                let code = |x: u16| {
                    if curve {
                        srgb.encode(f32::from(x) * (1.0 / 65_535.0))
                    } else {
                        plain(x)
                    }
                };
                [code(w[0]), code(w[1]), code(w[2]), plain(w[3])]
            },
        );
        let values = Box::new(std::array::from_fn(|c| {
            if curve {
                srgb.decode(c as u8)
            } else {
                c as f32 / 255.0
            }
        }));
        Self {
            lod_bias: lod_bias(width, height),
            levels,
            texels: Texels::Byte(all),
            values,
            has_alpha,
        }
    }

    /// Words are made linear at once: 16 bits are enough to keep the darkest sRGB codes apart.
    fn from_words(
        width: u32,
        height: u32,
        mut texels: Vec<[u16; 4]>,
        meaning: Meaning,
        has_alpha: bool,
    ) -> Self {
        if meaning == Meaning::Color {
            let table: Vec<u16> = (0..=u16::MAX)
                .map(|c| {
                    let linear = crate::film::srgb::to_linear(f64::from(c) / 65_535.0);
                    (linear * 65_535.0 + 0.5) as u16
                })
                .collect();
            for t in &mut texels {
                for c in &mut t[..3] {
                    *c = table[usize::from(*c)];
                }
            }
        }
        let levels = build_levels(width, height, &mut texels, |t| t, |t| t);
        Self {
            lod_bias: lod_bias(width, height),
            levels,
            texels: Texels::Word(texels),
            values: Box::new([0.0; 256]),
            has_alpha,
        }
    }
}

fn lod_bias(width: u32, height: u32) -> f32 {
    (libm::log2(f64::from(width) * f64::from(height)) * 0.5) as f32
}

/// Texels of level 0 in a list with room for all levels.
fn with_room<T: Copy>(width: u32, height: u32, values: &[T]) -> Vec<[T; 4]> {
    let count = level_sizes(width, height)
        .map(|(w, h)| w as usize * h as usize)
        .sum();
    let mut texels = Vec::with_capacity(count);
    texels.extend_from_slice(values.as_chunks::<4>().0);
    texels
}

/// Refuses sizes that are not allowed, and another number of texels than they say.
fn check_given(width: u32, height: u32, per_texel: u64, count: usize) -> Result<(), LoadError> {
    check_size(width, height, per_texel, MAX_BYTES)?;
    if count == width as usize * height as usize {
        return Ok(());
    }
    Err(LoadError::Damaged(format!(
        "{count} texels given for {width}x{height}"
    )))
}

/// Bytes of a texture and its levels, refused when a limit is passed.
fn check_size(width: u32, height: u32, per_texel: u64, budget: u64) -> Result<u64, LoadError> {
    if width == 0 || height == 0 {
        return Err(LoadError::Empty);
    }
    if width > MAX_SIDE || height > MAX_SIDE {
        return Err(LoadError::TooLarge { width, height });
    }
    let wanted = level_sizes(width, height)
        .map(|(w, h)| u64::from(w) * u64::from(h) * per_texel)
        .sum();
    let allowed = budget.min(MAX_BYTES);
    if wanted > allowed {
        return Err(LoadError::Budget {
            width,
            height,
            wanted,
            allowed,
        });
    }
    Ok(wanted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_checked_before_memory_is_taken() {
        assert_eq!(check_size(0, 4, 4, 1 << 30), Err(LoadError::Empty));
        assert!(matches!(
            check_size(65_536, 1, 4, u64::MAX),
            Err(LoadError::TooLarge { .. })
        ));
        assert!(matches!(
            check_size(65_535, 65_535, 4, u64::MAX),
            Err(LoadError::Budget { .. })
        ));
        assert_eq!(check_size(2, 2, 4, 20), Ok(20));
        assert!(check_size(2, 2, 4, 19).is_err());
        // An 8K map with its levels fits.
        assert!(check_size(8192, 8192, 4, u64::MAX).is_ok());
    }
}
