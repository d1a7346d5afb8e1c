//! Patterns as blocks that are drawn: squares of the grid where a pattern is uniform, lists of triangles elsewhere. Made once per pattern and
//! kept for further faces and frames, as the pool of the paper is.

use super::walk::Triangles;
use super::{Pattern, Place, QuadPattern, TrianglePattern};
use crate::limits::{LimitError, Limits};
use crate::records::{BLOCK_POINTS, BLOCK_STRIDE};
use crate::tessellate::depth_tags::FaceDepths;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

/// Micro-quads along the side of a block, as a power of two.
const MAX_LOG: u32 = 5;

/// Most triangles of a list: as many as there are ids in a block.
const MAX_TRIANGLES: usize = 2048;

/// Most points of a list.
const MAX_POINTS: usize = BLOCK_POINTS * BLOCK_POINTS;

/// Bytes that a pool keeps before it begins anew.
const KEPT_BYTES: usize = 256 << 20;

/// Triangles over the points of a block.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct List {
    /// Places of the points on the grid of the pattern's depth, point `k` in column `k % 33` and row `k / 33` of the block; empty where the
    /// points are the block's own grid.
    pub(crate) points: Vec<Place>,
    /// Triangles by the index of their points in a [`Grid3`](crate::records::Grid3), counter-clockwise.
    pub(crate) triangles: Vec<[u16; 3]>,
}

/// A block of a pattern.
#[derive(Clone, Debug)]
pub(crate) struct PatternBlock {
    /// First point on the grid of the pattern's depth, and the block's size as a power of two.
    pub(crate) start: [u16; 2],
    pub(crate) log: u8,
    /// `None` where the grid itself is drawn.
    pub(crate) list: Option<Arc<List>>,
}

/// A pattern with the depths of its four sides; a triangle's fourth is 0.
type Key = (bool, Pattern, [u8; 4]);

/// Patterns that were met.
#[derive(Debug, Default)]
pub(crate) struct Pool(Mutex<Kept>);

#[derive(Debug, Default)]
struct Kept {
    patterns: BTreeMap<Key, Arc<[PatternBlock]>>,
    bytes: usize,
}

impl List {
    fn bytes(&self) -> usize {
        self.points.len() * size_of::<Place>() + self.triangles.len() * size_of::<[u16; 3]>()
    }

    /// Columns and rows that its own points take, two at least.
    pub(crate) fn rows(&self) -> usize {
        self.points.len().div_ceil(BLOCK_POINTS).max(2)
    }
}

impl Pool {
    /// The blocks of a face's pattern.
    ///
    /// # Errors
    /// A budget was reached.
    pub(crate) fn get(
        &self,
        pattern: Pattern,
        triangular: bool,
        depths: &FaceDepths,
        limits: &Limits,
    ) -> Result<Arc<[PatternBlock]>, LimitError> {
        let key = (triangular, pattern, depths.sides.map(|d| d as u8));
        if let Some(found) = self.kept(|kept| kept.patterns.get(&key).cloned()).flatten() {
            return Ok(found);
        }
        let made: Arc<[PatternBlock]> = blocks(key, depths.inner, limits)?.into();
        let lists = made.iter().filter_map(|b| b.list.as_deref());
        let bytes = lists.map(List::bytes).sum::<usize>() + size_of_val(&*made);
        self.kept(|kept| {
            if kept.bytes + bytes > KEPT_BYTES {
                *kept = Kept::default();
            }
            kept.bytes += bytes;
            kept.patterns.insert(key, Arc::clone(&made));
        });
        Ok(made)
    }

    /// A pool that a thread left in disorder is as good as an empty one.
    fn kept<T>(&self, work: impl FnOnce(&mut Kept) -> T) -> Option<T> {
        self.0.lock().ok().map(|mut kept| work(&mut kept))
    }
}

/// Triangles of a pattern on the grid of a face.
fn on_grid((triangular, pattern, d): Key) -> impl Iterator<Item = [Place; 3]> {
    let found: Option<Triangles> = match triangular {
        true => TrianglePattern::new(pattern, [d[0], d[1], d[2]]).map(|p| p.triangles()),
        false => QuadPattern::new(pattern, d).map(|p| p.triangles()),
    };
    // A triangle fills the half of its grid where the row is at most the column.
    let place = move |[x, y]: Place| if triangular { [x + y, y] } else { [x, y] };
    found.into_iter().flatten().map(move |t| t.map(place))
}

/// The block that holds all of a triangle, by number.
fn block_of(t: &[Place; 3], log: u32, count: usize) -> Option<usize> {
    let range = |k: usize| {
        let (low, high) = t.iter().fold((u16::MAX, 0), |(low, high), p| {
            (low.min(p[k]), high.max(p[k]))
        });
        let block = low >> log;
        (usize::from(high) <= (usize::from(block) + 1) << log).then_some(usize::from(block))
    };
    Some(range(1)? * count + range(0)?)
}

