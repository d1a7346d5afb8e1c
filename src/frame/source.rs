//! Where blocks come from: the quads of a surface at a level, or the polygons of its cage.
//!
//! Items are numbered through all objects of a scene; an item has one or more blocks. This is the one place that knows what an item
//! is; binning, drawing and shading only count them.

use super::Use;
use super::attributes::Attributes;
use super::cage;
use super::leaf;
use super::prepared::SourceScratch;
use super::scene::{Object, Scene};
use super::spot::Shape;
use crate::dice::FacePatch;
use crate::dice::face::{Part, Sides};
use crate::limits::{Budget, LimitError};
use crate::records::{BlockSize, Grid3, SampleId};
use crate::shade::SurfaceMaterial;
use crate::surface::{PolygonBlock, PolygonBlocks, RefinedFans};
use crate::tessellate::Tessellation;
use std::borrow::Cow;

/// What is drawn of each surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Drawing {
    /// Points of the limit surface, or of the patches that the surface has in its place.
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
    pub(super) drawing: Drawing,
    refined: Option<RefinedFans>,
    /// Whether normals are tilted pixel by pixel.
    pub(super) wants_tangents: bool,
    /// Items are its leaves, not quads.
    pub(super) tessellation: Option<Tessellation>,
    /// Of a cage that is drawn as it is, its items, and their micro-triangles but for those of materials that are not drawn.
    polygons: Cow<'a, PolygonBlocks>,
    polygon_triangles: u64,
}

/// Corners of a 2×2 grid in the order of a quad's corners.
pub(super) const CORNERS: [(usize, usize); 4] = [(0, 0), (1, 0), (1, 1), (0, 1)];

impl<'a> Source<'a> {
    /// Sources of all objects, and the number of items. Surfaces are made ready, within `budget`.
    pub(super) fn all(
        scene: &'a Scene,
        (drawing, purpose): (Drawing, Use),
        levels: &[u32],
        tessellations: Vec<Option<Tessellation>>,
        budget: &mut Budget<'_>,
    ) -> Result<(Vec<Self>, u32), LimitError> {
        let (mut first_item, mut first_face) = (0, 0);
        let objects = scene.objects.iter().zip(levels).zip(tessellations);
        let sources = objects.map(|((object, &level), tessellation)| {
            let quad_level = level.saturating_sub(u32::from(object.surface.is_split()));
            // Tessellations have made theirs.
            if drawing != Drawing::Cage && tessellation.is_none() {
                object.surface.try_ensure(quad_level, budget)?;
            }
            let polygons = match drawing {
                Drawing::Cage => {
                    let making = PolygonBlocks::making_bytes(object.surface.cage());
                    budget.take("the blocks of the cage", 0, making)?;
                    cage::blocks(scene, object, purpose == Use::Lines)
                }
                _ => Cow::Owned(PolygonBlocks::default()),
            };
            budget.take("the blocks of the cage", polygons.bytes() as u128, 0)?;
            let is_seen = |b: &&PolygonBlock| {
                let material = scene.materials.get(object.material(b.face) as usize);
                !material.is_some_and(SurfaceMaterial::is_clear)
            };
            let seen = polygons.blocks.iter().filter(is_seen);
            let polygon_triangles = seen.map(|b| u64::from(b.triangles)).sum();
            let refined =
                (drawing == Drawing::Refined).then(|| object.surface.refined_fans(quad_level));
            let source = Source {
                object,
                first_item,
                first_face,
                level,
                drawing,
                refined,
                wants_tangents: object.surface.has_uvs()
                    && (scene.has_relief() || object.is_shaded_by_map()),
                tessellation,
                polygons,
                polygon_triangles,
            };
            first_item += source.item_count();
            first_face += object.surface.cage().face_count() as u32;
            Ok(source)
        });
        let sources = sources.collect::<Result<Vec<_>, LimitError>>()?;
        Ok((sources, first_item))
    }

    pub(super) fn item_count(&self) -> u32 {
        match (self.drawing, &self.tessellation) {
            (_, Some(t)) => t.leaves.len() as u32,
            (Drawing::Cage, _) => self.polygons.blocks.len() as u32,
            _ => self.object.surface.quads().face_count() as u32,
        }
    }

    /// Level of what an item shows, of the cage.
    pub(super) fn level(&self, item: u32) -> u32 {
        match &self.tessellation {
            Some(t) => {
                let split = u32::from(self.object.surface.is_split());
                u32::from(t.leaves[item as usize].level) + split
            }
            None => self.level,
        }
    }

    /// Level 0 of a cage with n-gons: its polygons with limit points at the corners.
    pub(super) fn is_polygonal(&self) -> bool {
        self.tessellation.is_none()
            && self.drawing != Drawing::Cage
            && self.object.surface.is_polygonal(self.level)
    }

    /// Level of the quads.
    pub(super) fn quad_level(&self) -> u32 {
        self.level
            .saturating_sub(u32::from(self.object.surface.is_split()))
    }

