//! Cages from arrays, piece by piece, with everything that a file can say and channels that none can.
//!
//! Nothing is checked before [`CageBuilder::build`], which names the first thing that is wrong; so pieces may come in any order.

use super::channel::{
    CageChannels, FaceVaryingChannel, UniformChannel, UniformValues, VertexChannel,
};
use super::{Cage, CageError, Corner, Crease, Material, Tags};
use crate::scheme::{Boundary, CreaseMethod, FaceVaryingRule, Scheme, TriangleRule};

mod check;

/// Collects a [`Cage`]; made by [`Cage::builder`].
///
/// ```
/// use earmark::Cage;
/// let sheet = Cage::builder()
///     .points([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [2.0, 1.0, 0.0]])
///     .face([0, 1, 4, 3])
///     .face([1, 2, 5, 4])
///     .crease(1, 4, 2.5)
///     .corner(5, 10.0)
///     .vertex_channel("weight", 1, [0.0, 0.5, 1.0, 0.0, 0.5, 1.0])
///     .build()?;
/// assert_eq!(sheet.face_count(), 2);
/// # Ok::<(), earmark::mesh::CageError>(())
/// ```
#[derive(Clone, Debug, Default)]
#[must_use]
pub struct CageBuilder {
    points: Vec<[f32; 3]>,
    sizes: Vec<u32>,
    corners: Vec<u32>,
    uvs: Option<(Vec<[f32; 2]>, Vec<u32>)>,
    colors: Vec<[f32; 3]>,
    materials: Option<(Vec<Material>, Vec<u32>)>,
    tags: Tags,
    channels: CageChannels,
}

