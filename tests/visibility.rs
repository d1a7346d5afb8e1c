//! Visibility keys: the same bits from every path, vector level and tile; clipped scenes equal those split beforehand; depths do not
//! swap; and samples lead back to where they are on the surface.

#[path = "support/sheets.rs"]
mod sheets;

use earmark::raster::{
    Coverage, Fault, Key, Path, ProjectedBlock, SoupVertex, Tile, barycentrics, draw_block,
    draw_block_with, draw_triangles, project, project_vertices, sample_positions, soup_id,
    soup_triangle, triangle_weights,
};
use earmark::records::{BlockSize, Grid3, Projection, SampleId};
use earmark::simd::Level;
use sheets::{Random, Sheet, draw_all};

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
