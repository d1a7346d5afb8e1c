//! Whole-mesh refinement, breadth first: a level is flat arrays, and the next level is made of it by four passes.
//!
//! [`face`], [`edge`] and [`vertex`] compute the points of one kind each, [`connectivity`] the next topology. Every pass is parallel and
//! gathers only: an element reads its parents and writes itself, sums run in a fixed order, so the bits do not depend on threads. This is
//! the path of export, and the oracle of the per-quad path, hence generic over `f32` and `f64`.
//!
//! Points belong to vertices, not to fans: where the mesh is not manifold, all fans of a vertex share one point, as in OpenSubdiv.
//! Children are numbered as OpenSubdiv does: those of vertices, then of faces (quads only), then of edges. So vertex `i` of any level descends from
//! vertex `i` of the cage.

pub mod channels;
pub mod connectivity;
pub mod edge;
pub mod face;
pub mod face_varying;
pub mod interpolating;
pub(crate) mod lattice;
pub mod limit;
pub mod passes;
pub mod real;
pub(crate) mod restrict;
pub mod ring;
pub mod sharpness;
pub mod stencils;
pub mod vertex;

use crate::mesh::Cage;
use crate::scheme::{CreaseMethod, FaceVaryingRule, Scheme, TriangleRule};
use crate::topology::{NONE, Topology};
use rayon::prelude::*;
use std::time::{Duration, Instant};

pub use channels::Channels;
pub use face_varying::FaceVarying;
pub use interpolating::has_semi_sharp;
pub use limit::{Limit, limit};
pub use real::Real;
pub use stencils::{Stencils, stencils};

/// Rules of refinement. The boundary rule is not among them: it is part of the topology.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Subdivision scheme.
    pub scheme: Scheme,
    /// Decay of semi-sharp creases.
    pub creases: CreaseMethod,
    /// Weights beside triangles.
    pub triangles: TriangleRule,
}

/// Wall time of each pass, summed over levels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Timings {
    /// Face points.
    pub face: Duration,
    /// Edge points.
    pub edge: Duration,
    /// Vertex points.
    pub vertex: Duration,
    /// Topology and tags of the next level.
    pub connectivity: Duration,
}

/// Why a mesh was not refined.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RefineError {
    /// 32-bit indices do not reach.
    #[error("level {level} would have {corners} corners, more than 32-bit indices can name")]
    TooManyCorners {
        /// The level that failed, counted from the cage.
        level: u32,
        /// Its corners.
        corners: u128,
    },
    /// More memory than allowed.
    #[error("refinement to level {level} would take {needed} bytes, {allowed} are allowed")]
    TooMuchMemory {
        /// The level asked for, counted from the cage.
        level: u32,
        /// Bytes predicted.
        needed: u128,
        /// Bytes allowed.
        allowed: u128,
    },
    /// A face that the scheme cannot split.
    #[error("face {face} has {corners} corners; this scheme takes triangles only")]
    NotTriangle {
        /// The first such face.
        face: u32,
        /// Its corners.
        corners: u32,
    },
    /// Points do not fit the topology.
    #[error("{got} points for {wanted} vertices")]
    WrongCount {
        /// Points given.
        got: usize,
        /// Vertices.
        wanted: usize,
    },
}

/// One level of refinement, flat arrays.
#[derive(Clone, Debug)]
pub struct Level<T> {
    /// Connectivity and sharpness.
    pub topology: Topology,
    /// One point per vertex.
    pub points: Vec<[T; 3]>,
    /// Texture coordinates.
    pub uvs: Option<FaceVarying<T>>,
    /// Further values, per vertex, face and corner.
    pub channels: Channels<T>,
    depth: u32,
    /// How many steps, from the cage on, split triangles.
    triangle_steps: u32,
    /// Face of every corner of the cage, for [`Level::base_face`].
    base_corner_faces: Vec<u32>,
    base_face_count: usize,
}