impl CageBuilder {
    /// Adds points.
    pub fn points(mut self, points: impl IntoIterator<Item = [f32; 3]>) -> Self {
        self.points.extend(points);
        self
    }
    /// Adds a face by its vertices, counter-clockwise seen from outside.
    pub fn face(mut self, vertices: impl IntoIterator<Item = u32>) -> Self {
        let before = self.corners.len();
        self.corners.extend(vertices);
        self.sizes.push((self.corners.len() - before) as u32);
        self
    }
    /// Adds faces: the number of corners of each, and the vertices of all of them.
    pub fn faces(
        mut self,
        sizes: impl IntoIterator<Item = u32>,
        corners: impl IntoIterator<Item = u32>,
    ) -> Self {
        self.sizes.extend(sizes);
        self.corners.extend(corners);
        self
    }
    /// Makes the edge between two vertices sharp: 0 is smooth, 10 and above infinitely sharp. The last one of an edge holds.
    pub fn crease(mut self, a: u32, b: u32, sharpness: f32) -> Self {
        self.tags.creases.push(Crease {
            vertices: [a, b],
            sharpness,
        });
        self
    }
    /// Makes many edges sharp.
    pub fn creases(mut self, creases: impl IntoIterator<Item = Crease>) -> Self {
        self.tags.creases.extend(creases);
        self
    }
    /// Makes a vertex sharp, measured as edges are.
    pub fn corner(mut self, vertex: u32, sharpness: f32) -> Self {
        self.tags.corners.push(Corner { vertex, sharpness });
        self
    }
    /// A face that is refined but not drawn.
    pub fn hole(mut self, face: u32) -> Self {
        self.tags.holes.push(face);
        self
    }
    /// Texture coordinates: values, and per corner the index of its value or [`NONE`](super::NONE).
    pub fn uvs(
        mut self,
        values: impl IntoIterator<Item = [f32; 2]>,
        corners: impl IntoIterator<Item = u32>,
    ) -> Self {
        self.uvs = Some((values.into_iter().collect(), corners.into_iter().collect()));
        self
    }
    /// Linear RGB per vertex.
    pub fn colors(mut self, colors: impl IntoIterator<Item = [f32; 3]>) -> Self {
        self.colors = colors.into_iter().collect();
        self
    }
    /// Materials, and per face an index into them or [`NONE`](super::NONE).
    pub fn materials(
        mut self,
        materials: impl IntoIterator<Item = Material>,
        faces: impl IntoIterator<Item = u32>,
    ) -> Self {
        self.materials = Some((materials.into_iter().collect(), faces.into_iter().collect()));
        self
    }
    /// A channel of `width` numbers per vertex.
    pub fn vertex_channel(
        mut self,
        name: &str,
        width: usize,
        values: impl IntoIterator<Item = f32>,
    ) -> Self {
        self.channels.vertex.push(VertexChannel {
            name: name.to_owned(),
            width,
            values: values.into_iter().collect(),
        });
        self
    }
    /// A channel of one id per face.
    pub fn face_ids(mut self, name: &str, ids: impl IntoIterator<Item = u32>) -> Self {
        self.channels.uniform.push(UniformChannel {
            name: name.to_owned(),
            values: UniformValues::Ids(ids.into_iter().collect()),
        });
        self
    }
    /// A channel of `width` numbers per face.
    pub fn face_channel(
        mut self,
        name: &str,
        width: usize,
        values: impl IntoIterator<Item = f32>,
    ) -> Self {
        self.channels.uniform.push(UniformChannel {
            name: name.to_owned(),
            values: UniformValues::Numbers {
                width,
                values: values.into_iter().collect(),
            },
        });
        self
    }
    /// A channel of `width` numbers per value, and per corner the index of its value or [`NONE`](super::NONE).
    pub fn face_varying(
        mut self,
        name: &str,
        width: usize,
        values: impl IntoIterator<Item = f32>,
        corners: impl IntoIterator<Item = u32>,
    ) -> Self {
        self.channels.face_varying.push(FaceVaryingChannel {
            name: name.to_owned(),
            width,
            values: values.into_iter().collect(),
            corners: corners.into_iter().collect(),
            rule: None,
        });
        self
    }
    /// Adds a whole channel of corners, with a rule of its own if it has one.
    pub fn face_varying_channel(mut self, channel: FaceVaryingChannel) -> Self {
        self.channels.face_varying.push(channel);
        self
    }
    /// The scheme that the cage is meant for.
    pub fn scheme(mut self, scheme: Scheme) -> Self {
        self.tags.scheme = Some(scheme);
        self
    }
    /// The boundary rule.
    pub fn boundary(mut self, rule: Boundary) -> Self {
        self.tags.boundary = Some(rule);
        self
    }
    /// The decay of semi-sharp edges.
    pub fn crease_method(mut self, method: CreaseMethod) -> Self {
        self.tags.crease_method = Some(method);
        self
    }
    /// The rule of texture coordinates and of channels without one.
    pub fn face_varying_rule(mut self, rule: FaceVaryingRule) -> Self {
        self.tags.face_varying = Some(rule);
        self
    }
    /// The weights beside triangles.
    pub fn triangle_rule(mut self, rule: TriangleRule) -> Self {
        self.tags.triangles = Some(rule);
        self
    }

