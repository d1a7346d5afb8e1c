//! Blocks of a tile, one after the other, for who draws lines: the same blocks that pictures are made of, with what their lines are in the
//! cage. Blocks behind what is seen are left out.

use super::source::Source;
use super::stats::StageTimes;
use super::tile::{self, Scratch};
use super::{Frame, FrameStats, RenderError, Renderer, Scene, Use, leaf, level};
use crate::camera::View;
use crate::limits::{LimitError, Limits};
use crate::mesh::NONE;
use crate::raster::{PixelBox, bounds};
use crate::records::{BLOCK_POINTS, BLOCK_STRIDE, BlockSize, Grid3, ScreenSize};
use crate::surface::Surface;
use rayon::prelude::*;
use std::time::Instant;

/// Levels beyond that of edges of five pixels which lines can tell apart; displacement has detail of its own.
const FINER: [u32; 2] = [0, 2];

/// The uniform level that lines are traced at: finer ones put lines closer than pixels, and move none by a tenth of one.
pub(super) fn level(surface: &Surface, view: &View, wanted: u32) -> u32 {
    let most = crate::dice::MAX_LEVEL;
    let finer = FINER[usize::from(surface.displacement().is_some())];
    wanted.min(level::by_edge_length(surface, view, most) + finer)
}

/// What the points of a block are in the cage.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    /// Place of the block's first point on the grid of its face, which has `full` steps along a side.
    start: [u32; 2],
    full: u32,
    /// Half-edge of the cage along each side of the face, or [`NONE`].
    pub(crate) sides: [u32; 4],
    /// Vertex of the cage at each corner of the face, or [`NONE`].
    corners: [u32; 4],
    /// Face of the cage whose middle corner 2 is, or [`NONE`].
    centre: u32,
    /// Whether lines inside of the face are the tessellation's, and not cuts through a polygon.
    pub(crate) wired: bool,
    /// Whether faces are triangles, so that the diagonal is a line like the others, and side 2.
    pub(crate) triangular: bool,
}

/// A block of points.
pub(crate) struct Block<'a> {
    /// Object of the scene.
    pub(crate) object: u32,
    pub(crate) points: &'a Grid3,
    pub(crate) size: BlockSize,
    /// Triangles by the indices of their points, where it is no grid.
    pub(crate) list: Option<&'a [[u16; 3]]>,
    /// Places of the points of a list, where they are its own.
    places: Option<&'a [[u16; 2]]>,
    pub(crate) layout: Layout,
}

impl Block<'_> {
    /// Place of point `k` of the component arrays on the face's grid.
    fn place(&self, k: usize) -> [u32; 2] {
        let [i, j] = [k % BLOCK_STRIDE, k / BLOCK_STRIDE];
        match self.places {
            Some(places) => places
                .get(j * BLOCK_POINTS + i)
                .map_or([u32::MAX; 2], |p| p.map(u32::from)),
            None => [
                self.layout.start[0] + i as u32,
                self.layout.start[1] + j as u32,
            ],
        }
    }

    /// The side of the face that the line between two points lies on.
    pub(crate) fn side(&self, a: usize, b: usize) -> Option<usize> {
        let full = self.layout.full;
        let (p, q) = (self.place(a), self.place(b));
        let both = |on: &dyn Fn([u32; 2]) -> bool| on(p) && on(q);
        let triangular = self.layout.triangular;
        if both(&|p| p[1] == 0) {
            Some(0)
        } else if both(&|p| p[0] == full) {
            Some(1)
        } else if triangular {
            both(&|p| p[0] == p[1]).then_some(2)
        } else if both(&|p| p[1] == full) {
            Some(2)
        } else {
            both(&|p| p[0] == 0).then_some(3)
        }
    }

    /// Corners of the face among the block's points: their place in the component arrays, and the vertex of the cage or, with the second
    /// number, the face.
    pub(crate) fn corners(&self) -> impl Iterator<Item = (usize, u32, u32)> + '_ {
        let Layout {
            full,
            corners,
            centre,
            ..
        } = self.layout;
        let at = [[0, 0], [full, 0], [full, full], [0, full]];
        self.size.indices().filter_map(move |k| {
            let place = self.place(k);
            let c = at.iter().position(|&p| p == place)?;
            let centre = if c == 2 { centre } else { NONE };
            (corners[c] != NONE || centre != NONE).then_some((k, corners[c], centre))
        })
    }
}

