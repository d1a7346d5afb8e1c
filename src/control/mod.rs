//! Control levels: what is left of a mesh, level by level, where features keep its quads from being patches.
//!
//! A quad with a *feature* at a corner (sharpness that fades, or a dart) is no B-spline however it is turned; its four children may be.
//! So those quads are refined, and of the children again those at features, as deep as sharpness lasts or the dicing goes
//! (feature-adaptive subdivision; Nießner, Loop, Meyer, DeRose, *Feature-adaptive GPU rendering of Catmull-Clark subdivision surfaces*,
//! 2012). Each level holds the children of the refined quads and one ring of support around them, in its own small topology: cost is paid
//! by the quads at features alone. Everything else about creases is gone once a level is cut open along its infinite edges ([`cut`]).

mod channel;
mod cut;
mod fans;
mod level;
mod pieces;
mod size;
pub(crate) mod tables;
mod tips;

use crate::dice::MAX_LEVEL;
use crate::limits::{Budget, LimitError};
use crate::refine::{self, Level};
use crate::topology::Topology;
pub(crate) use channel::TreeChannel;
pub(crate) use fans::Fans;
use level::ControlLevel;
pub(crate) use level::{ChannelMesh, Kind};
pub(crate) use pieces::{Pieces, levels_beyond};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use tables::surroundings;

/// Trees below single faces that are kept.
const MOST_FURTHER: usize = 32;

/// Trees that go on below single faces, by depth and face, with the face's number in them.
type FurtherTrees = BTreeMap<(u32, u32), (Arc<ControlTree>, u32)>;

/// Kept for the next place nearby; what is found does not depend on it.
#[derive(Debug, Default)]
struct Further(Mutex<FurtherTrees>);

impl Further {
    fn lock(&self) -> MutexGuard<'_, FurtherTrees> {
        // Trees are whole or not there, so a panic elsewhere leaves nothing broken behind.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Clone for Further {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// All control levels of a surface, made as deep as they are asked for.
#[derive(Clone, Debug)]
pub(crate) struct ControlTree {
    options: refine::Options,
    root: ControlLevel,
    deeper: [OnceLock<Option<Box<ControlLevel>>>; MAX_LEVEL as usize],
    /// Set once evaluation has the levels that it makes for all faces at once.
    evaluated: OnceLock<()>,
    further: Further,
}

impl ControlTree {
    /// The tree over `level`, whose faces are all quads or all triangles. `colors` holds one value per vertex, or nothing.
    pub(crate) fn new(level: Level<f64>, colors: Vec<[f64; 3]>, options: refine::Options) -> Self {
        let owned = vec![true; level.topology.face_count()];
        Self::of(
            ControlLevel::new(level, Vec::new(), colors, &owned, &options),
            options,
        )
    }

    fn of(root: ControlLevel, options: refine::Options) -> Self {
        Self {
            root,
            options,
            deeper: [const { OnceLock::new() }; MAX_LEVEL as usize],
            evaluated: OnceLock::new(),
            further: Further::default(),
        }
    }

    /// The first level's channels.
    pub(crate) fn root(&self, kind: Kind) -> Option<&ChannelMesh> {
        self.root.channel(kind)
    }

    /// The first level, not cut open.
    pub(crate) fn whole(&self) -> &Topology {
        &self.root.level.topology
    }

    /// Moves the points of the first level. The levels below that are there already get theirs by the same connectivity.
    pub(crate) fn update(&mut self, points: Vec<[f64; 3]>) {
        self.root.set_points(points, &self.options);
        self.further = Further::default();
        for depth in 0..self.deeper.len() {
            let Some(Some(mut below)) = self.deeper[depth].take() else {
                break;
            };
            if let Some(parent) = self.level(depth as u32) {
                let part: Vec<[f64; 3]> = (below.above.iter())
                    .map(|&v| parent.level.points[v as usize])
                    .collect();
                let points = refine::next_points(&below.from, &self.options, &part);
                below.set_points(points, &self.options);
            }
            self.deeper[depth] = OnceLock::from(Some(below));
        }
    }

    /// Makes the levels that dicing at `level` needs, and as many as `beyond` more.
    ///
    /// Nobody waits for another thread here: two that come at once both make the level, and the first to be done is kept. Waiting would be
    /// a deadlock where a thread pool hands the waiting thread a task that comes here again.
    pub(crate) fn ensure(&self, level: u32, beyond: u32) {
        // Without a budget nothing fails.
        let _ = self.make(level, beyond, None);
    }

    /// The same within a budget. Levels that are there already count like those that are made, so that what fails does not depend on
    /// what was drawn before.
    ///
    /// # Errors
    /// The next level would not fit; those before it are kept.
    pub(crate) fn try_ensure(
        &self,
        level: u32,
        beyond: u32,
        budget: &mut Budget<'_>,
    ) -> Result<(), LimitError> {
        self.make(level, beyond, Some(budget))
    }

