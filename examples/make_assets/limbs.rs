//! Legs with toes, and gills with frills: what grows out of the creature's body.

use super::creature::{Body, label, patch};
use super::edit::{Extrusion, Ring};
use super::mesh::{V3, add, cross, dot, mix, scale, sub, unit};

/// Grows all limbs of the right side.
pub(crate) fn grow(b: &mut Body) {
    leg(
        b,
        &Leg {
            section: 7,
            row: 6,
            path: [
                ([0.30, 0.31, -0.12], [0.9, -0.35, 0.1], 0.105),
                ([0.39, 0.265, -0.105], [0.85, -0.6, 0.15], 0.090),
                ([0.455, 0.195, -0.09], [0.45, -1.0, 0.15], 0.083),
                ([0.478, 0.125, -0.08], [0.15, -1.0, 0.15], 0.076),
            ],
            foot: [0.485, 0.0, -0.055],
            turn: 0.55,
        },
    );
    leg(
        b,
        &Leg {
            section: 11,
            row: 6,
            path: [
                ([0.25, 0.29, -0.56], [0.9, -0.35, 0.0], 0.125),
                ([0.345, 0.255, -0.555], [0.85, -0.6, 0.0], 0.108),
                ([0.42, 0.195, -0.55], [0.45, -1.0, 0.0], 0.090),
                ([0.447, 0.125, -0.545], [0.15, -1.0, 0.0], 0.078),
            ],
            foot: [0.455, 0.0, -0.53],
            turn: 0.75,
        },
    );
    for g in &GILLS {
        gill(b, g);
    }
}

/// Where a leg goes.
struct Leg {
    section: usize,
    row: usize,
    /// Middle, axis and radius of its rings, from the body down.
    path: [(V3, V3, f64); 4],
    /// Middle of the foot, on the ground.
    foot: V3,
    /// Direction of the foot in the plane, as an angle from z towards x.
    turn: f64,
}

fn leg(b: &mut Body, leg: &Leg) {
    let region = patch(b, leg.section, leg.row);
    let ahead = [libm::sin(leg.turn), 0.0, libm::cos(leg.turn)];
    let mut seam = Vec::new();
    let mut back = None;
    let mut all: Vec<Extrusion> = Vec::new();
    let down = [0.0, -1.0, 0.0];
    let mut rings: Vec<(V3, V3, [f64; 2])> =
        leg.path.iter().map(|&(c, a, r)| (c, a, [r; 2])).collect();
    let foot = leg.foot;
    rings.push((add(foot, [0.0, 0.072, 0.0]), down, [0.082, 0.074]));
    rings.push((add(foot, [0.0, 0.012, 0.0]), down, [0.092, 0.082]));
    for (k, &(centre, axis, radii)) in rings.iter().enumerate() {
        let own = if k + 1 == rings.len() {
            label::FOOT_RIM
        } else {
            label::LEG
        };
        let ring = Ring {
            centre,
            axis,
            side: ahead,
            radii,
        };
        all.push(b.mesh.grow(&region, &ring, |_| own));
    }
    // The chart is cut along the line that ends nearest the heel, on the inner side.
    let slab = &all[all.len() - 1];
    let heel_side = unit(add(scale(ahead, -1.0), [-0.35, 0.0, 0.0]));
    let along = |v: usize| dot(sub(b.mesh.points[v], foot), heel_side);
    for k in 0..8 {
        if back.is_none_or(|o: usize| along(slab.rim[k]) > along(slab.rim[o])) {
            back = Some(k);
        }
    }
    let back = back.unwrap_or(0);
    for e in &all {
        seam.push((e.base[back], e.rim[back]));
    }
    b.mesh.seams.extend(seam);
    for f in region {
        b.mesh.labels[f] = label::SOLE;
    }
    // Four toes out of the four sides that look ahead.
    let mut sides: Vec<(f64, usize)> = slab
        .sides
        .iter()
        .map(|&f| {
            let n = b.mesh.normal(f);
            let across = dot(n, cross([0.0, 1.0, 0.0], ahead));
            (libm::atan2(across, dot(n, ahead)), f)
        })
        .collect();
    sides.sort_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    for &(angle, f) in &sides[..4] {
        let spread = leg.turn + angle * 0.86;
        let out = [libm::sin(spread), 0.0, libm::cos(spread)];
        let long = 1.0 - 0.10 * angle.abs();
        for (reach, y, radius) in [(0.15, 0.030, 0.033), (0.222, 0.024, 0.026)] {
            let centre = add(foot, add(scale(out, reach * long), [0.0, y, 0.0]));
            let ring = Ring {
                centre,
                axis: out,
                side: [0.0, 1.0, 0.0],
                radii: [radius * 0.86, radius],
            };
            b.mesh.grow(&[f], &ring, |l| match l {
                label::LEG | label::SOLE => l,
                _ => label::FOOT_RIM,
            });
        }
    }
}

