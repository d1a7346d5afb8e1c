//! Procedural heights: smooth functions of a point in space with their exact gradients.
//!
//! Lattice points are hashed as integers and everything else is plain arithmetic without branches, so loops over many points become vector
//! code and give the same bits on every machine. Gradient noise after Perlin, *Improving noise* (2002); sums of octaves after Musgrave,
//! in Ebert et al., *Texturing and Modeling* (1998).

use crate::math;

/// A value and its gradient.
pub(crate) type Slope = [f32; 4];

/// Largest magnitude of gradient noise. The values of this noise reach 1.0364.
pub(super) const MOST: f32 = 1.04;

/// What a step along each axis adds to the sum that is hashed.
const STEPS: [u32; 3] = [0x8da6_b343, 0xd816_3841, 0xcb1a_b31f];

/// Mixes the bits of what the coordinates of a lattice point come to.
#[inline(always)]
fn hash(mut h: u32) -> u32 {
    h ^= h >> 16;
    h = h.wrapping_mul(0x7feb_352d);
    h ^= h >> 15;
    h = h.wrapping_mul(0x846c_a68b);
    h ^ (h >> 16)
}

/// A number with the sign turned if bit `bit` of `h` is set.
#[inline(always)]
fn turned(x: f32, h: u32, bit: u32) -> f32 {
    f32::from_bits(x.to_bits() ^ ((h << (31 - bit)) & 0x8000_0000))
}

/// One of the twelve directions to the middles of a cube's edges, four of them twice, by the four lowest bits of a hash.
#[inline(always)]
fn direction(h: u32) -> [f32; 3] {
    let (a, b) = (turned(1.0, h, 0), turned(1.0, h, 1));
    // The first component goes along x or y, the second along y, x or z.
    let first_x = h & 8 == 0;
    let second_y = h & 12 == 0;
    let second_x = h & 13 == 12;
    let other_x = if second_x { b } else { 0.0 };
    let x = if first_x { a } else { other_x };
    let other_y = if second_y { b } else { 0.0 };
    let y = if first_x { other_y } else { a };
    let z = if second_y || second_x { 0.0 } else { b };
    [x, y, z]
}

/// The integer below, and how far beyond it. Without a fraction (beyond 2^23, and of what is no number) 0.
#[inline(always)]
fn cell(x: f32) -> (i32, f32) {
    let x = if x.abs() < 8_388_608.0 { x } else { 0.0 };
    let i = math::floor(x);
    (i, x - i as f32)
}

/// Perlin's blend and its derivative.
#[inline(always)]
fn fade(t: f32) -> [f32; 2] {
    let s = t * t;
    [
        s * t * (t * (t * 6.0 - 15.0) + 10.0),
        30.0 * s * (t * (t - 2.0) + 1.0),
    ]
}

// No closures below: those that are not inlined would be compiled without the caller's vector instructions.

/// The cell that a point is in. Of each axis, for the lattice points below and above: what they add to the hash, and how far the point is
/// beyond them; and the blend from one to the other.
struct Cell {
    sums: [[u32; 2]; 3],
    beyond: [[f32; 2]; 3],
    fade: [[f32; 2]; 3],
}

impl Cell {
    #[inline(always)]
    fn at(p: [f32; 3], seed: u32) -> Self {
        let (i, x) = cell(p[0]);
        let (j, y) = cell(p[1]);
        let (k, z) = cell(p[2]);
        let seed = seed.wrapping_mul(0x9e37_79b9);
        let [a, b, c] = [
            (i as u32).wrapping_mul(STEPS[0]),
            (j as u32).wrapping_mul(STEPS[1]),
            (k as u32).wrapping_mul(STEPS[2]),
        ];
        Self {
            sums: [
                [a ^ seed, a.wrapping_add(STEPS[0]) ^ seed],
                [b, b.wrapping_add(STEPS[1])],
                [c, c.wrapping_add(STEPS[2])],
            ],
            beyond: [[x, x - 1.0], [y, y - 1.0], [z, z - 1.0]],
            fade: [fade(x), fade(y), fade(z)],
        }
    }

    /// The hash of corner (`a`, `b`, `c`), and how far the point is beyond it.
    #[inline(always)]
    fn corner(&self, [a, b, c]: [usize; 3]) -> (u32, [f32; 3]) {
        let [x, y, z] = &self.sums;
        let h = hash(x[a] ^ y[b] ^ z[c]);
        let [x, y, z] = &self.beyond;
        (h, [x[a], y[b], z[c]])
    }

    /// What a corner has to say of the point.
    #[inline(always)]
    fn slope(&self, at: [usize; 3]) -> Slope {
        let (h, [x, y, z]) = self.corner(at);
        let [gx, gy, gz] = direction(h);
        [(gx * x + gy * y) + gz * z, gx, gy, gz]
    }

    /// The first number of [`Cell::slope`]: of the two components of a direction that are not zero, in the same order but for what is added
    /// to zeros.
    #[inline(always)]
    fn value(&self, at: [usize; 3]) -> f32 {
        let (h, [x, y, z]) = self.corner(at);
        let first = if h & 8 == 0 { x } else { y };
        let other = if h & 13 == 12 { x } else { z };
        let second = if h & 12 == 0 { y } else { other };
        turned(first, h, 0) + turned(second, h, 1)
    }

    /// The blend along x of the two corners at `b` along y and `c` along z.
    #[inline(always)]
    fn slope_along_x(&self, [b, c]: [usize; 2]) -> Slope {
        mix(
            self.slope([0, b, c]),
            self.slope([1, b, c]),
            self.fade[0],
            1,
        )
    }

