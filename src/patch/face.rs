//! The patches of one face, ready to be diced.
//!
//! A face's grid is one square, or one or two triangles: `lower` where the row is at most the column, `upper` beyond the diagonal. Grids of
//! triangular faces have no upper half; there everything is folded onto the diagonal.

use super::bezier::{
    self, Cubic, Lanes, Quadratic, ROW, Row, Square, Vector, Weights, cubic_hull, quadratic_hull,
    square_hull,
};
use super::pn::PnCage;
use super::qas::{self, Samples};
use crate::dice::face::Part;
use crate::dispatch;
use crate::math;
use crate::records::{BLOCK_STRIDE, Grid3};
use crate::simd::Level;
use crate::topology::Topology;

/// A triangle of points.
#[derive(Clone, Copy, Debug)]
pub(super) enum Net {
    Quadratic(Quadratic),
    Cubic(Cubic),
}

/// Half of a grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Half {
    pub(super) points: Net,
    pub(super) normals: Quadratic,
    /// Barycentric coordinates at grid corner (0, 0), at (1, 0) (below the diagonal) or (0, 1) (above), and at (1, 1).
    pub(super) corners: [Weights; 3],
}

/// Vectors of a half in a list: its points, its normals, and barycentric coordinates of its corners.
pub(crate) const NET_LEN: u32 = 10 + 6 + 3;

/// What a grid is made of.
#[derive(Clone, Copy, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is one per thread, and its buffers are used again"
)]
pub(super) enum Shape {
    /// Points and normals.
    Square([Square; 2]),
    /// A triangular face.
    Triangle(Half),
    /// A quad of two triangles, below and above the diagonal.
    Halves([Half; 2]),
}

/// The patches of one face.
#[derive(Clone, Debug)]
pub(crate) struct FacePatches {
    shape: Shape,
    level: u32,
    /// Vector instructions; never changes a bit.
    pub(crate) simd: Level,
    /// What quadratic patches are fitted to.
    pub(crate) samples: Option<Samples>,
}

impl Default for FacePatches {
    fn default() -> Self {
        Self {
            shape: Shape::Square([[[[0.0; 3]; 3]; 3]; 2]),
            level: 0,
            simd: Level::SCALAR,
            samples: None,
        }
    }
}

