//! The picture: size, camera, what pixels show, lines, and what draws it.

use super::level::LevelFlags;
use super::values::{color, fov, number, positive, samples, size, vector};
use clap::{Args, ValueEnum};
use earmark::Camera;
use earmark::frame::Renderer;
use earmark::overlay::{self, Layers};
use earmark::shade::ShadeMode;
use std::path::PathBuf;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Shade {
    /// Studio light, normals of the limit surface
    Lit,
    /// Studio light, normals of the micro-triangles
    Flat,
    /// Unit normals, n/2 + 1/2, no light
    Normals,
    /// Texture coordinates in red and green
    Uv,
    /// White near, black far
    Depth,
    /// Levels of refinement by colour
    Level,
    /// Lines alone, hidden ones removed: tessellation, silhouettes, creases, boundaries; to .png or .svg
    Wireframe,
}

/// A layer of `--overlay`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Overlay {
    /// Edges of the tessellation
    Wireframe,
    /// Edges of the control cage, hidden by the surface
    Cage,
    /// Limit curves of the cage's edges, where patches meet
    Patches,
    /// Axes of the model, from its origin
    Axes,
    /// Edges with a sharpness
    Creases,
    /// Edges of one face
    Boundaries,
    /// Where the surface turns away from the eye
    Silhouettes,
    /// Extraordinary vertices with their valence
    Valences,
    /// Numbers of the cage's vertices, from 0 as in tags
    Labels,
    /// Scale bar, at the distance of the model's middle
    Scale,
}

impl Overlay {
    fn layer(self) -> Layers {
        match self {
            Self::Wireframe => Layers::WIREFRAME,
            Self::Cage => Layers::CAGE,
            Self::Patches => Layers::PATCHES,
            Self::Axes => Layers::AXES,
            Self::Creases => Layers::CREASES,
            Self::Boundaries => Layers::BOUNDARIES,
            Self::Silhouettes => Layers::SILHOUETTES,
            Self::Valences => Layers::VALENCES,
            Self::Labels => Layers::LABELS,
            Self::Scale => Layers::SCALE,
        }
    }
}

