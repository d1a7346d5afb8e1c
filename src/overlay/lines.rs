//! Lines of a tile before anything hides them: micro-edges of blocks, and straight lines that are no part of the surface.

use super::lens::{Lens, Screen, Spot};
use super::{Kind, Layers};
use crate::frame::{Block, Scene, Walk};
use crate::mesh::NONE;
use crate::raster::PixelBox;
use crate::records::BLOCK_STRIDE;
use crate::topology::Topology;

/// What a line is, bit by bit. A line that two blocks share is all that either says.
pub(super) mod is {
    pub(crate) const WIRE: u16 = 1;
    pub(crate) const PATCH: u16 = 2;
    pub(crate) const CREASE: u16 = 4;
    pub(crate) const BOUNDARY: u16 = 8;
    pub(crate) const CAGE: u16 = 16;
    pub(crate) const AXIS: u16 = 32;
    pub(crate) const SECOND_AXIS: u16 = 64;
    pub(crate) const THIRD_AXIS: u16 = 128;
    /// A triangle beside it is seen from its front, from behind.
    pub(crate) const FRONT: u16 = 256;
    pub(crate) const BACK: u16 = 512;
}

/// How much nearer lines of the cage are taken to be than they are, relative: where they lie in the surface they are not the edges of its
/// triangles, bit for bit.
pub(super) const CAGE_LIFT: f64 = 2e-5;

/// A straight line on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Segment {
    pub(super) a: Spot,
    pub(super) b: Spot,
    pub(super) flags: u16,
}

impl Segment {
    /// The same from either end.
    pub(super) fn new(a: Spot, b: Spot, flags: u16) -> Self {
        match order(&a, &b).is_gt() {
            true => Self { a: b, b: a, flags },
            false => Self { a, b, flags },
        }
    }

    /// The kind that it is drawn as, if it is one of `layers`: the strongest that it is.
    pub(super) fn kind(&self, layers: Layers) -> Option<Kind> {
        let has = |bits: u16| self.flags & bits != 0;
        let turned = has(is::FRONT) && has(is::BACK);
        let all = [
            (has(is::AXIS), Layers::AXES, Kind::AxisX),
            (has(is::SECOND_AXIS), Layers::AXES, Kind::AxisY),
            (has(is::THIRD_AXIS), Layers::AXES, Kind::AxisZ),
            (has(is::CAGE), Layers::CAGE, Kind::Cage),
            (has(is::BOUNDARY), Layers::BOUNDARIES, Kind::Boundary),
            (turned, Layers::SILHOUETTES, Kind::Silhouette),
            (has(is::CREASE), Layers::CREASES, Kind::Crease),
            (has(is::PATCH), Layers::PATCHES, Kind::Patch),
            (has(is::WIRE), Layers::WIREFRAME, Kind::Wire),
        ];
        all.into_iter()
            .find(|&(is, layer, _)| is && layers.contains(layer))
            .map(|(_, _, kind)| kind)
    }
}

fn order(a: &Spot, b: &Spot) -> std::cmp::Ordering {
    let by = |k: usize| a[k].total_cmp(&b[k]);
    by(0).then(by(1)).then(by(2))
}

/// Joins equal lines to one.
pub(super) fn join_equal(lines: &mut Vec<Segment>) {
    lines.sort_unstable_by(|p, q| order(&p.a, &q.a).then(order(&p.b, &q.b)));
    lines.dedup_by(|q, p| {
        let same = p.a == q.a && p.b == q.b;
        if same {
            p.flags |= q.flags;
        }
        same
    });
}

/// What edge `h` of a cage is.
fn edge_flags(t: &Topology, h: u32) -> u16 {
    if h == NONE {
        return 0;
    }
    let twin = t.twin(h);
    let ends = twin == NONE || t.is_hole(t.face_of(twin)) != t.is_hole(t.face_of(h));
    let sharp = t.edge_sharpness(t.edge(h)) > 0.0;
    let more = match (ends, sharp) {
        (true, _) => is::BOUNDARY,
        (_, true) => is::CREASE,
        _ => 0,
    };
    is::PATCH | more
}

/// Collects the micro-edges of blocks.
pub(super) struct Collector<'a> {
    pub(super) scene: &'a Scene,
    pub(super) layers: Layers,
    pub(super) lens: &'a Lens,
    pub(super) screen: Screen,
    /// Facing of the halves of a block's micro-quads.
    facing: Vec<[u16; 2]>,
    pub(super) found: Vec<Segment>,
}

/// Bits of [`is`] that a layer draws, of lines of the surface.
fn wanted_bits(layers: Layers) -> u16 {
    [
        (Layers::WIREFRAME, is::WIRE),
        (Layers::PATCHES, is::PATCH),
        (Layers::CREASES, is::CREASE),
        (Layers::BOUNDARIES, is::BOUNDARY),
    ]
    .into_iter()
    .filter(|&(layer, _)| layers.contains(layer))
    .fold(0, |all, (_, bit)| all | bit)
}

impl<'a> Collector<'a> {
    pub(super) fn new(scene: &'a Scene, layers: Layers, lens: &'a Lens) -> Self {
        Self {
            scene,
            layers,
            lens,
            screen: Screen::new(),
            facing: Vec::new(),
            found: Vec::new(),
        }
    }

    /// Whether any line of the surface is wanted.
    pub(super) fn wants_surface(&self) -> bool {
        wanted_bits(self.layers) != 0 || self.layers.contains(Layers::SILHOUETTES)
    }

