//! A finished picture of a device, and what it took.

use super::raster::Raster;
use crate::camera::View;
use crate::film::Image;
use crate::frame::Plane;
use std::time::Duration;

/// What a picture took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GpuStats {
    /// Faces of the cages.
    pub faces: u64,
    /// Micro-triangles.
    pub microtriangles: u64,
    /// Level of each object; of adaptive ones, their deepest.
    pub levels: Vec<u32>,
    /// Pixels with something in them.
    pub pixels_covered: u64,
    /// Bytes written to the device for this picture: points that moved, and the view.
    pub bytes_up: u64,
    /// Bytes read back: the picture, and what was asked for beside it.
    pub bytes_down: u64,
    /// Buffers that were read back.
    pub read_backs: u32,
    /// Whether blocks were decided on the device, for the view that was drawn.
    pub decides: bool,
    /// Faces and edges that ask for more than the deepest level that the device decides on, and are drawn at that.
    pub coarse: u64,
    /// Whether some of these are off by more than twice what is allowed, or are seen by their levels: a [`GpuScene`](super::GpuScene) that
    /// is made for this view has its blocks from the processor.
    pub falls_short: bool,
    /// Chunks of blocks.
    pub chunks: u32,
    /// Bands of rows that the picture was drawn in.
    pub bands: u32,
    /// What drew keys: [`Raster::Compute`] or [`Raster::Hardware`].
    pub raster: Raster,
    /// Bytes of the scene on the device.
    pub scene_bytes: u64,
    /// Shapes of surroundings with a table of weights each.
    pub shapes: u32,
    /// Time on the device by stage, of all bands together; `flatness` and `dice` only for views and points that are new. Empty unless asked for, or where the device
    /// keeps no time or not as many times as there are bands.
    pub stages: Vec<(&'static str, Duration)>,
    /// Wall time from the first byte up to the last one down.
    pub wall: Duration,
}

/// A finished picture.
#[derive(Clone, Debug)]
pub struct GpuFrame {
    /// The picture.
    pub image: Image,
    /// What was asked for beside it, in the order of [`Renderer::aovs`](crate::Renderer::aovs).
    pub planes: Vec<Plane>,
    /// What it took.
    pub stats: GpuStats,
    /// The view that the camera came to.
    pub view: View,
}
