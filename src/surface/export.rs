//! A displaced surface as the refined mesh that files hold.

use super::{QuadPatch, Surface};
use crate::dice::face::{FacePatch, Sides};
use crate::records::Grid3;
use crate::refine::Limit;
use crate::simd::Level;
use crate::topology::Topology;

impl Surface {
    /// Puts displaced points and normals in place of the limit's. `topology` is the mesh after `level` steps of this surface's cage
    /// ([`refine`](crate::refine)), and `limit` is its limit. Nothing changes without displacement.
    ///
    /// # Panics
    /// When `level` is above 10, or `topology` and `limit` belong to another cage or level.
    pub fn displace_limit(&self, level: u32, topology: &Topology, limit: &mut Limit<f32>) {
        if self.displacement().is_none() {
            return;
        }
        let split = u32::from(self.is_split());
        let quad_level = level.saturating_sub(split);
        self.ensure(quad_level);
        let mut patch = QuadPatch::for_level(Level::detect());
        let (mut points, mut normals) = (Grid3::boxed(), Grid3::boxed());
        let blocks = FacePatch::blocks_per_side(quad_level);
        let m = (FacePatch::block_size(quad_level).cols - 1) as u32;
        let mut corners = Vec::new();
        for q in 0..self.quads().face_count() as u32 {
            if level < split {
                // The corner of a polygon is that of its quad.
                corners.clear();
                corners.push((q, [0, 0]));
            } else {
                self.grid_corners(q, quad_level, &mut corners);
            }
            patch.prepare_points(self, q, quad_level, None, Sides::Normals);
            // Block by block, so that each is diced once.
            let block = |[i, j]: [u32; 2]| [i, j].map(|k| (k / m).min(blocks - 1));
            corners.sort_unstable_by_key(|&(h, at)| (block(at), h));
            let mut ready = None;
            for &(h, at) in &corners {
                let [bu, bv] = block(at);
                if ready != Some([bu, bv]) {
                    patch.dice(self, bu, bv, &mut points, Some(&mut normals));
                    ready = Some([bu, bv]);
                }
                let [i, j] = [at[0] - bu * m, at[1] - bv * m].map(|k| k as usize);
                limit.positions[topology.vertex(h) as usize] = points.get(i, j);
                let normal = limit.normal_index(topology, h);
                limit.normals[normal as usize] = normals.get(i, j);
            }
        }
    }

    /// Corners of the refined mesh that belong to face `q` of [`Surface::quads`], with the column and row in the face's grid.
    fn grid_corners(&self, q: u32, level: u32, out: &mut Vec<(u32, [u32; 2])>) {
        out.clear();
        let n = 1_u32 << level;
        let mid = |a: [u32; 2], b: [u32; 2]| [0, 1].map(|k| (a[k] + b[k]) / 2);
        if self.is_triangular() {
            let mut stack = vec![(0, q, [[0, 0], [n, 0], [n, n]])];
            while let Some((depth, face, p)) = stack.pop() {
                if depth == level {
                    out.extend((0..3).map(|c| (3 * face + c, p[c as usize])));
                    continue;
                }
                let e = [mid(p[0], p[1]), mid(p[1], p[2]), mid(p[2], p[0])];
                let children = [
                    [p[0], e[0], e[2]],
                    [e[0], p[1], e[1]],
                    [e[2], e[1], p[2]],
                    [e[1], e[2], e[0]],
                ];
                let children = (0..).zip(children);
                stack.extend(children.map(|(c, p)| (depth + 1, 4 * face + c, p)));
            }
            return;
        }
        let square = [[0, 0], [n, 0], [n, n], [0, n]];
        let mut first = square;
        if self.is_split() {
            // Children of quads keep their parent's directions; the quads of a split cage begin at their own corner.
            let base = self.topology();
            let face = base.face_halves(base.face_of(q));
            let turn = if face.len() == 4 { q - face.start } else { 0 } as usize;
            first = [0, 1, 2, 3].map(|k: usize| square[(k + 4 - turn) % 4]);
        }
        let mut stack = vec![(0, q, first)];
        while let Some((depth, face, p)) = stack.pop() {
            if depth == level {
                out.extend((0..4).map(|c| (4 * face + c, p[c as usize])));
                continue;
            }
            for j in 0..4 {
                let mut child = [[0; 2]; 4];
                child[j] = p[j];
                child[(j + 1) % 4] = mid(p[j], p[(j + 1) % 4]);
                child[(j + 2) % 4] = mid(p[0], p[2]);
                child[(j + 3) % 4] = mid(p[j], p[(j + 3) % 4]);
                stack.push((depth + 1, 4 * face + j as u32, child));
            }
        }
    }
}
