//! What every face needs: from samples of its inside, as far as they are needed.

use super::closed::{self, Told};
use super::edges::{Face, Lines, Own, halves};
use super::levels::{DEEPER, Levels, RESAMPLED};
use super::screen::Metric;
use super::surplus::{Square as Sampled, Surplus};
use crate::dice::face::{Part as Square, Sides};
use crate::limits::{LimitError, Limits};
use crate::math;
use crate::records::{BlockSize, Grid3};
use crate::simd::Level;
use crate::surface::{QuadPatch, Spline, Surface};
use crate::tessellate::CHUNK;
use crate::tessellate::blocks::{Needs, Part};
use crate::tessellate::quadtree::{MAX_LOG, Quadtree, Shape};
use rayon::prelude::*;

/// Samples along the side of a face, one after the other while they do not tell enough, as powers of two.
const LOGS: [u32; 4] = [2, 3, 4, MAX_LOG];

/// In place of the first of them where nothing has to be sampled.
const FLAT: u8 = 0;

/// How many times as far as is allowed two triangles are, by the bound, of faces for which the first number of samples will not do.
pub(crate) const ROUGH: f32 = 8.0;

/// Samples, as a power of two, whose last step is trusted to say what the next one adds; of fewer, the next one is looked at.
pub(crate) const TRUSTED: u32 = 3;

