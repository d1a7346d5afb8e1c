//! Quads that are no patches: dicing through the control levels below them.
//!
//! A quad at a feature is a tree of deeper quads. The leaves are diced like any other quad, into their place of the quad's grid. On the
//! sides the tree must not show: a side without a feature at its ends follows the edge's own rule, as from the other face; any other side
//! is what the tree of its *owner* says, the face with the edge's first half-edge, and the other face evaluates that tree along the side
//! by the same code. Across an infinite crease only points are shared; each face has its own normals.

use super::edge::EdgeSamples;
use super::face::{Channel, DiceFault, FacePatch, Sides};
use super::fan_points::FanPoints;
use super::regular::{BlockRange, dice_sheets};
use crate::dispatch;
use crate::records::Grid3;
use crate::topology::{NONE, Topology};

/// One control level of a channel of quads, or of triangles with their fans.
#[derive(Debug)]
pub(crate) struct View<'a, F = FanPoints> {
    /// Cut open along infinite creases (and seams).
    pub(crate) topology: &'a Topology,
    pub(crate) points: &'a [[f32; 3]],
    pub(crate) fans: &'a F,
    /// First of the four children of every face in the next level; [`NONE`] or nothing where a face is a patch.
    pub(crate) children: &'a [u32],
    /// Per vertex of the uncut mesh, whether its fans' rules do not hold.
    pub(crate) features: &'a [bool],
    /// The uncut mesh.
    pub(crate) whole: &'a Topology,
    /// Limits at features by vertex of `topology`, sorted; in place of those of the fans.
    pub(crate) tips: Option<&'a [(u32, [f32; 3])]>,
}

// Whatever the fans are: derived, they would have to be copied themselves.
impl<F> Clone for View<'_, F> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<F> Copy for View<'_, F> {}

/// Control levels by depth; 0 is the channel that is diced.
pub(crate) trait Descend: std::fmt::Debug + Sync {
    /// The level at `depth`, if there is one.
    fn at(&self, depth: u32) -> Option<View<'_>>;
}

impl<F> View<'_, F> {
    pub(crate) fn first_child(&self, face: u32) -> Option<u32> {
        let first = self.children.get(face as usize).copied();
        first.filter(|&c| c != NONE)
    }

    /// The limit of corner `h` if it is at a feature.
    pub(super) fn tip(&self, h: u32) -> Option<[f32; 3]> {
        let tips = self.tips?;
        let found = tips.binary_search_by_key(&self.topology.vertex(h), |t| t.0);
        found.ok().map(|i| tips[i].1)
    }
}

/// A point that no spline stands for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dot {
    at: [u32; 2],
    pub(super) point: [f32; 3],
    normal: [f32; 3],
}

impl Dot {
    pub(super) fn is_in(&self, low: [u32; 2], high: [u32; 2]) -> bool {
        (0..2).all(|k| (low[k]..=high[k]).contains(&self.at[k]))
    }
}

/// What evaluates the sides that other faces own.
#[derive(Clone, Debug)]
pub(super) struct Owner {
    patch: FacePatch,
    points: Box<Grid3>,
    normals: Box<Grid3>,
    samples: EdgeSamples,
}

impl Default for Owner {
    fn default() -> Self {
        Self {
            patch: FacePatch::default(),
            points: Grid3::boxed(),
            normals: Grid3::boxed(),
            samples: EdgeSamples::default(),
        }
    }
}

/// Whether quad `q` must be diced through deeper levels.
pub(super) fn is_refined(channel: Channel<'_>, q: u32) -> bool {
    let root = channel.below.and_then(|b| b.at(0));
    root.is_some_and(|r| r.first_child(q).is_some())
}

impl FacePatch {
    /// Prepares a quad with features at its corners. Level, target and sides are set.
    pub(super) fn prepare_refined(&mut self, channel: Channel<'_>, below: &dyn Descend, q: u32) {
        let Some(root) = below.at(0) else { return };
        let feature = |c: usize| root.features[root.whole.vertex(4 * q + c as u32 % 4) as usize];
        let plain: [bool; 4] = std::array::from_fn(|c| !feature(c) && !feature((c + 1) % 4));
        if self.wanted > Sides::None {
            self.sides
                .iter_mut()
                .for_each(|s| s.resize(1 << self.level));
            if plain.contains(&true) {
                // For the sides; the splines would be right only away from the features.
                self.prepare_patch(channel, q);
                (0..4).filter(|&c| plain[c]).for_each(|c| self.keep_side(c));
                self.sheets.clear();
                self.hull.clear();
            }
        }
        self.descend(below, 0, q, [0, 0], self.level, None);
        if self.wanted > Sides::None {
            for c in (0..4).filter(|&c| !plain[c]) {
                self.owned_side(below, root, q, c);
            }
        }
    }

    /// Corners at features, where the dicing ends with the quad itself.
    pub(super) fn tip_corners(&mut self, below: &dyn Descend, q: u32) {
        let Some(view) = below.at(0) else { return };
        for c in 0..4 {
            if let Some(point) = view.tip(4 * q + c as u32) {
                self.corners[c].0 = point;
            }
        }
    }

    /// Adds the leaves below quad `q` of the control level at `depth`, or those along its side `only`.
    fn descend(
        &mut self,
        below: &dyn Descend,
        depth: u32,
        q: u32,
        place: [u32; 2],
        level: u32,
        only: Option<usize>,
    ) {
        let Some(view) = below.at(depth) else { return };
        let Some(first) = view.first_child(q).filter(|_| level > 0) else {
            self.leaf(&view, q, place, level);
            return;
        };
        // Limits of values at features are known at the last level only.
        if !view.fans.normals.is_empty() {
            self.put_corners(&view, q, place, level);
        }
        let half = 1_u32 << (level - 1);
        for c in 0..4_usize {
            if only.is_some_and(|side| c != side && c != (side + 1) % 4) {
                continue;
            }
            let [u, v] = [[0, 0], [half, 0], [half, half], [0, half]][c];
            let place = [place[0] + u, place[1] + v];
            self.descend(below, depth + 1, first + c as u32, place, level - 1, only);
        }
    }

