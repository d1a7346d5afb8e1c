//! One control level: what is kept of the mesh, its channels, and the level below.

use super::cut::{VertexRules, cut_points, cut_values};
use super::fans::Fans;
use super::tips;
use crate::refine::{self, Level, Timings};
use crate::topology::{NONE, Topology};
use std::sync::OnceLock;

/// One channel of a level, cut and ready to be diced.
#[derive(Clone, Debug)]
pub(crate) struct ChannelMesh {
    pub(crate) topology: Topology,
    pub(crate) points: Vec<[f32; 3]>,
    pub(crate) fans: Fans,
}

impl ChannelMesh {
    pub(super) fn new(topology: Topology, points: Vec<[f32; 3]>, normals: bool) -> Self {
        let fans = Fans::new(&topology, &points, normals);
        Self {
            topology,
            points,
            fans,
        }
    }
}

/// One level: the whole mesh of it that is kept, and its channels.
#[derive(Clone, Debug)]
pub(super) struct ControlLevel {
    /// Not cut; points and texture coordinates. In `f64`: a chain of roundings would show in normals at the deepest levels.
    pub(super) level: Level<f64>,
    pub(super) rules: VertexRules,
    /// Vertices of the level above whose children are this level's first vertices, in order.
    pub(super) above: Vec<u32>,
    /// The part of the level above that this level was refined from; nothing for the first level.
    pub(super) from: Topology,
    /// Colours of the vertices; empty without.
    pub(super) colors: Vec<[f64; 3]>,
    /// First child of every face in the next level, or [`NONE`] where the face is not refined.
    pub(super) children: Vec<u32>,
    /// Faces of which the next level is made: those refined and those around them.
    pub(super) parents: Vec<(u32, u32)>,
    pub(super) points: ChannelMesh,
    pub(super) uvs: Option<ChannelMesh>,
    pub(super) color_points: Option<ChannelMesh>,
    /// Limits of texture coordinates and colours at features, for where the dicing ends at this level.
    pub(super) tips: OnceLock<tips::Tips>,
}

fn narrow(points: &[[f64; 3]]) -> Vec<[f32; 3]> {
    points.iter().map(|p| p.map(|c| c as f32)).collect()
}

/// Which channel of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Points,
    Uvs,
    Colors,
}

impl ControlLevel {
    pub(super) fn new(
        level: Level<f64>,
        above: Vec<u32>,
        colors: Vec<[f64; 3]>,
        owned: &[bool],
        options: &refine::Options,
    ) -> Self {
        let t = &level.topology;
        let rules = VertexRules::new(t);
        let feature = |f: u32| {
            t.face_halves(f)
                .any(|h| rules.features[t.vertex(h) as usize])
        };
        let refined: Vec<bool> = (0..t.face_count() as u32)
            .map(|f| owned[f as usize] && feature(f))
            .collect();
        let mut touched = vec![false; t.vertex_count()];
        for f in (0..t.face_count() as u32).filter(|&f| refined[f as usize]) {
            for h in t.face_halves(f) {
                touched[t.vertex(h) as usize] = true;
            }
        }
        let parents: Vec<(u32, u32)> = (0..t.face_count() as u32)
            .filter(|&f| t.face_halves(f).any(|h| touched[t.vertex(h) as usize]))
            .map(|f| (f, 0))
            .collect();
        let mut children = Vec::new();
        if !parents.is_empty() {
            children = vec![NONE; t.face_count()];
            for (i, &(f, _)) in parents.iter().enumerate() {
                if refined[f as usize] {
                    children[f as usize] = 4 * i as u32;
                }
            }
        }
        let mut points = ChannelMesh::new(cut_points(t, &rules), narrow(&level.points), true);
        tips::set_feature_limits(&level, &rules, options, &mut points);
        let uvs = level.uvs.as_ref().map(|uv| {
            let values = uv
                .values
                .iter()
                .map(|&[u, v]| [u as f32, v as f32, 0.0])
                .collect();
            ChannelMesh::new(cut_values(t, &rules, uv), values, false)
        });
        let color_points = (!colors.is_empty())
            .then(|| ChannelMesh::new(points.topology.clone(), narrow(&colors), false));
        Self {
            rules,
            above,
            from: Topology::default(),
            colors,
            children,
            parents,
            points,
            uvs,
            color_points,
            tips: OnceLock::new(),
            level,
        }
    }

    /// Moves the points; everything that follows from them is made anew, everything else stays.
    pub(super) fn set_points(&mut self, points: Vec<[f64; 3]>, options: &refine::Options) {
        self.points.points = narrow(&points);
        self.level.points = points;
        self.points
            .fans
            .update(&self.points.topology, &self.points.points);
        tips::set_feature_limits(&self.level, &self.rules, options, &mut self.points);
    }

    pub(super) fn channel(&self, kind: Kind) -> Option<&ChannelMesh> {
        match kind {
            Kind::Points => Some(&self.points),
            Kind::Uvs => self.uvs.as_ref(),
            Kind::Colors => self.color_points.as_ref(),
        }
    }

    /// The next level, unless nothing needs it.
    pub(super) fn next(&self, options: &refine::Options) -> Option<Self> {
        if self.parents.is_empty() {
            return None;
        }
        let part = self.level.part(&self.parents);
        let colors = self.next_colors(&part, options);
        let mut timings = Timings::default();
        let level = part.level.next(options, &mut timings).ok()?;
        let owned: Vec<bool> = (self.parents.iter())
            .flat_map(|&(f, _)| [self.children[f as usize] != NONE; 4])
            .collect();
        let mut below = Self::new(level, part.vertices, colors, &owned, options);
        below.from = part.level.topology;
        Some(below)
    }

    fn next_colors(
        &self,
        part: &refine::restrict::Part<f64>,
        options: &refine::Options,
    ) -> Vec<[f64; 3]> {
        if self.colors.is_empty() {
            return Vec::new();
        }
        let values = part.vertices.iter().map(|&v| self.colors[v as usize]);
        Level::new(part.level.topology.clone(), values.collect())
            .and_then(|level| level.next(options, &mut Timings::default()))
            .map(|level| level.points)
            .unwrap_or_default()
    }

    pub(super) fn refined(&self, steps: u32) -> Fans {
        let m = &self.points;
        m.fans.refined(&m.topology, &m.points, steps)
    }

    pub(super) fn make_tips(&self, options: &refine::Options) -> tips::Tips {
        tips::Tips::new(&self.level, &self.colors, &self.rules, options)
    }
}
