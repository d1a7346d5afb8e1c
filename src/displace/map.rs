//! Heights from a picture.

use crate::math;
use crate::records::{BLOCK_STRIDE, Grid3};
use crate::texture::Texture;
use std::hint::black_box;
use std::ops::Range;

/// A picture of heights: one number per texel, blended from the four nearest texels, without smaller levels: a displaced point must not
/// depend on who looks. Coordinates as [`Texture`]'s: `u` to the right, `v` up, (0, 0) the lower left corner; both repeat.
#[derive(Clone, Debug)]
pub struct HeightMap {
    width: u32,
    height: u32,
    texels: Vec<f32>,
    /// Lowest and highest texels of squares of `2^k` texels, for k from 3 on, each with a texel more all around for blending.
    ranges: Vec<Ranges>,
}

#[derive(Clone, Debug)]
struct Ranges {
    width: u32,
    height: u32,
    of: Vec<[f32; 2]>,
}

/// Binary logarithm of the smallest squares that have a range of their own.
const FINEST: u32 = 3;

/// Why texels are no map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// No texels, or not `width * height` of them.
    #[error("{got} heights given for {width}x{height}")]
    Count {
        /// Texels across.
        width: u32,
        /// Texels down.
        height: u32,
        /// Texels given.
        got: usize,
    },
    /// A height that is not finite.
    #[error("height {index} is not finite")]
    NotFinite {
        /// Which one.
        index: usize,
    },
}

/// A height with its derivatives by u and v.
pub(crate) type MapSlope = [f32; 3];

impl HeightMap {
    /// Longest side in texels.
    pub const MAX_SIDE: u32 = crate::texture::MAX_SIDE;

    /// A map from heights, rows from the top.
    ///
    /// # Errors
    /// [`MapError`].
    pub fn new(width: u32, height: u32, texels: Vec<f32>) -> Result<Self, MapError> {
        let side = |n: u32| (1..=Self::MAX_SIDE).contains(&n);
        if !side(width)
            || !side(height)
            || texels.len() as u64 != u64::from(width) * u64::from(height)
        {
            return Err(MapError::Count {
                width,
                height,
                got: texels.len(),
            });
        }
        if let Some(index) = texels.iter().position(|h| !h.is_finite()) {
            return Err(MapError::NotFinite { index });
        }
        Ok(Self::of_texels(width, height, texels))
    }

    /// The red channel of a picture, from 0 to 1.
    #[must_use]
    pub fn of_texture(texture: &Texture) -> Self {
        let [width, height] = texture.size();
        let all = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
        let texels = all.map(|[x, y]| texture.texel(0, x, y)[0]).collect();
        Self::of_texels(width, height, texels)
    }

    fn of_texels(width: u32, height: u32, texels: Vec<f32>) -> Self {
        Self {
            width,
            height,
            ranges: pyramid([width, height], &texels),
            texels,
        }
    }

    /// Bytes that a map of this size takes.
    #[must_use]
    pub fn bytes(width: u32, height: u32) -> u64 {
        // Ranges of squares of 8 texels are an eighth of the texels, and all larger ones a third of that.
        let texels = u64::from(width) * u64::from(height);
        texels * 4 + texels / 64 * 8 * 4 / 3 + 64 * (u64::from(width) + u64::from(height))
    }

    /// Texels across and down.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// The heights, rows from the top.
    #[cfg(feature = "gpu")]
    pub(crate) fn texels(&self) -> &[f32] {
        &self.texels
    }

    /// The height at a point. A coordinate that is not finite counts as 0.
    #[must_use]
    #[inline]
    pub fn at(&self, u: f32, v: f32) -> f32 {
        let (x0, x1, tx) = neighbours(u, self.width);
        let (y0, y1, ty) = neighbours(-v, self.height);
        let row = |y: usize| {
            let row = &self.texels[y * self.width as usize..][..self.width as usize];
            row[x0] + (row[x1] - row[x0]) * tx
        };
        let (a, b) = (row(y0), row(y1));
        a + (b - a) * ty
    }

