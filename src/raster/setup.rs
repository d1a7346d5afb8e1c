//! Conservative screen boxes of convex hulls, for binning and for hiding what lies behind.

use super::project::dot;
use crate::records::{Projection, ScreenSize};

/// Added to boxes on all sides, 1/256 pixel. Points of a surface inside the hull are evaluated and projected with rounding errors of
/// their own, far below this; too small a margin would lose samples at tile borders.
pub const SCREEN_MARGIN: f32 = 32.0;

/// Added to nearest depths, relative; for the same reason.
pub(super) const DEPTH_MARGIN: f32 = 1.0 + 1.0 / 16384.0;

/// Pixels that a convex hull may touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelBox {
    /// First column and row.
    pub low: [u32; 2],
    /// One beyond the last column and row.
    pub high: [u32; 2],
    /// No point of the hull is nearer: its depth as in visibility keys.
    pub nearest: f32,
}

/// Screen box of the convex hull of `points`, which may cross the near plane; `None` if it is not on the screen. The hull behind the
/// near plane is spanned by the points behind it and the crossings of all segments, so no part of it is lost.
#[must_use]
pub fn bounds(
    points: &[[f32; 3]],
    projection: &Projection,
    screen: ScreenSize,
) -> Option<PixelBox> {
    let p = projection;
    let whole = PixelBox {
        low: [0; 2],
        high: [screen.width, screen.height],
        nearest: f32::MAX,
    };
    let mut low = [f32::INFINITY; 2];
    let mut high = [f32::NEG_INFINITY; 2];
    let mut nearest = 0.0_f32;
    let (mut visible, mut hidden) = (false, false);
    let mut add = |x: f32, y: f32, depth: f32| {
        low = [low[0].min(x), low[1].min(y)];
        high = [high[0].max(x), high[1].max(y)];
        nearest = nearest.max(depth);
    };
    for &[x, y, z] in points {
        let (hx, hy) = (dot(&p.x, x, y, z), dot(&p.y, x, y, z));
        let h = if p.ortho {
            dot(&p.d, x, y, z)
        } else {
            dot(&p.w, x, y, z)
        };
        if !(hx + hy + h).is_finite() {
            return Some(whole);
        }
        if p.ortho {
            visible |= h <= 2.0;
            // Crossings have positions between those of their ends: the box of all points holds them.
            add(hx, hy, h.clamp(f32::MIN_POSITIVE, 2.0));
        } else if h >= p.near {
            visible = true;
            add(hx / h, hy / h, 1.0 / h);
        } else {
            hidden = true;
        }
    }
    if !visible {
        return None;
    }
    if hidden {
        nearest = 1.0 / p.near;
        for &[x, y, z] in points {
            let w = dot(&p.w, x, y, z);
            if w < p.near {
                continue;
            }
            let inside = [dot(&p.x, x, y, z), dot(&p.y, x, y, z)];
            for &[x, y, z] in points {
                let w_out = dot(&p.w, x, y, z);
                if w_out < p.near {
                    let t = (w - p.near) / (w - w_out);
                    let outside = [dot(&p.x, x, y, z), dot(&p.y, x, y, z)];
                    for k in 0..2 {
                        let at = (inside[k] + (outside[k] - inside[k]) * t) / p.near;
                        low[k] = low[k].min(at);
                        high[k] = high[k].max(at);
                    }
                }
            }
        }
        if !(low[0] + low[1] + high[0] + high[1]).is_finite() {
            return Some(whole);
        }
    }
    let size = [screen.width, screen.height];
    let mut out = PixelBox {
        low: [0; 2],
        high: [0; 2],
        nearest: nearest * DEPTH_MARGIN,
    };
    for k in 0..2 {
        // Relative, too: far off positions have coarse floats.
        let slack = SCREEN_MARGIN + (low[k].abs() + high[k].abs()) * 1e-5;
        let first = ((low[k] - slack) / 256.0).floor().max(0.0);
        let end = ((high[k] + slack) / 256.0).ceil().min(size[k] as f32);
        if first >= end {
            return None;
        }
        out.low[k] = first as u32;
        out.high[k] = end as u32;
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn projection() -> Projection {
        Projection {
            x: [12800.0, 0.0, 12800.0, 0.0],
            y: [0.0, 12800.0, 12800.0, 0.0],
            w: [0.0, 0.0, 1.0, 0.0],
            d: [0.0; 4],
            near: 0.125,
            ortho: false,
        }
    }
    const SCREEN: ScreenSize = ScreenSize {
        width: 100,
        height: 100,
        samples: 1,
    };

    #[test]
    fn box_holds_all_points_of_the_hull() {
        // A tetrahedron through the near plane; random points of it must project into the box.
        let corners = [
            [0.1_f32, 0.2, 1.5],
            [-0.3, 0.1, 0.05],
            [0.2, -0.2, 2.0],
            [0.05, 0.02, -0.3],
        ];
        let found = bounds(&corners, &projection(), SCREEN).unwrap();
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let mut checked = 0;
        for _ in 0..20_000 {
            let w: [f32; 4] = std::array::from_fn(|_| random());
            let sum: f32 = w.iter().sum();
            let p: [f32; 3] =
                std::array::from_fn(|k| (0..4).map(|c| w[c] * corners[c][k]).sum::<f32>() / sum);
            if p[2] < 0.125 {
                continue;
            }
            assert!(1.0 / p[2] <= found.nearest);
            for k in 0..2 {
                let at = (12800.0 * p[k] / p[2] + 12800.0) / 256.0;
                if at > 0.0 && at < 100.0 {
                    checked += 1;
                    assert!(at >= found.low[k] as f32 && at <= found.high[k] as f32);
                }
            }
        }
        assert!(checked > 10_000);
    }

    #[test]
    fn off_screen_and_behind_vanish() {
        let p = projection();
        assert_eq!(
            bounds(&[[0.0, 0.0, -1.0], [1.0, 0.0, 0.1]], &p, SCREEN),
            None
        );
        assert_eq!(
            bounds(&[[9.0, 0.0, 1.0], [8.0, 0.0, 1.0]], &p, SCREEN),
            None
        );
        let small = bounds(&[[0.0, 0.0, 1.0]], &p, SCREEN).unwrap();
        assert_eq!((small.low, small.high), ([49, 49], [51, 51]));
        assert!(bounds(&[[f32::NAN, 0.0, 1.0]], &p, SCREEN).is_some());
    }
}
