//! Metrics whose values mean something else than an amount, so that equal values show less, or have another distribution.

/// The length of a deposit, which cannot grow beyond the width of its container.
pub(super) const DEPOSIT_LENGTH: &str = "bed.deposit_length";

/// The distance that discs have gone, which tends to that of discs anywhere in the box.
pub(super) const DISPLACEMENT: &str = "mean_square_displacement.final";

/// The mean height of a gas above the center, which strong gravity moves to the bottom.
pub(super) const MEAN_HEIGHT: &str = "layers.mean_height";

/// Metrics that the container limits, with the one whose size shows it: a deposit from wall to wall no longer changes its length, nor the
/// growth of its length.
pub(super) const LIMITED: [(&str, &str); 3] = [
    (DEPOSIT_LENGTH, DEPOSIT_LENGTH),
    ("bed.normalized_runout", DEPOSIT_LENGTH),
    (DISPLACEMENT, DISPLACEMENT),
];

/// Metrics that are logarithms: their zero depends on the unit of the argument.
pub(super) const LOGARITHMS: [&str; 1] = ["h_function"];

/// Metrics that have a value by construction where what they measure has no effect, such as the compressibility factor 1 of a dilute
/// gas, or the fraction 1 of the energy that is lost. Their changes are fractions of the difference from this value, or from 0 if that
/// is nearer.
pub(super) const TRIVIAL: [(&str, f64); 17] = [
    ("adiabatic_invariant", 1.0),
    ("compressibility_factor", 1.0),
    ("compressibility_factor.from_collision_rate", 1.0),
    ("contact_value.from_collision_rate", 1.0),
    ("contact_value.from_pairs", 1.0),
    ("energy.drift_relative", -1.0),
    ("energy.friction_fraction", 1.0),
    ("energy.total_change_relative", -1.0),
    ("pair_correlation.near_contact", 1.0),
    ("psi6.global", 1.0),
    ("psi6.local", 1.0),
    ("restitution.measured", 1.0),
    ("row.velocity_transmission", 1.0),
    ("stress.overburden_deviation", 1.0),
    ("temperature.final_over_initial", 1.0),
    ("third_law.ratio", 1.0),
    ("velocity_autocorrelation.final", 1.0),
];

/// The value from which a metric's changes count: 0, or the trivial one if that is nearer.
pub(super) fn zero_of(name: &str, value: f64) -> f64 {
    let trivial = TRIVIAL.iter().find(|(metric, _)| *metric == name);
    trivial.map_or(0.0, |&(_, trivial)| nearer_of(trivial, value))
}

/// The one of 0 and another number that is nearer to a value.
pub(super) fn nearer_of(other: f64, value: f64) -> f64 {
    if (value - other).abs() < value.abs() { other } else { 0.0 }
}

/// Pure numbers that are the same in every gas in equilibrium, or in every one with this distribution of speeds, whatever its size, density
/// and temperature: moments of the distribution, distances from it, and chi-squares against the law. That they have an error depends on
/// the collisions or the counts of a run.
pub(super) const FORMS: [&str; 11] = [
    "a2",
    "a2.final",
    "a2.mean",
    "box_entropy.change",
    "fraction_within_half_radius",
    "layers.chi_square_per_layer",
    "mean_speed_over_rms",
    "pressure.second_half_over_first",
    "relative_entropy",
    "speed_histogram.chi_square_per_bin",
    "speed_histogram.total_variation_distance",
];

/// What carries the discs: in a bed at rest, their weight, which the manifest sets, whatever the contacts are.
pub(super) const WEIGHTS: [&str; 3] = ["floor.force", "floor.stress", "stress.vertical_at_floor"];

/// Whether values of the metric follow from a law in most runs, so that equal ones show little.
pub(super) fn is_lawful(name: &str) -> bool {
    FORMS.contains(&name) || WEIGHTS.contains(&name)
}

/// Metrics with an error that a run has or has not by chance: without a collision, where a disc may have gone too far between two frames,
/// where too few discs have left, and where the counts are small.
pub(super) const OF_SOME_SEEDS: [&str; 4] =
    ["mean_free_time", DISPLACEMENT, "outlet.discharge_rate", "speed_histogram.chi_square_per_bin"];

/// Metrics whose law's accuracy contains one standard deviation of their scatter: the losses of energy per collision.
const SCATTERED: [&str; 2] = ["temperature.final", "temperature.final_over_initial"];

/// Accuracies within which another seed of a value inside the accuracy of its law remains: chance exceeds five standard deviations in
/// fewer than one of a million runs.
pub(super) fn most_accuracies(name: &str) -> f64 {
    if SCATTERED.contains(&name) { 5.0 } else { 1.0 }
}

/// Metrics whose values follow chi-square distributions, which a few particles or a few bins make.
pub(super) const CHI_SQUARES: [&str; 3] = [
    "granular_temperature.start",
    "layers.chi_square_per_layer",
    "speed_histogram.chi_square_per_bin",
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::MODELS;

    /// Guarantee: a metric that gets another name is not forgotten here.
    #[test]
    fn kinds_contain_metrics_only() {
        let all: Vec<&str> =
            MODELS.iter().flat_map(|model| model.metrics).map(|metric| metric.name).collect();
        let limited = LIMITED.map(|(name, _)| name);
        let trivial = TRIVIAL.map(|(name, _)| name);
        let lists = [
            &limited[..],
            &trivial,
            &LOGARITHMS,
            &FORMS,
            &WEIGHTS,
            &OF_SOME_SEEDS,
            &SCATTERED,
            &CHI_SQUARES,
        ];
        for name in lists.concat().into_iter().chain([MEAN_HEIGHT]) {
            assert!(all.contains(&name), "{name}");
        }
    }

    /// Law: Z - 1 = 2 φ χ of a dilute gas (Tonks 1936, second virial coefficient): twice the radius is four times the effect, and 6 % of Z. Control: a
    /// metric without a trivial value.
    #[test]
    fn changes_of_a_ratio_count_from_its_trivial_value() {
        let fraction =
            |name: &str, [before, now]: [f64; 2]| (now - before) / (before - zero_of(name, before));
        assert!((fraction("compressibility_factor", [1.02, 1.08]) - 3.0).abs() < 1e-12);
        assert!(fraction("temperature.final", [1.02, 1.08]) < 0.06);
        // Almost all energy is lost; what is left has doubled.
        assert!((fraction("energy.total_change_relative", [-0.99, -0.98]) - 1.0).abs() < 1e-12);
        assert!(fraction("energy.total_change_relative", [-0.01, -0.02]) > 0.99);
    }
}
