//! Further values through all levels: per vertex, per face, per face corner.
//!
//! Values of vertices (colours, say) go by the rules of points, values of corners by those of texture coordinates, and values of faces are
//! inherited. The passes know triples of points and pairs of texture coordinates; wider channels travel in several *parts*.

use super::face_varying::FaceVarying;
use super::interpolating::{self, Sheets};
use super::limit::{self, Tables};
use super::real::Real;
use super::sharpness::Step;
use super::{RefineError, Timings, edge, face, fill, timed, vertex};
use crate::mesh::{Cage, FaceVaryingChannel, UniformChannel};
use crate::scheme::{FaceVaryingRule, Scheme};
use crate::topology::Topology;
use std::sync::Arc;

/// Name of the channel of a cage's colours.
pub const COLOR: &str = "color";

/// A channel of values per vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexValues<T> {
    /// Its name.
    pub name: String,
    /// Numbers per value, 1 to 4.
    pub width: usize,
    parts: Vec<Vec<[T; 3]>>,
}

/// A channel of values per face corner.
#[derive(Clone, Debug)]
pub struct FaceVaryingValues<T> {
    /// Its name.
    pub name: String,
    /// Numbers per value, 1 to 4.
    pub width: usize,
    parts: Vec<FaceVarying<T>>,
}

/// All channels of a level.
#[derive(Clone, Debug, Default)]
pub struct Channels<T> {
    /// Values per vertex; the colours of a cage are one of the name [`COLOR`].
    pub vertex: Vec<VertexValues<T>>,
    /// Values per corner, texture coordinates not among them.
    pub face_varying: Vec<FaceVaryingValues<T>>,
    /// Values per face of the cage, for [`Level::base_face`](super::Level::base_face).
    pub uniform: Arc<Vec<UniformChannel>>,
}

/// Number `k` of value `i` out of flat values.
fn number<T: Real>(values: &[f32], width: usize, i: usize, k: usize) -> T {
    let c = values.get(i * width + k).filter(|_| k < width);
    T::from_f64(c.map_or(0.0, |&c| f64::from(c)))
}

impl<T: Real> VertexValues<T> {
    /// From flat values, `width` numbers each.
    ///
    /// # Errors
    /// [`RefineError::WrongCount`] unless there are whole values.
    pub fn new(name: &str, width: usize, values: &[f32]) -> Result<Self, RefineError> {
        if width == 0 || !values.len().is_multiple_of(width) {
            return Err(RefineError::WrongCount {
                got: values.len(),
                wanted: values.len().next_multiple_of(width.max(1)),
            });
        }
        let part = |p: usize| {
            (0..values.len() / width)
                .map(|i| std::array::from_fn(|k| number(values, width, i, 3 * p + k)))
                .collect()
        };
        Ok(Self {
            name: name.to_owned(),
            width,
            parts: (0..width.div_ceil(3)).map(part).collect(),
        })
    }

    /// Columns of three numbers each, as they are.
    pub(super) fn of_parts(parts: Vec<Vec<[T; 3]>>) -> Self {
        Self {
            name: String::new(),
            width: 3 * parts.len(),
            parts,
        }
    }

    pub(super) fn parts(&self) -> &[Vec<[T; 3]>] {
        &self.parts
    }

    /// How many values there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.parts.first().map_or(0, Vec::len)
    }
    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// The numbers of vertex `v`.
    pub fn value(&self, v: usize) -> impl Iterator<Item = T> + '_ {
        (0..self.width).map(move |k| self.parts[k / 3][v][k % 3])
    }

    fn next(&self, step: &Step<'_>, timings: &mut Timings) -> Self {
        Self {
            name: self.name.clone(),
            width: self.width,
            parts: (self.parts.iter())
                .map(|values| next_values(step, values, timings))
                .collect(),
        }
    }
}

/// Values of the next level, by the rules of points.
pub(super) fn next_values<T: Real>(
    step: &Step<'_>,
    values: &[[T; 3]],
    timings: &mut Timings,
) -> Vec<[T; 3]> {
    let t = step.topology;
    let (faces, edges) = (step.face_points(), t.edge_count());
    let mut points = vec![[T::default(); 3]; t.vertex_count() + faces + edges];
    let (vertex_points, rest) = points.split_at_mut(t.vertex_count());
    let (face_points, edge_points) = rest.split_at_mut(faces);
    if step.options.scheme.is_interpolating() && !step.is_linear() {
        timed(&mut timings.vertex, || {
            vertex_points.copy_from_slice(values)
        });
        let masks = interpolating::Masks::default();
        let sheets = Sheets::<T, T, 3>::of_points(step, &masks, values);
        timed(&mut timings.edge, || {
            fill(edge_points, |e| sheets.edge_point(sheets.side(e)));
        });
        timed(&mut timings.face, || {
            let edge_point = |h: u32| edge_points[t.edge(h) as usize];
            fill(face_points, |f| sheets.face_point(4 * f, edge_point));
        });
        return points;
    }
    timed(&mut timings.face, || {
        face::points(step, &t.corner_vertices, values, face_points);
    });
    timed(&mut timings.edge, || {
        edge::points(step, &t.corner_vertices, values, face_points, edge_points);
    });
    timed(&mut timings.vertex, || {
        vertex::points(step, values, face_points, vertex_points);
    });
    points
}

