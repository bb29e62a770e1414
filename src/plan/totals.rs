//! What the runs of a plan take together: disk space, memory and time.

use crate::plan::{Plan, PlannedRun};
#[cfg(not(target_family = "wasm"))]
use crate::run::resources::time::measured_seconds;
use kinetoscope_recording::file;
use std::fs;

impl Plan {
    /// Upper estimate of the bytes still to be written.
    #[must_use]
    pub fn bytes_to_write(&self) -> u64 {
        let estimates = self.runs.iter().filter_map(PlannedRun::estimate);
        estimates.map(|estimate| estimate.bytes).fold(0, u64::saturating_add)
    }

    /// Upper estimate of the bytes that the `jobs` largest recordings still need. The part of an interrupted run on the disk is
    /// subtracted.
    #[must_use]
    pub fn bytes_at_once(&self, jobs: usize) -> u64 {
        let needed = |run: &PlannedRun| {
            let left = fs::metadata(file::partial_path(&self.folder, &run.stem));
            let there = left.map_or(0, |file| file.len());
            run.estimate().map(|estimate| estimate.bytes.saturating_sub(there))
        };
        largest(self.runs.iter().filter_map(needed).collect(), jobs)
    }

    /// Upper estimate of the memory of `jobs` runs in parallel.
    #[must_use]
    pub fn memory_at_once(&self, jobs: usize) -> u64 {
        let estimates = self.runs.iter().filter_map(PlannedRun::estimate);
        largest(estimates.map(|estimate| estimate.memory_bytes).collect(), jobs)
    }

    /// Seconds that the runs take on this machine with `jobs` in parallel and without recording, from a measurement of the
    /// costliest run; `None` if nothing could be measured.
    #[cfg(not(target_family = "wasm"))]
    #[must_use]
    pub fn expected_seconds(&self, jobs: usize) -> Option<f64> {
        let runs = self.to_do_by_cost();
        let costliest = runs.first()?;
        let longest = measured_seconds(&costliest.run.manifest, costliest.take_start())?;
        let cost = |run: &PlannedRun| run.estimate().map_or(0.0, |estimate| estimate.relative_cost);
        let total: f64 = runs.iter().map(|run| cost(run)).sum();
        let of_all = longest * total / cost(costliest);
        let in_parallel = of_all / jobs as f64;
        let seconds = if in_parallel > longest { in_parallel } else { longest };
        seconds.is_finite().then_some(seconds)
    }
}

/// Sum of the `count` largest numbers of bytes.
fn largest(mut bytes: Vec<u64>, count: usize) -> u64 {
    bytes.sort_unstable_by(|one, other| other.cmp(one));
    bytes.into_iter().take(count).fold(0, u64::saturating_add)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;
    use crate::interrupt::Interrupt;

    /// A disk with exactly the missing space must suffice after it was full.
    #[test]
    fn partial_recording_reduces_the_space_needed() {
        let output = tempfile::tempdir().unwrap();
        let experiment =
            kinetoscope_manifest::parse("seed = 1\n[model.gas]\n", "kept.toml", &[]).unwrap();
        let plan = Plan::new(&experiment, output.path(), false, &Interrupt::default());
        let whole = plan.bytes_at_once(1);
        fs::create_dir_all(&plan.folder).unwrap();
        let partial = file::partial_path(&plan.folder, &plan.runs[0].stem);
        fs::write(partial, [0; 1000]).unwrap();
        assert_eq!(plan.bytes_at_once(1), whole - 1000);
    }
}
