//! What can be drawn, and how it looks.

use crate::records::ScreenSize;
use std::ops::{BitOr, BitOrAssign, BitXorAssign};

/// Layers of line work; any of them together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Layers(u16);

/// Layers by name.
const NAMES: [(&str, Layers); 10] = [
    ("wireframe", Layers::WIREFRAME),
    ("cage", Layers::CAGE),
    ("patches", Layers::PATCHES),
    ("axes", Layers::AXES),
    ("creases", Layers::CREASES),
    ("boundaries", Layers::BOUNDARIES),
    ("silhouettes", Layers::SILHOUETTES),
    ("valences", Layers::VALENCES),
    ("labels", Layers::LABELS),
    ("scale", Layers::SCALE),
];

impl Layers {
    /// Nothing.
    pub const NONE: Self = Self(0);
    /// The tessellation as it is drawn: sides of micro-quads, or of triangles where those are the faces.
    pub const WIREFRAME: Self = Self(1);
    /// Straight edges of the control cage, hidden by the surface.
    pub const CAGE: Self = Self(2);
    /// Limit curves of the cage's edges: where the patches of its faces meet.
    pub const PATCHES: Self = Self(4);
    /// The axes of the model, from its origin to the sphere around it.
    pub const AXES: Self = Self(8);
    /// Edges with a sharpness.
    pub const CREASES: Self = Self(16);
    /// Edges of one face.
    pub const BOUNDARIES: Self = Self(32);
    /// Where the surface turns away from the eye.
    pub const SILHOUETTES: Self = Self(64);
    /// Extraordinary vertices, marked with their valence.
    pub const VALENCES: Self = Self(128);
    /// Numbers of the cage's vertices, counted from 0 as in tags.
    pub const LABELS: Self = Self(256);
    /// A bar with its length in model units, at the distance of the model's middle.
    pub const SCALE: Self = Self(512);

    /// The layer of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        NAMES.iter().find(|(n, _)| *n == name).map(|(_, l)| *l)
    }
    /// Names of all layers.
    pub fn names() -> impl Iterator<Item = &'static str> {
        NAMES.iter().map(|(n, _)| *n)
    }
    /// Names of its layers, with commas between them.
    #[must_use]
    pub fn to_names(self) -> String {
        let all = NAMES.iter().filter(|(_, l)| self.contains(*l));
        all.map(|(n, _)| *n).collect::<Vec<_>>().join(",")
    }
    /// Whether all layers of `other` are among its own.
    #[must_use]
    pub fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
    /// Whether it has none.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl BitOr for Layers {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl BitOrAssign for Layers {
    fn bitor_assign(&mut self, other: Self) {
        self.0 |= other.0;
    }
}

/// Switches layers on and off.
impl BitXorAssign for Layers {
    fn bitxor_assign(&mut self, other: Self) {
        self.0 ^= other.0;
    }
}

/// What a line is, in the order in which lines are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// A micro-edge.
    Wire,
    /// The limit curve of an edge of the cage.
    Patch,
    /// A crease.
    Crease,
    /// A boundary.
    Boundary,
    /// A silhouette.
    Silhouette,
    /// An edge of the control cage.
    Cage,
    /// The first axis.
    AxisX,
    /// The second axis.
    AxisY,
    /// The third axis.
    AxisZ,
    /// The scale bar.
    Scale,
}

impl Kind {
    /// All kinds, in the order in which they are drawn.
    pub const ALL: [Self; 10] = [
        Self::Wire,
        Self::Patch,
        Self::Crease,
        Self::Boundary,
        Self::Silhouette,
        Self::Cage,
        Self::AxisX,
        Self::AxisY,
        Self::AxisZ,
        Self::Scale,
    ];

    /// Its name, as in the classes of an SVG.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Wire => "wireframe",
            Self::Patch => "patches",
            Self::Crease => "creases",
            Self::Boundary => "boundaries",
            Self::Silhouette => "silhouettes",
            Self::Cage => "cage",
            Self::AxisX => "axis-x",
            Self::AxisY => "axis-y",
            Self::AxisZ => "axis-z",
            Self::Scale => "scale",
        }
    }
}

/// Ink of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ink {
    /// sRGB with straight alpha.
    pub color: [u8; 4],
    /// Width in units, see [`Style::unit`].
    pub width: f32,
}

