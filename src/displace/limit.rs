//! What a displaced surface's normals are made of: the limit surface around its points, one by one or those of a block in lanes.

use super::{DisplaceSite, Displacement, Heights, Kind, normal, padded};
use crate::dispatch;
use crate::math;
use crate::records::Grid3;
use crate::simd::Level;

impl Displacement {
    /// Unit normals of the displaced surface at the first `count` points: those of [`Displacement::normal`], bit for bit. `heights` are those
    /// of [`Displacement::all`]. What does not move keeps its normal.
    pub(crate) fn normals(
        &self,
        (simd, count): (Level, usize),
        limit: &Limit<'_>,
        directions: &Grid3,
        heights: &Heights,
        out: &mut Grid3,
    ) {
        let Limit {
            normals, jets, by, ..
        } = *limit;
        let (n, values) = (padded(count), &heights.values[..]);
        match &self.kind {
            Kind::Function(_) => {
                let slopes = Slopes::<false> {
                    scale: self.scale,
                    by,
                    of: &heights.slopes,
                };
                dispatch!(
                    simd,
                    normal_lanes(n, jets, normals, values, slopes, directions, out)
                );
            }
            Kind::Map(_) => {
                let slopes = Slopes::<true> {
                    scale: self.scale,
                    by,
                    of: &heights.slopes,
                };
                dispatch!(
                    simd,
                    normal_lanes(n, jets, normals, values, slopes, directions, out)
                );
            }
            Kind::Vector { .. } => {
                for k in 0..count {
                    let normal = match directions.at(k) == [0.0; 3] {
                        true => normals.at(k),
                        false => self.normal(&limit.around(k), 0.0, [0.0; 3]),
                    };
                    out.put(k, normal);
                }
            }
        }
    }

    /// Unit normal of the displaced surface at a point, from the derivatives of the limit surface and of the texture coordinates by the
    /// same parameters. `value` and `slope` are those of [`Displacement::all`].
    pub(crate) fn normal(&self, at: &Around, value: f32, slope: [f32; 3]) -> [f32; 3] {
        let (bend, n) = (&at.bend, at.normal);
        let [du, dv] = [bend.du, bend.dv];
        match &self.kind {
            Kind::Function(_) => {
                let slope = by_function([du, dv], slope, self.scale);
                bend.displaced(n, value, slope)
            }
            Kind::Map(_) => bend.displaced(n, value, by_map(at.uv_by, slope, self.scale)),
            Kind::Vector { rule, most } => at.of_rule(|site| Self::vector_at(&**rule, *most, site)),
        }
    }

    /// The vectors by which the slopes of a map tilt the limit normal `n` of the displaced surface: it runs along
    /// `n − (h_u a + h_v b)`. Zeros where the surface has no tangents.
    pub(crate) fn tilts(&self, at: &Around, value: f32) -> [[f32; 3]; 2] {
        let n = at.normal;
        let [nu, nv] = at.bend.normals_of(n);
        let along = |d: [f32; 3], nd: [f32; 3]| math::add(d, math::scale(nd, value));
        let (du, dv) = (along(at.bend.du, nu), along(at.bend.dv, nv));
        let area = math::dot(n, math::cross(du, dv));
        let factor = self.scale / area;
        if !factor.is_finite() {
            return [[0.0; 3]; 2];
        }
        let (first, second) = (math::cross(dv, n), math::cross(n, du));
        [0, 1].map(|k| {
            let [u, v] = [at.uv_by[0][k], at.uv_by[1][k]];
            math::scale(
                math::add(math::scale(first, u), math::scale(second, v)),
                factor,
            )
        })
    }

    /// Height and slope at a single point, as [`Displacement::all`] has them.
    pub(crate) fn slope_at(&self, position: [f32; 3], uv: [f32; 2]) -> (f32, [f32; 3]) {
        match &self.kind {
            Kind::Function(function) => {
                let [h, x, y, z] = function.slope(position);
                (self.height(h), [x, y, z])
            }
            Kind::Map(map) => {
                let [h, du, dv] = map.slope(uv[0], uv[1]);
                (self.height(h), [du, dv, 0.0])
            }
            Kind::Vector { .. } => (0.0, [0.0; 3]),
        }
    }
}

/// Slopes by both parameters of a function whose gradient is `slope`.
#[inline(always)]
fn by_function([du, dv]: [[f32; 3]; 2], slope: [f32; 3], scale: f32) -> [f32; 2] {
    [
        (du[0] * slope[0] + du[1] * slope[1] + du[2] * slope[2]) * scale,
        (dv[0] * slope[0] + dv[1] * slope[1] + dv[2] * slope[2]) * scale,
    ]
}

/// The same of a map, from its slopes by u and v.
#[inline(always)]
fn by_map([a, b]: [[f32; 2]; 2], slope: [f32; 3], scale: f32) -> [f32; 2] {
    [
        (slope[0] * a[0] + slope[1] * a[1]) * scale,
        (slope[0] * b[0] + slope[1] * b[1]) * scale,
    ]
}

