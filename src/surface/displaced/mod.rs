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
pub(crate) use owners::Displaced;

use super::Surface;
use super::jets::Jets;
use super::patch::ChannelPatch;
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
