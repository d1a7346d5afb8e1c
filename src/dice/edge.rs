//! Points and normals along a cage edge, by the edge's own rule: the operands are the rings of its two end vertices and nothing else,
//! so both faces at the edge get the same bits without talking to each other.
//!
//! * Both ends regular: the twelve points around the edge are a B-spline strip; it runs from the lower to the higher vertex number.
//! * Otherwise each half belongs to its end. At a regular end the half is a B-spline strip of the once-refined ring. At an irregular
//!   end it is a chain of strips, each half as long as the one before, from the rings of deeper and deeper levels.
//! * On a boundary the points (not the normals) come from the boundary polygon alone, so that all faces of a non-manifold edge agree.

use super::basis::{Basis, Target};
use super::point::P4;
use super::regular::{LANES, LINE, Line, unit_cross, weigh3};
use super::window::{Near, edge_point, face_point, vertex_point};
use crate::dispatch;
use crate::simd::Level;

/// Samples along one side of a face: positions and unit normals, component by component, padded by [`LANES`].
#[derive(Clone, Debug, Default)]
pub(crate) struct EdgeSamples {
    pub(crate) points: [Vec<f32>; 3],
    pub(crate) normals: [Vec<f32>; 3],
}

impl EdgeSamples {
    pub(crate) fn resize(&mut self, segments: usize) {
        for v in self.points.iter_mut().chain(&mut self.normals) {
            v.resize(segments + 1 + LANES, 0.0);
        }
    }
    /// Takes over all samples of `from`, from its end if `reversed`: points, normals, or both.
    pub(crate) fn copy(&mut self, from: &Self, reversed: bool, [points, normals]: [bool; 2]) {
        let pairs = (self.points.iter_mut().zip(&from.points).filter(|_| points)).chain(
            self.normals
                .iter_mut()
                .zip(&from.normals)
                .filter(|_| normals),
        );
        for (to, from) in pairs {
            let n = to.len() - LANES;
            to[..n].copy_from_slice(&from[..n]);
            if reversed {
                to[..n].reverse();
            }
        }
    }
    pub(crate) fn set(&mut self, i: usize, point: [f32; 3], normal: [f32; 3]) {
        for c in 0..3 {
            self.points[c][i] = point[c];
            self.normals[c][i] = normal[c];
        }
    }
}

/// Samples of a strip that are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SamplePart {
    All,
    /// The last one is left to the strip that follows.
    ButLast,
    First,
}

/// Which samples of a strip are wanted and where they go: at `0, 1/n, … 1` with `n = 2^level`, to places `at`, `at + step`, ….
#[derive(Clone, Copy, Debug)]
pub(crate) struct Samples {
    pub(crate) target: Target,
    pub(crate) level: u32,
    pub(crate) at: i64,
    pub(crate) step: i64,
    pub(crate) simd: Level,
    /// Whether normals are wanted too.
    pub(crate) normals: bool,
    /// Which of them are wanted.
    pub(crate) part: SamplePart,
}

/// A strip of three by four control points along an edge; `l` lies to the left of the direction of travel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strip {
    pub(crate) l: [P4; 4],
    pub(crate) c: [P4; 4],
    pub(crate) r: [P4; 4],
}

impl Strip {
    /// The same strip walked the other way.
    pub(crate) fn reversed(&self) -> Self {
        let turn = |a: [P4; 4]| [a[3], a[2], a[1], a[0]];
        Self {
            l: turn(self.r),
            c: turn(self.c),
            r: turn(self.l),
        }
    }

    /// Writes points and normals of the strip's middle line.
    #[inline(always)]
    pub(crate) fn sample(&self, to: Samples, out: &mut EdgeSamples) {
        dispatch!(to.simd, self.sample_kernel(to, out));
    }

    #[inline(always)]
    fn sample_kernel(&self, to: Samples, out: &mut EdgeSamples) {
        let basis = Basis::get(to.target, to.level);
        let row = self.across(basis.across);
        let mut line = [[0.0; LINE]; 3];
        to.runs(|i, n| {
            weigh3(&basis.point, i, n.next_multiple_of(LANES), &row, &mut line);
            to.put(&line, &mut out.points, i, n);
        });
        if to.normals {
            self.normals_kernel(to, basis, out);
        }
    }

    /// The strip's middle line: each centre blended with its neighbours.
    #[inline(always)]
    fn across(&self, [side, centre]: [f32; 2]) -> [P4; 4] {
        let at = |i: usize| (self.l[i] + self.r[i]) * side + self.c[i] * centre;
        [at(0), at(1), at(2), at(3)]
    }

