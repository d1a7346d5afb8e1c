//! Stencils: every refined point, or limit point, as a weighted sum of cage points.
//!
//! Refinement is linear, so the weights of cage vertex `v` are what becomes of values that are 1 at `v` and 0 elsewhere. Cage vertices that
//! no refined point depends on both of may share such values, as columns of a sparse Jacobian do (Curtis, Powell, Reid 1974): they are
//! coloured, all colours are refined at once as channels of the mesh, and each refined point then finds the vertex of a colour in the
//! surroundings of its cage face. So stencils need no masks of their own, whatever the scheme.

use super::channels::{Channels, VertexValues};
use super::limit::{self, Tables};
use super::sharpness::Step;
use super::{Level, Options, RefineError, Timings, refine};
use crate::scheme::Scheme;
use crate::topology::{NONE, Topology};
use rayon::prelude::*;
use std::io::{self, Write};

mod support;
mod write;

use support::Support;

/// Weights of refined points over cage points, as sparse rows.
///
/// Row `i` has the entries `offsets[i]..offsets[i + 1]`, in ascending order of cage points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stencils {
    /// Number of cage points.
    pub cage_points: usize,
    /// First entry of every row, and one past the last entry at the end.
    pub offsets: Vec<u64>,
    /// Cage point of every entry.
    pub indices: Vec<u32>,
    /// Weight of every entry. Those of a row sum to 1.
    pub weights: Vec<f32>,
    /// Weights of two tangents of the limit surface over the same entries; those of a row sum to 0. The tangents span the tangent plane of
    /// the point's first sector, and their cross product points outward but at reflex corners; their lengths mean nothing. Empty without limits.
    pub tangents: [Vec<f32>; 2],
}

impl Stencils {
    /// Number of rows, which is the number of refined points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }
    /// Whether there is no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Entries of row `i`.
    #[must_use]
    pub fn row(&self, i: usize) -> std::ops::Range<usize> {
        self.offsets[i] as usize..self.offsets[i + 1] as usize
    }
    /// The refined points of these cage points.
    ///
    /// # Errors
    /// [`RefineError::WrongCount`] unless there is one point per cage point.
    pub fn points(&self, cage: &[[f32; 3]]) -> Result<Vec<[f32; 3]>, RefineError> {
        self.apply(&self.weights, cage)
    }
    /// The tangents of the limit points of these cage points; empty without limits.
    ///
    /// # Errors
    /// [`RefineError::WrongCount`] unless there is one point per cage point.
    pub fn tangents(&self, cage: &[[f32; 3]]) -> Result<[Vec<[f32; 3]>; 2], RefineError> {
        let [a, b] = &self.tangents;
        Ok([self.apply(a, cage)?, self.apply(b, cage)?])
    }

    fn apply(&self, weights: &[f32], cage: &[[f32; 3]]) -> Result<Vec<[f32; 3]>, RefineError> {
        if cage.len() != self.cage_points {
            return Err(RefineError::WrongCount {
                got: cage.len(),
                wanted: self.cage_points,
            });
        }
        if weights.is_empty() {
            return Ok(Vec::new());
        }
        Ok((0..self.len())
            .into_par_iter()
            .with_min_len(1 << 10)
            .map(|i| {
                let mut sum = [0.0_f64; 3];
                for k in self.row(i) {
                    let w = f64::from(weights[k]);
                    for (s, c) in sum.iter_mut().zip(cage[self.indices[k] as usize]) {
                        *s += w * f64::from(c);
                    }
                }
                sum.map(|c| c as f32)
            })
            .collect())
    }
}

/// Bytes of an entry while rows are put together, with its share of tangents.
const ENTRY_BYTES: u128 = 40;

