//! Points of the interpolating schemes, Modified Butterfly and Kobbelt's: vertices stay, edges and faces get points from two rings.
//!
//! Both schemes see the mesh as *sheets*, cut along boundaries, infinitely sharp edges, and (for texture coordinates) seams. Along a cut
//! the four-point rule of curves holds; nothing beside it takes part. Semi-sharp edges mean nothing to either scheme.
//!
//! Every sum is ordered by place relative to the edge or face, never by number: pairs that lie alike on both sides are added first, and
//! rings are run through counter-clockwise from the edge. So an edge has the same bits seen from either end, and in every part of the mesh
//! that holds its two rings. Numbers count in one place only: where the two sides of a cut edge could differ, that of the lower face is
//! taken. Parts that keep the order of faces (and where each face begins) keep it on all levels.

use super::face_varying::{Sibling, SiblingKind};
use super::real::{Real, add, add_scaled, midpoint, scaled};
use super::sharpness::Step;
use crate::scheme::by_valence::ByValence;
use crate::scheme::crease::{is_infinite, is_semi_sharp};
use crate::scheme::{Scheme, butterfly, kobbelt};
use crate::topology::{NONE, Ring, Topology};
use std::marker::PhantomData;

/// Whether `t` has semi-sharp edges or vertices, which interpolating schemes ignore.
#[must_use]
pub fn has_semi_sharp(t: &Topology) -> bool {
    let any = |values: &[f32]| values.iter().any(|&s| is_semi_sharp(s));
    any(&t.edge_sharpness) || any(&t.vertex_sharpness)
}

/// Masks of both schemes, made when first needed.
#[derive(Debug)]
pub struct Masks {
    extraordinary: ByValence<Vec<f64>>,
    beyond: ByValence<[Vec<f64>; 2]>,
}

impl Default for Masks {
    fn default() -> Self {
        Self {
            extraordinary: ByValence::new(butterfly::extraordinary),
            beyond: ByValence::new(kobbelt::beyond),
        }
    }
}

/// Where a channel is linear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Linear {
    /// Nowhere.
    Never,
    /// On cut edges.
    Cuts,
    /// Everywhere.
    Always,
}

/// Values over the sheets of a mesh. `T` is what values are stored in, `R` what is computed in.
pub(crate) struct Sheets<'a, T, R, const N: usize> {
    step: &'a Step<'a>,
    masks: &'a Masks,
    /// Value of every corner.
    index: &'a [u32],
    values: &'a [[T; N]],
    /// Values where corners disagree, sorted; those that are corners end their curves.
    siblings: &'a [Sibling],
    linear: Linear,
    /// Whether edges of two faces may be cut: values of vertices agree on both sides.
    cuts: bool,
    computed: PhantomData<R>,
}

impl<'a, T: Real, R: Real, const N: usize> Sheets<'a, T, R, N> {
    /// Values of vertices.
    pub(crate) fn of_points(step: &'a Step<'a>, masks: &'a Masks, values: &'a [[T; N]]) -> Self {
        Self {
            step,
            masks,
            index: &step.topology.corner_vertices,
            values,
            siblings: &[],
            linear: Linear::Never,
            cuts: !step.topology.edge_sharpness.is_empty(),
            computed: PhantomData,
        }
    }

    /// Values of corners.
    pub(crate) fn of_corners(
        step: &'a Step<'a>,
        masks: &'a Masks,
        index: &'a [u32],
        values: &'a [[T; N]],
        siblings: &'a [Sibling],
        linear: Linear,
    ) -> Self {
        Self {
            step,
            masks,
            index,
            values,
            siblings,
            linear,
            cuts: true,
            computed: PhantomData,
        }
    }

