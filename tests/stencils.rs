//! Stencils times cage points are refined points, limits and tangent planes.
#![allow(missing_docs, clippy::print_stdout)]

mod support;

use earmark::refine::{Level, Options, RefineError, Stencils, Timings, limit, refine, stencils};
use earmark::scheme::{Boundary, Scheme};
use support::random_cages::{random_cage, random_triangles};
use support::{Shape, cube, distance, star};

fn narrow(points: &[[f64; 3]]) -> Vec<[f32; 3]> {
    points.iter().map(|p| p.map(|c| c as f32)).collect()
}

fn widest(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    assert_eq!(a.len(), b.len());
    (a.iter().zip(b))
        .map(|(a, b)| distance(&a.map(f64::from), &b.map(f64::from)))
        .fold(0.0, f64::max)
}

fn check_rows(s: &Stencils) {
    for i in 0..s.len() {
        let row = s.row(i);
        let own = &s.indices[row.clone()];
        assert!(own.windows(2).all(|w| w[0] < w[1]), "row {i} ascends");
        let sum = |w: &[f32]| w[row.clone()].iter().map(|&w| f64::from(w)).sum::<f64>();
        assert!(
            (sum(&s.weights) - 1.0).abs() < 1e-6,
            "row {i}: {}",
            sum(&s.weights)
        );
        for t in s.tangents.iter().filter(|t| !t.is_empty()) {
            assert!(sum(t).abs() < 1e-5, "row {i}: {}", sum(t));
        }
    }
}

/// Returns the worst error over refined and limit points, of the size of the cage.
fn compare(shape: &Shape, boundary: Boundary, options: &Options, levels: u32) -> f64 {
    let topology = shape.topology(boundary);
    let points = narrow(&shape.points);
    let base = Level::<f32>::new(topology.clone(), points.clone()).unwrap();
    let level = refine(base, options, levels, None, &mut Timings::default()).unwrap();
    let limits = limit(&level, options);
    let size = support::extent(&shape.points);

    let refined = stencils(&topology, options, levels, false, None).unwrap();
    check_rows(&refined);
    assert!(refined.tangents.iter().all(Vec::is_empty));
    let of_points = widest(&refined.points(&points).unwrap(), &level.points) / size;

    let baked = stencils(&topology, options, levels, true, None).unwrap();
    check_rows(&baked);
    let of_limits = widest(&baked.points(&points).unwrap(), &limits.positions) / size;

    // The first normal of a vertex is across its tangents, wherever they are not parallel.
    let [us, vs] = baked.tangents(&points).unwrap();
    let mut normals = 0;
    for v in 0..level.points.len() {
        let [a, b] = [us[v], vs[v]].map(|c| c.map(f64::from));
        let n = [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ];
        let length = |v: [f64; 3]| distance(&v, &[0.0; 3]);
        // Below a tenth single precision of the points begins to show.
        if length(n) < 0.1 * length(a) * length(b) || length(n) == 0.0 {
            continue;
        }
        let n = n.map(|c| c / length(n));
        let h = level.topology.fans()[v].first;
        let index = limits.normal_index(&level.topology, h) as usize;
        let own = limits.normals[index].map(f64::from);
        let error = distance(&n, &own).min(distance(&n.map(|c| -c), &own));
        if limits.corner_normals.is_empty() {
            assert!(error < 2e-3, "vertex {v}: {error}");
            // Tangents of a corner do not know on which side of a reflex angle they lie.
            let corner = level.topology.vertex_sharpness(v as u32) > 0.0;
            assert!(
                corner || distance(&n, &own) < 1.0,
                "vertex {v} points inward"
            );
            normals += 1;
        }
    }
    assert!(normals > 0 || !limits.corner_normals.is_empty());
    of_points.max(of_limits)
}

#[test]
fn stencils_times_cage_points_are_refined_points_and_limits() {
    let mut worst = 0.0_f64;
    for index in 0..48 {
        let cage = random_cage(index);
        let levels = (index % 4) as u32;
        let error = compare(&cage.shape, cage.case.boundary, &cage.case.options, levels);
        assert!(
            error <= 1e-6,
            "{} level {levels}: {error:.2e}",
            cage.case.name
        );
        worst = worst.max(error);
    }
    println!("48 cages, worst {worst:.2e}");
    assert!(worst > 0.0);
}

