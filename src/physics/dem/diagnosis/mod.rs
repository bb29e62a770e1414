//! Diagnosis before the first step: whether a run can be integrated.
//!
//! Each step of an explicit scheme subtracts c = eta dt/m_eff times the relative velocity of a contact: v' = (1 - c) v. The
//! velocity reverses for c > 1 and grows for c > 2; far above, each contact multiplies it by about c.

pub(super) mod messages;
mod suggestions;

use crate::dem::expected_load::ExpectedLoad;
use crate::dem::laws::Impact;
use crate::dem::parameters::Parameters;
use kinetoscope_manifest::model::{DemConfig, DemDashpot};

/// c = eta dt/m_eff from which a run is rejected.
const MAX_DAMPING_STEP: f64 = 1.0;
/// c from which the restitution deviates from the requested one.
const DOUBTFUL_DAMPING_STEP: f64 = 0.3;
/// Bound of 6 k dt^2/m + 12 eta dt/m, for a hexagonal bed.
const BED_BOUND: f64 = 4.0;
/// pi sqrt(m/k) / dt below which beds chatter.
const DOUBTFUL_STEPS_PER_CONTACT: f64 = 10.0;
/// Overlap over radius from which a run is rejected: a second impact would bring the center through the wall.
const MAX_OVERLAP: f64 = 0.5;
/// Overlap over radius from which a warning is given.
const DOUBTFUL_OVERLAP: f64 = 0.3;
/// Integers beyond this are not all floating-point numbers.
const MAX_STEPS: u64 = 1 << 53;

/// The figures that decide whether a start is accepted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Diagnosis {
    /// c = eta dt/m_eff of the lightest pair.
    pub(super) damping_step: f64,
    /// 6 k dt^2/m + 12 eta dt/m of the lightest discs; an implicit dashpot does not contribute.
    bed: f64,
    /// Whether `bed` is 24 k_t dt^2/m + 48 eta_t dt/m, which is larger; see `spin_bound`.
    has_faster_spins: bool,
    /// The DEM exercise's N_t: pi sqrt(m/k) / dt, m the smallest mass.
    steps_per_wall_contact: f64,
    /// Largest expected overlap at a wall, over the radius.
    pub(super) overlap_over_radius: f64,
    /// Whether the dashpot is implicit, and has no bound.
    is_implicit: bool,
    /// Whether any cohesion is given.
    is_cohesive: bool,
    /// The key that makes contacts stiffer.
    stiffness_key: &'static str,
    /// Whether the number of steps is at least one and exactly representable; no run starts without that.
    pub(super) is_countable: bool,
}

impl Diagnosis {
    pub(super) fn of(config: &DemConfig) -> Self {
        let parameters = Parameters::new(config);
        let is_implicit = config.dashpot == DemDashpot::Implicit;
        let (step, mass) = (parameters.time_step, parameters.smallest_mass);
        let law = parameters.law.normal;
        let damping = parameters.strongest_damping();
        let dashpot_part = if is_implicit { 0.0 } else { 12.0 * damping * step / mass };
        let by_springs = law.bed_bound(parameters.law.mass_of_stiffest(mass), step);
        let (by_forces, by_spins) =
            (by_springs + dashpot_part, spin_bound(config, &parameters, damping));
        let has_faster_spins = by_spins > by_forces;
        Self {
            damping_step: damping * step / parameters.lightest_pair_mass(),
            bed: if has_faster_spins { by_spins } else { by_forces },
            has_faster_spins,
            steps_per_wall_contact: parameters.law.contact_time(mass) / step,
            overlap_over_radius: expected_overlap(config, &parameters) / parameters.radius,
            is_implicit,
            stiffness_key: law.key(),
            is_cohesive: config.has_cohesion(),
            is_countable: step > 0.0 && (1..=MAX_STEPS).contains(&parameters.total_steps),
        }
    }

    /// Whether the run must be rejected. Comparisons are written so that a value that is not a number is unstable.
    pub(super) fn is_rejected(&self) -> bool {
        self.is_unstable() || self.passes_walls() || !self.is_countable
    }

    pub(super) fn is_unstable(&self) -> bool {
        let is_bed_stable = self.bed < BED_BOUND;
        let is_pair_stable = self.is_implicit || self.damping_step < MAX_DAMPING_STEP;
        !(is_bed_stable && is_pair_stable)
    }

    fn passes_walls(&self) -> bool {
        let is_held = self.overlap_over_radius < MAX_OVERLAP;
        !is_held
    }

