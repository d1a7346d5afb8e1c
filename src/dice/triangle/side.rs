//! Points and normals along an edge, by the edge's own rule: the operands are the rings of its two ends and nothing else, so both faces
//! at the edge get the same bits without talking to each other.
//!
//! * The surface along an edge depends on ten points, the edge's *strip*: its ends and their neighbours. With two regular ends it is one
//!   quartic, walked from the lower to the higher vertex number.
//! * Otherwise each half belongs to its end. At a regular end the half is the strip of the once-refined rings; at an irregular end it is
//!   a chain of strips, each half as long as the one before.

use super::super::basis::Target;
use super::super::edge::{EdgeSamples, SamplePart, Samples};
use super::super::point::P4;
use super::super::regular::{LANES, LINE, Line, unit_cross, weigh3};
use super::basis::{Bernstein, expansion};
use super::ring::{Hexagon, Near, edge_point, vertex_point};
use super::tensor::{Net12, differences, expand_row, fallback, step_across, weigh5};
use crate::dispatch;

/// The net of a triangle on the left of the edge, which runs from its corner 0 to corner 1; the two points that the edge does not
/// depend on are zero.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strip {
    /// Relative to `base`.
    net: Net12,
    base: P4,
}

impl Strip {
    /// From `v` with ring `e` (from the edge on, counter-clockwise) to `e[0]`, around which stand `far`: to the right, ahead, to the left.
    fn new(v: P4, e: [P4; 6], far: [P4; 3], base: P4) -> Self {
        let zero = P4::ZERO;
        let net = [
            e[4], e[5], far[0], e[3], v, e[0], far[1], e[2], e[1], far[2], zero, zero,
        ];
        Self { net, base }
    }

    /// Edge between two regular vertices: from `a`, along its ring edge `sa`, to `b`, whose ring edge `sb` it is.
    pub(super) fn whole(a: &Hexagon, sa: usize, b: &Hexagon, sb: usize) -> Self {
        let far = b.from(sb);
        Self::new(a.v, a.from(sa), [far[2], far[3], far[4]], P4::ZERO)
    }

    /// The same edge walked the other way.
    pub(super) fn reversed(&self) -> Self {
        let mut out = *self;
        out.net[..10].reverse();
        out
    }

    pub(super) fn sample(&self, to: Samples, out: &mut EdgeSamples) {
        dispatch!(to.simd, self.sample_kernel(to, out));
    }

    #[inline(always)]
    fn sample_kernel(&self, to: Samples, out: &mut EdgeSamples) {
        let b = Bernstein::get(to.level);
        let count = to.count();
        let mut first = expand_row(&self.net, expansion(to.target, to.level), 0);
        for q in &mut first {
            *q = self.base + *q;
        }
        let mut line = [[0.0; LINE]; 3];
        for i in (0..count).step_by(LINE) {
            let n = (count - i).min(LINE);
            weigh5(&b.quartic, i, n.next_multiple_of(LANES), &first, &mut line);
            put(to, &line, &mut out.points, i, n);
        }
        if !to.normals {
            return;
        }
        let weights = expansion(Target::Limit, 0);
        let first = expand_row(&self.net, weights, 0);
        let along = differences(&first);
        let across = step_across(&first, &expand_row(&self.net, weights, 1));
        let spare = fallback(&self.net);
        let (mut du, mut dv) = ([[0.0; LINE]; 3], [[0.0; LINE]; 3]);
        for i in (0..count).step_by(LINE) {
            let n = (count - i).min(LINE);
            let lanes = n.next_multiple_of(LANES);
            weigh3(&b.cubic, i, lanes, &along, &mut du);
            weigh3(&b.cubic, i, lanes, &across, &mut dv);
            unit_cross(&du, &dv, lanes, spare, &mut line);
            put(to, &line, &mut out.normals, i, n);
        }
    }
}

/// Stores a run of samples, `i` being the first.
#[inline(always)]
fn put(to: Samples, values: &[Line; 3], out: &mut [Vec<f32>; 3], i: usize, n: usize) {
    for (values, out) in values.iter().zip(out) {
        for (k, value) in values[..n].iter().enumerate() {
            out[(to.at + (i + k) as i64 * to.step) as usize] = *value;
        }
    }
}

/// The three points of `b`'s ring after one step that a half at the other end needs: to the right, the vertex, to the left.
fn far_row(b: &Near, sb: i32) -> [P4; 3] {
    [b.e(sb + 1), b.v, b.e(sb - 1)]
}

/// Half at a regular end with ring `a`, whose other end is irregular; both after one step. `half` has level and places of the whole edge.
pub(super) fn regular_half(
    a: &Hexagon,
    sa: usize,
    b: &Near,
    sb: i32,
    half: Samples,
    out: &mut EdgeSamples,
) {
    let to = Samples {
        level: half.level - 1,
        ..half
    };
    Strip::new(a.v, a.from(sa), far_row(b, sb), P4::ZERO).sample(to, out);
}

/// Half at an irregular end: `rings[d]` is its ring after `d + 1` steps, relative to `base`; `b` the other end's after the first.
///
/// As on quads, a sample where two strips meet is that of the strip further from the vertex, so that levels are nested bit for bit.
pub(super) fn irregular_half(
    rings: &[Near],
    base: P4,
    s: i32,
    b: &Near,
    sb: i32,
    half: Samples,
    out: &mut EdgeSamples,
) {
    let mut far = far_row(b, sb).map(|p| p - base);
    // The ring of the edge's middle point, from the far end on.
    let around = |ring: &Near, [right, ahead, left]: [P4; 3]| {
        [ahead, left, ring.e(s + 1), ring.v, ring.e(s - 1), right]
    };
    // The middle is regular, the start of a strip whose far points have no weight there.
    let to = Samples {
        level: half.level - 1,
        at: half.at + half.step * (1_i64 << (half.level - 1)),
        part: SamplePart::First,
        ..half
    };
    Strip::new(rings[0].e(s), around(&rings[0], far), [P4::ZERO; 3], base).sample(to, out);
    for depth in 1..half.level {
        let (ring, next) = (&rings[depth as usize - 1], &rings[depth as usize]);
        let (m, e) = (ring.e(s), around(ring, far));
        let edge = |k: usize| edge_point(m, e[k], e[(k + 5) % 6], e[(k + 1) % 6]);
        let (centre, left, right) = (vertex_point(m, e), edge(2), edge(4));
        let ring = [centre, left, next.e(s + 1), next.v, next.e(s - 1), right];
        let to = Samples {
            level: half.level - depth - 1,
            at: half.at + half.step * (1_i64 << (half.level - depth - 1)),
            part: SamplePart::ButLast,
            ..half
        };
        Strip::new(next.e(s), ring, [edge(5), edge(0), edge(1)], base).sample(to, out);
        far = [right, centre, left];
    }
}
