//! What of a tile is seen: its samples, sorted by block, with those of a pixel that show one place of a surface taken together.

use crate::dispatch;
use crate::raster::{Key, Tile};
use crate::records::SampleId;
use crate::simd::{LANES, Level, bits, flag};

/// Samples of one pixel that are shaded together: the first of them, and how many there are.
///
/// One number, so that sixteen of them are two vectors. From the lowest bit: column in 10 bits, row in 10, sample of the pixel in 4,
/// count less one in 8; the id in the upper half.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Fragment(u64);

impl Fragment {
    #[inline(always)]
    fn new(x: u32, y: u32, sample: u32, count: u32, id: u32) -> Self {
        Self(u64::from(x | y << 10 | sample << 20 | (count - 1) << 24) | u64::from(id) << 32)
    }
    /// The id of the first sample.
    #[inline(always)]
    pub(super) fn id(self) -> u32 {
        (self.0 >> 32) as u32
    }
    #[inline(always)]
    pub(super) fn x(self) -> u32 {
        self.0 as u32 & 1023
    }
    #[inline(always)]
    pub(super) fn y(self) -> u32 {
        self.0 as u32 >> 10 & 1023
    }
    #[inline(always)]
    pub(super) fn sample(self) -> u32 {
        self.0 as u32 >> 20 & 15
    }
    #[inline(always)]
    pub(super) fn count(self) -> u32 {
        (self.0 as u32 >> 24) + 1
    }
    /// One sample more.
    #[inline(always)]
    fn join(&mut self) {
        self.0 += 1 << 24;
    }
}

/// Neighbours in a row of which all show the block of one rank.
#[derive(Clone, Copy, Debug)]
struct Run {
    x: u16,
    y: u16,
    len: u16,
    rank: u32,
}

/// The rank that an empty sample's key holds. No block has it: ids of the last rank are not given.
const NO_RANK: u32 = u32::MAX >> 11;

/// The fragments of a tile.
#[derive(Debug, Default)]
pub(super) struct Visible {
    found: Vec<Fragment>,
    order: Vec<Fragment>,
    starts: Vec<u32>,
    runs: Vec<Run>,
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
    pub(super) fn gather(&mut self, simd: Level, tile: &Tile, ranks: usize, reach: &[u8]) {
        self.begin(tile, ranks);
        if tile.samples() == 1 {
            dispatch!(simd, self.gather_single(tile));
            return;
        }
        let count = dispatch!(simd, self.find(tile, reach));
        self.sort(count);
    }

    /// Collects and sorts one sample of every pixel that shows anything: the first in `order` that does. Its count is that of all samples
    /// of the pixel that do.
    pub(super) fn gather_nearest(&mut self, simd: Level, tile: &Tile, ranks: usize, order: &[u32]) {
        self.begin(tile, ranks);
        if tile.samples() == 1 {
            dispatch!(simd, self.gather_single(tile));
            return;
        }
        let count = self.find_nearest(tile, order);
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
        if self.order.len() < most {
            self.order.resize(most, Fragment::default());
        }
        if samples > 1 && self.found.len() < most {
            self.found.resize(most, Fragment::default());
        }
    }

