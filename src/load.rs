//! From model files to a scene: cages, materials and textures, with everything worth a warning collected.

use crate::files::{FileError, FolderResolver, read_model};
use crate::frame::Scene;
use crate::limits::LimitError;
use crate::mesh::obj::{self, ReadError, ReadOptions};
use crate::mesh::resolver::Resolver;
use crate::mesh::{Cage, Material, NONE};
use crate::patch::PatchKind;
use crate::shade::{Relief, SurfaceMaterial};
use crate::surface::{Surface, SurfaceOptions};
use crate::texture::{Meaning, Texture};
use crate::topology::TopologyWarning;
use std::collections::BTreeMap;
use std::path::Path;

/// Bytes that all textures of a scene may take together.
pub const TEXTURE_BUDGET: u64 = 1 << 30;

/// Largest texture file.
const TEXTURE_FILE: u64 = 512 << 20;

/// How models are loaded.
#[derive(Clone, Debug)]
pub struct LoadOptions {
    /// How the text is read.
    pub read: ReadOptions,
    /// How cages become surfaces.
    pub surface: SurfaceOptions,
    /// Largest model file.
    pub max_file: u64,
    /// Most bytes that the surface of one model may be predicted to take.
    pub max_surface: u64,
    /// Whether textures are loaded.
    pub textures: bool,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            read: ReadOptions::default(),
            surface: SurfaceOptions::default(),
            max_file: u64::MAX,
            max_surface: u64::MAX,
            textures: true,
        }
    }
}

/// Why a model was not loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The file could not be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// Its text is no cage.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A budget was reached.
    #[error(transparent)]
    Limit(#[from] LimitError),
}

/// About how many bytes a surface takes at its peak, while it is being connected: rounded up from measurements.
pub(crate) fn surface_bytes(cage: &Cage, patches: PatchKind) -> u128 {
    let corners = cage.corner_vertices.len() as u128;
    let values = (cage.points.len() + cage.uvs.len() + cage.colors.len()) as u128;
    let quads = cage.face_offsets.windows(2).all(|w| w[1] - w[0] == 4);
    let per_corner = if quads { PER_CORNER } else { PER_CORNER * 8 };
    let channels = 1 + u128::from(!cage.corner_uvs.is_empty());
    let pn = u128::from(patches == PatchKind::Pn) * (corners * PN_CORNER + values * PN_VERTEX);
    corners * per_corner * channels + values * PER_VERTEX + pn
}

/// What PN triangles keep, and pass through, per corner: two normals, two control points, a middle, a face's normal, a count.
const PN_CORNER: u128 = 96;
/// The same per vertex: a tension, two neighbours along creases.
const PN_VERTEX: u128 = 16;

/// Bytes per corner of a cage of quads. Others are split into four times as many, and are held beside.
const PER_CORNER: u128 = 26;
/// Bytes per vertex, texture coordinate or vertex colour.
const PER_VERTEX: u128 = 80;

/// Loads scenes model by model.
#[derive(Debug)]
pub struct Loader {
    options: LoadOptions,
    scene: Scene,
    warnings: Vec<String>,
    budget: u64,
}

impl Loader {
    /// An empty scene.
    #[must_use]
    pub fn new(options: LoadOptions) -> Self {
        Self {
            options,
            scene: Scene::default(),
            warnings: Vec::new(),
            budget: TEXTURE_BUDGET,
        }
    }

    /// Adds the model of a file.
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn add_file(&mut self, path: &Path) -> Result<(), LoadError> {
        let bytes = read_model(path, self.options.max_file)?;
        let mut resolver = FolderResolver::beside(path)?;
        self.add_bytes(&bytes, &path.display().to_string(), &mut resolver)
    }

    /// Adds the model of a text in memory; `name` is what messages call it.
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn add_bytes(
        &mut self,
        bytes: &[u8],
        name: &str,
        resolver: &mut dyn Resolver,
    ) -> Result<(), LoadError> {
        let read = self.read(bytes, name, resolver)?;
        let line = |face| obj::line_of_face(bytes, &read.report, face);
        self.add_cage_of_lines(read.cage, name, resolver, &line)
    }

    /// The first half of [`Loader::add_bytes`], for who times it: text to cage. Warnings are kept.
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn read(
        &mut self,
        bytes: &[u8],
        name: &str,
        resolver: &mut dyn Resolver,
    ) -> Result<obj::Read, LoadError> {
        let read = obj::read(bytes, name, resolver, &self.options.read)?;
        self.warnings
            .extend(read.warnings.iter().map(ToString::to_string));
        Ok(read)
    }

    /// The second half: cage to surface, with its textures. All models of a scene share the origin of the first.
    ///
    /// # Errors
    /// [`LoadError::Limit`] when the surface would take more than [`LoadOptions::max_surface`].
    pub fn add_cage(
        &mut self,
        cage: Cage,
        name: &str,
        resolver: &mut dyn Resolver,
    ) -> Result<(), LoadError> {
        self.add_cage_of_lines(cage, name, resolver, &|_| None)
    }

