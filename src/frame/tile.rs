//! One tile of a picture from start to end: dice and rasterise the blocks of its bin, then dice again those that are seen and shade
//! their samples, then resolve. Nothing but the tile's pixels leaves it.

use super::Frame;
use super::cutout::{Layers, draw_cutout};
use super::source::{Attributes, Source, SourceScratch};
use super::spot::{Listed, Quad, Spot, draw};
use super::stats::{Stage, StageTimes};
use crate::displace::Displacement;
use crate::film::PixelSum;
use crate::raster::{Key, PixelBox, ProjectedBlock, Tile, bounds, project};
use crate::records::{BLOCK_STRIDE, BlockSize, Grid3, SampleId};
use crate::shade::SurfacePoint;
use crate::simd::Level;

/// A block that was drawn into the tile; its place in the list is its rank.
#[derive(Clone, Copy)]
struct Drawn {
    item: u32,
    block: [u32; 2],
}

/// Buffers of one thread, used for tile after tile.
pub(super) struct Scratch {
    pub(super) tile: Tile<Key>,
    source: SourceScratch,
    pub(super) points: Box<Grid3>,
    pub(super) attributes: Attributes,
    pub(super) footprint: Vec<f32>,
    pub(super) projected: Box<ProjectedBlock>,
    /// Made when the first face with an opacity map is met.
    pub(super) layers: Option<Tile<Layers>>,
    hull: Vec<[f32; 3]>,
    drawn: Vec<Drawn>,
    starts: Vec<u32>,
    order: Vec<Visible>,
    /// Columns of each row that show anything, first and one past the last.
    spans: Vec<[u32; 2]>,
    surface: Vec<SurfacePoint>,
    shaded: Vec<[f32; 4]>,
    colors: Vec<[f32; 4]>,
    pub(super) times: StageTimes,
    simd: Level,
}

impl Scratch {
    pub(super) fn new(samples: u32, simd: Level) -> Self {
        Self {
            tile: Tile::new(0, 0, 0, 0, samples),
            source: SourceScratch::new(simd),
            points: Grid3::boxed(),
            attributes: Attributes::default(),
            footprint: Vec::new(),
            projected: ProjectedBlock::boxed(),
            layers: None,
            hull: Vec::new(),
            drawn: Vec::new(),
            starts: Vec::new(),
            order: Vec::new(),
            spans: Vec::new(),
            surface: Vec::new(),
            shaded: Vec::new(),
            colors: Vec::new(),
            times: StageTimes::default(),
            simd,
        }
    }

    /// Whether the buffers serve a frame of these settings.
    pub(super) fn fits(&self, samples: u32, simd: Level) -> bool {
        self.tile.samples() == samples && self.simd == simd
    }

    /// Drops what belongs to the scene of one frame; the next may have other points.
    pub(super) fn forget_scene(&mut self) {
        self.source.forget();
    }
}

/// Whether a box touches a rectangle of pixels.
fn touches(b: &PixelBox, [x, y, width, height]: [u32; 4]) -> bool {
    b.low[0] < x + width && b.high[0] > x && b.low[1] < y + height && b.high[1] > y
}

/// Hull of a local item on the screen.
pub(super) fn item_box(
    frame: &Frame<'_>,
    source: &Source<'_>,
    item: u32,
    scratch: &mut SourceScratch,
    hull: &mut Vec<[f32; 3]>,
) -> Option<PixelBox> {
    if !source.is_drawn(item) || frame.is_clear(source.object.material(source.cage_face(item))) {
        return None;
    }
    source.hull(scratch, item, hull);
    bounds(hull, &frame.view.projection, frame.size)
}

/// Draws one tile; `pixels` gets its RGBA8 rows. Returns the number of pixels with something in them.
pub(super) fn draw_tile(
    frame: &Frame<'_>,
    tile: usize,
    scratch: &mut Scratch,
    pixels: &mut Vec<u8>,
) -> u64 {
    let rect = frame.grid.rect(tile);
    pixels.clear();
    let items = frame.bins.items(tile);
    if items.is_empty() {
        let empty = frame.film.empty();
        pixels.extend((0..rect[2] as usize * rect[3] as usize).flat_map(|_| empty));
        return 0;
    }
    scratch
        .tile
        .place(rect[0], rect[1], rect[2], rect[3], frame.size.samples);
    scratch.drawn.clear();
    scratch.attributes.wants_uvs = frame.wants_uvs;
    scratch.source.measure(scratch.times.on);
    for &item in items {
        draw_item(frame, item, rect, scratch);
    }
    gather_samples(scratch);
    shade_samples(frame, scratch);
    let clock = scratch.times.start();
    let covered = resolve(frame, rect, scratch, pixels);
    scratch.times.stop(Stage::Film, clock);
    covered
}

