//! The triangles of a pattern, by halving: a triangle with three sides left to halve becomes four, one with fewer becomes two or three; a
//! quad becomes four or two, or two triangles. A side knows how deep it goes; so do the new ones inside, and both triangles beside
//! one take it from here. Nothing is looked up and nothing kept but the parts still to do.

use super::{Pattern, Place};

/// What is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Triangle,
    Quad,
}

type At = [i32; 2];

/// A part that is still to be cut, with the depths of its sides.
#[derive(Clone, Copy, Debug)]
enum Task {
    Triangle {
        corners: [At; 3],
        depths: [u32; 3],
        /// Halvings that are left to the inside.
        left: u32,
    },
    Quad {
        corners: [At; 4],
        depths: [u32; 4],
        left: u32,
    },
    /// A triangle of which side 1 is whole. The others are cut, from corner 0 on; so far as `done`, both have their triangles.
    Ladder {
        corners: [At; 3],
        depths: [u32; 2],
        done: [u32; 2],
    },
}

/// The triangles of a pattern, one after the other, always in the same order.
#[derive(Clone, Debug)]
pub struct Triangles {
    pattern: Pattern,
    shape: Shape,
    sides: [i32; 4],
    /// Steps of the finest lattice along a side of the whole.
    n: i32,
    tasks: Vec<Task>,
}

fn middle(a: At, b: At) -> At {
    debug_assert!((a[0] + b[0]) % 2 == 0 && (a[1] + b[1]) % 2 == 0);
    [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2]
}

impl Triangles {
    pub(super) fn new(pattern: Pattern, shape: Shape, depths: [u8; 4], depth: u32) -> Self {
        let n = 1_i32 << depth;
        let sides = depths.map(|d| n >> d);
        let count = if shape == Shape::Quad { 4 } else { 3 };
        let least = depths[..count].iter().min().copied().unwrap_or(0);
        let left = match pattern {
            Pattern::Split => least.into(),
            Pattern::Equilateral => depth,
        };
        let [i, j, k, l] = depths.map(u32::from);
        let first = match shape {
            Shape::Triangle => Task::Triangle {
                corners: [[0, 0], [n, 0], [0, n]],
                depths: [i, j, k],
                left,
            },
            Shape::Quad => Task::Quad {
                corners: [[0, 0], [n, 0], [n, n], [0, n]],
                depths: [i, j, k, l],
                left,
            },
        };
        Self {
            pattern,
            shape,
            sides,
            n,
            tasks: vec![first],
        }
    }

    /// Square of a length, as in an equilateral triangle or in a square.
    fn square(&self, a: At, b: At) -> i64 {
        let [x, y] = [0, 1].map(|k| i64::from(b[k] - a[k]));
        match self.shape {
            Shape::Triangle => x * x + x * y + y * y,
            Shape::Quad => x * x + y * y,
        }
    }

    /// Length that edges should have at a point, twice; the point is given twice its place. Beside a side they are as long as its pieces,
    /// and become shorter with twice the distance.
    fn wanted(&self, [x, y]: At) -> i64 {
        let n = 2 * self.n;
        let (distances, count) = match self.shape {
            Shape::Triangle => ([y, n - x - y, x, 0], 3),
            Shape::Quad => ([y, n - x, n - y, x], 4),
        };
        (0..count).fold(2, |most, k| {
            most.max(2 * (i64::from(self.sides[k]) - i64::from(distances[k])))
        })
    }

    /// Depth of a new edge inside, of at most `left` halvings.
    fn depth(&self, a: At, b: At, left: u32) -> u32 {
        if self.pattern == Pattern::Split {
            return left;
        }
        let places = [
            [2 * a[0], 2 * a[1]],
            [2 * b[0], 2 * b[1]],
            [a[0] + b[0], a[1] + b[1]],
        ];
        let wanted = places
            .map(|p| self.wanted(p))
            .into_iter()
            .min()
            .unwrap_or(2);
        let square = self.square(a, b);
        // An edge may be a fifth longer than wanted: (length / 2^depth)² <= (1.2 wanted / 2)².
        (0..left)
            .find(|&d| square * 25 <= (wanted * wanted * 9) << (2 * d))
            .unwrap_or(left)
    }

