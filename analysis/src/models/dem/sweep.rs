//! Fits and plots of DEM runs along an axis of a sweep.

use super::laws;
use crate::metric::definition::definitions;
use crate::models::contract::{Fit, FitShape, Ordinate};

definitions! {
    DISCHARGE_RATE_EXPONENT: "outlet.discharge_rate_vs_effective_width.exponent", "1", "exponent of the discharge rate in the orifice's effective width", "least-squares line through the logarithms of outlet.discharge_rate over outlet.effective_width", [laws::BEVERLOO], 0.0;
    RUNOUT_EXPONENT: "normalized_runout_vs_discs.exponent", "1", "exponent of the runout in the number of discs", "least-squares line through the logarithms of bed.normalized_runout over the number of discs", [laws::RUNOUT], 0.0;
    SATURATION_WEIGHT: "silo.saturation_weight", "N", "greatest weight that the floor can carry", "F_s of piston.force = F_s (1 - exp(-bed.weight/F_s)), by least squares", [laws::JANSSEN], 0.0;
    JANSSEN_DEVIATION: "silo.janssen_rms_deviation", "1", "typical deviation from Janssen's law", "root of the mean square of piston.force's relative distance from that fit", [laws::JANSSEN], 0.0;
}

const DISCS: &str = "model.dem.discs";

/// Fits along an axis of a sweep.
pub(crate) const FITS: &[Fit] = &[
    Fit {
        over: Some("outlet.effective_width"),
        theory: |_| Some(1.5),
        ..Fit::new(
            "variant",
            "outlet.discharge_rate",
            FitShape::PowerLaw,
            &[DISCHARGE_RATE_EXPONENT],
        )
    },
    Fit::new(DISCS, "bed.normalized_runout", FitShape::PowerLaw, &[RUNOUT_EXPONENT]),
    Fit {
        over: Some("bed.weight"),
        ..Fit::new(
            DISCS,
            "piston.force",
            FitShape::Saturation,
            &[SATURATION_WEIGHT, JANSSEN_DEVIATION],
        )
    },
];

/// Metrics that are plotted against swept numbers.
pub(crate) const ORDINATES: &[Ordinate] = &[
    Ordinate::new("restitution.measured", "restitution"),
    Ordinate {
        is_power_law: true,
        ..Ordinate::new(
            "energy.max_residual_relative",
            "largest |residual| / (initial + inserted energy)",
        )
    },
];