    /// The same where the lines of faces can be told: warnings name them. `line_of_face` is asked once or twice, if at all, and may take as
    /// long as reading the text once more ([`obj::line_of_face`]).
    ///
    /// # Errors
    /// [`LoadError::Limit`] when the surface would take more than [`LoadOptions::max_surface`].
    pub fn add_cage_of_lines(
        &mut self,
        mut cage: Cage,
        name: &str,
        resolver: &mut dyn Resolver,
        line_of_face: &dyn Fn(u32) -> Option<usize>,
    ) -> Result<(), LoadError> {
        if let Some(first) = self.scene.objects.first() {
            cage.move_origin(first.surface.cage().origin());
        }
        let wanted = surface_bytes(&cage, self.options.surface.patches);
        if wanted > u128::from(self.options.max_surface) {
            return Err(LoadError::Limit(LimitError::Memory {
                what: "the surface",
                wanted: u64::try_from(wanted).unwrap_or(u64::MAX),
                allowed: self.options.max_surface,
            }));
        }
        let surface = Surface::new(cage, &self.options.surface);
        let place = |w: &TopologyWarning| w.face(surface.topology()).and_then(line_of_face);
        let said = |w: &TopologyWarning| match place(w) {
            Some(line) => format!("{name}:{line}: {w}"),
            None => format!("{name}: {w}"),
        };
        self.warnings.extend(surface.warnings().iter().map(said));
        self.add_surface(surface, name, resolver);
        Ok(())
    }

    fn add_surface(&mut self, surface: Surface, name: &str, resolver: &mut dyn Resolver) {
        let cage = surface.cage();
        let mut used = vec![false; cage.materials.len()];
        for &m in &cage.face_materials {
            if m != NONE {
                used[m as usize] = true;
            }
        }
        let maps = if self.options.textures && surface.has_uvs() {
            self.load_maps(&cage.materials.clone(), &used, name, resolver)
        } else {
            BTreeMap::new()
        };
        if !cage.colors.is_empty() {
            self.scene
                .default_material
                .get_or_insert(SurfaceMaterial::WHITE);
        }
        let map = |name: &Option<String>, meaning: Meaning| {
            name.as_ref()
                .and_then(|n| maps.get(&(n.clone(), meaning == Meaning::Data)).copied())
        };
        let first = self.scene.materials.len();
        let reliefs: Vec<Option<Relief>> = (surface.cage().materials.iter())
            .map(|m| {
                let normals = map(&m.normal_map, Meaning::Data).map(Relief::Normals);
                normals.or_else(|| {
                    let map = map(&m.bump_map, Meaning::Data)?;
                    // Many programs write normal maps as bump maps.
                    Some(match self.scene.textures[map as usize].is_gray() {
                        true => Relief::Heights {
                            map,
                            strength: Relief::BUMP,
                        },
                        false => Relief::Normals(map),
                    })
                })
            })
            .collect();
        self.scene.add(surface, |m| {
            (
                map(&m.diffuse_map, Meaning::Color),
                map(&m.opacity_map, Meaning::Data),
            )
        });
        for (material, relief) in self.scene.materials[first..].iter_mut().zip(reliefs) {
            material.relief = relief;
        }
    }

    /// Loads every map of the used materials once.
    fn load_maps(
        &mut self,
        materials: &[Material],
        used: &[bool],
        model: &str,
        resolver: &mut dyn Resolver,
    ) -> BTreeMap<(String, bool), u32> {
        let mut maps: BTreeMap<(String, bool), Option<u32>> = BTreeMap::new();
        for (material, _) in materials.iter().zip(used).filter(|(_, used)| **used) {
            for (map, meaning) in [
                (&material.diffuse_map, Meaning::Color),
                (&material.opacity_map, Meaning::Data),
                (&material.normal_map, Meaning::Data),
                (&material.bump_map, Meaning::Data),
            ] {
                let Some(map) = map else { continue };
                let key = (map.clone(), meaning == Meaning::Data);
                if maps.contains_key(&key) {
                    continue;
                }
                let loaded = match resolver.read(map, TEXTURE_FILE) {
                    Err(e) => Err(e.to_string()),
                    Ok(bytes) => Texture::decode(&bytes, meaning, &mut self.budget)
                        .map_err(|e| e.to_string()),
                };
                let index = match loaded {
                    Ok(texture) => {
                        self.scene.textures.push(texture);
                        Some(self.scene.textures.len() as u32 - 1)
                    }
                    Err(why) => {
                        self.warnings.push(format!(
                            "{model}: texture {map:?} of material {:?} is left out: {why}",
                            material.name
                        ));
                        None
                    }
                };
                maps.insert(key, index);
            }
        }
        maps.into_iter()
            .filter_map(|(k, v)| Some((k, v?)))
            .collect()
    }

    /// The options, to change budgets between models.
    pub fn options_mut(&mut self) -> &mut LoadOptions {
        &mut self.options
    }

    /// The scene, and what was worth a warning.
    #[must_use]
    pub fn finish(self) -> (Scene, Vec<String>) {
        (self.scene, self.warnings)
    }
}
