//! The control cage, exactly as its author wrote it: no adjacency, global vertex numbers, polygons of any arity.

use super::builder::CageBuilder;
use super::channel::CageChannels;
use super::error::CageError;
use crate::scheme::{Boundary, CreaseMethod, FaceVaryingRule, Scheme, TriangleRule};

/// No index: a corner without texture coordinate or normal, a face without material.
pub const NONE: u32 = u32::MAX;

/// Sharpness of an edge, given by its two vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crease {
    /// Ends of the edge, 0-based.
    pub vertices: [u32; 2],
    /// 0 smooth, 10 and above infinitely sharp.
    pub sharpness: f32,
}

/// Sharpness of a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// The vertex, 0-based.
    pub vertex: u32,
    /// 0 smooth, 10 and above infinitely sharp.
    pub sharpness: f32,
}

/// Subdivision tags of a cage; `None` where the file says nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tags {
    /// Subdivision scheme that the cage is meant for.
    pub scheme: Option<Scheme>,
    /// Creased edges.
    pub creases: Vec<Crease>,
    /// Sharp vertices.
    pub corners: Vec<Corner>,
    /// Faces that are refined but not drawn, 0-based.
    pub holes: Vec<u32>,
    /// Boundary interpolation rule.
    pub boundary: Option<Boundary>,
    /// Face-varying rule.
    pub face_varying: Option<FaceVaryingRule>,
    /// Decay of sharpness.
    pub crease_method: Option<CreaseMethod>,
    /// Triangle rule of Catmull-Clark.
    pub triangles: Option<TriangleRule>,
}

/// A material as far as the cage's files describe it. Paths are relative to the cage's folder and not yet opened.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Its name (`newmtl`).
    pub name: String,
    /// Diffuse colour, sRGB values 0 to 1 as written (`Kd`).
    pub diffuse: [f32; 3],
    /// Opacity, 1 opaque (`d`).
    pub opacity: f32,
    /// Diffuse texture (`map_Kd`).
    pub diffuse_map: Option<String>,
    /// Opacity texture (`map_d`).
    pub opacity_map: Option<String>,
    /// Height texture for bumps (`map_Bump`, `bump`).
    pub bump_map: Option<String>,
    /// Normal map (`norm`).
    pub normal_map: Option<String>,
    /// Displacement texture (`disp`).
    pub displacement_map: Option<String>,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            diffuse: [0.8; 3],
            opacity: 1.0,
            diffuse_map: None,
            opacity_map: None,
            bump_map: None,
            normal_map: None,
            displacement_map: None,
        }
    }
}

/// A control cage: points, polygons, texture coordinates, normals, colours, materials and tags.
///
/// Made by [`Cage::new`] or [`Cage::builder`] from plain arrays, or by [`mesh::obj::read`](crate::mesh::obj::read) from a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cage {
    pub(crate) points: Vec<[f32; 3]>,
    /// Subtracted from every point of the file before rounding to `f32`, added again on export. Zero for cages near the origin.
    pub(crate) origin: [f64; 3],
    /// `face_offsets[f]..face_offsets[f + 1]` are the corners of face `f`.
    pub(crate) face_offsets: Vec<u32>,
    pub(crate) corner_vertices: Vec<u32>,
    pub(crate) uvs: Vec<[f32; 2]>,
    /// Per corner an index into `uvs` or [`NONE`]; empty when no corner has one.
    pub(crate) corner_uvs: Vec<u32>,
    pub(crate) normals: Vec<[f32; 3]>,
    /// Per corner an index into `normals` or [`NONE`]; empty when no corner has one.
    pub(crate) corner_normals: Vec<u32>,
    /// Linear RGB per vertex, empty when the file has none.
    pub(crate) colors: Vec<[f32; 3]>,
    /// Per face an index into `materials` or [`NONE`]; empty when no face has one.
    pub(crate) face_materials: Vec<u32>,
    pub(crate) materials: Vec<Material>,
    pub(crate) tags: Tags,
    pub(crate) channels: CageChannels,
}

impl Cage {
    /// Collects a cage piece by piece.
    pub fn builder() -> CageBuilder {
        CageBuilder::default()
    }

