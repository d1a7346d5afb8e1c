//! The pool of patterns: covered once, no point of an edge inside of another edge, sides as deep as they say.

use earmark::tessellate::patterns::{
    Attribute, Order, Pattern, Place, QuadPattern, TrianglePattern, refine, vertex_index, vertices,
};
use std::collections::{BTreeMap, BTreeSet};

const BOTH: [Pattern; 2] = [Pattern::Split, Pattern::Equilateral];

type Triangle = [Place; 3];

fn area(t: &Triangle) -> i64 {
    let p = t.map(|p| p.map(i64::from));
    (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0])
}

/// Which side of a triangle (or quad) of `n` steps both ends of an edge lie on.
fn side(a: Place, b: Place, n: u16, quad: bool) -> Option<usize> {
    let on = |[x, y]: Place| match quad {
        true => [y == 0, x == n, y == n, x == 0],
        false => [y == 0, x + y == n, x == 0, false],
    };
    (0..4).find(|&k| on(a)[k] && on(b)[k])
}

/// Checks a pattern. Edges run twice, once each way, or once along a side; so nothing overlaps, nothing is left out, and no point lies inside
/// of an edge. Beside that the areas add up.
fn check(what: &str, triangles: &[Triangle], depths: &[u8], quad: bool) {
    let depth = depths.iter().max().copied().unwrap_or(0);
    let n = 1_u16 << depth;
    let mut total = 0;
    let mut edges: BTreeMap<[Place; 2], u32> = BTreeMap::new();
    for t in triangles {
        let a = area(t);
        assert!(a > 0, "{what}: {t:?} has area {a}");
        total += a;
        for k in 0..3 {
            *edges.entry([t[k], t[(k + 1) % 3]]).or_default() += 1;
        }
    }
    let whole = i64::from(n) * i64::from(n);
    assert_eq!(total, if quad { 2 * whole } else { whole }, "{what}");
    let mut pieces = vec![BTreeSet::new(); depths.len()];
    for (&[a, b], &count) in &edges {
        assert_eq!(count, 1, "{what}: an edge runs {count} times the same way");
        if !edges.contains_key(&[b, a]) {
            let side = side(a, b, n, quad);
            let Some(side) = side else {
                panic!("{what}: {a:?} to {b:?} has one triangle");
            };
            pieces[side].extend([a, b]);
        }
    }
    for (k, (points, &d)) in pieces.iter().zip(depths).enumerate() {
        assert_eq!(points.len(), (1 << d) + 1, "{what}: points of side {k}");
        let step = n >> d;
        let aligned = points.iter().flatten().all(|c| c.is_multiple_of(step));
        assert!(aligned, "{what}: points of side {k} are not even");
    }
}

fn triangle(pattern: Pattern, depths: [u8; 3]) -> Vec<Triangle> {
    TrianglePattern::new(pattern, depths)
        .unwrap()
        .triangles()
        .collect()
}

/// All depths up to 5, and some up to 10.
fn depths() -> Vec<[u8; 3]> {
    let mut all = Vec::new();
    for i in 0..=5 {
        for j in 0..=5 {
            all.extend((0..=5).map(|k| [i, j, k]));
        }
    }
    all.extend([
        [10, 0, 0],
        [8, 3, 7],
        [0, 9, 2],
        [1, 1, 9],
        [7, 6, 7],
        [2, 10, 5],
    ]);
    all
}

#[test]
fn triangles_are_covered_once() {
    let mut count = 0;
    for pattern in BOTH {
        for d in depths() {
            let found = triangle(pattern, d);
            check(&format!("{pattern:?} {d:?}"), &found, &d, false);
            count += 1;
        }
    }
    assert_eq!(count, 2 * 222);
}

#[test]
fn quads_are_covered_once() {
    for pattern in BOTH {
        for d in 0..5_u32.pow(4) {
            let d = [0, 1, 2, 3].map(|k| (d / 5_u32.pow(k) % 5) as u8);
            let found: Vec<Triangle> = QuadPattern::new(pattern, d).unwrap().triangles().collect();
            check(&format!("{pattern:?} {d:?}"), &found, &d, true);
        }
        for d in [
            [9, 0, 1, 4],
            [0, 0, 0, 10],
            [6, 7, 8, 5],
            [7, 7, 7, 7],
            [8, 0, 8, 0],
        ] {
            let found: Vec<Triangle> = QuadPattern::new(pattern, d).unwrap().triangles().collect();
            check(&format!("{pattern:?} {d:?}"), &found, &d, true);
        }
    }
}

