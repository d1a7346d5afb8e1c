//! Opaque surfaces under light without textures, in lanes: from the ids of a block's fragments to colours, or to bytes where a pixel has one
//! sample.

use super::Frame;
use super::attributes::Attributes;
use super::pixels::Pixels;
use super::spot;
use super::visible::Fragment;
use crate::raster::{CornerLanes, PairedBlock, SampleLanes, sample_positions};
use crate::records::{Grid3, SampleId};
use crate::shade::has_direction;
use crate::simd::{LANES, bits, flag};

/// A block whose fragments are lit in lanes.
pub(super) struct LitBlock<'a> {
    pub(super) points: &'a Grid3,
    pub(super) paired: &'a PairedBlock,
    pub(super) attributes: &'a Attributes,
    pub(super) origin: [u32; 2],
    pub(super) albedo: [f32; 3],
}

/// Groups of lanes that go through each step together. A step's result is long in coming, and the next group's step does not wait for
/// it; one group through all steps would leave the processor with nothing else to do.
pub(super) const GROUPS: usize = 8;

/// Sixteen fragments between steps, aligned for vectors.
#[derive(Clone, Copy, Default)]
#[repr(align(64))]
pub(super) struct LitGroup {
    ids: [u32; LANES],
    x: [i32; LANES],
    y: [i32; LANES],
    /// Places in the tile's pixels.
    pixels: [u32; LANES],
    corners: CornerLanes,
    side: [f32; LANES],
    normals: [[f32; LANES]; 3],
    /// Colour of the surface, then its light.
    colors: [[f32; LANES]; 3],
    /// Pixels of that light alone.
    codes: [u32; LANES],
}

/// Lights fragments of a block and puts the light where their pixels are kept.
#[inline(always)]
pub(super) fn lit_fragments(
    frame: &Frame<'_>,
    block: &LitBlock<'_>,
    fragments: &[Fragment],
    groups: &mut [LitGroup; GROUPS],
    pixels: &mut Pixels,
) {
    for chunk in fragments.chunks(GROUPS * LANES) {
        let groups = &mut groups[..chunk.len().div_ceil(LANES)];
        let (whole, rest) = chunk.as_chunks::<LANES>();
        // The last group is filled up with its last fragment.
        let mut last = [rest.last().copied().unwrap_or_default(); LANES];
        last[..rest.len()].copy_from_slice(rest);
        let filled = (!rest.is_empty()).then_some(&last);
        for (lanes, group) in whole.iter().chain(filled).zip(&mut *groups) {
            group.place(frame, block, lanes, pixels.width);
        }
        for group in &mut *groups {
            group.corners.fetch(block.paired, &group.ids);
        }
        for group in &mut *groups {
            group.find_surface(frame, block);
        }
        for g in &mut *groups {
            let light = (frame.shader).light_lanes(&g.normals, &g.side, &g.x, &g.y, &g.colors);
            g.colors = light;
        }
        for group in &mut *groups {
            group.codes = frame.film.opaque_lanes(&group.colors);
        }
        for (fragments, group) in chunk.chunks(LANES).zip(&*groups) {
            group.keep(frame, fragments, pixels);
        }
    }
}

impl LitGroup {
    /// Where fragments are on the screen.
    #[inline(always)]
    fn place(
        &mut self,
        frame: &Frame<'_>,
        block: &LitBlock<'_>,
        lanes: &[Fragment; LANES],
        width: usize,
    ) {
        let samples = frame.size.samples;
        let positions = sample_positions(samples);
        for l in 0..LANES {
            let f = lanes[l];
            self.ids[l] = f.id();
            self.pixels[l] = f.y() * width as u32 + f.x();
            self.x[l] = (block.origin[0] + f.x()) as i32 * 256;
            self.y[l] = (block.origin[1] + f.y()) as i32 * 256;
        }
        if samples == 1 {
            for l in 0..LANES {
                self.x[l] += positions[0][0];
                self.y[l] += positions[0][1];
            }
        } else {
            for l in 0..LANES {
                let [ox, oy] = positions[lanes[l].sample() as usize];
                self.x[l] += ox;
                self.y[l] += oy;
            }
        }
    }

    /// Normals, sides and colours of the surface at the fragments.
    #[inline(always)]
    fn find_surface(&mut self, frame: &Frame<'_>, block: &LitBlock<'_>) {
        let (x, y) = (&self.x, &self.y);
        let at = SampleLanes::new(block.paired, &self.corners, &self.ids, x, y);
        let mut bad = [0; LANES];
        for l in 0..LANES {
            let n = [at.normals[0][l], at.normals[1][l], at.normals[2][l]];
            bad[l] = flag(!has_direction(n));
        }
        self.normals = at.normals;
        self.side = at.side;
        self.colors = albedo_lanes(block, &at);
        let bad = bits(&bad);
        if bad != 0 {
            self.mend_normals(frame, block, bad);
        }
    }

    /// Gives samples whose normal has no direction, the lanes in `bad`, that of their micro-triangle, or one to the eye.
    #[cold]
    fn mend_normals(&mut self, frame: &Frame<'_>, block: &LitBlock<'_>, mut bad: u32) {
        while bad != 0 {
            let l = bad.trailing_zeros() as usize & (LANES - 1);
            bad &= bad - 1;
            let mut n = spot::geometric(block.points, SampleId(self.ids[l]));
            if !has_direction(n) {
                let to_eye = frame.shader.to_eye(self.x[l], self.y[l]);
                n = to_eye.map(|c| c * self.side[l].signum());
            }
            for (lanes, n) in self.normals.iter_mut().zip(n) {
                lanes[l] = n;
            }
        }
    }

    /// Puts the light where its pixels are kept.
    #[inline(always)]
    fn keep(&self, frame: &Frame<'_>, fragments: &[Fragment], pixels: &mut Pixels) {
        let samples = frame.size.samples;
        if samples == 1 {
            for l in 0..fragments.len() {
                pixels.bytes[self.pixels[l] as usize] = self.codes[l].to_le_bytes();
            }
            return;
        }
        for (l, f) in fragments.iter().enumerate() {
            let k = self.pixels[l] as usize;
            if f.count() == samples {
                // Times a power of two and divided by it: the same.
                pixels.bytes[k] = self.codes[l].to_le_bytes();
                continue;
            }
            let n = f.count() as f32;
            let sum = &mut pixels.sums[k];
            for c in 0..3 {
                sum[c] += crate::math::saturate(self.colors[c][l]) * n;
            }
            sum[3] += n;
        }
    }
}

/// Colours of the surface at the samples, linear.
#[inline(always)]
fn albedo_lanes(block: &LitBlock<'_>, at: &SampleLanes) -> [[f32; LANES]; 3] {
    let mut albedo = block.albedo.map(|c| [c; LANES]);
    if block.attributes.has_colors {
        let colors = at.interpolate(&block.attributes.colors);
        for (a, c) in albedo.iter_mut().zip(colors) {
            for l in 0..LANES {
                a[l] *= crate::math::positive(c[l]);
            }
        }
    }
    albedo
}