/// Slopes of a block: of a map, or of a function of space.
struct Slopes<'a, const MAP: bool> {
    scale: f32,
    by: &'a Jets,
    of: &'a Grid3,
}

/// Normals of `n` points, a whole number of vectors.
#[inline(always)]
fn normal_lanes<const MAP: bool>(
    n: usize,
    jets: &Jets,
    normals: &Grid3,
    heights: &[f32],
    slopes: Slopes<'_, MAP>,
    directions: &Grid3,
    out: &mut Grid3,
) {
    let heights = &heights[..n];
    let Slopes { scale, by, of } = slopes;
    for i in 0..n {
        let bend = jets.bend(i);
        let normal = [normals.x[i], normals.y[i], normals.z[i]];
        let slope = [of.x[i], of.y[i], of.z[i]];
        let slope = if MAP {
            by_map(by.first_two(i), slope, scale)
        } else {
            by_function([bend.du, bend.dv], slope, scale)
        };
        let found = bend.displaced(normal, heights[i], slope);
        let held = (directions.x[i] == 0.0) & (directions.y[i] == 0.0) & (directions.z[i] == 0.0);
        out.x[i] = if held { normal[0] } else { found[0] };
        out.y[i] = if held { normal[1] } else { found[1] };
        out.z[i] = if held { normal[2] } else { found[2] };
    }
}

/// Derivatives at the points of a block, by u, by v, and the second ones.
#[derive(Clone, Debug)]
pub(crate) struct Jets {
    pub(crate) du: Grid3,
    pub(crate) dv: Grid3,
    pub(crate) second: [Grid3; 3],
}

impl Jets {
    pub(crate) fn boxed() -> Box<Self> {
        let zero = || *Grid3::boxed();
        Box::new(Self {
            du: zero(),
            dv: zero(),
            second: [zero(), zero(), zero()],
        })
    }

    #[inline(always)]
    pub(crate) fn bend(&self, k: usize) -> normal::Bend {
        let [a, b, c] = &self.second;
        normal::Bend {
            du: [self.du.x[k], self.du.y[k], self.du.z[k]],
            dv: [self.dv.x[k], self.dv.y[k], self.dv.z[k]],
            second: [
                [a.x[k], a.y[k], a.z[k]],
                [b.x[k], b.y[k], b.z[k]],
                [c.x[k], c.y[k], c.z[k]],
            ],
        }
    }

    /// Those of texture coordinates.
    #[inline(always)]
    pub(crate) fn first_two(&self, k: usize) -> [[f32; 2]; 2] {
        [[self.du.x[k], self.du.y[k]], [self.dv.x[k], self.dv.y[k]]]
    }
}

/// The limit surface at the points of a block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limit<'a> {
    pub(crate) points: &'a Grid3,
    pub(crate) normals: &'a Grid3,
    pub(crate) uvs: &'a Grid3,
    pub(crate) jets: &'a Jets,
    /// Derivatives of the texture coordinates.
    pub(crate) by: &'a Jets,
}

impl Limit<'_> {
    /// Around point `k`.
    pub(crate) fn around(&self, k: usize) -> Around {
        Around {
            position: self.points.at(k),
            normal: self.normals.at(k),
            bend: self.jets.bend(k),
            uv: [self.uvs.x[k], self.uvs.y[k]],
            uv_by: self.by.first_two(k),
        }
    }
}

/// The limit surface around a point.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Around {
    pub(crate) position: [f32; 3],
    pub(crate) normal: [f32; 3],
    pub(crate) bend: normal::Bend,
    pub(crate) uv: [f32; 2],
    /// Derivatives of the texture coordinates by the first and by the second parameter.
    pub(crate) uv_by: [[f32; 2]; 2],
}

impl Around {
    /// The normal under a caller's rule, by differences along both parameters.
    fn of_rule(&self, rule: impl Fn(&DisplaceSite) -> [f32; 3]) -> [f32; 3] {
        let normals = self.bend.normals_of(self.normal);
        let tangent = |k: usize| {
            let d = [self.bend.du, self.bend.dv][k];
            // About a thousandth of a face.
            const STEP: f32 = 1.0 / 2048.0;
            let near = |t: f32| {
                let moved = |a: [f32; 3], b: [f32; 3]| math::add(a, math::scale(b, t));
                let normal = moved(self.normal, normals[k]);
                let [u, v] = self.uv_by[k];
                rule(&DisplaceSite {
                    position: moved(self.position, d),
                    normal: math::normalize(normal).unwrap_or(self.normal),
                    uv: [self.uv[0] + u * t, self.uv[1] + v * t],
                })
            };
            let change = math::sub(near(STEP), near(-STEP));
            math::add(d, math::scale(change, 0.5 / STEP))
        };
        normal::unit(tangent(0), tangent(1)).unwrap_or(self.normal)
    }
}
