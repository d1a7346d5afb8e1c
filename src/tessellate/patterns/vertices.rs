//! The points that all patterns of triangles share, level after level: those of depth 0, then those that depth 1 adds, and so on.

use super::Place;

/// Points of a uniform triangle of this depth.
const fn count(depth: u32) -> u32 {
    let n = 1_u32 << depth;
    (n + 1) * (n + 2) / 2
}

/// Number of a place of the given depth, the same at every depth that has it.
#[must_use]
pub fn vertex_index(depth: u32, [x, y]: Place) -> u32 {
    // The least depth that has the point.
    let shift = (x | y).trailing_zeros().min(depth);
    let (depth, x, y) = (depth - shift, u32::from(x) >> shift, u32::from(y) >> shift);
    if depth == 0 {
        // Corners: 0 is neither 1 nor 2.
        return x + 2 * y;
    }
    // Rows of new points: those of even y have every second point, those of odd y all. Two rows together have 3 (n - y) / 2.
    let n = 1_u32 << depth;
    let pairs = y / 2;
    let before = 3 * (n * pairs - pairs * pairs.saturating_sub(1)) / 2;
    let row = if y.is_multiple_of(2) {
        x / 2
    } else {
        (n - (y - 1)) / 2 + x
    };
    count(depth - 1) + before + row
}

/// Barycentric coordinates of the points of a depth, in the order of [`vertex_index`]: the weights of corners 0, 1 and 2, exact. The
/// buffer of depth 10 has 525,825 points.
pub fn vertices(depth: u32) -> impl Iterator<Item = [f32; 3]> {
    let new = |level: u32| {
        let n = 1_u32 << level;
        let scale = 1.0 / n as f32;
        (0..=n).flat_map(move |y| {
            let all = level == 0 || y % 2 == 1;
            let (first, step) = if all { (0, 1) } else { (1, 2) };
            (first..=n - y)
                .step_by(step)
                .map(move |x| [n - x - y, x, y].map(|k| k as f32 * scale))
        })
    };
    (0..=depth).flat_map(new)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_points_have_the_same_order() {
        for depth in [0, 1, 2, 3, 6, 10] {
            let n = 1_u32 << depth;
            let mut points = 0;
            for (k, [_, x, y]) in vertices(depth).enumerate() {
                let place = [x, y].map(|w| (w * n as f32) as u16);
                assert_eq!(vertex_index(depth, place), k as u32, "{place:?} at {depth}");
                points += 1;
            }
            assert_eq!(points, count(depth));
        }
        assert_eq!(vertices(10).count(), 525_825);
    }

    #[test]
    fn a_depth_is_a_beginning_of_the_next() {
        let deep: Vec<[f32; 3]> = vertices(5).collect();
        assert!(vertices(3).eq(deep[..count(3) as usize].iter().copied()));
    }
}
