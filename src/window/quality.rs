//! How good a picture may be while something moves: as good as it can within a budget of time, from what pictures took so far.

use std::time::Duration;

/// A draft: what is left out of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draft {
    /// One pixel is drawn in place of so many in both directions.
    pub shrink: u32,
    /// Most samples per pixel.
    pub samples: u32,
    /// Uniform levels that are left out.
    pub coarser: u32,
    /// Whether adaptive tessellation gives way to a level by the length of edges: looking for what is flat takes longer than drawing it all.
    pub uniform: bool,
}

impl Draft {
    /// Nothing is left out.
    pub const FULL: Self = Self {
        uniform: false,
        ..draft(1, 16, 0)
    };

    /// Size of the picture that stands for one of `size` pixels.
    #[must_use]
    pub fn size(&self, size: [u32; 2]) -> [u32; 2] {
        size.map(|side| side.div_ceil(self.shrink).max(1))
    }
}

const fn draft(shrink: u32, samples: u32, coarser: u32) -> Draft {
    Draft {
        shrink,
        samples,
        coarser,
        uniform: true,
    }
}

/// Drafts from the best to the fastest. Adaptive tessellation goes first, because nobody sees it go, then samples; levels last, because
/// triangles then show.
pub(super) const LADDER: [Draft; 8] = [
    Draft::FULL,
    draft(1, 4, 0),
    draft(1, 1, 0),
    draft(2, 1, 0),
    draft(3, 1, 0),
    draft(4, 1, 1),
    draft(6, 1, 2),
    draft(8, 1, 3),
];

/// Time of each draft relative to the full picture, for those not drawn yet. Where it is too low, the first frame of a drag is late; where it
/// is too high, it is coarser than need be: either is mended with the next.
const GUESS: [f64; LADDER.len()] = [1.0, 0.5, 0.3, 0.18, 0.15, 0.1, 0.06, 0.04];
/// Part of the budget that a better draft has to fit in before it is tried: a picture that changes its grain all the time is worse than a
/// coarse one.
const ROOM: f64 = 0.75;
/// Times that are as good as the shortest: where even that is over the budget, a coarser picture has to save more than a part of it.
const AS_GOOD: f64 = 1.25;
/// What is left of a measured time with each picture drawn otherwise: slow ones are forgotten, and tried again, after some seconds.
const FADE: f64 = 0.997;

/// Chooses the draft of the next picture.
#[derive(Clone, Debug)]
pub(super) struct Quality {
    budget: f64,
    /// Seconds that each draft took; none where it was not drawn.
    took: [Option<f64>; LADDER.len()],
    /// The time of the full picture is a guess.
    guessed: bool,
    now: usize,
}

impl Quality {
    /// Pictures are to take no longer than `budget` while something moves.
    #[must_use]
    pub(super) fn new(budget: Duration) -> Self {
        Self {
            budget: budget.as_secs_f64(),
            took: [None; LADDER.len()],
            guessed: false,
            now: 0,
        }
    }

    /// Another model is drawn from here on, and nobody knows how long it takes: about so long, in full.
    pub(super) fn begin(&mut self, full: Duration) {
        self.took = [None; LADDER.len()];
        self.took[0] = Some(full.as_secs_f64());
        self.guessed = true;
        self.now = 0;
    }

    /// Other things are drawn from here on; what they take is a guess from what the last ones took.
    pub(super) fn forget(&mut self) {
        let full = self.expected(0);
        self.took = [None; LADDER.len()];
        self.took[0] = full;
        self.guessed = true;
    }

    /// Index in [`LADDER`] of the next picture while something moves.
    #[must_use]
    pub(super) fn next(&mut self) -> usize {
        let last = LADDER.len() - 1;
        let shortest = (0..=last).filter_map(|k| self.expected(k));
        let shortest = shortest.fold(f64::INFINITY, f64::min);
        let budget = if shortest > self.budget {
            shortest * AS_GOOD
        } else {
            self.budget
        };
        let fits = |k: usize| {
            // Finer than now needs room.
            let most = if k < self.now && shortest <= self.budget {
                budget * ROOM
            } else {
                budget
            };
            self.expected(k).is_none_or(|t| t <= most)
        };
        self.now = (0..last).find(|&k| fits(k)).unwrap_or(last);
        self.now
    }

