//! What parallel runs share: a run starts when its estimated memory and a place among the parallel runs are free.

use crate::run::resources::memory::available_bytes;
use std::sync::{Condvar, Mutex, PoisonError};

/// An amount, such as bytes, shared by the runs.
#[derive(Debug)]
pub struct Budget {
    total: u64,
    free: Mutex<u64>,
    released: Condvar,
}

/// A reserved part of the budget; dropping it releases the amount.
#[derive(Debug)]
pub struct Reservation<'a> {
    budget: &'a Budget,
    amount: u64,
}

impl Budget {
    /// A budget of this amount.
    #[must_use]
    pub fn new(total: u64) -> Self {
        Self { total, free: Mutex::new(total), released: Condvar::new() }
    }

    /// The bytes of the available memory (`MemAvailable` of Linux); unlimited on other operating systems.
    #[must_use]
    pub fn of_the_memory() -> Self {
        Self::new(available_bytes())
    }

    /// Blocks until the amount is free. A run that needs more than the total reserves all of it and executes alone.
    pub fn take(&self, amount: u64) -> Reservation<'_> {
        let amount = amount.min(self.total);
        let free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let mut free = self
            .released
            .wait_while(free, |free| *free < amount)
            .unwrap_or_else(PoisonError::into_inner);
        *free -= amount;
        Reservation { budget: self, amount }
    }
}

impl Drop for Reservation<'_> {
    fn drop(&mut self) {
        *self.budget.free.lock().unwrap_or_else(PoisonError::into_inner) += self.amount;
        self.budget.released.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::Budget;
    use std::sync::atomic::{AtomicU64, Ordering};
    use std::thread;

    /// Includes a reservation larger than the whole budget.
    #[test]
    fn shares_never_exceed_the_budget() {
        let budget = Budget::new(10);
        let (out, most) = (AtomicU64::new(0), AtomicU64::new(0));
        thread::scope(|scope| {
            for amount in [3, 4, 5, 6, 7, 99] {
                let (budget, out, most) = (&budget, &out, &most);
                scope.spawn(move || {
                    for _ in 0..200 {
                        let reservation = budget.take(amount);
                        most.fetch_max(
                            out.fetch_add(reservation.amount, Ordering::SeqCst)
                                + reservation.amount,
                            Ordering::SeqCst,
                        );
                        thread::yield_now();
                        out.fetch_sub(reservation.amount, Ordering::SeqCst);
                    }
                });
            }
        });
        assert!(most.into_inner() <= 10);
    }
}
