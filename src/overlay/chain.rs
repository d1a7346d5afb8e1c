//! Pieces of lines to polylines: fewer joints to draw and to store. Pieces that end in one place go on in the straightest way.

use super::{Kind, Polyline};
use std::collections::HashMap;

/// A visible stretch of a line, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    pub(super) ends: [[f64; 2]; 2],
    pub(super) kind: Kind,
}

/// Places closer than this, in pixels, are one.
const SAME: f64 = 1.0 / 4096.0;

/// Where more than two pieces meet, those that turn by less than this go on as one: cosine of 50 degrees.
const STRAIGHT: f64 = 0.64;

/// Polylines shorter than this, in pixels, are not seen.
const SHORTEST: f64 = 0.25;

/// Points are left out where the line stays this close without them, in pixels.
const FLAT: f64 = 0.04;

/// Coordinates are kept in steps of 1 / this, in pixels: what an SVG file states.
pub(super) const STEPS: f64 = 100.0;

type Place = (Kind, i64, i64);

fn place(kind: Kind, p: [f64; 2]) -> Place {
    let [x, y] = p.map(|c| (c / SAME).round() as i64);
    (kind, x, y)
}

/// Which end of which piece follows each end; pieces have two ends, `2k` and `2k + 1`.
fn partners(pieces: &[Piece]) -> Vec<Option<u32>> {
    let mut nodes: HashMap<Place, u32> = HashMap::new();
    // Ends at each node, one after the other: the latest, and for every end the one before.
    let (mut latest, mut before) = (Vec::new(), vec![None; pieces.len() * 2]);
    for (k, piece) in pieces.iter().enumerate() {
        for e in 0..2 {
            let next = latest.len() as u32;
            let node = *nodes
                .entry(place(piece.kind, piece.ends[e]))
                .or_insert(next);
            let end = (2 * k + e) as u32;
            if node == next {
                latest.push(end);
            } else {
                before[end as usize] = Some(latest[node as usize]);
                latest[node as usize] = end;
            }
        }
    }
    let mut out = vec![None; pieces.len() * 2];
    let mut ends = Vec::new();
    let mut pairs = Vec::new();
    for last in latest {
        ends.clear();
        let mut end = Some(last);
        while let Some(e) = end {
            ends.push(e);
            end = before[e as usize];
        }
        ends.reverse();
        let count = ends.len();
        pairs.clear();
        // Far more than lines that meet in a place are a fan of slivers: nothing goes on there.
        if count > 64 {
            continue;
        }
        for (i, &e) in ends.iter().enumerate() {
            for &f in &ends[i + 1..] {
                let straight = -cosine(pieces, e, f);
                if e / 2 != f / 2 && (count == 2 || straight > STRAIGHT) {
                    pairs.push((straight, e, f));
                }
            }
        }
        pairs.sort_by(|p, q| q.0.total_cmp(&p.0).then(p.1.cmp(&q.1)).then(p.2.cmp(&q.2)));
        for &(_, e, f) in &pairs {
            if out[e as usize].is_none() && out[f as usize].is_none() {
                out[e as usize] = Some(f);
                out[f as usize] = Some(e);
            }
        }
    }
    out
}

/// Cosine of the angle between two pieces that leave the place of these ends.
fn cosine(pieces: &[Piece], e: u32, f: u32) -> f64 {
    let leaving = |e: u32| {
        let ends = &pieces[e as usize / 2].ends;
        let (p, q) = (ends[e as usize % 2], ends[1 - e as usize % 2]);
        let d = [q[0] - p[0], q[1] - p[1]];
        let length = (d[0] * d[0] + d[1] * d[1]).sqrt();
        d.map(|c| if length > 0.0 { c / length } else { 0.0 })
    };
    let (d, g) = (leaving(e), leaving(f));
    d[0] * g[0] + d[1] * g[1]
}

/// Joins pieces to polylines, in the order of their first pieces.
pub(super) fn join(pieces: &[Piece]) -> Vec<Polyline> {
    let partners = partners(pieces);
    let mut done = vec![false; pieces.len()];
    let mut out = Vec::new();
    let mut points = Vec::new();
    // Lines with ends first, then closed ones.
    for closed in [false, true] {
        for k in 0..pieces.len() {
            for e in 0..2 {
                let first = (2 * k + e) as u32;
                if done[k] || (!closed && partners[first as usize].is_some()) {
                    continue;
                }
                points.clear();
                points.push(pieces[k].ends[e]);
                let mut end = first;
                loop {
                    let k = end as usize / 2;
                    if done[k] {
                        break;
                    }
                    done[k] = true;
                    points.push(pieces[k].ends[1 - end as usize % 2]);
                    match partners[end as usize ^ 1] {
                        Some(next) => end = next,
                        None => break,
                    }
                }
                out.extend(polyline(pieces[k].kind, &points));
            }
        }
    }
    out
}

