//! The memory budget of parallel runs: a run starts when its estimated memory is free.

use crate::run::resources::memory::available_bytes;
use std::sync::{Condvar, Mutex, PoisonError};

/// A number of bytes shared by the runs.
#[derive(Debug)]
pub struct MemoryBudget {
    total: u64,
    free: Mutex<u64>,
    released: Condvar,
}

/// A reserved part of the budget; dropping it releases the bytes.
#[derive(Debug)]
pub struct Reservation<'a> {
    budget: &'a MemoryBudget,
    bytes: u64,
}

impl MemoryBudget {
    /// A budget of `total` bytes.
    #[must_use]
    pub fn new(total: u64) -> Self {
        Self { total, free: Mutex::new(total), released: Condvar::new() }
    }

    /// The available memory (`MemAvailable` of Linux); unlimited on other operating systems.
    #[must_use]
    pub fn of_this_machine() -> Self {
        Self::new(available_bytes())
    }

    /// Blocks until the bytes are free. A run that needs more than the total reserves all of it and executes alone.
    pub fn take(&self, bytes: u64) -> Reservation<'_> {
        let bytes = bytes.min(self.total);
        let free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let mut free = self
            .released
            .wait_while(free, |free| *free < bytes)
            .unwrap_or_else(PoisonError::into_inner);
        *free -= bytes;
        Reservation { budget: self, bytes }
    }
}

impl Drop for Reservation<'_> {
    fn drop(&mut self) {
        *self.budget.free.lock().unwrap_or_else(PoisonError::into_inner) += self.bytes;
        self.budget.released.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::MemoryBudget;
    use std::sync::atomic::{AtomicU64, Ordering};
    use std::thread;

    /// Includes a reservation larger than the whole budget.
    #[test]
    fn shares_never_exceed_the_budget() {
        let budget = MemoryBudget::new(10);
        let (out, most) = (AtomicU64::new(0), AtomicU64::new(0));
        thread::scope(|scope| {
            for bytes in [3, 4, 5, 6, 7, 99] {
                let (budget, out, most) = (&budget, &out, &most);
                scope.spawn(move || {
                    for _ in 0..200 {
                        let reservation = budget.take(bytes);
                        most.fetch_max(
                            out.fetch_add(reservation.bytes, Ordering::SeqCst) + reservation.bytes,
                            Ordering::SeqCst,
                        );
                        thread::yield_now();
                        out.fetch_sub(reservation.bytes, Ordering::SeqCst);
                    }
                });
            }
        });
        assert!(most.into_inner() <= 10);
    }
}
