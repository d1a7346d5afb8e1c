//! The second half of a tile: blocks that are seen are diced again with what shading needs, unless they were kept, their fragments get
//! colours, and pixels their bytes.
//!
//! What most pictures are full of, opaque surfaces under light without textures, goes in lanes from the samples' ids to colours, or to
//! bytes where a pixel has one sample. Everything else goes by [`SurfacePoint`]s.

use super::source::{Attributes, Source};
use super::spot::{self, Listed, Quad, Shape, Spot};
use super::stats::Stage;
use super::tile::{Drawn, Scratch};
use super::visible::Fragment;
use super::{Frame, aov};
use crate::dispatch;
use crate::displace::Displacement;
use crate::raster::{
    CornerLanes, PairedBlock, ProjectedBlock, SampleLanes, project_rows, sample_positions,
};
use crate::records::{BLOCK_STRIDE, BlockSize, Grid3, SampleId};
use crate::shade::{ShadeMode, SurfacePoint, has_direction};
use crate::simd::{LANES, bits, flag};
use std::ops::Range;

/// Micro-quads by which samples of a pixel may be apart to be shaded together, as a part of a block's side: an eighth.
const REACH: usize = 8;

/// See [`REACH`]; in micro-quads.
pub(super) fn reach(size: BlockSize) -> u8 {
    ((size.cols.max(size.rows) - 1) / REACH) as u8
}

/// Colours of fragments on their way to pixels.
#[derive(Debug, Default)]
pub(super) struct Pixels {
    /// Pixels of the tile, row by row.
    bytes: Vec<[u8; 4]>,
    /// Where a pixel has several samples: their colours added up.
    sums: Vec<[f32; 4]>,
    width: usize,
}

impl Pixels {
    /// Makes the pixels of a tile empty, as far as spans of its rows reach; no others are read.
    fn clear(&mut self, width: u32, spans: &[[u32; 2]], several: bool, empty: [u8; 4]) {
        self.width = width as usize;
        let len = self.width * spans.len();
        if self.bytes.len() < len {
            self.bytes.resize(len, empty);
        }
        if several && self.sums.len() < len {
            self.sums.resize(len, [0.0; 4]);
        }
        for (y, &[low, high]) in (0..).zip(spans) {
            let range = self.range(y, low, high);
            if several {
                self.sums[range.clone()].fill([0.0; 4]);
            }
            self.bytes[range].fill(empty);
        }
    }

    #[inline(always)]
    fn range(&self, y: usize, low: u32, high: u32) -> Range<usize> {
        let row = y * self.width;
        // Spans of empty rows end before they begin.
        row + low.min(high) as usize..row + high as usize
    }

    /// Pixels of a row.
    pub(super) fn row(&self, y: usize, low: u32, high: u32) -> &[[u8; 4]] {
        &self.bytes[self.range(y, low, high)]
    }

    #[inline(always)]
    fn index(&self, f: Fragment) -> usize {
        f.y() as usize * self.width + f.x() as usize
    }
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

/// A block whose fragments are lit in lanes.
struct LitBlock<'a> {
    points: &'a Grid3,
    paired: &'a PairedBlock,
    attributes: &'a Attributes,
    origin: [u32; 2],
    albedo: [f32; 3],
}

/// Groups of lanes that go through each step together. A step's result is long in coming, and the next group's step does not wait for
/// it; one group through all steps would leave the processor with nothing else to do.
pub(super) const GROUPS: usize = 8;

/// Sixteen fragments between steps, aligned for vectors.
#[derive(Clone, Copy, Default)]
#[repr(align(64))]
pub(super) struct LitGroup {
    ids: [u32; LANES],
    x: [i32; LANES],
    y: [i32; LANES],
    /// Places in the tile's pixels.
    pixels: [u32; LANES],
    corners: CornerLanes,
    side: [f32; LANES],
    normals: [[f32; LANES]; 3],
    /// Colour of the surface, then its light.
    colors: [[f32; LANES]; 3],
    /// Pixels of that light alone.
    codes: [u32; LANES],
}

