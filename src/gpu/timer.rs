//! Time on the device: a pair of time stamps per stage.

use super::device::Gpu;
use super::error::GpuError;
use super::read_back::read;
use std::time::Duration;
use wgpu::BufferUsages as Usage;

/// Most time stamps of a set, in WebGPU.
const MOST: u32 = 4096;

/// Begins a pass, whose time is kept as that of stage `number` where time is kept.
pub(super) fn pass<'e>(
    timer: Option<&Timer>,
    encoder: &'e mut wgpu::CommandEncoder,
    name: &'static str,
    number: u32,
) -> wgpu::ComputePass<'e> {
    encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
        label: Some(name),
        timestamp_writes: timer.map(|t| t.of_stage(number)),
    })
}

/// Begins the last pass of a stage of several, of which [`opening`] is the first.
pub(super) fn last_pass<'e>(
    timer: Option<&Timer>,
    encoder: &'e mut wgpu::CommandEncoder,
    name: &'static str,
    number: u32,
) -> wgpu::ComputePass<'e> {
    encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
        label: Some(name),
        timestamp_writes: timer.map(|t| wgpu::ComputePassTimestampWrites {
            beginning_of_pass_write_index: None,
            ..t.of_stage(number)
        }),
    })
}

/// Where it is kept when a stage begins, in its first pass.
pub(super) fn opening(
    timer: Option<&Timer>,
    number: u32,
) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
    timer.map(|t| wgpu::RenderPassTimestampWrites {
        query_set: &t.set,
        beginning_of_pass_write_index: Some(2 * number),
        end_of_pass_write_index: None,
    })
}

/// Time stamps of some stages.
#[derive(Debug)]
pub(super) struct Timer {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    staging: wgpu::Buffer,
}

impl Timer {
    /// For some stages; nothing where the device keeps no time, or has not so many stamps.
    pub(super) fn of_stages(gpu: &Gpu, stages: u32) -> Result<Option<Self>, GpuError> {
        if !gpu.timestamps || stages > MOST / 2 {
            return Ok(None);
        }
        let set = gpu.device().create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("stages"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * stages,
        });
        let bytes = 16 * u64::from(stages);
        Ok(Some(Self {
            set,
            resolved: gpu.empty("times", bytes, Usage::QUERY_RESOLVE | Usage::COPY_SRC)?,
            staging: gpu.empty("times", bytes, Usage::COPY_DST | Usage::MAP_READ)?,
        }))
    }

    fn of_stage(&self, stage: u32) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: Some(2 * stage),
            end_of_pass_write_index: Some(2 * stage + 1),
        }
    }

    /// Copies the stamps of the first `stages`, all of which have been passed.
    pub(super) fn resolve(&self, encoder: &mut wgpu::CommandEncoder, stages: u32) {
        encoder.resolve_query_set(&self.set, 0..2 * stages, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.staging, 0, self.staging.size());
    }

    /// Times of the first `stages`, once the device is done.
    pub(super) fn read(&self, gpu: &Gpu, stages: u32) -> Result<Vec<Duration>, GpuError> {
        let bytes = read(gpu, &self.staging, ..)?;
        let period = f64::from(gpu.queue().get_timestamp_period());
        let ticks: Vec<u64> = bytes
            .as_chunks::<8>()
            .0
            .iter()
            .map(|b| u64::from_le_bytes(*b))
            .collect();
        let spent = |[begin, end]: &[u64; 2]| {
            Duration::from_nanos((end.saturating_sub(*begin) as f64 * period) as u64)
        };
        let pairs = ticks.as_chunks::<2>().0.iter().take(stages as usize);
        Ok(pairs.map(spent).collect())
    }
}
