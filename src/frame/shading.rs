//! The second half of a tile: blocks that are seen are diced again with what shading needs, unless they were kept, their fragments get
//! colours, and pixels their bytes.
//!
//! What most pictures are full of, opaque surfaces under light without textures, goes in lanes ([`lit`](super::lit)); everything else by
//! [`SurfacePoint`]s.

use super::attributes::Attributes;
use super::footprint::footprints;
use super::lit::{LitBlock, lit_fragments};
use super::source::Source;
use super::spot::{Listed, Quad, Spot};
use super::stats::Stage;
use super::tile::{Drawn, Scratch};
use super::visible::Fragment;
use super::{Frame, aov};
use crate::dispatch;
use crate::displace::Displacement;
use crate::raster::{ProjectedBlock, project_rows};
use crate::records::{BlockSize, Grid3, SampleId};
use crate::shade::{ShadeMode, SurfacePoint};

/// Micro-quads by which samples of a pixel may be apart to be shaded together, as a part of a block's side: an eighth.
const REACH: usize = 8;

/// See [`REACH`]; in micro-quads.
pub(super) fn reach(size: BlockSize) -> u8 {
    ((size.cols.max(size.rows) - 1) / REACH) as u8
}

/// Shades what `visible` holds.
pub(super) fn shade(frame: &Frame<'_>, s: &mut Scratch) {
    let several = frame.size.samples > 1;
    let [width, _] = s.tile.size();
    (s.pixels).clear(width, &s.visible.spans, several, frame.film.empty());
    for rank in 0..s.drawn.len() {
        if s.visible.of_rank(rank).is_empty() {
            continue;
        }
        shade_block(frame, s, rank);
    }
}

/// Dices a block again and shades its fragments.
fn shade_block(frame: &Frame<'_>, s: &mut Scratch, rank: usize) {
    let clock = s.times.start();
    let Drawn {
        item,
        block,
        clipped,
    } = s.drawn[rank];
    let source = frame.source_of(item);
    let local = item - source.first_item;
    let (size, shape) = (source.block_size(local), source.shape(local));
    let list = shape.list();
    let lit = frame.shader.mode() == ShadeMode::Lit && frame.wanted.aovs.is_empty();
    let in_part = lit && list.is_none() && !clipped && !s.attributes.wants_uvs;
    let seen = in_part.then(|| seen_rows(s.visible.of_rank(rank)));
    if !s.kept.take(rank as u32, &mut s.points, &mut s.attributes) {
        s.attributes.rows = seen;
        let attributes = Some(&mut s.attributes);
        source.dice(&mut s.source, local, block, &mut s.points, attributes);
        s.attributes.rows = None;
    }
    let [first, last] = seen.unwrap_or([0, size.rows as u32 - 1]);
    let rows = first as usize..last as usize + 1;
    project_rows(
        frame.simd,
        &s.points,
        (size, rows.clone()),
        &frame.view.projection,
        &mut s.projected,
    );
    if s.attributes.has_uvs {
        footprints(
            &s.projected,
            &s.attributes.uvs,
            shape,
            size,
            &mut s.footprint,
        );
    }
    // Coordinates that only an output beside the picture wants must not change how the picture is shaded.
    let has_uvs = s.attributes.has_uvs;
    s.attributes.has_uvs &= frame.wants_uvs;
    let clock = s.times.lap(Stage::Dice, clock);
    (s.times).shift(Stage::Dice, Stage::Displace, s.source.take_displaced());
    let face = source.cage_face(local);
    let template = SurfacePoint {
        face: source.first_face + face,
        level: source.level(local),
        material: source.object.material(face),
        ..SurfacePoint::default()
    };
    let a = &s.attributes;
    let plain = list.is_none() && !a.has_uvs && !a.has_tangents && !s.projected.is_clipped();
    if plain && frame.shader.mode() == ShadeMode::Lit {
        let albedo = frame.shader.albedo(&template);
        let fragments = s.visible.of_rank(rank);
        s.paired
            .fill(frame.simd, &s.projected, &s.attributes.normals, rows);
        let block = LitBlock {
            points: &s.points,
            paired: &s.paired,
            attributes: &s.attributes,
            origin: s.tile.origin(),
            albedo: [albedo[0], albedo[1], albedo[2]],
        };
        dispatch!(
            frame.simd,
            lit_fragments(frame, &block, fragments, &mut s.lit, &mut s.pixels)
        );
    } else {
        shade_points(frame, source, s, rank, template);
    }
    if !frame.wanted.aovs.is_empty() {
        s.attributes.has_uvs = has_uvs;
        aov::record(frame, source, s, rank, template);
    }
    s.times.stop(Stage::Shade, clock);
}

