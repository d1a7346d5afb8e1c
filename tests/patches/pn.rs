//! Curved PN triangles.

use super::*;

/// A triangle on the unit sphere whose sides span `degrees`, with the sphere's normals.
fn spherical(degrees: f64) -> Cage {
    // Corners around the z axis: the angle between two of them is that of the side.
    let side = degrees.to_radians();
    let r = 2.0 / 3.0_f64.sqrt() * (side / 2.0).sin();
    let z = (1.0 - r * r).sqrt();
    let mut text = String::new();
    for kind in ["v", "vn"] {
        for k in 0..3 {
            let a = std::f64::consts::TAU * f64::from(k) / 3.0;
            text += &format!("{kind} {} {} {z}\n", r * a.cos(), r * a.sin());
        }
    }
    read(&(text + "f 1//1 2//2 3//3\n"))
}

#[test]
fn normals_on_a_sphere_have_bernsteins_factor() {
    for (degrees, most) in [(14.0, 0.04), (45.0, 0.9)] {
        let cage = spherical(degrees);
        let pn = surface(&cage, Scheme::Loop, PatchKind::Pn);
        let diced = pn.dice(0, 5);
        let (mut worst, mut radius) = (0.0_f32, 0.0_f32);
        for k in drawn(&pn, diced.side) {
            let p = diced.points[k];
            let length = dot(p, p).sqrt();
            radius = radius.max((length - 1.0).abs());
            worst = worst.max(angle(diced.normals[k], p.map(|c| c / length)));
        }
        println!(
            "sides of {degrees} degrees: normals off by {worst:.3} degrees, radius by {radius:.1e}"
        );
        assert!(worst < most, "{degrees}: {worst}");
        assert!(radius < 0.02);
    }
}

#[test]
fn surfaces_go_through_the_cage_tangent_to_its_normals() {
    for (cage, scheme) in [
        (icosahedron(), Scheme::Loop),
        (asset("creature"), Scheme::CatmullClark),
        (asset("part"), Scheme::CatmullClark),
    ] {
        let pn = surface(&cage, scheme, PatchKind::Pn);
        let t = pn.topology();
        let step = 1.0 / 1024.0;
        let mut worst = 0.0_f32;
        for q in (0..pn.quads().face_count() as u32).step_by(7) {
            let (p, n) = pn.patch_point(q, 0.0, 0.0).unwrap();
            let h = if pn.is_split() {
                q
            } else {
                t.face_halves(q).start
            };
            assert_eq!(p, pn.cage().points()[t.vertex(h) as usize]);
            for (u, v) in [(step, 0.0), (step, step), (0.0, step)] {
                if pn.is_triangular() && v > u {
                    continue;
                }
                let d = minus(pn.patch_point(q, u, v).unwrap().0, p);
                let length = dot(d, d).sqrt();
                if length > 5e-6 * size(&cage) {
                    worst = worst.max((dot(d, n) / length).abs());
                }
            }
        }
        println!("{scheme:?}: tangents off the normals' planes by {worst:.1e}");
        assert!(worst < 0.02, "{scheme:?}: {worst}");
    }
}

#[test]
fn flat_cages_stay_flat() {
    // A triangle, a concave quad, a pentagon and an octagon beside one another.
    let points = [
        [0.0, 0.0],
        [2.0, 0.0],
        [3.0, 1.0],
        [3.0, 3.0],
        [2.0, 4.0],
        [0.0, 4.0],
        [-1.0, 3.0],
        [-1.0, 1.0],
        [5.0, -1.0],
        [3.5, 0.0],
        [6.0, 2.0],
        [4.0, 2.5],
        [5.0, 5.0],
    ];
    let points = points.map(|[x, y]| [x, 0.25, -y]);
    let faces: [&[u32]; 4] = [
        &[0, 1, 2, 3, 4, 5, 6, 7],
        &[1, 8, 9, 2],
        &[2, 9, 8, 10, 11],
        &[3, 11, 12],
    ];
    let cage = build(points, faces).build().unwrap();
    for tension in [1.0, 0.5] {
        let mut pn = surface(&cage, Scheme::CatmullClark, PatchKind::Pn);
        pn.set_tension(&[tension; 13]).unwrap();
        for q in 0..pn.quads().face_count() as u32 {
            let diced = pn.dice(q, 3);
            for (p, n) in diced.points.iter().zip(&diced.normals) {
                assert!((p[1] - 0.25).abs() < 1e-6, "{p:?}");
                assert!(n[1] > 0.999_999, "quad {q}: {n:?}");
            }
        }
    }
}

