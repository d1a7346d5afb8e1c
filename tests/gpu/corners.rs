//! Corners whose normals do not follow from the derivatives of one face: device and processor agree on them.

use crate::points::{ANGLE, DISTANCE, blocks, compare};
use crate::{gpu, torus};
use earmark::displace::{Displacement, Function, HeightMap};
use earmark::frame::Refinement;
use earmark::gpu::{Gpu, GpuScene};
use earmark::scheme::{Boundary, FaceVaryingRule, Scheme};
use earmark::{Cage, Camera, Renderer, Scene, Surface, SurfaceOptions};
use std::sync::Arc;

/// Points, faces and corners of infinite sharpness.
type Shape = (Vec<[f32; 3]>, Vec<Vec<u32>>, Vec<u32>);

/// All corners: points in a wavy plane around the origin.
fn ngon(n: u32) -> Vec<[f32; 3]> {
    let at = |k: u32| k as f32 / n as f32 * std::f32::consts::TAU;
    (0..n)
        .map(|k| {
            let a = at(k);
            [
                a.cos(),
                1.2 * a.sin(),
                0.2 * (2.0 * a).sin() + 0.1 * a.cos(),
            ]
        })
        .collect()
}

/// Quads or triangles around the origin, which a slit parts whose two sides lie at one place.
fn slit(triangles: bool) -> Shape {
    let rim = ngon(if triangles { 5 } else { 10 });
    let mut points = vec![[0.0, 0.0, 0.3]];
    points.extend(&rim);
    points.push(rim[0]);
    let last = points.len() as u32 - 1;
    let faces = match triangles {
        true => (1..last).map(|k| vec![0, k, k + 1]).collect(),
        false => (1..last)
            .step_by(2)
            .map(|k| vec![0, k, k + 1, k + 2])
            .collect(),
    };
    (points, faces, Vec::new())
}

/// A ring of faces around a vertex, closed, its middle sharp.
fn tip(triangles: bool) -> Shape {
    let (mut points, mut faces, _) = slit(triangles);
    let last = points.len() as u32 - 1;
    points.pop();
    for v in faces.iter_mut().flatten().filter(|v| **v == last) {
        *v = 1;
    }
    (points, faces, vec![0])
}

/// Two fans of two faces that hang together by a point.
fn bow(triangles: bool) -> Shape {
    let mut points = vec![[0.0; 3]];
    points.extend(ngon(if triangles { 7 } else { 11 }));
    let faces = match triangles {
        true => vec![[0, 1, 2], [0, 2, 3], [0, 4, 5], [0, 5, 6]]
            .into_iter()
            .map(Vec::from)
            .collect(),
        false => vec![[0, 1, 2, 3], [0, 3, 4, 5], [0, 6, 7, 8], [0, 8, 9, 10]]
            .into_iter()
            .map(Vec::from)
            .collect(),
    };
    (points, faces, Vec::new())
}

/// Three faces at a sharp point of the border, over angles up to `last`, in a plane that is parallel to no axis.
fn sector(triangles: bool, last: f32) -> Shape {
    let (u, v, n) = ([0.48, 0.6, 0.64], [0.8, -0.6, 0.0], [0.384, 0.512, -0.768]);
    let own = [0.1, 0.2, 0.3];
    let at = |k: u32, r: f32, h: f32| {
        let (sine, cosine) = (last * k as f32 / 6.0).sin_cos();
        std::array::from_fn(|c| own[c] + r * (cosine * u[c] + sine * v[c]) + h * n[c])
    };
    let heights = [0.0, 0.2, 0.3, 0.1, -0.2, -0.1, 0.0];
    let step = if triangles { 2 } else { 1 };
    let rim = (0..7).step_by(step);
    let mut points = vec![own];
    points.extend(rim.map(|k: u32| at(k, 1.0 + 0.2 * (k % 2) as f32, heights[k as usize])));
    let faces = match triangles {
        true => (1..4).map(|k| vec![0, k, k + 1]).collect(),
        false => (0..3)
            .map(|k| vec![0, 2 * k + 1, 2 * k + 2, 2 * k + 3])
            .collect(),
    };
    (points, faces, vec![0])
}

