//! Level 0 of cages with other polygons than quads: faces of four corners are blocks of one micro-quad between limit points, other polygons
//! one for each corner, with the centre.

use super::Surface;

impl Surface {
    /// Whether a level is drawn as polygons between limit points.
    pub(crate) fn is_polygonal(&self, level: u32) -> bool {
        level == 0 && self.is_split() && self.displacement().is_none()
    }

    /// Whether a quad of a polygonal level is drawn: the first alone of a face of four corners.
    pub(crate) fn stands_for_face(&self, quad: u32) -> bool {
        let corners = self.topology().face_halves(self.cage_face(quad));
        corners.len() != 4 || corners.start == quad
    }

    /// Half-edges of the quads, whose first corners are those of the block that a quad of a polygonal level is drawn as. Triangles repeat
    /// the centre.
    pub(crate) fn polygon_block(&self, quad: u32) -> [u32; 4] {
        let base = self.topology();
        let next = base.next(quad);
        if base.face_halves(self.cage_face(quad)).len() == 4 {
            let third = base.next(next);
            return [quad, next, third, base.next(third)].map(|h| 4 * h);
        }
        let centre = 4 * quad + 2;
        [4 * quad, 4 * next, centre, centre]
    }
}
