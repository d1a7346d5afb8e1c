//! Weights of a regular triangle: its quartic box spline as a polynomial over the square of which it is one half.
//!
//! With corners 0, 1, 2 at (s, t) = (0, 0), (1, 0), (1, 1) the surface is one polynomial of degree 4 in s and t together, linear in the
//! twelve control points. Written in Bernstein polynomials of s times those of t, it is diced row by row like a tensor product: a row
//! blends the five rows of the net, every lane then blends five points. The other half of the square continues the polynomial; its
//! weights stay small, so nothing is lost. After any number of refinement steps the control points themselves are such a polynomial,
//! which differs from the limit by even differences.

use super::super::basis::{MAX_LEVEL, Target};
use std::sync::OnceLock;

/// Places of the twelve control points, row by row; corner 0 is entry 4, corner 1 entry 5, corner 2 entry 8.
pub(super) const OFFSETS: [[i32; 2]; 12] = [
    [-1, -1],
    [0, -1],
    [1, -1],
    [-1, 0],
    [0, 0],
    [1, 0],
    [2, 0],
    [0, 1],
    [1, 1],
    [2, 1],
    [1, 2],
    [2, 2],
];

/// The fifteen Bézier points of a triangle, times 24: rows towards corner 2, in a row from corner 0 to corner 1.
pub(super) const BEZIER: [[u8; 12]; 15] = [
    [2, 2, 0, 2, 12, 2, 0, 2, 2, 0, 0, 0],
    [1, 3, 0, 0, 12, 4, 0, 1, 3, 0, 0, 0],
    [0, 4, 0, 0, 8, 8, 0, 0, 4, 0, 0, 0],
    [0, 3, 1, 0, 4, 12, 0, 0, 3, 1, 0, 0],
    [0, 2, 2, 0, 2, 12, 2, 0, 2, 2, 0, 0],
    [0, 1, 0, 1, 12, 3, 0, 3, 4, 0, 0, 0],
    [0, 1, 0, 0, 10, 6, 0, 1, 6, 0, 0, 0],
    [0, 1, 0, 0, 6, 10, 0, 0, 6, 1, 0, 0],
    [0, 1, 0, 0, 3, 12, 1, 0, 4, 3, 0, 0],
    [0, 0, 0, 0, 8, 4, 0, 4, 8, 0, 0, 0],
    [0, 0, 0, 0, 6, 6, 0, 1, 10, 1, 0, 0],
    [0, 0, 0, 0, 4, 8, 0, 0, 8, 4, 0, 0],
    [0, 0, 0, 0, 4, 3, 0, 3, 12, 1, 1, 0],
    [0, 0, 0, 0, 3, 4, 0, 1, 12, 3, 0, 1],
    [0, 0, 0, 0, 2, 2, 0, 2, 12, 2, 2, 2],
];

/// A polynomial: entry `[p][q]` belongs to `s^p t^q`.
type Poly = [[f64; 5]; 5];

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |b, i| b * (n - i) as f64 / (i + 1) as f64)
}

fn combine(terms: &[(f64, Poly)]) -> Poly {
    std::array::from_fn(|p| std::array::from_fn(|q| terms.iter().map(|(w, f)| w * f[p][q]).sum()))
}

fn times(a: &Poly, b: &Poly) -> Poly {
    let mut out = [[0.0; 5]; 5];
    for (p, row) in a.iter().enumerate() {
        for (q, &x) in row.iter().enumerate() {
            for r in 0..5 - p {
                for s in 0..5 - q {
                    out[p + r][q + s] += x * b[r][s];
                }
            }
        }
    }
    out
}

/// Weight of control point `k` in 24ths.
fn weight(k: usize) -> Poly {
    let mut unit = [[0.0; 5]; 5];
    unit[0][0] = 1.0;
    // Barycentric coordinates of the corners: 1 − s, s − t, t.
    let mut corners = [[[0.0; 5]; 5]; 3];
    corners[0][0][0] = 1.0;
    corners[0][1][0] = -1.0;
    corners[1][1][0] = 1.0;
    corners[1][0][1] = -1.0;
    corners[2][0][1] = 1.0;
    let mut terms = Vec::new();
    let mut row = BEZIER.iter();
    for c2 in 0..=4 {
        for c1 in 0..=4 - c2 {
            let mut term = unit;
            for (corner, power) in corners.iter().zip([4 - c1 - c2, c1, c2]) {
                for _ in 0..power {
                    term = times(&term, corner);
                }
            }
            let Some(weights) = row.next() else { continue };
            let choices = binomial(4, c2) * binomial(4 - c2, c1);
            terms.push((choices * f64::from(weights[k]), term));
        }
    }
    combine(&terms)
}

fn derivative(f: &Poly, [along_s, along_t]: [f64; 2]) -> Poly {
    std::array::from_fn(|p| {
        std::array::from_fn(|q| {
            let s = if p < 4 {
                (p + 1) as f64 * f[p + 1][q]
            } else {
                0.0
            };
            let t = if q < 4 {
                (q + 1) as f64 * f[p][q + 1]
            } else {
                0.0
            };
            along_s * s + along_t * t
        })
    })
}

