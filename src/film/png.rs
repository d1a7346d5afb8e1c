//! PNG out, and in again for comparisons: bytes to bytes, no files.
//!
//! Fast compression with the Paeth filter. For a shaded picture of 1024x1024 pixels on a busy machine that took 13 to 15 ms and
//! 500 to 620 KB; other filters were no faster and up to a third larger, zlib's level 2 took four times as long for a fifth
//! less, the default level twenty times as long for a third less. The bytes depend on the pixels and on the version of the
//! `png` package alone.

use std::io::{Cursor, Write};

use image::codecs::png::{CompressionType, FilterType, PngDecoder, PngEncoder};
use image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, Limits};

use super::{DeepImage, Image, ReadError, WriteError};

/// Most bytes that [`decode`] allocates.
const MAX_DECODED: u64 = 2 << 30;

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

/// PNG bytes of a picture with 8 or 16 bits a channel, with an alpha channel.
///
/// # Errors
/// As [`encode`]. Of 8 bits, codes above 255 are written as 255.
pub fn encode_deep(image: &DeepImage) -> Result<Vec<u8>, WriteError> {
    let (width, height) = (image.width, image.height);
    if image.bits > 8 {
        let bytes = native_bytes(&image.data);
        return write(&bytes, 8, width, height, ExtendedColorType::Rgba16);
    }
    let bytes: Vec<u8> = image.data.iter().map(|&c| c.min(255) as u8).collect();
    write(&bytes, 4, width, height, ExtendedColorType::Rgba8)
}

/// PNG bytes of data as the file stores them: `format` is channels (1 grey, 3 RGB, 4 RGBA) and bits (8 or 16, the higher byte first).
/// Every pair of a keyword and a text is a chunk of its own before the data.
///
/// # Errors
/// As [`encode`]; also for keywords that PNG does not take.
pub fn encode_data(
    data: &[u8],
    [width, height]: [u32; 2],
    [channels, bits]: [u32; 2],
    texts: &[(&str, String)],
) -> Result<Vec<u8>, WriteError> {
    let color = match channels {
        1 => ::png::ColorType::Grayscale,
        3 => ::png::ColorType::Rgb,
        _ => ::png::ColorType::Rgba,
    };
    let wanted = (width as usize)
        .checked_mul(height as usize)
        .and_then(|n| n.checked_mul(color.samples() * (bits as usize / 8)))
        .ok_or(WriteError::Size { width, height })?;
    if data.len() != wanted {
        let got = data.len();
        return Err(WriteError::WrongLength { got, wanted });
    }
    let mut out = Vec::new();
    let mut encoder = fast_encoder(&mut out, width, height);
    encoder.set_color(color);
    encoder.set_depth(match bits {
        16 => ::png::BitDepth::Sixteen,
        _ => ::png::BitDepth::Eight,
    });
    for (keyword, text) in texts {
        encoder
            .add_text_chunk((*keyword).to_owned(), text.clone())
            .map_err(failed)?;
    }
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(data).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(out)
}

fn failed(e: ::png::EncodingError) -> WriteError {
    WriteError::Encoder(e.to_string())
}

/// The encoder with the settings of all pictures.
fn fast_encoder<W: Write>(out: W, width: u32, height: u32) -> ::png::Encoder<'static, W> {
    let mut encoder = ::png::Encoder::new(out, width, height);
    encoder.set_compression(::png::Compression::Fast);
    encoder.set_filter(::png::Filter::Paeth);
    encoder
}

/// Frames that follow each other in one animated PNG, written as they come; viewers that do not know animations show the first.
pub struct Animation<W: Write> {
    writer: ::png::Writer<W>,
    size: [u32; 2],
}

impl<W: Write> std::fmt::Debug for Animation<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Animation({:?})", self.size)
    }
}

impl<W: Write> Animation<W> {
    /// Begins an animation of `frames` frames that is repeated without end, each shown for 1/`rate` second.
    ///
    /// # Errors
    /// [`WriteError`] without frames, or when `out` fails.
    pub fn begin(
        out: W,
        [width, height]: [u32; 2],
        frames: u32,
        rate: u16,
    ) -> Result<Self, WriteError> {
        if width == 0 || height == 0 {
            return Err(WriteError::Size { width, height });
        }
        let mut encoder = fast_encoder(out, width, height);
        encoder.set_color(::png::ColorType::Rgba);
        encoder.set_depth(::png::BitDepth::Eight);
        encoder.set_animated(frames, 0).map_err(failed)?;
        encoder.set_frame_delay(1, rate).map_err(failed)?;
        // Frames replace what was there, transparent pixels too.
        encoder
            .set_blend_op(::png::BlendOp::Source)
            .map_err(failed)?;
        let writer = encoder.write_header().map_err(failed)?;
        Ok(Self {
            writer,
            size: [width, height],
        })
    }

    /// The next frame.
    ///
    /// # Errors
    /// [`WriteError`] for a picture of another size, for more frames than announced, and when the output fails.
    pub fn add(&mut self, image: &Image) -> Result<(), WriteError> {
        let (width, height) = (image.width, image.height);
        if [width, height] != self.size {
            return Err(WriteError::Size { width, height });
        }
        self.writer.write_image_data(&image.data).map_err(failed)
    }

