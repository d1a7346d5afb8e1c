//! Two rings of points around a vertex one level on, and tangents as weights of them, for the interpolating schemes.
//!
//! The two rings of a level depend on the two rings of the level before and on nothing else, so tangents are left eigenvectors of that map.
//! Where no closed form is known they are computed: the map is measured with the very code that refines, on a small mesh made for it.
//!
//! Rings are listed counter-clockwise, each kind on its own. Triangles: ends of edges, points beyond the opposite sides, points straight
//! beyond the ends. Quads, per corner of 2 by 2 quads between edges `i` and `i + 1`: ends, points straight beyond them, opposite corners,
//! and around these the points next to edge `i`, next to edge `i + 1`, and the outermost. Open rings have one edge more than faces.

use super::Point;
use crate::refine::Options;
use crate::refine::interpolating::{Masks, Sheets};
use crate::refine::real::Real;
use crate::refine::sharpness::Step;
use crate::scheme::by_valence::ByValence;
use crate::scheme::dart::dominant_left;
use crate::scheme::{Boundary, Scheme, butterfly};
use crate::topology::{ConnectOptions, NONE, Topology, connect};
use std::f64::consts::PI;

/// Most faces of an open ring with a tangent of its own; beyond, normals are those of faces.
const MOST_OPEN: u32 = 16;

/// Tangents by number of faces.
#[derive(Debug)]
pub(super) struct RingMasks {
    pub(super) stencils: Masks,
    pub(super) scheme: Scheme,
    closed: ByValence<[Vec<f64>; 2]>,
    open: ByValence<Vec<f64>>,
}

impl RingMasks {
    pub(super) fn new(scheme: Scheme) -> Self {
        let quads = scheme == Scheme::Kobbelt;
        Self {
            stencils: Masks::default(),
            scheme,
            closed: ByValence::new(if quads {
                closed_quads
            } else {
                butterfly::tangents
            }),
            open: ByValence::new(if quads {
                |k| across(k, true)
            } else {
                |k| across(k, false)
            }),
        }
    }

    /// Two tangents in a closed ring of `n` faces, the first along edge 0, the second a right angle on.
    pub(super) fn closed<const N: usize>(
        &self,
        n: u32,
        ring: &[[f64; N]],
        x: &[f64; N],
    ) -> Option<[[f64; N]; 2]> {
        let apply = |masks: &[Vec<f64>; 2]| [0, 1].map(|i| weigh(&masks[i], ring, x));
        (n > 2).then(|| self.closed.with(n, apply))
    }

    /// The tangent into an open ring of `k` faces between two edges of one smooth curve.
    pub(super) fn across<const N: usize>(
        &self,
        k: u32,
        ring: &[[f64; N]],
        x: &[f64; N],
    ) -> Option<[f64; N]> {
        let apply = |mask: &Vec<f64>| weigh(mask, ring, x);
        (k <= MOST_OPEN).then(|| self.open.with(k, apply))
    }
}

fn weigh<const N: usize>(mask: &[f64], ring: &[[f64; N]], x: &[f64; N]) -> [f64; N] {
    let mut sum = [0.0; N];
    for (w, p) in mask.iter().zip(ring) {
        for ((s, p), x) in sum.iter_mut().zip(p).zip(x) {
            *s += *w * (*p - *x);
        }
    }
    sum
}

/// The two rings one level on, around the sheet that begins with `first`.
pub(super) fn gather<T: Real, const N: usize>(
    t: &Topology,
    sheets: &Sheets<'_, T, f64, N>,
    scheme: Scheme,
    halves: &[u32],
    closed: bool,
) -> Vec<[f64; N]> {
    let end = |h: u32| sheets.at(t.next(h));
    // The last edge of an open ring arrives.
    let arriving = match halves.last() {
        Some(&h) if !closed => Some(t.prev(h)),
        _ => None,
    };
    let mut out: Vec<[f64; N]> = halves.iter().map(|&h| sheets.edge_point(h)).collect();
    out.extend(arriving.map(|h| sheets.edge_point(h)));
    let ends = |out: &mut Vec<[f64; N]>| {
        out.extend(halves.iter().map(|&h| end(h)));
        out.extend(arriving.map(|h| sheets.at(h)));
    };
    if scheme != Scheme::Kobbelt {
        out.extend(halves.iter().map(|&h| sheets.edge_point(t.next(h))));
        ends(&mut out);
        return out;
    }
    ends(&mut out);
    let face_point = |&h: &u32| {
        let first = t.face_halves(t.face_of(h)).start;
        sheets.face_point(first, |g| sheets.edge_point(g))
    };
    out.extend(halves.iter().map(face_point));
    out.extend(halves.iter().map(|&h| sheets.edge_point(t.next(h))));
    let opposite = |h: u32| t.next(t.next(h));
    out.extend(halves.iter().map(|&h| sheets.edge_point(opposite(h))));
    out.extend(halves.iter().map(|&h| sheets.at(opposite(h))));
    out
}

