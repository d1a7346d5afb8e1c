//! A frame: the order of its stages. `refinement` finds how far models are refined, `passes` takes items and tiles over threads. The only
//! module that sees all others.
//!
//! ```text
//! (flatness | depth tags ─▶ blocks) quads ─ setup ─▶ screen boxes ─ bin ─▶ per tile: dice ▸ project ▸ rasterise ─▶ keys ─ dice again what is seen ▸ shade ─▶ film ─▶ pixels
//! ```
//!
//! Tiles are independent and each is drawn by one thread from its bin, whose items stand in ascending order. So the picture is the
//! same for any number of threads. No thread waits for another but at the end of a stage.

mod aov;
mod attributes;
mod cage;
#[doc(hidden)]
pub mod coverage;
mod cutout;
#[doc(hidden)]
pub mod deviation;
mod footprint;
mod kept;
mod leaf;
mod level;
mod lit;
mod passes;
mod pixels;
mod prepared;
mod refinement;
mod scene;
mod shading;
mod source;
mod spot;
mod stats;
mod tile;
mod visible;
mod walk;

use crate::camera::{Camera, CameraError, View};
use crate::film::{Film, Image};
use crate::limits::{Budget, LimitError, Limits};
use crate::raster::{Bins, MAX_SCREEN, PixelBox, TileGrid, tile_side};
use crate::records::ScreenSize;
use crate::shade::{LightRig, ShadeMode, Shader, SurfaceMaterial};
use crate::simd::Level as SimdLevel;
use crate::tessellate::Flatness;
use crate::tessellate::patterns::Pool;
use crate::texture::Texture;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

#[cfg(feature = "gpu")]
pub(crate) use aov::Wanted;
pub use aov::{Aov, Plane};
#[cfg(feature = "gpu")]
pub(crate) use leaf::triangles as leaf_triangles;
pub use refinement::Refinement;
pub use scene::{Object, Scene};
pub use source::Drawing;
pub use stats::{FrameStats, Stage, StageTimes};
pub(crate) use walk::{Block, Walk};

use passes::ScratchPool;
use source::Source;

/// Draws scenes.
///
/// ```
/// use earmark::{Cage, Camera, Renderer, Scene, Surface};
///
/// let points = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|b| 2.0 * b as f32 - 1.0)).collect();
/// let corners = vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
/// let cage = Cage::new(points, &[4; 6], corners)?;
/// let scene = Scene::of(Surface::new(cage, &Default::default()));
/// let frame = Renderer::new(64, 64).render(&scene, &Camera::default())?;
/// assert_eq!(frame.image.pixel(32, 32)[3], 255);
/// assert_eq!(frame.image.pixel(0, 0), [0, 0, 0, 0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Renderer {
    /// Size of the picture and samples per pixel.
    pub size: ScreenSize,
    /// How far to refine.
    pub refinement: Refinement,
    /// What of the surface is drawn.
    pub drawing: Drawing,
    /// What the picture shows.
    pub mode: ShadeMode,
    /// Background, sRGB with straight alpha; transparent by default.
    pub background: [u8; 4],
    /// Degrees by which the lights are turned ([`LightRig::turned`]); 0 by default.
    pub light_turn: f64,
    /// Vector instructions; never changes a pixel.
    pub simd: SimdLevel,
    /// Whether what lies behind drawn surfaces is left out before it is diced; never changes a pixel.
    #[doc(hidden)]
    pub leave_out: bool,
    /// What is written beside the picture; never changes a pixel of it.
    pub aovs: Vec<Aov>,
    /// Whether [`FrameStats::times`] is measured.
    pub measure: bool,
    /// Budgets.
    pub limits: Limits,
    /// The view that decides where triangles are, if not the one that is drawn: to see what a change of triangles alone does.
    #[doc(hidden)]
    pub decided_by: Option<View>,
    scratch: ScratchPool,
    patterns: Pool,
}

/// A finished frame.
#[derive(Clone, Debug)]
pub struct Finished {
    /// The picture.
    pub image: Image,
    /// What was asked for beside it, in the order of [`Renderer::aovs`].
    pub planes: Vec<Plane>,
    /// What it took.
    pub stats: FrameStats,
    /// The view that the camera came to.
    pub view: View,
}

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The camera gives none.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// A budget was reached.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// Size or samples are not possible.
    #[error(
        "pictures are 1 to {MAX_SCREEN} pixels wide and high with 1, 4, 8 or 16 samples; {width}x{height} with {samples} is none"
    )]
    Size {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Samples per pixel.
        samples: u32,
    },
    /// Numbers of faces do not fit into the `face` output.
    #[error("the face output numbers {MOST_FACES} faces; the models have {faces}")]
    FaceIds {
        /// Faces of all models.
        faces: usize,
    },
    /// A level above 10.
    #[error("level {level} is above 10")]
    Level {
        /// The level asked for.
        level: u32,
    },
}

/// What a frame is set up for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Use {
    Picture,
    /// Line work: one sample per pixel, and no level whose edges no line could tell apart.
    Lines,
}
/// Most faces whose numbers plus 1 fit into 24 bits.
const MOST_FACES: usize = (1 << 24) - 2;

