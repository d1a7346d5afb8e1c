//! Limit points and unit normals of a cube: `cargo run --example limit_points`.
#![allow(clippy::print_stdout)]

use earmark::{Cage, Surface};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let points = (0..8)
        .map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| 2.0 * bit as f32 - 1.0))
        .collect();
    let corners = vec![
        0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5,
    ];
    let surface = Surface::new(Cage::new(points, &[4; 6], corners)?, &Default::default());
    let grid = surface.dice(0, 2);
    for (point, normal) in grid.points.iter().zip(&grid.normals) {
        println!("{point:?} {normal:?}");
    }
    Ok(())
}
