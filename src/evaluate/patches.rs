//! What evaluation needs of a kind of faces: quads of Catmull-Clark and bilinear surfaces, or triangles of Loop's.

use super::locate::{Local, child, is_unit};
use crate::control::{Kind, Pieces};
use crate::dice::evaluate::{self, Jet, QuadEvaluator, Row};
use crate::dice::face::Channel;
use crate::dice::triangle::{TriangleChannel, TriangleEvaluator, TriangleRow};
use crate::surface::Surface;
use std::cell::RefCell;

/// Position and derivatives along a row of a grid.
#[allow(private_interfaces, reason = "nobody outside can name it")]
pub trait GridRow {
    /// Writes what `to` makes of position, du and dv.
    fn tangents<S>(&self, out: &mut [S], to: impl Fn([[f32; 3]; 3]) -> S);
    /// All of it at place `i`.
    fn jet(&self, i: usize) -> Jet;
    /// The corner that place `i` is, if it is an irregular one.
    fn corner(&self, i: usize) -> Option<usize>;
}

impl GridRow for Row {
    #[inline(always)]
    fn tangents<S>(&self, out: &mut [S], to: impl Fn([[f32; 3]; 3]) -> S) {
        self.tangents(out, to);
    }
    #[inline(always)]
    fn jet(&self, i: usize) -> Jet {
        self.jet(i)
    }
    #[inline(always)]
    fn corner(&self, i: usize) -> Option<usize> {
        self.corner(i)
    }
}

impl GridRow for TriangleRow {
    #[inline(always)]
    fn tangents<S>(&self, out: &mut [S], to: impl Fn([[f32; 3]; 3]) -> S) {
        for (jet, out) in self.jets.iter().zip(out) {
            *out = to([jet.position.xyz(), jet.du.xyz(), jet.dv.xyz()]);
        }
    }
    #[inline(always)]
    fn jet(&self, i: usize) -> Jet {
        self.jets[i]
    }
    fn corner(&self, i: usize) -> Option<usize> {
        let found = self.corners.iter().find(|c| c.0 == i);
        found.map(|c| c.1)
    }
}

/// The evaluator of one face, and how places get to it.
#[allow(
    private_interfaces,
    private_bounds,
    reason = "nobody outside can name it"
)]
pub trait Patches: Pieces + Clone + std::fmt::Debug + Default {
    /// A row of a grid.
    type Row: GridRow;
    /// Both parameters in the middle of a face.
    const MIDDLE: f32;

