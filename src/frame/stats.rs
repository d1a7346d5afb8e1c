//! Where the time of a frame goes, by stage.

use std::time::{Duration, Instant};

/// A stage of the frame; the names are those of the modules.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Levels and blocks of an adaptive tessellation.
    Flatness,
    /// Tags of vertices and the blocks that follow from them.
    DepthTags,
    /// Refinement patterns as blocks.
    Patterns,
    /// Hulls and screen boxes.
    Setup,
    /// Bins of tiles.
    Bin,
    /// Points, normals and texture coordinates of blocks.
    Dice,
    /// Displacement of points and their normals.
    Displace,
    /// Projection, coverage and depth.
    Tile,
    /// Colours of samples.
    Shade,
    /// Samples to pixels.
    Film,
}

impl Stage {
    /// All stages, in the order of the frame.
    pub const ALL: [Self; 10] = [
        Self::Flatness,
        Self::DepthTags,
        Self::Patterns,
        Self::Setup,
        Self::Bin,
        Self::Dice,
        Self::Displace,
        Self::Tile,
        Self::Shade,
        Self::Film,
    ];

    /// Its name, as in `--stats`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Flatness => "flatness",
            Self::DepthTags => "depth_tags",
            Self::Patterns => "patterns",
            Self::Setup => "setup",
            Self::Bin => "bin",
            Self::Dice => "dice",
            Self::Displace => "displace",
            Self::Tile => "tile",
            Self::Shade => "shade",
            Self::Film => "film",
        }
    }
}

/// Time per stage, summed over what one thread did. Measures nothing unless switched on.
#[derive(Clone, Copy, Debug, Default)]
pub struct StageTimes {
    pub(super) on: bool,
    total: [Duration; Stage::ALL.len()],
}

impl StageTimes {
    pub(super) fn measuring(on: bool) -> Self {
        Self {
            on,
            ..Self::default()
        }
    }
    #[inline]
    pub(super) fn start(&self) -> Option<Instant> {
        self.on.then(Instant::now)
    }
    #[inline]
    pub(super) fn stop(&mut self, stage: Stage, clock: Option<Instant>) {
        if let Some(begin) = clock {
            self.total[stage as usize] += begin.elapsed();
        }
    }
    /// Ends one stage and begins the next.
    #[inline]
    pub(super) fn lap(&mut self, stage: Stage, clock: Option<Instant>) -> Option<Instant> {
        let begin = clock?;
        let now = Instant::now();
        self.total[stage as usize] += now - begin;
        Some(now)
    }
    /// Hands time that was counted with one stage to another.
    #[inline]
    pub(super) fn shift(&mut self, from: Stage, to: Stage, time: Duration) {
        let time = time.min(self.total[from as usize]);
        self.total[from as usize] -= time;
        self.total[to as usize] += time;
    }
    pub(super) fn add(&mut self, other: &Self) {
        for (a, b) in self.total.iter_mut().zip(&other.total) {
            *a += *b;
        }
    }
    /// Time spent in a stage, summed over threads.
    #[must_use]
    pub fn get(&self, stage: Stage) -> Duration {
        self.total[stage as usize]
    }
}

/// What a frame did.
#[derive(Clone, Debug, Default)]
pub struct FrameStats {
    /// Faces of the cages.
    pub faces: u64,
    /// Micro-triangles of all faces drawn.
    pub microtriangles: u64,
    /// Pixels with something in them.
    pub pixels_covered: u64,
    /// Level of each object; of adaptive ones, their deepest.
    pub levels: Vec<u32>,
    /// Time per stage summed over threads; zero unless asked for.
    pub times: StageTimes,
    /// Wall time of set-up, bins, and tiles.
    pub wall: [Duration; 3],
    /// Wall time of the adaptive tessellation.
    pub flatness: Duration,
    /// Wall time of depth tags and their blocks.
    pub depth_tags: Duration,
    /// Wall time of refinement patterns.
    pub patterns: Duration,
    /// Bytes of adaptive tessellations: blocks with their moved points, and trees of edges.
    pub flatness_bytes: u64,
    /// Points that tiles diced, to draw and to shade them.
    pub diced: u64,
    /// Points that were diced to find where displaced blocks are.
    pub diced_in_setup: u64,
}