#[test]
fn uniform_patterns_are_uniform() {
    for pattern in BOTH {
        for d in 0..=6 {
            let found = triangle(pattern, [d; 3]);
            assert_eq!(found.len(), 1 << (2 * d));
            assert!(found.iter().all(|t| area(t) == 1));
            let quad = QuadPattern::new(pattern, [d; 4]).unwrap();
            // The diagonal of the grid, from (i, j) to (i + 1, j + 1).
            for t in quad.triangles() {
                let low = [0, 1].map(|k| t.iter().map(|p| p[k]).min().unwrap());
                assert!(t.contains(&low) && t.contains(&low.map(|k| k + 1)), "{t:?}");
            }
        }
    }
}

/// As a set, every triangle beginning with its least corner.
fn set(triangles: impl Iterator<Item = Triangle>) -> BTreeSet<Triangle> {
    triangles
        .map(|t| {
            let k = (0..3).min_by_key(|&k| t[k]).unwrap();
            [t[k], t[(k + 1) % 3], t[(k + 2) % 3]]
        })
        .collect()
}

#[test]
fn patterns_turn_with_their_sides() {
    for pattern in BOTH {
        for d in depths().into_iter().filter(|d| d.iter().all(|&d| d < 6)) {
            let n = 1_u16 << d.iter().max().unwrap();
            // Corner 0 becomes corner 1: the weights move on by one.
            let turned = triangle(pattern, d)
                .into_iter()
                .map(|t| t.map(|[x, y]| [n - x - y, x]));
            let other = triangle(pattern, [d[2], d[0], d[1]]);
            assert_eq!(set(turned), set(other.into_iter()), "{pattern:?} {d:?}");
        }
        for d in [[0, 1, 2, 3], [4, 0, 0, 1], [3, 3, 5, 0], [2, 2, 2, 1]] {
            let n = 1_u16 << d.iter().max().unwrap();
            let of = |d| QuadPattern::new(pattern, d).unwrap().triangles();
            let turned = of(d).map(|t| t.map(|[x, y]| [n - x, n - y]));
            assert_eq!(
                set(turned),
                set(of([d[2], d[3], d[0], d[1]])),
                "{pattern:?} {d:?}"
            );
        }
    }
}

/// Smallest angle of a triangle in degrees, where the whole is equilateral.
fn least_angle(t: &Triangle) -> f64 {
    let p = t.map(|[x, y]| {
        let [x, y] = [f64::from(x), f64::from(y)];
        [x + y / 2.0, y * 0.75_f64.sqrt()]
    });
    (0..3)
        .map(|k| {
            let (a, b, c) = (p[k], p[(k + 1) % 3], p[(k + 2) % 3]);
            let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
            (u[0] * v[1] - u[1] * v[0]).atan2(u[0] * v[0] + u[1] * v[1])
        })
        .fold(f64::INFINITY, f64::min)
        .to_degrees()
}

#[test]
fn equilateral_patterns_have_better_triangles() {
    let mut means = Vec::new();
    for pattern in BOTH {
        let (mut count, mut sum, mut slender, mut worst, mut worsts) = (0, 0.0, 0, 90.0_f64, 0.0);
        let mut unequal = 0;
        for d in depths().into_iter().filter(|d| d.iter().all(|&d| d < 6)) {
            if d[0] == d[1] && d[1] == d[2] {
                continue;
            }
            let angles: Vec<f64> = triangle(pattern, d).iter().map(least_angle).collect();
            let least = angles.iter().copied().fold(f64::INFINITY, f64::min);
            count += angles.len();
            sum += angles.iter().sum::<f64>();
            slender += angles.iter().filter(|&&a| a < 20.0).count();
            worst = worst.min(least);
            worsts += least;
            unequal += 1;
        }
        let mean = sum / count as f64;
        println!(
            "{pattern:?}: {count} triangles of {unequal} unequal patterns, least angle {mean:.1} degrees on average, {:.1} % below 20, {worst:.2} at the worst, {:.2} in the worst triangle of a pattern on average",
            100.0 * slender as f64 / count as f64,
            worsts / f64::from(unequal),
        );
        means.push((mean, worst, worsts));
    }
    let [split, equilateral] = means.as_slice() else {
        panic!("two patterns");
    };
    assert!(equilateral.0 > split.0 && equilateral.1 > split.1 && equilateral.2 > split.2);
}

#[test]
fn indices_name_points_of_any_deeper_buffer() {
    for pattern in BOTH {
        for d in [[3, 4, 5], [0, 2, 1], [5, 5, 5]] {
            let p = TrianglePattern::new(pattern, d).unwrap();
            let buffer: Vec<[f32; 3]> = vertices(7).collect();
            let n = f32::from(1_u16 << p.depth());
            for (places, indices) in p.triangles().zip(p.indices()) {
                for (place, index) in places.into_iter().zip(indices) {
                    let [w, x, y] = buffer[index as usize].map(|w| w * n);
                    assert_eq!([x, y], place.map(f32::from));
                    assert_eq!(w + x + y, n);
                    assert_eq!(vertex_index(p.depth(), place), index);
                }
            }
        }
    }
}

