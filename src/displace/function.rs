//! Procedural functions by name and parameters, as the command line has them: `fbm:frequency=3,octaves=5`.

use super::noise::{self, Slope};
use crate::dispatch;
use crate::records::Grid3;
use crate::simd::Level;

/// What a [`Function`] computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Shape {
    /// Gradient noise.
    Perlin,
    /// Octaves of noise, each of a higher frequency and weaker.
    Fbm,
    /// Octaves of sharp ridges: `1 − |noise|`, squared.
    Ridged,
    /// Round waves about a centre.
    Ripples,
}

impl Shape {
    /// All shapes with their names.
    pub const ALL: [(&'static str, Self); 4] = [
        ("perlin", Self::Perlin),
        ("fbm", Self::Fbm),
        ("ridged", Self::Ridged),
        ("ripples", Self::Ripples),
    ];
}

/// A height at every point in space, from about −1 to 1. The same numbers on every machine.
///
/// ```
/// use earmark::displace::Function;
///
/// let function: Function = "fbm:frequency=3,octaves=5,gain=0.5".parse()?;
/// assert_eq!(function.octaves, 5);
/// assert!(function.at([0.1, 0.2, 0.3]).abs() < 1.0);
/// assert!("fbm:octaves=99".parse::<Function>().is_err());
/// # Ok::<(), earmark::displace::FunctionError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Function {
    /// What is computed.
    pub shape: Shape,
    /// Features per model unit; noise has its lattice points this dense, ripples so many waves.
    pub frequency: f32,
    /// Number of octaves, 1 to 16; of `fbm` and `ridged` alone.
    pub octaves: u32,
    /// Frequency of an octave over that of the one before.
    pub lacunarity: f32,
    /// Strength of an octave over that of the one before, 0 to 1.
    pub gain: f32,
    /// Another seed is another noise.
    pub seed: u32,
    /// Time: a step of 1 is all new noise, or one wave further out.
    pub time: f32,
    /// Centre of ripples, model units.
    pub center: [f32; 3],
}

/// Why a text names no function.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FunctionError {
    /// The name is none of them.
    #[error("no function {0:?}: perlin, fbm, ridged, ripples")]
    Name(String),
    /// A parameter without `=`, or of another name.
    #[error("no parameter {0:?}: frequency, scale, octaves, lacunarity, gain, seed, t, x, y, z")]
    Parameter(String),
    /// A value that is no number, or out of its range.
    #[error("{name}={value}: {wanted}")]
    Value {
        /// The parameter.
        name: String,
        /// What was given.
        value: String,
        /// What is wanted.
        wanted: &'static str,
    },
}

/// Most octaves: with the usual lacunarity of 2 the last is 32,768 times as fine as the first.
const MAX_OCTAVES: u32 = 16;

impl Function {
    /// A function with the default parameters.
    #[must_use]
    pub fn new(shape: Shape) -> Self {
        Self {
            shape,
            frequency: 1.0,
            octaves: 5,
            lacunarity: 2.0,
            gain: 0.5,
            seed: 0,
            time: 0.0,
            center: [0.0; 3],
        }
    }

    /// The height at a point.
    #[must_use]
    pub fn at(&self, p: [f32; 3]) -> f32 {
        self.slope(p)[0]
    }

    /// Height and gradient at a point.
    #[inline(always)]
    pub(crate) fn slope(&self, p: [f32; 3]) -> Slope {
        match self.shape {
            Shape::Perlin => self.octave(p, self.frequency, self.seed),
            Shape::Fbm => self.sum(p, |n| n),
            Shape::Ridged => self.sum(p, ridge),
            Shape::Ripples => self.ripples(p),
        }
    }

    #[inline(always)]
    fn octave(&self, p: [f32; 3], frequency: f32, seed: u32) -> Slope {
        let at = [p[0] * frequency, p[1] * frequency, p[2] * frequency];
        let n = match self.time == 0.0 {
            true => noise::perlin(at, seed),
            false => noise::moving(at, self.time, seed),
        };
        [n[0], n[1] * frequency, n[2] * frequency, n[3] * frequency]
    }

    /// Octaves, weighed so that their weights sum to 1.
    #[inline(always)]
    fn sum(&self, p: [f32; 3], shape: impl Fn(Slope) -> Slope) -> Slope {
        let (mut frequency, mut weight) = (self.frequency, 1.0 / self.weights());
        let mut out = [0.0; 4];
        for k in 0..self.octaves {
            let n = shape(self.octave(p, frequency, self.seed.wrapping_add(k)));
            for (out, n) in out.iter_mut().zip(n) {
                *out += n * weight;
            }
            frequency *= self.lacunarity;
            weight *= self.gain;
        }
        out
    }

