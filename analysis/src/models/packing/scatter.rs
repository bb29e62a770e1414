//! Scatter of packing metrics from start to start: of drawn velocities, of the drift through a periodic box, and of drawn radii.

use super::laws::DiffusingDiscs;
use super::observe::PackingRun;
use crate::metric::{Quantity, Violation};
use crate::models::hard_discs::contact_value;
use crate::statistics::Estimate;
use kinetoscope_manifest::model::{Boundary, PackingPlacement};
use std::f64::consts::PI;

/// Longest wave over the critical one up to which the energy of shear flow is at most twice that of independent discs,
/// 1/(1 - (this)^2).
const STABLE_FRACTION: f64 = 0.7;

impl PackingRun {
    /// Standard deviation of the mean thermal speed from start to start, relative to it: the energy of n discs has two
    /// degrees of freedom per disc, or 2(n - 1) if the momentum is fixed, and the speed is proportional to its root.
    fn thermal_speed_scatter(&self) -> f64 {
        let is_drawn = !matches!(
            self.config.placement,
            PackingPlacement::Given(_) | PackingPlacement::Recorded(_)
        );
        let has_fixed_momentum = self.keeps_momentum() || self.config.remove_mean_velocity;
        let free = if has_fixed_momentum { self.discs() - 1.0 } else { self.discs() };
        if is_drawn && free > 0.0 { 0.5 / free.sqrt() } else { 0.0 }
    }

    /// Scatter from start to start of the squared distance by which all discs drift together: |V|^2 of the mean velocity V
    /// follows an exponential distribution with the mean `<v^2>`/n.
    pub(super) fn drift_scatter(&self) -> f64 {
        let Some(last) = self.frames.last().filter(|_| self.has_drift()) else { return 0.0 };
        2.0 * last.temperature / self.discs() * last.time * last.time
    }

    /// A rate, which is proportional to the thermal speed, with the scatter of starts.
    pub(super) fn with_scatter_of_starts(&self, rate: Estimate) -> Estimate {
        self.with_scatter_of_sizes(
            rate.with_scatter_of_starts(rate.value.abs() * self.thermal_speed_scatter()),
        )
    }

    /// Z - 1 of the energy of all discs, with the scatter of starts: the energy of the center of mass, which n discs in a
    /// periodic box keep if it was drawn, is not thermal. Its share is Beta(1, n - 1)-distributed.
    pub(super) fn excess_with_scatter_of_starts(&self, excess: Estimate) -> Estimate {
        let discs = self.discs();
        let share = ((discs - 1.0) / (discs + 1.0)).sqrt() / discs;
        let drift = if self.has_drift() { excess.value.abs() * share } else { 0.0 };
        self.with_scatter_of_sizes(excess.with_scatter_of_starts(drift))
    }

    /// The estimate, whose scatter from start to start is unknown if the radii are drawn or follow from a compression. Theory
    /// uses the radii of the run.
    pub(super) fn with_scatter_of_sizes(&self, estimate: Estimate) -> Estimate {
        if self.equal_radius().is_some() {
            return estimate;
        }
        let given = estimate.conditional_standard_error.or(estimate.standard_error);
        Estimate { standard_error: given, ..estimate }.with_unknown_scatter_of_starts()
    }

    /// Whether the box is so small that no shear wave of cooling discs grows. Otherwise, flow and clusters make values differ from seed to
    /// seed by more than the scatter within a run.
    pub(super) fn stays_homogeneous(&self) -> bool {
        let (width, height) = (self.config.width.get(), self.config.height.get());
        // Between specular walls, half a wave fits.
        let longest = width.max(height) * if self.has_walls() { 2.0 } else { 1.0 };
        let Some(packing_fraction) = self.packing_fraction() else { return false };
        let diameter = 2.0 * self.config.radius.get();
        let contact_value = contact_value(packing_fraction);
        let density = self.discs() / (width * height);
        let pair_rate = 2.0 * PI.sqrt() * density * diameter * contact_value;
        let (discs, temperature) = (self.discs(), 1.0);
        let discs = DiffusingDiscs {
            discs,
            packing_fraction,
            diameter,
            contact_value,
            temperature,
            pair_rate,
        };
        longest <= STABLE_FRACTION * discs.critical_wavelength(self.config.restitution.get())
    }

    /// Standard deviation of the discs' area from start to start, relative to it: radii R (1 + h u) with u uniform from -1 to 1 have
    /// squares with the mean R^2 (1 + h^2/3) and the variance R^4 (4 h^2/3 + 4 h^4/45). `None` where they are not drawn as they remain.
    pub(super) fn scatter_of_area(&self) -> Option<f64> {
        let is_recorded = matches!(self.config.placement, PackingPlacement::Recorded(_));
        let square = self.config.radius_half_width.get() * self.config.radius_half_width.get();
        let variance = 4.0 * square / 3.0 + 4.0 * square * square / 45.0;
        let is_drawn = !is_recorded && self.config.target_reduced_pressure.is_none();
        is_drawn.then(|| (variance / self.discs()).sqrt() / (1.0 + square / 3.0))
    }

    pub(super) fn has_walls(&self) -> bool {
        self.config.boundary == Boundary::Walls
    }

    pub(super) fn has_obstacles(&self) -> bool {
        self.config.obstacles.is_some()
    }

    /// Whether neither walls nor obstacles take up momentum.
    pub(super) fn keeps_momentum(&self) -> bool {
        !self.has_walls() && !self.has_obstacles()
    }

    /// Whether the discs drift through a periodic box: their drawn velocities have a mean, and nothing takes it up. Theory
    /// is that of discs whose total momentum is zero.
    pub(super) fn has_drift(&self) -> bool {
        let is_drawn = !matches!(
            self.config.placement,
            PackingPlacement::Given(_) | PackingPlacement::Recorded(_)
        );
        self.keeps_momentum() && is_drawn && !self.config.remove_mean_velocity
    }

    /// The condition of a total momentum of zero, if the discs drift.
    pub(super) fn drift(&self) -> Option<Violation> {
        Quantity::Drift.required(!self.has_drift())
    }

    /// The condition of the laws of a fluid that a drift or obstacles break: discs have less room, and collide with obstacles as well.
    pub(super) fn outside_fluid(&self) -> Option<Violation> {
        self.drift().or_else(|| Quantity::Obstacles.required(!self.has_obstacles()))
    }

    /// The radius of equal discs; `None` if radii differ or result from a compression.
    pub(crate) fn equal_radius(&self) -> Option<f64> {
        let is_given = self.config.radius_half_width.get() == 0.0
            && self.config.target_reduced_pressure.is_none();
        is_given.then(|| self.config.radius.get())
    }
}
