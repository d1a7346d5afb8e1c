//! Rows of a grid: many parameters on one line of constant v.
//!
//! On a regular quad a row is one curve, evaluated component by component with lanes along u. Elsewhere it runs through several pieces, some
//! with a point or two, and every point has its components in the lanes. Both do the sums of
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

/// Position and derivatives along a row; what was not asked for is not written.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    simd: Level,
    pub(super) columns: Vec<Column>,
    u: Vec<f32>,
    /// Of a regular quad: line after line, each as long as the row.
    lines: Vec<f32>,
    /// Of any other: place after place.
    jets: Vec<[F4; 6]>,
    /// Places that are irregular corners: at most two.
    corners: [Option<(usize, usize)>; 2],
}

impl Row {
    /// Rows of a quad's grid of `n` segments.
    pub(crate) fn new(n: u32) -> Self {
        Self::of_columns((0..=n).map(|i| i as f32 / n as f32), Level::detect())
    }

    /// Rows of any places along u, in ascending order.
    pub(crate) fn of_columns(u: impl Iterator<Item = f32>, simd: Level) -> Self {
        Self {
            simd,
            columns: u.map(Column::new).collect(),
            u: Vec::new(),
            lines: Vec::new(),
            jets: Vec::new(),
            corners: [None; 2],
        }
    }

    fn length(&self) -> usize {
        self.columns.len()
    }

    /// The whole row lies on one curve.
    pub(super) fn fill<const ORDER: u32>(&mut self, curve: &Curve) {
        if self.u.len() != self.length() {
            self.u.clear();
            self.u.extend(self.columns.iter().map(|c| c.u));
            self.lines.resize(LINES * self.length(), 0.0);
        }
        dispatch!(self.simd, lanes::<ORDER>(curve, &self.u, &mut self.lines));
    }

    /// Begins a row of several pieces.
    pub(super) fn begin(&mut self) {
        self.jets.clear();
        self.corners = [None; 2];
    }

    /// Appends the places `columns`, which lie on `curve` with the place `spot`.
    pub(super) fn append<const ORDER: u32>(
        &mut self,
        curve: &Curve,
        spot: &Spot,
        columns: Range<usize>,
    ) {
        let start = self.jets.len();
        self.jets.resize(start + columns.len(), [F4::splat(0.0); 6]);
        run::<ORDER>(curve, spot, &self.columns[columns], &mut self.jets[start..]);
    }

    /// Appends irregular corner `c` of the quad.
    pub(super) fn append_corner(&mut self, jet: Jet, c: usize) {
        let free = usize::from(self.corners[0].is_some());
        self.corners[free] = Some((self.jets.len(), c));
        self.jets.push(parts(jet));
    }

    /// The corner that place `i` is, if it is an irregular one.
    pub(crate) fn corner(&self, i: usize) -> Option<usize> {
        let found = self.corners.iter().flatten().find(|c| c.0 == i);
        found.map(|c| c.1)
    }

    /// Writes what `to` makes of position, du and dv.
    #[inline(always)]
    pub(crate) fn tangents<S>(&self, out: &mut [S], to: impl Fn([[f32; 3]; 3]) -> S) {
        if !self.jets.is_empty() {
            for (jet, out) in self.jets.iter().zip(out) {
                *out = to([jet[0].xyz(), jet[1].xyz(), jet[2].xyz()]);
            }
            return;
        }
        let n = out.len().min(self.length());
        let l = self.lines().map(|line| &line[..n]);
        for (i, out) in out[..n].iter_mut().enumerate() {
            *out = to([0, 3, 6].map(|k| [l[k][i], l[k + 1][i], l[k + 2][i]]));
        }
    }

    /// All of it at place `i`.
    pub(crate) fn jet(&self, i: usize) -> Jet {
        let parts = if self.jets.is_empty() {
            let l = self.lines();
            [0, 3, 6, 9, 12, 15].map(|k| F4::new([l[k][i], l[k + 1][i], l[k + 2][i], 0.0]))
        } else {
            self.jets[i]
        };
        let [position, du, dv, duu, duv, dvv] = parts;
        Jet {
            position,
            du,
            dv,
            duu,
            duv,
            dvv,
        }
    }

    #[inline(always)]
    fn lines(&self) -> [&[f32]; LINES] {
        let n = self.length();
        let mut lines = [&self.lines[..0]; LINES];
        for (k, line) in lines.iter_mut().enumerate() {
            *line = &self.lines[k * n..(k + 1) * n];
        }
        lines
    }
}

#[inline(always)]
fn parts(jet: Jet) -> [F4; 6] {
    [jet.position, jet.du, jet.dv, jet.duu, jet.duv, jet.dvv]
}

/// Points one by one, all four lanes of them stored: otherwise the compiler does them number by number.
#[inline(never)]
fn run<const ORDER: u32>(curve: &Curve, spot: &Spot, columns: &[Column], out: &mut [[F4; 6]]) {
    for (column, out) in columns.iter().zip(out) {
        let jet = curve.at::<ORDER>(spot.along(column));
        let jet = jet.scaled::<ORDER>(spot.scale);
        (out[0], out[1], out[2]) = (jet.position, jet.du, jet.dv);
        if ORDER > 1 {
            (out[3], out[4], out[5]) = (jet.duu, jet.duv, jet.dvv);
        }
    }
}

/// A line for each component of position and derivatives. Written out: closures would be compiled without the level's instructions.
#[inline(always)]
fn lanes<const ORDER: u32>(curve: &Curve, u: &[f32], lines: &mut [f32]) {
    let n = u.len();
    let mut lines = lines.chunks_exact_mut(n);
    let mut parts = [[0.0; 4]; 3];
    for k in 0..3 {
        let (value, Some(out)) = (component(&curve.value, k), lines.next()) else {
            return;
        };
        parts[k] = value;
        let origin = curve.origin.0[k];
        for i in 0..n {
            out[i] = origin + cubic(value, u[i]);
        }
    }
    if ORDER == 0 {
        return;
    }
    for value in parts {
        let Some(out) = lines.next() else { return };
        for i in 0..n {
            out[i] = first(value, u[i]);
        }
    }
    for k in 0..3 {
        let (slope, Some(out)) = (component(&curve.slope, k), lines.next()) else {
            return;
        };
        for i in 0..n {
            out[i] = cubic(slope, u[i]);
        }
    }
    if ORDER == 1 {
        return;
    }
    for value in parts {
        let Some(out) = lines.next() else { return };
        for i in 0..n {
            let half = half_second(value, u[i]);
            out[i] = half + half;
        }
    }
    for k in 0..3 {
        let (slope, Some(out)) = (component(&curve.slope, k), lines.next()) else {
            return;
        };
        for i in 0..n {
            out[i] = first(slope, u[i]);
        }
    }
    for k in 0..3 {
        let (bend, Some(out)) = (component(&curve.bend, k), lines.next()) else {
            return;
        };
        for i in 0..n {
            let half = cubic(bend, u[i]);
            out[i] = half + half;
        }
    }
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
