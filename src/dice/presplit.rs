//! Points of a cage after the one Catmull-Clark (or bilinear) step that turns its polygons into quads; made once per frame for cages with n-gons.

use super::fan_points::step_fan;
use super::point::P4;
use super::window::edge_point;
use crate::topology::split::Split;
use crate::topology::{NONE, Topology};
use rayon::prelude::*;

/// Points of the split mesh, in the order of its vertices: fans, faces, edges.
pub(crate) fn presplit(
    t: &Topology,
    split: &Split,
    points: &[[f32; 3]],
    linear: bool,
) -> Vec<[f32; 3]> {
    let at = |h: u32| P4::new(points[t.vertex(h) as usize]);
    let faces: Vec<[f32; 3]> = (0..t.face_count() as u32)
        .into_par_iter()
        .with_min_len(1024)
        .map(|f| {
            let range = t.face_halves(f);
            let mut sum = [0.0_f64; 3];
            for h in range.clone() {
                let p = points[t.vertex(h) as usize];
                sum = std::array::from_fn(|c| sum[c] + f64::from(p[c]));
            }
            sum.map(|s| (s / range.len() as f64) as f32)
        })
        .collect();
    let face = |h: u32| P4::new(faces[t.face_of(h) as usize]);
    let mut out: Vec<[f32; 3]> = (0..t.fans().len() as u32)
        .into_par_iter()
        .with_min_len(1024)
        .map(|fan| match linear {
            true => points[t.fan_vertex(fan) as usize],
            false => step_fan(t, fan, points, &faces),
        })
        .collect();
    let edges: Vec<[f32; 3]> = split
        .edge_vertex_halves
        .par_iter()
        .with_min_len(1024)
        .map(|&h| {
            let (a, b) = (at(h), at(t.next(h)));
            let twin = t.twin(h);
            if twin == NONE || linear {
                ((a + b) * 0.5).xyz()
            } else {
                edge_point(a, b, face(h), face(twin)).xyz()
            }
        })
        .collect();
    out.extend_from_slice(&faces);
    out.extend(edges);
    out
}
