//! Derivatives of the limit surface at the points of a part: what its normals are made of, and what tilts normals pixel by pixel.

use super::derivatives::{at_corner, differences, linear_rows};
use super::layout::Layout;
use super::{DisplacedPatch, Rows};
use crate::control::Kind;
use crate::dice::face::Part;
use crate::displace::Around;
use crate::records::Grid3;
use crate::surface::Surface;

impl DisplacedPatch {
    /// Leaves in `rows` the derivatives at the points of a part, from its packed limit points and texture coordinates.
    pub(super) fn derivatives(
        &self,
        surface: &Surface,
        (part, layout): (Part, Layout),
        points: &Grid3,
        uvs: &Grid3,
        rows: &mut Rows,
    ) {
        let Rows {
            own,
            points: out,
            uvs: by,
        } = rows;
        let [own, own_uv] = own;
        for j in layout.rows() {
            let columns = layout.columns(j);
            let columns = columns.start as u32..columns.end as u32;
            let at = layout.first(j);
            let row = (part, j as u32, columns.clone());
            let of = Kind::Points;
            if !own.row::<2>(surface, of, self.face, row.clone(), self.simd, (out, at)) {
                differences(layout, points, j, out);
            }
            if !self.has_uvs {
                continue;
            }
            // Differences are those of steps, and so of points and coordinates alike.
            if surface.has_linear_uvs() && surface.tables.is_none() {
                let corners = surface.linear_corners(self.face).unwrap_or_default();
                linear_rows(&corners, self.triangle, row, (by, at));
            } else {
                let of = Kind::Uvs;
                if !own_uv.row::<1>(surface, of, self.face, row, self.simd, (by, at)) {
                    differences(layout, uvs, j, by);
                }
            }
        }
        let first = surface.halves_of(self.face).start;
        self.on_corners(part, |c, at| {
            if !surface.is_flat_corner(first + c as u32) {
                return;
            }
            let (at, place) = (layout.place(at), self.corners()[c].map(|x| x as f32));
            let Some(found) = own.at::<2>(surface, Kind::Points, self.face, place) else {
                return;
            };
            let coordinates = (self.has_uvs).then(|| self.uv_at(surface, own_uv, self.face, place));
            let [found, coordinates] = at_corner(found, coordinates);
            found.put::<2>(out, at);
            if self.has_uvs {
                coordinates.put::<1>(by, at);
            }
        });
    }

    /// Leaves in `out` the vectors by which slopes of the map tilt normals, at the points of a part: limit points and normals, and texture
    /// coordinates.
    pub(in crate::surface) fn tilts(
        &mut self,
        surface: &Surface,
        part: Part,
        limit: [&Grid3; 3],
        out: [&mut Grid3; 2],
    ) {
        let Some(on) = self.on.clone() else { return };
        self.each_around(surface, part, limit, out, |around| {
            let (height, _) = on.displacement.slope_at(around.position, around.uv);
            on.displacement.tilts(around, height)
        });
    }

    /// Leaves in `out` the derivatives of the limit surface by its texture coordinates.
    pub(in crate::surface) fn tangents(
        &mut self,
        surface: &Surface,
        part: Part,
        limit: [&Grid3; 3],
        out: [&mut Grid3; 2],
    ) {
        self.each_around(surface, part, limit, out, |around| {
            around.bend.by_uv(around.uv_by)
        });
    }

    /// Leaves in `out` what `of` says of the limit surface around the points of a part.
    fn each_around(
        &mut self,
        surface: &Surface,
        part: Part,
        [points, normals, uvs]: [&Grid3; 3],
        [first, second]: [&mut Grid3; 2],
        of: impl Fn(&Around) -> [[f32; 3]; 2],
    ) {
        let layout = Layout::of(part, self.triangle);
        let mut work = self.work.take().unwrap_or_default();
        layout.pack(points, &mut work.limits);
        layout.pack(normals, &mut work.normals);
        layout.pack(uvs, &mut work.uvs);
        // Texture coordinates are read, whatever is displaced by.
        let has_uvs = std::mem::replace(&mut self.has_uvs, true);
        self.derivatives(
            surface,
            (part, layout),
            &work.limits,
            &work.uvs,
            &mut work.rows,
        );
        self.has_uvs = has_uvs;
        let limit = work.rows.limit([&work.limits, &work.normals, &work.uvs]);
        for k in 0..layout.count() {
            let [a, b] = of(&limit.around(k));
            work.points.put(k, a);
            work.moved.put(k, b);
        }
        layout.unpack(&work.points, first);
        layout.unpack(&work.moved, second);
        self.work = Some(work);
    }
}
