//! Sources of the device's stages. Each is the numbers that both sides know, `records.wgsl`, which holds the shared structures, what it shares
//! with others and its own file.

mod mesh;

use super::records::POINT_FLOATS;
use crate::patch::NET_LEN;
use crate::raster::{GUARD_BAND, SCREEN_MARGIN};
use crate::records::BLOCK_POINTS;
use crate::scheme::INFINITE_SHARPNESS;
use crate::shade::{LEVEL_COLORS, ShadeMode};
use crate::tessellate::flatness::numbers;
use crate::topology::NONE;
use std::fmt::Write;

pub use mesh::{Faces, MeshStep, connectivity, edge, face, limit, vertex};

/// A stage's source, by its name.
#[derive(Clone, Debug)]
pub struct Source {
    /// Name of the stage.
    pub name: &'static str,
    /// WGSL.
    pub text: String,
}

/// Workgroups along x of a dispatch; more go into further rows.
pub(super) const ACROSS: u32 = 32768;
/// Invocations of a workgroup.
pub(super) const GROUP: u32 = 64;
/// Parts of one buffer begin at multiples of this many words.
pub(super) const ALIGN: u32 = 64;
/// Micro-quads along a side of the largest block, as a power of two.
pub(super) const BLOCK_BITS: u32 = (BLOCK_POINTS as u32 - 1).ilog2();

/// Kind of a chunk of quadratic patches through points of level 1.
pub const QAS: u32 = 1;
/// Kind of a chunk of curved PN triangles.
pub const PN: u32 = 2;

/// In place of a point of a table, of a normal that is made of the ring around a corner (`rings`).
pub const RINGED: u32 = u32::MAX - 1;
/// How: across the two ends of the ring, as the mean of its faces' normals, or as its area. The last bit says that two ends may enclose more
/// than half a turn.
pub const RING_ENDS: u32 = 0;
/// See above.
pub const RING_MEAN: u32 = 1;
/// See above.
pub const RING_AREA: u32 = 2;
/// See above.
pub const RING_REFLEX: u32 = 4;

/// [`Rise::shape`](super::records::Rise::shape) of what is not displaced.
pub const STILL: u32 = 0;
/// Of a map.
pub const MAP: u32 = 1;
/// Of octaves of noise.
pub const NOISE: u32 = 2;
/// Of octaves of ridges.
pub const RIDGED: u32 = 3;
/// Of waves.
pub const RIPPLES: u32 = 4;

/// Mark of a [`Patch`](super::records::Patch) whose sides follow from what its inside says.
pub const PATCH_PLAIN: u32 = 16;
/// Of one that is not left out of all pictures.
pub const PATCH_DRAWN: u32 = 32;
/// Of a quad of a face that is split into quads.
pub const PATCH_SPLIT: u32 = 64;
/// Mark of an [`Edge`](super::records::Edge) that runs against the side of its second face.
pub const EDGE_BACK: u32 = 16;
/// Depths of the squares below a face that the device makes blocks of.
pub(super) const TREE_DEPTH: u32 = numbers::RESAMPLED;
/// Words of a face's quadtree: the number of its nodes, and as many as there can be.
pub(super) const NODE_WORDS: u32 = 1 + squares(TREE_DEPTH);
/// The finest level whose samples are kept: those of the next lie between them.
const KEPT: u32 = BLOCK_BITS - 1;
/// Squares around each other that are measured one after the other: the face, then quarters at a corner.
const NESTED: u32 = BLOCK_BITS - numbers::TRUSTED + 1;

// Cells of the last step are quarters of the smallest squares; nodes have two bits for their depth and three for a place and a level.
const _: () = assert!(KEPT == TREE_DEPTH + 1 && TREE_DEPTH <= 3 && BLOCK_BITS <= 7);

/// Squares of a quadtree down to a depth.
const fn squares(depth: u32) -> u32 {
    ((1 << (2 * depth + 2)) - 1) / 3
}

/// Squares of all that are nested; each reaches a depth less far than the one around it.
fn nested_squares() -> u32 {
    (0..NESTED).map(|number| squares(KEPT - number)).sum()
}

