//! Vectors that are no longer used, kept for later ones: the system would have to clear fresh memory page by page. Copying states into
//! fresh memory, and returning it, took a fifth of the processor time of an analysis.

use std::mem;
use std::ops::Deref;
use std::sync::{Arc, Mutex, PoisonError};

/// Vectors kept at most. More than are in use at the same time are never needed.
const KEPT: usize = 8;

/// Unused vectors, shared by those who use them. Their old values are gone.
#[derive(Debug)]
pub(crate) struct SpareMemory<T>(Arc<Mutex<Vec<Vec<T>>>>);

impl<T> Clone for SpareMemory<T> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<T> SpareMemory<T> {
    pub(crate) fn new() -> Self {
        Self(Arc::new(Mutex::new(Vec::new())))
    }

    /// An empty vector, whose memory returns here.
    pub(crate) fn take(&self) -> Lent<T> {
        let vector = self.0.lock().unwrap_or_else(PoisonError::into_inner).pop();
        Lent { vector: vector.unwrap_or_default(), home: self.clone() }
    }
}

/// A vector whose memory returns to where it was taken from.
#[derive(Clone, Debug)]
pub(crate) struct Lent<T> {
    pub(crate) vector: Vec<T>,
    home: SpareMemory<T>,
}

impl<T> Deref for Lent<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.vector
    }
}

impl<T> AsRef<[T]> for Lent<T> {
    fn as_ref(&self) -> &[T] {
        &self.vector
    }
}

impl<T> Drop for Lent<T> {
    fn drop(&mut self) {
        let mut vector = mem::take(&mut self.vector);
        vector.clear();
        let mut kept = self.home.0.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.len() < KEPT {
            kept.push(vector);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_used_again_without_old_values() {
        let spare = SpareMemory::new();
        let (mut one, other) = (spare.take(), spare.take());
        one.vector.extend([1, 2, 3]);
        let address = one.vector.as_ptr();
        drop((other, one));
        let again = spare.take();
        assert!(again.is_empty());
        assert_eq!(again.vector.as_ptr(), address);
    }
}
