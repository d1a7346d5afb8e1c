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
//!
//! Derivatives are by these u and v. Surfaces of triangles (Loop's scheme) are to take barycentric coordinates, where (1 − u − v, u, v)
//! are the weights of corners 0, 1 and 2; they are not evaluated yet, and nothing is found on them.
//!
//! # Where derivatives do not exist
//!
//! At a vertex of another valence than 4 (on a boundary, of other than 2 faces), derivatives by u and v tend to nothing or to no end, and
//! second derivatives have no limit. Right at such a corner, and nearer than 2⁻⁴⁰ to it, a sample holds the limit point and the limit
//! normal of the vertex, and as `du` and `dv` the tangents along the two sides with lengths in the vertex' natural parameters: those of
//! the flat star of n equal sectors whose spokes come closest to the ring (after Stam, *Exact evaluation of Catmull-Clark subdivision
//! surfaces at arbitrary parameter values*, 1998). For 4 sectors that is the derivative itself. At corners that stay where they are, of
//! several faces, `du` and `dv` are the sides of the control quad. `second` is `None` at all of these. Everywhere else, however close,
//! derivatives are those of the surface.
//!
//! Creases that fade are followed until they have faded. Right at a vertex where a crease begins, fades or ends, position and normal are
//! the limit's, `du` and `dv` those of the deepest control level. Within 2⁻¹⁰ of the end of an infinitely sharp crease inside the surface,
//! derivatives are those of the smooth rule.

use crate::control::{Kind, TreeChannel};
use crate::dice::MAX_LEVEL;
use crate::dice::control::Descend;
use crate::dice::evaluate::{Jet, QuadEvaluator, leaf};
use crate::dice::face::Channel;
use crate::surface::Surface;
use rayon::prelude::*;
use std::cell::RefCell;
use std::collections::BTreeMap;

mod sample;

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
    /// The output does not hold as many samples as wanted.
    #[error("room for {got} samples, {wanted} wanted")]
    WrongCount {
        /// Length of the output.
        got: usize,
        /// Samples wanted.
        wanted: usize,
    },
    /// Surfaces of triangles are not evaluated yet.
    #[error("surfaces of this scheme cannot be evaluated")]
    Scheme,
}

/// A place in a mesh of quads.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Local {
    pub(crate) quad: u32,
    pub(crate) u: f32,
    pub(crate) v: f32,
    /// Control level that the quad belongs to.
    depth: u32,
    /// The quad is seen from this corner of the face, at this scale.
    turned: usize,
    scale: f32,
}

/// Control data of a surface, of points or texture coordinates.
#[derive(Clone, Copy, Debug)]
struct Source<'a> {
    root: Channel<'a>,
    below: Option<TreeChannel<'a>>,
}

impl<'a> Source<'a> {
    fn new(surface: &'a Surface, kind: Kind) -> Option<Self> {
        surface.ensure(MAX_LEVEL);
        Some(Self {
            root: surface.channel(kind, None)?,
            below: surface.below(kind, MAX_LEVEL, None),
        })
    }

    /// Calls `then` with the patch at a place of the quads.
    #[inline(always)]
    fn patch<R>(&self, at: Local, then: impl FnOnce(Channel<'_>, Local, Option<Tip>) -> R) -> R {
        let Some(below) = &self.below else {
            return then(self.root, at, None);
        };
        match leaf(below as &dyn Descend, at.quad, at.u, at.v) {
            None => then(self.root, at, None),
            Some(leaf) => {
                let local = Local {
                    quad: leaf.quad,
                    u: leaf.at[0],
                    v: leaf.at[1],
                    depth: leaf.depth,
                    turned: at.turned,
                    scale: at.scale * (1_u32 << leaf.depth) as f32,
                };
                let tip = leaf.tip.map(|c| {
                    let fan = self.root.topology.fan(4 * at.quad + c as u32) as usize;
                    let fans = self.root.fans;
                    Tip {
                        position: fans.limits[fan],
                        normal: fans.normals.get(fan).copied().unwrap_or_default(),
                    }
                });
                then(leaf.channel, local, tip)
            }
        }
    }
}

/// What is known of a corner where creases end or fade.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tip {
    pub(crate) position: [f32; 3],
    pub(crate) normal: [f32; 3],
}

impl Local {
    /// A place in a quad that is its own face.
    pub(crate) fn quad(quad: u32, u: f32, v: f32) -> Self {
        Self {
            quad,
            u,
            v,
            depth: 0,
            turned: 0,
            scale: 1.0,
        }
    }

    /// What was found in the quad, by the parameters of the face.
    #[inline(always)]
    pub(crate) fn outer<const ORDER: u32>(&self, jet: Jet) -> Jet {
        if self.scale == 1.0 {
            return jet;
        }
        jet.scaled::<ORDER>(self.scale).turned::<ORDER>(self.turned)
    }
}

#[inline(always)]
fn is_unit(x: f32) -> bool {
    (0.0..=1.0).contains(&x)
}

/// The child of `corner` of a quad that is split once.
fn child(first: u32, u: f32, v: f32) -> Local {
    let (corner, [s, t]) = match (u >= 0.5, v >= 0.5) {
        (false, false) => (0, [u, v]),
        (true, false) => (1, [v, 1.0 - u]),
        (true, true) => (2, [1.0 - u, 1.0 - v]),
        (false, true) => (3, [1.0 - v, u]),
    };
    Local {
        quad: first + corner as u32,
        u: 2.0 * s,
        v: 2.0 * t,
        depth: 0,
        turned: corner,
        scale: 2.0,
    }
}

