//! Normals of the interpolating schemes: two tangents from the two rings of a vertex one level on.
//!
//! Every sector between cuts (boundaries, infinitely sharp edges) has a normal of its own. One level on all new vertices are regular, which
//! is what the masks of Butterfly need. Kobbelt's rules reach one face further: where a neighbour is extraordinary, the surroundings are
//! cut out and refined once more.

use super::rings::{RingMasks, gather};
use super::sectors::{across, cross, dot, minus, unit};
use super::{Point, VertexLimit};
use crate::mesh::{Corner, Crease};
use crate::refine::connectivity::{Split, child_corner};
use crate::refine::interpolating::{Masks, Sheets};
use crate::refine::real::{Real, add, add_scaled};
use crate::refine::sharpness::Step;
use crate::refine::{Level, Options, Timings};
use crate::scheme::{Boundary, INFINITE_SHARPNESS, Scheme};
use crate::topology::{ConnectOptions, NONE, Ring, Topology, connect};
use std::collections::{BTreeMap, BTreeSet};

/// Most faces that are cut out around a vertex.
const MOST_FACES: usize = 4096;
/// Faces that are cut out lie within so many rings.
const RINGS: usize = 3;

/// Position and normals of vertex `v`.
pub(super) fn vertex_limit<T: Real>(
    step: &Step<'_>,
    masks: &RingMasks,
    points: &[[T; 3]],
    v: u32,
) -> VertexLimit {
    let t = step.topology;
    let mut out = VertexLimit {
        position: points[v as usize].map(T::to_f64),
        normal: [0.0, 0.0, 1.0],
        corners: Vec::new(),
    };
    if t.fans[v as usize].first == NONE {
        return out;
    }
    let sheets = Sheets::<T, f64, 3>::of_points(step, &masks.stencils, points);
    let mut sectors = 0;
    for fan in std::iter::once(v).chain(step.incidence.extra_fans(v)) {
        let mut starts: Vec<u32> = Ring::of_fan(t, fan)
            .filter(|&h| sheets.twin(h) == NONE)
            .collect();
        if starts.is_empty() {
            starts.push(t.fans[fan as usize].first);
        }
        for start in starts {
            let normal = sector_normal(step, masks, points, start, 2);
            out.corners
                .extend(sheets.around(start).map(|h| (h, normal)));
            sectors += 1;
        }
    }
    out.normal = out.corners.first().map_or(out.normal, |c| c.1);
    if sectors < 2 {
        out.corners.clear();
    }
    out
}

/// The half-edges of one sector of a vertex.
pub(super) struct Sector {
    pub(super) halves: Vec<u32>,
    pub(super) closed: bool,
}

impl Sector {
    /// The sector that begins with half-edge `start`.
    pub(super) fn new<T: Real>(t: &Topology, sheets: &Sheets<'_, T, f64, 3>, start: u32) -> Self {
        let halves: Vec<u32> = sheets.around(start).collect();
        let last = halves[halves.len() - 1];
        Self {
            closed: sheets.twin(t.prev(last)) == start,
            halves,
        }
    }

    /// Whether the rows of quads do not go straight on beyond a neighbour.
    pub(super) fn has_odd_neighbour<T: Real>(
        &self,
        t: &Topology,
        sheets: &Sheets<'_, T, f64, 3>,
    ) -> bool {
        let inner = if self.closed {
            &self.halves[..]
        } else {
            &self.halves[1..]
        };
        inner.iter().any(|&h| sheets.is_irregular(t.next(h)))
    }
}

/// Tangents as linear maps, of vertices that refinement put into edges and faces: their rings are regular.
#[derive(Debug)]
pub(crate) struct Tangents(RingMasks);

impl Tangents {
    pub(crate) fn new(scheme: Scheme) -> Self {
        Self(RingMasks::new(scheme))
    }

    pub(super) fn rings(&self) -> &RingMasks {
        &self.0
    }

    /// Masks of the scheme itself.
    pub(crate) fn masks(&self) -> &Masks {
        &self.0.stencils
    }

