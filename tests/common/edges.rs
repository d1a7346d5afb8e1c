//! What the rasteriser gets of an edge from either of its faces.
#![allow(dead_code, missing_docs, unreachable_pub)]

use earmark::camera::{Camera, View};
use earmark::dice::DiceFault;
use earmark::raster::{ProjectedBlock, project};
use earmark::records::{BlockSize, Grid3, ScreenSize};
use earmark::simd::Level;
use earmark::surface::DicedQuad;
use earmark::topology::NONE;
use earmark::{Scene, Surface};

pub fn view_of(scene: &Scene) -> View {
    let size = ScreenSize {
        width: 1024,
        height: 1024,
        samples: 4,
    };
    Camera::default()
        .framing(&scene.bounding_sphere(), size)
        .unwrap()
}

/// Bits of one point: position, normal, snapped x and y, depth.
type Bits = [u32; 9];

fn side_bits(
    grid: &DicedQuad,
    c: usize,
    triangle: bool,
    view: &View,
    scratch: &mut (Box<Grid3>, Box<ProjectedBlock>),
) -> Vec<Bits> {
    let n = grid.side - 1;
    let place = |k: usize| match c {
        0 => k,
        1 => k * (n + 1) + n,
        // The third side of a triangle is the diagonal.
        2 if triangle => (n - k) * (n + 2),
        2 => n * (n + 1) + n - k,
        _ => (n - k) * (n + 1),
    };
    let (points, projected) = scratch;
    let mut out = Vec::with_capacity(n + 1);
    // The side in runs of at most 32 points, each as a block of two equal rows.
    let all: Vec<usize> = (0..=n).map(place).collect();
    for run in all.chunks(32) {
        for (i, &k) in run.iter().enumerate() {
            points.set(i, 0, grid.points[k]);
            points.set(i, 1, grid.points[k]);
        }
        let size = BlockSize {
            cols: run.len().max(2),
            rows: 2,
        };
        project(Level::detect(), points, size, &view.projection, projected);
        for (i, &k) in run.iter().enumerate() {
            let (p, q) = (
                grid.points[k].map(f32::to_bits),
                grid.normals[k].map(f32::to_bits),
            );
            let [x, y] = projected.position(i, 0);
            out.push([
                p[0],
                p[1],
                p[2],
                q[0],
                q[1],
                q[2],
                x as u32,
                y as u32,
                projected.depth(i, 0).to_bits(),
            ]);
        }
    }
    out
}

/// Compares all shared edges of a surface at a level; returns points that differ, and points compared.
pub fn compare(surface: &Surface, view: &View, level: u32, fault: DiceFault) -> (u64, u64) {
    let t = surface.quads();
    let level = level - u32::from(surface.is_split());
    let mut scratch = (Grid3::boxed(), ProjectedBlock::boxed());
    let mut waiting: Vec<Option<Vec<Bits>>> = vec![None; t.half_count()];
    let (mut differ, mut compared) = (0, 0);
    for q in 0..t.face_count() as u32 {
        let grid = surface.dice_with(q, level, fault);
        for (c, h) in t.face_halves(q).enumerate() {
            let twin = t.twin(h);
            if twin == NONE {
                continue;
            }
            let mut bits = side_bits(&grid, c, surface.is_triangular(), view, &mut scratch);
            match waiting[twin as usize].take() {
                None => waiting[h as usize] = Some(bits),
                Some(other) => {
                    bits.reverse();
                    compared += bits.len() as u64;
                    differ += bits.iter().zip(&other).filter(|(a, b)| a != b).count() as u64;
                }
            }
        }
    }
    (differ, compared)
}
