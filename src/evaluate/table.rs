//! Interpolating surfaces, at dyadic places: see the section on them in the [module](super).

use super::{EvaluateError, Evaluated, Place, Sample};
use crate::control::Kind;
use crate::control::tables::{Found, STEPS, Walk};
use crate::surface::Surface;
use rayon::prelude::*;

/// Places that one thread evaluates at a time, at least.
const RUN: usize = 64;

/// Why a place has no point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Miss {
    /// It is not on the surface.
    Nowhere,
    /// It is between the places that are known.
    NotDyadic,
}

/// A place among the faces that are drawn.
#[derive(Clone, Copy, Debug)]
struct Spot {
    face: u32,
    at: [u32; 2],
    /// The face is one of the four quads of a quad of the cage: seen from this corner.
    turned: Option<usize>,
}

/// `x` in steps of the deepest level.
fn steps(x: f32) -> Result<u32, Miss> {
    let x = x * STEPS as f32;
    if x.fract() == 0.0 {
        Ok(x as u32)
    } else {
        Err(Miss::NotDyadic)
    }
}

fn locate(surface: &Surface, face: u32, u: f32, v: f32) -> Result<Spot, Miss> {
    let t = surface.topology();
    if face as usize >= t.face_count() {
        return Err(Miss::Nowhere);
    }
    let halves = t.face_halves(face);
    let n = halves.len();
    let wide = if n == 4 || n == 3 && surface.is_triangular() {
        1.0
    } else {
        n as f32
    };
    // What is not a number is in no range.
    if !((0.0..=wide).contains(&u) && (0.0..=1.0).contains(&v)) {
        return Err(Miss::Nowhere);
    }
    if surface.is_triangular() && f64::from(u) + f64::from(v) > 1.0 {
        return Err(Miss::Nowhere);
    }
    let [x, y] = [steps(u)?, steps(v)?];
    if !surface.is_split() {
        return Ok(Spot {
            face,
            at: [x, y],
            turned: None,
        });
    }
    if n == 4 {
        let half = STEPS / 2;
        let (corner, [s, t]) = match (x >= half, y >= half) {
            (false, false) => (0, [x, y]),
            (true, false) => (1, [y, STEPS - x]),
            (true, true) => (2, [STEPS - x, STEPS - y]),
            (false, true) => (3, [STEPS - y, x]),
        };
        return Ok(Spot {
            face: halves.start + corner as u32,
            at: [2 * s, 2 * t],
            turned: Some(corner),
        });
    }
    let k = (x / STEPS).min(n as u32 - 1);
    part(surface, face, k, [u - k as f32, v])
}

/// Whether there is something at a place.
pub(super) fn holds(surface: &Surface, face: u32, u: f32, v: f32) -> bool {
    locate(surface, face, u, v).is_ok()
}

fn narrow(p: [f64; 3]) -> [f32; 3] {
    p.map(|c| c as f32)
}

/// What was found as a sample, by the parameters of the face of the cage.
fn sample<S: Evaluated>(found: &Found, turned: Option<usize>) -> S {
    let (s, t) = (found.du, found.dv);
    let twice = |d: [f64; 3], sign: f64| d.map(|x| 2.0 * sign * x);
    let (du, dv) = match turned {
        None => (s, t),
        Some(0) => (twice(s, 1.0), twice(t, 1.0)),
        Some(1) => (twice(t, -1.0), twice(s, 1.0)),
        Some(2) => (twice(s, -1.0), twice(t, -1.0)),
        Some(_) => (twice(t, 1.0), twice(s, -1.0)),
    };
    S::of_sample(Sample {
        position: narrow(found.position),
        du: narrow(du),
        dv: narrow(dv),
        normal: narrow(found.normal),
        second: None,
    })
}

fn at<S: Evaluated>(walk: &mut Walk<'_>, spot: Spot) -> Option<S> {
    let found = walk.find(spot.face, spot.at, S::DERIVATIVES)?;
    Some(sample(&found, spot.turned))
}

/// [`Surface::evaluate_as`].
pub(super) fn evaluate<S: Evaluated>(surface: &Surface, face: u32, u: f32, v: f32) -> Option<S> {
    let mut walk = surface.walk(Kind::Points)?;
    at(&mut walk, locate(surface, face, u, v).ok()?)
}