#[inline(always)]
fn lit_fragments(
    frame: &Frame<'_>,
    block: &LitBlock<'_>,
    fragments: &[Fragment],
    groups: &mut [LitGroup; GROUPS],
    pixels: &mut Pixels,
) {
    for chunk in fragments.chunks(GROUPS * LANES) {
        let groups = &mut groups[..chunk.len().div_ceil(LANES)];
        let (whole, rest) = chunk.as_chunks::<LANES>();
        // The last group is filled up with its last fragment.
        let mut last = [rest.last().copied().unwrap_or_default(); LANES];
        last[..rest.len()].copy_from_slice(rest);
        let filled = (!rest.is_empty()).then_some(&last);
        for (lanes, group) in whole.iter().chain(filled).zip(&mut *groups) {
            group.place(frame, block, lanes, pixels.width);
        }
        for group in &mut *groups {
            group.corners.fetch(block.paired, &group.ids);
        }
        for group in &mut *groups {
            group.find_surface(frame, block);
        }
        for g in &mut *groups {
            let light = (frame.shader).light_lanes(&g.normals, &g.side, &g.x, &g.y, &g.colors);
            g.colors = light;
        }
        for group in &mut *groups {
            group.codes = frame.film.opaque_lanes(&group.colors);
        }
        for (fragments, group) in chunk.chunks(LANES).zip(&*groups) {
            group.keep(frame, fragments, pixels);
        }
    }
}

impl LitGroup {
    /// Where fragments are on the screen.
    #[inline(always)]
    fn place(
        &mut self,
        frame: &Frame<'_>,
        block: &LitBlock<'_>,
        lanes: &[Fragment; LANES],
        width: usize,
    ) {
        let samples = frame.size.samples;
        let positions = sample_positions(samples);
        for l in 0..LANES {
            let f = lanes[l];
            self.ids[l] = f.id();
            self.pixels[l] = f.y() * width as u32 + f.x();
            self.x[l] = (block.origin[0] + f.x()) as i32 * 256;
            self.y[l] = (block.origin[1] + f.y()) as i32 * 256;
        }
        if samples == 1 {
            for l in 0..LANES {
                self.x[l] += positions[0][0];
                self.y[l] += positions[0][1];
            }
        } else {
            for l in 0..LANES {
                let [ox, oy] = positions[lanes[l].sample() as usize];
                self.x[l] += ox;
                self.y[l] += oy;
            }
        }
    }

    /// Normals, sides and colours of the surface at the fragments.
    #[inline(always)]
    fn find_surface(&mut self, frame: &Frame<'_>, block: &LitBlock<'_>) {
        let (x, y) = (&self.x, &self.y);
        let at = SampleLanes::new(block.paired, &self.corners, &self.ids, x, y);
        let mut bad = [0; LANES];
        for l in 0..LANES {
            let n = [at.normals[0][l], at.normals[1][l], at.normals[2][l]];
            bad[l] = flag(!has_direction(n));
        }
        self.normals = at.normals;
        self.side = at.side;
        self.colors = albedo_lanes(block, &at);
        let bad = bits(&bad);
        if bad != 0 {
            self.mend_normals(frame, block, bad);
        }
    }

    /// Gives samples whose normal has no direction, the lanes in `bad`, that of their micro-triangle, or one to the eye.
    #[cold]
    fn mend_normals(&mut self, frame: &Frame<'_>, block: &LitBlock<'_>, mut bad: u32) {
        while bad != 0 {
            let l = bad.trailing_zeros() as usize & (LANES - 1);
            bad &= bad - 1;
            let mut n = spot::geometric(block.points, SampleId(self.ids[l]));
            if !has_direction(n) {
                let to_eye = frame.shader.to_eye(self.x[l], self.y[l]);
                n = to_eye.map(|c| c * self.side[l].signum());
            }
            for (lanes, n) in self.normals.iter_mut().zip(n) {
                lanes[l] = n;
            }
        }
    }

    /// Puts the light where its pixels are kept.
    #[inline(always)]
    fn keep(&self, frame: &Frame<'_>, fragments: &[Fragment], pixels: &mut Pixels) {
        let samples = frame.size.samples;
        if samples == 1 {
            for l in 0..fragments.len() {
                pixels.bytes[self.pixels[l] as usize] = self.codes[l].to_le_bytes();
            }
            return;
        }
        for (l, f) in fragments.iter().enumerate() {
            let k = self.pixels[l] as usize;
            if f.count() == samples {
                // Times a power of two and divided by it: the same.
                pixels.bytes[k] = self.codes[l].to_le_bytes();
                continue;
            }
            let n = f.count() as f32;
            let sum = &mut pixels.sums[k];
            for c in 0..3 {
                sum[c] += crate::math::saturate(self.colors[c][l]) * n;
            }
            sum[3] += n;
        }
    }
}

