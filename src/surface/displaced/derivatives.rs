//! Derivatives as displacement wants them: of linear faces, by differences on grids, and of the surface by texture coordinates.

use super::layout::Layout;
use crate::dice::face::Part;
use crate::displace::Jets;
use crate::displace::normal::Bend;
use crate::math;
use crate::records::Grid3;
use crate::surface::Surface;
use crate::surface::jets::Derivatives;
use std::ops::Range;

pub(super) fn bend(d: &Derivatives) -> Bend {
    Bend {
        du: d.du,
        dv: d.dv,
        second: d.second,
    }
}

pub(super) fn two([u, v, _]: [f32; 3]) -> [f32; 2] {
    [u, v]
}

pub(super) fn uv_by(d: &Derivatives) -> [[f32; 2]; 2] {
    [two(d.du), two(d.dv)]
}

/// Texture coordinates that are linear between the corners.
pub(in crate::surface) fn linear_at(
    c: &[[f32; 3]; 4],
    triangle: bool,
    [s, t]: [f32; 2],
) -> [f32; 3] {
    let at = |k: usize| {
        if triangle {
            // Above the diagonal, everything is folded onto it.
            let t = t.min(s);
            return (c[0][k] * (1.0 - s) + c[1][k] * (s - t)) + c[2][k] * t;
        }
        (c[0][k] * (1.0 - s) + c[1][k] * s) * (1.0 - t) + (c[3][k] * (1.0 - s) + c[2][k] * s) * t
    };
    [at(0), at(1), 0.0]
}

pub(in crate::surface) fn linear_derivatives(
    surface: &Surface,
    face: u32,
    triangle: bool,
    [s, t]: [f32; 2],
) -> Derivatives {
    let corners = surface.linear_corners(face);
    corners.map_or_else(Derivatives::default, |c| linear_of(&c, triangle, [s, t]))
}

fn linear_of(c: &[[f32; 3]; 4], triangle: bool, [s, t]: [f32; 2]) -> Derivatives {
    let along = |a: usize, b: usize| [0, 1, 2].map(|k| c[b][k] - c[a][k]);
    let mix = |a: [f32; 3], b: [f32; 3], t: f32| [0, 1, 2].map(|k| a[k] * (1.0 - t) + b[k] * t);
    let (du, dv) = match triangle {
        // By the weights of corners 1 and 2, as everything of triangles.
        true => (along(0, 1), along(0, 2)),
        false => (
            mix(along(0, 1), along(3, 2), t),
            mix(along(0, 3), along(1, 2), s),
        ),
    };
    Derivatives {
        du,
        dv,
        ..Derivatives::default()
    }
}

/// What normals at a corner are made of, from the derivatives of the surface and of texture coordinates: where the surface has tangents of its own,
/// by those.
pub(super) fn at_corner(found: Derivatives, by: Option<Derivatives>) -> [Derivatives; 2] {
    let Some(own) = found.flat else {
        return [found, by.unwrap_or_default()];
    };
    let first = |[du, dv]: [[f32; 3]; 2]| Derivatives {
        du,
        dv,
        ..Derivatives::default()
    };
    let by = by.map(|by| first(by.flat.unwrap_or_else(|| upright(&found, &by))));
    [first(own), by.unwrap_or_default()]
}

/// Derivatives by the parameters of a flat corner's tangents of texture coordinates that are cut otherwise there, which change along both
/// derivatives of the surface: along the first tangent, and where the surface stands still much more than along the second. What moves by them
/// stands upright.
pub(in crate::surface) fn upright(surface: &Derivatives, by: &Derivatives) -> [[f32; 3]; 2] {
    const MORE: f32 = (1 << 14) as f32;
    let Some([along, _]) = surface.flat else {
        return [by.du, by.dv];
    };
    let square = math::dot(along, along);
    let [a, b] = [surface.du, surface.dv].map(|d| math::dot(d, along) / square);
    let both = a * a + b * b;
    if !(both > 0.0 && both.is_finite()) {
        return [[0.0; 3]; 2];
    }
    let mix = |s: f32, t: f32| math::add(math::scale(by.du, s), math::scale(by.dv, t));
    [mix(a / both, b / both), mix(-b * MORE, a * MORE)]
}

/// Derivatives of linear texture coordinates along a row of a part, from place `at` of `out` on.
pub(super) fn linear_rows(
    corners: &[[f32; 3]; 4],
    triangle: bool,
    (part, j, columns): (Part, u32, Range<u32>),
    (out, at): (&mut Jets, usize),
) {
    let scale = 1.0 / (1_u32 << part.level) as f32;
    let t = (part.start[1] + j) as f32 * scale;
    for (k, i) in (at..).zip(columns) {
        let s = (part.start[0] + i) as f32 * scale;
        linear_of(corners, triangle, [s, t]).put::<1>(out, k);
    }
}

/// Derivatives of surfaces that have no formula: differences of the packed grid, along row `j`.
pub(super) fn differences(layout: Layout, grid: &Grid3, j: usize, out: &mut Jets) {
    let last = layout.rows().end - 1;
    let step = |k: usize| (k.saturating_sub(1), (k + 1).min(last));
    let get = |i: usize, j: usize| grid.at(layout.place([i, j]));
    for i in layout.columns(j) {
        let ((i0, i1), (j0, j1)) = (step(i), step(j));
        let between = |a: [f32; 3], b: [f32; 3], steps: usize| {
            [0, 1, 2].map(|k| (b[k] - a[k]) / steps.max(1) as f32)
        };
        let found = Derivatives {
            du: between(get(i0, j), get(i1, j), i1 - i0),
            dv: between(get(i, j0), get(i, j1), j1 - j0),
            ..Derivatives::default()
        };
        found.put::<2>(out, layout.place([i, j]));
    }
}
