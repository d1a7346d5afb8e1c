//! A picture on a device: bands of rows whose keys fit a binding, drawn one after the other into the same buffers.

use super::device::Gpu;
use super::error::GpuError;
use super::flatness::COUNT_BYTES;
use super::outputs::Outputs;
use super::pipelines::{Pipelines, Stage};
use super::records::{Frame, Record, words};
use super::timer::{self, Timer};
use super::upload::{DeviceChunk, uniform};
use super::wgsl::GROUP;
use crate::limits::Budget;
use crate::records::ScreenSize;
use wgpu::BufferUsages as Usage;

/// Workgroups that share the list of large quads.
const LARGE_GROUPS: u32 = 1024;

/// Stages of a band that are timed, in the order of their passes.
pub(super) const TIMED: [&str; 3] = ["tile", "shade", "film"];

struct Band {
    rows: [u32; 2],
    frame: wgpu::Buffer,
    /// Per chunk and pass.
    tile: Vec<Vec<wgpu::BindGroup>>,
    large: Vec<Vec<wgpu::BindGroup>>,
    shade: Vec<wgpu::BindGroup>,
    /// Per chunk where anything is written beside the picture.
    outputs: Vec<wgpu::BindGroup>,
    film: wgpu::BindGroup,
}

/// All bands of a picture.
pub(super) struct Bands {
    size: ScreenSize,
    bands: Vec<Band>,
    keys: wgpu::Buffer,
    sums: wgpu::Buffer,
    /// A band of the picture.
    image: wgpu::Buffer,
    /// The same of what is written beside it.
    codes: wgpu::Buffer,
    outputs: Outputs,
    /// The whole picture, what is beside it, and counts, on their way down.
    staging: wgpu::Buffer,
}

/// What is read of a scene beside its chunks.
pub(super) struct Shared<'a> {
    pub(super) materials: &'a wgpu::Buffer,
    pub(super) textures: &'a wgpu::Buffer,
    pub(super) heights: &'a wgpu::Buffer,
}

impl Bands {
    pub(super) fn new(
        gpu: &Gpu,
        pipelines: &Pipelines,
        (size, outputs): (ScreenSize, Outputs),
        chunks: &[DeviceChunk],
        shared: &Shared<'_>,
        budget: &mut Budget<'_>,
    ) -> Result<Self, GpuError> {
        let words = u64::from(outputs.words());
        // Rows whose keys, sums of 16 bytes a pixel, and codes fit a binding.
        let pixel_bytes = (8 * u64::from(size.samples)).max(16).max(4 * words);
        let row_bytes = u64::from(size.width) * pixel_bytes;
        let rows = (gpu.max_binding / row_bytes).clamp(1, u64::from(size.height)) as u32;
        let band_pixels = u64::from(size.width) * u64::from(rows);
        let storage = Usage::STORAGE | Usage::COPY_DST;
        let down = storage | Usage::COPY_SRC;
        let keys = gpu.empty("keys", band_pixels * 8 * u64::from(size.samples), storage)?;
        let sums = gpu.empty("sums", band_pixels * 16, storage)?;
        let image = gpu.empty("picture", 4 * band_pixels, down)?;
        let codes = gpu.empty("outputs", 4 * words * band_pixels, down)?;
        let pixels = u64::from(size.width) * u64::from(size.height);
        let all_bytes = 4 * (1 + words) * pixels;
        // The picture, its bytes as they come down, and what is made of those beside it.
        let kept = u128::from(4 * pixels) + u128::from(all_bytes) + outputs.plane_bytes(pixels);
        budget.take("the picture", kept, 0)?;
        let counts = chunks.iter().filter(|c| c.flatness.is_some()).count() as u64;
        let staging = gpu.empty(
            "picture",
            all_bytes + counts * COUNT_BYTES,
            Usage::COPY_DST | Usage::MAP_READ,
        )?;
        let record = uniform(gpu, &outputs.record())?;
        let mut bands = Vec::new();
        for start in (0..size.height).step_by(rows as usize) {
            let frame = gpu.empty(
                "frame",
                Frame::SIZE as u64,
                Usage::UNIFORM | Usage::COPY_DST,
            )?;
            let drawn = |stage: &Stage, c: &DeviceChunk, phase: usize| {
                stage.bind(
                    gpu,
                    &[
                        (0, &frame),
                        (1, &c.phases[phase]),
                        (2, &c.blocks),
                        (3, &c.points),
                        (4, &keys),
                        (5, &c.large),
                        (6, &c.faces),
                        (7, shared.materials),
                        (8, &c.uvs),
                        (9, shared.textures),
                        (10, &c.lists),
                    ],
                )
            };
            let all = |stage: &Stage| -> Vec<Vec<wgpu::BindGroup>> {
                let phases = |c: &DeviceChunk| 0..c.phases.len();
                let of = |c| phases(c).map(|p| drawn(stage, c, p)).collect();
                chunks.iter().map(of).collect()
            };
            let shown = |stage: &Stage, own: &[(u32, &wgpu::Buffer)]| -> Vec<wgpu::BindGroup> {
                let of = |c: &DeviceChunk| {
                    let read = [
                        (0, &frame),
                        (1, &c.phases[0]),
                        (2, &c.blocks),
                        (3, &c.points),
                        (4, &keys),
                        (5, &c.faces),
                        (6, shared.materials),
                        (8, &c.uvs),
                        (9, shared.textures),
                        (10, &c.colors),
                        (11, &c.tangents),
                        (12, &c.rise),
                        (13, shared.heights),
                        (15, &c.lists),
                    ];
                    stage.bind(gpu, &[&read, own].concat())
                };
                chunks.iter().map(of).collect()
            };
            let film = [(0, &frame), (1, &sums), (2, &image)];
            bands.push(Band {
                rows: [start, (start + rows).min(size.height)],
                tile: all(&pipelines.tile),
                large: all(&pipelines.large),
                shade: shown(&pipelines.shade, &[(7, &sums)]),
                outputs: match words {
                    0 => Vec::new(),
                    _ => shown(pipelines.outputs(gpu)?, &[(7, &codes), (14, &record)]),
                },
                film: pipelines.film.bind(gpu, &film),
                frame,
            });
        }
        Ok(Self {
            size,
            bands,
            keys,
            sums,
            image,
            codes,
            outputs,
            staging,
        })
    }

