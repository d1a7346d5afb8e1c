//! `--backend gpu` and `info --gpu`. Without feature `gpu` they and the measurements of it say so, with the exit code of what is not available.

#[cfg(feature = "gpu")]
mod with;
#[cfg(not(feature = "gpu"))]
mod without;

use super::stats::Json;
use earmark::frame::Finished;

#[cfg(all(feature = "gpu", feature = "window"))]
pub(super) use with::{Kept, draw_kept, ready};
#[cfg(feature = "gpu")]
pub(super) use with::{check, draw, list, ms, open};
#[cfg(all(not(feature = "gpu"), feature = "window"))]
pub(super) use without::{Kept, draw_kept, ready};
#[cfg(not(feature = "gpu"))]
pub(super) use without::{check, draw, frame, list, suite};

/// What statistics say of a picture beside what every picture has.
pub(super) type Said = Vec<(&'static str, Json)>;

/// A picture, and what is said of it.
pub(super) type Drawn = (Finished, Said);
