//! Limit positions and unit limit normals of the vertices of a level.
//!
//! A vertex and its ring of quads (Loop: of triangles) refine on their own: the ring of the next level needs nothing but this ring. So where masks do not hold
//! yet (polygons, semi-sharp creases) the ring alone is refined until they do, at no cost for the rest of the mesh. Where sharp edges
//! divide the ring, every sector has its own normal, and the corners of its faces name it.
//!
//! Interpolating schemes have their points for limits, and need two rings for a normal; see the module `interpolating`.

use super::real::Real;
use super::ring::Spoke;
use super::sharpness::Step;
use super::{Channels, Level, Options, edge, face, vertex};
use crate::scheme::Scheme;
use crate::scheme::crease::is_semi_sharp;
use crate::topology::{NONE, Ring, Topology};
use rayon::prelude::*;

mod face_varying;
mod frame;
mod interpolating;
mod local;
#[cfg(feature = "gpu")]
mod masks;
mod rings;
mod sectors;

pub(crate) use frame::{Frame, normal};
pub(crate) use interpolating::Tangents;
use local::LocalRing;
#[cfg(feature = "gpu")]
pub(crate) use masks::{Masks, RingShape, VertexMasks};
use rings::RingMasks;
pub(super) use sectors::Tables;

type Point = [f64; 3];

/// Limit points of a level.
#[derive(Clone, Debug, Default)]
pub struct Limit<T> {
    /// One position per vertex.
    pub positions: Vec<[T; 3]>,
    /// Unit normals: one per vertex, then those of further sectors.
    pub normals: Vec<[T; 3]>,
    /// Normal of every corner; empty when that is the normal of its vertex everywhere.
    pub corner_normals: Vec<u32>,
    /// Limits of the texture coordinates: one for each of the level's; empty without.
    pub uvs: Vec<[T; 2]>,
    /// Limits of the channels.
    pub channels: Channels<T>,
}

impl<T> Limit<T> {
    /// The normal of corner `h` of `topology`.
    #[must_use]
    pub fn normal_index(&self, topology: &Topology, h: u32) -> u32 {
        match self.corner_normals.get(h as usize) {
            Some(&n) => n,
            None => topology.vertex(h),
        }
    }
}

/// One vertex: position, first normal, and every corner's normal where they differ.
struct VertexLimit {
    position: Point,
    normal: Point,
    corners: Vec<(u32, Point)>,
}

/// Computes the limit of all vertices of `level`.
#[must_use]
pub fn limit<T: Real>(level: &Level<T>, options: &Options) -> Limit<T> {
    T::limit(level, options)
}

pub(super) fn make<T: Real>(level: &Level<T>, options: &Options) -> Limit<T> {
    let t = &level.topology;
    let step = Step::new(t, options);
    let tables = Tables::new(options.scheme == Scheme::Loop);
    let masks = options
        .scheme
        .is_interpolating()
        .then(|| RingMasks::new(options.scheme));
    let vertices: Vec<VertexLimit> = (0..t.vertex_count() as u32)
        .into_par_iter()
        .with_min_len(1 << 10)
        .map_init(
            || (LocalRing::default(), Vec::new()),
            |(ring, spokes), v| match &masks {
                Some(masks) => interpolating::vertex_limit(&step, masks, &level.points, v),
                None => vertex_limit(&step, &tables, &level.points, v, ring, spokes),
            },
        )
        .collect();
    let narrow = |p: &Point| p.map(T::from_f64);
    let mut out = Limit {
        positions: vertices.iter().map(|v| narrow(&v.position)).collect(),
        normals: vertices.iter().map(|v| narrow(&v.normal)).collect(),
        corner_normals: Vec::new(),
        uvs: (level.uvs.as_ref()).map_or_else(Vec::new, |uvs| uvs.limit(&step, &tables)),
        channels: level.channels.limit(&step, &tables),
    };
    for (v, limit) in vertices.iter().enumerate() {
        if !limit.corners.is_empty() && out.corner_normals.is_empty() {
            out.corner_normals.clone_from(&t.corner_vertices);
        }
        let mut seen: Vec<(Point, u32)> = vec![];
        for (h, normal) in &limit.corners {
            let known = seen.iter().find(|(n, _)| n == normal).map(|s| s.1);
            let index = known.unwrap_or_else(|| {
                let index = if seen.is_empty() && *normal == limit.normal {
                    v as u32
                } else {
                    out.normals.push(narrow(normal));
                    out.normals.len() as u32 - 1
                };
                seen.push((*normal, index));
                index
            });
            out.corner_normals[*h as usize] = index;
        }
    }
    out
}

fn vertex_limit<T: Real>(
    step: &Step<'_>,
    tables: &Tables,
    points: &[[T; 3]],
    v: u32,
    ring: &mut LocalRing,
    spokes: &mut Vec<Spoke>,
) -> VertexLimit {
    let t = step.topology;
    let x = points[v as usize].map(T::to_f64);
    if t.fans[v as usize].first == NONE {
        return VertexLimit {
            position: x,
            normal: [0.0, 0.0, 1.0],
            corners: Vec::new(),
        };
    }
    let mut position = x;
    let mut corners = Vec::new();
    let mut sectors = 0;
    for fan in std::iter::once(v).chain(step.incidence.extra_fans(v)) {
        fan_ring(step, &t.corner_vertices, points, v, fan, ring, spokes);
        if fan == v {
            position = if step.is_linear() {
                x
            } else {
                ring.position(tables)
            };
        }
        for (faces, normal) in ring.normals(tables, step.is_linear()) {
            sectors += 1;
            let of_face = |i: usize| Ring::of_fan(t, fan).nth(i);
            corners.extend(faces.filter_map(of_face).map(|h| (h, normal)));
        }
    }
    let normal = corners.first().map_or([0.0, 0.0, 1.0], |c| c.1);
    if sectors < 2 {
        corners.clear();
    }
    VertexLimit {
        position,
        normal,
        corners,
    }
}