/// Corners of a triangle in its own coordinates.
pub(super) const CORNERS: [Weights; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

impl FacePatches {
    /// Fits patches to the samples.
    pub(crate) fn fit(&mut self, triangular: bool, level: u32) {
        let Some(samples) = &self.samples else { return };
        let grids = [&*samples.points, &*samples.normals];
        self.level = level;
        self.shape = match triangular {
            true => {
                let [points, normals] = grids.map(qas::triangle);
                Shape::Triangle(Half {
                    points: Net::Quadratic(points),
                    normals,
                    corners: CORNERS,
                })
            }
            false => Shape::Square(grids.map(qas::square)),
        };
    }

    /// Takes face `q` of the mesh that is diced from a cage with PN triangles.
    pub(crate) fn take(
        &mut self,
        cage: &PnCage,
        t: &Topology,
        points: &[[f32; 3]],
        q: u32,
        split: bool,
        level: u32,
    ) {
        self.level = level;
        self.shape = cage.shape(t, points, q, split);
    }

    /// Appends what cubic halves are made of, [`NET_LEN`] vectors each. Others have none.
    #[cfg(feature = "gpu")]
    pub(crate) fn list_nets(&self, out: &mut Vec<[f32; 3]>) {
        let halves: &[Half] = match &self.shape {
            Shape::Square(_) => &[],
            Shape::Triangle(half) => std::slice::from_ref(half),
            Shape::Halves(halves) => halves,
        };
        for half in halves {
            if let Net::Cubic(points) = &half.points {
                out.extend(points.iter().chain(&half.normals).chain(&half.corners));
            }
        }
    }

    /// Dices block (`bu`, `bv`) of the level that was prepared.
    pub(crate) fn dice(&self, bu: u32, bv: u32, points: &mut Grid3, normals: Option<&mut Grid3>) {
        self.dice_part(Part::block(self.level, [bu, bv]), points, normals);
    }

    /// Dices a part, of any level.
    pub(crate) fn dice_part(&self, part: Part, points: &mut Grid3, normals: Option<&mut Grid3>) {
        dispatch!(self.simd, dice(&self.shape, part, points, normals));
    }

    /// Point and unit normal at (`u`, `v`), with the bits that every grid gives them.
    pub(crate) fn at(&self, u: f32, v: f32) -> (Vector, Vector) {
        at(&self.shape, u, v)
    }

    /// Samples of side `c` at the level that was prepared, in the face's direction, ends included.
    pub(crate) fn side(&self, c: usize, points: &mut Vec<Vector>, normals: &mut Vec<Vector>) {
        points.clear();
        normals.clear();
        let n = 1_u32 << self.level;
        let scale = 1.0 / n as f32;
        for k in 0..=n {
            let (t, back) = (k as f32 * scale, (n - k) as f32 * scale);
            let [u, v] = match (&self.shape, c) {
                (_, 0) => [t, 0.0],
                (_, 1) => [1.0, t],
                (Shape::Triangle(_), _) => [back, back],
                (_, 2) => [back, 1.0],
                _ => [0.0, back],
            };
            let (p, n) = self.at(u, v);
            points.push(p);
            normals.push(n);
        }
    }

    /// Points whose convex hull holds the whole face, but for rounding.
    pub(crate) fn hull(&self, mut out: impl FnMut(Vector)) {
        let half = |half: &Half, out: &mut dyn FnMut(Vector)| match &half.points {
            Net::Quadratic(net) => net.iter().for_each(|&p| out(p)),
            Net::Cubic(net) => net.iter().for_each(|&p| out(p)),
        };
        match &self.shape {
            Shape::Square([points, _]) => points.iter().flatten().for_each(|&p| out(p)),
            Shape::Triangle(lower) => half(lower, &mut out),
            Shape::Halves(halves) => halves.iter().for_each(|h| half(h, &mut out)),
        }
    }

    /// The same for one block of the level that was prepared.
    pub(crate) fn block_hull(&self, bu: u32, bv: u32, out: impl FnMut(Vector)) {
        self.part_hull(Part::block(self.level, [bu, bv]), out);
    }

    /// The same for a part.
    pub(crate) fn part_hull(&self, part: Part, mut out: impl FnMut(Vector)) {
        let scale = 1.0 / (1_u32 << part.level) as f32;
        let low = part.start.map(|k| k as f32 * scale);
        let high = part.start.map(|k| (k + part.segments) as f32 * scale);
        if part.segments == 0 {
            return out(self.at(low[0], low[1]).0);
        }
        let (below, above) = match &self.shape {
            Shape::Square([points, _]) => return square_hull(points, low, high, &mut out),
            Shape::Triangle(lower) => (lower, None),
            Shape::Halves([lower, upper]) => (lower, Some(upper)),
        };
        let [a, b, c, d] = [low, [high[0], low[1]], high, [low[0], high[1]]];
        // A square of the grid lies on one side of the diagonal, or on it from corner to corner.
        let on = low[0] == low[1] && high[0] == high[1];
        if high[1] <= low[0] {
            below.hull(false, [[a, b, c], [a, c, d]], &mut out);
        } else if on {
            below.hull(false, [[a, b, c]], &mut out);
            if let Some(above) = above {
                above.hull(true, [[a, c, d]], &mut out);
            }
        } else if let (Some(above), true) = (above, high[0] <= low[1]) {
            above.hull(true, [[a, b, c], [a, c, d]], &mut out);
        } else {
            self.hull(out);
        }
    }
}

impl Half {
    /// Barycentric coordinates of `n` places of this half.
    #[inline(always)]
    fn places(&self, upper: bool, u: &[f32], v: &[f32]) -> [Lanes; 3] {
        let mut out = [[0.0; ROW]; 3];
        let n = u.len().min(v.len()).min(ROW);
        let (u, v) = (&u[..n], &v[..n]);
        let (far, near) = if upper { (v, u) } else { (u, v) };
        for k in 0..3 {
            let [a, b, c] = self.corners.map(|w| w[k]);
            for i in 0..n {
                // Where sides of two halves meet, one of the three weights is zero in both, and the others are the same.
                out[k][i] = a * (1.0 - far[i]) + (b * (far[i] - near[i]) + c * near[i]);
            }
        }
        out
    }

    /// Points, and unit normals if wanted, at places of this half.
    #[inline(always)]
    fn row(
        &self,
        upper: bool,
        u: &[f32],
        v: &[f32],
        points: &mut Row<'_>,
        normals: Option<&mut Row<'_>>,
    ) {
        let w = self.places(upper, u, v);
        match &self.points {
            Net::Quadratic(net) => bezier::quadratic(net, &w, points),
            Net::Cubic(net) => bezier::cubic(net, &w, points),
        }
        if let Some(normals) = normals {
            bezier::quadratic(&self.normals, &w, normals);
            let [a, b, c, ..] = self.normals;
            bezier::normalize(normals, |i| {
                let at = |k: usize| (a[k] * w[0][i] + b[k] * w[1][i]) + c[k] * w[2][i];
                [at(0), at(1), at(2)]
            });
        }
    }

    fn hull<const N: usize>(
        &self,
        upper: bool,
        triangles: [[[f32; 2]; 3]; N],
        out: &mut impl FnMut(Vector),
    ) {
        for triangle in triangles {
            let at = triangle.map(|[u, v]| {
                let w = self.places(upper, &[u], &[v]);
                [0, 1, 2].map(|k| w[k][0])
            });
            match &self.points {
                Net::Quadratic(net) => quadratic_hull(net, at, out),
                Net::Cubic(net) => cubic_hull(net, at, out),
            }
        }
    }
}

/// Lanes `from..to` of row `j` of a grid.
#[inline(always)]
fn row(grid: &mut Grid3, j: usize, from: usize, to: usize) -> Row<'_> {
    let lanes = j * BLOCK_STRIDE + from..j * BLOCK_STRIDE + to;
    let Grid3 { x, y, z } = grid;
    Row([&mut x[lanes.clone()], &mut y[lanes.clone()], &mut z[lanes]])
}