fn draw_item(frame: &Frame<'_>, item: u32, rect: [u32; 4], s: &mut Scratch) {
    let source = frame.source_of(item);
    let local = item - source.first_item;
    let size = source.block_size(local);
    let list = source.list(local);
    let cutout = frame.cutout(source.object.material(source.cage_face(local)));
    let [nu, nv] = source.blocks(local);
    for bv in 0..nv {
        for bu in (0..nu).filter(|&bu| source.has_block([bu, bv])) {
            let clock = s.times.start();
            if nu * nv > 1 {
                source.block_hull(&mut s.source, local, [bu, bv], &mut s.hull);
                let seen = bounds(&s.hull, &frame.view.projection, frame.size)
                    .is_some_and(|b| touches(&b, rect));
                if !seen {
                    s.times.stop(Stage::Setup, clock);
                    continue;
                }
            }
            let attributes = cutout.map(|_| &mut s.attributes);
            source.dice(&mut s.source, local, [bu, bv], &mut s.points, attributes);
            let clock = s.times.lap(Stage::Dice, clock);
            s.times
                .shift(Stage::Dice, Stage::Displace, s.source.take_displaced());
            project(
                frame.simd,
                &s.points,
                size,
                &frame.view.projection,
                &mut s.projected,
            );
            let rank = next_rank(s);
            match cutout {
                Some(map) if s.attributes.has_uvs => {
                    footprints(
                        &s.projected,
                        &s.attributes.uvs,
                        list,
                        size,
                        &mut s.footprint,
                    );
                    draw_cutout(frame, s, list, map, rank);
                }
                _ => draw(frame.simd, &mut s.tile, &s.projected, list, rank),
            }
            s.drawn.push(Drawn {
                item,
                block: [bu, bv],
            });
            s.times.stop(Stage::Tile, clock);
        }
    }
}

/// Rank of the next block. When the ranks run out, those of blocks of which nothing is left are given up; the others keep their order.
fn next_rank(s: &mut Scratch) -> u32 {
    if s.drawn.len() < SampleId::MAX_BLOCKS as usize {
        return s.drawn.len() as u32;
    }
    let mut alive = vec![false; s.drawn.len()];
    s.tile.update_ids(|id| {
        alive[id.rank() as usize] = true;
        id
    });
    let mut ranks = vec![0_u32; s.drawn.len()];
    let mut kept = 0;
    for (rank, &alive) in alive.iter().enumerate() {
        ranks[rank] = kept;
        if alive {
            s.drawn[kept as usize] = s.drawn[rank];
            kept += 1;
        }
    }
    s.drawn.truncate(kept as usize);
    s.tile
        .update_ids(|id| SampleId::new(ranks[id.rank() as usize], id.col(), id.row(), id.half()));
    kept
}

/// A visible sample: where it is in the tile, and what it shows.
#[derive(Clone, Copy, Default)]
struct Visible {
    /// Column in bits 0 to 9, row in bits 10 to 19, sample of the pixel above.
    place: u32,
    id: u32,
}

impl Visible {
    fn new(x: u32, y: u32, sample: u32, id: SampleId) -> Self {
        Self {
            place: x | y << 10 | sample << 20,
            id: id.0,
        }
    }
    fn place(self) -> [u32; 3] {
        [self.place & 1023, self.place >> 10 & 1023, self.place >> 20]
    }
}

/// Sorts the tile's visible samples by block: `order[starts[r]..starts[r + 1]]` are those of rank `r`, by counting. Notes for every
/// row the columns that show anything.
fn gather_samples(s: &mut Scratch) {
    let [width, height] = s.tile.size();
    let samples = s.tile.samples();
    s.starts.clear();
    s.starts.resize(s.drawn.len() + 2, 0);
    s.spans.clear();
    s.spans.resize(height as usize, [width, 0]);
    let mut count = 0_usize;
    for sample in 0..samples {
        for y in 0..height {
            let span = &mut s.spans[y as usize];
            for (x, key) in (0..width).zip(s.tile.row(y, sample)) {
                if let Some(id) = key.id() {
                    s.starts[id.rank() as usize + 2] += 1;
                    count += 1;
                    *span = [span[0].min(x), span[1].max(x + 1)];
                }
            }
        }
    }
    for r in 2..s.starts.len() {
        s.starts[r] += s.starts[r - 1];
    }
    s.order.clear();
    s.order.resize(count, Visible::default());
    for sample in 0..samples {
        for y in 0..height {
            let [low, high] = s.spans[y as usize];
            if low >= high {
                continue;
            }
            for (x, key) in (low..high).zip(&s.tile.row(y, sample)[low as usize..high as usize]) {
                if let Some(id) = key.id() {
                    let slot = &mut s.starts[id.rank() as usize + 1];
                    s.order[*slot as usize] = Visible::new(x, y, sample, id);
                    *slot += 1;
                }
            }
        }
    }
}