/// The stencils of all points of level `levels` over the points of level 0, or of their limits with two tangents.
///
/// Rows are in the order of the level's points; `topology` is that of the cage. A vertex of no face is its own row. Interpolating schemes have
/// their points for limits; their tangents reach one ring further than points.
///
/// # Errors
/// [`RefineError`] when they do not fit `max_bytes` or 32-bit indices.
pub fn stencils(
    topology: &Topology,
    options: &Options,
    levels: u32,
    limit: bool,
    max_bytes: Option<u64>,
) -> Result<Stencils, RefineError> {
    let allowed = max_bytes.map_or(u128::MAX, u128::from);
    let rings = support::rings(options.scheme, limit);
    let surroundings = support::bytes(topology, rings);
    let too_much = |needed: u128| RefineError::TooMuchMemory {
        level: levels,
        needed,
        allowed,
    };
    if surroundings > allowed {
        return Err(too_much(surroundings));
    }
    let support = Support::new(topology, rings);
    let mut base = Level::<f64>::new(topology.clone(), vec![[0.0; 3]; topology.vertex_count()])?;
    // Three colours to a part. Columns are not made before it is known that they fit.
    let parts = support.colors.div_ceil(3);
    let counts = super::counts(topology, options.scheme, levels);
    let number = size_of::<f64>() as u128;
    let columns = (counts.vertices)
        .saturating_mul(3 * number * parts as u128)
        .saturating_mul(if limit { 4 } else { 2 });
    let entries = counts
        .vertices
        .saturating_mul(ENTRY_BYTES * support.typical as u128);
    let needed = (base.predicted_bytes(options.scheme, levels))
        .saturating_add(surroundings)
        .saturating_add(columns)
        .saturating_add(entries);
    if needed > allowed {
        return Err(too_much(needed));
    }
    let columns = (0..parts)
        .map(|p| {
            let of_vertex = |&color: &u32| -> [f64; 3] {
                std::array::from_fn(|k| f64::from(u8::from(color as usize == 3 * p + k)))
            };
            support.color.iter().map(of_vertex).collect()
        })
        .collect();
    base.channels = Channels {
        vertex: vec![VertexValues::of_parts(columns)],
        ..Channels::default()
    };
    let level = refine(base, options, levels, None, &mut Timings::default())?;
    let parts = level.channels.vertex[0].parts();
    if !limit {
        return Ok(rows(&level, &support, parts, None));
    }
    let step = Step::new(&level.topology, options);
    if options.scheme.is_interpolating() {
        let mut tangents = [Vec::new(), Vec::new()];
        for part in parts {
            let [a, b] = limit::interpolating_tangents(&step, part);
            tangents[0].push(a);
            tangents[1].push(b);
        }
        return Ok(rows(&level, &support, parts, Some(&tangents)));
    }
    let tables = Tables::new(options.scheme == Scheme::Loop);
    let mut positions = Vec::with_capacity(parts.len());
    let mut tangents = [Vec::new(), Vec::new()];
    for part in parts {
        let (p, [a, b]) = limit::values(&step, &tables, part, true);
        positions.push(p);
        tangents[0].push(a);
        tangents[1].push(b);
    }
    Ok(rows(&level, &support, &positions, Some(&tangents)))
}

type Columns = Vec<Vec<[f64; 3]>>;

/// Entries of one row: cage point, weight, weights of tangents.
type Row = Vec<(u32, f32, [f32; 2])>;

fn rows(
    level: &Level<f64>,
    support: &Support,
    columns: &[Vec<[f64; 3]>],
    tangents: Option<&[Columns; 2]>,
) -> Stencils {
    let t = &level.topology;
    let at = |columns: &[Vec<[f64; 3]>], color: u32, v: usize| {
        columns[color as usize / 3][v][color as usize % 3]
    };
    let row = |v: usize| -> Row {
        let first = t.fans()[v].first;
        if first == NONE {
            return vec![(v as u32, 1.0, [0.0; 2])];
        }
        let base = level.base_face(t.face_of(first));
        let mut row = Vec::new();
        for &u in support.around(base) {
            let color = support.color[u as usize];
            let w = at(columns, color, v);
            let ts = tangents.map_or([0.0; 2], |ts| [0, 1].map(|k| at(&ts[k], color, v)));
            if w != 0.0 || ts != [0.0; 2] {
                row.push((u, w as f32, ts.map(|c| c as f32)));
            }
        }
        row
    };
    let mut out = Stencils {
        cage_points: support.color.len(),
        offsets: vec![0],
        ..Stencils::default()
    };
    // A few runs at a time: rows apart from each other take more room than entries one behind the other.
    let count = level.points.len();
    let run = 1 << 14;
    for start in (0..count).step_by(run) {
        let rows: Vec<Row> = (start..(start + run).min(count))
            .into_par_iter()
            .with_min_len(1 << 8)
            .map(row)
            .collect();
        for row in rows {
            for (u, w, [a, b]) in row {
                out.indices.push(u);
                out.weights.push(w);
                if tangents.is_some() {
                    out.tangents[0].push(a);
                    out.tangents[1].push(b);
                }
            }
            out.offsets.push(out.indices.len() as u64);
        }
    }
    out
}

impl Stencils {
    /// Writes the stencils as bytes, all numbers little-endian: the eight characters `EARSTEN1`, then as `u64` the number of cage points,
    /// rows, entries, and weights per entry (1, or 3 with tangents); then `u64` offsets of rows (one more than rows), `u32` cage points of
    /// entries, and `f32` weights of entries: all of the points, then all of the first tangents, then all of the second.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_bytes(&self, out: &mut impl Write) -> io::Result<()> {
        write::bytes(self, out)
    }

    /// Writes the stencils as one JSON object: `version` 1, `cage_points`, `rows`, and `stencils`, a list per row of `indices`, `weights`
    /// and, with limits, `du` and `dv`.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_json(&self, out: &mut impl Write) -> io::Result<()> {
        write::json(self, out)
    }

    /// Reads what [`Stencils::write_bytes`] wrote.
    ///
    /// # Errors
    /// [`io::ErrorKind::InvalidData`] when the bytes are something else.
    pub fn read_bytes(bytes: &[u8]) -> io::Result<Self> {
        write::read(bytes)
    }
}