/// The control points of step width `h` whose limit is `f`. A limit point is the control point plus a twelfth of the differences to
/// its six neighbours; on quartics that is undone by a short series.
fn control(f: &Poly, h: f64) -> Poly {
    const DIRECTIONS: [[f64; 2]; 3] = [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let twice = |f: &Poly, d| derivative(&derivative(f, d), d);
    let laplace = |f: &Poly| combine(&DIRECTIONS.map(|d| (1.0, twice(f, d))));
    let fourth = combine(&DIRECTIONS.map(|d| (1.0, twice(&twice(f, d), d))));
    let second = laplace(f);
    let square = laplace(&second);
    let (h2, h4) = (h * h / 12.0, h * h * h * h / 144.0);
    combine(&[(1.0, *f), (-h2, second), (-h4, fourth), (h4, square)])
}

/// Bernstein coefficients in s and t: entry `5 r + c` belongs to `B_r(t) B_c(s)`.
fn bernstein(f: &Poly) -> [f64; 25] {
    std::array::from_fn(|k| {
        let (r, c) = (k / 5, k % 5);
        let mut sum = 0.0;
        for p in 0..=c {
            for q in 0..=r {
                let ws = binomial(c, p) / binomial(4, p);
                let wt = binomial(r, q) / binomial(4, q);
                sum += f[p][q] * ws * wt;
            }
        }
        sum
    })
}

/// How the 25 points of a net come from the twelve control points, in 24ths.
pub(super) type Expansion = [[f32; 12]; 25];

/// The expansion for points of `target` after `level` steps.
pub(super) fn expansion(target: Target, level: u32) -> &'static Expansion {
    static TABLES: [OnceLock<Expansion>; MAX_LEVEL as usize + 2] =
        [const { OnceLock::new() }; MAX_LEVEL as usize + 2];
    let (at, h) = match target {
        Target::Limit => (0, 0.0),
        Target::Refined => (level as usize + 1, 1.0 / f64::from(1_u32 << level)),
    };
    TABLES[at].get_or_init(|| {
        let columns: [[f64; 25]; 12] = std::array::from_fn(|k| bernstein(&control(&weight(k), h)));
        std::array::from_fn(|i| std::array::from_fn(|k| columns[k][i] as f32))
    })
}

fn value(f: &Poly, [s, t]: [f64; 2]) -> f64 {
    let row = |row: &[f64; 5]| row.iter().rev().fold(0.0, |sum, a| sum * t + a);
    f.iter().rev().fold(0.0, |sum, a| sum * s + row(a))
}

/// Weights of the twelve control points at one place: for the point of `target` after `level` steps, and for the derivatives of the
/// limit along s and t.
pub(super) fn point_weights(target: Target, level: u32, at: [f64; 2]) -> [[f64; 3]; 12] {
    std::array::from_fn(|k| {
        let limit = weight(k);
        let point = match target {
            Target::Limit => limit,
            Target::Refined => control(&limit, 1.0 / f64::from(1_u32 << level)),
        };
        let slope = |d| value(&derivative(&limit, d), at) / 24.0;
        [
            value(&point, at) / 24.0,
            slope([1.0, 0.0]),
            slope([0.0, 1.0]),
        ]
    })
}

/// Bernstein polynomials at `0, 1/n, … 1` with `n = 2^level`, padded by 16 entries that repeat the last one.
#[derive(Clone, Debug)]
pub(super) struct Bernstein {
    pub(super) quartic: [Vec<f32>; 5],
    pub(super) cubic: [Vec<f32>; 4],
}

impl Bernstein {
    pub(super) fn get(level: u32) -> &'static Self {
        static TABLES: [OnceLock<Bernstein>; MAX_LEVEL as usize + 1] =
            [const { OnceLock::new() }; MAX_LEVEL as usize + 1];
        TABLES[level as usize].get_or_init(|| Self {
            quartic: sample(level, 4),
            cubic: sample(level, 3),
        })
    }
}

fn sample<const N: usize>(level: u32, degree: usize) -> [Vec<f32>; N] {
    let n = 1_usize << level;
    let power = |x: f64, k: usize| (0..k).fold(1.0, |p, _| p * x);
    std::array::from_fn(|k| {
        (0..=n + 16)
            .map(|i| {
                let x = i.min(n) as f64 / n as f64;
                (binomial(degree, k) * power(x, k) * power(1.0 - x, degree - k)) as f32
            })
            .collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one() {
        assert!(BEZIER.iter().all(|row| row.iter().sum::<u8>() == 24));
        for level in 0..=MAX_LEVEL {
            for target in [Target::Limit, Target::Refined] {
                for row in expansion(target, level) {
                    let sum: f32 = row.iter().sum();
                    assert!((sum - 24.0).abs() < 1e-5, "{target:?} {level}: {sum}");
                }
            }
        }
    }

    #[test]
    fn without_a_step_the_corners_are_control_points() {
        let e = expansion(Target::Refined, 0);
        for (corner, k) in [(0, 4), (4, 5), (24, 8)] {
            for (i, w) in e[corner].iter().enumerate() {
                let want = if i == k { 24.0 } else { 0.0 };
                assert!((w - want).abs() < 1e-5, "{corner} {i}: {w}");
            }
        }
    }

    #[test]
    fn edges_do_not_see_the_points_beyond() {
        // Side 0, and the derivative of the limit across it, belong to both triangles at the edge: the two last control points have no
        // part in them.
        for (target, rows) in [(Target::Limit, 2), (Target::Refined, 1)] {
            let e = &expansion(target, 3)[..5 * rows];
            let seen = e.iter().map(|row| row[10].abs() + row[11].abs());
            assert!(seen.fold(0.0, f32::max) < 1e-6);
        }
    }
}
