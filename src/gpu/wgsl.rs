//! Sources of the device's stages. Each is the numbers that both sides know, `records.wgsl`, which holds the shared structures, what it shares
//! with others and its own file.

mod mesh;
mod numbers;

pub use mesh::{Faces, MeshStep, connectivity, edge, face, limit, vertex};
pub use numbers::*;

/// A stage's source, by its name.
#[derive(Clone, Debug)]
pub struct Source {
    /// Name of the stage.
    pub name: &'static str,
    /// WGSL.
    pub text: String,
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
        text: [&[&*numbers::source(), INDEX, RECORDS], parts]
            .concat()
            .join("\n"),
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
    for step in MeshStep::ends() {
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