    fn weights(&self) -> f32 {
        (1..self.octaves)
            .fold((1.0, 1.0), |(sum, w): (f32, f32), _| {
                (sum + w * self.gain, w * self.gain)
            })
            .0
    }

    /// Waves `cos(2π (frequency · r − time))`; close to the centre r is rounded off, so that there is no tip.
    fn ripples(&self, p: [f32; 3]) -> Slope {
        let d = [0, 1, 2].map(|k| p[k] - self.center[k]);
        let soft = 0.25 / self.frequency;
        let r = (((d[0] * d[0] + d[1] * d[1]) + d[2] * d[2]) + soft * soft).sqrt();
        if !r.is_finite() {
            return [0.0; 4];
        }
        const TURN: f32 = std::f32::consts::TAU;
        let phase = self.frequency * r - self.time;
        let (sin, cos) = libm::sincosf(TURN * (phase - phase.floor()));
        let slope = -sin * TURN * self.frequency / r;
        [cos, slope * d[0], slope * d[1], slope * d[2]]
    }

    /// Bound of the magnitude.
    pub(crate) fn most(&self) -> f32 {
        let still = if self.time == 0.0 { 1.0 } else { noise::MOVING };
        match self.shape {
            Shape::Ripples => 1.0,
            Shape::Perlin | Shape::Fbm => noise::MOST * still,
            // 2 (1 − |n|)² − 1 with |n| up to the bound.
            Shape::Ridged => 1.0,
        }
    }

    /// Frequency and weight of every octave that there is.
    pub(crate) fn octaves(&self) -> impl Iterator<Item = [f32; 2]> + use<> {
        let function = *self;
        let count = match self.shape {
            Shape::Perlin | Shape::Ripples => 1,
            _ => self.octaves,
        };
        let first = if count == 1 {
            1.0
        } else {
            1.0 / self.weights()
        };
        (0..count).scan([self.frequency, first], move |state, _| {
            let now = *state;
            *state = [now[0] * function.lacunarity, now[1] * function.gain];
            Some(now)
        })
    }

    /// Heights, and gradients if wanted, of the first `heights.len()` points of the component arrays.
    pub(crate) fn all(
        &self,
        simd: Level,
        points: &Grid3,
        heights: &mut [f32],
        mut slopes: Option<&mut Grid3>,
    ) {
        for first in (0..heights.len()).step_by(CHUNK) {
            let part = first..(first + CHUNK).min(heights.len());
            let at = Places {
                x: &points.x[part.clone()],
                y: &points.y[part.clone()],
                z: &points.z[part.clone()],
            };
            let heights = &mut heights[part.clone()];
            match slopes.as_deref_mut() {
                Some(s) => {
                    let out = Slopes {
                        h: heights,
                        x: &mut s.x[part.clone()],
                        y: &mut s.y[part.clone()],
                        z: &mut s.z[part],
                    };
                    dispatch!(simd, self.slopes(at, out));
                }
                None => dispatch!(simd, self.values(at, heights)),
            }
        }
    }

    /// Number of octaves that are summed up, and the weight of the first.
    fn sums(&self) -> (u32, f32) {
        match self.shape {
            Shape::Perlin | Shape::Ripples => (1, 1.0),
            Shape::Fbm | Shape::Ridged => (self.octaves, 1.0 / self.weights()),
        }
    }

    /// Heights alone: those of [`Function::slopes`], bit for bit.
    #[inline(always)]
    fn values(&self, at: Places<'_>, heights: &mut [f32]) {
        if self.shape == Shape::Ripples || self.time != 0.0 {
            for (i, h) in heights.iter_mut().enumerate() {
                *h = self.slope([at.x[i], at.y[i], at.z[i]])[0];
            }
            return;
        }
        let (mut frequency, (count, mut weight)) = (self.frequency, self.sums());
        heights.fill(0.0);
        for k in 0..count {
            let seed = self.seed.wrapping_add(k);
            match self.shape {
                Shape::Ridged => add_values::<true>(at, frequency, seed, weight, heights),
                _ => add_values::<false>(at, frequency, seed, weight, heights),
            }
            frequency *= self.lacunarity;
            weight *= self.gain;
        }
    }

    /// Heights and gradients: octave by octave, each with the points in lanes, by the sums of [`Function::slope`].
    #[inline(always)]
    fn slopes(&self, at: Places<'_>, out: Slopes<'_>) {
        let Slopes { h, x, y, z } = out;
        if self.shape == Shape::Ripples || self.time != 0.0 {
            for i in 0..h.len() {
                [h[i], x[i], y[i], z[i]] = self.slope([at.x[i], at.y[i], at.z[i]]);
            }
            return;
        }
        let (mut frequency, (count, mut weight)) = (self.frequency, self.sums());
        h.fill(0.0);
        x.fill(0.0);
        y.fill(0.0);
        z.fill(0.0);
        for k in 0..count {
            let seed = self.seed.wrapping_add(k);
            match self.shape {
                Shape::Ridged => add_slopes::<true>(at, frequency, seed, weight, h, x, y, z),
                _ => add_slopes::<false>(at, frequency, seed, weight, h, x, y, z),
            }
            frequency *= self.lacunarity;
            weight *= self.gain;
        }
    }
}

