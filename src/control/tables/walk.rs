//! Single points of interpolating surfaces: from a face to its child, and on to the face that has the point for a corner.
//!
//! Every face on the way is a small mesh, it and some rings around it, which is refined as meshes are; so points have the bits of
//! whole-mesh refinement, whichever face they are asked of. As soon as the rings are regular they are a [`Lattice`], and take no time.

use super::TableTree;
use crate::dice::MAX_LEVEL;
use crate::refine::interpolating::{Masks, Sheets};
use crate::refine::lattice::Lattice;
use crate::refine::limit::{Frame, normal};
use crate::refine::sharpness::Step;
use crate::refine::{Level, Timings};
use crate::scheme::Scheme;
use crate::topology::{Ring, Topology};
use std::collections::{BTreeMap, BTreeSet};

/// Steps along the side of a face: places are told in these.
pub(crate) const STEPS: u32 = 1 << MAX_LEVEL;

/// A point that was found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Found {
    /// Texture coordinates are two numbers and 0.
    pub(crate) position: [f64; 3],
    /// By the parameters of the face.
    pub(crate) du: [f64; 3],
    pub(crate) dv: [f64; 3],
    pub(crate) normal: [f64; 3],
}

/// A face on the way, with its surroundings.
#[derive(Clone, Debug)]
enum Region {
    Lattice(Box<Lattice>),
    Mesh {
        level: Box<Level<f64>>,
        /// The face.
        own: u32,
        /// One level on, once something asked for it.
        next: Option<Box<Level<f64>>>,
    },
}

/// Faces one inside the other, kept from place to place.
#[derive(Clone, Debug)]
pub(crate) struct Walk<'a> {
    tree: &'a TableTree,
    uvs: bool,
    face: Option<u32>,
    /// By depth, and number among the descendants of the face.
    regions: BTreeMap<(u32, u32), Region>,
}

/// Regions that are kept, and the depth above which all are: rows of places come back to those.
const MOST_KEPT: usize = 32;
const DEPTH_KEPT: u32 = 3;

/// Rings that are refined around a face at a depth.
fn rings(scheme: Scheme, depth: u32) -> usize {
    match (scheme, depth) {
        // Extraordinary vertices side by side make Kobbelt's points look further.
        (Scheme::Kobbelt, 0) => 4,
        (Scheme::Kobbelt, _) => 3,
        _ => 2,
    }
}

/// Face `own` and rings around it, in order, and which of them it is.
pub(in crate::control) fn surroundings(
    t: &Topology,
    own: u32,
    rings: usize,
) -> (Vec<(u32, u32)>, u32) {
    let mut faces = BTreeSet::from([own]);
    let mut rim = vec![own];
    let mut seen = BTreeSet::new();
    for _ in 0..rings {
        let mut next = Vec::new();
        for &f in &rim {
            for v in t.face_halves(f).map(|h| t.vertex(h)) {
                if !seen.insert(v) {
                    continue;
                }
                let others = (t.vertex_count() as u32..t.fans().len() as u32)
                    .filter(|&fan| t.fan_vertex(fan) == v);
                for fan in std::iter::once(v).chain(others) {
                    let around = Ring::of_fan(t, fan).map(|h| t.face_of(h));
                    next.extend(around.filter(|g| faces.insert(*g)));
                }
            }
        }
        rim = next;
    }
    let own = faces.range(..own).count() as u32;
    (faces.into_iter().map(|f| (f, 0)).collect(), own)
}

/// The child of a face of `size` steps a side that holds a place, and the place in it.
fn child(triangular: bool, [x, y]: [u32; 2], size: u32) -> (u32, [u32; 2]) {
    let half = size / 2;
    if !triangular {
        let (right, up) = (u32::from(x > half), u32::from(y > half));
        let number = [[0, 1], [3, 2]][up as usize][right as usize];
        return (number, [x - right * half, y - up * half]);
    }
    match (x >= half, y >= half) {
        (true, _) => (1, [x - half, y]),
        (_, true) => (2, [x, y - half]),
        _ if x + y <= half => (0, [x, y]),
        // The one in the middle stands on its head.
        _ => (3, [half - x, half - y]),
    }
}

/// The corner of a face that is a place.
fn corner(triangular: bool, [x, y]: [u32; 2], size: u32) -> Option<u32> {
    let last = if triangular { 2 } else { 3 };
    match (x, y) {
        (0, 0) => Some(0),
        (_, 0) if x == size => Some(1),
        (0, _) if y == size => Some(last),
        _ if x == size && y == size => Some(2),
        _ => None,
    }
}

/// Derivatives by the parameters of a face, from those along both sides at corner `c`.
fn by_parameters(triangular: bool, c: u32, frame: &Frame) -> [[f64; 3]; 2] {
    let (a, b) = (frame.ahead, frame.behind);
    let negative = |d: [f64; 3]| d.map(|x| -x);
    let minus = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| a[k] - b[k]);
    match (triangular, c) {
        (_, 0) => [a, b],
        (false, 1) => [negative(b), a],
        (false, 2) => [negative(a), negative(b)],
        (false, _) => [b, negative(a)],
        (true, 1) => [negative(b), minus(a, b)],
        (true, _) => [minus(b, a), negative(a)],
    }
}

impl<'a> Walk<'a> {
    pub(super) fn new(tree: &'a TableTree, uvs: bool) -> Self {
        Self {
            tree,
            uvs,
            face: None,
            regions: BTreeMap::new(),
        }
    }

