//! QAS and PN patches: through what they are fitted to, equal where they should be, the same from both sides of every edge.

mod common;
#[path = "common/coverage.rs"]
mod coverage;
#[path = "patches/pictures.rs"]
mod pictures;
#[path = "patches/pn.rs"]
mod pn;
#[path = "patches/qas.rs"]
mod qas;
#[path = "patches/sides.rs"]
mod sides;

use earmark::mesh::CageBuilder;
use earmark::mesh::obj;
use earmark::mesh::resolver::NoFiles;
use earmark::patch::PatchKind;
use earmark::scheme::Scheme;
use earmark::{Cage, Surface, SurfaceOptions};

fn asset(name: &str) -> Cage {
    let path = common::assets().join(format!("{name}.obj"));
    read(&std::fs::read_to_string(path).unwrap())
}

fn read(text: &str) -> Cage {
    obj::read(
        text.as_bytes(),
        "test.obj",
        &mut NoFiles,
        &Default::default(),
    )
    .unwrap()
    .cage
}

fn options(scheme: Scheme, patches: PatchKind) -> SurfaceOptions {
    SurfaceOptions {
        scheme: Some(scheme),
        patches,
        ..SurfaceOptions::default()
    }
}

fn surface(cage: &Cage, scheme: Scheme, patches: PatchKind) -> Surface {
    Surface::new(cage.clone(), &options(scheme, patches))
}

fn icosahedron() -> Cage {
    let g = (1.0 + 5.0_f32.sqrt()) / 2.0;
    let points = [
        [-1.0, g, 0.0],
        [1.0, g, 0.0],
        [-1.0, -g, 0.0],
        [1.0, -g, 0.0],
        [0.0, -1.0, g],
        [0.0, 1.0, g],
        [0.0, -1.0, -g],
        [0.0, 1.0, -g],
        [g, 0.0, -1.0],
        [g, 0.0, 1.0],
        [-g, 0.0, -1.0],
        [-g, 0.0, 1.0],
    ];
    let faces = [
        0, 11, 5, 0, 5, 1, 0, 1, 7, 0, 7, 10, 0, 10, 11, 1, 5, 9, 5, 11, 4, 11, 10, 2, 10, 7, 6, 7,
        1, 8, 3, 9, 4, 3, 4, 2, 3, 2, 6, 3, 6, 8, 3, 8, 9, 4, 9, 5, 2, 4, 11, 6, 2, 10, 8, 6, 7, 9,
        8, 1,
    ];
    Cage::new(points.to_vec(), &[3; 20], faces.to_vec()).unwrap()
}

/// A builder of these points and faces.
fn build<F: AsRef<[u32]>>(
    points: impl IntoIterator<Item = [f32; 3]>,
    faces: impl IntoIterator<Item = F>,
) -> CageBuilder {
    let start = Cage::builder().points(points);
    let add = |b: CageBuilder, f: F| b.face(f.as_ref().iter().copied());
    faces.into_iter().fold(start, add)
}

/// The cube of corners ±1 with every edge tagged.
fn creased_cube(sharpness: f32) -> Cage {
    let points = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|b| 2.0 * b as f32 - 1.0));
    let faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let mut cage = build(points, faces);
    for i in 0..8_u32 {
        for k in (0..3).filter(|k| i >> k & 1 == 0) {
            cage = cage.crease(i, i | 1 << k, sharpness);
        }
    }
    cage.build().unwrap()
}

/// A closed prism: first an octagon with a creased rim, then quads around, then triangles below.
fn prism() -> Cage {
    let n = 8_u32;
    let ring = |z: f32| {
        (0..n).map(move |k| {
            let a = std::f32::consts::TAU * k as f32 / n as f32;
            [a.cos(), a.sin(), z]
        })
    };
    let points = ring(0.0).chain(ring(1.0)).chain([[0.0, 0.0, -0.5]]);
    let mut builder = Cage::builder().points(points).face(n..2 * n);
    for k in 0..n {
        let next = (k + 1) % n;
        builder = (builder.face([k, next, n + next, n + k]))
            .face([next, k, 2 * n])
            .crease(n + k, n + next, 10.0);
    }
    builder.build().unwrap()
}

fn minus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    dot(minus(a, b), minus(a, b)).sqrt()
}

/// Angle in degrees between unit vectors.
fn angle(a: [f32; 3], b: [f32; 3]) -> f32 {
    (distance(a, b) / 2.0).asin().to_degrees() * 2.0
}

/// Diagonal of a cage's box.
fn size(cage: &Cage) -> f32 {
    let [low, high] = cage.bounds();
    distance(low, high)
}

/// Grid points of a diced face that are drawn: a triangle fills the half where the row is at most the column.
fn drawn(surface: &Surface, side: usize) -> Vec<usize> {
    let half = surface.is_triangular();
    (0..side * side)
        .filter(|k| !half || k / side <= k % side)
        .collect()
}
