//! Derivatives of a surface, and of its texture coordinates, at points of a face's grid.

use super::Surface;
#[cfg(feature = "gpu")]
use super::displaced::{linear_derivatives, upright};
use crate::control::{Kind, Pieces, TreeChannel, levels_beyond};
use crate::dice::MAX_LEVEL;
use crate::dice::evaluate::{Jet, Leaf, Place, QuadEvaluator, Row};
use crate::dice::face::Part;
use crate::dice::triangle::{JetLines, TriangleChannel, TriangleEvaluator};
use crate::displace;
use crate::records::BLOCK_STRIDE;
use crate::simd::Level;
use std::ops::Range;

/// Derivatives at a point; second ones are zeros where there are none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Derivatives {
    pub(super) du: [f32; 3],
    pub(super) dv: [f32; 3],
    pub(super) second: [[f32; 3]; 3],
    /// At a [flat corner](crate::topology::Fan::is_flat), where both derivatives have one direction, the tangents of the surface: derivatives by
    /// parameters of their own, the same for all channels.
    pub(super) flat: Option<[[f32; 3]; 2]>,
}

impl Derivatives {
    /// Leaves them at place `k`; second ones if `ORDER` is 2.
    pub(super) fn put<const ORDER: u32>(&self, out: &mut displace::Jets, k: usize) {
        out.du.put(k, self.du);
        out.dv.put(k, self.dv);
        if ORDER > 1 {
            for (out, d) in out.second.iter_mut().zip(self.second) {
                out.put(k, d);
            }
        }
    }

    fn put_line(&self, out: &mut JetLines<'_>, k: usize) {
        let [du, dv] = &mut out.first;
        du.put(k, self.du);
        dv.put(k, self.dv);
        for (out, d) in out.second.iter_mut().flatten().zip(self.second) {
            out.put(k, d);
        }
    }

    fn of(jet: Jet, smooth: bool) -> Self {
        let second = [jet.duu.xyz(), jet.duv.xyz(), jet.dvv.xyz()];
        Self {
            du: jet.du.xyz(),
            dv: jet.dv.xyz(),
            second: if smooth { second } else { Default::default() },
            flat: None,
        }
    }
}

/// Evaluates one channel of one face at a time; what it has made of a face is kept until the next.
#[derive(Clone, Debug, Default)]
pub(super) struct Jets {
    quad: QuadEvaluator,
    triangle: TriangleEvaluator,
    row: Option<(Part, Row)>,
    /// Depth among the control levels, and face there.
    ready: Option<(u32, u32)>,
}

impl Jets {
    /// Forgets what was prepared: other points come.
    pub(super) fn forget(&mut self) {
        self.ready = None;
    }

    /// Derivatives at column `at[0]` and row `at[1]` of a face's grid, both from 0 to 1. None of interpolating surfaces.
    ///
    /// They do not depend on how many control levels there are.
    pub(super) fn at<const ORDER: u32>(
        &mut self,
        surface: &Surface,
        kind: Kind,
        face: u32,
        [s, t]: [f32; 2],
    ) -> Option<Derivatives> {
        let below = surface.below(kind, MAX_LEVEL, None);
        let (ready, site) = (&mut self.ready, |at| Site {
            kind,
            face,
            at,
            scale: 1.0,
            depth: 0,
            tip: false,
        });
        Some(if surface.triangles {
            let root = surface.triangle_channel(kind)?;
            let at = site([(s - t).max(0.0), t]);
            below_face::<_, ORDER>(&mut self.triangle, ready, (root, below.as_ref()), at)
        } else {
            let root = surface.channel(kind, None)?;
            let at = site([s, t]);
            below_face::<_, ORDER>(&mut self.quad, ready, (root, below.as_ref()), at)
        })
    }