    /// The same of values.
    #[inline(always)]
    fn value_along_x(&self, [b, c]: [usize; 2]) -> f32 {
        let (near, far) = (self.value([0, b, c]), self.value([1, b, c]));
        near + (far - near) * self.fade[0][0]
    }
}

/// The blend of two values along an axis, which adds its own derivative.
#[inline(always)]
fn mix(a: Slope, b: Slope, [t, dt]: [f32; 2], axis: usize) -> Slope {
    let mut out = [
        a[0] + (b[0] - a[0]) * t,
        a[1] + (b[1] - a[1]) * t,
        a[2] + (b[2] - a[2]) * t,
        a[3] + (b[3] - a[3]) * t,
    ];
    out[axis] += (b[0] - a[0]) * dt;
    out
}

/// Gradient noise at a point: 0 at lattice points, about 1 apart.
#[inline(always)]
pub(super) fn perlin(p: [f32; 3], seed: u32) -> Slope {
    let cell = Cell::at(p, seed);
    let [_, v, w] = cell.fade;
    // Along x, then y, then z. No loop: the compiler would do the four in lanes, and not the points.
    let low = mix(cell.slope_along_x([0, 0]), cell.slope_along_x([1, 0]), v, 2);
    let high = mix(cell.slope_along_x([0, 1]), cell.slope_along_x([1, 1]), v, 2);
    mix(low, high, w, 3)
}

/// [`perlin`] without its gradient.
#[inline(always)]
pub(super) fn perlin_value(p: [f32; 3], seed: u32) -> f32 {
    let cell = Cell::at(p, seed);
    let [_, [v, _], [w, _]] = cell.fade;
    let (a, b) = (cell.value_along_x([0, 0]), cell.value_along_x([1, 0]));
    let low = a + (b - a) * v;
    let (a, b) = (cell.value_along_x([0, 1]), cell.value_along_x([1, 1]));
    let high = a + (b - a) * v;
    low + (high - low) * w
}

/// The seed of a whole time.
#[inline(always)]
fn seed_at(seed: u32, time: i32) -> u32 {
    seed.wrapping_add((time as u32).wrapping_mul(0x632b_e5ab))
}

/// The same as it changes with time: at whole times it is noise of different seeds, between them a blend of the two that keeps its
/// strength about.
#[inline(always)]
pub(super) fn moving(p: [f32; 3], time: f32, seed: u32) -> Slope {
    let (step, t) = cell(time);
    let a = perlin(p, seed_at(seed, step));
    if t == 0.0 {
        return a;
    }
    let b = perlin(p, seed_at(seed, step.wrapping_add(1)));
    let [s, _] = fade(t);
    // Independent values of equal variance: the sum of squares of the weights is kept at 1.
    let norm = 1.0 / ((1.0 - s) * (1.0 - s) + s * s).sqrt();
    let mut out = [0.0; 4];
    for k in 0..4 {
        out[k] = (a[k] * (1.0 - s) + b[k] * s) * norm;
    }
    out
}

/// Largest growth of [`moving`] over [`perlin`]: the square root of 2, half-way between two times.
pub(super) const MOVING: f32 = 1.4143;

#[cfg(test)]
mod tests {
    use super::*;

    fn places() -> impl Iterator<Item = [f32; 3]> {
        (0..4000_u32).map(|i| {
            [1, 2, 3]
                .map(|k| hash(i.wrapping_mul(STEPS[0]) ^ k) as f32 / u32::MAX as f32 * 40.0 - 20.0)
        })
    }

    #[test]
    fn noise_is_zero_at_the_lattice_and_within_its_bound() {
        for p in places() {
            assert_eq!(perlin(p.map(f32::floor), 3)[0], 0.0);
            assert!(perlin(p, 3)[0].abs() <= MOST);
            assert!(moving(p, 0.5, 3)[0].abs() <= MOST * MOVING);
        }
        let most = places().map(|p| perlin(p, 3)[0].abs()).fold(0.0, f32::max);
        assert!(most > 0.7, "{most}");
    }

    #[test]
    fn values_alone_have_the_same_bits() {
        for p in places().chain(places().map(|p| p.map(f32::round))) {
            // Zeros may have another sign: they are added to heights.
            assert_eq!(perlin_value(p, 3) + 0.0, perlin(p, 3)[0] + 0.0, "{p:?}");
        }
    }

    #[test]
    fn gradients_are_differences() {
        for p in places() {
            for f in [&|p| perlin(p, 5), &|p| moving(p, 2.3, 5)] as [&dyn Fn([f32; 3]) -> Slope; 2]
            {
                let slope = f(p);
                for k in 0..3 {
                    let step = 1.0 / 256.0;
                    let (mut a, mut b) = (p, p);
                    a[k] -= step;
                    b[k] += step;
                    let found = (f(b)[0] - f(a)[0]) / (2.0 * step);
                    assert!(
                        (found - slope[1 + k]).abs() < 2e-3,
                        "{p:?} {k}: {found} {slope:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn seeds_and_times_differ() {
        let p = [0.3, 0.4, 0.7];
        assert_ne!(perlin(p, 1), perlin(p, 2));
        assert_ne!(moving(p, 0.0, 1), moving(p, 1.0, 1));
        assert_eq!(moving(p, 0.0, 1), perlin(p, 1));
        for far in [f32::INFINITY, f32::NAN, 1e30] {
            assert!(perlin([far, 0.5, 0.5], 1).iter().all(|x| x.is_finite()));
        }
    }
}
