//! Fits and plots of DEM runs along an axis of a sweep.

use super::laws;
use crate::metric::definition::definitions;
use crate::models::contract::{Fit, FitShape, Ordinate};

definitions! {
    BEVERLOO_EXPONENT: "outlet.rate_vs_free_width.exponent", "1", "least-squares line through the logarithms of outlet.rate over outlet.free_width", [laws::BEVERLOO], 0.0;
    RUN_OUT_EXPONENT: "run_out_vs_discs.exponent", "1", "least-squares line through the logarithms of bed.run_out over the number of discs", [laws::RUN_OUT], 0.0;
    SCREENING_WEIGHT: "silo.screening_weight", "N", "Ws of piston.force = Ws (1 - exp(-bed.weight/Ws)), by least squares", [laws::JANSSEN], 0.0;
    JANSSEN_MISFIT: "silo.janssen_misfit", "1", "root of the mean square of piston.force's relative distance from that fit", [laws::JANSSEN], 0.0;
}

/// Fits along an axis of a sweep.
pub const FITS: &[Fit] = &[
    Fit {
        over: Some("outlet.free_width"),
        theory: |_| Some(1.5),
        ..Fit::new("variant", "outlet.rate", FitShape::PowerLaw(BEVERLOO_EXPONENT))
    },
    Fit::new("model.dem.discs", "bed.run_out", FitShape::PowerLaw(RUN_OUT_EXPONENT)),
    Fit {
        over: Some("bed.weight"),
        ..Fit::new(
            "model.dem.discs",
            "piston.force",
            FitShape::Saturation { scale: SCREENING_WEIGHT, misfit: JANSSEN_MISFIT },
        )
    },
];

/// Metrics that are plotted against swept numbers.
pub const ORDINATES: &[Ordinate] = &[
    Ordinate::new("restitution.measured", "restitution"),
    Ordinate {
        is_power_law: true,
        ..Ordinate::new(
            "energy.largest_residual_relative",
            "largest |residual| / energy at the start",
        )
    },
];
