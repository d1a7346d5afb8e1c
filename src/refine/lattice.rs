//! Faces of the interpolating schemes amid regular ones: their surroundings are a piece of a lattice, and so are those of all descendants.
//!
//! Then points follow from points by number alone, without a mesh. Sums are ordered as in the module [`interpolating`](super::interpolating),
//! so that bits do not depend on which way a point was made.
//!
//! Quads: the 6 by 6 points of the face and two rings, the face's first corner at (2, 2). Triangles: point (a, b) lies a steps along the first
//! side and b steps along the last, backwards, counted from (2, 2) as well; those two steps or nearer to a corner are known.

use super::interpolating::{Sheets, eight_points, four_points};
use super::real::midpoint;
use crate::topology::NONE;

type Point = [f64; 3];

const SIDE: usize = 6;
/// Steps from a point of triangles to its six neighbours, counter-clockwise.
const STEPS: [[i32; 2]; 6] = [[1, 0], [0, 1], [-1, 1], [-1, 0], [0, -1], [1, -1]];

/// Points around a face.
#[derive(Clone, Debug)]
pub(crate) struct Lattice {
    triangular: bool,
    points: [Point; SIDE * SIDE],
}

/// Where corner `c` of the face lies.
fn corner(triangular: bool, c: u32) -> [i32; 2] {
    match (triangular, c) {
        (_, 0) => [2, 2],
        (_, 1) => [3, 2],
        (false, 2) => [3, 3],
        _ => [2, 3],
    }
}

/// Whether a triangle's lattice has point (a, b).
fn is_known([a, b]: [i32; 2]) -> bool {
    (2..=7).contains(&(a + b))
}

fn add([a, b]: [i32; 2], [c, d]: [i32; 2]) -> [i32; 2] {
    [a + c, b + d]
}

fn back([a, b]: [i32; 2]) -> [i32; 2] {
    [-a, -b]
}

/// Steps from a point of triangles to the nearest corner of the face.
fn from_corners(p: [i32; 2]) -> i32 {
    let distance = |c: u32| {
        let [a, b] = add(p, back(corner(true, c)));
        a.abs().max(b.abs()).max((a + b).abs())
    };
    distance(0).min(distance(1)).min(distance(2))
}

impl Lattice {
    /// The surroundings of the face that begins with half-edge `first`, if they are regular.
    pub(crate) fn of(
        sheets: &Sheets<'_, f64, f64, 3>,
        triangular: bool,
        first: u32,
    ) -> Option<Self> {
        let mut out = Self {
            triangular,
            points: [[0.0; 3]; SIDE * SIDE],
        };
        if triangular {
            out.gather_triangles(sheets, first)?;
        } else {
            out.gather_quads(sheets, first)?;
        }
        Some(out)
    }

    fn gather_quads(&mut self, sheets: &Sheets<'_, f64, f64, 3>, first: u32) -> Option<()> {
        let t = sheets.topology();
        let across = |h: u32| Some(sheets.twin(h)).filter(|&g| g != NONE);
        let right = |h: u32| across(t.next(h)).map(|g| t.next(g));
        let left = |h: u32| across(t.prev(h)).map(|g| t.prev(g));
        let up = |h: u32| across(t.next(t.next(h)));
        let down = |h: u32| across(h).map(|g| t.next(t.next(g)));
        let lowest = down(down(first)?)?;
        let mut row = left(left(lowest)?)?;
        for y in 0..5_usize {
            let mut h = row;
            for x in 0..5_usize {
                let corners = [(0, 0), (1, 0), (1, 1), (0, 1)];
                let mut at = h;
                for (i, j) in corners {
                    // Every point once, by the face whose first corner it is, or at the far sides.
                    if (i == 0 || x == 4) && (j == 0 || y == 4) {
                        if sheets.closed(at) != Some(4) {
                            return None;
                        }
                        self.points[(y + j) * SIDE + x + i] = sheets.at(at);
                    }
                    at = t.next(at);
                }
                if x < 4 {
                    h = right(h)?;
                }
            }
            if y < 4 {
                row = up(row)?;
            }
        }
        Some(())
    }

    fn gather_triangles(&mut self, sheets: &Sheets<'_, f64, f64, 3>, first: u32) -> Option<()> {
        let t = sheets.topology();
        // Outgoing half-edges of every point reached, of the direction of step 0.
        let mut east = [NONE; SIDE * SIDE];
        let index = |[a, b]: [i32; 2]| b as usize * SIDE + a as usize;
        let turned = |h: u32, steps: usize| {
            (0..steps).try_fold(h, |h, _| {
                Some(sheets.twin(t.prev(h))).filter(|&g| g != NONE)
            })
        };
        // The corners, then the points around them, each with its six steps.
        let mut reached = vec![[2, 2]];
        east[index([2, 2])] = first;
        let mut done = 0;
        while done < reached.len() {
            let p = reached[done];
            done += 1;
            let h = east[index(p)];
            self.points[index(p)] = sheets.at(h);
            if sheets.closed(h) != Some(6) {
                return None;
            }
            for (k, step) in STEPS.into_iter().enumerate() {
                let q = add(p, step);
                if east[index(q)] != NONE {
                    continue;
                }
                // Half-edge k of the ring leads to q, and the next of its face leaves q two directions on.
                let onward = t.next(turned(h, k)?);
                if from_corners(q) > 1 {
                    // Points two steps away need no ring.
                    self.points[index(q)] = sheets.at(onward);
                    continue;
                }
                if sheets.closed(onward) != Some(6) {
                    return None;
                }
                let ahead = sheets.around(onward).nth((6 - (k + 2) % 6) % 6);
                east[index(q)] = ahead?;
                reached.push(q);
            }
        }
        Some(())
    }