impl<T: Real> Level<T> {
    /// Level 0.
    ///
    /// # Errors
    /// [`RefineError::WrongCount`] unless there is one point per vertex.
    pub fn new(topology: Topology, points: Vec<[T; 3]>) -> Result<Self, RefineError> {
        if points.len() != topology.vertex_count() {
            return Err(RefineError::WrongCount {
                got: points.len(),
                wanted: topology.vertex_count(),
            });
        }
        Ok(Self {
            base_corner_faces: (0..topology.half_count() as u32)
                .map(|h| topology.face_of(h))
                .collect(),
            base_face_count: topology.face_count(),
            topology,
            points,
            uvs: None,
            channels: Channels::default(),
            depth: 0,
            triangle_steps: 0,
        })
    }

    /// Level 0 of a cage with its texture coordinates and channels, connected as `topology`. Points are relative to [`Cage::origin`].
    ///
    /// # Errors
    /// [`RefineError::WrongCount`] when `topology` belongs to another cage.
    pub fn of_cage(
        cage: &Cage,
        topology: Topology,
        scheme: Scheme,
        rule: FaceVaryingRule,
    ) -> Result<Self, RefineError> {
        T::of_cage(cage, topology, scheme, rule)
    }

    fn make_of_cage(
        cage: &Cage,
        topology: Topology,
        scheme: Scheme,
        rule: FaceVaryingRule,
    ) -> Result<Self, RefineError> {
        let points = cage
            .points()
            .iter()
            .map(|p| p.map(|c| T::from_f64(f64::from(c))))
            .collect();
        let mut level = Self::new(topology, points)?;
        level.channels = Channels::of_cage(cage, &level.topology, scheme, rule)?;
        if !cage.corner_uvs().is_empty() {
            let values: Vec<[T; 2]> = cage
                .uvs()
                .iter()
                .map(|p| p.map(|c| T::from_f64(f64::from(c))))
                .collect();
            level = level.make_with_uvs(&values, cage.corner_uvs(), scheme, rule)?;
        }
        Ok(level)
    }

    /// Adds texture coordinates to level 0: values, and per corner the index of its value or [`NONE`].
    ///
    /// # Errors
    /// [`RefineError::WrongCount`] unless there is one index per corner and every index has a value.
    pub fn with_uvs(
        self,
        values: &[[T; 2]],
        corners: &[u32],
        scheme: Scheme,
        rule: FaceVaryingRule,
    ) -> Result<Self, RefineError> {
        T::with_uvs(self, values, corners, scheme, rule)
    }

    fn make_with_uvs(
        mut self,
        values: &[[T; 2]],
        corners: &[u32],
        scheme: Scheme,
        rule: FaceVaryingRule,
    ) -> Result<Self, RefineError> {
        let out_of_range = |&&i: &&u32| i != NONE && i as usize >= values.len();
        let wanted = self.topology.half_count();
        if corners.len() != wanted || corners.iter().any(|i| out_of_range(&i)) {
            return Err(RefineError::WrongCount {
                got: corners.len(),
                wanted,
            });
        }
        self.uvs = Some(FaceVarying::new(
            &self.topology,
            values,
            corners,
            scheme,
            rule,
        ));
        Ok(self)
    }

    /// Steps since the cage.
    #[must_use]
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// The face of the cage that face `f` descends from.
    #[must_use]
    pub fn base_face(&self, f: u32) -> u32 {
        match self.depth - self.triangle_steps {
            0 => f >> (2 * self.triangle_steps),
            d => {
                let corner = f >> (2 * (d - 1));
                if self.triangle_steps == 0 {
                    self.base_corner_faces[corner as usize]
                } else {
                    (corner / 3) >> (2 * self.triangle_steps)
                }
            }
        }
    }

    /// Number of faces of the cage.
    #[must_use]
    pub fn base_face_count(&self) -> usize {
        self.base_face_count
    }

