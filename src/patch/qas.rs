//! QAS: quadratic patches through points and unit normals of the limit surface.
//!
//! After one step of subdivision every vertex is projected on the limit surface: what dicing at level 1 gives, by its own rules for edges,
//! creases and corners. A quadratic through the two ends of an edge and its middle is `(4 m − (a + b))/2` between; positions and normals are
//! fitted alike. Of quads this is done along u, then along v, and reproduces biquadratics.

use super::bezier::{Quadratic, Square, Vector};
use crate::records::Grid3;

/// Points and normals of the limit surface on the grid of level 1.
#[derive(Clone, Debug)]
pub(crate) struct Samples {
    pub(crate) points: Box<Grid3>,
    pub(crate) normals: Box<Grid3>,
}

impl Default for Samples {
    fn default() -> Self {
        Self {
            points: Grid3::boxed(),
            normals: Grid3::boxed(),
        }
    }
}

/// The control point between `a` and `b` of the quadratic curve through `m`; the same with `a` and `b` exchanged.
fn between(a: Vector, m: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|k| (4.0 * m[k] - (a[k] + b[k])) * 0.5)
}

fn fit([a, m, b]: [Vector; 3]) -> [Vector; 3] {
    [a, between(a, m, b), b]
}

/// The biquadratic through a grid of 3 by 3.
pub(super) fn square(grid: &Grid3) -> Square {
    let rows = [0, 1, 2].map(|j| fit([0, 1, 2].map(|i| grid.get(i, j))));
    [0, 1, 2].map(|i| fit([0, 1, 2].map(|j| rows[j][i])))
}

/// The quadratic through the six points of a triangle's half of the grid.
pub(super) fn triangle(grid: &Grid3) -> Quadratic {
    let [a, b, c] = [(0, 0), (2, 0), (2, 2)].map(|(i, j)| grid.get(i, j));
    let [ab, bc, ca] = [(1, 0), (2, 1), (1, 1)].map(|(i, j)| grid.get(i, j));
    [
        a,
        b,
        c,
        between(a, ab, b),
        between(b, bc, c),
        between(c, ca, a),
    ]
}