/// Triangles whose normals may be further off where samples ask for more levels than there are, in pixels.
const FEW_PIXELS: f32 = 4.0;
/// Where counts of a chunk stand whose blocks the device decides: blocks that are drawn, all of them, their points, moved points, micro-quads.
pub(super) const TOTAL_DRAWN: u32 = 0;
pub(super) const TOTAL_BLOCKS: u32 = 1;
const TOTAL_POINTS: u32 = 2;
pub(super) const TOTAL_MOVES: u32 = 3;
pub(super) const TOTAL_QUADS: u32 = 4;
/// Faces and edges that ask for more than there is, the deepest level, and the most that the last step adds where more is asked for, in
/// thousandths of what is allowed.
pub(super) const TOTAL_DEEPER: u32 = 5;
pub(super) const TOTAL_DEEPEST: u32 = 6;
pub(super) const TOTAL_MISSING: u32 = 7;
/// Their number.
#[cfg(feature = "gpu")]
pub(super) const TOTALS: u32 = 8;

/// Faces whose sums are taken by one workgroup.
pub(super) const PART: u32 = 16 * GROUP;

/// Bits of a row or column of a face.
const PLACE_BITS: u32 = 12;

/// A place on the grid of `level` of a face of PN triangles.
#[must_use]
pub fn pn_place([x, y]: [u32; 2], level: u32) -> u32 {
    (((level << PLACE_BITS) | y) << PLACE_BITS) | x
}

const INDEX: &str = include_str!("wgsl/index.wgsl");
const RECORDS: &str = include_str!("wgsl/records.wgsl");
const EVALUATE: &str = include_str!("wgsl/evaluate.wgsl");
const METRIC: &str = include_str!("wgsl/metric.wgsl");
const TREE: &str = include_str!("wgsl/tree.wgsl");
const HEIGHT: &str = include_str!("wgsl/height.wgsl");
const SCREEN: &str = include_str!("wgsl/screen.wgsl");
const TEXTURE: &str = include_str!("wgsl/texture.wgsl");
const SURFACE: &str = include_str!("wgsl/surface.wgsl");
const ENCODE: &str = include_str!("wgsl/encode.wgsl");
const CUTOUT: &str = include_str!("wgsl/cutout.wgsl");
const WIDE: &str = include_str!("wgsl/wide.wgsl");

/// How keys are written: by one maximum of 64 bits, or in two passes of 32.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keys {
    /// `atomicMax` of `u64`.
    Wide,
    /// Depths first, then the lowest id among those of equal depth.
    TwoPass,
}

fn keys(keys: Keys) -> &'static str {
    match keys {
        Keys::Wide => include_str!("wgsl/keys_64.wgsl"),
        Keys::TwoPass => include_str!("wgsl/keys_32.wgsl"),
    }
}

