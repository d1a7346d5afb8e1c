//! Displacement as the device has it: what says heights, and what spots take from elsewhere.

use super::chunk::Builder;
use super::dicer::Dicer;
use super::error::GpuError;
use super::owners::Owners;
use super::patches::Curve;
use super::records::{Lift, Rise};
use super::wgsl::{MAP, NOISE, RIDGED, RIPPLES};
use crate::displace::{Displacement, HeightMap, Shape, Source};
use crate::limits::{Budget, LimitError};

impl Rise {
    /// Of a displacement, whose map is put among `heights`. Nothing of a caller's rule.
    pub(super) fn of<'a>(
        displacement: Option<&'a Displacement>,
        heights: &mut Maps<'a>,
        budget: &mut Budget<'_>,
    ) -> Result<Option<Self>, LimitError> {
        let Some(displacement) = displacement else {
            return Ok(Some(Self::default()));
        };
        let plain = Self {
            scale: displacement.scale,
            bias: displacement.bias,
            ..Self::default()
        };
        let Some(source) = displacement.source() else {
            return Ok(None);
        };
        Ok(Some(match source {
            Source::Map(map) => {
                let [width, height] = map.size();
                Self {
                    shape: MAP,
                    first: heights.place(map, budget)?,
                    width,
                    height,
                    per_pixel: u32::from(displacement.per_pixel),
                    ..plain
                }
            }
            Source::Function(f) => {
                let [x, y, z] = f.center;
                let [_, weight] = f.octaves().next().unwrap_or([0.0; 2]);
                Self {
                    center: [x, y, z, 0.0],
                    shape: match f.shape {
                        Shape::Perlin | Shape::Fbm => NOISE,
                        Shape::Ridged => RIDGED,
                        Shape::Ripples => RIPPLES,
                    },
                    frequency: f.frequency,
                    lacunarity: f.lacunarity,
                    gain: f.gain,
                    weight,
                    time: f.time,
                    octaves: f.octaves().count() as u32,
                    seed: f.seed,
                    ..plain
                }
            }
        }))
    }
}

/// Texels of the maps of all objects, each map once.
#[derive(Default)]
pub(super) struct Maps<'a> {
    pub(super) texels: Vec<f32>,
    maps: Vec<(&'a HeightMap, u32)>,
}

impl<'a> Maps<'a> {
    /// Where the texels of a map begin. They are kept until they are on the device.
    fn place(&mut self, map: &'a HeightMap, budget: &mut Budget<'_>) -> Result<u32, LimitError> {
        if let Some(&(_, first)) = self.maps.iter().find(|m| std::ptr::eq(m.0, map)) {
            return Ok(first);
        }
        let bytes = 4 * map.texels().len() as u128;
        budget.take("the heights of the GPU backend", bytes, 0)?;
        let first = self.texels.len() as u32;
        self.texels.extend_from_slice(map.texels());
        self.maps.push((map, first));
        Ok(first)
    }
}

impl Builder {
    /// What the corner that half-edge `h` begins with takes from elsewhere, once its spot is there; with what patches stand on.
    pub(super) fn lift_corner(
        &mut self,
        dicer: &Dicer<'_>,
        h: u32,
        of: (Owners, Option<Curve>),
    ) -> Result<(), GpuError> {
        let Some(mitred) = dicer.surface.mitred_corner(h) else {
            self.lift(dicer, of, None);
            return Ok(());
        };
        if dicer.lifts_patches() {
            let curves = self.mitred_corners(dicer, &mitred)?;
            self.lift(dicer, of, Some(Mitre::Curves(&curves)));
            return Ok(());
        }
        let count = dicer.corner_count();
        let mut places = Vec::new();
        for h in mitred {
            let at = dicer.along(h % count, 0, 1);
            let place = self.place(dicer, h / count, at, 0)?;
            places.push(self.corner_normal(dicer, h, place));
        }
        self.lift(dicer, of, Some(Mitre::Places(&places)));
        Ok(())
    }

    /// The same of point `k` of the side `h` at `level`, as its positions' owner walks it; nothing of surfaces that are not displaced.
    pub(super) fn lift_side(
        &mut self,
        dicer: &Dicer<'_>,
        h: u32,
        of: (Owners, Option<Curve>),
        [k, level]: [u32; 2],
    ) -> Result<(), GpuError> {
        let position = of.0.position;
        let Some(mitred) = dicer.surface.mitred_side(h) else {
            self.lift(dicer, of, None);
            return Ok(());
        };
        if dicer.lifts_patches() {
            let curves = self.mitred_curves(dicer, &mitred, position, [k, level])?;
            self.lift(dicer, of, Some(Mitre::Curves(&curves)));
            return Ok(());
        }
        let (count, n) = (dicer.corner_count(), 1 << level);
        let mut places = Vec::new();
        for h in mitred {
            // Twins run the other way.
            let k = if h == position { k } else { n - k };
            let at = dicer.along(h % count, k, n);
            places.push(self.place(dicer, h / count, at, level)?);
        }
        self.lift(dicer, of, Some(Mitre::Places(&places)));
        Ok(())
    }

    fn lift(
        &mut self,
        dicer: &Dicer<'_>,
        (owners, curve): (Owners, Option<Curve>),
        mitre: Option<Mitre<'_>>,
    ) {
        let count = dicer.corner_count();
        let (mut uv, mut own) = ([0; 3], [0; 3]);
        if dicer.lifts_by_uvs() {
            uv = self.uv_stencil(dicer, owners.position / count, true);
            own = self.uv_stencil(dicer, dicer.evaluated(owners) / count, true);
        }
        let first = self.data.gathers.len() as u32;
        let (held, of_curves, mitre_count, words) = match mitre {
            None => (1, 0, 0, &[][..]),
            Some(Mitre::Places(all)) => (0, 0, all.len(), all.as_flattened()),
            Some(Mitre::Curves(all)) => (0, 1, all.len(), all.as_flattened()),
        };
        self.data.gathers.extend(words);
        self.data.lifts.push(Lift {
            curve: curve.unwrap_or_default(),
            uv_gather: uv[0],
            uv_count: uv[1],
            uv_table: uv[2],
            held,
            own_gather: own[0],
            own_count: own[1],
            own_table: own[2],
            mitre: first,
            mitre_count: mitre_count as u32,
            curved: u32::from(curve.is_some()),
            mitre_curves: of_curves,
            padding: 0,
        });
    }
}

/// What a direction is the mitre of: normals of the limit surface, each a stencil and a point of its table, or those of curves.
#[derive(Clone, Copy)]
enum Mitre<'a> {
    Places(&'a [[u32; 2]]),
    Curves(&'a [Curve]),
}
