//! What holds a quad and its parts: points whose convex hull does, or corners of a box where displacement moves them.

use super::Surface;
use super::channel_patch::By;
use super::patch::QuadPatch;
use crate::dice::face::Part;
use crate::math;

impl QuadPatch {
    /// Corners of a box that holds a part wherever it is displaced, which must be prepared for that.
    pub(crate) fn displaced_hull(
        &self,
        surface: &Surface,
        part: Part,
        mut out: impl FnMut([f32; 3]),
    ) {
        let [mut low, mut high] = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        self.points.part_hull(part, |p| {
            low = [0, 1, 2].map(|k| low[k].min(p[k]));
            high = [0, 1, 2].map(|k| high[k].max(p[k]));
        });
        let far = [[-self.reach; 3], [self.reach; 3]];
        let [down, up] = self.moves(surface, part).unwrap_or(far);
        let slack = 1e-4 * self.reach;
        low = [0, 1, 2].map(|k| low[k] + down[k] - slack);
        high = [0, 1, 2].map(|k| high[k] + up[k] + slack);
        math::box_corners(low, high).for_each(&mut out);
    }

    /// Bounds of the vectors by which the points of a part move, if more is known than how long they are at most.
    fn moves(&self, surface: &Surface, part: Part) -> Option<[[f32; 3]; 2]> {
        let displacement = surface.displacement()?;
        let kept = self.displaced.borrow();
        let patch = kept.as_deref()?;
        let elsewhere = patch.plain_corners(surface, part)?;
        let normals = match self.points.by {
            By::Triangle => self.points.triangle.part_normals(part)?,
            By::Quad | By::Table | By::Patches => return None,
        };
        let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        let mut hold = |uv: [f32; 3]| {
            low = [0, 1].map(|k| low[k].min(uv[k]));
            high = [0, 1].map(|k| high[k].max(uv[k]));
        };
        if patch.reads_uvs() {
            match &self.linear {
                Some(of) => of.iter().for_each(|&uv| hold(uv)),
                None => self.uvs.part_hull(part, &mut hold),
            }
            elsewhere.into_iter().for_each(hold);
        }
        let heights = displacement.heights_in([low, high])?;
        let mut out = [[0.0; 3]; 2];
        for k in 0..3 {
            let all = [0, 1, 2, 3].map(|c| heights[c & 1] * normals[c >> 1][k]);
            out[0][k] = all[1..].iter().fold(all[0], |x, &y| x.min(y));
            out[1][k] = all[1..].iter().fold(all[0], |x, &y| x.max(y));
        }
        Some(out)
    }

    /// Points whose convex hull holds a part.
    pub(crate) fn part_hull(&self, part: Part, mut out: impl FnMut([f32; 3])) {
        let mut hull = Hull::new(self.reach);
        self.points.part_hull(part, |p| hull.add(p, &mut out));
        hull.finish(&mut out);
    }

    /// The same of the whole quad.
    pub(crate) fn hull(&self, mut out: impl FnMut([f32; 3])) {
        let mut hull = Hull::new(self.reach);
        self.points.hull(|p| hull.add(p, &mut out));
        hull.finish(&mut out);
    }
    /// The same of a block.
    pub(crate) fn block_hull(&self, bu: u32, bv: u32, mut out: impl FnMut([f32; 3])) {
        let mut hull = Hull::new(self.reach);
        self.points.block_hull(bu, bv, |p| hull.add(p, &mut out));
        hull.finish(&mut out);
    }
}

/// Points of a hull as they are, or of displaced ones the corners of their box, grown by as far as points move.
struct Hull {
    reach: f32,
    low: [f32; 3],
    high: [f32; 3],
}

impl Hull {
    fn new(reach: f32) -> Self {
        Self {
            reach,
            low: [f32::INFINITY; 3],
            high: [f32::NEG_INFINITY; 3],
        }
    }

    fn add(&mut self, p: [f32; 3], out: &mut impl FnMut([f32; 3])) {
        if self.reach == 0.0 {
            return out(p);
        }
        self.low = [0, 1, 2].map(|k| self.low[k].min(p[k] - self.reach));
        self.high = [0, 1, 2].map(|k| self.high[k].max(p[k] + self.reach));
    }

    fn finish(&self, out: &mut impl FnMut([f32; 3])) {
        if self.reach == 0.0 || self.low[0] > self.high[0] {
            return;
        }
        math::box_corners(self.low, self.high).for_each(out);
    }
}