/// It takes less than half a turn.
fn narrow(triangles: bool) -> Shape {
    sector(triangles, 2.5)
}

/// It takes more than half a turn.
fn wide(triangles: bool) -> Shape {
    sector(triangles, 4.2)
}

/// The same with a triangle apart, which has cages of quads split once.
fn beside_triangle((mut points, mut faces, sharp): Shape) -> Shape {
    let first = points.len() as u32;
    points.extend([[3.0, 0.0, 0.0], [4.0, 0.0, 0.2], [3.0, 1.0, 0.0]]);
    faces.push(vec![first, first + 1, first + 2]);
    (points, faces, sharp)
}

fn surface(shape: &Shape, scheme: Scheme, boundary: Boundary, rule: FaceVaryingRule) -> Surface {
    let (points, faces, sharp) = shape;
    let mut cage = Cage::builder().points(points.iter().copied());
    for face in faces {
        cage = cage.face(face.iter().copied());
    }
    for &v in sharp {
        cage = cage.corner(v, 10.0);
    }
    let uvs = points.iter().map(|p| [0.4 + 0.2 * p[0], 0.4 + 0.2 * p[1]]);
    let corners: Vec<u32> = faces.iter().flatten().copied().collect();
    let cage = cage.build().unwrap().with_uvs(uvs.collect(), corners);
    let options = SurfaceOptions {
        scheme: Some(scheme),
        boundary: Some(boundary),
        face_varying: Some(rule),
        ..SurfaceOptions::default()
    };
    Surface::new(cage.unwrap(), &options)
}

/// As it is, by noise, and by a ramp in texture coordinates.
fn displacements() -> [Option<Displacement>; 3] {
    const SIDE: u32 = 64;
    let ramp = (0..SIDE * SIDE).map(|k| (k % SIDE) as f32 / SIDE as f32);
    let ramp = HeightMap::new(SIDE, SIDE, ramp.collect()).unwrap();
    let noise: Function = "perlin:frequency=0.9,seed=4".parse().unwrap();
    [
        None,
        Some(Displacement::function(noise).scaled(0.1)),
        Some(Displacement::map(Arc::new(ramp)).scaled(0.3)),
    ]
}

fn check(gpu: &Gpu, scene: &Scene, what: &str) -> f64 {
    let mut most = 0.0_f64;
    for level in [1, 2] {
        let surface = &scene.objects[0].surface;
        let got = compare(surface, &blocks(gpu, scene, level), level);
        let what = format!("{what} at level {level}");
        assert_eq!(got.bare, 0, "{what}");
        assert!(got.distance <= DISTANCE, "{what}: {}", got.distance);
        assert!(got.angle() <= ANGLE, "{what}: {} degrees", got.angle());
        most = most.max(got.angle());
    }
    most
}

#[test]
fn flat_corners_are_the_processors() {
    let Some(gpu) = gpu("flat corners") else {
        return;
    };
    let single = |n: u32| (ngon(n), vec![(0..n).collect()], Vec::new());
    // Two faces close around a vertex.
    let pair = || {
        let points = [
            [0.0, 0.0, 0.1],
            [1.0, 0.1, 0.0],
            [-1.0, 0.0, 0.0],
            [0.0, 1.0, 0.2],
            [0.1, -0.9, 0.0],
        ];
        let faces = vec![vec![0, 1, 3, 2], vec![0, 2, 4, 1]];
        (points.to_vec(), faces, Vec::new())
    };
    let (mut run, mut most) = (0, 0.0_f64);
    for (what, shape, scheme) in [
        ("quad", single(4), Scheme::CatmullClark),
        ("pentagon", single(5), Scheme::CatmullClark),
        ("triangle", single(3), Scheme::Loop),
        ("pair", pair(), Scheme::CatmullClark),
    ] {
        for rule in [
            FaceVaryingRule::None,
            FaceVaryingRule::CornersOnly,
            FaceVaryingRule::All,
        ] {
            for displacement in displacements() {
                let mut surface = surface(&shape, scheme, Boundary::EdgeOnly, rule);
                let what = format!("{what} {rule:?} {displacement:?}");
                surface.set_displacement(displacement);
                most = most.max(check(&gpu, &Scene::of(surface), &what));
                run += 1;
            }
        }
    }
    println!("gpu flat corners: {run} cases, off by at most {most:.4} degrees");
}

