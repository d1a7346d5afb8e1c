//! Catmull-Clark refinement masks (Catmull, Clark 1978), weights in `f64`.

/// Weights of a vertex point: for the vertex, for each neighbour along an edge, and for each new face point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexMask {
    /// Weight of the vertex itself.
    pub vertex: f64,
    /// Weight of each end of an edge.
    pub edge: f64,
    /// Weight of each new face point (centroid).
    pub face: f64,
}

/// Smooth interior vertex of valence `n`.
#[must_use]
#[inline]
pub fn vertex(n: u32) -> VertexMask {
    let n = f64::from(n);
    VertexMask {
        vertex: (n - 2.0) / n,
        edge: 1.0 / (n * n),
        face: 1.0 / (n * n),
    }
}

/// Weight of the vertex itself on a crease or boundary.
pub const CREASE_VERTEX: f64 = 0.75;
/// Weight of each of the two neighbours along a crease or boundary.
pub const CREASE_END: f64 = 0.125;

/// Weight of each new face point in a smooth edge point between two faces; each end of the edge has `0.5 - weight`.
pub const EDGE_FACE: f64 = 0.25;

/// As [`EDGE_FACE`] under [`TriangleRule::Smooth`](super::TriangleRule::Smooth), for faces with these numbers of corners.
#[must_use]
#[inline]
pub fn edge_face_beside_triangles(corners: [u32; 2]) -> f64 {
    let weight = |n: u32| if n == 3 { 0.470 } else { EDGE_FACE };
    0.5 * (weight(corners[0]) + weight(corners[1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one() {
        for n in 2..=64 {
            let m = vertex(n);
            let sum = m.vertex + f64::from(n) * (m.edge + m.face);
            assert!((sum - 1.0).abs() < 1e-14, "valence {n}: {sum}");
        }
        assert_eq!(CREASE_VERTEX + 2.0 * CREASE_END, 1.0);
    }

    #[test]
    fn triangle_rule_changes_triangles_only() {
        assert_eq!(edge_face_beside_triangles([4, 5]), EDGE_FACE);
        assert_eq!(edge_face_beside_triangles([3, 3]), 0.470);
        assert!((edge_face_beside_triangles([3, 4]) - 0.36).abs() < 1e-15);
    }
}
