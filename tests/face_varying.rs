//! Rules of texture coordinates at seams, on a sheet of 2 by 2 quads with a seam up its middle.
//!
//! ```text
//!   6 ── 7 ── 8      The seam runs 1, 4, 7. Left faces 0 and 2 have values 0 to 5, right faces 1 and 3 have 6 to 11.
//!   │  2 │  3 │
//!   3 ── 4 ── 5
//!   │  0 │  1 │
//!   0 ── 1 ── 2
//! ```
#![allow(missing_docs)]

mod support;

use earmark::mesh::NONE;
use earmark::refine::{Level, Options};
use earmark::scheme::{Boundary, FaceVaryingRule as Rule, Scheme};
use support::*;

const RULES: [Rule; 6] = [
    Rule::None,
    Rule::CornersOnly,
    Rule::CornersPlus1,
    Rule::CornersPlus2,
    Rule::Boundaries,
    Rule::All,
];

/// Values of the left side: (vertex, value) in rows from below; those of the right side follow.
fn values() -> Vec<[f64; 2]> {
    let mut noise = Noise(5);
    (0..12).map(|_| [noise.number(), noise.number()]).collect()
}

/// Value of vertex `v` on the left or right side of the seam.
fn value(v: u32, right: bool) -> u32 {
    let (column, row) = (v % 3, v / 3);
    6 * u32::from(right) + 2 * row + column - u32::from(right)
}

/// The sheet; faces of `right` lie right of the seam.
fn sheet(shape: &Shape, rule: Rule, right: &[u32]) -> Level<f64> {
    let corners: Vec<u32> = (0..16)
        .map(|h| value(shape.corners[h], right.contains(&(h as u32 / 4))))
        .collect();
    shape
        .level(Boundary::EdgeOnly)
        .with_uvs(&values(), &corners, Scheme::CatmullClark, rule)
        .unwrap()
}

/// The value of the middle vertex one level on, in the child of face `face`.
fn middle(level: &Level<f64>, face: u32) -> [f64; 2] {
    let next = refined(level.clone(), 1, &Options::default());
    let uvs = next.uvs.as_ref().unwrap();
    let h = (16 * face..16 * face + 16).find(|&h| next.topology.vertex(h) == 4);
    uvs.values[uvs.corners[h.unwrap() as usize] as usize]
}

fn curve(x: u32, a: u32, b: u32) -> [f64; 2] {
    let v = values();
    let [x, a, b] = [x, a, b].map(|i| v[i as usize]);
    std::array::from_fn(|k| 0.75 * x[k] + 0.125 * (a[k] + b[k]))
}

fn mean(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    std::array::from_fn(|k| 0.5 * (a[k] + b[k]))
}

/// What the left and the right value become: along the seam, half way, or nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Becomes {
    Curve,
    Half,
    Same,
}

#[track_caller]
fn check(shape: &Shape, rule: Rule, left: Becomes, right: Becomes) {
    let level = sheet(shape, rule, &[1, 3]);
    for (face, side, becomes) in [
        (0, false, left),
        (2, false, left),
        (1, true, right),
        (3, true, right),
    ] {
        let [below, here, above] = [1, 4, 7].map(|v| value(v, side));
        let (x, c) = (values()[here as usize], curve(here, below, above));
        let want = match becomes {
            Becomes::Curve => c,
            Becomes::Half => mean(x, c),
            Becomes::Same => x,
        };
        let got = middle(&level, face);
        assert!(
            distance(&got, &want) < 1e-15,
            "{rule:?} face {face}: not {becomes:?}"
        );
    }
}

#[test]
fn a_plain_seam_is_a_curve_on_both_sides() {
    let shape = grid(2, |_, _| 0.0);
    for rule in RULES {
        let becomes = match rule {
            Rule::Boundaries | Rule::All => Becomes::Same,
            _ => Becomes::Curve,
        };
        check(&shape, rule, becomes, becomes);
    }
}

/// A semi-sharp edge on one side holds that side's value; from corners-plus1 on the other side follows.
#[test]
fn semi_sharp_edges_hold_both_sides() {
    let plain = grid(2, |_, _| 0.0);
    for (sharpness, held) in [
        (0.5, Becomes::Half),
        (1.5, Becomes::Same),
        (10.0, Becomes::Same),
    ] {
        let shape = plain.clone().crease(4, 5, sharpness);
        for rule in [Rule::None, Rule::CornersOnly] {
            check(&shape, rule, Becomes::Curve, held);
        }
        for rule in [Rule::CornersPlus1, Rule::CornersPlus2] {
            check(&shape, rule, held, held);
        }
        let both = plain.clone().corner(4, sharpness);
        for rule in [
            Rule::None,
            Rule::CornersOnly,
            Rule::CornersPlus1,
            Rule::CornersPlus2,
        ] {
            check(&both, rule, held, held);
        }
    }
}