/// Points whose octaves are summed up together: few enough to stay in the cache next to the processor.
const CHUNK: usize = 256;

/// Points, component by component.
#[derive(Clone, Copy)]
struct Places<'a> {
    x: &'a [f32],
    y: &'a [f32],
    z: &'a [f32],
}

/// Heights and their gradients.
struct Slopes<'a> {
    h: &'a mut [f32],
    x: &'a mut [f32],
    y: &'a mut [f32],
    z: &'a mut [f32],
}

/// Adds an octave of noise, or of ridges.
#[inline(always)]
fn add_values<const RIDGED: bool>(
    at: Places<'_>,
    frequency: f32,
    seed: u32,
    weight: f32,
    out: &mut [f32],
) {
    let n = out.len();
    let (x, y, z) = (&at.x[..n], &at.y[..n], &at.z[..n]);
    for i in 0..n {
        let at = [x[i] * frequency, y[i] * frequency, z[i] * frequency];
        let n = noise::perlin_value(at, seed);
        let n = if RIDGED {
            ridge([n, 0.0, 0.0, 0.0])[0]
        } else {
            n
        };
        out[i] += n * weight;
    }
}

/// The same with gradients.
#[inline(always)]
#[expect(
    clippy::too_many_arguments,
    reason = "outputs that cannot overlap, as the compiler is to know"
)]
fn add_slopes<const RIDGED: bool>(
    at: Places<'_>,
    frequency: f32,
    seed: u32,
    weight: f32,
    h: &mut [f32],
    sx: &mut [f32],
    sy: &mut [f32],
    sz: &mut [f32],
) {
    let n = h.len();
    let (x, y, z) = (&at.x[..n], &at.y[..n], &at.z[..n]);
    let (sx, sy, sz) = (&mut sx[..n], &mut sy[..n], &mut sz[..n]);
    for i in 0..n {
        let at = [x[i] * frequency, y[i] * frequency, z[i] * frequency];
        let n = noise::perlin(at, seed);
        let n = [n[0], n[1] * frequency, n[2] * frequency, n[3] * frequency];
        let n = if RIDGED { ridge(n) } else { n };
        h[i] += n[0] * weight;
        sx[i] += n[1] * weight;
        sy[i] += n[2] * weight;
        sz[i] += n[3] * weight;
    }
}

/// A ridge where noise is 0: from 1 there down to −1.
#[inline(always)]
fn ridge(n: Slope) -> Slope {
    let sign = if n[0] < 0.0 { -1.0 } else { 1.0 };
    let rest = (1.0 - n[0] * sign).max(0.0);
    let slope = -4.0 * rest * sign;
    [
        2.0 * rest * rest - 1.0,
        slope * n[1],
        slope * n[2],
        slope * n[3],
    ]
}

impl std::str::FromStr for Function {
    type Err = FunctionError;

    fn from_str(text: &str) -> Result<Self, FunctionError> {
        let (name, parameters) = match text.split_once(':') {
            Some((name, parameters)) => (name, Some(parameters)),
            None => (text, None),
        };
        let shape = (Shape::ALL.iter().find(|s| s.0 == name))
            .ok_or_else(|| FunctionError::Name(name.to_owned()))?
            .1;
        let mut function = Self::new(shape);
        for part in parameters.into_iter().flat_map(|p| p.split(',')) {
            let (name, value) =
                (part.split_once('=')).ok_or_else(|| FunctionError::Parameter(part.to_owned()))?;
            function.set(name.trim(), value.trim())?;
        }
        Ok(function)
    }
}

