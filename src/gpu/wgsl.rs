//! Sources of the device's stages. Each is `records.wgsl`, which holds the shared structures, followed by what it shares with others and
//! by its own file.

/// A stage's source, by its name.
#[derive(Clone, Debug)]
pub struct Source {
    /// Name of the stage.
    pub name: &'static str,
    /// WGSL.
    pub text: String,
}

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

fn source(name: &'static str, parts: &[&str]) -> Source {
    Source {
        name,
        text: std::iter::once(RECORDS)
            .chain(parts.iter().copied())
            .collect::<Vec<_>>()
            .join("\n"),
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
