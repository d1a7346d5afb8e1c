//! Binary trees of splits along edges.
//!
//! A segment is a node: the whole edge is node 1, the halves of node `k` are `2k` and `2k + 1`, in the edge's own direction. A tree is one bit
//! per node down to the depth that it has.

/// A tree in a [`Forest`].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tree<'a> {
    /// Levels of points: 0 where the edge is not split.
    depth: u32,
    bits: &'a [u64],
}

/// Trees by number.
#[derive(Clone, Debug, Default)]
pub(super) struct Forest {
    /// Depth and first word of each tree.
    trees: Vec<(u8, u32)>,
    words: Vec<u64>,
}

/// Nodes that are split, while a tree is made.
#[derive(Clone, Debug, Default)]
pub(super) struct Splits {
    pub(super) depth: u32,
    bits: Vec<u64>,
}

fn has(bits: &[u64], node: usize) -> bool {
    bits.get(node / 64)
        .is_some_and(|w| w >> (node % 64) & 1 == 1)
}

impl Splits {
    pub(super) fn clear(&mut self) {
        self.depth = 0;
        self.bits.clear();
    }
    pub(super) fn split(&mut self, node: usize) {
        let word = node / 64;
        if self.bits.len() <= word {
            self.bits.resize(word + 1, 0);
        }
        self.bits[word] |= 1 << (node % 64);
        self.depth = self.depth.max(node.ilog2() + 1);
    }
}

impl Forest {
    /// A forest of `count` trees without splits.
    pub(super) fn new(count: usize) -> Self {
        Self {
            trees: vec![(0, 0); count],
            words: Vec::new(),
        }
    }

    pub(super) fn set(&mut self, tree: u32, depth: u8, words: &[u64]) {
        self.trees[tree as usize] = (depth, self.words.len() as u32);
        self.words.extend_from_slice(words);
    }

    pub(super) fn get(&self, tree: u32) -> Tree<'_> {
        let (depth, first) = self.trees[tree as usize];
        let words = (1_usize << depth).div_ceil(64);
        Tree {
            depth: u32::from(depth),
            bits: match depth {
                0 => &[],
                _ => &self.words[first as usize..first as usize + words],
            },
        }
    }

    /// Level of the deepest points of all trees.
    pub(super) fn deepest(&self) -> u32 {
        self.trees.iter().map(|t| u32::from(t.0)).max().unwrap_or(0)
    }

    pub(super) fn bytes(&self) -> usize {
        self.trees.len() * size_of::<(u8, u32)>() + self.words.len() * 8
    }
}

impl Splits {
    /// Depth and words, as [`Forest::set`] takes them.
    pub(super) fn words(&mut self) -> (u8, &[u64]) {
        let words = (1_usize << self.depth).div_ceil(64);
        self.bits.resize(words.max(self.bits.len()), 0);
        let words = if self.depth == 0 { 0 } else { words };
        (self.depth as u8, &self.bits[..words])
    }
}

impl Tree<'_> {
    /// Level of its deepest points.
    pub(super) fn depth(&self) -> u32 {
        self.depth
    }

    /// Level of the deepest points inside of the segment that is number `place` of `2^depth`; `depth` where there are none.
    pub(super) fn deepest(&self, depth: u32, place: u32) -> u32 {
        if depth >= self.depth || !has(self.bits, (1 << depth) + place as usize) {
            return depth;
        }
        let halves = [0, 1].map(|k| self.deepest(depth + 1, 2 * place + k));
        halves[0].max(halves[1])
    }

    /// The point next to place `t` of `2^level`; of two equally near ones the first.
    pub(super) fn nearest(&self, level: u32, t: u32) -> u32 {
        let (mut node, mut low, mut high) = (1_usize, 0, 1_u32 << level);
        while t != low && t != high {
            if node.ilog2() >= self.depth || !has(self.bits, node) {
                return if t - low <= high - t { low } else { high };
            }
            let middle = (low + high) / 2;
            if t >= middle {
                (node, low) = (2 * node + 1, middle);
            } else {
                (node, high) = (2 * node, middle);
            }
        }
        t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Splits the edge, its second half, and that one's first half: points at 1/2, 3/4, 5/8.
    fn forest() -> Forest {
        let mut splits = Splits::default();
        [1, 3, 6].into_iter().for_each(|node| splits.split(node));
        let mut forest = Forest::new(2);
        let (depth, words) = splits.words();
        forest.set(1, depth, words);
        forest
    }

    #[test]
    fn points_that_are_not_there_go_to_the_nearest() {
        let forest = forest();
        let tree = forest.get(1);
        let nearest: Vec<u32> = (0..=16).map(|t| tree.nearest(4, t)).collect();
        assert_eq!(
            nearest,
            [0, 0, 0, 0, 0, 8, 8, 8, 8, 8, 10, 10, 12, 12, 12, 16, 16]
        );
        let empty: Vec<u32> = (0..=4).map(|t| forest.get(0).nearest(2, t)).collect();
        assert_eq!(empty, [0, 0, 0, 4, 4]);
    }

    #[test]
    fn depth_is_that_of_the_deepest_point() {
        let forest = forest();
        let tree = forest.get(1);
        assert_eq!((tree.depth(), forest.get(0).depth()), (3, 0));
        assert_eq!(tree.deepest(0, 0), 3);
        assert_eq!([0, 1].map(|k| tree.deepest(1, k)), [1, 3]);
        assert_eq!([2, 3].map(|k| tree.deepest(2, k)), [3, 2]);
        assert_eq!(tree.deepest(4, 9), 4);
    }
}