impl<T: Real> FaceVaryingValues<T> {
    fn new(
        t: &Topology,
        channel: &FaceVaryingChannel,
        scheme: Scheme,
        rule: FaceVaryingRule,
    ) -> Self {
        let width = channel.width;
        let count = channel.values.len() / width.max(1);
        let part = |p: usize| {
            let values: Vec<[T; 2]> = (0..count)
                .map(|i| std::array::from_fn(|k| number(&channel.values, width, i, 2 * p + k)))
                .collect();
            let rule = channel.rule.unwrap_or(rule);
            FaceVarying::new(t, &values, &channel.corners, scheme, rule)
        };
        Self {
            name: channel.name.clone(),
            width,
            parts: (0..width.div_ceil(2)).map(part).collect(),
        }
    }

    /// How many values there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.parts.first().map_or(0, |p| p.values.len())
    }
    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Value of every corner.
    #[must_use]
    pub fn corners(&self) -> &[u32] {
        self.parts.first().map_or(&[], |p| &p.corners)
    }
    /// The numbers of value `i`.
    pub fn value(&self, i: usize) -> impl Iterator<Item = T> + '_ {
        (0..self.width).map(move |k| self.parts[k / 2].values[i][k % 2])
    }
    /// Whether the faces that descend from face `base` of the cage have a value at every corner.
    #[must_use]
    pub fn is_complete(&self, base: u32) -> bool {
        self.parts.iter().all(|p| p.is_complete(base))
    }
}

impl<T: Real> Channels<T> {
    /// The channels of a cage, its colours among them. `rule` holds where a channel has none of its own.
    pub(super) fn of_cage(
        cage: &Cage,
        t: &Topology,
        scheme: Scheme,
        rule: FaceVaryingRule,
    ) -> Result<Self, RefineError> {
        let channels = cage.channels();
        let mut vertex = Vec::new();
        if !cage.colors().is_empty() {
            vertex.push(VertexValues::new(COLOR, 3, cage.colors().as_flattened())?);
        }
        for c in &channels.vertex {
            vertex.push(VertexValues::new(&c.name, c.width, &c.values)?);
        }
        if let Some(odd) = vertex.iter().find(|c| c.len() != t.vertex_count()) {
            return Err(RefineError::WrongCount {
                got: odd.len(),
                wanted: t.vertex_count(),
            });
        }
        Ok(Self {
            vertex,
            face_varying: (channels.face_varying.iter())
                .map(|c| FaceVaryingValues::new(t, c, scheme, rule))
                .collect(),
            uniform: Arc::new(channels.uniform.clone()),
        })
    }

    /// The channel of values per vertex of this name.
    #[must_use]
    pub fn vertex_named(&self, name: &str) -> Option<&VertexValues<T>> {
        self.vertex.iter().find(|c| c.name == name)
    }

    /// Numbers per vertex, over all channels and filled up to whole parts.
    pub(super) fn numbers_per_vertex(&self) -> usize {
        self.vertex.iter().map(|c| 3 * c.parts.len()).sum()
    }

    /// Texture-like parts: how many, and the values of each.
    pub(super) fn pairs(&self) -> impl Iterator<Item = usize> + '_ {
        (self.face_varying.iter()).flat_map(|c| c.parts.iter().map(|p| p.values.len()))
    }

    pub(super) fn next(&self, step: &Step<'_>, timings: &mut Timings) -> Self {
        Self {
            vertex: self.vertex.iter().map(|c| c.next(step, timings)).collect(),
            face_varying: self
                .face_varying
                .iter()
                .map(|c| c.map(|p| p.next(step, timings)))
                .collect(),
            uniform: Arc::clone(&self.uniform),
        }
    }

    /// The limits of all values.
    pub(super) fn limit(&self, step: &Step<'_>, tables: &Tables) -> Self {
        let of_part = |p: &Vec<[T; 3]>| limit::values(step, tables, p, false).0;
        Self {
            vertex: (self.vertex.iter())
                .map(|c| VertexValues {
                    name: c.name.clone(),
                    width: c.width,
                    parts: c.parts.iter().map(of_part).collect(),
                })
                .collect(),
            face_varying: (self.face_varying.iter())
                .map(|c| {
                    c.map(|p| {
                        let mut part = p.clone();
                        part.values = p.limit(step, tables);
                        part
                    })
                })
                .collect(),
            uniform: Arc::clone(&self.uniform),
        }
    }
}

impl<T> FaceVaryingValues<T> {
    fn map(&self, part: impl FnMut(&FaceVarying<T>) -> FaceVarying<T>) -> Self {
        Self {
            name: self.name.clone(),
            width: self.width,
            parts: self.parts.iter().map(part).collect(),
        }
    }
}
