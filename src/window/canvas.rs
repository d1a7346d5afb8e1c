//! Pictures to window pixels: 32-bit words of red, green and blue, at the size of the window whatever the size of the picture.

use crate::film::Image;
use rayon::prelude::*;

/// The pixels of a window.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Canvas {
    /// Pixels across and down.
    pub(super) size: [u32; 2],
    /// Rows from the top; red in bits 16 to 23, green 8 to 15, blue 0 to 7.
    pub(super) pixels: Vec<u32>,
}

/// The word of a colour.
#[must_use]
pub(super) fn word(color: [u8; 3]) -> u32 {
    let [r, g, b] = color.map(u32::from);
    r << 16 | g << 8 | b
}

impl Canvas {
    /// One colour all over.
    pub(super) fn fill(&mut self, size: [u32; 2], color: u32) {
        self.size = size;
        self.pixels.clear();
        self.pixels.resize(count(size), color);
    }

    /// The same pixels as another.
    pub(super) fn copy(&mut self, other: &Self) {
        self.size = other.size;
        self.pixels.clear();
        self.pixels.extend_from_slice(&other.pixels);
    }

    /// The pixels of another size, nearest to nearest: for the moment until there is a picture of the size.
    pub(super) fn stretch(&mut self, other: &Self, size: [u32; 2]) {
        self.fill(size, 0);
        if other.pixels.is_empty() || self.pixels.is_empty() {
            return;
        }
        let [width, height] = size.map(|s| s as usize);
        let [from_width, from_height] = other.size.map(|s| s as usize);
        for (y, row) in self.pixels.chunks_exact_mut(width).enumerate() {
            let from = &other.pixels[y * from_height / height * from_width..][..from_width];
            for (x, to) in row.iter_mut().enumerate() {
                *to = from[x * from_width / width];
            }
        }
    }

    /// An opaque picture at the size of the window: as it is where it has that size, else enlarged smoothly. Runs on rayon's current pool.
    pub(super) fn fit(&mut self, image: &Image, size: [u32; 2]) {
        self.size = size;
        self.pixels.resize(count(size), 0);
        if self.pixels.is_empty() || image.data.is_empty() {
            return;
        }
        if [image.width, image.height] == size {
            const CHUNK: usize = 1 << 14;
            self.pixels
                .par_chunks_mut(CHUNK)
                .zip(image.data.par_chunks(CHUNK * 4))
                .for_each(|(to, from)| {
                    for (t, p) in to.iter_mut().zip(from.chunks_exact(4)) {
                        *t = word([p[0], p[1], p[2]]);
                    }
                });
        } else {
            self.enlarge(image);
        }
    }

    fn enlarge(&mut self, image: &Image) {
        let [width, height] = self.size;
        let columns: Vec<(usize, usize, u32)> = steps(image.width, width).collect();
        let rows: Vec<(usize, usize, u32)> = steps(image.height, height).collect();
        let line = image.width as usize * 4;
        self.pixels
            .par_chunks_mut(width as usize)
            .zip(rows.par_iter())
            .for_each_init(
                || vec![0_u8; line],
                |between, (out, &(y0, y1, part))| {
                    // Down first, over the fewer pixels of the picture.
                    let [above, below] = [y0, y1].map(|y| &image.data[y * line..][..line]);
                    for ((b, &p), &q) in between.iter_mut().zip(above).zip(below) {
                        *b = mixed(p, q, part);
                    }
                    for (to, &(x0, x1, part)) in out.iter_mut().zip(&columns) {
                        let [p, q] = [x0, x1].map(|x| &between[x * 4..x * 4 + 3]);
                        *to = word([0, 1, 2].map(|k| mixed(p[k], q[k], part)));
                    }
                },
            );
    }

    /// Lays premultiplied RGBA bytes, `width` pixels a row, over the canvas with their upper left corner at a pixel.
    pub(super) fn lay_over(&mut self, rgba: &[u8], width: u32, at: [i64; 2]) {
        let line = width as usize * 4;
        if line == 0 {
            return;
        }
        let [across, down] = self.size.map(i64::from);
        for (j, row) in rgba.chunks_exact(line).enumerate() {
            let y = at[1] + j as i64;
            if !(0..down).contains(&y) {
                continue;
            }
            let start = (y * across) as usize;
            let target = &mut self.pixels[start..start + across as usize];
            for (i, p) in row.chunks_exact(4).enumerate() {
                let x = at[0] + i as i64;
                if p[3] == 0 || !(0..across).contains(&x) {
                    continue;
                }
                let to = &mut target[x as usize];
                let rest = 255 - u32::from(p[3]);
                let channel = |k: usize, shift: u32| {
                    let under = *to >> shift & 255;
                    (u32::from(p[k]) + (under * rest + 127) / 255).min(255) << shift
                };
                *to = channel(0, 16) | channel(1, 8) | channel(2, 0);
            }
        }
    }
}

