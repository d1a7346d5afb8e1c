//! The topology of the next level. Every corner `h` has a child face: a quad, or a triangle, and then the four of a face have the child of
//! its middle in the last place.
//!
//! Unlike [`topology::split`](crate::topology::split), which serves the per-quad path, edges stay welded where the mesh is not manifold and
//! semi-sharp tags are carried on.

use super::ring::start_end;
use super::sharpness::Step;
use crate::topology::{Fan, FanRule, NONE, Topology};
use rayon::prelude::*;

/// Elements per task.
const RUN: usize = 1 << 12;

/// What faces split into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// Quads around the face point, one per corner.
    Quads,
    /// Four triangles, one per corner and one in the middle. All faces must be triangles.
    Triangles,
}

/// Corner `k` of the children of corner `h`, where `k` is 0 for the vertex, 1 for the edge point of `h`, 3 for the edge point before, all
/// three in the child at `h`; and 2 for the face point in the child at `h`, or for the edge point of `h` in the triangle in the middle.
///
/// The vertex stands at position 0 of the child, but in children of quads and triangles at the position it has in the parent: so children
/// keep the parent's directions of u and v.
#[must_use]
#[inline]
pub fn child_corner(split: Split, t: &Topology, h: u32, k: u32) -> u32 {
    if split == Split::Triangles {
        let (first, at) = (h - h % 3, h % 3);
        return match k {
            2 => 4 * first + 9 + (at + 2) % 3,
            3 => 4 * first + 3 * at + (at + 2) % 3,
            k => 4 * first + 3 * at + (at + k) % 3,
        };
    }
    let turn = if t.all_quads() {
        h & 3
    } else {
        let face = t.face_halves(t.face_of(h));
        if face.len() == 4 { h - face.start } else { 0 }
    };
    4 * h + ((k + turn) & 3)
}

/// Makes the child topology.
#[must_use]
pub fn child(step: &Step<'_>) -> Topology {
    let t = step.topology;
    let halves = t.half_count();
    let vertex_count = step.first_edge_point() + t.edge_count();
    let mut corner_vertices = vec![0_u32; 4 * halves];
    let mut twins = vec![NONE; 4 * halves];
    let mut edges = vec![0_u32; 4 * halves];
    let triangles = step.split() == Split::Triangles;
    // The children of a face of triangles, or of a corner.
    let group = if triangles { 12 } else { 4 };
    corner_vertices
        .par_chunks_exact_mut(group)
        .zip(twins.par_chunks_exact_mut(group))
        .zip(edges.par_chunks_exact_mut(group))
        .enumerate()
        .with_min_len(RUN)
        .for_each(|(i, ((vertices, twins), edges))| {
            let mut out = Corners {
                base: (group * i) as u32,
                vertices,
                twins,
                edges,
            };
            let i = i as u32;
            if triangles {
                (3 * i..3 * i + 3).for_each(|h| out.fill(step, h));
            } else {
                out.fill(step, i);
            }
        });
    let (fans, extra_fan_vertices, corner_fans) = child_fans(step, vertex_count);
    let mut holes = Vec::new();
    if !t.holes.is_empty() {
        // Children of a face of triangles, or of a corner: both come to as many as there are corners, or 4/3 of them.
        let count = 4 * halves / if triangles { 3 } else { 4 };
        holes = (0..count as u32)
            .into_par_iter()
            .with_min_len(RUN)
            .map(|c| t.is_hole(if triangles { c / 4 } else { t.face_of(c) }))
            .collect();
    }
    let (mut face_offsets, mut corner_faces) = (Vec::new(), Vec::new());
    if triangles {
        let corners = 4 * halves as u32;
        let each = |count: u32| (0..count).into_par_iter().with_min_len(RUN);
        face_offsets = each(corners / 3 + 1).map(|f| 3 * f).collect();
        corner_faces = each(corners).map(|h| h / 3).collect();
    }
    Topology {
        vertex_count,
        face_offsets,
        corner_faces,
        corner_vertices,
        corner_fans,
        twins,
        edges,
        edge_halves: child_edge_halves(step),
        fans,
        extra_fan_vertices,
        edge_sharpness: child_edge_sharpness(step),
        vertex_sharpness: child_vertex_sharpness(step, vertex_count),
        holes,
    }
}