/// Layout of faces with `full` steps along their sides.
fn face_layout(surface: &Surface, q: u32, start: [u32; 2], full: u32) -> Layout {
    let t = surface.topology();
    let mut layout = Layout {
        start,
        full,
        sides: [NONE; 4],
        corners: [NONE; 4],
        centre: NONE,
        wired: true,
        triangular: surface.is_triangular(),
    };
    if surface.is_split() {
        // Of the corner `q` of a polygon: the halves of its two edges, and the middle of the polygon.
        layout.sides = [q, NONE, NONE, t.prev(q)];
        layout.corners[0] = t.vertex(q);
        let face = t.face_of(q);
        if t.face_halves(face).len() != 4 {
            layout.centre = face;
        }
    } else {
        for (c, h) in t.face_halves(q).enumerate().take(4) {
            layout.sides[c] = h;
            layout.corners[c] = t.vertex(h);
        }
    }
    layout
}

impl Source<'_> {
    /// Layout of a block of a local item.
    fn layout(&self, item: u32, block: [u32; 2]) -> Layout {
        let surface = &self.object.surface;
        if let Some(t) = &self.tessellation {
            let leaf = &t.leaves[item as usize];
            let start = leaf.start.map(u32::from);
            return face_layout(surface, leaf.quad, start, 1 << leaf.level);
        }
        let t = surface.topology();
        let polygon = |sides: [u32; 4], corners: [u32; 4]| Layout {
            start: [0, 0],
            full: 1,
            sides,
            corners: corners.map(|h| if h == NONE { NONE } else { t.vertex(h) }),
            centre: NONE,
            wired: false,
            triangular: false,
        };
        if let Some(block) = self.polygon_block(item) {
            // Lines are asked for one by one.
            let halves = t.face_halves(block.face);
            let (first, n) = (halves.start, halves.len() as u32);
            if n == 4 {
                let all = [0, 1, 2, 3].map(|k| first + k);
                return polygon(all, all);
            }
            // A triangle of the fan around corner 0.
            let k = block.fan;
            let only = |is: bool, h: u32| if is { h } else { NONE };
            let sides = [
                only(k == 0, first),
                first + k + 1,
                NONE,
                only(k + 3 == n, first + k + 2),
            ];
            return polygon(sides, [first, first + k + 1, first + k + 2, NONE]);
        }
        if self.is_polygonal() {
            let h = item;
            let next = t.next(h);
            if t.face_halves(t.face_of(h)).len() == 4 {
                let third = t.next(next);
                let all = [h, next, third, t.next(third)];
                return polygon(all, all);
            }
            return polygon([h, NONE, NONE, NONE], [h, next, NONE, NONE]);
        }
        let steps = self.block_size(item).cols as u32 - 1;
        let start = block.map(|b| b * steps);
        face_layout(surface, item, start, 1 << self.quad_level())
    }
}

/// One tile, rasterised.
pub(crate) struct Walk<'a> {
    frame: &'a Frame<'a>,
    tile: usize,
    scratch: Scratch,
    limits: &'a Limits,
}

