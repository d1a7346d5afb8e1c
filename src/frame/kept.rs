//! Blocks that a tile keeps from drawing to shading. Displacing a block costs more than all else that is done with it, so what is drawn
//! gets its attributes at once, and what is seen of it need not be displaced again.

use super::attributes::Attributes;
use crate::records::{BLOCK_POINTS, BLOCK_STRIDE, BlockSize, Grid3};

/// Most numbers of a block: points and five attributes.
const BLOCK: usize = 18 * BLOCK_POINTS * BLOCK_POINTS;

/// Numbers that a thread keeps at most, 8 MB of them; what is drawn after that is diced again. Items are drawn nearest first, and those are
/// the most likely to be seen.
const MOST: usize = 1 << 21;

/// Kept blocks of one tile, without what fills their grids up.
#[derive(Default)]
pub(super) struct Kept {
    numbers: Vec<f32>,
    blocks: Vec<Block>,
    /// Whether what is drawn will be shaded.
    is_open: bool,
}

#[derive(Clone, Copy)]
struct Block {
    rank: u32,
    first: usize,
    size: BlockSize,
    /// Which attributes there are, as [`Attributes::flags`].
    flags: [bool; 3],
}

impl Kept {
    /// Keeps blocks of a new tile from now on.
    pub(super) fn open(&mut self) {
        self.forget();
        self.is_open = true;
    }

    /// Keeps no others.
    pub(super) fn close(&mut self) {
        self.is_open = false;
        self.blocks.sort_unstable_by_key(|b| b.rank);
    }

    /// Forgets what was kept, and keeps no others.
    pub(super) fn forget(&mut self) {
        self.numbers.clear();
        self.blocks.clear();
        self.is_open = false;
    }

    /// Whether another block can be kept.
    pub(super) fn has_room(&self) -> bool {
        self.is_open && self.numbers.len() + BLOCK <= MOST
    }

    /// Keeps a block that was drawn.
    pub(super) fn keep(
        &mut self,
        rank: u32,
        size: BlockSize,
        points: &Grid3,
        attributes: &Attributes,
    ) {
        self.blocks.push(Block {
            rank,
            first: self.numbers.len(),
            size,
            flags: attributes.flags(),
        });
        let grids = std::iter::once(points).chain(attributes.grids());
        for line in grids.flat_map(|g| [&g.x, &g.y, &g.z]) {
            for row in line.chunks_exact(BLOCK_STRIDE).take(size.rows) {
                self.numbers.extend_from_slice(&row[..size.cols]);
            }
        }
    }

    /// Brings a block back, if it was kept.
    pub(super) fn take(&self, rank: u32, points: &mut Grid3, attributes: &mut Attributes) -> bool {
        let Ok(k) = self.blocks.binary_search_by_key(&rank, |b| b.rank) else {
            return false;
        };
        let block = self.blocks[k];
        attributes.set_flags(block.flags);
        let mut rows = self.numbers[block.first..].chunks_exact(block.size.cols);
        let grids = std::iter::once(points).chain(attributes.grids_mut());
        for line in grids.flat_map(|g| [&mut g.x, &mut g.y, &mut g.z]) {
            let lines = line.chunks_exact_mut(BLOCK_STRIDE).take(block.size.rows);
            for (to, from) in lines.zip(&mut rows) {
                to[..from.len()].copy_from_slice(from);
            }
        }
        true
    }
}
