//! Blocks of a displaced face: its points move, and those inside have normals of their own. Points of sides and corners get the normals of
//! their owners.

use super::derivatives::{at_corner, bend, linear_derivatives, two, uv_by};
use super::layout::Layout;
use super::{Displaced, DisplacedPatch, Work};
use crate::control::Kind;
use crate::dice::face::Part;
use crate::displace::Around;
use crate::records::Grid3;
use crate::surface::Surface;
use crate::surface::jets::{Derivatives, Jets};

impl DisplacedPatch {
    /// Displaces a part of the face, whose limit points are in `points`, unit normals in `normals` and texture coordinates, if they are
    /// read, in `uvs`. Normals become those of the displaced surface if `wants_normals`.
    pub(in crate::surface) fn displace(
        &mut self,
        surface: &Surface,
        part: Part,
        points: &mut Grid3,
        normals: &mut Grid3,
        uvs: Option<&Grid3>,
        wants_normals: bool,
    ) {
        let Some(on) = self.on.clone() else { return };
        let layout = Layout::of(part, self.triangle);
        let mut work = self.work.take().unwrap_or_default();
        // Under slopes by pixel, normals are those of the limit.
        let wants_normals = wants_normals && on.displacement.pixel_map().is_none();
        work.replaced.clear();
        layout.pack(points, &mut work.points);
        layout.pack(normals, &mut work.directions);
        match uvs {
            Some(uvs) => layout.pack(uvs, &mut work.uvs),
            // Another surface may have left its own.
            None if on.displacement.reads_uvs() => work.forget_uvs(),
            None => (),
        }
        if wants_normals {
            layout.pack(points, &mut work.limits);
            layout.pack(normals, &mut work.normals);
        }
        self.on_rims(part, |c, k, at| {
            let (rim, place) = (&self.rims[c], layout.place(at));
            if let Some(&uv) = rim.uvs.get(k as usize) {
                if rim.crease && wants_normals {
                    work.replaced.push((at, work.uvs.at(place)));
                }
                work.uvs.put(place, uv);
            }
            if let Some(&direction) = rim.directions.get(k as usize) {
                work.directions.put(place, direction);
            }
        });
        self.on_corners(part, |c, at| {
            let (corner, place) = (&self.corners[c], layout.place(at));
            if self.has_uvs {
                work.uvs.put(place, corner.uv);
            }
            if let Some(direction) = corner.direction {
                work.directions.put(place, direction);
            }
        });
        on.displacement.all(
            (self.simd, layout.count()),
            &mut work.points,
            &work.directions,
            &work.uvs,
            wants_normals,
            &mut work.heights,
        );
        layout.unpack(&work.points, points);
        if wants_normals {
            self.normals(surface, &on, (part, layout), uvs, &mut work);
            layout.unpack(&work.moved, normals);
        }
        self.work = Some(work);
    }

    /// Leaves the normals of a part in `work`.
    fn normals(
        &self,
        surface: &Surface,
        on: &Displaced,
        (part, layout): (Part, Layout),
        own_uvs: Option<&Grid3>,
        work: &mut Work,
    ) {
        let displacement = &on.displacement;
        // Differences are those of the face's own coordinates, whatever its sides took from their owners at seams.
        if let Some(uvs) = own_uvs {
            layout.pack(uvs, &mut work.moved);
        }
        self.derivatives(
            surface,
            (part, layout),
            &work.limits,
            &work.moved,
            &mut work.rows,
        );
        let Work {
            limits,
            normals: limit_normals,
            directions,
            uvs,
            moved,
            heights,
            rows,
            others,
            owners,
            replaced,
            ..
        } = work;
        let limit = rows.limit([limits, limit_normals, uvs]);
        let lanes = (self.simd, layout.count());
        displacement.normals(lanes, &limit, directions, heights, moved);
        if surface.tables.is_some() {
            return;
        }
        let n = 1_u32 << self.level;
        // What belongs to others, once more.
        let site = |at: [usize; 2]| {
            let k = layout.place(at);
            let is_held = directions.at(k) == [0.0; 3];
            (!is_held).then(|| (k, limits.at(k), limit_normals.at(k), heights.values[k]))
        };
        self.on_rims(part, |c, k, at| {
            let rim = &self.rims[c];
            if !rim.own
                && !rim.crease
                && let Some((place, position, normal, height)) = site(at)
            {
                let slope = heights.slopes.at(place);
                let uv = two(uvs.at(place));
                let found = self.around(
                    surface,
                    &mut others[c],
                    self.place_of(surface, rim.owner, n - k),
                    (position, normal, uv),
                );
                if let Some(around) = found {
                    moved.put(place, displacement.normal(&around, height, slope));
                }
            }
        });
        for &(at, uv) in replaced.iter() {
            // The side of a crease that has other texture coordinates than its owner.
            let scale = 1.0 / (1_u32 << part.level) as f32;
            let own_place = [0, 1].map(|k| (part.start[k] + at[k] as u32) as f32 * scale);
            if let Some((place, position, normal, height)) = site(at)
                && let Some(around) = self.around(
                    surface,
                    &mut rows.own,
                    (self.face, own_place),
                    (position, normal, two(uv)),
                )
            {
                let slope = displacement.slope_at(position, around.uv).1;
                moved.put(place, displacement.normal(&around, height, slope));
            }
        }
        self.on_corners(part, |c, at| {
            if let Some((place, position, normal, height)) = site(at)
                && let Some(found) =
                    self.corner_normal(surface, on, (c, &mut owners[c]), (position, normal), height)
            {
                moved.put(place, found);
            }
        });
    }

    /// Normal at corner `c`, by the first face of its fan.
    pub(super) fn corner_normal(
        &self,
        surface: &Surface,
        on: &Displaced,
        (c, jets): (usize, &mut [Jets; 2]),
        (position, normal): ([f32; 3], [f32; 3]),
        height: f32,
    ) -> Option<[f32; 3]> {
        let corner = &self.corners[c];
        let place = self.place_of(surface, corner.owner, 0);
        let around = self.around(
            surface,
            jets,
            place,
            (position, normal, two(corner.owner_uv)),
        )?;
        let slope = on.displacement.slope_at(position, around.uv).1;
        Some(on.displacement.normal(&around, height, slope))
    }

    /// The limit surface around a point of another face.
    pub(super) fn around(
        &self,
        surface: &Surface,
        [points, uvs]: &mut [Jets; 2],
        (face, at): (u32, [f32; 2]),
        (position, normal, uv): ([f32; 3], [f32; 3], [f32; 2]),
    ) -> Option<Around> {
        let found = points.at::<2>(surface, Kind::Points, face, at)?;
        let by = (self.has_uvs).then(|| self.uv_at(surface, uvs, face, at));
        let [found, by] = at_corner(found, by);
        Some(Around {
            position,
            normal,
            bend: bend(&found),
            uv,
            uv_by: uv_by(&by),
        })
    }

    pub(super) fn uv_at(
        &self,
        surface: &Surface,
        jets: &mut Jets,
        face: u32,
        at: [f32; 2],
    ) -> Derivatives {
        if surface.has_linear_uvs() {
            return linear_derivatives(surface, face, self.triangle, at);
        }
        (jets.at::<1>(surface, Kind::Uvs, face, at)).unwrap_or_default()
    }
}
