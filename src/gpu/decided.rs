//! What a scene on a device does about blocks that the device itself decides on: when that is done anew, what is dispatched by it, and what is
//! heard of it.

use super::bands::TIMED;
use super::chunk::NamedBlock;
use super::draw::{DICE, FLATNESS, GpuScene};
use super::error::GpuError;
use super::flatness::{COUNT_BYTES, Counts, DeviceFlatness};
use super::pipelines::Stage;
use super::read_back::{read, read_floats};
use super::records::{Block, Record};
use super::stats::GpuStats;
use super::timer;
use super::upload::DeviceChunk;
use super::wgsl::GROUP;
use crate::camera::View;

impl GpuScene<'_> {
    /// Chunks whose blocks are decided here, with the numbers of their counts.
    pub(super) fn deciding(&self) -> impl Iterator<Item = (u64, &DeviceFlatness)> {
        (0..).zip(self.chunks.iter().filter_map(|c| c.flatness.as_ref()))
    }

    /// Whether the device decides on blocks, whatever the view.
    #[doc(hidden)]
    #[must_use]
    pub fn decides(&self) -> bool {
        self.deciding().next().is_some()
    }

    /// Whether the device can decide on all blocks of the view that it was made for: nothing that asks for deeper levels than it has falls
    /// short of them by much, and there is room. The one look at counts without a picture.
    pub(super) fn covers(&mut self) -> Result<bool, GpuError> {
        let gpu = self.gpu;
        gpu.caught(|| {
            let descriptor = wgpu::CommandEncoderDescriptor::default();
            let mut encoder = gpu.device().create_command_encoder(&descriptor);
            let view = self.view;
            let mut before = Vec::new();
            self.encode_flatness(&mut encoder, &view, &mut before)?;
            self.copy_counts(&mut encoder);
            gpu.queue().submit([encoder.finish()]);
            let bytes = read(gpu, self.bands.staging(), self.bands.down()[1]..)?;
            let all = |c: Counts| c.fits() && !c.falls_short(self.drawn.mode);
            Ok(self.counts(&bytes).all(all))
        })
    }

    pub(super) fn copy_counts(&self, encoder: &mut wgpu::CommandEncoder) {
        for (k, flatness) in self.deciding() {
            let at = self.bands.down()[1] + k * COUNT_BYTES;
            flatness.copy_counts(encoder, self.bands.staging(), at);
        }
    }

    /// What came down behind a picture and what is beside it.
    fn counts<'b>(&'b self, bytes: &'b [u8]) -> impl Iterator<Item = Counts> + 'b {
        self.deciding().map(move |(k, flatness)| {
            let at = k * COUNT_BYTES;
            flatness.counts(bytes.get(at as usize..).unwrap_or_default())
        })
    }

    /// Decides on blocks for `view`, unless they are those of it.
    pub(super) fn encode_flatness(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        before: &mut Vec<&'static str>,
    ) -> Result<u64, GpuError> {
        let seen = self.decided_by.unwrap_or(*view);
        let decided = !self.decides() || self.sided && self.decided_for == Some(seen);
        if !self.sided {
            let timer = self.timer.as_ref();
            let mut pass = timer::pass(timer, encoder, DICE, self.first_before());
            for c in &self.chunks {
                let groups = c.data.spots.div_ceil(GROUP);
                self.pipelines.sides.run(&mut pass, &c.sides, groups);
                if let Some(curves) = &c.curves {
                    self.pipelines.curves.run(&mut pass, curves, groups);
                }
            }
            drop(pass);
            before.push(DICE);
            self.sided = true;
            self.diced = false;
        }
        if decided {
            return Ok(0);
        }
        let up = self.deciding().map(|(_, f)| f.see(self.gpu, &seen)).sum();
        self.deciding().for_each(|(_, f)| f.clear(encoder));
        let number = self.first_before() + before.len() as u32;
        let mut pass = timer::pass(self.timer.as_ref(), encoder, FLATNESS, number);
        for (_, flatness) in self.deciding() {
            flatness.run(self.gpu, &mut pass)?;
        }
        if let Some(hardware) = &self.bands.by_hardware {
            hardware.sort(self.pipelines.raster(self.gpu)?, &mut pass);
        }
        drop(pass);
        before.push(FLATNESS);
        for c in &self.chunks {
            if let Some(flatness) = &c.flatness {
                flatness.tell(encoder, &c.phases);
            }
        }
        self.decided_for = Some(seen);
        self.diced = false;
        Ok(up)
    }

    /// Number of the first pass of [`BEFORE`].
    pub(super) fn first_before(&self) -> u32 {
        (self.bands.len() * TIMED.len()) as u32
    }

    /// Takes counts that came with the picture. A picture for which there was no room is none.
    pub(super) fn count(&self, bytes: &[u8], stats: &mut GpuStats) -> Result<(), GpuError> {
        for (level, counts) in stats.levels.iter_mut().zip(self.counts(bytes)) {
            if !counts.fits() {
                return Err(GpuError::OutOfMemory {
                    what: "the blocks that this view asks for",
                });
            }
            *level = counts.deepest;
            stats.microtriangles += counts.triangles;
            stats.coarse += u64::from(counts.coarse);
            stats.falls_short |= counts.falls_short(self.drawn.mode);
            stats.decides = true;
        }
        if stats.decides {
            self.limits.faces(u128::from(stats.microtriangles) / 2)?;
        }
        Ok(())
    }

    /// Which blocks a chunk has; those that the device decided on are read back.
    pub(super) fn named(&self, c: &DeviceChunk) -> Result<Vec<NamedBlock>, GpuError> {
        let Some(flatness) = &c.flatness else {
            return Ok(c.named.clone());
        };
        let count = read_floats(self.gpu, flatness.totals(), COUNT_BYTES)?[0].to_bits();
        let floats = read_floats(self.gpu, &c.blocks, u64::from(count) * Block::SIZE as u64)?;
        let words = floats.chunks_exact(Block::SIZE / 4);
        let named = words.take(count as usize).map(|w| {
            let [face, x, y, step, log, base] = [0, 1, 2, 3, 4, 5].map(|k: usize| w[k].to_bits());
            NamedBlock {
                quad: face,
                start: [x / step.max(1), y / step.max(1)],
                log,
                base: base - c.data.spots,
            }
        });
        Ok(named.collect())
    }
}

impl DeviceChunk {
    /// Runs a stage with a workgroup for each block.
    pub(super) fn by_block(
        &self,
        stage: &Stage,
        pass: &mut wgpu::ComputePass<'_>,
        bindings: &wgpu::BindGroup,
    ) {
        match &self.flatness {
            Some(flatness) => flatness.dispatch(stage, pass, bindings),
            None => stage.run(pass, bindings, self.data.blocks),
        }
    }
}