#[test]
fn corners_of_rings_are_the_processors() {
    let Some(gpu) = gpu("corners of rings") else {
        return;
    };
    let (mut run, mut most) = (0, 0.0_f64);
    for (what, shape) in [
        ("slit", slit as fn(bool) -> Shape),
        ("tip", tip),
        ("bow", bow),
        ("narrow", narrow),
        ("wide", wide),
    ] {
        for (kind, shape, scheme) in [
            ("quads", shape(false), Scheme::CatmullClark),
            ("split", beside_triangle(shape(false)), Scheme::CatmullClark),
            ("triangles", shape(true), Scheme::Loop),
        ] {
            for displacement in displacements() {
                let none = FaceVaryingRule::None;
                let mut surface = surface(&shape, scheme, Boundary::default(), none);
                let what = format!("{what} {kind} {displacement:?}");
                surface.set_displacement(displacement);
                let mut scene = Scene::of(surface);
                most = most.max(check(&gpu, &scene, &what));
                // Points move, and what is made of them.
                let renderer = crate::uniform(32, 32, 1);
                let camera = Camera::default();
                let mut ready = GpuScene::new(&gpu, &renderer, &scene, &camera).unwrap();
                let surface = &mut scene.objects[0].surface;
                let points = surface.cage().points().iter();
                let moved: Vec<[f32; 3]> = points
                    .map(|p| [p[0], 0.9 * p[1] + 0.1 * p[0], p[2]])
                    .collect();
                surface.update_points(&moved).unwrap();
                ready.move_points(&moved).unwrap();
                ready.draw().unwrap();
                let got = compare(&scene.objects[0].surface, &ready.read_blocks().unwrap(), 1);
                assert_eq!(got.bare, 0, "{what} moved");
                let angle = got.angle();
                assert!(angle <= ANGLE, "{what} moved: {angle} degrees");
                run += 1;
            }
        }
    }
    println!("gpu corners of rings: {run} cases, off by at most {most:.4} degrees");
}

#[test]
fn nothing_above_the_diagonal_of_triangles_has_an_area() {
    let Some(gpu) = gpu("folded triangles") else {
        return;
    };
    let options = SurfaceOptions {
        scheme: Some(Scheme::Loop),
        ..SurfaceOptions::default()
    };
    let cage = torus(9, 7).objects[0].surface.cage().triangulated();
    let scene = Scene::of(Surface::new(cage, &options));
    let mut renderer = Renderer::new(200, 150);
    renderer.refinement = Refinement::Default { max_level: 5 };
    let mut ready = GpuScene::new(&gpu, &renderer, &scene, &Camera::default()).unwrap();
    ready.draw().unwrap();
    let (mut folded, mut moved) = (0, 0);
    for block in ready.read_blocks().unwrap() {
        if block.start[0] != block.start[1] {
            continue;
        }
        let at = |i: usize, j: usize| block.points[j * block.side + i].map(f32::to_bits);
        for j in 1..block.side {
            assert!((0..j).all(|i| at(i, j) == at(j, j)), "{:?}", block.start);
            folded += j;
            moved += usize::from(at(j, j) == at(j - 1, j - 1));
        }
    }
    // Where sizes differ points on the diagonal move to those beside.
    assert!(moved > 0);
    println!("gpu folded triangles: {folded} points, {moved} moved");
}
