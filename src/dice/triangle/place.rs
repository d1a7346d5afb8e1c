//! Where control triangles lie in the grid of a face.

/// Where a control triangle lies in the grid of its face: its corner 0 at `origin`, and steps of its own lattice in grid points. Corner 1
/// is `size` steps `du` from corner 0, corner 2 another `size` steps `dv` on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) origin: [i32; 2],
    pub(crate) du: [i32; 2],
    pub(crate) dv: [i32; 2],
    pub(crate) size: u32,
}

impl Place {
    /// The whole grid of a face of `size` segments.
    pub(crate) fn root(size: u32) -> Self {
        Self {
            origin: [0, 0],
            du: [1, 0],
            dv: [0, 1],
            size,
        }
    }

    /// Grid point of lattice point (`i`, `j`).
    pub(crate) fn at(&self, [i, j]: [i32; 2]) -> [i32; 2] {
        [0, 1].map(|k| self.origin[k] + i * self.du[k] + j * self.dv[k])
    }

    /// The same triangle with its corners 1, 2, 0 as corners 0, 1, 2.
    pub(crate) fn turned(&self) -> Self {
        Self {
            origin: self.at([self.size as i32, 0]),
            du: self.dv,
            dv: [0, 1].map(|k| -self.du[k] - self.dv[k]),
            size: self.size,
        }
    }

    /// Child `c` of a 1-to-4 split: 0 to 2 at the corners, 3 in the middle, whose corners are the middles of sides 1, 2, 0.
    pub(crate) fn child(&self, c: usize) -> Self {
        let half = self.size as i32 / 2;
        let at = [[0, 0], [half, 0], [half, half], [2 * half, half]][c];
        let sign = if c == 3 { -1 } else { 1 };
        Self {
            origin: self.at(at),
            du: self.du.map(|d| sign * d),
            dv: self.dv.map(|d| sign * d),
            size: half as u32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::basis::OFFSETS;
    use super::super::tensor::TURN;
    use super::*;

    #[test]
    fn turning_thrice_is_nothing_and_follows_the_lattice() {
        for (k, &from) in TURN.iter().enumerate() {
            let [i, j] = OFFSETS[k];
            assert_eq!(OFFSETS[from], [1 - j, i - j]);
            assert_eq!(TURN[TURN[from]], k);
        }
        let place = Place::root(8);
        assert_eq!(place.turned().turned().turned(), place);
        assert_eq!(place.turned().origin, [8, 0]);
        assert_eq!(place.child(3).at([4, 0]), [4, 4]);
        assert_eq!(place.child(3).at([4, 4]), [4, 0]);
    }
}