    /// Heights, and slopes if wanted, at the first `heights.len()` texture coordinates.
    #[inline(always)]
    pub(super) fn all(&self, uvs: &Grid3, heights: &mut [f32], mut slopes: Option<&mut Grid3>) {
        for first in (0..heights.len()).step_by(BLOCK_STRIDE) {
            let part = first..(first + BLOCK_STRIDE).min(heights.len());
            let (u, v) = (&uvs.x[part.clone()], &uvs.y[part.clone()]);
            let heights = &mut heights[part.clone()];
            match slopes.as_deref_mut() {
                Some(s) => self.slope_line(u, v, [heights, &mut s.x[part.clone()], &mut s.y[part]]),
                None => self.line(u, v, heights),
            }
        }
    }

    /// Heights along a line of points, by the sums of [`HeightMap::at`].
    #[inline(always)]
    fn line(&self, u: &[f32], v: &[f32], out: &mut [f32]) {
        let (mut across, mut down) = (Taps::NONE, Taps::NONE);
        across.find(u, [1.0, 0.0], self.width);
        down.find(v, [-1.0, 0.0], self.height);
        self.blend(&across, &down, out);
    }

    /// The same with slopes, by those of [`HeightMap::slope`].
    #[inline(always)]
    fn slope_line(&self, u: &[f32], v: &[f32], out: [&mut [f32]; 3]) {
        let (w, h) = (self.width as f32, self.height as f32);
        let (du, dv) = (0.5 / w, 0.5 / h);
        let [height, by_u, by_v] = out;
        let n = height.len();
        let (by_u, by_v) = (&mut by_u[..n], &mut by_v[..n]);
        let mut other = [0.0; BLOCK_STRIDE];
        let other = &mut other[..n];
        let (mut across, mut down, mut taps) = (Taps::NONE, Taps::NONE, Taps::NONE);
        across.find(u, [1.0, 0.0], self.width);
        down.find(v, [-1.0, 0.0], self.height);
        self.blend(&across, &down, height);
        taps.find(u, [1.0, du], self.width);
        self.blend(&taps, &down, by_u);
        taps.find(u, [1.0, -du], self.width);
        self.blend(&taps, &down, other);
        for i in 0..n {
            by_u[i] = (by_u[i] - other[i]) * w;
        }
        taps.find(v, [-1.0, dv], self.height);
        self.blend(&across, &taps, by_v);
        taps.find(v, [-1.0, -dv], self.height);
        self.blend(&across, &taps, other);
        for i in 0..n {
            by_v[i] = (by_v[i] - other[i]) * h;
        }
    }

    #[inline(always)]
    fn blend(&self, across: &Taps, down: &Taps, out: &mut [f32]) {
        let n = out.len().min(BLOCK_STRIDE);
        let out = &mut out[..n];
        let mut places = [[0_u32; BLOCK_STRIDE]; 2];
        let [above, below] = &mut places;
        for i in 0..n {
            let x = across.first[i] as u32;
            above[i] = (down.first[i] as u32)
                .wrapping_mul(self.width)
                .wrapping_add(x);
            below[i] = (down.second[i] as u32)
                .wrapping_mul(self.width)
                .wrapping_add(x);
        }
        let mut found = [[0.0; BLOCK_STRIDE]; 4];
        let [a, b, c, d] = &mut found;
        for i in 0..n {
            // Keeps this loop scalar: gathers under masks take several times as long.
            black_box(());
            [a[i], b[i]] = self.pair(above[i]);
            [c[i], d[i]] = self.pair(below[i]);
            // Behind the last column comes the first.
            if across.second[i] == 0 {
                let back = across.first[i] as u32;
                b[i] = self.pair(above[i] - back)[0];
                d[i] = self.pair(below[i] - back)[0];
            }
        }
        let (a, b, c, d) = (&a[..n], &b[..n], &c[..n], &d[..n]);
        let (tx, ty) = (&across.share[..n], &down.share[..n]);
        for i in 0..n {
            let low = a[i] + (b[i] - a[i]) * tx[i];
            let high = c[i] + (d[i] - c[i]) * tx[i];
            out[i] = low + (high - low) * ty[i];
        }
    }

