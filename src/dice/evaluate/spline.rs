//! A bicubic B-spline and its derivatives at one parameter.
//!
//! Rows of four points are sixteen lanes: the blend across rows is plain lane arithmetic, the blend along the row follows.

use crate::dice::point::P4;

/// One row of four control points.
pub(super) type Row = [f32; 16];

/// Position and derivatives; those above the order asked for are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Jet {
    pub(crate) position: P4,
    pub(crate) du: P4,
    pub(crate) dv: P4,
    pub(crate) duu: P4,
    pub(crate) duv: P4,
    pub(crate) dvv: P4,
}

impl Jet {
    /// The same surface over a parameter `scale` times as fast.
    #[inline(always)]
    pub(crate) fn scaled<const ORDER: u32>(mut self, scale: f32) -> Self {
        if ORDER > 0 {
            self.du = self.du * scale;
            self.dv = self.dv * scale;
        }
        if ORDER > 1 {
            let square = scale * scale;
            self.duu = self.duu * square;
            self.duv = self.duv * square;
            self.dvv = self.dvv * square;
        }
        self
    }

    /// From the view of corner `c` of a quad, where s runs along the side that leaves the corner, to the quad's own u and v.
    #[inline(always)]
    pub(crate) fn turned<const ORDER: u32>(self, c: usize) -> Self {
        let minus = |p: P4| P4::ZERO - p;
        let (s, t) = (self.du, self.dv);
        let (du, dv) = match c {
            0 => return self,
            1 => (minus(t), s),
            2 => (minus(s), minus(t)),
            _ => (t, minus(s)),
        };
        let mut out = Self { du, dv, ..self };
        if ORDER > 1 && c % 2 == 1 {
            (out.duu, out.dvv) = (self.dvv, self.duu);
            out.duv = minus(self.duv);
        }
        out
    }
}

/// Weights of the four control points at `t`, for the value and the first two derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    value: [f32; 4],
    slope: [f32; 4],
    bend: [f32; 4],
}

impl Weights {
    #[inline(always)]
    pub(super) fn at(t: f32) -> Self {
        let s = 1.0 - t;
        let (t2, s2) = (t * t, s * s);
        const SIXTH: f32 = 1.0 / 6.0;
        Self {
            value: [
                s2 * s * SIXTH,
                (4.0 + t2 * (3.0 * t - 6.0)) * SIXTH,
                (4.0 + s2 * (3.0 * s - 6.0)) * SIXTH,
                t2 * t * SIXTH,
            ],
            slope: [
                s2 * -0.5,
                t * (1.5 * t - 2.0),
                s * (2.0 - 1.5 * s),
                t2 * 0.5,
            ],
            bend: [s, 3.0 * t - 2.0, 3.0 * s - 2.0, t],
        }
    }
}

/// The four rows blended across: a curve in u of values, slopes and bends in v.
#[derive(Clone, Copy, Debug)]
pub(super) struct Curve {
    value: Row,
    slope: Row,
    bend: Row,
}

impl Curve {
    #[inline(always)]
    pub(super) fn across<const ORDER: u32>(rows: [&Row; 4], v: &Weights) -> Self {
        let blend = |w: [f32; 4]| {
            let mut out = [0.0; 16];
            for l in 0..16 {
                out[l] = (rows[0][l] * w[0] + rows[1][l] * w[1])
                    + (rows[2][l] * w[2] + rows[3][l] * w[3]);
            }
            out
        };
        Self {
            value: blend(v.value),
            slope: if ORDER > 0 { blend(v.slope) } else { [0.0; 16] },
            bend: if ORDER > 1 { blend(v.bend) } else { [0.0; 16] },
        }
    }

    #[inline(always)]
    pub(super) fn at<const ORDER: u32>(&self, u: &Weights, origin: P4) -> Jet {
        let along = |row: &Row, w: [f32; 4]| {
            P4(std::array::from_fn(|c| {
                (row[c] * w[0] + row[4 + c] * w[1]) + (row[8 + c] * w[2] + row[12 + c] * w[3])
            }))
        };
        let mut jet = Jet {
            position: origin + along(&self.value, u.value),
            ..Jet::default()
        };
        if ORDER > 0 {
            jet.du = along(&self.value, u.slope);
            jet.dv = along(&self.slope, u.value);
        }
        if ORDER > 1 {
            jet.duu = along(&self.value, u.bend);
            jet.duv = along(&self.slope, u.slope);
            jet.dvv = along(&self.bend, u.value);
        }
        jet
    }
}

/// Five rows of five control points, of which every four by four make a piece.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub(super) struct Sheet(pub(super) [[f32; 20]; 5]);

impl Sheet {
    pub(super) fn new(points: impl Fn(usize, usize) -> P4) -> Self {
        let mut rows = [[0.0; 20]; 5];
        for (r, row) in rows.iter_mut().enumerate() {
            for (c, p) in row.chunks_exact_mut(4).enumerate() {
                p.copy_from_slice(&points(r, c).0);
            }
        }
        Self(rows)
    }

    /// The rows of the piece at (`row`, `col`), each 0 or 1.
    #[inline(always)]
    pub(super) fn rows(&self, row: usize, col: usize) -> [&Row; 4] {
        std::array::from_fn(|r| {
            let points = &self.0[row + r];
            let tail = if col == 0 {
                &points[..16]
            } else {
                &points[4..]
            };
            tail.try_into().unwrap_or(const { &[0.0; 16] })
        })
    }
}
