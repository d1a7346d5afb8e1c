//! What of a tile is seen: its samples, sorted by block, with those of a pixel that show one place of a surface taken together.

use crate::raster::Tile;
use crate::records::SampleId;

/// Samples of one pixel that are shaded together: the first of them, and how many there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Fragment {
    /// Column in bits 0 to 9, row in bits 10 to 19, sample of the pixel in bits 20 to 23, count less one above.
    place: u32,
    pub(super) id: u32,
}

impl Fragment {
    #[inline(always)]
    fn new(x: u32, y: u32, sample: u32, count: u32, id: u32) -> Self {
        Self {
            place: x | y << 10 | sample << 20 | (count - 1) << 24,
            id,
        }
    }
    #[inline(always)]
    pub(super) fn x(self) -> u32 {
        self.place & 1023
    }
    #[inline(always)]
    pub(super) fn y(self) -> u32 {
        self.place >> 10 & 1023
    }
    #[inline(always)]
    pub(super) fn sample(self) -> u32 {
        self.place >> 20 & 15
    }
    #[inline(always)]
    pub(super) fn count(self) -> u32 {
        (self.place >> 24) + 1
    }
}

/// The fragments of a tile.
#[derive(Debug, Default)]
pub(super) struct Visible {
    found: Vec<Fragment>,
    order: Vec<Fragment>,
    starts: Vec<u32>,
    /// Columns of each row that show anything, first and one past the last.
    pub(super) spans: Vec<[u32; 2]>,
    /// Pixels that show anything.
    pub(super) pixels: u64,
}

impl Visible {
    /// Fragments of the block of a rank.
    pub(super) fn of_rank(&self, rank: usize) -> &[Fragment] {
        &self.order[self.starts[rank] as usize..self.starts[rank + 1] as usize]
    }

    /// Collects and sorts what `tile` shows of `ranks` blocks. `reach` of a rank is how many micro-quads apart samples of a pixel may
    /// be, in either direction of the block, to be shaded together; without it every sample is a fragment.
    pub(super) fn gather(&mut self, tile: &Tile, ranks: usize, reach: &[u8]) {
        self.begin(tile, ranks);
        let count = if tile.samples() == 1 {
            self.find_single(tile)
        } else {
            self.find(tile, reach)
        };
        self.sort(count);
    }

    /// Collects and sorts one sample of every pixel that shows anything: the first in `order` that does. Its count is that of all samples
    /// of the pixel that do.
    pub(super) fn gather_nearest(&mut self, tile: &Tile, ranks: usize, order: &[u32]) {
        self.begin(tile, ranks);
        let count = if tile.samples() == 1 {
            self.find_single(tile)
        } else {
            self.find_nearest(tile, order)
        };
        self.sort(count);
    }

    fn begin(&mut self, tile: &Tile, ranks: usize) {
        let [width, height] = tile.size();
        let samples = tile.samples();
        self.starts.clear();
        self.starts.resize(ranks + 2, 0);
        self.spans.clear();
        self.spans.resize(height as usize, [width, 0]);
        self.pixels = 0;
        // Grows once, and is written from the start every time.
        let most = (width * height * samples) as usize;
        if self.found.len() < most {
            self.found.resize(most, Fragment::default());
            self.order.resize(most, Fragment::default());
        }
    }

    /// Puts what was found in the order of ranks.
    fn sort(&mut self, count: usize) {
        for r in 2..self.starts.len() {
            self.starts[r] += self.starts[r - 1];
        }
        // Neighbours are mostly of one block: its place in the order is kept while they are.
        let mut rank = usize::MAX;
        let mut at = 0;
        for &fragment in &self.found[..count] {
            let own = (fragment.id >> 11) as usize;
            if own != rank {
                if rank != usize::MAX {
                    self.starts[rank + 1] = at as u32;
                }
                rank = own;
                at = self.starts[rank + 1] as usize;
            }
            self.order[at] = fragment;
            at += 1;
        }
        if rank != usize::MAX {
            self.starts[rank + 1] = at as u32;
        }
    }

    /// One sample per pixel: every one is a fragment.
    fn find_single(&mut self, tile: &Tile) -> usize {
        let [width, height] = tile.size();
        let mut count = 0;
        let mut last = usize::MAX;
        let mut run = 0;
        for y in 0..height {
            let (mut low, mut high) = (width, 0);
            for (block, keys) in tile.row(y, 0).chunks(16).enumerate() {
                if keys.iter().fold(0, |all, key| all | key.0) == 0 {
                    continue;
                }
                let x0 = block as u32 * 16;
                for (x, key) in (x0..).zip(keys) {
                    if key.0 == 0 {
                        continue;
                    }
                    low = low.min(x);
                    high = x + 1;
                    let id = !(key.0 as u32);
                    self.found[count] = Fragment::new(x, y, 0, 1, id);
                    count += 1;
                    let rank = (id >> 11) as usize;
                    if rank != last {
                        if last != usize::MAX {
                            self.starts[last + 2] += run;
                        }
                        (last, run) = (rank, 0);
                    }
                    run += 1;
                }
            }
            self.spans[y as usize] = [low, high];
        }
        if last != usize::MAX {
            self.starts[last + 2] += run;
        }
        self.pixels = count as u64;
        count
    }

