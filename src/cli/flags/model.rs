//! How a file becomes a surface.

use clap::{Args, ValueEnum};
use earmark::Cage;
use earmark::mesh::obj::UpAxis as FileUp;
use earmark::scheme;
use earmark::surface::SurfaceOptions;
use earmark::topology::{ConnectOptions, Topology, TopologyWarning, connect};

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
