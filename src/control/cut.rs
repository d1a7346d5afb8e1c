//! A mesh cut open along its infinitely sharp edges, as the per-quad path sees it.
//!
//! An infinite crease is a boundary of the surface on either side: the same curve, other tangent planes. So cutting leaves nothing of
//! creases but fans whose rule is known, and one code dices boundaries and creases. What cannot be cut away are *features*: vertices with
//! sharpness that fades, and darts, where a crease ends inside a smooth surface.

use crate::refine::FaceVarying;
use crate::refine::face_varying::SiblingKind;
use crate::refine::ring::{Incidence, Spoke};
use crate::scheme::crease::{Rule, is_infinite, is_semi_sharp};
use crate::topology::channel::number_edges;
use crate::topology::connect::rebuild_fans;
use crate::topology::{FanRule, NONE, Topology};
use rayon::prelude::*;

/// Rules of the vertices of a mesh once it is cut.
#[derive(Clone, Debug)]
pub(super) struct VertexRules {
    pub(super) rules: Vec<FanRule>,
    /// Per vertex, whether it is a feature.
    pub(super) features: Vec<bool>,
}

impl VertexRules {
    pub(super) fn new(t: &Topology) -> Self {
        let incidence = Incidence::new(t);
        let n = t.vertex_count();
        let of_vertex = |spokes: &mut Vec<Spoke>, v: u32| {
            incidence.spokes(t, v, spokes);
            let sharpness = |s: &Spoke| t.edge_sharpness(s.edge);
            let sigma = t.vertex_sharpness(v);
            let infinite = spokes.iter().filter(|s| is_infinite(sharpness(s))).count();
            let fades = is_semi_sharp(sigma) || spokes.iter().any(|s| is_semi_sharp(sharpness(s)));
            let pinned = if is_infinite(sigma) { sigma } else { 0.0 };
            let rule = Rule::of(pinned, infinite);
            let shape = match rule {
                Rule::Corner => FanRule::Corner,
                Rule::Crease | Rule::Dart => FanRule::Crease,
                Rule::Smooth => FanRule::Smooth,
            };
            (shape, fades || rule == Rule::Dart)
        };
        let (rules, features) = (0..n as u32)
            .into_par_iter()
            .with_min_len(1 << 10)
            .map_init(Vec::new, of_vertex)
            .unzip();
        Self { rules, features }
    }
}

/// Cuts `t`. Fans of features get the rule that their shape has.
pub(super) fn cut_points(t: &Topology, rules: &VertexRules) -> Topology {
    let mut out = t.clone();
    for h in 0..t.half_count() {
        if is_infinite(t.edge_sharpness(t.edge(h as u32))) {
            out.twins[h] = NONE;
        }
    }
    finish(&mut out);
    for fan in 0..out.fans.len() as u32 {
        let v = out.fan_vertex(fan) as usize;
        set_rule(&mut out, fan, rules.rules[v], rules.features[v]);
    }
    out
}

/// Cuts the mesh of face-varying values, along seams too; vertices of the result are values.
pub(super) fn cut_values(t: &Topology, rules: &VertexRules, values: &FaceVarying<f64>) -> Topology {
    let corners = &values.corners;
    let mut out = Topology {
        vertex_count: values.values.len(),
        corner_vertices: corners.clone(),
        corner_fans: Vec::new(),
        ..t.clone()
    };
    for h in 0..t.half_count() as u32 {
        let g = t.twin(h);
        let joined = g != NONE
            && !values.is_linear()
            && !is_infinite(t.edge_sharpness(t.edge(h)))
            && corners[h as usize] == corners[t.next(g) as usize]
            && corners[t.next(h) as usize] == corners[g as usize];
        out.twins[h as usize] = if joined { g } else { NONE };
    }
    finish(&mut out);
    let mut vertex_of = vec![NONE; out.vertex_count];
    for (h, &value) in corners.iter().enumerate() {
        vertex_of[value as usize] = t.vertex(h as u32);
    }
    for fan in 0..out.fans.len() as u32 {
        let value = out.fan_vertex(fan);
        let sibling = values
            .siblings()
            .binary_search_by_key(&value, |s| s.value)
            .ok()
            .map(|i| values.siblings()[i].kind);
        let v = vertex_of[value as usize] as usize;
        let (rule, feature) = match sibling {
            _ if values.is_linear() || v == NONE as usize => (FanRule::Corner, false),
            Some(SiblingKind::Corner) => (FanRule::Corner, false),
            Some(SiblingKind::Crease) => (FanRule::Crease, false),
            Some(SiblingKind::SemiSharp | SiblingKind::Dependent) => (FanRule::Crease, true),
            None => (rules.rules[v], rules.features[v]),
        };
        set_rule(&mut out, fan, rule, feature);
    }
    out
}

fn finish(t: &mut Topology) {
    t.edge_sharpness.clear();
    t.vertex_sharpness.clear();
    number_edges(t);
    rebuild_fans(t);
}

/// A rule must suit the fan's shape, or masks would look for edges that are not there: curves need two ends, smooth fans none.
fn set_rule(t: &mut Topology, fan: u32, rule: FanRule, feature: bool) {
    let info = &mut t.fans[fan as usize];
    let shape = if info.closed {
        FanRule::Smooth
    } else {
        FanRule::Crease
    };
    if info.first != NONE && !feature && (rule == FanRule::Corner || rule == shape) {
        info.rule = rule;
    }
}
