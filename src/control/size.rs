//! How many bytes the next control level will take, from counts of the level above: asked before anything of it is made.
//!
//! The numbers per element are rounded up from peaks of whole runs, on sheets whose edges all have sharpness 9.

use super::ControlLevel;

/// Bytes per channel beside the points: what is kept of a corner, an edge and a vertex, copies of the topology with it.
const CHANNEL: [u128; 3] = [16, 8, 72];
/// The same of the points, with the level itself, its rules, and numbers of children.
const POINTS: [u128; 3] = [40, 20, 128];
/// What is needed beside while a level is made, as a part of what is kept.
const PASSING: u128 = 4;

impl ControlLevel {
    /// Bytes that the next level keeps, and bytes beyond that it takes while it is made.
    pub(super) fn next_bytes(&self) -> (u128, u128) {
        let t = &self.level.topology;
        if self.parents.is_empty() {
            return (0, 0);
        }
        let mut corners = 0_u128;
        let (mut has_vertex, mut has_edge) =
            (vec![false; t.vertex_count()], vec![false; t.edge_count()]);
        let (mut vertices, mut edges) = (0_u128, 0_u128);
        let first =
            |seen: &mut [bool], i: u32| u128::from(!std::mem::replace(&mut seen[i as usize], true));
        for &(f, _) in &self.parents {
            for h in t.face_halves(f) {
                corners += 1;
                vertices += first(&mut has_vertex, t.vertex(h));
                edges += first(&mut has_edge, t.edge(h));
            }
        }
        let triangles = !t.all_quads();
        let faces = self.parents.len() as u128;
        // Every edge is halved; the rest lies inside of the faces: four edges and a vertex, or three edges.
        let inside = if triangles { 3 * faces } else { corners };
        let middles = if triangles { 0 } else { faces };
        let next = [4 * corners, 2 * edges + inside, vertices + edges + middles];
        let of = |per: [u128; 3]| (0..3).map(|k| per[k] * next[k]).sum::<u128>();
        let channels = u128::from(self.uvs.is_some()) + u128::from(self.color_points.is_some());
        let kept = of(POINTS) + channels * of(CHANNEL);
        (kept, kept / PASSING)
    }
}
