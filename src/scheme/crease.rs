//! Sharpness: decay, the rule of a vertex, and how a rule gives way to the next.
//!
//! Semi-sharp creases after DeRose, Kass, Truong 1998, with OpenSubdiv's choices where the paper leaves any. Sharpness is stored and
//! decays in `f32`, also where points are refined in `f64`: 1.4 − 1 is 0.39999998 for everybody.

use super::{CreaseMethod, INFINITE_SHARPNESS};

/// Rule of a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// No sharp edge.
    Smooth,
    /// One sharp edge; refines like a smooth vertex.
    Dart,
    /// Two sharp edges, a curve through the vertex.
    Crease,
    /// Three sharp edges or more, or a sharp vertex: it stays where it is.
    Corner,
}

impl Rule {
    /// The rule of a vertex of sharpness `vertex` with `sharp_edges` edges of sharpness above 0.
    #[must_use]
    #[inline]
    pub fn of(vertex: f32, sharp_edges: usize) -> Self {
        if vertex > 0.0 || sharp_edges > 2 {
            Self::Corner
        } else {
            match sharp_edges {
                0 => Self::Smooth,
                1 => Self::Dart,
                _ => Self::Crease,
            }
        }
    }
}

/// Whether sharpness `s` is above 0 and will decay.
#[must_use]
#[inline]
pub fn is_semi_sharp(s: f32) -> bool {
    s > 0.0 && s < INFINITE_SHARPNESS
}

/// Whether sharpness `s` never decays.
#[must_use]
#[inline]
pub fn is_infinite(s: f32) -> bool {
    s >= INFINITE_SHARPNESS
}

/// Sharpness one level on: less by one, unless infinite. For vertices, and for edges of uniform creases.
#[must_use]
#[inline]
pub fn decay(s: f32) -> f32 {
    if s >= INFINITE_SHARPNESS {
        INFINITE_SHARPNESS
    } else if s > 1.0 {
        s - 1.0
    } else {
        0.0
    }
}

/// Sharpness of the child at vertex v of an edge of sharpness `s`.
///
/// `sum` and `count` are those of the semi-sharp edges at v, this one included; infinite edges take no part. Uniform creases ignore
/// both.
#[must_use]
#[inline]
pub fn decay_edge(method: CreaseMethod, s: f32, sum: f32, count: usize) -> f32 {
    if method == CreaseMethod::Uniform || !is_semi_sharp(s) || count < 2 {
        return decay(s);
    }
    let others = (sum - s) / (count - 1) as f32;
    (0.75 * s + 0.25 * others - 1.0).max(0.0)
}

/// Weight of the midpoint in the edge point; the smooth point has the rest.
///
/// Chaikin creases between 1 and 4/3 may lose all their sharpness in one step. The weight is then above 1 and the edge point lies
/// beyond the midpoint. A clamp would look more plausible, but every other implementation extrapolates too, so we match.
#[must_use]
#[inline]
pub fn midpoint_weight(s: f32, children: [f32; 2]) -> f64 {
    if s <= 0.0 {
        0.0
    } else if children[0] > 0.0 && children[1] > 0.0 {
        1.0
    } else {
        f64::from(s)
    }
}

/// What loses its sharpness at a vertex in this step; gives the weight of the parent's rule against the child's.
#[derive(Clone, Copy, Debug, Default)]
pub struct Transition {
    sum: f32,
    count: u32,
}

impl Transition {
    /// Takes note of a vertex or edge of sharpness `s` whose child has sharpness `child`.
    #[inline]
    pub fn note(&mut self, s: f32, child: f32) {
        if s > 0.0 && child <= 0.0 {
            self.sum += s;
            self.count += 1;
        }
    }
    /// Weight of the parent's rule: the mean sharpness of what is lost, at most 1.
    #[must_use]
    #[inline]
    pub fn weight(&self) -> f64 {
        if self.count == 0 {
            0.0
        } else {
            f64::from(self.sum / self.count as f32).min(1.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decay_is_single_precision() {
        assert_eq!(decay(1.4), 1.4_f32 - 1.0);
        assert_eq!(decay(1.0), 0.0);
        assert_eq!(decay(10.0), 10.0);
        assert_eq!(decay(25.0), 10.0);
        assert_eq!(decay(-3.0), 0.0);
    }

    #[test]
    fn chaikin_averages_along_the_crease() {
        let m = CreaseMethod::Chaikin;
        // Neighbour 4 beside 2: 0.75·2 + 0.25·4 − 1.
        assert_eq!(decay_edge(m, 2.0, 6.0, 2), 1.5);
        // Alone at its vertex, and infinite: as uniform.
        assert_eq!(decay_edge(m, 2.0, 2.0, 1), 1.0);
        assert_eq!(decay_edge(m, 10.0, 3.0, 2), 10.0);
        assert_eq!(decay_edge(m, 0.2, 0.4, 2), 0.0);
        assert_eq!(decay_edge(CreaseMethod::Uniform, 2.0, 6.0, 2), 1.0);
    }

    #[test]
    fn blends() {
        assert_eq!(midpoint_weight(0.0, [0.0; 2]), 0.0);
        assert_eq!(midpoint_weight(0.4, [0.0; 2]), f64::from(0.4_f32));
        assert_eq!(midpoint_weight(1.2, [0.0, 0.1]), f64::from(1.2_f32));
        assert_eq!(midpoint_weight(3.0, [2.0; 2]), 1.0);
        let mut t = Transition::default();
        t.note(0.25, 0.0);
        t.note(0.75, 0.0);
        t.note(3.0, 2.0);
        assert_eq!(t.weight(), 0.5);
        assert_eq!(Transition::default().weight(), 0.0);
    }
}