    /// Bytes that refinement by `levels` more steps will hold at its peak: the last two levels.
    #[must_use]
    pub fn predicted_bytes(&self, scheme: Scheme, levels: u32) -> u128 {
        let pairs: Vec<usize> = (self.uvs.iter().map(|uv| uv.values.len()))
            .chain(self.channels.pairs())
            .collect();
        let numbers = 3 + self.channels.numbers_per_vertex() as u128;
        let scalar = size_of::<T>() as u128;
        peak_bytes(
            &self.topology,
            scheme,
            levels,
            numbers * scalar,
            &pairs,
            scalar,
        )
    }

    /// The next level.
    ///
    /// # Errors
    /// [`RefineError::TooManyCorners`] when 32-bit indices do not reach, [`RefineError::NotTriangle`] when the scheme needs triangles.
    pub fn next(&self, options: &Options, timings: &mut Timings) -> Result<Self, RefineError> {
        T::next(self, options, timings)
    }

    fn make_next(&self, options: &Options, timings: &mut Timings) -> Result<Self, RefineError> {
        let t = &self.topology;
        if options.scheme.is_triangular() {
            check_triangles(t)?;
        }
        let corners = 4 * t.half_count() as u128;
        if corners >= u128::from(NONE) {
            return Err(RefineError::TooManyCorners {
                level: self.depth + 1,
                corners,
            });
        }
        let start = Instant::now();
        let step = sharpness::Step::new(t, options);
        timings.connectivity += start.elapsed();

        let points = channels::next_values(&step, &self.points, timings);
        let channels = self.channels.next(&step, timings);
        let topology = timed(&mut timings.connectivity, || connectivity::child(&step));
        let uvs = self.uvs.as_ref().map(|uv| uv.next(&step, timings));
        Ok(Self {
            topology,
            points,
            uvs,
            channels,
            depth: self.depth + 1,
            triangle_steps: self.triangle_steps + u32::from(options.scheme.is_triangular()),
            base_corner_faces: self.base_corner_faces.clone(),
            base_face_count: self.base_face_count,
        })
    }
}

/// Whether all faces are triangles, as [`Scheme::is_triangular`] schemes need.
///
/// # Errors
/// [`RefineError::NotTriangle`] names the first face that is none.
pub fn check_triangles(t: &Topology) -> Result<(), RefineError> {
    let odd = (0..t.face_count() as u32)
        .into_par_iter()
        .with_min_len(1 << 14)
        .find_first(|&f| t.face_halves(f).len() != 3);
    match odd {
        None => Ok(()),
        Some(face) => Err(RefineError::NotTriangle {
            face,
            corners: t.face_halves(face).len() as u32,
        }),
    }
}

/// Computes every element on its own.
fn fill<P: Send>(out: &mut [P], of: impl Fn(u32) -> P + Sync) {
    out.par_iter_mut()
        .enumerate()
        .with_min_len(1 << 10)
        .for_each(|(i, p)| *p = of(i as u32));
}

/// Points of the level after a mesh of connectivity `topology` at `points`.
pub(crate) fn next_points<T: Real>(
    topology: &Topology,
    options: &Options,
    points: &[[T; 3]],
) -> Vec<[T; 3]> {
    let step = sharpness::Step::new(topology, options);
    channels::next_values(&step, points, &mut Timings::default())
}

fn timed<R>(total: &mut Duration, work: impl FnOnce() -> R) -> R {
    let start = Instant::now();
    let result = work();
    *total += start.elapsed();
    result
}

/// Refines `level` by `levels` steps. Parents are dropped on the way; `max_bytes` bounds the peak.
///
/// # Errors
/// [`RefineError`] when the result does not fit `max_bytes` or 32-bit indices; nothing is allocated then.
pub fn refine<T: Real>(
    level: Level<T>,
    options: &Options,
    levels: u32,
    max_bytes: Option<u64>,
    timings: &mut Timings,
) -> Result<Level<T>, RefineError> {
    let last = level.depth.saturating_add(levels);
    let corners = counts(&level.topology, options.scheme, levels).corners;
    if corners >= u128::from(NONE) {
        return Err(RefineError::TooManyCorners {
            level: last,
            corners,
        });
    }
    let needed = level.predicted_bytes(options.scheme, levels);
    let allowed = max_bytes.map_or(u128::MAX, u128::from);
    if needed > allowed {
        return Err(RefineError::TooMuchMemory {
            level: last,
            needed,
            allowed,
        });
    }
    let mut level = level;
    for _ in 0..levels {
        level = level.next(options, timings)?;
    }
    Ok(level)
}

