//! Uniform level of a model from the length of its quads' edges on the screen.

use crate::camera::View;
use crate::surface::Surface;

/// Micro-edges of this many pixels are short enough for smooth silhouettes: a chord of a circle of 50 pixels radius is then off by a
/// tenth of a pixel. Longer shows corners on small bright rims, shorter costs time and shows nothing.
const TARGET_PIXELS: f32 = 5.0;

/// Share of the edges that may stay longer than the target.
const LONGER: f32 = 0.02;

/// The lowest level at which nearly all micro-edges are at most [`TARGET_PIXELS`] long, no higher than `max_level`.
pub(super) fn by_edge_length(surface: &Surface, view: &View, max_level: u32) -> u32 {
    let quads = surface.quads();
    let split = u32::from(surface.is_split());
    // Number of edges that need each level.
    let mut needs = [0_u64; 12];
    for e in 0..quads.edge_count() as u32 {
        let h = quads.edge_half(e);
        if quads.is_hole(quads.face_of(h)) {
            continue;
        }
        let (a, b) = (
            surface.corner_point(h).0,
            surface.corner_point(quads.next(h)).0,
        );
        let (da, db) = (view.distance(a), view.distance(b));
        if !view.projection.ortho && da.max(db) < view.near {
            continue;
        }
        let length = crate::math::length(crate::math::sub(a, b)) * view.pixel_scale(da.min(db));
        let mut level = 0;
        while level < 11 && length > TARGET_PIXELS * (1_u32 << level) as f32 {
            level += 1;
        }
        needs[level] += 1;
    }
    let total: u64 = needs.iter().sum();
    let allowed = (total as f64 * f64::from(LONGER)) as u64;
    let mut above = 0;
    for level in (0..needs.len()).rev() {
        above += needs[level];
        if above > allowed {
            return (level as u32 + split).min(max_level);
        }
    }
    split.min(max_level)
}
