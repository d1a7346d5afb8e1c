//! Sides of a displaced face sample by sample, for who looks at edges.

use super::DisplacedPatch;
use super::derivatives::two;
use crate::records::BLOCK_POINTS;
use crate::surface::Surface;

impl DisplacedPatch {
    /// Displaces the samples of side `c` in place; `uvs` are its texture coordinates if they are read.
    pub(in crate::surface) fn displace_side(
        &mut self,
        surface: &Surface,
        c: usize,
        points: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
        uvs: &[[f32; 3]],
    ) {
        let Some(on) = self.on.clone() else { return };
        let n = points.len() - 1;
        let next = (c + 1) % self.corners().len();
        let mut work = self.work.take().unwrap_or_default();
        for first in (0..=n).step_by(BLOCK_POINTS) {
            let count = BLOCK_POINTS.min(n + 1 - first);
            for (i, k) in (first..first + count).enumerate() {
                let rim = &self.rims[c];
                let corner = if k == 0 {
                    Some(c)
                } else {
                    (k == n).then_some(next)
                };
                let (uv, direction) = match corner.map(|c| &self.corners[c]) {
                    Some(corner) => (Some(corner.uv), corner.direction),
                    None => {
                        let uv = rim.uvs.get(k).or(uvs.get(k));
                        (uv.copied(), rim.directions.get(k).copied())
                    }
                };
                work.limits.put(i, points[k]);
                work.uvs.put(i, uv.unwrap_or_default());
                work.directions.put(i, direction.unwrap_or(normals[k]));
            }
            work.points.clone_from(&work.limits);
            on.displacement.all(
                (self.simd, count),
                &mut work.points,
                &work.directions,
                &work.uvs,
                true,
                &mut work.heights,
            );
            for (i, k) in (first..first + count).enumerate() {
                let (position, normal) = (points[k], normals[k]);
                points[k] = work.points.at(i);
                if work.directions.at(i) == [0.0; 3] {
                    continue;
                }
                let height = work.heights.values[i];
                let corner = if k == 0 {
                    Some(c)
                } else {
                    (k == n).then_some(next)
                };
                if let Some(corner) = corner {
                    let jets = &mut work.owners[corner];
                    let found = self.corner_normal(
                        surface,
                        &on,
                        (corner, jets),
                        (position, normal),
                        height,
                    );
                    normals[k] = found.unwrap_or(normal);
                    continue;
                }
                let rim = &self.rims[c];
                let own = surface.halves_of(self.face).start + c as u32;
                let at_owner = !rim.own && !rim.crease;
                let (half, at) = if at_owner {
                    (rim.owner, n - k)
                } else {
                    (own, k)
                };
                let uv = match (rim.crease, uvs.get(k)) {
                    (true, Some(&uv)) => two(uv),
                    _ => two(work.uvs.at(i)),
                };
                let place = self.place_of(surface, half, at as u32);
                if let Some(around) =
                    self.around(surface, &mut work.others[c], place, (position, normal, uv))
                {
                    let slope = on.displacement.slope_at(position, uv).1;
                    normals[k] = on.displacement.normal(&around, height, slope);
                }
            }
        }
        self.work = Some(work);
    }
}
