//! Patches in place of the limit surface, as the surface keeps them.

use super::{PatchCage, QuadPatch, Surface};
use crate::dice::face::Sides;
use crate::math;
#[cfg(feature = "gpu")]
use crate::patch::FacePatches;
use crate::patch::PatchKind;

impl Surface {
    /// Sets the tension of every vertex under [`PatchKind::Pn`]: from 0, which leaves the surface flat around it, to 1, which is the default but at
    /// tagged corners. Means nothing to other surfaces.
    ///
    /// # Errors
    /// [`CageError`](crate::mesh::CageError) unless there is one per vertex, all of them finite.
    pub fn set_tension(&mut self, tension: &[f32]) -> Result<(), crate::mesh::CageError> {
        use crate::mesh::CageError;
        if tension.len() != self.cage.points.len() {
            return Err(CageError::WrongCount {
                what: "tensions",
                got: tension.len(),
                wanted: self.cage.points.len(),
            });
        }
        if let Some(vertex) = tension.iter().position(|t| !t.is_finite()) {
            return Err(CageError::NotFinite { vertex });
        }
        if let Some(PatchCage::Pn(pn)) = &mut self.patches {
            let tension = tension.iter().map(|&t| math::saturate(t)).collect();
            pn.set_tension(&self.mesh.base, &self.cage.points, tension);
        }
        Ok(())
    }

    /// Leaves PN triangles with the cage's own normals, which differ along creases alone: elsewhere nobody keeps sides together that move apart.
    pub(super) fn forget_given_normals(&mut self) {
        if let Some(PatchCage::Pn(pn)) = &mut self.patches {
            pn.move_points(&self.mesh.base, &self.cage.points);
        }
    }

    /// The patches that are diced in place of the limit surface.
    #[must_use]
    pub fn patch_kind(&self) -> PatchKind {
        match &self.patches {
            None => PatchKind::None,
            Some(PatchCage::Qas) => PatchKind::Qas,
            Some(PatchCage::Pn(_)) => PatchKind::Pn,
        }
    }

    /// Point and unit normal of the patches at parameter (`u`, `v`) of face `q` of [`Surface::quads`]; nothing where there are no patches or no
    /// such face. Parameters of triangles lie where v is at most u.
    #[must_use]
    pub fn patch_point(&self, q: u32, u: f32, v: f32) -> Option<([f32; 3], [f32; 3])> {
        self.patches.as_ref()?;
        if q as usize >= self.quads().face_count() {
            return None;
        }
        self.ensure(0);
        let mut patch = QuadPatch::default();
        patch.prepare_points(self, q, 0, None, Sides::Normals);
        Some(patch.patch_at(u, v))
    }

    /// Vectors that the PN triangles of one of [`Surface::quads`] are made of.
    #[cfg(feature = "gpu")]
    pub(crate) fn pn_net_len(&self) -> u32 {
        let halves = if self.triangles { 1 } else { 2 };
        halves * crate::patch::NET_LEN
    }

    /// Those of all of them; nothing where there are no PN triangles.
    #[cfg(feature = "gpu")]
    pub(crate) fn list_pn_nets(&self, out: &mut Vec<[f32; 3]>) {
        if let Some(PatchCage::Pn(cage)) = &self.patches {
            let (t, points) = (&self.mesh.base, &self.cage.points);
            let mut patches = FacePatches::default();
            for q in 0..self.quads().face_count() as u32 {
                patches.take(cage, t, points, q, self.is_split(), 0);
                patches.list_nets(out);
            }
        }
    }
}
