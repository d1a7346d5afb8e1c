//! Small cages: grids, stars, a cube, and meshes of everything at once.

use super::Shape;

/// Pseudo-random numbers from -0.5 to 0.5.
pub struct Noise(pub u64);

impl Noise {
    pub fn number(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }
    pub fn point(&mut self) -> [f64; 3] {
        std::array::from_fn(|_| self.number())
    }
}

/// Grid of `n` by `n` quads over [0, n]², height by `height`.
pub fn grid(n: u32, height: impl Fn(f64, f64) -> f64) -> Shape {
    let mut points = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            let (u, v) = (f64::from(i), f64::from(j));
            points.push([u, v, height(u, v)]);
        }
    }
    let quads: Vec<[u32; 4]> = (0..n * n)
        .map(|q| {
            let a = q / n * (n + 1) + q % n;
            [a, a + 1, a + n + 2, a + n + 1]
        })
        .collect();
    let faces: Vec<&[u32]> = quads.iter().map(|q| q.as_slice()).collect();
    Shape::new(&points, &faces)
}

/// Vertex 0 amid `n` quads with random heights: edge `i` ends in vertex 1 + 2i, face `i` has vertex 2 + 2i opposite.
pub fn star(n: u32, seed: u64) -> Shape {
    fan(n, true, seed)
}

/// As [`star`], but half a disc: vertex 0 on the boundary, `k` faces, `k + 1` edges.
pub fn half_star(k: u32, seed: u64) -> Shape {
    fan(k, false, seed)
}

fn fan(n: u32, closed: bool, seed: u64) -> Shape {
    let mut noise = Noise(seed);
    let turn = if closed {
        std::f64::consts::TAU
    } else {
        std::f64::consts::PI
    };
    let mut points = vec![[0.0, 0.0, noise.number()]];
    let edges = if closed { n } else { n + 1 };
    for i in 0..edges + n {
        let a = turn * f64::from(i) / f64::from(2 * n);
        let r = if i % 2 == 0 { 1.0 } else { 1.4 };
        let bump = noise.point().map(|c| 0.1 * c);
        points.push([r * a.cos() + bump[0], r * a.sin() + bump[1], 5.0 * bump[2]]);
    }
    let quads: Vec<[u32; 4]> = (0..n)
        .map(|i| [0, 1 + 2 * i, 2 + 2 * i, 1 + 2 * ((i + 1) % edges)])
        .collect();
    let faces: Vec<&[u32]> = quads.iter().map(|q| q.as_slice()).collect();
    Shape::new(&points, &faces)
}

/// The cube of corners ±1.
pub fn cube() -> Shape {
    let points: Vec<[f64; 3]> = (0..8)
        .map(|i| std::array::from_fn(|k| if i >> k & 1 == 1 { 1.0 } else { -1.0 }))
        .collect();
    Shape::new(
        &points,
        &[
            &[0, 2, 3, 1],
            &[4, 5, 7, 6],
            &[0, 1, 5, 4],
            &[2, 6, 7, 3],
            &[0, 4, 6, 2],
            &[1, 3, 7, 5],
        ],
    )
}

/// All edges of the cube.
pub fn cube_edges() -> Vec<[u32; 2]> {
    (0..8_u32)
        .flat_map(|a| [1, 2, 4].map(|k| [a, a ^ k]))
        .filter(|[a, b]| a < b)
        .collect()
}

/// A closed mesh of triangles, quads and pentagons with noise, and creases of several kinds: a prism over a pentagon, one lid fanned.
pub fn gem() -> Shape {
    let mut noise = Noise(7);
    let mut points = Vec::new();
    for z in [-1.0, 1.0] {
        for i in 0..5 {
            let a = std::f64::consts::TAU * f64::from(i) / 5.0;
            let b = noise.point().map(|c| 0.3 * c);
            points.push([a.cos() + b[0], a.sin() + b[1], z + b[2]]);
        }
    }
    points.push([0.1, -0.1, 1.8]);
    let mut faces: Vec<Vec<u32>> = vec![vec![4, 3, 2, 1, 0]];
    for i in 0..5 {
        let j = (i + 1) % 5;
        faces.push(vec![i, j, 5 + j, 5 + i]);
        faces.push(vec![5 + i, 5 + j, 10]);
    }
    let faces: Vec<&[u32]> = faces.iter().map(Vec::as_slice).collect();
    Shape::new(&points, &faces)
        .crease(0, 1, 10.0)
        .crease(1, 2, 10.0)
        .crease(5, 6, 1.5)
        .crease(6, 7, 0.6)
        .crease(7, 8, 2.3)
        .crease(8, 9, 10.0)
        .corner(10, 1.4)
}

/// An open mesh of triangles, quads and a hexagon, with noise and creases up to the boundary.
pub fn patch() -> Shape {
    let mut noise = Noise(11);
    let mut shape = grid(5, |_, _| 0.0);
    for p in &mut shape.points {
        let b = noise.point();
        *p = [p[0] + 0.3 * b[0], p[1] + 0.3 * b[1], b[2]];
    }
    // Quads 6 and 7 become a hexagon, quad 12 two triangles.
    let mut faces: Vec<Vec<u32>> = shape.corners.chunks(4).map(<[u32]>::to_vec).collect();
    faces[6] = vec![7, 8, 9, 15, 14, 13];
    faces[12] = vec![14, 15, 21];
    faces[7] = vec![14, 21, 20];
    let faces: Vec<&[u32]> = faces.iter().map(Vec::as_slice).collect();
    Shape::new(&shape.points, &faces)
        .crease(2, 8, 10.0)
        .crease(21, 22, 10.0)
        .crease(22, 23, 1.7)
        .crease(28, 29, 0.8)
        .crease(29, 30 - 7, 3.0)
        .corner(20, 2.2)
}
