//! Limits of texture coordinates and other values per corner.
//!
//! Where values agree they go by the rules of points, and so does their limit. A sibling is a corner, which stays; or a cubic curve along the
//! borders of its span, whose limit is one sixth of either neighbour and two thirds of itself; or it becomes one once the sharpness within
//! its span is gone: then it is refined on its own until that.

use super::super::face_varying::{FaceVarying, Sibling, SiblingKind};
use super::super::real::{Real, blend, midpoint};
use super::super::ring::start_end;
use super::super::sharpness::{Step, semi_sharp_sum};
use super::super::vertex::crease;
use super::local::LocalRing;
use super::{Point, Tables, fan_ring};
use crate::scheme::crease::{Transition, decay, decay_edge, is_semi_sharp};
use crate::scheme::limit::{CREASE_END, CREASE_VERTEX};
use crate::topology::NONE;
use rayon::prelude::*;

/// No sharpness below infinite outlives as many steps.
const MOST_STEPS: u32 = 16;

impl<T: Real> FaceVarying<T> {
    /// The limit of every value.
    pub(in crate::refine) fn limit(&self, step: &Step<'_>, tables: &Tables) -> Vec<[T; 2]> {
        if self.is_linear() || step.options.scheme.is_interpolating() {
            return self.values.clone();
        }
        let t = step.topology;
        (0..self.values.len() as u32)
            .into_par_iter()
            .with_min_len(1 << 10)
            .map_init(
                || (LocalRing::default(), Vec::new()),
                |(ring, spokes), i| {
                    if let Ok(rank) = self.siblings().binary_search_by_key(&i, |s| s.value) {
                        return self.sibling_limit(step, rank);
                    }
                    let v = t.vertex(self.value_corners[i as usize]);
                    fan_ring(step, &self.corners, &self.values, v, v, ring, spokes);
                    let [x, y, _] = ring.position(tables);
                    [T::from_f64(x), T::from_f64(y)]
                },
            )
            .collect()
    }

    fn sibling_limit(&self, step: &Step<'_>, rank: usize) -> [T; 2] {
        let t = step.topology;
        let sibling = self.siblings()[rank];
        let at = |i: u32| {
            let [x, y] = self.values[i as usize].map(T::to_f64);
            [x, y, 0.0]
        };
        let x = at(sibling.value);
        let a = at(self.corners[t.next(sibling.first) as usize]);
        let b = at(self.corners[t.prev(sibling.last) as usize]);
        let [x, y, _] = match sibling.kind {
            SiblingKind::Corner => x,
            SiblingKind::Crease => curve_limit(&x, &a, &b),
            SiblingKind::SemiSharp => decayed(step, sibling, sibling, [x, a, b]),
            SiblingKind::Dependent => decayed(step, sibling, self.partner(t, rank), [x, a, b]),
        };
        [T::from_f64(x), T::from_f64(y)]
    }
}

fn curve_limit(x: &Point, a: &Point, b: &Point) -> Point {
    std::array::from_fn(|k| CREASE_VERTEX * x[k] + CREASE_END * (a[k] + b[k]))
}

/// Refines a sibling, and the two values beside it, until it is a crease. `governing` is the one whose sharpness counts.
fn decayed(step: &Step<'_>, own: Sibling, governing: Sibling, values: [Point; 3]) -> Point {
    let t = step.topology;
    let [mut x, mut a, mut b] = values;
    let v = t.vertex(own.first);
    let mut spokes = Vec::new();
    step.incidence.spokes(t, v, &mut spokes);
    let mut inner = vec![false; spokes.len()];
    let mut h = governing.first;
    while h != governing.last {
        h = t.rotate(h);
        if h == NONE {
            break;
        }
        let key = (t.edge(h), start_end(t, h));
        if let Some(i) = spokes.iter().position(|s| (s.edge, s.end) == key) {
            inner[i] = true;
        }
    }
    let mut sharpness: Vec<f32> = spokes.iter().map(|s| t.edge_sharpness(s.edge)).collect();
    let mut sigma = t.vertex_sharpness(v);
    let mut dependent = own.kind == SiblingKind::Dependent;
    for _ in 0..MOST_STEPS {
        let (sum, count) = semi_sharp_sum(sharpness.iter().copied());
        let next: Vec<f32> = (sharpness.iter())
            .map(|&s| decay_edge(step.options.creases, s, sum, count))
            .collect();
        let next_sigma = decay(sigma);
        let mut transition = Transition::default();
        transition.note(sigma, next_sigma);
        let mut still = next_sigma > 0.0;
        for i in (0..spokes.len()).filter(|&i| inner[i]) {
            transition.note(sharpness[i], next[i]);
            still |= is_semi_sharp(next[i]);
        }
        // A dependent one that is left to itself beside semi-sharp edges waits one step more, and then has no sharpness of its own.
        if !still && dependent && next.iter().any(|&s| is_semi_sharp(s)) {
            still = true;
            inner.fill(false);
        }
        dependent &= inner.contains(&true);
        let curve = crease(&x, [a, b].iter());
        (a, b) = (midpoint(&x, &a), midpoint(&x, &b));
        if !still {
            x = blend(transition.weight(), &x, &curve);
            return curve_limit(&x, &a, &b);
        }
        (sharpness, sigma) = (next, next_sigma);
    }
    x
}