    #[inline(always)]
    fn normals_kernel(&self, to: Samples, basis: &Basis, out: &mut EdgeSamples) {
        let along = self.across(Basis::get(Target::Limit, 0).across);
        let across = [
            self.l[0] - self.r[0],
            self.l[1] - self.r[1],
            self.l[2] - self.r[2],
            self.l[3] - self.r[3],
        ];
        let spare = (self.c[2] - self.c[1])
            .cross(across[1] + across[2])
            .unit()
            .map_or([0.0, 0.0, 1.0], P4::xyz);
        let (mut du, mut dv, mut unit) = ([[0.0; LINE]; 3], [[0.0; LINE]; 3], [[0.0; LINE]; 3]);
        to.runs(|i, n| {
            let lanes = n.next_multiple_of(LANES);
            weigh3(&basis.slope, i, lanes, &along, &mut du);
            weigh3(&basis.limit, i, lanes, &across, &mut dv);
            unit_cross(&du, &dv, lanes, spare, &mut unit);
            to.put(&unit, &mut out.normals, i, n);
        });
    }
}

impl Samples {
    /// Number of samples.
    #[inline(always)]
    pub(crate) fn count(&self) -> usize {
        match self.part {
            SamplePart::All => (1 << self.level) + 1,
            SamplePart::ButLast => 1 << self.level,
            SamplePart::First => 1,
        }
    }

    /// Cuts the samples into runs of at most a line: first sample and number.
    #[inline(always)]
    fn runs(&self, mut f: impl FnMut(usize, usize)) {
        let count = self.count();
        let mut i = 0;
        while i < count {
            f(i, (count - i).min(LINE));
            i += LINE;
        }
    }

    /// Stores a run of samples, `i` being the first.
    #[inline(always)]
    fn put(&self, values: &[Line; 3], out: &mut [Vec<f32>; 3], i: usize, n: usize) {
        for (values, out) in values.iter().zip(out) {
            let at = self.at + i as i64 * self.step;
            if self.step > 0 {
                out[at as usize..at as usize + n].copy_from_slice(&values[..n]);
            } else {
                let to = &mut out[at as usize + 1 - n..=at as usize];
                for (value, out) in values[..n].iter().zip(to.iter_mut().rev()) {
                    *out = *value;
                }
            }
        }
    }
}

/// Points of a boundary curve from its own polygon: `p[1]` to `p[2]`, with the neighbours before and after.
pub(crate) fn sample_boundary(
    p: [P4; 4],
    target: Target,
    level: u32,
    out: &mut EdgeSamples,
    at: i64,
    step: i64,
) {
    let basis = Basis::get(target, level);
    for i in 0..=1_usize << level {
        let w: [f32; 4] = std::array::from_fn(|k| basis.point[k][i]);
        let q = (p[0] * w[0] + p[3] * w[3]) + (p[1] * w[1] + p[2] * w[2]);
        for c in 0..3 {
            out.points[c][(at + i as i64 * step) as usize] = q.0[c];
        }
    }
}

/// The three points of a ring that stand across its edge `s`: left, centre and right, with phantoms beyond a boundary.
fn row(window: &Near, s: i32, left: P4, centre: P4, right: P4) -> [P4; 3] {
    match (window.has(s), window.has(s - 1)) {
        (true, true) => [left, centre, right],
        (true, false) => [left, centre, P4::beyond(centre, left)],
        (false, _) => [P4::beyond(centre, right), centre, right],
    }
}

/// Row through the vertex, across ring edge `s`.
fn row_at(w: &Near, s: i32) -> [P4; 3] {
    let side = |present: bool, i: i32| if present { w.e(i) } else { P4::ZERO };
    row(w, s, side(w.has(s), s + 1), w.v, side(w.has(s - 1), s - 1))
}

/// Row through the far end of ring edge `s`.
fn row_ahead(w: &Near, s: i32) -> [P4; 3] {
    let side = |i: i32| if w.has(i) { w.f(i) } else { P4::ZERO };
    row(w, s, side(s), w.e(s), side(s - 1))
}

