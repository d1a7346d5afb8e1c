//! Bézier patches over triangles and squares: rows of points and unit normals, and hulls of parts.
//!
//! Control points of triangles stand in this order: the three corners; between corners 0 and 1, 1 and 2, 2 and 0, one (quadratic) or two
//! (cubic), in the direction of the side; the middle of a cubic.

use crate::math;

/// A point or a normal.
pub(super) type Vector = [f32; 3];
/// Barycentric coordinates.
pub(super) type Weights = [f32; 3];

/// Control points of a quadratic triangle.
pub(super) type Quadratic = [Vector; 6];
/// Control points of a cubic triangle.
pub(super) type Cubic = [Vector; 10];
/// Control points of a biquadratic square: column (along u), row.
pub(super) type Square = [[Vector; 3]; 3];

/// Most lanes of a row: the points of a block's row, and what the last vector overruns.
pub(super) const ROW: usize = 48;
/// A number per lane.
pub(super) type Lanes = [f32; ROW];

/// Three components of one row of a grid.
pub(super) struct Row<'a>(pub(super) [&'a mut [f32]; 3]);

impl Row<'_> {
    fn get(&self, i: usize) -> Vector {
        [0, 1, 2].map(|k| self.0[k][i])
    }
    fn set(&mut self, i: usize, v: Vector) {
        (0..3).for_each(|k| self.0[k][i] = v[k]);
    }
}

/// Products of barycentric coordinates, in the order of control points.
#[inline(always)]
fn weights2(w: &[Lanes; 3], n: usize) -> [Lanes; 6] {
    let mut out = [[0.0; ROW]; 6];
    for k in 0..3 {
        let (a, b) = (&w[k][..n], &w[(k + 1) % 3][..n]);
        for i in 0..n {
            out[k][i] = a[i] * a[i];
            out[3 + k][i] = 2.0 * (a[i] * b[i]);
        }
    }
    out
}

/// The same of third degree.
#[inline(always)]
fn weights3(w: &[Lanes; 3], n: usize) -> [Lanes; 10] {
    let mut out = [[0.0; ROW]; 10];
    for k in 0..3 {
        let (a, b) = (&w[k][..n], &w[(k + 1) % 3][..n]);
        for i in 0..n {
            let (aa, bb) = (a[i] * a[i], b[i] * b[i]);
            out[k][i] = aa * a[i];
            out[3 + 2 * k][i] = 3.0 * (aa * b[i]);
            out[4 + 2 * k][i] = 3.0 * (bb * a[i]);
        }
    }
    for i in 0..n {
        out[9][i] = 6.0 * ((w[0][i] * w[1][i]) * w[2][i]);
    }
    out
}

/// Points of a quadratic at `out.len()` places.
#[inline(always)]
pub(super) fn quadratic(net: &Quadratic, w: &[Lanes; 3], out: &mut Row<'_>) {
    let n = out.0[0].len().min(ROW);
    let w = weights2(w, n);
    for k in 0..3 {
        let p = net.map(|p| p[k]);
        let out = &mut out.0[k][..n];
        for i in 0..n {
            let corners = (p[0] * w[0][i] + p[1] * w[1][i]) + p[2] * w[2][i];
            out[i] = corners + ((p[3] * w[3][i] + p[4] * w[4][i]) + p[5] * w[5][i]);
        }
    }
}

/// Points of a cubic at `out.len()` places.
#[inline(always)]
pub(super) fn cubic(net: &Cubic, w: &[Lanes; 3], out: &mut Row<'_>) {
    let n = out.0[0].len().min(ROW);
    let w = weights3(w, n);
    for k in 0..3 {
        let p = net.map(|p| p[k]);
        let out = &mut out.0[k][..n];
        for i in 0..n {
            let corners = (p[0] * w[0][i] + p[1] * w[1][i]) + p[2] * w[2][i];
            // Pairs first: they are the same from either end of their side.
            let sides = ((p[3] * w[3][i] + p[4] * w[4][i]) + (p[5] * w[5][i] + p[6] * w[6][i]))
                + (p[7] * w[7][i] + p[8] * w[8][i]);
            out[i] = (corners + sides) + p[9] * w[9][i];
        }
    }
}

/// Weights of a quadratic curve: of its ends, and of what is between.
#[inline(always)]
fn curve(t: f32) -> [f32; 3] {
    let s = 1.0 - t;
    [s * s, 2.0 * (s * t), t * t]
}

/// [`curve`] at every lane.
#[inline(always)]
pub(super) fn curves(u: &[f32]) -> [Lanes; 3] {
    let mut out = [[0.0; ROW]; 3];
    let n = u.len().min(ROW);
    for i in 0..n {
        let [a, b, c] = curve(u[i]);
        (out[0][i], out[1][i], out[2][i]) = (a, b, c);
    }
    out
}

