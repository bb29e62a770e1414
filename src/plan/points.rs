//! What the replicates of a point of the sweep share in a plan: the end of their canonical text, and an estimate.

use crate::run::resources::Estimate;
use kinetoscope_manifest::{Run, RunKey, RunManifest, run_key};
use kinetoscope_physics::kind_of;
use kinetoscope_recording::channels::SCHEMA_VERSION;
use std::sync::{Arc, OnceLock};

/// Points whose texts are kept, which bounds the memory.
const MOST_TEXTS: usize = 10_000;

/// An estimate, and the seconds that the start takes.
type Shared = (Arc<Estimate>, f64);

/// The points of a sweep.
pub(super) struct Points {
    /// The point of each run.
    of_runs: Vec<u32>,
    points: Vec<Point>,
}

#[derive(Default)]
struct Point {
    /// Index of its first run.
    first: usize,
    text: OnceLock<String>,
    /// `None` if the first replicate is rejected.
    estimate: OnceLock<Option<Shared>>,
}

impl Points {
    /// The points of these runs: those of one have the same values in memory.
    pub(super) fn of(runs: &[Run]) -> Self {
        let mut points: Vec<Point> = Vec::new();
        let of_runs = runs.iter().enumerate().map(|(index, run)| {
            let is_same =
                |point: &Point| Arc::ptr_eq(&runs[point.first].manifest.model, &run.manifest.model);
            if !points.last().is_some_and(is_same) {
                points.push(Point { first: index, ..Point::default() });
            }
            (points.len() - 1) as u32
        });
        let of_runs = of_runs.collect();
        Self { of_runs, points }
    }

    /// The canonical text and the key of a run.
    pub(super) fn identity(&self, run: usize, manifest: &RunManifest) -> (String, RunKey) {
        let canonical = if self.points.len() > MOST_TEXTS {
            manifest.canonical()
        } else {
            let point = &self.points[self.of_runs[run] as usize];
            manifest.canonical_with(point.text.get_or_init(|| manifest.shared_text()))
        };
        let key = run_key(&canonical, kind_of(&manifest.model).physics_version, SCHEMA_VERSION);
        (canonical, key)
    }

    /// The estimate of a run's point, as its first run gives it.
    pub(super) fn estimate(
        &self,
        run: usize,
        of_first: impl FnOnce(usize) -> Option<Shared>,
    ) -> Option<Shared> {
        let point = &self.points[self.of_runs[run] as usize];
        point.estimate.get_or_init(|| of_first(point.first)).clone()
    }
}
