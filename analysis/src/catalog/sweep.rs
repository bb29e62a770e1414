//! What is fitted along an axis of a sweep, a replicate at a time; the error is that of the mean over replicates.

use super::definitions;
use crate::laws::{dem, gas, orbit};

definitions! {
    MEASURED_SLOPE: "pressure_vs_temperature.measured.slope", "N/(m K)", "least-squares line of pressure.measured", [gas::PRESSURE_SLOPE], 0.0;
    MEASURED_INTERCEPT: "pressure_vs_temperature.measured.intercept", "N/m", "least-squares line of pressure.measured", [gas::PRESSURE_SLOPE], 0.0;
    MEAN_SPEED_SLOPE: "pressure_vs_temperature.mean_speed_formula.slope", "N/(m K)", "least-squares line of pressure.mean_speed_formula", [gas::PRESSURE_SLOPE], 0.0;
    MEAN_SPEED_INTERCEPT: "pressure_vs_temperature.mean_speed_formula.intercept", "N/m", "least-squares line of pressure.mean_speed_formula", [gas::PRESSURE_SLOPE], 0.0;
    MEAN_SQUARE_SLOPE: "pressure_vs_temperature.mean_square_formula.slope", "N/(m K)", "least-squares line of pressure.mean_square_formula", [gas::PRESSURE_SLOPE], 0.0;
    MEAN_SQUARE_INTERCEPT: "pressure_vs_temperature.mean_square_formula.intercept", "N/m", "least-squares line of pressure.mean_square_formula", [gas::PRESSURE_SLOPE], 0.0;
    PRESSURE_RADIUS_EXPONENT: "pressure_vs_radius.measured.exponent", "1", "least-squares line through the logarithms of pressure.measured", [gas::PRESSURE_RADIUS_EXPONENT], 1e-9;
    MEAN_SPEED_EXPONENT: "mean_speed_vs_temperature.exponent", "1", "least-squares line through the logarithms of mean_speed", [gas::SPEED_EXPONENT], 1e-9;
    CONVERGENCE_ORDER: "convergence.order", "1", "least-squares line through the logarithms of position_error.final", [orbit::CONVERGENCE], 1e-9;
    BEVERLOO_EXPONENT: "outlet.rate_vs_free_width.exponent", "1", "least-squares line through the logarithms of outlet.rate over outlet.free_width", [dem::BEVERLOO], 0.0;
    RUN_OUT_EXPONENT: "run_out_vs_discs.exponent", "1", "least-squares line through the logarithms of bed.run_out over the number of discs", [dem::RUN_OUT], 0.0;
    SCREENING_WEIGHT: "silo.screening_weight", "N", "Ws of piston.force = Ws (1 - exp(-bed.weight/Ws)), by least squares", [dem::JANSSEN], 0.0;
    JANSSEN_MISFIT: "silo.janssen_misfit", "1", "root of the mean square of piston.force's relative distance from that fit", [dem::JANSSEN], 0.0;
    ENERGY_CONVERGENCE_ORDER: "energy.convergence_order", "1", "least-squares line through the logarithms of energy.largest_error_relative", [orbit::ENERGY_CONVERGENCE], 1e-9;
}