/// Sizes of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// Vertices.
    pub vertices: u128,
    /// Faces.
    pub faces: u128,
    /// Edges.
    pub edges: u128,
    /// Corners, which are half-edges.
    pub corners: u128,
}

/// Sizes after `levels` steps, without refining. Saturates beyond any machine's reach.
#[must_use]
pub fn counts(topology: &Topology, scheme: Scheme, levels: u32) -> Counts {
    let mut c = Counts {
        vertices: topology.vertex_count() as u128,
        faces: topology.face_count() as u128,
        edges: topology.edge_count() as u128,
        corners: topology.half_count() as u128,
    };
    // 4^64 is beyond 128 bits already.
    for _ in 0..levels.min(64) {
        if scheme.is_triangular() {
            c = Counts {
                vertices: c.vertices.saturating_add(c.edges),
                faces: c.faces.saturating_mul(4),
                edges: c.edges.saturating_mul(2).saturating_add(c.corners),
                corners: c.corners.saturating_mul(4),
            };
            continue;
        }
        c = Counts {
            vertices: c.vertices.saturating_add(c.faces).saturating_add(c.edges),
            faces: c.corners,
            edges: c.edges.saturating_mul(2).saturating_add(c.corners),
            corners: c.corners.saturating_mul(4),
        };
    }
    c
}

/// Bytes that refining positions in `f32` by `levels` steps holds at its peak.
#[must_use]
pub fn predicted_bytes(topology: &Topology, scheme: Scheme, levels: u32) -> u128 {
    peak_bytes(topology, scheme, levels, 12, &[], 4)
}

/// `numbers`: bytes of all numbers of a vertex. `pairs`: how many values each channel of corners has, of two numbers of `scalar` bytes.
fn peak_bytes(
    topology: &Topology,
    scheme: Scheme,
    levels: u32,
    numbers: u128,
    pairs: &[usize],
    scalar: u128,
) -> u128 {
    let triangles = u128::from(scheme.is_triangular());
    let tagged = u128::from(!topology.edge_sharpness.is_empty());
    let pointed = u128::from(!topology.vertex_sharpness.is_empty());
    let holes = u128::from(!topology.holes.is_empty());
    let split = u128::from(!topology.corner_fans.is_empty());
    let fan = size_of::<crate::topology::Fan>() as u128;
    let level_bytes = |level: u32| {
        let c = counts(topology, scheme, level);
        let per_vertex = numbers + fan + 4 * pointed;
        let per_corner = 12 + 4 * split + 4 * triangles;
        let mut sum = c
            .vertices
            .saturating_mul(per_vertex)
            .saturating_add(c.corners.saturating_mul(per_corner))
            .saturating_add(c.edges.saturating_mul(4 + 12 * tagged))
            .saturating_add(c.faces.saturating_mul(holes + 4 * triangles));
        for &values in pairs {
            // Values exceed vertices by what seams duplicate; seams double per level, so the first excess times 2^levels.
            let excess = (values as u128).saturating_sub(topology.vertex_count() as u128);
            let seams = excess.saturating_mul(1_u128.checked_shl(level).unwrap_or(u128::MAX));
            let values = c.vertices.saturating_add(seams);
            sum = sum
                .saturating_add(values.saturating_mul(2 * scalar + 4))
                .saturating_add(seams.saturating_mul(24))
                .saturating_add(c.corners.saturating_mul(4))
                .saturating_add(c.edges.saturating_mul(4));
        }
        sum
    };
    match levels {
        0 => level_bytes(0),
        n => level_bytes(n).saturating_add(level_bytes(n - 1)),
    }
}
