//! The topology of the next level: child `h` of every corner `h`, a quad.
//!
//! Unlike [`topology::split`](crate::topology::split), which serves the per-quad path, edges stay welded where the mesh is not manifold and
//! semi-sharp tags are carried on.

use super::ring::start_end;
use super::sharpness::Step;
use crate::topology::{Fan, FanRule, NONE, Topology};
use rayon::prelude::*;

/// Elements per task.
const RUN: usize = 1 << 12;

/// Corner `k` of child `h`, where `k` is 0 for the vertex, 1 for the edge point of `h`, 2 for the face point, 3 for the edge point before.
///
/// The vertex stands at position 0 of the child, but in children of quads at the position it has in the parent: so children keep the
/// parent's directions of u and v.
#[must_use]
#[inline]
pub fn child_corner(t: &Topology, h: u32, k: u32) -> u32 {
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
    let (vertices, faces, edges) = (t.vertex_count(), t.face_count(), t.edge_count());
    let first_edge = (vertices + faces) as u32;
    let vertex_count = vertices + faces + edges;

    let mut corner_vertices = vec![0_u32; 4 * halves];
    let mut twins = vec![NONE; 4 * halves];
    let mut child_edges = vec![0_u32; 4 * halves];
    corner_vertices
        .par_chunks_exact_mut(4)
        .zip(twins.par_chunks_exact_mut(4))
        .zip(child_edges.par_chunks_exact_mut(4))
        .enumerate()
        .with_min_len(RUN)
        .for_each(|(h, ((vertex_of, twin_of), edge_of))| {
            let h = h as u32;
            let (before, next) = (t.prev(h), t.next(h));
            let at = |k: u32| (child_corner(t, h, k) & 3) as usize;
            vertex_of[at(0)] = t.vertex(h);
            vertex_of[at(1)] = first_edge + t.edge(h);
            vertex_of[at(2)] = vertices as u32 + t.face_of(h);
            vertex_of[at(3)] = first_edge + t.edge(before);
            twin_of[at(1)] = child_corner(t, next, 2);
            twin_of[at(2)] = child_corner(t, before, 1);
            let twin = t.twin(h);
            if twin != NONE {
                twin_of[at(0)] = child_corner(t, t.next(twin), 3);
            }
            let twin = t.twin(before);
            if twin != NONE {
                twin_of[at(3)] = child_corner(t, twin, 0);
            }
            // Child edges: those inside faces, one per parent corner, then two per parent edge.
            edge_of[at(0)] = halves as u32 + 2 * t.edge(h) + start_end(t, h);
            edge_of[at(1)] = h;
            edge_of[at(2)] = before;
            edge_of[at(3)] = halves as u32 + 2 * t.edge(before) + 1 - start_end(t, before);
        });
    let (fans, extra_fan_vertices, corner_fans) = child_fans(step, vertex_count);
    let mut holes = Vec::new();
    if !t.holes.is_empty() {
        holes = (0..halves as u32)
            .into_par_iter()
            .with_min_len(RUN)
            .map(|h| t.is_hole(t.face_of(h)))
            .collect();
    }
    Topology {
        vertex_count,
        face_offsets: Vec::new(),
        corner_faces: Vec::new(),
        corner_vertices,
        corner_fans,
        twins,
        edges: child_edges,
        edge_halves: child_edge_halves(step),
        fans,
        extra_fan_vertices,
        edge_sharpness: child_edge_sharpness(step),
        vertex_sharpness: child_vertex_sharpness(step, vertex_count),
        holes,
    }
}

/// The child half-edge on the part of edge `edge(h)` at end `end` that lies in the face of `h`.
fn half_at_end(t: &Topology, h: u32, end: u32) -> u32 {
    if start_end(t, h) == end {
        child_corner(t, h, 0)
    } else {
        child_corner(t, t.next(h), 3)
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
            *half = child_corner(t, h, 1).min(child_corner(t, t.next(h), 2));
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
                    .map(|h| half_at_end(t, h, end as u32))
                    .fold(NONE, u32::min);
            }
        });
    out
}

/// Fans of the child, vertices of its extra fans, and the fan of every corner where there are extra fans.
fn child_fans(step: &Step<'_>, vertex_count: usize) -> (Vec<Fan>, Vec<u32>, Vec<u32>) {
    let t = step.topology;
    let (vertices, faces) = (t.vertex_count(), t.face_count());
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
            child_corner(t, fan.first, 0)
        },
        ..*fan
    };
    let open_at = |h: u32| Fan {
        first: child_corner(t, t.next(h), 3),
        faces: 2,
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
                    .map(|h| child_corner(t, h, 2))
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
                    child_corner(t, h, 1),
                    child_corner(t, t.next(h), 3),
                    child_corner(t, twin, 1),
                    child_corner(t, t.next(twin), 3),
                ];
                Fan {
                    first: around.into_iter().fold(NONE, u32::min),
                    faces: 4,
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
    let first_edge = (vertices + faces) as u32;
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
        corner_fans[child_corner(t, h, 0) as usize] = moved;
        corner_fans[child_corner(t, h, 1) as usize] = edge_fan(h);
        corner_fans[child_corner(t, h, 2) as usize] = vertices as u32 + t.face_of(h);
        corner_fans[child_corner(t, h, 3) as usize] = edge_fan(t.prev(h));
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
