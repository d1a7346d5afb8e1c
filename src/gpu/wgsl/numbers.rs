//! Numbers that both sides know.

use crate::gpu::records::POINT_FLOATS;
use crate::patch::NET_LEN;
use crate::raster::{GUARD_BAND, SCREEN_MARGIN};
use crate::records::BLOCK_POINTS;
use crate::scheme::INFINITE_SHARPNESS;
use crate::shade::{LEVEL_COLORS, ShadeMode};
use crate::tessellate::flatness::numbers;
use crate::topology::NONE;
use std::fmt::Write;

/// Workgroups along x of a dispatch; more go into further rows.
pub(in crate::gpu) const ACROSS: u32 = 32768;
/// Invocations of a workgroup.
pub(in crate::gpu) const GROUP: u32 = 64;
/// Parts of one buffer begin at multiples of this many words.
pub(in crate::gpu) const ALIGN: u32 = 64;
/// Micro-quads along a side of the largest block, as a power of two.
pub(in crate::gpu) const BLOCK_BITS: u32 = (BLOCK_POINTS as u32 - 1).ilog2();

/// Kind of a chunk of quadratic patches through points of level 1.
pub const QAS: u32 = 1;
/// Kind of a chunk of curved PN triangles.
pub const PN: u32 = 2;

/// In place of a point of a table, of a normal that is made of the ring around a corner (`rings`).
pub const RINGED: u32 = u32::MAX - 1;
/// How: across the two ends of the ring, on the side that its area says, as the mean of its faces' normals, or as its area.
pub const RING_ENDS: u32 = 0;
/// See above.
pub const RING_MEAN: u32 = 1;
/// See above.
pub const RING_AREA: u32 = 2;

/// [`Rise::shape`](crate::gpu::records::Rise::shape) of what is not displaced.
pub const STILL: u32 = 0;
/// Of a map.
pub const MAP: u32 = 1;
/// Of octaves of noise.
pub const NOISE: u32 = 2;
/// Of octaves of ridges.
pub const RIDGED: u32 = 3;
/// Of waves.
pub const RIPPLES: u32 = 4;

/// Mark of a [`Patch`](crate::gpu::records::Patch) whose sides follow from what its inside says.
pub const PATCH_PLAIN: u32 = 16;
/// Of one that is not left out of all pictures.
pub const PATCH_DRAWN: u32 = 32;
/// Of a quad of a face that is split into quads.
pub const PATCH_SPLIT: u32 = 64;
/// Mark of an [`Edge`](crate::gpu::records::Edge) that runs against the side of its second face.
pub const EDGE_BACK: u32 = 16;
/// Depths of the squares below a face that the device makes blocks of.
pub(in crate::gpu) const TREE_DEPTH: u32 = numbers::RESAMPLED;
/// Words of a face's quadtree: the number of its nodes, and as many as there can be.
pub(in crate::gpu) const NODE_WORDS: u32 = 1 + squares(TREE_DEPTH);
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
pub(in crate::gpu) const TOTAL_DRAWN: u32 = 0;
pub(in crate::gpu) const TOTAL_BLOCKS: u32 = 1;
const TOTAL_POINTS: u32 = 2;
pub(in crate::gpu) const TOTAL_MOVES: u32 = 3;
pub(in crate::gpu) const TOTAL_QUADS: u32 = 4;
/// Faces and edges that ask for more than there is, the deepest level, and the most that the last step adds where more is asked for, in
/// thousandths of what is allowed.
pub(in crate::gpu) const TOTAL_DEEPER: u32 = 5;
pub(in crate::gpu) const TOTAL_DEEPEST: u32 = 6;
pub(in crate::gpu) const TOTAL_MISSING: u32 = 7;
/// Their number.
#[cfg(feature = "gpu")]
pub(in crate::gpu) const TOTALS: u32 = 8;

/// Faces whose sums are taken by one workgroup.
pub(in crate::gpu) const PART: u32 = 16 * GROUP;

/// Bits of a row or column of a face.
const PLACE_BITS: u32 = 12;

/// A place on the grid of `level` of a face of PN triangles.
#[must_use]
pub fn pn_place([x, y]: [u32; 2], level: u32) -> u32 {
    (((level << PLACE_BITS) | y) << PLACE_BITS) | x
}

/// Numbers that both sides know, from where the processor has them.
pub(super) fn source() -> String {
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
