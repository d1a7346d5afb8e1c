//! Half-edges brought together by edge.

use super::warning::TopologyWarning;
use super::{NONE, Topology};
use rayon::prelude::*;

pub(super) const GROUP_BOUNDARY: u8 = 0;
pub(super) const GROUP_PAIR: u8 = 1;
pub(super) const GROUP_FLIPPED: u8 = 2;
pub(super) const GROUP_NON_MANIFOLD: u8 = 3;

/// Half-edges sorted by edge.
pub(super) struct Pairing {
    /// First entry of each smaller vertex.
    starts: Vec<u32>,
    /// (larger vertex, half-edge), sorted within each bucket.
    entries: Vec<(u32, u32)>,
}

/// Per edge: how its half-edges go together.
pub(super) struct Groups {
    pub(super) kinds: Vec<u8>,
}

impl Pairing {
    pub(super) fn new(t: &Topology) -> Self {
        let n = t.corner_vertices.len();
        let mut starts = vec![0_u32; t.vertex_count + 1];
        let ends = |h: u32| {
            let (a, b) = (t.vertex(h), t.vertex(t.next(h)));
            (a.min(b), a.max(b))
        };
        for h in 0..n as u32 {
            starts[ends(h).0 as usize + 1] += 1;
        }
        for v in 0..t.vertex_count {
            starts[v + 1] += starts[v];
        }
        let mut cursor = starts.clone();
        let mut entries = vec![(0_u32, 0_u32); n];
        for h in 0..n as u32 {
            let (a, b) = ends(h);
            entries[cursor[a as usize] as usize] = (b, h);
            cursor[a as usize] += 1;
        }
        drop(cursor);
        // Buckets are disjoint slices; hand them to threads in runs of vertices.
        let mut rest = entries.as_mut_slice();
        let mut runs = Vec::new();
        let mut v = 0;
        while v < t.vertex_count {
            let end = (v + 16384).min(t.vertex_count);
            let (run, tail) = rest.split_at_mut((starts[end] - starts[v]) as usize);
            runs.push((v, end, run));
            rest = tail;
            v = end;
        }
        runs.into_par_iter().for_each(|(v0, v1, run)| {
            let base = starts[v0];
            for v in v0..v1 {
                run[(starts[v] - base) as usize..(starts[v + 1] - base) as usize].sort_unstable();
            }
        });
        Self { starts, entries }
    }

    /// Runs of entries with the same edge, in (smaller, larger) order.
    fn runs(&self, v: usize) -> impl Iterator<Item = &[(u32, u32)]> {
        self.entries[self.starts[v] as usize..self.starts[v + 1] as usize]
            .chunk_by(|a, b| a.0 == b.0)
    }

    pub(super) fn number_edges(&self, t: &mut Topology) -> Groups {
        let mut edges = vec![0_u32; self.entries.len()];
        let mut halves = Vec::with_capacity(self.entries.len() / 2 + 1);
        let mut kinds = Vec::with_capacity(self.entries.len() / 2 + 1);
        for v in 0..t.vertex_count {
            for run in self.runs(v) {
                let e = halves.len() as u32;
                halves.push(run[0].1);
                for &(_, h) in run {
                    edges[h as usize] = e;
                }
                kinds.push(match run {
                    [(b, _), ..] if *b == v as u32 => GROUP_NON_MANIFOLD,
                    [_] => GROUP_BOUNDARY,
                    [(_, g), (_, h)] if t.vertex(*g) != t.vertex(*h) => GROUP_PAIR,
                    [_, _] => GROUP_FLIPPED,
                    _ => GROUP_NON_MANIFOLD,
                });
            }
        }
        t.edges = edges;
        t.edge_halves = halves;
        Groups { kinds }
    }

    pub(super) fn pair(
        &self,
        t: &mut Topology,
        groups: &Groups,
        warnings: &mut Vec<TopologyWarning>,
    ) {
        let mut twins = vec![NONE; self.entries.len()];
        let mut odd: [(usize, [u32; 2]); 2] = [(0, [0; 2]); 2];
        let mut e = 0;
        for v in 0..t.vertex_count {
            for run in self.runs(v) {
                match groups.kinds[e] {
                    GROUP_PAIR => {
                        twins[run[0].1 as usize] = run[1].1;
                        twins[run[1].1 as usize] = run[0].1;
                    }
                    GROUP_BOUNDARY => {}
                    kind => {
                        let (count, first) = &mut odd[usize::from(kind == GROUP_FLIPPED)];
                        if *count == 0 {
                            *first = [v as u32, run[0].0];
                        }
                        *count += 1;
                    }
                }
                e += 1;
            }
        }
        t.twins = twins;
        let [(count, first), (flipped, first_flipped)] = odd;
        if count > 0 {
            warnings.push(TopologyWarning::NonManifoldEdges { count, first });
        }
        if flipped > 0 {
            warnings.push(TopologyWarning::FlippedEdges {
                count: flipped,
                first: first_flipped,
            });
        }
    }
}
