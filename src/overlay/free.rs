//! Straight lines that are no part of the surface: edges of cages, and axes. They are found once and looked up tile by tile.

use super::Layers;
use super::lens::Lens;
use super::lines::{CAGE_LIFT, Segment, is};
use super::marks::axes;
use super::squares::{Cells, Squares};
use crate::frame::Scene;
use crate::limits::{LimitError, Limits};
use crate::raster::tile_side;
use crate::records::ScreenSize;

/// Pixels by which a line is taken to be in squares beside it: more than rounding of ends that are far outside.
const SLACK: f64 = 1.0;

/// What messages call them.
const WHAT: &str = "the lines of the cage";

/// A straight line in the model, and how much nearer it is taken to be.
#[derive(Clone, Copy, Debug)]
pub(super) struct FreeLine {
    pub(super) segment: Segment,
    pub(super) lift: f64,
}

/// All that may be in the picture.
pub(super) struct FreeLines {
    lines: Vec<FreeLine>,
    /// As large as tiles.
    squares: Squares,
    cells: Cells,
}

impl FreeLines {
    /// Finds the lines of `layers`.
    ///
    /// # Errors
    /// There are more than memory allows, or time is up.
    pub(super) fn new(
        scene: &Scene,
        layers: Layers,
        lens: &Lens,
        size: ScreenSize,
        limits: &Limits,
    ) -> Result<Self, LimitError> {
        let edges = scene.objects.iter().map(|o| o.surface.topology());
        let edges: usize = match layers.contains(Layers::CAGE) {
            true => edges.map(|t| t.edge_count()).sum(),
            false => 0,
        };
        let most = edges + if layers.contains(Layers::AXES) { 3 } else { 0 };
        limits.memory(WHAT, most as u128 * size_of::<FreeLine>() as u128)?;
        let mut lines = Vec::with_capacity(most);
        let picture = [size.width, size.height].map(f64::from);
        let mut add = |p: [f32; 3], q: [f32; 3], flags: u16| {
            let Some(ends) = lens.line(&lens.wide(p), &lens.wide(q)) else {
                return;
            };
            let [a, b] = ends;
            if a != b && ends.as_flattened().iter().all(|c| c.is_finite()) {
                let segment = Segment::new(a, b, flags);
                if meets(&segment, picture) {
                    let lift = CAGE_LIFT;
                    lines.push(FreeLine { segment, lift });
                }
            }
        };
        if layers.contains(Layers::CAGE) {
            for object in &scene.objects {
                limits.check()?;
                let (t, points) = (object.surface.topology(), object.surface.cage().points());
                for e in 0..t.edge_count() as u32 {
                    let h = t.edge_half(e);
                    let [a, b] = [t.vertex(h), t.vertex(t.next(h))].map(|v| points[v as usize]);
                    add(a, b, is::CAGE);
                }
            }
        }
        if layers.contains(Layers::AXES) {
            let (start, tips) = axes(scene);
            let kinds = [is::AXIS, is::SECOND_AXIS, is::THIRD_AXIS];
            for (tip, flags) in tips.into_iter().zip(kinds) {
                add(start, tip, flags);
            }
        }
        Self::sorted(lines, picture, limits)
    }