    fn channel(surface: &Surface, kind: Kind) -> Option<Self::Channel<'_>>;
    /// Faces that are prepared.
    fn faces(channel: Self::Channel<'_>) -> usize;
    /// Limit point and normal of a corner, by the rule of its fan.
    fn corner(channel: Self::Channel<'_>, face: u32, corner: usize) -> ([f32; 3], [f32; 3]);
    /// Linear interpolation of the corners' control points.
    fn linear(channel: Self::Channel<'_>, at: Local) -> [f32; 2];

    /// Whether a parameter is on a face that is prepared.
    fn holds(u: f32, v: f32) -> bool;
    /// The place among prepared faces of a place of the cage.
    fn locate(surface: &Surface, face: u32, u: f32, v: f32) -> Option<Local>;
    fn nearest_corner(u: f32, v: f32) -> usize;
    /// The grid of `n` segments: samples, and their parameters in order.
    fn grid_len(n: u32) -> usize;
    fn grid_places(n: u32) -> impl Iterator<Item = [f32; 2]>;
    /// Faces of the surface that have a grid of their own in face `face` of the cage, and whether that grid is to be put together from
    /// the four children of a face that is split.
    fn grids(surface: &Surface, face: u32) -> (usize, bool);
    /// The place in the children of a split face, from `first` on.
    fn in_children(first: u32, u: f32, v: f32) -> Local;

    /// A face at one place, without preparing it, where there is such a way. The bits are those of [`Patches::at`].
    fn at_once<const ORDER: u32>(channel: Self::Channel<'_>, at: Local) -> Option<Jet>;
    /// Evaluates a grid of `n` segments row by row; `convert` writes a row's samples.
    fn rows<const ORDER: u32, S>(
        &mut self,
        channel: Self::Channel<'_>,
        n: u32,
        out: &mut [S],
        convert: impl Fn(&Self::Row, &mut [S]),
    );

    /// Lends an evaluator that keeps its memory from one place to the next.
    fn with_own<R>(then: impl FnOnce(&mut Self) -> R) -> R;
}

impl Patches for QuadEvaluator {
    type Row = Row;
    const MIDDLE: f32 = 0.5;

    fn channel(surface: &Surface, kind: Kind) -> Option<Channel<'_>> {
        surface.channel(kind, None)
    }
    fn faces(channel: Channel<'_>) -> usize {
        channel.topology.face_count()
    }
    fn corner(channel: Channel<'_>, face: u32, corner: usize) -> ([f32; 3], [f32; 3]) {
        let fan = channel.topology.fan(4 * face + corner as u32) as usize;
        let normal = channel.fans.normals.get(fan).copied();
        (channel.fans.limits[fan], normal.unwrap_or_default())
    }
    fn linear(channel: Channel<'_>, at: Local) -> [f32; 2] {
        let corner = |c: u32| channel.points[channel.topology.vertex(4 * at.face + c) as usize];
        let [a, b, c, d] = [0, 1, 2, 3].map(corner);
        let (s, t) = (at.u, at.v);
        [0, 1].map(|k: usize| {
            (a[k] * (1.0 - s) + b[k] * s) * (1.0 - t) + (d[k] * (1.0 - s) + c[k] * s) * t
        })
    }

    #[inline(always)]
    fn holds(u: f32, v: f32) -> bool {
        is_unit(u) && is_unit(v)
    }
    #[inline(always)]
    fn locate(surface: &Surface, face: u32, u: f32, v: f32) -> Option<Local> {
        surface.locate_quad(face, u, v)
    }
    fn nearest_corner(u: f32, v: f32) -> usize {
        [[0, 1], [3, 2]][usize::from(v >= 0.5)][usize::from(u >= 0.5)]
    }
    fn grid_len(n: u32) -> usize {
        let side = n as usize + 1;
        side.saturating_mul(side)
    }
    fn grid_places(n: u32) -> impl Iterator<Item = [f32; 2]> {
        let at = move |i: u32| i as f32 / n as f32;
        (0..=n).flat_map(move |j| (0..=n).map(move |i| [at(i), at(j)]))
    }
    fn grids(surface: &Surface, face: u32) -> (usize, bool) {
        match surface.topology().face_halves(face).len() {
            4 => (1, surface.is_split()),
            n => (n, false),
        }
    }
    fn in_children(first: u32, u: f32, v: f32) -> Local {
        child(first, u, v)
    }

    #[inline(always)]
    fn at_once<const ORDER: u32>(channel: Channel<'_>, at: Local) -> Option<Jet> {
        evaluate::at_once::<ORDER>(channel, at.face, at.u, at.v)
    }
    #[inline(always)]
    fn rows<const ORDER: u32, S>(
        &mut self,
        channel: Channel<'_>,
        n: u32,
        out: &mut [S],
        convert: impl Fn(&Row, &mut [S]),
    ) {
        let mut rows = out.chunks_exact_mut(n as usize + 1);
        self.grid::<ORDER>(channel, n, |row| {
            if let Some(out) = rows.next() {
                convert(row, out);
            }
        });
    }

    fn with_own<R>(then: impl FnOnce(&mut Self) -> R) -> R {
        thread_local! {
            static OWN: RefCell<QuadEvaluator> = RefCell::default();
        }
        OWN.with_borrow_mut(then)
    }
}

impl Patches for TriangleEvaluator {
    type Row = TriangleRow;
    const MIDDLE: f32 = 1.0 / 3.0;

    fn channel(surface: &Surface, kind: Kind) -> Option<TriangleChannel<'_>> {
        surface.triangle_channel(kind)
    }
    fn faces(channel: TriangleChannel<'_>) -> usize {
        channel.topology.face_count()
    }
    fn corner(channel: TriangleChannel<'_>, face: u32, corner: usize) -> ([f32; 3], [f32; 3]) {
        let fan = channel.topology.fan(3 * face + corner as u32) as usize;
        let normal = channel.fans.normals.get(fan).copied();
        (channel.fans.limits[fan], normal.unwrap_or_default())
    }
    fn linear(channel: TriangleChannel<'_>, at: Local) -> [f32; 2] {
        let corner = |c: u32| channel.points[channel.topology.vertex(3 * at.face + c) as usize];
        let [a, b, c] = [0, 1, 2].map(corner);
        let w = (1.0 - at.u) - at.v;
        [0, 1].map(|k: usize| a[k] * w + (b[k] * at.u + c[k] * at.v))
    }

    #[inline(always)]
    fn holds(u: f32, v: f32) -> bool {
        u >= 0.0 && v >= 0.0 && u + v <= 1.0
    }
    #[inline(always)]
    fn locate(surface: &Surface, face: u32, u: f32, v: f32) -> Option<Local> {
        let is_there = (face as usize) < surface.topology().face_count() && Self::holds(u, v);
        is_there.then(|| Local::whole(face, u, v))
    }
    fn nearest_corner(u: f32, v: f32) -> usize {
        let w = (1.0 - u) - v;
        match () {
            () if u >= v && u > w => 1,
            () if v > u && v > w => 2,
            () => 0,
        }
    }
    fn grid_len(n: u32) -> usize {
        (n as usize + 1).saturating_mul(n as usize + 2) / 2
    }
    fn grid_places(n: u32) -> impl Iterator<Item = [f32; 2]> {
        let at = move |i: u32| i as f32 / n as f32;
        (0..=n).flat_map(move |j| (0..=n - j).map(move |i| [at(i), at(j)]))
    }
    fn grids(_: &Surface, _: u32) -> (usize, bool) {
        (1, false)
    }
    fn in_children(first: u32, u: f32, v: f32) -> Local {
        Local::whole(first, u, v)
    }

    #[inline(always)]
    fn at_once<const ORDER: u32>(_: TriangleChannel<'_>, _: Local) -> Option<Jet> {
        None
    }
    #[inline(always)]
    fn rows<const ORDER: u32, S>(
        &mut self,
        channel: TriangleChannel<'_>,
        n: u32,
        out: &mut [S],
        convert: impl Fn(&TriangleRow, &mut [S]),
    ) {
        let (mut row, mut rest) = (TriangleRow::default(), out);
        for j in 0..=n {
            self.grid_row::<ORDER>(channel, n, j, &mut row);
            let Some((out, after)) = rest.split_at_mut_checked((n - j) as usize + 1) else {
                return;
            };
            convert(&row, out);
            rest = after;
        }
    }

    fn with_own<R>(then: impl FnOnce(&mut Self) -> R) -> R {
        thread_local! {
            static OWN: RefCell<TriangleEvaluator> = RefCell::default();
        }
        OWN.with_borrow_mut(then)
    }
}