    fn make(
        &self,
        level: u32,
        beyond: u32,
        mut budget: Option<&mut Budget<'_>>,
    ) -> Result<(), LimitError> {
        for depth in 1..=(level + beyond).min(MAX_LEVEL) {
            let Some(parent) = self.level(depth - 1) else {
                break;
            };
            if let Some(budget) = budget.as_deref_mut() {
                let (kept, passing) = parent.next_bytes();
                budget.take("the control faces at fading creases", kept, passing)?;
            }
            self.make_below(parent, depth);
        }
        self.end_at(level);
        Ok(())
    }

    /// Makes the level at `depth` below `parent`, unless it is there.
    fn make_below(&self, parent: &ControlLevel, depth: u32) {
        let slot = &self.deeper[depth as usize - 1];
        if slot.get().is_none() {
            // When another thread was first, its level is the same.
            let _ = slot.set(parent.next(&self.options).map(Box::new));
        }
    }

    /// Makes the limits at features where the tree ends at `level`.
    fn end_at(&self, level: u32) {
        if let Some(last) = self.level(level.min(MAX_LEVEL))
            && last.tips.get().is_none()
        {
            let _ = last.tips.set(last.make_tips(&self.options));
        }
    }

    /// Makes the levels that evaluation has for all faces at once: as many as `bytes` hold. Where these end, it goes on for single faces
    /// ([`ControlTree::continued`]), with the same bits. The first to call decides.
    pub(crate) fn ensure_evaluation(&self, bytes: u128) {
        if self.evaluated.get().is_some() {
            return;
        }
        let mut left = bytes;
        for depth in 1..=MAX_LEVEL {
            let Some(parent) = self.level(depth - 1) else {
                break;
            };
            let (kept, passing) = parent.next_bytes();
            if kept + passing > left {
                break;
            }
            left -= kept;
            self.make_below(parent, depth);
        }
        self.end_at(MAX_LEVEL);
        let _ = self.evaluated.set(());
    }

    fn level(&self, depth: u32) -> Option<&ControlLevel> {
        match depth {
            0 => Some(&self.root),
            d => self.deeper.get(d as usize - 1)?.get()?.as_deref(),
        }
    }

    /// A tree of `levels` levels below face `face` of the level at `depth` alone, and the face's number in it: where this tree ends and
    /// the face is still at a feature. Faces keep their order, so the bits are those of a tree of all faces.
    pub(crate) fn continued(&self, depth: u32, face: u32, levels: u32) -> Option<(Arc<Self>, u32)> {
        let key = (depth, face);
        if let Some(found) = self.further.lock().get(&key) {
            return Some(found.clone());
        }
        let level = &self.level(depth)?.level;
        if face as usize >= level.topology.face_count() {
            return None;
        }
        let (faces, own) = surroundings(&level.topology, face, 1);
        let owned: Vec<bool> = faces.iter().map(|&(f, _)| f == face).collect();
        let part = level.part(&faces).level;
        let root = ControlLevel::new(part, Vec::new(), Vec::new(), &owned, &self.options);
        let tree = Arc::new(Self::of(root, self.options));
        tree.ensure(levels, 0);
        let found = (tree, own);
        let mut kept = self.further.lock();
        if kept.len() >= MOST_FURTHER {
            kept.clear();
        }
        kept.insert(key, found.clone());
        Some(found)
    }

    /// Fans whose positions are the control points after `level` steps; one set for every control level.
    pub(crate) fn refined(&self, level: u32) -> Vec<Fans> {
        self.ensure(level, 0);
        let mut all: Vec<Fans> = (0..=level)
            .map_while(|depth| self.level(depth).map(|l| l.refined(level - depth)))
            .collect();
        // The fans of features know nothing of their vertices' way: it ends where the vertex is no feature any more.
        for top in 0..all.len() {
            let Some(here) = self.level(top as u32) else {
                break;
            };
            let t = &here.points.topology;
            for fan in 0..t.fans().len() as u32 {
                let v = t.fan_vertex(fan);
                if let Some((depth, v)) = self.settled(top as u32, v, level) {
                    let point = all[depth as usize].limits()[v as usize];
                    all[top].limits_mut()[fan as usize] = point;
                }
            }
        }
        all
    }

    /// Where feature `v` of the level at `depth` stops being one, at `last` at the latest: that depth, and its descendant there.
    fn settled(&self, mut depth: u32, mut v: u32, last: u32) -> Option<(u32, u32)> {
        let top = depth;
        while depth < last && self.level(depth)?.rules.features[v as usize] {
            let below = self.level(depth + 1)?;
            v = below.above.binary_search(&v).ok()? as u32;
            depth += 1;
        }
        (depth > top).then_some((depth, v))
    }

    /// The tree as dicing sees it, for one channel.
    pub(crate) fn channel<'a>(
        &'a self,
        kind: Kind,
        level: u32,
        refined: Option<&'a [Fans]>,
    ) -> TreeChannel<'a> {
        TreeChannel {
            tree: self,
            kind,
            level,
            refined,
        }
    }
}
