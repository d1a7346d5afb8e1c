//! Dicing of interpolating surfaces (Modified Butterfly, Kobbelt's scheme) by tables of weights at dyadic points.
//!
//! These surfaces have no closed form, but every dyadic point of a face is a fixed weighted sum of the control points in two rings around
//! it, and so are two tangents there. Faces whose surroundings look alike share one [`Table`] of such weights. A table has rows of weights
//! per control point with lanes along grid points, so that sums over control points vectorise, and it keeps the inside of the face and its
//! sides apart: a side is diced by one of its faces alone (the face of its edge's first half-edge), and the other face runs the same
//! code over the same table and points, hence gets the same bits. Corners are control points.

mod patch;
mod place;
mod side;

use super::regular::{LANES, LINE, Line};
use std::sync::OnceLock;

pub(crate) use patch::{TableChannel, TableMesh, TablePatch, TableShapes};
pub(crate) use place::{Place, cells, places};

/// Sums run over so many control points at a time.
const GROUP: usize = 4;

/// Weights of a number of points, and of two tangents there, over the control points of a table.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rows {
    count: usize,
    /// Points, first and second tangents: line by line, in a line control by control, in a control point by point.
    layers: [Vec<f32>; 3],
}

impl Rows {
    /// Rows of `count` points over `controls` control points; `weight(layer, point, control)` tells each.
    pub(crate) fn new(
        count: usize,
        controls: usize,
        weight: impl Fn(usize, usize, usize) -> f32,
    ) -> Self {
        let controls = controls.next_multiple_of(GROUP);
        let layers = [0, 1, 2].map(|layer| {
            let mut out = Vec::with_capacity(count.next_multiple_of(LANES) * controls);
            for first in (0..count).step_by(LINE) {
                let points = (count - first).min(LINE);
                for control in 0..controls {
                    for i in 0..points.next_multiple_of(LANES) {
                        let inside = i < points;
                        out.push(if inside {
                            weight(layer, first + i, control)
                        } else {
                            0.0
                        });
                    }
                }
            }
            out
        });
        Self { count, layers }
    }

    /// The points of these that `chosen` names, in its order; sums of theirs have the same bits.
    fn choose(&self, controls: usize, chosen: &[usize]) -> Self {
        let padded = controls.next_multiple_of(GROUP);
        Self::new(chosen.len(), padded, |layer, point, control| {
            let (line, i) = (chosen[point] / LINE, chosen[point] % LINE);
            let lanes = (self.count - line * LINE).min(LINE).next_multiple_of(LANES);
            self.layers[layer][line * LINE * padded + control * lanes + i]
        })
    }

    fn bytes(&self) -> usize {
        self.layers.iter().map(|l| 4 * l.len()).sum()
    }

    /// Cuts the points into lines: first point, number, place of the line's weights, and lanes.
    fn lines(&self, controls: usize) -> impl Iterator<Item = (usize, usize, usize, usize)> + '_ {
        let controls = controls.next_multiple_of(GROUP);
        (0..self.count).step_by(LINE).map(move |first| {
            let points = (self.count - first).min(LINE);
            (
                first,
                points,
                first * controls,
                points.next_multiple_of(LANES),
            )
        })
    }
}

/// Weights of all points of a face at a level.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    /// Which of the vertices around a face are control points. The face's first corner is vertex 0 and none of them: all is relative to it.
    pub(crate) controls: Vec<u32>,
    /// Points inside of the face, row by row.
    pub(crate) inside: Rows,
    /// Points along each side without its ends.
    pub(crate) sides: Vec<Rows>,
    /// The table of every second of its points, once one was asked for.
    coarser: OnceLock<Box<Table>>,
}

impl Table {
    pub(crate) fn new(controls: Vec<u32>, inside: Rows, sides: Vec<Rows>) -> Self {
        Self {
            controls,
            inside,
            sides,
            coarser: OnceLock::new(),
        }
    }

    /// The table of every `2^steps`-th point of its `2^level` segments a side.
    fn coarser(&self, level: u32, steps: u32) -> &Self {
        if steps == 0 {
            return self;
        }
        let next = self.coarser.get_or_init(|| Box::new(self.halved(level)));
        next.coarser(level - 1, steps - 1)
    }