/// Row behind the vertex, opposite ring edge `s`, of a regular fan.
fn row_behind(w: &Near, s: i32) -> [P4; 3] {
    if w.has(s + 1) {
        // Two sectors on the left side: the edge straight on is s + 2.
        let right = if w.has(s - 2) && w.has(s - 1) {
            w.f(s - 2)
        } else {
            P4::ZERO
        };
        row(w, s, w.f(s + 1), w.e(s + 2), right)
    } else if w.has(s - 2) {
        row(w, s, P4::ZERO, w.e(s - 2), w.f(s - 2))
    } else {
        // Across the edge lies a boundary: reflect.
        let (near, far) = (row_at(w, s), row_ahead(w, s));
        std::array::from_fn(|k| P4::beyond(near[k], far[k]))
    }
}

/// Strip of an edge with two regular ends, from the end `a` (ring edge `sa`) to the end `b` (ring edge `sb`).
pub(crate) fn whole_strip(a: &Near, sa: i32, b: &Near, sb: i32) -> Strip {
    let (behind, first) = (row_behind(a, sa), row_at(a, sa));
    let (second, ahead) = (row_at(b, sb), row_behind(b, sb));
    // Seen from b, left and right are exchanged.
    strip([
        behind,
        first,
        [second[2], second[1], second[0]],
        [ahead[2], ahead[1], ahead[0]],
    ])
}

fn strip(rows: [[P4; 3]; 4]) -> Strip {
    Strip {
        l: std::array::from_fn(|i| rows[i][0]),
        c: std::array::from_fn(|i| rows[i][1]),
        r: std::array::from_fn(|i| rows[i][2]),
    }
}

/// Row through the far end `b` of ring edge `s` at depth 1, as the half at the other end sees it.
fn far_row(a: &Near, s: i32, b: &Near, sb: i32) -> [P4; 3] {
    let far = row_at(b, sb);
    debug_assert!(a.has(s) == b.has(sb - 1) && a.has(s - 1) == b.has(sb));
    [far[2], far[1], far[0]]
}

/// Half at a regular end `a`, whose other end `b` is irregular; both windows at depth 1.
pub(crate) fn regular_half(
    a: &Near,
    s: i32,
    b: &Near,
    sb: i32,
    half: Samples,
    out: &mut EdgeSamples,
) {
    let rows = [
        row_behind(a, s),
        row_at(a, s),
        row_ahead(a, s),
        far_row(a, s, b, sb),
    ];
    strip(rows).sample(
        Samples {
            level: half.level - 1,
            ..half
        },
        out,
    );
}

/// Half at an irregular end: `rings[d]` is its window at depth `d + 1`, `b` the other end's window at depth 1.
/// Level and places in `half` are those of the whole edge and of its end at the vertex.
///
/// A sample where two strips meet is that of the strip further from the vertex, and does not depend on how many strips follow:
/// so the samples of a level are among those of the next, bit for bit.
pub(crate) fn irregular_half(
    rings: &[Near],
    s: i32,
    b: &Near,
    sb: i32,
    half: Samples,
    out: &mut EdgeSamples,
) {
    let mut far = far_row(&rings[0], s, b, sb);
    // The middle is regular, the start of a strip whose last row has no weight there.
    let (near, mid) = (row_at(&rings[0], s), row_ahead(&rings[0], s));
    strip([near, mid, far, far]).sample(
        Samples {
            level: half.level - 1,
            at: half.at + half.step * (1_i64 << (half.level - 1)),
            part: SamplePart::First,
            ..half
        },
        out,
    );
    for depth in 1..half.level {
        let (ring, next) = (&rings[depth as usize - 1], &rings[depth as usize]);
        let (near, mid) = (row_at(ring, s), row_ahead(ring, s));
        let cell = |k: usize| face_point(mid[k], mid[k + 1], far[k + 1], far[k]);
        let inner = |k: usize| face_point(near[k], near[k + 1], mid[k + 1], mid[k]);
        let (ahead_l, ahead_r) = (cell(0), cell(1));
        let centre = vertex_point([near, mid, far]);
        let new_far = [
            edge_point(mid[0], mid[1], inner(0), ahead_l),
            centre,
            edge_point(mid[1], mid[2], inner(1), ahead_r),
        ];
        let beyond = [
            ahead_l,
            edge_point(mid[1], far[1], ahead_l, ahead_r),
            ahead_r,
        ];
        let start = half.at + half.step * (1_i64 << (half.level - depth - 1));
        strip([row_at(next, s), row_ahead(next, s), new_far, beyond]).sample(
            Samples {
                level: half.level - depth - 1,
                at: start,
                part: SamplePart::ButLast,
                ..half
            },
            out,
        );
        far = new_far;
    }
}
