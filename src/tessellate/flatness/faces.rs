//! What every face needs: from samples of its inside, as far as they are needed.

use super::closed::{self, Told};
use super::edges::{Face, Lines, Own, halves};
use super::screen::Metric;
use super::surplus::{Square as Sampled, Surplus};
use crate::dice::face::{Part as Square, Sides};
use crate::limits::{LimitError, Limits};
use crate::records::{BlockSize, Grid3};
use crate::simd::Level;
use crate::surface::{QuadPatch, Spline, Surface};
use crate::tessellate::CHUNK;
use crate::tessellate::blocks::{Needs, Part};
use crate::tessellate::quadtree::{MAX_LOG, Quadtree, Shape};
use rayon::prelude::*;

/// What a block costs beside its micro-quads, in micro-quads. Drawn, it costs about 20; fewer triangles are worth the difference (measured:
/// a third fewer for a twentieth more of a frame's time).
const OVERHEAD: u32 = 6;

/// Depth below a sampled square at which its parts are sampled on their own.
const RESAMPLED: u32 = 3;

/// Samples along the side of a face, one after the other while they do not tell enough, as powers of two.
const LOGS: [u32; 4] = [2, 3, 4, MAX_LOG];

/// In place of the first of them where nothing has to be sampled.
const FLAT: u32 = 0;

/// How many times as far as is allowed two triangles are, by the bound, of faces for which the first number of samples will not do.
const ROUGH: f32 = 8.0;

/// Samples, as a power of two, whose last step is trusted to say what the next one adds; of fewer, the next one is looked at.
const TRUSTED: u32 = 3;

/// Need of a square whose samples do not tell.
const DEEPER: u32 = MAX_LOG + 1;

/// Says which faces `is_drawn` (it gets the quad and points whose hull holds it) and finds what those and their neighbours need.
pub(super) fn needs(
    surface: &Surface,
    metric: &Metric<'_>,
    limits: &Limits,
    simd: Level,
    is_drawn: impl Fn(u32, &mut Vec<[f32; 3]>) -> bool + Sync,
) -> Result<(Needs, Vec<Own>), LimitError> {
    let quads = surface.whole_quads();
    let faces = quads.face_count();
    let mut plans = vec![None; faces];
    plans.par_chunks_mut(CHUNK).enumerate().try_for_each_init(
        || (QuadPatch::for_level(simd), Vec::new()),
        |(patch, hull), (k, plans)| {
            limits.check()?;
            for (i, plan) in plans.iter_mut().enumerate() {
                let q = (k * CHUNK + i) as u32;
                hull.clear();
                patch.prepare_points(surface, q, metric.reach.level, None, Sides::Hull);
                let spline = patch.spline();
                match &spline {
                    Some(spline) => hull.extend_from_slice(spline.points()),
                    None if metric.reach.always => table_box(patch, metric.reach.level, hull),
                    None => patch.hull(|p| hull.push(p)),
                }
                *plan = is_drawn(q, hull).then(|| first_log(metric, spline.as_ref()) as u8);
            }
            Ok(())
        },
    )?;
    let drawn: Vec<bool> = plans.iter().map(Option::is_some).collect();
    // The first face of an edge samples it for the other as well.
    let near = |q: usize| {
        let mut sides = quads.face_halves(q as u32).flat_map(|h| halves(quads, h));
        drawn[q] || sides.any(|h| drawn[quads.face_of(h) as usize])
    };
    let parts: Vec<(Part, Own)> = (0..faces.div_ceil(CHUNK))
        .into_par_iter()
        .map_init(
            || Worker::new(surface, metric, simd, &is_drawn),
            |worker, k| {
                limits.check()?;
                let (mut out, mut own) = (Part::default(), Own::new());
                for q in k * CHUNK..((k + 1) * CHUNK).min(faces) {
                    if near(q) {
                        worker.face(q as u32, plans[q].map(u32::from));
                        worker.edges(&drawn, q as u32, &mut own);
                        out.nodes.extend_from_slice(&worker.tree.nodes);
                    }
                    out.ends.push(out.nodes.len() as u32);
                }
                limits.memory(
                    "the blocks of the tessellation",
                    out.nodes.len() as u128 * 12,
                )?;
                Ok((out, own))
            },
        )
        .collect::<Result<_, LimitError>>()?;
    let (parts, own) = parts.into_iter().unzip();
    let needs = Needs { drawn, parts };
    limits.memory("the blocks of the tessellation", needs.bytes() as u128)?;
    Ok((needs, own))
}