/// [`Surface::evaluate_many`]; `out` is as long as `places`.
pub(super) fn evaluate_many<S: Evaluated>(
    surface: &Surface,
    places: &[Place],
    out: &mut [S],
) -> Result<(), EvaluateError> {
    if surface.walk(Kind::Points).is_none() {
        return Err(EvaluateError::Scheme);
    }
    let spots = places.par_iter().with_min_len(RUN);
    let spots: Vec<Result<Spot, Miss>> = spots.map(|p| locate(surface, p.face, p.u, p.v)).collect();
    let (mut order, mut missed) = (Vec::with_capacity(places.len()), None);
    for (index, spot) in spots.into_iter().enumerate() {
        match spot {
            // Close places have most of their way in common: order them as walks branch.
            Ok(spot) => order.push((spot.face, key(spot.at), index, spot)),
            Err(miss) => {
                missed = Some((index, miss));
                break;
            }
        }
    }
    match missed {
        Some((index, Miss::Nowhere)) => return Err(EvaluateError::NoSuchPlace { index }),
        Some((index, Miss::NotDyadic)) => return Err(EvaluateError::NotDyadic { index }),
        None => {}
    }
    order.par_sort_unstable_by_key(|&(face, key, index, _)| (face, key, index));
    let found: Vec<(usize, Option<S>)> = order
        .par_iter()
        .with_min_len(RUN)
        .map_init(
            || surface.walk(Kind::Points),
            |walk, &(_, _, index, spot)| {
                let sample = walk.as_mut().and_then(|walk| at(walk, spot));
                (index, sample)
            },
        )
        .collect();
    for (index, sample) in found {
        out[index] = sample.ok_or(EvaluateError::Scheme)?;
    }
    Ok(())
}

/// Bits of both numbers one after the other.
fn key([x, y]: [u32; 2]) -> u32 {
    (0..=STEPS.ilog2()).fold(0, |key, bit| {
        key | (x >> bit & 1) << (2 * bit) | (y >> bit & 1) << (2 * bit + 1)
    })
}

/// One face of an interpolating surface, kept for many places.
#[derive(Clone, Debug)]
pub(super) struct TableFace<'a> {
    surface: &'a Surface,
    pub(super) face: u32,
    points: Walk<'a>,
    uvs: Option<Walk<'a>>,
}

impl<'a> TableFace<'a> {
    /// Face `face` of the cage; `None` on other surfaces.
    pub(super) fn new(surface: &'a Surface, face: u32) -> Option<Self> {
        Some(Self {
            surface,
            face,
            points: surface.walk(Kind::Points)?,
            uvs: surface.walk(Kind::Uvs),
        })
    }

    pub(super) fn at<S: Evaluated>(&mut self, u: f32, v: f32) -> Option<S> {
        let spot = locate(self.surface, self.face, u, v).ok()?;
        at(&mut self.points, spot)
    }

    pub(super) fn uv(&mut self, u: f32, v: f32) -> Option<[f32; 2]> {
        let spot = locate(self.surface, self.face, u, v).ok()?;
        let found = self.uvs.as_mut()?.find(spot.face, spot.at, false)?;
        let [u, v, _] = narrow(found.position);
        Some([u, v])
    }

    /// Quads of the face that have a grid each.
    fn parts(&self) -> usize {
        match self.surface.topology().face_halves(self.face).len() {
            4 => 1,
            _ if self.surface.is_triangular() => 1,
            n => n,
        }
    }

    /// See [`FaceEvaluator::grid_len`](super::FaceEvaluator::grid_len).
    pub(super) fn grid_len(&self, n: u32) -> usize {
        let side = n as usize + 1;
        match self.surface.is_triangular() {
            true => side.saturating_mul(side + 1) / 2,
            false => side.saturating_mul(side).saturating_mul(self.parts()),
        }
    }

    /// See [`FaceEvaluator::grid`](super::FaceEvaluator::grid).
    pub(super) fn grid<S: Evaluated>(
        &mut self,
        n: u32,
        out: &mut [S],
    ) -> Result<(), EvaluateError> {
        let (got, wanted) = (out.len(), self.grid_len(n));
        if got != wanted || n == 0 {
            return Err(EvaluateError::WrongCount { got, wanted });
        }
        let quads = self.parts();
        let triangular = self.surface.is_triangular();
        let mut index = 0;
        for k in 0..quads {
            for j in 0..=n {
                for i in 0..=if triangular { n - j } else { n } {
                    let [u, v] = [i, j].map(|i| i as f32 / n as f32);
                    let spot = match quads {
                        1 => locate(self.surface, self.face, u, v),
                        // What ends one quad is no place of the next.
                        _ => part(self.surface, self.face, k as u32, [u, v]),
                    };
                    let sample = spot.ok().and_then(|spot| at(&mut self.points, spot));
                    out[index] = sample.ok_or(EvaluateError::NotDyadic { index })?;
                    index += 1;
                }
            }
        }
        Ok(())
    }
}

/// A place in quad `k` of a polygon.
fn part(surface: &Surface, face: u32, k: u32, [u, v]: [f32; 2]) -> Result<Spot, Miss> {
    Ok(Spot {
        face: surface.topology().face_halves(face).start + k,
        at: [steps(u)?, steps(v)?],
        turned: None,
    })
}
