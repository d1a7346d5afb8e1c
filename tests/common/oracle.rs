//! The per-quad path held against whole-mesh refinement in f64: an independent way to the same points.
#![allow(dead_code, missing_docs, unreachable_pub)]

use earmark::mesh::NONE;
use earmark::refine::{Level, Options, limit, refine};
use earmark::topology::{ConnectOptions, Topology, connect};
use earmark::{Cage, Surface, SurfaceOptions};

/// Largest differences of one comparison.
#[derive(Clone, Copy, Debug, Default)]
pub struct Worst {
    /// Distance of points, of the bounding box's diagonal.
    pub point: f64,
    /// Angle of normals in degrees, where single precision can tell and the oracle has a normal by rule.
    pub normal: f64,
    /// Points compared.
    pub count: u64,
    /// Distance of texture coordinates at the limit.
    pub uv: f64,
    /// Texture coordinates compared.
    pub uv_count: u64,
}

impl Worst {
    pub fn add(&mut self, o: Worst) {
        self.point = self.point.max(o.point);
        self.normal = self.normal.max(o.normal);
        self.count += o.count;
        self.uv = self.uv.max(o.uv);
        self.uv_count += o.uv_count;
    }
}

/// The same cage without creases and corners, hence smooth.
pub fn smooth(surface: &Surface, options: &SurfaceOptions) -> Surface {
    let cage = surface.cage();
    let sizes: Vec<u32> = (0..cage.face_count())
        .map(|f| cage.face(f).len() as u32)
        .collect();
    let mut plain = Cage::new(
        cage.points().to_vec(),
        &sizes,
        cage.corner_vertices().to_vec(),
    )
    .unwrap();
    if !cage.corner_uvs().is_empty() && !cage.corner_uvs().contains(&NONE) {
        plain = plain
            .with_uvs(cage.uvs().to_vec(), cage.corner_uvs().to_vec())
            .unwrap();
    }
    Surface::new(plain, options)
}

pub fn size(surface: &Surface) -> f64 {
    let [lo, hi] = surface.cage().bounds();
    (0..3)
        .map(|c| f64::from(hi[c] - lo[c]).powi(2))
        .sum::<f64>()
        .sqrt()
}

fn distance(a: [f32; 3], b: [f64; 3]) -> f64 {
    (0..3)
        .map(|c| (f64::from(a[c]) - b[c]).powi(2))
        .sum::<f64>()
        .sqrt()
}

pub fn angle(a: [f32; 3], b: [f64; 3]) -> f64 {
    let a = a.map(f64::from);
    let cross = [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ];
    let sine = cross.iter().map(|c| c * c).sum::<f64>().sqrt();
    let cosine: f64 = (0..3).map(|c| a[c] * b[c]).sum();
    sine.atan2(cosine).to_degrees()
}

