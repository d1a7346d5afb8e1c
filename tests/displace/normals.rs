//! Normals of displaced surfaces against differences in double precision.

use super::*;
use earmark::scheme::{Boundary, FaceVaryingRule};

/// Largest angle in degrees between normals at `level` and fourth-order differences of the points `stride` apart, inside of faces and, one
/// sided, on their sides.
fn worst(surface: &Surface, level: u32, stride: usize) -> f64 {
    let mut worst = 0.0_f64;
    for q in 0..surface.quads().face_count() as u32 {
        let grid = surface.dice(q, level);
        let n = grid.side;
        let at = |i: usize, j: usize| grid.points[j * n + i].map(f64::from);
        let slope = |k: usize, at: &dyn Fn(usize) -> [f64; 3]| {
            let s = stride;
            let (weights, first): ([f64; 5], usize) = if k < 2 * s {
                ([-25.0, 48.0, -36.0, 16.0, -3.0], k)
            } else if k + 2 * s >= n {
                ([3.0, -16.0, 36.0, -48.0, 25.0], k - 4 * s)
            } else {
                ([1.0, -8.0, 0.0, 8.0, -1.0], k - 2 * s)
            };
            let mut sum = [0.0; 3];
            for (m, w) in weights.iter().enumerate() {
                let p = at(first + m * s);
                (0..3).for_each(|c| sum[c] += w * p[c]);
            }
            sum
        };
        for j in (0..n).step_by(stride) {
            for i in (0..n).step_by(stride) {
                let du = slope(i, &|k| at(k, j));
                let dv = slope(j, &|k| at(i, k));
                let cross = [
                    du[1] * dv[2] - du[2] * dv[1],
                    du[2] * dv[0] - du[0] * dv[2],
                    du[0] * dv[1] - du[1] * dv[0],
                ];
                let normal = grid.normals[j * n + i].map(f64::from);
                let sin = {
                    let c = [
                        cross[1] * normal[2] - cross[2] * normal[1],
                        cross[2] * normal[0] - cross[0] * normal[2],
                        cross[0] * normal[1] - cross[1] * normal[0],
                    ];
                    (c[0] * c[0] + c[1] * c[1] + c[2] * c[2]).sqrt()
                };
                let cos = (0..3).map(|c| cross[c] * normal[c]).sum::<f64>();
                worst = worst.max(sin.atan2(cos).to_degrees());
            }
        }
    }
    worst
}

#[test]
fn normals_are_those_of_the_displaced_surface() {
    // Slopes up to about 1, heights up to a third of the radius of curvature.
    for (what, displacement, stride) in [
        (
            "ripples",
            noise("ripples:frequency=0.5,x=0.3,y=0.2").scaled(0.2),
            2,
        ),
        ("perlin", noise("perlin:frequency=0.6").scaled(0.25), 1),
    ] {
        let mut surface = torus(12, 8, false, &SurfaceOptions::default());
        surface.set_displacement(Some(displacement));
        let found = worst(&surface, 7, 2 * stride);
        println!("{what}: {found:.4} degrees");
        assert!(found < 0.05, "{what}: {found} degrees");
    }
}

#[test]
fn normals_are_the_same_whatever_was_diced_before_and_at_every_level() {
    let creased = |deepest: u32| {
        let mut out: Vec<Surface> = [Scheme::CatmullClark, Scheme::Loop]
            .map(|scheme| {
                let cage = torus(8, 6, true, &SurfaceOptions::default()).cage().clone();
                match scheme {
                    Scheme::Loop => Surface::new(cage.triangulated(), &by(scheme)),
                    _ => Surface::new(cage, &by(scheme)),
                }
            })
            .into();
        let part = common::load(&common::assets().join("part_creased.obj"));
        out.push(part.objects[0].surface.clone());
        for surface in &mut out {
            surface.set_displacement(Some(noise("perlin:frequency=0.9,seed=3").scaled(0.1)));
            let _ = surface.dice(0, deepest);
        }
        out
    };
    let bits = |n: [f32; 3]| n.map(f32::to_bits);
    for (surface, deeper) in creased(0).iter().zip(&creased(7)) {
        for level in [1, 3] {
            let (mut differ, mut among, mut compared) = (0, 0, 0);
            for q in (0..surface.quads().face_count() as u32).step_by(3) {
                let (a, b) = (surface.dice(q, level), deeper.dice(q, level));
                differ += a
                    .points
                    .iter()
                    .zip(&b.points)
                    .filter(|(a, b)| bits(**a) != bits(**b))
                    .count();
                differ += a
                    .normals
                    .iter()
                    .zip(&b.normals)
                    .filter(|(a, b)| bits(**a) != bits(**b))
                    .count();
                let fine = deeper.dice(q, level + 1);
                for k in 0..a.normals.len() {
                    let (i, j) = (k % a.side, k / a.side);
                    let other = fine.normals[2 * j * fine.side + 2 * i];
                    // Folded triangles repeat their diagonal.
                    among += usize::from(bits(a.normals[k]) != bits(other));
                    compared += 1;
                }
            }
            println!("level {level}: {differ} and {among} of {compared}");
            assert!(compared > 100);
            assert_eq!(differ, 0);
            if surface.scheme() != Scheme::Loop {
                assert_eq!(among, 0);
            }
        }
    }
}