/// Loop and Butterfly on triangles, Kobbelt's rules on anything.
#[test]
fn schemes_of_other_masks() {
    for index in 0..24 {
        let (cage, triangles) = (random_cage(index), random_triangles(index));
        let levels = (index % 4) as u32;
        for (cage, scheme) in [
            (&triangles, Scheme::Loop),
            (&triangles, Scheme::Butterfly),
            (&cage, Scheme::Kobbelt),
        ] {
            let options = Options {
                scheme,
                ..cage.case.options
            };
            let error = compare(&cage.shape, cage.case.boundary, &options, levels);
            assert!(
                error <= 2e-6,
                "{scheme:?} {} level {levels}: {error:.2e}",
                cage.case.name
            );
        }
    }
}

#[test]
fn other_schemes_and_odd_meshes() {
    let bilinear = Options {
        scheme: Scheme::Bilinear,
        ..Options::default()
    };
    assert!(compare(&support::patch(), Boundary::EdgeAndCorner, &bilinear, 2) <= 1e-6);
    // Three quads at one edge, a vertex of no face.
    let points = [
        [0.0, 0.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 0.0],
        [1.0, 0.0, 1.0],
        [0.0, 1.0, 0.0],
        [0.0, 1.0, 1.0],
        [-1.0, -1.0, 0.0],
        [-1.0, -1.0, 1.0],
        [9.0, 9.0, 9.0],
    ];
    let shape = Shape::new(&points, &[&[0, 1, 3, 2], &[0, 1, 5, 4], &[0, 1, 7, 6]]);
    assert!(compare(&shape, Boundary::EdgeAndCorner, &Options::default(), 2) <= 1e-6);
    let valent = star(40, 3);
    assert!(compare(&valent, Boundary::EdgeAndCorner, &Options::default(), 2) <= 1e-6);
}

#[test]
fn stencils_are_as_sparse_as_the_surface_is_local() {
    let shape = support::grid(8, |_, _| 0.0);
    let topology = shape.topology(Boundary::EdgeAndCorner);
    let baked = stencils(&topology, &Options::default(), 3, true, None).unwrap();
    let longest = (0..baked.len()).map(|i| baked.row(i).len()).max();
    // A point of a bicubic patch has 16 control points.
    assert_eq!(longest, Some(16));
}

#[test]
fn budgets_are_kept_and_counts_checked() {
    let topology = cube().topology(Boundary::EdgeAndCorner);
    let go = |max| stencils(&topology, &Options::default(), 4, true, Some(max));
    assert!(matches!(
        go(1 << 10),
        Err(RefineError::TooMuchMemory { .. })
    ));
    assert!(go(1 << 30).is_ok());
    let far = stencils(&topology, &Options::default(), 60, false, Some(1 << 30));
    assert!(far.is_err());
    // A star of many faces has surroundings that no memory holds.
    let star = star(20_000, 1).topology(Boundary::EdgeAndCorner);
    let many = stencils(&star, &Options::default(), 0, false, Some(1 << 30));
    assert!(matches!(many, Err(RefineError::TooMuchMemory { .. })));
    let wrong = go(1 << 30).unwrap().points(&[[0.0; 3]; 3]);
    assert_eq!(wrong, Err(RefineError::WrongCount { got: 3, wanted: 8 }));
}

#[test]
fn files_read_back() {
    let topology = support::gem().topology(Boundary::EdgeAndCorner);
    for limit in [false, true] {
        let s = stencils(&topology, &Options::default(), 1, limit, None).unwrap();
        let mut bytes = Vec::new();
        s.write_bytes(&mut bytes).unwrap();
        assert_eq!(&bytes[..8], b"EARSTEN1");
        let entries = s.indices.len();
        let layers = if limit { 3 } else { 1 };
        assert_eq!(
            bytes.len(),
            8 + 32 + 8 * (s.len() + 1) + entries * (4 + 4 * layers)
        );
        assert_eq!(Stencils::read_bytes(&bytes).unwrap(), s);
        assert!(Stencils::read_bytes(&bytes[..bytes.len() - 1]).is_err());
        bytes[8] = 0;
        assert!(Stencils::read_bytes(&bytes).is_err());

        let mut text = Vec::new();
        s.write_json(&mut text).unwrap();
        let json: serde_json::Value = serde_json::from_slice(&text).unwrap();
        assert_eq!(json["cage_points"], s.cage_points);
        assert_eq!(json["rows"], s.len());
        let rows = json["stencils"].as_array().unwrap();
        assert_eq!(rows.len(), s.len());
        for (i, row) in rows.iter().enumerate() {
            let weights: Vec<f32> = (row["weights"].as_array().unwrap().iter())
                .map(|w| w.as_f64().unwrap() as f32)
                .collect();
            assert_eq!(weights, s.weights[s.row(i)]);
            assert_eq!(row["indices"][0], s.indices[s.row(i).start]);
            assert_eq!(row.get("dv").is_some(), limit);
        }
    }
}