    /// Derivatives along row `j` of a part of a face's grid, in `columns`, from place `at` of `out` on; second ones if `ORDER` is 2. Says
    /// whether there are any. Whole vectors are written: what is beyond the row means nothing.
    pub(super) fn row<const ORDER: u32>(
        &mut self,
        surface: &Surface,
        kind: Kind,
        face: u32,
        (part, j, columns): (Part, u32, Range<u32>),
        simd: Level,
        (out, at): (&mut displace::Jets, usize),
    ) -> bool {
        let scale = 1.0 / (1_u32 << part.level) as f32;
        let place = |i: u32, k: usize| (part.start[k] + i) as f32 * scale;
        let below = surface.below(kind, MAX_LEVEL, None);
        if surface.triangles {
            let t = place(j, 1);
            let us = columns.map(|i| place(i, 0) - t);
            let Some(root) = surface.triangle_channel(kind) else {
                return false;
            };
            let [uu, uv, vv] = &mut out.second;
            let mut out = JetLines {
                first: [&mut out.du, &mut out.dv],
                second: (ORDER > 1).then_some([uu, uv, vv]),
            };
            let of = (root, below.as_ref(), kind);
            self.triangle_line::<ORDER>(of, face, (us, t), simd, &mut out, at);
            return true;
        }
        if (below.as_ref()).is_some_and(|b| QuadEvaluator::is_refined(b, face)) {
            let t = place(j, 1);
            for (k, i) in columns.enumerate() {
                match self.at::<ORDER>(surface, kind, face, [place(i, 0), t]) {
                    Some(found) => found.put::<ORDER>(out, at + k),
                    None => return false,
                }
            }
            return true;
        }
        let Some(root) = surface.channel(kind, None) else {
            return false;
        };
        if self.ready != Some((0, face)) {
            self.quad.prepare(root, face);
            self.ready = Some((0, face));
        }
        let key = Part {
            start: [part.start[0], 0],
            ..part
        };
        let row = match &mut self.row {
            Some((of, row)) if *of == key => row,
            other => {
                let columns = (0..=part.segments).map(|i| place(i, 0));
                &mut other.insert((key, Row::of_columns(columns, simd))).1
            }
        };
        self.quad.grid_row::<ORDER>(root, place(j, 1), row);
        let [uu, uv, vv] = &mut out.second;
        let mut grids = [&mut out.du, &mut out.dv, uu, uv, vv];
        let orders = if ORDER > 1 { 5 } else { 2 };
        let all = columns.start as usize..columns.end as usize;
        for (k, grid) in grids.iter_mut().enumerate().take(orders) {
            let lines = [&mut grid.x, &mut grid.y, &mut grid.z];
            for (c, line) in lines.into_iter().enumerate() {
                let from = &row.derivative(k, c)[all.clone()];
                line[at..at + from.len()].copy_from_slice(from);
            }
        }
        for i in all.clone().filter(|&i| row.corner(i).is_some()) {
            for grid in &mut grids[2..] {
                grid.put(at + i - all.start, [0.0; 3]);
            }
        }
        true
    }

