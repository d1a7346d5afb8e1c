//! Which cage vertices the points of a cage face depend on, and colours that tell them apart.

use crate::scheme::Scheme;
use crate::topology::Topology;

/// Rings of faces around a face that its points depend on, or its points and tangents.
pub(super) fn rings(scheme: Scheme, tangents: bool) -> usize {
    match scheme {
        Scheme::CatmullClark | Scheme::Bilinear | Scheme::Loop => 1,
        // Four-point rules reach one vertex further, at every level; tangents see two rings of the level after.
        Scheme::Butterfly | Scheme::Kobbelt => 2 + usize::from(tangents),
    }
}

/// Surroundings of all faces, and a colour per vertex such that no surroundings have two of one colour.
pub(super) struct Support {
    starts: Vec<usize>,
    vertices: Vec<u32>,
    pub(super) color: Vec<u32>,
    /// Number of colours.
    pub(super) colors: usize,
    /// Vertices of surroundings, in the mean over faces.
    pub(super) typical: usize,
}

impl Support {
    pub(super) fn new(t: &Topology, rings: usize) -> Self {
        let faces_of = Lists::new(
            t.vertex_count(),
            (0..t.half_count() as u32).map(|h| (t.vertex(h), t.face_of(h))),
        );
        let mut starts = vec![0];
        let mut vertices = Vec::new();
        let mut seen = vec![u32::MAX; t.vertex_count()];
        let mut ring: Vec<u32> = Vec::new();
        for f in 0..t.face_count() as u32 {
            ring.clear();
            let mut reached = 0;
            let add = |f2: u32, ring: &mut Vec<u32>, seen: &mut Vec<u32>| {
                for h in t.face_halves(f2) {
                    let v = t.vertex(h);
                    if seen[v as usize] != f {
                        seen[v as usize] = f;
                        ring.push(v);
                    }
                }
            };
            add(f, &mut ring, &mut seen);
            for _ in 0..rings {
                let end = ring.len();
                for i in reached..end {
                    for &g in faces_of.of(ring[i]) {
                        add(g, &mut ring, &mut seen);
                    }
                }
                reached = end;
            }
            ring.sort_unstable();
            vertices.extend(&ring);
            starts.push(vertices.len());
        }
        let typical = vertices.len().div_ceil(t.face_count().max(1));
        let mut support = Self {
            starts,
            vertices,
            color: vec![u32::MAX; t.vertex_count()],
            colors: 0,
            typical,
        };
        support.paint(t.face_count());
        support
    }

    /// Vertices that the points of face `f` depend on, ascending.
    pub(super) fn around(&self, f: u32) -> &[u32] {
        &self.vertices[self.starts[f as usize]..self.starts[f as usize + 1]]
    }

    /// Gives every vertex the first colour that none of its company has.
    fn paint(&mut self, faces: usize) {
        let near = Lists::new(
            self.color.len(),
            (0..faces as u32).flat_map(|f| self.around(f).iter().map(move |&v| (v, f))),
        );
        // Colours around each face, as bits.
        let mut around: Vec<Vec<u64>> = vec![Vec::new(); faces];
        let mut taken: Vec<u64> = Vec::new();
        for v in 0..self.color.len() as u32 {
            taken.clear();
            for &f in near.of(v) {
                let own = &around[f as usize];
                if taken.len() < own.len() {
                    taken.resize(own.len(), 0);
                }
                taken.iter_mut().zip(own).for_each(|(t, o)| *t |= o);
            }
            let word = (taken.iter().position(|&w| w != u64::MAX)).unwrap_or(taken.len());
            let bit = taken.get(word).map_or(0, |w| w.trailing_ones());
            for &f in near.of(v) {
                let own = &mut around[f as usize];
                if own.len() <= word {
                    own.resize(word + 1, 0);
                }
                own[word] |= 1 << bit;
            }
            let color = 64 * word as u32 + bit;
            self.color[v as usize] = color;
            self.colors = self.colors.max(color as usize + 1);
        }
    }
}

/// Bytes that [`Support::new`] takes, at most.
pub(super) fn bytes(t: &Topology, rings: usize) -> u128 {
    // How many corners lie within so many rings of each vertex, counted as often as they are met.
    let mut reach = vec![1_u128; t.vertex_count()];
    for _ in 0..rings {
        let mut next = vec![0_u128; t.vertex_count()];
        for f in 0..t.face_count() as u32 {
            let sum: u128 = (t.face_halves(f))
                .map(|h| reach[t.vertex(h) as usize])
                .sum();
            for h in t.face_halves(f) {
                let n = &mut next[t.vertex(h) as usize];
                *n = n.saturating_add(sum);
            }
        }
        reach = next;
    }
    let all = t.vertex_count() as u128;
    let entries: u128 = (0..t.face_count() as u32)
        .map(|f| {
            let met = t.face_halves(f).map(|h| reach[t.vertex(h) as usize]);
            met.fold(0, u128::saturating_add).min(all)
        })
        .fold(0, u128::saturating_add);
    entries.saturating_mul(9)
}

/// Lists of numbers, one behind the other.
struct Lists {
    starts: Vec<usize>,
    items: Vec<u32>,
}

impl Lists {
    fn new(count: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let mut starts = vec![0; count + 1];
        for (key, _) in pairs.clone() {
            starts[key as usize + 1] += 1;
        }
        for i in 0..count {
            starts[i + 1] += starts[i];
        }
        let mut cursor = starts.clone();
        let mut items = vec![0; starts[count]];
        for (key, item) in pairs {
            items[cursor[key as usize]] = item;
            cursor[key as usize] += 1;
        }
        Self { starts, items }
    }

    fn of(&self, key: u32) -> &[u32] {
        &self.items[self.starts[key as usize]..self.starts[key as usize + 1]]
    }
}
