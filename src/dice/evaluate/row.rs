//! Rows of a grid: many parameters on one line of constant v.
//!
//! On a regular quad a row is one curve, evaluated component by component with lanes along u. Elsewhere it runs through several pieces: long
//! ones are done the same way, of those with a point or two every point has its components in the lanes. Both do the sums of
//! [`Patch::jet`](super::spline::Patch::jet) in the same order, so a grid gives the bits of single parameters at every level of vector
//! instructions.

use super::Spot;
use super::spline::{Curve, F4, Jet};
use crate::dispatch;
use crate::simd::Level;
use std::ops::Range;

/// Position, du, dv, duu, duv, dvv, of three components each.
const LINES: usize = 18;

/// What a row needs to know of one of its parameters.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Column {
    pub(super) u: f32,
    /// The half in which `u` lies, and the distance from its end.
    pub(super) far: bool,
    pub(super) from: f32,
    /// Depth of pieces around an irregular corner, as far as `u` tells it.
    pub(super) depth: u32,
}

impl Column {
    pub(super) fn new(u: f32) -> Self {
        let far = u >= 0.5;
        let from = (f32::from(u8::from(far)) - u).abs();
        Self {
            u,
            far,
            from,
            depth: Spot::depth(from),
        }
    }
}

/// Lanes that are evaluated past the end of a piece, into places of the next or none.
const PAD: usize = 8;

/// Fewest places on a piece for which lanes along u pay.
const FEW: usize = 3;

/// Position and derivatives along a row; what was not asked for is not written.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    simd: Level,
    n: u32,
    pub(super) columns: Vec<Column>,
    /// Parameters on their pieces.
    u: Vec<f32>,
    /// A line for each component of position, du, dv, duu, duv, dvv; each [`PAD`] longer than the row.
    lines: Vec<f32>,
    /// Places that are irregular corners: at most two.
    corners: [Option<(usize, usize)>; 2],
}

impl Row {
    /// Rows of a quad's grid of `n` segments.
    pub(crate) fn new(n: u32) -> Self {
        Self::of_columns((0..=n).map(|i| i as f32 / n as f32), Level::detect())
    }

    /// Rows of any places along u, in ascending order; at least one.
    pub(crate) fn of_columns(u: impl Iterator<Item = f32>, simd: Level) -> Self {
        let columns: Vec<Column> = u.map(Column::new).collect();
        let padded = columns.len() + PAD;
        Self {
            simd,
            n: (columns.len() as u32).saturating_sub(1),
            columns,
            u: vec![0.0; padded],
            lines: vec![0.0; LINES * padded],
            corners: [None; 2],
        }
    }

    /// Segments of the grid.
    pub(crate) fn segments(&self) -> u32 {
        self.n
    }

    /// The whole row lies on one curve.
    pub(super) fn fill<const ORDER: u32>(&mut self, curve: &Curve) {
        self.corners = [None; 2];
        let length = self.columns.len();
        for (u, column) in self.u.iter_mut().zip(&self.columns) {
            *u = column.u;
        }
        let part = 0..length;
        dispatch!(
            self.simd,
            lanes::<ORDER, false>(curve, 1.0, &self.u, part, &mut self.lines)
        );
    }

    /// Begins a row of several pieces, which are to be put from left to right.
    pub(super) fn begin(&mut self) {
        self.corners = [None; 2];
    }

    /// Puts the places `columns`, which lie on `curve` with the place `spot`.
    pub(super) fn put<const ORDER: u32>(
        &mut self,
        curve: &Curve,
        spot: &Spot,
        columns: Range<usize>,
    ) {
        if columns.len() < FEW {
            for i in columns {
                let jet = curve.at::<ORDER>(spot.along(&self.columns[i]));
                self.set::<ORDER>(i, jet.scaled::<ORDER>(spot.scale));
            }
            return;
        }
        for i in columns.clone() {
            self.u[i] = spot.along(&self.columns[i]);
        }
        dispatch!(
            self.simd,
            lanes::<ORDER, true>(curve, spot.scale, &self.u, columns, &mut self.lines)
        );
    }

    /// Puts irregular corner `c` of the quad at place `i`.
    pub(super) fn put_corner<const ORDER: u32>(&mut self, i: usize, jet: Jet, c: usize) {
        let free = usize::from(self.corners[0].is_some());
        self.corners[free] = Some((i, c));
        self.set::<ORDER>(i, jet);
    }

    #[inline(always)]
    fn set<const ORDER: u32>(&mut self, i: usize, jet: Jet) {
        let parts = [jet.position, jet.du, jet.dv, jet.duu, jet.duv, jet.dvv];
        let wanted = [1, 3, 6][ORDER as usize];
        let lines = self.lines.chunks_exact_mut(self.columns.len() + PAD);
        for (k, line) in lines.enumerate().take(3 * wanted) {
            line[i] = parts[k / 3].0[k % 3];
        }
    }

    /// The corner that place `i` is, if it is an irregular one.
    pub(crate) fn corner(&self, i: usize) -> Option<usize> {
        let found = self.corners.iter().flatten().find(|c| c.0 == i);
        found.map(|c| c.1)
    }