    pub(super) fn len(&self) -> usize {
        self.bands.len()
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        let all = [&self.keys, &self.sums, &self.image, &self.codes];
        all.iter().map(|b| b.size()).sum()
    }

    pub(super) fn outputs(&self) -> &Outputs {
        &self.outputs
    }

    /// What comes down: the picture, then what is beside it, then counts of blocks that the device decides on.
    pub(super) fn staging(&self) -> &wgpu::Buffer {
        &self.staging
    }

    /// Bytes of the picture, and of it with what is beside it.
    pub(super) fn down(&self) -> [u64; 2] {
        let picture = 4 * u64::from(self.size.width) * u64::from(self.size.height);
        [picture, picture * u64::from(1 + self.outputs.words())]
    }

    /// Sends a view to all bands; returns the bytes that go up.
    pub(super) fn send(&self, queue: &wgpu::Queue, mut frame: Frame) -> u64 {
        let mut up = 0;
        for band in &self.bands {
            [frame.band_start, frame.band_end] = band.rows;
            let words = words(&[frame]);
            queue.write_buffer(&band.frame, 0, bytemuck::cast_slice(&words));
            up += 4 * words.len() as u64;
        }
        up
    }

    /// Draws all bands and copies what they come to.
    pub(super) fn encode(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        (pipelines, chunks): (&Pipelines, &[DeviceChunk]),
        timer: Option<&Timer>,
    ) -> Result<(), GpuError> {
        let [picture, _] = self.down();
        let words = u64::from(self.outputs.words());
        let row_bytes = 4 * u64::from(self.size.width);
        for (k, band) in self.bands.iter().enumerate() {
            let first = (k * TIMED.len()) as u32;
            self.encode_band(gpu, encoder, (pipelines, chunks, timer), (band, first))?;
            let [start, end] = band.rows.map(|row| u64::from(row) * row_bytes);
            encoder.copy_buffer_to_buffer(&self.image, 0, &self.staging, start, end - start);
            if words > 0 {
                let (to, size) = (picture + words * start, words * (end - start));
                encoder.copy_buffer_to_buffer(&self.codes, 0, &self.staging, to, size);
            }
        }
        Ok(())
    }

    /// Draws a band; its passes are numbered from `first` on.
    fn encode_band(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        (p, chunks, timer): (&Pipelines, &[DeviceChunk], Option<&Timer>),
        (band, first): (&Band, u32),
    ) -> Result<(), GpuError> {
        let [tile, shade, film] = TIMED;
        encoder.clear_buffer(&self.keys, 0, None);
        encoder.clear_buffer(&self.sums, 0, None);
        encoder.clear_buffer(&self.codes, 0, None);
        for c in chunks {
            encoder.clear_buffer(&c.large, 0, Some(4));
        }
        let mut pass = timer::pass(timer, encoder, tile, first);
        let phases = chunks.first().map_or(0, |c| c.phases.len());
        for phase in 0..phases {
            for (k, c) in chunks.iter().enumerate() {
                c.by_block(&p.tile, &mut pass, &band.tile[k][phase]);
                p.large.run(&mut pass, &band.large[k][phase], LARGE_GROUPS);
            }
        }
        drop(pass);
        let pixels = self.size.width * (band.rows[1] - band.rows[0]);
        let groups = pixels.div_ceil(GROUP);
        let mut pass = timer::pass(timer, encoder, shade, first + 1);
        for bindings in &band.shade {
            p.shade.run(&mut pass, bindings, groups);
        }
        for bindings in &band.outputs {
            p.outputs(gpu)?.run(&mut pass, bindings, groups);
        }
        drop(pass);
        let mut pass = timer::pass(timer, encoder, film, first + 2);
        p.film.run(&mut pass, &band.film, groups);
        Ok(())
    }
}
