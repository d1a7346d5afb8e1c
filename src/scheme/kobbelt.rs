//! Masks of Kobbelt's interpolatory scheme on quads; weights in `f64`.
//!
//! L. Kobbelt, *Interpolatory subdivision on open quadrilateral nets with arbitrary topology*, 1996. Vertices stay where they are. On a
//! regular grid it is the four-point rule (Dyn, Gregory, Levin, *A 4-point interpolatory subdivision scheme for curve design*, 1987) in
//! both directions, with tension 1. Beyond an extraordinary vertex there is no fourth point; a virtual one takes its place, such that
//! both directions give the same face points next to the vertex.
//!
//! # Smoothness at extraordinary vertices
//!
//! How fast normals around a vertex settle is the ratio of the subdominant eigenvalue (twofold) of its subdivision matrix and the next
//! one (twofold too, of the second rotation mode). By these rules, with the ratio and by what the angle between normals falls per level:
//!
//! | valence | 3 | 4 | 5 | 6 | 7 | 8 | 9 |
//! |---|---|---|---|---|---|---|---|
//! | subdominant | 0.4263 | 0.5 | 0.5379 | 0.5597 | 0.5732 | 0.5821 | 0.5883 |
//! | next | 0.25 | 0.25 | 0.3619 | 0.4263 | 0.4697 | 0.5 | 0.5218 |
//! | ratio | 0.586 | 0.5 | 0.673 | 0.762 | 0.819 | 0.859 | 0.887 |
//! | per level | 1.71 | 2 | 1.49 | 1.31 | 1.22 | 1.16 | 1.13 |
//!
//! So surfaces are tangent continuous at every valence, but from valence 6 on normals settle slowly: that is the scheme's own, not
//! this code's. The virtual point of no other weights would make both directions agree.

/// Weight of the two inner points of the four.
pub const NEAR: f64 = super::butterfly::CURVE_NEAR;
/// Weight of the two outer points.
pub const FAR: f64 = super::butterfly::CURVE_FAR;

