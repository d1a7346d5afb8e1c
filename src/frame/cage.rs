//! Polygons of a cage as they are given, laid out as blocks: every cell has four points of its own in the block's grid, so that corners may have
//! what they like, and the micro-quads between them are not drawn.

use super::attributes::Attributes;
use super::scene::{Object, Scene};
use super::source::CORNERS;
use crate::Cage;
use crate::records::Grid3;
use crate::surface::{MOST_CELLS, PolygonBlock, PolygonBlocks, cell_places};
use std::borrow::Cow;

/// The blocks of an object's cage. `apart`: every polygon is a block.
pub(super) fn blocks<'a>(scene: &Scene, object: &'a Object, apart: bool) -> Cow<'a, PolygonBlocks> {
    let surface = &object.surface;
    if apart {
        return Cow::Owned(PolygonBlocks::new(
            surface.cage(),
            surface.topology(),
            |_| 1,
        ));
    }
    // A sample keeps few layers of a block with an opacity map.
    let most = |material: u32| {
        let found = scene.materials.get(object.material_of(material) as usize);
        match found.is_some_and(|m| m.opacity_map.is_some()) {
            true => 1,
            false => MOST_CELLS,
        }
    };
    let materials = 0..surface.cage().materials().len() as u32;
    if materials.clone().all(|m| most(m) == MOST_CELLS) {
        Cow::Borrowed(surface.polygon_blocks())
    } else {
        Cow::Owned(PolygonBlocks::new(surface.cage(), surface.topology(), most))
    }
}

/// Lays out points of a block, and what shading needs where asked for.
pub(super) fn dice(
    cage: &Cage,
    all: &PolygonBlocks,
    block: &PolygonBlock,
    points: &mut Grid3,
    attributes: Option<&mut Attributes>,
) {
    for ((x, y), corners) in cell_places().zip(all.corners(block)) {
        for (c, (i, j)) in corners.into_iter().zip(CORNERS) {
            let vertex = cage.corner_vertices[c as usize];
            points.set(x + i, y + j, cage.points[vertex as usize]);
        }
    }
    // What is left of the last row shows nothing.
    let size = block.size();
    if let Some(rest) = block.rest() {
        let p = points.get(2 * rest - 1, size.rows - 1);
        for j in [size.rows - 2, size.rows - 1] {
            (2 * rest..size.cols).for_each(|i| points.set(i, j, p));
        }
    }
    let Some(a) = attributes else { return };
    a.has_tangents = false;
    a.has_uvs = a.wants_uvs && !cage.corner_uvs.is_empty();
    a.has_colors = !cage.colors.is_empty();
    for ((x, y), corners) in cell_places().zip(all.corners(block)) {
        for (c, (i, j)) in corners.into_iter().zip(CORNERS) {
            a.set_corner((x + i, y + j), cage, c);
        }
    }
}
