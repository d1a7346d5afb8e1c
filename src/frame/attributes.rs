//! What shading needs of a block beside its points.

use crate::Cage;
use crate::mesh::NONE;
use crate::records::Grid3;

/// What shading needs of a block; grids that are not there hold what was there before.
pub(super) struct Attributes {
    pub(super) normals: Box<Grid3>,
    pub(super) uvs: Box<Grid3>,
    pub(super) colors: Box<Grid3>,
    /// What tilts normals, for relief and slopes by pixel.
    pub(super) tangents: [Box<Grid3>; 2],
    /// First and last row of points that are wanted, where not all are; only where texture coordinates are not.
    pub(super) rows: Option<[u32; 2]>,
    /// Whether anything of the frame reads texture coordinates.
    pub(super) wants_uvs: bool,
    pub(super) has_uvs: bool,
    pub(super) has_colors: bool,
    pub(super) has_tangents: bool,
}

impl Default for Attributes {
    fn default() -> Self {
        Self {
            normals: Grid3::boxed(),
            uvs: Grid3::boxed(),
            colors: Grid3::boxed(),
            tangents: [Grid3::boxed(), Grid3::boxed()],
            rows: None,
            wants_uvs: false,
            has_uvs: false,
            has_colors: false,
            has_tangents: false,
        }
    }
}

impl Attributes {
    /// Which of texture coordinates, colours and tangents there are.
    pub(super) fn flags(&self) -> [bool; 3] {
        [self.has_uvs, self.has_colors, self.has_tangents]
    }

    pub(super) fn set_flags(&mut self, flags: [bool; 3]) {
        [self.has_uvs, self.has_colors, self.has_tangents] = flags;
    }

    /// What there is.
    pub(super) fn grids(&self) -> impl Iterator<Item = &Grid3> {
        let [first, second] = &self.tangents;
        let all = [&self.normals, &self.uvs, &self.colors, first, second];
        let [uvs, colors, tangents] = self.flags();
        let there = [true, uvs, colors, tangents, tangents];
        all.into_iter().zip(there).filter(|g| g.1).map(|g| &**g.0)
    }

    pub(super) fn grids_mut(&mut self) -> impl Iterator<Item = &mut Grid3> {
        let [uvs, colors, tangents] = self.flags();
        let there = [true, uvs, colors, tangents, tangents];
        let [first, second] = &mut self.tangents;
        let all = [
            &mut self.normals,
            &mut self.uvs,
            &mut self.colors,
            first,
            second,
        ];
        all.into_iter()
            .zip(there)
            .filter(|g| g.1)
            .map(|g| &mut **g.0)
    }
}

impl Attributes {
    /// Puts what a corner of a cage has at a point.
    pub(super) fn set_corner(&mut self, (i, j): (usize, usize), cage: &Cage, corner: u32) {
        let of = |numbers: &[u32]| numbers.get(corner as usize).copied().filter(|&n| n != NONE);
        let normal = of(&cage.corner_normals).map(|n| cage.normals[n as usize]);
        self.normals.set(i, j, normal.unwrap_or_default());
        if self.has_uvs {
            let [u, v] = of(&cage.corner_uvs).map_or([0.0; 2], |n| cage.uvs[n as usize]);
            self.uvs.set(i, j, [u, v, 0.0]);
        }
        if self.has_colors {
            let vertex = cage.corner_vertices[corner as usize];
            let color = cage.colors.get(vertex as usize).copied();
            self.colors.set(i, j, color.unwrap_or_default());
        }
    }
}