/// A plane under a ramp, where coordinates are linear and derivatives are differences.
#[test]
fn slopes_of_interpolating_surfaces_do_not_depend_on_the_level() {
    const SIDE: u32 = 64;
    let ramp = (0..SIDE * SIDE).map(|k| (k % SIDE) as f32 / SIDE as f32);
    let ramp = Arc::new(HeightMap::new(SIDE, SIDE, ramp.collect()).unwrap());
    // One unit up over four units of the plane.
    let at = |k: u32| [(k % 5) as f32, (k / 5) as f32];
    let points = (0..25).map(|k| [at(k)[0], at(k)[1], 0.0]).collect();
    let uvs = (0..25).map(|k| at(k).map(|c| c / 4.0)).collect();
    let quads = (0..16).map(|q| q % 4 + q / 4 * 5);
    let corners: Vec<u32> = quads.flat_map(|a| [a, a + 1, a + 6, a + 5]).collect();
    let cage = Cage::new(points, &[4; 16], corners.clone()).unwrap();
    let cage = cage.with_uvs(uvs, corners).unwrap();
    let options = SurfaceOptions {
        face_varying: Some(FaceVaryingRule::All),
        ..by(Scheme::Kobbelt)
    };
    let mut surface = Surface::new(cage, &options);
    surface.set_displacement(Some(Displacement::map(ramp)));
    let length = (1.0_f32 + 1.0 / 16.0).sqrt();
    for level in [1, 4] {
        // A face in the middle, away from where the ramp begins again.
        for n in surface.dice(5, level).normals {
            let off = [n[0] + 0.25 / length, n[1], n[2] - 1.0 / length];
            assert!(off.iter().all(|c| c.abs() < 1e-3), "{level}: {n:?}");
        }
    }
}

/// A plane of one face whose boundary is smooth all around: at its corners both derivatives run along that. Texture coordinates are linear in
/// the plane.
fn disc(scheme: Scheme, face_varying: FaceVaryingRule) -> Surface {
    let count = if scheme == Scheme::Loop { 3 } else { 4 };
    let points = [[0.0, 0.0], [2.0, 0.2], [2.3, 2.0], [-0.1, 1.8]].map(|[x, y]| [x, y, 0.0]);
    let points = points[..count as usize].to_vec();
    let uvs = points.iter().map(|p| uv_of([p[0], p[1]])).collect();
    let corners: Vec<u32> = (0..count).collect();
    let cage = Cage::new(points, &[count], corners.clone()).unwrap();
    let cage = cage.with_uvs(uvs, corners).unwrap();
    let options = SurfaceOptions {
        face_varying: Some(face_varying),
        boundary: Some(Boundary::EdgeOnly),
        ..by(scheme)
    };
    Surface::new(cage, &options)
}

fn uv_of([x, y]: [f32; 2]) -> [f32; 2] {
    [0.3 + 0.1 * x + 0.02 * y, 0.3 - 0.01 * x + 0.1 * y]
}

/// Angle in degrees between a normal and that of the graph of a function with this gradient.
fn off_graph(normal: [f32; 3], [x, y]: [f64; 2]) -> f64 {
    let n = normal.map(f64::from);
    let dot = n[2] - n[0] * x - n[1] * y;
    let cos = dot / (1.0 + x * x + y * y).sqrt();
    let cross = [n[1] + n[2] * y, -n[0] - n[2] * x, n[1] * x - n[0] * y];
    let sin = cross.iter().map(|c| c * c).sum::<f64>().sqrt() / (1.0 + x * x + y * y).sqrt();
    sin.atan2(cos).to_degrees()
}

#[test]
fn corners_between_two_sides_of_a_smooth_crease_are_tilted() {
    let function: Function = "perlin:frequency=0.8,seed=2".parse().unwrap();
    let slope = |p: [f32; 3], k: usize| {
        let at = |t: f32| {
            let mut p = [p[0], p[1], 0.0];
            p[k] += t;
            f64::from(function.at(p))
        };
        const STEP: f32 = 1.0 / 128.0;
        let near = at(STEP) - at(-STEP);
        let far = at(2.0 * STEP) - at(-2.0 * STEP);
        (8.0 * near - far) / (12.0 * f64::from(STEP))
    };
    for scheme in [Scheme::CatmullClark, Scheme::Loop] {
        let mut surface = disc(scheme, FaceVaryingRule::None);
        surface.set_displacement(Some(Displacement::function(function).scaled(0.5)));
        let grid = surface.dice(0, 2);
        for (p, &n) in grid.points.iter().zip(&grid.normals) {
            let gradient = [0, 1].map(|k| 0.5 * slope(*p, k));
            let off = off_graph(n, gradient);
            assert!(off < 0.05, "{scheme:?} at {p:?}: {n:?}, {off} degrees");
        }
        // A map, by coordinates that bend as the surface does.
        const SIDE: u32 = 64;
        let ramp = (0..SIDE * SIDE).map(|k| (k % SIDE) as f32 / SIDE as f32);
        let ramp = Arc::new(HeightMap::new(SIDE, SIDE, ramp.collect()).unwrap());
        let lifted = |rule| {
            let mut surface = disc(scheme, rule);
            surface.set_displacement(Some(Displacement::map(Arc::clone(&ramp)).scaled(4.0)));
            surface.dice(0, 2)
        };
        let grid = lifted(FaceVaryingRule::None);
        for &n in &grid.normals {
            let off = off_graph(n, [0.4, 0.08]);
            assert!(off < 0.05, "{scheme:?}: {n:?}, {off} degrees");
        }
        // By others heights change where the surface stands still.
        let (sharp, plain) = (lifted(FaceVaryingRule::CornersOnly), &grid);
        let last = sharp.side * sharp.side - 1;
        for at in [0, sharp.side - 1, last] {
            let n = sharp.normals[at];
            assert!(n[2].abs() < 1e-3, "{scheme:?} at {at}: {n:?}");
            assert!(plain.normals[at][2] > 0.9);
        }
    }
}
