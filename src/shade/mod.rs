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
pub use surface::{NO_MATERIAL, SurfaceMaterial, SurfacePoint, has_direction};

use crate::camera::View;
use crate::film::Encoding;
use crate::math::{DVec3, dot, saturate};
use crate::simd::{LANES, Level};
use crate::texture::Texture;
use light::{side_seen, unit};

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
pub(crate) const LEVEL_COLORS: [[f32; 3]; 11] = [
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

/// Cosine to the eye from which on normals of a flat tessellation are decided.
const FOLDED: f32 = 0.25;

/// In its place where no normal is believed against its triangle.
const NEVER: f32 = 2.0;

/// Shades the points of one picture.
#[derive(Clone, Copy, Debug)]
pub struct Shader<'a> {
    mode: ShadeMode,
    lights: LightRig,
    eye: [f32; 3],
    back: [f32; 3],
    rays: [[f32; 3]; 3],
    ortho: bool,
    decided: f32,
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
            rays: rays_to_eye(view),
            ortho: view.projection.ortho,
            decided: NEVER,
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

    /// The same shader with its lights turned ([`LightRig::turned`]).
    #[must_use]
    pub fn with_lights(mut self, lights: LightRig) -> Self {
        self.lights = lights;
        self
    }

    /// The same shader with another material for points that have none.
    #[must_use]
    pub fn with_default_material(mut self, material: SurfaceMaterial) -> Self {
        self.default = material;
        self
    }

    /// The same shader for triangles within a few degrees of their normals: one that is seen from the side that its normals decidedly are not is
    /// folded over. That happens by less than a pixel where levels meet and points have moved.
    #[must_use]
    pub fn with_folds(mut self) -> Self {
        self.decided = FOLDED;
        self
    }

    /// Vectors to the eye over the screen, for shading elsewhere; see [`Shader::to_eye`].
    #[cfg(feature = "gpu")]
    pub(crate) fn rays(&self) -> [[f32; 3]; 3] {
        self.rays
    }

    /// Cosine to the eye from which on normals are believed against their triangles; see [`Shader::with_folds`].
    #[cfg(feature = "gpu")]
    pub(crate) fn decided(&self) -> f32 {
        self.decided
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

    /// Unit normal of a point with the relief of its material, not turned to the eye; zeros where there is none.
    #[must_use]
    #[inline]
    pub fn normal(&self, point: &SurfacePoint) -> [f32; 3] {
        let tilted = SurfacePoint {
            normal: self.tilted(point, point.normal),
            ..*point
        };
        tilted.unit_normal()
    }

    /// The colour of a point, premultiplied. Finite and from 0 to 1 whatever the point holds.
    #[must_use]
    #[inline]
    pub fn shade(&self, point: &SurfacePoint) -> [f32; 4] {
        let rgb = match self.mode {
            ShadeMode::Lit | ShadeMode::Flat => {
                let (normal, side, to_eye) = self.vectors(point);
                let [r, g, b, a] = self.albedo(point);
                let light = (self.lights).light(unit(normal), side, unit(to_eye), [r, g, b]);
                return premultiply(light, a);
            }
            ShadeMode::Normals => self.normal(point).map(|c| c * 0.5 + 0.5),
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

    /// Vector to the eye, of any length, from what is seen at a place of the screen, 1/256 pixel.
    #[must_use]
    #[inline]
    pub fn to_eye(&self, x: i32, y: i32) -> [f32; 3] {
        along(&self.rays, x, y)
    }

    /// Opaque surfaces under light in lanes: `x` and `y` are positions on the screen, 1/256 pixel; `side` is 1 where the front is
    /// seen, -1 where the back is, 0 where the normal decides alone. Normals have any length but a direction. The vector to the eye is that of the pixel, not of the
    /// point: the same but for rounding. Linear colours, component by component.
    #[must_use]
    #[inline(always)]
    pub fn light_lanes(
        &self,
        normals: &[[f32; LANES]; 3],
        side: &[f32; LANES],
        x: &[i32; LANES],
        y: &[i32; LANES],
        albedo: &[[f32; LANES]; 3],
    ) -> [[f32; LANES]; 3] {
        let mut out = [[0.0_f32; LANES]; 3];
        let rays = self.rays;
        for l in 0..LANES {
            let v = unit(along(&rays, x[l], y[l]));
            let n = unit([normals[0][l], normals[1][l], normals[2][l]]);
            let albedo = [albedo[0][l], albedo[1][l], albedo[2][l]];
            let light = self
                .lights
                .light(n, side_seen(n, side[l], v, self.decided), v, albedo);
            for k in 0..3 {
                out[k][l] = light[k];
            }
        }
        out
    }

    /// One group under light: gather component by component, light all lanes, scatter.
    #[inline(always)]
    fn light_group(&self, points: &[SurfacePoint], out: &mut [[f32; 4]]) {
        let mut n = [[0.0_f32; GROUP]; 3];
        let mut sides = [1.0_f32; GROUP];
        let mut v = [[0.0_f32; GROUP]; 3];
        let mut c = [[0.0_f32; GROUP]; 4];
        for (i, p) in points.iter().enumerate().take(GROUP) {
            let (normal, side, to_eye) = self.vectors(p);
            sides[i] = side;
            let albedo = self.albedo(p);
            for k in 0..3 {
                n[k][i] = normal[k];
                v[k][i] = to_eye[k];
            }
            for k in 0..4 {
                c[k][i] = albedo[k];
            }
        }
        let mut rgba = [[0.0_f32; GROUP]; 4];
        for i in 0..GROUP {
            let light = self.lights.light(
                unit([n[0][i], n[1][i], n[2][i]]),
                sides[i],
                unit([v[0][i], v[1][i], v[2][i]]),
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

    /// Normal to light, the side that is seen, and the vector to the eye; both vectors have a direction.
    #[inline(always)]
    fn vectors(&self, point: &SurfacePoint) -> ([f32; 3], f32, [f32; 3]) {
        let to_eye = if self.ortho {
            self.back
        } else {
            crate::math::sub(self.eye, point.position)
        };
        let normal = point.usable_normal(to_eye);
        let geometric = point.usable_geometric(normal);
        let v = unit(to_eye);
        let side = if dot(geometric, v) < 0.0 { -1.0 } else { 1.0 };
        if self.mode == ShadeMode::Flat {
            return (geometric, side, to_eye);
        }
        // Relief does not say which side is seen.
        let side = side_seen(unit(normal), side, v, self.decided);
        (self.tilted(point, normal), side, to_eye)
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
            (Some(n), Some(v)) => dot(n, v).abs(),
            _ => 1.0,
        };
        let shade = (0.55 + 0.45 * facing) * if point.face % 2 == 1 { 0.86 } else { 1.0 };
        LEVEL_COLORS[point.level as usize % LEVEL_COLORS.len()].map(|c| c * shade)
    }
}

/// Vectors to the eye as a linear function of the place on the screen, in 1/256 pixel: `x * r[0] + (y * r[1] + r[2])`. Those of
/// a perspective view are the negative directions of distance 1, by inverting the projection's three rows.
fn rays_to_eye(view: &View) -> [[f32; 3]; 3] {
    let p = &view.projection;
    if p.ortho {
        return [[0.0; 3], [0.0; 3], view.forward.map(|c| -c)];
    }
    let row = |r: &[f32; 4]| DVec3::new(r[0].into(), r[1].into(), r[2].into());
    let (x, y, w) = (row(&p.x), row(&p.y), row(&p.w));
    let k = -1.0 / x.dot(y.cross(w));
    [y.cross(w) * k, w.cross(x) * k, x.cross(y) * k].map(|v| [v.x as f32, v.y as f32, v.z as f32])
}

#[inline(always)]
fn along(rays: &[[f32; 3]; 3], x: i32, y: i32) -> [f32; 3] {
    let (x, y) = (x as f32, y as f32);
    let at = |k: usize| rays[0][k] * x + (rays[1][k] * y + rays[2][k]);
    [at(0), at(1), at(2)]
}

/// Colour times opacity, both brought to the range from 0 to 1; what is not a number becomes 0.
#[inline(always)]
fn premultiply(rgb: [f32; 3], alpha: f32) -> [f32; 4] {
    let a = saturate(alpha);
    let channel = |k: usize| saturate(rgb[k]) * a;
    [channel(0), channel(1), channel(2), a]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Sphere};
    use crate::records::ScreenSize;

    #[test]
    fn lanes_light_as_single_points_do() {
        let size = ScreenSize {
            width: 200,
            height: 150,
            samples: 1,
        };
        let sphere = Sphere {
            center: [1.0, 2.0, 3.0],
            radius: 2.0,
        };
        for camera in [Camera::default(), Camera::default().with_ortho()] {
            let view = camera.framing(&sphere, size).unwrap();
            let shader = Shader::new(ShadeMode::Lit, &view, &[], &[]);
            let p = &view.projection;
            for k in 1..400 {
                let turn = |i: i32| libm::sinf((k * i) as f32 * 0.7);
                let normal = [turn(3), turn(5), turn(7)];
                let position = [0, 1, 2].map(|i| sphere.center[i] as f32 + normal[i]);
                let row = |r: &[f32; 4]| dot([r[0], r[1], r[2]], position) + r[3];
                let w = if p.ortho { 1.0 } else { row(&p.w) };
                let (x, y) = ((row(&p.x) / w) as i32, (row(&p.y) / w) as i32);
                let point = SurfacePoint {
                    position,
                    normal,
                    geometric: normal,
                    ..SurfacePoint::default()
                };
                // From behind, the same place is lit as its other side.
                let side = if k % 2 == 0 { 1.0 } else { -1.0 };
                let facing = dot(normal, shader.to_eye(x, y)) > 0.0;
                let want = shader.shade(&point);
                let albedo = shader.albedo(&point);
                let lanes = |side: f32| {
                    let albedo = [0, 1, 2].map(|i| [albedo[i]; LANES]);
                    let normals = normal.map(|c| [c * side; LANES]);
                    let towards = if facing { side } else { -side };
                    shader.light_lanes(
                        &normals,
                        &[towards; LANES],
                        &[x; LANES],
                        &[y; LANES],
                        &albedo,
                    )
                };
                for (i, got) in lanes(side).iter().enumerate() {
                    assert!((got[0] - want[i]).abs() < 2e-4, "{got:?} {want:?}");
                    assert_eq!(got, &[got[0]; LANES]);
                }
            }
        }
    }
}