    /// The mesh.
    pub(crate) fn topology(&self) -> &'a Topology {
        self.step.topology
    }

    /// The value at corner `h`.
    #[inline]
    pub(crate) fn at(&self, h: u32) -> [R; N] {
        self.values[self.index[h as usize] as usize].map(|c| R::from_f64(c.to_f64()))
    }

    /// The opposite half-edge unless the edge is cut.
    #[inline]
    pub(crate) fn twin(&self, h: u32) -> u32 {
        let t = self.step.topology;
        let g = t.twin(h);
        if g == NONE || !self.cuts {
            return g;
        }
        let joined = self.index[h as usize] == self.index[t.next(g) as usize]
            && self.index[t.next(h) as usize] == self.index[g as usize]
            && (t.edge_sharpness.is_empty() || !is_infinite(t.edge_sharpness(t.edge(h))));
        if joined { g } else { NONE }
    }

    /// Half-edges of the sheet around the vertex of `h`, counter-clockwise from `h`, up to a cut or once around.
    pub(crate) fn around(&self, h: u32) -> impl Iterator<Item = u32> + '_ {
        let t = self.step.topology;
        let turn = move |x: &u32| Some(self.twin(t.prev(*x))).filter(|&g| g != NONE && g != h);
        std::iter::successors(Some(h), turn)
    }

    /// The half-edge at the vertex of `h` with which its sector begins: `h` itself where the sector is closed.
    pub(crate) fn start(&self, h: u32) -> u32 {
        let t = self.step.topology;
        let back = |&x: &u32| Some(self.twin(x)).filter(|&g| g != NONE).map(|g| t.next(g));
        let mut at = h;
        while let Some(before) = back(&at) {
            if before == h {
                return h;
            }
            at = before;
        }
        at
    }

    /// Number of faces around the vertex of `h` if they close.
    pub(crate) fn closed(&self, h: u32) -> Option<u32> {
        let t = self.step.topology;
        let (count, last) = self.around(h).fold((0, h), |(n, _), x| (n + 1, x));
        (self.twin(t.prev(last)) == h).then_some(count)
    }

    /// Whether the sheet around the vertex of `h` is other than a grid's: not four faces, or two of a cut one, or one of a corner.
    pub(crate) fn is_irregular(&self, h: u32) -> bool {
        if let Some(n) = self.closed(h) {
            return n != 4;
        }
        let t = self.step.topology;
        let back = std::iter::successors(Some(h), |&x| {
            Some(self.twin(x)).filter(|&g| g != NONE).map(|g| t.next(g))
        });
        self.around(h).count() + back.count() - 1 > 2
    }

    /// Whether a cut runs smoothly through the vertex of `h`: it has two cut edges, is whole and no corner.
    pub(crate) fn runs_through(&self, h: u32) -> bool {
        let t = self.step.topology;
        let v = t.vertex(h);
        let is_corner = || {
            let value = self.index[h as usize];
            let found = self.siblings.binary_search_by_key(&value, |s| s.value);
            found.is_ok_and(|rank| self.siblings[rank].kind == SiblingKind::Corner)
        };
        if is_infinite(t.vertex_sharpness(v))
            || self.step.incidence.extra_fans(v).next().is_some()
            || is_corner()
        {
            return false;
        }
        let cuts = Ring::of_fan(t, v).filter(|&x| self.twin(x) == NONE).count();
        cuts + usize::from(!t.fans[v as usize].closed) == 2
    }

    /// The half-edge that speaks for edge `e`: the one of lower number, which only matters where the sides of a cut differ.
    pub(crate) fn side(&self, e: u32) -> u32 {
        self.step.topology.edge_half(e)
    }

    /// The point of the edge of `h`.
    pub(crate) fn edge_point(&self, h: u32) -> [R; N] {
        let t = self.step.topology;
        let (a, b) = (self.at(h), self.at(t.next(h)));
        if self.linear == Linear::Always || self.step.is_linear() {
            return midpoint(&a, &b);
        }
        let twin = self.twin(h);
        if twin != NONE && self.step.options.scheme == Scheme::Kobbelt {
            return four_points(&a, &b, &self.beyond(h), &self.beyond(twin));
        }
        if twin != NONE {
            return self.butterfly(h, twin);
        }
        if self.linear == Linear::Cuts {
            return midpoint(&a, &b);
        }
        let before = if self.runs_through(h) {
            // Counter-clockwise from the cut to the next one.
            self.at(t.prev(self.around(h).last().unwrap_or(h)))
        } else {
            mirrored(&a, &b)
        };
        let after = if self.runs_through(t.next(h)) {
            let mut x = t.next(h);
            while self.twin(x) != NONE {
                x = t.next(self.twin(x));
            }
            self.at(t.next(x))
        } else {
            mirrored(&b, &a)
        };
        four_points(&a, &b, &before, &after)
    }

    fn butterfly(&self, h: u32, twin: u32) -> [R; N] {
        // Two triangles around a vertex have no rule of their own.
        let odd = |h: u32| self.closed(h).filter(|&k| k != 6 && k > 2);
        match (odd(h), odd(twin)) {
            (None, None) => self.eight_points(h, twin),
            (Some(k), None) => self.extraordinary(h, k),
            (None, Some(k)) => self.extraordinary(twin, k),
            (Some(j), Some(k)) => midpoint(&self.extraordinary(h, j), &self.extraordinary(twin, k)),
        }
    }

    fn extraordinary(&self, h: u32, k: u32) -> [R; N] {
        let t = self.step.topology;
        self.masks.extraordinary.with(k, |mask| {
            let mut point = scaled(butterfly::EXTRAORDINARY_VERTEX, &self.at(h));
            for (x, w) in self.around(h).zip(mask) {
                add_scaled(&mut point, *w, &self.at(t.next(x)));
            }
            point
        })
    }

    fn eight_points(&self, h: u32, twin: u32) -> [R; N] {
        let t = self.step.topology;
        let wings = |h: u32| [self.wing(t.next(h)), self.wing(t.prev(h))];
        let (near, far) = (wings(h), wings(twin));
        eight_points(
            [&self.at(h), &self.at(t.next(h))],
            [&self.at(t.prev(h)), &self.at(t.prev(twin))],
            [near.each_ref(), far.each_ref()],
        )
    }

    /// The vertex beyond side `h` of a triangle; past a cut the one that makes a parallelogram of its own triangle.
    fn wing(&self, h: u32) -> [R; N] {
        let t = self.step.topology;
        let twin = self.twin(h);
        if twin != NONE {
            return self.at(t.prev(twin));
        }
        let mut point = self.at(h);
        add(&mut point, &self.at(t.next(h)));
        add_scaled(&mut point, -1.0, &self.at(t.prev(h)));
        point
    }

    /// What lies straight on beyond the vertex of `h`, seen from the other end of `h`.
    fn beyond(&self, h: u32) -> [R; N] {
        let t = self.step.topology;
        let end = |x: u32| self.at(t.next(x));
        match self.closed(h) {
            None => mirrored(&self.at(h), &end(h)),
            Some(4) => end(self.around(h).nth(2).unwrap_or(h)),
            Some(n) => self.masks.beyond.with(n, |[ends, opposite]| {
                let mut point = [R::default(); N];
                for ((x, a), b) in self.around(h).zip(ends).zip(opposite) {
                    add_scaled(&mut point, *a, &end(x));
                    add_scaled(&mut point, *b, &end(t.next(x)));
                }
                point
            }),
        }
    }

    /// Kobbelt's point of the quad that starts with `h`, from the points of edges.
    pub(crate) fn face_point(&self, h: u32, edge_point: impl Fn(u32) -> [R; N]) -> [R; N] {
        let t = self.step.topology;
        let sides = [h, t.next(h), t.next(t.next(h)), t.prev(h)];
        // The side of the next quad that is parallel to side `h`, if it is not cut off.
        let parallel = |h: u32| {
            let g = self.twin(h);
            (g != NONE).then(|| t.next(t.next(g)))
        };
        let across = |h: u32, opposite: u32| {
            let (a, b) = (edge_point(h), edge_point(opposite));
            let outer = |side: u32, near: &[R; N], far: &[R; N]| match parallel(side) {
                Some(x) => edge_point(x),
                None => mirrored(near, far),
            };
            four_points(&a, &b, &outer(h, &a, &b), &outer(opposite, &b, &a))
        };
        let touches = |h: u32, opposite: u32| {
            [h, opposite]
                .into_iter()
                .filter_map(parallel)
                .any(|x| self.is_irregular(x) || self.is_irregular(t.next(x)))
        };
        let [a, b, c, d] = sides;
        // Next to an extraordinary vertex both directions agree. One face on, the direction is right whose edges keep clear of it.
        let own = sides.into_iter().any(|x| self.is_irregular(x));
        let odd = match own {
            true => (false, false),
            false => (touches(a, c), touches(b, d)),
        };
        match odd {
            (true, false) => across(b, d),
            (false, true) => across(a, c),
            _ => midpoint(&across(a, c), &across(b, d)),
        }
    }
}

