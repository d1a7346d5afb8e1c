//! Where blocks come from: the quads of a surface at a level, or the polygons of its cage.
//!
//! Items are numbered through all objects of a scene; an item has one or more blocks. This is the one place that knows what an item
//! is; binning, drawing and shading only count them.

use super::scene::{Object, Scene};
use crate::dice::FacePatch;
use crate::dice::fan_points::FanPoints;
use crate::mesh::NONE;
use crate::records::{BlockSize, Grid3};
use crate::surface::QuadPatch;

/// What is drawn of each surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Drawing {
    /// Points of the limit surface.
    #[default]
    Limit,
    /// Control points after as many steps as the level says.
    Refined,
    /// The polygons of the cage.
    Cage,
}

/// One object with its level, ready to give blocks.
pub(super) struct Source<'a> {
    pub(super) object: &'a Object,
    pub(super) first_item: u32,
    pub(super) first_face: u32,
    /// Level of the cage.
    pub(super) level: u32,
    drawing: Drawing,
    refined: Option<FanPoints>,
}

/// Buffers of one thread.
#[derive(Default)]
pub(super) struct SourceScratch {
    patch: QuadPatch,
    prepared: Option<(u32, bool)>,
}

const PAIR: BlockSize = BlockSize { cols: 2, rows: 2 };

impl<'a> Source<'a> {
    /// Sources of all objects, and the number of items.
    pub(super) fn all(scene: &'a Scene, drawing: Drawing, levels: &[u32]) -> (Vec<Self>, u32) {
        let (mut first_item, mut first_face) = (0, 0);
        let sources = scene.objects.iter().zip(levels).map(|(object, &level)| {
            let quad_level = level.saturating_sub(u32::from(object.surface.is_split()));
            let refined =
                (drawing == Drawing::Refined).then(|| object.surface.refined_fans(quad_level));
            let source = Source {
                object,
                first_item,
                first_face,
                level,
                drawing,
                refined,
            };
            first_item += source.item_count();
            first_face += object.surface.cage().face_count() as u32;
            source
        });
        let sources: Vec<_> = sources.collect();
        (sources, first_item)
    }

    pub(super) fn item_count(&self) -> u32 {
        match self.drawing {
            Drawing::Cage => self.object.surface.cage().face_count() as u32,
            _ => self.object.surface.quads().face_count() as u32,
        }
    }

    /// Level 0 of a cage with n-gons: its polygons with limit points at the corners.
    fn is_polygonal(&self) -> bool {
        self.level == 0 && self.object.surface.is_split()
    }

    /// Level of the quads.
    fn quad_level(&self) -> u32 {
        self.level
            .saturating_sub(u32::from(self.object.surface.is_split()))
    }

    /// Face of the cage that a local item shows.
    pub(super) fn cage_face(&self, item: u32) -> u32 {
        if self.drawing == Drawing::Cage {
            item
        } else {
            self.object.surface.cage_face(item)
        }
    }

    /// Whether a local item is drawn at all.
    pub(super) fn is_drawn(&self, item: u32) -> bool {
        let surface = &self.object.surface;
        let face = self.cage_face(item);
        if surface.topology().is_hole(face) {
            return false;
        }
        // A polygonal level draws four-sided faces by their first item alone.
        let quad = self.drawing != Drawing::Cage
            && self.is_polygonal()
            && surface.topology().face_halves(face).len() == 4;
        !quad || surface.topology().face_halves(face).start == item
    }

    /// Blocks of a local item along each side; the polygons of a cage are in a row.
    pub(super) fn blocks(&self, item: u32) -> [u32; 2] {
        if self.drawing == Drawing::Cage {
            let n = self.object.surface.cage().face(item as usize).len() as u32;
            return [if n == 4 { 1 } else { n - 2 }, 1];
        }
        [FacePatch::blocks_per_side(self.quad_level()); 2]
    }

    pub(super) fn block_size(&self) -> BlockSize {
        if self.drawing == Drawing::Cage {
            PAIR
        } else {
            FacePatch::block_size(self.quad_level())
        }
    }

    /// Micro-triangles of all items that are drawn.
    pub(super) fn triangles(&self) -> u64 {
        let per_quad = 2_u64 << (2 * self.quad_level());
        let count = |item: u32| match self.drawing {
            Drawing::Cage => self.object.surface.cage().face(item as usize).len() as u64 - 2,
            _ => per_quad,
        };
        (0..self.item_count())
            .filter(|&i| self.is_drawn(i))
            .map(count)
            .sum()
    }

    fn prepare(&self, scratch: &mut SourceScratch, item: u32, sides: bool) {
        let key = (self.first_item + item, sides);
        let ready = scratch
            .prepared
            .is_some_and(|(i, s)| i == key.0 && (s || !sides));
        if !ready {
            scratch.patch.prepare_points(
                &self.object.surface,
                item,
                self.quad_level(),
                self.refined.as_ref(),
                sides,
            );
            scratch.prepared = Some(key);
        }
    }

