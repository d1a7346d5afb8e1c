//! Sources of the device's stages. Each is the numbers that both sides know, `records.wgsl`, which holds the shared structures, what it shares
//! with others and its own file.

use super::records::POINT_FLOATS;
use crate::raster::GUARD_BAND;
use crate::records::BLOCK_POINTS;
use crate::scheme::INFINITE_SHARPNESS;
use crate::shade::{LEVEL_COLORS, ShadeMode};
use crate::topology::NONE;
use std::fmt::Write;

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

const INDEX: &str = include_str!("wgsl/index.wgsl");
const RECORDS: &str = include_str!("wgsl/records.wgsl");
const SCREEN: &str = include_str!("wgsl/screen.wgsl");
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

fn source(name: &'static str, parts: &[&str]) -> Source {
    Source {
        name,
        text: [&[&*numbers(), INDEX, RECORDS], parts].concat().join("\n"),
    }
}

/// Corners, sides and insides of blocks.
#[must_use]
pub fn dice() -> Source {
    source("dice", &[include_str!("wgsl/dice.wgsl")])
}

/// Micro-quads into keys.
#[must_use]
pub fn tile(by: Keys) -> Source {
    let parts = [SCREEN, keys(by), include_str!("wgsl/tile.wgsl")];
    source("tile", &parts)
}

/// Large and clipped quads into keys.
#[must_use]
pub fn large(by: Keys) -> Source {
    let parts = [
        SCREEN,
        WIDE,
        include_str!("wgsl/clip.wgsl"),
        keys(by),
        include_str!("wgsl/large.wgsl"),
    ];
    source("large", &parts)
}

/// Keys into colours.
#[must_use]
pub fn shade() -> Source {
    let parts = [
        SCREEN,
        WIDE,
        include_str!("wgsl/light.wgsl"),
        include_str!("wgsl/shade.wgsl"),
    ];
    source("shade", &parts)
}

/// Colours into bytes.
#[must_use]
pub fn film() -> Source {
    source("film", &[include_str!("wgsl/film.wgsl")])
}

const LEVELS: &str = include_str!("wgsl/levels_shared.wgsl");
const LEVEL_POINTS: &str = include_str!("wgsl/levels_points.wgsl");

/// Face points of a level.
#[must_use]
pub fn face() -> Source {
    let parts = [LEVELS, LEVEL_POINTS, include_str!("wgsl/face.wgsl")];
    source("face", &parts)
}

/// Edge points of a level.
#[must_use]
pub fn edge() -> Source {
    let parts = [LEVELS, LEVEL_POINTS, include_str!("wgsl/edge.wgsl")];
    source("edge", &parts)
}

/// Vertex points of a level.
#[must_use]
pub fn vertex() -> Source {
    let parts = [LEVELS, LEVEL_POINTS, include_str!("wgsl/vertex.wgsl")];
    source("vertex", &parts)
}

/// Half-edges, edges and vertices of the next level.
#[must_use]
pub fn connectivity() -> Source {
    let parts = [LEVELS, include_str!("wgsl/connectivity.wgsl")];
    source("connectivity", &parts)
}

/// All of them.
#[must_use]
pub fn all() -> Vec<Source> {
    let mut out = vec![
        dice(),
        shade(),
        film(),
        face(),
        edge(),
        vertex(),
        connectivity(),
    ];
    for by in [Keys::Wide, Keys::TwoPass] {
        out.extend([tile(by), large(by)]);
    }
    out
}