/// One row of a square: places along u with weights `w`, all at `v`.
#[inline(always)]
pub(super) fn square(net: &Square, w: &[Lanes; 3], v: f32, out: &mut Row<'_>) {
    let n = out.0[0].len().min(ROW);
    let b = curve(v);
    for k in 0..3 {
        let c = net.map(|p| (p[0][k] * b[0] + p[2][k] * b[2]) + p[1][k] * b[1]);
        let out = &mut out.0[k][..n];
        for i in 0..n {
            out[i] = (c[0] * w[0][i] + c[2] * w[2][i]) + c[1] * w[1][i];
        }
    }
}

/// Shortest blend of unit normals that tells a direction, squared.
const SHORT: f32 = 1e-12;

/// Brings a row to length 1. What is too short gets `spare` of its lane.
#[inline(always)]
pub(super) fn normalize(row: &mut Row<'_>, spare: impl Fn(usize) -> Vector) {
    let [x, y, z] = &mut row.0;
    let n = x.len().min(ROW);
    let (x, y, z) = (&mut x[..n], &mut y[..n], &mut z[..n]);
    let mut short = 0_u32;
    for i in 0..n {
        let d = (x[i] * x[i] + y[i] * y[i]) + z[i] * z[i];
        let ok = (d > SHORT) & (d < f32::INFINITY);
        let s = if ok { 1.0 / d.sqrt() } else { 0.0 };
        short += u32::from(!ok);
        x[i] *= s;
        y[i] *= s;
        z[i] *= s;
    }
    if short > 0 {
        for i in 0..n {
            let v = row.get(i);
            // Not a number where the blend was not finite.
            if v.iter().all(|&c| c == 0.0 || c.is_nan()) {
                row.set(i, math::normalize(spare(i)).unwrap_or([0.0, 0.0, 1.0]));
            }
        }
    }
}

fn mix(p: [Vector; 3], w: Weights) -> Vector {
    [0, 1, 2].map(|k| (p[0][k] * w[0] + p[1][k] * w[1]) + p[2][k] * w[2])
}

/// The polar form of a quadratic.
fn polar2(q: &Quadratic, [x, y]: [Weights; 2]) -> Vector {
    let once = [
        mix([q[0], q[3], q[5]], x),
        mix([q[3], q[1], q[4]], x),
        mix([q[5], q[4], q[2]], x),
    ];
    mix(once, y)
}

/// The polar form of a cubic.
fn polar3(b: &Cubic, [x, y, z]: [Weights; 3]) -> Vector {
    let once = [
        mix([b[0], b[3], b[8]], x),
        mix([b[4], b[1], b[5]], x),
        mix([b[7], b[6], b[2]], x),
        mix([b[3], b[4], b[9]], x),
        mix([b[9], b[5], b[6]], x),
        mix([b[8], b[9], b[7]], x),
    ];
    polar2(&once, [y, z])
}

/// Control points of the piece of a quadratic over the triangle of three places.
pub(super) fn quadratic_hull(net: &Quadratic, at: [Weights; 3], out: &mut impl FnMut(Vector)) {
    for k in 0..3 {
        out(polar2(net, [at[k]; 2]));
        out(polar2(net, [at[k], at[(k + 1) % 3]]));
    }
}

/// The same of a cubic.
pub(super) fn cubic_hull(net: &Cubic, at: [Weights; 3], out: &mut impl FnMut(Vector)) {
    for k in 0..3 {
        let (a, b) = (at[k], at[(k + 1) % 3]);
        out(polar3(net, [a; 3]));
        out(polar3(net, [a, a, b]));
        out(polar3(net, [a, b, b]));
    }
    out(polar3(net, at));
}

/// The same of a square, over a rectangle.
pub(super) fn square_hull(
    net: &Square,
    low: [f32; 2],
    high: [f32; 2],
    out: &mut impl FnMut(Vector),
) {
    let polar = |p: [Vector; 3], [s, t]: [f32; 2]| {
        let on = |a: Vector, b: Vector, t: f32| [0, 1, 2].map(|k| a[k] * (1.0 - t) + b[k] * t);
        on(on(p[0], p[1], s), on(p[1], p[2], s), t)
    };
    let pairs = |k: usize| [[low[k]; 2], [low[k], high[k]], [high[k]; 2]];
    for v in pairs(1) {
        let row = net.map(|column| polar(column, v));
        pairs(0).iter().for_each(|&u| out(polar(row, u)));
    }
}
