//! Faces that are diced displaced. The rules stand in [`displace`](crate::displace).
//!
//! `rims` says what sides and corners take from elsewhere, `block` moves the points of a part, `tangents` finds what normals are made of,
//! `sides` does the same for sides alone.

mod block;
mod derivatives;
mod layout;
mod owners;
mod rims;
mod sides;
mod tangents;

pub(super) use derivatives::linear_at;
#[cfg(feature = "gpu")]
pub(super) use derivatives::{linear_derivatives, upright};
pub(crate) use owners::Displaced;

use super::Surface;
use super::channel_patch::ChannelPatch;
use super::jets::Jets;
use crate::dice::face::Sides;
use crate::displace::{self, Heights, Limit};
use crate::records::Grid3;
use crate::simd::Level;
use rims::{Corner, Rim};
use std::sync::Arc;

/// Buffers of one thread for dicing displaced faces.
#[derive(Clone, Debug)]
pub(super) struct DisplacedPatch {
    pub(super) on: Option<Arc<Displaced>>,
    simd: Level,
    face: u32,
    level: u32,
    triangle: bool,
    has_uvs: bool,
    rims: [Rim; 4],
    corners: [Corner; 4],
    /// Another face.
    other: ChannelPatch,
    work: Option<Box<Work>>,
    spare: Option<[Box<Grid3>; 2]>,
    relief: Option<[Box<Grid3>; 3]>,
}

/// Derivatives of the face itself at the points of a part, of the limit surface and of texture coordinates, and what evaluates them.
#[derive(Clone, Debug)]
struct Rows {
    own: [Jets; 2],
    points: Box<displace::Jets>,
    uvs: Box<displace::Jets>,
}

impl Rows {
    /// The limit surface at packed points, with their normals and texture coordinates.
    fn limit<'a>(&'a self, [points, normals, uvs]: [&'a Grid3; 3]) -> Limit<'a> {
        Limit {
            points,
            normals,
            uvs,
            jets: &self.points,
            by: &self.uvs,
        }
    }
}

/// Grids are packed.
#[derive(Clone, Debug)]
struct Work {
    limits: Box<Grid3>,
    /// Of the limit surface.
    normals: Box<Grid3>,
    directions: Box<Grid3>,
    uvs: Box<Grid3>,
    points: Box<Grid3>,
    /// Normals of the displaced surface.
    moved: Box<Grid3>,
    heights: Heights,
    rows: Rows,
    /// Of the faces that own the sides, and of those that own the corners.
    others: [[Jets; 2]; 4],
    owners: [[Jets; 2]; 4],
    /// Of the last block: texture coordinates that the owner of a crease replaced.
    replaced: Vec<([usize; 2], [f32; 3])>,
}

impl Default for Work {
    fn default() -> Self {
        Self {
            limits: Grid3::boxed(),
            normals: Grid3::boxed(),
            directions: Grid3::boxed(),
            uvs: Grid3::boxed(),
            points: Grid3::boxed(),
            moved: Grid3::boxed(),
            heights: Heights::default(),
            rows: Rows {
                own: Default::default(),
                points: displace::Jets::boxed(),
                uvs: displace::Jets::boxed(),
            },
            others: Default::default(),
            owners: Default::default(),
            replaced: Vec::new(),
        }
    }
}

impl Work {
    /// Texture coordinates of surfaces without: zeros.
    fn forget_uvs(&mut self) {
        for grid in [&mut *self.uvs, &mut self.rows.uvs.du, &mut self.rows.uvs.dv] {
            for line in [&mut grid.x, &mut grid.y, &mut grid.z] {
                line.fill(0.0);
            }
        }
    }
}

impl Default for DisplacedPatch {
    fn default() -> Self {
        Self {
            on: None,
            simd: Level::SCALAR,
            face: 0,
            level: 0,
            triangle: false,
            has_uvs: false,
            rims: Default::default(),
            corners: Default::default(),
            other: ChannelPatch::default(),
            work: None,
            spare: None,
            relief: None,
        }
    }
}

impl DisplacedPatch {
    pub(super) fn set_simd(&mut self, simd: Level) {
        self.simd = simd;
        self.other.set_simd(simd);
    }

    /// Prepares face `q` of a displaced surface; false of one that is not.
    pub(super) fn prepare(&mut self, surface: &Surface, q: u32, level: u32, sides: Sides) -> bool {
        self.on.clone_from(&surface.displaced);
        (self.face, self.level) = (q, level);
        self.triangle = surface.triangles;
        if let Some(work) = &mut self.work {
            work.rows.own.iter_mut().for_each(Jets::forget);
            let others = work.others.iter_mut().chain(&mut work.owners);
            others.flatten().for_each(Jets::forget);
        }
        let Some(on) = self.on.clone() else {
            return false;
        };
        self.has_uvs = on.displacement.reads_uvs() && surface.has_uvs();
        if sides > Sides::Hull {
            self.prepare_rims(surface, &on);
        }
        true
    }

    /// Whether texture coordinates are to be given.
    pub(super) fn reads_uvs(&self) -> bool {
        self.has_uvs
    }

    /// Grids for normals and texture coordinates of the limit, lent while a part is diced.
    pub(super) fn take_spare(&mut self) -> [Box<Grid3>; 2] {
        self.spare
            .take()
            .unwrap_or_else(|| [Grid3::boxed(), Grid3::boxed()])
    }

