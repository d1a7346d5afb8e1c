//! Scenes for the tests of the rasteriser: random numbers, sheets of points cut into blocks, cameras.
#![allow(dead_code, unreachable_pub, reason = "not every test uses every part")]

use earmark::raster::{Cell, ProjectedBlock, Tile, draw_block, project};
use earmark::records::{BlockSize, Grid3, Projection};
use earmark::simd::Level;

/// A small generator (PCG), so that a failure can be repeated from its seed.
pub struct Random(pub u64);

impl Random {
    /// 32 random bits.
    pub fn bits(&mut self) -> u32 {
        let old = self.0;
        self.0 = old
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let mixed = (((old >> 18) ^ old) >> 27) as u32;
        mixed.rotate_right((old >> 59) as u32)
    }
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / (1 << 24) as f32
    }
    pub fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }
    pub fn below(&mut self, n: u32) -> u32 {
        ((u64::from(self.bits()) * u64::from(n)) >> 32) as u32
    }
}

/// A grid of points, row by row.
pub struct Sheet {
    pub cols: usize,
    pub rows: usize,
    pub points: Vec<[f32; 3]>,
}

impl Sheet {
    /// Blocks of up to `side` quads a side, neighbours sharing their border points.
    pub fn blocks(&self, side: usize) -> Vec<(Box<Grid3>, BlockSize)> {
        let mut blocks = Vec::new();
        for j0 in (0..self.rows - 1).step_by(side) {
            for i0 in (0..self.cols - 1).step_by(side) {
                let size = BlockSize {
                    cols: (self.cols - i0).min(side + 1),
                    rows: (self.rows - j0).min(side + 1),
                };
                let mut grid = Grid3::boxed();
                for j in 0..size.rows {
                    for i in 0..size.cols {
                        grid.set(i, j, self.points[(j0 + j) * self.cols + i0 + i]);
                    }
                }
                blocks.push((grid, size));
            }
        }
        blocks
    }
}

/// Grid coordinates are 1/256 pixels, depth is `1.5 + z`.
pub const FLAT: Projection = Projection {
    x: [1.0, 0.0, 0.0, 0.0],
    y: [0.0, 1.0, 0.0, 0.0],
    w: [0.0, 0.0, 0.0, 1.0],
    d: [0.0, 0.0, 1.0, 1.5],
    near: 0.0,
    ortho: true,
};

/// A camera at `eye` looking at `target`, `scale` half pictures per unit at distance 1; picture of `side` pixels.
pub fn camera(eye: [f32; 3], target: [f32; 3], scale: f32, side: u32, near: f32) -> Projection {
    let sub = |a: [f32; 3], b: [f32; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross = |a: [f32; 3], b: [f32; 3]| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    let unit = |a: [f32; 3]| a.map(|c| c / dot(a, a).sqrt());
    let w = unit(sub(target, eye));
    let x = unit(cross(w, [0.13, 0.21, 0.97]));
    let y = cross(w, x);
    let half = side as f32 * 128.0;
    let row = |axis: [f32; 3], s: f32, shift: f32| {
        let r = [0, 1, 2].map(|k| axis[k] * s + w[k] * shift);
        [r[0], r[1], r[2], -dot(r, eye)]
    };
    Projection {
        x: row(x, scale * half, half),
        y: row(y, scale * half, half),
        w: row(w, 1.0, 0.0),
        d: [0.0; 4],
        near,
        ortho: false,
    }
}

pub fn draw_all<C: Cell>(tile: &mut Tile<C>, sheet: &Sheet, side: usize, p: &Projection) -> usize {
    let mut block = ProjectedBlock::boxed();
    let mut clipped = 0;
    for (rank, (grid, size)) in sheet.blocks(side).iter().enumerate() {
        project(Level::detect(), grid, *size, p, &mut block);
        clipped += usize::from(block.is_clipped());
        draw_block(Level::detect(), tile, &block, rank as u32);
    }
    clipped
}