/// How many samples a face begins with, as a power of two, if it is this spline or none.
fn first_log(metric: &Metric<'_>, spline: Option<&Spline>) -> u32 {
    match spline.map(|s| closed::tell(metric, s)) {
        Some(Told::Flat) => FLAT,
        Some(Told::Far(times)) if times.is_finite() && times > ROUGH => LOGS[1],
        _ => LOGS[0],
    }
}

/// The corners of a box that holds a face of tables: that of a few of its points, with room for those between. All of its points would take
/// longer than drawing them.
fn table_box(patch: &QuadPatch, reach: u32, out: &mut Vec<[f32; 3]>) {
    const FEW: u32 = 3;
    const ROOM: f32 = 0.25;
    let level = reach.min(FEW);
    let whole = Square {
        level,
        start: [0; 2],
        segments: 1 << level,
    };
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    patch.part_hull(whole, |p| {
        low = [0, 1, 2].map(|k| low[k].min(p[k]));
        high = [0, 1, 2].map(|k| high[k].max(p[k]));
    });
    let room = [0, 1, 2].map(|k| ROOM * (high[k] - low[k]));
    let corner = |c: u32, k: usize| match c >> k & 1 {
        0 => low[k] - room[k],
        _ => high[k] + room[k],
    };
    out.extend((0..8).map(|c| [0, 1, 2].map(|k| corner(c, k))));
}

/// Buffers of one thread.
struct Worker<'a, F> {
    surface: &'a Surface,
    metric: &'a Metric<'a>,
    is_drawn: &'a F,
    patch: QuadPatch,
    /// Level and sides that the face is prepared for.
    prepared: Option<(u32, Sides)>,
    points: Box<Grid3>,
    normals: Box<Grid3>,
    tree: Quadtree,
    surplus: Surplus,
    levels: Levels,
    /// Sides of the picture that samples are beyond, row by row, and points of a hull.
    outside: Vec<u8>,
    hull: Vec<[f32; 3]>,
    lines: Lines,
    /// Whether nothing of the face has to be sampled.
    is_flat: bool,
    /// Which of its corners are irregular.
    irregular: [bool; 4],
}

/// Mark of a square that cannot be in the picture, beside its level.
const HIDDEN: u8 = 0x80;

/// Levels below a sampled square that its parts need, depth by depth.
#[derive(Default)]
struct Levels(Vec<u8>);

impl Levels {
    fn index(depth: u32, x: u32, y: u32) -> usize {
        ((4_usize.pow(depth) - 1) / 3) + ((y as usize) << depth) + x as usize
    }
    fn get(&self, depth: u32, x: u32, y: u32) -> u32 {
        u32::from(self.0[Self::index(depth, x, y)] & !HIDDEN)
    }
    fn set(&mut self, [depth, x, y]: [u32; 3], value: u8) {
        let at = Self::index(depth, x, y);
        if self.0.len() <= at {
            self.0.resize(at + 1, 0);
        }
        self.0[at] = value;
    }
    /// Says that a square cannot be in the picture.
    fn hide(&mut self, at: [u32; 3]) {
        self.set(at, at[0] as u8 | HIDDEN);
    }
    fn is_hidden(&self, [depth, x, y]: [u32; 3]) -> bool {
        let value = self.0.get(Self::index(depth, x, y));
        value.is_some_and(|v| v & HIDDEN != 0)
    }

    /// Children of square (`x`, `y`) that are not void.
    fn children(s: Shape, x: u32, y: u32) -> impl Iterator<Item = [u32; 2]> {
        let all = (0..4).map(move |k| [2 * x + (k & 1), 2 * y + (k >> 1)]);
        all.filter(move |[x, y]| s == Shape::Square || y <= x)
    }

    /// Finds what a square of the samples needs; `cap` is what it may have.
    fn find(&mut self, s: &Sampled, surplus: &Surplus, cap: u32, [depth, x, y]: [u32; 3]) -> u32 {
        if self.is_hidden([depth, x, y]) {
            return depth;
        }
        let need = if depth >= cap || !surplus.is_far(s, depth, [x, y]) {
            depth
        } else if depth >= s.log {
            DEEPER
        } else {
            let mut need = 0;
            for [x, y] in Self::children(s.shape, x, y) {
                need = need.max(self.find(s, surplus, cap, [depth + 1, x, y]));
            }
            need
        };
        self.set([depth, x, y], need as u8);
        need
    }

    /// Micro-quads of a square as one block.
    fn whole(&self, s: Shape, depth: u32, x: u32, y: u32) -> u32 {
        let quads = 1 << (2 * (self.get(depth, x, y) - depth));
        let half = s == Shape::Triangle && x == y;
        (if half { quads / 2 } else { quads }) + OVERHEAD
    }

