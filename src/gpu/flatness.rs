//! Stage `flatness`: blocks decided on the device, for the view of a frame, from points that the device itself evaluates.
//!
//! The steps and tests are those of the processor's stage of the same name, in the same order ([`flatness`](crate::tessellate::flatness)):
//! what faces need (`flatness.wgsl`), how edges are split, each by one invocation for both of its faces (`edges.wgsl`), the blocks that come
//! of both (`blocks.wgsl`), and between counting and listing them prefix sums over faces (`scan.wgsl`). Whatever is drawn then is
//! dispatched by what they came to. Of that the processor only sees counts, with the picture.

use super::deciding::Deciding;
use super::device::Gpu;
use super::error::GpuError;
use super::pipelines::{Stage, module, stage};
use super::records::{Block, Metric, Move, Record, words};
use super::upload::uniform;
use super::wgsl::{self, GROUP, NODE_WORDS};
use crate::camera::View;
use crate::shade::ShadeMode;
use crate::tessellate::Flatness;
use crate::tessellate::flatness::Numbers;
use wgpu::BufferUsages as Usage;

/// How many times what is allowed the last step of samples may add where more is asked for than there is. Each step adds a quarter of the
/// one before, or at an irregular corner half.
const SHORT: f32 = 2.0;

/// Bytes that come down with the picture for each chunk.
pub(super) const COUNT_BYTES: u64 = 4 * wgsl::TOTALS as u64;

/// Its pipelines.
#[derive(Debug)]
pub(super) struct FlatnessPipelines {
    faces: Stage,
    edges: Stage,
    count: Stage,
    list: Stage,
    sum_parts: Stage,
    scan_parts: Stage,
    scan_faces: Stage,
}

impl FlatnessPipelines {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let blocks = module(gpu, &wgsl::blocks());
        let scan = module(gpu, &wgsl::scan());
        Self {
            faces: stage(gpu, &module(gpu, &wgsl::flatness()), "needs_of_faces"),
            edges: stage(gpu, &module(gpu, &wgsl::edges()), "edges_of_faces"),
            count: stage(gpu, &blocks, "count_blocks"),
            list: stage(gpu, &blocks, "list_blocks"),
            sum_parts: stage(gpu, &scan, "sum_parts"),
            scan_parts: stage(gpu, &scan, "scan_parts"),
            scan_faces: stage(gpu, &scan, "scan_faces"),
        }
    }
}

/// What of a chunk it reads.
pub(super) struct Chunk<'a> {
    pub(super) chunk: &'a wgpu::Buffer,
    pub(super) control: &'a wgpu::Buffer,
    pub(super) gathers: &'a wgpu::Buffer,
    pub(super) weights: &'a wgpu::Buffer,
    pub(super) stencils: &'a wgpu::Buffer,
    pub(super) faces: &'a wgpu::Buffer,
    pub(super) points: &'a wgpu::Buffer,
    /// What it fills.
    pub(super) blocks: &'a wgpu::Buffer,
    pub(super) moves: &'a wgpu::Buffer,
}

/// A chunk whose blocks are decided here.
pub(super) struct DeviceFlatness {
    flatness: Flatness,
    split: u32,
    /// Blocks that there is room for.
    pub(super) room: u32,
    metric: wgpu::Buffer,
    totals: wgpu::Buffer,
    dispatched: wgpu::Buffer,
    /// Numbers of faces, edges, and parts of faces.
    counts: [u32; 3],
    /// Stages with what they bind, in order.
    steps: [wgpu::BindGroup; 7],
    bytes: u64,
}

/// What there is of a chunk.
#[derive(Clone, Copy, Debug)]
pub(super) struct Counts {
    /// Blocks, if there is room for all.
    pub(super) drawn: u32,
    pub(super) blocks: u32,
    /// Micro-triangles with an area: a point that moves takes the edge behind it away.
    pub(super) triangles: u64,
    /// Faces and edges that ask for more levels than there are.
    pub(super) coarse: u32,
    /// Deepest level of the cage's faces.
    pub(super) deepest: u32,
    /// The most that the last step adds there, in thousandths of what is allowed.
    missing: u32,
}

impl Counts {
    /// Whether that is more than can be left out of a picture; of one that shows levels, nothing can.
    pub(super) fn falls_short(&self, mode: ShadeMode) -> bool {
        self.missing as f32 > 1000.0 * SHORT || self.coarse > 0 && mode == ShadeMode::Level
    }

