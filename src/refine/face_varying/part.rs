//! Values of a part of a level.

use super::super::restrict::{Renumbered, compact};
use super::{FaceVarying, Sibling};
use crate::refine::real::Real;
use crate::topology::NONE;

impl<T: Real> FaceVarying<T> {
    /// The values of the part that consists of `corners`; `new_corner` says where each went. Siblings at the rim that have lost an end of
    /// their span are left out: nothing that follows from them is used. Also gives the old number of every value.
    pub(in crate::refine) fn part(
        &self,
        corners: &[u32],
        new_corner: &Renumbered,
    ) -> (Self, Vec<u32>) {
        let value = |&h: &u32| self.corners[h as usize];
        let (old_values, new_value) = compact(self.values.len(), corners.iter().map(value));
        let new_corners: Vec<u32> = corners.iter().map(|h| new_value.get(value(h))).collect();
        let mut value_corners = vec![NONE; old_values.len()];
        for (h, &v) in new_corners.iter().enumerate().rev() {
            value_corners[v as usize] = h as u32;
        }
        // Both lists are in the order of values.
        let siblings = (0..).zip(&old_values).filter_map(|(value, old)| {
            let found = self.siblings.binary_search_by_key(old, |s| s.value);
            let s = &self.siblings[found.ok()?];
            let ends = [s.first, s.last].map(|h| new_corner.get(h));
            (!ends.contains(&NONE)).then_some(Sibling {
                value,
                first: ends[0],
                last: ends[1],
                kind: s.kind,
            })
        });
        let part = Self {
            values: old_values
                .iter()
                .map(|&v| self.values[v as usize])
                .collect(),
            siblings: siblings.collect(),
            corners: new_corners,
            value_corners,
            missing: Vec::new(),
            rule: self.rule,
            linear: self.linear,
        };
        (part, old_values)
    }
}
