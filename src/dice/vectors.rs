//! Vectors of rings in `f64`.

pub(super) type V3 = [f64; 3];

/// Square of the sine of the angle below which the two ends of a corner's ring are one line: points have 24 bits, and what those leave of a
/// cross product has no direction.
const STRAIGHT: f64 = 1e-10;

pub(super) fn add(a: V3, b: V3, k: f64) -> V3 {
    [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]]
}

pub(super) fn dot(a: V3, b: V3) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

pub(super) fn cross(a: V3, b: V3) -> V3 {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn size(v: V3) -> f64 {
    v[0].abs().max(v[1].abs()).max(v[2].abs())
}

/// With length 1; nothing where there is no direction.
pub(super) fn unit(a: V3) -> Option<V3> {
    let m = size(a);
    if !(m > 0.0 && m.is_finite()) {
        return None;
    }
    let s = a.map(|c| c / m);
    let l = dot(s, s).sqrt();
    Some(s.map(|c| c / l))
}

/// Tangents that cancel to rounding have no direction: compared with the size of what was summed.
pub(super) fn are_parallel([a, b]: [V3; 2]) -> bool {
    size(cross(a, b)) <= 1e-10 * (size(a) * size(b))
}

/// The unit normal of the two ends of a corner's ring, unless they are one line. They know the plane, but not on which side of a reflex angle
/// the faces are: the `area` of the ring does.
pub(super) fn normal_of_ends([a, b]: [V3; 2], area: V3) -> Option<V3> {
    let turn = cross(unit(a)?, unit(b)?);
    if dot(turn, turn) <= STRAIGHT {
        return None;
    }
    let normal = cross(a, b);
    let inward = dot(normal, area) < 0.0;
    unit(if inward { normal.map(|c| -c) } else { normal })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_of_one_line_have_no_normal() {
        // Rounded to single precision, as points are.
        let a = [0.1_f32, 0.2, 0.3].map(f64::from);
        let b = a.map(|c| f64::from(-1.7 * c as f32));
        assert_ne!(cross(a, b), [0.0; 3]);
        assert_eq!(normal_of_ends([a, b], [0.0, 0.0, 1.0]), None);
        assert_eq!(normal_of_ends([a, [0.0; 3]], [0.0, 0.0, 1.0]), None);
        let side = normal_of_ends([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]], [0.0, 0.0, -3.0]);
        assert_eq!(side, Some([-0.0, -0.0, -1.0]));
    }
}