/// Places in the list of two rings of `k` faces.
#[derive(Clone, Copy)]
struct Layout {
    k: usize,
    edges: usize,
    quads: bool,
}

impl Layout {
    fn new(k: usize, closed: bool, quads: bool) -> Self {
        Self {
            k,
            edges: if closed { k } else { k + 1 },
            quads,
        }
    }
    fn len(self) -> usize {
        2 * self.edges + if self.quads { 4 * self.k } else { self.k }
    }
    fn end(self, i: usize) -> usize {
        i % self.edges
    }
    fn straight(self, i: usize) -> usize {
        let before = if self.quads { 0 } else { self.k };
        self.edges + before + i % self.edges
    }
    /// Triangles: beyond side `i`.
    fn side(self, i: usize) -> usize {
        self.edges + i % self.k
    }
    /// Quads: the opposite corner, next to edge i beyond it, next to edge i + 1, outermost.
    fn corner(self, kind: usize, i: usize) -> usize {
        2 * self.edges + kind * self.k + i % self.k
    }

    /// The place that mirrors place `p` of an open ring.
    fn mirror(self, p: usize) -> usize {
        let (k, e) = (self.k, self.edges);
        if p < e {
            return e - 1 - p;
        }
        if !self.quads {
            return if p < e + k {
                e + (k - 1 - (p - e))
            } else {
                e + k + (e - 1 - (p - e - k))
            };
        }
        if p < 2 * e {
            return e + (e - 1 - (p - e));
        }
        let (kind, i) = ((p - 2 * e) / k, (p - 2 * e) % k);
        let kind = [0, 2, 1, 3][kind];
        2 * e + kind * k + (k - 1 - i)
    }

    /// The mesh of two rings: places are vertices, the middle comes last.
    fn mesh(self, closed: bool) -> Topology {
        let x = self.len();
        let mut corners: Vec<usize> = Vec::new();
        for i in 0..self.k {
            let (a, b) = (self.end(i), self.end(i + 1));
            let (c, d) = (self.straight(i), self.straight(i + 1));
            if self.quads {
                let [m, near, far, outer] = [0, 1, 2, 3].map(|kind| self.corner(kind, i));
                corners.extend([x, a, m, b]);
                corners.extend([a, c, near, m]);
                corners.extend([m, near, outer, far]);
                corners.extend([b, m, far, d]);
            } else {
                let f = self.side(i);
                corners.extend([x, a, b]);
                corners.extend([a, f, b]);
                corners.extend([a, c, f]);
                corners.extend([b, f, d]);
            }
        }
        let sides = if self.quads { 4 } else { 3 };
        let offsets: Vec<u32> = (0..=corners.len() / sides)
            .map(|f| (sides * f) as u32)
            .collect();
        // Rows of an open ring end at its border, they do not turn into the rim.
        let sharp = |i: usize| crate::mesh::Corner {
            vertex: self.straight(i) as u32,
            sharpness: crate::scheme::INFINITE_SHARPNESS,
        };
        let rim = [sharp(0), sharp(self.k)];
        let options = ConnectOptions {
            boundary: Boundary::EdgeOnly,
            corners: if closed { &[] } else { &rim },
            ..ConnectOptions::default()
        };
        let corners = corners.into_iter().map(|v| v as u32).collect();
        connect(x + 1, &offsets, corners, &options).0
    }

