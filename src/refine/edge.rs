//! Edge points: smooth, midpoint of a sharp edge, or in between where sharpness runs out.

use super::real::{Real, add, add_scaled, blend, midpoint, scaled};
use super::sharpness::Step;
use crate::scheme::{Scheme, TriangleRule, catmull_clark, crease, loop_scheme};
use crate::topology::NONE;
use rayon::prelude::*;

/// Computes the edge points of a level; arguments as for [`face::points`](super::face::points).
pub fn points<T: Real, const N: usize>(
    step: &Step<'_>,
    index: &[u32],
    values: &[[T; N]],
    face_points: &[[T; N]],
    out: &mut [[T; N]],
) {
    out.par_iter_mut()
        .enumerate()
        .with_min_len(1 << 12)
        .for_each(|(e, point)| {
            *point = value(step, e as u32, index, values, |f| face_points[f as usize]);
        });
}

/// The point of edge `e`.
#[inline]
pub(crate) fn value<T: Real, const N: usize>(
    step: &Step<'_>,
    e: u32,
    index: &[u32],
    values: &[[T; N]],
    face_point: impl Fn(u32) -> [T; N],
) -> [T; N] {
    let t = step.topology;
    let h = t.edge_half(e);
    let twin = t.twin(h);
    let a = &values[index[h as usize] as usize];
    let b = &values[index[t.next(h) as usize] as usize];
    if step.is_linear() || twin == NONE {
        return midpoint(a, b);
    }
    let weight = crease::midpoint_weight(t.edge_sharpness(e), step.child_edge(e));
    if weight == 1.0 {
        return midpoint(a, b);
    }
    let mut ends = *a;
    add(&mut ends, b);
    if step.options.scheme == Scheme::Loop {
        let [c, d] = [h, twin].map(|h| &values[index[t.prev(h) as usize] as usize]);
        let mut opposite = *c;
        add(&mut opposite, d);
        let mut smooth = scaled(loop_scheme::EDGE_OPPOSITE, &opposite);
        add_scaled(&mut smooth, loop_scheme::EDGE_END, &ends);
        return if weight == 0.0 {
            smooth
        } else {
            blend(weight, &midpoint(a, b), &smooth)
        };
    }
    let faces = [t.face_of(h), t.face_of(twin)];
    let face_weight = if step.options.triangles == TriangleRule::Smooth {
        catmull_clark::edge_face_beside_triangles(faces.map(|f| t.face_halves(f).len() as u32))
    } else {
        catmull_clark::EDGE_FACE
    };
    let mut middles = face_point(faces[0]);
    add(&mut middles, &face_point(faces[1]));
    let mut smooth = scaled(0.5 - face_weight, &ends);
    add_scaled(&mut smooth, face_weight, &middles);
    if weight == 0.0 {
        smooth
    } else {
        blend(weight, &midpoint(a, b), &smooth)
    }
}
