//! Triangles in place of polygons, for schemes that know nothing else.
//!
//! A quad is cut along its shorter diagonal, along that of its first corner if both are as long; other polygons become fans around their
//! first corner. Vertices, creases, corners and rules stay; texture coordinates, normals, materials, channels and holes go with their
//! faces.

use super::cage::Cage;
use super::channel::{CageChannels, FaceVaryingChannel, UniformChannel, UniformValues};
use std::cmp::Ordering;

/// Corners of a polygon of `count`, as it is drawn where it is flat: those of a quad, or of triangle `k` of its fan around the first, with the
/// last one twice.
pub(crate) fn fan_corners(count: usize, k: u32) -> [u32; 4] {
    match count {
        4 => [0, 1, 2, 3],
        _ => [0, k + 1, k + 2, k + 2],
    }
}

impl Cage {
    /// The first face that is no triangle.
    #[must_use]
    pub fn first_polygon(&self) -> Option<u32> {
        (0..self.face_count())
            .find(|&f| self.face(f).len() != 3)
            .map(|f| f as u32)
    }

    /// The same cage of triangles. Face `f` of this one becomes as many as it has corners less two, in order.
    #[must_use]
    pub fn triangulated(&self) -> Self {
        // Old corner of every new one, and old face of every new one.
        let mut corners: Vec<u32> = Vec::with_capacity(self.corner_vertices.len());
        let mut faces: Vec<u32> = Vec::new();
        for f in 0..self.face_count() {
            let first = self.face_offsets[f];
            let n = self.face_offsets[f + 1] - first;
            let turn = u32::from(n == 4 && self.second_diagonal_is_shorter(f));
            for i in 1..n - 1 {
                corners.extend([0, i, i + 1].map(|k| first + (k + turn) % n));
                faces.push(f as u32);
            }
        }
        let pick = |of_corners: &[u32]| -> Vec<u32> {
            let value = |&c: &u32| of_corners.get(c as usize).copied();
            corners.iter().filter_map(value).collect()
        };
        let mut tags = self.tags.clone();
        if !tags.holes.is_empty() {
            let mut is_hole = vec![false; self.face_count()];
            for &f in &tags.holes {
                if let Some(hole) = is_hole.get_mut(f as usize) {
                    *hole = true;
                }
            }
            tags.holes = (0..faces.len() as u32)
                .filter(|&f| is_hole[faces[f as usize] as usize])
                .collect();
        }
        let material = |&f: &u32| self.face_materials.get(f as usize).copied();
        Self {
            points: self.points.clone(),
            origin: self.origin,
            face_offsets: (0..=faces.len() as u32).map(|f| 3 * f).collect(),
            corner_vertices: pick(&self.corner_vertices),
            uvs: self.uvs.clone(),
            corner_uvs: pick(&self.corner_uvs),
            normals: self.normals.clone(),
            corner_normals: pick(&self.corner_normals),
            colors: self.colors.clone(),
            face_materials: faces.iter().filter_map(material).collect(),
            materials: self.materials.clone(),
            tags,
            channels: CageChannels {
                vertex: self.channels.vertex.clone(),
                uniform: self
                    .channels
                    .uniform
                    .iter()
                    .map(|c| inherited(c, &faces))
                    .collect(),
                face_varying: self
                    .channels
                    .face_varying
                    .iter()
                    .map(|c| FaceVaryingChannel {
                        corners: pick(&c.corners),
                        ..c.clone()
                    })
                    .collect(),
            },
        }
    }

    /// Whether every face has four corners.
    pub(crate) fn is_quads(&self) -> bool {
        self.face_offsets.windows(2).all(|w| w[1] - w[0] == 4)
    }

    /// Which quads are better parted from corner 1 to corner 3: the shorter diagonal; of two as long, the one at the lowest vertex.
    pub(crate) fn second_diagonals(&self) -> Vec<bool> {
        let better = |f: usize| {
            let [a, b, c, d] = *self.face(f) else {
                return false;
            };
            match self.diagonal(f, 1).total_cmp(&self.diagonal(f, 0)) {
                Ordering::Less => true,
                Ordering::Equal => b.min(d) < a.min(c),
                Ordering::Greater => false,
            }
        };
        (0..self.face_count()).map(better).collect()
    }

    /// The same cage of quads with those of `turn` beginning at their second corner.
    pub(crate) fn turned(mut self, turn: &[bool]) -> Self {
        let lists = [
            &mut self.corner_vertices,
            &mut self.corner_uvs,
            &mut self.corner_normals,
        ];
        let channels = self.channels.face_varying.iter_mut();
        for list in lists.into_iter().chain(channels.map(|c| &mut c.corners)) {
            for (corners, _) in list.chunks_exact_mut(4).zip(turn).filter(|(_, t)| **t) {
                corners.rotate_left(1);
            }
        }
        self
    }