/// One picture being drawn: what all tiles read.
pub(crate) struct Frame<'a> {
    view: View,
    size: ScreenSize,
    grid: TileGrid,
    bins: Bins,
    /// Screen boxes of all items.
    boxes: Vec<Option<PixelBox>>,
    /// Boxes of displaced blocks by those tiles that were the first to dice them; none if boxes are exact from the beginning.
    seen: Vec<OnceLock<PixelBox>>,
    sources: Vec<Source<'a>>,
    shader: Shader<'a>,
    film: Film,
    simd: SimdLevel,
    leaves_out: bool,
    wants_uvs: bool,
    wanted: aov::Wanted,
    /// Materials with their opacity, by which faces are cut out.
    materials: &'a [SurfaceMaterial],
    textures: &'a [Texture],
}

impl<'a> Frame<'a> {
    /// The opacity map that faces of a material are cut out by.
    #[inline]
    fn cutout(&self, material: u32) -> Option<&'a Texture> {
        let map = self.materials.get(material as usize)?.opacity_map?;
        self.textures.get(map as usize)
    }

    /// Whether faces of a material are too transparent to be drawn at all.
    #[inline]
    fn is_clear(&self, material: u32) -> bool {
        self.materials
            .get(material as usize)
            .is_some_and(SurfaceMaterial::is_clear)
    }

    #[inline]
    fn source_of(&self, item: u32) -> &Source<'a> {
        let k = self.sources.partition_point(|s| s.first_item <= item);
        &self.sources[k - 1]
    }
}

/// Bytes that binning takes: every item once for each tile that it touches, twice while chunks are joined, and the chunks' own tables.
fn bin_bytes(boxes: &[Option<PixelBox>], grid: &TileGrid, side: u32) -> u128 {
    let span = |b: &PixelBox, k: usize| {
        u128::from(b.high[k].max(1) - 1).div_euclid(side.into()) - u128::from(b.low[k] / side) + 1
    };
    let entries: u128 = boxes
        .iter()
        .flatten()
        .map(|b| span(b, 0) * span(b, 1))
        .sum();
    8 * entries + 8 * grid.len() as u128 * (boxes.len() / 4096 + 1) as u128
}

