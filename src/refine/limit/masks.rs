//! The weights of masks, ring by ring, for who applies them elsewhere: what the local ring makes of points that are unit vectors.

use super::Point;
use super::local::LocalRing;
use super::sectors::{Sector, Tables};
use crate::scheme::INFINITE_SHARPNESS;
use crate::scheme::crease::Rule;
use crate::scheme::limit::RingMask;

/// What the masks of a vertex depend on: the ring of its faces, with edges that are sharp for good and others that are smooth.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct RingShape {
    /// Whether the faces close around the vertex.
    pub(crate) closed: bool,
    /// Whether the vertex itself is sharp.
    pub(crate) corner: bool,
    /// Whether edges are sharp, counter-clockwise. An open ring has an edge more than faces; the first and the last are.
    pub(crate) sharp: Vec<bool>,
}

/// A run of faces with one normal.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SectorMasks {
    /// The first face.
    pub(crate) first: usize,
    /// How many, around the end if need be.
    pub(crate) count: usize,
    /// Two tangents whose cross product points outward: weights from edge and face `first` on, of differences to the vertex.
    pub(crate) tangents: [RingMask; 2],
    /// Whether it points inward where the sector takes more than half a turn.
    pub(crate) reflex: bool,
}

/// Masks of a vertex.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct VertexMasks {
    /// The limit position.
    pub(crate) position: RingMask,
    /// At least one.
    pub(crate) sectors: Vec<SectorMasks>,
}

/// Makes masks of one scheme.
pub(crate) struct Masks {
    tables: Tables,
    triangles: bool,
    linear: bool,
}

impl Masks {
    /// Of triangles under Loop's rules or of quads under those of Catmull-Clark; `linear` where points stay and faces are flat.
    pub(crate) fn new(triangles: bool, linear: bool) -> Self {
        Self {
            tables: Tables::new(triangles),
            triangles,
            linear,
        }
    }

    /// Those of a vertex of this shape, which has a face.
    pub(crate) fn of(&self, shape: &RingShape) -> VertexMasks {
        let mut ring = LocalRing::default();
        ring.clear(shape.closed, self.triangles);
        ring.sigma = if shape.corner {
            INFINITE_SHARPNESS
        } else {
            0.0
        };
        for &sharp in &shape.sharp {
            let sharpness = if sharp { INFINITE_SHARPNESS } else { 0.0 };
            ring.push_edge([0.0; 3], sharpness, sharpness);
        }
        if !self.triangles {
            ring.faces = vec![[0.0; 3]; ring.face_count()];
        }
        let position = weights(&mut ring, |ring| match self.linear {
            true => ring.x,
            false => ring.position(&self.tables),
        });
        let sectors = ring.sectors(self.linear);
        let sectors = sectors.into_iter().map(|s| self.sector(&mut ring, s));
        VertexMasks {
            position,
            sectors: sectors.collect(),
        }
    }

    fn sector(&self, ring: &mut LocalRing, sector: Sector) -> SectorMasks {
        let (edges, faces) = (ring.edges.len(), ring.faces.len());
        let Sector { first, count } = sector;
        let ends = edges.min(count + 1);
        let tangents = [0, 1].map(|k| {
            let all = weights(ring, |ring| {
                ring.tangents(&self.tables, sector, self.linear)[k]
            });
            let of =
                |w: &[f64], count: usize| (0..count).map(|i| w[(first + i) % w.len()]).collect();
            RingMask {
                vertex: all.vertex,
                edges: of(&all.edges, ends),
                faces: of(&all.faces, count.min(faces)),
            }
        });
        SectorMasks {
            first,
            count,
            tangents,
            reflex: !self.linear && ring.rule() == Rule::Corner && ring.may_be_reflex(sector),
        }
    }
}

/// Weights of a linear map of the ring's points, three at a time: one for each coordinate. The points are 0 before and after.
fn weights(ring: &mut LocalRing, of: impl Fn(&LocalRing) -> Point) -> RingMask {
    fn point(ring: &mut LocalRing, at: usize) -> Option<&mut Point> {
        let edges = ring.edges.len();
        match at.checked_sub(1) {
            None => Some(&mut ring.x),
            Some(at) if at < edges => ring.edges.get_mut(at),
            Some(at) => ring.faces.get_mut(at - edges),
        }
    }
    let (edges, faces) = (ring.edges.len(), ring.faces.len());
    let mut all = Vec::with_capacity(3 + edges + faces);
    for first in (0..1 + edges + faces).step_by(3) {
        for k in 0..3 {
            if let Some(p) = point(ring, first + k) {
                p[k] = 1.0;
            }
        }
        all.extend(of(ring));
        for k in 0..3 {
            if let Some(p) = point(ring, first + k) {
                p[k] = 0.0;
            }
        }
    }
    RingMask {
        vertex: all[0],
        edges: all[1..=edges].to_vec(),
        faces: all[1 + edges..=edges + faces].to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scheme::limit;

    fn smooth(valence: usize) -> RingShape {
        RingShape {
            closed: true,
            corner: false,
            sharp: vec![false; valence],
        }
    }

    #[test]
    fn weights_are_those_of_the_masks() {
        for n in [3_u32, 4, 5, 9] {
            let masks = Masks::new(false, false).of(&smooth(n as usize));
            let [x, e, f] = limit::position(n);
            assert_eq!(masks.position.vertex, x);
            assert!(masks.position.edges.iter().all(|&w| w == e));
            assert!(masks.position.faces.iter().all(|&w| w == f));
            let [sector] = &masks.sectors[..] else {
                panic!("one sector")
            };
            for (got, want) in sector.tangents.iter().zip(limit::smooth_tangents(n)) {
                assert_eq!((&got.edges, &got.faces), (&want.edges, &want.faces));
            }
        }
    }

    #[test]
    fn a_sector_has_the_weights_of_its_own_faces() {
        // Sharp edges 1 and 3 of five: sectors of two and of three faces, the second around the end.
        let mut shape = smooth(5);
        (shape.sharp[1], shape.sharp[3]) = (true, true);
        let masks = Masks::new(false, false).of(&shape);
        assert_eq!(masks.position.vertex, 2.0 / 3.0);
        assert_eq!(masks.position.edges, [0.0, 1.0 / 6.0, 0.0, 1.0 / 6.0, 0.0]);
        let [a, b] = &masks.sectors[..] else {
            panic!("two sectors")
        };
        assert_eq!([a.first, a.count, b.first, b.count], [1, 2, 3, 3]);
        for s in [a, b] {
            let [along, inward] = &s.tangents;
            let want = limit::side_tangent(s.count as u32);
            assert_eq!((&inward.edges, &inward.faces), (&want.edges, &want.faces));
            assert_eq!(along.edges.len(), s.count + 1);
            assert_eq!([along.edges[0], along.edges[s.count]], [1.0, -1.0]);
            assert!(!s.reflex);
        }
        shape.corner = true;
        let masks = Masks::new(false, false).of(&shape);
        assert_eq!(masks.position.vertex, 1.0);
        assert!(masks.sectors.iter().all(|s| s.reflex));
    }

    #[test]
    fn flat_faces_have_a_normal_each() {
        let masks = Masks::new(false, true).of(&smooth(4));
        assert_eq!((masks.position.vertex, masks.sectors.len()), (1.0, 4));
        assert_eq!(masks.sectors[3].tangents[1].edges, [0.0, 1.0]);
    }
}
