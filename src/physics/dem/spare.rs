//! Working memory that is used again: new memory would have to be cleared and is not in the cache.

use std::sync::{Arc, Mutex, PoisonError};

/// Memory that is lent for one block at a time. There are as many pieces as threads have worked at once, so that a thread writes
/// to the memory that it has in its cache.
#[derive(Debug)]
pub(super) struct Spare<T>(Arc<Mutex<Vec<T>>>);

impl<T> Clone for Spare<T> {
    /// A copy shares the memory.
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<T> Default for Spare<T> {
    fn default() -> Self {
        Self(Arc::default())
    }
}

impl<T: Default> Spare<T> {
    /// Lends a piece, as the last use has left it.
    pub(super) fn lend<R>(&self, to: impl FnOnce(&mut T) -> R) -> R {
        let idle = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut piece = idle().pop().unwrap_or_default();
        let result = to(&mut piece);
        idle().push(piece);
        result
    }
}