    fn second_diagonal_is_shorter(&self, f: usize) -> bool {
        self.diagonal(f, 1) < self.diagonal(f, 0)
    }

    /// Squared length of the diagonal at corner `k` of a quad.
    fn diagonal(&self, f: usize, k: usize) -> f64 {
        let p = |k: usize| self.points[self.face(f)[k] as usize].map(f64::from);
        let (a, b) = (p(k), p(k + 2));
        (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum()
    }
}

/// The values of a channel for faces that descend from `faces`.
fn inherited(channel: &UniformChannel, faces: &[u32]) -> UniformChannel {
    let values = match &channel.values {
        UniformValues::Ids(ids) => {
            let of_face = |&f: &u32| ids.get(f as usize).copied();
            UniformValues::Ids(faces.iter().filter_map(of_face).collect())
        }
        UniformValues::Numbers { width, values } => {
            let of_face = |&f: &u32| values.get(f as usize * width..(f as usize + 1) * width);
            let values = faces.iter().filter_map(of_face).flatten().copied();
            UniformValues::Numbers {
                width: *width,
                values: values.collect(),
            }
        }
    };
    UniformChannel {
        name: channel.name.clone(),
        values,
    }
}

#[cfg(test)]
mod tests {
    use super::super::cage::{Corner, Material, NONE};
    use super::*;

    #[test]
    fn everything_goes_with_its_face() {
        let points = [[0.0, 0.0], [2.0, 0.0], [2.5, 1.0], [0.0, 1.0], [-1.0, 0.5]];
        let points = points.map(|[x, y]| [x, y, 0.0]).to_vec();
        // A quad whose second diagonal is the shorter one, and a triangle.
        let mut cage = Cage::new(points, &[4, 3], vec![0, 1, 2, 3, 0, 3, 4])
            .unwrap()
            .with_uvs(vec![[0.0; 2]; 9], vec![1, 2, 3, 4, NONE, 6, 7])
            .unwrap();
        cage.tags.holes = vec![0, 7];
        cage.tags.corners = vec![Corner {
            vertex: 2,
            sharpness: 3.0,
        }];
        cage.materials = vec![Material::default()];
        cage.face_materials = vec![NONE, 0];
        let numbers = UniformValues::Numbers {
            width: 2,
            values: vec![1.0, 2.0, 3.0, 4.0],
        };
        for (name, values) in [("a", UniformValues::Ids(vec![5, 6])), ("b", numbers)] {
            let name = name.to_owned();
            cage.channels.uniform.push(UniformChannel { name, values });
        }
        cage.channels.face_varying.push(FaceVaryingChannel {
            corners: vec![6, 5, 4, 3, 2, 1, 0],
            ..FaceVaryingChannel::default()
        });
        assert_eq!(cage.first_polygon(), Some(0));
        let out = cage.triangulated();
        assert_eq!(out.first_polygon(), None);
        assert_eq!(out.corner_vertices, [1, 2, 3, 1, 3, 0, 0, 3, 4]);
        assert_eq!(out.corner_uvs, [2, 3, 4, 2, 4, 1, NONE, 6, 7]);
        assert_eq!(out.face_materials, [NONE, NONE, 0]);
        assert_eq!(out.tags.holes, [0, 1]);
        assert_eq!(out.tags.corners, cage.tags.corners);
        assert_eq!(out.face_offsets, [0, 3, 6, 9]);
        assert_eq!(out.triangulated(), out);
        let uniform = &out.channels.uniform;
        assert_eq!(uniform[0].values, UniformValues::Ids(vec![5, 5, 6]));
        let numbers = UniformValues::Numbers {
            width: 2,
            values: vec![1.0, 2.0, 1.0, 2.0, 3.0, 4.0],
        };
        assert_eq!(uniform[1].values, numbers);
        let corners = &out.channels.face_varying[0].corners;
        assert_eq!(corners[..], [5, 4, 3, 5, 3, 6, 2, 1, 0]);
    }

    #[test]
    fn ties_and_polygons_go_by_the_first_corner() {
        let points = (0..6)
            .map(|i| [(i as f32).cos(), (i as f32).sin(), 0.0])
            .collect();
        let square = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let cage = Cage::new(square, &[4], vec![0, 1, 2, 3]).unwrap();
        assert_eq!(cage.triangulated().corner_vertices, [0, 1, 2, 0, 2, 3]);
        let cage = Cage::new(points, &[5], vec![5, 0, 1, 2, 3]).unwrap();
        let fan = [5, 0, 1, 5, 1, 2, 5, 2, 3];
        assert_eq!(cage.triangulated().corner_vertices, fan);
    }
}
