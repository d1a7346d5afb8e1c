//! earmark: subdivision surfaces without a GPU, from control cage to finished picture on CPU cores.
//!
//! Each quad of a control cage is refined on its own from its *ear stencil* (its one-ring): a block of at most 33×33 points of the
//! exact Catmull-Clark limit surface is diced in cache, projected, rasterised into a tile's z-buffer, shaded, and forgotten. The
//! refined mesh is never stored. Shared edges are evaluated by the edge's own rule, so both faces get the same bits; coverage is
//! decided by integers, every sample exactly once; sums have a fixed order, so one input gives one picture, byte for byte, for any
//! number of threads and any vector instructions.
//!
//! A picture in five lines:
//!
//! ```
//! # let cage_bytes = b"v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n";
//! use earmark::{Cage, Camera, Renderer, Scene, Surface, mesh::obj, mesh::resolver::NoFiles};
//!
//! let cage = obj::read(cage_bytes, "sheet.obj", &mut NoFiles, &Default::default())?.cage;
//! let scene = Scene::of(Surface::new(cage, &Default::default()));
//! let frame = Renderer::new(64, 64).render(&scene, &Camera::default())?;
//! let png = earmark::film::png::encode(&frame.image)?;
//! # assert_eq!(frame.image.pixel(32, 32)[3], 255);
//! # assert_eq!(&png[1..4], b"PNG");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Limit points with unit normals in four: see [`Surface`]. Files, materials and textures: [`load`]. The way through the code:
//! [`architecture`]. For users: the [`guide`].
//!
//! # Features
//!
//! | feature | brings | default |
//! |---|---|---|
//! | `cli` | the `earmark` program: argument parser and JSON | yes |
//! | `window` | the preview window, module `window`, and `earmark view` | no |
//! | `gpu` | the same stages on a GPU ([`gpu`]), through wgpu | no |
//!
//! A library user writes `default-features = false`.
//!
//! # Scope and current state
//!
//! * Catmull-Clark, Loop, bilinear, Modified Butterfly and Kobbelt's scheme on meshes of any valence, with boundaries, holes, creases of any
//!   sharpness, darts and corners: in pictures, in points and derivatives anywhere ([`evaluate`]), and as whole meshes ([`refine`]).
//! * Modified Butterfly and Kobbelt's scheme know infinite creases only, and are evaluated at dyadic places.
//! * At an interior vertex of valence 2 the scheme has no limit normal in general; a defined fallback stands there, never NaN.
//! * Surfaces are opaque: opacity cuts out at one half. One set of studio lights, no shadows.
//! * Pictures are at most 16383 pixels wide and high.

pub mod bake;
pub mod camera;
pub mod compare;
pub(crate) mod control;
pub mod dice;
pub mod displace;
pub mod distance;
pub mod evaluate;
pub mod files;
pub mod film;
pub mod frame;
pub mod golden;
pub mod gpu;
pub mod guide;
pub mod limits;
pub mod load;
pub mod math;
pub mod mesh;
pub mod overlay;
pub mod patch;
pub mod raster;
pub mod records;
pub mod refine;
pub mod scheme;
pub mod shade;
pub mod sheet;
pub mod simd;
pub mod stream;
pub mod surface;
pub mod tessellate;
pub mod texture;
pub mod topology;
#[cfg(feature = "window")]
pub mod window;

#[doc = include_str!("architecture.md")]
pub mod architecture {}

pub use camera::Camera;
pub use frame::{Renderer, Scene};
pub use mesh::Cage;
pub use surface::{Surface, SurfaceOptions};