/// The virtual point straight beyond an interior vertex of valence `n`, seen from the end of its edge 0: weights of the ends of its edges,
/// then of the opposite corners of its faces; face `i` lies between edges `i` and `i + 1`. The vertex itself has no weight.
#[must_use]
pub fn beyond(n: u32) -> [Vec<f64>; 2] {
    let size = n as usize;
    let share = 4.0 / f64::from(n);
    let mut ends = vec![share; size];
    let mut opposite = vec![-share / 9.0; size];
    for i in [size - 1, 0, 1] {
        ends[i % size] -= 1.0;
    }
    // Indices -2, -1, 0, 1.
    for i in [2 * size - 2, size - 1, 0, 1] {
        opposite[i % size] += 1.0 / 9.0;
    }
    [ends, opposite]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one() {
        assert_eq!(2.0 * (NEAR + FAR), 1.0);
        for n in 1..=64 {
            let [ends, opposite] = beyond(n);
            assert!(
                (ends.iter().sum::<f64>() - 1.0).abs() < 1e-13,
                "valence {n}"
            );
            assert!(opposite.iter().sum::<f64>().abs() < 1e-13, "valence {n}");
        }
    }

    /// Values around a vertex of valence `n`, three rings of them: sector, steps along its first edge and along its second.
    struct Star {
        n: i32,
        centre: f64,
        values: Vec<f64>,
    }

    impl Star {
        const RINGS: i32 = 3;

        fn place(&self, s: i32, i: i32, j: i32) -> Option<usize> {
            match (i, j) {
                (0, 0) => None,
                (..0, _) => self.place(s + 1, j, -i),
                (_, ..0) => self.place(s - 1, -j, i),
                (0, _) => self.place(s + 1, j, 0),
                _ => {
                    let s = s.rem_euclid(self.n);
                    Some(((s * Self::RINGS + i - 1) * (Self::RINGS + 1) + j) as usize)
                }
            }
        }

        fn at(&self, s: i32, [i, j]: [i32; 2]) -> f64 {
            self.place(s, i, j).map_or(self.centre, |k| self.values[k])
        }

        /// Straight beyond the vertex, seen from the end of edge `s`.
        fn beyond(&self, s: i32) -> f64 {
            let [ends, opposite] = beyond(self.n as u32);
            (0..self.n)
                .map(|k| {
                    let (e, f) = (self.at(s + k, [1, 0]), self.at(s + k, [1, 1]));
                    ends[k as usize] * e + opposite[k as usize] * f
                })
                .sum()
        }

        /// The point of the edge from (i, j) on along the first edge of the sector, or the second.
        fn edge(&self, s: i32, [i, j]: [i32; 2], second: bool) -> f64 {
            let on = |k: i32| match second {
                false => [i + k, j],
                true => [i, j + k],
            };
            let before = match on(0) {
                [0, 0] => self.beyond(s + i32::from(second)),
                _ => self.at(s, on(-1)),
            };
            rule(
                before,
                self.at(s, on(0)),
                self.at(s, on(1)),
                self.at(s, on(2)),
            )
        }

        /// The point of a face by its edges along the first or second edge of the sector.
        fn face(&self, s: i32, [i, j]: [i32; 2], second: bool) -> f64 {
            let across = |k: i32| match second {
                false if j + k < 0 => self.edge(s - 1, [-(j + k), i], true),
                false => self.edge(s, [i, j + k], false),
                true if i + k < 0 => self.edge(s + 1, [j, -(i + k)], false),
                true => self.edge(s, [i + k, j], true),
            };
            rule(across(-1), across(0), across(1), across(2))
        }

        fn step(&self) -> Self {
            let mut next = Self {
                values: self.values.clone(),
                ..*self
            };
            for s in 0..self.n {
                for i in 1..=Self::RINGS {
                    for j in 0..=Self::RINGS {
                        let half = [i / 2, j / 2];
                        let value = match (i % 2, j % 2) {
                            (0, 0) => self.at(s, half),
                            (_, 0) => self.edge(s, half, false),
                            (0, _) => self.edge(s, half, true),
                            // The edges that keep clear of the vertex; right at it both agree.
                            _ => self.face(s, half, half == [0, 1]),
                        };
                        if let Some(k) = self.place(s, i, j) {
                            next.values[k] = value;
                        }
                    }
                }
            }
            next
        }
    }

    fn rule(before: f64, a: f64, b: f64, after: f64) -> f64 {
        NEAR * (a + b) + FAR * (before + after)
    }

    /// The largest eigenvalue of a rotation mode, by powers.
    fn eigenvalue(n: i32, mode: i32) -> f64 {
        let count = n * Star::RINGS * (Star::RINGS + 1);
        let mut star = Star {
            n,
            centre: 0.0,
            values: vec![0.0; count as usize],
        };
        for s in 0..n {
            for i in 1..=Star::RINGS {
                for j in 0..=Star::RINGS {
                    let turn = f64::from(s) + f64::from(j) / f64::from(i + j);
                    let angle = std::f64::consts::TAU * f64::from(mode) * turn / f64::from(n);
                    let k = star.place(s, i, j).unwrap();
                    star.values[k] = libm::cos(angle) * f64::from(i + j);
                }
            }
        }
        let mut grown = 0.0;
        // No more: rounding brings in other modes, which would outgrow this one.
        for _ in 0..40 {
            let next = star.step();
            grown = next.at(0, [1, 0]) / star.at(0, [1, 0]);
            let scale = 1.0 / next.at(0, [1, 0]);
            star.values = next.values.iter().map(|x| x * scale).collect();
        }
        grown
    }

    #[test]
    fn eigenvalues_are_those_of_the_documentation() {
        let table = [
            (3, 0.4263, 0.4263),
            (5, 0.5379, 0.3619),
            (6, 0.5597, 0.4263),
            (7, 0.5732, 0.4697),
            (8, 0.5821, 0.5000),
            (9, 0.5883, 0.5218),
        ];
        for (n, first, second) in table {
            let found = [eigenvalue(n, 1), eigenvalue(n, 2)];
            let close = |k: usize, want: f64| (found[k] - want).abs() < 6e-5;
            assert!(
                close(0, first) && close(1, second),
                "valence {n}: {found:?}"
            );
        }
        assert!((eigenvalue(4, 1) - 0.5).abs() < 1e-9);
    }

    #[test]
    fn both_directions_agree_at_the_vertex() {
        for n in 3..10 {
            let count = n * Star::RINGS * (Star::RINGS + 1);
            let values = (0..count).map(|k| f64::from(k * k % 101) / 101.0).collect();
            let star = Star {
                n,
                centre: 0.4,
                values,
            };
            for s in 0..n {
                let [a, b] = [false, true].map(|second| star.face(s, [0, 0], second));
                assert!((a - b).abs() < 1e-12, "valence {n}: {a} {b}");
            }
        }
    }

    #[test]
    fn a_regular_vertex_has_the_end_of_the_edge_ahead() {
        let [ends, opposite] = beyond(4);
        assert_eq!(ends, [0.0, 0.0, 1.0, 0.0]);
        assert!(opposite.iter().all(|w| w.abs() < 1e-16));
    }
}
