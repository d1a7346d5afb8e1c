//! The flags that verbs share, and how their values are read. Every value is checked here, before any work is done.

use clap::{Args, ValueEnum};
use earmark::frame::{Drawing, Refinement, Renderer};
use earmark::mesh::obj::UpAxis as FileUp;
use earmark::overlay::{self, Layers};
use earmark::patch::PatchKind;
use earmark::raster::MAX_SCREEN;
use earmark::scheme;
use earmark::shade::ShadeMode;
use earmark::surface::SurfaceOptions;
use earmark::tessellate::{self, DepthTags, Flatness};
use earmark::topology::{ConnectOptions, Topology, TopologyWarning, connect};
use earmark::{Cage, Camera};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// `auto`, `always` or `never`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum When {
    Auto,
    Always,
    Never,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    Obj,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Scheme {
    /// Loop where every face of the file is a triangle (refine, info), else Catmull-Clark
    Auto,
    /// Any polygons
    CatmullClark,
    /// Triangles
    Loop,
    /// Triangles; goes through the vertices
    Butterfly,
    /// Any polygons, made for quads; goes through the vertices
    Kobbelt,
    /// Any polygons; flat between their corners
    Bilinear,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Boundary {
    /// Faces at the boundary are not drawn
    None,
    /// Smooth boundary curve
    EdgeOnly,
    /// The same, with sharp corners at vertices of one face
    EdgeAndCorner,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum FaceVarying {
    /// Smooth everywhere
    None,
    /// Sharp at corners of charts
    CornersOnly,
    /// Also where three or more charts meet
    #[value(name = "corners-plus1")]
    CornersPlus1,
    /// Also at darts and concave corners
    #[value(name = "corners-plus2")]
    CornersPlus2,
    /// Sharp along boundaries of charts
    Boundaries,
    /// Linear everywhere
    All,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Creases {
    /// Sharpness falls by one per level
    Uniform,
    /// It is averaged along the crease as it falls
    Chaikin,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Triangles {
    /// The ordinary weights
    Catmark,
    /// Smoother edges beside triangles
    Smooth,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum UpAxis {
    Y,
    Z,
}

/// How a file becomes a surface.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Model")]
pub(crate) struct ModelFlags {
    /// Format of a model; needed when it comes from standard input
    #[arg(long, value_enum)]
    pub(crate) format: Option<Format>,
    /// Subdivision scheme
    #[arg(long, value_enum, default_value = "auto")]
    pub(crate) scheme: Scheme,
    /// For --scheme loop and butterfly, make triangles of the model's faces first: quads along their shorter diagonal, others as fans; tags
    /// and texture coordinates are kept. `refine` then writes triangles under any scheme
    #[arg(long)]
    pub(crate) triangulate: bool,
    /// Boundary rule [default: the file's, else edge-and-corner]
    #[arg(long, value_enum)]
    pub(crate) boundary: Option<Boundary>,
    /// Decay of semi-sharp creases [default: the file's, else uniform]
    #[arg(long, value_enum)]
    pub(crate) creases: Option<Creases>,
    /// Weights of Catmull-Clark beside triangles [default: the file's, else catmark]
    #[arg(long, value_enum)]
    pub(crate) triangles: Option<Triangles>,
    /// Rule for texture coordinates [default: the file's, else corners-plus1]
    #[arg(long, value_enum)]
    pub(crate) fvar: Option<FaceVarying>,
    /// Axis of the file that points up; z is turned to y, also for --eye, --target and --up
    #[arg(long, value_enum, default_value = "y")]
    pub(crate) up_axis: UpAxis,
}

/// The name of a scheme on the command line.
pub(crate) fn scheme_name(s: scheme::Scheme) -> &'static str {
    match s {
        scheme::Scheme::CatmullClark => "catmull-clark",
        scheme::Scheme::Loop => "loop",
        scheme::Scheme::Butterfly => "butterfly",
        scheme::Scheme::Kobbelt => "kobbelt",
        scheme::Scheme::Bilinear => "bilinear",
        _ => "another scheme",
    }
}

impl ModelFlags {
    /// The scheme of the flag, unless that is `auto`.
    pub(crate) fn named_scheme(&self) -> Option<scheme::Scheme> {
        match self.scheme {
            Scheme::Auto => None,
            Scheme::CatmullClark => Some(scheme::Scheme::CatmullClark),
            Scheme::Loop => Some(scheme::Scheme::Loop),
            Scheme::Butterfly => Some(scheme::Scheme::Butterfly),
            Scheme::Kobbelt => Some(scheme::Scheme::Kobbelt),
            Scheme::Bilinear => Some(scheme::Scheme::Bilinear),
        }
    }
    /// The scheme of the flag, else the one that suits the cage.
    pub(crate) fn scheme_of(&self, cage: &Cage) -> scheme::Scheme {
        let suitable = || match cage.face_count() > 0 && cage.first_polygon().is_none() {
            true => scheme::Scheme::Loop,
            false => scheme::Scheme::CatmullClark,
        };
        self.named_scheme().unwrap_or_else(suitable)
    }
    pub(crate) fn surface(&self) -> SurfaceOptions {
        SurfaceOptions {
            creases: self.creases.map(|c| match c {
                Creases::Uniform => scheme::CreaseMethod::Uniform,
                Creases::Chaikin => scheme::CreaseMethod::Chaikin,
            }),
            triangles: self.triangles.map(|t| match t {
                Triangles::Catmark => scheme::TriangleRule::Catmark,
                Triangles::Smooth => scheme::TriangleRule::Smooth,
            }),
            scheme: self.named_scheme(),
            boundary: self.boundary.map(|b| match b {
                Boundary::None => scheme::Boundary::None,
                Boundary::EdgeOnly => scheme::Boundary::EdgeOnly,
                Boundary::EdgeAndCorner => scheme::Boundary::EdgeAndCorner,
            }),
            face_varying: self.fvar.map(|f| match f {
                FaceVarying::None => scheme::FaceVaryingRule::None,
                FaceVarying::CornersOnly => scheme::FaceVaryingRule::CornersOnly,
                FaceVarying::CornersPlus1 => scheme::FaceVaryingRule::CornersPlus1,
                FaceVarying::CornersPlus2 => scheme::FaceVaryingRule::CornersPlus2,
                FaceVarying::Boundaries => scheme::FaceVaryingRule::Boundaries,
                FaceVarying::All => scheme::FaceVaryingRule::All,
            }),
            ..SurfaceOptions::default()
        }
    }
    /// The flag, else the file, else the default.
    pub(crate) fn boundary(&self, cage: &Cage) -> scheme::Boundary {
        let flag = self.surface().boundary;
        flag.or(cage.tags().boundary).unwrap_or_default()
    }
    pub(crate) fn face_varying(&self, cage: &Cage) -> scheme::FaceVaryingRule {
        let flag = self.surface().face_varying;
        flag.or(cage.tags().face_varying).unwrap_or_default()
    }
    /// Connects a cage with all of its tags.
    pub(crate) fn connect(&self, cage: &Cage) -> (Topology, Vec<TopologyWarning>) {
        let tags = cage.tags();
        let options = ConnectOptions {
            boundary: self.boundary(cage),
            creases: &tags.creases,
            corners: &tags.corners,
            holes: &tags.holes,
        };
        let corners = cage.corner_vertices().to_vec();
        connect(cage.points().len(), cage.face_offsets(), corners, &options)
    }
    pub(crate) fn file_up(&self) -> FileUp {
        match self.up_axis {
            UpAxis::Y => FileUp::Y,
            UpAxis::Z => FileUp::Z,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SurfaceKind {
    /// Points of the limit surface
    Limit,
    /// Control points after as many steps as the level says
    Refined,
    /// The polygons as given
    Cage,
    /// Quadratic patches through points of the limit surface
    Qas,
    /// Curved PN triangles over the polygons
    Pn,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Pattern {
    /// Uniform inside; triangles at deeper edges are split
    Split,
    /// Coarser and finer over a distance, triangles near to equilateral
    Equilateral,
}

/// What of the surface is drawn, and how finely.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Model")]
pub(crate) struct LevelFlags {
    /// What is drawn
    #[arg(long, value_enum, default_value = "limit")]
    pub(crate) surface: SurfaceKind,
    /// Tension of --surface pn: a text file with one number per vertex of the model, from 0 (flat around it) to 1, one a line or several,
    /// # begins a comment [default: 1; at corners tagged with sharpness S, 1 − S/10]
    #[arg(long, value_name = "FILE")]
    pub(crate) pn_tags: Option<PathBuf>,
    /// Uniform level of refinement, 0 to 10 [default: as fine as --adaptive says; under interpolating schemes, and where it is not the limit
    /// that is drawn, per model, from the length of its edges in pixels]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=10), allow_hyphen_values = true)]
    pub(crate) level: Option<u32>,
    /// Largest distance of triangles from the surface on the screen, in pixels; edge by edge and block by block [default: 0.5;
    /// none under --scheme butterfly and kobbelt, where looking for what is flat takes longer than drawing it]
    #[arg(long, value_name = "PX", value_parser = parse_flatness, conflicts_with = "level")]
    pub(crate) adaptive: Option<f32>,
    /// Highest level that is chosen without --level, 0 to 10
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(0..=10), allow_hyphen_values = true)]
    pub(crate) max_level: u32,
    /// Depth of refinement at every vertex of the cage, 0 to 10, that of an edge being the mean of its two: `distance` (edges of 5 pixels),
    /// `curvature` (normals turn by 4 degrees along an edge), `distance+curvature` (the lesser of the two), or a file of integers, one per
    /// vertex in the model's order, with white space between them and comments from # on; --max-level does not matter
    #[arg(long, value_name = "SOURCE", conflicts_with_all = ["level", "adaptive"])]
    pub(crate) depth_tags: Option<PathBuf>,
    /// With --depth-tags: how triangles join edges of unequal depths [default: grids whose points beside a coarser edge are moved to its own]
    #[arg(long, value_enum, requires = "depth_tags")]
    pub(crate) pattern: Option<Pattern>,
}

impl LevelFlags {
    pub(crate) fn drawing(&self) -> Drawing {
        match self.surface {
            SurfaceKind::Limit | SurfaceKind::Qas | SurfaceKind::Pn => Drawing::Limit,
            SurfaceKind::Refined => Drawing::Refined,
            SurfaceKind::Cage => Drawing::Cage,
        }
    }
    /// What is diced in place of the limit surface.
    pub(crate) fn patches(&self) -> PatchKind {
        match self.surface {
            SurfaceKind::Qas => PatchKind::Qas,
            SurfaceKind::Pn => PatchKind::Pn,
            _ => PatchKind::None,
        }
    }
    pub(crate) fn refinement(&self) -> Refinement {
        let max_level = self.max_level;
        if let Some(tags) = self.tag_source() {
            let pattern = self.pattern.map(|p| match p {
                Pattern::Split => tessellate::Pattern::Split,
                Pattern::Equilateral => tessellate::Pattern::Equilateral,
            });
            return Refinement::DepthTags(DepthTags {
                pattern,
                ..tags.unwrap_or(DepthTags::GIVEN)
            });
        }
        match (self.level, self.adaptive) {
            (Some(level), _) => Refinement::Uniform(level),
            (None, None) => Refinement::Default { max_level },
            (None, Some(pixels)) => Refinement::Adaptive(Flatness {
                pixels,
                max_level,
                ..Flatness::default()
            }),
        }
    }
}

impl LevelFlags {
    /// What `--depth-tags` says: tags that are computed, or `None` for a file.
    fn tag_source(&self) -> Option<Option<DepthTags>> {
        let named = match self.depth_tags.as_ref()?.to_str() {
            Some("distance") => Some(DepthTags::by_distance()),
            Some("curvature") => Some(DepthTags::by_curvature()),
            Some("distance+curvature") => Some(DepthTags::by_distance_and_curvature()),
            _ => None,
        };
        Some(named)
    }
    /// The file of `--depth-tags`.
    pub(crate) fn tag_file(&self) -> Option<&Path> {
        match self.tag_source()? {
            Some(_) => None,
            None => self.depth_tags.as_deref(),
        }
    }
}

fn parse_flatness(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(pixels) if (0.01..=1e4).contains(&pixels) => Ok(pixels),
        _ => Err("expected pixels, 0.01 to 10000".into()),
    }
}

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

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Simd {
    Auto,
    Scalar,
    Sse2,
    Avx2,
    Avx512,
    Neon,
}

impl Simd {
    pub(crate) fn name(self) -> String {
        self.to_possible_value()
            .map(|v| v.get_name().to_owned())
            .unwrap_or_default()
    }
}

/// Threads, limits, and what is said.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Running")]
pub(crate) struct RunningFlags {
    /// Threads [default: RAYON_NUM_THREADS, else one per processor that the process may use]
    #[arg(short = 'j', long, value_name = "N", env = "EARMARK_THREADS", hide_env_values = true,
          value_parser = clap::value_parser!(u32).range(1..), allow_hyphen_values = true)]
    pub(crate) threads: Option<u32>,
    /// Vector instructions; never changes a pixel
    #[arg(
        long,
        value_enum,
        default_value = "auto",
        env = "EARMARK_SIMD",
        hide_env_values = true
    )]
    pub(crate) simd: Simd,
    /// Give up after so many seconds [default: never]
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_hyphen_values = true)]
    pub(crate) timeout: Option<Duration>,
    /// Most memory to take: bytes, or with K, M, G or T [default: 75 % of what the process may have]
    #[arg(long, value_name = "SIZE", value_parser = bytes, allow_hyphen_values = true)]
    pub(crate) max_memory: Option<u64>,
    /// Most micro-faces [default: no limit; refine: 100 million]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub(crate) max_faces: Option<u64>,
    /// Write what was done and how long it took as JSON; - is standard output
    #[arg(long, value_name = "FILE")]
    pub(crate) stats: Option<PathBuf>,
    /// Say nothing but errors
    #[arg(short, long, conflicts_with = "verbose")]
    pub(crate) quiet: bool,
    /// Say what is being done
    #[arg(short, long, action = clap::ArgAction::Count)]
    pub(crate) verbose: u8,
    /// Progress on standard error; auto: on a terminal, after a second
    #[arg(long, value_enum, value_name = "WHEN", default_value = "auto")]
    pub(crate) progress: When,
    /// Colours in messages; auto: on a terminal, unless NO_COLOR is set
    #[arg(long, value_enum, value_name = "WHEN", default_value = "auto")]
    pub(crate) color: When,
}

