//! Fits and plots of orbit runs along an axis of a sweep.

use super::laws;
use crate::metric::definition::definitions;
use crate::models::contract::{AsymptoticRange, Fit, FitShape, OrderInKey, Ordinate, TradeOff};
use kinetoscope_manifest::model::{
    ModelConfig, OrbitConfig, OrbitStart, OrbitState, OrbitSummation,
};

definitions! {
    CONVERGENCE_ORDER: "convergence.order", "1", "order of the position error in the time step", "least-squares line through the logarithms of position_error.final, over the runs in the asymptotic range: phase error up to 0.1 rad, error over 30 times its rounding, and neighboring steps whose orders differ by less than 0.04; at least three", [laws::CONVERGENCE], 1e-9;
    ENERGY_CONVERGENCE_ORDER: "energy.convergence_order", "1", "order of the energy error in the time step", "least-squares line through the logarithms of energy.max_error_relative, over the runs in the asymptotic range as for convergence.order", [laws::ENERGY_CONVERGENCE], 1e-9;
}

const TIME_STEP: &str = "model.orbit.time_step_days";
const PHASE_ERROR: &str = "phase_error.final";

/// Rounding error of the relative energy: that of one step, which the steps add at random unless the sums are compensated.
fn energy_rounding(model: &ModelConfig, end_days: f64) -> f64 {
    match model {
        ModelConfig::Orbit(config) if config.summation == OrbitSummation::Plain => {
            f64::EPSILON * (end_days / config.time_step_days.get()).sqrt()
        }
        _ => f64::EPSILON,
    }
}

/// Rounding error of the position, AU: an energy error changes the phase in proportion to the time.
fn position_rounding(model: &ModelConfig, end_days: f64) -> f64 {
    let distance = match model {
        ModelConfig::Orbit(OrbitConfig { start: OrbitStart::Given(start), .. }) => match start {
            OrbitState::Vectors { position_au, .. } => {
                laws::norm(position_au.map(|component| component.get()))
            }
            OrbitState::Elements { semi_major_axis_au, .. } => semi_major_axis_au.get(),
        },
        _ => 1.0,
    };
    let mean_motion = (laws::GM_SUN_AU3_PER_DAY2 / (distance * distance * distance)).sqrt();
    energy_rounding(model, end_days) * distance * (1.0 + mean_motion * end_days)
}

/// Fits along an axis of a sweep.
pub(crate) const FITS: &[Fit] = &[
    Fit {
        theory: laws::position_order,
        asymptotic_range: Some(AsymptoticRange {
            phase_error: PHASE_ERROR,
            rounding: position_rounding,
        }),
        ..Fit::new(TIME_STEP, "position_error.final", FitShape::PowerLaw, &[CONVERGENCE_ORDER])
    },
    Fit {
        theory: laws::energy_order,
        asymptotic_range: Some(AsymptoticRange {
            phase_error: PHASE_ERROR,
            rounding: energy_rounding,
        }),
        ..Fit::new(
            TIME_STEP,
            "energy.max_error_relative",
            FitShape::PowerLaw,
            &[ENERGY_CONVERGENCE_ORDER],
        )
    },
];

/// Metrics that are plotted against swept numbers.
pub(crate) const ORDINATES: &[Ordinate] = &[
    Ordinate {
        is_power_law: true,
        order: Some(OrderInKey { key: TIME_STEP, order: laws::position_order }),
        ..Ordinate::new("position_error.final", "position error")
    },
    Ordinate {
        is_power_law: true,
        order: Some(OrderInKey { key: TIME_STEP, order: laws::energy_order }),
        ..Ordinate::new("energy.max_error_relative", "largest |E − E₀| / |E₀|")
    },
];

/// Pairs of metrics that are plotted against each other.
pub(crate) const TRADE_OFFS: &[TradeOff] = &[TradeOff {
    stem: "position_error_vs_cost",
    title: "Cost against error",
    x: ("force_evaluations", "force evaluations", ""),
    y: ("position_error.final", "position error", "AU"),
    keys: &[TIME_STEP, "model.orbit.tolerance"],
}];
