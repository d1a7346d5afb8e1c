//! How far what is drawn is from the limit surface, or from its patches, on the screen: the drawn triangles against the surface at the same parameters. Tests and
//! benchmarks hold adaptive tessellation against this, on the very blocks that pictures are made of.

use super::attributes::Attributes;
use super::prepared::SourceScratch;
use super::source::Source;
use super::{Frame, RenderError, Renderer, Scene, Use};
use crate::camera::View;
use crate::evaluate::Sample;
use crate::math;
use crate::patch::PatchKind;
use crate::records::Grid3;
use crate::surface::Surface;
use crate::tessellate::Flatness;
use rayon::prelude::*;

/// Largest distances of one view, of what is in its picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Micro-triangles with an area.
    pub triangles: u64,
    /// Distance in pixels between a point of the surface and that of its triangle.
    pub pixels: f32,
    /// The same of blocks at the deepest level that was allowed.
    pub capped: f32,
    /// Angle in degrees between the normal of the surface and that interpolated in its triangle; of triangles larger than a pixel.
    pub degrees: f32,
    /// Sum of the squares of distances, and their number.
    pub squares: (f64, u64),
}

/// Distances of one block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockDeviation {
    /// Object of the scene, and quad of its surface.
    pub quad: (u32, u32),
    /// The distances.
    pub deviation: Deviation,
}

impl Deviation {
    fn add(&mut self, o: &Self) {
        self.triangles += o.triangles;
        self.pixels = self.pixels.max(o.pixels);
        self.capped = self.capped.max(o.capped);
        self.degrees = self.degrees.max(o.degrees);
        self.squares.0 += o.squares.0;
        self.squares.1 += o.squares.1;
    }

    /// Root of the mean square of the distances.
    #[must_use]
    pub fn rms(&self) -> f64 {
        (self.squares.0 / self.squares.1.max(1) as f64).sqrt()
    }
}

impl Renderer {
    /// Measures the drawn triangles, at `steps` places along their sides and those between. Interpolating surfaces are known at dyadic
    /// places alone: `steps` should be a power of two.
    ///
    /// # Errors
    /// As [`Renderer::render_view`].
    pub fn deviation(
        &self,
        scene: &Scene,
        view: &View,
        steps: u32,
    ) -> Result<Deviation, RenderError> {
        self.deviation_of(scene, view, steps, 1)
    }

    /// The same of every `every`-th quad alone.
    ///
    /// # Errors
    /// As [`Renderer::render_view`].
    pub fn deviation_of(
        &self,
        scene: &Scene,
        view: &View,
        steps: u32,
        every: u32,
    ) -> Result<Deviation, RenderError> {
        let all = self.deviations(scene, view, steps, every)?;
        let mut sum = Deviation::default();
        all.iter().for_each(|block| sum.add(&block.deviation));
        Ok(sum)
    }

    /// The same of every block by itself.
    ///
    /// # Errors
    /// As [`Renderer::render_view`].
    pub fn deviations(
        &self,
        scene: &Scene,
        view: &View,
        steps: u32,
        every: u32,
    ) -> Result<Vec<BlockDeviation>, RenderError> {
        let cap = match self.refinement {
            super::Refinement::Adaptive(Flatness { max_level, .. })
            | super::Refinement::Default { max_level } => max_level,
            _ => u32::MAX,
        };
        self.with_frame(scene, view, Use::Picture, |frame, _| {
            let items: u32 = frame.sources.iter().map(Source::item_count).sum();
            let all = (0..items).into_par_iter().map_init(
                || Worker {
                    scratch: SourceScratch::new(frame.simd),
                    points: Grid3::boxed(),
                    attributes: Attributes::default(),
                },
                |worker, item| worker.item(frame, item, steps, [cap, every]),
            );
            let all: Vec<Vec<BlockDeviation>> = all.collect();
            Ok(all.into_iter().flatten().collect())
        })
    }
}

/// A block as it is drawn.
#[derive(Clone, Debug, Default)]
pub struct DrawnBlock {
    /// Object of the scene, and quad of its surface.
    pub quad: (u32, u32),
    /// Level of its points.
    pub level: u32,
    /// Points in a row.
    pub columns: usize,
    /// Parameters of its points in the quad, row by row.
    pub places: Vec<[f32; 2]>,
    /// The points.
    pub points: Vec<[f32; 3]>,
}