impl Function {
    fn set(&mut self, name: &str, value: &str) -> Result<(), FunctionError> {
        let wrong = |wanted: &'static str| FunctionError::Value {
            name: name.to_owned(),
            value: value.to_owned(),
            wanted,
        };
        let number = |low: f32, high: f32, wanted: &'static str| match value.parse::<f32>() {
            Ok(x) if (low..=high).contains(&x) => Ok(x),
            _ => Err(wrong(wanted)),
        };
        const SIZE: &str = "a number from 1e-6 to 1e6 is wanted";
        const PLACE: &str = "a number from -1e6 to 1e6 is wanted";
        match name {
            "frequency" => self.frequency = number(1e-6, 1e6, SIZE)?,
            "scale" => self.frequency = 1.0 / number(1e-6, 1e6, SIZE)?,
            "octaves" => {
                self.octaves = (value.parse().ok())
                    .filter(|n| (1..=MAX_OCTAVES).contains(n))
                    .ok_or_else(|| wrong("a whole number from 1 to 16 is wanted"))?;
            }
            "lacunarity" => self.lacunarity = number(1.0, 16.0, "a number from 1 to 16 is wanted")?,
            "gain" => self.gain = number(0.0, 1.0, "a number from 0 to 1 is wanted")?,
            "seed" => {
                self.seed = (value.parse().ok())
                    .ok_or_else(|| wrong("a whole number from 0 to 4294967295 is wanted"))?;
            }
            "t" => self.time = number(-1e6, 1e6, PLACE)?,
            "x" | "y" | "z" => {
                let axis = usize::from(name.as_bytes()[0] - b'x');
                self.center[axis] = number(-1e6, 1e6, PLACE)?;
            }
            _ => return Err(FunctionError::Parameter(name.to_owned())),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_read_or_refused() {
        let f: Function = "ridged:scale=0.5,octaves=3,lacunarity=2.5,gain=0.4,seed=9,t=1.5"
            .parse()
            .unwrap();
        assert_eq!((f.shape, f.frequency, f.octaves), (Shape::Ridged, 2.0, 3));
        assert_eq!((f.lacunarity, f.gain, f.seed, f.time), (2.5, 0.4, 9, 1.5));
        let f: Function = "ripples:x=1,y=-2,z=3".parse().unwrap();
        assert_eq!(f.center, [1.0, -2.0, 3.0]);
        for bad in [
            "",
            "noise",
            "perlin:",
            "perlin:frequency",
            "perlin:frequency=",
            "perlin:frequency=0",
            "perlin:frequency=nan",
            "perlin:frequency=inf",
            "fbm:octaves=0",
            "fbm:octaves=17",
            "fbm:octaves=1.5",
            "fbm:gain=2",
            "fbm:gain=-1",
            "fbm:lacunarity=0.5",
            "fbm:seed=-1",
            "fbm:t=1e9",
            "fbm:q=1",
            "fbm:frequency=1,",
            "Fbm",
        ] {
            assert!(bad.parse::<Function>().is_err(), "{bad}");
        }
    }

    #[test]
    fn rows_and_points_have_the_same_bits_with_and_without_gradients() {
        // More than a chunk, and no whole number of vectors.
        const COUNT: usize = CHUNK + 37;
        let mut points = Grid3::boxed();
        for k in 0..COUNT {
            points.put(
                k,
                [0.371, 0.719, 0.131].map(|s| (s * k as f32).fract() * 8.0 - 4.0),
            );
        }
        for text in [
            "perlin",
            "fbm:frequency=3",
            "ridged:octaves=4",
            "ripples",
            "fbm:t=0.4",
        ] {
            let f: Function = text.parse().unwrap();
            for simd in Level::available() {
                let (mut alone, mut both) = (vec![0.0; COUNT], vec![0.0; COUNT]);
                let mut slopes = Grid3::boxed();
                f.all(simd, &points, &mut alone, None);
                f.all(simd, &points, &mut both, Some(&mut slopes));
                for k in 0..COUNT {
                    let [h, x, y, z] = f.slope(points.at(k));
                    assert_eq!(alone[k].to_bits(), both[k].to_bits(), "{text}");
                    assert_eq!((h, [x, y, z]), (both[k], slopes.at(k)), "{text}");
                }
            }
        }
    }

    #[test]
    fn gradients_are_differences_and_values_are_bounded() {
        for text in [
            "perlin:frequency=2",
            "fbm:frequency=1.5,t=0.3",
            "ridged:octaves=2",
            "ripples:frequency=2,t=0.2,x=0.3",
        ] {
            let f: Function = text.parse().unwrap();
            let mut off = 0;
            for i in 0..2000_i32 {
                // Keep off the lattice, where noise is 0.
                let p =
                    [0.371_73, 0.719_31, 0.131_97].map(|k: f32| (k * i as f32).fract() * 4.0 - 2.0);
                let slope = f.slope(p);
                assert!(slope[0].abs() <= f.most(), "{text} {p:?} {slope:?}");
                for k in 0..3 {
                    let step = 1.0 / 4096.0;
                    let (mut a, mut b) = (p, p);
                    a[k] -= step;
                    b[k] += step;
                    let found = (f.at(b) - f.at(a)) / (2.0 * step);
                    let close = (found - slope[1 + k]).abs() < 0.02 * (1.0 + slope[1 + k].abs());
                    // On a ridge there is no gradient.
                    off += i32::from(!close);
                    assert!(
                        close || f.shape == Shape::Ridged,
                        "{text} {p:?}: {found} {slope:?}"
                    );
                }
            }
            assert!(off < 30, "{text}: {off}");
        }
    }
}
