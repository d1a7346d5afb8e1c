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

/// Mixes the bits of a lattice point.
#[inline(always)]
fn hash([x, y, z]: [i32; 3], seed: u32) -> u32 {
    let mut h = (x as u32).wrapping_mul(0x8da6_b343)
        ^ (y as u32).wrapping_mul(0xd816_3841)
        ^ (z as u32).wrapping_mul(0xcb1a_b31f)
        ^ seed.wrapping_mul(0x9e37_79b9);
    h ^= h >> 16;
    h = h.wrapping_mul(0x7feb_352d);
    h ^= h >> 15;
    h = h.wrapping_mul(0x846c_a68b);
    h ^ (h >> 16)
}

/// One of the twelve directions to the middles of a cube's edges; four of them twice.
#[inline(always)]
fn direction(h: u32) -> [f32; 3] {
    let h = h & 15;
    let a = if h & 1 == 0 { 1.0 } else { -1.0 };
    let b = if h & 2 == 0 { 1.0 } else { -1.0 };
    // The first component goes along x or y, the second along y, x or z.
    let first_x = h < 8;
    let second_y = h < 4;
    let second_x = !second_y && (h == 12 || h == 14);
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

/// What lattice point `of + at` has to say of the place `from` beyond `of`.
#[inline(always)]
fn corner(of: [i32; 3], from: [f32; 3], at: [i32; 3], seed: u32) -> Slope {
    let place = [
        of[0].wrapping_add(at[0]),
        of[1].wrapping_add(at[1]),
        of[2].wrapping_add(at[2]),
    ];
    let [gx, gy, gz] = direction(hash(place, seed));
    let (x, y, z) = (
        from[0] - at[0] as f32,
        from[1] - at[1] as f32,
        from[2] - at[2] as f32,
    );
    [(gx * x + gy * y) + gz * z, gx, gy, gz]
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

/// The blend along x of the two corners at `b` along y and `c` along z.
#[inline(always)]
fn along_x(of: [i32; 3], from: [f32; 3], [b, c]: [i32; 2], seed: u32, u: [f32; 2]) -> Slope {
    let near = corner(of, from, [0, b, c], seed);
    let far = corner(of, from, [1, b, c], seed);
    mix(near, far, u, 1)
}

/// Gradient noise at a point: 0 at lattice points, about 1 apart.
#[inline(always)]
pub(super) fn perlin(p: [f32; 3], seed: u32) -> Slope {
    let (ix, x) = cell(p[0]);
    let (iy, y) = cell(p[1]);
    let (iz, z) = cell(p[2]);
    let (of, from) = ([ix, iy, iz], [x, y, z]);
    let (u, v, w) = (fade(x), fade(y), fade(z));
    // Along x, then y, then z. No loop: the compiler would do the four in lanes, and not the points.
    let low = mix(
        along_x(of, from, [0, 0], seed, u),
        along_x(of, from, [1, 0], seed, u),
        v,
        2,
    );
    let high = mix(
        along_x(of, from, [0, 1], seed, u),
        along_x(of, from, [1, 1], seed, u),
        v,
        2,
    );
    mix(low, high, w, 3)
}

/// The same as the first number of `corner`: of the two components of a direction that are not zero, in the same order but for what is added
/// to zeros.
#[inline(always)]
fn corner_value(of: [i32; 3], from: [f32; 3], at: [i32; 3], seed: u32) -> f32 {
    let place = [
        of[0].wrapping_add(at[0]),
        of[1].wrapping_add(at[1]),
        of[2].wrapping_add(at[2]),
    ];
    let h = hash(place, seed) & 15;
    let (x, y, z) = (
        from[0] - at[0] as f32,
        from[1] - at[1] as f32,
        from[2] - at[2] as f32,
    );
    let first = if h < 8 { x } else { y };
    let other = if h == 12 || h == 14 { x } else { z };
    let second = if h < 4 { y } else { other };
    let first = if h & 1 == 0 { first } else { -first };
    let second = if h & 2 == 0 { second } else { -second };
    first + second
}

/// [`perlin`] without its gradient.
#[inline(always)]
pub(super) fn perlin_value(p: [f32; 3], seed: u32) -> f32 {
    let (ix, x) = cell(p[0]);
    let (iy, y) = cell(p[1]);
    let (iz, z) = cell(p[2]);
    let (of, from) = ([ix, iy, iz], [x, y, z]);
    let (u, v, w) = (fade(x)[0], fade(y)[0], fade(z)[0]);
    let mut edges = [0.0; 4];
    for k in 0..4 {
        let (b, c) = (k as i32 & 1, k as i32 >> 1);
        let near = corner_value(of, from, [0, b, c], seed);
        let far = corner_value(of, from, [1, b, c], seed);
        edges[k] = near + (far - near) * u;
    }
    let low = edges[0] + (edges[1] - edges[0]) * v;
    let high = edges[2] + (edges[3] - edges[2]) * v;
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
            [1, 2, 3].map(|k| hash([i as i32, k, 7], 1) as f32 / u32::MAX as f32 * 40.0 - 20.0)
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