impl DrawnBlock {
    /// Micro-triangles of three different points, as numbers of theirs.
    pub fn triangles(&self) -> impl Iterator<Item = [usize; 3]> + '_ {
        let n = self.columns;
        let quads = (0..self.points.len() - n).filter(move |k| k % n != n - 1);
        let halves = quads.flat_map(move |k| [[k, k + 1, k + n + 1], [k, k + n + 1, k + n]]);
        let differ = |a: usize, b: usize| self.places[a] != self.places[b];
        halves.filter(move |&[a, b, c]| differ(a, b) && differ(b, c) && differ(c, a))
    }
}

impl Renderer {
    /// The blocks that a picture of `scene` is made of.
    ///
    /// # Errors
    /// As [`Renderer::render_view`].
    pub fn drawn_blocks(&self, scene: &Scene, view: &View) -> Result<Vec<DrawnBlock>, RenderError> {
        self.with_frame(scene, view, Use::Picture, |frame, _| {
            let (mut scratch, mut grid) = (SourceScratch::new(frame.simd), Grid3::boxed());
            let mut out = Vec::new();
            for (object, source) in frame.sources.iter().enumerate() {
                for item in (0..source.item_count()).filter(|&i| source.is_drawn(i)) {
                    let [nu, nv] = source.blocks();
                    let all = (0..nu * nv).map(|b| [b % nu, b / nu]);
                    for block in all.filter(|&b| source.has_block(b)) {
                        source.dice(&mut scratch, item, block, &mut grid, None);
                        let size = source.block_size(item);
                        let places = source.places(item, block);
                        let at = |k: usize| grid.get(k % size.cols, k / size.cols);
                        out.push(DrawnBlock {
                            quad: (object as u32, source.quad(item)),
                            level: source.level(item),
                            columns: size.cols,
                            points: (0..places.len()).map(at).collect(),
                            places,
                        });
                    }
                }
            }
            Ok(out)
        })
    }
}

struct Worker {
    scratch: SourceScratch,
    points: Box<Grid3>,
    attributes: Attributes,
}

impl Worker {
    fn item(
        &mut self,
        frame: &Frame<'_>,
        item: u32,
        steps: u32,
        [cap, every]: [u32; 2],
    ) -> Vec<BlockDeviation> {
        let mut found = Vec::new();
        let source = frame.source_of(item);
        let local = item - source.first_item;
        if !source.is_drawn(local) {
            return found;
        }
        let object = frame.sources.iter().position(|s| std::ptr::eq(s, source));
        let object = object.unwrap_or(0) as u32;
        let quad = source.quad(local);
        if !quad.is_multiple_of(every) {
            return found;
        }
        let capped = source.level(local) >= cap;
        let [nu, nv] = source.blocks();
        for block in (0..nu * nv).map(|b| [b % nu, b / nu]) {
            let mut out = Deviation::default();
            let a = Some(&mut self.attributes);
            source.dice(&mut self.scratch, local, block, &mut self.points, a);
            let size = source.block_size(local);
            let places = source.places(local, block);
            let place = |i: usize, j: usize| places[j * size.cols + i];
            let surface = &source.object.surface;
            let Some(mut evaluator) = surface.face_evaluator(surface.cage_face(quad)) else {
                continue;
            };
            let patch = &self.scratch.patch;
            let mut limit = |u: f32, v: f32| {
                if surface.patch_kind() != PatchKind::None {
                    let (position, normal) = patch.patch_at(u, v);
                    return Some(Sample {
                        position,
                        normal,
                        ..Sample::default()
                    });
                }
                let [u, v] = cage_place(surface, quad, [u, v]);
                evaluator.at_as::<Sample>(u, v)
            };
            if source.shape(local).list().is_some() {
                // Lists are not measured.
                continue;
            }
            for j in 0..size.rows - 1 {
                for i in 0..size.cols - 1 {
                    for half in [[(0, 0), (1, 0), (1, 1)], [(0, 0), (1, 1), (0, 1)]] {
                        let at = half.map(|(a, b)| (i + a, j + b));
                        let corners = at.map(|(i, j)| place(i, j));
                        if area(corners) == 0.0 {
                            continue;
                        }
                        let triangle = Triangle {
                            places: corners,
                            points: at.map(|(i, j)| self.points.get(i, j)),
                            normals: at.map(|(i, j)| self.attributes.normals.get(i, j)),
                        };
                        triangle.measure(&frame.view, &mut limit, steps, &mut out);
                    }
                }
            }
            if capped {
                out.capped = out.pixels;
                out.pixels = 0.0;
            }
            found.push(BlockDeviation {
                quad: (object, quad),
                deviation: out,
            });
        }
        found
    }
}