    /// Ends the animation.
    ///
    /// # Errors
    /// [`WriteError`] for fewer frames than announced, and when the output fails.
    pub fn finish(self) -> Result<(), WriteError> {
        self.writer.finish().map_err(failed)
    }
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
    PngEncoder::new_with_quality(&mut out, CompressionType::Fast, FilterType::Paeth)
        .write_image(data, width, height, color)
        .map_err(|e| WriteError::Encoder(e.to_string()))?;
    Ok(out)
}

/// Opens a PNG, unless it is damaged or needs more than 2 GiB.
///
/// `pixel_bytes`: what a pixel takes when it is decoded.
fn open(bytes: &[u8], pixel_bytes: u64) -> Result<PngDecoder<Cursor<&[u8]>>, ReadError> {
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(MAX_DECODED);
    let decoder = PngDecoder::with_limits(Cursor::new(bytes), limits).map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    let decoded = (u64::from(width) * u64::from(height)).saturating_mul(pixel_bytes);
    if decoded > MAX_DECODED || decoder.total_bytes() > MAX_DECODED {
        return Err(ReadError(format!("{width}x{height} pixels are too many")));
    }
    Ok(decoder)
}

fn damaged(e: image::ImageError) -> ReadError {
    ReadError(e.to_string())
}

/// Width and height of a PNG, from its head alone.
///
/// # Errors
/// [`ReadError`] when the bytes are no PNG.
pub fn size(bytes: &[u8]) -> Result<[u32; 2], ReadError> {
    let (width, height) = open(bytes, 4)?.dimensions();
    Ok([width, height])
}

/// Reads a PNG of any colour type as 8-bit RGBA.
///
/// # Errors
/// [`ReadError`] when the bytes are no PNG, are damaged, or need more than 2 GiB.
pub fn decode(bytes: &[u8]) -> Result<Image, ReadError> {
    let decoder = open(bytes, 4)?;
    let (width, height) = decoder.dimensions();
    let picture = DynamicImage::from_decoder(decoder).map_err(damaged)?;
    Ok(Image {
        width,
        height,
        data: picture.into_rgba8().into_raw(),
    })
}

/// Reads a PNG of any colour type as RGBA, with 16 bits where the file has them. Of an animated PNG, its still picture.
///
/// # Errors
/// As [`decode`].
pub fn decode_deep(bytes: &[u8]) -> Result<DeepImage, ReadError> {
    let decoder = open(bytes, 8)?;
    let (width, height) = decoder.dimensions();
    let picture = DynamicImage::from_decoder(decoder).map_err(damaged)?;
    let deep = picture.color().bytes_per_pixel() / picture.color().channel_count() > 1;
    let (bits, data) = match deep {
        true => (16, picture.into_rgba16().into_raw()),
        false => {
            let bytes = picture.into_rgba8().into_raw();
            (8, bytes.into_iter().map(u16::from).collect())
        }
    };
    Ok(DeepImage {
        width,
        height,
        bits,
        data,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture() -> Image {
        let mut image = Image::new(13, 7);
        for (i, b) in image.data.iter_mut().enumerate() {
            *b = (i * i % 251) as u8;
        }
        image
    }

    #[test]
    fn pictures_come_back_equal() {
        let image = picture();
        let bytes = encode(&image).expect("encodes");
        assert_eq!(bytes, encode(&image).expect("encodes"), "same bytes twice");
        assert_eq!(decode(&bytes).expect("decodes"), image);
        let back = decode(&encode_rgb(&image).expect("encodes")).expect("decodes");
        assert!(back.is_opaque());
        for (p, q) in image.data.chunks(4).zip(back.data.chunks(4)) {
            assert_eq!(p[..3], q[..3]);
        }
    }

    #[test]
    fn sixteen_bits_are_kept() {
        let values: Vec<u16> = (0..15 * 4 * 3).map(|i| (i * 911) as u16).collect();
        let gray = encode_gray16(15, 12, &values).expect("encodes");
        let back = image::load_from_memory(&gray).expect("decodes");
        assert_eq!(back.as_luma16().expect("16-bit grey").as_raw(), &values);
        let rgb = encode_rgb16(15, 4, &values).expect("encodes");
        let back = image::load_from_memory(&rgb).expect("decodes");
        assert_eq!(back.as_rgb16().expect("16-bit RGB").as_raw(), &values);
        let deep = decode_deep(&gray).expect("decodes");
        assert_eq!((deep.width, deep.height, deep.bits), (15, 12, 16));
        for (p, &v) in deep.data.chunks(4).zip(&values) {
            assert_eq!(p, [v, v, v, 65535]);
        }
        let image = picture();
        let shallow = decode_deep(&encode(&image).expect("encodes")).expect("decodes");
        assert_eq!(shallow, DeepImage::from(&image));
        assert_eq!(size(&gray).expect("a PNG"), [15, 12]);
    }

    #[test]
    fn wrong_sizes_are_refused() {
        assert!(matches!(
            encode(&Image::new(0, 5)),
            Err(WriteError::Size { .. })
        ));
        let mut short = picture();
        short.data.pop();
        assert!(matches!(
            encode(&short),
            Err(WriteError::WrongLength {
                got: 363,
                wanted: 364
            })
        ));
        assert!(encode_rgb(&short).is_err());
        assert!(encode_gray16(2, 2, &[0; 3]).is_err());
    }

    #[test]
    fn damaged_files_are_errors() {
        let bytes = encode(&picture()).expect("encodes");
        for n in 0..bytes.len() - 12 {
            assert!(decode(&bytes[..n]).is_err(), "cut at {n}");
        }
        assert!(decode(b"no picture").is_err());
    }
}