/// A sharp edge along the seam is no edge inside a side.
#[test]
fn creases_along_the_seam_change_nothing() {
    let shape = grid(2, |_, _| 0.0).crease(1, 4, 10.0).crease(4, 7, 3.0);
    for rule in [
        Rule::None,
        Rule::CornersOnly,
        Rule::CornersPlus1,
        Rule::CornersPlus2,
    ] {
        check(&shape, rule, Becomes::Curve, Becomes::Curve);
    }
}

/// The side without a semi-sharp edge of its own waits for the seam as well.
#[test]
fn semi_sharp_seams_hold_the_dependent_side() {
    let shape = grid(2, |_, _| 0.0).crease(4, 5, 0.5).crease(1, 4, 1.5);
    for rule in [Rule::CornersPlus1, Rule::CornersPlus2] {
        check(&shape, rule, Becomes::Same, Becomes::Half);
    }
}

/// One face against three: the single face has a corner, and from corners-plus2 on the three too.
#[test]
fn a_single_face_has_a_corner() {
    let shape = grid(2, |_, _| 0.0);
    // Face 3 alone; its seam runs 5, 4, 7.
    let mut corners = shape.corners.clone();
    let mut all = vec![[0.0; 2]; 13];
    let mut noise = Noise(6);
    for v in &mut all {
        *v = [noise.number(), noise.number()];
    }
    for (h, c) in corners.iter_mut().enumerate() {
        if h >= 12 {
            *c = 9 + h as u32 - 12;
        }
    }
    for rule in [
        Rule::None,
        Rule::CornersOnly,
        Rule::CornersPlus1,
        Rule::CornersPlus2,
    ] {
        let level = shape
            .level(Boundary::EdgeOnly)
            .with_uvs(&all, &corners, Scheme::CatmullClark, rule)
            .unwrap();
        let curve = |x: usize, a: usize, b: usize| -> [f64; 2] {
            std::array::from_fn(|k| 0.75 * all[x][k] + 0.125 * (all[a][k] + all[b][k]))
        };
        // Corners of face 3 are vertices 4, 5, 8, 7, values 9 to 12.
        let alone = if rule == Rule::None {
            curve(9, 10, 12)
        } else {
            all[9]
        };
        let three = if rule == Rule::CornersPlus2 {
            all[4]
        } else {
            curve(4, 5, 7)
        };
        assert!(
            distance(&middle(&level, 3), &alone) < 1e-15,
            "{rule:?}: the single face"
        );
        assert!(
            distance(&middle(&level, 0), &three) < 1e-15,
            "{rule:?}: the three"
        );
    }
}

/// Faces 0 and 3 share values, so do 1 and 2: at the middle both sides are in two pieces and stay.
#[test]
fn a_side_in_pieces_is_a_corner() {
    let shape = grid(2, |_, _| 0.0);
    let all: Vec<[f64; 2]> = (0..18)
        .map(|i| [f64::from(i * i % 7), f64::from(i % 5)])
        .collect();
    let corners: Vec<u32> = (0..16)
        .map(|h| shape.corners[h] + if matches!(h / 4, 1 | 2) { 9 } else { 0 })
        .collect();
    for rule in RULES {
        let level = shape
            .level(Boundary::EdgeOnly)
            .with_uvs(&all, &corners, Scheme::CatmullClark, rule)
            .unwrap();
        for (face, want) in [(0, 4), (1, 13), (2, 13), (3, 4)] {
            assert_eq!(middle(&level, face), all[want], "{rule:?}");
        }
    }
}

#[test]
fn no_value_is_a_value() {
    let shape = grid(2, |_, _| 0.0);
    let level = shape
        .level(Boundary::EdgeOnly)
        .with_uvs(&[], &[NONE; 16], Scheme::CatmullClark, Rule::CornersPlus1)
        .unwrap();
    assert_eq!(middle(&level, 0), [0.0; 2]);
    assert!(!level.uvs.as_ref().unwrap().is_complete(0));
}