/// The parameters by which [`Surface::evaluate`] knows a place on the grid of quad `quad`.
fn cage_place(surface: &Surface, quad: u32, [u, v]: [f32; 2]) -> [f32; 2] {
    if surface.is_triangular() {
        return [(u - v).max(0.0), v];
    }
    if !surface.is_split() {
        return [u, v];
    }
    let t = surface.topology();
    let halves = t.face_halves(t.face_of(quad));
    let corner = quad - halves.start;
    match (halves.len(), corner) {
        (4, 0) => [0.5 * u, 0.5 * v],
        (4, 1) => [1.0 - 0.5 * v, 0.5 * u],
        (4, 2) => [1.0 - 0.5 * u, 1.0 - 0.5 * v],
        (4, _) => [0.5 * v, 1.0 - 0.5 * u],
        // The end of a quad is the beginning of the next one, which runs elsewhere.
        _ => [
            (corner as f32 + u).min((corner as f32 + 1.0).next_down()),
            v,
        ],
    }
}

/// Twice the area in parameters.
fn area([a, b, c]: [[f32; 2]; 3]) -> f32 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

struct Triangle {
    places: [[f32; 2]; 3],
    points: [[f32; 3]; 3],
    normals: [[f32; 3]; 3],
}

impl Triangle {
    fn measure(
        &self,
        view: &View,
        limit: &mut impl FnMut(f32, f32) -> Option<Sample>,
        steps: u32,
        out: &mut Deviation,
    ) {
        out.triangles += 1;
        let screen = |p: [f32; 3]| {
            let e = math::sub(p, view.eye);
            let z = view.distance(p);
            let scale = if view.projection.ortho {
                view.scale
            } else if z >= view.near {
                view.scale / z
            } else {
                return None;
            };
            Some([
                math::dot(view.right, e) * scale,
                math::dot(view.up, e) * scale,
            ])
        };
        let sides = [[0, 1], [1, 2], [2, 0]].map(|[a, b]| {
            match (screen(self.points[a]), screen(self.points[b])) {
                (Some(p), Some(q)) => (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2),
                _ => 0.0,
            }
        });
        let is_dot = sides.iter().all(|&s| s <= 1.0);
        for a in 0..=steps {
            for b in 0..=steps - a {
                let w = [a, b, steps - a - b].map(|k| k as f32 / steps as f32);
                let mix = |v: [[f32; 3]; 3]| {
                    [0, 1, 2].map(|k| w[0] * v[0][k] + w[1] * v[1][k] + w[2] * v[2][k])
                };
                let [u, v] = [0, 1].map(|k| {
                    let sum = (0..3).map(|c| w[c] * self.places[c][k]).sum::<f32>();
                    sum.clamp(0.0, 1.0)
                });
                let (p, n) = (mix(self.points), mix(self.normals));
                // What is not in the picture may be as it likes.
                let half = [view.size.width, view.size.height].map(|n| 0.5 * n as f32);
                let in_picture = |p: [f32; 2]| p[0].abs() <= half[0] && p[1].abs() <= half[1];
                if !screen(p).is_some_and(in_picture) {
                    continue;
                }
                let Some(sample) = limit(u, v) else {
                    continue;
                };
                if let (Some(p), Some(q)) = (screen(p), screen(sample.position)) {
                    let square = (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2);
                    out.pixels = out.pixels.max(square.sqrt());
                    out.squares.0 += f64::from(square);
                    out.squares.1 += 1;
                }
                if let (false, Some(n)) = (is_dot, math::normalize(n)) {
                    let cross = math::length(math::cross(n, sample.normal));
                    let angle = libm::atan2f(cross, math::dot(n, sample.normal));
                    out.degrees = out.degrees.max(angle.to_degrees());
                }
            }
        }
    }
}
