//! The first Catmull-Clark step as connectivity: any polygon mesh becomes quads, child `h` of every corner `h`.
//!
//! Child vertices are numbered as OpenSubdiv does: those of vertices (here of fans), then of faces, then of edges. An edge that has no
//! twins is shared by nobody, so each of its half-edges gets an edge vertex of its own beyond the first.

use super::{Fan, FanRule, NONE, Topology};

/// Quads after one step.
#[derive(Clone, Debug)]
pub struct Split {
    /// Connectivity of the child quads; corner 0 of child `h` is the vertex of corner `h`, then edge `h`, the face, the edge before.
    pub topology: Topology,
    /// Parent half-edge of every edge vertex.
    pub edge_vertex_halves: Vec<u32>,
}

/// Splits every face into quads.
#[must_use]
pub fn split(parent: &Topology) -> Split {
    let fan_count = parent.fans.len();
    let face_count = parent.face_count();
    let first_edge = (fan_count + face_count) as u32;
    let halves = parent.half_count() as u32;
    // Edge vertices: one per pair of twins or per lone half-edge, numbered by the lower half-edge.
    let mut edge_vertices = vec![NONE; halves as usize];
    let mut edge_vertex_halves = Vec::with_capacity(halves as usize / 2 + 1);
    for h in 0..halves {
        let twin = parent.twin(h);
        edge_vertices[h as usize] = if twin != NONE && twin < h {
            edge_vertices[twin as usize]
        } else {
            edge_vertex_halves.push(h);
            first_edge + edge_vertex_halves.len() as u32 - 1
        };
    }
    let vertex_count = first_edge as usize + edge_vertex_halves.len();
    let mut corner_vertices = Vec::with_capacity(halves as usize * 4);
    let mut twins = vec![NONE; halves as usize * 4];
    for h in 0..halves {
        let before = parent.prev(h);
        corner_vertices.extend([
            parent.fan(h),
            edge_vertices[h as usize],
            fan_count as u32 + parent.face_of(h),
            edge_vertices[before as usize],
        ]);
        // Child h: side 0 runs along edge h, side 3 along the edge before; sides 1 and 2 lie between siblings.
        let next = parent.next(h);
        twins[4 * h as usize + 1] = 4 * next + 2;
        twins[4 * next as usize + 2] = 4 * h + 1;
        let twin = parent.twin(h);
        if twin != NONE {
            let child = 4 * parent.next(twin) + 3;
            twins[4 * h as usize] = child;
            twins[child as usize] = 4 * h;
        }
    }
    let mut fans = Vec::with_capacity(vertex_count);
    for fan in &parent.fans {
        let first = if fan.first == NONE {
            NONE
        } else {
            4 * fan.first
        };
        fans.push(Fan { first, ..*fan });
    }
    for f in 0..face_count as u32 {
        let range = parent.face_halves(f);
        fans.push(Fan {
            first: 4 * range.start + 2,
            faces: range.len() as u32,
            closed: true,
            rule: FanRule::Smooth,
        });
    }
    for &h in &edge_vertex_halves {
        let lone = parent.twin(h) == NONE;
        // Around an edge vertex: child h leaves it by its corner 1, the child after by its corner 3.
        let (first, faces) = if lone {
            (4 * parent.next(h) + 3, 2)
        } else {
            (4 * h + 1, 4)
        };
        fans.push(Fan {
            first,
            faces,
            closed: !lone,
            rule: if lone {
                FanRule::Crease
            } else {
                FanRule::Smooth
            },
        });
    }
    let mut edges = vec![NONE; twins.len()];
    let mut edge_halves = Vec::with_capacity(twins.len() / 2);
    for h in 0..twins.len() as u32 {
        let twin = twins[h as usize];
        edges[h as usize] = if twin != NONE && twin < h {
            edges[twin as usize]
        } else {
            edge_halves.push(h);
            edge_halves.len() as u32 - 1
        };
    }
    let mut holes = Vec::new();
    if !parent.holes.is_empty() {
        holes = (0..halves)
            .map(|h| parent.is_hole(parent.face_of(h)))
            .collect();
    }
    let topology = Topology {
        vertex_count,
        corner_vertices,
        twins,
        edges,
        edge_halves,
        fans,
        holes,
        ..Topology::default()
    };
    Split {
        topology,
        edge_vertex_halves,
    }
}
