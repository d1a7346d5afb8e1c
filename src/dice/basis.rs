//! One-dimensional weights of the uniform cubic B-spline at the dyadic parameters of a level.
//!
//! A regular patch is a tensor product, so these few numbers dice it at any level. They are made in `f64`, where all of them are exact
//! but for the division by 6, and rounded once. The weights at a parameter do not depend on the level: finer levels repeat the bits of
//! coarser ones.

use std::sync::OnceLock;

/// Deepest uniform level.
pub const MAX_LEVEL: u32 = 10;

/// What is evaluated at a grid point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Target {
    /// The point of the limit surface.
    #[default]
    Limit,
    /// The control point after as many refinement steps as the level says (Antal's output). Normals are those of the limit.
    Refined,
}

/// Four weights at each place of a line, padded by 16 places that repeat the last one.
#[derive(Clone, Debug)]
pub(crate) struct LineWeights {
    /// By control point, for lanes over places.
    lanes: [Vec<f32>; 4],
    /// By place.
    places: Vec<[f32; 4]>,
}

impl LineWeights {
    fn new(weights: impl Iterator<Item = [f64; 4]>) -> Self {
        let mut places: Vec<[f32; 4]> = weights.map(|w| w.map(|w| w as f32)).collect();
        let last = places.last().copied().unwrap_or_default();
        places.resize(places.len() + 16, last);
        let lanes = std::array::from_fn(|k| places.iter().map(|w| w[k]).collect());
        Self { lanes, places }
    }

    /// The weights at one place.
    #[inline(always)]
    pub(crate) fn at(&self, place: usize) -> [f32; 4] {
        self.places[place]
    }

    /// The weights at `W` places from one on, by control point.
    #[inline(always)]
    pub(crate) fn lanes<const W: usize>(&self, place: usize) -> [[f32; W]; 4] {
        let mut out = [[0.0; W]; 4];
        for (out, w) in out.iter_mut().zip(&self.lanes) {
            out.copy_from_slice(&w[place..place + W]);
        }
        out
    }
}

/// Weights at `0, 1/n, … 1` with `n = 2^level`.
#[derive(Clone, Debug)]
pub(crate) struct Basis {
    /// Weights of the four control points for the position.
    pub(crate) point: LineWeights,
    /// Weights for the first derivative of the limit.
    pub(crate) slope: LineWeights,
    /// Weights for the position of the limit (the same as `point` for [`Target::Limit`]).
    pub(crate) limit: LineWeights,
    /// Weights of left or right neighbour, and of the centre, for a point on a line of control points.
    pub(crate) across: [f32; 2],
}

impl Basis {
    #[inline(always)]
    pub(crate) fn get(target: Target, level: u32) -> &'static Self {
        static TABLES: [[OnceLock<Basis>; MAX_LEVEL as usize + 1]; 2] =
            [const { [const { OnceLock::new() }; MAX_LEVEL as usize + 1] }; 2];
        let table = &TABLES[target as usize][level as usize];
        // No call in the usual case: kernels are full of vectors that a call would have to save.
        match table.get() {
            Some(basis) => basis,
            None => Self::first(table, target, level),
        }
    }

    #[cold]
    fn first(table: &'static OnceLock<Self>, target: Target, level: u32) -> &'static Self {
        table.get_or_init(|| Self::make(target, level))
    }

    fn make(target: Target, level: u32) -> Self {
        let n = 1_usize << level;
        let limit = sample(n, spline);
        let point = match target {
            Target::Limit => limit.clone(),
            Target::Refined => LineWeights::new(refined(level).into_iter()),
        };
        let [side, centre, ..] = point.at(0);
        Self {
            point,
            slope: sample(n, spline_slope),
            limit,
            across: [side, centre],
        }
    }
}

fn sample(n: usize, f: impl Fn(f64) -> [f64; 4]) -> LineWeights {
    LineWeights::new((0..=n).map(|i| f(i as f64 / n as f64)))
}

/// Values of the four cubic B-splines at `t` in 0…1.
pub(crate) fn spline(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [
        s * s * s / 6.0,
        (4.0 + t * t * (3.0 * t - 6.0)) / 6.0,
        (4.0 + s * s * (3.0 * s - 6.0)) / 6.0,
        t * t * t / 6.0,
    ]
}

/// Their derivatives.
pub(crate) fn spline_slope(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [
        -s * s / 2.0,
        t * (3.0 * t - 4.0) / 2.0,
        -s * (3.0 * s - 4.0) / 2.0,
        t * t / 2.0,
    ]
}

/// Weights of the control points of level `level` at the dyadic places of the segment: cubic subdivision of four unit vectors.
fn refined(level: u32) -> Vec<[f64; 4]> {
    // Control points from one before the segment to one after it.
    let mut row: Vec<[f64; 4]> = (0..4)
        .map(|k| std::array::from_fn(|i| f64::from(u8::from(i == k))))
        .collect();
    let mix = |terms: &[(f64, &[f64; 4])]| {
        std::array::from_fn(|k| terms.iter().map(|(w, p)| w * p[k]).sum())
    };
    for _ in 0..level {
        let mut next = Vec::with_capacity(2 * row.len());
        for i in 0..row.len() - 1 {
            if i > 0 {
                next.push(mix(&[
                    (0.125, &row[i - 1]),
                    (0.75, &row[i]),
                    (0.125, &row[i + 1]),
                ]));
            }
            next.push(mix(&[(0.5, &row[i]), (0.5, &row[i + 1])]));
        }
        row = next;
    }
    row[1..row.len() - 1].to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one_and_slopes_to_zero() {
        for target in [Target::Limit, Target::Refined] {
            for level in 0..=MAX_LEVEL {
                let b = Basis::get(target, level);
                for i in 0..=1 << level {
                    let sum: f32 = b.point.at(i).iter().sum();
                    let slope: f32 = b.slope.at(i).iter().sum();
                    assert!(
                        (sum - 1.0).abs() < 3e-7 && slope.abs() < 3e-7,
                        "{target:?} {level} {i}"
                    );
                }
            }
        }
    }

    #[test]
    fn one_refinement_is_the_cubic_mask() {
        let b = Basis::get(Target::Refined, 1);
        let rows: Vec<[f32; 4]> = (0..3).map(|i| b.point.at(i)).collect();
        assert_eq!(
            rows,
            [
                [0.125, 0.75, 0.125, 0.0],
                [0.0, 0.5, 0.5, 0.0],
                [0.0, 0.125, 0.75, 0.125]
            ]
        );
    }

    #[test]
    fn finer_levels_repeat_the_bits_of_coarser_ones() {
        let (coarse, fine) = (Basis::get(Target::Limit, 3), Basis::get(Target::Limit, 7));
        for k in 0..4 {
            for i in 0..=8 {
                assert_eq!(
                    coarse.point.at(i)[k].to_bits(),
                    fine.point.at(16 * i)[k].to_bits()
                );
            }
        }
    }
}