    /// A texel and the one that is stored after it, if there is one.
    #[inline(always)]
    fn pair(&self, at: u32) -> [f32; 2] {
        match self.texels.get(at as usize..at as usize + 2) {
            Some(&[a, b]) => [a, b],
            // The last of all is in the last column.
            _ => [self.texels.last().copied().unwrap_or_default(), 0.0],
        }
    }

    /// Height and derivatives by u and v. The height's own derivatives jump at texels; these are its differences over one texel, which are
    /// the derivatives of the map averaged over a texel: continuous, and right to second order where the map is smooth.
    #[inline]
    pub(crate) fn slope(&self, u: f32, v: f32) -> MapSlope {
        let (w, h) = (self.width as f32, self.height as f32);
        let (du, dv) = (0.5 / w, 0.5 / h);
        [
            self.at(u, v),
            (self.at(u + du, v) - self.at(u - du, v)) * w,
            (self.at(u, v + dv) - self.at(u, v - dv)) * h,
        ]
    }

    /// Derivatives by u and v as a pixel sees them that covers a square of side `footprint`.
    #[inline]
    pub(crate) fn slope_over(&self, u: f32, v: f32, footprint: f32) -> [f32; 2] {
        let step = |side: u32| (0.5 / side as f32).max(0.5 * footprint).min(0.25);
        let (du, dv) = (step(self.width), step(self.height));
        [
            (self.at(u + du, v) - self.at(u - du, v)) * (0.5 / du),
            (self.at(u, v + dv) - self.at(u, v - dv)) * (0.5 / dv),
        ]
    }

    /// Lowest and highest height.
    #[must_use]
    pub fn range(&self) -> [f32; 2] {
        // The last level of ranges is one square.
        self.ranges
            .last()
            .and_then(|r| r.of.first())
            .copied()
            .unwrap_or_default()
    }

    /// Lowest and highest height in a box of texture coordinates, from `low` to `high`.
    #[must_use]
    pub fn range_in(&self, low: [f32; 2], high: [f32; 2]) -> [f32; 2] {
        let sides = [self.width, self.height];
        let (mut from, mut to) = ([0_i64; 2], [0_i64; 2]);
        for k in 0..2 {
            let side = f64::from(sides[k]);
            // v points up, rows go down.
            let (a, b) = match k {
                0 => (low[0], high[0]),
                _ => (-high[1], -low[1]),
            };
            // Rounding may reach one texel further than the blend does.
            let (a, b) = (f64::from(a) * side - 1.5, f64::from(b) * side + 1.5);
            if !(b - a < side && a.abs() < 1e9 && b.abs() < 1e9) {
                (from[k], to[k]) = (0, i64::from(sides[k]) - 1);
            } else {
                (from[k], to[k]) = (a.floor() as i64, b.ceil() as i64);
            }
        }
        self.range_of([from[0]..to[0] + 1, from[1]..to[1] + 1])
    }

    /// Of a box of texels, which repeat.
    fn range_of(&self, [x, y]: [Range<i64>; 2]) -> [f32; 2] {
        let (w, h) = (i64::from(self.width), i64::from(self.height));
        let longest = (x.end - x.start).max(y.end - y.start);
        let mut out = [f32::INFINITY, f32::NEG_INFINITY];
        let mut add = |[lo, hi]: [f32; 2]| out = [out[0].min(lo), out[1].max(hi)];
        // So coarse that a few squares across hold the box.
        let level = (0..self.ranges.len()).find(|k| longest >> (FINEST as usize + k) < 8);
        if longest <= 16 {
            for j in y {
                for i in x.clone() {
                    let at = j.rem_euclid(h) * w + i.rem_euclid(w);
                    add([self.texels[at as usize]; 2]);
                }
            }
            return out;
        }
        let Some(level) = level else {
            return self.range();
        };
        let (ranges, step) = (&self.ranges[level], 1_i64 << (FINEST as usize + level));
        // The last square of a side may be cut short: steps are clipped to it.
        let squares = |r: Range<i64>, side: i64| {
            let mut out = Vec::new();
            let mut at = r.start;
            while at < r.end {
                let inside = at.rem_euclid(side);
                out.push((inside / step) as usize);
                at += (step - inside % step).min(side - inside);
            }
            out
        };
        let columns = squares(x, w);
        for j in squares(y, h) {
            for &i in &columns {
                add(ranges.of[j * ranges.width as usize + i]);
            }
        }
        out
    }
}

