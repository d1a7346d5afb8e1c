//! One face, kept for many places.

use super::locate::{Local, Source, child, is_unit};
use super::sample::sealed::{Asked, Kind as _};
use super::table::TableFace;
use super::{EvaluateError, Evaluated, Sample};
use crate::control::Kind;
use crate::dice::evaluate::QuadEvaluator;
use crate::dice::face::Channel;
use crate::surface::Surface;
use std::collections::BTreeMap;

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
#[repr(C)]
pub struct FaceEvaluator<'a> {
    /// Whether the first quad is the face, and a patch.
    whole: bool,
    first: u32,
    quad: QuadEvaluator,
    face: u32,
    surface: &'a Surface,
    source: Source<'a>,
    /// Further quads of a face that is split, and patches of deeper control levels, by depth and number.
    others: BTreeMap<(u32, u32), Box<QuadEvaluator>>,
    uv: Option<Box<Uvs<'a>>>,
    /// Of an interpolating surface, in place of all else.
    table: Option<Box<TableFace<'a>>>,
}

/// Texture coordinates of a face.
#[derive(Clone, Debug)]
struct Uvs<'a> {
    source: Source<'a>,
    quad: QuadEvaluator,
    ready: Option<(u32, u32)>,
}

impl FaceEvaluator<'_> {
    /// The face.
    #[must_use]
    pub fn face(&self) -> u32 {
        self.face
    }

    /// The surface at (`u`, `v`), as [`Surface::evaluate`].
    #[inline]
    pub fn at(&mut self, u: f32, v: f32) -> Option<Sample> {
        self.at_as(u, v)
    }

    /// As [`FaceEvaluator::at`], with only as much as `S` holds.
    #[inline]
    pub fn at_as<S: Evaluated>(&mut self, u: f32, v: f32) -> Option<S> {
        if self.whole && is_unit(u) && is_unit(v) {
            return Some(S::evaluate(Asked {
                quad: &mut self.quad,
                channel: self.source.root,
                at: Local::quad(self.first, u, v),
                tip: None,
            }));
        }
        self.elsewhere(u, v)
    }

    #[inline(never)]
    fn elsewhere<S: Evaluated>(&mut self, u: f32, v: f32) -> Option<S> {
        if let Some(table) = &mut self.table {
            return table.at(u, v);
        }
        let local = self.surface.locate(self.face, u, v)?;
        Some(self.local(local))
    }

    fn local<S: Evaluated>(&mut self, local: Local) -> S {
        let (first, own, others) = (self.first, &mut self.quad, &mut self.others);
        self.source.patch(local, |channel, at, tip| {
            let quad = if at.depth == 0 && at.quad == first {
                own
            } else {
                other(others, channel, (at.depth, at.quad))
            };
            S::evaluate(Asked {
                quad,
                channel,
                at,
                tip,
            })
        })
    }

    /// Samples of a grid of `n` segments along each side: (n + 1)², or as many for each quad of a polygon of other than 4 corners, or
    /// (n + 1) (n + 2) / 2 on a triangle of Modified Butterfly.
    #[must_use]
    pub fn grid_len(&self, n: u32) -> usize {
        if let Some(table) = &self.table {
            return table.grid_len(n);
        }
        let side = n as usize + 1;
        side * side * self.quads_of_grid()
    }

    fn quads_of_grid(&self) -> usize {
        match self.surface.topology().face_halves(self.face).len() {
            4 => 1,
            n => n,
        }
    }

    /// Evaluates the grid u, v = 0, 1/n, … 1, row by row: u first, then the next v. A polygon of other than 4 corners has one grid per
    /// corner, one after the other; on a triangle of Modified Butterfly rows end where u + v is 1.
    ///
    /// # Errors
    /// [`EvaluateError::WrongCount`] unless `n` is above 0 and `out` has [`FaceEvaluator::grid_len`] places; on interpolating surfaces
    /// [`EvaluateError::NotDyadic`] unless `n` is a power of two up to 1024.
    pub fn grid<S: Evaluated>(&mut self, n: u32, out: &mut [S]) -> Result<(), EvaluateError> {
        if let Some(table) = &mut self.table {
            return table.grid(n, out);
        }
        let wanted = self.grid_len(n);
        if out.len() != wanted || n == 0 {
            return Err(EvaluateError::WrongCount {
                got: out.len(),
                wanted,
            });
        }
        let quads = self.quads_of_grid();
        let split = quads == 1 && self.surface.is_split();
        let side = n as usize + 1;
        for (k, out) in out.chunks_exact_mut(side * side).enumerate() {
            let quad = self.first + k as u32;
            if split || self.source.below.is_some() {
                for (i, out) in out.iter_mut().enumerate() {
                    let [u, v] = [i % side, i / side].map(|i| i as f32 / n as f32);
                    *out = self.local(if split {
                        child(self.first, u, v)
                    } else {
                        Local::quad(quad, u, v)
                    });
                }
                continue;
            }
            let channel = self.source.root;
            let asked = Asked {
                quad: if k == 0 {
                    &mut self.quad
                } else {
                    other(&mut self.others, channel, (0, quad))
                },
                channel,
                at: Local::quad(quad, 0.0, 0.0),
                tip: None,
            };
            S::grid(asked, n, out);
        }
        Ok(())
    }

    /// Texture coordinates at (`u`, `v`). `None` when the surface has none, or (`u`, `v`) is no place that [`Surface::evaluate`] finds.
    pub fn uv(&mut self, u: f32, v: f32) -> Option<[f32; 2]> {
        if let Some(table) = &mut self.table {
            return table.uv(u, v);
        }
        let local = self.surface.locate(self.face, u, v)?;
        let uvs = match &mut self.uv {
            Some(uvs) => uvs,
            none => none.insert(Box::new(Uvs {
                source: Source::new(self.surface, Kind::Uvs)?,
                quad: QuadEvaluator::default(),
                ready: None,
            })),
        };
        if self.surface.has_linear_uvs() {
            let channel = uvs.source.root;
            let corner =
                |c: u32| channel.points[channel.topology.vertex(4 * local.quad + c) as usize];
            let [a, b, c, d] = [0, 1, 2, 3].map(corner);
            let (s, t) = (local.u, local.v);
            let at = |k: usize| {
                (a[k] * (1.0 - s) + b[k] * s) * (1.0 - t) + (d[k] * (1.0 - s) + c[k] * s) * t
            };
            return Some([at(0), at(1)]);
        }
        let (quad, ready) = (&mut uvs.quad, &mut uvs.ready);
        let position = uvs.source.patch(local, |channel, at, _| {
            let key = Some((at.depth, at.quad));
            if *ready != key {
                quad.prepare(channel, at.quad);
                *ready = key;
            }
            <[f32; 3]>::evaluate(Asked {
                quad,
                channel,
                at,
                tip: None,
            })
        });
        Some([position[0], position[1]])
    }
}

