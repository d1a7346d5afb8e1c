//! Tables of masks by valence, made when first needed and shared by threads.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Valences that have a place of their own; larger ones are looked up under a lock.
const COMMON: usize = 65;

/// One mask per valence.
#[derive(Debug)]
pub struct ByValence<M> {
    make: fn(u32) -> M,
    common: [OnceLock<M>; COMMON],
    others: Mutex<BTreeMap<u32, Arc<M>>>,
}

impl<M> ByValence<M> {
    /// A table that is filled by `make`.
    #[must_use]
    pub fn new(make: fn(u32) -> M) -> Self {
        Self {
            make,
            common: [const { OnceLock::new() }; COMMON],
            others: Mutex::default(),
        }
    }

    /// Hands the mask of valence `n` to `using`.
    pub fn with<R>(&self, n: u32, using: impl FnOnce(&M) -> R) -> R {
        if let Some(cell) = self.common.get(n as usize) {
            return using(cell.get_or_init(|| (self.make)(n)));
        }
        let mask = {
            // Masks are whole or not there, so a panic elsewhere leaves nothing broken behind.
            let mut others = self.others.lock().unwrap_or_else(PoisonError::into_inner);
            let entry = others.entry(n);
            Arc::clone(entry.or_insert_with(|| Arc::new((self.make)(n))))
        };
        using(&mask)
    }
}
