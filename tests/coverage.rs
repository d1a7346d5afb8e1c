//! Coverage: every sample inside a sheet exactly once, fronts equal backs over closed surfaces, and the same keys from every path
//! and vector level. The harness is shown to bite by breaking the tie rule and by moving one copy of a shared point by 1/256 pixel.

use earmark::raster::{
    Coverage, Fault, Key, Path, ProjectedBlock, SoupVertex, Tile, barycentrics, draw_block,
    draw_block_with, draw_triangles, draw_triangles_with, project, project_vertices,
    sample_positions, soup_id, soup_triangle, tile_side, triangle_weights,
};
use earmark::records::{BlockSize, Grid3, Projection, SampleId};
use earmark::simd::Level;

/// A small generator (PCG), so that a failure can be repeated from its seed.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u32 {
        let old = self.0;
        self.0 = old
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let mixed = (((old >> 18) ^ old) >> 27) as u32;
        mixed.rotate_right((old >> 59) as u32)
    }
    fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / (1 << 24) as f32
    }
    fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }
    fn below(&mut self, n: u32) -> u32 {
        (u64::from(self.bits()) * u64::from(n) >> 32) as u32
    }
}

/// A grid of points, row by row.
struct Sheet {
    cols: usize,
    rows: usize,
    points: Vec<[f32; 3]>,
}

