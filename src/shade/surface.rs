//! What shading knows of a visible point, and what the surface is made of there.

use super::Relief;
use crate::film::srgb::to_linear;
use crate::math::{dot, normalize, saturate};
use crate::texture::Texture;

/// The material index of a point without one.
pub const NO_MATERIAL: u32 = u32::MAX;

/// A visible point of the surface, as `frame` finds it from a sample's id.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Position in model space.
    pub position: [f32; 3],
    /// Normal of the limit surface, outward. Need not have length 1; is not turned to the eye.
    pub normal: [f32; 3],
    /// Normal of the micro-triangle, outward, any length. Decides which side the eye sees, and is drawn by
    /// [`ShadeMode::Flat`](super::ShadeMode::Flat). Zeros where it is not known: `normal` serves then.
    pub geometric: [f32; 3],
    /// Texture coordinates.
    pub uv: Option<[f32; 2]>,
    /// Derivatives of the surface by the texture coordinates, for relief; any length.
    pub tangents: Option<[[f32; 3]; 2]>,
    /// Side of the square in texture coordinates that has the area of a pixel's: the MIP levels follow from it.
    pub uv_footprint: f32,
    /// Linear colour of the vertices, `[1.0; 3]` without.
    pub color: [f32; 3],
    /// The cage's face.
    pub face: u32,
    /// Level of subdivision.
    pub level: u32,
    /// Place in the depth range: 0 near, 1 far ([`View::depth01`](crate::camera::View::depth01)).
    pub depth01: f32,
    /// Index of the material, or [`NO_MATERIAL`].
    pub material: u32,
}

impl Default for SurfacePoint {
    fn default() -> Self {
        Self {
            position: [0.0; 3],
            normal: [0.0; 3],
            geometric: [0.0; 3],
            uv: None,
            tangents: None,
            uv_footprint: 0.0,
            color: [1.0; 3],
            face: 0,
            level: 0,
            depth01: 0.0,
            material: NO_MATERIAL,
        }
    }
}

impl SurfacePoint {
    /// The normal, or what there is instead: the geometric normal, then a vector to the eye. Not of length 1, but it can be
    /// brought to it.
    #[inline]
    pub(super) fn usable_normal(&self, to_eye: [f32; 3]) -> [f32; 3] {
        if has_direction(self.normal) {
            self.normal
        } else if has_direction(self.geometric) {
            self.geometric
        } else if has_direction(to_eye) {
            to_eye
        } else {
            [0.0, 0.0, 1.0]
        }
    }

    /// The geometric normal, or else the normal.
    #[inline]
    pub(super) fn usable_geometric(&self, normal: [f32; 3]) -> [f32; 3] {
        if has_direction(self.geometric) {
            self.geometric
        } else {
            normal
        }
    }

    /// The unit normal that `--shade normals` and the normal output show; never turned to the eye.
    #[must_use]
    pub fn unit_normal(&self) -> [f32; 3] {
        normalize(self.normal)
            .or_else(|| normalize(self.geometric))
            .unwrap_or([0.0; 3])
    }
}

/// Whether a vector can be brought to length 1.
#[must_use]
#[inline]
pub fn has_direction(v: [f32; 3]) -> bool {
    let d = dot(v, v);
    (f32::MIN_POSITIVE..=f32::MAX).contains(&d)
}

/// What a face is made of: a diffuse colour and opacity, each with an optional texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceMaterial {
    /// Linear colour; multiplied with the texture and the vertex colour.
    pub diffuse: [f32; 3],
    /// 1 opaque, 0 invisible.
    pub opacity: f32,
    /// Index of the colour texture.
    pub diffuse_map: Option<u32>,
    /// Index of the opacity texture.
    pub opacity_map: Option<u32>,
    /// Finer normals.
    pub relief: Option<Relief>,
}

impl SurfaceMaterial {
    /// Warm light-grey clay, for models that say nothing.
    pub const CLAY: Self = Self {
        diffuse: [0.53, 0.49, 0.44],
        opacity: 1.0,
        diffuse_map: None,
        opacity_map: None,
        relief: None,
    };
    /// Paper white, to carry vertex colours or a texture unchanged.
    pub const WHITE: Self = Self {
        diffuse: [1.0; 3],
        ..Self::CLAY
    };

    /// Whether it is too transparent to be drawn at all: what is drawn is opaque.
    #[must_use]
    pub(crate) fn is_clear(&self) -> bool {
        self.opacity < 0.5
    }

    /// A material from the values of an MTL file: `Kd` as sRGB from 0 to 1, `d`, and indices of the loaded maps. A black `Kd`
    /// under a map counts as white: many exporters write it so and mean the map.
    #[must_use]
    pub fn from_mtl(
        diffuse: [f32; 3],
        opacity: f32,
        diffuse_map: Option<u32>,
        opacity_map: Option<u32>,
    ) -> Self {
        let black = diffuse.iter().all(|&c| c <= 0.0);
        Self {
            diffuse: if black && diffuse_map.is_some() {
                [1.0; 3]
            } else {
                diffuse.map(|c| to_linear(f64::from(saturate(c))) as f32)
            },
            opacity: saturate(opacity),
            diffuse_map,
            opacity_map,
            relief: None,
        }
    }

    /// Linear colour and opacity at a point.
    #[must_use]
    #[inline]
    pub fn albedo(&self, point: &SurfacePoint, textures: &[Texture]) -> [f32; 4] {
        let [mut r, mut g, mut b] = self.diffuse;
        let mut a = self.opacity;
        if let Some([u, v]) = point.uv {
            if let Some(map) = self.diffuse_map.and_then(|i| textures.get(i as usize)) {
                let t = map.sample(u, v, map.lod(point.uv_footprint));
                (r, g, b) = (r * t[0], g * t[1], b * t[2]);
            }
            if let Some(map) = self.opacity_map.and_then(|i| textures.get(i as usize)) {
                a *= map.opacity(u, v, map.lod(point.uv_footprint));
            }
        }
        let c = point.color;
        [r * c[0], g * c[1], b * c[2], a]
    }
}