    fn halved(&self, level: u32) -> Self {
        let (n, controls) = (1_usize << level, self.controls.len());
        let triangular = self.sides.len() == 3;
        let place = |[i, j]: [usize; 2]| inside_place(triangular, n, [i, j]);
        let inside = (2..n).step_by(2).flat_map(|j| {
            let low = if triangular { j + 2 } else { 2 };
            (low..n).step_by(2).map(move |i| [i, j])
        });
        let inside: Vec<usize> = inside.map(place).collect();
        let along: Vec<usize> = (2..n).step_by(2).map(|k| k - 1).collect();
        let sides = self.sides.iter();
        Self::new(
            self.controls.clone(),
            self.inside.choose(controls, &inside),
            sides.map(|s| s.choose(controls, &along)).collect(),
        )
    }

    /// Bytes of the weights.
    pub(crate) fn bytes(&self) -> usize {
        self.inside.bytes() + self.sides.iter().map(Rows::bytes).sum::<usize>()
    }
}

/// Number of a point among those inside of a face of `n` segments a side, which stand row by row.
fn inside_place(triangular: bool, n: usize, [i, j]: [usize; 2]) -> usize {
    if triangular {
        // Row r has the points r + 1 to n − 1.
        (j - 1) * (n - 1) - (j - 1) * j / 2 + (i - j - 1)
    } else {
        (j - 1) * (n - 1) + i - 1
    }
}

/// Control points relative to a base, component by component; a multiple of [`GROUP`].
#[derive(Clone, Debug, Default)]
struct Controls([Vec<f32>; 3]);

impl Controls {
    fn gather(&mut self, base: [f32; 3], points: impl Iterator<Item = [f32; 3]>) {
        self.0.iter_mut().for_each(Vec::clear);
        for p in points {
            for (k, out) in self.0.iter_mut().enumerate() {
                out.push(p[k] - base[k]);
            }
        }
        for out in &mut self.0 {
            out.resize(out.len().next_multiple_of(GROUP), 0.0);
        }
    }
}

/// The sum of one point, with the bits that its lane has in [`weigh`].
fn weigh_one(weights: &[f32], lanes: usize, lane: usize, controls: &Controls) -> [f32; 3] {
    [0, 1, 2].map(|c| {
        let groups = controls.0[c].chunks_exact(GROUP);
        let groups = groups.zip(weights.chunks_exact(GROUP * lanes));
        groups.fold(0.0, |sum, (q, w)| {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| w[k * lanes + lane]);
            sum + ((a * q[0] + d * q[3]) + (b * q[1] + c * q[2]))
        })
    })
}

/// Sums of a line: `weights` has `lanes` numbers per control point.
#[inline(always)]
fn weigh(weights: &[f32], lanes: usize, controls: &Controls, out: &mut [Line; 3]) {
    let [x, y, z] = out;
    let (x, y, z) = (&mut x[..lanes], &mut y[..lanes], &mut z[..lanes]);
    x.fill(0.0);
    y.fill(0.0);
    z.fill(0.0);
    let [qx, qy, qz] = &controls.0;
    let groups = (qx.chunks_exact(GROUP)).zip(qy.chunks_exact(GROUP));
    let groups = groups.zip(qz.chunks_exact(GROUP));
    for (((qx, qy), qz), w) in groups.zip(weights.chunks_exact(GROUP * lanes)) {
        let (w0, rest) = w.split_at(lanes);
        let (w1, rest) = rest.split_at(lanes);
        let (w2, w3) = rest.split_at(lanes);
        let w3 = &w3[..lanes];
        for i in 0..lanes {
            let (a, b, c, d) = (w0[i], w1[i], w2[i], w3[i]);
            x[i] += (a * qx[0] + d * qx[3]) + (b * qx[1] + c * qx[2]);
            y[i] += (a * qy[0] + d * qy[3]) + (b * qy[1] + c * qy[2]);
            z[i] += (a * qz[0] + d * qz[3]) + (b * qz[1] + c * qz[2]);
        }
    }
}