    /// Whether there was room for all that the view asks for.
    pub(super) fn fits(&self) -> bool {
        self.drawn == self.blocks
    }
}

impl DeviceFlatness {
    pub(super) fn new(gpu: &Gpu, of: &Chunk<'_>, data: &Deciding) -> Result<Self, GpuError> {
        let pipelines = gpu.flatness_pipelines()?;
        let (faces, edges) = (data.patches.len() as u64, data.edges.len() as u64);
        let storage = Usage::STORAGE;
        let patches = gpu.filled("faces that are decided on", &words(&data.patches))?;
        let edge_list = gpu.filled("edges that are decided on", &words(&data.edges))?;
        let nodes = gpu.empty("quadtrees", 4 * u64::from(NODE_WORDS) * faces, storage)?;
        let trees = gpu.empty("splits of edges", 4 * edges, storage)?;
        let counts = gpu.empty("counts of faces", 16 * faces, storage)?;
        let offsets = gpu.empty("places of faces", 16 * faces, storage)?;
        let parts = gpu.empty("sums", 16 * u64::from(data.room.parts), storage)?;
        let totals_usage = storage | Usage::COPY_SRC | Usage::COPY_DST;
        let totals = gpu.empty("counts", COUNT_BYTES, totals_usage)?;
        let dispatched = gpu.empty("dispatches", 12, storage | Usage::INDIRECT)?;
        let usage = Usage::UNIFORM | Usage::COPY_DST;
        let metric = gpu.empty("metric", Metric::SIZE as u64, usage)?;
        let room = uniform(gpu, &data.room)?;
        let p = pipelines;
        let steps = [
            p.faces.bind(
                gpu,
                &[
                    (0, of.chunk),
                    (1, of.control),
                    (2, of.gathers),
                    (3, of.weights),
                    (4, of.stencils),
                    (5, of.faces),
                    (6, &patches),
                    (7, of.points),
                    (8, &metric),
                    (9, &nodes),
                    (10, &totals),
                ],
            ),
            p.edges.bind(
                gpu,
                &[
                    (5, of.faces),
                    (6, &patches),
                    (7, of.points),
                    (8, &metric),
                    (9, &nodes),
                    (10, &totals),
                    (11, &edge_list),
                    (12, &trees),
                ],
            ),
            p.count.bind(
                gpu,
                &[
                    (6, &patches),
                    (9, &nodes),
                    (10, &totals),
                    (12, &trees),
                    (13, &counts),
                    (16, of.moves),
                ],
            ),
            p.sum_parts
                .bind(gpu, &[(13, &counts), (17, &room), (18, &parts)]),
            p.scan_parts.bind(
                gpu,
                &[(10, &totals), (17, &room), (18, &parts), (19, &dispatched)],
            ),
            p.scan_faces.bind(
                gpu,
                &[(13, &counts), (14, &offsets), (17, &room), (18, &parts)],
            ),
            p.list.bind(
                gpu,
                &[
                    (6, &patches),
                    (9, &nodes),
                    (10, &totals),
                    (12, &trees),
                    (14, &offsets),
                    (15, of.blocks),
                    (16, of.moves),
                    (17, &room),
                ],
            ),
        ];
        let all = [
            &patches, &edge_list, &nodes, &trees, &counts, &offsets, &parts,
        ];
        Ok(Self {
            flatness: data.flatness,
            split: data.split,
            room: data.room.blocks,
            metric,
            totals,
            dispatched,
            counts: [faces as u32, edges as u32, data.room.parts],
            steps,
            bytes: all.iter().map(|b| b.size()).sum(),
        })
    }

    /// Bytes of its buffers.
    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Buffers of blocks and of moved points.
    pub(super) fn lists(gpu: &Gpu, data: &Deciding) -> Result<[wgpu::Buffer; 2], GpuError> {
        let bytes = |count: u32, size: usize| u64::from(count) * size as u64;
        let usage = Usage::STORAGE | Usage::COPY_SRC;
        Ok([
            gpu.empty("blocks", bytes(data.room.blocks, Block::SIZE), usage)?,
            gpu.empty("moved points", bytes(data.room.moves, Move::SIZE), usage)?,
        ])
    }

