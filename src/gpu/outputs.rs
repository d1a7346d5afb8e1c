//! Outputs beside the picture: the device writes codes, those of a pixel one after the other, and planes are made of what comes down.

use super::records;
use crate::camera::View;
use crate::frame::{Aov, Plane, Wanted};
use crate::records::ScreenSize;
use crate::topology::NONE;

/// Words of a pixel that an output takes.
fn words_of(aov: Aov) -> u32 {
    aov.pixel_bytes().div_ceil(4) as u32
}

/// What is written beside a picture, and where.
#[derive(Clone, Debug, Default)]
pub(super) struct Outputs {
    wanted: Wanted,
}

impl Outputs {
    pub(super) fn new(wanted: Wanted) -> Self {
        Self { wanted }
    }

    pub(super) fn wants(&self, aov: Aov) -> bool {
        self.wanted.wants(aov)
    }

    /// Words of a pixel; none where only the picture is wanted.
    pub(super) fn words(&self) -> u32 {
        self.wanted.aovs.iter().copied().map(words_of).sum()
    }

    /// Bytes of all planes of so many pixels.
    pub(super) fn plane_bytes(&self, pixels: u64) -> u128 {
        self.wanted.bytes(pixels.into())
    }

    pub(super) fn record(&self) -> records::Outputs {
        let aovs = &self.wanted.aovs;
        let place = |aov: Aov| match aovs.iter().position(|&a| a == aov) {
            Some(k) => aovs[..k].iter().copied().map(words_of).sum(),
            None => NONE,
        };
        let four = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
        let [position_low, position_high] = self.wanted.position.map(four);
        let [[u0, v0, _], [u1, v1, _]] = self.wanted.uv;
        let mut order = [[0; 4]; 4];
        let places = order.as_flattened_mut().iter_mut();
        for (to, &sample) in places.zip(&self.wanted.nearest) {
            *to = sample;
        }
        records::Outputs {
            position_low,
            position_high,
            uv_range: [u0, v0, u1, v1],
            order,
            words: self.words(),
            depth: place(Aov::Depth),
            normal: place(Aov::Normal),
            position: place(Aov::Position),
            albedo: place(Aov::Albedo),
            uv: place(Aov::Uv),
            face: place(Aov::Face),
            level: place(Aov::Level),
            coverage: place(Aov::Coverage),
            ..records::Outputs::default()
        }
    }

    /// Planes of the pixels of `view`, from as many words of each: the bytes of every output, as what differs from those of a pixel that
    /// shows nothing.
    pub(super) fn planes(&self, view: &View, bytes: &[u8]) -> Vec<Plane> {
        if self.wanted.aovs.is_empty() {
            return Vec::new();
        }
        let ScreenSize { width, height, .. } = view.size;
        let wanted = Wanted {
            depth: [view.near, view.far],
            ..self.wanted.clone()
        };
        let mut planes = wanted.planes(width, height);
        let pixel_bytes = 4 * self.words() as usize;
        let mut first = 0;
        for plane in &mut planes {
            let size = plane.aov.pixel_bytes();
            let pixels = bytes.chunks_exact(pixel_bytes);
            for (to, from) in plane.data.chunks_exact_mut(size).zip(pixels) {
                for (to, from) in to.iter_mut().zip(&from[first..]) {
                    *to ^= from;
                }
            }
            first += 4 * words_of(plane.aov) as usize;
        }
        planes
    }
}