fn shade_samples(frame: &Frame<'_>, s: &mut Scratch) {
    let [width, height] = s.tile.size();
    let at = |x: u32, y: u32, sample: u32| ((sample * height + y) * width + x) as usize;
    // Only what the spans hold is read again.
    s.colors
        .resize((width * height * s.tile.samples()) as usize, [0.0; 4]);
    for sample in 0..s.tile.samples() {
        for (y, &[low, high]) in (0..height).zip(&s.spans) {
            if low < high {
                s.colors[at(low, y, sample)..at(low, y, sample) + (high - low) as usize]
                    .fill([0.0; 4]);
            }
        }
    }
    for rank in 0..s.drawn.len() {
        let range = s.starts[rank] as usize..s.starts[rank + 1] as usize;
        if range.is_empty() {
            continue;
        }
        let clock = s.times.start();
        let Drawn { item, block } = s.drawn[rank];
        let source = frame.source_of(item);
        let local = item - source.first_item;
        let (size, list) = (source.block_size(local), source.list(local));
        source.dice(
            &mut s.source,
            local,
            block,
            &mut s.points,
            Some(&mut s.attributes),
        );
        project(
            frame.simd,
            &s.points,
            size,
            &frame.view.projection,
            &mut s.projected,
        );
        if s.attributes.has_uvs {
            footprints(
                &s.projected,
                &s.attributes.uvs,
                list,
                size,
                &mut s.footprint,
            );
        }
        let clock = s.times.lap(Stage::Dice, clock);
        (s.times).shift(Stage::Dice, Stage::Displace, s.source.take_displaced());
        let face = source.cage_face(local);
        let template = SurfacePoint {
            face: source.first_face + face,
            level: source.level(local),
            material: source.object.material(face),
            ..SurfacePoint::default()
        };
        s.surface.clear();
        let [x0, y0] = s.tile.origin();
        for v in &s.order[range.clone()] {
            let ([x, y, sample], id) = (v.place(), SampleId(v.id));
            let at = [x0 + x, y0 + y, sample];
            let samples = frame.size.samples;
            s.surface.push(match list {
                None => {
                    let spot = Quad::new(&s.projected, id, at, samples);
                    surface_point(
                        frame,
                        source,
                        (&s.points, &s.attributes, &s.footprint),
                        spot,
                        template,
                    )
                }
                Some(list) => {
                    let spot = Listed::new(&s.projected, list, id, at, samples);
                    surface_point(
                        frame,
                        source,
                        (&s.points, &s.attributes, &s.footprint),
                        spot,
                        template,
                    )
                }
            });
        }
        s.shaded.clear();
        s.shaded.resize(s.surface.len(), [0.0; 4]);
        frame.shader.shade_all(&s.surface, &mut s.shaded);
        for (v, &color) in s.order[range].iter().zip(&s.shaded) {
            let [x, y, sample] = v.place();
            s.colors[at(x, y, sample)] = color;
        }
        s.times.stop(Stage::Shade, clock);
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
fn footprints(
    block: &ProjectedBlock,
    uvs: &Grid3,
    list: Option<&[[u16; 3]]>,
    size: BlockSize,
    out: &mut Vec<f32>,
) {
    if let Some(list) = list {
        return list_footprints(block, uvs, list, size, out);
    }
    out.clear();
    out.resize((size.rows + 1) * BLOCK_STRIDE, 0.0);
    let step = |k: usize, n: usize| (k.saturating_sub(1), (k + 1).min(n - 1));
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

/// Averages samples into pixels. Returns how many pixels show something.
fn resolve(frame: &Frame<'_>, rect: [u32; 4], s: &Scratch, pixels: &mut Vec<u8>) -> u64 {
    let samples = frame.size.samples;
    let (width, plane) = (rect[2] as usize, (rect[2] * rect[3]) as usize);
    let empty = frame.film.empty();
    pixels.resize(plane * 4, 0);
    let mut covered = 0;
    for (y, line) in pixels.chunks_exact_mut(width * 4).enumerate() {
        let [low, high] = s.spans[y].map(|x| x as usize);
        let blank = |line: &mut [u8]| {
            line.chunks_exact_mut(4)
                .for_each(|p| p.copy_from_slice(&empty))
        };
        if low >= high {
            blank(line);
            continue;
        }
        blank(&mut line[..low * 4]);
        blank(&mut line[high * 4..]);
        for (x, pixel) in (low..high).zip(line[low * 4..high * 4].chunks_exact_mut(4)) {
            let mut sum = PixelSum::default();
            for k in 0..samples as usize {
                sum.add(s.colors[k * plane + y * width + x]);
            }
            let color = sum.mean(samples);
            if color[3] > 0.0 {
                covered += 1;
                pixel.copy_from_slice(&frame.film.pixel(color));
            } else {
                pixel.copy_from_slice(&empty);
            }
        }
    }
    covered
}
