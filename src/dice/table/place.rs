//! Where the faces of deeper levels stand in the grid of a face.

/// A face of a deeper level in the grid of the face that it comes from: its first corner stands at `origin`, and its own grid point
/// (i, j) at `origin + turn * (i, j)`, in units of its own size. The triangle in the middle of four stands on its head.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) origin: [i32; 2],
    pub(crate) turn: i32,
}

impl Place {
    /// Place of grid point (i, j) of a face whose grid has `n` segments.
    pub(crate) fn at(self, n: i32, i: i32, j: i32) -> [i32; 2] {
        [
            self.origin[0] * n + self.turn * i,
            self.origin[1] * n + self.turn * j,
        ]
    }
}

/// Places of the `4^depth` faces `depth` levels below a face, by number.
pub(crate) fn places(triangular: bool, depth: u32) -> Vec<Place> {
    let mut out = vec![Place {
        origin: [0, 0],
        turn: 1,
    }];
    // Origins and turns of the children of a face of two segments.
    let children: [([i32; 2], i32); 4] = match triangular {
        false => [([0, 0], 1), ([1, 0], 1), ([1, 1], 1), ([0, 1], 1)],
        true => [([0, 0], 1), ([1, 0], 1), ([1, 1], 1), ([2, 1], -1)],
    };
    for _ in 0..depth {
        let next = |p: &Place| {
            let p = *p;
            children.map(|([i, j], turn)| Place {
                origin: p.at(1, i, j),
                turn: p.turn * turn,
            })
        };
        let doubled = out.iter().map(|p| Place {
            origin: p.origin.map(|c| 2 * c),
            ..*p
        });
        out = doubled.flat_map(|p| next(&p)).collect();
    }
    out
}

/// Faces by the unit squares of the grid that they fill, row by row: for triangles the one on the side of (i + 1, j) and the one on the
/// side of (i, j + 1), where there are such.
pub(crate) fn cells(triangular: bool, depth: u32) -> Vec<[u32; 2]> {
    let side = 1_usize << depth;
    let mut out = vec![[u32::MAX; 2]; side * side];
    for (face, p) in places(triangular, depth).into_iter().enumerate() {
        let upper = p.turn < 0;
        let [i, j] = p.origin.map(|c| (c - i32::from(upper)) as usize);
        out[j * side + i][usize::from(upper)] = face as u32;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_are_filled_once() {
        for depth in 0..5 {
            let side = 1 << depth;
            for triangular in [false, true] {
                let cells = cells(triangular, depth);
                let mut seen: Vec<u32> = cells.iter().flatten().copied().collect();
                seen.retain(|&f| f != u32::MAX);
                seen.sort_unstable();
                assert!(seen.into_iter().eq(0..1 << (2 * depth)));
                for (k, [lower, upper]) in cells.into_iter().enumerate() {
                    let (i, j) = (k % side, k / side);
                    assert_eq!(lower != u32::MAX, !triangular || j <= i);
                    assert_eq!(upper != u32::MAX, triangular && j < i);
                }
            }
        }
    }
}
