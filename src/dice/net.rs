//! Nets of control points around a quad: gathered, filled up beyond boundaries, refined, and turned to a corner's view.

use super::point::{P4, Point};
use super::window::{Around, edge_point, face_point, vertex_point};
use crate::topology::{FanRule, NONE, Topology};

/// A square of control points, row by row.
pub(super) type Net<const N: usize, P = P4> = [[P; N]; N];

/// The 16 control points of a regular quad, in the first rows and columns of `net`; phantoms `2a − b` stand where a boundary leaves a row or
/// column out.
pub(super) fn gather_net<const N: usize>(
    t: &Topology,
    points: &[[f32; 3]],
    q: u32,
    net: &mut Net<N>,
) {
    let at = |h: u32| P4::new(points[t.vertex(h) as usize]);
    // Places in walking order around the square: corner, the two points beyond the side that leaves it, the point beyond the corner.
    const INNER: [(usize, usize); 4] = [(1, 1), (1, 2), (2, 2), (2, 1)];
    const BEYOND: [[(usize, usize); 2]; 4] = [
        [(0, 1), (0, 2)],
        [(1, 3), (2, 3)],
        [(3, 2), (3, 1)],
        [(2, 0), (1, 0)],
    ];
    const DIAGONAL: [(usize, usize); 4] = [(0, 0), (0, 3), (3, 3), (3, 0)];
    let mut open = [false; 4];
    // The mesh is one of quads: half-edges around a face by arithmetic.
    let after = |h: u32| (h & !3) | ((h + 1) & 3);
    let before = |h: u32| (h & !3) | ((h + 3) & 3);
    for c in 0..4 {
        let h = 4 * q + c as u32;
        net[INNER[c].0][INNER[c].1] = at(h);
        let twin = t.twin(h);
        if twin == NONE {
            open[c] = true;
            continue;
        }
        let [first, second] = BEYOND[c];
        net[first.0][first.1] = at(twin ^ 2);
        net[second.0][second.1] = at(before(twin));
        let diagonal = t.twin(after(twin));
        net[DIAGONAL[c].0][DIAGONAL[c].1] = match diagonal {
            NONE => P4::ZERO,
            _ => at(after(diagonal) ^ 2),
        };
    }
    fill_phantoms(net, 3, open);
}

/// Fills the rows and columns up to `last` beyond the sides that are open; columns first, so that at a corner of two open sides both agree.
#[inline(always)]
pub(super) fn fill_phantoms<const N: usize, P: Point>(
    net: &mut Net<N, P>,
    last: usize,
    open: [bool; 4],
) {
    for row in &mut net[..=last] {
        if open[3] {
            row[0] = P::beyond(row[1], row[2]);
        }
        if open[1] {
            row[last] = P::beyond(row[last - 1], row[last - 2]);
        }
    }
    for c in 0..=last {
        if open[0] {
            net[0][c] = P::beyond(net[1][c], net[2][c]);
        }
        if open[2] {
            net[last][c] = P::beyond(net[last - 1][c], net[last - 2][c]);
        }
    }
}

/// The net seen from corner `c`: its outgoing side becomes the bottom row.
pub(super) fn turn<const N: usize, P: Point>(net: &Net<N, P>, c: usize) -> Net<N, P> {
    let m = N - 1;
    let from = |f: &dyn Fn(usize, usize) -> P| -> Net<N, P> {
        std::array::from_fn(|t| std::array::from_fn(|s| f(s, t)))
    };
    match c {
        0 => *net,
        1 => from(&|s, t| net[s][m - t]),
        2 => from(&|s, t| net[m - t][m - s]),
        _ => from(&|s, t| net[m - s][t]),
    }
}

/// Inverse of [`turn`], into its place.
#[inline(always)]
pub(super) fn turn_back(net: &Net<5>, c: usize, out: &mut Net<5>) {
    #[inline(always)]
    fn put(net: &Net<5>, mut at: impl FnMut(usize, usize, P4)) {
        for (r, row) in net.iter().enumerate() {
            for (k, p) in row.iter().enumerate() {
                at(r, k, *p);
            }
        }
    }
    match c {
        0 => put(net, |r, k, p| out[r][k] = p),
        1 => put(net, |r, k, p| out[k][4 - r] = p),
        2 => put(net, |r, k, p| out[4 - r][4 - k] = p),
        _ => put(net, |r, k, p| out[4 - k][r] = p),
    }
}

/// Grid origin of a square that lies at `place` seen from corner `c`.
pub(super) fn corner_origin(c: usize, [s, t]: [u32; 2], size: u32, n: u32) -> [u32; 2] {
    match c {
        0 => [s, t],
        1 => [n - t - size, s],
        2 => [n - s - size, n - t - size],
        _ => [t, n - s - size],
    }
}

/// Which sides of quad `q` have no face beyond.
#[inline(always)]
pub(super) fn open_sides(t: &Topology, q: u32) -> [bool; 4] {
    [0, 1, 2, 3].map(|c| t.twin(4 * q + c) == NONE)
}