/// A polyline of few points, unless it is too short to be seen.
fn polyline(kind: Kind, points: &[[f64; 2]]) -> Option<Polyline> {
    let length: f64 = points.windows(2).map(|p| distance(p[0], p[1])).sum();
    if length < SHORTEST {
        return None;
    }
    let mut keep = vec![false; points.len()];
    keep[0] = true;
    keep[points.len() - 1] = true;
    let mut spans = vec![(0, points.len() - 1)];
    while let Some((a, b)) = spans.pop() {
        let off = |k: usize| from_line(points[k], points[a], points[b]);
        let far = (a + 1..b).max_by(|&p, &q| off(p).total_cmp(&off(q)));
        if let Some(far) = far.filter(|&k| off(k) > FLAT) {
            keep[far] = true;
            spans.push((a, far));
            spans.push((far, b));
        }
    }
    let mut out: Vec<[f32; 2]> = Vec::new();
    for (p, _) in points.iter().zip(&keep).filter(|(_, keep)| **keep) {
        let p = p.map(|c| ((c * STEPS).round() / STEPS) as f32);
        if out.last() != Some(&p) {
            out.push(p);
        }
    }
    (out.len() > 1).then_some(Polyline { kind, points: out })
}

fn distance(p: [f64; 2], q: [f64; 2]) -> f64 {
    let d = [q[0] - p[0], q[1] - p[1]];
    (d[0] * d[0] + d[1] * d[1]).sqrt()
}

/// Distance of a point from the stretch between two others.
fn from_line(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let d = [b[0] - a[0], b[1] - a[1]];
    let square = d[0] * d[0] + d[1] * d[1];
    let along = (p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1];
    let t = if square > 0.0 {
        (along / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    distance(p, [a[0] + d[0] * t, a[1] + d[1] * t])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(a: [f64; 2], b: [f64; 2]) -> Piece {
        Piece {
            ends: [a, b],
            kind: Kind::Wire,
        }
    }

    #[test]
    fn lines_go_on_straight_where_four_meet() {
        let centre = [5.0, 5.0];
        let arms = [[0.0, 5.0], [5.0, 0.0], [10.0, 5.0], [5.0, 10.0]];
        let lines = join(&arms.map(|p| piece(p, centre)));
        assert_eq!(lines.len(), 2);
        for line in &lines {
            // The middle is on the line, and needs no point.
            assert_eq!(line.points.len(), 2);
            let [p, q] = [line.points[0], line.points[1]];
            assert!(p[0] == q[0] || p[1] == q[1]);
        }
    }

    #[test]
    fn corners_and_rings_are_kept() {
        let corner = join(&[piece([0.0, 0.0], [5.0, 0.0]), piece([5.0, 4.0], [5.0, 0.0])]);
        assert_eq!(corner.len(), 1);
        assert_eq!(corner[0].points, [[0.0, 0.0], [5.0, 0.0], [5.0, 4.0]]);
        let square = [[0.0, 0.0], [5.0, 0.0], [5.0, 5.0], [0.0, 5.0]];
        let ring: Vec<Piece> = (0..4)
            .map(|k| piece(square[k], square[(k + 1) % 4]))
            .collect();
        let ring = join(&ring);
        assert_eq!((ring.len(), ring[0].points.len()), (1, 5));
        assert_eq!(ring[0].points[0], ring[0].points[4]);
    }

    #[test]
    fn kinds_are_not_joined_and_specks_are_left_out() {
        let mut other = piece([5.0, 0.0], [9.0, 0.0]);
        other.kind = Kind::Crease;
        assert_eq!(join(&[piece([0.0, 0.0], [5.0, 0.0]), other]).len(), 2);
        assert!(join(&[piece([0.0, 0.0], [0.1, 0.0])]).is_empty());
        let two = [piece([0.0, 0.0], [0.2, 0.0]), piece([0.2, 0.0], [0.4, 0.0])];
        assert_eq!(join(&two).len(), 1);
    }
}
