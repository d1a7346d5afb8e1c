//! The limit surface at any parameter: [`Surface::evaluate`] for one point, [`FaceEvaluator`] for many on a face,
//! [`Surface::evaluate_many`] for many anywhere.
//!
//! # Parameters
//!
//! A place is a face of the cage and two numbers (u, v).
//!
//! * **Quads**: u and v from 0 to 1; corner 0 lies at (0, 0), corner 1 at (1, 0), corner 2 at (1, 1), corner 3 at (0, 1).
//! * **Polygons of n ≠ 4 corners**: u from 0 to n and v from 0 to 1. The polygon is n quads, one at each corner k, which has its own
//!   corner 0 there and its corner 2 in the middle of the polygon; u = k + s stands for (s, v) in that quad, so s runs along the
//!   polygon's side k as far as its middle, and v along side k − 1, backwards. u = n is the end of the last quad.
//! * **Triangles** under Loop's scheme and Modified Butterfly: barycentric coordinates; (1 − u − v, u, v) are the weights of corners 0, 1 and 2. u and v are not
//!   negative, and their sum as an `f32` is at most 1; where that is so only after rounding, the place is on the side.
//!
//! Derivatives are by these u and v.
//!
//! # Where derivatives do not exist
//!
//! At a vertex of another valence than 4 (on a boundary, of other than 2 faces), derivatives by u and v tend to nothing or to no end, and
//! second derivatives have no limit; among triangles these valences are 6 and 3. Right at such a corner, and nearer than 2⁻⁴⁰ to it, a
//! sample holds the limit point and the limit normal of the vertex, and as `du` and `dv` the tangents along the two sides of a quad with
//! lengths in the vertex' natural parameters: those of the flat star of equal sectors whose spokes come closest to the ring (after Stam,
//! *Exact evaluation of Catmull-Clark subdivision surfaces at arbitrary parameter values*, 1998; for triangles, *Evaluation of Loop
//! subdivision surfaces*). For an ordinary number of sectors that is the derivative itself. In a triangle the same two tangents make up
//! `du` and `dv`, as they do in the plane: at corner 1, `du` is the tangent towards corner 0 turned round. At corners that stay where they
//! are, of several faces (of triangles, of any number), `du` and `dv` are those of the control face. `second` is `None` at all of these.
//! Everywhere else, however close, derivatives are those of the surface.
//!
//! Creases that fade are followed until they have faded. Right at a vertex where a crease begins, fades or ends, position and normal are
//! the limit's, `du` and `dv` those of the deepest control level.
//! Close to the end of an infinitely sharp crease inside the surface the control levels go on for the place alone: right, but in
//! milliseconds.
//!
//! The first evaluation of a surface with such vertices makes its control levels for all faces, up to 16 MB of them. Where sharpness lasts
//! longer, the surroundings of the place go on alone, in about a millisecond; the last 32 such places are kept, so that places close to
//! each other come cheaper. The result does not depend on it. Other surfaces make nothing beforehand.
//!
//! # Interpolating surfaces
//!
//! Modified Butterfly and Kobbelt's scheme have no formula for a point anywhere; each step of theirs makes new points and keeps the old.
//! So these surfaces are known at **dyadic places to depth 10** alone: u and v are multiples of 2⁻¹⁰ = 1/1024. Elsewhere nothing is found,
//! and [`Surface::evaluate_many`] says [`EvaluateError::NotDyadic`]. Positions have the bits of whole-mesh refinement in double precision,
//! rounded once, whichever face they are asked of. There are no second derivatives: `second` is `None` everywhere.
//!
//! `du` and `dv` are the derivatives, by masks of the scheme, at all places but vertices of the cage. At those they are where the vertex
//! is regular (inside the surface 4 quads or 6 triangles, on a smooth border half as many); else they are the tangents along the two sides
//! with lengths in natural parameters: those of the flat star of n equal sectors (half of one at a border) for which the masks say the same.
//! (At corners 1 and 2 of a triangle the side between them runs along `dv` − `du`.) At corners that stay
//! where they are, and where creases end, each side has the derivative of its own row of points; inside a corner of several triangles that
//! is close to the surface's own, no more. Semi-sharp creases mean nothing to these schemes.
//!
//! A place is found by refining the surroundings of its face alone, down to a face that has it for a corner: in about a microsecond a step
//! amid regular vertices, in 50 to 100 beside an extraordinary one or a border; beside a vertex of hundreds of faces in milliseconds, by the
//! square of their number. [`FaceEvaluator`] keeps the steps, and [`Surface::evaluate_many`] sorts its places.

use crate::control::Kind;
use crate::dice::evaluate::QuadEvaluator;
use crate::dice::triangle::TriangleEvaluator;
use crate::surface::Surface;
use rayon::prelude::*;

mod batch;
mod channel;
mod face;
mod locate;
mod one_face;
mod patches;
mod sample;
mod table;
#[cfg(test)]
mod tests;

use batch::{Batch, CHUNK};
pub use channel::{ChannelKind, ChannelSurface};
pub use face::FaceEvaluator;
use locate::Source;
use patches::Patches;
use sample::sealed::Asked;
pub use sample::{Evaluated, Sample, SecondDerivatives, Tangents};

/// A face of the cage and a parameter on it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Place {
    /// Face of the cage.
    pub face: u32,
    /// First parameter.
    pub u: f32,
    /// Second parameter.
    pub v: f32,
}

