//! Pieces of a few points, of which every irregular corner leaves many: one line of the kernels holds all their points, and every control
//! point is weighed for all of them at once.

use super::super::basis::Target;
use super::super::regular::{LANES, LINE, Line, unit_cross};
use super::basis::point_weights;
use super::tensor::Net12;
use std::sync::OnceLock;

/// Deepest level whose points fit into one line of the kernels: 45 of 48.
pub(super) const SMALL_LEVEL: u32 = 3;

/// Weights of the twelve control points at every lattice point, row by row: of the point, and of the limit's derivatives.
#[derive(Clone, Debug)]
pub(super) struct Small {
    /// Lattice points, corner 0 first, row by row.
    pub(super) places: Vec<[i32; 2]>,
    point: [Vec<f32>; 12],
    along: [Vec<f32>; 12],
    across: [Vec<f32>; 12],
}

impl Small {
    /// The weights at the lattice points of `level`, at most [`SMALL_LEVEL`].
    pub(super) fn get(target: Target, level: u32) -> &'static Self {
        static TABLES: [[OnceLock<Small>; SMALL_LEVEL as usize + 1]; 2] =
            [const { [const { OnceLock::new() }; SMALL_LEVEL as usize + 1] }; 2];
        TABLES[target as usize][level as usize].get_or_init(|| {
            let n = 1_i32 << level;
            let places: Vec<[i32; 2]> =
                (0..=n).flat_map(|j| (j..=n).map(move |i| [i, j])).collect();
            let weights: Vec<[[f64; 3]; 12]> = (0..places.len().next_multiple_of(LANES))
                .map(|k| {
                    let at = places[k.min(places.len() - 1)];
                    point_weights(target, level, at.map(|x| f64::from(x) / f64::from(n)))
                })
                .collect();
            let [point, along, across] = [0, 1, 2].map(|q: usize| {
                std::array::from_fn(|k| weights.iter().map(|w| w[k][q] as f32).collect())
            });
            Self {
                places,
                point,
                along,
                across,
            }
        })
    }

    /// The points, relative to the net's base, one per lane.
    #[inline(always)]
    pub(super) fn points(&self, net: &Net12, out: &mut [Line; 3]) {
        sum(&self.point, net, out);
    }

    /// The unit normals; `spare` where there is none.
    #[inline(always)]
    pub(super) fn normals(&self, net: &Net12, spare: [f32; 3], out: &mut [Line; 3]) {
        let (mut du, mut dv) = ([[0.0; LINE]; 3], [[0.0; LINE]; 3]);
        sum(&self.along, net, &mut du);
        sum(&self.across, net, &mut dv);
        unit_cross(&du, &dv, self.point[0].len(), spare, out);
    }
}

#[inline(always)]
fn sum(weights: &[Vec<f32>; 12], net: &Net12, out: &mut [Line; 3]) {
    for (c, out) in out.iter_mut().enumerate() {
        // Not a constant to the compiler, which would unroll the loop instead of vectorising it.
        let n = weights[0].len();
        let out = &mut out[..n];
        for k in [0, 4, 8] {
            let (w0, w1) = (&weights[k][..n], &weights[k + 1][..n]);
            let (w2, w3) = (&weights[k + 2][..n], &weights[k + 3][..n]);
            let (q0, q1) = (net[k].0[c], net[k + 1].0[c]);
            let (q2, q3) = (net[k + 2].0[c], net[k + 3].0[c]);
            let first = k == 0;
            for i in 0..n {
                let part = (w0[i] * q0 + w1[i] * q1) + (w2[i] * q2 + w3[i] * q3);
                out[i] = if first { part } else { out[i] + part };
            }
        }
    }
}
