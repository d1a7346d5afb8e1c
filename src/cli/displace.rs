//! The flags of displacement, and what they make of a scene.

use super::exit::Failure;
use super::job::Job;
use super::messages::warning;
use clap::Args;
use earmark::Scene;
use earmark::displace::{Displacement, Function, HeightMap};
use earmark::files;
use earmark::limits::LimitError;
use earmark::texture::{Meaning, Texture};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Largest file of a map, and most bytes it may take decoded.
pub(crate) const MAP: u64 = 512 << 20;

/// Displacement along the limit normal.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Displacement")]
pub(crate) struct DisplaceFlags {
    /// Picture (PNG or JPEG, 8 or 16 bits) whose red channel moves the surface along its normals, black by the bias alone; read at the
    /// texture coordinates, level 0 only
    #[arg(long, value_name = "IMAGE", conflicts_with = "displace_noise")]
    pub(crate) displace: Option<PathBuf>,
    /// Function of space that moves the surface along its normals: perlin, fbm, ridged or ripples, from about -1 to 1. Parameters:
    /// frequency (features per model unit, 1) or scale (model units per feature, 1), seed (0), t (time, 0); of fbm and ridged octaves (5),
    /// lacunarity (2), gain (0.5); of ripples their centre x, y, z (0)
    #[arg(long, value_name = "NAME[:k=v,...]", value_parser = function)]
    pub(crate) displace_noise: Option<Function>,
    /// Model units by which white, or a function's 1, moves the surface
    #[arg(long, value_name = "S", default_value = "1", value_parser = single, allow_hyphen_values = true)]
    pub(crate) displace_scale: f32,
    /// Model units that are added
    #[arg(long, value_name = "B", default_value = "0", value_parser = single, allow_hyphen_values = true)]
    pub(crate) displace_bias: f32,
    /// With --displace, take the slopes of the map pixel by pixel: detail shows however coarse the triangles are
    #[arg(long, requires = "displace")]
    pub(crate) displace_per_pixel: bool,
}

fn function(text: &str) -> Result<Function, String> {
    text.parse()
        .map_err(|e: earmark::displace::FunctionError| e.to_string())
}

/// A finite number of single precision.
fn single(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err("not a finite number".into()),
    }
}

impl DisplaceFlags {
    pub(crate) fn is_on(&self) -> bool {
        self.displace.is_some() || self.displace_noise.is_some()
    }

    /// The displacement that the flags ask for.
    pub(crate) fn displacement(&self, job: &Job) -> Result<Option<Displacement>, Failure> {
        let found = match (&self.displace, self.displace_noise) {
            (Some(path), _) => Displacement::map(Arc::new(height_map(job, path)?)),
            (None, Some(function)) => Displacement::function(function),
            (None, None) => return Ok(None),
        };
        let found = found.scaled(self.displace_scale).biased(self.displace_bias);
        Ok(Some(found.with_slopes_per_pixel(self.displace_per_pixel)))
    }

    /// Displaces all models of a scene.
    pub(crate) fn apply(&self, job: &Job, scene: &mut Scene) -> Result<(), Failure> {
        let Some(displacement) = self.displacement(job)? else {
            return Ok(());
        };
        if displacement.needs_uvs() && !scene.objects.iter().any(|o| o.surface.has_uvs()) {
            warning(
                "no model has texture coordinates: --displace moves everything by the map's lower left corner",
            );
        }
        for object in &mut scene.objects {
            let origin = object.surface.cage().origin();
            object
                .surface
                .set_displacement(Some(displacement.clone().relative_to(origin)));
        }
        Ok(())
    }
}

fn height_map(job: &Job, path: &Path) -> Result<HeightMap, Failure> {
    let most = job.memory_left().unwrap_or(u64::MAX).min(MAP);
    let bytes = files::read_model(path, most)?;
    let mut budget = most;
    let picture = Texture::decode(&bytes, Meaning::Data, &mut budget)
        .map_err(|e| Failure::texture(path, &e))?;
    let [width, height] = picture.size();
    let wanted = HeightMap::bytes(width, height);
    if wanted > budget {
        return Err(LimitError::Memory {
            what: "the displacement map",
            wanted,
            allowed: budget,
        }
        .into());
    }
    Ok(HeightMap::of_texture(&picture))
}