    /// Sorts lines into squares.
    fn sorted(
        lines: Vec<FreeLine>,
        picture: [f64; 2],
        limits: &Limits,
    ) -> Result<Self, LimitError> {
        let squares = Squares::new([0.0; 2], picture, f64::from(tile_side(1, false)));
        let each = |k: usize, visit: &mut dyn FnMut(usize)| {
            let line: &FreeLine = &lines[k];
            let (segment, stretch) = (&line.segment, [0.0, 1.0]);
            squares.through(segment, stretch, hull(segment), SLACK, visit);
        };
        let mut places = 0_u64;
        (0..lines.len()).for_each(|k| each(k, &mut |_| places += 1));
        let bytes = lines.capacity() * size_of::<FreeLine>() + squares.len() * 8;
        limits.memory(WHAT, bytes as u128 + u128::from(places) * 4)?;
        if places > u64::from(u32::MAX) {
            return Err(LimitError::Memory {
                what: WHAT,
                wanted: places.saturating_mul(4),
                allowed: u64::from(u32::MAX) * 4,
            });
        }
        let cells = Cells::new(squares.len(), lines.len(), each);
        Ok(Self {
            lines,
            squares,
            cells,
        })
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> u128 {
        let lines = self.lines.capacity() * size_of::<FreeLine>();
        (lines + self.squares.len() * 4 + self.cells.len() * 4) as u128
    }

    /// Numbers of the lines that may be in a tile (first column and row, columns and rows), in order.
    pub(super) fn near(&self, [x, y, width, height]: [u32; 4]) -> Vec<u32> {
        let low = [x, y].map(f64::from);
        let high = [x + width, y + height].map(|end| f64::from(end) - 0.5);
        let [first, last] = self.squares.range(low, high);
        let mut out = Vec::new();
        for row in first[1]..=last[1] {
            for column in first[0]..=last[0] {
                out.extend_from_slice(self.cells.of(self.squares.index(column, row)));
            }
        }
        if first != last {
            out.sort_unstable();
            out.dedup();
        }
        out
    }

    /// A line by its number.
    pub(super) fn line(&self, number: u32) -> (Segment, f64) {
        let line = &self.lines[number as usize];
        (line.segment, line.lift)
    }
}

/// Whether the box of a line meets the picture.
fn meets(line: &Segment, picture: [f64; 2]) -> bool {
    let [low, high] = hull(line);
    (0..2).all(|k| high[k] >= 0.0 && low[k] <= picture[k])
}

/// The box of a line on the screen.
fn hull(line: &Segment) -> [[f64; 2]; 2] {
    let both = |by: fn(f64, f64) -> f64| [0, 1].map(|k| by(line.a[k], line.b[k]));
    [both(f64::min), both(f64::max)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::overlay::hidden::Visibility;
    use crate::overlay::lens::Spot;

    const PICTURE: [u32; 2] = [1000, 700];

    /// Lines of all lengths in and around the picture, some of them along the borders of tiles.
    fn lines() -> Vec<FreeLine> {
        let mut state = 7_u32;
        let mut random = |below: f64| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24) * below
        };
        let mut out = Vec::new();
        for k in 0..2000 {
            let reach = [3.0, 60.0, 900.0, 1e9][k % 4];
            let mut a: Spot = [random(1400.0) - 200.0, random(1100.0) - 200.0, 1.0];
            if k % 5 == 0 {
                a[k % 2] = (a[k % 2] / 256.0).round() * 256.0;
            }
            let mut b = [0, 1].map(|c| a[c] + random(2.0 * reach) - reach);
            if k % 10 == 0 {
                b[k % 2] = a[k % 2];
            }
            let segment = Segment::new(a, [b[0], b[1], 1.0], is::CAGE);
            if meets(&segment, PICTURE.map(f64::from)) {
                out.push(FreeLine { segment, lift: 0.0 });
            }
        }
        out
    }

    #[test]
    fn every_tile_finds_its_lines_and_few_others() {
        let all = lines();
        let picture = PICTURE.map(f64::from);
        let free = FreeLines::sorted(all.clone(), picture, &Limits::default()).unwrap();
        // The tiles of pictures, and others.
        for side in [256, 128, 100] {
            let (mut found, mut wanted) = (0, 0);
            for y in (0..PICTURE[1]).step_by(side) {
                for x in (0..PICTURE[0]).step_by(side) {
                    let side = side as u32;
                    let rect = [x, y, side.min(PICTURE[0] - x), side.min(PICTURE[1] - y)];
                    let near = free.near(rect);
                    assert!(near.is_sorted_by(|a, b| a < b));
                    found += near.len();
                    for (k, l) in all.iter().enumerate() {
                        let one = std::iter::once((l.segment, l.lift));
                        let is_in = !Visibility::new(rect, one, std::iter::empty()).is_empty();
                        let known = near.binary_search(&(k as u32)).is_ok();
                        assert!(known || !is_in, "{:?} in {rect:?}", l.segment);
                        wanted += usize::from(is_in);
                    }
                }
            }
            assert!(wanted > 1000);
            let most = if side == 256 {
                wanted * 3 / 2
            } else {
                wanted * 8
            };
            assert!(found < most, "{side}: {found} for {wanted}");
        }
    }

    #[test]
    fn places_are_counted_before_they_are_taken() {
        let all = lines();
        let least = (all.len() * size_of::<FreeLine>()) as u64;
        let mut limits = Limits::default();
        let mut sorted = |bytes: u64| {
            limits.max_memory = Some(bytes);
            FreeLines::sorted(all.clone(), PICTURE.map(f64::from), &limits).map(|f| f.bytes())
        };
        assert!(sorted(least).is_err());
        let bytes = sorted(least + 100_000).unwrap();
        assert!(bytes > u128::from(least) && bytes <= u128::from(least) + 100_000);
    }
}