/// Corners of the child faces from corner `base` on.
struct Corners<'a> {
    base: u32,
    vertices: &'a mut [u32],
    twins: &'a mut [u32],
    edges: &'a mut [u32],
}

impl Corners<'_> {
    fn set(&mut self, corner: u32, vertex: u32, edge: u32, twin: u32) {
        let at = (corner - self.base) as usize;
        self.vertices[at] = vertex;
        self.edges[at] = edge;
        self.twins[at] = twin;
    }

    /// Fills the four child corners that belong to corner `h`.
    fn fill(&mut self, step: &Step<'_>, h: u32) {
        let t = step.topology;
        let halves = t.half_count() as u32;
        let first_edge = step.first_edge_point() as u32;
        let (before, next) = (t.prev(h), t.next(h));
        let own = |k: u32| step.child_corner(h, k);
        // Child edges: those inside faces, one per parent corner, then two per parent edge.
        let outer = |h: u32, end: u32| halves + 2 * t.edge(h) + end;
        let ahead = match t.twin(h) {
            NONE => NONE,
            twin => step.child_corner(t.next(twin), 3),
        };
        let behind = match t.twin(before) {
            NONE => NONE,
            twin => step.child_corner(twin, 0),
        };
        let (start, end) = (
            outer(h, start_end(t, h)),
            outer(before, 1 - start_end(t, before)),
        );
        let (edge_point, edge_before) = (first_edge + t.edge(h), first_edge + t.edge(before));
        self.set(own(0), t.vertex(h), start, ahead);
        if step.split() == Split::Triangles {
            // The middle triangle lies beyond the side from this edge point to the one before; it leaves that one there.
            self.set(own(1), edge_point, h, step.child_corner(before, 2));
            self.set(own(3), edge_before, end, behind);
            // Its side from here leads to the next edge point, along the child of the next corner.
            self.set(own(2), edge_point, next, step.child_corner(next, 1));
        } else {
            self.set(own(1), edge_point, h, step.child_corner(next, 2));
            let face_point = t.vertex_count() as u32 + t.face_of(h);
            self.set(own(2), face_point, before, step.child_corner(before, 1));
            self.set(own(3), edge_before, end, behind);
        }
    }
}

/// The child half-edge on the part of edge `edge(h)` at end `end` that lies in the face of `h`.
fn half_at_end(step: &Step<'_>, h: u32, end: u32) -> u32 {
    let t = step.topology;
    if start_end(t, h) == end {
        step.child_corner(h, 0)
    } else {
        step.child_corner(t.next(h), 3)
    }
}

fn child_edge_halves(step: &Step<'_>) -> Vec<u32> {
    let t = step.topology;
    let halves = t.half_count() as u32;
    let mut out = vec![0; halves as usize + 2 * t.edge_count()];
    let (inner, outer) = out.split_at_mut(halves as usize);
    inner
        .par_iter_mut()
        .enumerate()
        .with_min_len(RUN)
        .for_each(|(h, half)| {
            let h = h as u32;
            let beyond = match step.split() {
                Split::Quads => t.next(h),
                Split::Triangles => t.prev(h),
            };
            *half = step.child_corner(h, 1).min(step.child_corner(beyond, 2));
        });
    outer
        .par_chunks_exact_mut(2)
        .enumerate()
        .with_min_len(RUN)
        .for_each(|(e, ends)| {
            for (end, half) in ends.iter_mut().enumerate() {
                *half = step
                    .incidence
                    .halves(t, e as u32)
                    .map(|h| half_at_end(step, h, end as u32))
                    .fold(NONE, u32::min);
            }
        });
    out
}

