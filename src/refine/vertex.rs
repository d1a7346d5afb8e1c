//! Vertex points: the rule of the parent's sharpness, the rule of the child's, or a blend of both.

use super::real::{Real, add, add_scaled, blend, scaled};
use super::ring::Spoke;
use super::sharpness::Step;
use crate::scheme::crease::{Rule, Transition};
use crate::scheme::{Scheme, catmull_clark, loop_scheme};
use crate::topology::{NONE, Ring};
use rayon::prelude::*;

/// Computes the vertex points of a level.
pub fn points<T: Real>(
    step: &Step<'_>,
    points: &[[T; 3]],
    face_points: &[[T; 3]],
    out: &mut [[T; 3]],
) {
    let index = &step.topology.corner_vertices;
    out.par_iter_mut()
        .enumerate()
        .with_min_len(1 << 12)
        .for_each_init(Vec::new, |spokes, (v, point)| {
            *point = if step.topology.fans[v].first == NONE {
                points[v]
            } else {
                value(step, v as u32, spokes, index, points, |f| {
                    face_points[f as usize]
                })
            };
        });
}

/// The point of vertex `v`, which must have a face. `index` names the value of every corner; all corners at `v` must agree.
#[inline]
pub(crate) fn value<T: Real, const N: usize>(
    step: &Step<'_>,
    v: u32,
    spokes: &mut Vec<Spoke>,
    index: &[u32],
    values: &[[T; N]],
    face_point: impl Fn(u32) -> [T; N],
) -> [T; N] {
    let t = step.topology;
    let fan = t.fans[v as usize];
    let x = &values[index[fan.first as usize] as usize];
    if step.is_linear() {
        return *x;
    }
    let smooth = || smooth(step, v, x, index, values, &face_point);
    if step.is_plain() && fan.closed {
        return smooth();
    }
    let far = |s: &Spoke| &values[index[s.far_corner as usize] as usize];
    step.incidence.spokes(t, v, spokes);
    let child_sharp = |s: &Spoke| step.child_edge(s.edge)[s.end as usize];
    let sigma = t.vertex_sharpness(v);
    let child_sigma = step.child_vertex(v);
    let mut transition = Transition::default();
    transition.note(sigma, child_sigma);
    let (mut sharp, mut still_sharp) = (0, 0);
    for s in spokes.iter() {
        let (own, child) = (t.edge_sharpness(s.edge), child_sharp(s));
        transition.note(own, child);
        sharp += usize::from(own > 0.0);
        still_sharp += usize::from(child > 0.0);
    }
    let parent_rule = Rule::of(sigma, sharp);
    let child_rule = Rule::of(child_sigma, still_sharp);
    let apply = |rule: Rule, is_sharp: &dyn Fn(&Spoke) -> bool| match rule {
        Rule::Corner => *x,
        Rule::Smooth | Rule::Dart => smooth(),
        Rule::Crease => crease(x, spokes.iter().filter(|s| is_sharp(s)).map(far)),
    };
    let of_parent = apply(parent_rule, &|s| t.edge_sharpness(s.edge) > 0.0);
    if matches!(parent_rule, Rule::Smooth | Rule::Dart) || parent_rule == child_rule {
        return of_parent;
    }
    let of_child = apply(child_rule, &|s| child_sharp(s) > 0.0);
    blend(transition.weight(), &of_parent, &of_child)
}

/// The smooth rule over the vertex' own fan.
#[inline]
fn smooth<T: Real, const N: usize>(
    step: &Step<'_>,
    v: u32,
    x: &[T; N],
    index: &[u32],
    values: &[[T; N]],
    face_point: &impl Fn(u32) -> [T; N],
) -> [T; N] {
    let t = step.topology;
    let mut ends = [T::default(); N];
    if step.options.scheme == Scheme::Loop {
        for h in Ring::of_fan(t, v) {
            add(&mut ends, &values[index[t.next(h) as usize] as usize]);
        }
        let n = t.fans[v as usize].faces;
        let near = loop_scheme::neighbour(n);
        let mut point = scaled(near, &ends);
        add_scaled(&mut point, 1.0 - f64::from(n) * near, x);
        return point;
    }
    let mask = catmull_clark::vertex(t.fans[v as usize].faces);
    let mut middles = [T::default(); N];
    for h in Ring::of_fan(t, v) {
        add(&mut ends, &values[index[t.next(h) as usize] as usize]);
        add(&mut middles, &face_point(t.face_of(h)));
    }
    let mut point = scaled(mask.face, &middles);
    add_scaled(&mut point, mask.edge, &ends);
    add_scaled(&mut point, mask.vertex, x);
    point
}

/// The curve rule through `x` between two neighbours.
#[inline]
pub(crate) fn crease<'a, T: Real, const N: usize>(
    x: &[T; N],
    ends: impl Iterator<Item = &'a [T; N]>,
) -> [T; N] {
    let mut sum = [T::default(); N];
    for end in ends {
        add(&mut sum, end);
    }
    let mut point = scaled(catmull_clark::CREASE_END, &sum);
    add_scaled(&mut point, catmull_clark::CREASE_VERTEX, x);
    point
}