    /// What `values` around a middle of 0 become one level on; each column is a case of its own.
    fn image(self, t: &Topology, closed: bool, values: &[Point]) -> Vec<Point> {
        let scheme = if self.quads {
            Scheme::Kobbelt
        } else {
            Scheme::Butterfly
        };
        let options = Options {
            scheme,
            ..Options::default()
        };
        let step = Step::new(t, &options);
        let masks = Masks::default();
        let mut points = values.to_vec();
        points.push([0.0; 3]);
        let sheets = Sheets::<f64, f64, 3>::of_points(&step, &masks, &points);
        // The first face is x, end 0, …
        let halves: Vec<u32> = sheets.around(0).collect();
        gather(t, &sheets, scheme, &halves, closed)
    }
}

/// Tangents of a vertex amid `n` quads. Of all vectors only those turn by one step per edge that have the frequency of tangents; six
/// patterns span them, so the map is six by six.
fn closed_quads(n: u32) -> [Vec<f64>; 2] {
    let layout = Layout::new(n as usize, true, true);
    let t = layout.mesh(true);
    let theta = 2.0 * PI / f64::from(n);
    // Wave of a pattern's place: amplitudes of cosine and sine about the middle of its place's direction.
    let place = |p: usize| -> (usize, f64) {
        let k = layout.k;
        match p {
            p if p < 2 * k => (p / k, (p % k) as f64 * theta),
            p => (p / k, ((p % k) as f64 + 0.5) * theta),
        }
    };
    // Kinds 0 and 1 are ends, 2 opposite corners, 3 and 4 the mirrored pair, 5 outermost. The pair makes patterns 3 (even) and 4 (odd).
    let pattern = |r: usize, p: usize| -> f64 {
        let (kind, angle) = place(p);
        match (r, kind) {
            (3, 3 | 4) => libm::cos(angle),
            (4, 3) => libm::sin(angle),
            (4, 4) => -libm::sin(angle),
            (r, kind) if r == kind && !matches!(r, 3 | 4) => libm::cos(angle),
            _ => 0.0,
        }
    };
    let places = 0..layout.len();
    let norm = |r: usize| -> f64 { places.clone().map(|p| pattern(r, p) * pattern(r, p)).sum() };
    let norms: Vec<f64> = (0..6).map(norm).collect();
    let mut map = vec![vec![0.0; 6]; 6];
    for first in [0, 3] {
        let values: Vec<Point> = places
            .clone()
            .map(|p| [0, 1, 2].map(|c| pattern(first + c, p)))
            .collect();
        let image = layout.image(&t, true, &values);
        for (r, row) in map.iter_mut().enumerate() {
            for c in 0..3 {
                let dot: f64 = places.clone().map(|p| pattern(r, p) * image[p][c]).sum();
                // A row of weights r goes to this much of row first + c.
                row[first + c] = dot / norms[first + c];
            }
        }
    }
    let mut weights = dominant_left(map);
    let sign = if weights[0] < 0.0 { -1.0 } else { 1.0 };
    weights.iter_mut().for_each(|w| *w *= sign);
    let along = |p: usize| (0..6).map(|r| weights[r] * pattern(r, p)).sum();
    // The same wave a quarter turn on.
    let turned = |p: usize| {
        let (kind, angle) = place(p);
        let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
        match kind {
            3 => weights[3] * sine - weights[4] * cosine,
            4 => weights[3] * sine + weights[4] * cosine,
            kind => weights[kind] * sine,
        }
    };
    [
        places.clone().map(along).collect(),
        places.map(turned).collect(),
    ]
}

