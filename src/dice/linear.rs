//! Bilinear patches: the surface of the bilinear scheme, as B-splines whose control points lie on the patch.
//!
//! A cubic B-spline reproduces linear functions, so the net that continues the patch by its own slopes evaluates to it, and all that dices
//! B-splines dices this too. Sides are walked from the lower to the higher vertex number; normals are each face's own, for the surface
//! has creases along all edges.

use super::face::{Channel, FacePatch, Sides};
use super::net::Net;
use super::point::P4;

/// The patch over corners `c` at column `i` and row `j` of its net.
fn at(c: [P4; 4], i: usize, j: usize) -> P4 {
    let (s, t) = (i as f32 - 1.0, j as f32 - 1.0);
    let low = c[0] * (1.0 - s) + c[1] * s;
    let high = c[3] * (1.0 - s) + c[2] * s;
    low * (1.0 - t) + high * t
}

/// The net of quad `q`.
pub(super) fn net(channel: Channel<'_>, q: u32) -> Net<4> {
    let vertex = |c: usize| channel.topology.vertex(4 * q + c as u32);
    let corners = std::array::from_fn(|c| P4::new(channel.points[vertex(c) as usize]));
    std::array::from_fn(|j| std::array::from_fn(|i| at(corners, i, j)))
}

impl FacePatch {
    /// Prepares quad `q` as a bilinear patch.
    pub(super) fn prepare_linear(&mut self, channel: Channel<'_>, q: u32) {
        let t = channel.topology;
        let corners: [P4; 4] =
            std::array::from_fn(|c| P4::new(channel.points[t.vertex(4 * q + c as u32) as usize]));
        let middle = (corners[2] - corners[0]).cross(corners[3] - corners[1]);
        for c in 0..4 {
            let (before, next) = (corners[(c + 3) % 4], corners[(c + 1) % 4]);
            let normal = (next - corners[c]).cross(before - corners[c]);
            let unit = normal.unit().or_else(|| middle.unit());
            self.corners[c].1 = unit.map_or([0.0, 0.0, 1.0], P4::xyz);
        }
        if self.level == 0 {
            return;
        }
        let sheet = self.sheets.add();
        for (j, row) in sheet.net[..4].iter_mut().enumerate() {
            for (i, p) in row[..4].iter_mut().enumerate() {
                *p = at(corners, i, j);
            }
        }
        sheet.be_whole(self.level);
        self.regular = Some(0b1111);
        if self.wanted <= Sides::None {
            return;
        }
        self.whole = 0b1111;
        for c in 0..4 {
            let (mut a, mut b) = (corners[c], corners[(c + 1) % 4]);
            if c > 1 {
                (a, b) = (b, a);
            }
            self.polygons[c] = Some([P4::beyond(a, b), a, b, P4::beyond(b, a)]);
        }
    }
}
