//! The same stages on a GPU, through wgpu: feature `gpu`.
//!
//! Without the feature there are only the [`records`] that processor and device share and the sources of the stages ([`wgsl`]), so that
//! a test can hold them together on any machine.
//!
//! # A frame
//!
//! | stage | file | one invocation |
//! |---|---|---|
//! | `sides` | `sides.wgsl` | a corner or a point of a side: evaluated once, from one face's control points, whoever shares it |
//! | `curves` | `sides.wgsl` | the same of displaced patches, whose sides run through other such points |
//! | `flatness` | `flatness.wgsl`, `edges.wgsl`, `blocks.wgsl`, `scan.wgsl` | a workgroup: what a face needs; then an edge, a face: adaptive blocks, for the view of the frame |
//! | `dice` | `dice.wgsl` | points of a block's inside; what lies on sides is copied, so shared points have the same bits |
//! | `tile` | `tile.wgsl` | micro-quads: projected, snapped, covered samples by exact integers into visibility keys |
//! | `large` | `large.wgsl` | quads of many pixels and clipped ones, a workgroup each |
//! | `raster` | `raster.wgsl` | in place of the two before, if `Raster` says so: a corner for the device's own rasteriser, then a pixel |
//! | `shade` | `shade.wgsl` | a pixel: its samples that show one place of the surface together, as on the processor |
//! | `film` | `film.wgsl` | a pixel: resolved and encoded |
//!
//! What is written beside the picture ([`Aov`](crate::frame::Aov)) belongs to `shade`: `outputs.wgsl`, a pixel.
//!
//! Points, normals and keys stay on the device. Up goes what moved: control points and the view. Down comes the picture,
//! with what was asked for beside it.
//!
//! # Adaptive blocks
//!
//! Of smooth Catmull-Clark surfaces the device decides on blocks itself, anew for every view and whenever points move: stage `flatness`. It
//! makes the processor's tests of the same samples, evaluated here, in the same order. An edge is decided on by one invocation; both faces read
//! what came of it. Prefix sums say where blocks go, and what is drawn of them is dispatched by their counts, of which the processor
//! only hears with the picture; more than there is room for is an error then.
//!
//! Its deepest level is that of one block, 5 of a quad. What asks for more (seldom more than the corners of a few faces) is drawn at
//! that and counted; where it would be off by more than twice what is allowed, in pixels or in normals of triangles of more than 4
//! pixels, or is to be seen by its levels, or where the tables of weights do not fit, a scene is made with the blocks that the processor decides on for its view. Unlike there,
//! parts of a face beyond the sides of the picture are not looked for: they are as fine as the rest.
//!
//! # Dicing
//!
//! Every point of a face is a sum of weights times control points, and so are its derivatives: the weights depend on nothing but how the
//! mesh hangs together around the face. They are taken from the processor's own evaluation ([`evaluate`](crate::evaluate)), by control
//! points that are unit vectors, once per *shape* of surroundings; so every scheme and rule that it knows is here, with its exactness. QAS patches
//! are quadratics through points of level 1. Control points of curved PN triangles are made on the processor, from angles at vertices that WGSL
//! would know too roughly; the triangles are evaluated on the device. Interpolating surfaces have no formula for derivatives: where displacement
//! or relief asks for some, they are differences of a block's points, as on the processor.
//!
//! # Whole meshes
//!
//! `Refiner` makes the levels of a cage on a caller's device, in buffers that the caller draws from: `face`, `edge`, `vertex` and
//! `connectivity`, all of them gathers, of quads, triangles (Loop) or any polygons; and `limit`, the limit points and normals of the last.
//!
//! # What is refused
//!
//! Displacement by a caller's rule, n-gons at level 0 of bilinear surfaces, vertices of more than 512 faces. An error names it; nothing is drawn
//! elsewhere instead.
//! Adaptive blocks of other surfaces than these (displaced ones, other schemes, patches) and by depth tags are decided on the processor, for
//! the view that a scene was made for.

pub mod records;
pub mod wgsl;

#[cfg(feature = "gpu")]
mod bands;
#[cfg(feature = "gpu")]
mod chosen;
#[cfg(feature = "gpu")]
mod chunk;
#[cfg(feature = "gpu")]
mod decided;
#[cfg(feature = "gpu")]
mod deciding;
#[cfg(feature = "gpu")]
mod device;
#[cfg(feature = "gpu")]
mod dicer;
#[cfg(feature = "gpu")]
mod draw;
#[cfg(feature = "gpu")]
mod error;
#[cfg(feature = "gpu")]
mod face;
#[cfg(feature = "gpu")]
mod flatness;
#[cfg(feature = "gpu")]
mod further;
#[cfg(feature = "gpu")]
mod levels;
#[cfg(feature = "gpu")]
mod lists;
#[cfg(feature = "gpu")]
mod order;
#[cfg(feature = "gpu")]
mod outputs;
#[cfg(feature = "gpu")]
mod owners;
#[cfg(feature = "gpu")]
mod patches;
#[cfg(feature = "gpu")]
mod pipelines;
#[cfg(feature = "gpu")]
mod plan;
#[cfg(feature = "gpu")]
mod polygon;
#[cfg(feature = "gpu")]
mod raster;
#[cfg(feature = "gpu")]
mod read_back;
#[cfg(feature = "gpu")]
mod ready;
#[cfg(feature = "gpu")]
mod rings;
#[cfg(feature = "gpu")]
mod rise;
#[cfg(feature = "gpu")]
mod room;
#[cfg(feature = "gpu")]
mod sectors;
#[cfg(feature = "gpu")]
mod shapes;
#[cfg(feature = "gpu")]
mod stats;
#[cfg(feature = "gpu")]
mod surroundings;
#[cfg(feature = "gpu")]
mod tables;
#[cfg(feature = "gpu")]
mod timer;
#[cfg(feature = "gpu")]
mod upload;
#[cfg(feature = "gpu")]
mod uv_tables;
#[cfg(feature = "gpu")]
mod view;

#[cfg(feature = "gpu")]
pub use device::{AdapterKind, AdapterSummary, DeviceOptions, Gpu, adapters};
#[cfg(feature = "gpu")]
pub use draw::GpuScene;
#[cfg(feature = "gpu")]
pub use error::GpuError;
#[cfg(feature = "gpu")]
pub use levels::Refiner;
#[cfg(feature = "gpu")]
pub use raster::Raster;
#[cfg(feature = "gpu")]
#[doc(hidden)]
pub use read_back::ReadBlock;
#[cfg(feature = "gpu")]
pub use stats::{GpuFrame, GpuStats};