    fn at(&self, [a, b]: [i32; 2]) -> &Point {
        &self.points[b as usize * SIDE + a as usize]
    }

    /// The point of corner `c` of the face.
    pub(crate) fn corner(&self, c: u32) -> Point {
        *self.at(corner(self.triangular, c))
    }

    /// The sides of the face at its first corner.
    pub(crate) fn sides(&self) -> [Point; 2] {
        let (x, last) = (self.corner(0), if self.triangular { 2 } else { 3 });
        [1, last].map(|c| {
            let p = self.corner(c);
            [0, 1, 2].map(|k| p[k] - x[k])
        })
    }

    /// The surroundings of child `c`.
    pub(crate) fn child(&self, c: u32) -> Self {
        let mut out = self.clone();
        // Where the child's first corner lies, in half steps, and which way it looks.
        let (origin, turn) = match (self.triangular, c) {
            (_, 0) => ([4, 4], 1),
            (_, 1) => ([5, 4], 1),
            (false, 2) => ([5, 5], 1),
            (true, 3) => ([5, 5], -1),
            _ => ([4, 5], 1),
        };
        for b in 0..SIDE as i32 {
            for a in 0..SIDE as i32 {
                if !self.triangular || is_known([a, b]) {
                    let at = add(origin, [turn * (a - 2), turn * (b - 2)]);
                    out.points[b as usize * SIDE + a as usize] = self.half(at);
                }
            }
        }
        out
    }

    /// The point at a place in half steps.
    fn half(&self, [i, j]: [i32; 2]) -> Point {
        let low = [i >> 1, j >> 1];
        let step = match (i & 1, j & 1) {
            (0, 0) => return *self.at(low),
            (1, 0) => 0,
            (0, _) => 1,
            _ if self.triangular => return self.edge(add(low, [1, 0]), 2),
            _ => return self.face(low),
        };
        self.edge(low, step)
    }

    /// The point of the edge from `p` by step `k`.
    fn edge(&self, p: [i32; 2], k: usize) -> Point {
        let d = STEPS[k];
        let end = add(p, d);
        let at = |p: [i32; 2]| self.at(p);
        if !self.triangular {
            let (before, after) = (add(p, back(d)), add(end, d));
            return four_points(at(p), at(end), at(before), at(after));
        }
        let (l, r) = (STEPS[(k + 1) % 6], STEPS[(k + 5) % 6]);
        let wings = [
            [add(end, l), add(p, add(l, back(d)))],
            [add(end, r), add(p, add(r, back(d)))],
        ];
        eight_points(
            [at(p), at(end)],
            [at(add(p, l)), at(add(p, r))],
            wings.map(|pair| pair.map(at)),
        )
    }

    /// The point of the quad whose first corner is `p`.
    fn face(&self, p: [i32; 2]) -> Point {
        let across = |k: usize| {
            let edge = |i: i32| {
                let [a, b] = STEPS[1 - k];
                self.edge(add(p, [i * a, i * b]), k)
            };
            four_points(&edge(0), &edge(1), &edge(-1), &edge(2))
        };
        midpoint(&across(0), &across(1))
    }

    /// Derivatives at corner `c` along step 0 and step 1, per step.
    pub(crate) fn derivatives(&self, c: u32) -> [Point; 2] {
        let p = corner(self.triangular, c);
        let at = |scale: i32, [a, b]: [i32; 2]| self.at(add(p, [scale * a, scale * b]));
        [0, 1].map(|first| {
            if !self.triangular {
                let d = STEPS[first];
                let [p, q, far_p, far_q] = [1, -1, 2, -2].map(|s| at(s, d));
                return [0, 1, 2].map(|k| (8.0 * (p[k] - q[k]) - (far_p[k] - far_q[k])) / 12.0);
            }
            // The masks of Butterfly's tangents for six faces, by their cosines.
            let mut sum = [0.0; 3];
            let near = [1.0, 0.5, -0.5, -1.0, -0.5, 0.5];
            let beside = [1.0, 0.0, -1.0, -1.0, 0.0, 1.0];
            for i in 0..6 {
                let d = STEPS[(first + i) % 6];
                let side = at(1, add(d, STEPS[(first + i + 1) % 6]));
                let (p, q) = (at(1, d), at(2, d));
                for (k, s) in sum.iter_mut().enumerate() {
                    *s += near[i] * (16.0 * p[k] + q[k]) - 4.0 * beside[i] * side[k];
                }
            }
            sum.map(|s| s / 30.0)
        })
    }
}
