//! One quad as plain arrays, for export and for other programs.

use super::limits::RefinedFans;
use super::{QuadPatch, Surface};
use crate::dice::face::FacePatch;
use crate::dice::{DiceFault, MAX_LEVEL};
use crate::math;
use crate::records::Grid3;
use crate::simd::Level;

/// Points of one quad of the surface's quad mesh on a grid, row by row: `side` points along u, then the next v.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DicedQuad {
    /// Points along each side.
    pub side: usize,
    /// Limit points, or control points of the level.
    pub points: Vec<[f32; 3]>,
    /// Unit limit normals.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates; empty without.
    pub uvs: Vec<[f32; 2]>,
}

impl Surface {
    /// Dices quad `q` of [`Surface::quads`] on a grid of `2^level + 1` points along each side.
    ///
    /// # Panics
    /// When there is no such quad or `level` is above 10.
    #[must_use]
    pub fn dice(&self, q: u32, level: u32) -> DicedQuad {
        self.dice_with(q, level, DiceFault::None)
    }

    /// Every quad's control points after `level` steps, with the normals of the limit.
    ///
    /// # Panics
    /// As [`Surface::dice`].
    pub fn refine_quads(&self, level: u32) -> impl Iterator<Item = DicedQuad> + '_ {
        assert!(level <= MAX_LEVEL, "level {level} is above {MAX_LEVEL}");
        let fans = self.refined_fans(level);
        (0..self.quads().face_count() as u32)
            .map(move |q| self.dice_quad(q, level, DiceFault::None, Some(&fans)))
    }

    /// [`Surface::dice`] with a rule broken, for tests.
    #[doc(hidden)]
    #[must_use]
    pub fn dice_with(&self, q: u32, level: u32, fault: DiceFault) -> DicedQuad {
        self.dice_quad(q, level, fault, None)
    }

    fn dice_quad(
        &self,
        q: u32,
        level: u32,
        fault: DiceFault,
        refined: Option<&RefinedFans>,
    ) -> DicedQuad {
        assert!(level <= MAX_LEVEL, "level {level} is above {MAX_LEVEL}");
        self.ensure(level);
        let mut patch = QuadPatch::default();
        patch.set_fault(fault);
        patch.set_simd(Level::detect());
        patch.prepare(self, q, level, refined);
        let side = (1_usize << level) + 1;
        let mut out = DicedQuad {
            side,
            ..DicedQuad::default()
        };
        out.points.resize(side * side, [0.0; 3]);
        out.normals.resize(side * side, [0.0; 3]);
        let (mut points, mut normals) = (Grid3::boxed(), Grid3::boxed());
        let mut uvs = self.has_uvs().then(|| {
            out.uvs.resize(side * side, [0.0; 2]);
            Grid3::boxed()
        });
        let blocks = FacePatch::blocks_per_side(level);
        let m = FacePatch::block_size(level).cols - 1;
        for bv in 0..blocks {
            let first = if self.triangles { bv } else { 0 };
            for bu in first..blocks {
                patch.dice(self, bu, bv, &mut points, Some(&mut normals));
                if let Some(uvs) = uvs.as_deref_mut() {
                    patch.dice_uvs(bu, bv, uvs);
                }
                for j in 0..=m {
                    for i in 0..=m {
                        let k = (bv as usize * m + j) * side + bu as usize * m + i;
                        out.points[k] = points.get(i, j);
                        out.normals[k] = normals.get(i, j);
                        if let Some(uvs) = &uvs {
                            let [u, v, _] = uvs.get(i, j);
                            out.uvs[k] = [u, v];
                        }
                    }
                }
            }
        }
        if self.triangles {
            out.fold();
        }
        out
    }
}

impl DicedQuad {
    /// Repeats the diagonal above it: the other half of a triangle's grid.
    pub(super) fn fold(&mut self) {
        let n = self.side;
        for j in 1..n {
            let (from, to) = (j * n + j, j * n..j * n + j);
            for i in to {
                self.points[i] = self.points[from];
                self.normals[i] = self.normals[from];
                if let Some(&uv) = self.uvs.get(from) {
                    self.uvs[i] = uv;
                }
            }
        }
    }

    /// Tangent and bitangent at every point, row by row: unit vectors in the tangent plane along which the texture's u and v grow (along
    /// the grid's u and v where there are no texture coordinates). From central differences of the grid, made normal to the limit
    /// normal; so they suit normal maps, and are not exact like the normals are. Mirrored texture shows as a left-handed pair.
    #[must_use]
    pub fn tangents(&self) -> Vec<[[f32; 3]; 2]> {
        let n = self.side;
        let step = |k: usize| (k.saturating_sub(1), (k + 1).min(n - 1));
        let mut out = Vec::with_capacity(n * n);
        for j in 0..n {
            for i in 0..n {
                let ((i0, i1), (j0, j1)) = (step(i), step(j));
                let (west, east, south, north) = (j * n + i0, j * n + i1, j0 * n + i, j1 * n + i);
                let along = math::sub(self.points[east], self.points[west]);
                let across = math::sub(self.points[north], self.points[south]);
                let [a, b, c, d] = match self.uvs.is_empty() {
                    true => [1.0, 0.0, 0.0, 1.0],
                    false => {
                        let uv = |k: usize| self.uvs[k];
                        [
                            uv(east)[0] - uv(west)[0],
                            uv(north)[0] - uv(south)[0],
                            uv(east)[1] - uv(west)[1],
                            uv(north)[1] - uv(south)[1],
                        ]
                    }
                };
                // (along, across) = (T, B) · [[a, b], [c, d]]; only directions matter, so the determinant enters by its sign.
                let sign = if a * d - b * c < 0.0 { -1.0 } else { 1.0 };
                let mix = |p: f32, q: f32| [0, 1, 2].map(|k| (along[k] * p + across[k] * q) * sign);
                let normal = self.normals[j * n + i];
                let flat = |v: [f32; 3], spare: [f32; 3]| {
                    let h = math::dot(v, normal);
                    math::normalize([0, 1, 2].map(|k| v[k] - normal[k] * h)).unwrap_or(spare)
                };
                let tangent = flat(mix(d, -c), flat(along, [1.0, 0.0, 0.0]));
                out.push([tangent, flat(mix(-b, a), math::cross(normal, tangent))]);
            }
        }
        out
    }

    /// Antal's triangle strips: one per row of micro-quads, each alternating between the row's upper and lower points, from column
    /// 0 on. Indices into the grid. At level 3 these are 8 strips of 18, 144 vertices in all.
    #[must_use]
    pub fn strips(&self) -> Vec<Vec<u32>> {
        let n = self.side as u32;
        (0..n - 1)
            .map(|j| (0..n).flat_map(|i| [(j + 1) * n + i, j * n + i]).collect())
            .collect()
    }
}