impl Renderer {
    /// A renderer with the defaults of the command line: 4 samples, limit surface within half a pixel, lit, transparent background.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            size: ScreenSize {
                width,
                height,
                samples: 4,
            },
            refinement: Refinement::Default {
                max_level: Flatness::default().max_level,
            },
            drawing: Drawing::Limit,
            mode: ShadeMode::Lit,
            background: [0; 4],
            light_turn: 0.0,
            simd: SimdLevel::detect(),
            leave_out: true,
            aovs: Vec::new(),
            measure: false,
            limits: Limits::default(),
            decided_by: None,
            scratch: ScratchPool::default(),
            patterns: Pool::default(),
        }
    }

    /// Draws `scene` as `camera` sees it. Runs on rayon's current thread pool.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn render(&self, scene: &Scene, camera: &Camera) -> Result<Finished, RenderError> {
        let view = self.view(scene, camera)?;
        self.render_view(scene, &view)
    }

    /// The view of `scene` that `camera` comes to.
    ///
    /// # Errors
    /// [`RenderError`] for sizes and cameras that give no picture.
    pub fn view(&self, scene: &Scene, camera: &Camera) -> Result<View, RenderError> {
        self.check_size()?;
        let sphere = scene.framed_sphere(self.drawing);
        Ok(camera.framing(&sphere, self.size)?)
    }

    /// What is written beside the picture of a scene.
    pub(crate) fn wanted(&self, scene: &Scene, view: &View) -> Result<aov::Wanted, RenderError> {
        let mut wanted = aov::Wanted::new(&self.aovs, view, self.size.samples);
        if wanted.wants(Aov::Position) {
            wanted.set_sphere(&scene.framed_sphere(self.drawing));
        }
        if wanted.wants(Aov::Uv) {
            let cages = scene.objects.iter().map(|o| o.surface.cage());
            wanted.set_uvs(cages.flat_map(|c| c.uvs.iter().copied()));
        }
        let faces = scene.face_count();
        if wanted.wants(Aov::Face) && faces > MOST_FACES {
            return Err(RenderError::FaceIds { faces });
        }
        Ok(wanted)
    }

    /// Takes the buffers of a renderer that has drawn before: fresh memory costs more than it looks like.
    pub fn take_buffers(&mut self, other: &mut Self) {
        std::mem::swap(&mut self.scratch, &mut other.scratch);
        std::mem::swap(&mut self.patterns, &mut other.patterns);
    }

    /// Draws `scene` through a view that is already resolved, for instance that of the frame before.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn render_view(&self, scene: &Scene, view: &View) -> Result<Finished, RenderError> {
        self.with_frame(scene, view, Use::Picture, |frame, mut stats| {
            let begin = Instant::now();
            let (image, planes) = self.tiles(frame, &mut stats)?;
            stats.wall[2] = begin.elapsed();
            Ok(Finished {
                image,
                planes,
                stats,
                view: *view,
            })
        })
    }

    /// Sets a frame up, bins its items, and hands it to `draw`.
    fn with_frame<T>(
        &self,
        scene: &Scene,
        view: &View,
        purpose: Use,
        draw: impl FnOnce(&Frame<'_>, FrameStats) -> Result<T, LimitError>,
    ) -> Result<T, RenderError> {
        self.check_size()?;
        let mut levels = self.levels(scene, view)?;
        let mut size = self.size;
        if purpose == Use::Lines {
            size.samples = 1;
            for (object, level) in scene.objects.iter().zip(&mut levels) {
                *level = walk::level(&object.surface, view, *level);
            }
        }
        let begin = Instant::now();
        let mut budget = Budget::new(&self.limits);
        let decided_by = self.decided_by.as_ref().unwrap_or(view);
        let tessellations = self.tessellations(scene, decided_by, &mut levels, &mut budget)?;
        let spent = begin.elapsed();
        let patterns = tessellations.iter().flatten().map(|t| t.pattern_time);
        let patterns = patterns.sum::<Duration>();
        let [flatness, depth_tags] = match self.refinement {
            Refinement::DepthTags(_) => [Duration::ZERO, spent.saturating_sub(patterns)],
            _ => [spent, Duration::ZERO],
        };
        let flatness_bytes = tessellations
            .iter()
            .flatten()
            .map(|t| t.bytes() + t.tree_bytes);
        let flatness_bytes = flatness_bytes.sum::<usize>() as u64;
        let (sources, item_count) = Source::all(
            scene,
            (self.drawing, purpose),
            &levels,
            tessellations,
            &mut budget,
        )?;
        let microtriangles = sources.iter().map(Source::triangles).sum();
        self.limits.faces(u128::from(microtriangles) / 2)?;
        let wanted = self.wanted(scene, view)?;
        let pixels = u128::from(self.size.width) * u128::from(self.size.height);
        let bytes = self.predicted_bytes(item_count) + wanted.bytes(pixels);
        budget.take("the picture", bytes, 0)?;
        // Opacity decides what is drawn; what is drawn is opaque.
        let solid: Vec<SurfaceMaterial> = scene
            .materials
            .iter()
            .map(|m| SurfaceMaterial {
                opacity: 1.0,
                opacity_map: None,
                ..*m
            })
            .collect();
        let mut shader = Shader::new(self.mode, view, &solid, &scene.textures)
            .with_lights(LightRig::turned(view, self.light_turn))
            .with_simd(self.simd);
        if let Some(material) = scene.default_material {
            shader = shader.with_default_material(material);
        }
        if self.is_flat(scene) {
            shader = shader.with_folds();
        }
        let side = tile_side(size.samples, sources.iter().any(Source::is_costly));
        let mut frame = Frame {
            view: *view,
            size,
            grid: TileGrid::new(size, side),
            bins: Bins::default(),
            boxes: Vec::new(),
            seen: Vec::new(),
            sources,
            shader,
            film: Film::new(self.mode.encoding(), self.background),
            simd: self.simd,
            leaves_out: self.leave_out,
            wants_uvs: self.mode == ShadeMode::Uv
                || !scene.textures.is_empty()
                || scene.objects.iter().any(Object::is_shaded_by_map),
            wanted,
            materials: &scene.materials,
            textures: &scene.textures,
        };
        let mut stats = FrameStats {
            faces: scene.face_count() as u64,
            microtriangles,
            levels,
            flatness,
            depth_tags,
            patterns,
            flatness_bytes,
            ..FrameStats::default()
        };
        let begin = Instant::now();
        // Line work looks beyond the borders of tiles, at what is in their bins.
        if purpose == Use::Picture && frame.sources.iter().any(Source::has_wide_hulls) {
            frame.seen.resize_with(item_count as usize, OnceLock::new);
        }
        let boxes = self.setup(&frame, item_count, &mut stats.diced_in_setup)?;
        stats.wall[0] = begin.elapsed();
        self.limits.memory(
            "the bins of the tiles",
            bin_bytes(&boxes, &frame.grid, side),
        )?;
        let begin = Instant::now();
        frame.bins = Bins::new(&frame.grid, &boxes);
        frame.boxes = boxes;
        stats.wall[1] = begin.elapsed();
        Ok(draw(&frame, stats)?)
    }

    pub(crate) fn check_size(&self) -> Result<(), RenderError> {
        let ScreenSize {
            width,
            height,
            samples,
        } = self.size;
        let fits = |n: u32| (1..=MAX_SCREEN).contains(&n);
        if fits(width) && fits(height) && matches!(samples, 1 | 4 | 8 | 16) {
            Ok(())
        } else {
            Err(RenderError::Size {
                width,
                height,
                samples,
            })
        }
    }

    /// Bytes that a frame takes beside the scene: boxes and bins of the quads, the picture twice, and the tiles of the threads.
    fn predicted_bytes(&self, items: u32) -> u128 {
        let pixels = u128::from(self.size.width) * u128::from(self.size.height);
        let tile = 16_u128 << 20;
        pixels * 8 + u128::from(items) * 64 + tile * rayon::current_num_threads() as u128
    }
}
