//! Displacement: the limit surface moved along its normals by a map, a function of space, or the caller's own rule.
//!
//! What is diced is displaced ([`Surface::set_displacement`](crate::Surface::set_displacement)), so everything after dicing sees the
//! displaced surface: adaptive tessellation, hulls, bins, drawing, and export. A point moves by `scale · value + bias` model units.
//!
//! # One owner
//!
//! A point on an edge or at a corner of the cage belongs to several faces, and may have several texture coordinates (at seams) and several
//! normals (at creases). It still moves once:
//!
//! * **Texture coordinates**, and with them the height, are those of the edge's first half-edge; at a corner, of the first half-edge
//!   around the vertex. Seams do not open, whatever the map holds on their two sides.
//! * **Direction**: the normal of what is drawn, the limit surface or its patches; at infinite creases the mitre of the normals of all sides,
//!   the vector m with `m · n = 1` for every one of two normals n (no longer than 2), so that a constant height keeps flat sides flat and
//!   creases where their offsets meet.
//! * **Normal**: from the derivatives of the owner's face, and so the same from all faces of a smooth edge. Each side of a crease has its own.
//! * Where more than two faces share an edge, and at vertices where the surface hangs together by a point, nothing moves.

mod bounds;
mod function;
mod limit;
mod map;
mod noise;
pub(crate) mod normal;

use crate::dispatch;
use crate::math;
use crate::records::{BLOCK_LEN, Grid3};
use crate::simd::{LANES, Level};
use std::fmt;
use std::sync::Arc;

pub use function::{Function, FunctionError, Shape};
pub(crate) use limit::{Around, Jets, Limit};
pub use map::{HeightMap, MapError};

/// A point that is about to be displaced.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DisplaceSite {
    /// Limit point, model space.
    pub position: [f32; 3],
    /// Unit limit normal; at creases the direction between the normals of their sides.
    pub normal: [f32; 3],
    /// Texture coordinates; zeros without.
    pub uv: [f32; 2],
}

/// A caller's rule: the vector by which a point moves, model units.
type Rule = dyn Fn(&DisplaceSite) -> [f32; 3] + Send + Sync;

/// Where heights come from.
#[derive(Clone)]
enum Kind {
    Map(Arc<HeightMap>),
    Function(Function),
    Vector { rule: Arc<Rule>, most: f32 },
}

/// Where heights come from, but for a caller's rule.
#[cfg(feature = "gpu")]
pub(crate) enum Source<'a> {
    Map(&'a HeightMap),
    Function(&'a Function),
}

/// How a surface is displaced.
///
/// ```
/// use earmark::{Cage, Surface, displace::{Displacement, Function}};
///
/// let points = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|b| 2.0 * b as f32 - 1.0)).collect();
/// let corners = vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
/// let mut surface = Surface::new(Cage::new(points, &[4; 6], corners)?, &Default::default());
/// let before = surface.dice(0, 3);
/// let noise: Function = "perlin:frequency=2".parse()?;
/// surface.set_displacement(Some(Displacement::function(noise).scaled(0.1)));
/// assert_ne!(surface.dice(0, 3).points, before.points);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Displacement {
    kind: Kind,
    /// Model units per unit of the map or function; not of vectors.
    pub scale: f32,
    /// Model units that are added; not of vectors.
    pub bias: f32,
    /// Whether pictures take the slopes of a map pixel by pixel, with the triangles only carrying the heights: then what a picture shows hardly
    /// depends on how fine they are. Of maps alone.
    pub per_pixel: bool,
}

impl fmt::Debug for Displacement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = match &self.kind {
            Kind::Map(map) => format!("map {:?}", map.size()),
            Kind::Function(function) => format!("{function:?}"),
            Kind::Vector { most, .. } => format!("vectors up to {most}"),
        };
        write!(
            f,
            "Displacement({kind}, scale {}, bias {})",
            self.scale, self.bias
        )
    }
}

impl Displacement {
    /// By the heights of a map at the texture coordinates.
    #[must_use]
    pub fn map(map: Arc<HeightMap>) -> Self {
        Self::of(Kind::Map(map))
    }

    /// By a function of the limit point.
    #[must_use]
    pub fn function(function: Function) -> Self {
        Self::of(Kind::Function(function))
    }