/// The tangent into a smooth border of `k` faces: the slowest of what is the same on both sides of the middle.
fn across(k: u32, quads: bool) -> Vec<f64> {
    let layout = Layout::new(k as usize, false, quads);
    let t = layout.mesh(false);
    debug_assert_eq!(t.twin(0), NONE);
    let size = layout.len();
    let mut map = vec![vec![0.0; size]; size];
    for first in (0..size).step_by(3) {
        let unit = |p: usize| [0, 1, 2].map(|c| f64::from(u8::from(p == first + c)));
        let values: Vec<Point> = (0..size).map(unit).collect();
        let image = layout.image(&t, false, &values);
        for (row, point) in map.iter_mut().zip(image) {
            for (c, x) in point.into_iter().enumerate() {
                if let Some(cell) = row.get_mut(first + c) {
                    *cell = x;
                }
            }
        }
    }
    // Rows of weights that are even in the mirror, by one place of every pair.
    let leaders: Vec<usize> = (0..size).filter(|&p| p <= layout.mirror(p)).collect();
    let even: Vec<Vec<f64>> = leaders
        .iter()
        .map(|&r| {
            let partner = layout.mirror(r);
            let entry = |&c: &usize| map[r][c] + if partner == r { 0.0 } else { map[partner][c] };
            leaders.iter().map(entry).collect()
        })
        .collect();
    let weights = dominant_left(even);
    let mut mask = vec![0.0; size];
    for (&p, w) in leaders.iter().zip(weights) {
        mask[p] = w;
        mask[layout.mirror(p)] = w;
    }
    // It shall point into the surface: so it does where the ring lies flat, as regular as it goes, about the middle direction.
    let step = (if quads { PI / 2.0 } else { PI / 3.0 }).min(PI / f64::from(k));
    let inward = |turns: f64| libm::cos((turns - 0.5 * f64::from(k)) * step);
    let depth = |i: usize, u: f64, v: f64| u * inward(i as f64) + v * inward(i as f64 + 1.0);
    let mut height = 0.0;
    for i in 0..layout.edges {
        height += (mask[i] + 2.0 * mask[layout.straight(i)]) * inward(i as f64);
    }
    for i in 0..layout.k {
        if quads {
            for (kind, (u, v)) in [(1.0, 1.0), (2.0, 1.0), (1.0, 2.0), (2.0, 2.0)]
                .into_iter()
                .enumerate()
            {
                height += mask[layout.corner(kind, i)] * depth(i, u, v);
            }
        } else {
            height += mask[layout.side(i)] * depth(i, 1.0, 1.0);
        }
    }
    if height < 0.0 {
        mask.iter_mut().for_each(|w| *w = -*w);
    }
    mask
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weights times the map, against the eigenvalue times the weights.
    fn check(k: u32, closed: bool, quads: bool, mask: &[f64]) -> f64 {
        let layout = Layout::new(k as usize, closed, quads);
        let t = layout.mesh(closed);
        let size = layout.len();
        let mut image = vec![0.0; size];
        for first in (0..size).step_by(3) {
            let unit = |p: usize| [0, 1, 2].map(|c| f64::from(u8::from(p == first + c)));
            let values: Vec<Point> = (0..size).map(unit).collect();
            let new = layout.image(&t, closed, &values);
            for c in 0..3.min(size - first) {
                image[first + c] = mask.iter().zip(&new).map(|(w, p)| w * p[c]).sum();
            }
        }
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(x, y)| x * y).sum() };
        let lambda = dot(&image, mask) / dot(mask, mask);
        let scale = dot(mask, mask).sqrt();
        for (p, (got, w)) in image.iter().zip(mask).enumerate() {
            let error = (got - lambda * w).abs() / scale;
            assert!(
                error < 1e-10,
                "{k} faces, closed {closed}, quads {quads}, place {p}: {got} and {w}"
            );
        }
        lambda
    }

    #[test]
    fn closed_tangents_are_left_eigenvectors() {
        let known = [0.426, 0.5, 0.538, 0.560, 0.573, 0.582];
        for n in 3..=20 {
            for mask in closed_quads(n) {
                let lambda = check(n, true, true, &mask);
                if let Some(want) = known.get(n as usize - 3) {
                    assert!((lambda - want).abs() < 6e-4, "valence {n}: {lambda}");
                }
            }
            for mask in butterfly::tangents(n) {
                let lambda = check(n, true, false, &mask);
                assert!((lambda - 0.5).abs() < 1e-12, "valence {n}: {lambda}");
            }
        }
    }

    #[test]
    fn tangents_across_borders_are_left_eigenvectors() {
        for k in 1..=MOST_OPEN {
            let lambda = check(k, false, false, &across(k, false));
            if k == 3 {
                assert!((lambda - 0.5).abs() < 1e-12, "{lambda}");
            }
            let lambda = check(k, false, true, &across(k, true));
            if k == 2 {
                assert!((lambda - 0.5).abs() < 1e-12, "{lambda}");
            }
        }
    }
}