#[test]
fn a_pattern_of_depth_ten_is_made_on_demand() {
    assert!(TrianglePattern::new(Pattern::Split, [11, 0, 0]).is_none());
    assert!(QuadPattern::new(Pattern::Split, [0, 0, 0, 11]).is_none());
    let p = TrianglePattern::new(Pattern::Equilateral, [10; 3]).unwrap();
    let total: i64 = p.triangles().map(|t| area(&t)).sum();
    assert_eq!((p.triangles().count(), total), (1 << 20, 1 << 20));
}

/// Two faces that share an edge have the same bits there, whatever their patterns, in every order.
#[test]
fn shared_edges_have_the_same_bits() {
    let mut random = super::common::Random(5);
    let mut value = || random.range(-1.0, 1.0) as f32;
    for (order, shared) in [
        (Order::Linear, vec![(0, 1), (1, 0)]),
        (Order::Quadratic, vec![(0, 1), (1, 0), (3, 3)]),
        (Order::Cubic, vec![(0, 1), (1, 0), (3, 4), (4, 3)]),
    ] {
        let n = order.controls();
        let mut control: Vec<f32> = (0..2 * n * 3).map(|_| value()).collect();
        // Side 0 of face 1 is side 0 of face 0, run backwards.
        for (a, b) in shared {
            for c in 0..3 {
                control[(n + b) * 3 + c] = control[a * 3 + c];
            }
        }
        let attribute = Attribute {
            order,
            components: 3,
            control: &control,
        };
        for pattern in BOTH {
            let mut seen = Vec::new();
            refine(
                pattern,
                &[[4, 2, 5], [4, 0, 1]],
                &[attribute],
                |_, p| p[2] += p[0] * 0.5,
                |f| {
                    let points: Vec<[u32; 3]> = f
                        .vertices
                        .chunks_exact(3)
                        .map(|p| [0, 1, 2].map(|k| p[k].to_bits()))
                        .collect();
                    seen.push((points, f.triangles.to_vec()));
                },
            );
            let [a, b] = [0, 1].map(|k| seen[k].0.iter().copied().collect::<BTreeSet<_>>());
            assert_eq!(a.intersection(&b).count(), 17, "{pattern:?} {order:?}");
            let [a, b] = [0, 1].map(|k| seen[k].1.len());
            assert!(a != b && b > 16);
        }
    }
}

/// A plane stays a plane, and a parabola that the control points stand for is met exactly.
#[test]
fn orders_are_their_polynomials() {
    // Position (x, y, 0) linear; height x² quadratic: b110 of x² between corners at 0 and 1 is 0, the others likewise.
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let linear: Vec<f32> = corners.concat();
    let square = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
    // x³ as a cubic: 1 at corner 1, nothing else.
    let cube = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let attributes = [
        (Order::Linear, 3, &linear[..]),
        (Order::Quadratic, 1, &square[..]),
        (Order::Cubic, 1, &cube[..]),
    ]
    .map(|(order, components, control)| Attribute {
        order,
        components,
        control,
    });
    let mut count = 0;
    refine(
        Pattern::Equilateral,
        &[[3, 2, 1]],
        &attributes,
        |_, _| {},
        |f| {
            for v in f.vertices.chunks_exact(5) {
                let x = v[0];
                assert_eq!((v[3], v[4]), (x * x, x * x * x));
                count += 1;
            }
        },
    );
    assert!(count > 20);
}

#[test]
fn damaged_patterns_are_noticed() {
    let d = [3, 1, 4];
    let whole = triangle(Pattern::Equilateral, d);
    let noticed = |damaged: Vec<Triangle>| {
        std::panic::catch_unwind(|| check("damaged", &damaged, &d, false)).is_err()
    };
    assert!(!noticed(whole.clone()));
    // One is missing, one is there twice, one is turned over, and one has lost a point of a side to its neighbour.
    assert!(noticed(whole[1..].to_vec()));
    assert!(noticed([&whole[..], &whole[..1]].concat()));
    let turned = whole.iter().enumerate().map(|(k, &[a, b, c])| match k {
        5 => [a, c, b],
        _ => [a, b, c],
    });
    assert!(noticed(turned.collect()));
    let mut moved = whole;
    let inside = |[x, y]: &Place| *x > 0 && *y > 0 && x + y < 16;
    let found = moved.iter_mut().flatten().find(|p| inside(p)).unwrap();
    found[0] -= 1;
    assert!(noticed(moved));
}