    /// By vectors that `rule` says; longer ones are shortened to `most` model units, and what is not finite does not move. The rule must
    /// depend on its argument alone, and is asked from many threads. Normals come from differences of the rule.
    #[must_use]
    pub fn vector(
        most: f32,
        rule: impl Fn(&DisplaceSite) -> [f32; 3] + Send + Sync + 'static,
    ) -> Self {
        Self::of(Kind::Vector {
            rule: Arc::new(rule),
            most: if most.is_finite() { most.abs() } else { 0.0 },
        })
    }

    fn of(kind: Kind) -> Self {
        Self {
            kind,
            scale: 1.0,
            bias: 0.0,
            per_pixel: false,
        }
    }

    /// The same with another scale; one that is not finite is 0.
    #[must_use]
    pub fn scaled(mut self, scale: f32) -> Self {
        self.scale = if scale.is_finite() { scale } else { 0.0 };
        self
    }

    /// The same with another bias; one that is not finite is 0.
    #[must_use]
    pub fn biased(mut self, bias: f32) -> Self {
        self.bias = if bias.is_finite() { bias } else { 0.0 };
        self
    }

    /// The same with slopes taken pixel by pixel, or not.
    #[must_use]
    pub fn with_slopes_per_pixel(mut self, on: bool) -> Self {
        self.per_pixel = on;
        self
    }

    /// Where heights come from; none of a caller's rule.
    #[cfg(feature = "gpu")]
    pub(crate) fn source(&self) -> Option<Source<'_>> {
        match &self.kind {
            Kind::Map(map) => Some(Source::Map(map)),
            Kind::Function(function) => Some(Source::Function(function)),
            Kind::Vector { .. } => None,
        }
    }

    /// The map, if its slopes are taken pixel by pixel.
    pub(crate) fn pixel_map(&self) -> Option<&HeightMap> {
        match &self.kind {
            Kind::Map(map) if self.per_pixel => Some(map),
            _ => None,
        }
    }

    /// The same for points that are relative to `origin`, as those of a cage far from 0 are: ripples keep their centre. (Noise is that of
    /// the relative points.)
    #[must_use]
    pub fn relative_to(mut self, origin: [f64; 3]) -> Self {
        if let Kind::Function(function) = &mut self.kind {
            let center = function.center;
            function.center = [0, 1, 2].map(|k| (f64::from(center[k]) - origin[k]) as f32);
        }
        self
    }

    /// Whether it reads texture coordinates.
    #[must_use]
    pub fn needs_uvs(&self) -> bool {
        matches!(self.kind, Kind::Map(_))
    }

    /// Whether texture coordinates change what it does.
    pub(crate) fn reads_uvs(&self) -> bool {
        !matches!(self.kind, Kind::Function(_))
    }

    /// Bound of how far a point moves, in model units; twice as far at creases.
    #[must_use]
    pub fn most(&self) -> f32 {
        let most = match &self.kind {
            Kind::Map(map) => map
                .range()
                .map(|h| self.height(h).abs())
                .into_iter()
                .fold(0.0, f32::max),
            Kind::Function(function) => {
                let most = function.most();
                self.height(most).abs().max(self.height(-most).abs())
            }
            Kind::Vector { most, .. } => *most,
        };
        // Sums are rounded.
        (most * 1.0001).min(f32::MAX)
    }

    #[inline(always)]
    fn height(&self, value: f32) -> f32 {
        value * self.scale + self.bias
    }

    /// Vector of a caller's rule, as it is allowed.
    fn vector_at(rule: &Rule, most: f32, site: &DisplaceSite) -> [f32; 3] {
        let d = rule(site);
        let square = math::dot(d, d);
        if square <= most * most {
            d
        } else if square.is_finite() {
            math::scale(d, most / square.sqrt())
        } else {
            [0.0; 3]
        }
    }

    /// Bounds of the heights where texture coordinates are within bounds; none of a caller's rule.
    pub(crate) fn heights_in(&self, [low, high]: [[f32; 2]; 2]) -> Option<[f32; 2]> {
        let values = match &self.kind {
            Kind::Map(map) => map.range_in(low, high),
            Kind::Function(function) => [-function.most(), function.most()],
            Kind::Vector { .. } => return None,
        };
        let [a, b] = values.map(|x| self.height(x));
        Some([a.min(b), a.max(b)])
    }

    /// Displaces the first `count` points of the component arrays. `directions` are those along which points move: unit normals but at creases.
    /// Leaves what normals need in `heights`.
    pub(crate) fn all(
        &self,
        (simd, count): (Level, usize),
        points: &mut Grid3,
        directions: &Grid3,
        uvs: &Grid3,
        wants_slopes: bool,
        heights: &mut Heights,
    ) {
        let Heights { values, slopes } = heights;
        // Whole vectors; what is beyond the points means nothing.
        let values = &mut values[..padded(count)];
        let slopes = wants_slopes.then_some(&mut **slopes);
        match &self.kind {
            Kind::Function(function) => function.all(simd, points, values, slopes),
            Kind::Map(map) => dispatch!(simd, map.all(uvs, values, slopes)),
            Kind::Vector { rule, most } => {
                for k in 0..count {
                    let site = DisplaceSite {
                        position: points.at(k),
                        normal: directions.at(k),
                        uv: [uvs.x[k], uvs.y[k]],
                    };
                    let d = match site.normal == [0.0; 3] {
                        true => [0.0; 3],
                        false => Self::vector_at(&**rule, *most, &site),
                    };
                    points.put(k, math::add(site.position, d));
                }
                return;
            }
        }
        dispatch!(simd, self.lift(points, directions, values));
    }

    /// Makes heights of values, and moves points along their directions.
    #[inline(always)]
    fn lift(&self, points: &mut Grid3, directions: &Grid3, values: &mut [f32]) {
        let n = values.len();
        for h in values.iter_mut() {
            *h = self.height(*h);
        }
        let lines = [
            (&mut points.x, &directions.x),
            (&mut points.y, &directions.y),
            (&mut points.z, &directions.z),
        ];
        for (p, d) in lines {
            let (p, d) = (&mut p[..n], &d[..n]);
            for i in 0..n {
                p[i] += d[i] * values[i];
            }
        }
    }
}