/// The 5×5 net after one step around a quad with its net in the first rows and columns of `n`. Of what lies beyond irregular corners only the points that it shares with regular
/// ones are right, and points beyond open sides are not set.
pub(super) fn once_refined(n: &Net<5>, open: [bool; 4], rules: [FanRule; 4], out: &mut Net<5>) {
    for r in 0..3 {
        for k in 0..3 {
            out[2 * r][2 * k] = face_point(n[r][k], n[r][k + 1], n[r + 1][k + 1], n[r + 1][k]);
        }
    }
    for i in 1..3 {
        for k in 0..3 {
            let (at, beyond) = (2 * i - 1, if i == 1 { [0, 3] } else { [2, 1] });
            let (a, b) = (n[i][k], n[i][k + 1]);
            out[at][2 * k] = match open[beyond[0]] {
                true => (a + b) * 0.5,
                false => edge_point(a, b, out[at - 1][2 * k], out[at + 1][2 * k]),
            };
            let (a, b) = (n[k][i], n[k + 1][i]);
            out[2 * k][at] = match open[beyond[1]] {
                true => (a + b) * 0.5,
                false => edge_point(a, b, out[2 * k][at - 1], out[2 * k][at + 1]),
            };
        }
    }
    for (c, (r, k)) in [(1, 1), (1, 2), (2, 2), (2, 1)].into_iter().enumerate() {
        let v = n[r][k];
        out[2 * r - 1][2 * k - 1] = match rules[c] {
            FanRule::Corner => v,
            FanRule::Crease => {
                let along = if open[if r == 1 { 0 } else { 2 }] {
                    n[r][k - 1] + n[r][k + 1]
                } else {
                    n[r - 1][k] + n[r + 1][k]
                };
                v * 0.75 + along * 0.125
            }
            FanRule::Smooth => vertex_point(std::array::from_fn(|i| {
                std::array::from_fn(|j| n[r + i - 1][k + j - 1])
            })),
        };
    }
}

/// Puts what is around corner `c` at depth 1 in its place of the 5×5 net.
#[inline(always)]
pub(super) fn put_corner<P: Point>(
    net: &mut Net<5, P>,
    c: usize,
    w: &impl Around<P>,
    regular: bool,
) {
    // Seen from corner c, written back to the face's own places.
    let mut put = |row: usize, col: usize, p: P| {
        let (r, k) = match c {
            0 => (row, col),
            1 => (col, 4 - row),
            2 => (4 - row, 4 - col),
            _ => (4 - col, row),
        };
        net[r][k] = p;
    };
    if c == 0 {
        put(2, 2, w.f(0));
    }
    put(1, 1, w.v());
    put(1, 2, w.e(0));
    if w.has(-1) {
        put(0, 1, w.e(-1));
        put(0, 2, w.f(-1));
    }
    if w.has(1) {
        put(1, 0, w.e(2));
    }
    if regular && w.has(-1) && w.has(1) && w.has(2) {
        put(0, 0, w.f(2));
    }
}

/// One step of the net around an irregular corner at `node[1][1]`; `w` is the corner's window after the step.
///
/// Inlined with all of its parts, so that it is compiled with the vector instructions of whoever calls it.
#[inline(always)]
pub(super) fn refine_node<P: Point>(node: &Net<4, P>, w: &impl Around<P>) -> Net<5, P> {
    let n = node;
    let mut out = [[P::ZERO; 5]; 5];
    out[1][1] = w.v();
    out[1][2] = w.e(0);
    out[2][2] = w.f(0);
    out[2][1] = w.e(1);
    let (left, below) = (w.has(1), w.has(-1));
    if left {
        out[2][0] = w.f(1);
        out[1][0] = w.e(2);
    }
    if below {
        out[0][1] = w.e(-1);
        out[0][2] = w.f(-1);
    }
    out[1][3] = vertex_at(n, 1, 2);
    out[3][3] = vertex_at(n, 2, 2);
    out[3][1] = vertex_at(n, 2, 1);
    out[2][3] = along(n, 1, 2);
    out[3][2] = across(n, 2, 1);
    out[1][4] = across(n, 1, 2);
    out[3][4] = across(n, 2, 2);
    out[4][1] = along(n, 2, 1);
    out[4][3] = along(n, 2, 2);
    out[2][4] = face_at(n, 1, 2);
    out[4][2] = face_at(n, 2, 1);
    out[4][4] = face_at(n, 2, 2);
    out[0][3] = along(n, 0, 2);
    out[0][4] = face_at(n, 0, 2);
    out[3][0] = across(n, 2, 0);
    out[4][0] = face_at(n, 2, 0);
    fill_phantoms(&mut out, 4, [!below, false, false, !left]);
    out
}

/// The face point between rows `r` and `r + 1` and columns `c` and `c + 1`.
#[inline(always)]
pub(super) fn face_at<P: Point>(n: &Net<4, P>, r: usize, c: usize) -> P {
    face_point(n[r][c], n[r][c + 1], n[r + 1][c + 1], n[r + 1][c])
}

/// The edge point along row `r` between columns `c` and `c + 1`.
#[inline(always)]
fn across<P: Point>(n: &Net<4, P>, r: usize, c: usize) -> P {
    edge_point(n[r][c], n[r][c + 1], face_at(n, r - 1, c), face_at(n, r, c))
}

/// The edge point along column `c` between rows `r` and `r + 1`.
#[inline(always)]
fn along<P: Point>(n: &Net<4, P>, r: usize, c: usize) -> P {
    edge_point(n[r][c], n[r + 1][c], face_at(n, r, c - 1), face_at(n, r, c))
}

#[inline(always)]
fn vertex_at<P: Point>(n: &Net<4, P>, r: usize, c: usize) -> P {
    let (low, middle, high) = (&n[r - 1], &n[r], &n[r + 1]);
    vertex_point([
        [low[c - 1], low[c], low[c + 1]],
        [middle[c - 1], middle[c], middle[c + 1]],
        [high[c - 1], high[c], high[c + 1]],
    ])
}