    /// Two tangents, whose cross product points outward, in the sector of corner `h` of a mesh that is cut along its creases. Neighbours
    /// must be regular in Kobbelt's scheme.
    pub(crate) fn at<const N: usize>(
        &self,
        t: &Topology,
        sheets: &Sheets<'_, f64, f64, N>,
        h: u32,
    ) -> Option<[[f64; N]; 2]> {
        let start = sheets.start(h);
        let halves: Vec<u32> = sheets.around(start).collect();
        let closed = sheets.twin(start) != NONE;
        let count = halves.len();
        let quads = self.0.scheme == Scheme::Kobbelt;
        // Amid a regular grid both tangents are differences along its rows, with no need of the next level.
        if let (true, true, &[a, b, c, d]) = (quads, closed, &halves[..]) {
            let row = |a: u32, c: u32| -> Option<[f64; N]> {
                let (p, q) = (sheets.at(t.next(a)), sheets.at(t.next(c)));
                let (far_p, far_q) = (straight_on(t, sheets, a)?, straight_on(t, sheets, c)?);
                let difference = |k: usize| 8.0 * (p[k] - q[k]) - (far_p[k] - far_q[k]);
                Some(std::array::from_fn(difference))
            };
            if let (Some(u), Some(v)) = (row(a, c), row(b, d)) {
                return Some([u, v]);
            }
        }
        let ring = gather(t, sheets, self.0.scheme, &halves, closed);
        let x = sheets.at(start);
        if closed {
            return self.0.closed(count as u32, &ring, &x);
        }
        let straight = count + 1 + if quads { 0 } else { count };
        let along = std::array::from_fn(|k| {
            let far = ring[straight + count][k] - ring[straight][k];
            far + 8.0 * (ring[0][k] - ring[count][k])
        });
        let inward = self.0.across(count as u32, &ring, &x)?;
        Some([along, inward])
    }
}

/// The vertex straight beyond the far end of `h`, if four quads meet there.
fn straight_on<const N: usize>(
    t: &Topology,
    sheets: &Sheets<'_, f64, f64, N>,
    h: u32,
) -> Option<[f64; N]> {
    let next = t.next(h);
    let twin = sheets.twin(next);
    if twin == NONE || sheets.is_irregular(next) {
        return None;
    }
    Some(sheets.at(t.next(t.next(twin))))
}

/// The normal of the sector that begins with half-edge `start`; `spare` is how often the surroundings may be refined first.
pub(super) fn sector_normal<T: Real>(
    step: &Step<'_>,
    masks: &RingMasks,
    points: &[[T; 3]],
    start: u32,
    spare: u32,
) -> Point {
    let t = step.topology;
    let sheets = Sheets::<T, f64, 3>::of_points(step, &masks.stencils, points);
    let sector = Sector::new(t, &sheets, start);
    let linear = step.is_linear();
    let quads = masks.scheme == Scheme::Kobbelt;
    if spare > 0 && quads && (linear || sector.has_odd_neighbour(t, &sheets)) {
        let refined = refined_around(step, points, t.vertex(start), start);
        if let Some((level, corner)) = refined {
            let options = Options {
                scheme: masks.scheme,
                ..step.options
            };
            let step = Step::new(&level.topology, &options);
            return sector_normal(&step, masks, &level.points, corner, spare - 1);
        }
    }
    let Sector { halves, closed } = sector;
    let last = halves[halves.len() - 1];
    let x = sheets.at(start);
    if linear {
        return flat_normal(t, &sheets, &halves, closed, &[], &x);
    }
    let ring = gather(t, &sheets, masks.scheme, &halves, closed);
    let normal = if closed {
        masks
            .closed(halves.len() as u32, &ring, &x)
            .and_then(across)
    } else {
        let count = halves.len();
        // The end of edge i, and what is straight beyond it: edge and vertex of one row.
        let straight = count + 1 + if quads { 0 } else { count };
        let rows = [0, count].map(|i| (minus(&ring[i], &x), minus(&ring[straight + i], &x)));
        if sheets.runs_through(start) {
            let [(p1, p2), (q1, q2)] = rows;
            let mut along = minus(&q2, &p2);
            add_scaled(&mut along, 8.0, &minus(&p1, &q1));
            masks
                .across(count as u32, &ring, &x)
                .and_then(|inward| across([along, inward]))
        } else {
            // Where a row ends it is continued by its mirror image.
            let ends = rows.map(|(near, far)| {
                let mut d = near.map(|c| 8.0 * c);
                add_scaled(&mut d, -1.0, &far);
                d
            });
            let is_dart = t.twin(start) == t.prev(last);
            let second = if is_dart {
                let mut sum = [0.0; 3];
                for (i, p) in ring[..count].iter().enumerate() {
                    let angle = std::f64::consts::TAU * i as f64 / count as f64;
                    add_scaled(&mut sum, libm::sin(angle), &minus(p, &x));
                }
                sum
            } else {
                ends[1]
            };
            // Two tangents know the plane, but not which side of a reflex angle is the sector.
            let faces = turning(&ring, count, closed, &x);
            across([ends[0], second]).map(|n| match dot(&n, &faces) < 0.0 {
                true => n.map(|c| -c),
                false => n,
            })
        }
    };
    normal.unwrap_or_else(|| flat_normal(t, &sheets, &halves, closed, &ring, &x))
}

