//! Projection for lines, in double precision and without snapping: equal points get equal positions, and nothing else matters here.

use crate::camera::View;
use crate::records::{BLOCK_LEN, BlockSize, Grid3};

/// Position in pixels, and depth: larger when nearer, linear along lines on the screen.
pub(super) type Spot = [f64; 3];

/// Depth range in front of the near plane of parallel views, as the rasteriser has it.
const ORTHO_NEAR: f64 = 2.0;

/// A view in double precision.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lens {
    rows: [[f64; 4]; 4],
    near: f64,
    ortho: bool,
}

/// A point before division: X, Y, W and depth, and how far it is behind the near plane.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wide {
    row: [f64; 4],
    beyond: f64,
}

impl Wide {
    fn toward(&self, other: &Self, t: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * t;
        Self {
            row: [0, 1, 2, 3].map(|k| mix(self.row[k], other.row[k])),
            beyond: 0.0,
        }
    }

    /// Where the line to a point on the other side of the near plane crosses it; the same from either end.
    fn crossing(&self, other: &Self) -> Self {
        match self.beyond >= 0.0 {
            true => self.toward(other, self.beyond / (self.beyond - other.beyond)),
            false => other.crossing(self),
        }
    }
}

impl Lens {
    pub(super) fn new(view: &View) -> Self {
        let p = &view.projection;
        let wide = |row: [f32; 4], scale: f64| row.map(|c| f64::from(c) * scale);
        Self {
            rows: [
                wide(p.x, 1.0 / 256.0),
                wide(p.y, 1.0 / 256.0),
                wide(p.w, 1.0),
                wide(p.d, 1.0),
            ],
            near: f64::from(p.near),
            ortho: p.ortho,
        }
    }

    pub(super) fn wide(&self, p: [f32; 3]) -> Wide {
        let p = p.map(f64::from);
        let row = self
            .rows
            .map(|r| (r[0] * p[0] + r[1] * p[1]) + (r[2] * p[2] + r[3]));
        let beyond = match self.ortho {
            true => ORTHO_NEAR - row[3],
            false => row[2] - self.near,
        };
        Wide { row, beyond }
    }

    fn divided(&self, w: &Wide) -> Spot {
        let [x, y, w, d] = w.row;
        match self.ortho {
            true => [x, y, d],
            false => [x / w, y / w, 1.0 / w],
        }
    }

    /// Where a point is seen; `None` before the near plane.
    pub(super) fn spot(&self, p: [f32; 3]) -> Option<Spot> {
        let w = self.wide(p);
        (w.beyond >= 0.0).then(|| self.divided(&w))
    }

    /// What of a line is behind the near plane.
    pub(super) fn line(&self, a: &Wide, b: &Wide) -> Option<[Spot; 2]> {
        let end = |a: &Wide, b: &Wide| match a.beyond >= 0.0 {
            true => self.divided(a),
            false => self.divided(&a.crossing(b)),
        };
        (a.beyond >= 0.0 || b.beyond >= 0.0).then(|| [end(a, b), end(b, a)])
    }

    /// What of a triangle is behind the near plane: none, one or two triangles.
    pub(super) fn triangle(&self, corners: [&Wide; 3], mut out: impl FnMut([Spot; 3])) {
        let mut kept = [[0.0; 3]; 4];
        let mut count = 0;
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            if a.beyond >= 0.0 {
                kept[count] = self.divided(a);
                count += 1;
            }
            if (a.beyond >= 0.0) != (b.beyond >= 0.0) {
                kept[count] = self.divided(&a.crossing(b));
                count += 1;
            }
        }
        for k in 2..count {
            out([kept[0], kept[k - 1], kept[k]]);
        }
    }
}

/// The points of a block on the screen.
pub(super) struct Screen {
    pub(super) spots: Vec<Spot>,
    pub(super) wide: Vec<Wide>,
    /// A point lies before the near plane; its spot means nothing.
    pub(super) is_clipped: bool,
}

impl Screen {
    pub(super) fn new() -> Self {
        Self {
            spots: vec![[0.0; 3]; BLOCK_LEN],
            wide: vec![Wide::default(); BLOCK_LEN],
            is_clipped: false,
        }
    }

    pub(super) fn project(&mut self, lens: &Lens, points: &Grid3, size: BlockSize) {
        self.is_clipped = false;
        for k in size.indices() {
            let w = lens.wide(points.at(k));
            self.is_clipped |= w.beyond < 0.0;
            self.wide[k] = w;
            self.spots[k] = lens.divided(&w);
        }
    }

    /// Twice the area of a triangle on the screen; `None` where the near plane cuts it.
    pub(super) fn area(&self, [p, q, r]: [usize; 3]) -> Option<f64> {
        if self.is_clipped && [p, q, r].iter().any(|&k| self.wide[k].beyond < 0.0) {
            return None;
        }
        Some(area(self.spots[p], self.spots[q], self.spots[r]))
    }
}

/// Twice the signed area of a triangle on the screen. Exactly 0 where two corners are equal.
#[inline]
pub(super) fn area(p: Spot, q: Spot, r: Spot) -> f64 {
    (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
}