/// First and last row of points of the micro-quads that fragments of a block show.
fn seen_rows(fragments: &[Fragment]) -> [u32; 2] {
    let (mut first, mut last) = (u32::MAX, 0);
    for f in fragments {
        let row = SampleId(f.id()).row();
        first = first.min(row);
        last = last.max(row);
    }
    [first.min(last), last + 1]
}

/// Fragments of a block point by point.
fn shade_points(
    frame: &Frame<'_>,
    source: &Source<'_>,
    s: &mut Scratch,
    rank: usize,
    template: SurfacePoint,
) {
    let samples = frame.size.samples;
    let item = s.drawn[rank].item - source.first_item;
    let block = Shown {
        points: &s.points,
        attributes: &s.attributes,
        footprint: &s.footprint,
        projected: &s.projected,
        item,
        list: source.shape(item).list(),
        origin: s.tile.origin(),
    };
    s.surface.clear();
    for &f in s.visible.of_rank(rank) {
        s.surface.push(block.point(frame, source, f, template));
    }
    s.shaded.clear();
    s.shaded.resize(s.surface.len(), [0.0; 4]);
    frame.shader.shade_all(&s.surface, &mut s.shaded);
    for (&f, color) in s.visible.of_rank(rank).iter().zip(&s.shaded) {
        let k = s.pixels.index(f);
        if samples == 1 {
            s.pixels.bytes[k] = frame.film.pixel(*color);
        } else {
            let n = f.count() as f32;
            for (sum, c) in s.pixels.sums[k].iter_mut().zip(color) {
                *sum += c * n;
            }
        }
    }
}

/// A block that is seen, diced and projected.
pub(super) struct Shown<'a> {
    pub(super) points: &'a Grid3,
    pub(super) attributes: &'a Attributes,
    pub(super) footprint: &'a [f32],
    pub(super) projected: &'a ProjectedBlock,
    /// Of the source.
    pub(super) item: u32,
    /// Its triangles, where it is no grid.
    pub(super) list: Option<&'a [[u16; 3]]>,
    /// Upper left pixel of the tile.
    pub(super) origin: [u32; 2],
}

impl Shown<'_> {
    /// The surface at the first sample of a fragment.
    #[inline]
    pub(super) fn point(
        &self,
        frame: &Frame<'_>,
        source: &Source<'_>,
        f: Fragment,
        template: SurfacePoint,
    ) -> SurfacePoint {
        let (id, samples) = (SampleId(f.id()), frame.size.samples);
        let template = SurfacePoint {
            face: source.first_face + source.face_at(self.item, id),
            ..template
        };
        let at = [self.origin[0] + f.x(), self.origin[1] + f.y(), f.sample()];
        let block = (self.points, self.attributes, self.footprint);
        match self.list {
            None => {
                let spot = Quad::new(self.projected, id, at, samples);
                surface_point(frame, source, block, spot, template)
            }
            Some(list) => {
                let spot = Listed::new(self.projected, list, id, at, samples);
                surface_point(frame, source, block, spot, template)
            }
        }
    }
}

/// The surface at a sample of a block.
#[inline]
fn surface_point(
    frame: &Frame<'_>,
    source: &Source<'_>,
    (points, a, footprint): (&Grid3, &Attributes, &[f32]),
    spot: impl Spot,
    template: SurfacePoint,
) -> SurfacePoint {
    let position = spot.mix3(points);
    let uv = a.has_uvs.then(|| [spot.mix(&a.uvs.x), spot.mix(&a.uvs.y)]);
    let mut point = SurfacePoint {
        position,
        normal: spot.mix3(&a.normals),
        geometric: spot.geometric(points),
        uv,
        uv_footprint: if uv.is_some() {
            spot.mix(footprint)
        } else {
            0.0
        },
        // The limit of colours may leave the range of its control values by rounding only, but files may hold anything.
        color: if a.has_colors {
            spot.mix3(&a.colors).map(|c| c.max(0.0))
        } else {
            [1.0; 3]
        },
        depth01: frame.view.depth01(frame.view.distance(position)),
        ..template
    };
    if a.has_tangents {
        relief(source, a, &spot, &mut point);
    }
    point
}

/// What tilts the normal of a point: given to shading, or done at once where the displacement's map says it.
fn relief(source: &Source<'_>, a: &Attributes, spot: &impl Spot, point: &mut SurfacePoint) {
    let tangents = [0, 1].map(|k| spot.mix3(&a.tangents[k]));
    let map = (source.object.surface.displacement()).and_then(Displacement::pixel_map);
    match (map, point.uv) {
        (Some(map), Some([u, v])) => {
            let [du, dv] = map.slope_over(u, v, point.uv_footprint);
            let [first, second] = tangents;
            point.normal = [0, 1, 2].map(|k| point.normal[k] - (first[k] * du + second[k] * dv));
        }
        _ => point.tangents = Some(tangents),
    }
}