    /// Points whose convex hull holds a local item.
    pub(super) fn hull(&self, scratch: &mut SourceScratch, item: u32, out: &mut Vec<[f32; 3]>) {
        out.clear();
        let surface = &self.object.surface;
        if self.drawing == Drawing::Cage {
            let cage = surface.cage();
            out.extend(
                cage.face(item as usize)
                    .iter()
                    .map(|&v| cage.points[v as usize]),
            );
        } else if self.is_polygonal() {
            out.extend(self.polygon(item).map(|fan| self.fan_point(fan)));
        } else {
            self.prepare(scratch, item, false);
            scratch.patch.hull(|p| out.push(p));
        }
    }

    /// The same for one block, where the item has several.
    pub(super) fn block_hull(
        &self,
        scratch: &mut SourceScratch,
        item: u32,
        [bu, bv]: [u32; 2],
        out: &mut Vec<[f32; 3]>,
    ) {
        out.clear();
        if self.drawing == Drawing::Cage {
            out.extend(
                self.cage_corners(item, bu)
                    .map(|(v, _)| self.object.surface.cage().points[v as usize]),
            );
        } else {
            self.prepare(scratch, item, true);
            scratch.patch.block_hull(bu, bv, |p| out.push(p));
        }
    }

    /// Dices a block: points, and normals and texture coordinates where asked for. Returns whether there are texture coordinates.
    pub(super) fn dice(
        &self,
        scratch: &mut SourceScratch,
        item: u32,
        [bu, bv]: [u32; 2],
        points: &mut Grid3,
        extra: Option<(&mut Grid3, &mut Grid3)>,
    ) -> bool {
        if self.drawing == Drawing::Cage {
            return self.dice_cage(item, bu, points, extra);
        }
        if self.is_polygonal() {
            self.dice_polygon(item, points, extra);
            return false;
        }
        self.prepare(scratch, item, true);
        match extra {
            None => {
                scratch.patch.dice(bu, bv, points, None);
                false
            }
            Some((normals, uvs)) => {
                scratch.patch.dice(bu, bv, points, Some(normals));
                if !scratch.patch.has_uvs() {
                    scratch.patch.prepare_uvs(&self.object.surface, item);
                }
                if scratch.patch.has_uvs() {
                    scratch.patch.dice_uvs(bu, bv, uvs);
                }
                scratch.patch.has_uvs()
            }
        }
    }

    /// Fans of a polygonal item: the corners of a quad, or one sector of an n-gon with its centre.
    fn polygon(&self, item: u32) -> [u32; 4] {
        let quads = self.object.surface.quads();
        let base = self.object.surface.topology();
        let next = base.next(item);
        if base.face_halves(base.face_of(item)).len() == 4 {
            let third = base.next(next);
            return [item, next, third, base.next(third)].map(|h| quads.fan(4 * h));
        }
        let centre = quads.fan(4 * item + 2);
        [quads.fan(4 * item), quads.fan(4 * next), centre, centre]
    }

    fn fan_point(&self, fan: u32) -> [f32; 3] {
        match &self.refined {
            Some(fans) => fans.limits[fan as usize],
            None => self.object.surface.fan_limit(fan).0,
        }
    }

    fn dice_polygon(&self, item: u32, points: &mut Grid3, extra: Option<(&mut Grid3, &mut Grid3)>) {
        let fans = self.polygon(item);
        // Grid order: (0, 0), (1, 0), (1, 1), (0, 1).
        let places = [(0, 0), (1, 0), (1, 1), (0, 1)];
        for (&fan, (i, j)) in fans.iter().zip(places) {
            points.set(i, j, self.fan_point(fan));
        }
        if let Some((normals, _)) = extra {
            for (&fan, (i, j)) in fans.iter().zip(places) {
                normals.set(i, j, self.object.surface.fan_limit(fan).1);
            }
        }
    }

    /// Vertex and corner number of the four points of a cage block; triangles repeat their last one.
    fn cage_corners(&self, item: u32, block: u32) -> [(u32, u32); 4] {
        let cage = self.object.surface.cage();
        let first = cage.face_offsets[item as usize];
        let face = cage.face(item as usize);
        let corner = |k: u32| (face[k as usize], first + k);
        if face.len() == 4 {
            [corner(0), corner(1), corner(2), corner(3)]
        } else {
            [
                corner(0),
                corner(block + 1),
                corner(block + 2),
                corner(block + 2),
            ]
        }
    }

    fn dice_cage(
        &self,
        item: u32,
        block: u32,
        points: &mut Grid3,
        extra: Option<(&mut Grid3, &mut Grid3)>,
    ) -> bool {
        let cage = self.object.surface.cage();
        let corners = self.cage_corners(item, block);
        let places = [(0, 0), (1, 0), (1, 1), (0, 1)];
        for ((v, _), (i, j)) in corners.iter().zip(places) {
            points.set(i, j, cage.points[*v as usize]);
        }
        let Some((normals, uvs)) = extra else {
            return false;
        };
        for ((_, c), (i, j)) in corners.iter().zip(places) {
            let normal = match cage.corner_normals.get(*c as usize) {
                Some(&n) if n != NONE => cage.normals[n as usize],
                _ => [0.0; 3],
            };
            normals.set(i, j, normal);
            let uv = match cage.corner_uvs.get(*c as usize) {
                Some(&k) if k != NONE => cage.uvs[k as usize],
                _ => [0.0; 2],
            };
            uvs.set(i, j, [uv[0], uv[1], 0.0]);
        }
        !cage.corner_uvs.is_empty()
    }
}
