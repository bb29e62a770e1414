//! What the manifests of the runs behind a metric set: the number of particles, and the size of the container that limits it.

use super::kinds::{DEPOSIT_LENGTH, LIMITED};
use super::relation::Place;
use crate::metric_files::document::Document;
use crate::models::extent;
use crate::run::RunAnalysis;
use std::collections::BTreeMap;

/// What the manifest of a run sets.
#[derive(Clone, Copy, Debug)]
struct Setting {
    particles: f64,
    /// The length of a deposit from which it reaches both walls, up to a column of discs, m. Infinite without walls.
    full_length_m: f64,
}

/// The runs of an analysis, and the deposits of two.
pub(super) struct Runs {
    settings: BTreeMap<Place, Setting>,
    /// The shorter of the deposits before and now.
    lengths_m: BTreeMap<Place, f64>,
}

impl Runs {
    /// Of the runs of an analysis, which `new` contains in the same order, and of an earlier one.
    pub(super) fn of(old: &Document, new: &Document, runs: &[RunAnalysis]) -> Self {
        let setting = |run: &RunAnalysis| {
            let extent = extent(run.model());
            let width = extent.bounds.map(|[low, high]| high[0] - low[0]);
            Setting {
                particles: run.model().particles() as f64,
                // A column is two mean diameters wide.
                full_length_m: width.map_or(f64::INFINITY, |width| width - 4.0 * extent.radius),
            }
        };
        let places = new.runs.iter().map(Place::of_run);
        let lengths = |document: &Document| -> BTreeMap<Place, f64> {
            let named = document.metrics.iter().filter(|entry| entry.name == DEPOSIT_LENGTH);
            named.filter_map(|entry| Some((Place::of_metric(entry), entry.value?))).collect()
        };
        let mut lengths_m = lengths(new);
        let before = lengths(old);
        lengths_m.retain(|place, now| match before.get(place) {
            Some(before) => {
                *now = now.min(*before);
                true
            }
            None => false,
        });
        Self { settings: places.zip(runs.iter().map(setting)).collect(), lengths_m }
    }

    /// The number of particles behind a metric: the least of the runs from which it is derived.
    pub(super) fn particles(&self, place: &Place) -> f64 {
        self.included(place).map(|setting| setting.particles).fold(f64::INFINITY, f64::min)
    }

    /// Whether the container limits a metric in both analyses.
    pub(super) fn is_saturated(&self, name: &str, place: &Place) -> bool {
        let reaches =
            |length: &f64| self.included(place).all(|setting| *length >= setting.full_length_m);
        LIMITED.contains(&name) && self.lengths_m.get(place).is_some_and(reaches)
    }

    fn included(&self, place: &Place) -> impl Iterator<Item = &Setting> {
        let included = self.settings.iter().filter(|(run, _)| place.includes(run));
        included.map(|(_, setting)| setting)
    }
}