    pub(super) fn give_spare(&mut self, spare: [Box<Grid3>; 2]) {
        self.spare = Some(spare);
    }

    /// The same for limit points, normals and texture coordinates, for relief.
    pub(super) fn take_relief(&mut self) -> [Box<Grid3>; 3] {
        (self.relief.take()).unwrap_or_else(|| [Grid3::boxed(), Grid3::boxed(), Grid3::boxed()])
    }

    pub(super) fn give_relief(&mut self, grids: [Box<Grid3>; 3]) {
        self.relief = Some(grids);
    }
}

#[cfg(test)]
mod tests {
    use crate::dice::face::{Part, Sides};
    use crate::displace::{Displacement, Function, HeightMap};
    use crate::records::Grid3;
    use crate::scheme::Scheme;
    use crate::surface::{QuadPatch, SurfaceOptions};
    use crate::{Cage, Surface};
    use std::sync::Arc;

    /// A torus of triangles with bumps and, where its texture coordinates begin again, seams; `open` leaves a face out.
    fn torus(m: u32, n: u32, open: bool) -> Cage {
        let turn = |k: u32, of: u32| k as f32 / of as f32 * std::f32::consts::TAU;
        let points = (0..m * n).map(|k| {
            let (a, b) = (turn(k / n, m), turn(k % n, n));
            let r = 1.0 + (0.4 + 0.1 * libm::sinf(3.0 * a)) * libm::cosf(b);
            [r * libm::sinf(a), 0.4 * libm::sinf(b), r * libm::cosf(a)]
        });
        let uvs = (0..(m + 1) * (n + 1)).map(|k| {
            [
                (k / (n + 1)) as f32 / m as f32,
                (k % (n + 1)) as f32 / n as f32,
            ]
        });
        let (mut corners, mut uv_corners) = (Vec::new(), Vec::new());
        for (i, j) in (0..m).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let at = |i: u32, j: u32| i % m * n + j % n;
            let uv = |i: u32, j: u32| i * (n + 1) + j;
            let quad = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            for c in [0, 1, 2, 0, 2, 3] {
                corners.push(at(quad[c].0, quad[c].1));
                uv_corners.push(uv(quad[c].0, quad[c].1));
            }
        }
        if open {
            corners.truncate(corners.len() - 3);
            uv_corners.truncate(uv_corners.len() - 3);
        }
        let counts = vec![3; corners.len() / 3];
        let cage = Cage::new(points.collect(), &counts, corners).unwrap();
        cage.with_uvs(uvs.collect(), uv_corners).unwrap()
    }

    #[test]
    fn hulls_hold_what_is_displaced_and_are_narrower_than_what_may_be() {
        let texels = (0..64 * 64).map(|k: u32| (k.wrapping_mul(0x9e37_79b9) >> 24) as f32 / 255.0);
        let map = HeightMap::new(64, 64, texels.collect()).unwrap();
        let noise: Function = "fbm:frequency=5".parse().unwrap();
        let all = [
            Displacement::map(Arc::new(map)).scaled(0.1).biased(-0.03),
            Displacement::function(noise).scaled(0.1),
        ];
        let options = SurfaceOptions {
            scheme: Some(Scheme::Loop),
            ..SurfaceOptions::default()
        };
        const LEVEL: u32 = 6;
        let (mut grid, mut narrow, mut count) = (Grid3::boxed(), 0, 0);
        for (displacement, open) in all.iter().flat_map(|d| [(d, false), (d, true)]) {
            let mut surface = Surface::new(torus(9, 7, open), &options);
            surface.set_displacement(Some(displacement.clone()));
            surface.ensure(LEVEL);
            let (mut hulls, mut diced) = (QuadPatch::default(), QuadPatch::default());
            for q in 0..surface.quads().face_count() as u32 {
                hulls.prepare_part_hulls(&surface, q, LEVEL);
                diced.prepare_points(&surface, q, LEVEL, None, Sides::Points);
                for (log, segments) in [(0, 0), (0, 1), (3, 8), (5, 32_u32)] {
                    let blocks = 1_u32 << (LEVEL - log);
                    for (x, y) in (0..blocks).flat_map(|y| (y..blocks).map(move |x| (x, y))) {
                        if log == 0 && (x * 7 + y * 3 + q) % 31 != 0 {
                            continue;
                        }
                        let part = Part {
                            level: LEVEL,
                            start: [x << log, y << log],
                            segments,
                        };
                        let [mut low, mut high] = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
                        hulls.displaced_hull(&surface, part, |p| {
                            low = [0, 1, 2].map(|k| low[k].min(p[k]));
                            high = [0, 1, 2].map(|k| high[k].max(p[k]));
                        });
                        diced.dice_part(&surface, part, &mut grid, None);
                        for j in 0..=segments as usize {
                            for i in 0..=segments as usize {
                                let p = grid.get(i, j);
                                assert!(
                                    (0..3).all(|k| low[k] <= p[k] && p[k] <= high[k]),
                                    "face {q}, {part:?}: {p:?} beyond {low:?} to {high:?}"
                                );
                            }
                        }
                        let size = |k: usize| high[k] - low[k];
                        let most = 2.0 * surface.displacement_reach();
                        narrow += usize::from((0..3).any(|k| size(k) < most));
                        count += 1;
                    }
                }
            }
        }
        assert!(2 * narrow > count, "{narrow} of {count}");
    }
}