    /// Puts what was found in the order of ranks.
    fn sort(&mut self, count: usize) {
        self.add_up();
        // Neighbours are mostly of one block: its place in the order is kept while they are.
        let mut rank = usize::MAX;
        let mut at = 0;
        for &fragment in &self.found[..count] {
            let own = (fragment.id() >> 11) as usize;
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

    /// Turns the numbers of fragments into where those of a rank begin: `starts[rank + 1]` until they are put there, `starts[rank]`
    /// afterwards.
    #[inline(always)]
    fn add_up(&mut self) {
        for r in 2..self.starts.len() {
            self.starts[r] += self.starts[r - 1];
        }
    }

    /// One sample per pixel: every one is a fragment. Neighbours are mostly of one block, so runs of them are found first, and then put
    /// in their place whole.
    #[inline(always)]
    fn gather_single(&mut self, tile: &Tile) {
        let [width, height] = tile.size();
        self.runs.clear();
        for y in 0..height {
            let keys = tile.row(y, 0);
            let (mut begin, mut rank) = (0, NO_RANK);
            let (groups, rest) = keys.as_chunks::<LANES>();
            // The last group is filled up with empty samples.
            let mut last = [Key::EMPTY; LANES];
            last[..rest.len()].copy_from_slice(rest);
            let filled = (!rest.is_empty()).then_some(&last);
            for (group, x) in groups.iter().chain(filled).zip((0..).step_by(LANES)) {
                let any = group.iter().fold(0, |any, key| any | key.0);
                if any == 0 && rank == NO_RANK {
                    continue;
                }
                let mut ranks = [0; LANES];
                for l in 0..LANES {
                    ranks[l] = !(group[l].0 as u32) >> 11;
                }
                let mut turns = [0; LANES];
                turns[0] = flag(ranks[0] != rank);
                for l in 1..LANES {
                    turns[l] = flag(ranks[l] != ranks[l - 1]);
                }
                let mut turns = bits(&turns);
                while turns != 0 {
                    let l = turns.trailing_zeros();
                    turns &= turns - 1;
                    self.end_run([begin, x + l, y], rank);
                    (begin, rank) = (x + l, ranks[l as usize & (LANES - 1)]);
                }
            }
            self.end_run([begin, width, y], rank);
        }
        self.add_up();
        for &Run { x, y, len, rank } in &self.runs {
            let (x, y, len) = (u32::from(x), u32::from(y), usize::from(len));
            let keys = &tile.row(y, 0)[x as usize..][..len];
            let start = &mut self.starts[rank as usize + 1];
            let order = &mut self.order[*start as usize..][..len];
            *start += len as u32;
            for (i, (fragment, key)) in (x..).zip(order.iter_mut().zip(keys)) {
                *fragment = Fragment::new(i, y, 0, 1, !(key.0 as u32));
            }
        }
    }

    /// Takes note of a run, unless it shows nothing.
    #[inline(always)]
    fn end_run(&mut self, [begin, end, y]: [u32; 3], rank: u32) {
        if rank == NO_RANK || begin == end {
            return;
        }
        let len = end - begin;
        self.runs.push(Run {
            x: begin as u16,
            y: y as u16,
            len: len as u16,
            rank,
        });
        self.starts[rank as usize + 2] += len;
        let [low, high] = &mut self.spans[y as usize];
        *low = (*low).min(begin);
        *high = end;
        self.pixels += u64::from(len);
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

    /// Several samples per pixel: those that are near the first of a fragment join it. Inside a surface all samples of a pixel do, which is
    /// seen for sixteen pixels at once.
    #[inline(always)]
    fn find(&mut self, tile: &Tile, reach: &[u8]) -> usize {
        let [width, height] = tile.size();
        let samples = tile.samples();
        let mut count = 0;
        for y in 0..height {
            let rows: [&[_]; 16] =
                std::array::from_fn(|k| tile.padded_row(y, (k as u32).min(samples - 1)));
            let rows = &rows[..samples as usize];
            let (mut low, mut high) = (width, 0);
            for x in (0..width).step_by(LANES) {
                let group = Group::look(rows, x as usize, reach);
                let mut hits = group.hits & below(width - x);
                if hits == 0 {
                    continue;
                }
                self.pixels += u64::from(hits.count_ones());
                low = low.min(x + hits.trailing_zeros());
                high = x + 32 - hits.leading_zeros();
                while hits != 0 {
                    let l = hits.trailing_zeros();
                    hits &= hits - 1;
                    if group.whole >> l & 1 != 0 {
                        let id = group.first[l as usize & (LANES - 1)];
                        self.found[count] = Fragment::new(x + l, y, 0, samples, id);
                        self.starts[(id >> 11) as usize + 2] += 1;
                        count += 1;
                    } else {
                        count = self.find_in_pixel(rows, [x + l, y], count, reach);
                    }
                }
            }
            self.spans[y as usize] = [low, high];
        }
        count
    }

    /// The fragments of one pixel; `count` were found before. Returns how many are found with them.
    #[inline(always)]
    fn find_in_pixel(
        &mut self,
        rows: &[&[Key]],
        [x, y]: [u32; 2],
        mut count: usize,
        reach: &[u8],
    ) -> usize {
        let begin = count;
        for (sample, row) in (0..).zip(rows) {
            let key = row[x as usize];
            if key.0 == 0 {
                continue;
            }
            let id = !(key.0 as u32);
            let joins = |f: &&mut Fragment| near(f.id(), id, reach);
            match self.found[begin..count].iter_mut().find(joins) {
                Some(fragment) => fragment.join(),
                None => {
                    self.found[count] = Fragment::new(x, y, sample, 1, id);
                    self.starts[(id >> 11) as usize + 2] += 1;
                    count += 1;
                }
            }
        }
        count
    }
}

/// The lowest `n` bits, at most sixteen.
#[inline(always)]
fn below(n: u32) -> u32 {
    (1 << n.min(LANES as u32)) - 1
}

/// Sixteen pixels of a row that have several samples.
struct Group {
    /// Ids of the first samples; all bits where those show nothing.
    first: [u32; LANES],
    /// Pixels that show anything, bit by bit.
    hits: u32,
    /// Pixels of which all samples are near the first.
    whole: u32,
}

impl Group {
    #[inline(always)]
    fn look(rows: &[&[Key]], x: usize, reach: &[u8]) -> Self {
        let mut first = [0; LANES];
        let mut hit = [0; LANES];
        for (k, row) in rows.iter().enumerate() {
            let keys = &row[x..x + LANES];
            for l in 0..LANES {
                let id = !(keys[l].0 as u32);
                hit[l] |= flag(id != u32::MAX);
                if k == 0 {
                    first[l] = id;
                }
            }
        }
        let hits = bits(&hit);
        let mut group = Self {
            first,
            hits,
            whole: 0,
        };
        if hits != 0 && !reach.is_empty() {
            group.whole = group.near_first(&rows[1..], x, reach);
        }
        group
    }

    /// Pixels of which all samples, those of `rows` too, are [`near`] the first.
    #[inline(always)]
    fn near_first(&self, rows: &[&[Key]], x: usize, reach: &[u8]) -> u32 {
        let first = &self.first;
        let mut far = [0; LANES];
        let mut reaches = [0_u32; LANES];
        for l in 0..LANES {
            // Where the first sample shows nothing, any reach serves.
            let rank = (first[l] >> 11) as usize;
            reaches[l] = reach[rank.min(reach.len() - 1)].into();
            far[l] = flag(first[l] == u32::MAX);
        }
        for row in rows {
            let keys = &row[x..x + LANES];
            for l in 0..LANES {
                let id = !(keys[l].0 as u32);
                let part = |shift: u32| {
                    let of = |id: u32| (id >> shift & 31) as i32;
                    (of(first[l]) - of(id)).unsigned_abs()
                };
                let apart = (part(1) > reaches[l]) | (part(6) > reaches[l]);
                // The rank, and without a reach the half.
                let other = (first[l] ^ id) & !(0x7fe | u32::from(reaches[l] != 0));
                far[l] |= flag(apart | (other != 0));
            }
        }
        bits(&far) ^ below(LANES as u32)
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
            visible.gather_nearest(Level::detect(), &tile, 5, order);
            let mut found = std::collections::BTreeMap::new();
            for rank in 0..5 {
                for f in visible.of_rank(rank) {
                    assert_eq!(SampleId(f.id()).rank() as usize, rank);
                    assert!(found.insert((f.x(), f.y()), *f).is_none());
                }
            }
            for (y, x) in (0..24).flat_map(|y| (0..40).map(move |x| (y, x))) {
                let shows = |s: &&u32| tile.cell(x, y, **s).0 != 0;
                let want = order.iter().find(shows);
                let f = found.get(&(x, y));
                assert_eq!(f.map(|f| f.sample()), want.copied());
                if let Some(f) = f {
                    assert_eq!(tile.cell(x, y, f.sample()).id(), Some(SampleId(f.id())));
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
                visible.gather(Level::detect(), &tile, 5, reach);
                let (mut left, mut joined) = (0_i64, 0);
                for sample in 0..samples {
                    for y in 0..24 {
                        left += tile.row(y, sample).iter().filter(|k| k.0 != 0).count() as i64;
                    }
                }
                for rank in 0..5 {
                    for f in visible.of_rank(rank) {
                        let id = tile.cell(f.x(), f.y(), f.sample()).id();
                        assert_eq!(id, Some(SampleId(f.id())));
                        assert_eq!(SampleId(f.id()).rank() as usize, rank);
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
