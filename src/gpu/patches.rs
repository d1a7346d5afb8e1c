//! Patches: what quadratic ones run through, and the curves that points of sides of displaced patches stand on.

use super::chunk::Builder;
use super::dicer::{Dicer, Shown};
use super::error::GpuError;
use super::face::{rim_place, spot};
use super::owners::Owners;
use super::records::Lift;
use super::wgsl::pn_place;

/// See [`Lift::curve`].
pub(super) type Curve = [u32; 4];

/// A side of a displaced patch.
#[derive(Clone, Copy)]
pub(super) enum SideCurve {
    /// Spots of the first end, of the middle and of the last end, as the positions' owner walks it.
    Qas([u32; 3]),
    /// PN triangles: whose points and whose normals.
    Pn(Owners),
}

impl SideCurve {
    /// Its point: as the positions' owner walks it, and as the normals' owner does.
    pub(super) fn at(self, dicer: &Dicer<'_>, [k, own]: [u32; 2], level: u32) -> Curve {
        let count = dicer.corner_count();
        match self {
            Self::Qas([a, m, b]) => [a, m, b, pn_place([k, 0], level)],
            Self::Pn(owners) => {
                let place = |h: u32, k: u32| {
                    let at = dicer.along(h % count, k, 1 << level);
                    dicer.net_place(h / count, at, level)
                };
                let ([p, at], [n, to]) = (place(owners.position, k), place(owners.normal, own));
                [p, at, n, to]
            }
        }
    }
}

impl Dicer<'_> {
    /// Where the control points of a quad's PN triangles stand, and a place on the grid of `level`.
    pub(super) fn net_place(&self, quad: u32, at: [u32; 2], level: u32) -> [u32; 2] {
        [self.net(quad), pn_place(at, level)]
    }
}

impl Builder {
    /// What patches have of their own: the spot in the middle of a quad, or where control points stand.
    pub(super) fn middle(&mut self, dicer: &Dicer<'_>, quad: u32) -> Result<u32, GpuError> {
        if dicer.shown == Shown::Pn {
            return Ok(dicer.net(quad));
        }
        if dicer.shown != Shown::Qas || dicer.surface.is_triangular() {
            return Ok(0);
        }
        let there = &mut self.there.base;
        let table = dicer.base_table(quad)?;
        let stencil = (self.data).stencil(there, dicer, quad, table, false);
        // In the middle of three rows of three.
        Ok(self.base_spot(dicer, [[stencil, 4]; 2]))
    }

    /// A spot that stays where it is: the stencil and the point of its position and of its normal.
    fn base_spot(&mut self, dicer: &Dicer<'_>, places: [[u32; 2]; 2]) -> u32 {
        self.data.spots.push(spot(places));
        if dicer.is_displaced() {
            self.data.lifts.push(Lift {
                held: 1,
                ..Lift::default()
            });
        }
        self.data.spots.len() as u32 - 1
    }

    /// Stencil and point of level 1: point `k` of two on the side that is half-edge `h`.
    fn base_place(&mut self, dicer: &Dicer<'_>, h: u32, k: u32) -> Result<[u32; 2], GpuError> {
        let count = dicer.corner_count();
        let (quad, at) = (h / count, dicer.along(h % count, k, 2));
        let index = rim_place(dicer, at, 1, 1)?;
        let there = &mut self.there.base_rims;
        let table = dicer.base_table(quad)?;
        Ok([(self.data).stencil(there, dicer, quad, table, true), index])
    }

    /// The spot at the corner that half-edge `h` begins with.
    pub(super) fn base_corner(&mut self, dicer: &Dicer<'_>, h: u32) -> Result<u32, GpuError> {
        let owners = dicer.corner_owners(h);
        if let Some(&found) = self.there.base_corners.get(&owners.normal) {
            return Ok(found);
        }
        let position = self.base_place(dicer, owners.position, 0)?;
        let normal = self.base_place(dicer, owners.normal, 0)?;
        let normal = self.corner_normal(dicer, h, normal);
        let at = self.base_spot(dicer, [position, normal]);
        self.there.base_corners.insert(owners.normal, at);
        Ok(at)
    }

    /// The spot in the middle of the side that is half-edge `h`.
    pub(super) fn base_side(&mut self, dicer: &Dicer<'_>, h: u32) -> Result<u32, GpuError> {
        let owners = dicer.side_owners(h);
        if let Some(&found) = self.there.base_sides.get(&owners.normal) {
            return Ok(found);
        }
        let position = self.base_place(dicer, owners.position, 1)?;
        let normal = self.base_place(dicer, owners.normal, 1)?;
        let at = self.base_spot(dicer, [position, normal]);
        self.there.base_sides.insert(owners.normal, at);
        Ok(at)
    }

    /// Where a corner of a displaced patch stands; nothing of other surfaces.
    pub(super) fn corner_curve(
        &mut self,
        dicer: &Dicer<'_>,
        h: u32,
        owners: Owners,
    ) -> Result<Option<Curve>, GpuError> {
        if !dicer.lifts_patches() {
            return Ok(None);
        }
        if dicer.shown == Shown::Pn {
            return Ok(Some(SideCurve::Pn(owners).at(dicer, [0; 2], 0)));
        }
        let at = self.base_corner(dicer, h)?;
        Ok(Some(SideCurve::Qas([at; 3]).at(dicer, [0; 2], 0)))
    }

    /// What the points of the side that is half-edge `h` stand on, of a displaced patch.
    pub(super) fn side_curve(
        &mut self,
        dicer: &Dicer<'_>,
        h: u32,
        owners: Owners,
    ) -> Result<Option<SideCurve>, GpuError> {
        if !dicer.lifts_patches() {
            return Ok(None);
        }
        if dicer.shown == Shown::Pn {
            return Ok(Some(SideCurve::Pn(owners)));
        }
        let whole = dicer.surface.whole_quads();
        let [a, b] = [
            self.base_corner(dicer, h)?,
            self.base_corner(dicer, whole.next(h))?,
        ];
        let middle = self.base_side(dicer, h)?;
        let same = whole.vertex(owners.position) == whole.vertex(h);
        Ok(Some(SideCurve::Qas(match same {
            true => [a, middle, b],
            false => [b, middle, a],
        })))
    }

    /// The curves whose normals that of a corner is the mitre of. What they run through has to be there before the spot of the corner.
    pub(super) fn mitred_corners(
        &mut self,
        dicer: &Dicer<'_>,
        mitred: &[u32],
    ) -> Result<Vec<Curve>, GpuError> {
        let mut out = Vec::new();
        for &h in mitred {
            out.extend(self.corner_curve(dicer, h, Owners::own(h))?);
        }
        Ok(out)
    }

    /// The same of a side's points.
    pub(super) fn mitred_curves(
        &mut self,
        dicer: &Dicer<'_>,
        mitred: &[u32],
        position: u32,
        [k, level]: [u32; 2],
    ) -> Result<Vec<Curve>, GpuError> {
        let mut out = Vec::new();
        for &h in mitred {
            // Each walks its own way.
            let own = Owners::own(h);
            let k = if h == position { k } else { (1 << level) - k };
            let curve = self.side_curve(dicer, h, own)?;
            out.extend(curve.map(|curve| curve.at(dicer, [k; 2], level)));
        }
        Ok(out)
    }
}