    /// A row of a triangle: places `us` on a line of constant `v`.
    fn triangle_line<const ORDER: u32>(
        &mut self,
        (root, below, kind): (TriangleChannel<'_>, Option<&TreeChannel<'_>>, Kind),
        face: u32,
        (us, v): (impl Iterator<Item = f32>, f32),
        simd: Level,
        out: &mut JetLines<'_>,
        mut at: usize,
    ) {
        let (mut line, mut count) = ([0.0; BLOCK_STRIDE], 0);
        let Some(below) = below.filter(|b| TriangleEvaluator::is_refined(b, face)) else {
            for (out, u) in line.iter_mut().zip(us) {
                *out = u;
                count += 1;
            }
            let of = whole(root, face, [line[0], v]);
            return self.put_line::<ORDER>(&of, &line[..count], simd, out, at);
        };
        // Of the patch that holds the last places, which wait to be evaluated together.
        let mut waiting: Option<Leaf<TriangleChannel<'_>>> = None;
        for u in us {
            let found = TriangleEvaluator::leaf(below, face, [u, v], true);
            let found = found.unwrap_or_else(|| whole(root, face, [u, v]));
            let goes_on = waiting.as_ref().is_some_and(|w| {
                (w.depth, w.quad, w.tip) == (found.depth, found.quad, found.tip)
                    && w.at[1] == found.at[1]
            });
            if !goes_on && let Some(of) = waiting.take() {
                self.put_line::<ORDER>(&of, &line[..count], simd, out, at);
                at += count;
                count = 0;
            }
            if found.open {
                let site = Site {
                    kind,
                    face,
                    at: [u, v],
                    scale: 1.0,
                    depth: 0,
                    tip: false,
                };
                let of = (root, Some(below));
                below_face::<_, ORDER>(&mut self.triangle, &mut self.ready, of, site)
                    .put_line(out, at);
                at += 1;
                continue;
            }
            line[count] = found.at[0];
            count += 1;
            waiting.get_or_insert(found);
        }
        if let Some(of) = waiting {
            self.put_line::<ORDER>(&of, &line[..count], simd, out, at);
        }
    }

    fn put_line<const ORDER: u32>(
        &mut self,
        of: &Leaf<TriangleChannel<'_>>,
        us: &[f32],
        simd: Level,
        out: &mut JetLines<'_>,
        at: usize,
    ) {
        if self.ready != Some((of.depth, of.quad)) {
            self.triangle.prepare(of.channel, of.quad);
            self.ready = Some((of.depth, of.quad));
        }
        let line = (us, of.at[1]);
        self.triangle
            .line::<ORDER>(of.channel, line, of.scale, simd, (&mut *out, at));
        if let Some(second) = out.second.as_mut().filter(|_| of.tip.is_some()) {
            for grid in second.iter_mut() {
                (at..at + us.len()).for_each(|k| grid.put(k, [0.0; 3]));
            }
        }
    }
}

/// Derivatives of a surface at places, for who keeps no grids.
#[cfg(feature = "gpu")]
pub(crate) struct PlaceJets<'a> {
    surface: &'a Surface,
    points: Jets,
    uvs: Jets,
}

#[cfg(feature = "gpu")]
impl<'a> PlaceJets<'a> {
    pub(crate) fn new(surface: &'a Surface) -> Self {
        Self {
            surface,
            points: Jets::default(),
            uvs: Jets::default(),
        }
    }

    /// By u, by v, by u twice, by u and v, by v twice, at column and row `at` of quad `q`, both from 0 to 1; second ones are zeros where
    /// there are none. At [flat corners](crate::topology::Fan::is_flat) the tangents. None of interpolating surfaces.
    pub(crate) fn points(&mut self, q: u32, at: [f32; 2]) -> Option<[[f32; 3]; 5]> {
        let found = (self.points).at::<2>(self.surface, Kind::Points, q, at)?;
        let [uu, uv, vv] = found.second;
        let [du, dv] = found.flat.unwrap_or([found.du, found.dv]);
        Some([du, dv, uu, uv, vv])
    }

    /// The tangents at a corner of a quad where both derivatives have one direction; nothing at other places.
    pub(crate) fn flat(&mut self, q: u32, at: [f32; 2]) -> Option<[[f32; 3]; 2]> {
        self.flat_ways(q, at)?.flat
    }

    fn flat_ways(&mut self, q: u32, at: [f32; 2]) -> Option<Derivatives> {
        const CORNERS: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let c = CORNERS.iter().position(|&c| c == at)? as u32;
        let halves = self.surface.quads().face_halves(q);
        let h = halves.clone().nth(c as usize)?;
        if !self.surface.is_flat_corner(h) {
            return None;
        }
        let found = (self.points).at::<1>(self.surface, Kind::Points, q, at)?;
        found.flat.is_some().then_some(found)
    }

