//! MIP levels: each texel covers its exact share of the level before.

/// One MIP level.
#[derive(Clone, Debug)]
pub(super) struct Level {
    pub(super) width: u32,
    pub(super) height: u32,
    /// Index of its first texel.
    pub(super) start: usize,
}

/// Sizes of the levels, each half of the one before, rounded down, down to one texel.
pub(super) fn level_sizes(width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    std::iter::successors(Some((width, height)), |&(w, h)| {
        (w > 1 || h > 1).then(|| ((w / 2).max(1), (h / 2).max(1)))
    })
}

/// Appends the smaller levels to `all`, which holds the texels of level 0. `widen` and `narrow` turn stored texels into 16-bit
/// linear numbers and back; a level is averaged from the 16-bit numbers of the one before, so stored rounding does not add up.
pub(super) fn build_levels<T: Copy>(
    width: u32,
    height: u32,
    all: &mut Vec<T>,
    widen: impl Fn(T) -> [u16; 4],
    narrow: impl Fn([u16; 4]) -> T,
) -> Vec<Level> {
    let mut levels = Vec::new();
    let mut start = 0;
    let mut wide: Vec<[u16; 4]> = Vec::new();
    let mut previous = (width, height);
    for (w, h) in level_sizes(width, height) {
        levels.push(Level {
            width: w,
            height: h,
            start,
        });
        if levels.len() > 1 {
            wide = if levels.len() == 2 {
                halve(previous, (w, h), |i| widen(all[i]))
            } else {
                halve(previous, (w, h), |i| wide[i])
            };
            all.extend(wide.iter().map(|&t| narrow(t)));
        }
        start += w as usize * h as usize;
        previous = (w, h);
    }
    levels
}

/// One level from the one before. A side of `n` texels becomes one of `m`: in units of 1/m texel, new texel `i` covers
/// `[i n, (i + 1) n)` and old texel `j` covers `[j m, (j + 1) m)`; the overlaps are the weights, and they sum to `n`.
fn halve(from: (u32, u32), to: (u32, u32), texel: impl Fn(usize) -> [u16; 4]) -> Vec<[u16; 4]> {
    let columns = taps(from.0, to.0);
    let rows = taps(from.1, to.1);
    let total = u64::from(from.0) * u64::from(from.1);
    let mut out = Vec::with_capacity(to.0 as usize * to.1 as usize);
    for row in &rows {
        for column in &columns {
            let mut sum = [0_u64; 4];
            for &(y, wy) in row.iter().filter(|t| t.1 > 0) {
                for &(x, wx) in column.iter().filter(|t| t.1 > 0) {
                    let t = texel(y as usize * from.0 as usize + x as usize);
                    for (s, c) in sum.iter_mut().zip(t) {
                        *s += u64::from(c) * u64::from(wx) * u64::from(wy);
                    }
                }
            }
            out.push(sum.map(|s| ((s + total / 2) / total) as u16));
        }
    }
    out
}

/// Per new texel, the up to three old ones it covers and their weights (0 for none).
fn taps(n: u32, m: u32) -> Vec<[(u32, u32); 3]> {
    (0..m)
        .map(|i| {
            let (begin, end) = (i * n, (i + 1) * n);
            let first = begin / m;
            [0, 1, 2].map(|k| {
                let j = first + k;
                let overlap = end.min((j + 1) * m).saturating_sub(begin.max(j * m));
                (j.min(n - 1), overlap)
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::MAX_SIDE;
    use super::*;

    #[test]
    fn taps_share_every_texel_exactly() {
        for n in [1, 2, 3, 5, 8, 13, 255, 4095, 65_535] {
            let m = (n / 2).max(1);
            let mut covered = vec![0_u64; n as usize];
            for t in taps(n, m) {
                assert_eq!(t.iter().map(|t| t.1).sum::<u32>(), n);
                for (j, w) in t {
                    covered[j as usize] += u64::from(w);
                }
            }
            assert!(covered.iter().all(|&c| c == u64::from(m)), "{n}");
        }
    }

    #[test]
    fn levels_end_with_one_texel() {
        let sizes: Vec<_> = level_sizes(5, 2).collect();
        assert_eq!(sizes, [(5, 2), (2, 1), (1, 1)]);
        assert_eq!(level_sizes(1, 1).count(), 1);
        assert_eq!(level_sizes(MAX_SIDE, 1).count(), 16);
    }
}