fn count(size: [u32; 2]) -> usize {
    size[0] as usize * size[1] as usize
}

/// For each of `to` pixels the two of `from` that it lies between, and the part of the second in 256ths.
fn steps(from: u32, to: u32) -> impl Iterator<Item = (usize, usize, u32)> {
    let last = u64::from(from) - 1;
    (0..u64::from(to)).map(move |x| {
        // Middle to middle, in 256ths of a pixel.
        let at = ((2 * x + 1) * u64::from(from) * 128 / u64::from(to)).saturating_sub(128);
        let low = (at >> 8).min(last);
        let part = if low == last { 0 } else { (at & 255) as u32 };
        (low as usize, (low + 1).min(last) as usize, part)
    })
}

#[inline(always)]
fn mixed(p: u8, q: u8, part: u32) -> u8 {
    ((u32::from(p) * (256 - part) + u32::from(q) * part + 128) >> 8) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(width: u32, height: u32) -> Image {
        let mut image = Image::new(width, height);
        for (k, p) in image.data.chunks_exact_mut(4).enumerate() {
            let (x, y) = (k as u32 % width, k as u32 / width);
            p.copy_from_slice(&[
                (x * 255 / (width - 1).max(1)) as u8,
                (y * 255 / (height - 1).max(1)) as u8,
                7,
                255,
            ]);
        }
        image
    }

    #[test]
    fn the_same_size_is_the_same_pixels() {
        let image = ramp(37, 11);
        let mut canvas = Canvas::default();
        canvas.fit(&image, [37, 11]);
        for y in 0..11 {
            for x in 0..37 {
                let [r, g, b, _] = image.pixel(x, y);
                assert_eq!(canvas.pixels[(y * 37 + x) as usize], word([r, g, b]));
            }
        }
    }

    #[test]
    fn enlarged_ramps_stay_ramps() {
        for (small, size) in [([8, 5], [16, 10]), ([9, 7], [25, 20]), ([1, 1], [3, 2])] {
            let mut canvas = Canvas::default();
            canvas.fit(&ramp(small[0], small[1]), size);
            let at = |x: u32, y: u32| canvas.pixels[(y * size[0] + x) as usize];
            // No step is larger than the ramp is steep, so nothing is taken from the nearest pixel alone.
            let steepest = 255.0 / (size[0] as f32 - size[0] as f32 / small[0] as f32).max(1.0);
            for y in 0..size[1] {
                for x in 1..size[0] {
                    let [left, right] = [x - 1, x].map(|x| at(x, y) >> 16);
                    assert!(right >= left);
                    assert!(
                        (right - left) as f32 <= steepest + 1.5,
                        "at {x}: {left} {right}"
                    );
                }
            }
            // The ends are those of the picture.
            assert_eq!(at(0, 0), word([0, 0, 7]));
            let corner = at(size[0] - 1, size[1] - 1);
            let end = if small[0] > 1 { 255 } else { 0 };
            assert_eq!(corner, word([end, end, 7]));
        }
    }

    #[test]
    fn panels_are_cut_at_the_border() {
        let mut canvas = Canvas::default();
        canvas.fill([4, 3], word([10, 20, 30]));
        let half = [100, 0, 0, 128].repeat(6 * 6);
        canvas.lay_over(&half, 6, [2, -1]);
        assert_eq!(canvas.pixels[0], word([10, 20, 30]));
        assert_eq!(canvas.pixels[2], word([105, 10, 15]));
        assert_eq!(canvas.pixels[11], word([105, 10, 15]));
    }

    #[test]
    fn stretching_covers_the_window() {
        let mut small = Canvas::default();
        small.fill([2, 1], 0);
        small.pixels[1] = 9;
        let mut canvas = Canvas::default();
        canvas.stretch(&small, [4, 2]);
        assert_eq!(canvas.pixels, [0, 0, 9, 9, 0, 0, 9, 9]);
        canvas.stretch(&Canvas::default(), [2, 2]);
        assert_eq!(canvas.pixels, [0; 4]);
    }
}
