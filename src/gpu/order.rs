//! Blocks of a chunk by their size, as the device's own rasteriser draws them: an instance is a block, and instances of one draw have as many
//! micro-triangles, up to the next power of two. Blocks of one size stand in the order of their ranks.

use super::device::Gpu;
use super::error::GpuError;
use super::pipelines::Stage;
use super::records::Block;
use super::upload::DeviceChunk;
use super::wgsl::BLOCK_BITS;
use wgpu::BufferUsages as Usage;

/// Bytes of what is drawn of one size: corners of an instance, instances, and the first of both.
const DRAW_BYTES: u64 = 5 * size_of::<u32>() as u64;

/// What the blocks of one draw are: grids of so many micro-quads along a side, as a power of two, or lists of so many triangles or fewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Size {
    Grid(u8),
    List(u8),
}

impl Size {
    pub(super) fn of(block: &Block) -> Self {
        match block.list_count {
            0 => Self::Grid(block.log as u8),
            triangles => Self::List(triangles.next_power_of_two().ilog2() as u8),
        }
    }
}

/// First corner of grids of a size among those of all.
fn first_corner(log: u32) -> u32 {
    2 * ((1 << (2 * log)) - 1)
}

/// Corners of the micro-triangles of grids of all sizes, in the order of their ids: twice the number of a point, and the half of the
/// micro-quad.
pub(super) fn grid_corners() -> Vec<u16> {
    let mut out = Vec::with_capacity(first_corner(BLOCK_BITS + 1) as usize);
    for log in 0..=BLOCK_BITS {
        let side = (1 << log) + 1;
        for line in 0..side - 1 {
            for a in line * side..(line + 1) * side - 1 {
                let c = a + side + 1;
                out.extend([a, a + 1, c].map(|k| 2 * k));
                out.extend([a, a + side, c].map(|k| 2 * k + 1));
            }
        }
    }
    out
}

/// Blocks of one size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Run {
    size: Size,
    /// First of them in the order.
    first: u32,
    /// How many there are, or can be.
    count: u32,
}

/// Numbers of blocks of these sizes by size, and where each size begins.
fn runs(sizes: &[Size]) -> (Vec<u32>, Vec<Run>) {
    let size_of = |k: &u32| sizes[*k as usize];
    let mut order: Vec<u32> = (0..sizes.len() as u32).collect();
    order.sort_unstable_by_key(|k| (size_of(k), *k));
    let mut runs = Vec::new();
    let mut first = 0;
    for same in order.chunk_by(|a, b| size_of(a) == size_of(b)) {
        runs.push(Run {
            size: size_of(&same[0]),
            first,
            count: same.len() as u32,
        });
        first += same.len() as u32;
    }
    (order, runs)
}

/// The order of a chunk's blocks.
#[derive(Debug)]
pub(super) struct Order {
    /// Their numbers.
    blocks: wgpu::Buffer,
    runs: Vec<Run>,
    decided: Option<Decided>,
}

/// What the device fills itself where it decides on blocks.
#[derive(Debug)]
struct Decided {
    draws: wgpu::Buffer,
    bindings: wgpu::BindGroup,
}

impl Order {
    pub(super) fn new(gpu: &Gpu, by_size: &Stage, chunk: &DeviceChunk) -> Result<Self, GpuError> {
        const WHAT: &str = "the order of blocks";
        let Some(flatness) = &chunk.flatness else {
            let (order, runs) = runs(&chunk.sizes);
            let usage = Usage::VERTEX | Usage::COPY_DST;
            let blocks = gpu.empty(WHAT, 4 * order.len() as u64, usage)?;
            gpu.queue()
                .write_buffer(&blocks, 0, bytemuck::cast_slice(&order));
            return Ok(Self {
                blocks,
                runs,
                decided: None,
            });
        };
        let room = flatness.room;
        let run = |log: u32| Run {
            size: Size::Grid(log as u8),
            first: log * room,
            count: room,
        };
        let runs: Vec<Run> = (0..=BLOCK_BITS).map(run).collect();
        let usage = Usage::VERTEX | Usage::STORAGE;
        let blocks = gpu.empty(WHAT, 4 * runs.len() as u64 * u64::from(room), usage)?;
        let usage = Usage::INDIRECT | Usage::STORAGE;
        let draws = gpu.empty("draws", DRAW_BYTES * runs.len() as u64, usage)?;
        let bindings = by_size.bind(
            gpu,
            &[
                (2, &chunk.blocks),
                (13, &blocks),
                (14, &draws),
                (15, flatness.totals()),
            ],
        );
        Ok(Self {
            blocks,
            runs,
            decided: Some(Decided { draws, bindings }),
        })
    }

    /// Bytes on the device.
    pub(super) fn bytes(&self) -> u64 {
        self.blocks.size() + self.decided.as_ref().map_or(0, |d| d.draws.size())
    }

    /// Sorts blocks that the device has just decided on.
    pub(super) fn sort(&self, by_size: &Stage, pass: &mut wgpu::ComputePass<'_>) {
        if let Some(decided) = &self.decided {
            by_size.run(pass, &decided.bindings, 1);
        }
    }

    /// Draws all blocks, with their numbers for each instance and [`grid_corners`] as indices.
    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        for (k, run) in (0..).zip(&self.runs) {
            let [first, end] = [run.first, run.first + run.count].map(|b| 4 * u64::from(b));
            pass.set_vertex_buffer(0, self.blocks.slice(first..end));
            match (&self.decided, run.size) {
                (Some(decided), _) => pass.draw_indexed_indirect(&decided.draws, k * DRAW_BYTES),
                (None, Size::Grid(log)) => {
                    let corners = [log, log + 1].map(|log| first_corner(log.into()));
                    pass.draw_indexed(corners[0]..corners[1], 0, 0..run.count);
                }
                (None, Size::List(log)) => pass.draw(0..3 << log, 0..run.count),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_of_one_size_keep_their_order() {
        use Size::{Grid, List};
        let (order, found) = runs(&[List(0), Grid(1), List(0), Grid(0), Grid(1)]);
        assert_eq!(order, [3, 1, 4, 0, 2]);
        let run = |size, first, count| Run { size, first, count };
        let want = [run(Grid(0), 0, 1), run(Grid(1), 1, 2), run(List(0), 3, 2)];
        assert_eq!(found, want);
        assert_eq!(runs(&[]), (Vec::new(), Vec::new()));
    }

    #[test]
    fn sizes_hold_all_triangles() {
        let of = |log, list_count| {
            Size::of(&Block {
                log,
                list_count,
                ..Block::default()
            })
        };
        assert_eq!([of(0, 0), of(5, 0)], [Size::Grid(0), Size::Grid(5)]);
        let lists = [(5, 1), (5, 5), (1, 8), (0, 2049)].map(|(log, count)| of(log, count));
        assert_eq!(lists, [0, 3, 3, 12].map(Size::List));
    }

    #[test]
    fn corners_are_those_of_grids() {
        let all = grid_corners();
        assert_eq!(all.len(), first_corner(BLOCK_BITS + 1) as usize);
        for log in 0..=BLOCK_BITS {
            let [first, end] = [log, log + 1].map(|log| first_corner(log) as usize);
            let own = &all[first..end];
            assert_eq!(own.len(), 6 << (2 * log));
            let most = own.iter().max().map(|&c| u32::from(c));
            assert_eq!(most, Some(2 * ((1 << log) + 1_u32).pow(2) - 1));
        }
        // The first micro-quad of two by two.
        assert_eq!(all[6..12], [0, 2, 8, 1, 7, 9]);
    }
}