    /// Face of the cage that a local item shows, or the first of those; all have the same material.
    pub(super) fn cage_face(&self, item: u32) -> u32 {
        if let Some(t) = &self.tessellation {
            self.object.surface.cage_face(t.leaves[item as usize].quad)
        } else if let Some(block) = self.polygon_block(item) {
            block.face
        } else {
            self.object.surface.cage_face(item)
        }
    }

    /// Of a cage that is drawn as it is, a local item.
    pub(super) fn polygon_block(&self, item: u32) -> Option<&PolygonBlock> {
        self.polygons.blocks.get(item as usize)
    }

    /// Face of the cage that a sample of a local item shows.
    pub(super) fn face_at(&self, item: u32, id: SampleId) -> u32 {
        match self.polygon_block(item) {
            Some(block) => (self.polygons).face_at(self.object.surface.cage(), block, id),
            None => self.cage_face(item),
        }
    }

    /// Whether a local item is drawn at all.
    pub(super) fn is_drawn(&self, item: u32) -> bool {
        if self.tessellation.is_some() || self.drawing == Drawing::Cage {
            return true;
        }
        let surface = &self.object.surface;
        if surface.topology().is_hole(self.cage_face(item)) {
            return false;
        }
        !self.is_polygonal() || surface.stands_for_face(item)
    }

    /// Blocks of an item along each side.
    pub(super) fn blocks(&self) -> [u32; 2] {
        if self.tessellation.is_some() || self.drawing == Drawing::Cage {
            return [1, 1];
        }
        [FacePatch::blocks_per_side(self.quad_level()); 2]
    }

    /// Whether block (`bu`, `bv`) has an area: triangles fill one half of their square of blocks.
    pub(super) fn has_block(&self, [bu, bv]: [u32; 2]) -> bool {
        self.drawing == Drawing::Cage || !self.object.surface.is_triangular() || bv <= bu
    }

