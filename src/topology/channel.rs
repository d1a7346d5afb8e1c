//! Connectivity of a face-varying channel: the same faces, joined only where their corner values join.
//!
//! A texture chart is a mesh of its own, whose seams are boundaries. So the surface of the values is diced by the same code as the
//! surface of the points; only the rule of each fan of values follows the face-varying options (as OpenSubdiv does).

use super::connect::rebuild_fans;
use super::{FanRule, NONE, Topology};
use crate::scheme::{Boundary, FaceVaryingRule, INFINITE_SHARPNESS};

/// Connects a channel over the faces of `base`. `values[h]` is the index of the value at corner `h`, below `value_count`.
///
/// # Panics
/// When an index is out of range or there is not one per corner.
#[must_use]
pub fn connect_channel(
    base: &Topology,
    values: Vec<u32>,
    value_count: usize,
    rule: FaceVaryingRule,
    boundary: Boundary,
) -> Topology {
    assert_eq!(values.len(), base.half_count(), "one value per corner");
    let twins: Vec<u32> = (0..values.len() as u32)
        .map(|h| {
            let g = base.twin(h);
            let joined = g != NONE
                && rule != FaceVaryingRule::All
                && values[h as usize] == values[base.next(g) as usize]
                && values[base.next(h) as usize] == values[g as usize];
            if joined { g } else { NONE }
        })
        .collect();
    let mut t = Topology {
        vertex_count: value_count,
        face_offsets: base.face_offsets.clone(),
        corner_faces: base.corner_faces.clone(),
        corner_vertices: values,
        twins,
        holes: base.holes.clone(),
        ..Topology::default()
    };
    number_edges(&mut t);
    rebuild_fans(&mut t);
    set_rules(&mut t, base, rule, boundary);
    t
}

/// Numbers the edges by twins.
pub(crate) fn number_edges(t: &mut Topology) {
    t.edge_halves.clear();
    let n = t.twins.len();
    t.edges = vec![NONE; n];
    for h in 0..n {
        let g = t.twins[h];
        t.edges[h] = if g != NONE && (g as usize) < h {
            t.edges[g as usize]
        } else {
            t.edge_halves.push(h as u32);
            t.edge_halves.len() as u32 - 1
        };
    }
}

/// Decides crease or corner for every open fan of values.
fn set_rules(t: &mut Topology, base: &Topology, rule: FaceVaryingRule, boundary: Boundary) {
    use FaceVaryingRule as R;
    let plus = matches!(rule, R::CornersPlus1 | R::CornersPlus2);
    for v in 0..base.fans().len() as u32 {
        let around = base.fans()[v as usize];
        if around.first == NONE {
            continue;
        }
        // The fans of values around this vertex, each once, in ring order.
        let mut siblings: Vec<u32> = Vec::new();
        for h in super::Ring::of_fan(base, v) {
            let fan = t.fan(h);
            if siblings.last() != Some(&fan) && siblings.first() != Some(&fan) {
                siblings.push(fan);
            }
        }
        let infinite = base.vertex_sharpness(base.fan_vertex(v)) >= INFINITE_SHARPNESS;
        if let [only] = siblings[..] {
            let info = t.fans()[only as usize];
            if info.closed {
                continue;
            }
            let matched = info.faces == around.faces && !around.closed;
            let corner = if matched {
                around.rule == FanRule::Corner
                    || matches!(rule, R::Boundaries | R::All)
                    || (around.faces == 1 && boundary != Boundary::EdgeAndCorner && rule != R::None)
            } else {
                // A dart: one cut edge ends here.
                infinite || matches!(rule, R::CornersPlus2 | R::Boundaries | R::All)
            };
            t.fans[only as usize].rule = if corner {
                FanRule::Corner
            } else {
                FanRule::Crease
            };
            continue;
        }
        let mut distinct: Vec<u32> = siblings.iter().map(|&f| t.fan_vertex(f)).collect();
        distinct.sort_unstable();
        let runs = distinct.len();
        let repeated: Vec<u32> = distinct
            .windows(2)
            .filter(|w| w[0] == w[1])
            .map(|w| w[0])
            .collect();
        distinct.dedup();
        let crowded = plus && distinct.len() > 2;
        let short = rule == R::CornersPlus2
            && distinct.len() == 2
            && siblings.iter().any(|&f| t.fans()[f as usize].faces == 1);
        let torn = plus && distinct.len() == 2 && runs > 2;
        for &fan in &siblings {
            let single = t.fans()[fan as usize].faces == 1 && rule != R::None;
            let corner = matches!(rule, R::Boundaries | R::All)
                || infinite
                || crowded
                || short
                || torn
                || single
                || repeated.binary_search(&t.fan_vertex(fan)).is_ok();
            t.fans[fan as usize].rule = if corner {
                FanRule::Corner
            } else {
                FanRule::Crease
            };
        }
    }
}
