//! Coverage: every sample inside a sheet exactly once, and fronts equal backs over closed surfaces. The harness is shown to bite by
//! breaking the tie rule and by moving one copy of a shared point by 1/256 pixel.

#[path = "support/sheets.rs"]
mod sheets;

use earmark::raster::{
    Coverage, Fault, Path, ProjectedBlock, SoupVertex, Tile, draw_block, draw_block_with,
    draw_triangles, draw_triangles_with, project, sample_positions, tile_side,
};
use earmark::records::Projection;
use earmark::simd::Level;
use sheets::{FLAT, Random, Sheet, camera, draw_all};

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
    let side = tile_side(samples, false);
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
            let (sheet, bounds) = rectangle(&mut random);
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

#[test]
fn closed_surfaces_balance() {
    let mut random = Random(4);
    let (mut checked, mut covered, mut clipped) = (0_u64, 0_u64, 0);
    for scene in 0..120 {
        let samples = [1, 4, 8, 16][scene % 4];
        let tile_side = tile_side(samples, false);
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
