//! Metrics whose values mean something else than an amount, so that equal values show less, or have another distribution.

/// The length of a deposit, which cannot grow beyond the width of its container.
pub(super) const DEPOSIT_LENGTH: &str = "bed.deposit_length";

/// Metrics that a deposit from wall to wall no longer changes: its length, and the growth of its length.
pub(super) const LIMITED: [&str; 2] = [DEPOSIT_LENGTH, "bed.normalized_runout"];

/// Metrics that are logarithms: their zero depends on the unit of the argument.
pub(super) const LOGARITHMS: [&str; 1] = ["h_function"];

/// Ratios that are the same pure number in every gas in equilibrium, whatever its size, density and temperature.
pub(super) const FORMS: [&str; 3] =
    ["fraction_within_half_radius", "mean_speed_over_rms", "pressure.second_half_over_first"];

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
        for name in [&LIMITED[..], &LOGARITHMS, &FORMS, &CHI_SQUARES].concat() {
            assert!(all.contains(&name), "{name}");
        }
    }
}