    fn push(&mut self, corners: [At; 3], depths: [u32; 3], left: u32) {
        self.tasks.push(Task::Triangle {
            corners,
            depths,
            left,
        });
    }

    fn push_quad(&mut self, corners: [At; 4], depths: [u32; 4], left: u32) {
        self.tasks.push(Task::Quad {
            corners,
            depths,
            left,
        });
    }

    /// Cuts a triangle; gives it back if nothing of it is left to cut.
    fn triangle(&mut self, t: [At; 3], d: [u32; 3], left: u32) -> Option<[At; 3]> {
        let whole = d.iter().filter(|&&d| d == 0).count();
        if whole == 3 {
            return Some(t);
        }
        if self.pattern == Pattern::Split && left == 0 {
            self.ladder(t, d);
            return None;
        }
        let left = left.saturating_sub(1);
        // Turned so that the odd side is the first.
        let turned = |k: usize| {
            let at = [k, (k + 1) % 3, (k + 2) % 3];
            (at.map(|k| t[k]), at.map(|k| d[k]))
        };
        match whole {
            0 => {
                let m = [0, 1, 2].map(|k| middle(t[k], t[(k + 1) % 3]));
                // Across each corner.
                let x = [0, 1, 2].map(|k| self.depth(m[(k + 2) % 3], m[k], left));
                self.push(m, [x[1], x[2], x[0]], left);
                for k in [2, 1, 0] {
                    let before = (k + 2) % 3;
                    self.push(
                        [t[k], m[k], m[before]],
                        [d[k] - 1, x[k], d[before] - 1],
                        left,
                    );
                }
            }
            1 => {
                let (t, d) = turned(d.iter().position(|&d| d == 0).unwrap_or(0));
                let [right, across] = [middle(t[1], t[2]), middle(t[2], t[0])];
                let x = self.depth(right, across, left);
                let lengths = [self.square(t[0], right), self.square(t[1], across)];
                if lengths[0] < lengths[1] || (lengths[0] == lengths[1] && d[1] >= d[2]) {
                    let y = self.depth(t[0], right, left);
                    self.push([t[0], right, across], [y, x, d[2] - 1], left);
                    self.push([t[0], t[1], right], [0, d[1] - 1, y], left);
                } else {
                    let y = self.depth(t[1], across, left);
                    self.push([t[1], right, across], [d[1] - 1, x, y], left);
                    self.push([t[0], t[1], across], [0, y, d[2] - 1], left);
                }
                self.push([across, right, t[2]], [x, d[1] - 1, d[2] - 1], left);
            }
            _ => {
                let (t, d) = turned(d.iter().position(|&d| d > 0).unwrap_or(0));
                let m = middle(t[0], t[1]);
                let x = self.depth(m, t[2], left);
                self.push([m, t[1], t[2]], [d[0] - 1, d[1], x], left);
                self.push([t[0], m, t[2]], [d[0] - 1, x, d[2]], left);
            }
        }
        None
    }

    /// Cuts a triangle, one side of which is whole, without points inside: from the corner opposite of that side on, rung by rung.
    fn ladder(&mut self, t: [At; 3], d: [u32; 3]) {
        let k = d.iter().position(|&d| d == 0).unwrap_or(0);
        let at = [(k + 2) % 3, k, (k + 1) % 3];
        self.tasks.push(Task::Ladder {
            corners: at.map(|k| t[k]),
            depths: [d[at[0]], d[(k + 1) % 3]],
            done: [0, 0],
        });
    }

