//! Textures: decoding, MIP levels, filtered look-up.
//!
//! A texture keeps what its file holds: 8-bit codes (4 bytes per texel) or 16-bit numbers (8 bytes). Colours of 8 bits are
//! decoded by a table at every look-up; the table stays in the first-level cache, and a large texture at a third of the bytes
//! of `f32` does so more often. MIP levels average light, not codes: each texel of a level covers its exact share of the level
//! below, in integer arithmetic, so that sides of any length neither shift nor darken.
//!
//! Coordinates: `u` to the right, `v` up, (0, 0) the lower left corner of the picture (OBJ's convention); both repeat.
//! Williams, *Pyramidal parametrics*, 1983.

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use crate::film::srgb::Srgb;
use crate::math::{log2_rough, positive};

/// Longest side of a texture in texels.
pub const MAX_SIDE: u32 = 65_535;
/// Most bytes of one texture with its MIP levels, and most bytes its decoder may allocate.
pub const MAX_BYTES: u64 = 512 << 20;

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

/// What the numbers of a picture mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Meaning {
    /// Colours: red, green and blue are sRGB codes. Alpha never is.
    #[default]
    Color,
    /// Data (opacity, normals, displacement): all numbers are used as they stand.
    Data,
}

/// One MIP level.
#[derive(Clone, Debug)]
struct Level {
    width: u32,
    height: u32,
    /// Index of its first texel.
    start: usize,
}

#[derive(Clone, Debug)]
enum Texels {
    Byte(Vec<[u8; 4]>),
    Word(Vec<[u16; 4]>),
}

/// A decoded picture with its MIP levels.
#[derive(Clone, Debug)]
pub struct Texture {
    levels: Vec<Level>,
    texels: Texels,
    /// Values of the 8-bit codes of red, green and blue.
    values: Box<[f32; 256]>,
    has_alpha: bool,
    /// Half the binary logarithm of the number of texels: level of detail of a footprint of 1.
    lod_bias: f32,
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
        check_size(width, height, 4, MAX_BYTES)?;
        if texels.len() != width as usize * height as usize {
            return Err(LoadError::Damaged(format!(
                "{} texels given for {width}x{height}",
                texels.len()
            )));
        }
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
        check_size(width, height, 8, MAX_BYTES)?;
        if texels.len() != width as usize * height as usize {
            return Err(LoadError::Damaged(format!(
                "{} texels given for {width}x{height}",
                texels.len()
            )));
        }
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

