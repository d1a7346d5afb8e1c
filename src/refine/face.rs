//! Face points: the centroid of the corners, for any number of corners.

use super::real::{Real, add, scaled};
use super::sharpness::Step;
use rayon::prelude::*;

/// Computes the face points of a level.
///
/// `index` names the value of every corner, so the same pass serves points (value = vertex) and texture coordinates.
pub fn points<T: Real, const N: usize>(
    step: &Step<'_>,
    index: &[u32],
    values: &[[T; N]],
    out: &mut [[T; N]],
) {
    out.par_iter_mut()
        .enumerate()
        .with_min_len(1 << 12)
        .for_each(|(f, point)| *point = value(step, f as u32, index, values));
}

/// The point of face `f`.
#[inline]
pub(crate) fn value<T: Real, const N: usize>(
    step: &Step<'_>,
    f: u32,
    index: &[u32],
    values: &[[T; N]],
) -> [T; N] {
    let mut sum = [T::default(); N];
    let halves = step.topology.face_halves(f);
    let n = halves.len();
    for h in halves {
        add(&mut sum, &values[index[h as usize] as usize]);
    }
    scaled(1.0 / n as f64, &sum)
}