    fn region(&self, whole: &Level<f64>, face: u32, depth: u32) -> Region {
        let t = &whole.topology;
        let scheme = self.tree.options.scheme;
        let (faces, own) = surroundings(t, face, rings(scheme, depth));
        if self.uvs {
            return Region::Mesh {
                level: Box::new(whole.part(&faces).level),
                own,
                next: None,
            };
        }
        let level = Box::new(whole.part_of_points(&faces).level);
        let masks = Masks::default();
        let step = Step::new(&level.topology, &self.tree.options);
        let sheets = Sheets::<f64, f64, 3>::of_points(&step, &masks, &level.points);
        let first = level.topology.face_halves(own).start;
        let lattice = Lattice::of(&sheets, scheme.is_triangular(), first);
        drop(step);
        match lattice {
            Some(lattice) => Region::Lattice(Box::new(lattice)),
            None => Region::Mesh {
                level,
                own,
                next: None,
            },
        }
    }

    /// Makes child `c` of a region.
    fn enter(&mut self, (depth, number): (u32, u32), c: u32) -> Option<()> {
        let child = (depth + 1, 4 * number + c);
        if self.regions.contains_key(&child) {
            return Some(());
        }
        self.refine((depth, number))?;
        let region = match self.regions.get(&(depth, number))? {
            Region::Lattice(lattice) => Region::Lattice(Box::new(lattice.child(c))),
            Region::Mesh { own, next, .. } => self.region(next.as_deref()?, 4 * own + c, child.0),
        };
        self.regions.insert(child, region);
        Some(())
    }

    /// Makes the next level of a region that is a mesh.
    fn refine(&mut self, key: (u32, u32)) -> Option<()> {
        let options = self.tree.options;
        if let Region::Mesh { level, next, .. } = self.regions.get_mut(&key)?
            && next.is_none()
        {
            let finer = level.next(&options, &mut Timings::default()).ok()?;
            *next = Some(Box::new(finer));
        }
        Some(())
    }

    /// The surface at `place` of face `face` of those that are drawn, in [`STEPS`] along its sides; derivatives if wanted. Triangles have
    /// weights of corners 1 and 2 for places.
    pub(crate) fn find(&mut self, face: u32, place: [u32; 2], derivatives: bool) -> Option<Found> {
        if self.regions.len() > MOST_KEPT {
            self.regions.retain(|&(depth, _), _| depth < DEPTH_KEPT);
        }
        if self.face != Some(face) {
            self.regions.clear();
            let region = self.region(&self.tree.root.level, face, 0);
            self.regions.insert((0, 0), region);
            self.face = Some(face);
        }
        let triangular = self.tree.options.scheme.is_triangular();
        let (mut at, mut size, mut turn) = (place, STEPS, 1.0);
        let mut key = (0, 0);
        loop {
            let scale = turn * f64::from(STEPS / size);
            if let Some(c) = corner(triangular, at, size) {
                return self.at_corner(key, c, scale, derivatives);
            }
            let (number, inner) = child(triangular, at, size);
            (at, size) = (inner, size / 2);
            if triangular && number == 3 {
                turn = -turn;
            }
            // Corners of children need no surroundings of their own.
            if let Some(c) = corner(triangular, at, size)
                && matches!(self.regions.get(&key)?, Region::Mesh { .. })
            {
                self.refine(key)?;
                if let Region::Mesh { own, next, .. } = self.regions.get(&key)? {
                    let scale = turn * f64::from(STEPS / size);
                    let face = 4 * own + number;
                    return self.in_mesh(next.as_deref()?, face, c, scale, derivatives);
                }
            }
            self.enter(key, number)?;
            key = (key.0 + 1, 4 * key.1 + number);
        }
    }

    /// Corner `c` of the face of a region.
    fn at_corner(&self, key: (u32, u32), c: u32, scale: f64, derivatives: bool) -> Option<Found> {
        let lattice = match self.regions.get(&key)? {
            Region::Mesh { level, own, .. } => {
                return self.in_mesh(level, *own, c, scale, derivatives);
            }
            Region::Lattice(lattice) => lattice,
        };
        let mut found = Found {
            position: lattice.corner(c),
            ..Found::default()
        };
        if derivatives {
            let sides = lattice.derivatives(c);
            found.normal = normal(sides)
                .or_else(|| normal(lattice.sides()))
                .unwrap_or([0.0, 0.0, 1.0]);
            [found.du, found.dv] = sides.map(|d| d.map(|x| scale * x));
        }
        Some(found)
    }

    /// Corner `c` of a face of a mesh.
    fn in_mesh(
        &self,
        level: &Level<f64>,
        face: u32,
        c: u32,
        scale: f64,
        derivatives: bool,
    ) -> Option<Found> {
        let t = &level.topology;
        let h = t.face_halves(face).start + c;
        if self.uvs {
            let uvs = level.uvs.as_ref()?;
            let [u, v] = uvs.values[uvs.corners[h as usize] as usize];
            return Some(Found {
                position: [u, v, 0.0],
                ..Found::default()
            });
        }
        let mut found = Found {
            position: level.points[t.vertex(h) as usize],
            ..Found::default()
        };
        if derivatives {
            let scheme = self.tree.options.scheme;
            let step = Step::new(t, &self.tree.options);
            let frame = self.tree.tangents().frame(&step, &level.points, h);
            let both = by_parameters(scheme.is_triangular(), c, &frame);
            [found.du, found.dv] = both.map(|d| d.map(|x| scale * x));
            found.normal = frame.normal;
        }
        Some(found)
    }
}
