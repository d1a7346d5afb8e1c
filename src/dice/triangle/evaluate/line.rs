//! Derivatives along lines of a triangle, in lanes.

use super::super::patch::TriangleChannel;
use super::quartic::Curve;
use super::{Spot, TriangleEvaluator, corner};
use crate::dice::evaluate::{F4, Jet, Place};
use crate::dispatch;
use crate::records::{BLOCK_STRIDE, Grid3};
use crate::simd::{LANES, Level};

/// Derivatives of a block of points, component by component: by u, by v, and the second ones.
pub(crate) struct JetLines<'a> {
    pub(crate) first: [&'a mut Grid3; 2],
    /// Not wanted of first order.
    pub(crate) second: Option<[&'a mut Grid3; 3]>,
}

impl JetLines<'_> {
    /// Derivatives at place `k`.
    pub(crate) fn put(&mut self, k: usize, jet: &Jet) {
        for (out, d) in self.first.iter_mut().zip([jet.du, jet.dv]) {
            out.put(k, d.xyz());
        }
        if let Some(second) = &mut self.second {
            for (out, d) in second.iter_mut().zip([jet.duu, jet.duv, jet.dvv]) {
                out.put(k, d.xyz());
            }
        }
    }

    /// Those along a curve at the parameters `u`, from place `at` on.
    #[inline(always)]
    fn fill(&mut self, curve: &Curve, u: &[f32], scales: [f32; 2], at: usize) {
        let part = at..at + u.len();
        let [du, dv] = &mut self.first;
        curve.first(
            0,
            u,
            scales,
            &mut du.x[part.clone()],
            &mut dv.x[part.clone()],
        );
        curve.first(
            1,
            u,
            scales,
            &mut du.y[part.clone()],
            &mut dv.y[part.clone()],
        );
        curve.first(
            2,
            u,
            scales,
            &mut du.z[part.clone()],
            &mut dv.z[part.clone()],
        );
        let Some([uu, uv, vv]) = &mut self.second else {
            return;
        };
        let (a, b, c) = (
            &mut uu.x[part.clone()],
            &mut uv.x[part.clone()],
            &mut vv.x[part.clone()],
        );
        curve.second(0, u, scales, a, b, c);
        let (a, b, c) = (
            &mut uu.y[part.clone()],
            &mut uv.y[part.clone()],
            &mut vv.y[part.clone()],
        );
        curve.second(1, u, scales, a, b, c);
        let (a, b, c) = (
            &mut uu.z[part.clone()],
            &mut uv.z[part.clone()],
            &mut vv.z[part],
        );
        curve.second(2, u, scales, a, b, c);
    }
}

impl TriangleEvaluator {
    /// Derivatives at the places `us` of a line of constant `v`, by parameters `scale` times as fast, from place `at` of `out` on: those of
    /// [`TriangleEvaluator::at`], bit for bit. Whole vectors are written: what is beyond the line means nothing.
    pub(crate) fn line<const ORDER: u32>(
        &mut self,
        channel: TriangleChannel<'_>,
        (us, v): (&[f32], f32),
        scale: f32,
        simd: Level,
        (out, at): (&mut JetLines<'_>, usize),
    ) {
        let mut u = [0.0; BLOCK_STRIDE];
        if !self.irregular {
            let Some(patch) = self.patches.first() else {
                return;
            };
            u[..us.len()].copy_from_slice(us);
            let u = &u[..us.len().next_multiple_of(LANES)];
            let curve = patch.curve::<ORDER>(v);
            dispatch!(simd, out.fill(&curve, u, [1.0, scale], at));
            return;
        }
        let mut first = 0;
        while let Some(&start) = us.get(first) {
            let spot = Spot::new(&self.regular, start, v);
            let mut count = 0;
            for &next in &us[first..] {
                let next = Spot::new(&self.regular, next, v);
                if next.slot != spot.slot || next.at[1] != spot.at[1] {
                    break;
                }
                u[count] = next.at[0];
                count += 1;
            }
            match self.patch(channel, spot.slot) {
                Some(patch) => {
                    let curve = patch.curve::<ORDER>(spot.at[1]);
                    u[count..].fill(0.0);
                    let u = &u[..count.next_multiple_of(LANES)];
                    dispatch!(simd, out.fill(&curve, u, [spot.scale, scale], at + first));
                }
                None => {
                    // A corner is one point.
                    count = 1;
                    if let Place::Corner(jet, _) = corner::<ORDER>(channel, self.face, spot.slot) {
                        let zero = F4::splat(0.0);
                        let jet = Jet {
                            duu: zero,
                            duv: zero,
                            dvv: zero,
                            ..jet
                        };
                        out.put(at + first, &jet.scaled::<ORDER>(scale));
                    }
                }
            }
            first += count.max(1);
        }
    }
}