    fn facing_of(&self, triangle: [usize; 3]) -> u16 {
        match self.screen.area(triangle) {
            // Counter-clockwise in the picture, whose y points down.
            Some(a) if a < 0.0 => is::FRONT,
            Some(a) if a > 0.0 => is::BACK,
            _ => 0,
        }
    }

    /// Takes the lines of a block.
    pub(super) fn add(&mut self, walk: &Walk<'_>, block: &Block<'_>) {
        self.screen.project(self.lens, block.points, block.size);
        let surface = &self.scene.objects[block.object as usize].surface;
        let t = surface.topology();
        let sides = block.layout.sides.map(|h| edge_flags(t, h));
        let wire = match block.layout.wired {
            true => is::WIRE,
            false => 0,
        };
        let side = |a: usize, b: usize| block.side(a, b).map_or(0, |c| sides[c]);
        // A side of a polygon is a line of it in any case.
        let of_side = |flags: u16| if flags != 0 { flags | is::WIRE } else { 0 };
        if let Some(list) = block.list {
            for triangle in list {
                let [p, q, r] = triangle.map(usize::from);
                let facing = self.facing_of([p, q, r]);
                for (a, b) in [(p, q), (q, r), (r, p)] {
                    self.push(walk, [a, b], of_side(side(a, b)) | wire | facing, true);
                }
            }
            return;
        }
        let (cols, rows) = (block.size.cols, block.size.rows);
        let quads = cols - 1;
        let at = |i: usize, j: usize| j * BLOCK_STRIDE + i;
        let mut facing = std::mem::take(&mut self.facing);
        facing.clear();
        for j in 0..rows - 1 {
            for i in 0..quads {
                let diagonal = [at(i, j), at(i + 1, j + 1)];
                facing.push([
                    self.facing_of([diagonal[0], at(i + 1, j), diagonal[1]]),
                    self.facing_of([diagonal[0], diagonal[1], at(i, j + 1)]),
                ]);
            }
        }
        let half = |i: usize, j: usize, half: usize| match i < quads && j < rows - 1 {
            true => facing[j * quads + i][half],
            false => 0,
        };
        for j in 0..rows {
            for i in 0..cols {
                if i < quads {
                    let (a, b) = (at(i, j), at(i + 1, j));
                    let rim = j == 0 || j == rows - 1;
                    let above = if j > 0 { half(i, j - 1, 1) } else { 0 };
                    let flags = if rim { of_side(side(a, b)) } else { 0 };
                    self.push(walk, [a, b], flags | wire | half(i, j, 0) | above, rim);
                }
                if j < rows - 1 {
                    let (a, b) = (at(i, j), at(i, j + 1));
                    let rim = i == 0 || i == quads;
                    let left = if i > 0 { half(i - 1, j, 0) } else { 0 };
                    let flags = if rim { of_side(side(a, b)) } else { 0 };
                    self.push(walk, [a, b], flags | wire | half(i, j, 1) | left, rim);
                }
                if i < quads && j < rows - 1 {
                    let (a, b) = (at(i, j), at(i + 1, j + 1));
                    let flags = match block.layout.triangular {
                        true => of_side(side(a, b)) | wire,
                        false => 0,
                    };
                    let both = half(i, j, 0) | half(i, j, 1);
                    self.push(walk, [a, b], flags | both, block.layout.triangular);
                }
            }
        }
        self.facing = facing;
    }

    /// Keeps a line if it may be drawn. Whether a line on a block's rim is a silhouette, the block beyond says.
    fn push(&mut self, walk: &Walk<'_>, [a, b]: [usize; 2], flags: u16, rim: bool) {
        let turned = flags & is::FRONT != 0 && flags & is::BACK != 0;
        let may_turn = self.layers.contains(Layers::SILHOUETTES) && (turned || rim);
        if flags & wanted_bits(self.layers) == 0 && !may_turn {
            return;
        }
        let screen = &self.screen;
        let ends = match screen.is_clipped {
            false => [screen.spots[a], screen.spots[b]],
            true => match self.lens.line(&screen.wide[a], &screen.wide[b]) {
                Some(ends) => ends,
                None => return,
            },
        };
        if ends[0] == ends[1] || !ends.as_flattened().iter().all(|c| c.is_finite()) {
            return;
        }
        if is_in(walk, &ends).is_some_and(|hull| !walk.hides(&hull)) {
            self.found.push(Segment::new(ends[0], ends[1], flags));
        }
    }
}

/// The pixels of a line, if it touches the tile.
pub(super) fn is_in(walk: &Walk<'_>, ends: &[Spot; 2]) -> Option<PixelBox> {
    let [x, y, width, height] = walk.rect();
    let (from, size) = ([x, y], [width, height]);
    let mut hull = PixelBox {
        low: [0; 2],
        high: [0; 2],
        // As much as hulls of blocks are brought nearer.
        nearest: (ends[0][2].max(ends[1][2]) * (1.0 + 1.0 / 16384.0)) as f32,
    };
    for k in 0..2 {
        let (low, high) = (ends[0][k].min(ends[1][k]), ends[0][k].max(ends[1][k]));
        let first = f64::from(from[k]);
        if high < first || low > f64::from(from[k] + size[k]) {
            return None;
        }
        hull.low[k] = low.max(first).floor() as u32;
        hull.high[k] = high.min(f64::from(from[k] + size[k])).floor() as u32 + 1;
    }
    Some(hull)
}
