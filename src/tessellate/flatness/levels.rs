//! What the squares of a face need, depth by depth below one that was sampled.

use super::surplus::{Square as Sampled, Surplus};
use crate::dice::MAX_LEVEL;
use crate::tessellate::quadtree::{MAX_LOG, Shape};

/// What a block costs beside its micro-quads, in micro-quads. Drawn, it costs about 20; fewer triangles are worth the difference (measured:
/// a third fewer for a twentieth more of a frame's time).
pub(crate) const OVERHEAD: u32 = 6;

/// Depth below a sampled square at which its parts are sampled on their own.
pub(crate) const RESAMPLED: u32 = 3;

/// Need of a square whose samples do not tell.
pub(crate) const DEEPER: u32 = 0x7f;

/// Mark of a square that cannot be in the picture, beside its level.
const HIDDEN: u8 = 0x80;

/// Levels below a sampled square that its parts need, depth by depth.
#[derive(Default)]
pub(super) struct Levels(Vec<u8>);

impl Levels {
    fn index([depth, x, y]: [u32; 3]) -> usize {
        ((4_usize.pow(depth) - 1) / 3) + ((y as usize) << depth) + x as usize
    }

    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    pub(super) fn get(&self, at: [u32; 3]) -> u32 {
        u32::from(self.0[Self::index(at)] & !HIDDEN)
    }

    fn set(&mut self, at: [u32; 3], value: u8) {
        let at = Self::index(at);
        if self.0.len() <= at {
            self.0.resize(at + 1, 0);
        }
        self.0[at] = value;
    }

    /// Says that a square cannot be in the picture.
    pub(super) fn hide(&mut self, at: [u32; 3]) {
        self.set(at, at[0] as u8 | HIDDEN);
    }

    pub(super) fn is_hidden(&self, at: [u32; 3]) -> bool {
        let value = self.0.get(Self::index(at));
        value.is_some_and(|v| v & HIDDEN != 0)
    }

    /// Children of square (`x`, `y`) that are not void.
    pub(super) fn children(s: Shape, x: u32, y: u32) -> impl Iterator<Item = [u32; 2]> {
        let all = (0..4).map(move |k| [2 * x + (k & 1), 2 * y + (k >> 1)]);
        all.filter(move |[x, y]| s == Shape::Square || y <= x)
    }

    /// Finds what a square of the samples needs; `cap` is what it may have.
    pub(super) fn find(
        &mut self,
        s: &Sampled,
        surplus: &Surplus,
        cap: u32,
        [depth, x, y]: [u32; 3],
    ) -> u32 {
        if self.is_hidden([depth, x, y]) {
            return depth;
        }
        let need = if depth >= cap || depth >= s.log || !surplus.is_far(s, depth, [x, y]) {
            depth
        } else {
            let below = (depth + 1 == s.log).then(|| surplus.beyond(s, [x, y]));
            let mut need = 0;
            for [x, y] in Self::children(s.shape, x, y) {
                let at = [depth + 1, x, y];
                need = need.max(match below {
                    Some(added) => self.last(s, added, cap, at),
                    None => self.find(s, surplus, cap, at),
                });
            }
            need
        };
        self.set([depth, x, y], need as u8);
        need
    }

    /// What a square as small as the samples needs, of whose inside nothing is known; the next step may add `added`.
    fn last(&mut self, s: &Sampled, added: f32, cap: u32, at: [u32; 3]) -> u32 {
        let [depth, x, y] = at;
        if self.is_hidden(at) {
            return depth;
        }
        let need = match depth < cap && added * s.left(depth, [x, y]) > 1.0 {
            true => DEEPER,
            false => depth,
        };
        self.set(at, need as u8);
        need
    }

    /// The most that quarters need other than those at the corners `at`; of a square that is found to be too far as a whole.
    pub(super) fn beside(&self, s: Shape, at: [bool; 4]) -> u32 {
        let quarters = Self::children(s, 0, 0).filter(|&c| !at[corner(c)]);
        quarters.fold(0, |most, [x, y]| most.max(self.get([1, x, y])))
    }