    /// A cage from points and polygons.
    ///
    /// `face_sizes[f]` is the number of corners of face `f`; `corners` lists the vertices of all faces one after the other,
    /// counter-clockwise seen from outside.
    ///
    /// # Errors
    /// [`CageError`] when a face has fewer than 3 corners, an index is out of range, or a coordinate is not finite.
    pub fn new(
        points: Vec<[f32; 3]>,
        face_sizes: &[u32],
        corners: Vec<u32>,
    ) -> Result<Self, CageError> {
        if points.len() >= NONE as usize || corners.len() >= NONE as usize {
            return Err(CageError::TooLarge);
        }
        if let Some(vertex) = points.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
            return Err(CageError::NotFinite { vertex });
        }
        let mut face_offsets = Vec::with_capacity(face_sizes.len() + 1);
        face_offsets.push(0);
        let mut end = 0_usize;
        for (face, &n) in face_sizes.iter().enumerate() {
            if n < 3 {
                return Err(CageError::ShortFace {
                    face,
                    corners: n as usize,
                });
            }
            end += n as usize;
            if end > corners.len() {
                return Err(CageError::WrongCount {
                    what: "corners",
                    got: corners.len(),
                    wanted: end,
                });
            }
            if let Some(&vertex) = corners[end - n as usize..end]
                .iter()
                .find(|&&v| v as usize >= points.len())
            {
                return Err(CageError::NoSuchVertex {
                    face,
                    vertex,
                    count: points.len(),
                });
            }
            face_offsets.push(end as u32);
        }
        if end != corners.len() {
            return Err(CageError::WrongCount {
                what: "corners",
                got: corners.len(),
                wanted: end,
            });
        }
        Ok(Self {
            points,
            face_offsets,
            corner_vertices: corners,
            ..Self::default()
        })
    }

    /// Adds texture coordinates: values, and per corner the index of its value.
    ///
    /// # Errors
    /// [`CageError::WrongCount`] unless there is one index per corner, all in range.
    pub fn with_uvs(mut self, uvs: Vec<[f32; 2]>, corner_uvs: Vec<u32>) -> Result<Self, CageError> {
        if corner_uvs.len() != self.corner_vertices.len() {
            return Err(CageError::WrongCount {
                what: "uv indices",
                got: corner_uvs.len(),
                wanted: self.corner_vertices.len(),
            });
        }
        if let Some(&i) = corner_uvs
            .iter()
            .find(|&&i| i != NONE && i as usize >= uvs.len())
        {
            return Err(CageError::WrongCount {
                what: "uvs",
                got: uvs.len(),
                wanted: i as usize + 1,
            });
        }
        self.uvs = uvs;
        self.corner_uvs = corner_uvs;
        Ok(self)
    }

    /// Moves the origin that points are relative to; the shape stays where it is, but for rounding.
    pub fn move_origin(&mut self, origin: [f64; 3]) {
        let shift: [f64; 3] = std::array::from_fn(|k| self.origin[k] - origin[k]);
        if shift != [0.0; 3] {
            for p in &mut self.points {
                *p = std::array::from_fn(|k| (f64::from(p[k]) + shift[k]) as f32);
            }
        }
        self.origin = origin;
    }

    /// Positions of the cage's vertices, relative to [`Cage::origin`].
    #[must_use]
    pub fn points(&self) -> &[[f32; 3]] {
        &self.points
    }
    /// What was subtracted from the file's positions; zero for cages near the origin.
    #[must_use]
    pub fn origin(&self) -> [f64; 3] {
        self.origin
    }
    /// Number of faces.
    #[must_use]
    pub fn face_count(&self) -> usize {
        self.face_offsets.len().saturating_sub(1)
    }
    /// Vertices of face `f`, counter-clockwise.
    ///
    /// # Panics
    /// When `f` is not below [`Cage::face_count`].
    #[must_use]
    pub fn face(&self, f: usize) -> &[u32] {
        &self.corner_vertices[self.face_offsets[f] as usize..self.face_offsets[f + 1] as usize]
    }
    /// First corner of every face, and one past the last corner at the end.
    #[must_use]
    pub fn face_offsets(&self) -> &[u32] {
        &self.face_offsets
    }
    /// Vertices of all corners, face by face.
    #[must_use]
    pub fn corner_vertices(&self) -> &[u32] {
        &self.corner_vertices
    }
    /// Texture coordinate values.
    #[must_use]
    pub fn uvs(&self) -> &[[f32; 2]] {
        &self.uvs
    }
    /// Per corner an index into [`Cage::uvs`] or [`NONE`]; empty without texture coordinates.
    #[must_use]
    pub fn corner_uvs(&self) -> &[u32] {
        &self.corner_uvs
    }
    /// Normals of the file (`vn`); for `--surface cage` and `pn` only.
    #[must_use]
    pub fn normals(&self) -> &[[f32; 3]] {
        &self.normals
    }
    /// Per corner an index into [`Cage::normals`] or [`NONE`]; empty without normals.
    #[must_use]
    pub fn corner_normals(&self) -> &[u32] {
        &self.corner_normals
    }
    /// Linear RGB per vertex; empty without colours.
    #[must_use]
    pub fn colors(&self) -> &[[f32; 3]] {
        &self.colors
    }
    /// Material of face `f`.
    #[must_use]
    pub fn face_material(&self, f: usize) -> Option<&Material> {
        self.materials.get(*self.face_materials.get(f)? as usize)
    }
    /// Index of the material of face `f` in [`Cage::materials`].
    #[must_use]
    pub fn face_material_index(&self, f: usize) -> Option<usize> {
        let index = *self.face_materials.get(f)?;
        (index != NONE).then_some(index as usize)
    }
    /// All materials.
    #[must_use]
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }
    /// Subdivision tags.
    #[must_use]
    pub fn tags(&self) -> &Tags {
        &self.tags
    }
    /// Named values per vertex, face and corner.
    #[must_use]
    pub fn channels(&self) -> &CageChannels {
        &self.channels
    }
    /// Smallest and largest coordinates of the vertices that belong to a face; zeros for an empty cage.
    #[must_use]
    pub fn bounds(&self) -> [[f32; 3]; 2] {
        let mut lo = [f32::INFINITY; 3];
        let mut hi = [f32::NEG_INFINITY; 3];
        for &v in &self.corner_vertices {
            for (k, &c) in self.points[v as usize].iter().enumerate() {
                lo[k] = lo[k].min(c);
                hi[k] = hi[k].max(c);
            }
        }
        if self.corner_vertices.is_empty() {
            [[0.0; 3]; 2]
        } else {
            [lo, hi]
        }
    }
}
