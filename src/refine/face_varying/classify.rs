//! Which values of the cage are siblings, and of what kind: from the equality of value indices around each vertex.

use super::{Sibling, SiblingKind};
use crate::refine::ring::Incidence;
use crate::scheme::FaceVaryingRule as Rule;
use crate::scheme::crease::{is_infinite, is_semi_sharp};
use crate::topology::{NONE, Ring, Topology};

/// Whether edges on boundaries and seams, and all vertices there, are linear.
pub(super) fn linear_borders(rule: Rule) -> bool {
    matches!(rule, Rule::Boundaries | Rule::All)
}

/// Renumbers values so that no value belongs to two vertices. Returns the new value of every corner, and per new value one corner and
/// the old value.
pub(super) fn number_values(t: &Topology, corners: &[u32]) -> (Vec<u32>, Vec<(u32, u32)>) {
    let incidence = Incidence::new(t);
    let mut out = vec![NONE; corners.len()];
    let mut values: Vec<(u32, u32)> = Vec::new();
    for v in 0..t.vertex_count() as u32 {
        let start = values.len();
        for fan in std::iter::once(v).chain(incidence.extra_fans(v)) {
            for h in Ring::of_fan(t, fan) {
                let old = corners[h as usize];
                let found = values[start..].iter().position(|&(_, o)| o == old);
                let rank = found.map_or(values.len(), |r| start + r);
                if found.is_none() {
                    values.push((h, old));
                }
                out[h as usize] = rank as u32;
            }
        }
    }
    (out, values)
}

/// Whether two faces at edge `e` have different values at either end.
pub(super) fn disagrees(t: &Topology, incidence: &Incidence, corners: &[u32], e: u32) -> bool {
    let first = t.edge_half(e);
    let ends = |h: u32| {
        let mut ends = [h, t.next(h)].map(|h| corners[h as usize]);
        if super::super::ring::start_end(t, h) == 1 {
            ends.reverse();
        }
        ends
    };
    let twin = t.twin(first);
    (twin != NONE && ends(twin) != ends(first))
        || incidence.extra_halves(e).any(|h| ends(h) != ends(first))
}

/// A distinct value at a vertex.
struct Span {
    value: u32,
    first: u32,
    last: u32,
    faces: u32,
    runs: u32,
    inner_infinite: bool,
    inner_seam: bool,
    inner_semi_sharp: bool,
}

/// All siblings of the cage, sorted by value.
pub(super) fn siblings(t: &Topology, corners: &[u32], rule: Rule) -> Vec<Sibling> {
    let incidence = Incidence::new(t);
    let seams: Vec<bool> = (0..t.edge_count() as u32)
        .map(|e| disagrees(t, &incidence, corners, e))
        .collect();
    let mut irregular = vec![false; t.vertex_count()];
    for &(_, h) in incidence.all_extra_halves() {
        irregular[t.vertex(h) as usize] = true;
        irregular[t.vertex(t.next(h)) as usize] = true;
    }
    let mut spokes = Vec::new();
    let mut siblings = Vec::new();
    for v in 0..t.vertex_count() as u32 {
        let fan = t.fans()[v as usize];
        if fan.first == NONE {
            continue;
        }
        incidence.spokes(t, v, &mut spokes);
        let seam_count = spokes.iter().filter(|s| seams[s.edge as usize]).count();
        let many_fans = incidence.extra_fans(v).next().is_some();
        let sigma = t.vertex_sharpness(v);
        // Under edge-and-corner a vertex with one face is infinitely sharp: a corner whether it agrees or not.
        let border = !fan.closed
            && (linear_borders(rule)
                || (fan.faces == 1 && !is_infinite(sigma) && rule != Rule::None));
        if seam_count == 0 && !border {
            let values_differ = many_fans
                && incidence.extra_fans(v).any(|f| {
                    corners[t.fans()[f as usize].first as usize] != corners[fan.first as usize]
                });
            if !values_differ {
                continue;
            }
        }
        let mut spans = Vec::new();
        for f in std::iter::once(v).chain(incidence.extra_fans(v)) {
            add_spans(t, corners, &seams, f, &mut spans);
        }
        let irregular = irregular[v as usize] || many_fans;
        let dart = fan.closed && spans.len() == 1;
        classify(
            &spans,
            rule,
            sigma,
            irregular,
            dart.then_some(seam_count),
            &mut siblings,
        );
    }
    siblings.sort_unstable_by_key(|s| s.value);
    siblings
}

