//! Exact edge functions. `E(p) = dx*(p.y - a.y) - dy*(p.x - a.x)` of the edge from `a` with direction `(dx, dy)` is an integer; all
//! paths compute the same one, in i32, in i64, or in floats where it is below the mantissa.
//!
//! A sample on an edge is decided as if it were moved by `(+e, +e*e)` for an infinitely small `e`: then no sample is on any edge,
//! and the sign of `E` is never zero. The rule needs no orientation, and an edge looked at from its other end gets the opposite
//! sign, so a sample on the common edge of two triangles is in exactly one of them. A triangle covers a sample where the three
//! signs agree, whichever they are: both of its sides are visible.

/// What is added to a picture by breaking a rule on purpose. Only tests use other than [`Fault::None`]: they show that the tests
/// of coverage notice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[doc(hidden)]
pub enum Fault {
    /// Nothing broken.
    #[default]
    None,
    /// A sample on an edge counts as positive whatever the edge's direction.
    NoTieRule,
}

impl Fault {
    /// What the tie rule may add: 1, or 0 where it is switched off.
    #[inline(always)]
    pub(super) fn tie(self) -> i32 {
        match self {
            Self::None => 1,
            Self::NoTieRule => 0,
        }
    }
}

/// The sign of an edge is positive where `E >= threshold`: 0 where a sample on the edge moves to its positive side, else `tie`.
#[inline(always)]
pub(super) fn threshold(dx: i32, dy: i32, tie: i32) -> i32 {
    if (dy < 0) | ((dy == 0) & (dx > 0)) {
        0
    } else {
        tie
    }
}

/// A vertex on the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ScreenVertex {
    pub(super) x: i32,
    pub(super) y: i32,
    pub(super) depth: f32,
}

/// First pixel whose sample, `offset` into the pixel, is at or after `from`; with the box of a triangle this gives the half-open
/// window of the samples that it can cover.
#[inline(always)]
pub(super) fn first_pixel(from: i32, offset: i32) -> i32 {
    (from - offset + 255) >> 8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reversed_edges_disagree() {
        for dx in -3..=3 {
            for dy in -3..=3 {
                if (dx, dy) == (0, 0) {
                    continue;
                }
                for e in -2..=2 {
                    let forward = e >= threshold(dx, dy, 1);
                    let backward = -e >= threshold(-dx, -dy, 1);
                    assert_ne!(forward, backward, "{dx} {dy} {e}");
                }
            }
        }
    }

    #[test]
    fn windows_are_half_open() {
        assert_eq!(first_pixel(128, 128), 0);
        assert_eq!(first_pixel(129, 128), 1);
        assert_eq!(first_pixel(-128, 128), -1);
        assert_eq!(first_pixel(-127, 128), 0);
    }
}
