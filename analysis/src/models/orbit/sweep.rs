//! Fits and plots of orbit runs along an axis of a sweep.

use super::laws::{self, model_order};
use crate::metric::definition::definitions;
use crate::models::contract::{Fit, FitShape, OrderInKey, Ordinate, TradeOff};

definitions! {
    CONVERGENCE_ORDER: "convergence.order", "1", "least-squares line through the logarithms of position_error.final", [laws::CONVERGENCE], 1e-9;
    ENERGY_CONVERGENCE_ORDER: "energy.convergence_order", "1", "least-squares line through the logarithms of energy.max_error_relative", [laws::ENERGY_CONVERGENCE], 1e-9;
}

const TIME_STEP: &str = "model.orbit.time_step_days";

/// Fits along an axis of a sweep.
pub(crate) const FITS: &[Fit] = &[
    Fit {
        theory: |model| model_order(model, laws::order),
        is_convergence_order: true,
        ..Fit::new(TIME_STEP, "position_error.final", FitShape::PowerLaw, &[CONVERGENCE_ORDER])
    },
    Fit {
        theory: |model| model_order(model, laws::energy_order),
        is_convergence_order: true,
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
        order: Some(OrderInKey { key: TIME_STEP, order: |model| model_order(model, laws::order) }),
        ..Ordinate::new("position_error.final", "position error")
    },
    Ordinate {
        is_power_law: true,
        order: Some(OrderInKey {
            key: TIME_STEP,
            order: |model| model_order(model, laws::energy_order),
        }),
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
