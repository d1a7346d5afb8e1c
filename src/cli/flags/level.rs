//! What of the surface is drawn, and how finely.

use clap::{Args, ValueEnum};
use earmark::frame::{Drawing, Refinement};
use earmark::patch::PatchKind;
use earmark::tessellate::{self, DepthTags, Flatness};
use std::path::{Path, PathBuf};

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
