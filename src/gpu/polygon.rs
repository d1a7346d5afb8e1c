//! The polygons of a cage as blocks of one micro-quad: their corners are control points as they are, and what is given there.

use super::chunk::{ALIGNED, Builder, NamedBlock};
use super::dicer::Dicer;
use super::plan::PlannedBlock;
use super::records::{Block, Face, POINT_FLOATS, Spot, Stencil};
use crate::mesh::fan_corners;
use crate::topology::NONE;

/// Corner of a quad at each place of a block, row by row.
pub(super) const CORNERS: [usize; 4] = [0, 1, 3, 2];

/// Words of a table that gives each place its corner: by corner and place.
const TABLE: usize = 4 * 4;

/// The number of a table, of the corners that have a value.
fn table_number(there: [bool; 4]) -> u32 {
    (0..4).map(|c| u32::from(there[c]) << c).sum()
}

impl Builder {
    /// Bytes of points, weights and gathers with the blocks of one more face: no less than what they take.
    pub(super) fn polygon_bytes(&self, dicer: &Dicer<'_>, blocks: &[PlannedBlock]) -> [u64; 4] {
        let cage = dicer.surface.cage();
        let face = blocks[0].quad as usize;
        let (vertices, first) = (cage.face(face), cage.face_offsets()[face]);
        let points = u64::from(self.data.points()) + (4 * blocks.len() + vertices.len()) as u64;
        let is_new = |v: &&u32| !self.there.points.stencils.contains_key(v);
        let mut gathers = self.data.gathers.len() + vertices.iter().filter(is_new).count();
        let mut tables = Vec::new();
        if dicer.colors > 0 {
            gathers += 4 * blocks.len();
            tables.push(table_number([true; 4]));
        }
        if dicer.look.textured {
            gathers += 4 * blocks.len();
            let of = |b: &PlannedBlock| fan_corners(vertices.len(), b.start[0]);
            let uvs = |b| of(b).map(|k| cage.corner_uvs()[(first + k) as usize] != NONE);
            tables.extend(blocks.iter().map(|b| table_number(uvs(b))));
        }
        tables.sort_unstable();
        tables.dedup();
        tables.retain(|number| !self.there.uv_tables.contains_key(number));
        // Each table begins at a multiple.
        let table = TABLE.next_multiple_of(ALIGNED as usize);
        let weights = self.data.weights.len() + tables.len() * table;
        [
            points * 4 * u64::from(POINT_FLOATS),
            4 * weights as u64,
            4 * gathers as u64,
            0,
        ]
    }

    /// Adds the blocks of a face of the cage.
    pub(super) fn add_polygon(&mut self, dicer: &Dicer<'_>, blocks: &[PlannedBlock]) {
        let cage = dicer.surface.cage();
        let face = blocks[0].quad as usize;
        let first = cage.face_offsets()[face];
        let count = cage.face(face).len();
        let spots = self.data.spots.len() as u32;
        for corner in first..first + count as u32 {
            let spot = self.polygon_corner(dicer, corner);
            self.data.spots.push(spot);
        }
        for b in blocks {
            let of = fan_corners(count, b.start[0]);
            let own = self.polygon(dicer, face as u32, spots, of.map(|k| first + k));
            let corners = of.map(|k| spots + k);
            self.add_single(Face { corners, ..own }, b);
        }
    }

    /// Adds a face that is one block of one micro-quad.
    pub(super) fn add_single(&mut self, face: Face, b: &PlannedBlock) {
        let data = &mut self.data;
        data.named.push(NamedBlock {
            quad: b.quad,
            start: b.start,
            log: 0,
            base: data.block_points,
        });
        data.blocks.push(Block {
            face: data.faces.len() as u32,
            step: 1,
            base: data.block_points,
            level: b.shown,
            ..Block::default()
        });
        data.faces.push(face);
        data.block_points += 4;
        data.quads += 1;
    }

    /// A corner of the cage: its point as it is, and the normal that is given there.
    fn polygon_corner(&mut self, dicer: &Dicer<'_>, corner: u32) -> Spot {
        let cage = dicer.surface.cage();
        let vertex = cage.corner_vertices()[corner as usize];
        let data = &mut self.data;
        let stencil = *self.there.points.stencils.entry(vertex).or_insert_with(|| {
            data.stencils.push(Stencil {
                gather: data.gathers.len() as u32,
                count: 1,
                table: 0,
                stride: 0,
            });
            data.gathers.push(dicer.first_point + vertex);
            data.stencils.len() as u32 - 1
        });
        let given = cage.corner_normals().get(corner as usize).copied();
        // Points have no derivatives, and so no normal of their own.
        let (normal_stencil, normal_index) = match given.filter(|&n| n != NONE) {
            Some(n) => (dicer.first_extra + n, NONE),
            None => (stencil, 0),
        };
        Spot {
            stencil,
            index: 0,
            normal_stencil,
            normal_index,
        }
    }

    /// A face of one micro-quad between these corners of the cage, but for its spots.
    fn polygon(&mut self, dicer: &Dicer<'_>, face: u32, stencil: u32, corners: [u32; 4]) -> Face {
        let cage = dicer.surface.cage();
        let mut out = Face {
            stencil,
            row: 2,
            number: dicer.first_face + face,
            material: dicer.object.material(face),
            colors: dicer.colors,
            ..Face::default()
        };
        if dicer.colors > 0 {
            let table = self.polygon_table([true; 4]);
            let data = &mut self.data;
            out.color_stencil = data.stencils.len() as u32;
            data.stencils.push(Stencil {
                gather: data.gathers.len() as u32,
                count: 4,
                table,
                stride: 4,
            });
            let own = corners.map(|c| dicer.first_point + cage.corner_vertices()[c as usize]);
            data.gathers.extend(own);
        }
        if dicer.look.textured {
            let own = corners.map(|c| cage.corner_uvs()[c as usize]);
            out.uv_table = self.polygon_table(own.map(|uv| uv != NONE));
            out.uv_gather = self.data.gathers.len() as u32;
            out.uv_count = 4;
            // What is missing has no weight.
            let own = own.map(|uv| if uv == NONE { 0 } else { uv });
            let own = own.map(|uv| dicer.first_uv + 2 * uv);
            self.data.gathers.extend(own);
        }
        out
    }

    /// Where a table begins that gives each place its corner, but for corners that are missing.
    fn polygon_table(&mut self, there: [bool; 4]) -> u32 {
        let weights = &mut self.data.weights;
        let tables = &mut self.there.uv_tables;
        *tables.entry(table_number(there)).or_insert_with(|| {
            let base = weights.len();
            weights.resize((base + TABLE).next_multiple_of(ALIGNED as usize), 0.0);
            for (place, &corner) in CORNERS.iter().enumerate() {
                if there[corner] {
                    weights[base + corner * 4 + place] = 1.0;
                }
            }
            base as u32
        })
    }
}