/// Steps that are looked at beyond the last one that is wanted, at irregular corners.
pub(crate) const UNEVEN: u32 = 2;

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
    let seen = metric.seen();
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
                let inside = hull.iter().all(|&p| metric.outside(seen.point(p)) == 0);
                *plan = is_drawn(q, hull).then(|| Plan {
                    log: first_log(metric, spline.as_ref()),
                    inside,
                });
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
                        worker.face(q as u32, plans[q]);
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
fn first_log(metric: &Metric<'_>, spline: Option<&Spline>) -> u8 {
    match spline.map(|s| closed::tell(metric, s)) {
        Some(Told::Flat) => FLAT,
        Some(Told::Far(times)) if times.is_finite() && times > ROUGH => LOGS[1] as u8,
        _ => LOGS[0] as u8,
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
    out.extend(math::box_corners(
        math::sub(low, room),
        math::add(high, room),
    ));
}

/// What is known of a face that may be seen before it is sampled.
#[derive(Clone, Copy)]
struct Plan {
    /// How many samples to begin with, as a power of two, or [`FLAT`].
    log: u8,
    /// Whether all of it is in the picture.
    inside: bool,
}

/// What samples of a square say.
enum Found {
    Known,
    /// They may leave out more of a displacement than is allowed, however many they are.
    Unseen,
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
    /// Levels that are not in use.
    spare: Vec<Levels>,
    /// Whether all of the face is in the picture; if not, sides of the picture that samples are beyond, row by row, and points of a hull.
    inside: bool,
    outside: Vec<u8>,
    hull: Vec<[f32; 3]>,
    lines: Lines,
    /// Whether nothing of the face has to be sampled.
    is_flat: bool,
    /// Which of its corners are irregular.
    irregular: [bool; 4],
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
            spare: Vec::new(),
            inside: false,
            outside: Vec::new(),
            hull: Vec::new(),
            lines: Lines::default(),
            is_flat: false,
            irregular: [true; 4],
        }
    }

    /// Leaves in `tree` what face `q` needs; there is no plan for a face that is not drawn.
    fn face(&mut self, q: u32, plan: Option<Plan>) {
        self.tree.clear();
        self.prepared = None;
        self.is_flat = plan.is_some_and(|p| p.log == FLAT);
        match plan {
            Some(Plan { log: FLAT, .. }) => {}
            Some(Plan { log, inside }) => {
                self.inside = inside;
                self.irregular = self.surface.irregular_corners(q);
                self.grow(q, 0, u32::from(log));
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

    /// Samples leaf `node` by `2^log` segments and more, and cuts it up as far as it needs.
    fn grow(&mut self, q: u32, node: usize, log: u32) {
        let (depth, place) = (self.tree.nodes[node].depth(), self.tree.nodes[node].place());
        let mut levels = self.spare.pop().unwrap_or_default();
        let deepest = self.metric.reach.level.min(depth + MAX_LOG);
        match self.measure(q, (depth, place), (log, deepest), &mut levels) {
            Found::Known if levels.is_hidden([0; 3]) => self.tree.hide(node),
            Found::Unseen if depth < self.tree.deepest => {
                let first = self.tree.split(node);
                let shape = self.tree.nodes[node].shape(self.tree.face);
                for [x, y] in Levels::children(shape, 0, 0) {
                    self.grow(q, first + (x + 2 * y) as usize, MAX_LOG);
                }
            }
            Found::Known | Found::Unseen => {
                let shape = self.tree.nodes[node].shape(self.tree.face);
                self.cut(q, node, &levels, shape, [0, 0, 0]);
            }
        }
        self.spare.push(levels);
    }

    /// Finds what a square of the face needs by `2^log` segments a side, and by more while they do not tell and are at most of level `deepest`.
    fn measure(
        &mut self,
        q: u32,
        (depth, place): (u32, [u32; 2]),
        (log, deepest): (u32, u32),
        levels: &mut Levels,
    ) -> Found {
        let cap = self.metric.max_level.saturating_sub(depth);
        let mut log = log.min(deepest - depth);
        loop {
            let (sampled, hides) = self.sample(q, (depth, place), log, levels);
            if levels.is_hidden([0; 3]) {
                return Found::Known;
            }
            let need = levels.find(&sampled, &self.surplus, cap, [0, 0, 0]);
            // A few samples tell enough of what needs next to nothing; towards an irregular corner steps add nearly as much as the one
            // before, so two are looked at.
            let next = u32::from(log < TRUSTED);
            let is_uneven = sampled.irregular.contains(&true);
            let told = need + if is_uneven { UNEVEN } else { next } <= log;
            let is_last = depth + log >= deepest;
            if !hides && (told || is_last) {
                return Found::Known;
            }
            // Where all but the irregular corners is told, their quarters alone are sampled further.
            let parts = is_uneven && !hides && log >= LOGS[1] && !self.metric.reach.always;
            let parts = parts && depth + 1 + LOGS[1] <= deepest;
            if parts && levels.beside(sampled.shape, sampled.irregular) + next <= log {
                self.measure_corners(q, (depth, place), deepest, &sampled, levels);
                return Found::Known;
            }
            let promising = match hides {
                true => 0,
                false => self.surplus.promising(&sampled),
            };
            let more = LOGS.into_iter().find(|&l| l > log && l >= promising);
            match more {
                Some(more) if !is_last => log = more.min(deepest - depth),
                _ if hides && depth + log < self.metric.max_level => return Found::Unseen,
                _ => return Found::Known,
            }
        }
    }

    /// Measures the quarters of a square at irregular corners by samples of their own.
    fn measure_corners(
        &mut self,
        q: u32,
        (depth, place): (u32, [u32; 2]),
        deepest: u32,
        sampled: &Sampled,
        levels: &mut Levels,
    ) {
        let quarters = [[0, 0], [1, 0], [1, 1], [0, 1]];
        for (c, at) in quarters.into_iter().enumerate() {
            if sampled.irregular[c] && !levels.is_hidden([1, at[0], at[1]]) {
                let mut inner = self.spare.pop().unwrap_or_default();
                let place = [0, 1].map(|k| 2 * place[k] + at[k]);
                self.measure(q, (depth + 1, place), (LOGS[1], deepest), &mut inner);
                levels.insert(sampled.shape, at, &inner);
                self.spare.push(inner);
            }
        }
    }

    /// Samples a square of the face by `2^log` segments a side, and says in `levels` what of it cannot be in the picture; whether the displaced
    /// surface may leave the samples unseen by more than is allowed.
    fn sample(
        &mut self,
        q: u32,
        (depth, place): (u32, [u32; 2]),
        log: u32,
        levels: &mut Levels,
    ) -> (Sampled, bool) {
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
        let shape = self.tree.face.part(place);
        self.surplus
            .grid(self.metric, (log, shape), &mut self.points, &self.normals);
        let last = (1 << depth) - 1;
        let mut corners = [[0, 0], [last, 0], [last, last], [0, last]].map(|c| c == place);
        // The last one of a triangle's square is none of its own.
        corners[3] &= self.tree.face == Shape::Square;
        levels.clear();
        self.find_hidden(q, (part, shape), levels);
        let sampled = Sampled {
            log,
            shape,
            corners,
            irregular: [0, 1, 2, 3].map(|c| corners[c] && self.irregular[c]),
        };
        (sampled, hides)
    }

    /// Says which squares of the samples cannot be in the picture: beyond one of its sides by their points, and by their hulls.
    fn find_hidden(&mut self, q: u32, (part, shape): (Square, Shape), levels: &mut Levels) {
        // Tables have no hulls of parts.
        if self.metric.reach.always || self.inside {
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
        let at = [depth, x, y];
        let own = self.tree.nodes[node].depth();
        let smallest = own >= self.tree.deepest;
        let need = needs.get(at);
        if need < DEEPER && (smallest || needs.is_whole(s, at)) {
            match needs.is_hidden(at) {
                true => self.tree.hide(node),
                false => self.tree.set_need(node, own + (need - depth)),
            }
            return;
        }
        // The smallest squares are sampled as deep as can be.
        if smallest && depth > 0 {
            return self.grow(q, node, MAX_LOG);
        }
        if depth >= RESAMPLED {
            return self.grow(q, node, LOGS[1]);
        }
        let first = self.tree.split(node);
        for [cx, cy] in Levels::children(s, x, y) {
            let k = (cx & 1) + 2 * (cy & 1);
            self.cut(q, first + k as usize, needs, s, [depth + 1, cx, cy]);
        }
    }
}