    /// Several samples per pixel: the first in `order` that shows anything.
    fn find_nearest(&mut self, tile: &Tile, order: &[u32]) -> usize {
        let [width, height] = tile.size();
        let mut count = 0;
        for y in 0..height {
            let rows: [&[_]; 16] = std::array::from_fn(|k| {
                let sample = order.get(k).or(order.last()).copied().unwrap_or(0);
                tile.row(y, sample)
            });
            let rows = &rows[..order.len().min(16)];
            for x in 0..width {
                let keys = rows.iter().map(|row| row[x as usize].0);
                let hits = keys.clone().filter(|&k| k != 0).count() as u32;
                let first = keys.zip(order).find(|(k, _)| *k != 0);
                let Some((key, &sample)) = first else {
                    continue;
                };
                let id = !(key as u32);
                self.found[count] = Fragment::new(x, y, sample, hits, id);
                self.starts[(id >> 11) as usize + 2] += 1;
                count += 1;
            }
        }
        count
    }

    /// Several samples per pixel: those that are near the first of a fragment join it.
    fn find(&mut self, tile: &Tile, reach: &[u8]) -> usize {
        let [width, height] = tile.size();
        let samples = tile.samples();
        let mut count = 0;
        for y in 0..height {
            let rows: [&[_]; 16] =
                std::array::from_fn(|k| tile.row(y, (k as u32).min(samples - 1)));
            let rows = &rows[..samples as usize];
            let (mut low, mut high) = (width, 0);
            for x in 0..width {
                let begin = count;
                for (sample, row) in (0..).zip(rows) {
                    let key = row[x as usize];
                    if key.0 == 0 {
                        continue;
                    }
                    let id = !(key.0 as u32);
                    let joins = |f: &&mut Fragment| near(f.id, id, reach);
                    match self.found[begin..count].iter_mut().find(joins) {
                        Some(fragment) => fragment.place += 1 << 24,
                        None => {
                            self.found[count] = Fragment::new(x, y, sample, 1, id);
                            self.starts[(id >> 11) as usize + 2] += 1;
                            count += 1;
                        }
                    }
                }
                if count > begin {
                    self.pixels += 1;
                    low = low.min(x);
                    high = x + 1;
                }
            }
            self.spans[y as usize] = [low, high];
        }
        count
    }
}

/// Whether two samples of a pixel are shaded together. Without a reach, of the same half only: a coarse quad may be folded.
#[inline(always)]
fn near(a: u32, b: u32, reach: &[u8]) -> bool {
    let (a, b) = (SampleId(a), SampleId(b));
    if a.rank() != b.rank() {
        return false;
    }
    let Some(&reach) = reach.get(a.rank() as usize) else {
        return false;
    };
    if reach == 0 {
        return a == b;
    }
    let reach = u32::from(reach);
    a.col().abs_diff(b.col()) <= reach && a.row().abs_diff(b.row()) <= reach
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Key;

    /// A tile with samples of a few blocks, some places empty.
    fn tile(samples: u32) -> Tile {
        let mut tile = Tile::new(0, 0, 40, 24, samples);
        let mut state = 1_u32;
        for sample in 0..samples {
            for y in 0..24 {
                for x in 0..40 {
                    state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
                    if x > 33 || (state >> 8).is_multiple_of(5) {
                        continue;
                    }
                    let id = SampleId::new((x / 9 + y / 7) % 5, (state >> 12) % 32, y, state >> 31);
                    tile.merge(x, y, sample, Key::new(0.5, id));
                }
            }
        }
        tile
    }

    #[test]
    fn one_sample_counts_for_its_pixel() {
        for (samples, order) in [(1, &[0][..]), (4, &[2, 0, 3, 1])] {
            let tile = tile(samples);
            let mut visible = Visible::default();
            visible.gather_nearest(&tile, 5, order);
            let mut found = std::collections::BTreeMap::new();
            for rank in 0..5 {
                for f in visible.of_rank(rank) {
                    assert_eq!(SampleId(f.id).rank() as usize, rank);
                    assert!(found.insert((f.x(), f.y()), *f).is_none());
                }
            }
            for (y, x) in (0..24).flat_map(|y| (0..40).map(move |x| (y, x))) {
                let shows = |s: &&u32| tile.cell(x, y, **s).0 != 0;
                let want = order.iter().find(shows);
                let f = found.get(&(x, y));
                assert_eq!(f.map(|f| f.sample()), want.copied());
                if let Some(f) = f {
                    assert_eq!(tile.cell(x, y, f.sample()).id(), Some(SampleId(f.id)));
                    assert_eq!(f.count() as usize, order.iter().filter(shows).count());
                }
            }
            assert!(found.len() > 600);
        }
    }

    #[test]
    fn every_sample_is_in_one_fragment() {
        for samples in [1, 4, 16] {
            let tile = tile(samples);
            for reach in [&[][..], &[4; 5], &[0; 5]] {
                let mut visible = Visible::default();
                visible.gather(&tile, 5, reach);
                let (mut left, mut joined) = (0_i64, 0);
                for sample in 0..samples {
                    for y in 0..24 {
                        left += tile.row(y, sample).iter().filter(|k| k.0 != 0).count() as i64;
                    }
                }
                for rank in 0..5 {
                    for f in visible.of_rank(rank) {
                        let id = tile.cell(f.x(), f.y(), f.sample()).id();
                        assert_eq!(id, Some(SampleId(f.id)));
                        assert_eq!(SampleId(f.id).rank() as usize, rank);
                        left -= i64::from(f.count());
                        joined += i64::from(f.count()) - 1;
                        let [low, high] = visible.spans[f.y() as usize];
                        assert!((low..high).contains(&f.x()) && high <= 34);
                    }
                }
                assert_eq!(left, 0, "{samples} samples");
                // Without a reach only one sample per pixel, or none that are alike, keep all apart.
                let apart = samples == 1 || reach.is_empty();
                assert!(if apart { joined == 0 } else { joined > 0 });
            }
        }
    }
}