#[inline(never)]
fn other<'q>(
    others: &'q mut BTreeMap<(u32, u32), Box<QuadEvaluator>>,
    channel: Channel<'_>,
    key: (u32, u32),
) -> &'q mut QuadEvaluator {
    others.entry(key).or_insert_with(|| {
        let mut quad = Box::<QuadEvaluator>::default();
        quad.prepare(channel, key.1);
        quad
    })
}

impl Surface {
    /// An evaluator of face `face` of the cage, which keeps what several places have in common. `None` when there is no such face.
    #[must_use]
    pub fn face_evaluator(&self, face: u32) -> Option<FaceEvaluator<'_>> {
        if face as usize >= self.topology().face_count() {
            return None;
        }
        let first = if self.is_split() {
            self.topology().face_halves(face).start
        } else {
            face
        };
        let table = TableFace::new(self, face).map(Box::new);
        let source = match &table {
            Some(_) => Source::bare(self),
            None => Source::new(self, Kind::Points)?,
        };
        let mut quad = QuadEvaluator::default();
        if table.is_none() {
            quad.prepare(source.root, first);
        }
        Some(FaceEvaluator {
            surface: self,
            source,
            face,
            first,
            whole: source.below.is_none() && !self.is_split() && table.is_none(),
            table,
            quad,
            others: BTreeMap::new(),
            uv: None,
        })
    }
}
