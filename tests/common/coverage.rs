//! Signed coverage of a closed model from many cameras.
#![allow(dead_code, missing_docs, unreachable_pub)]

use super::common::Random;
use earmark::Scene;
use earmark::camera::{Camera, View};
use earmark::frame::coverage::{CoverageFault, SignedCoverage};
use earmark::frame::{Refinement, Renderer};

/// Cameras all around: outside, near, far and grazing, the model wholly in front of the near plane.
pub fn views(scene: &Scene, renderer: &Renderer, count: u32, seed: u64) -> Vec<View> {
    let mut random = Random(seed);
    let sphere = scene.bounding_sphere();
    // The surface may bulge beyond its corners: keep clear of it.
    let (centre, radius) = (sphere.center, sphere.radius * 1.3);
    let mut out = Vec::new();
    while out.len() < count as usize {
        let distance = radius
            * if out.len() % 3 == 0 {
                random.range(1.05, 1.3)
            } else {
                random.range(1.3, 12.0)
            };
        let (a, z) = (
            random.range(0.0, std::f64::consts::TAU),
            random.range(-1.0, 1.0),
        );
        let r = (1.0 - z * z).sqrt();
        let eye = [
            centre[0] + distance * r * a.cos(),
            centre[1] + distance * z,
            centre[2] + distance * r * a.sin(),
        ];
        // Look past the middle now and then, so that the model grazes the picture's border.
        let off = if out.len() % 4 == 1 {
            radius
        } else {
            0.2 * radius
        };
        let target = std::array::from_fn(|k| centre[k] + random.range(-off, off));
        let near = distance - radius;
        let camera = Camera::default()
            .with_eye_target(eye, target)
            .with_fov(random.range(8.0, 100.0))
            .with_near_far(near * 0.5, distance + radius);
        if let Ok(view) = camera.framing(&sphere, renderer.size) {
            out.push(view);
        }
    }
    out
}

pub fn renderer(side: u32, level: u32) -> Renderer {
    let mut r = Renderer::new(side, side);
    r.size.samples = if level.is_multiple_of(2) { 1 } else { 4 };
    r.refinement = Refinement::Uniform(level);
    r
}

pub fn count(
    scene: &Scene,
    side: u32,
    level: u32,
    cameras: u32,
    fault: CoverageFault,
) -> SignedCoverage {
    let renderer = renderer(side, level);
    let mut sum = SignedCoverage::default();
    for view in views(scene, &renderer, cameras, 7 + u64::from(level)) {
        let c = renderer.signed_coverage(scene, &view, fault).unwrap();
        sum.samples += c.samples;
        sum.covered += c.covered;
        sum.unequal += c.unequal;
    }
    sum
}