    /// The first two of the texture coordinates. At flat corners of the surface by the parameters of its tangents, whose points have to differ
    /// then.
    pub(crate) fn uvs(&mut self, q: u32, at: [f32; 2]) -> Option<[[f32; 2]; 2]> {
        let surface = self.surface;
        let found = match surface.has_linear_uvs() {
            true => linear_derivatives(surface, q, surface.triangles, at),
            false => (self.uvs).at::<1>(surface, Kind::Uvs, q, at)?,
        };
        let by = match self.flat_ways(q, at) {
            Some(ways) => found.flat.unwrap_or_else(|| upright(&ways, &found)),
            None => [found.du, found.dv],
        };
        Some(by.map(|[u, v, _]| [u, v]))
    }
}

/// A place of a face, of the surface or where a tree goes on below one.
struct Site {
    kind: Kind,
    face: u32,
    at: [f32; 2],
    /// How much faster the place runs than that of the surface's face.
    scale: f32,
    /// Depth of the face among the control levels of the surface.
    depth: u32,
    /// Whether it is a corner of the surface's face that is a feature.
    tip: bool,
}

/// Derivatives at a place: of the patch that holds it, in levels below the face.
///
/// Where levels end before the patch does, they go on for this place alone, so what is found does not depend on how many there are
/// (`evaluate` does the same).
fn below_face<'a, P: Pieces, const ORDER: u32>(
    patches: &mut P,
    ready: &mut Option<(u32, u32)>,
    (root, below): (P::Channel<'a>, Option<&'a TreeChannel<'a>>),
    site: Site,
) -> Derivatives {
    let is_whole = site.depth == 0 || site.depth == MAX_LEVEL;
    let found = below.and_then(|b| P::leaf(b, site.face, site.at, is_whole));
    let leaf = found.unwrap_or_else(|| whole(root, site.face, site.at));
    let (scale, tip) = (site.scale * leaf.scale, site.tip || leaf.tip.is_some());
    let depth = (site.depth + leaf.depth).min(MAX_LEVEL);
    let ends = depth == MAX_LEVEL && (tip || leaf.value.is_some());
    if let Some(below) = below.filter(|_| leaf.open && !ends) {
        let levels = levels_beyond(depth);
        if let Some((tree, face)) = below.continued(leaf.depth, leaf.quad, levels) {
            let further = tree.channel(site.kind, levels, None);
            if let Some(root) = P::root(&further) {
                let site = Site {
                    face,
                    at: leaf.at,
                    scale,
                    depth,
                    tip: tip && depth < MAX_LEVEL,
                    ..site
                };
                // Faces of that tree have numbers of their own.
                *ready = None;
                let found = below_face::<P, ORDER>(patches, ready, (root, Some(&further)), site);
                *ready = None;
                return found;
            }
        }
    }
    if *ready != Some((leaf.depth, leaf.quad)) {
        patches.prepare(leaf.channel, leaf.quad);
        *ready = Some((leaf.depth, leaf.quad));
    }
    let found = patches.at::<ORDER>(leaf.channel, leaf.at[0], leaf.at[1]);
    let mut out = derivatives::<ORDER>(found, scale, tip);
    if let Place::Corner(_, c) = found {
        out.flat = P::flat_tangents(leaf.channel, leaf.quad, c, scale);
    }
    out
}

/// The face itself is the patch.
fn whole<C>(channel: C, quad: u32, at: [f32; 2]) -> Leaf<C> {
    Leaf {
        channel,
        depth: 0,
        quad,
        at,
        scale: 1.0,
        tip: None,
        value: None,
        open: false,
    }
}

fn derivatives<const ORDER: u32>(found: Place, scale: f32, tip: bool) -> Derivatives {
    match found {
        Place::Smooth(jet) => Derivatives::of(jet.scaled::<ORDER>(scale), !tip),
        Place::Corner(jet, _) => Derivatives::of(jet.scaled::<ORDER>(scale), false),
    }
}