/// Numbers that both sides know, from where the processor has them.
fn numbers() -> String {
    let mut out = String::new();
    for (name, value) in [
        ("ACROSS", ACROSS),
        ("GROUP", GROUP),
        ("ALIGN", ALIGN),
        ("NONE", NONE),
        ("POINT_FLOATS", POINT_FLOATS),
        ("BLOCK_SIDE", BLOCK_POINTS as u32),
        ("BLOCK_BITS", BLOCK_BITS),
        ("LEVEL_COUNT", LEVEL_COLORS.len() as u32),
        ("QAS", QAS),
        ("PN", PN),
        ("PN_HALF", NET_LEN),
        ("PLACE_BITS", PLACE_BITS),
        ("PATCH_PLAIN", PATCH_PLAIN),
        ("PATCH_DRAWN", PATCH_DRAWN),
        ("PATCH_SPLIT", PATCH_SPLIT),
        ("EDGE_BACK", EDGE_BACK),
        ("NODE_WORDS", NODE_WORDS),
        ("TREE_DEPTH", TREE_DEPTH),
        ("SQUARES", squares(TREE_DEPTH)),
        ("KEPT", KEPT),
        ("CELLS", squares(KEPT)),
        ("NESTED", NESTED),
        ("NEEDS", nested_squares()),
        ("PART", PART),
        ("TOTAL_DRAWN", TOTAL_DRAWN),
        ("TOTAL_BLOCKS", TOTAL_BLOCKS),
        ("TOTAL_POINTS", TOTAL_POINTS),
        ("TOTAL_MOVES", TOTAL_MOVES),
        ("TOTAL_QUADS", TOTAL_QUADS),
        ("TOTAL_DEEPER", TOTAL_DEEPER),
        ("TOTAL_DEEPEST", TOTAL_DEEPEST),
        ("TOTAL_MISSING", TOTAL_MISSING),
        ("TRUSTED", numbers::TRUSTED),
        ("UNEVEN_STEPS", numbers::UNEVEN_STEPS),
        ("DEEPER", numbers::DEEPER),
        ("OVERHEAD", numbers::OVERHEAD),
        ("RINGED", RINGED),
        ("RING_ENDS", RING_ENDS),
        ("RING_MEAN", RING_MEAN),
        ("RING_REFLEX", RING_REFLEX),
        ("STILL", STILL),
        ("MAP", MAP),
        ("NOISE", NOISE),
        ("RIDGED", RIDGED),
        ("RIPPLES", RIPPLES),
        ("LIT", ShadeMode::Lit as u32),
        ("FLAT", ShadeMode::Flat as u32),
        ("NORMALS", ShadeMode::Normals as u32),
        ("UV", ShadeMode::Uv as u32),
        ("DEPTH", ShadeMode::Depth as u32),
    ] {
        let _ = writeln!(out, "const {name} = {value}u;");
    }
    for (name, value) in [
        ("GUARD_BAND", GUARD_BAND as f32),
        ("SMALLEST", f32::MIN_POSITIVE),
        ("INFINITE", INFINITE_SHARPNESS),
        ("SCREEN_MARGIN", SCREEN_MARGIN),
        ("FEW_PIXELS", FEW_PIXELS),
        ("BOUND_SHARE", numbers::BOUND_SHARE),
        ("ROUGH", numbers::ROUGH),
        ("DOT", numbers::DOT),
        ("LEFT", numbers::LEFT),
        ("UNEVEN", numbers::UNEVEN),
    ] {
        let _ = writeln!(out, "const {name} = {value:?}f;");
    }
    let colors = LEVEL_COLORS.map(|[r, g, b]| format!("vec3<f32>({r:?}f, {g:?}f, {b:?}f)"));
    let colors = colors.join(", ");
    let _ = writeln!(
        out,
        "const LEVEL_COLORS = array<vec3<f32>, LEVEL_COUNT>({colors});"
    );
    out
}

/// What stages leave out where a scene has none of it: long code that drivers need not read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Variant {
    /// Whether anything is displaced.
    pub lifted: bool,
    /// Whether normals are tilted pixel by pixel.
    pub tilted: bool,
    /// Whether anything is cut out by opacity maps.
    pub cut: bool,
    /// Whether blocks are lists of triangles.
    pub listed: bool,
}

impl Variant {
    /// Those with nothing and with everything.
    pub const ENDS: [Self; 2] = [
        Self {
            lifted: false,
            tilted: false,
            cut: false,
            listed: false,
        },
        Self {
            lifted: true,
            tilted: true,
            cut: true,
            listed: true,
        },
    ];
    /// How many there are.
    #[cfg(feature = "gpu")]
    pub(super) const COUNT: usize = 16;

    /// Its number.
    #[cfg(feature = "gpu")]
    pub(super) fn number(self) -> usize {
        let all = [self.lifted, self.tilted, self.cut, self.listed];
        (all.iter().rev()).fold(0, |number, &is| number << 1 | usize::from(is))
    }

    fn constants(self) -> String {
        let of = [
            ("LIFTED", self.lifted),
            ("TILTED", self.tilted),
            ("CUT", self.cut),
            ("LISTED", self.listed),
        ];
        of.map(|(name, is)| format!("const {name} = {is};\n"))
            .concat()
    }
}

fn source(name: &'static str, parts: &[&str]) -> Source {
    Source {
        name,
        text: [&[&*numbers(), INDEX, RECORDS], parts].concat().join("\n"),
    }
}

/// Corners, sides and insides of blocks.
#[must_use]
pub fn dice(variant: Variant) -> Source {
    let parts = [
        &*variant.constants(),
        EVALUATE,
        HEIGHT,
        include_str!("wgsl/displace.wgsl"),
        include_str!("wgsl/patch.wgsl"),
        include_str!("wgsl/rings.wgsl"),
        include_str!("wgsl/sides.wgsl"),
        include_str!("wgsl/dice.wgsl"),
    ];
    source("dice", &parts)
}