    /// Says by which view blocks are decided, and the bytes that go up for it.
    pub(super) fn see(&self, gpu: &Gpu, view: &View) -> u64 {
        let words = words(&[metric(view, &self.flatness)]);
        gpu.queue()
            .write_buffer(&self.metric, 0, bytemuck::cast_slice(&words));
        4 * words.len() as u64
    }

    /// What has to be empty before.
    pub(super) fn clear(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.clear_buffer(&self.totals, 0, None);
    }

    /// Decides on blocks.
    pub(super) fn run(&self, gpu: &Gpu, pass: &mut wgpu::ComputePass<'_>) -> Result<(), GpuError> {
        let p = gpu.flatness_pipelines()?;
        let [faces, edges, parts] = self.counts;
        let by_lane = |count: u32| count.div_ceil(GROUP);
        let groups = [
            (&p.faces, faces),
            (&p.edges, by_lane(edges)),
            (&p.count, by_lane(faces)),
            (&p.sum_parts, parts),
            (&p.scan_parts, 1),
            (&p.scan_faces, parts),
            (&p.list, by_lane(faces)),
        ];
        for ((stage, groups), bindings) in groups.into_iter().zip(&self.steps) {
            stage.run(pass, bindings, groups);
        }
        Ok(())
    }

    /// Puts the number of blocks into what the stages that follow read of the chunk.
    pub(super) fn tell(&self, encoder: &mut wgpu::CommandEncoder, chunks: &[wgpu::Buffer]) {
        /// Where [`Chunk::blocks`](super::records::Chunk::blocks) is.
        const AT: u64 = std::mem::offset_of!(super::records::Chunk, blocks) as u64;
        for chunk in chunks {
            encoder.copy_buffer_to_buffer(&self.totals, 0, chunk, AT, 4);
        }
    }

    /// Runs a stage with one workgroup for each block.
    pub(super) fn dispatch(
        &self,
        stage: &Stage,
        pass: &mut wgpu::ComputePass<'_>,
        bindings: &wgpu::BindGroup,
    ) {
        pass.set_pipeline(&stage.pipeline);
        pass.set_bind_group(0, bindings, &[]);
        pass.dispatch_workgroups_indirect(&self.dispatched, 0);
    }

    /// Its counts.
    pub(super) fn totals(&self) -> &wgpu::Buffer {
        &self.totals
    }

    /// Lets its counts come down with the picture, to place `at` of what is read back.
    pub(super) fn copy_counts(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        to: &wgpu::Buffer,
        at: u64,
    ) {
        encoder.copy_buffer_to_buffer(&self.totals, 0, to, at, COUNT_BYTES);
    }

    /// The counts that came down.
    pub(super) fn counts(&self, bytes: &[u8]) -> Counts {
        let words = bytes.as_chunks::<4>().0;
        let word = |k: u32| (words.get(k as usize)).map_or(0, |b| u32::from_le_bytes(*b));
        let quads = u64::from(word(wgsl::TOTAL_QUADS));
        Counts {
            drawn: word(wgsl::TOTAL_DRAWN),
            blocks: word(wgsl::TOTAL_BLOCKS),
            triangles: (2 * quads).saturating_sub(word(wgsl::TOTAL_MOVES).into()),
            coarse: word(wgsl::TOTAL_DEEPER),
            deepest: word(wgsl::TOTAL_DEEPEST) + self.split,
            missing: word(wgsl::TOTAL_MISSING),
        }
    }
}

/// What a view and a flatness say of distances.
fn metric(view: &View, flatness: &Flatness) -> Metric {
    let four = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
    let numbers = Numbers::new(view, flatness);
    let p = &view.projection;
    Metric {
        x: p.x,
        y: p.y,
        h: if p.ortho { p.d } else { p.w },
        eye: four(view.eye),
        right: four(view.right),
        up: four(view.up),
        forward: four(view.forward),
        size: [view.size.width as f32, view.size.height as f32, 0.0, 0.0],
        near: view.near,
        plane: p.near,
        scale: view.scale,
        pixels: numbers.pixels,
        chord: numbers.chord,
        whole_pixels: numbers.whole[0],
        whole_radians: numbers.whole[1],
        max_level: numbers.max_level,
        ortho: u32::from(p.ortho),
        padding: 0,
        more_padding: [0; 2],
    }
}
