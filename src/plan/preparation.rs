//! The starts that a plan builds: who stops it, and who sees how much is complete.

use crate::interrupt::Interrupt;
use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};

/// Parts of a start whose completion is reported.
const PARTS: f64 = 1000.0;

/// What stops a plan, and what receives its progress.
#[derive(Clone, Copy)]
pub struct Preparation<'a> {
    /// Whether to stop.
    pub interrupt: &'a Interrupt,
    /// Receives the number of runs whose starts are complete, with the complete fractions of the others, and the number of all runs.
    pub on_progress: &'a (dyn Fn(f64, usize) + Sync),
}

/// A preparation that nothing observes.
impl<'a> From<&'a Interrupt> for Preparation<'a> {
    fn from(interrupt: &'a Interrupt) -> Self {
        Self { interrupt, on_progress: &|_, _| {} }
    }
}

/// The progress of all starts of a plan.
pub(super) struct StartProgress<'a> {
    preparation: Preparation<'a>,
    runs: usize,
    /// Complete parts of all starts.
    parts: AtomicU64,
}

impl<'a> StartProgress<'a> {
    pub(super) fn new(preparation: Preparation<'a>, runs: usize) -> Self {
        Self { preparation, runs, parts: AtomicU64::new(0) }
    }

    /// The start of one run, on the thread that builds it.
    pub(super) fn of_run(&self) -> RunPreparation<'_> {
        RunPreparation { all: self, parts: Cell::new(0) }
    }
}

/// The start of one run.
pub(super) struct RunPreparation<'a> {
    all: &'a StartProgress<'a>,
    parts: Cell<u64>,
}

impl RunPreparation<'_> {
    /// Reports the complete fraction; returns whether to continue.
    pub(super) fn proceed(&self, fraction: f64) -> bool {
        let parts = ((fraction * PARTS) as u64).min(PARTS as u64);
        let more = parts.saturating_sub(self.parts.get());
        if more > 0 {
            self.parts.set(parts);
            let before = self.all.parts.fetch_add(more, Ordering::Relaxed);
            let done = (before + more) as f64 / PARTS;
            (self.all.preparation.on_progress)(done, self.all.runs);
        }
        !self.all.preparation.interrupt.is_raised()
    }
}
