//! One tile of a picture from start to end: dice and rasterise the blocks of its bin, then dice again those that are seen and shade
//! their samples, then resolve. Nothing but the tile's pixels leaves it.
//!
//! Items are drawn nearest first, and what lies wholly behind samples that were drawn is not diced. Keys decide what is seen whatever
//! the order, and ranks are given in (face, block) order before, so the picture is that of drawing everything.

use super::Frame;
use super::aov::{self, TilePlanes};
use super::attributes::Attributes;
use super::cutout::{Layers, draw_cutout};
use super::footprint::footprints;
use super::kept::Kept;
use super::lit::{GROUPS, LitGroup};
use super::pixels::{self, Pixels};
use super::prepared::SourceScratch;
use super::shading;
use super::source::Source;
use super::spot::{Shape, draw};
use super::stats::{Stage, StageTimes};
use super::visible::Visible;
use crate::raster::{Key, PairedBlock, PixelBox, ProjectedBlock, Tile, bounds, project};
use crate::records::{Grid3, SampleId};
use crate::shade::{ShadeMode, SurfacePoint};
use crate::simd::Level;
use std::cmp::Reverse;
use std::sync::OnceLock;

/// A block that was drawn into the tile; its place in the list is its rank.
#[derive(Clone, Copy, Default)]
pub(super) struct Drawn {
    pub(super) item: u32,
    pub(super) block: [u32; 2],
    /// Some of its points are not on the screen.
    pub(super) clipped: bool,
}

/// Buffers of one thread, used for tile after tile.
pub(super) struct Scratch {
    pub(super) tile: Tile<Key>,
    pub(super) source: SourceScratch,
    pub(super) points: Box<Grid3>,
    pub(super) attributes: Attributes,
    pub(super) footprint: Vec<f32>,
    pub(super) projected: Box<ProjectedBlock>,
    pub(super) paired: Box<PairedBlock>,
    /// Made when the first face with an opacity map is met.
    pub(super) layers: Option<Tile<Layers>>,
    pub(super) hull: Vec<[f32; 3]>,
    pub(super) drawn: Vec<Drawn>,
    pub(super) kept: Kept,
    /// Items of the tile, nearest first, each with the rank of its first block.
    queue: Vec<Queued>,
    /// Per rank, how far apart on the block samples are shaded together.
    reach: Vec<u8>,
    pub(super) visible: Visible,
    pub(super) surface: Vec<SurfacePoint>,
    pub(super) shaded: Vec<[f32; 4]>,
    pub(super) lit: Box<[LitGroup; GROUPS]>,
    pub(super) pixels: Pixels,
    pub(super) planes: TilePlanes,
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
            paired: PairedBlock::boxed(),
            layers: None,
            hull: Vec::new(),
            drawn: Vec::new(),
            kept: Kept::default(),
            queue: Vec::new(),
            reach: Vec::new(),
            visible: Visible::default(),
            surface: Vec::new(),
            shaded: Vec::new(),
            lit: Box::default(),
            pixels: Pixels::default(),
            planes: TilePlanes::default(),
            times: StageTimes::default(),
            simd,
        }
    }

    /// Whether the buffers serve a frame of these settings.
    pub(super) fn fits(&self, samples: u32, simd: Level) -> bool {
        self.tile.samples() == samples && self.simd == simd
    }

    /// What of the tile's rows shows anything: the first column and the pixels from there on.
    pub(super) fn shown_rows(&self) -> impl Iterator<Item = (u32, &[[u8; 4]])> {
        let spans = &self.visible.spans;
        (0..)
            .zip(spans)
            .map(|(y, &[low, high])| (low, self.pixels.row(y, low, high)))
    }

    /// Drops what belongs to the scene of one frame; the next may have other points.
    pub(super) fn forget_scene(&mut self) {
        self.source.forget();
    }
}

/// Whether a box touches a rectangle of pixels.
pub(super) fn touches(b: &PixelBox, [x, y, width, height]: [u32; 4]) -> bool {
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
    let on_screen = |hull: &[[f32; 3]]| bounds(hull, &frame.view.projection, frame.size);
    if source.has_wide_hulls() && frame.seen.is_empty() {
        source.drawn_box(scratch, item, hull);
        return on_screen(hull);
    }
    source.hull(scratch, item, hull);
    let found = on_screen(hull)?;
    if source.has_wide_hulls() && frame.grid.touches(&found) > WIDE {
        source.drawn_box(scratch, item, hull);
        return on_screen(hull);
    }
    Some(found)
}