    /// Texels across and down.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.levels[0].width, self.levels[0].height]
    }

    /// Number of MIP levels; the last has one texel.
    #[must_use]
    pub fn level_count(&self) -> usize {
        self.levels.len()
    }

    /// Whether red, green and blue are the same everywhere: heights rather than vectors.
    #[must_use]
    pub fn is_gray(&self) -> bool {
        let count = self.levels[0].width as usize * self.levels[0].height as usize;
        match &self.texels {
            Texels::Byte(t) => t[..count].iter().all(|t| t[0] == t[1] && t[1] == t[2]),
            Texels::Word(t) => t[..count].iter().all(|t| t[0] == t[1] && t[1] == t[2]),
        }
    }

    /// The file has an alpha channel.
    #[must_use]
    pub fn has_alpha(&self) -> bool {
        self.has_alpha
    }

    /// Bytes of all texels.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match &self.texels {
            Texels::Byte(t) => size_of_val(&t[..]),
            Texels::Word(t) => size_of_val(&t[..]),
        }
    }

    /// Level of detail for a pixel that covers a square of side `footprint` in texture coordinates. 0 is the picture itself;
    /// each step halves it.
    #[must_use]
    #[inline]
    pub fn lod(&self, footprint: f32) -> f32 {
        log2_rough(footprint) + self.lod_bias
    }

    /// The texture at a point, linear RGB with straight alpha, blended from the eight nearest texels of two levels (four below
    /// level 0). A coordinate that is not finite counts as 0.
    #[must_use]
    #[inline]
    pub fn sample(&self, u: f32, v: f32, lod: f32) -> [f32; 4] {
        let u = wrap(u);
        let v = 1.0 - wrap(v);
        let last = self.levels.len() - 1;
        let lod = positive(lod);
        let lod = if lod < last as f32 { lod } else { last as f32 };
        let level = lod as usize;
        let t = lod - level as f32;
        let a = self.bilinear(level, u, v);
        if t == 0.0 {
            return a;
        }
        mix(a, self.bilinear((level + 1).min(last), u, v), t)
    }

    /// The texture as opacity (`map_d`): its alpha channel, or red where it has none. Meant for [`Meaning::Data`].
    #[must_use]
    #[inline]
    pub fn opacity(&self, u: f32, v: f32, lod: f32) -> f32 {
        self.sample(u, v, lod)[if self.has_alpha { 3 } else { 0 }]
    }

    /// One texel of a level, linear.
    ///
    /// # Panics
    /// Outside the level.
    #[must_use]
    pub fn texel(&self, level: usize, x: u32, y: u32) -> [f32; 4] {
        let l = &self.levels[level];
        assert!(x < l.width && y < l.height, "texel outside");
        self.fetch(l.start + y as usize * l.width as usize + x as usize)
    }

    /// Texels across and down of a level.
    ///
    /// # Panics
    /// When there is no such level.
    #[must_use]
    pub fn level_size(&self, level: usize) -> [u32; 2] {
        [self.levels[level].width, self.levels[level].height]
    }

    /// The texture as words, for look-up elsewhere: a header of eight (levels, where their sizes are, where texels are, where the values of
    /// codes are, whether texels take two words, bits of the bias of levels of detail, whether there is an alpha channel), then width, height
    /// and first texel of every level, the values, and the texels. Places count from `base`.
    #[cfg(feature = "gpu")]
    pub(crate) fn words(&self, base: u32) -> Vec<u32> {
        let sizes = base + 8;
        let values = sizes + 3 * self.levels.len() as u32;
        let texels = values + 256;
        let wide = matches!(self.texels, Texels::Word(_));
        let levels = self.levels.len() as u32;
        let bias = self.lod_bias.to_bits();
        let alpha = u32::from(self.has_alpha);
        let mut out = vec![
            levels,
            sizes,
            texels,
            values,
            u32::from(wide),
            bias,
            alpha,
            0,
        ];
        out.extend((self.levels.iter()).flat_map(|l| [l.width, l.height, l.start as u32]));
        out.extend(self.values.iter().map(|v| v.to_bits()));
        match &self.texels {
            Texels::Byte(t) => out.extend(t.iter().map(|t| u32::from_le_bytes(*t))),
            Texels::Word(t) => {
                let pair = |a: u16, b: u16| u32::from(a) | u32::from(b) << 16;
                out.extend(t.iter().flat_map(|t| [pair(t[0], t[1]), pair(t[2], t[3])]));
            }
        }
        out
    }

    #[inline]
    fn fetch(&self, i: usize) -> [f32; 4] {
        match &self.texels {
            Texels::Byte(t) => byte_value(&self.values, t[i]),
            Texels::Word(t) => word_value(t[i]),
        }
    }

    /// `u` and `v` from 0 to 1, `v` down.
    #[inline]
    fn bilinear(&self, level: usize, u: f32, v: f32) -> [f32; 4] {
        let l = &self.levels[level];
        let (x0, x1, tx) = neighbours(u, l.width);
        let (y0, y1, ty) = neighbours(v, l.height);
        let row0 = l.start + y0 * l.width as usize;
        let row1 = l.start + y1 * l.width as usize;
        let at = [row0 + x0, row0 + x1, row1 + x0, row1 + x1];
        let [a, b, c, d] = match &self.texels {
            Texels::Byte(t) => at.map(|i| byte_value(&self.values, t[i])),
            Texels::Word(t) => at.map(|i| word_value(t[i])),
        };
        mix(mix(a, b, tx), mix(c, d, tx), ty)
    }
}

#[inline(always)]
fn byte_value(values: &[f32; 256], [r, g, b, a]: [u8; 4]) -> [f32; 4] {
    let value = |c: u8| values[usize::from(c)];
    [value(r), value(g), value(b), f32::from(a) * (1.0 / 255.0)]
}

#[inline(always)]
fn word_value([r, g, b, a]: [u16; 4]) -> [f32; 4] {
    let value = |c: u16| f32::from(c) * (1.0 / 65_535.0);
    [value(r), value(g), value(b), value(a)]
}

/// The fractional part, from 0 to below 1; 0 where there is none.
#[inline]
fn wrap(x: f32) -> f32 {
    // Not `floor`, which is a call where the processor's baseline lacks the instruction. Beyond 2^24 there is no fraction.
    if x.abs() < 16_777_216.0 {
        let f = x - (x as i32) as f32;
        let f = if f < 0.0 { f + 1.0 } else { f };
        // Just below 0 the sum rounds to 1.
        if f < 1.0 { f } else { 0.0 }
    } else {
        0.0
    }
}

/// The two texels around a coordinate from 0 to 1 along a side of `n` texels, and the share of the second.
#[inline]
fn neighbours(x: f32, n: u32) -> (usize, usize, f32) {
    let p = x * n as f32 - 0.5;
    // `p` is at least -0.5.
    let i = if p < 0.0 { -1 } else { p as i32 };
    let floor = i as f32;
    let n = n as i32;
    let a = if i < 0 {
        i + n
    } else if i >= n {
        i - n
    } else {
        i
    };
    let b = if a + 1 == n { 0 } else { a + 1 };
    (a as usize, b as usize, p - floor)
}