    /// Adds a quad that is a patch (or has no level left) at its place.
    fn leaf(&mut self, view: &View<'_>, q: u32, place: [u32; 2], level: u32) {
        self.put_corners(view, q, place, level);
        if level == 0 {
            return;
        }
        let (whole, wanted, first) = (self.level, self.wanted, self.sheets.len());
        self.level = level;
        self.wanted = wanted.min(Sides::None);
        let channel = Channel {
            topology: view.topology,
            points: view.points,
            fans: view.fans,
            below: None,
            linear: false,
        };
        self.prepare_patch(channel, q);
        (self.level, self.wanted) = (whole, wanted);
        self.sheets[first..].iter_mut().for_each(|s| s.shift(place));
    }

    /// Dots at the corners of quad `q`, which are what its own level says however deep the tree goes on.
    fn put_corners(&mut self, view: &View<'_>, q: u32, place: [u32; 2], level: u32) {
        let size = 1_u32 << level;
        for (c, [u, v]) in [[0, 0], [size, 0], [size, size], [0, size]]
            .into_iter()
            .enumerate()
        {
            let h = 4 * q + c as u32;
            let fan = view.topology.fan(h) as usize;
            self.dots.push(Dot {
                at: [place[0] + u, place[1] + v],
                point: view.tip(h).unwrap_or(view.fans.limits[fan]),
                normal: view.fans.normals.get(fan).copied().unwrap_or_default(),
            });
        }
    }

    /// Samples side `c` of quad `q` from the tree of the edge's owner.
    fn owned_side(&mut self, below: &dyn Descend, root: View<'_>, q: u32, c: usize) {
        let t = root.whole;
        let h = 4 * q + c as u32;
        let own = self.fault == DiceFault::OwnDirection;
        let owner = if own { h } else { t.edge_half(t.edge(h)) };
        let mut helper = self.owner.take().unwrap_or_default();
        let normals = self.wanted == Sides::Normals;
        let joined = owner == h || root.topology.twin(h) == owner;
        if owner == h || (normals && !joined) {
            self.sample_line(
                c,
                normals,
                &mut helper.points,
                &mut helper.normals,
                &mut helper.samples,
            );
            self.sides[c].copy(&helper.samples, false, [true, normals]);
        }
        if owner != h {
            let Owner {
                patch,
                points,
                normals: normal_grid,
                samples,
            } = &mut *helper;
            patch.begin(self.level, self.target, self.wanted);
            patch.simd = self.simd;
            let side = (owner & 3) as usize;
            patch.descend(below, 0, owner / 4, [0, 0], self.level, Some(side));
            patch.sample_line(side, normals && joined, points, normal_grid, samples);
            let reversed = t.vertex(owner) != t.vertex(h);
            self.sides[c].copy(samples, reversed, [true, normals && joined]);
        }
        self.owner = Some(helper);
    }

    /// Evaluates what the sheets say along side `c`, in its direction.
    fn sample_line(
        &self,
        c: usize,
        normals: bool,
        points: &mut Grid3,
        normal_grid: &mut Grid3,
        out: &mut EdgeSamples,
    ) {
        let n = 1_u32 << self.level;
        let segments = n.min(32);
        out.resize(n as usize);
        // The coordinate that runs, and where the other one stands.
        let along = c & 1;
        let across = if c == 1 || c == 2 { n } else { 0 };
        for from in (0..n).step_by(segments as usize) {
            let place = |run: u32, other: u32| {
                if along == 0 {
                    [run, other]
                } else {
                    [other, run]
                }
            };
            let start = place(from, across.min(n - segments));
            let range = BlockRange {
                shift: 0,
                start,
                end: start[0] + segments,
                low: place(from, across),
                high: place(from + segments, across),
            };
            dispatch!(
                self.simd,
                dice_sheets(
                    &self.sheets,
                    self.target,
                    range,
                    points,
                    normals.then_some(&mut *normal_grid)
                )
            );
            self.put_dots(range, points, normals.then_some(&mut *normal_grid));
            for k in 0..=segments {
                let at = place(from + k, across);
                let (i, j) = (
                    (at[0] - range.start[0]) as usize,
                    (at[1] - range.start[1]) as usize,
                );
                let to = if c < 2 { from + k } else { n - from - k };
                out.set(to as usize, points.get(i, j), normal_grid.get(i, j));
            }
        }
    }

    /// Writes the dots inside a block; where there are several, the one of the shallowest level is seen.
    pub(super) fn put_dots(
        &self,
        range: BlockRange,
        points: &mut Grid3,
        mut normals: Option<&mut Grid3>,
    ) {
        let between = (1 << range.shift) - 1;
        for dot in self.dots.iter().rev() {
            let at = dot.at.map(|k| k >> range.shift);
            let on_grid = (dot.at[0] | dot.at[1]) & between == 0;
            if !on_grid || !(0..2).all(|k| (range.low[k]..=range.high[k]).contains(&at[k])) {
                continue;
            }
            let [i, j] = [0, 1].map(|k| (at[k] - range.start[k]) as usize);
            points.set(i, j, dot.point);
            if let Some(normals) = normals.as_deref_mut() {
                normals.set(i, j, dot.normal);
            }
        }
    }
}
