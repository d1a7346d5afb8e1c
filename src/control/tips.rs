//! Limits at the features themselves: where dicing ends at a vertex whose sharpness still fades, or at a dart.
//!
//! Points and normals have masks for it ([`limit`]). Texture coordinates and colours take the plain way: the ring of the vertex alone is
//! refined until nothing is left of it.

use super::ChannelMesh;
use super::cut::VertexRules;
use crate::refine::{Level, Options, Timings, limit};
use crate::topology::{FanRule, NONE};
use std::collections::BTreeMap;

/// Steps after which a ring has shrunk below the last bit of its vertex.
const STEPS: u32 = 24;

/// Limits of values at features, by value.
#[derive(Clone, Debug, Default)]
pub(super) struct Tips {
    pub(super) uvs: Vec<(u32, [f32; 3])>,
    pub(super) colors: Vec<(u32, [f32; 3])>,
}

/// Faces with a marked vertex, unturned.
fn around(level: &Level<f64>, marked: &[bool]) -> Vec<(u32, u32)> {
    let t = &level.topology;
    (0..t.face_count() as u32)
        .filter(|&f| t.face_halves(f).any(|h| marked[t.vertex(h) as usize]))
        .map(|f| (f, 0))
        .collect()
}

/// Puts the limit points and normals of features in place of what their fans' shapes say; of corners too, whose normals go by sectors.
pub(super) fn set_feature_limits(
    level: &Level<f64>,
    rules: &VertexRules,
    options: &Options,
    points: &mut ChannelMesh,
) {
    let marked: Vec<bool> = (rules.features.iter().zip(&rules.rules))
        .map(|(&feature, &rule)| feature || rule == FanRule::Corner)
        .collect();
    let faces = around(level, &marked);
    if faces.is_empty() {
        return;
    }
    let part = level.part(&faces).level;
    let limits = limit(&part, options);
    let t = &level.topology;
    // Normals of all corners of each fan, in the order of the corners.
    let mut normals: BTreeMap<u32, Vec<[f64; 3]>> = BTreeMap::new();
    for (i, &(f, _)) in faces.iter().enumerate() {
        let halves = t.face_halves(f);
        let first = part.topology.face_halves(i as u32).start;
        for h in halves.clone() {
            let v = t.vertex(h);
            if !marked[v as usize] {
                continue;
            }
            let local = first + (h - halves.start);
            let fan = points.topology.fan(h);
            let position = limits.positions[part.topology.vertex(local) as usize];
            points.fans.limits_mut()[fan as usize] = position.map(|c| c as f32);
            let normal = limits.normals[limits.normal_index(&part.topology, local) as usize];
            normals.entry(fan).or_default().push(normal);
        }
    }
    // A sharp point without creases through it is the tip of a cone and has as many normals as faces; the faces of a fan share their mean.
    for (fan, all) in normals {
        let first = all[0];
        if all.iter().all(|n| *n == first) {
            points.fans.normals_mut()[fan as usize] = first.map(|c| c as f32);
            continue;
        }
        let sum = all
            .iter()
            .fold([0.0; 3], |s: [f64; 3], n| [0, 1, 2].map(|k| s[k] + n[k]));
        let length = sum.iter().map(|c| c * c).sum::<f64>().sqrt();
        if length > 1e-6 {
            points.fans.normals_mut()[fan as usize] = sum.map(|c| (c / length) as f32);
        }
    }
}

impl Tips {
    pub(super) fn new(
        level: &Level<f64>,
        colors: &[[f64; 3]],
        rules: &VertexRules,
        options: &Options,
    ) -> Self {
        let mut tips = Self::default();
        if !rules.features.contains(&true) {
            return tips;
        }
        if level.uvs.is_some() {
            tips.uvs = shrink(level, &rules.features, options);
        }
        if !colors.is_empty()
            && let Ok(values) = Level::new(level.topology.clone(), colors.to_vec())
        {
            tips.colors = shrink(&values, &rules.features, options);
        }
        tips
    }
}

/// Refines the rings of the marked vertices alone, and gives what their values (texture coordinates if there are any, else points)
/// come to.
fn shrink(level: &Level<f64>, marked: &[bool], options: &Options) -> Vec<(u32, [f32; 3])> {
    let by_value = level.uvs.is_some();
    let mut part = level.part(&around(level, marked));
    // Value of the level, and where it is now.
    let mut tracked: Vec<(u32, u32)> = match by_value {
        true => identity(&part.values),
        false => identity(&part.vertices),
    };
    let mut marked: Vec<bool> = part.vertices.iter().map(|&v| marked[v as usize]).collect();
    tracked.retain(|&(_, now)| marked[vertex_of(&part.level, now) as usize]);
    for _ in 0..STEPS {
        let Ok(next) = part.level.next(options, &mut Timings::default()) else {
            break;
        };
        // Children of vertices and of values come first, in the order of their parents.
        marked.resize(next.topology.vertex_count(), false);
        part = next.part(&around(&next, &marked));
        let place = if by_value {
            &part.values
        } else {
            &part.vertices
        };
        for (_, now) in &mut tracked {
            *now = place.binary_search(now).map_or(NONE, |i| i as u32);
        }
        tracked.retain(|&(_, now)| now != NONE);
        marked = part.vertices.iter().map(|&v| marked[v as usize]).collect();
    }
    let value = |i: u32| match &part.level.uvs {
        Some(uv) => {
            let [u, v] = uv.values[i as usize];
            [u as f32, v as f32, 0.0]
        }
        None => part.level.points[i as usize].map(|c| c as f32),
    };
    tracked.iter().map(|&(of, now)| (of, value(now))).collect()
}

fn identity(old: &[u32]) -> Vec<(u32, u32)> {
    old.iter()
        .enumerate()
        .map(|(i, &v)| (v, i as u32))
        .collect()
}

/// Vertex of a value, or of a vertex itself.
fn vertex_of(level: &Level<f64>, value: u32) -> u32 {
    match &level.uvs {
        Some(uv) => level.topology.vertex(uv.value_corner(value)),
        None => value,
    }
}