#[test]
fn tension_goes_from_flat_to_curved() {
    let cage = icosahedron();
    let curved = surface(&cage, Scheme::Loop, PatchKind::Pn);
    let mut tagged = curved.clone();
    tagged.set_tension(&[1.0; 12]).unwrap();
    assert_eq!(tagged.dice(3, 3), curved.dice(3, 3));
    tagged.set_tension(&[0.0; 12]).unwrap();
    let flat = tagged.dice(3, 3);
    let n = flat.side - 1;
    let [a, b, c] = [0, n, n * (n + 2)].map(|k| flat.points[k]);
    for k in drawn(&curved, flat.side) {
        let (u, v) = (
            (k % (n + 1)) as f32 / n as f32,
            (k / (n + 1)) as f32 / n as f32,
        );
        let want = [0, 1, 2].map(|k| a[k] * (1.0 - u) + b[k] * (u - v) + c[k] * v);
        assert!(distance(flat.points[k], want) < 1e-6);
    }
    assert_eq!(flat.normals, curved.dice(3, 3).normals);
    // One vertex of half the tension: halfway at its end of a side, all the way at the other.
    let mut tension = [1.0; 12];
    tension[cage.face(3)[0] as usize] = 0.5;
    tagged.set_tension(&tension).unwrap();
    let half = tagged.dice(3, 4);
    let (flat, curved) = (
        {
            tagged.set_tension(&[0.0; 12]).unwrap();
            tagged.dice(3, 4)
        },
        curved.dice(3, 4),
    );
    let share = |k: usize| {
        let [f, h, c] = [&flat, &half, &curved].map(|d| d.points[k]);
        distance(f, h) / distance(f, c)
    };
    assert!(share(1) > 0.5 && share(1) < 0.6, "{}", share(1));
    assert!(share(15) > 0.9 && share(15) < 1.0, "{}", share(15));
}

#[test]
fn tagged_corners_are_flat() {
    let text = "v 0 0 1\nv 1 0 0\nv 0 1 0\nv -1 -1 0\nf 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\nt corner 1/1/0 0 10\nt corner 1/1/0 1 4\n";
    let cage = read(text);
    let tagged = surface(&cage, Scheme::Loop, PatchKind::Pn);
    let mut set = tagged.clone();
    set.set_tension(&[0.0, 0.6, 1.0, 1.0]).unwrap();
    assert_eq!(tagged.dice(0, 3), set.dice(0, 3));
    set.set_tension(&[1.0; 4]).unwrap();
    assert_ne!(tagged.dice(0, 3), set.dice(0, 3));
}

#[test]
fn creases_keep_their_lines() {
    // Corners of three creases: every edge stays straight, every face flat, its normal its own.
    let cage = creased_cube(10.0);
    let pn = surface(&cage, Scheme::CatmullClark, PatchKind::Pn);
    for q in 0..6 {
        let diced = pn.dice(q, 3);
        let normal = diced.normals[0];
        for (p, n) in diced.points.iter().zip(&diced.normals) {
            assert!(p.iter().any(|c| (c.abs() - 1.0).abs() < 1e-6), "{p:?}");
            assert!(angle(*n, normal) < 1e-3);
        }
        assert!(normal.iter().any(|c| c.abs() > 0.999_999), "{normal:?}");
    }
    // A prism's rim: the crease bends, though its faces' planes do not.
    let pn = surface(&prism(), Scheme::CatmullClark, PatchKind::Pn);
    // The first quads are those at the corners of the lid.
    let lid = pn.dice(0, 4);
    let middle = lid.points[lid.side - 1];
    let radius = (middle[0] * middle[0] + middle[1] * middle[1]).sqrt();
    println!(
        "middle of the rim at radius {radius}, of its chord at {}",
        (std::f32::consts::PI / 8.0).cos()
    );
    assert!((radius - 1.0).abs() < 0.01 && (middle[2] - 1.0).abs() < 1e-6);
    assert!(lid.normals.iter().all(|n| n[2] > 0.999_999));
}