/// Ranges of squares of all sizes.
fn pyramid([width, height]: [u32; 2], texels: &[f32]) -> Vec<Ranges> {
    let mut out: Vec<Ranges> = Vec::new();
    let (w, h) = (width.div_ceil(1 << FINEST), height.div_ceil(1 << FINEST));
    let join = |a: [f32; 2], b: [f32; 2]| [a[0].min(b[0]), a[1].max(b[1])];
    let none = [f32::INFINITY, f32::NEG_INFINITY];
    let mut of = vec![none; w as usize * h as usize];
    for (y, row) in texels.chunks_exact(width as usize).enumerate() {
        for (x, &t) in row.iter().enumerate() {
            let at = (y >> FINEST) * w as usize + (x >> FINEST);
            of[at] = join(of[at], [t, t]);
        }
    }
    out.push(Ranges {
        width: w,
        height: h,
        of,
    });
    while let Some(last) = out.last().filter(|l| l.width > 1 || l.height > 1) {
        let (w, h) = (last.width.div_ceil(2), last.height.div_ceil(2));
        let mut of = vec![none; w as usize * h as usize];
        for y in 0..last.height {
            for x in 0..last.width {
                let at = (y / 2 * w + x / 2) as usize;
                of[at] = join(of[at], last.of[(y * last.width + x) as usize]);
            }
        }
        out.push(Ranges {
            width: w,
            height: h,
            of,
        });
    }
    out
}

/// The texels around a line of coordinates, one direction of them.
struct Taps {
    first: [i32; BLOCK_STRIDE],
    second: [i32; BLOCK_STRIDE],
    /// Share of the second.
    share: [f32; BLOCK_STRIDE],
}

impl Taps {
    const NONE: Self = Self {
        first: [0; BLOCK_STRIDE],
        second: [0; BLOCK_STRIDE],
        share: [0.0; BLOCK_STRIDE],
    };

    /// Those around `sign` times (coordinate + `step`).
    #[inline(always)]
    fn find(&mut self, x: &[f32], [sign, step]: [f32; 2], n: u32) {
        let count = x.len().min(BLOCK_STRIDE);
        let x = &x[..count];
        let (first, second) = (&mut self.first[..count], &mut self.second[..count]);
        let share = &mut self.share[..count];
        for i in 0..count {
            (first[i], second[i], share[i]) = texels_at(sign * (x[i] + step), n);
        }
    }
}

/// The two texels around a coordinate along a side of `n` texels, and the share of the second.
#[inline(always)]
fn neighbours(x: f32, n: u32) -> (usize, usize, f32) {
    let (a, b, t) = texels_at(x, n);
    (a as usize, b as usize, t)
}

