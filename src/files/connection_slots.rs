//! The places of the connections of a server. Clients that only connect, or that read slowly, cannot lock out others.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

/// Maximum number of connections.
const MAX_CONNECTIONS: usize = 64;
/// Maximum number of connections together with displaced ones that have not ended yet.
pub const MAX_OPEN: usize = 2 * MAX_CONNECTIONS;
/// Interval at which a blocked read or write checks whether its connection must end.
pub const CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// The place of one connection. `P` is what it has achieved, from the least to the most.
#[derive(Debug)]
pub struct Slot<P> {
    /// What was achieved, and when.
    progress: Mutex<(P, Instant)>,
    is_displaced: AtomicBool,
}

impl<P: Copy> Slot<P> {
    /// What the connection has achieved, and when.
    pub fn progress(&self) -> (P, Instant) {
        *self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reports what the connection has achieved now.
    pub fn report(&self, progress: P) {
        *self.progress.lock().unwrap_or_else(PoisonError::into_inner) = (progress, Instant::now());
    }

    /// Changes what the connection has achieved. It is as idle as before.
    pub fn change(&self, change: impl FnOnce(&mut P)) {
        change(&mut self.progress.lock().unwrap_or_else(PoisonError::into_inner).0);
    }

    /// Whether another connection took the place.
    pub fn is_displaced(&self) -> bool {
        self.is_displaced.load(Ordering::Relaxed)
    }
}

/// The places of all connections, at most `MAX_CONNECTIONS`. If all are occupied, a new connection displaces the one that has achieved
/// least, and among these the one that has been idle longest.
#[derive(Debug)]
pub struct Slots<P> {
    slots: Vec<Weak<Slot<P>>>,
}

impl<P> Default for Slots<P> {
    fn default() -> Self {
        Self { slots: Vec::new() }
    }
}

impl<P: Copy + Ord> Slots<P> {
    /// Occupies a place until the value is dropped.
    pub fn occupy(&mut self, progress: P) -> Arc<Slot<P>> {
        let all = self.slots.iter().filter_map(Weak::upgrade);
        let occupied: Vec<_> = all.filter(|slot| !slot.is_displaced()).collect();
        if occupied.len() >= MAX_CONNECTIONS
            && let Some(least) = occupied.iter().min_by_key(|slot| slot.progress())
        {
            least.is_displaced.store(true, Ordering::Relaxed);
        }
        let progress = Mutex::new((progress, Instant::now()));
        let slot = Arc::new(Slot { progress, is_displaced: AtomicBool::new(false) });
        self.slots.retain(|slot| slot.strong_count() > 0);
        self.slots.push(Arc::downgrade(&slot));
        slot
    }

    /// Whether the server accepts one more connection: displaced ones need some time to end.
    pub fn has_room(&mut self) -> bool {
        self.slots.retain(|slot| slot.strong_count() > 0);
        self.slots.len() < MAX_OPEN
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_connection_displaces_the_one_that_has_achieved_least() {
        let mut slots = Slots::default();
        let mut occupied: Vec<Arc<Slot<u8>>> =
            (0..MAX_CONNECTIONS).map(|_| slots.occupy(0)).collect();
        // The first one is a viewer, and the second one has agreed on the protocol.
        occupied[0].report(2);
        occupied[1].report(1);
        let displaced = |occupied: &[Arc<Slot<u8>>]| -> Vec<usize> {
            (0..occupied.len()).filter(|&at| occupied[at].is_displaced()).collect()
        };
        assert!(displaced(&occupied).is_empty());
        for count in 1..=3 * MAX_CONNECTIONS {
            occupied.push(slots.occupy(0));
            // The oldest of those that have only connected, in the order in which they came.
            assert_eq!(displaced(&occupied), (2..2 + count).collect::<Vec<_>>());
        }
        let newest = occupied.last().unwrap();
        assert!(!newest.is_displaced());
    }

    #[test]
    fn ended_connections_leave_their_slots() {
        let mut slots = Slots::default();
        let mut occupied: Vec<Arc<Slot<u8>>> =
            (0..MAX_CONNECTIONS).map(|_| slots.occupy(0)).collect();
        occupied.remove(7);
        occupied.push(slots.occupy(0));
        assert!(!occupied.iter().any(|slot| slot.is_displaced()));
    }

    #[test]
    fn displaced_connections_count_until_they_end() {
        let mut slots = Slots::default();
        let mut all: Vec<_> = (0..MAX_OPEN).map(|_| slots.occupy(0)).collect();
        assert!(!slots.has_room());
        all.pop();
        assert!(slots.has_room());
    }
}
