//! A vertex and its ring of quads or triangles, refined on their own in `f64`.

use super::Point;
use crate::refine::real::{add, add_scaled, blend, midpoint, scaled};
use crate::refine::sharpness::semi_sharp_sum;
use crate::refine::vertex::crease;
use crate::scheme::crease::{Rule, Transition, decay, decay_edge, is_semi_sharp, midpoint_weight};
use crate::scheme::{CreaseMethod, catmull_clark, loop_scheme};

/// The ring of one fan: edge `i`, then face `i`, counter-clockwise. An open ring has one edge more than faces.
#[derive(Clone, Debug, Default)]
pub(super) struct LocalRing {
    pub(super) x: Point,
    pub(super) sigma: f32,
    pub(super) closed: bool,
    pub(super) edges: Vec<Point>,
    /// Opposite corners of quads.
    pub(super) faces: Vec<Point>,
    /// The faces are triangles: `faces` is empty, and rules are those of Loop.
    pub(super) triangles: bool,
    /// Sharpness of the ring's edges.
    pub(super) sharpness: Vec<f32>,
    /// Sharpness of what lies straight beyond each edge; only semi-sharp Chaikin creases look at it.
    beyond: Vec<f32>,
}

impl LocalRing {
    pub(super) fn clear(&mut self, closed: bool, triangles: bool) {
        self.closed = closed;
        self.triangles = triangles;
        self.edges.clear();
        self.faces.clear();
        self.sharpness.clear();
        self.beyond.clear();
    }

    pub(super) fn push_edge(&mut self, end: Point, sharpness: f32, beyond: f32) {
        self.edges.push(end);
        self.sharpness.push(sharpness);
        self.beyond.push(beyond);
    }

    /// Number of faces.
    pub(super) fn face_count(&self) -> usize {
        self.edges.len() - usize::from(!self.closed && !self.edges.is_empty())
    }

    pub(super) fn is_semi_sharp(&self) -> bool {
        is_semi_sharp(self.sigma) || self.sharpness.iter().any(|&s| is_semi_sharp(s))
    }

    /// Edges of sharpness above 0.
    pub(super) fn sharp_edges(&self) -> Vec<usize> {
        (0..self.edges.len())
            .filter(|&i| self.sharpness[i] > 0.0)
            .collect()
    }

    pub(super) fn rule(&self) -> Rule {
        Rule::of(self.sigma, self.sharp_edges().len())
    }

    /// The ring one level on.
    pub(super) fn advance(&mut self, method: CreaseMethod) {
        let count = self.edges.len();
        let (sum, semi_sharp) = semi_sharp_sum(self.sharpness.iter().copied());
        let near: Vec<f32> = self
            .sharpness
            .iter()
            .map(|&s| decay_edge(method, s, sum, semi_sharp))
            .collect();
        let far: Vec<f32> = (self.sharpness.iter().zip(&self.beyond))
            .map(|(&s, &b)| {
                let (sum, semi_sharp) = semi_sharp_sum([s, b].into_iter());
                decay_edge(method, s, sum, semi_sharp)
            })
            .collect();
        let sigma = decay(self.sigma);
        let faces: Vec<Point> = (0..self.faces.len())
            .map(|i| {
                let mut sum = self.x;
                add(&mut sum, &self.edges[i]);
                add(&mut sum, &self.faces[i]);
                add(&mut sum, &self.edges[(i + 1) % count]);
                scaled(0.25, &sum)
            })
            .collect();
        let edges = (0..count)
            .map(|i| {
                let middle = midpoint(&self.x, &self.edges[i]);
                if !self.closed && (i == 0 || i + 1 == count) {
                    return middle;
                }
                let smooth = if self.triangles {
                    let mut ends = self.x;
                    add(&mut ends, &self.edges[i]);
                    let mut opposite = self.edges[(i + count - 1) % count];
                    add(&mut opposite, &self.edges[(i + 1) % count]);
                    let mut point = scaled(loop_scheme::EDGE_OPPOSITE, &opposite);
                    add_scaled(&mut point, loop_scheme::EDGE_END, &ends);
                    point
                } else {
                    let before = (i + faces.len() - 1) % faces.len();
                    midpoint(&middle, &midpoint(&faces[before], &faces[i]))
                };
                let weight = midpoint_weight(self.sharpness[i], [near[i], far[i]]);
                blend(weight, &middle, &smooth)
            })
            .collect();
        self.x = self.vertex_point(&faces, sigma, &near);
        self.edges = edges;
        self.faces = faces;
        self.sharpness = near;
        self.beyond = far;
        self.sigma = sigma;
    }

    fn vertex_point(&self, faces: &[Point], sigma: f32, near: &[f32]) -> Point {
        let mut transition = Transition::default();
        transition.note(self.sigma, sigma);
        for (&s, &child) in self.sharpness.iter().zip(near) {
            transition.note(s, child);
        }
        let apply = |rule: Rule, sharpness: &[f32]| match rule {
            Rule::Corner => self.x,
            Rule::Smooth | Rule::Dart => self.smooth(faces),
            Rule::Crease => {
                let sharp = sharpness.iter().zip(&self.edges).filter(|(s, _)| **s > 0.0);
                crease(&self.x, sharp.map(|(_, e)| e))
            }
        };
        let parent = self.rule();
        let child = Rule::of(sigma, near.iter().filter(|&&s| s > 0.0).count());
        let of_parent = apply(parent, &self.sharpness);
        if parent == child || matches!(parent, Rule::Smooth | Rule::Dart) {
            return of_parent;
        }
        blend(transition.weight(), &of_parent, &apply(child, near))
    }

    fn smooth(&self, faces: &[Point]) -> Point {
        if self.triangles {
            let n = self.face_count();
            let near = loop_scheme::neighbour(n as u32);
            let mut point = scaled(1.0 - n as f64 * near, &self.x);
            for e in &self.edges[..n] {
                add_scaled(&mut point, near, e);
            }
            return point;
        }
        let mask = catmull_clark::vertex(faces.len() as u32);
        let mut point = scaled(mask.vertex, &self.x);
        for (e, f) in self.edges.iter().zip(faces) {
            add_scaled(&mut point, mask.edge, e);
            add_scaled(&mut point, mask.face, f);
        }
        point
    }
}