/// Colours of the surface at the samples, linear.
#[inline(always)]
fn albedo_lanes(block: &LitBlock<'_>, at: &SampleLanes) -> [[f32; LANES]; 3] {
    let mut albedo = block.albedo.map(|c| [c; LANES]);
    if block.attributes.has_colors {
        let colors = at.interpolate(&block.attributes.colors);
        for (a, c) in albedo.iter_mut().zip(colors) {
            for l in 0..LANES {
                a[l] *= crate::math::positive(c[l]);
            }
        }
    }
    albedo
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

/// Per grid point the side of the square in texture coordinates that covers the area of a pixel, from differences along the grid.
pub(super) fn footprints(
    block: &ProjectedBlock,
    uvs: &Grid3,
    shape: Shape<'_>,
    size: BlockSize,
    out: &mut Vec<f32>,
) {
    if let Some(list) = shape.list() {
        return list_footprints(block, uvs, list, size, out);
    }
    out.clear();
    out.resize((size.rows + 1) * BLOCK_STRIDE, 0.0);
    let step = |k: usize, n: usize| match shape {
        Shape::Apart => (k & !1, k | 1),
        Shape::Grid | Shape::List(_) => (k.saturating_sub(1), (k + 1).min(n - 1)),
    };
    for j in 0..size.rows {
        let (j0, j1) = step(j, size.rows);
        for i in 0..size.cols {
            let (i0, i1) = step(i, size.cols);
            let screen = |a: [i32; 2], b: [i32; 2]| {
                [(b[0] - a[0]) as f32 / 256.0, (b[1] - a[1]) as f32 / 256.0]
            };
            let su = screen(block.position(i0, j), block.position(i1, j));
            let sv = screen(block.position(i, j0), block.position(i, j1));
            let uv = |a: [f32; 3], b: [f32; 3]| [b[0] - a[0], b[1] - a[1]];
            let tu = uv(uvs.get(i0, j), uvs.get(i1, j));
            let tv = uv(uvs.get(i, j0), uvs.get(i, j1));
            let pixels = (su[0] * sv[1] - su[1] * sv[0]).abs();
            let texture = (tu[0] * tv[1] - tu[1] * tv[0]).abs();
            // A grid cell seen edge-on has no area: do not let its footprint run away.
            out[j * BLOCK_STRIDE + i] = (texture / pixels.max(1.0 / 256.0)).sqrt();
        }
    }
}

/// The same at the points of a list of triangles: from the areas of those around each.
fn list_footprints(
    block: &ProjectedBlock,
    uvs: &Grid3,
    list: &[[u16; 3]],
    size: BlockSize,
    out: &mut Vec<f32>,
) {
    let count = (size.rows + 1) * BLOCK_STRIDE;
    let mut areas = vec![[0.0_f32; 2]; count];
    for t in list {
        let at = t.map(|k| [usize::from(k) % BLOCK_STRIDE, usize::from(k) / BLOCK_STRIDE]);
        let p = at.map(|[i, j]| block.position(i, j).map(|c| c as f32 / 256.0));
        let uv = at.map(|[i, j]| uvs.get(i, j)).map(|[u, v, _]| [u, v]);
        let area = |p: [[f32; 2]; 3]| {
            let (a, b) = (
                [p[1][0] - p[0][0], p[1][1] - p[0][1]],
                [p[2][0] - p[0][0], p[2][1] - p[0][1]],
            );
            (a[0] * b[1] - a[1] * b[0]).abs()
        };
        let [texture, pixels] = [area(uv), area(p)];
        for &k in t {
            areas[usize::from(k)][0] += texture;
            areas[usize::from(k)][1] += pixels;
        }
    }
    out.clear();
    let side = |[texture, pixels]: [f32; 2]| (texture / pixels.max(1.0 / 256.0)).sqrt();
    out.extend(areas.into_iter().map(side));
}

/// Averages the samples of pixels that have several; those that are of one colour have their bytes.
pub(super) fn resolve(frame: &Frame<'_>, s: &mut Scratch) {
    let samples = frame.size.samples;
    if samples == 1 {
        return;
    }
    let share = 1.0 / samples as f32;
    for (y, &[low, high]) in s.visible.spans.iter().enumerate() {
        let range = s.pixels.range(y, low, high);
        let sums = &s.pixels.sums[range.clone()];
        for (sum, pixel) in sums.iter().zip(&mut s.pixels.bytes[range]) {
            if sum[3] > 0.0 {
                *pixel = frame.film.pixel(sum.map(|c| c * share));
            }
        }
    }
}
