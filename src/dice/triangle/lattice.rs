//! The refined control points around a triangle, on its lattice: the nets of its four children, and the way towards one corner.

use super::super::point::{P4, Point};
use super::basis::OFFSETS;
use super::ring::{Hexagon, Near, edge_point, vertex_point};

/// The neighbours of a lattice point, counter-clockwise.
const DIRECTIONS: [[i32; 2]; 6] = [[1, 0], [1, 1], [0, 1], [-1, 0], [-1, -1], [0, -1]];

/// Corners in units of the children's lattice.
const CORNERS: [[i32; 2]; 3] = [[0, 0], [2, 0], [2, 2]];

/// Points −1 to 3 both ways after one step, the triangle's corners at (0, 0), (2, 0) and (2, 2). Zero where nothing is known.
#[derive(Clone, Debug)]
pub(super) struct Lattice<P = P4>([[P; 5]; 5]);

impl<P: Point> Lattice<P> {
    pub(super) const ZERO: Self = Self([[P::ZERO; 5]; 5]);

    #[inline]
    fn get(&self, [i, j]: [i32; 2]) -> P {
        self.0[(j + 1) as usize][(i + 1) as usize]
    }
    #[inline]
    fn set(&mut self, [i, j]: [i32; 2], p: P) {
        self.0[(j + 1) as usize][(i + 1) as usize] = p;
    }

    /// From the rings of the corners after one step; whole hexagons where the corner is regular.
    pub(super) fn around(near: &[Near<P>; 3], regular: [Option<&Hexagon<P>>; 3]) -> Self {
        let mut out = Self::ZERO;
        for c in 0..3 {
            let [x, y] = CORNERS[c];
            let mut put = |i: usize, p: P| {
                let [dx, dy] = DIRECTIONS[(i + 2 * c) % 6];
                out.set([x + dx, y + dy], p);
            };
            if let Some(ring) = regular[c] {
                put(3, ring.e[3]);
                put(4, ring.e[4]);
            }
            for i in -1..=2 {
                put((i + 6) as usize % 6, near[c].e(i));
            }
            out.set([x, y], near[c].v);
        }
        out
    }

    /// The net of child `c`: 0 to 2 at the corners, 3 in the middle.
    pub(super) fn child(&self, c: usize) -> [P; 12] {
        OFFSETS.map(|[i, j]| match c {
            0 => self.get([i, j]),
            1 => self.get([1 + i, j]),
            2 => self.get([1 + i, 1 + j]),
            _ => self.get([2 - i, 1 - j]),
        })
    }

    /// The same seen from corner `c`, as far as [`Lattice::deeper`] needs it, and relative to `base`; `ring` is the corner's ring, which
    /// is so already.
    pub(super) fn towards(&self, c: usize, base: P, ring: &Near<P>) -> Self {
        let mut out = self.turned(c);
        NODE.iter().for_each(|&at| out.set(at, out.get(at) - base));
        out.set_ring(ring);
        out
    }

    fn set_ring(&mut self, ring: &Near<P>) {
        self.set([0, 0], ring.v);
        for (i, d) in (-1..=2).zip([[0, -1], [1, 0], [1, 1], [0, 1]]) {
            self.set(d, ring.e(i));
        }
    }

    fn turned(&self, c: usize) -> Self {
        let mut out = Self::ZERO;
        for [i, j] in NODE {
            let ([mut x, mut y], at) = ([i, j], CORNERS[c]);
            for _ in 0..c {
                [x, y] = [-y, x - y];
            }
            out.set([i, j], self.get([at[0] + x, at[1] + y]));
        }
        out
    }

    /// The lattice around the child at corner 0 after another step; `ring` is the corner's ring after it.
    pub(super) fn deeper(&self, ring: &Near<P>) -> Self {
        let mut out = Self::ZERO;
        out.set_ring(ring);
        for [x, y] in [[1, 0], [1, 1]] {
            let v = self.get([x, y]);
            let e: [P; 6] = DIRECTIONS.map(|[dx, dy]| self.get([x + dx, y + dy]));
            out.set([2 * x, 2 * y], vertex_point(v, e));
            for (k, [dx, dy]) in DIRECTIONS.into_iter().enumerate() {
                if [x + dx, y + dy] != [0, 0] {
                    let p = edge_point(v, e[k], e[(k + 5) % 6], e[(k + 1) % 6]);
                    out.set([2 * x + dx, 2 * y + dy], p);
                }
            }
        }
        out
    }

    /// Calls `out` with the points around the two middles next to corner `c`.
    pub(super) fn each_around(&self, c: usize, mut out: impl FnMut(P)) {
        let turned = self.turned(c);
        NODE.iter().for_each(|&at| out(turned.get(at)));
    }
}

/// What the refinement towards corner 0 needs: the rings of the two middles next to it.
const NODE: [[i32; 2]; 10] = [
    [0, 0],
    [1, 0],
    [1, 1],
    [0, -1],
    [0, 1],
    [2, 1],
    [2, 0],
    [1, -1],
    [2, 2],
    [1, 2],
];
