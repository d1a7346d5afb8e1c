//! Budgets that a caller sets: memory, faces, time. Checked before allocating and between pieces of work; a limit that is reached
//! is an error, never a partial result.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Budgets of one job. The default has none.
#[derive(Debug, Default)]
pub struct Limits {
    /// Most bytes that the job may be predicted to take.
    pub max_memory: Option<u64>,
    /// Most micro-faces.
    pub max_faces: Option<u64>,
    /// When to give up, and how long that was at the start.
    pub deadline: Option<(Instant, Duration)>,
    /// Set by another thread, or a signal handler, to stop the job.
    pub cancelled: Arc<AtomicBool>,
    /// How far the job is, for another thread to look at.
    pub progress: Arc<Progress>,
}

/// Pieces of work done, and how many there are in all.
#[derive(Debug, Default)]
pub struct Progress {
    done: AtomicU64,
    total: AtomicU64,
}

impl Progress {
    /// Begins a stretch of `total` pieces.
    pub fn begin(&self, total: u64) {
        self.done.store(0, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
    }
    /// One piece is done.
    pub fn step(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }
    /// Pieces done and pieces in all; both 0 before [`Progress::begin`].
    #[must_use]
    pub fn get(&self) -> (u64, u64) {
        let done = self.done.load(Ordering::Relaxed);
        (done, self.total.load(Ordering::Relaxed).max(done))
    }
}

/// A limit was reached.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LimitError {
    /// The job would take too much memory.
    #[error("{what} would take about {wanted} bytes; the limit is {allowed}")]
    Memory {
        /// What asked for it.
        what: &'static str,
        /// Predicted bytes.
        wanted: u64,
        /// The limit.
        allowed: u64,
    },
    /// Too many faces.
    #[error("{wanted} micro-faces; the limit is {allowed}")]
    Faces {
        /// Number of faces.
        wanted: u64,
        /// The limit.
        allowed: u64,
    },
    /// Time is up.
    #[error("not done after {seconds} seconds")]
    Time {
        /// The time allowed.
        seconds: f64,
    },
    /// Another thread asked to stop.
    #[error("cancelled")]
    Cancelled,
}

/// Memory of one job, counted as it is taken piece by piece.
#[derive(Debug)]
pub(crate) struct Budget<'a> {
    limits: &'a Limits,
    taken: u128,
}

impl<'a> Budget<'a> {
    /// Nothing is taken yet.
    pub(crate) fn new(limits: &'a Limits) -> Self {
        Self { limits, taken: 0 }
    }

    /// What it is counted against.
    #[cfg(feature = "gpu")]
    pub(crate) fn limits(&self) -> &'a Limits {
        self.limits
    }

    /// Takes `kept` bytes for good, if with `passing` more, which are given back soon, all that was taken is within the limit.
    ///
    /// # Errors
    /// [`LimitError`]; also when time is up.
    pub(crate) fn take(
        &mut self,
        what: &'static str,
        kept: u128,
        passing: u128,
    ) -> Result<(), LimitError> {
        self.limits.check()?;
        let taken = self.taken.saturating_add(kept);
        self.limits.memory(what, taken.saturating_add(passing))?;
        self.taken = taken;
        Ok(())
    }
}

impl Limits {
    /// Gives the job `time` from now on.
    #[must_use]
    pub fn with_timeout(mut self, time: Duration) -> Self {
        self.deadline = Instant::now().checked_add(time).map(|end| (end, time));
        self
    }

    /// Fails when time is up or the job was cancelled.
    ///
    /// # Errors
    /// [`LimitError::Time`], [`LimitError::Cancelled`].
    pub fn check(&self) -> Result<(), LimitError> {
        if self.cancelled.load(Ordering::Relaxed) {
            return Err(LimitError::Cancelled);
        }
        match self.deadline {
            Some((end, time)) if Instant::now() >= end => Err(LimitError::Time {
                seconds: time.as_secs_f64(),
            }),
            _ => Ok(()),
        }
    }

    /// Fails when `wanted` bytes are more than allowed.
    ///
    /// # Errors
    /// [`LimitError::Memory`].
    pub fn memory(&self, what: &'static str, wanted: u128) -> Result<(), LimitError> {
        match self.max_memory {
            Some(allowed) if wanted > u128::from(allowed) => Err(LimitError::Memory {
                what,
                wanted: u64::try_from(wanted).unwrap_or(u64::MAX),
                allowed,
            }),
            _ => Ok(()),
        }
    }

    /// Fails when `wanted` micro-faces are more than allowed.
    ///
    /// # Errors
    /// [`LimitError::Faces`].
    pub fn faces(&self, wanted: u128) -> Result<(), LimitError> {
        match self.max_faces {
            Some(allowed) if wanted > u128::from(allowed) => Err(LimitError::Faces {
                wanted: u64::try_from(wanted).unwrap_or(u64::MAX),
                allowed,
            }),
            _ => Ok(()),
        }
    }
}