    /// What of a block's grid is drawn.
    pub(super) fn shape(&self, item: u32) -> Shape<'_> {
        if self.drawing == Drawing::Cage {
            return Shape::Apart;
        }
        let tessellation = self.tessellation.as_ref();
        match tessellation.and_then(|t| t.list(&t.leaves[item as usize])) {
            Some(list) => Shape::List(&list.triangles),
            None => Shape::Grid,
        }
    }

    pub(super) fn block_size(&self, item: u32) -> BlockSize {
        if let Some(t) = &self.tessellation {
            leaf::block_size(t, item)
        } else if let Some(block) = self.polygon_block(item) {
            block.size()
        } else {
            FacePatch::block_size(self.quad_level())
        }
    }

    /// Points of a block that are evaluated.
    fn point_count(&self, item: u32) -> u64 {
        let n = self.block_size(item);
        match &self.tessellation {
            Some(t) if leaf::is_half(t, &t.leaves[item as usize]) => {
                (n.cols * (n.cols + 1) / 2) as u64
            }
            _ => (n.cols * n.rows) as u64,
        }
    }

    /// Whether dicing a block costs more than drawing and shading it.
    pub(super) fn is_costly(&self) -> bool {
        self.object.surface.displacement().is_some()
    }

    /// Micro-triangles of all items that are drawn.
    pub(super) fn triangles(&self) -> u64 {
        if let Some(t) = &self.tessellation {
            return leaf::triangles(t);
        }
        if self.drawing == Drawing::Cage {
            return self.polygon_triangles;
        }
        let per_face = if self.object.surface.is_triangular() {
            1_u64
        } else {
            2
        };
        let per_quad = per_face << (2 * self.quad_level());
        let drawn = (0..self.item_count()).filter(|&i| self.is_drawn(i));
        drawn.count() as u64 * per_quad
    }

    /// The quad that a local item shows.
    pub(super) fn quad(&self, item: u32) -> u32 {
        match &self.tessellation {
            Some(t) => t.leaves[item as usize].quad,
            None => item,
        }
    }

    /// The parameters of a block's points in its quad, row by row.
    pub(super) fn places(&self, item: u32, [bu, bv]: [u32; 2]) -> Vec<[f32; 2]> {
        if let Some(t) = &self.tessellation {
            return leaf::places(t, item);
        }
        let size = self.block_size(item);
        let scale = 1.0 / (1_u32 << self.quad_level()) as f32;
        let at = |b: u32, n: usize, i: usize| (b as usize * (n - 1) + i) as f32 * scale;
        let all = (0..size.rows).flat_map(|j| {
            (0..size.cols).map(move |i| [at(bu, size.cols, i), at(bv, size.rows, j)])
        });
        all.collect()
    }

    fn prepare(&self, scratch: &mut SourceScratch, item: u32, sides: Sides) {
        let key = (self.first_item + item, sides);
        let ready = scratch
            .prepared
            .is_some_and(|(i, s)| i == key.0 && s >= sides);
        if !ready {
            scratch.leaf = None;
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

    /// Whether items are displaced blocks, where hulls are far larger than what is drawn.
    pub(super) fn has_wide_hulls(&self) -> bool {
        self.tessellation.is_some() && self.object.surface.displacement().is_some()
    }

    /// Object and quad, if this is so deep that preparing it costs about as much as a block of it.
    pub(super) fn group(&self, item: u32) -> Option<(u32, u32)> {
        const DEEP: u8 = 7;
        let leaf = &self.tessellation.as_ref()?.leaves[item as usize];
        (self.has_wide_hulls() && leaf.reach >= DEEP).then_some((self.first_item, leaf.quad))
    }

    /// Corners of the box of what is drawn of a local item with a wide hull: the price is to dice it.
    pub(super) fn drawn_box(
        &self,
        scratch: &mut SourceScratch,
        item: u32,
        out: &mut Vec<[f32; 3]>,
    ) {
        out.clear();
        if let Some(t) = &self.tessellation {
            scratch.diced += self.point_count(item);
            leaf::drawn_box(&self.object.surface, t, item, scratch, out);
        }
    }

    /// Points whose convex hull holds a local item.
    pub(super) fn hull(&self, scratch: &mut SourceScratch, item: u32, out: &mut Vec<[f32; 3]>) {
        out.clear();
        let surface = &self.object.surface;
        if let Some(t) = &self.tessellation {
            leaf::hull(surface, t, item, scratch, out);
        } else if let Some(block) = self.polygon_block(item) {
            self.polygons.hull(surface.cage(), block, out);
        } else if self.is_polygonal() {
            out.extend(surface.polygon_block(item).map(|h| self.corner_point(h)));
        } else {
            self.prepare(scratch, item, Sides::Hull);
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
        self.prepare(scratch, item, Sides::Points);
        scratch.patch.block_hull(bu, bv, |p| out.push(p));
    }

    /// Dices a block: points, and what shading needs where asked for.
    pub(super) fn dice(
        &self,
        scratch: &mut SourceScratch,
        item: u32,
        [bu, bv]: [u32; 2],
        points: &mut Grid3,
        attributes: Option<&mut Attributes>,
    ) {
        scratch.diced += self.point_count(item);
        if let Some(t) = &self.tessellation {
            let attributes = attributes.map(|a| (a, self.wants_tangents));
            return leaf::dice(&self.object.surface, t, item, scratch, points, attributes);
        }
        if let Some(block) = self.polygon_block(item) {
            let cage = self.object.surface.cage();
            return cage::dice(cage, &self.polygons, block, points, attributes);
        }
        if self.is_polygonal() {
            return self.dice_polygon(item, points, attributes);
        }
        let Some(a) = attributes else {
            self.prepare(scratch, item, Sides::Points);
            (scratch.patch).dice(&self.object.surface, bu, bv, points, None);
            return;
        };
        self.prepare(scratch, item, Sides::Normals);
        let (surface, patch) = (&self.object.surface, &mut scratch.patch);
        match a.rows {
            Some(rows) if surface.displacement().is_none() => {
                patch.dice_rows([bu, bv], rows, points, &mut a.normals);
            }
            _ => patch.dice(surface, bu, bv, points, Some(&mut a.normals)),
        }
        if a.wants_uvs && !patch.has_uvs() {
            patch.prepare_uvs(surface, item);
        }
        a.has_uvs = a.wants_uvs && patch.has_uvs();
        if a.has_uvs {
            patch.dice_uvs(bu, bv, &mut a.uvs);
        }
        a.has_tangents = a.has_uvs && self.wants_tangents;
        if a.has_tangents {
            let part = Part::block(self.quad_level(), [bu, bv]);
            let [first, second] = &mut a.tangents;
            patch.dice_tangents(surface, part, first, second);
        }
        a.has_colors = patch.prepare_colors(surface, item);
        if a.has_colors {
            patch.dice_colors(bu, bv, &mut a.colors);
        }
    }

    fn corner_point(&self, h: u32) -> [f32; 3] {
        let surface = &self.object.surface;
        let of_fan = |fans: &RefinedFans| fans.point(surface.quads().fan(h));
        let refined = self.refined.as_ref().and_then(of_fan);
        refined.unwrap_or_else(|| surface.corner_point(h).0)
    }

    fn dice_polygon(&self, item: u32, points: &mut Grid3, attributes: Option<&mut Attributes>) {
        let surface = &self.object.surface;
        let corners = surface.polygon_block(item);
        for (&h, (i, j)) in corners.iter().zip(CORNERS) {
            points.set(i, j, self.corner_point(h));
        }
        let Some(a) = attributes else { return };
        a.has_tangents = false;
        a.has_uvs = a.wants_uvs && surface.has_uvs();
        a.has_colors = !surface.cage().colors.is_empty();
        for (&h, (i, j)) in corners.iter().zip(CORNERS) {
            a.normals.set(i, j, surface.corner_point(h).1);
            a.uvs.set(i, j, surface.uv_limit(h).unwrap_or_default());
            a.colors
                .set(i, j, surface.color_limit(h).unwrap_or_default());
        }
    }
}
