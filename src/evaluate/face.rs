//! One face, kept for many places.

use super::one_face::OneFace;
use super::table::TableFace;
use super::{EvaluateError, Evaluated, Sample};
use crate::dice::evaluate::QuadEvaluator;
use crate::dice::triangle::TriangleEvaluator;
use crate::surface::Surface;

/// One face of the cage, prepared for evaluation: keeps its control points and pieces, and makes the latter when a place first needs them.
///
/// ```
/// # use earmark::{Cage, Surface};
/// # let corners = vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
/// # let points = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|b| 2.0 * b as f32 - 1.0)).collect();
/// # let cube = Surface::new(Cage::new(points, &[4; 6], corners)?, &Default::default());
/// let mut face = cube.face_evaluator(0).unwrap();
/// let middle = face.at(0.5, 0.5).unwrap();
/// assert!((middle.position[2] + 68.0 / 81.0).abs() < 1e-6);
/// # Ok::<(), earmark::mesh::CageError>(())
/// ```
#[derive(Clone, Debug)]
pub struct FaceEvaluator<'a>(Shape<'a>);

/// Neither is boxed: one step more to memory would show.
#[derive(Clone, Debug)]
enum Shape<'a> {
    Quads(OneFace<'a, QuadEvaluator>),
    Triangle(OneFace<'a, TriangleEvaluator>),
    Table(TableFace<'a>),
}

impl FaceEvaluator<'_> {
    /// The face.
    #[must_use]
    pub fn face(&self) -> u32 {
        match &self.0 {
            Shape::Quads(face) => face.face,
            Shape::Triangle(face) => face.face,
            Shape::Table(face) => face.face,
        }
    }

    /// The surface at (`u`, `v`), as [`Surface::evaluate`].
    #[inline]
    pub fn at(&mut self, u: f32, v: f32) -> Option<Sample> {
        self.at_as(u, v)
    }

    /// As [`FaceEvaluator::at`], with only as much as `S` holds.
    #[inline]
    pub fn at_as<S: Evaluated>(&mut self, u: f32, v: f32) -> Option<S> {
        match &mut self.0 {
            Shape::Quads(face) => face.at_as(u, v),
            Shape::Triangle(face) => face.at_as(u, v),
            Shape::Table(face) => face.at(u, v),
        }
    }

    /// Samples of a grid of `n` segments along each side: (n + 1)² of a quad, as many for each corner of another polygon, and
    /// (n + 1)(n + 2) / 2 of a triangle under Loop's scheme or Modified Butterfly.
    #[must_use]
    pub fn grid_len(&self, n: u32) -> usize {
        match &self.0 {
            Shape::Quads(face) => face.grid_len(n),
            Shape::Triangle(face) => face.grid_len(n),
            Shape::Table(face) => face.grid_len(n),
        }
    }

    /// Evaluates the grid u, v = 0, 1/n, … 1, row by row: u first, then the next v. A polygon of other than 4 corners has one grid per
    /// corner, one after the other. On triangles row j has v = j/n and ends on the side u + v = 1, at u = (n − j)/n; each row is
    /// one sample shorter than the one before.
    ///
    /// # Errors
    /// [`EvaluateError::WrongCount`] unless `n` is above 0 and `out` has [`FaceEvaluator::grid_len`] places; on interpolating surfaces
    /// [`EvaluateError::NotDyadic`] unless `n` is a power of two up to 1024.
    pub fn grid<S: Evaluated>(&mut self, n: u32, out: &mut [S]) -> Result<(), EvaluateError> {
        match &mut self.0 {
            Shape::Quads(face) => face.grid(n, out),
            Shape::Triangle(face) => face.grid(n, out),
            Shape::Table(face) => face.grid(n, out),
        }
    }

    /// Texture coordinates at (`u`, `v`). `None` when the surface has none, or (`u`, `v`) is no place that [`Surface::evaluate`] finds.
    pub fn uv(&mut self, u: f32, v: f32) -> Option<[f32; 2]> {
        match &mut self.0 {
            Shape::Quads(face) => face.uv(u, v),
            Shape::Triangle(face) => face.uv(u, v),
            Shape::Table(face) => face.uv(u, v),
        }
    }
}

impl Surface {
    /// An evaluator of face `face` of the cage, which keeps what several places have in common. `None` when there is no such face.
    #[must_use]
    pub fn face_evaluator(&self, face: u32) -> Option<FaceEvaluator<'_>> {
        if face as usize >= self.topology().face_count() {
            return None;
        }
        if let Some(table) = TableFace::new(self, face) {
            return Some(FaceEvaluator(Shape::Table(table)));
        }
        Some(FaceEvaluator(if self.is_triangular() {
            Shape::Triangle(OneFace::new(self, face, face)?)
        } else {
            let first = match self.is_split() {
                true => self.topology().face_halves(face).start,
                false => face,
            };
            Shape::Quads(OneFace::new(self, face, first)?)
        }))
    }
}