/// Camera and picture.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Picture")]
pub(crate) struct PictureFlags {
    /// Size in pixels, each side 1 to 16383
    #[arg(short, long, value_name = "WxH", default_value = "1024x1024", value_parser = size, allow_hyphen_values = true)]
    pub(crate) size: [u32; 2],
    /// Angle around the model in degrees; 0 looks from the front, 90 from the right
    #[arg(long, value_name = "DEG", default_value = "45", value_parser = number, allow_hyphen_values = true)]
    pub(crate) azimuth: f64,
    /// Angle above the horizon in degrees
    #[arg(long, value_name = "DEG", default_value = "25", value_parser = number, allow_hyphen_values = true)]
    pub(crate) elevation: f64,
    /// Magnification, above 0
    #[arg(long, value_name = "F", default_value = "1", value_parser = positive, allow_hyphen_values = true)]
    pub(crate) zoom: f64,
    /// Vertical field of view in degrees, above 0 and below 180
    #[arg(long, value_name = "DEG", default_value = "35", value_parser = fov, allow_hyphen_values = true)]
    pub(crate) fov: f64,
    /// Parallel projection [default: perspective]
    #[arg(long)]
    pub(crate) ortho: bool,
    /// Position of the eye in model units; --azimuth and --elevation then mean nothing [default: framed on the model]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) eye: Option<[f64; 3]>,
    /// Point looked at, in model units [default: the middle of the model]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) target: Option<[f64; 3]>,
    /// Direction that points up in the picture
    #[arg(long, value_name = "X,Y,Z", default_value = "0,1,0", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) up: [f64; 3],
    /// Distance of the near plane in model units, above 0 [default: the whole model]
    #[arg(long, value_name = "D", value_parser = positive, allow_hyphen_values = true)]
    pub(crate) near: Option<f64>,
    /// Distance in model units where the depth range ends [default: the whole model]
    #[arg(long, value_name = "D", value_parser = positive, allow_hyphen_values = true)]
    pub(crate) far: Option<f64>,
    /// Samples per pixel: 1, 4, 8 or 16
    #[arg(long, value_name = "N", default_value = "4", value_parser = samples, allow_hyphen_values = true)]
    pub(crate) samples: u32,
    /// Background, sRGB and opacity in hexadecimal [default: transparent]
    #[arg(long, value_name = "RRGGBB[AA]", value_parser = color, allow_hyphen_values = true)]
    pub(crate) background: Option<[u8; 4]>,
    /// What pixels show
    #[arg(long, value_enum, default_value = "lit")]
    pub(crate) shade: Shade,
    /// Lines over the picture, hidden ones removed; several with commas between them [default: none]
    #[arg(long, value_name = "LAYERS", value_enum, value_delimiter = ',')]
    pub(crate) overlay: Vec<Overlay>,
    /// Turn of the studio lights around the direction that points up in the picture, in degrees; above 0 the key light, from the upper left,
    /// goes to the right
    #[arg(long, value_name = "DEG", default_value = "0", value_parser = number, allow_hyphen_values = true)]
    pub(crate) light_turn: f64,
    /// Picture (PNG or JPEG) that colours the surface in place of the materials' maps
    #[arg(long, value_name = "IMAGE")]
    pub(crate) color_map: Option<PathBuf>,
    /// Normal map (PNG or JPEG, 8 or 16 bits) in place of the materials' normal and bump maps: tangent space as MikkTSpace has it, x along u,
    /// y along v, so green points up
    #[arg(long, value_name = "IMAGE")]
    pub(crate) normal_map: Option<PathBuf>,
    /// What draws
    #[arg(long, value_enum, default_value = "cpu")]
    pub(crate) backend: Backend,
    /// Let --backend gpu take adapters that compute on the processor, such as Mesa's lavapipe
    #[arg(long)]
    pub(crate) allow_software_gpu: bool,
}

/// What draws pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Backend {
    /// Processor cores
    Cpu,
    /// A GPU through Vulkan, Metal or Direct3D 12; earmark must be built with feature gpu
    Gpu,
}

impl PictureFlags {
    pub(crate) fn camera(&self) -> Camera {
        Camera {
            azimuth: self.azimuth,
            elevation: self.elevation,
            zoom: self.zoom,
            fov: self.fov,
            ortho: self.ortho,
            eye: self.eye,
            target: self.target,
            up: self.up,
            near: self.near,
            far: self.far,
        }
    }
    pub(crate) fn mode(&self) -> ShadeMode {
        match self.shade {
            Shade::Lit => ShadeMode::Lit,
            Shade::Flat => ShadeMode::Flat,
            Shade::Normals => ShadeMode::Normals,
            Shade::Uv => ShadeMode::Uv,
            Shade::Depth => ShadeMode::Depth,
            Shade::Level => ShadeMode::Level,
            // No pixel of the surface itself is seen.
            Shade::Wireframe => ShadeMode::Flat,
        }
    }
    /// Line work over the picture, or in its place.
    pub(crate) fn line_work(&self) -> Option<overlay::Options> {
        let layers = self.overlay.iter().map(|o| o.layer());
        let layers = layers.fold(Layers::NONE, |all, layer| all | layer);
        match self.shade {
            Shade::Wireframe => Some(overlay::Options::illustration(layers)),
            _ => (!layers.is_empty()).then(|| overlay::Options::overlay(layers)),
        }
    }
    /// A renderer without limits.
    pub(crate) fn renderer(&self, level: &LevelFlags) -> Renderer {
        let mut renderer = Renderer::new(self.size[0], self.size[1]);
        renderer.size.samples = self.samples;
        renderer.refinement = level.refinement();
        renderer.drawing = level.drawing();
        renderer.mode = self.mode();
        renderer.background = self.background.unwrap_or_default();
        renderer.light_turn = self.light_turn;
        renderer
    }
}
