//! Shading: from a visible point of the surface to a colour.
//!
//! A [`Shader`] is made once per picture from the view, the materials and their textures, and is then only read, by any number
//! of threads. Colours are RGBA, premultiplied with opacity; linear light for [`ShadeMode::Lit`] and [`ShadeMode::Flat`], plain
//! numbers that are written without a curve for the other modes ([`ShadeMode::encoding`]).

mod light;
mod relief;
mod surface;

pub use light::LightRig;
pub use relief::Relief;
pub use surface::{NO_MATERIAL, SurfaceMaterial, SurfacePoint};

use crate::camera::View;
use crate::film::Encoding;
use crate::math::saturate;
use crate::simd::Level;
use crate::texture::Texture;

/// Points shaded together by [`Shader::shade_all`]. 16 fills the widest vector registers; the arrays of one group take 1 KB.
const GROUP: usize = 16;

/// What a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShadeMode {
    /// The surface under studio light, with the normals of the limit surface.
    #[default]
    Lit,
    /// The same with the normals of the micro-triangles.
    Flat,
    /// The unit normal in model space, `n * 0.5 + 0.5`, not turned to the eye.
    Normals,
    /// Texture coordinates in red and green, their fractional part outside of 0 to 1; black without.
    Uv,
    /// Depth: white near, black far, linear along the view axis.
    Depth,
    /// Level of subdivision by hue, cage faces of odd number a little darker.
    Level,
}

impl ShadeMode {
    /// How the numbers of this mode become bytes.
    #[must_use]
    pub fn encoding(self) -> Encoding {
        match self {
            Self::Lit | Self::Flat => Encoding::Srgb,
            Self::Normals | Self::Uv | Self::Depth | Self::Level => Encoding::Raw,
        }
    }
}

/// Colours of levels 0, 1, 2…, repeated after the last. Neighbours differ in hue and in brightness.
const LEVEL_COLORS: [[f32; 3]; 11] = [
    [0.62, 0.62, 0.65],
    [0.26, 0.36, 0.75],
    [0.20, 0.62, 0.86],
    [0.16, 0.58, 0.48],
    [0.45, 0.76, 0.30],
    [0.93, 0.82, 0.25],
    [0.92, 0.52, 0.16],
    [0.82, 0.25, 0.20],
    [0.90, 0.42, 0.62],
    [0.56, 0.24, 0.60],
    [0.45, 0.30, 0.22],
];

/// Shades the points of one picture.
#[derive(Clone, Copy, Debug)]
pub struct Shader<'a> {
    mode: ShadeMode,
    lights: LightRig,
    eye: [f32; 3],
    back: [f32; 3],
    ortho: bool,
    default: SurfaceMaterial,
    materials: &'a [SurfaceMaterial],
    textures: &'a [Texture],
    simd: Level,
}

impl<'a> Shader<'a> {
    /// A shader for a view. Points name a material by its index in `materials`, materials a texture by its index in `textures`;
    /// points without a material get [`SurfaceMaterial::CLAY`].
    #[must_use]
    pub fn new(
        mode: ShadeMode,
        view: &View,
        materials: &'a [SurfaceMaterial],
        textures: &'a [Texture],
    ) -> Self {
        Self {
            mode,
            lights: LightRig::new(view),
            eye: view.eye,
            back: view.forward.map(|c| -c),
            ortho: view.projection.ortho,
            default: SurfaceMaterial::CLAY,
            materials,
            textures,
            simd: Level::SCALAR,
        }
    }

    /// The same shader with other vector instructions; they never change a bit.
    #[must_use]
    pub fn with_simd(mut self, simd: Level) -> Self {
        self.simd = simd;
        self
    }

    /// The same shader with another material for points that have none.
    #[must_use]
    pub fn with_default_material(mut self, material: SurfaceMaterial) -> Self {
        self.default = material;
        self
    }

    /// What the shader shows.
    #[must_use]
    pub fn mode(&self) -> ShadeMode {
        self.mode
    }

    /// Linear colour and opacity of the surface at a point, without light.
    #[must_use]
    #[inline]
    pub fn albedo(&self, point: &SurfacePoint) -> [f32; 4] {
        self.materials
            .get(point.material as usize)
            .unwrap_or(&self.default)
            .albedo(point, self.textures)
    }

    /// The colour of a point, premultiplied. Finite and from 0 to 1 whatever the point holds.
    #[must_use]
    #[inline]
    pub fn shade(&self, point: &SurfacePoint) -> [f32; 4] {
        let rgb = match self.mode {
            ShadeMode::Lit | ShadeMode::Flat => {
                let (normal, geometric, to_eye) = self.vectors(point);
                let [r, g, b, a] = self.albedo(point);
                return premultiply(self.lights.light(normal, geometric, to_eye, [r, g, b]), a);
            }
            ShadeMode::Normals => {
                let tilted = SurfacePoint {
                    normal: self.tilted(point, point.normal),
                    ..*point
                };
                tilted.unit_normal().map(|c| c * 0.5 + 0.5)
            }
            ShadeMode::Uv => match point.uv {
                Some(uv) => {
                    let [u, v] = uv.map(|c| {
                        if (0.0..=1.0).contains(&c) {
                            c
                        } else {
                            c - c.floor()
                        }
                    });
                    [u, v, 0.0]
                }
                None => [0.0; 3],
            },
            ShadeMode::Depth => [1.0 - point.depth01; 3],
            ShadeMode::Level => self.level_color(point),
        };
        premultiply(rgb, 1.0)
    }