/// Butterfly's point of a regular edge: of its ends, the vertices opposite it, and those beyond the other sides of either triangle.
pub(crate) fn eight_points<R: Real, const N: usize>(
    ends: [&[R; N]; 2],
    opposite: [&[R; N]; 2],
    wings: [[&[R; N]; 2]; 2],
) -> [R; N] {
    let sum = |[a, b]: [&[R; N]; 2]| {
        let mut sum = *a;
        add(&mut sum, b);
        sum
    };
    let outer = wings.map(sum);
    let mut point = scaled(butterfly::EDGE_WING, &sum(outer.each_ref()));
    add_scaled(&mut point, butterfly::EDGE_OPPOSITE, &sum(opposite));
    add_scaled(&mut point, butterfly::EDGE_END, &sum(ends));
    point
}

/// The four-point rule between `a` and `b`.
pub(crate) fn four_points<R: Real, const N: usize>(
    a: &[R; N],
    b: &[R; N],
    before: &[R; N],
    after: &[R; N],
) -> [R; N] {
    let mut near = *a;
    add(&mut near, b);
    let mut far = *before;
    add(&mut far, after);
    let mut point = scaled(kobbelt::FAR, &far);
    add_scaled(&mut point, kobbelt::NEAR, &near);
    point
}

/// Beyond the end `a` of a row that comes from `b`: `2a - b`.
fn mirrored<R: Real, const N: usize>(a: &[R; N], b: &[R; N]) -> [R; N] {
    let mut point = scaled(2.0, a);
    add_scaled(&mut point, -1.0, b);
    point
}