/// One row of a square: places `u`, whose weights are `w`, all at `v`.
#[inline(always)]
fn square_row(
    [points, normals]: &[Square; 2],
    u: &[f32],
    w: &[Lanes; 3],
    v: f32,
    to: &mut Row<'_>,
    unit: Option<&mut Row<'_>>,
) {
    bezier::square(points, w, v, to);
    if let Some(unit) = unit {
        bezier::square(normals, w, v, unit);
        let corner = |i: usize, j: usize| normals[2 * i][2 * j];
        bezier::normalize(unit, |i| {
            let (s, t) = (1.0 - u[i], 1.0 - v);
            let at = |p: Vector, w: f32| math::scale(p, w);
            let first = math::add(at(corner(0, 0), s * t), at(corner(1, 0), u[i] * t));
            let second = math::add(at(corner(0, 1), s * v), at(corner(1, 1), u[i] * v));
            math::add(first, second)
        });
    }
}

#[inline(always)]
fn dice(shape: &Shape, part: Part, points: &mut Grid3, mut normals: Option<&mut Grid3>) {
    let scale = 1.0 / (1_u32 << part.level) as f32;
    let [x, y] = part.start.map(|k| k as usize);
    let n = part.segments as usize + 1;
    // Few odd lanes: rows are long enough for what is too much.
    let padded = |n: usize| if n == 1 { 1 } else { n.next_multiple_of(8) };
    let u: Lanes = std::array::from_fn(|i| (x + i) as f32 * scale);
    let w = match shape {
        Shape::Square(_) => bezier::curves(&u),
        _ => [[0.0; ROW]; 3],
    };
    for j in 0..n {
        let v = (y + j) as f32 * scale;
        // Columns before this one lie above the diagonal.
        let diagonal = (y + j).saturating_sub(x).min(n);
        let mut ranges = [(0, padded(n)); 2];
        if let Shape::Halves(_) = shape {
            ranges = [
                (diagonal, diagonal + padded(n - diagonal)),
                (0, padded(diagonal)),
            ];
        }
        for (k, (from, to)) in ranges.into_iter().enumerate().rev() {
            let mut own = row(points, j, from, to);
            let mut unit = normals.as_deref_mut().map(|g| row(g, j, from, to));
            let unit = unit.as_mut();
            match shape {
                Shape::Square(square) if k == 0 => square_row(square, &u, &w, v, &mut own, unit),
                Shape::Triangle(half) if k == 0 => {
                    let folded = u.map(|u| if u > v { u } else { v });
                    half.row(false, &folded[..to], &[v; ROW], &mut own, unit);
                }
                Shape::Halves(halves) if from < to => {
                    halves[k].row(k == 1, &u[from..to], &[v; ROW], &mut own, unit);
                }
                _ => {}
            }
        }
    }
}

fn at(shape: &Shape, u: f32, v: f32) -> (Vector, Vector) {
    let (mut p, mut n) = ([[0.0; 1]; 3], [[0.0; 1]; 3]);
    let mut own = Row(p.each_mut().map(|c| &mut c[..]));
    let mut unit = Row(n.each_mut().map(|c| &mut c[..]));
    match shape {
        Shape::Square(square) => square_row(
            square,
            &[u],
            &bezier::curves(&[u]),
            v,
            &mut own,
            Some(&mut unit),
        ),
        Shape::Triangle(half) => {
            let u = if u > v { u } else { v };
            half.row(false, &[u], &[v], &mut own, Some(&mut unit));
        }
        Shape::Halves(halves) => {
            let k = usize::from(v > u);
            halves[k].row(k == 1, &[u], &[v], &mut own, Some(&mut unit));
        }
    }
    (p.map(|[c]| c), n.map(|[c]| c))
}
