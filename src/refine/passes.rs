//! The passes for both types of numbers, compiled here once. Without this, every crate that refines would compile them anew: generic code
//! is made where it is used.

use super::limit::{self, Limit};
use super::{Level, Options, RefineError, Timings};
use crate::mesh::Cage;
use crate::scheme::{FaceVaryingRule, Scheme};
use crate::topology::Topology;

/// What [`Level`] and [`limit()`](limit::limit) forward to.
pub trait Passes: Sized {
    /// [`Level::of_cage`].
    #[doc(hidden)]
    fn of_cage(
        cage: &Cage,
        topology: Topology,
        scheme: Scheme,
        rule: FaceVaryingRule,
    ) -> Result<Level<Self>, RefineError>;
    /// [`Level::with_uvs`].
    #[doc(hidden)]
    fn with_uvs(
        level: Level<Self>,
        values: &[[Self; 2]],
        corners: &[u32],
        scheme: Scheme,
        rule: FaceVaryingRule,
    ) -> Result<Level<Self>, RefineError>;
    /// [`Level::next`].
    #[doc(hidden)]
    fn next(
        level: &Level<Self>,
        options: &Options,
        timings: &mut Timings,
    ) -> Result<Level<Self>, RefineError>;
    /// [`limit()`](limit::limit).
    #[doc(hidden)]
    fn limit(level: &Level<Self>, options: &Options) -> Limit<Self>;
}

macro_rules! passes {
    ($($real:ty),*) => {$(
        impl Passes for $real {
            fn of_cage(
                cage: &Cage,
                topology: Topology,
                scheme: Scheme,
                rule: FaceVaryingRule,
            ) -> Result<Level<Self>, RefineError> {
                Level::make_of_cage(cage, topology, scheme, rule)
            }
            fn with_uvs(
                level: Level<Self>,
                values: &[[Self; 2]],
                corners: &[u32],
                scheme: Scheme,
                rule: FaceVaryingRule,
            ) -> Result<Level<Self>, RefineError> {
                level.make_with_uvs(values, corners, scheme, rule)
            }
            fn next(
                level: &Level<Self>,
                options: &Options,
                timings: &mut Timings,
            ) -> Result<Level<Self>, RefineError> {
                level.make_next(options, timings)
            }
            fn limit(level: &Level<Self>, options: &Options) -> Limit<Self> {
                limit::make(level, options)
            }
        }
    )*};
}

passes!(f32, f64);
