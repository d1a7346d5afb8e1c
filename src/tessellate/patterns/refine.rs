//! Faces of any triangle mesh refined by patterns: every attribute interpolated by its own order, then displaced by whoever asks.

use super::{Pattern, Place, TrianglePattern};
use std::collections::BTreeMap;

/// How an attribute runs over a triangle: a Bézier triangle of degree 1, 2 or 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Three values, of corners 0, 1 and 2.
    Linear,
    /// Six: those of the corners, then of sides 0, 1 and 2 (b110, b011, b101).
    Quadratic,
    /// Ten: those of the corners; then two of each side, the one nearer to its first corner first (b210, b120, b021, b012, b102, b201); then
    /// the middle, b111.
    Cubic,
}

impl Order {
    /// Control values per component.
    #[must_use]
    pub const fn controls(self) -> usize {
        match self {
            Self::Linear => 3,
            Self::Quadratic => 6,
            Self::Cubic => 10,
        }
    }

    /// Weights of the control values at barycentric coordinates `w`, grouped so that a point of a side has the same sum from both faces.
    fn weights(self, [u, v, w]: [f32; 3]) -> ([f32; 3], [[f32; 2]; 3], f32) {
        let none = [[0.0; 2]; 3];
        match self {
            Self::Linear => ([u, v, w], none, 0.0),
            Self::Quadratic => {
                let sides = [u * v, v * w, w * u].map(|w| [2.0 * w, 0.0]);
                ([u * u, v * v, w * w], sides, 0.0)
            }
            Self::Cubic => {
                let side = |a: f32, b: f32| [3.0 * (a * a * b), 3.0 * (b * b * a)];
                let corners = [u, v, w].map(|a| a * a * a);
                (
                    corners,
                    [side(u, v), side(v, w), side(w, u)],
                    6.0 * (u * v * w),
                )
            }
        }
    }
}

/// One attribute of all faces: positions, normals, texture coordinates or whatever there is.
#[derive(Clone, Copy, Debug)]
pub struct Attribute<'a> {
    /// How it is interpolated.
    pub order: Order,
    /// Components of a value, 3 for positions.
    pub components: usize,
    /// Face after face its [`Order::controls`] control values, each of so many components.
    pub control: &'a [f32],
}

impl Attribute<'_> {
    /// Appends the value at `w` of a face.
    fn evaluate(&self, face: usize, w: [f32; 3], out: &mut Vec<f32>) {
        let count = self.order.controls();
        let values = &self.control[face * count * self.components..];
        let (corners, sides, middle) = self.order.weights(w);
        for c in 0..self.components {
            let at = |k: usize| values[k * self.components + c];
            let mut sum = (corners[0] * at(0) + corners[1] * at(1)) + corners[2] * at(2);
            sum += match self.order {
                Order::Linear => 0.0,
                Order::Quadratic => {
                    (sides[0][0] * at(3) + sides[1][0] * at(4)) + sides[2][0] * at(5)
                }
                Order::Cubic => {
                    let side = |k: usize| sides[k][0] * at(3 + 2 * k) + sides[k][1] * at(4 + 2 * k);
                    ((side(0) + side(1)) + side(2)) + middle * at(9)
                }
            };
            out.push(sum);
        }
    }
}

/// A refined face, handed out and then forgotten.
#[derive(Clone, Copy, Debug)]
pub struct RefinedFace<'a> {
    /// Number of the face.
    pub face: usize,
    /// Its vertices, one after the other, with the components of all attributes in their order.
    pub vertices: &'a [f32],
    /// Triangles over the vertices.
    pub triangles: &'a [[u32; 3]],
}

/// A pattern in hand: the points that it uses, and its triangles over them.
struct Prepared {
    weights: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Prepared {
    fn new(pattern: &TrianglePattern) -> Self {
        let scale = 1.0 / (1_u32 << pattern.depth()) as f32;
        let mut numbers: BTreeMap<Place, u32> = BTreeMap::new();
        let (mut weights, mut triangles) = (Vec::new(), Vec::new());
        for t in pattern.triangles() {
            triangles.push(t.map(|place| {
                *numbers.entry(place).or_insert_with(|| {
                    let [x, y] = place.map(|k| f32::from(k) * scale);
                    weights.push([1.0 - x - y, x, y]);
                    weights.len() as u32 - 1
                })
            }));
        }
        Self { weights, triangles }
    }
}

/// Refines triangles by patterns: `depths` has three depths per face, one for each side. `displace` gets the number of the face and the
/// components of a vertex, to change as it likes; `each` gets face after face. Faces of one pattern follow each other, as an engine would
/// bind it once. One pattern and one face are held at a time: at depth 10, about 40 MB.
///
/// Values of a side depend, bit for bit, on the side's control values alone. What `displace` does has to as well, or the surface opens.
///
/// # Panics
/// A depth is above 10, or an attribute has fewer control values than the faces need.
pub fn refine(
    pattern: Pattern,
    depths: &[[u8; 3]],
    attributes: &[Attribute<'_>],
    mut displace: impl FnMut(usize, &mut [f32]),
    mut each: impl FnMut(RefinedFace<'_>),
) {
    for a in attributes {
        let wanted = depths.len() * a.order.controls() * a.components;
        assert!(
            a.control.len() >= wanted,
            "{} control values, {wanted} are needed",
            a.control.len()
        );
    }
    let mut groups: BTreeMap<[u8; 3], Vec<usize>> = BTreeMap::new();
    for (face, &d) in depths.iter().enumerate() {
        groups.entry(d).or_default().push(face);
    }
    let size: usize = attributes.iter().map(|a| a.components).sum();
    let mut vertices = Vec::new();
    for (d, faces) in groups {
        let found = TrianglePattern::new(pattern, d);
        assert!(found.is_some(), "depths are 0 to 10, not {d:?}");
        let Some(prepared) = found.as_ref().map(Prepared::new) else {
            continue;
        };
        for face in faces {
            vertices.clear();
            for &w in &prepared.weights {
                let first = vertices.len();
                for a in attributes {
                    a.evaluate(face, w, &mut vertices);
                }
                if size > 0 {
                    displace(face, &mut vertices[first..]);
                }
            }
            each(RefinedFace {
                face,
                vertices: &vertices,
                triangles: &prepared.triangles,
            });
        }
    }
}
