//! What is drawn: surfaces with their materials, and the textures they share.

use super::Drawing;
use crate::camera::{Sphere, View};
use crate::shade::{NO_MATERIAL, SurfaceMaterial};
use crate::surface::Surface;
use crate::tessellate::{DepthTags, depth_tags};
use crate::texture::Texture;

/// One model of a scene.
#[derive(Clone, Debug)]
pub struct Object {
    /// Its surface.
    pub surface: Surface,
    /// First of its materials in the scene's list; face materials of the cage count from there.
    pub first_material: u32,
    /// Depth tags of the cage's vertices, 0 to 10, for [`Refinement::DepthTags`](super::Refinement::DepthTags); vertices beyond its end
    /// have none, which is 0.
    pub depth_tags: Vec<u8>,
}

/// Models, materials and textures.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The models; faces are numbered through in this order.
    pub objects: Vec<Object>,
    /// Materials of all models.
    pub materials: Vec<SurfaceMaterial>,
    /// Textures of all materials.
    pub textures: Vec<Texture>,
    /// Material of faces that have none; clay, or white under vertex colours or a texture given apart.
    pub default_material: Option<SurfaceMaterial>,
}

impl Scene {
    /// A scene of one surface. Its materials get their colours, no textures.
    #[must_use]
    pub fn of(surface: Surface) -> Self {
        let mut scene = Self::default();
        scene.add(surface, |_| (None, None));
        scene
    }

    /// Adds a surface; `maps` gives, for each of its materials, the indices of colour and opacity texture in
    /// [`Scene::textures`].
    pub fn add(
        &mut self,
        surface: Surface,
        mut maps: impl FnMut(&crate::mesh::Material) -> (Option<u32>, Option<u32>),
    ) {
        let first_material = self.materials.len() as u32;
        for m in surface.cage().materials() {
            let (diffuse, opacity) = maps(m);
            self.materials.push(SurfaceMaterial::from_mtl(
                m.diffuse, m.opacity, diffuse, opacity,
            ));
        }
        self.objects.push(Object {
            surface,
            first_material,
            depth_tags: Vec::new(),
        });
    }

    /// Where the origin of the scene's coordinates is in model units: that of the first object's cage, which the others share. 0 of an empty
    /// scene.
    #[must_use]
    pub fn origin(&self) -> [f64; 3] {
        let first = self.objects.first();
        first.map_or([0.0; 3], |o| o.surface.cage().origin())
    }

    /// A sphere around the limit points of all models, for framing; with displacement, larger by as far as points move.
    #[must_use]
    pub fn bounding_sphere(&self) -> Sphere {
        let mut sphere = self.limit_sphere();
        let reach = |o: &Object| f64::from(o.surface.displacement_reach());
        sphere.radius += self.objects.iter().map(reach).fold(0.0, f64::max);
        sphere
    }

    /// The sphere that a camera frames: around the cages where they are drawn, else [`Scene::bounding_sphere`].
    #[must_use]
    pub fn framed_sphere(&self, drawing: Drawing) -> Sphere {
        match drawing {
            Drawing::Cage => Sphere::of_points(self.objects.iter().flat_map(|o| {
                let cage = o.surface.cage();
                let corners = cage.corner_vertices().iter();
                corners.map(|&v| cage.points()[v as usize])
            })),
            _ => self.bounding_sphere(),
        }
    }

    fn limit_sphere(&self) -> Sphere {
        Sphere::of_points(self.objects.iter().flat_map(|o| {
            let quads = o.surface.quads();
            let drawn = move |h: &u32| !quads.is_hole(quads.face_of(*h));
            (0..quads.half_count() as u32)
                .filter(drawn)
                .map(move |h| o.surface.corner_point(h).0)
        }))
    }

    /// Whether anything has finer normals than its surface.
    pub(crate) fn has_relief(&self) -> bool {
        let mut all = self.materials.iter().chain(&self.default_material);
        all.any(|m| m.relief.is_some())
    }

    /// Whether a face of an object's cage is drawn at all: holes are not, nor is what is more than half transparent.
    pub(crate) fn is_drawn(&self, object: &Object, face: u32) -> bool {
        let material = self.materials.get(object.material(face) as usize);
        !object.surface.topology().is_hole(face) && !material.is_some_and(SurfaceMaterial::is_clear)
    }

    /// Faces of all cages.
    #[must_use]
    pub fn face_count(&self) -> usize {
        self.objects
            .iter()
            .map(|o| o.surface.cage().face_count())
            .sum()
    }
}

impl Object {
    /// Whether its normals come from the slopes of a map, pixel by pixel.
    pub(crate) fn is_shaded_by_map(&self) -> bool {
        self.surface
            .displacement()
            .is_some_and(|d| d.pixel_map().is_some())
    }

    /// Depth tags of the cage's vertices in a view.
    pub(super) fn tags(&self, view: &View, wanted: &DepthTags) -> Vec<u8> {
        depth_tags::vertex_tags(&self.surface, view, wanted, &self.depth_tags)
    }

    /// Material of a face of the cage, as an index into the scene's list.
    #[must_use]
    pub fn material(&self, face: u32) -> u32 {
        let of_cage = self.surface.cage().face_materials.get(face as usize);
        self.material_of(of_cage.copied().unwrap_or(crate::mesh::NONE))
    }

    /// One of the cage's materials as an index into the scene's list.
    pub(super) fn material_of(&self, of_cage: u32) -> u32 {
        match of_cage {
            crate::mesh::NONE => NO_MATERIAL,
            m => self.first_material + m,
        }
    }
}
