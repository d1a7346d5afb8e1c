//! Textures: decoding, MIP levels, filtered look-up.
//!
//! A texture keeps what its file holds: 8-bit codes (4 bytes per texel) or 16-bit numbers (8 bytes). Colours of 8 bits are
//! decoded by a table at every look-up; the table stays in the first-level cache, and a large texture at a third of the bytes
//! of `f32` does so more often. MIP levels average light, not codes: each texel of a level covers its exact share of the level
//! below, in integer arithmetic, so that sides of any length neither shift nor darken.
//!
//! Coordinates: `u` to the right, `v` up, (0, 0) the lower left corner of the picture (OBJ's convention); both repeat.
//! Williams, *Pyramidal parametrics*, 1983.

mod levels;
mod load;

use crate::math::{log2_rough, positive};
use levels::Level;
pub use load::LoadError;

/// Longest side of a texture in texels.
pub const MAX_SIDE: u32 = 65_535;
/// Most bytes of one texture with its MIP levels, and most bytes its decoder may allocate.
pub const MAX_BYTES: u64 = 512 << 20;

/// What the numbers of a picture mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Meaning {
    /// Colours: red, green and blue are sRGB codes. Alpha never is.
    #[default]
    Color,
    /// Data (opacity, normals, displacement): all numbers are used as they stand.
    Data,
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

#[cfg(test)]
mod tests {
    use super::*;

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
