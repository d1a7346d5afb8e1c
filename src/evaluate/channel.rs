//! Named channels of the cage, anywhere on the surface.
//!
//! Values of vertices go by the rules of points, values of corners by those of texture coordinates. So a channel has surfaces of its own:
//! those of the same cage with its numbers in place of points, three at a time, or of texture coordinates, two at a time.

use super::patches::Patches;
use super::table;
use crate::dice::evaluate::QuadEvaluator;
use crate::dice::triangle::TriangleEvaluator;
use crate::mesh::{FaceVaryingChannel, UniformValues};
use crate::surface::{Surface, SurfaceOptions};

/// What a channel has values for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChannelKind {
    /// Vertices.
    Vertex,
    /// Faces of the cage, which are the same all over.
    Uniform,
    /// Corners of faces, with seams where corners disagree.
    FaceVarying,
}

/// A named channel of a cage, ready to be evaluated. It keeps a surface for every three numbers per vertex, or two per corner.
#[derive(Clone, Debug)]
pub struct ChannelSurface<'a> {
    surface: &'a Surface,
    width: usize,
    values: Values<'a>,
}

#[derive(Clone, Debug)]
enum Values<'a> {
    Vertex(Vec<Surface>),
    Uniform(&'a [f32]),
    FaceVarying(Vec<Surface>),
}

/// Numbers `from` to `from + N` of all values of so many numbers each; those that a value lacks are 0.
fn part<const N: usize>(values: &[f32], width: usize, from: usize) -> Vec<[f32; N]> {
    (values.chunks_exact(width.max(1)))
        .map(|value| std::array::from_fn(|k| value.get(from + k).copied().unwrap_or(0.0)))
        .collect()
}

impl Surface {
    /// The channel `name` of the cage among those of `kind` ([`Cage::channels`](crate::Cage::channels)), to be evaluated. `None` when there is
    /// none, or its values are ids, which mean nothing between faces: they are those of the cage's face everywhere on it.
    ///
    /// Values of vertices have the limit of points of those coordinates, by the scheme and all creases of the surface; values of corners that
    /// of texture coordinates by the channel's own rule, or else the surface's.
    ///
    /// ```
    /// # use earmark::{Cage, Surface, evaluate::ChannelKind};
    /// let cage = Cage::builder()
    ///     .points([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    ///     .faces([4], [0, 1, 2, 3])
    ///     .vertex_channel("heat", 1, [0.0, 1.0, 1.0, 0.0])
    ///     .build()?;
    /// let surface = Surface::new(cage, &Default::default());
    /// let heat = surface.named_channel(ChannelKind::Vertex, "heat").unwrap();
    /// assert_eq!(heat.at(0, 0.5, 0.25).unwrap()[0], 0.5);
    /// # Ok::<(), earmark::mesh::CageError>(())
    /// ```
    #[must_use]
    pub fn named_channel(&self, kind: ChannelKind, name: &str) -> Option<ChannelSurface<'_>> {
        let channels = self.cage().channels();
        let (width, values) = match kind {
            ChannelKind::Vertex => {
                let found = channels.vertex.iter().find(|c| c.name == name)?;
                let parts = (0..found.width).step_by(3).map(|from| {
                    let mut cage = self.bare_cage();
                    cage.points = part(&found.values, found.width, from);
                    Self::new(cage, &self.same_options())
                });
                (found.width, Values::Vertex(parts.collect()))
            }
            ChannelKind::Uniform => {
                let found = channels.uniform.iter().find(|c| c.name == name)?;
                match &found.values {
                    UniformValues::Numbers { width, values } => (*width, Values::Uniform(values)),
                    UniformValues::Ids(_) => return None,
                }
            }
            ChannelKind::FaceVarying => {
                let found = channels.face_varying.iter().find(|c| c.name == name)?;
                let parts = (0..found.width).step_by(2);
                let parts = parts.map(|from| self.of_corners(found, from)).collect();
                (found.width, Values::FaceVarying(parts))
            }
        };
        Some(ChannelSurface {
            surface: self,
            width,
            values,
        })
    }

    /// The cage with nothing but points and tags.
    fn bare_cage(&self) -> crate::Cage {
        let cage = self.cage();
        crate::Cage {
            points: cage.points.clone(),
            face_offsets: cage.face_offsets.clone(),
            corner_vertices: cage.corner_vertices.clone(),
            tags: cage.tags.clone(),
            ..crate::Cage::default()
        }
    }

    fn same_options(&self) -> SurfaceOptions {
        SurfaceOptions {
            scheme: Some(self.scheme()),
            ..*self.options()
        }
    }

    fn of_corners(&self, channel: &FaceVaryingChannel, from: usize) -> Self {
        let mut cage = self.bare_cage();
        cage.uvs = part(&channel.values, channel.width, from);
        cage.corner_uvs = channel.corners.clone();
        let options = SurfaceOptions {
            face_varying: Some(channel.rule.unwrap_or(self.face_varying_rule())),
            ..self.same_options()
        };
        Self::new(cage, &options)
    }

    /// Whether there is something at a place.
    fn holds(&self, face: u32, u: f32, v: f32) -> bool {
        if self.scheme().is_interpolating() {
            table::holds(self, face, u, v)
        } else if self.is_triangular() {
            TriangleEvaluator::locate(self, face, u, v).is_some()
        } else {
            QuadEvaluator::locate(self, face, u, v).is_some()
        }
    }
}

impl ChannelSurface<'_> {
    /// Numbers per value, 1 to 4.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// The value at a place of face `face` of the cage, with zeros after its [`width`](ChannelSurface::width) numbers. `None` where
    /// [`Surface::evaluate`] finds nothing.
    #[must_use]
    pub fn at(&self, face: u32, u: f32, v: f32) -> Option<[f32; 4]> {
        let mut out = [0.0; 4];
        match &self.values {
            Values::Vertex(parts) => {
                for (out, part) in out.chunks_mut(3).zip(parts) {
                    copy(out, &part.evaluate_as::<[f32; 3]>(face, u, v)?);
                }
            }
            Values::Uniform(values) => {
                if !self.surface.holds(face, u, v) {
                    return None;
                }
                let start = face as usize * self.width;
                copy(&mut out, values.get(start..start + self.width)?);
            }
            Values::FaceVarying(parts) => {
                for (out, part) in out.chunks_mut(2).zip(parts) {
                    copy(out, &part.face_evaluator(face)?.uv(u, v)?);
                }
            }
        }
        Some(out)
    }
}

/// As much of `from` as there is room for.
fn copy(to: &mut [f32], from: &[f32]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
    }
}