impl Sheet {
    /// Blocks of up to `side` quads a side, neighbours sharing their border points.
    fn blocks(&self, side: usize) -> Vec<(Box<Grid3>, BlockSize)> {
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
const FLAT: Projection = Projection {
    x: [1.0, 0.0, 0.0, 0.0],
    y: [0.0, 1.0, 0.0, 0.0],
    w: [0.0, 0.0, 0.0, 1.0],
    d: [0.0, 0.0, 1.0, 1.5],
    near: 0.0,
    ortho: true,
};

/// A rectangle of the screen in 1/256 pixel, cut into convex quads with integer corners, many of them on samples.
fn rectangle(random: &mut Random) -> (Sheet, [i32; 4]) {
    let cell = [8, 40, 150, 500, 1024, 2100, 8000, 30_000][random.below(8) as usize];
    let most = 120.min(90_000 / cell).max(1) as u32;
    let (cols, rows) = (
        2 + random.below(most) as usize,
        2 + random.below(most) as usize,
    );
    let (left, top) = (
        random.below(40_000) as i32 - 12_000,
        random.below(40_000) as i32 - 12_000,
    );
    let aligned = cell >= 1024 && random.below(2) == 0;
    let jitter = cell * if aligned { 15 } else { 24 } / 100;
    let mut points = Vec::new();
    let snap = |v: i32| {
        if aligned {
            (v + 64).div_euclid(128) * 128
        } else {
            v
        }
    };
    for j in 0..rows {
        for i in 0..cols {
            let mut at = [left + i as i32 * cell, top + j as i32 * cell];
            let inner = [i > 0 && i + 1 < cols, j > 0 && j + 1 < rows];
            for k in 0..2 {
                if inner[k] {
                    at[k] += random.below(2 * jitter as u32 + 1) as i32 - jitter;
                }
                at[k] = snap(at[k]);
            }
            points.push([at[0] as f32, at[1] as f32, 0.0]);
        }
    }
    let end = |start: i32, n: usize| snap(start + (n as i32 - 1) * cell);
    let bounds = [snap(left), snap(top), end(left, cols), end(top, rows)];
    (Sheet { cols, rows, points }, bounds)
}

/// Samples of a tile that are not covered exactly once inside, and not at all outside, of `[left, top, right, bottom]`; a sample on
/// the border is inside on the left and above. Returns (wrong, inside).
fn miscounted(tile: &Tile<Coverage>, bounds: [i32; 4]) -> (u64, u64) {
    let ([x0, y0], [_, height]) = (tile.origin(), tile.size());
    let (mut wrong, mut checked) = (0, 0);
    for (s, [ox, oy]) in sample_positions(tile.samples()).iter().enumerate() {
        for y in 0..height {
            for (x, cell) in tile.row(y, s as u32).iter().enumerate() {
                let (px, py) = (
                    (x0 as i32 + x as i32) * 256 + ox,
                    (y0 + y) as i32 * 256 + oy,
                );
                let inside = px >= bounds[0] && py >= bounds[1] && px < bounds[2] && py < bounds[3];
                wrong += u64::from(cell.hits != i32::from(inside));
                checked += u64::from(inside);
            }
        }
    }
    (wrong, checked)
}

fn coverage_tile(samples: u32) -> Tile<Coverage> {
    let side = tile_side(samples);
    Tile::new(37, 21, side, side, samples)
}

fn draw_sheet(tile: &mut Tile<Coverage>, sheet: &Sheet, side: usize, path: Path, fault: Fault) {
    let mut block = ProjectedBlock::boxed();
    for (rank, (grid, size)) in sheet.blocks(side).iter().enumerate() {
        project(Level::detect(), grid, *size, &FLAT, &mut block);
        draw_block_with(Level::detect(), tile, &block, rank as u32, path, fault);
    }
}

#[test]
fn rectangles_of_blocks_exactly_once() {
    let mut random = Random(1);
    let mut total = 0;
    for samples in [1, 4, 8, 16] {
        let mut tile = coverage_tile(samples);
        let mut checked = 0;
        let mut scenes = 0;
        while checked < 3_000_000 {
            let (sheet, bounds) = rectangle(&mut random);
            let side = 1 + random.below(32) as usize;
            tile.clear();
            draw_sheet(&mut tile, &sheet, side, Path::Auto, Fault::None);
            let (wrong, inside) = miscounted(&tile, bounds);
            assert_eq!(wrong, 0, "scene {scenes} at {samples} samples");
            checked += inside;
            scenes += 1;
        }
        total += checked;
    }
    println!("{total} samples inside, each covered once");
}

/// The sheet as a soup, each quad with a diagonal of its own.
fn soup_of(sheet: &Sheet, random: &mut Random) -> (Vec<SoupVertex>, Vec<[u32; 3]>) {
    let vertices = sheet
        .points
        .iter()
        .map(|p| SoupVertex::at(p[0] as i32, p[1] as i32, 1.5))
        .collect();
    let mut triangles = Vec::new();
    for j in 0..sheet.rows - 1 {
        for i in 0..sheet.cols - 1 {
            let a = (j * sheet.cols + i) as u32;
            let (b, d) = (a + 1, a + sheet.cols as u32);
            let c = d + 1;
            let mut pair = if random.below(2) == 0 {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            };
            // Orientation and first corner must not matter.
            for t in &mut pair {
                t.rotate_left(random.below(3) as usize);
                if random.below(2) == 0 {
                    t.reverse();
                }
            }
            triangles.extend(pair);
        }
    }
    (vertices, triangles)
}

#[test]
fn rectangles_of_triangles_exactly_once() {
    let mut random = Random(2);
    let mut total = 0;
    for samples in [1, 4, 8, 16] {
        let mut tile = coverage_tile(samples);
        let mut checked = 0;
        while checked < 1_000_000 {
            let (sheet, bounds) = rectangle(&mut random);
            let (vertices, triangles) = soup_of(&sheet, &mut random);
            tile.clear();
            draw_triangles(
                Level::detect(),
                &mut tile,
                &vertices,
                &triangles,
                &FLAT,
                0,
                0,
            );
            let (wrong, inside) = miscounted(&tile, bounds);
            assert_eq!(wrong, 0);
            checked += inside;
        }
        total += checked;
    }
    println!("{total} samples inside, each covered once");
}

#[test]
fn broken_rules_are_noticed() {
    let mut random = Random(3);
    let mut wrong = [0; 5];
    for _ in 0..60 {
        for samples in [1, 16] {
            let mut tile = coverage_tile(samples);
            let (mut sheet, bounds) = rectangle(&mut random);
            for (k, path) in [Path::Auto, Path::Medium, Path::Span]
                .into_iter()
                .enumerate()
            {
                tile.clear();
                draw_sheet(&mut tile, &sheet, 16, path, Fault::NoTieRule);
                wrong[k] += miscounted(&tile, bounds).0;
            }
            let (vertices, triangles) = soup_of(&sheet, &mut random);
            tile.clear();
            draw_triangles_with(
                Level::detect(),
                &mut tile,
                &vertices,
                &triangles,
                Fault::NoTieRule,
            );
            wrong[3] += miscounted(&tile, bounds).0;
            // One copy of every block's first point moves.
            tile.clear();
            let mut block = ProjectedBlock::boxed();
            sheet.points.iter_mut().for_each(|p| p[2] = 0.0);
            for (rank, (grid, size)) in sheet.blocks(4).iter().enumerate() {
                project(Level::detect(), grid, *size, &FLAT, &mut block);
                block.nudge(0, 0, 1);
                draw_block(Level::detect(), &mut tile, &block, rank as u32);
            }
            wrong[4] += miscounted(&tile, bounds).0;
        }
    }
    println!(
        "wrong samples: no tie rule {:?}, moved points {}",
        &wrong[..4],
        wrong[4]
    );
    assert!(wrong.iter().all(|&w| w > 0), "{wrong:?}");
}

/// A bumpy torus around the z axis, closed: the last row and column repeat the first bit by bit. Inner points may be wild.
fn torus(random: &mut Random, nu: usize, nv: usize, noise: f32) -> Sheet {
    let (cols, rows) = (nu + 1, nv + 1);
    let mut points = vec![[0.0; 3]; cols * rows];
    for j in 0..nv {
        for i in 0..nu {
            let (u, v) = (i as f32 / nu as f32, j as f32 / nv as f32);
            let (u, v) = (u * std::f32::consts::TAU, v * std::f32::consts::TAU);
            let r = 1.0 + 0.4 * libm::cosf(v);
            let p = [r * libm::cosf(u), r * libm::sinf(u), 0.4 * libm::sinf(v)];
            points[j * cols + i] = p.map(|c| c + noise * random.range(-1.0, 1.0));
        }
        points[j * cols + nu] = points[j * cols];
    }
    for i in 0..cols {
        points[nv * cols + i] = points[i];
    }
    Sheet { cols, rows, points }
}

/// A camera at `eye` looking at `target`, `scale` half pictures per unit at distance 1; picture of `side` pixels.
fn camera(eye: [f32; 3], target: [f32; 3], scale: f32, side: u32, near: f32) -> Projection {
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

fn draw_all<C: earmark::raster::Cell>(
    tile: &mut Tile<C>,
    sheet: &Sheet,
    side: usize,
    p: &Projection,
) -> usize {
    let mut block = ProjectedBlock::boxed();
    let mut clipped = 0;
    for (rank, (grid, size)) in sheet.blocks(side).iter().enumerate() {
        project(Level::detect(), grid, *size, p, &mut block);
        clipped += usize::from(block.is_clipped());
        draw_block(Level::detect(), tile, &block, rank as u32);
    }
    clipped
}

#[test]
fn closed_surfaces_balance() {
    let mut random = Random(4);
    let (mut checked, mut covered, mut clipped) = (0_u64, 0_u64, 0);
    for scene in 0..120 {
        let samples = [1, 4, 8, 16][scene % 4];
        let tile_side = tile_side(samples);
        let n = [6, 20, 70, 200][random.below(4) as usize];
        let sheet = torus(&mut random, n, n, [0.0, 0.02, 0.3][scene % 3]);
        let eye = [0, 1, 2]
            .map(|_| random.range(-1.0, 1.0))
            .map(|c| c * 3.0 + c.signum() * 1.4);
        // Up to so near that most of the surface is far off the screen and beyond the guard band.
        let scale = [1.0, 2.5, 20.0, 3000.0][scene / 4 % 4];
        let target = [0, 1, 2].map(|_| random.range(-0.4, 0.4));
        let p = camera(eye, target, scale, tile_side, 1e-3);
        let mut tile = Tile::<Coverage>::new(0, 0, tile_side, tile_side, samples);
        clipped += draw_all(&mut tile, &sheet, 1 + random.below(32) as usize, &p);
        for s in 0..samples {
            for y in 0..tile_side {
                for cell in tile.row(y, s) {
                    assert_eq!(cell.balance, 0, "scene {scene}");
                    checked += 1;
                    covered += u64::from(cell.hits > 0);
                }
            }
        }
    }
    println!("{checked} samples balance, {covered} of them covered; {clipped} blocks clipped");
    assert!(covered > 1_000_000 && clipped > 0);
}

#[test]
fn near_plane_cuts_cleanly() {
    // A ray that starts on the near plane inside of the solid leaves it once more than it enters.
    let mut random = Random(5);
    let (mut inside, mut outside, mut clipped) = (0_u64, 0_u64, 0);
    for _ in 0..40 {
        let side = 128;
        let sheet = torus(&mut random, 256, 128, 0.0);
        let angle = random.range(0.0, std::f32::consts::TAU);
        let eye = [
            1.0 * libm::cosf(angle),
            1.0 * libm::sinf(angle),
            random.range(-0.9, 0.3),
        ];
        let target = [0, 1, 2].map(|_| random.range(-0.5, 0.5));
        let near = random.range(0.05, 0.5);
        let p = camera(eye, target, random.range(0.5, 3.0), side, near);
        let mut tile = Tile::<Coverage>::new(0, 0, side, side, 4);
        clipped += draw_all(&mut tile, &sheet, 32, &p);
        for (s, [ox, oy]) in sample_positions(4).iter().enumerate() {
            for y in 0..side {
                for x in 0..side {
                    let sample = [x as i32 * 256 + ox, y as i32 * 256 + oy];
                    let at = unproject(&p, sample, near);
                    let ring = (at[0] * at[0] + at[1] * at[1]).sqrt() - 1.0;
                    let distance = (ring * ring + at[2] * at[2]).sqrt() - 0.4;
                    if distance.abs() < 0.004 {
                        continue;
                    }
                    let want = -i32::from(distance < 0.0);
                    assert_eq!(
                        tile.cell(x, y, s as u32).balance,
                        want,
                        "{x} {y} {distance}"
                    );
                    inside += u64::from(distance < 0.0);
                    outside += u64::from(distance > 0.0);
                }
            }
        }
    }
    println!("near plane: {inside} samples inside, {outside} outside; {clipped} blocks clipped");
    assert!(inside > 100_000 && outside > 100_000 && clipped > 100);
}

/// The point at distance `w` along the view axis that is seen at a screen position: solves the three rows by Cramer's rule.
fn unproject(p: &Projection, at: [i32; 2], w: f32) -> [f64; 3] {
    let w = f64::from(w);
    let wide = |r: [f32; 4]| r.map(f64::from);
    let (r0, r1, r2) = (wide(p.x), wide(p.y), wide(p.w));
    let b = [
        f64::from(at[0]) * w - r0[3],
        f64::from(at[1]) * w - r1[3],
        w - r2[3],
    ];
    let det = |c: [[f64; 3]; 3]| {
        c[0][0] * (c[1][1] * c[2][2] - c[1][2] * c[2][1])
            - c[0][1] * (c[1][0] * c[2][2] - c[1][2] * c[2][0])
            + c[0][2] * (c[1][0] * c[2][1] - c[1][1] * c[2][0])
    };
    let m = [
        [r0[0], r0[1], r0[2]],
        [r1[0], r1[1], r1[2]],
        [r2[0], r2[1], r2[2]],
    ];
    let whole = det(m);
    [0, 1, 2].map(|k| {
        let mut c = m;
        for row in 0..3 {
            c[row][k] = b[row];
        }
        det(c) / whole
    })
}

/// Grids of all sizes and tempers: flat, folded, crumpled, with repeated points, crossing the near plane and the guard band.
fn wild_block(random: &mut Random) -> (Box<Grid3>, BlockSize, Projection) {
    let size = BlockSize {
        cols: 2 + random.below(32) as usize,
        rows: 2 + random.below(32) as usize,
    };
    let quad = libm::exp2f(random.range(-3.0, 7.0));
    let noise = [0.0, 0.1, 1.0][random.below(3) as usize] * quad;
    let crossing = random.below(8) == 0;
    let mut grid = Grid3::boxed();
    let angle = random.range(0.0, 6.3);
    let (sin, cos) = (libm::sinf(angle), libm::cosf(angle));
    let rough = random.below(3) == 0;
    let (mx, my) = (random.range(-60.0, 60.0), random.range(-60.0, 60.0));
    for j in 0..size.rows {
        for i in 0..size.cols {
            let u = (i as f32 - size.cols as f32 / 2.0) * quad + noise * random.range(-1.0, 1.0);
            let v = (j as f32 - size.rows as f32 / 2.0) * quad + noise * random.range(-1.0, 1.0);
            let mut z = 1.0
                + if rough {
                    random.range(0.0, 0.3)
                } else {
                    u * 1e-3
                };
            if crossing {
                z = random.range(-0.2, 2.0);
            }
            let mut p = [
                (u * cos - v * sin + mx) * z,
                (u * sin + v * cos + my) * z,
                z,
            ];
            if random.below(16) == 0 && i > 0 {
                p = grid.get(i - 1, j);
            }
            grid.set(i, j, p);
        }
    }
    let projection = Projection {
        x: [256.0, 0.0, 16_384.0, 0.0],
        y: [0.0, 256.0, 16_384.0, 0.0],
        w: [0.0, 0.0, 1.0, 0.0],
        d: [0.0, 0.0, -0.1, 1.8],
        near: 0.1,
        ortho: random.below(4) == 0,
    };
    (grid, size, projection)
}

/// Draws a block; the keys in one row.
fn keys_of(level: Level, block: &ProjectedBlock, samples: u32, path: Path) -> Vec<Key> {
    let mut tile = Tile::<Key>::new(3, 5, 120, 113, samples);
    draw_block_with(level, &mut tile, block, 77, path, Fault::None);
    (0..samples)
        .flat_map(|s| {
            (0..113)
                .flat_map(|y| tile.row(y, s).to_vec())
                .collect::<Vec<_>>()
        })
        .collect()
}

#[test]
fn paths_and_levels_agree_in_every_bit() {
    let mut random = Random(6);
    let (mut drawn, mut clipped) = (0_u64, 0);
    for scene in 0..400 {
        let samples = [1, 4, 8, 16][scene % 4];
        let (grid, size, projection) = wild_block(&mut random);
        let mut block = ProjectedBlock::boxed();
        project(Level::SCALAR, &grid, size, &projection, &mut block);
        clipped += u32::from(block.is_clipped());
        let want = keys_of(Level::SCALAR, &block, samples, Path::Span);
        drawn += want.iter().filter(|k| **k != Key::EMPTY).count() as u64;
        for key in want.iter().filter(|k| **k != Key::EMPTY) {
            assert!(key.depth().is_finite() && key.depth() > 0.0);
            assert_eq!(key.id().map(SampleId::rank), Some(77));
        }
        for level in Level::available() {
            project(level, &grid, size, &projection, &mut block);
            for path in [Path::Auto, Path::Medium, Path::Span] {
                let got = keys_of(level, &block, samples, path);
                let differing = got.iter().zip(&want).filter(|(a, b)| a != b).count();
                assert_eq!(
                    differing,
                    0,
                    "scene {scene}, {}, {path:?}, {samples}",
                    level.name()
                );
            }
        }
    }
    println!("{drawn} keys equal on all levels and paths; {clipped} of 400 blocks clipped");
    assert!(drawn > 1_000_000 && clipped > 20);
}

#[test]
fn tiles_never_change_a_sample() {
    let mut random = Random(7);
    for scene in 0..60 {
        let samples = [1, 4, 8, 16][scene % 4];
        let (grid, size, projection) = wild_block(&mut random);
        let mut block = ProjectedBlock::boxed();
        project(Level::detect(), &grid, size, &projection, &mut block);
        let mut whole = Tile::<Key>::new(0, 0, 128, 128, samples);
        draw_block(Level::detect(), &mut whole, &block, 1);
        for (x0, y0, w, h) in [(0, 0, 31, 128), (31, 0, 97, 50), (31, 50, 97, 78)] {
            let mut part = Tile::<Key>::new(x0, y0, w, h, samples);
            draw_block(Level::detect(), &mut part, &block, 1);
            for s in 0..samples {
                for y in 0..h {
                    let row = &whole.row(y0 + y, s)[x0 as usize..(x0 + w) as usize];
                    assert_eq!(part.row(y, s), row, "scene {scene}");
                }
            }
        }
    }
}

#[test]
fn clipped_equals_split_beforehand() {
    // Near plane: with integer points at W = 0 and W = 2 and near 1, the crossings are exact.
    let mut random = Random(8);
    let p = Projection {
        x: [256.0, 0.0, 16_384.0, 0.0],
        y: [0.0, 256.0, 16_384.0, 0.0],
        w: [0.0, 0.0, 1.0, 0.0],
        d: [0.0; 4],
        near: 1.0,
        ortho: false,
    };
    let mut drawn = 0;
    for _ in 0..300 {
        let mut point = |w: f32| {
            let at = [0, 1].map(|_| random.below(161) as f32 - 80.0);
            [at[0] * w.max(1.0), at[1] * w.max(1.0), w]
        };
        let middle = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|k| (a[k] + b[k]) / 2.0);
        let v = [point(2.0), point(2.0), point(0.0)];
        let split = [v[0], v[1], middle(v[1], v[2]), middle(v[0], v[2])];
        let mut tiles = [
            Tile::<Key>::new(0, 0, 128, 128, 1),
            Tile::new(0, 0, 128, 128, 1),
        ];
        let level = Level::detect();
        draw_triangles(
            level,
            &mut tiles[0],
            &project_vertices(&v, &p),
            &[[0, 1, 2]],
            &p,
            5,
            0,
        );
        let corners = project_vertices(&split, &p);
        for triangle in [[0, 1, 2], [0, 2, 3]] {
            draw_triangles(level, &mut tiles[1], &corners, &[triangle], &p, 5, 0);
        }
        for y in 0..128 {
            assert_eq!(tiles[0].row(y, 0), tiles[1].row(y, 0));
            drawn += tiles[0]
                .row(y, 0)
                .iter()
                .filter(|k| k.id().is_some())
                .count();
        }
    }
    // Guard band: a rectangle far beyond it, against the same cut into 64 by 64.
    for n in 0..40 {
        let (x0, y0) = (
            random.below(100) as f32 - 40_000.0,
            random.below(100) as f32 - 60_000.0,
        );
        let side = [131_072.0, 80_000.0 + n as f32 * 64.0][n % 2];
        let corner = |i: usize, j: usize| {
            [
                (x0 + side * i as f32 / 64.0) * 2.0,
                (y0 + side * j as f32 / 64.0) * 2.0,
                2.0,
            ]
        };
        let fine: Vec<[f32; 3]> = (0..65 * 65).map(|k| corner(k % 65, k / 65)).collect();
        let sheet = Sheet {
            cols: 65,
            rows: 65,
            points: fine,
        };
        let coarse = Sheet {
            cols: 2,
            rows: 2,
            points: vec![corner(0, 0), corner(64, 0), corner(0, 64), corner(64, 64)],
        };
        let mut tiles = [
            Tile::<Coverage>::new(0, 0, 128, 128, 4),
            Tile::new(0, 0, 128, 128, 4),
        ];
        assert!(draw_all(&mut tiles[0], &coarse, 1, &p) > 0);
        draw_all(&mut tiles[1], &sheet, 32, &p);
        for s in 0..4 {
            for y in 0..128 {
                assert_eq!(tiles[0].row(y, s), tiles[1].row(y, s));
            }
        }
    }
    println!("{drawn} clipped samples equal those of the split scene");
    assert!(drawn > 100_000);
}

#[test]
fn near_depths_do_not_swap() {
    // Two planes 1e-4 apart, relatively; near 0.01; from close by to 1e5 away.
    let p = Projection {
        x: [256.0, 0.0, 16_384.0, 0.0],
        y: [0.0, 256.0, 16_384.0, 0.0],
        w: [0.0, 0.0, 1.0, 0.0],
        d: [0.0; 4],
        near: 0.01,
        ortho: false,
    };
    let mut distance = 0.011_f32;
    while distance < 1e5 {
        let mut vertices = Vec::new();
        for w in [distance * 1.0001, distance] {
            for [x, y, tilt] in [[-90.0, -80.0, 1.0], [95.0, -77.0, 1.5], [3.0, 99.0, 1.2]] {
                let w = w * tilt;
                vertices.push([x * w, y * w, w]);
            }
        }
        let vertices = project_vertices(&vertices, &p);
        let mut tile = Tile::<Key>::new(0, 0, 128, 128, 1);
        draw_triangles(
            Level::detect(),
            &mut tile,
            &vertices,
            &[[0, 1, 2], [3, 4, 5]],
            &p,
            0,
            0,
        );
        let mut seen = 0;
        for y in 0..128 {
            for id in tile.row(y, 0).iter().filter_map(|k| k.id()) {
                assert_eq!(soup_triangle(0, id), 1, "at {distance}");
                seen += 1;
            }
        }
        assert!(seen > 5000);
        distance *= 3.7;
    }
}

#[test]
fn ids_of_soups_round_trip() {
    for k in [0, 1, 1023, 1024, 5000] {
        assert_eq!(soup_triangle(9, soup_id(9, k)), k);
    }
}

#[test]
fn weights_lead_back_to_the_sample() {
    let mut random = Random(9);
    let (mut checked, mut clipped) = (0, 0);
    for _ in 0..200 {
        let (grid, size, p) = wild_block(&mut random);
        let mut block = ProjectedBlock::boxed();
        project(Level::detect(), &grid, size, &p, &mut block);
        clipped += usize::from(block.is_clipped());
        let mut tile = Tile::<Key>::new(0, 0, 128, 128, 4);
        draw_block(Level::detect(), &mut tile, &block, 3);
        for (s, [ox, oy]) in sample_positions(4).iter().enumerate() {
            for y in 0..128 {
                for x in 0..128 {
                    let key = tile.cell(x, y, s as u32);
                    let Some(id) = key.id() else { continue };
                    let w = barycentrics(&block, id, x, y, s as u32, 4);
                    assert!(w.iter().all(|&w| (0.0..=1.0).contains(&w)), "{w:?}");
                    assert!((w.iter().sum::<f32>() - 1.0).abs() < 1e-5);
                    let (i, j) = (id.col() as usize, id.row() as usize);
                    let corners = [
                        grid.get(i, j),
                        grid.get(i + 1, j),
                        grid.get(i + 1, j + 1),
                        grid.get(i, j + 1),
                    ];
                    let mut at = [0.0_f64; 3];
                    for (corner, w) in corners.iter().zip(w) {
                        for k in 0..3 {
                            at[k] += f64::from(corner[k]) * f64::from(w);
                        }
                    }
                    let row = |r: &[f32; 4]| {
                        (0..3).map(|k| f64::from(r[k]) * at[k]).sum::<f64>() + f64::from(r[3])
                    };
                    let w = if p.ortho { 1.0 } else { row(&p.w) };
                    // Snapping moves points by up to half a unit and cuts corners of slivers.
                    let off = (row(&p.x) / w - f64::from(x as i32 * 256 + ox))
                        .abs()
                        .max((row(&p.y) / w - f64::from(y as i32 * 256 + oy)).abs());
                    assert!(
                        off < 3.0 || block.is_clipped() && off < 40.0,
                        "{off} {id:?} {}",
                        block.is_clipped()
                    );
                    checked += 1;
                }
            }
        }
    }
    println!("{checked} samples led back; {clipped} of 200 blocks clipped");
    assert!(checked > 500_000);
}

#[test]
fn triangle_weights_weigh_corners() {
    let v = [
        SoupVertex::at(0, 0, 1.0),
        SoupVertex::at(2560, 0, 0.5),
        SoupVertex::at(0, 2560, 0.25),
    ];
    let near = triangle_weights(&v, false, 0, 0, 0, 1);
    assert!(near[0] > 0.9 && (near.iter().sum::<f32>() - 1.0).abs() < 1e-6);
    let flat = triangle_weights(&v, true, 4, 0, 0, 1);
    assert!((flat[1] - (4.5 / 10.0)).abs() < 1e-6);
    let deep = triangle_weights(&v, false, 4, 0, 0, 1);
    assert!(deep[1] < flat[1]);
}