    /// Micro-quads of the cheapest way to cut a square into blocks.
    fn cost(&self, s: Shape, depth: u32, x: u32, y: u32) -> u32 {
        let whole = self.whole(s, depth, x, y);
        if self.get(depth, x, y) < depth + 2 || depth >= RESAMPLED {
            return whole;
        }
        let parts = Self::children(s, x, y).map(|[x, y]| self.cost(s, depth + 1, x, y));
        whole.min(parts.sum())
    }
}

impl<'a, F: Fn(u32, &mut Vec<[f32; 3]>) -> bool> Worker<'a, F> {
    fn new(surface: &'a Surface, metric: &'a Metric<'a>, simd: Level, is_drawn: &'a F) -> Self {
        Self {
            surface,
            metric,
            is_drawn,
            patch: QuadPatch::for_level(simd),
            prepared: None,
            points: Grid3::boxed(),
            normals: Grid3::boxed(),
            tree: Quadtree::new(Shape::of(surface), metric.reach.squares),
            surplus: Surplus::new(simd),
            levels: Levels::default(),
            outside: Vec::new(),
            hull: Vec::new(),
            lines: Lines::default(),
            is_flat: false,
            irregular: [true; 4],
        }
    }

    /// Leaves in `tree` what face `q` needs; `log` is how many samples to begin with, and none for a face that is not drawn.
    fn face(&mut self, q: u32, log: Option<u32>) {
        self.tree.clear();
        self.prepared = None;
        self.is_flat = log == Some(FLAT);
        match log {
            Some(FLAT) => {}
            Some(log) => {
                self.irregular = self.surface.irregular_corners(q);
                self.grow(q, 0, log);
            }
            None => {
                self.tree.hide(0);
                let level = self.metric.reach.level;
                self.patch
                    .prepare_points(self.surface, q, level, None, Sides::Hull);
            }
        }
    }

    /// Adds what the edges of face `q` ask for, which was looked at last. Samples of the face's inside have its rim among them, and edges are
    /// asked for what those need; only where the rim is not what the inside says, edges are sampled on their own.
    fn edges(&mut self, drawn: &[bool], q: u32, out: &mut Own) {
        if self.is_flat || self.patch.has_plain_sides() {
            return;
        }
        let face = Face {
            surface: self.surface,
            drawn,
            q,
        };
        let patch = (&mut self.patch, &mut self.prepared);
        face.split(self.metric, &mut self.lines, &mut self.surplus, patch, out);
    }

    /// Samples leaf `node` by `2^log` segments and cuts it up as far as it needs.
    fn grow(&mut self, q: u32, node: usize, log: u32) {
        let (depth, place) = (self.tree.nodes[node].depth(), self.tree.nodes[node].place());
        let deepest = self.metric.reach.level;
        let log = log.min(deepest - depth);
        let level = depth + log;
        if self.prepared.is_none_or(|(have, _)| have < level) {
            // Sides by their own rule are wanted only where they are sampled.
            let sides = match self.surface.has_rims_inside() {
                true => Sides::None,
                false => Sides::Normals,
            };
            let level = self.metric.reach.prepared(level);
            self.patch
                .prepare_points(self.surface, q, level, None, sides);
            self.prepared = Some((level, sides));
            // What control levels below hold is not known before; tables have it everywhere alike.
            if !self.patch.has_plain_sides() && !self.metric.reach.always {
                self.irregular = [true; 4];
            }
        }
        let part = Square {
            level,
            start: place.map(|k| k << log),
            segments: 1 << log,
        };
        self.patch.dice_part(
            self.surface,
            part,
            &mut self.points,
            Some(&mut self.normals),
        );
        let hides = self.hides(part);
        let shape = self.tree.nodes[node].shape(self.tree.face);
        self.surplus
            .grid(self.metric, (log, shape), &mut self.points, &self.normals);
        let last = (1 << depth) - 1;
        let corners = [[0, 0], [last, 0], [last, last], [0, last]].map(|c| c == place);
        let sampled = Sampled {
            log,
            shape,
            corners,
            irregular: [0, 1, 2, 3].map(|c| corners[c] && self.irregular[c]),
        };
        let cap = self.metric.max_level.saturating_sub(depth);
        let mut levels = std::mem::take(&mut self.levels);
        levels.0.clear();
        self.find_hidden(q, (part, shape), &mut levels);
        if levels.is_hidden([0; 3]) {
            self.levels = levels;
            self.tree.hide(node);
            return;
        }
        let need = levels.find(&sampled, &self.surplus, cap, [0, 0, 0]);
        // A few samples tell enough of what needs next to nothing.
        let promising = match hides {
            true => 0,
            false => self.surplus.promising(&sampled),
        };
        let more = LOGS.into_iter().find(|&l| l > log && l >= promising);
        // Towards an irregular corner steps add nearly as much as the one before: two are looked at.
        let ahead = match sampled.irregular.contains(&true) {
            true => 2,
            false => u32::from(log < TRUSTED),
        };
        let told = need + ahead <= log;
        match more.filter(|_| (!told || hides) && level < deepest) {
            Some(more) => {
                self.levels = levels;
                self.grow(q, node, more);
            }
            None if hides && level < self.metric.max_level && depth < self.tree.deepest => {
                self.levels = levels;
                let first = self.tree.split(node);
                for [x, y] in Levels::children(sampled.shape, 0, 0) {
                    self.grow(q, first + (x + 2 * y) as usize, MAX_LOG);
                }
            }
            None => {
                self.cut(q, node, &levels, sampled.shape, [0, 0, 0]);
                self.levels = levels;
            }
        }
    }