/// Tiles that the hull of a displaced block may touch. Tiles find out where the block really is when they dice it; those of a hull across all
/// of the picture would all have to ask.
const WIDE: u64 = 6;

/// Where an item may be, as far as that is known by now.
fn known_box(frame: &Frame<'_>, item: u32) -> Option<PixelBox> {
    let seen = frame.seen.get(item as usize).and_then(OnceLock::get);
    seen.copied().or(frame.boxes[item as usize])
}

/// An item that waits to be drawn.
#[derive(Clone, Copy)]
struct Queued {
    item: u32,
    rank: u32,
    /// Bits of its nearest depth.
    nearest: u32,
    /// Bits of the nearest depth, and rank of the first, of the displaced blocks of a deep face: preparing it costs as much as a block, so
    /// they follow each other. Else its own.
    group: (u32, u32),
}

/// Draws one tile; its RGBA8 pixels are in [`Scratch::shown_rows`] then, and all others are empty. Returns the number of pixels with
/// something in them.
pub(super) fn draw_tile(frame: &Frame<'_>, tile: usize, s: &mut Scratch) -> u64 {
    let rect = frame.grid.rect(tile);
    s.planes.clear(&frame.wanted, [rect[2], rect[3]]);
    s.kept.open();
    let is_touched = rasterise(frame, tile, rect, s);
    s.kept.close();
    if !is_touched {
        s.visible.spans.clear();
        return 0;
    }
    let clock = s.times.start();
    s.reach.clear();
    if frame.size.samples > 1 && frame.shader.mode() == ShadeMode::Lit {
        for d in &s.drawn {
            let source = frame.source_of(d.item);
            let size = source.block_size(d.item - source.first_item);
            // Elsewhere ids say nothing about distances.
            let reach = match source.shape(d.item - source.first_item) {
                Shape::Grid => shading::reach(size),
                Shape::Apart | Shape::List(_) => 0,
            };
            s.reach.push(reach);
        }
    }
    s.visible
        .gather(frame.simd, &s.tile, s.drawn.len(), &s.reach);
    aov::gather(frame, s);
    s.times.stop(Stage::Shade, clock);
    shading::shade(frame, s);
    let clock = s.times.start();
    pixels::resolve(frame, s);
    s.times.stop(Stage::Film, clock);
    s.visible.pixels
}

/// Visibility keys of one tile, in [`Scratch::tile`], over `rect`: the tile's own or a larger one, in which what does not touch the tile is
/// missing. False where nothing touches it.
pub(super) fn rasterise(frame: &Frame<'_>, tile: usize, rect: [u32; 4], s: &mut Scratch) -> bool {
    let items = frame.bins.items(tile);
    s.tile
        .place(rect[0], rect[1], rect[2], rect[3], frame.size.samples);
    s.drawn.clear();
    if items.is_empty() {
        return false;
    }
    s.attributes.wants_uvs = frame.wants_uvs || frame.wanted.wants(aov::Aov::Uv);
    s.source.measure(s.times.on);
    if queue(frame, items, s) {
        for k in 0..s.queue.len() {
            let Queued { item, rank, .. } = s.queue[k];
            draw_item(frame, item, rect, Some(rank), s);
        }
    } else {
        for &item in items {
            draw_item(frame, item, rect, None, s);
        }
    }
    true
}

