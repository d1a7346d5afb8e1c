//! Second derivatives for tables of displaced surfaces, and tangents of the corners that have no others.

use super::tables::Table;
use crate::surface::{PlaceJets, Surface};

/// Derivatives of the quads of a face, each by its own parameters.
pub(super) struct QuadJets<'a> {
    places: PlaceJets<'a>,
    /// Segments of the grid of the whole face where that is one quad and its quarters are asked for.
    quarters: Option<u32>,
}

impl<'a> QuadJets<'a> {
    pub(super) fn new(surface: &'a Surface, level: u32, quarters: Option<u32>) -> Self {
        let level = level + u32::from(quarters.is_some());
        Self {
            places: PlaceJets::new(surface, level),
            quarters,
        }
    }

    /// Quad and place of point `at` of quad `sub`, whose grid has `n` segments.
    fn place(&self, sub: usize, [i, j]: [usize; 2], n: u32) -> (u32, [f32; 2]) {
        match self.quarters {
            None => (sub as u32, [i, j].map(|k| k as f32 / n as f32)),
            Some(n) => {
                let k = quarter(sub, i, j, n as usize) as u32;
                (0, [k % (n + 1), k / (n + 1)].map(|k| k as f32 / n as f32))
            }
        }
    }

    /// First derivatives in the directions of a quarter: half as fast, and turned.
    fn turned<const N: usize>(&self, sub: usize, [du, dv]: [[f32; N]; 2]) -> [[f32; N]; 2] {
        if self.quarters.is_none() {
            return [du, dv];
        }
        let half = |d: [f32; N], s: f32| d.map(|c| s * c);
        match sub {
            0 => [half(du, 0.5), half(dv, 0.5)],
            1 => [half(dv, 0.5), half(du, -0.5)],
            2 => [half(du, -0.5), half(dv, -0.5)],
            _ => [half(dv, -0.5), half(du, 0.5)],
        }
    }

    pub(super) fn points(&mut self, sub: usize, at: [usize; 2], n: u32) -> Option<[[f32; 3]; 5]> {
        let (quad, at) = self.place(sub, at, n);
        let [du, dv, uu, uv, vv] = self.places.points(quad, at)?;
        let [du, dv] = self.turned(sub, [du, dv]);
        if self.quarters.is_none() {
            return Some([du, dv, uu, uv, vv]);
        }
        let quarter = |d: [f32; 3], s: f32| d.map(|c| s * c);
        let (uu, uv, vv) = match sub % 2 {
            0 => (uu, quarter(uv, 0.25), vv),
            _ => (vv, quarter(uv, -0.25), uu),
        };
        Some([du, dv, quarter(uu, 0.25), uv, quarter(vv, 0.25)])
    }

    pub(super) fn uvs(&mut self, sub: usize, at: [usize; 2], n: u32) -> Option<[[f32; 2]; 2]> {
        let (quad, at) = self.place(sub, at, n);
        let found = self.places.uvs(quad, at)?;
        Some(self.turned(sub, found))
    }
}

/// Where in a grid of `n` segments over a face of four corners point (i, j) of its quad at corner `sub` is.
pub(super) fn quarter(sub: usize, i: usize, j: usize, n: usize) -> usize {
    let [x, y] = match sub {
        0 => [i, j],
        1 => [n - j, i],
        2 => [n - i, n - j],
        _ => [j, n - i],
    };
    y * (n + 1) + x
}

/// Corners of quads with what is around them in the mesh of quads.
///
/// Where a face lies between two sides of one smooth crease, both of its derivatives run along that at the corner. The tangents of such a
/// corner, the limit of a boundary with one face, are those of its spokes: their difference, and their sum without twice the corner.
pub(super) struct Corners {
    /// Per quad, corner and column: shares in the corner, in the next one and in the one before.
    shares: Vec<[f32; 3]>,
    count: usize,
    corners: usize,
    /// Whether quads are quarters of one, of whose corners theirs is the first.
    quarters: bool,
    triangles: bool,
}

impl Corners {
    pub(super) fn new(subs: usize, count: usize, triangles: bool, quarters: bool) -> Self {
        let corners = if triangles { 3 } else { 4 };
        Self {
            shares: vec![[0.0; 3]; subs * corners * count],
            count,
            corners,
            quarters,
            triangles,
        }
    }

    /// Reads the shares of columns `first..first + 3`, whose points are unit vectors.
    pub(super) fn read(&mut self, surface: &Surface, first: usize) {
        let (t, points) = (surface.quads(), surface.control_points());
        let (count, corners) = (self.count, self.corners);
        for (k, shares) in self.shares.chunks_exact_mut(count).enumerate() {
            let (sub, c) = (k / corners, k % corners);
            let h = match (self.quarters, c) {
                (false, _) => t.face_halves(sub as u32).start + c as u32,
                (true, 0) => t.face_halves(0).start + sub as u32,
                (true, _) => continue,
            };
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
            if self.quarters && c > 0 {
                continue;
            }
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
