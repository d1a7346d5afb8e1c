//! A picture on a device: bands of rows whose keys fit a binding, drawn one after the other into the same buffers.

use super::device::Gpu;
use super::error::GpuError;
use super::flatness::COUNT_BYTES;
use super::outputs::Outputs;
use super::pipelines::{Pipelines, Stage};
use super::raster::{HardwareRaster, Picture, PictureBand, RASTER};
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
/// The same where the device's own rasteriser draws.
const TIMED_BY_HARDWARE: [&str; 3] = [RASTER, "shade", "film"];

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
    /// Of the last band that was drawn.
    pub(super) keys: wgpu::Buffer,
    sums: wgpu::Buffer,
    /// A band of the picture.
    image: wgpu::Buffer,
    /// The same of what is written beside it.
    codes: wgpu::Buffer,
    outputs: Outputs,
    shared: Shared,
    /// What draws keys in place of `tile` and `large`, if that is to be the device's own rasteriser.
    pub(super) by_hardware: Option<HardwareRaster>,
    /// The whole picture, what is beside it, and counts, on their way down.
    staging: wgpu::Buffer,
}

/// What is read of a scene beside its chunks.
pub(super) struct Shared {
    pub(super) materials: wgpu::Buffer,
    pub(super) textures: wgpu::Buffer,
    pub(super) heights: wgpu::Buffer,
}

impl Shared {
    /// What is read of a chunk by all that draws keys.
    fn read_of<'b>(
        &'b self,
        frame: &'b wgpu::Buffer,
        c: &'b DeviceChunk,
        phase: usize,
    ) -> [(u32, &'b wgpu::Buffer); 9] {
        [
            (0, frame),
            (1, &c.phases[phase]),
            (2, &c.blocks),
            (3, &c.points),
            (6, &c.faces),
            (7, &self.materials),
            (8, &c.uvs),
            (9, &self.textures),
            (10, &c.lists),
        ]
    }
}

impl Bands {
    pub(super) fn new(
        gpu: &Gpu,
        pipelines: &Pipelines,
        (size, outputs): (ScreenSize, Outputs),
        chunks: &[DeviceChunk],
        shared: Shared,
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
        let keys = gpu.empty("keys", band_pixels * 8 * u64::from(size.samples), down)?;
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
                let read = shared.read_of(&frame, c, phase);
                stage.bind(gpu, &[&read[..], &[(4, &keys), (5, &c.large)]].concat())
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
                        (6, &shared.materials),
                        (8, &c.uvs),
                        (9, &shared.textures),
                        (10, &c.colors),
                        (11, &c.tangents),
                        (12, &c.rise),
                        (13, &shared.heights),
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
            shared,
            by_hardware: None,
            staging,
        })
    }

    pub(super) fn len(&self) -> usize {
        self.bands.len()
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        let all = [&self.keys, &self.sums, &self.image, &self.codes];
        let by_hardware = self.by_hardware.as_ref().map_or(0, HardwareRaster::bytes);
        by_hardware + all.iter().map(|b| b.size()).sum::<u64>()
    }

    /// Names of the stages of [`TIMED`] as the picture is drawn.
    pub(super) fn timed(&self) -> [&'static str; TIMED.len()] {
        match self.by_hardware {
            Some(_) => TIMED_BY_HARDWARE,
            None => TIMED,
        }
    }

    /// Lets the device's own rasteriser draw keys from now on.
    pub(super) fn make_hardware(
        &mut self,
        gpu: &Gpu,
        pipelines: &Pipelines,
        chunks: &[DeviceChunk],
    ) -> Result<(), GpuError> {
        let bands = self.bands.iter().map(|band| PictureBand {
            rows: band.rows[1] - band.rows[0],
            frame: &band.frame,
            read: (chunks.iter())
                .map(|c| self.shared.read_of(&band.frame, c, 0).to_vec())
                .collect(),
        });
        let picture = Picture {
            size: self.size,
            keys: &self.keys,
            bands: bands.collect(),
        };
        self.by_hardware = Some(HardwareRaster::new(gpu, pipelines, &picture, chunks)?);
        Ok(())
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
            self.encode_keys(gpu, encoder, (pipelines, chunks, timer), (k, first))?;
            self.encode_band(gpu, encoder, (pipelines, timer), (band, first))?;
            let [start, end] = band.rows.map(|row| u64::from(row) * row_bytes);
            encoder.copy_buffer_to_buffer(&self.image, 0, &self.staging, start, end - start);
            if words > 0 {
                let (to, size) = (picture + words * start, words * (end - start));
                encoder.copy_buffer_to_buffer(&self.codes, 0, &self.staging, to, size);
            }
        }
        Ok(())
    }

    /// Draws the keys of band `k`, in a pass with the number `first`.
    fn encode_keys(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        (p, chunks, timer): (&Pipelines, &[DeviceChunk], Option<&Timer>),
        (k, first): (usize, u32),
    ) -> Result<(), GpuError> {
        if let Some(hardware) = &self.by_hardware {
            hardware.encode(encoder, (p.raster(gpu)?, timer), (k, first));
            return Ok(());
        }
        let [tile, ..] = TIMED;
        let band = &self.bands[k];
        encoder.clear_buffer(&self.keys, 0, None);
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
        Ok(())
    }

    /// Makes a band of its keys; their pass is numbered `first`, others follow.
    fn encode_band(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        (p, timer): (&Pipelines, Option<&Timer>),
        (band, first): (&Band, u32),
    ) -> Result<(), GpuError> {
        let [_, shade, film] = TIMED;
        encoder.clear_buffer(&self.sums, 0, None);
        encoder.clear_buffer(&self.codes, 0, None);
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
