//! Unit normals of a cage: one per vertex, or one per side where infinite creases and borders part its faces.

use super::bezier::Vector;
use crate::math;
use crate::scheme::crease::is_infinite;
use crate::topology::{NONE, Ring, Topology};

/// The normal at every corner: the mean over the faces around, weighted by their angles there (Thürmer, Wüthrich, *Computing Vertex Normals
/// from Polygonal Facets*, 1998). `given` may know better. What has no direction gets (0, 0, 1).
pub(super) fn corner_normals(
    t: &Topology,
    points: &[Vector],
    given: impl Fn(u32) -> Option<Vector>,
) -> Vec<Vector> {
    let mut out = vec![[0.0, 0.0, 1.0]; t.half_count()];
    let mut ring = Vec::new();
    let faces: Vec<Vector> = (0..t.face_count() as u32)
        .map(|f| area(t, points, f))
        .collect();
    for fan in t.fans() {
        if fan.first == NONE {
            continue;
        }
        ring.clear();
        ring.extend(Ring::from_half(t, fan.first));
        let cuts = |h: &u32| is_infinite(t.edge_sharpness(t.edge(*h)));
        if fan.closed {
            // A sector begins at a crease.
            let first = ring.iter().position(cuts).unwrap_or(0);
            ring.rotate_left(first);
        }
        let mut from = 0;
        while from < ring.len() {
            let rest = &ring[from + 1..];
            let to = from + 1 + rest.iter().position(cuts).unwrap_or(rest.len());
            let sector = &ring[from..to];
            let sum = (sector.iter()).fold([0.0; 3], |sum, &h| {
                math::add(sum, angle(t, points, &faces, h))
            });
            if let Some(normal) = math::normalize(sum) {
                sector.iter().for_each(|&h| out[h as usize] = normal);
            }
            from = to;
        }
    }
    for (h, normal) in out.iter_mut().enumerate() {
        if let Some(better) = given(h as u32) {
            *normal = better;
        }
    }
    out
}

/// Twice the area of a face, along its normal (Newell's sum).
fn area(t: &Topology, points: &[Vector], f: u32) -> Vector {
    let halves = t.face_halves(f);
    let base = points[t.vertex(halves.start) as usize];
    let at = |h: u32| math::sub(points[t.vertex(h) as usize], base);
    let crosses = halves.map(|h| math::cross(at(h), at(t.next(h))));
    crosses.fold([0.0; 3], math::add)
}

/// The normal of a face at one of its corners, as long as its angle there.
fn angle(t: &Topology, points: &[Vector], faces: &[Vector], h: u32) -> Vector {
    let at = |h: u32| points[t.vertex(h) as usize];
    let side = |to: u32| math::normalize(math::sub(at(to), at(h)));
    let (Some(a), Some(b)) = (side(t.next(h)), side(t.prev(h))) else {
        return [0.0; 3];
    };
    let cross = math::cross(a, b);
    let mut angle = libm::atan2f(math::length(cross), math::dot(a, b));
    // A corner that points into its face has the rest of the turn, on the other side.
    if math::dot(cross, faces[t.face_of(h) as usize]) < 0.0 {
        angle -= std::f32::consts::TAU;
    }
    math::normalize(cross).map_or([0.0; 3], |n| math::scale(n, angle))
}