/// Corner number of the level's mesh at every point of quad `q`'s grid, row by row.
pub fn grid_corners(surface: &Surface, q: u32, quad_level: u32) -> Vec<u32> {
    if surface.is_triangular() {
        return triangle_corners(q, quad_level);
    }
    let n = 1_i32 << quad_level;
    let mut grid = vec![u32::MAX; ((n + 1) * (n + 1)) as usize];
    // Faces are numbered by the corners of the level above; a quad's child has the parent's corner at the parent's position.
    let square = [[0, 0], [n, 0], [n, n], [0, n]];
    let mut first = square;
    if surface.is_split() {
        // The quad is child q of a polygon; the oracle turns children of quads, the split mesh does not.
        let base = surface.topology();
        let face = base.face_halves(base.face_of(q));
        let turn = if face.len() == 4 { q - face.start } else { 0 };
        first = std::array::from_fn(|k| square[(k + 4 - turn as usize) % 4]);
    }
    let mut stack = vec![(0, q, first)];
    while let Some((depth, face, p)) = stack.pop() {
        if depth == quad_level {
            for c in 0..4 {
                grid[(p[c][1] * (n + 1) + p[c][0]) as usize] = 4 * face + c as u32;
            }
            continue;
        }
        let mid = |a: [i32; 2], b: [i32; 2]| [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
        for j in 0..4 {
            let mut child = [[0; 2]; 4];
            child[j] = p[j];
            child[(j + 1) % 4] = mid(p[j], p[(j + 1) % 4]);
            child[(j + 2) % 4] = mid(p[0], p[2]);
            child[(j + 3) % 4] = mid(p[j], p[(j + 3) % 4]);
            stack.push((depth + 1, 4 * face + j as u32, child));
        }
    }
    grid
}

/// Whether the rules have one tangent plane in each sector of a fan. They have none where too many faces lie between sharp edges: a
/// second mode shrinks no faster than the plane's, so what counts as the normal is a convention that depends on the level.
fn has_tangent_plane(t: &Topology, fan: u32, triangles: bool) -> bool {
    let sharp = |h: u32| t.edge_sharpness(t.edge(h)) >= 10.0;
    let ring: Vec<u32> = earmark::topology::Ring::of_fan(t, fan).collect();
    let info = t.fans()[fan as usize];
    let edges = ring.iter().filter(|&&h| sharp(h)).count() + usize::from(!info.closed);
    let corner = t.vertex_sharpness(t.fan_vertex(fan)) >= 10.0 || edges > 2;
    if !corner && edges < 2 {
        return true;
    }
    // Longest run of faces without a sharp edge between them, around the end of a closed fan.
    let (mut longest, mut run) = (0, 0);
    for &h in ring.iter().chain(ring.iter().filter(|_| info.closed)) {
        run = if sharp(h) { 1 } else { run + 1 };
        longest = longest.max(run);
    }
    longest
        <= match (corner, triangles) {
            (true, false) => 1,
            (true, true) => 2,
            (false, false) => 3,
            (false, true) => 5,
        }
}

/// The same for a triangle, which fills the half of its grid where the row is at most the column; `u32::MAX` elsewhere.
fn triangle_corners(face: u32, level: u32) -> Vec<u32> {
    let n = 1_i32 << level;
    let mut grid = vec![u32::MAX; ((n + 1) * (n + 1)) as usize];
    let mut stack = vec![(0, face, [[0, 0], [n, 0], [n, n]])];
    while let Some((depth, face, p)) = stack.pop() {
        if depth == level {
            for c in 0..3 {
                grid[(p[c][1] * (n + 1) + p[c][0]) as usize] = 3 * face + c as u32;
            }
            continue;
        }
        let mid = |a: usize, b: usize| [0, 1].map(|k| (p[a][k] + p[b][k]) / 2);
        let e = [mid(0, 1), mid(1, 2), mid(2, 0)];
        let children = [
            [p[0], e[0], e[2]],
            [e[0], p[1], e[1]],
            [e[2], e[1], p[2]],
            [e[1], e[2], e[0]],
        ];
        stack.extend(
            (0..)
                .zip(children)
                .map(|(c, p)| (depth + 1, 4 * face + c, p)),
        );
    }
    grid
}

/// Degrees by which a normal may turn because the points around it are rounded to single precision: a few units in the last place of the
/// coordinates, seen over the shortest edge of the grid there.
fn rounding(grid: &earmark::surface::DicedQuad, k: usize) -> f64 {
    let n = grid.side;
    let (i, j) = (k % n, k / n);
    let mut neighbours = Vec::new();
    if i > 0 {
        neighbours.push(k - 1);
    }
    if i + 1 < n {
        neighbours.push(k + 1);
    }
    if j > 0 {
        neighbours.push(k - n);
    }
    if j + 1 < n {
        neighbours.push(k + n);
    }
    let p = grid.points[k];
    let shortest = (neighbours.iter())
        .map(|&m| distance(grid.points[m], p.map(f64::from)))
        .filter(|&d| d > 0.0)
        .fold(f64::INFINITY, f64::min);
    let largest = p.iter().fold(0.0_f64, |m, c| m.max(f64::from(c.abs())));
    (4.0 * f64::from(f32::EPSILON) * largest / shortest).to_degrees()
}

/// Compares limit points, normals and control points of every quad at a level of the cage.
pub fn compare(surface: &Surface, level: u32) -> Worst {
    let base = Level::<f64>::of_cage(
        surface.cage(),
        surface.topology().clone(),
        surface.refine_options().scheme,
        surface.face_varying_rule(),
    )
    .unwrap();
    let options = surface.refine_options();
    let fine = refine(base, &options, level, None, &mut Default::default()).unwrap();
    let want = limit(&fine, &options);
    let t = &fine.topology;
    let quad_level = level - u32::from(surface.is_split());
    let scale = size(surface);
    let mut worst = Worst::default();
    for (q, control) in surface.refine_quads(quad_level).enumerate() {
        let grid = surface.dice(q as u32, quad_level);
        for (k, h) in grid_corners(surface, q as u32, quad_level)
            .into_iter()
            .enumerate()
            .filter(|(_, h)| *h != u32::MAX)
        {
            let v = t.vertex(h) as usize;
            worst.point = worst
                .point
                .max(distance(grid.points[k], want.positions[v]) / scale);
            worst.point = worst
                .point
                .max(distance(control.points[k], fine.points[v]) / scale);
            // Vertices of valence 2 have no normal in general, and the tangents of folded or flat sheets are parallel.
            let fan = t.fans()[t.fan(h) as usize];
            // A sharp point on a smooth sheet is the tip of a cone, and has none either.
            let tip = fan.closed && t.vertex_sharpness(t.vertex(h)) >= 10.0;
            if fan.edges() > 2 && !tip && has_tangent_plane(t, t.fan(h), surface.is_triangular()) {
                let n = want.normals[want.normal_index(t, h) as usize];
                let a = angle(grid.normals[k], n);
                // Where cells are so small that single precision blurs them, normals of the cage itself mean no more.
                if rounding(&grid, k) < 0.02 {
                    worst.normal = worst.normal.max(a);
                }
            }
            worst.count += 1;
            if let Some(uvs) = &fine.uvs
                && uvs.is_complete(surface.cage_face(q as u32))
            {
                let [u, v] = want.uvs[uvs.corners[h as usize] as usize];
                let [gu, gv] = grid.uvs[k].map(f64::from);
                worst.uv = worst.uv.max((gu - u).hypot(gv - v));
                worst.uv_count += 1;
            }
        }
    }
    worst
}

/// The faces around face `f` of a level as a mesh of their own; `f` becomes face 0.
fn crop(level: &Level<f64>, f: u32) -> Level<f64> {
    let t = &level.topology;
    let mut faces = vec![f];
    for h in t.face_halves(f) {
        for g in earmark::topology::Ring::of_fan(t, t.fan(h)) {
            if !faces.contains(&t.face_of(g)) {
                faces.push(t.face_of(g));
            }
        }
    }
    let (mut points, mut corners, mut offsets, mut number) = (
        Vec::new(),
        Vec::new(),
        vec![0],
        std::collections::BTreeMap::new(),
    );
    for f in faces {
        for h in t.face_halves(f) {
            let v = t.vertex(h);
            corners.push(*number.entry(v).or_insert_with(|| {
                points.push(level.points[v as usize]);
                points.len() as u32 - 1
            }));
        }
        offsets.push(corners.len() as u32);
    }
    let (t, _) = connect(points.len(), &offsets, corners, &ConnectOptions::default());
    Level::new(t, points).unwrap()
}

/// Compares the limit at chosen points of quad `q` of a quad cage at a deep level; `picks` are grid squares (column, row).
pub fn compare_deep(surface: &Surface, q: u32, level: u32, picks: &[[u32; 2]]) -> Worst {
    assert!(!surface.is_split());
    let grid = surface.dice(q, level);
    let n = 1_u32 << level;
    let scale = size(surface);
    let mut worst = Worst::default();
    for &[col, row] in picks {
        let points = surface
            .control_base()
            .iter()
            .map(|p| p.map(f64::from))
            .collect();
        let mut mesh = crop(
            &Level::<f64>::new(surface.topology().clone(), points).unwrap(),
            q,
        );
        // Walk down: the child at the corner of the half that holds the square. Children keep the directions of u and v.
        for depth in 1..=level {
            let bit = |x: u32| (x >> (level - depth)) & 1;
            let child = match (bit(col), bit(row)) {
                (0, 0) => 0,
                (1, 0) => 1,
                (1, 1) => 2,
                _ => 3,
            };
            let fine = refine(mesh, &Options::default(), 1, None, &mut Default::default()).unwrap();
            mesh = crop(&fine, child);
        }
        let want = limit(&mesh, &Options::default());
        for (c, [i, j]) in [
            [col, row],
            [col + 1, row],
            [col + 1, row + 1],
            [col, row + 1],
        ]
        .into_iter()
        .enumerate()
        {
            let v = mesh.topology.vertex(c as u32) as usize;
            let k = (j * (n + 1) + i) as usize;
            worst.point = worst
                .point
                .max(distance(grid.points[k], want.positions[v]) / scale);
            worst.normal = worst.normal.max(angle(grid.normals[k], want.normals[v]));
            worst.count += 1;
        }
    }
    worst
}