/// What the faces of a view need.
#[must_use]
pub fn flatness() -> Source {
    let parts = [
        &*Variant::default().constants(),
        EVALUATE,
        METRIC,
        TREE,
        include_str!("wgsl/closed.wgsl"),
        include_str!("wgsl/flatness.wgsl"),
        include_str!("wgsl/cut.wgsl"),
    ];
    source("flatness", &parts)
}

/// How edges are split by it.
#[must_use]
pub fn edges() -> Source {
    let parts = [
        &*Variant::default().constants(),
        EVALUATE,
        METRIC,
        TREE,
        include_str!("wgsl/edges.wgsl"),
    ];
    source("edges", &parts)
}

/// The blocks that come of both.
#[must_use]
pub fn blocks() -> Source {
    source("blocks", &[TREE, include_str!("wgsl/blocks.wgsl")])
}

/// Prefix sums over faces.
#[must_use]
pub fn scan() -> Source {
    source("scan", &[TREE, include_str!("wgsl/scan.wgsl")])
}

/// Micro-quads into keys.
#[must_use]
pub fn tile(by: Keys, variant: Variant) -> Source {
    let parts = [
        &*variant.constants(),
        SCREEN,
        WIDE,
        SURFACE,
        TEXTURE,
        CUTOUT,
        keys(by),
        include_str!("wgsl/tile.wgsl"),
    ];
    source("tile", &parts)
}

/// Large and clipped quads into keys.
#[must_use]
pub fn large(by: Keys, variant: Variant) -> Source {
    let parts = [
        &*variant.constants(),
        SCREEN,
        WIDE,
        SURFACE,
        TEXTURE,
        CUTOUT,
        include_str!("wgsl/clip.wgsl"),
        keys(by),
        include_str!("wgsl/large.wgsl"),
    ];
    source("large", &parts)
}

/// Micro-quads into keys, by the device's own rasteriser.
#[must_use]
pub fn raster(variant: Variant) -> Source {
    let parts = [
        &*variant.constants(),
        SCREEN,
        WIDE,
        SURFACE,
        TEXTURE,
        CUTOUT,
        include_str!("wgsl/raster.wgsl"),
    ];
    source("raster", &parts)
}

/// What reads the surface that samples show.
fn of_shown(name: &'static str, variant: Variant, own: &[&str]) -> Source {
    let constants = variant.constants();
    let parts = [
        &*constants,
        SCREEN,
        WIDE,
        SURFACE,
        TEXTURE,
        HEIGHT,
        include_str!("wgsl/light.wgsl"),
        include_str!("wgsl/relief.wgsl"),
        include_str!("wgsl/shown.wgsl"),
    ];
    source(name, &[&parts, own].concat())
}

/// Keys into colours.
#[must_use]
pub fn shade(variant: Variant) -> Source {
    of_shown("shade", variant, &[include_str!("wgsl/shade.wgsl")])
}

/// Keys into codes of what is written beside the picture.
#[must_use]
pub fn outputs(variant: Variant) -> Source {
    let own = [ENCODE, include_str!("wgsl/outputs.wgsl")];
    of_shown("outputs", variant, &own)
}

/// Colours into bytes.
#[must_use]
pub fn film() -> Source {
    source("film", &[ENCODE, include_str!("wgsl/film.wgsl")])
}

/// All of them.
#[must_use]
pub fn all() -> Vec<Source> {
    let mut out = vec![film()];
    for faces in [Faces::Quads, Faces::Triangles, Faces::Polygons] {
        let step = MeshStep::of(faces);
        let stages = [face, edge, vertex, connectivity, limit];
        out.extend(stages.map(|stage| stage(step)));
    }
    out.extend([flatness(), edges(), blocks(), scan()]);
    for variant in Variant::ENDS {
        out.extend([dice(variant), shade(variant), outputs(variant)]);
        out.push(raster(variant));
        for by in [Keys::Wide, Keys::TwoPass] {
            out.extend([tile(by, variant), large(by, variant)]);
        }
    }
    out
}