/// Gives every block of the tile its rank, in (face, block) order, and queues the items nearest first, so that what lies behind is
/// noticed before it is diced. False where ranks do not suffice: they are given while drawing then.
fn queue(frame: &Frame<'_>, items: &[u32], s: &mut Scratch) -> bool {
    s.queue.clear();
    let mut ranks = 0_u64;
    let (mut last, mut leader) = (None, 0);
    for &item in items {
        let source = frame.source_of(item);
        let [nu, nv] = source.blocks();
        let nearest = frame.boxes[item as usize].map_or(0, |b| b.nearest.to_bits());
        s.queue.push(Queued {
            item,
            rank: ranks as u32,
            nearest,
            group: (nearest, ranks as u32),
        });
        let face = source.group(item - source.first_item);
        if face.is_none() || face != last {
            (last, leader) = (face, s.queue.len() - 1);
        }
        let group = &mut s.queue[leader].group;
        group.0 = group.0.max(nearest);
        let rank = group.1;
        if let Some(own) = s.queue.last_mut() {
            own.group.1 = rank;
        }
        ranks += u64::from(nu) * u64::from(nv);
        if ranks > u64::from(SampleId::MAX_BLOCKS) {
            return false;
        }
    }
    let mut group = (0, 0);
    for q in &mut s.queue {
        if q.group.1 == q.rank {
            group = q.group;
        }
        q.group = group;
    }
    s.drawn.resize(ranks as usize, Drawn::default());
    // Depths are positive: their bits have their order.
    s.queue
        .sort_unstable_by_key(|q| (Reverse(q.group.0), q.group.1, Reverse(q.nearest), q.rank));
    true
}

/// Whether nothing inside a box can be seen any more in the tile.
#[inline]
fn hides(frame: &Frame<'_>, s: &Scratch, hull: &PixelBox) -> bool {
    frame.leaves_out && s.tile.hides(frame.simd, hull)
}

/// Draws the blocks of an item; `rank` is that of its first block, if ranks are given.
fn draw_item(frame: &Frame<'_>, item: u32, rect: [u32; 4], rank: Option<u32>, s: &mut Scratch) {
    let source = frame.source_of(item);
    let local = item - source.first_item;
    if known_box(frame, item).is_some_and(|b| !touches(&b, rect) || hides(frame, s, &b)) {
        return;
    }
    let size = source.block_size(local);
    let shape = source.shape(local);
    let cutout = frame.cutout(source.object.material(source.cage_face(local)));
    let [nu, nv] = source.blocks();
    for bv in 0..nv {
        for bu in (0..nu).filter(|&bu| source.has_block([bu, bv])) {
            let clock = s.times.start();
            if nu * nv > 1 {
                source.block_hull(&mut s.source, local, [bu, bv], &mut s.hull);
                let seen = bounds(&s.hull, &frame.view.projection, frame.size)
                    .is_some_and(|b| touches(&b, rect) && !hides(frame, s, &b));
                if !seen {
                    s.times.stop(Stage::Setup, clock);
                    continue;
                }
            }
            let keeps = source.is_costly() && s.kept.has_room();
            let attributes = (keeps || cutout.is_some()).then_some(&mut s.attributes);
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
            if let Some(found) = s.projected.pixel_box() {
                if source.has_wide_hulls()
                    && let Some(seen) = frame.seen.get(item as usize)
                {
                    // Whichever tile is first: all of them find the same.
                    let _ = seen.set(found);
                }
                if !touches(&found, rect) || hides(frame, s, &found) {
                    s.times.stop(Stage::Tile, clock);
                    continue;
                }
            }
            let drawn = Drawn {
                item,
                block: [bu, bv],
                clipped: s.projected.is_clipped(),
            };
            let rank = match rank {
                Some(first) => first + bv * nu + bu,
                None => {
                    let rank = next_rank(s);
                    s.drawn.push(drawn);
                    rank
                }
            };
            s.drawn[rank as usize] = drawn;
            match cutout {
                Some(map) if s.attributes.has_uvs => {
                    footprints(
                        &s.projected,
                        &s.attributes.uvs,
                        shape,
                        size,
                        &mut s.footprint,
                    );
                    draw_cutout(frame, s, shape, map, rank);
                }
                _ => draw(frame.simd, &mut s.tile, &s.projected, shape, rank),
            }
            if keeps {
                s.kept.keep(rank, size, &s.points, &s.attributes);
            }
            s.times.stop(Stage::Tile, clock);
        }
    }
}

/// Rank of the next block. When the ranks run out, those of blocks of which nothing is left are given up; the others keep their order.
fn next_rank(s: &mut Scratch) -> u32 {
    if s.drawn.len() < SampleId::MAX_BLOCKS as usize {
        return s.drawn.len() as u32;
    }
    // Those that were kept have other ranks from now on.
    s.kept.forget();
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