/// Places of whole vectors that hold `count` points.
fn padded(count: usize) -> usize {
    count.next_multiple_of(LANES).min(BLOCK_LEN)
}

/// Heights of a block in model units, and slopes of what they come from: by x, y and z of a function, by u and v of a map.
#[derive(Clone, Debug)]
pub(crate) struct Heights {
    pub(crate) values: Box<[f32; BLOCK_LEN]>,
    pub(crate) slopes: Box<Grid3>,
}

impl Default for Heights {
    fn default() -> Self {
        Self {
            values: Box::new([0.0; BLOCK_LEN]),
            slopes: Grid3::boxed(),
        }
    }
}

/// The direction in which a point with several normals moves: along their mean, so far that on average it moves by 1 along each.
pub(crate) fn mitre(normals: &[[f32; 3]]) -> [f32; 3] {
    /// Longest mitre: sides that meet at less than 60 degrees get no longer tip.
    const LONGEST: f32 = 2.0;
    let sum = normals.iter().fold([0.0; 3], |sum, &n| math::add(sum, n));
    let (count, square) = (normals.len() as f32, math::dot(sum, sum));
    if square < 1e-6 {
        return normals.first().copied().unwrap_or_default();
    }
    math::scale(sum, (count / square).min(LONGEST / square.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mitres_reach_where_offsets_meet() {
        let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        assert_eq!(mitre(&[x, y]), [1.0, 1.0, 0.0]);
        assert_eq!(mitre(&[x, y, z]), [1.0; 3]);
        assert_eq!(mitre(&[z]), z);
        assert_eq!(mitre(&[x, [-1.0, 0.0, 0.0]]), x);
        let sharp = mitre(&[x, math::normalize([-1.0, 0.1, 0.0]).unwrap_or_default()]);
        assert!((math::length(sharp) - 2.0).abs() < 1e-5);
    }

    #[test]
    fn bounds_hold() {
        let map = Arc::new(HeightMap::new(2, 1, vec![0.25, 0.75]).unwrap());
        let d = Displacement::map(map).scaled(-2.0).biased(1.0);
        assert!((d.most() - 0.5).abs() < 1e-3);
        let d = Displacement::vector(0.5, |_| [f32::NAN, 3.0, 0.0]);
        let Kind::Vector { rule, most } = &d.kind else {
            return;
        };
        assert_eq!(
            Displacement::vector_at(&**rule, *most, &DisplaceSite::default()),
            [0.0; 3]
        );
        assert_eq!(
            Displacement::vector_at(&|_| [3.0, 4.0, 0.0], 0.5, &DisplaceSite::default()),
            [0.3, 0.4, 0.0]
        );
    }
}