impl Walk<'_> {
    /// The tile's pixels: first column and row, columns and rows.
    pub(crate) fn rect(&self) -> [u32; 4] {
        self.frame.grid.rect(self.tile)
    }

    /// Pixels that show anything at their centre.
    pub(crate) fn covered(&self) -> u64 {
        let [x, y, width, height] = self.rect();
        let [x0, y0] = self.scratch.tile.origin();
        let columns = (x - x0) as usize..(x - x0 + width) as usize;
        let rows = (y - y0..y - y0 + height).map(|y| self.scratch.tile.row(y, 0));
        rows.map(|row| row[columns.clone()].iter().filter(|k| k.0 != 0).count() as u64)
            .sum()
    }

    /// Whether a box is behind what is drawn in the tile, and a pixel around it as well: samples stand a pixel apart, and a line may be seen
    /// between them. A box that reaches the tile's border never is: what hides it there, or turns it into a silhouette, is in another tile.
    pub(crate) fn hides(&self, hull: &PixelBox) -> bool {
        let [x, y, width, height] = self.rect();
        let (from, to) = ([x, y], [x + width, y + height]);
        if (0..2).any(|k| hull.low[k] <= from[k] || hull.high[k] >= to[k]) {
            return false;
        }
        let wide = PixelBox {
            low: hull.low.map(|c| c - 1),
            high: hull.high.map(|c| c + 1),
            nearest: hull.nearest,
        };
        self.frame.leaves_out && self.scratch.tile.hides(self.frame.simd, &wide)
    }

    /// Hands out the blocks that may be seen in the tile, in (face, block) order.
    ///
    /// # Errors
    /// Those of `visit`; also when time is up.
    pub(crate) fn each(
        &mut self,
        mut visit: impl FnMut(&Self, &Block<'_>) -> Result<(), LimitError>,
    ) -> Result<(), LimitError> {
        let frame = self.frame;
        let rect = self.rect();
        let mut points = Grid3::boxed();
        for &item in frame.bins.items(self.tile) {
            if frame.boxes[item as usize].is_some_and(|b| self.hides(&b)) {
                continue;
            }
            self.limits.check()?;
            let object = frame.sources.partition_point(|s| s.first_item <= item) - 1;
            let source = &frame.sources[object];
            let local = item - source.first_item;
            let [nu, nv] = source.blocks();
            let all = (0..nu * nv).map(|k| [k % nu, k / nu]);
            for block in all.filter(|&b| source.has_block(b)) {
                if nu * nv > 1 {
                    let Scratch {
                        source: s, hull, ..
                    } = &mut self.scratch;
                    source.block_hull(s, local, block, hull);
                    let seen = bounds(hull, &frame.view.projection, frame.size)
                        .is_some_and(|b| tile::touches(&b, rect) && !self.hides(&b));
                    if !seen {
                        continue;
                    }
                }
                source.dice(&mut self.scratch.source, local, block, &mut points, None);
                let places = source.tessellation.as_ref().and_then(|t| {
                    let list = leaf::scattered(t, &t.leaves[local as usize])?;
                    Some(list.points.as_slice())
                });
                visit(
                    self,
                    &Block {
                        object: object as u32,
                        points: &points,
                        size: source.block_size(local),
                        list: source.shape(local).list(),
                        places,
                        layout: source.layout(local, block),
                    },
                )?;
            }
        }
        Ok(())
    }
}

/// A rectangle and the pixels around it that are in the picture.
fn apron([x, y, width, height]: [u32; 4], size: ScreenSize) -> [u32; 4] {
    let (left, top) = (x.saturating_sub(1), y.saturating_sub(1));
    let right = (x + width + 1).min(size.width);
    let bottom = (y + height + 1).min(size.height);
    [left, top, right - left, bottom - top]
}

impl Renderer {
    /// Rasterises all tiles of a view at one sample per pixel and hands them out, in parallel; results are in the tiles' order.
    pub(crate) fn walk<T: Send>(
        &self,
        scene: &Scene,
        view: &View,
        visit: impl Fn(&mut Walk<'_>) -> Result<T, LimitError> + Sync,
    ) -> Result<(Vec<T>, FrameStats), RenderError> {
        self.with_frame(scene, view, Use::Lines, |frame, mut stats| {
            let begin = Instant::now();
            self.limits.progress.begin(frame.grid.len() as u64);
            let found = (0..frame.grid.len())
                .into_par_iter()
                .with_max_len(1)
                .map(|tile| {
                    self.limits.check()?;
                    let mut scratch = self.scratch.take(frame.size.samples, self.simd);
                    scratch.times = StageTimes::default();
                    let rect = apron(frame.grid.rect(tile), frame.size);
                    tile::rasterise(frame, tile, rect, &mut scratch);
                    let mut walk = Walk {
                        frame,
                        tile,
                        scratch,
                        limits: &self.limits,
                    };
                    let result = visit(&mut walk);
                    self.scratch.give_back(walk.scratch);
                    self.limits.progress.step();
                    result
                })
                .collect::<Result<Vec<T>, LimitError>>()?;
            stats.wall[2] = begin.elapsed();
            Ok((found, stats))
        })
    }
}