#[inline(always)]
fn texels_at(x: f32, n: u32) -> (i32, i32, f32) {
    // Beyond 2^23 there is no fraction.
    let x = if x.abs() < 8_388_608.0 { x } else { 0.0 };
    let p = (x - math::floor(x) as f32) * n as f32 - 0.5;
    let below = math::floor(p);
    let n = n as i32;
    // The fraction may round to 1.
    let a = if below < 0 { n - 1 } else { below.min(n - 1) };
    let b = if a + 1 == n { 0 } else { a + 1 };
    let t = p - below as f32;
    (a, b, if t < 1.0 { t } else { 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn waves(w: u32, h: u32) -> HeightMap {
        let at = |x: u32, y: u32| {
            let (u, v) = (
                (x as f32 + 0.5) / w as f32,
                1.0 - (y as f32 + 0.5) / h as f32,
            );
            libm::sinf(std::f32::consts::TAU * u) * libm::cosf(std::f32::consts::TAU * v)
        };
        let texels = (0..h).flat_map(|y| (0..w).map(move |x| at(x, y))).collect();
        HeightMap::new(w, h, texels).unwrap()
    }

    #[test]
    fn texels_stand_where_textures_have_them() {
        let map = HeightMap::new(2, 2, vec![0.0, 1.0, 2.0, 3.0]).unwrap();
        assert_eq!(map.at(0.25, 0.75), 0.0);
        assert_eq!(map.at(0.75, 0.25), 3.0);
        assert_eq!(map.at(0.5, 0.75), 0.5);
        assert_eq!(map.at(1.25, -0.25), 0.0);
        for x in [f32::NAN, f32::INFINITY, 1e30, -1e-9, 1.0, -0.0] {
            assert!(map.at(x, x).is_finite() && map.slope(x, x)[1].is_finite());
        }
    }

    #[test]
    fn lines_have_the_bits_of_points() {
        let map = waves(37, 29);
        let at = |k: f32| -> Vec<f32> {
            let ends = [0.0, -0.0, 1.0, -1.0, f32::NAN, 1e30, -1e-9];
            let all = (0..33 - ends.len()).map(|i| (i as f32 * k).fract() * 3.0 - 1.0);
            ends.into_iter().chain(all).collect()
        };
        let (u, v) = (at(0.371), at(0.713));
        for simd in crate::simd::Level::available() {
            let mut heights = vec![0.0; u.len()];
            crate::dispatch!(simd, map.line(&u, &v, &mut heights));
            let [mut h, mut x, mut y] = [(); 3].map(|()| vec![0.0; u.len()]);
            crate::dispatch!(simd, map.slope_line(&u, &v, [&mut h, &mut x, &mut y]));
            for i in 0..u.len() {
                assert_eq!(heights[i].to_bits(), map.at(u[i], v[i]).to_bits());
                assert_eq!([h[i], x[i], y[i]], map.slope(u[i], v[i]));
            }
        }
    }

    #[test]
    fn slopes_are_those_of_the_wave() {
        let map = waves(256, 128);
        for i in 0..500 {
            let (u, v) = ((i as f32 * 0.371).fract(), (i as f32 * 0.713).fract());
            let [h, du, dv] = map.slope(u, v);
            let (a, b) = (std::f32::consts::TAU * u, std::f32::consts::TAU * v);
            assert!((h - libm::sinf(a) * libm::cosf(b)).abs() < 2e-3);
            assert!((du - std::f32::consts::TAU * libm::cosf(a) * libm::cosf(b)).abs() < 1e-2);
            assert!((dv + std::f32::consts::TAU * libm::sinf(a) * libm::sinf(b)).abs() < 1e-2);
        }
    }

    #[test]
    fn ranges_hold_every_height() {
        for (w, h) in [(1, 1), (5, 3), (37, 64), (300, 200)] {
            let map = waves(w, h);
            for i in 0..300 {
                let at = |k: f32| (i as f32 * k).fract() * 3.0 - 1.0;
                let (u, v, size) = (
                    at(0.371),
                    at(0.713),
                    (i as f32 * 0.17).fract().powi(4) * 1.5,
                );
                let [lo, hi] = map.range_in([u, v], [u + size, v + size]);
                for j in 0..40 {
                    let (s, t) = ((j as f32 * 0.31).fract(), (j as f32 * 0.77).fract());
                    let h = map.at(u + s * size, v + t * size);
                    assert!(lo <= h && h <= hi, "{w}x{h} {u} {v} {size}");
                }
            }
            let [lo, hi] = map.range_in([0.2, 0.2], [0.2, 0.2]);
            assert!(w < 200 || hi - lo < 0.3);
        }
    }

    #[test]
    fn wrong_texels_are_refused() {
        assert!(HeightMap::new(0, 1, vec![]).is_err());
        assert!(HeightMap::new(2, 2, vec![0.0; 3]).is_err());
        assert_eq!(
            HeightMap::new(1, 2, vec![0.0, f32::NAN]).unwrap_err(),
            MapError::NotFinite { index: 1 }
        );
    }
}