impl Default for RunningFlags {
    /// What verbs that only print a text run with.
    fn default() -> Self {
        Self {
            threads: Some(1),
            simd: Simd::Auto,
            timeout: None,
            max_memory: None,
            max_faces: None,
            stats: None,
            quiet: false,
            verbose: 0,
            progress: When::Never,
            color: When::Auto,
        }
    }
}

/// A finite number.
fn number(s: &str) -> Result<f64, String> {
    match s.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err("not a finite number".into()),
    }
}

fn positive(s: &str) -> Result<f64, String> {
    match number(s)? {
        x if x > 0.0 => Ok(x),
        _ => Err("must be above 0".into()),
    }
}

fn fov(s: &str) -> Result<f64, String> {
    match number(s)? {
        x if x > 0.0 && x < 180.0 => Ok(x),
        _ => Err("must be above 0 and below 180".into()),
    }
}

fn vector(s: &str) -> Result<[f64; 3], String> {
    let parts: Vec<f64> = s
        .split(',')
        .map(|p| number(p.trim()))
        .collect::<Result<_, _>>()
        .map_err(|_| "not three finite numbers with commas between them")?;
    parts
        .try_into()
        .map_err(|_| "not three finite numbers with commas between them".into())
}

fn size(s: &str) -> Result<[u32; 2], String> {
    let wrong = "not two numbers from 1 to 16383 with an x between them";
    let (w, h) = s.split_once(['x', 'X']).ok_or(wrong)?;
    let side = |s: &str| {
        let digits = !s.is_empty() && s.bytes().all(|b| b.is_ascii_digit());
        match s.parse::<u32>() {
            Ok(n) if digits && (1..=MAX_SCREEN).contains(&n) => Ok(n),
            _ => Err(wrong),
        }
    };
    Ok([side(w)?, side(h)?])
}

