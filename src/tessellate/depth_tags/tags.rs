//! Tags of vertices from distance and curvature.

use super::{DepthTags, MAX_DEPTH};
use crate::camera::View;
use crate::math;
use crate::surface::Surface;

/// One tag per vertex of the cage. `given` are those of the user, one per vertex, or none.
pub(crate) fn vertex_tags(
    surface: &Surface,
    view: &View,
    wanted: &DepthTags,
    given: &[u8],
) -> Vec<u8> {
    let cage = surface.cage();
    let mut tags = vec![0_u8; cage.points().len()];
    if wanted.distance.is_some() || wanted.curvature.is_some() {
        from_edges(surface, view, wanted, &mut tags);
    }
    for (tag, &given) in tags.iter_mut().zip(given) {
        *tag = (*tag).max(given.min(MAX_DEPTH as u8));
    }
    tags
}

/// The lesser of what distance and curvature ask for, each of them the most that any edge at the vertex asks for.
fn from_edges(surface: &Surface, view: &View, wanted: &DepthTags, tags: &mut [u8]) {
    let (base, quads) = (surface.topology(), surface.quads());
    // Corner `h` of the cage is that of a quad, too.
    let fan = |h: u32| match surface.is_split() {
        true => quads.fan(4 * h),
        false => quads.fan(h),
    };
    let mut both = vec![[0_u8; 2]; tags.len()];
    for h in 0..base.half_count() as u32 {
        if base.is_hole(base.face_of(h)) {
            continue;
        }
        let ends = [h, base.next(h)];
        let [a, b] = ends.map(|h| surface.fan_limit(fan(h)));
        let asked = [
            wanted
                .distance
                .map(|most| halvings(pixels(view, a.0, b.0), most)),
            wanted
                .curvature
                .map(|most| halvings(degrees(a.1, b.1), most)),
        ];
        for v in ends.map(|h| base.vertex(h) as usize) {
            for k in 0..2 {
                both[v][k] = both[v][k].max(asked[k].unwrap_or(MAX_DEPTH as u8));
            }
        }
    }
    for (tag, [distance, curvature]) in tags.iter_mut().zip(both) {
        *tag = distance.min(curvature);
    }
}

/// How often a length has to be halved to be at most `most`, up to the deepest.
fn halvings(length: f32, most: f32) -> u8 {
    let most = most.max(1e-3);
    (0..MAX_DEPTH as u8)
        .find(|&k| length <= most * (1_u32 << k) as f32)
        .unwrap_or(MAX_DEPTH as u8)
}

/// Length in pixels where it is nearest to the eye; 0 behind it.
fn pixels(view: &View, a: [f32; 3], b: [f32; 3]) -> f32 {
    let (da, db) = (view.distance(a), view.distance(b));
    if !view.projection.ortho && da.max(db) < view.near {
        return 0.0;
    }
    math::length(math::sub(a, b)) * view.pixel_scale(da.min(db))
}

/// Angle between unit normals.
fn degrees(a: [f32; 3], b: [f32; 3]) -> f32 {
    libm::atan2f(math::length(math::cross(a, b)), math::dot(a, b)).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_halved_until_short_enough() {
        assert_eq!(
            [0.0, 5.0, 5.1, 10.0, 11.0].map(|l| halvings(l, 5.0)),
            [0, 0, 1, 1, 2]
        );
        assert_eq!(halvings(f32::INFINITY, 5.0), 10);
        assert_eq!(halvings(f32::NAN, 5.0), 10);
        assert_eq!(halvings(5.0, 0.0), 10);
    }

    #[test]
    fn angles_are_those_between_vectors() {
        let at = |d: f32| {
            let r = d.to_radians();
            [libm::cosf(r), libm::sinf(r), 0.0]
        };
        for d in [0.0, 1.0, 30.0, 90.0, 180.0] {
            assert!((degrees(at(0.0), at(d)) - d).abs() < 1e-3);
        }
    }
}
