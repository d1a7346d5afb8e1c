//! Masks of Kobbelt's interpolatory scheme on quads; weights in `f64`.
//!
//! L. Kobbelt, *Interpolatory subdivision on open quadrilateral nets with arbitrary topology*, 1996. Vertices stay where they are. On a
//! regular grid it is the four-point rule (Dyn, Gregory, Levin, *A 4-point interpolatory subdivision scheme for curve design*, 1987) in
//! both directions, with tension 1. Beyond an extraordinary vertex there is no fourth point; a virtual one takes its place, such that
//! both directions give the same face points next to the vertex.

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

    #[test]
    fn a_regular_vertex_has_the_end_of_the_edge_ahead() {
        let [ends, opposite] = beyond(4);
        assert_eq!(ends, [0.0, 0.0, 1.0, 0.0]);
        assert!(opposite.iter().all(|w| w.abs() < 1e-16));
    }
}