fn samples(s: &str) -> Result<u32, String> {
    match s.parse() {
        Ok(n @ (1 | 4 | 8 | 16)) => Ok(n),
        _ => Err("must be 1, 4, 8 or 16".into()),
    }
}

fn color(s: &str) -> Result<[u8; 4], String> {
    let wrong = || "not 6 or 8 hexadecimal digits".to_owned();
    let digits = s.strip_prefix('#').unwrap_or(s);
    if !matches!(digits.len(), 6 | 8) || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return Err(wrong());
    }
    let n = u32::from_str_radix(digits, 16).map_err(|_| wrong())?;
    Ok(match digits.len() {
        6 => (n << 8 | 0xff).to_be_bytes(),
        _ => n.to_be_bytes(),
    })
}

fn seconds(s: &str) -> Result<Duration, String> {
    Duration::try_from_secs_f64(positive(s)?).map_err(|_| "too many seconds".into())
}

/// Bytes, with K, M, G or T for powers of 1024.
fn bytes(s: &str) -> Result<u64, String> {
    let wrong = "not a size such as 800000000, 512M or 1.5G";
    let text = s.trim_end_matches(['B', 'b']).trim_end_matches('i');
    let (digits, shift) = match text.char_indices().next_back() {
        Some((at, c)) if c.is_ascii_alphabetic() => {
            let shift = match c.to_ascii_uppercase() {
                'K' => 10,
                'M' => 20,
                'G' => 30,
                'T' => 40,
                _ => return Err(wrong.into()),
            };
            (&text[..at], shift)
        }
        _ => (text, 0),
    };
    let n = positive(digits).map_err(|_| wrong)?;
    let total = n * (1_u64 << shift) as f64;
    // Everything that large is more than any machine has.
    if total >= 1.0 {
        Ok(total as u64)
    } else {
        Err(wrong.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read_or_refused() {
        assert_eq!(size("640x480"), Ok([640, 480]));
        for s in [
            "", "640", "0x1", "1x0", "16384x1", "-1x5", "+1x5", "1x1x1", "1.5x2", "x",
        ] {
            assert!(size(s).is_err(), "{s}");
        }
        assert_eq!(color("ff8000"), Ok([255, 128, 0, 255]));
        assert_eq!(color("#01020304"), Ok([1, 2, 3, 4]));
        for s in ["", "fff", "gg0000", "+12345", "1234567"] {
            assert!(color(s).is_err(), "{s}");
        }
        assert_eq!(vector("-1, 2.5,3e2"), Ok([-1.0, 2.5, 300.0]));
        for s in ["", "1,2", "1,2,3,4", "1,nan,2", "1,inf,2", "a,b,c"] {
            assert!(vector(s).is_err(), "{s}");
        }
        assert_eq!(bytes("1024"), Ok(1024));
        assert_eq!(bytes("1.5K"), Ok(1536));
        assert_eq!(bytes("2GiB"), Ok(2 << 30));
        assert_eq!(bytes("3mb"), Ok(3 << 20));
        for s in ["", "M", "-1", "0", "1X", "nan", "1e999", "0.5"] {
            assert!(bytes(s).is_err(), "{s}");
        }
        assert_eq!(seconds("0.25"), Ok(Duration::from_millis(250)));
        for s in ["0", "-1", "1e300", "inf"] {
            assert!(seconds(s).is_err(), "{s}");
        }
        assert!(fov("180").is_err() && fov("0").is_err() && fov("179.9").is_ok());
        assert!(samples("2").is_err() && samples("16").is_ok());
    }
}
