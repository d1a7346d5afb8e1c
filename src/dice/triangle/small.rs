//! Pieces of a few points, of which every irregular corner leaves many: one vector holds all their points, and each control point is
//! weighed once for all of them.

use super::super::basis::Target;
use super::super::point::P4;
use super::super::regular::{LANES, LINE, Line, unit_cross};
use super::basis::point_weights;
use super::piece::Net12;
use std::sync::OnceLock;

/// Deepest level whose points fit into one vector.
pub(super) const SMALL_LEVEL: u32 = 2;

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
            let weights: Vec<[[f64; 3]; 12]> = (0..LANES)
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
        let w: [&[f32]; 12] = std::array::from_fn(|k| &weights[k][..n]);
        let q: [f32; 12] = net.map(|p: P4| p.0[c]);
        for i in 0..n {
            let low = (w[0][i] * q[0] + w[1][i] * q[1]) + (w[2][i] * q[2] + w[3][i] * q[3]);
            let mid = (w[4][i] * q[4] + w[5][i] * q[5]) + (w[6][i] * q[6] + w[7][i] * q[7]);
            let top = (w[8][i] * q[8] + w[9][i] * q[9]) + (w[10][i] * q[10] + w[11][i] * q[11]);
            out[i] = (low + top) + mid;
        }
    }
}