/// Sum of the normals of the triangles between the first `count` edges of a ring and the next.
fn turning(ring: &[Point], count: usize, closed: bool, x: &Point) -> Point {
    let mut sum = [0.0; 3];
    for i in 0..count {
        let next = if closed { (i + 1) % count } else { i + 1 };
        add(
            &mut sum,
            &cross(&minus(&ring[i], x), &minus(&ring[next], x)),
        );
    }
    sum
}

/// A normal from faces: those one level on, or those of this level.
fn flat_normal<T: Real>(
    t: &Topology,
    sheets: &Sheets<'_, T, f64, 3>,
    halves: &[u32],
    closed: bool,
    ring: &[Point],
    x: &Point,
) -> Point {
    let of_corner = |&h: &u32| {
        let (a, b) = (sheets.at(t.next(h)), sheets.at(t.prev(h)));
        unit(cross(&minus(&a, x), &minus(&b, x)))
    };
    let here = || {
        let mut sum = [0.0; 3];
        let normals = halves.iter().filter_map(of_corner);
        normals.for_each(|n| add(&mut sum, &n));
        unit(sum)
    };
    (!ring.is_empty())
        .then(|| turning(ring, halves.len(), closed, x))
        .and_then(unit)
        .or_else(here)
        .or_else(|| halves.iter().find_map(of_corner))
        .unwrap_or([0.0, 0.0, 1.0])
}

/// The surroundings of vertex `v`, one level on, and the corner there that descends from corner `h`.
pub(super) fn refined_around<T: Real>(
    step: &Step<'_>,
    points: &[[T; 3]],
    v: u32,
    h: u32,
) -> Option<(Level<f64>, u32)> {
    let t = step.topology;
    let mut faces = BTreeSet::new();
    let mut rim = BTreeSet::from([v]);
    let mut seen = rim.clone();
    for _ in 0..RINGS {
        let mut next = BTreeSet::new();
        for &u in &rim {
            for fan in std::iter::once(u).chain(step.incidence.extra_fans(u)) {
                for half in Ring::of_fan(t, fan) {
                    if !faces.insert(t.face_of(half)) {
                        continue;
                    }
                    let corners = t.face_halves(t.face_of(half)).map(|g| t.vertex(g));
                    next.extend(corners.filter(|w| seen.insert(*w)));
                    if faces.len() > MOST_FACES {
                        return None;
                    }
                }
            }
        }
        rim = next;
    }
    let mut names = BTreeMap::new();
    for &u in &seen {
        names.insert(u, names.len() as u32);
    }
    let mut corners = Vec::new();
    let mut offsets = vec![0];
    let mut creases = Vec::new();
    let mut corner = None;
    for &f in &faces {
        for g in t.face_halves(f) {
            if g == h {
                corner = Some(corners.len() as u32);
            }
            corners.push(names[&t.vertex(g)]);
            if !t.edge_sharpness.is_empty() && t.edge_sharpness(t.edge(g)) > 0.0 {
                creases.push(Crease {
                    vertices: [names[&t.vertex(g)], names[&t.vertex(t.next(g))]],
                    sharpness: t.edge_sharpness(t.edge(g)),
                });
            }
        }
        offsets.push(corners.len() as u32);
    }
    let sharp: Vec<Corner> = names
        .iter()
        .filter(|&(&u, _)| t.vertex_sharpness(u) >= INFINITE_SHARPNESS)
        .map(|(_, &vertex)| Corner {
            vertex,
            sharpness: INFINITE_SHARPNESS,
        })
        .collect();
    let options = ConnectOptions {
        boundary: Boundary::EdgeOnly,
        creases: &creases,
        corners: &sharp,
        holes: &[],
    };
    let (sub, _) = connect(names.len(), &offsets, corners, &options);
    let positions = seen.iter().map(|&u| points[u as usize].map(T::to_f64));
    let child = child_corner(Split::Quads, &sub, corner?, 0);
    let level = Level::new(sub, positions.collect()).ok()?;
    // Where the whole mesh takes a linear step, so does this part of it.
    let scheme = match step.is_linear() {
        true => Scheme::Bilinear,
        false => step.options.scheme,
    };
    let options = Options {
        scheme,
        ..step.options
    };
    let next = level.next(&options, &mut Timings::default()).ok()?;
    Some((next, child))
}
