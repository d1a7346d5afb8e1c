//! Derivatives of a surface, and of its texture coordinates, at points of a face's grid.

use super::Surface;
use crate::control::Kind;
use crate::dice::control::Descend;
use crate::dice::evaluate::{self, Jet, Leaf, Place, QuadEvaluator, Row};
use crate::dice::face::Part;
use crate::dice::triangle::{TriangleEvaluator, leaf};
use crate::simd::Level;

/// Derivatives at a point; second ones are zeros where there are none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Derivatives {
    pub(super) du: [f32; 3],
    pub(super) dv: [f32; 3],
    pub(super) second: [[f32; 3]; 3],
}

impl Derivatives {
    fn of(jet: Jet, smooth: bool) -> Self {
        let second = [jet.duu.xyz(), jet.duv.xyz(), jet.dvv.xyz()];
        Self {
            du: jet.du.xyz(),
            dv: jet.dv.xyz(),
            second: if smooth { second } else { Default::default() },
        }
    }
}

/// Evaluates one channel of one face at a time; what it has made of a face is kept until the next.
#[derive(Clone, Debug, Default)]
pub(super) struct Jets {
    quad: QuadEvaluator,
    triangle: TriangleEvaluator,
    row: Option<(Part, Row)>,
    /// Depth among the control levels, and face there.
    ready: Option<(u32, u32)>,
}

impl Jets {
    /// Forgets what was prepared: other points come.
    pub(super) fn forget(&mut self) {
        self.ready = None;
    }

    /// Derivatives at column `at[0]` and row `at[1]` of a face's grid, both from 0 to 1. None of interpolating surfaces.
    pub(super) fn at<const ORDER: u32>(
        &mut self,
        surface: &Surface,
        kind: Kind,
        level: u32,
        face: u32,
        [s, t]: [f32; 2],
    ) -> Option<Derivatives> {
        let below = surface.below(kind, level, None);
        if surface.triangles {
            let root = surface.triangle_channel(kind)?;
            let (u, v) = (s - t, t);
            let found = below.as_ref().and_then(|b| leaf(b, face, u, v, true));
            let Leaf {
                channel,
                depth,
                quad,
                at,
                scale,
                tip,
                ..
            } = found.unwrap_or_else(|| whole(root, face, [u, v]));
            if self.ready != Some((depth, quad)) {
                self.triangle.prepare(channel, quad);
                self.ready = Some((depth, quad));
            }
            let found = self.triangle.at::<ORDER>(channel, at[0], at[1]);
            return Some(derivatives::<ORDER>(found, scale, tip.is_some()));
        }
        let root = surface.channel(kind, None)?;
        let found =
            (below.as_ref()).and_then(|b| evaluate::leaf(b as &dyn Descend, face, s, t, true));
        let Leaf {
            channel,
            depth,
            quad,
            at,
            scale,
            tip,
            ..
        } = found.unwrap_or_else(|| whole(root, face, [s, t]));
        if self.ready != Some((depth, quad)) {
            self.quad.prepare(channel, quad);
            self.ready = Some((depth, quad));
        }
        let found = self.quad.at::<ORDER>(channel, at[0], at[1]);
        Some(derivatives::<ORDER>(found, scale, tip.is_some()))
    }

    /// Derivatives along row `j` of a part of a face's grid. Says whether there are any.
    pub(super) fn row<const ORDER: u32>(
        &mut self,
        surface: &Surface,
        (kind, level): (Kind, u32),
        face: u32,
        (part, j): (Part, u32),
        simd: Level,
        out: &mut [Derivatives],
    ) -> bool {
        let scale = 1.0 / (1_u32 << part.level) as f32;
        let place = |i: u32, k: usize| (part.start[k] + i) as f32 * scale;
        let below = surface.below(kind, level, None);
        let is_refined = |below: &dyn Descend| {
            below
                .at(0)
                .is_some_and(|root| root.first_child(face).is_some())
        };
        if surface.triangles || below.as_ref().is_some_and(|b| is_refined(b)) {
            let t = place(j, 1);
            for (i, out) in (0..).zip(&mut *out) {
                // Above the diagonal there is nothing.
                let s = if surface.triangles {
                    place(i, 0).max(t)
                } else {
                    place(i, 0)
                };
                match self.at::<ORDER>(surface, kind, level, face, [s, t]) {
                    Some(found) => *out = found,
                    None => return false,
                }
            }
            return true;
        }
        let Some(root) = surface.channel(kind, None) else {
            return false;
        };
        if self.ready != Some((0, face)) {
            self.quad.prepare(root, face);
            self.ready = Some((0, face));
        }
        let key = Part {
            start: [part.start[0], 0],
            ..part
        };
        let row = match &mut self.row {
            Some((of, row)) if *of == key => row,
            other => {
                let columns = (0..=part.segments).map(|i| place(i, 0));
                &mut other.insert((key, Row::of_columns(columns, simd))).1
            }
        };
        self.quad.grid_row::<ORDER>(root, place(j, 1), row);
        for (i, out) in out.iter_mut().enumerate() {
            *out = Derivatives::of(row.jet(i), row.corner(i).is_none());
        }
        true
    }
}

/// The face itself is the patch.
fn whole<C>(channel: C, quad: u32, at: [f32; 2]) -> Leaf<C> {
    Leaf {
        channel,
        depth: 0,
        quad,
        at,
        scale: 1.0,
        tip: None,
        value: None,
        open: false,
    }
}

fn derivatives<const ORDER: u32>(found: Place, scale: f32, tip: bool) -> Derivatives {
    match found {
        Place::Smooth(jet) => Derivatives::of(jet.scaled::<ORDER>(scale), !tip),
        Place::Corner(jet, _) => Derivatives::of(jet.scaled::<ORDER>(scale), false),
    }
}