/// Two tangents of every vertex under an interpolating scheme, those of the first sector, as linear maps of `points`.
pub(super) fn interpolating_tangents(step: &Step<'_>, points: &[Point]) -> [Vec<Point>; 2] {
    let masks = Tangents::new(step.options.scheme);
    let both: Vec<[Point; 2]> = (0..points.len() as u32)
        .into_par_iter()
        .with_min_len(1 << 8)
        .map(|v| masks.pair(step, points, v))
        .collect();
    [0, 1].map(|k| both.iter().map(|pair| pair[k]).collect())
}

/// Limits of values that go by the rules of points, and on demand two tangents each, those of the first sector; interpolating schemes
/// have theirs elsewhere.
pub(super) fn values<T: Real>(
    step: &Step<'_>,
    tables: &Tables,
    values: &[[T; 3]],
    tangents: bool,
) -> (Vec<[T; 3]>, [Vec<[T; 3]>; 2]) {
    let t = step.topology;
    if step.options.scheme.is_interpolating() {
        return (values.to_vec(), [Vec::new(), Vec::new()]);
    }
    let all: Vec<[Point; 3]> = (0..values.len() as u32)
        .into_par_iter()
        .with_min_len(1 << 10)
        .map_init(
            || (LocalRing::default(), Vec::new()),
            |(ring, spokes), v| {
                let x = values[v as usize].map(T::to_f64);
                if t.fans[v as usize].first == NONE {
                    return [x, [0.0; 3], [0.0; 3]];
                }
                fan_ring(step, &t.corner_vertices, values, v, v, ring, spokes);
                let position = if step.is_linear() {
                    x
                } else {
                    ring.position(tables)
                };
                let [a, b] = if tangents {
                    ring.first_tangents(tables, step.is_linear())
                } else {
                    [[0.0; 3]; 2]
                };
                [position, a, b]
            },
        )
        .collect();
    let part = |k: usize| all.iter().map(|p| p[k].map(T::from_f64)).collect();
    let no = Vec::new;
    let both = if tangents {
        [part(1), part(2)]
    } else {
        [no(), no()]
    };
    (part(0), both)
}

/// Fills `ring` with the ring of quads around one fan of vertex `v`, refined as far as masks need. `index` names the value of every corner;
/// the corners of the fan must agree, at `v` and at the far ends of its edges.
fn fan_ring<T: Real, const N: usize>(
    step: &Step<'_>,
    index: &[u32],
    points: &[[T; N]],
    v: u32,
    fan: u32,
    ring: &mut LocalRing,
    spokes: &mut Vec<Spoke>,
) {
    let t = step.topology;
    let wide =
        |p: [T; N]| -> Point { std::array::from_fn(|k| p.get(k).map_or(0.0, |c| c.to_f64())) };
    let at = |h: u32| &points[index[h as usize] as usize];
    let triangles = step.options.scheme == Scheme::Loop;
    ring.clear(t.fans()[fan as usize].closed, triangles);
    let masks_hold = triangles
        || t.all_quads()
        || Ring::of_fan(t, fan).all(|h| t.face_halves(t.face_of(h)).len() == 4);
    step.incidence.spokes(t, v, spokes);
    let semi_sharp = is_semi_sharp(t.vertex_sharpness(v))
        || spokes
            .iter()
            .any(|s| is_semi_sharp(t.edge_sharpness(s.edge)));
    let face_point = |f: u32| face::value(step, f, index, points);
    let here = masks_hold && !semi_sharp || step.is_linear();
    if here {
        ring.x = wide(*at(t.fans[v as usize].first));
        ring.sigma = t.vertex_sharpness(v);
    } else {
        ring.x = wide(vertex::value(step, v, spokes, index, points, face_point));
        ring.sigma = step.child_vertex(v);
    }
    spokes.clear();
    super::ring::fan_spokes(t, fan, spokes);
    for s in spokes.iter() {
        if here {
            let sharpness = t.edge_sharpness(s.edge);
            ring.push_edge(wide(*at(s.far_corner)), sharpness, sharpness);
        } else {
            let children = step.child_edge(s.edge);
            let near = children[s.end as usize];
            let far = children[1 - s.end as usize];
            ring.push_edge(
                wide(edge::value(step, s.edge, index, points, face_point)),
                near,
                far,
            );
        }
    }
    let quads = Ring::of_fan(t, fan).take_while(|_| !triangles);
    for h in quads {
        ring.faces.push(if here {
            wide(*at(t.next(t.next(h))))
        } else {
            wide(face_point(t.face_of(h)))
        });
    }
    while ring.is_semi_sharp() {
        ring.advance(step.options.creases);
    }
}
