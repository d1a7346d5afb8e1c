//! Normals of corners that no face tells by its own derivatives: those of the ring of faces around.
//!
//! Where the surface stays at its control point, its tangents there are the two ends of the ring between creases (by convention: from three
//! faces on there is no tangent plane); a sharp point without creases has the mean of its faces' normals. Where tangents have one direction, as where two ends of a ring lie at one place, the ring's area is left.

use super::chunk::Builder;
use super::dicer::Dicer;
use super::error::GpuError;
use super::surroundings::Finder;
use super::tables::NO_WEIGHTS;
use super::wgsl::{RING_AREA, RING_ENDS, RING_MEAN, RINGED};
use crate::dice::fan_points;
use crate::dice::tangent_masks::TangentMasks;
use crate::dice::triangle::{self, TriangleMasks};
use crate::limits::Budget;
use crate::scheme::Scheme;
use crate::surface::Surface;
use crate::topology::{FanRule, NONE, Ring, Topology};
use std::collections::HashMap;

/// By fan of the quads, what the device makes its normal of: how many faces there are and by which rule, then points, that of the vertex first.
/// Every point is a number of terms, and for each a control point of the surface and its weight.
pub(super) type Rings = HashMap<u32, Vec<u32>>;

/// Those of a surface. They are chosen by the points that it has.
pub(super) fn rings(surface: &Surface, budget: &mut Budget<'_>) -> Result<Rings, GpuError> {
    let mut out = Rings::new();
    let (t, points) = (surface.quads(), surface.control_points());
    let triangles = match surface.scheme() {
        Scheme::CatmullClark => false,
        Scheme::Loop => true,
        _ => return Ok(out),
    };
    let (of_quads, of_triangles) = match triangles {
        true => (None, Some(TriangleMasks::new(t))),
        false => (Some(TangentMasks::new(t)), None),
    };
    let has_no_plane = |id: u32| match (&of_quads, &of_triangles) {
        (Some(masks), _) => fan_points::has_no_plane(t, masks, points, id),
        (_, Some(masks)) => triangle::has_no_plane(t, masks, points, id),
        _ => false,
    };
    let finder = (surface.is_split()).then(|| Finder::new(surface));
    for (id, fan) in (0..).zip(t.fans()) {
        let is_corner = fan.rule == FanRule::Corner;
        if fan.first == NONE || is_corner && fan.faces == 1 || !is_corner && !has_no_plane(id) {
            continue;
        }
        let rule = match (is_corner, fan.closed) {
            (false, _) => RING_AREA,
            (true, true) => RING_MEAN,
            (true, false) => RING_ENDS,
        };
        budget.limits().check()?;
        let points = match &finder {
            Some(finder) => split_ring(finder, surface, fan.first)?,
            None => ring(surface, id),
        };
        let mut words = vec![fan.faces << 2 | rule];
        words.extend(points);
        let bytes = 4 * words.len() as u128;
        budget.take("the corners of the GPU backend", bytes, 0)?;
        out.insert(id, words);
    }
    Ok(out)
}

/// The points of a fan's ring, that of the fan first and the first neighbour once more at the end of a closed one.
fn ring(surface: &Surface, id: u32) -> Vec<u32> {
    let (own, ends) = halves(surface.quads(), id);
    let cage = surface.topology();
    let all = std::iter::once(own).chain(ends);
    all.flat_map(|h| [1, cage.vertex(h), 1.0_f32.to_bits()])
        .collect()
}

/// A half-edge that leaves a fan's vertex, and others that leave its neighbours.
fn halves(t: &Topology, id: u32) -> (u32, Vec<u32>) {
    let all: Vec<u32> = Ring::of_fan(t, id).collect();
    let last = all.last().map(|&h| t.prev(h));
    let ends = all.iter().map(|&h| t.next(h)).chain(last);
    (t.fans()[id as usize].first, ends.collect())
}

/// The same of a mesh that is split into quads, whose points are sums: those of unit vectors tell what of. `h` begins with the fan's vertex.
fn split_ring(finder: &Finder<'_>, surface: &Surface, h: u32) -> Result<Vec<u32>, GpuError> {
    let face = surface.cage_face(h / 4);
    let found = finder.find(face);
    let mut local = found.surface(surface);
    // The face's quads come first.
    let h = h - 4 * surface.topology().face_halves(face).start;
    let t = local.quads();
    let (own, ends) = halves(t, t.fan(h));
    let points: Vec<u32> = std::iter::once(own)
        .chain(ends)
        .map(|h| t.vertex(h))
        .collect();
    let mut terms = vec![Vec::new(); points.len()];
    let count = found.vertices.len();
    let mut units = vec![[0.0; 3]; local.control_base().len()];
    for first in (0..count).step_by(3) {
        let columns = first..count.min(first + 3);
        units.fill([0.0; 3]);
        for k in columns.clone() {
            units[k][k - first] = 1.0;
        }
        local.update_points(&units).map_err(|_| NO_WEIGHTS)?;
        for (out, &v) in terms.iter_mut().zip(&points) {
            let weights = local.control_points()[v as usize];
            for k in columns.clone().filter(|k| weights[k - first] != 0.0) {
                out.extend([found.vertices[k], weights[k - first].to_bits()]);
            }
        }
    }
    let all = terms.into_iter();
    let words = all.flat_map(|t| std::iter::once(t.len() as u32 / 2).chain(t));
    Ok(words.collect())
}

impl Dicer<'_> {
    /// Words that normals of rings take at the corner that half-edge `h` begins with: no fewer.
    pub(super) fn ring_words(&self, h: u32) -> u64 {
        if self.rings.is_empty() {
            return 0;
        }
        let mitred = self.surface.mitred_corner(h).unwrap_or_default();
        let words = |h: u32| {
            let ring = self.rings.get(&self.surface.quads().fan(h));
            ring.map_or(0, |ring| ring.len() as u64 + 2)
        };
        // Of quadratic patches, what they run through as well.
        3 * words(h) + 2 * mitred.into_iter().map(words).sum::<u64>()
    }
}

impl Builder {
    /// Where the normal of the corner that half-edge `h` begins with comes from, whose derivatives are those at `place`.
    pub(super) fn corner_normal(&mut self, dicer: &Dicer<'_>, h: u32, place: [u32; 2]) -> [u32; 2] {
        let fan = dicer.surface.quads().fan(h);
        let Some(ring) = dicer.rings.get(&fan) else {
            return place;
        };
        let gathers = &mut self.data.gathers;
        let at = gathers.len() as u32;
        gathers.extend(place);
        gathers.push(ring[0]);
        let mut rest = &ring[1..];
        while let [terms, points @ ..] = rest {
            gathers.push(*terms);
            let (own, others) = points.split_at(2 * *terms as usize);
            for term in own.chunks_exact(2) {
                gathers.extend([term[0] + dicer.first_point, term[1]]);
            }
            rest = others;
        }
        [at, RINGED]
    }
}