    /// Next triangle of a ladder whose corner 0 is where both cut sides begin: one runs to corner 1, the other to corner 2.
    fn rung(&mut self, corners: [At; 3], depths: [u32; 2], done: [u32; 2]) -> [At; 3] {
        let place = |side: usize, k: u32| {
            let (a, b) = (corners[0], corners[1 + side]);
            [0, 1].map(|c| a[c] + ((b[c] - a[c]) >> depths[side]) * k as i32)
        };
        let [i, j] = done;
        let (triangle, done) = if done == [0, 0] {
            ([corners[0], place(0, 1), place(1, 1)], [1, 1])
        } else {
            // The side that is behind, measured by its whole.
            let ahead = [u64::from(i + 1) << depths[1], u64::from(j + 1) << depths[0]];
            let first = i < 1 << depths[0] && (ahead[0] <= ahead[1] || j == 1 << depths[1]);
            match first {
                true => ([place(0, i), place(0, i + 1), place(1, j)], [i + 1, j]),
                false => ([place(0, i), place(1, j + 1), place(1, j)], [i, j + 1]),
            }
        };
        if done != [1 << depths[0], 1 << depths[1]] {
            self.tasks.push(Task::Ladder {
                corners,
                depths,
                done,
            });
        }
        triangle
    }

    /// Cuts a quad, whose corners stay in their order.
    fn quad(&mut self, t: [At; 4], d: [u32; 4], left: u32) {
        let cut = d.map(|d| d > 0);
        let halves = match self.pattern {
            Pattern::Split if left == 0 => [false; 2],
            // Sides 0 and 2, sides 1 and 3.
            _ => [cut[0] && cut[2], cut[1] && cut[3]],
        };
        let inner = left.saturating_sub(1);
        let m = [0, 1, 2, 3].map(|k| match cut[k] {
            true => middle(t[k], t[(k + 1) % 4]),
            false => t[k],
        });
        match halves {
            [true, true] => {
                let centre = middle(t[0], t[2]);
                let x = m.map(|m| self.depth(m, centre, inner));
                for k in [3, 2, 1, 0] {
                    let before = (k + 3) % 4;
                    // The child at corner k, beginning with its corner 0.
                    let corners = [t[k], m[k], centre, m[before]];
                    let depths = [d[k] - 1, x[k], x[before], d[before] - 1];
                    let at = [0, 1, 2, 3].map(|c| (c + 4 - k) % 4);
                    self.push_quad(at.map(|c| corners[c]), at.map(|c| depths[c]), inner);
                }
            }
            [true, false] => {
                let x = self.depth(m[0], m[2], inner);
                self.push_quad(
                    [m[0], t[1], t[2], m[2]],
                    [d[0] - 1, d[1], d[2] - 1, x],
                    inner,
                );
                self.push_quad(
                    [t[0], m[0], m[2], t[3]],
                    [d[0] - 1, x, d[2] - 1, d[3]],
                    inner,
                );
            }
            [false, true] => {
                let x = self.depth(m[3], m[1], inner);
                self.push_quad(
                    [m[3], m[1], t[2], t[3]],
                    [x, d[1] - 1, d[2], d[3] - 1],
                    inner,
                );
                self.push_quad(
                    [t[0], t[1], m[1], m[3]],
                    [d[0], d[1] - 1, x, d[3] - 1],
                    inner,
                );
            }
            [false, false] => {
                let x = match self.pattern {
                    Pattern::Split => 0,
                    Pattern::Equilateral if d == [0; 4] => 0,
                    Pattern::Equilateral => self.depth(t[0], t[2], inner),
                };
                self.push([t[0], t[2], t[3]], [x, d[2], d[3]], inner);
                self.push([t[0], t[1], t[2]], [d[0], d[1], x], inner);
            }
        }
    }
}

impl Iterator for Triangles {
    type Item = [Place; 3];

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let found = match self.tasks.pop()? {
                Task::Triangle {
                    corners,
                    depths,
                    left,
                } => self.triangle(corners, depths, left),
                Task::Quad {
                    corners,
                    depths,
                    left,
                } => {
                    self.quad(corners, depths, left);
                    None
                }
                Task::Ladder {
                    corners,
                    depths,
                    done,
                } => Some(self.rung(corners, depths, done)),
            };
            if let Some(t) = found {
                return Some(t.map(|at| at.map(|k| k as u16)));
            }
        }
    }
}