/// Adds the spans of one fan.
fn add_spans(t: &Topology, corners: &[u32], seams: &[bool], fan: u32, spans: &mut Vec<Span>) {
    let info = t.fans()[fan as usize];
    let value = |h: u32| corners[h as usize];
    // Start a closed ring where the value changes, else behind a seam edge.
    let mut start = info.first;
    if info.closed {
        let changes = |h: u32| value(h) != value(t.rotate_back(h));
        start = Ring::of_fan(t, fan)
            .find(|&h| changes(h))
            .or_else(|| Ring::of_fan(t, fan).find(|&h| seams[t.edge(h) as usize]))
            .unwrap_or(start);
    }
    let mut current: Option<usize> = None;
    for (i, h) in Ring::from_half(t, start).enumerate() {
        let e = t.edge(h);
        match current {
            Some(c) if spans[c].value == value(h) => {
                let span = &mut spans[c];
                let s = t.edge_sharpness(e);
                span.inner_infinite |= is_infinite(s);
                span.inner_semi_sharp |= is_semi_sharp(s);
                span.inner_seam |= seams[e as usize];
                span.faces += 1;
                if span.runs == 1 {
                    span.last = h;
                }
            }
            _ => {
                debug_assert!(i == 0 || current.is_some());
                current = Some(match spans.iter().position(|s| s.value == value(h)) {
                    Some(c) => {
                        spans[c].runs += 1;
                        spans[c].faces += 1;
                        c
                    }
                    None => {
                        spans.push(Span {
                            value: value(h),
                            first: h,
                            last: h,
                            faces: 1,
                            runs: 1,
                            inner_infinite: false,
                            inner_seam: false,
                            inner_semi_sharp: false,
                        });
                        spans.len() - 1
                    }
                });
            }
        }
    }
}

/// `dart`: number of seam edges where an interior vertex has but one value.
fn classify(
    spans: &[Span],
    rule: Rule,
    sigma: f32,
    irregular: bool,
    dart: Option<usize>,
    out: &mut Vec<Sibling>,
) {
    let plus = matches!(rule, Rule::CornersPlus1 | Rule::CornersPlus2);
    let two = spans.len() == 2;
    let blocked = |s: &Span| s.inner_infinite || s.inner_seam;
    let all_corners = linear_borders(rule)
        || is_infinite(sigma)
        || irregular
        || (plus && spans.len() > 2)
        || (plus && two && spans.iter().any(blocked))
        || (rule == Rule::CornersPlus2 && two && spans.iter().any(|s| s.faces == 1))
        || dart.is_some_and(|seams| seams > 1 || rule == Rule::CornersPlus2);
    let semi_sharp_spans = spans.iter().filter(|s| s.inner_semi_sharp).count();
    for s in spans {
        let corner =
            all_corners || s.runs > 1 || blocked(s) || (s.faces == 1 && rule != Rule::None);
        let kind = if corner {
            SiblingKind::Corner
        } else if s.inner_semi_sharp || is_semi_sharp(sigma) {
            SiblingKind::SemiSharp
        } else if plus && two && semi_sharp_spans == 1 {
            SiblingKind::Dependent
        } else {
            SiblingKind::Crease
        };
        out.push(Sibling {
            value: s.value,
            first: s.first,
            last: s.last,
            kind,
        });
    }
}