    /// Puts in what was found of a quarter by samples of its own.
    pub(super) fn insert(&mut self, s: Shape, [x, y]: [u32; 2], inner: &Self) {
        for depth in 0..RESAMPLED {
            let places = (0..1 << (2 * depth)).map(|k| [k & ((1 << depth) - 1), k >> depth]);
            for [i, j] in places {
                let Some(&value) = inner.0.get(Self::index([depth, i, j])) else {
                    break;
                };
                let need = u32::from(value & !HIDDEN);
                let need = if need == DEEPER { need } else { need + 1 };
                let at = [depth + 1, (x << depth) + i, (y << depth) + j];
                self.set(at, need as u8 | value & HIDDEN);
            }
        }
        self.set([0; 3], self.beside(s, [false; 4]) as u8);
    }

    /// Micro-quads of a square as one block.
    fn whole(&self, s: Shape, [depth, x, y]: [u32; 3]) -> u32 {
        let quads = 1 << (2 * (self.get([depth, x, y]) - depth).min(MAX_LEVEL));
        let half = s == Shape::Triangle && x == y;
        (if half { quads / 2 } else { quads }) + OVERHEAD
    }

    /// Micro-quads of the cheapest way to cut a square into blocks.
    fn cost(&self, s: Shape, [depth, x, y]: [u32; 3]) -> u32 {
        let whole = self.whole(s, [depth, x, y]);
        if self.get([depth, x, y]) < depth + 2 || depth >= RESAMPLED {
            return whole;
        }
        let parts = Self::children(s, x, y).map(|[x, y]| self.cost(s, [depth + 1, x, y]));
        whole.min(parts.sum())
    }

    /// Whether a square is drawn best as one block.
    pub(super) fn is_whole(&self, s: Shape, at: [u32; 3]) -> bool {
        self.get(at) - at[0] <= MAX_LOG && self.cost(s, at) >= self.whole(s, at)
    }
}

/// Number of the corner that a quarter lies at.
fn corner([x, y]: [u32; 2]) -> usize {
    [[0, 1], [3, 2]][y as usize][x as usize]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Levels of a square whose quarters need these, in rows.
    fn of_quarters(needs: [u8; 4]) -> Levels {
        let mut out = Levels::default();
        let places = [[0, 0], [1, 0], [0, 1], [1, 1]];
        for (need, [x, y]) in needs.into_iter().zip(places) {
            out.set([1, x, y], need);
        }
        out.set([0; 3], needs.into_iter().fold(0, u8::max));
        out
    }

    #[test]
    fn a_quarter_measured_on_its_own_takes_its_place() {
        let mut inner = of_quarters([3, 1, DEEPER as u8, 2]);
        inner.hide([1, 1, 0]);
        let mut levels = of_quarters([1, DEEPER as u8, 2, 2]);
        assert_eq!(levels.beside(Shape::Square, [false, true, false, false]), 2);
        levels.insert(Shape::Square, [1, 0], &inner);
        assert_eq!(levels.get([0; 3]), DEEPER);
        assert_eq!(levels.get([1, 1, 0]), DEEPER);
        assert_eq!(levels.get([2, 2, 0]), 4);
        assert_eq!(levels.get([2, 3, 1]), 3);
        assert_eq!(levels.get([2, 2, 1]), DEEPER);
        assert!(levels.is_hidden([2, 3, 0]) && !levels.is_hidden([2, 2, 0]));

        let known = of_quarters([3, 1, 2, 2]);
        levels.insert(Shape::Square, [1, 0], &known);
        assert_eq!([levels.get([0; 3]), levels.get([1, 1, 0])], [4, 4]);
    }

    #[test]
    fn squares_are_cut_where_only_a_part_needs_much() {
        let mut far = of_quarters([3, 1, 1, 1]);
        for [x, y] in Levels::children(Shape::Square, 0, 0) {
            far.set([2, x, y], 3);
        }
        assert!(!far.is_whole(Shape::Square, [0; 3]));
        let even = of_quarters([2, 2, 2, 2]);
        assert!(even.is_whole(Shape::Square, [0; 3]));
    }
}