/// Fans of the child, vertices of its extra fans, and the fan of every corner where there are extra fans.
fn child_fans(step: &Step<'_>, vertex_count: usize) -> (Vec<Fan>, Vec<u32>, Vec<u32>) {
    let t = step.topology;
    let vertices = t.vertex_count();
    let faces = step.first_edge_point() - vertices;
    let split = step.split();
    let extra_halves = step.incidence.all_extra_halves();
    let none = Fan {
        first: NONE,
        faces: 0,
        closed: false,
        rule: FanRule::Corner,
    };
    let of_fan = |fan: &Fan| Fan {
        first: if fan.first == NONE {
            NONE
        } else {
            step.child_corner(fan.first, 0)
        },
        ..*fan
    };
    let open_at = |h: u32| Fan {
        first: step.child_corner(t.next(h), 3),
        faces: if split == Split::Triangles { 3 } else { 2 },
        closed: false,
        rule: FanRule::Crease,
    };
    let mut fans = vec![none; vertex_count];
    let (of_vertices, rest) = fans.split_at_mut(vertices);
    let (of_faces, of_edges) = rest.split_at_mut(faces);
    of_vertices
        .par_iter_mut()
        .zip(&t.fans[..vertices])
        .with_min_len(RUN)
        .for_each(|(child, fan)| *child = of_fan(fan));
    of_faces
        .par_iter_mut()
        .enumerate()
        .with_min_len(RUN)
        .for_each(|(f, child)| {
            let range = t.face_halves(f as u32);
            *child = Fan {
                first: range
                    .clone()
                    .map(|h| step.child_corner(h, 2))
                    .fold(NONE, u32::min),
                faces: range.len() as u32,
                closed: true,
                rule: FanRule::Smooth,
            };
        });
    of_edges
        .par_iter_mut()
        .enumerate()
        .with_min_len(RUN)
        .for_each(|(e, child)| {
            let h = t.edge_half(e as u32);
            let twin = t.twin(h);
            *child = if twin == NONE {
                open_at(h)
            } else {
                let around = [
                    step.child_corner(h, 1),
                    step.child_corner(t.next(h), 3),
                    step.child_corner(twin, 1),
                    step.child_corner(t.next(twin), 3),
                ];
                // The middle triangles come after their siblings, so they are never the first.
                Fan {
                    first: around.into_iter().fold(NONE, u32::min),
                    faces: if split == Split::Triangles { 6 } else { 4 },
                    closed: true,
                    rule: FanRule::Smooth,
                }
            };
        });
    if extra_halves.is_empty() && t.extra_fan_vertices.is_empty() {
        return (fans, Vec::new(), Vec::new());
    }
    // Not manifold: extra fans of vertices first, then one per extra half-edge.
    fans.extend(t.fans[vertices..].iter().map(of_fan));
    fans.extend(extra_halves.iter().map(|&(_, h)| open_at(h)));
    let first_edge = step.first_edge_point() as u32;
    let mut extra = t.extra_fan_vertices.clone();
    let first_extra_half = (vertex_count + extra.len()) as u32;
    extra.extend(extra_halves.iter().map(|&(e, _)| first_edge + e));
    let edge_fan = |h: u32| match extra_halves.binary_search(&(t.edge(h), h)) {
        Ok(rank) => first_extra_half + rank as u32,
        Err(_) => first_edge + t.edge(h),
    };
    let mut corner_fans = vec![0; 4 * t.half_count()];
    for h in 0..t.half_count() as u32 {
        let fan = t.fan(h);
        let beyond = (vertex_count - vertices) as u32;
        let moved = if (fan as usize) < vertices {
            fan
        } else {
            fan + beyond
        };
        corner_fans[step.child_corner(h, 0) as usize] = moved;
        corner_fans[step.child_corner(h, 1) as usize] = edge_fan(h);
        corner_fans[step.child_corner(h, 2) as usize] = match split {
            Split::Quads => vertices as u32 + t.face_of(h),
            Split::Triangles => edge_fan(h),
        };
        corner_fans[step.child_corner(h, 3) as usize] = edge_fan(t.prev(h));
    }
    (fans, extra, corner_fans)
}

/// Empty once no edge is sharp but those without twins, which are infinitely sharp anyway.
fn child_edge_sharpness(step: &Step<'_>) -> Vec<f32> {
    let t = step.topology;
    let tagged = step
        .child_edges()
        .par_iter()
        .enumerate()
        .with_min_len(RUN)
        .any(|(e, c)| c[0].max(c[1]) > 0.0 && t.twin(t.edge_half(e as u32)) != NONE);
    if !tagged {
        return Vec::new();
    }
    let mut out = vec![0.0; t.half_count()];
    out.extend(step.child_edges().iter().flatten());
    out
}

fn child_vertex_sharpness(step: &Step<'_>, vertex_count: usize) -> Vec<f32> {
    let t = step.topology;
    let mut out: Vec<f32> = (0..t.vertex_sharpness.len() as u32)
        .map(|v| step.child_vertex(v))
        .collect();
    if out.iter().all(|&s| s == 0.0) {
        return Vec::new();
    }
    out.resize(vertex_count, 0.0);
    out
}