    /// A picture was drawn.
    pub(super) fn drawn(&mut self, draft: usize, time: Duration) {
        for (k, t) in self.took.iter_mut().enumerate() {
            if k != draft {
                *t = t.map(|t| t * FADE);
            }
        }
        let time = time.as_secs_f64();
        // One that is slow once may have been disturbed, so half of it counts.
        let slot = &mut self.took[draft];
        if draft == 0 && std::mem::take(&mut self.guessed) {
            *slot = None;
        }
        *slot = Some(slot.map_or(time, |t| 0.5 * (t + time)));
    }

    /// Whether a draft is likely to take longer than the budget.
    #[must_use]
    pub(super) fn is_slow(&self, draft: usize) -> bool {
        self.expected(draft).is_some_and(|t| t > self.budget)
    }

    /// Seconds that a draft will take: what it took, else a guess from the nearest that was drawn.
    fn expected(&self, draft: usize) -> Option<f64> {
        let known = |k: &usize| self.took[*k].is_some();
        let nearest = (0..LADDER.len())
            .filter(known)
            .min_by_key(|k| k.abs_diff(draft))?;
        Some(self.took[nearest]? * GUESS[draft] / GUESS[nearest])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(x: f64) -> Duration {
        Duration::from_secs_f64(x * 1e-3)
    }

    /// Draws until the draft stands still, on a machine where draft `k` takes `times[k]`.
    fn settled(quality: &mut Quality, times: &[f64; LADDER.len()]) -> usize {
        for _ in 0..30 {
            let k = quality.next();
            quality.drawn(k, ms(times[k]));
        }
        quality.next()
    }

    #[test]
    fn fast_machines_draw_everything() {
        let mut q = Quality::new(ms(16.0));
        assert_eq!(q.next(), 0, "nothing is known: try");
        assert_eq!(settled(&mut q, &[9.0; LADDER.len()]), 0);
    }

    #[test]
    fn the_finest_that_fits_is_drawn() {
        let times = [60.0, 40.0, 20.0, 14.0, 9.0, 5.0, 3.0, 2.0];
        let mut q = Quality::new(ms(16.0));
        q.drawn(0, ms(60.0));
        assert!(q.next() >= 2, "a guess is better than the full picture");
        let k = settled(&mut q, &times);
        assert!(times[k] <= 16.0 && times[k - 1] > 16.0, "{k}");
        assert!(q.is_slow(0) && !q.is_slow(k));
    }

    #[test]
    fn where_nothing_fits_the_finest_of_the_fast_is_drawn() {
        let mut q = Quality::new(ms(16.0));
        let times = [900.0, 700.0, 500.0, 300.0, 200.0, 90.0, 80.0, 75.0];
        // Whichever saves something over those before it.
        assert!(times[settled(&mut q, &times)] <= 75.0 * AS_GOOD);
        // Coarser pictures save nothing, so few of them are drawn.
        let mut q = Quality::new(ms(16.0));
        assert!(settled(&mut q, &[200.0; LADDER.len()]) <= 2);
    }

    #[test]
    fn large_models_begin_with_a_draft() {
        let mut q = Quality::new(ms(16.0));
        q.begin(ms(3000.0));
        assert!(q.next() > 4 && q.is_slow(0));
        q.begin(ms(5.0));
        assert!(q.next() == 0 && !q.is_slow(0));
        // What was measured counts, not the guess.
        q.drawn(0, ms(20.0));
        assert!(q.is_slow(0));
    }

    #[test]
    fn one_slow_picture_is_forgotten() {
        let mut q = Quality::new(ms(16.0));
        q.drawn(0, ms(10.0));
        q.drawn(0, ms(60.0));
        assert!(q.next() > 0);
        for _ in 0..1000 {
            let k = q.next();
            q.drawn(k, ms(10.0));
        }
        assert_eq!(q.next(), 0);
    }

    #[test]
    fn drafts_are_never_empty() {
        for d in LADDER {
            assert!(d.size([1, 3]).iter().all(|&side| side >= 1));
        }
        assert_eq!(LADDER[3].size([1280, 721]), [640, 361]);
    }
}
