//! Packing of charts into the unit square: each slides to the lowest free place of a coarse bitmap.

use super::unwrap::{Chart, area};

/// Cells along a side of the packing bitmap; charts stay one cell apart.
pub(crate) const CELLS: usize = 256;

/// The cells a chart touches at some scale: 2 where it lies, 1 next to that, which must be free of other charts.
pub(crate) fn footprint(chart: &Chart, scale: f64) -> Vec<Vec<u8>> {
    let top = |d: usize| chart.uv.iter().map(|p| p[d]).fold(0.0, f64::max);
    let (w, h) = ((top(0) * scale) as usize + 3, (top(1) * scale) as usize + 3);
    let mut mask = vec![vec![0_u8; w]; h];
    for c in &chart.corners {
        // A quad is sampled densely enough to hit every cell it covers.
        let p: Vec<[f64; 2]> = c.iter().map(|&v| chart.uv[v].map(|x| x * scale)).collect();
        let n = 2
            + (0..4)
                .map(|k| {
                    let (a, b) = (p[k], p[(k + 1) % 4]);
                    (a[0] - b[0]).abs().max((a[1] - b[1]).abs())
                })
                .fold(0.0, f64::max) as usize
                * 2;
        for j in 0..=n {
            for i in 0..=n {
                let (s, t) = (i as f64 / n as f64, j as f64 / n as f64);
                let at = |d: usize| {
                    (p[0][d] * (1.0 - s) + p[1][d] * s) * (1.0 - t)
                        + (p[3][d] * (1.0 - s) + p[2][d] * s) * t
                };
                let (x, y) = (at(0) as usize + 1, at(1) as usize + 1);
                for row in mask
                    .iter_mut()
                    .take((y + 2).min(h))
                    .skip(y.saturating_sub(1))
                {
                    for cell in row
                        .iter_mut()
                        .take((x + 2).min(w))
                        .skip(x.saturating_sub(1))
                    {
                        *cell = (*cell).max(1);
                    }
                }
                mask[y][x] = 2;
            }
        }
    }
    mask
}

/// A row of the bitmap, one bit per cell.
type Row = [u64; CELLS / 64];

/// `row` moved up by `x` cells.
fn shifted(row: &Row, x: usize) -> Row {
    let (words, bits) = (x / 64, x % 64);
    std::array::from_fn(|k| {
        let word = |k: Option<usize>| k.map_or(0, |k| row[k]);
        let high = word(k.checked_sub(words)) << bits;
        let low = word(k.checked_sub(words + 1));
        high | if bits > 0 { low >> (64 - bits) } else { 0 }
    })
}

/// Places of all charts (in cells, and quarter turns clockwise) or `None` when they do not fit.
fn place(charts: &[Chart], order: &[usize], scale: f64) -> Option<Vec<([usize; 2], u8)>> {
    let mut taken = vec![[0_u64; CELLS / 64]; CELLS];
    let mut places = vec![([0, 0], 0); charts.len()];
    for &i in order {
        let mut mask = footprint(&charts[i], scale);
        // Lowest upper edge, then leftmost, of the four orientations.
        let mut best: Option<(usize, usize, usize, u8, Vec<Row>)> = None;
        for turn in 0..4 {
            if turn > 0 {
                mask = (0..mask[0].len())
                    .rev()
                    .map(|x| mask.iter().map(|row| row[x]).collect())
                    .collect();
            }
            let (w, h) = (mask[0].len(), mask.len());
            if w > CELLS || h > CELLS {
                continue;
            }
            let bits = |least: u8| -> Vec<Row> {
                let word = |row: &[u8], k: usize| {
                    let set = |b: &u32| row.get(k * 64 + *b as usize).is_some_and(|&c| c >= least);
                    (0..64).filter(set).fold(0, |word, b| word | 1 << b)
                };
                mask.iter()
                    .map(|row| std::array::from_fn(|k| word(row, k)))
                    .collect()
            };
            let rows = bits(1);
            let free = |x: usize, y: usize| {
                rows.iter()
                    .zip(&taken[y..])
                    .all(|(row, taken)| shifted(row, x).iter().zip(taken).all(|(a, b)| a & b == 0))
            };
            let found = (0..=CELLS - h)
                .take_while(|y| best.as_ref().is_none_or(|b| y + h < b.0))
                .find_map(|y| (0..=CELLS - w).find(|&x| free(x, y)).map(|x| (x, y)));
            if let Some((x, y)) = found {
                best = Some((y + h, x, y, turn, bits(2)));
            }
        }
        let (_, x, y, turn, rows) = best?;
        places[i] = ([x, y], turn);
        for (row, taken) in rows.iter().zip(&mut taken[y..]) {
            for (a, b) in shifted(row, x).iter().zip(taken.iter_mut()) {
                *b |= a;
            }
        }
    }
    Some(places)
}

/// Places of all charts, as [`place`] gives them, and the scale from chart to cells.
pub(crate) fn layout(charts: &[Chart]) -> (Vec<([usize; 2], u8)>, f64) {
    // Large charts first, by length and by something nearer area: greedy packing is too uneven to trust one order.
    let orders: Vec<Vec<usize>> = [0.0, 0.6]
        .map(|bias| {
            let measure = |&k: &usize| {
                let [w, h]: [f64; 2] = charts[k].size();
                libm::pow(h / w, bias) * w
            };
            let mut order: Vec<usize> = (0..charts.len()).collect();
            order.sort_by(|a, b| measure(b).total_cmp(&measure(a)));
            order
        })
        .to_vec();
    let total: f64 = charts
        .iter()
        .flat_map(|c| c.corners.iter().map(|q| area(q.iter().map(|&v| c.uv[v]))))
        .sum();
    // The largest scale that fits, from one that would fill three fifths of the square.
    let mut scale = 0.78 * CELLS as f64 / total.sqrt();
    loop {
        scale *= 0.99;
        if let Some(p) = orders.iter().find_map(|o| place(charts, o, scale)) {
            return (p, scale);
        }
    }
}