fn blocks(key: Key, depth: u32, limits: &Limits) -> Result<Vec<PatternBlock>, LimitError> {
    /// Triangles between two looks at the clock.
    const CHECK: usize = 1 << 16;
    let triangular = key.0;
    let log = depth.min(MAX_LOG);
    let count = 1_usize << (depth - log);
    let n = 1_u16 << log;
    let whole = |b: usize| match triangular && b.is_multiple_of(count + 1) {
        true => 1_usize << (2 * log),
        false => 2 << (2 * log),
    };
    let mut blocks = Vec::new();
    let start = |b: usize| [b % count, b / count].map(|k| (k << log) as u16);
    let mut numbers = vec![0_u32; count * count];
    let sides = if triangular { 3 } else { 4 };
    if key.2[..sides].iter().all(|&d| u32::from(d) == depth) {
        numbers
            .iter_mut()
            .enumerate()
            .for_each(|(b, k)| *k = whole(b) as u32);
    } else {
        let mut bytes = 0_u128;
        for (k, t) in on_grid(key).enumerate() {
            if k % CHECK == 0 {
                limits.check()?;
            }
            if let Some(b) = block_of(&t, log, count) {
                numbers[b] += 1;
            }
            bytes += 18;
        }
        limits.memory("a refinement pattern", bytes)?;
    }
    // A block is uniform if it holds as many triangles as fit.
    let mut lists: Vec<List> = vec![List::default(); count * count];
    let is_grid = |b: usize| numbers[b] as usize == whole(b);
    let mut wide = Wide::default();
    // Above the diagonal of a triangle there is nothing.
    let is_void = |b: usize| triangular && b / count > b % count;
    let mixed = (0..count * count).any(|b| !is_grid(b) && !is_void(b));
    if mixed {
        for t in on_grid(key) {
            match block_of(&t, log, count) {
                Some(b) if is_grid(b) => {}
                Some(b) => {
                    let from = start(b);
                    let index = |p: Place| (p[1] - from[1]) * BLOCK_STRIDE as u16 + p[0] - from[0];
                    lists[b].triangles.push(t.map(index));
                }
                None => wide.add(&t),
            }
        }
    }
    for (b, list) in lists.into_iter().enumerate() {
        if is_void(b) {
            continue;
        }
        let list = match is_grid(b) {
            true => None,
            false if list.triangles.is_empty() => continue,
            false => Some(Arc::new(list)),
        };
        debug_assert!(
            list.as_ref()
                .is_none_or(|l| l.triangles.len() <= 2 * usize::from(n) * usize::from(n))
        );
        blocks.push(PatternBlock {
            start: start(b),
            log: log as u8,
            list,
        });
    }
    blocks.extend(wide.finish().into_iter().map(|list| PatternBlock {
        start: [0; 2],
        log: log as u8,
        list: Some(Arc::new(list)),
    }));
    Ok(blocks)
}

/// Triangles that lie in no single block, with points of their own.
#[derive(Default)]
struct Wide {
    done: Vec<List>,
    open: List,
    numbers: BTreeMap<Place, u16>,
}

impl Wide {
    fn add(&mut self, t: &[Place; 3]) {
        if self.open.triangles.len() == MAX_TRIANGLES || self.open.points.len() + 3 > MAX_POINTS {
            self.done.push(std::mem::take(&mut self.open));
            self.numbers.clear();
        }
        let points = &mut self.open.points;
        let triangle = t.map(|place| {
            *self.numbers.entry(place).or_insert_with(|| {
                let k = points.len();
                points.push(place);
                (k / BLOCK_POINTS * BLOCK_STRIDE + k % BLOCK_POINTS) as u16
            })
        });
        self.open.triangles.push(triangle);
    }

    fn finish(mut self) -> Vec<List> {
        if !self.open.triangles.is_empty() {
            self.done.push(self.open);
        }
        self.done
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice the area of everything drawn, in the units of the finest grid.
    fn area(blocks: &[PatternBlock], triangular: bool) -> i64 {
        let mut total = 0;
        for b in blocks {
            let Some(list) = &b.list else {
                let half = triangular && b.start[0] == b.start[1];
                total += if half { 1 } else { 2 } << (2 * b.log);
                continue;
            };
            for t in &list.triangles {
                let p = t.map(|k| {
                    let at = [usize::from(k) % BLOCK_STRIDE, usize::from(k) / BLOCK_STRIDE];
                    match list.points.get(at[1] * BLOCK_POINTS + at[0]) {
                        Some(p) => p.map(i64::from),
                        None => [0, 1].map(|k| i64::from(b.start[k]) + at[k] as i64),
                    }
                });
                let a = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1])
                    - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
                assert!(a > 0);
                total += a;
            }
        }
        total
    }

    #[test]
    fn blocks_hold_all_of_a_pattern() {
        let pool = Pool::default();
        let limits = Limits::default();
        for pattern in [Pattern::Split, Pattern::Equilateral] {
            for triangular in [false, true] {
                for sides in [
                    [0, 0, 0, 0],
                    [3, 1, 4, 2],
                    [7, 2, 7, 6],
                    [0, 8, 3, 0],
                    [6; 4],
                    [8, 8, 8, 1],
                ] {
                    let sides = if triangular {
                        [sides[0], sides[1], sides[2], 0]
                    } else {
                        sides
                    };
                    let inner = *sides.iter().max().unwrap();
                    let depths = FaceDepths { inner, sides };
                    let blocks = pool.get(pattern, triangular, &depths, &limits).unwrap();
                    let whole = if triangular { 1_i64 } else { 2 } << (2 * inner);
                    assert_eq!(area(&blocks, triangular), whole, "{pattern:?} {sides:?}");
                    for list in blocks.iter().filter_map(|b| b.list.as_ref()) {
                        assert!(list.triangles.len() <= MAX_TRIANGLES);
                        assert!(list.points.len() <= MAX_POINTS);
                    }
                    // Kept: the second face gets the same.
                    let again = pool.get(pattern, triangular, &depths, &limits).unwrap();
                    assert!(Arc::ptr_eq(&blocks, &again));
                }
            }
        }
    }

    #[test]
    fn memory_is_counted_before_it_is_taken() {
        let limits = Limits {
            max_memory: Some(1 << 20),
            ..Limits::default()
        };
        let depths = FaceDepths {
            inner: 9,
            sides: [9, 9, 9, 8],
        };
        let found = Pool::default().get(Pattern::Equilateral, false, &depths, &limits);
        assert!(matches!(found, Err(LimitError::Memory { .. })));
    }
}
