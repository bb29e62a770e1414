//! What the manifests of the runs behind a metric set: the number of particles, and the size of the container that limits it.

use super::kinds::{DEPOSIT_LENGTH, DISPLACEMENT, LIMITED, MEAN_HEIGHT, nearer_of, zero_of};
use super::relation::Place;
use crate::metric_files::document::{Document, MetricEntry};
use crate::models::contract::Extent;
use crate::models::extent;
use crate::run::RunAnalysis;
use std::collections::BTreeMap;

/// What the manifest of a run sets.
#[derive(Clone, Copy, Debug)]
struct Setting {
    particles: f64,
    /// The length of a deposit from which it reaches both walls, up to a column of discs, m. Infinite without walls.
    full_length_m: f64,
    /// Half of the mean square displacement of discs that may be anywhere between the walls. Infinite without walls.
    far_square: f64,
    /// The height of the bottom above the center, m; 0 without a container.
    bottom_m: f64,
}

impl Setting {
    fn of(run: &RunAnalysis) -> Self {
        let Extent { bounds, radius, is_periodic, .. } = extent(run.model());
        let particles = run.model().particles() as f64;
        let Some([width, height]) =
            bounds.map(|[low, high]| [0, 1].map(|axis: usize| high[axis] - low[axis]))
        else {
            let far = f64::INFINITY;
            return Self { particles, full_length_m: far, far_square: far, bottom_m: 0.0 };
        };
        // Two independent places on a line differ by a sixth of its squared length in the mean square.
        let free = [width, height].map(|side| (side - 2.0 * radius).powi(2));
        let far_square = if is_periodic { f64::INFINITY } else { (free[0] + free[1]) / 12.0 };
        // A column is two mean diameters wide.
        Self { particles, full_length_m: width - 4.0 * radius, far_square, bottom_m: -height / 2.0 }
    }

    /// The size of this metric from which the container limits it.
    fn limit(&self, metric: &str) -> f64 {
        if metric == DEPOSIT_LENGTH { self.full_length_m } else { self.far_square }
    }
}

/// The runs of an analysis, and the sizes of two that show whether the container limits them.
pub(super) struct Runs {
    settings: BTreeMap<Place, Setting>,
    /// The smaller of the values before and now.
    sizes: BTreeMap<(&'static str, Place), f64>,
}

impl Runs {
    /// Of the runs of an analysis, which `new` contains in the same order, and of an earlier one.
    pub(super) fn of(old: &Document, new: &Document, runs: &[RunAnalysis]) -> Self {
        let places = new.runs.iter().map(Place::of_run);
        let sizes = |document: &Document| -> BTreeMap<(&'static str, Place), f64> {
            let size = |entry: &MetricEntry| {
                let shown = [DEPOSIT_LENGTH, DISPLACEMENT].into_iter();
                let name = shown.into_iter().find(|name| entry.name == *name)?;
                Some(((name, Place::of_metric(entry)), entry.value?))
            };
            document.metrics.iter().filter_map(size).collect()
        };
        let (before, now) = (sizes(old), sizes(new));
        let both = now.into_iter().filter_map(|(key, now)| {
            let before = *before.get(&key)?;
            Some((key, now.min(before)))
        });
        Self { settings: places.zip(runs.iter().map(Setting::of)).collect(), sizes: both.collect() }
    }

    /// The number of particles behind a metric: the least of the runs from which it is derived.
    pub(super) fn particles(&self, place: &Place) -> f64 {
        self.included(place).map(|setting| setting.particles).fold(f64::INFINITY, f64::min)
    }

    /// Whether the container limits a metric in both analyses.
    pub(super) fn is_saturated(&self, name: &str, place: &Place) -> bool {
        let Some((_, shown)) = LIMITED.iter().find(|(limited, _)| *limited == name) else {
            return false;
        };
        let reaches =
            |size: &f64| self.included(place).all(|setting| *size >= setting.limit(shown));
        self.sizes.get(&(*shown, place.clone())).is_some_and(reaches)
    }

    /// The value from which the changes of a metric count.
    pub(super) fn zero_of(&self, name: &str, place: &Place, value: f64) -> f64 {
        if name != MEAN_HEIGHT {
            return zero_of(name, value);
        }
        let bottom = self.included(place).map(|setting| setting.bottom_m).fold(0.0, f64::min);
        nearer_of(bottom, value)
    }

    fn included(&self, place: &Place) -> impl Iterator<Item = &Setting> {
        let included = self.settings.iter().filter(|(run, _)| place.includes(run));
        included.map(|(_, setting)| setting)
    }
}