#[inline]
fn mix(a: [f32; 4], b: [f32; 4], t: f32) -> [f32; 4] {
    let at = |k: usize| a[k] + (b[k] - a[k]) * t;
    [at(0), at(1), at(2), at(3)]
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

/// Sizes of the levels, each half of the one before, rounded down, down to one texel.
fn level_sizes(width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    std::iter::successors(Some((width, height)), |&(w, h)| {
        (w > 1 || h > 1).then(|| ((w / 2).max(1), (h / 2).max(1)))
    })
}

/// Appends the smaller levels to `all`, which holds the texels of level 0. `widen` and `narrow` turn stored texels into 16-bit
/// linear numbers and back; a level is averaged from the 16-bit numbers of the one before, so stored rounding does not add up.
fn build_levels<T: Copy>(
    width: u32,
    height: u32,
    all: &mut Vec<T>,
    widen: impl Fn(T) -> [u16; 4],
    narrow: impl Fn([u16; 4]) -> T,
) -> Vec<Level> {
    let mut levels = Vec::new();
    let mut start = 0;
    let mut wide: Vec<[u16; 4]> = Vec::new();
    let mut previous = (width, height);
    for (w, h) in level_sizes(width, height) {
        levels.push(Level {
            width: w,
            height: h,
            start,
        });
        if levels.len() > 1 {
            wide = if levels.len() == 2 {
                halve(previous, (w, h), |i| widen(all[i]))
            } else {
                halve(previous, (w, h), |i| wide[i])
            };
            all.extend(wide.iter().map(|&t| narrow(t)));
        }
        start += w as usize * h as usize;
        previous = (w, h);
    }
    levels
}

/// One level from the one before. A side of `n` texels becomes one of `m`: in units of 1/m texel, new texel `i` covers
/// `[i n, (i + 1) n)` and old texel `j` covers `[j m, (j + 1) m)`; the overlaps are the weights, and they sum to `n`.
fn halve(from: (u32, u32), to: (u32, u32), texel: impl Fn(usize) -> [u16; 4]) -> Vec<[u16; 4]> {
    let columns = taps(from.0, to.0);
    let rows = taps(from.1, to.1);
    let total = u64::from(from.0) * u64::from(from.1);
    let mut out = Vec::with_capacity(to.0 as usize * to.1 as usize);
    for row in &rows {
        for column in &columns {
            let mut sum = [0_u64; 4];
            for &(y, wy) in row.iter().filter(|t| t.1 > 0) {
                for &(x, wx) in column.iter().filter(|t| t.1 > 0) {
                    let t = texel(y as usize * from.0 as usize + x as usize);
                    for (s, c) in sum.iter_mut().zip(t) {
                        *s += u64::from(c) * u64::from(wx) * u64::from(wy);
                    }
                }
            }
            out.push(sum.map(|s| ((s + total / 2) / total) as u16));
        }
    }
    out
}

/// Per new texel, the up to three old ones it covers and their weights (0 for none).
fn taps(n: u32, m: u32) -> Vec<[(u32, u32); 3]> {
    (0..m)
        .map(|i| {
            let (begin, end) = (i * n, (i + 1) * n);
            let first = begin / m;
            [0, 1, 2].map(|k| {
                let j = first + k;
                let overlap = end.min((j + 1) * m).saturating_sub(begin.max(j * m));
                (j.min(n - 1), overlap)
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn taps_share_every_texel_exactly() {
        for n in [1, 2, 3, 5, 8, 13, 255, 4095, 65_535] {
            let m = (n / 2).max(1);
            let mut covered = vec![0_u64; n as usize];
            for t in taps(n, m) {
                assert_eq!(t.iter().map(|t| t.1).sum::<u32>(), n);
                for (j, w) in t {
                    covered[j as usize] += u64::from(w);
                }
            }
            assert!(covered.iter().all(|&c| c == u64::from(m)), "{n}");
        }
    }

    #[test]
    fn levels_end_with_one_texel() {
        let sizes: Vec<_> = level_sizes(5, 2).collect();
        assert_eq!(sizes, [(5, 2), (2, 1), (1, 1)]);
        assert_eq!(level_sizes(1, 1).count(), 1);
        assert_eq!(level_sizes(MAX_SIDE, 1).count(), 16);
    }

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

    #[test]
    fn wrapping_keeps_the_range() {
        for x in [-1e-9, 0.0, 1.0, -7.25, 1e20, f32::NAN, f32::INFINITY] {
            let w = wrap(x);
            assert!((0.0..1.0).contains(&w), "{x} gave {w}");
            for n in [1, 2, 3, 100] {
                let (a, b, t) = neighbours(w, n);
                assert!(a < n as usize && b < n as usize && (0.0..1.0).contains(&t));
                let (a, b, _) = neighbours(1.0 - w, n);
                assert!(a < n as usize && b < n as usize);
            }
        }
        assert_eq!(wrap(-7.25), 0.75);
    }
}
