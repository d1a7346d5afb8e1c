//! The one way back: the picture, and for tests what else lies on the device.

use super::device::Gpu;
use super::error::GpuError;
use super::records::POINT_FLOATS;
use std::ops::RangeBounds;
use wgpu::BufferUsages as Usage;

/// A block as it stands on the device, for tests.
#[doc(hidden)]
#[derive(Clone, Debug)]
pub struct ReadBlock {
    /// Its quad, of its object.
    pub quad: u32,
    /// Its first point, on the grid of its level.
    pub start: [u32; 2],
    /// Points along a side.
    pub side: usize,
    /// Position and normal of every point, row by row.
    pub points: Vec<[f32; POINT_FLOATS as usize]>,
}

/// Waits for a buffer that can be mapped and returns a part of it.
pub(super) fn read(
    gpu: &Gpu,
    staging: &wgpu::Buffer,
    part: impl RangeBounds<u64> + Clone,
) -> Result<Vec<u8>, GpuError> {
    let bytes = mapped(gpu, staging, part);
    // Else nothing could be copied there any more.
    staging.unmap();
    bytes
}

fn mapped(
    gpu: &Gpu,
    staging: &wgpu::Buffer,
    part: impl RangeBounds<u64> + Clone,
) -> Result<Vec<u8>, GpuError> {
    let lost = || GpuError::Device {
        reason: "the picture cannot be read back".to_owned(),
    };
    let (told, mapped) = std::sync::mpsc::channel();
    staging.map_async(wgpu::MapMode::Read, part.clone(), move |result| {
        // Whoever waited may be gone.
        let _ = told.send(result.is_ok());
    });
    gpu.wait()?;
    if mapped.recv() != Ok(true) {
        gpu.check()?;
        return Err(lost());
    }
    let bytes = staging.get_mapped_range(part).map_err(|_| lost())?.to_vec();
    Ok(bytes)
}

/// Reads floats of a buffer back, for tests.
pub(super) fn read_floats(
    gpu: &Gpu,
    buffer: &wgpu::Buffer,
    bytes: u64,
) -> Result<Vec<f32>, GpuError> {
    let staging = gpu.empty("test", bytes, Usage::COPY_DST | Usage::MAP_READ)?;
    let mut encoder = gpu
        .device()
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, bytes);
    gpu.queue().submit([encoder.finish()]);
    let found = read(gpu, &staging, ..)?;
    // Buffers are a little longer.
    let floats = found[..bytes as usize].as_chunks::<4>().0.iter();
    Ok(floats.map(|b| f32::from_le_bytes(*b)).collect())
}