    /// The reasons for a rejection, each a sentence without its period. `the` is the first word, capital or small.
    pub(super) fn problems(&self, the: &str) -> Vec<String> {
        let mut problems = Vec::new();
        if self.is_unstable() {
            let terms = match self.has_faster_spins {
                false => "6 k dt^2/m + 12 eta dt/m",
                true => "24 k_t dt^2/m + 48 eta_t dt/m",
            };
            problems.push(format!(
                "{the} time step is unstable: c = eta dt/m_eff = {} for the lightest pair (must be below 1, because a \
                 step changes the velocity to (1 - c) v), and {terms} = {} for a bed (must be below 4)",
                figure(self.damping_step),
                figure(self.bed)
            ));
        }
        if self.passes_walls() {
            let (cause, other) = match self.is_cohesive {
                false => ("a disc that falls through the box overlaps the wall", "the wall"),
                true => (
                    "a disc that falls through the box, and that cohesion presses, overlaps the wall or another disc",
                    "it",
                ),
            };
            problems.push(format!(
                "{the} contacts are too soft: {cause} by about {} of its radius (at most {MAX_OVERLAP} is accepted), and \
                 its center may pass {other}",
                figure(self.overlap_over_radius)
            ));
        }
        if !self.is_countable {
            problems.push(format!(
                "{the} duration must hold at least one time step, and at most 2^53 of them"
            ));
        }
        problems
    }

    /// Warnings for an accepted run, one sentence each.
    pub(super) fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.is_unstable() {
            return warnings;
        }
        if self.is_implicit && self.damping_step >= DOUBTFUL_DAMPING_STEP {
            warnings.push(format!(
                "c = eta dt/m_eff = {} with the implicit dashpot: collisions dissipate more energy than with the exact \
                 dashpot; from c = 1 on, only the state at rest is meaningful.",
                figure(self.damping_step)
            ));
        } else if self.damping_step >= DOUBTFUL_DAMPING_STEP {
            warnings.push(format!(
                "c = eta dt/m_eff = {} for the lightest pair: from 0.3 on, the restitution deviates from the \
                 requested one; use a smaller time step.",
                figure(self.damping_step)
            ));
        }
        if self.steps_per_wall_contact < DOUBTFUL_STEPS_PER_CONTACT {
            warnings.push(format!(
                "steps_per_wall_contact is {}; below 10, discs in beds chatter.",
                figure(self.steps_per_wall_contact)
            ));
        }
        if self.overlap_over_radius >= DOUBTFUL_OVERLAP && !self.passes_walls() {
            warnings.push(format!(
                "A disc that falls through the box overlaps the wall by about {} of its radius; a higher {} reduces \
                 the overlap.",
                figure(self.overlap_over_radius),
                self.stiffness_key
            ));
        }
        warnings
    }
}

/// 24 k_t dt^2/m + 48 eta_t dt/m with Mindlin's springs, else 0: a hexagonal bed whose discs rotate alike vibrates with 24 k_t/m, which
/// is the largest squared frequency for k_t above a quarter of k.
fn spin_bound(config: &DemConfig, parameters: &Parameters, damping: f64) -> f64 {
    let Parameters { ref law, time_step, smallest_mass, .. } = *parameters;
    if !config.has_mindlin_springs() || !config.has_friction() {
        return 0.0;
    }
    let stiffness = law.materials.stiffness_range().1 * law.tangential_stiffness;
    let dashpot = law.tangential_to_normal_damping * damping;
    (24.0 * stiffness * time_step + 48.0 * dashpot) * time_step / smallest_mass
}

/// Largest expected overlap at a wall, m: that of a disc that falls onto it, plus that due to the weight of a column of discs and cohesion.
fn expected_overlap(config: &DemConfig, parameters: &Parameters) -> f64 {
    let ExpectedLoad { mass, speed, weight } = ExpectedLoad::of(config);
    let damping_ratio = parameters.weakest_damping_ratio(mass);
    let impact = Impact { speed, mass, radius: parameters.radius, damping_ratio };
    parameters.law.expected_overlap(&impact, weight)
}

/// A figure for a message: an integer from ten on, else two decimals.
pub(super) fn figure(value: f64) -> String {
    if value >= 1e5 {
        format!("{value:.2e}")
    } else if value >= 10.0 {
        format!("{value:.0}")
    } else {
        format!("{value:.2}")
    }
}