    /// Writes what `to` makes of position, du and dv.
    #[inline(always)]
    pub(crate) fn tangents<S>(&self, out: &mut [S], to: impl Fn([[f32; 3]; 3]) -> S) {
        let n = out.len().min(self.columns.len());
        let l = self.lines().map(|line| &line[..n]);
        for (i, out) in out[..n].iter_mut().enumerate() {
            *out = to([0, 3, 6].map(|k| [l[k][i], l[k + 1][i], l[k + 2][i]]));
        }
    }

    /// Component `c` of derivative `k` along the row: du, dv, duu, duv, dvv.
    pub(crate) fn derivative(&self, k: usize, c: usize) -> &[f32] {
        let n = self.columns.len();
        &self.lines[(3 * (k + 1) + c) * (n + PAD)..][..n]
    }

    /// All of it at place `i`.
    pub(crate) fn jet(&self, i: usize) -> Jet {
        let l = self.lines();
        let part = |k: usize| F4::new([l[k][i], l[k + 1][i], l[k + 2][i], 0.0]);
        Jet {
            position: part(0),
            du: part(3),
            dv: part(6),
            duu: part(9),
            duv: part(12),
            dvv: part(15),
        }
    }

    #[inline(always)]
    fn lines(&self) -> [&[f32]; LINES] {
        let n = self.columns.len() + PAD;
        let mut lines = [&self.lines[..0]; LINES];
        for (k, line) in lines.iter_mut().enumerate() {
            *line = &self.lines[k * n..(k + 1) * n];
        }
        lines
    }
}

/// The places `part` of a line for each component of position and derivatives, by a parameter `scale` times as fast. Written out: closures
/// would be compiled without the level's instructions.
#[inline(always)]
fn lanes<const ORDER: u32, const SCALED: bool>(
    curve: &Curve,
    scale: f32,
    u: &[f32],
    part: Range<usize>,
    lines: &mut [f32],
) {
    // In whole vectors: what is beyond the part is written over by the next, or stands beyond the row.
    let whole = part.start..part.start + part.len().next_multiple_of(PAD);
    let mut lines = lines.chunks_exact_mut(u.len());
    let u = &u[whole.clone()];
    let n = u.len();
    let square = scale * scale;
    let mut parts = [[0.0; 4]; 3];
    for k in 0..3 {
        let (value, Some(out)) = (component(&curve.value, k), lines.next()) else {
            return;
        };
        parts[k] = value;
        let (origin, out) = (curve.origin.0[k], &mut out[whole.clone()]);
        for i in 0..n {
            out[i] = origin + cubic(value, u[i]);
        }
    }
    if ORDER == 0 {
        return;
    }
    for value in parts {
        let Some(out) = lines.next() else { return };
        let out = &mut out[whole.clone()];
        for i in 0..n {
            out[i] = times::<SCALED>(first(value, u[i]), scale);
        }
    }
    for k in 0..3 {
        let (slope, Some(out)) = (component(&curve.slope, k), lines.next()) else {
            return;
        };
        let out = &mut out[whole.clone()];
        for i in 0..n {
            out[i] = times::<SCALED>(cubic(slope, u[i]), scale);
        }
    }
    if ORDER == 1 {
        return;
    }
    for value in parts {
        let Some(out) = lines.next() else { return };
        let out = &mut out[whole.clone()];
        for i in 0..n {
            let half = half_second(value, u[i]);
            out[i] = times::<SCALED>(half + half, square);
        }
    }
    for k in 0..3 {
        let (slope, Some(out)) = (component(&curve.slope, k), lines.next()) else {
            return;
        };
        let out = &mut out[whole.clone()];
        for i in 0..n {
            out[i] = times::<SCALED>(first(slope, u[i]), square);
        }
    }
    for k in 0..3 {
        let (bend, Some(out)) = (component(&curve.bend, k), lines.next()) else {
            return;
        };
        let out = &mut out[whole.clone()];
        for i in 0..n {
            let half = cubic(bend, u[i]);
            out[i] = times::<SCALED>(half + half, square);
        }
    }
}

#[inline(always)]
fn times<const SCALED: bool>(x: f32, scale: f32) -> f32 {
    if SCALED { x * scale } else { x }
}

#[inline(always)]
fn component(c: &[F4; 4], k: usize) -> [f32; 4] {
    [c[0].0[k], c[1].0[k], c[2].0[k], c[3].0[k]]
}

/// By Horner's rule, as [`Curve`] does it.
#[inline(always)]
fn cubic(c: [f32; 4], t: f32) -> f32 {
    ((c[3] * t + c[2]) * t + c[1]) * t + c[0]
}

#[inline(always)]
fn first(c: [f32; 4], t: f32) -> f32 {
    let p = c[3] * t + c[2];
    (c[3] * t + p) * t + (p * t + c[1])
}

#[inline(always)]
fn half_second(c: [f32; 4], t: f32) -> f32 {
    let p = c[3] * t + c[2];
    c[3] * t + (c[3] * t + p)
}
