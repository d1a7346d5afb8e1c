//! PNG out (and in again, for comparisons): bytes to bytes, no files.
//!
//! Fast compression with the `Up`… see [`encode`] for the settings and what they cost. The bytes depend on the pixels and on
//! the version of the `png` package alone.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use super::{Image, WriteError};

/// PNG bytes with an alpha channel.
///
/// # Errors
/// [`WriteError`] when the data does not fit the size, or the picture has no pixels.
pub fn encode(image: &Image) -> Result<Vec<u8>, WriteError> {
    write(
        &image.data,
        4,
        image.width,
        image.height,
        ExtendedColorType::Rgba8,
    )
}

/// PNG bytes without an alpha channel.
///
/// # Errors
/// As [`encode`].
pub fn encode_rgb(image: &Image) -> Result<Vec<u8>, WriteError> {
    let rgb: Vec<u8> = image
        .data
        .chunks_exact(4)
        .flat_map(|p| [p[0], p[1], p[2]])
        .collect();
    write(&rgb, 3, image.width, image.height, ExtendedColorType::Rgb8)
}

/// PNG bytes of one 16-bit value per pixel.
///
/// # Errors
/// As [`encode`].
pub fn encode_gray16(width: u32, height: u32, values: &[u16]) -> Result<Vec<u8>, WriteError> {
    write(
        &native_bytes(values),
        2,
        width,
        height,
        ExtendedColorType::L16,
    )
}

/// PNG bytes of three 16-bit values per pixel.
///
/// # Errors
/// As [`encode`].
pub fn encode_rgb16(width: u32, height: u32, values: &[u16]) -> Result<Vec<u8>, WriteError> {
    write(
        &native_bytes(values),
        6,
        width,
        height,
        ExtendedColorType::Rgb16,
    )
}

/// The encoder takes 16-bit values in the machine's own byte order.
fn native_bytes(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_ne_bytes()).collect()
}

fn write(
    data: &[u8],
    bytes_per_pixel: usize,
    width: u32,
    height: u32,
    color: ExtendedColorType,
) -> Result<Vec<u8>, WriteError> {
    // PNG sides are 31-bit numbers above 0.
    if width == 0 || height == 0 || width > i32::MAX as u32 || height > i32::MAX as u32 {
        return Err(WriteError::Size { width, height });
    }
    let wanted = (width as usize)
        .checked_mul(height as usize)
        .and_then(|n| n.checked_mul(bytes_per_pixel))
        .ok_or(WriteError::Size { width, height })?;
    if data.len() != wanted {
        return Err(WriteError::WrongLength {
            got: data.len(),
            wanted,
        });
    }
    let mut out = Vec::new();
    PngEncoder::new_with_quality(&mut out, CompressionType::Fast, FilterType::Up)
        .write_image(data, width, height, color)
        .map_err(|e| WriteError::Encoder(e.to_string()))?;
    Ok(out)
}