/// A gill: its root, its tip and how it bends.
pub(crate) struct Gill {
    pub(crate) root: V3,
    pub(crate) tip: V3,
    pub(crate) bend: V3,
    row: usize,
}

/// The three gills of the right side.
pub(crate) const GILLS: [Gill; 3] = [
    Gill {
        root: [0.21, 0.69, 0.13],
        tip: [0.46, 1.13, -0.06],
        bend: [0.06, -0.04, -0.10],
        row: 1,
    },
    Gill {
        root: [0.33, 0.56, 0.13],
        tip: [0.80, 0.83, -0.10],
        bend: [0.04, -0.08, -0.10],
        row: 3,
    },
    Gill {
        root: [0.36, 0.40, 0.13],
        tip: [0.80, 0.44, -0.10],
        bend: [0.02, -0.09, -0.10],
        row: 5,
    },
];

impl Gill {
    /// Point and direction at `t` along it.
    pub(crate) fn at(&self, t: f64) -> (V3, V3) {
        let d = sub(self.tip, self.root);
        let p = add(
            mix(self.root, self.tip, t),
            scale(self.bend, 4.0 * t * (1.0 - t)),
        );
        (p, unit(add(d, scale(self.bend, 4.0 - 8.0 * t))))
    }
}

fn gill(b: &mut Body, g: &Gill) {
    let f = b.face[5][g.row];
    let ahead = [0.0, 0.0, 1.0];
    let steps = [
        (0.10, 0.064),
        (0.20, 0.058),
        (0.31, 0.054),
        (0.41, 0.050),
        (0.52, 0.047),
        (0.61, 0.043),
        (0.71, 0.040),
        (0.79, 0.036),
        (0.95, 0.026),
    ];
    let mut frills = Vec::new();
    for (k, &(t, radius)) in steps.iter().enumerate() {
        let (centre, axis) = g.at(t);
        let ring = Ring {
            centre,
            axis,
            side: ahead,
            radii: [radius * 0.85, radius],
        };
        let e = b
            .mesh
            .grow(&[f], &ring, |l| if k == 0 { label::GILL_RIM } else { l });
        for &s in &e.sides {
            let n = dot(b.mesh.normal(s), ahead);
            if k == 0 && n > 0.6 {
                b.mesh.labels[s] = label::GILL_FRONT;
            } else if k == 0 && n < -0.6 {
                b.mesh.labels[s] = label::GILL_BACK;
            } else if b.mesh.labels[s] == label::GILL_RIM && k % 2 == 1 {
                frills.push((s, (t + steps[k - 1].0) / 2.0));
            }
        }
    }
    b.mesh.labels[f] = label::GILL_RIM;
    for (s, t) in frills {
        let (centre, axis) = g.at(t);
        let out = b.mesh.normal(s);
        let out = unit(sub(out, scale(axis, dot(axis, out))));
        let tip = unit(add(out, scale(axis, 0.75)));
        let long = 0.15 - 0.04 * t;
        let ring = Ring {
            centre: add(add(centre, scale(out, 0.03)), scale(tip, long)),
            axis: tip,
            side: ahead,
            radii: [0.026; 2],
        };
        b.mesh.grow(&[s], &ring, |l| match l {
            label::GILL_FRONT | label::GILL_BACK => l,
            _ => label::GILL_RIM,
        });
    }
}