    /// Checks all pieces and puts them together.
    ///
    /// # Errors
    /// [`CageError`] names the first thing that is wrong.
    pub fn build(self) -> Result<Cage, CageError> {
        let mut cage = Cage::new(self.points, &self.sizes, self.corners)?;
        check::tags(&cage, &self.tags)?;
        if let Some((values, corners)) = self.uvs {
            check::finite("uvs", values.as_flattened())?;
            cage = cage.with_uvs(values, corners)?;
        }
        if !self.colors.is_empty() {
            check::count("colors", self.colors.len(), cage.points.len())?;
            check::finite("colors", self.colors.as_flattened())?;
            cage.colors = self.colors;
        }
        if let Some((materials, faces)) = self.materials {
            check::count("materials of faces", faces.len(), cage.face_count())?;
            check::in_range("materials", &faces, materials.len())?;
            cage.materials = materials;
            cage.face_materials = faces;
        }
        check::channels(&cage, &self.channels)?;
        cage.tags = self.tags;
        cage.channels = self.channels;
        Ok(cage)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::NONE;

    fn sheet() -> CageBuilder {
        Cage::builder()
            .points([[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
            .points([[0.5, 2.0, 0.0]])
            .face([0, 1, 2, 3])
            .face([3, 2, 4])
    }

    #[test]
    fn everything_arrives() {
        let cage = sheet()
            .crease(2, 3, 1.5)
            .corner(4, 10.0)
            .hole(1)
            .uvs([[0.0; 2], [1.0; 2]], [0, 1, 1, 0, 0, 1, NONE])
            .colors([[0.5; 3]; 5])
            .materials([Material::default()], [0, NONE])
            .vertex_channel("heat", 2, [0.25; 10])
            .face_ids("part", [7, 8])
            .face_channel("tint", 3, [0.5; 6])
            .face_varying("light", 4, [0.5; 8], [0, 1, 0, 1, 0, 1, 0])
            .scheme(Scheme::Bilinear)
            .boundary(Boundary::EdgeOnly)
            .crease_method(CreaseMethod::Chaikin)
            .face_varying_rule(FaceVaryingRule::All)
            .triangle_rule(TriangleRule::Smooth)
            .build()
            .unwrap();
        let tags = cage.tags();
        assert_eq!(tags.creases[0].vertices, [2, 3]);
        assert_eq!((tags.corners[0].vertex, tags.holes[0]), (4, 1));
        assert_eq!(tags.scheme, Some(Scheme::Bilinear));
        assert_eq!(tags.boundary, Some(Boundary::EdgeOnly));
        assert_eq!(tags.crease_method, Some(CreaseMethod::Chaikin));
        assert_eq!(tags.face_varying, Some(FaceVaryingRule::All));
        assert_eq!(tags.triangles, Some(TriangleRule::Smooth));
        assert_eq!(cage.uvs().len(), 2);
        assert_eq!(cage.colors().len(), 5);
        assert_eq!(cage.face_material_index(1), None);
        assert_eq!(cage.channels().vertex[0].width, 2);
        assert_eq!(cage.channels().uniform.len(), 2);
        assert_eq!(cage.channels().face_varying[0].corners.len(), 7);
    }

    #[test]
    fn the_first_mistake_is_named() {
        let message = |b: CageBuilder| b.build().unwrap_err().to_string();
        assert_eq!(
            message(sheet().crease(0, 2, 1.0)),
            "no edge joins vertices 0 and 2"
        );
        assert_eq!(
            message(sheet().crease(0, 1, f32::NAN)),
            "sharpness NaN of edge 0-1; it must be 0 or more"
        );
        assert_eq!(
            message(sheet().corner(5, 1.0)),
            "corner names vertex 5, but there are 5"
        );
        assert_eq!(
            message(sheet().hole(2)),
            "hole names face 2, but there are 2"
        );
        assert_eq!(
            message(sheet().vertex_channel("a", 5, [])),
            "channel a has 5 numbers per value; 1 to 4 are possible"
        );
        assert_eq!(
            message(sheet().vertex_channel("a", 1, [0.0])),
            "a: 1 given, 5 wanted"
        );
        assert_eq!(
            message(
                sheet()
                    .colors([[0.0; 3]; 5])
                    .vertex_channel("color", 1, [0.0; 5])
            ),
            "two channels are called color"
        );
        assert_eq!(
            message(sheet().face_varying("b", 1, [0.0], [0, 0, 0, 0, 0, 0, 1])),
            "b: corner 6 names value 1, but there are 1"
        );
        assert_eq!(
            message(sheet().face_channel("c", 1, [0.0, f32::INFINITY])),
            "c: number 1 is not finite"
        );
        assert_eq!(
            message(sheet().face([0, 1])),
            "face 2 has 2 corners; a face needs at least 3"
        );
    }
}