/// Why a batch was not evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum EvaluateError {
    /// There is no such face, or the parameter is not on it.
    #[error("place {index} is not on the surface")]
    NoSuchPlace {
        /// The first such place.
        index: usize,
    },
    /// On an interpolating surface, the parameter is no multiple of 2⁻¹⁰.
    #[error("place {index} is not a multiple of 1/1024, and the surface is known at these alone")]
    NotDyadic {
        /// The first such place.
        index: usize,
    },
    /// The output does not hold as many samples as wanted.
    #[error("room for {got} samples, {wanted} wanted")]
    WrongCount {
        /// Length of the output.
        got: usize,
        /// Samples wanted.
        wanted: usize,
    },
    /// The surface has nothing to evaluate.
    #[error("surfaces of this scheme cannot be evaluated")]
    Scheme,
}

impl Surface {
    /// The limit surface at a place of face `face` of the cage (see the [module](crate::evaluate) for parameters): position, normal, first
    /// and second derivatives. `None` when there is no such face, or (`u`, `v`) is not on it; on interpolating surfaces also unless `u` and
    /// `v` are multiples of 1/1024. Holes have a surface too.
    ///
    /// ```
    /// # use earmark::{Cage, Surface};
    /// let corners = (0..9).flat_map(|q| [0, 1, 5, 4].map(|k| q / 3 * 4 + q % 3 + k)).collect();
    /// let points = (0..16).map(|k| [(k % 4) as f32, (k / 4) as f32, 0.0]).collect();
    /// let surface = Surface::new(Cage::new(points, &[4; 9], corners)?, &Default::default());
    /// let sample = surface.evaluate(4, 0.25, 0.5).unwrap();
    /// assert_eq!(sample.normal, [0.0, 0.0, 1.0]);
    /// assert!((sample.position[0] - 1.25).abs() < 1e-6 && (sample.du[0] - 1.0).abs() < 1e-6);
    /// # Ok::<(), earmark::mesh::CageError>(())
    /// ```
    #[must_use]
    pub fn evaluate(&self, face: u32, u: f32, v: f32) -> Option<Sample> {
        self.evaluate_as(face, u, v)
    }

    /// As [`Surface::evaluate`], with only as much as `S` holds: [`Sample`], [`Tangents`] or a position `[f32; 3]`.
    #[must_use]
    pub fn evaluate_as<S: Evaluated>(&self, face: u32, u: f32, v: f32) -> Option<S> {
        if self.scheme().is_interpolating() {
            table::evaluate(self, face, u, v)
        } else if self.is_triangular() {
            self.evaluate_one::<TriangleEvaluator, S>(face, u, v)
        } else {
            self.evaluate_one::<QuadEvaluator, S>(face, u, v)
        }
    }

    #[inline(always)]
    fn evaluate_one<P: Patches, S: Evaluated>(&self, face: u32, u: f32, v: f32) -> Option<S> {
        let local = P::locate(self, face, u, v)?;
        if self.is_plain()
            && let Some(channel) = P::channel(self, Kind::Points)
            && let Some(sample) = S::at_once::<P>(channel, local)
        {
            return Some(sample);
        }
        self.evaluate_at::<P, S>(local)
    }

    #[inline(never)]
    fn evaluate_at<P: Patches, S: Evaluated>(&self, local: locate::Local) -> Option<S> {
        let source = Source::<P>::new(self, Kind::Points)?;
        Some(source.patch(local, |channel, at, tip| {
            if !self.is_plain()
                && tip.is_none()
                && let Some(sample) = S::at_once::<P>(channel, at)
            {
                return sample;
            }
            P::with_own(|patches| {
                patches.prepare(channel, at.face);
                S::evaluate(Asked {
                    patches,
                    channel,
                    at,
                    tip,
                })
            })
        }))
    }

    /// Evaluates many places, on all threads where there are more than 65,536. Places on the same face are cheaper, wherever in the list they stand. The result does not
    /// depend on the number of threads, and is that of [`Surface::evaluate_as`].
    ///
    /// # Errors
    /// [`EvaluateError`] when `out` has another length than `places`, or a place is not on the surface; then nothing was written.
    pub fn evaluate_many<S: Evaluated>(
        &self,
        places: &[Place],
        out: &mut [S],
    ) -> Result<(), EvaluateError> {
        if places.len() != out.len() {
            return Err(EvaluateError::WrongCount {
                got: out.len(),
                wanted: places.len(),
            });
        }
        if self.scheme().is_interpolating() {
            table::evaluate_many(self, places, out)
        } else if self.is_triangular() {
            self.evaluate_all::<TriangleEvaluator, S>(places, out)
        } else {
            self.evaluate_all::<QuadEvaluator, S>(places, out)
        }
    }

    fn evaluate_all<P: Patches, S: Evaluated>(
        &self,
        places: &[Place],
        out: &mut [S],
    ) -> Result<(), EvaluateError>
    where
        for<'a> P::Channel<'a>: Sync,
    {
        let source = Source::<P>::new(self, Kind::Points).ok_or(EvaluateError::Scheme)?;
        if let Some(index) = places
            .par_iter()
            .with_min_len(CHUNK)
            .position_first(|p| P::locate(self, p.face, p.u, p.v).is_none())
        {
            return Err(EvaluateError::NoSuchPlace { index });
        }
        places
            .par_chunks(CHUNK)
            .zip(out.par_chunks_mut(CHUNK))
            .for_each_init(Batch::<P>::default, |batch, (places, out)| {
                batch.evaluate(self, &source, places, out);
            });
        Ok(())
    }
}