#[test]
fn polygons_bulge_as_triangles_do() {
    // A pyramid's cap over a polygon on the sphere: its middle comes close to the sphere.
    for n in [5_u32, 8] {
        let r = 0.4_f64;
        let z = (1.0 - r * r).sqrt();
        let mut text = String::new();
        for kind in ["v", "vn"] {
            for k in 0..n {
                let a = std::f64::consts::TAU * f64::from(k) / f64::from(n);
                text += &format!("{kind} {} {} {z}\n", r * a.cos(), r * a.sin());
            }
        }
        text += "f";
        (1..=n).for_each(|k| text += &format!(" {k}//{k}"));
        let pn = surface(&read(&(text + "\n")), Scheme::CatmullClark, PatchKind::Pn);
        let (mut worst, mut off) = (0.0_f32, 0.0_f32);
        for q in 0..n {
            let diced = pn.dice(q, 3);
            for (p, unit) in diced.points.iter().zip(&diced.normals) {
                let length = dot(*p, *p).sqrt();
                worst = worst.max((length - 1.0).abs());
                off = off.max(angle(*unit, p.map(|c| c / length)));
            }
        }
        println!(
            "polygon of {n} on a sphere: radius off by {worst:.1e}, normals by {off:.2} degrees"
        );
        assert!(worst < 0.012 && off < 2.0, "{n}: {worst} {off}");
    }
}

#[test]
fn moving_a_cage_forgets_normals_of_the_file() {
    let cage = spherical(45.0);
    let mut pn = surface(&cage, Scheme::Loop, PatchKind::Pn);
    let given = pn.dice(0, 2);
    pn.update_points(cage.points()).unwrap();
    let own = pn.dice(0, 2);
    assert_ne!(given.points, own.points);
    assert!(
        own.normals.iter().all(|n| n[2] > 0.999_999),
        "one flat face"
    );
}

#[test]
fn wrong_tensions_are_errors() {
    let mut pn = surface(&icosahedron(), Scheme::Loop, PatchKind::Pn);
    assert!(pn.set_tension(&[1.0; 11]).is_err());
    assert!(pn.set_tension(&[f32::NAN; 12]).is_err());
    pn.set_tension(&[7.0; 12]).unwrap();
    assert_eq!(
        pn.dice(0, 2),
        surface(&icosahedron(), Scheme::Loop, PatchKind::Pn).dice(0, 2)
    );
    assert_eq!(pn.patch_point(20, 0.0, 0.0), None);
    assert_eq!(
        surface(&icosahedron(), Scheme::Loop, PatchKind::None).patch_point(0, 0.0, 0.0),
        None
    );
}

#[test]
fn quads_are_parted_by_their_shorter_diagonal() {
    // The shorter diagonal of this kite runs from vertex 1 to 3; above it the fold is.
    let points = [
        [0.0, 0.0, 0.0],
        [2.0, -0.5, 0.5],
        [4.0, 0.0, 0.0],
        [2.0, 0.5, 0.5],
    ];
    let cage = Cage::new(points.to_vec(), &[4], vec![0, 1, 2, 3]).unwrap();
    let mut pn = surface(&cage, Scheme::CatmullClark, PatchKind::Pn);
    pn.set_tension(&[0.0; 4]).unwrap();
    assert_eq!(pn.cage().face(0), [1, 2, 3, 0]);
    let (middle, _) = pn.patch_point(0, 0.5, 0.5).unwrap();
    assert!(distance(middle, [2.0, 0.0, 0.5]) < 1e-6, "{middle:?}");
    // A square: the diagonal at the lowest vertex.
    let square = [
        [1.0, 1.0, 0.0],
        [0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
    ];
    let cage = Cage::new(square.to_vec(), &[4], vec![2, 1, 3, 0]).unwrap();
    let pn = surface(&cage, Scheme::CatmullClark, PatchKind::Pn);
    assert_eq!(pn.cage().face(0), [1, 3, 0, 2]);
}
