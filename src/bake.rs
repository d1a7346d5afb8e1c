//! Normal maps of displaced surfaces: what displacement does to normals, as a picture over the limit surface.

use crate::dice::face::{Part, Sides};
use crate::math;
use crate::records::{BlockSize, Grid3};
use crate::simd::Level;
use crate::surface::{QuadPatch, Surface};
use crate::texture::{LoadError, Meaning, Texture};

/// Finest grid of a face.
const MAX_LEVEL: u32 = 8;
/// Texels that colours grow beyond the borders of charts, so that blending meets no blanks there.
const BORDER: u32 = 8;

/// A normal map of `surface` in tangent space, as [`Relief::Normals`](crate::shade::Relief::Normals) reads it: x along u, y along v, z along the limit
/// normal, codes of 16 bits. Texels that no face covers point straight up. Charts that lie over each other overwrite each other, in the order
/// of their faces. Without texture coordinates or displacement the map is flat.
///
/// # Errors
/// [`LoadError`] when a map of this size is not allowed.
pub fn normal_map(surface: &Surface, width: u32, height: u32) -> Result<Texture, LoadError> {
    let blank = [32768, 32768, u16::MAX, u16::MAX];
    if width == 0
        || height == 0
        || u64::from(width) * u64::from(height) > crate::texture::MAX_BYTES / 8
    {
        // The texture says what is wrong.
        return Texture::from_rgba16(width, height, Vec::new(), Meaning::Data);
    }
    let mut map = Map {
        width,
        height,
        texels: vec![[0.0; 3]; width as usize * height as usize],
    };
    if surface.has_uvs() {
        let mut displaced = surface.clone();
        let displacement = displaced.displacement().cloned();
        displaced.set_displacement(displacement.map(|d| d.with_slopes_per_pixel(false)));
        let mut plain = surface.clone();
        plain.set_displacement(None);
        let mut faces = Faces::new(&plain, &displaced);
        for q in 0..surface.quads().face_count() as u32 {
            faces.draw(q, &mut map);
        }
        map.grow();
    }
    let code = |x: f32| (x * 32767.5 + 32768.0).clamp(0.0, 65535.0) as u16;
    let texels = map.texels.iter().map(|&n| match math::normalize(n) {
        Some([x, y, z]) => [code(x), code(y), code(z), u16::MAX],
        None => blank,
    });
    Texture::from_rgba16(width, height, texels.collect(), Meaning::Data)
}

/// Normals of texels; zeros where there are none yet.
struct Map {
    width: u32,
    height: u32,
    texels: Vec<[f32; 3]>,
}

impl Map {
    /// Draws a triangle; corners are texture coordinates.
    fn triangle(&mut self, corners: [[f32; 3]; 3], normals: [[f32; 3]; 3]) {
        let (w, h) = (self.width as f32, self.height as f32);
        let p = corners.map(|[u, v, _]| [u * w - 0.5, -v * h - 0.5]);
        let area = cross(p[0], p[1], p[2]);
        let bound = |k: usize, of: fn(f32, f32) -> f32| of(of(p[0][k], p[1][k]), p[2][k]);
        let (low, high) = (
            [0, 1].map(|k| bound(k, f32::min).ceil()),
            [0, 1].map(|k| bound(k, f32::max).floor()),
        );
        let small = |k: usize| low[k].abs() < 1e6 && high[k] - low[k] < [w, h][k];
        if area == 0.0 || !area.is_finite() || !small(0) || !small(1) {
            return;
        }
        for y in low[1] as i32..=high[1] as i32 {
            for x in low[0] as i32..=high[0] as i32 {
                let at = [x as f32, y as f32];
                let weights = [
                    cross(p[1], p[2], at) / area,
                    cross(p[2], p[0], at) / area,
                    cross(p[0], p[1], at) / area,
                ];
                if weights.iter().any(|&w| w < -1e-4) {
                    continue;
                }
                let mix = |k: usize| {
                    (weights[0] * normals[0][k] + weights[1] * normals[1][k])
                        + weights[2] * normals[2][k]
                };
                let column = x.rem_euclid(self.width as i32) as usize;
                let row = y.rem_euclid(self.height as i32) as usize;
                self.texels[row * self.width as usize + column] = [mix(0), mix(1), mix(2)];
            }
        }
    }

