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
    // An edge asks both of its faces, whichever is drawn: what is outside of the picture must not change what is inside.
    let near = |q: usize| {
        let mut sides = quads.face_halves(q as u32).flat_map(|h| halves(quads, h));
        drawn[q] || sides.any(|h| drawn[quads.face_of(h) as usize])
    };
    let parts: Vec<(Part, Own)> = (0..faces.div_ceil(CHUNK))
        .into_par_iter()
        .map_init(
            || Worker::new(surface, metric, simd),
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
struct Worker<'a> {
    surface: &'a Surface,
    metric: &'a Metric<'a>,
    patch: QuadPatch,
    /// Level and sides that the face is prepared for.
    prepared: Option<(u32, Sides)>,
    points: Box<Grid3>,
    normals: Box<Grid3>,
    tree: Quadtree,
    surplus: Surplus,
    levels: Levels,
    lines: Lines,
    /// Whether nothing of the face has to be sampled.
    is_flat: bool,
    /// Which of its corners are irregular.
    irregular: [bool; 4],
}

/// Levels below a sampled square that its parts need, depth by depth.
#[derive(Default)]
struct Levels(Vec<u8>);

impl Levels {
    fn index(depth: u32, x: u32, y: u32) -> usize {
        ((4_usize.pow(depth) - 1) / 3) + ((y as usize) << depth) + x as usize
    }
    fn get(&self, depth: u32, x: u32, y: u32) -> u32 {
        u32::from(self.0[Self::index(depth, x, y)])
    }

    /// Children of square (`x`, `y`) that are not void.
    fn children(s: Shape, x: u32, y: u32) -> impl Iterator<Item = [u32; 2]> {
        let all = (0..4).map(move |k| [2 * x + (k & 1), 2 * y + (k >> 1)]);
        all.filter(move |[x, y]| s == Shape::Square || y <= x)
    }

    /// Finds what a square of the samples needs; `cap` is what it may have.
    fn find(&mut self, s: &Sampled, surplus: &Surplus, cap: u32, [depth, x, y]: [u32; 3]) -> u32 {
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
        let at = Self::index(depth, x, y);
        if self.0.len() <= at {
            self.0.resize(at + 1, 0);
        }
        self.0[at] = need as u8;
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

impl<'a> Worker<'a> {
    fn new(surface: &'a Surface, metric: &'a Metric<'a>, simd: Level) -> Self {
        Self {
            surface,
            metric,
            patch: QuadPatch::for_level(simd),
            prepared: None,
            points: Grid3::boxed(),
            normals: Grid3::boxed(),
            tree: Quadtree::new(Shape::of(surface), metric.reach.squares),
            surplus: Surplus::new(simd),
            levels: Levels::default(),
            lines: Lines::default(),
            is_flat: false,
            irregular: [true; 4],
        }
    }

    /// Leaves in `tree` what face `q` needs; `log` is how many samples to begin with, if that is known.
    fn face(&mut self, q: u32, log: Option<u32>) {
        self.tree.clear();
        self.prepared = None;
        let log = log.unwrap_or_else(|| {
            let level = self.metric.reach.level;
            self.patch
                .prepare_points(self.surface, q, level, None, Sides::Hull);
            first_log(self.metric, self.patch.spline().as_ref())
        });
        self.is_flat = log == FLAT;
        if !self.is_flat {
            self.irregular = self.surface.irregular_corners(q);
            self.grow(q, 0, log);
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
            self.tree.set_need(node, own + (need - depth));
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
