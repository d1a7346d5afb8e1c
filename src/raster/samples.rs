//! Sample positions inside a pixel. One sample stands in the centre; 4, 8 and 16 are the standard patterns of Direct3D, which
//! Vulkan shares: no two samples of a pattern have a row or a column in common (16: at most one neighbour each).

/// Positions in units of 1/256 pixel from the pixel's upper left corner, x to the right, y down.
///
/// | samples | offsets from the centre, 1/16 pixel |
/// |---|---|
/// | 1 | (0,0) |
/// | 4 | (-2,-6) (6,-2) (-6,2) (2,6) |
/// | 8 | (1,-3) (-1,3) (5,1) (-3,-5) (-5,5) (-7,-1) (3,7) (7,-7) |
/// | 16 | (1,1) (-1,-3) (-3,2) (4,-1) (-5,-2) (2,5) (5,3) (3,-5) (-2,6) (0,-7) (-4,-6) (-6,4) (-8,0) (7,-4) (6,7) (-7,-8) |
///
/// # Panics
/// `samples` is not 1, 4, 8 or 16.
#[must_use]
pub fn sample_positions(samples: u32) -> &'static [[i32; 2]] {
    match samples {
        1 => &ONE,
        4 => &FOUR,
        8 => &EIGHT,
        16 => &SIXTEEN,
        _ => panic!("samples per pixel must be 1, 4, 8 or 16, not {samples}"),
    }
}

const fn from_centre<const N: usize>(offsets: [[i32; 2]; N]) -> [[i32; 2]; N] {
    let mut positions = [[0; 2]; N];
    let mut k = 0;
    while k < N {
        positions[k] = [128 + 16 * offsets[k][0], 128 + 16 * offsets[k][1]];
        k += 1;
    }
    positions
}

static ONE: [[i32; 2]; 1] = from_centre([[0, 0]]);
static FOUR: [[i32; 2]; 4] = from_centre([[-2, -6], [6, -2], [-6, 2], [2, 6]]);
static EIGHT: [[i32; 2]; 8] = from_centre([
    [1, -3],
    [-1, 3],
    [5, 1],
    [-3, -5],
    [-5, 5],
    [-7, -1],
    [3, 7],
    [7, -7],
]);
static SIXTEEN: [[i32; 2]; 16] = from_centre([
    [1, 1],
    [-1, -3],
    [-3, 2],
    [4, -1],
    [-5, -2],
    [2, 5],
    [5, 3],
    [3, -5],
    [-2, 6],
    [0, -7],
    [-4, -6],
    [-6, 4],
    [-8, 0],
    [7, -4],
    [6, 7],
    [-7, -8],
]);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_are_inside_and_distinct() {
        for samples in [1, 4, 8, 16] {
            let positions = sample_positions(samples);
            assert_eq!(positions.len(), samples as usize);
            for (k, p) in positions.iter().enumerate() {
                assert!(p.iter().all(|&c| (0..256).contains(&c)));
                assert!(positions[..k].iter().all(|q| q[0] != p[0] && q[1] != p[1]));
            }
        }
    }
}