    /// Gives blank texels the sum of their neighbours, again and again.
    fn grow(&mut self) {
        let (w, h) = (self.width as usize, self.height as usize);
        for _ in 0..BORDER {
            let before = self.texels.clone();
            for y in 0..h {
                for x in 0..w {
                    if before[y * w + x] != [0.0; 3] {
                        continue;
                    }
                    let around = [(x + 1, y), (x + w - 1, y), (x, y + 1), (x, y + h - 1)];
                    let sum = around.iter().fold([0.0; 3], |sum, &(x, y)| {
                        math::add(sum, before[y % h * w + x % w])
                    });
                    self.texels[y * w + x] = math::normalize(sum).unwrap_or([0.0; 3]);
                }
            }
        }
    }
}

/// Twice the signed area of a triangle.
fn cross(a: [f32; 2], b: [f32; 2], c: [f32; 2]) -> f32 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Faces of the limit surface and of the displaced one.
struct Faces<'a> {
    surfaces: [&'a Surface; 2],
    patches: [QuadPatch; 2],
    points: Box<Grid3>,
    normals: [Box<Grid3>; 2],
    uvs: Box<Grid3>,
    tangents: [Box<Grid3>; 2],
}

impl<'a> Faces<'a> {
    fn new(plain: &'a Surface, displaced: &'a Surface) -> Self {
        let simd = Level::detect();
        Self {
            surfaces: [plain, displaced],
            patches: [QuadPatch::for_level(simd), QuadPatch::for_level(simd)],
            points: Grid3::boxed(),
            normals: [Grid3::boxed(), Grid3::boxed()],
            uvs: Grid3::boxed(),
            tangents: [Grid3::boxed(), Grid3::boxed()],
        }
    }

    fn prepare(&mut self, q: u32, level: u32) {
        for (surface, patch) in self.surfaces.iter().zip(&mut self.patches) {
            surface.ensure(level);
            patch.prepare_points(surface, q, level, None, Sides::Normals);
            patch.prepare_uvs(surface, q);
        }
    }

    /// A level at which micro-quads are about as large as texels.
    fn level(&mut self, q: u32, map: &Map) -> u32 {
        self.prepare(q, 2);
        self.patches[0].dice_uvs(0, 0, &mut self.uvs);
        let mut most = 0.0_f32;
        for j in 0..4 {
            for i in 0..4 {
                let p = self.uvs.get(i, j);
                for (a, b) in [(i + 1, j), (i, j + 1)] {
                    let d = math::sub(self.uvs.get(a, b), p);
                    most = most
                        .max(d[0].abs() * map.width as f32)
                        .max(d[1].abs() * map.height as f32);
                }
            }
        }
        let mut level = 2;
        while level < MAX_LEVEL && most > 1.0 {
            level += 1;
            most *= 0.5;
        }
        level
    }

    fn draw(&mut self, q: u32, map: &mut Map) {
        let level = self.level(q, map);
        self.prepare(q, level);
        let triangular = self.surfaces[0].is_triangular();
        let blocks = 1_u32 << level.saturating_sub(5);
        for bv in 0..blocks {
            for bu in if triangular { bv } else { 0 }..blocks {
                self.block(Part::block(level, [bu, bv]), map);
            }
        }
    }

    fn block(&mut self, part: Part, map: &mut Map) {
        for k in 0..2 {
            self.patches[k].dice_part(
                self.surfaces[k],
                part,
                &mut self.points,
                Some(&mut self.normals[k]),
            );
        }
        self.patches[0].dice_part_uvs(part, &mut self.uvs);
        let [first, second] = &mut self.tangents;
        self.patches[0].dice_tangents(self.surfaces[0], part, first, second);
        let side = part.segments as usize + 1;
        // Normals of the displaced surface become vectors in tangent space.
        let size = BlockSize {
            cols: side,
            rows: side,
        };
        for k in size.indices() {
            let (n, displaced) = (self.normals[0].at(k), self.normals[1].at(k));
            let (along, across) = (self.tangents[0].at(k), self.tangents[1].at(k));
            let flat = math::sub(along, math::scale(n, math::dot(n, along)));
            let local = match math::normalize(flat) {
                Some(t) => {
                    let b = math::cross(n, t);
                    let sign = if math::dot(b, across) < 0.0 {
                        -1.0
                    } else {
                        1.0
                    };
                    [
                        math::dot(displaced, t),
                        math::dot(displaced, b) * sign,
                        math::dot(displaced, n),
                    ]
                }
                None => [0.0, 0.0, 1.0],
            };
            self.points.put(k, local);
        }
        for j in 0..side - 1 {
            for i in 0..side - 1 {
                for half in [[(0, 0), (1, 0), (1, 1)], [(0, 0), (1, 1), (0, 1)]] {
                    let at = half.map(|(a, b)| (i + a, j + b));
                    map.triangle(
                        at.map(|(i, j)| self.uvs.get(i, j)),
                        at.map(|(i, j)| self.points.get(i, j)),
                    );
                }
            }
        }
    }
}