    /// Shades many points; the same bits as [`Shader::shade`] for each, several times as fast under light.
    ///
    /// # Panics
    /// When `out` is not as long as `points`.
    pub fn shade_all(&self, points: &[SurfacePoint], out: &mut [[f32; 4]]) {
        assert_eq!(points.len(), out.len(), "one colour per point");
        if !matches!(self.mode, ShadeMode::Lit | ShadeMode::Flat) {
            for (p, o) in points.iter().zip(out) {
                *o = self.shade(p);
            }
            return;
        }
        let mut groups = points.chunks_exact(GROUP);
        let mut outs = out.chunks_exact_mut(GROUP);
        for (points, out) in (&mut groups).zip(&mut outs) {
            crate::dispatch!(self.simd, self.light_group(points, out));
        }
        for (p, o) in groups.remainder().iter().zip(outs.into_remainder()) {
            *o = self.shade(p);
        }
    }

    /// One group under light: gather component by component, light all lanes, scatter.
    #[inline(always)]
    fn light_group(&self, points: &[SurfacePoint], out: &mut [[f32; 4]]) {
        let mut n = [[0.0_f32; GROUP]; 3];
        let mut g = [[0.0_f32; GROUP]; 3];
        let mut v = [[0.0_f32; GROUP]; 3];
        let mut c = [[0.0_f32; GROUP]; 4];
        for (i, p) in points.iter().enumerate().take(GROUP) {
            let (normal, geometric, to_eye) = self.vectors(p);
            let albedo = self.albedo(p);
            for k in 0..3 {
                n[k][i] = normal[k];
                g[k][i] = geometric[k];
                v[k][i] = to_eye[k];
            }
            for k in 0..4 {
                c[k][i] = albedo[k];
            }
        }
        let mut rgba = [[0.0_f32; GROUP]; 4];
        for i in 0..GROUP {
            let light = self.lights.light(
                [n[0][i], n[1][i], n[2][i]],
                [g[0][i], g[1][i], g[2][i]],
                [v[0][i], v[1][i], v[2][i]],
                [c[0][i], c[1][i], c[2][i]],
            );
            let color = premultiply(light, c[3][i]);
            for k in 0..4 {
                rgba[k][i] = color[k];
            }
        }
        for (i, o) in out.iter_mut().enumerate().take(GROUP) {
            *o = [rgba[0][i], rgba[1][i], rgba[2][i], rgba[3][i]];
        }
    }

    /// Normal to light, geometric normal, and vector to the eye; each has a direction.
    #[inline(always)]
    fn vectors(&self, point: &SurfacePoint) -> ([f32; 3], [f32; 3], [f32; 3]) {
        let to_eye = if self.ortho {
            self.back
        } else {
            crate::math::sub(self.eye, point.position)
        };
        let normal = point.usable_normal(to_eye);
        let geometric = point.usable_geometric(normal);
        let normal = self.tilted(point, normal);
        if self.mode == ShadeMode::Flat {
            (geometric, geometric, to_eye)
        } else {
            (normal, geometric, to_eye)
        }
    }

    /// The normal with the relief of the material.
    #[inline(always)]
    fn tilted(&self, point: &SurfacePoint, normal: [f32; 3]) -> [f32; 3] {
        let (Some(tangents), Some(uv)) = (point.tangents, point.uv) else {
            return normal;
        };
        let material = (self.materials.get(point.material as usize)).unwrap_or(&self.default);
        match material.relief {
            Some(relief) => relief.tilt(self.textures, normal, tangents, uv, point.uv_footprint),
            None => normal,
        }
    }

    /// Hue by level, a little shape from the angle to the eye.
    fn level_color(&self, point: &SurfacePoint) -> [f32; 3] {
        let (normal, _, to_eye) = self.vectors(point);
        let facing = match (
            crate::math::normalize(normal),
            crate::math::normalize(to_eye),
        ) {
            (Some(n), Some(v)) => crate::math::dot(n, v).abs(),
            _ => 1.0,
        };
        let shade = (0.55 + 0.45 * facing) * if point.face % 2 == 1 { 0.86 } else { 1.0 };
        LEVEL_COLORS[point.level as usize % LEVEL_COLORS.len()].map(|c| c * shade)
    }
}

/// Colour times opacity, both brought to the range from 0 to 1; what is not a number becomes 0.
#[inline(always)]
fn premultiply(rgb: [f32; 3], alpha: f32) -> [f32; 4] {
    let a = saturate(alpha);
    let channel = |k: usize| saturate(rgb[k]) * a;
    [channel(0), channel(1), channel(2), a]
}
