//! From surface point to pixel: camera, textures, shading and film through the public API.

#[path = "picture/cameras.rs"]
mod cameras;
#[path = "picture/shading.rs"]
mod shading;
#[path = "picture/textures.rs"]
mod textures;

use earmark::camera::{Sphere, View};
use earmark::records::ScreenSize;
use earmark::texture::{Meaning, Texture};

const fn size(width: u32, height: u32) -> ScreenSize {
    ScreenSize {
        width,
        height,
        samples: 4,
    }
}

const UNIT: Sphere = Sphere {
    center: [0.0; 3],
    radius: 1.0,
};

/// A small generator of numbers from 0 to 1, the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
    fn within(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.next()
    }
    fn direction(&mut self) -> [f64; 3] {
        loop {
            let v = [0; 3].map(|_| self.within(-1.0, 1.0));
            let d = v.iter().map(|c| c * c).sum::<f64>();
            if (0.01..1.0).contains(&d) {
                return v.map(|c| c / d.sqrt());
            }
        }
    }
}

fn close(a: f32, b: f32, tolerance: f32) -> bool {
    (a - b).abs() <= tolerance
}

fn project(view: &View, p: [f32; 3]) -> [f32; 3] {
    view.project(p).expect("in front of the eye")
}

fn texture(width: u32, height: u32, at: impl Fn(u32, u32) -> [u8; 4]) -> Texture {
    let texels = (0..width * height)
        .map(|i| at(i % width, i / width))
        .collect();
    Texture::from_rgba8(width, height, texels, Meaning::Color).expect("allowed")
}