impl Surface {
    #[inline(always)]
    fn locate(&self, face: u32, u: f32, v: f32) -> Option<Local> {
        // What is not a number is in no range.
        if face as usize >= self.topology().face_count() || !is_unit(v) {
            return None;
        }
        if self.is_split() {
            return self.locate_child(face, u, v);
        }
        is_unit(u).then_some(Local::quad(face, u, v))
    }

    fn locate_child(&self, face: u32, u: f32, v: f32) -> Option<Local> {
        let halves = self.topology().face_halves(face);
        let n = halves.len() as u32;
        if n == 4 {
            return is_unit(u).then(|| child(halves.start, u, v));
        }
        let k = (0.0..=n as f32)
            .contains(&u)
            .then(|| (u as u32).min(n - 1))?;
        let u = (u - k as f32).min(1.0);
        Some(Local::quad(halves.start + k, u, v))
    }

    /// The limit surface at a place of face `face` of the cage (see the [module](crate::evaluate) for parameters): position, normal, first
    /// and second derivatives. `None` when there is no such face, or (`u`, `v`) is not on it. Holes have a surface too.
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
        thread_local! {
            /// Keeps its memory from one place to the next.
            static QUAD: RefCell<QuadEvaluator> = RefCell::default();
        }
        let local = self.locate(face, u, v)?;
        let source = Source::new(self, Kind::Points)?;
        Some(QUAD.with_borrow_mut(|quad| {
            source.patch(local, |channel, at, tip| {
                quad.prepare(channel, at.quad);
                S::evaluate(Asked {
                    quad,
                    channel,
                    at,
                    tip,
                })
            })
        }))
    }

    /// Evaluates many places, on all threads. Places on the same face are cheaper, wherever in the list they stand. The result does not
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
        let source = Source::new(self, Kind::Points).ok_or(EvaluateError::Scheme)?;
        if let Some(index) = places
            .par_iter()
            .with_min_len(CHUNK)
            .position_first(|p| self.locate(p.face, p.u, p.v).is_none())
        {
            return Err(EvaluateError::NoSuchPlace { index });
        }
        places
            .par_chunks(CHUNK)
            .zip(out.par_chunks_mut(CHUNK))
            .for_each_init(Batch::default, |batch, (places, out)| {
                batch.evaluate(self, &source, places, out);
            });
        Ok(())
    }

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
        let source = Source::new(self, Kind::Points)?;
        let mut quad = QuadEvaluator::default();
        quad.prepare(source.root, first);
        Some(FaceEvaluator {
            surface: self,
            source,
            face,
            first,
            whole: source.below.is_none() && !self.is_split(),
            quad,
            others: BTreeMap::new(),
            uv: None,
        })
    }
}

/// Places that one thread evaluates at a time.
const CHUNK: usize = 1 << 16;

/// Memory of [`Surface::evaluate_many`].
#[derive(Default)]
struct Batch {
    quad: QuadEvaluator,
    starts: Vec<u32>,
    order: Vec<u32>,
}

impl Batch {
    fn evaluate<S: Evaluated>(
        &mut self,
        surface: &Surface,
        source: &Source<'_>,
        places: &[Place],
        out: &mut [S],
    ) {
        let quads = source.root.topology.face_count();
        let changes = places.windows(2).filter(|p| p[0].face != p[1].face).count();
        // Sorting pays where a face comes more than once, and where its counters are no more than the places.
        if 4 * changes < places.len() || quads > places.len() {
            self.in_order(surface, source, places, out, 0..places.len() as u32);
            return;
        }
        self.starts.clear();
        self.starts.resize(quads + 1, 0);
        let quad = |p: &Place| surface.locate(p.face, p.u, p.v).map_or(0, |l| l.quad) as usize;
        for p in places {
            self.starts[quad(p) + 1] += 1;
        }
        for q in 0..quads {
            self.starts[q + 1] += self.starts[q];
        }
        self.order.resize(places.len(), 0);
        for (i, p) in (0..).zip(places) {
            let at = &mut self.starts[quad(p)];
            self.order[*at as usize] = i;
            *at += 1;
        }
        let order = std::mem::take(&mut self.order);
        self.in_order(surface, source, places, out, order.iter().copied());
        self.order = order;
    }

    fn in_order<S: Evaluated>(
        &mut self,
        surface: &Surface,
        source: &Source<'_>,
        places: &[Place],
        out: &mut [S],
        order: impl Iterator<Item = u32>,
    ) {
        let (quad, mut ready) = (&mut self.quad, None);
        for i in order {
            let p = places[i as usize];
            let Some(local) = surface.locate(p.face, p.u, p.v) else {
                continue;
            };
            out[i as usize] = source.patch(local, |channel, at, tip| {
                let key = Some((at.depth, at.quad));
                if ready != key {
                    quad.prepare(channel, at.quad);
                    ready = key;
                }
                S::evaluate(Asked {
                    quad,
                    channel,
                    at,
                    tip,
                })
            });
        }
    }
}

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

    /// Samples of a grid of `n` segments along each side: (n + 1)², or as many for each quad of a polygon of other than 4 corners.
    #[must_use]
    pub fn grid_len(&self, n: u32) -> usize {
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
    /// corner, one after the other.
    ///
    /// # Errors
    /// [`EvaluateError::WrongCount`] unless `n` is above 0 and `out` has [`FaceEvaluator::grid_len`] places.
    pub fn grid<S: Evaluated>(&mut self, n: u32, out: &mut [S]) -> Result<(), EvaluateError> {
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

    /// Texture coordinates at (`u`, `v`). `None` when the surface has none, or (`u`, `v`) is not on the face.
    pub fn uv(&mut self, u: f32, v: f32) -> Option<[f32; 2]> {
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
            <[f32; 3] as sample::sealed::Kind>::evaluate(Asked {
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