const fn ink(rgb: u32, alpha: u8, width: f32) -> Ink {
    let [_, r, g, b] = rgb.to_be_bytes();
    Ink {
        color: [r, g, b, alpha],
        width,
    }
}

/// How lines look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// Ink of each [`Kind`], in the order of [`Kind::ALL`].
    pub inks: [Ink; 10],
    /// Colour of letters, sRGB with straight alpha, and of the rim that sets them off.
    pub text: [u8; 4],
    /// Colour of the rim around letters and marks.
    pub halo: [u8; 4],
    /// Length of a unit in pixels; `None` follows the picture: 1 pixel at 1000 pixels in the smaller side, less than in proportion
    /// beyond.
    pub unit: Option<f32>,
}

impl Style {
    /// Lines over a shaded surface.
    #[must_use]
    pub fn overlay() -> Self {
        Self {
            inks: [
                ink(0x101418, 150, 0.9),
                ink(0x0b2f6b, 235, 1.5),
                ink(0xc81e1e, 255, 2.2),
                ink(0x0a7d38, 255, 2.2),
                ink(0x101418, 255, 2.0),
                ink(0xe07800, 255, 1.5),
                ink(0xd42a2a, 255, 2.0),
                ink(0x2a9a2a, 255, 2.0),
                ink(0x2a52d4, 255, 2.0),
                ink(0x101418, 255, 2.0),
            ],
            text: [16, 20, 24, 255],
            halo: [255, 255, 255, 210],
            unit: None,
        }
    }

    /// Lines alone, on paper: dark, and heavier where the form is.
    #[must_use]
    pub fn illustration() -> Self {
        let dark = 0x15181c;
        Self {
            inks: [
                ink(0x5a6068, 255, 0.7),
                ink(dark, 255, 1.1),
                ink(dark, 255, 2.0),
                ink(dark, 255, 2.0),
                ink(dark, 255, 2.4),
                ink(0xc06000, 255, 1.2),
                ink(0xd42a2a, 255, 2.0),
                ink(0x2a9a2a, 255, 2.0),
                ink(0x2a52d4, 255, 2.0),
                ink(dark, 255, 2.0),
            ],
            text: [21, 24, 28, 255],
            halo: [255, 255, 255, 230],
            unit: None,
        }
    }

    /// The ink of a kind.
    #[must_use]
    pub fn ink(&self, kind: Kind) -> Ink {
        self.inks[kind as usize]
    }

    /// Length of a unit in pixels, in a picture of a size. Grows with the side to the power of 0.7, so that lines stay fine on large
    /// pictures and do not vanish on small ones.
    #[must_use]
    pub fn unit_of(&self, size: ScreenSize) -> f32 {
        self.unit.unwrap_or_else(|| {
            let side = f64::from(size.width.min(size.height)) / 1000.0;
            libm::pow(side, 0.7).max(0.7) as f32
        })
    }
}

/// What is drawn, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// What is drawn.
    pub layers: Layers,
    /// How it looks.
    pub style: Style,
}

impl Options {
    /// Layers over a shaded picture.
    #[must_use]
    pub fn overlay(layers: Layers) -> Self {
        Self {
            layers,
            style: Style::overlay(),
        }
    }

    /// A drawing of lines alone, as `--shade wireframe` makes it: the tessellation, creases, boundaries and silhouettes, and `more`.
    #[must_use]
    pub fn illustration(more: Layers) -> Self {
        let form = Layers::CREASES | Layers::BOUNDARIES | Layers::SILHOUETTES;
        Self {
            layers: Layers::WIREFRAME | form | more,
            style: Style::illustration(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_have_names() {
        let mut all = Layers::NONE;
        for name in Layers::names() {
            let layer = Layers::from_name(name).unwrap();
            assert!(!all.contains(layer));
            assert_eq!(layer.to_names(), name);
            all |= layer;
        }
        all ^= Layers::AXES;
        assert!(!all.contains(Layers::AXES) && all.contains(Layers::CAGE));
        assert_eq!(Layers::from_name("wires"), None);
        let two = Layers::AXES | Layers::WIREFRAME;
        assert_eq!(two.to_names(), "wireframe,axes");
    }

    #[test]
    fn kinds_stand_in_their_order() {
        for (k, kind) in Kind::ALL.iter().enumerate() {
            assert_eq!(*kind as usize, k);
        }
    }
}
