//! Tangents of corners where both derivatives of a face have one direction.

use super::tables::Table;
use crate::surface::Surface;

/// Corners of quads with what is around them in the mesh of quads.
///
/// Where a face lies between two sides of one smooth crease, both of its derivatives run along that at the corner. The tangents of such a
/// corner, the limit of a boundary with one face, are those of its spokes: their difference, and their sum without twice the corner.
pub(super) struct Corners {
    /// Per quad, corner and column: shares in the corner, in the next one and in the one before.
    shares: Vec<[f32; 3]>,
    count: usize,
    corners: usize,
    triangles: bool,
}

impl Corners {
    pub(super) fn new(subs: usize, count: usize, triangles: bool) -> Self {
        let corners = if triangles { 3 } else { 4 };
        Self {
            shares: vec![[0.0; 3]; subs * corners * count],
            count,
            corners,
            triangles,
        }
    }

    /// Reads the shares of columns `first..first + 3`, whose points are unit vectors.
    pub(super) fn read(&mut self, surface: &Surface, first: usize) {
        let (t, points) = (surface.quads(), surface.control_points());
        let (count, corners) = (self.count, self.corners);
        for (k, shares) in self.shares.chunks_exact_mut(count).enumerate() {
            let (sub, c) = (k / corners, k % corners);
            let h = t.face_halves(sub as u32).start + c as u32;
            let around = [h, t.next(h), t.prev(h)].map(|h| points[t.vertex(h) as usize]);
            for k in first..count.min(first + 3) {
                shares[k] = around.map(|p| p[k - first]);
            }
        }
    }

    /// Gives corners whose derivatives have one direction their tangents.
    pub(super) fn mend(&self, table: &mut Table, subs: usize) {
        let n = 1_usize << table.level;
        let places = match self.triangles {
            true => [[0, 0], [n, 0], [n, n], [n, n]],
            false => [[0, 0], [n, 0], [n, n], [0, n]],
        };
        let (grid, width) = (table.stride() as usize, table.width as usize);
        for (sub, c) in (0..subs).flat_map(|s| (0..self.corners).map(move |c| (s, c))) {
            let place = places[c][1] * (n + 1) + places[c][0];
            let at = |k: usize| ((sub * self.count + k) * grid + place) * width;
            let (mut e, mut f, mut g) = (0.0_f32, 0.0, 0.0);
            for k in 0..self.count {
                let [u, v] = [1, 2].map(|d| table.weights[at(k) + d]);
                (e, f, g) = (e + u * u, f + u * v, g + v * v);
            }
            if e * g - f * f > 1e-6 * e * g {
                continue;
            }
            for k in 0..self.count {
                let [own, next, before] = self.shares[(sub * self.corners + c) * self.count + k];
                let out = &mut table.weights[at(k)..at(k) + width];
                out[1..].fill(0.0);
                out[1] = next - before;
                out[2] = (next - own) + (before - own);
            }
        }
    }
}