    /// Says which squares of the samples cannot be in the picture: beyond one of its sides by their points, and by their hulls.
    fn find_hidden(&mut self, q: u32, (part, shape): (Square, Shape), levels: &mut Levels) {
        // Tables have no hulls of parts.
        if self.metric.reach.always {
            return;
        }
        let side = part.segments as usize + 1;
        let size = BlockSize {
            cols: side,
            rows: side,
        };
        self.outside.clear();
        let points = size.indices().map(|k| self.points.at(k));
        self.outside.extend(points.map(|p| self.metric.outside(p)));
        if self.outside.iter().any(|&o| o != 0) {
            self.hide_square(q, (part, shape), levels, [0; 3]);
        }
    }

    /// The same of square (`x`, `y`) at `depth`, and those in it.
    fn hide_square(
        &mut self,
        q: u32,
        (part, shape): (Square, Shape),
        levels: &mut Levels,
        [depth, x, y]: [u32; 3],
    ) {
        let size = part.segments >> depth;
        let [column, row] = [x, y].map(|k| (k * size) as usize);
        let (side, n) = (part.segments as usize + 1, size as usize);
        let rows = self.outside.chunks_exact(side).skip(row).take(n + 1);
        let points = rows.flat_map(|r| &r[column..=column + n]);
        let (all, any) = points.fold((u8::MAX, 0), |(all, any), &o| (all & o, any | o));
        if all != 0 {
            let square = Square {
                level: part.level,
                start: [part.start[0] + x * size, part.start[1] + y * size],
                segments: size,
            };
            self.hull.clear();
            self.patch.part_hull(square, |p| self.hull.push(p));
            if !(self.is_drawn)(q, &mut self.hull) {
                return levels.hide([depth, x, y]);
            }
        }
        if any != 0 && depth < RESAMPLED && size > 1 {
            for [x, y] in Levels::children(shape, x, y) {
                self.hide_square(q, (part, shape), levels, [depth + 1, x, y]);
            }
        }
    }

    /// Whether the displaced surface may leave its samples unseen by more than is allowed.
    fn hides(&self, part: Square) -> bool {
        let height = self.patch.hidden(self.surface, part, &self.points);
        if height == 0.0 {
            return false;
        }
        let side = part.segments as usize + 1;
        let size = BlockSize {
            cols: side,
            rows: side,
        };
        let depths = size.indices().map(|k| self.metric.depth(self.points.at(k)));
        self.metric
            .height(height, depths.fold(f32::INFINITY, f32::min))
            > 1.0
    }

    /// Cuts leaf `node`, square (`x`, `y`) at `depth` of samples over a square of shape `s`, into blocks.
    fn cut(&mut self, q: u32, node: usize, needs: &Levels, s: Shape, [depth, x, y]: [u32; 3]) {
        let need = needs.get(depth, x, y);
        let own = self.tree.nodes[node].depth();
        let smallest = own >= self.tree.deepest;
        if need < DEEPER && (smallest || needs.cost(s, depth, x, y) >= needs.whole(s, depth, x, y))
        {
            match needs.is_hidden([depth, x, y]) {
                true => self.tree.hide(node),
                false => self.tree.set_need(node, own + (need - depth)),
            }
            return;
        }
        // The smallest squares are sampled as deep as can be.
        if depth >= RESAMPLED || (smallest && depth > 0) {
            return self.grow(q, node, MAX_LOG);
        }
        let first = self.tree.split(node);
        for [cx, cy] in Levels::children(s, x, y) {
            let k = (cx & 1) + 2 * (cy & 1);
            self.cut(q, first + k as usize, needs, s, [depth + 1, cx, cy]);
        }
    }
}
