//! Fits and plots of gas runs along an axis of a sweep.

use super::laws::{self, SpeedMoments};
use crate::metric::definition::{Definition, definitions};
use crate::models::contract::{Fit, FitShape, Ordinate};
use kinetoscope_manifest::model::ModelConfig;

definitions! {
    MEASURED_SLOPE: "pressure_vs_temperature.measured.slope", "N/(m K)", "slope of the pressure on the wall over the temperature", "least-squares line of pressure.measured", [laws::PRESSURE_SLOPE], 0.0;
    MEASURED_INTERCEPT: "pressure_vs_temperature.measured.intercept", "N/m", "pressure on the wall extrapolated to zero temperature", "least-squares line of pressure.measured", [laws::PRESSURE_SLOPE], 0.0;
    MEAN_SPEED_SLOPE: "pressure_vs_temperature.mean_speed_formula.slope", "N/(m K)", "slope of the pressure by the mean speed over the temperature", "least-squares line of pressure.mean_speed_formula", [laws::PRESSURE_SLOPE], 0.0;
    MEAN_SPEED_INTERCEPT: "pressure_vs_temperature.mean_speed_formula.intercept", "N/m", "pressure by the mean speed extrapolated to zero temperature", "least-squares line of pressure.mean_speed_formula", [laws::PRESSURE_SLOPE], 0.0;
    MEAN_SQUARE_SLOPE: "pressure_vs_temperature.mean_square_formula.slope", "N/(m K)", "slope of the pressure by the mean square speed over the temperature", "least-squares line of pressure.mean_square_formula", [laws::PRESSURE_SLOPE], 0.0;
    MEAN_SQUARE_INTERCEPT: "pressure_vs_temperature.mean_square_formula.intercept", "N/m", "pressure by the mean square speed extrapolated to zero temperature", "least-squares line of pressure.mean_square_formula", [laws::PRESSURE_SLOPE], 0.0;
    RADIUS_EXPONENT: "pressure_vs_radius.measured.exponent", "1", "exponent of the pressure in the radius", "least-squares line through the logarithms of pressure.measured", [laws::PRESSURE_RADIUS_EXPONENT], 1e-9;
    MEAN_SPEED_EXPONENT: "mean_speed_vs_temperature.exponent", "1", "exponent of the mean speed in the temperature", "least-squares line through the logarithms of mean_speed", [laws::SPEED_EXPONENT], 1e-9;
}

const TEMPERATURE: &str = "model.gas.temperature_k";

/// Fits along an axis of a sweep.
pub(crate) const FITS: &[Fit] = &[
    pressure_line("pressure.measured", &[MEASURED_SLOPE, MEASURED_INTERCEPT], exact_slope),
    pressure_line(
        "pressure.mean_speed_formula",
        &[MEAN_SPEED_SLOPE, MEAN_SPEED_INTERCEPT],
        |model| pressure_slope(model, |moments| moments.mean_m_per_s * moments.mean_m_per_s),
    ),
    pressure_line(
        "pressure.mean_square_formula",
        &[MEAN_SQUARE_SLOPE, MEAN_SQUARE_INTERCEPT],
        exact_slope,
    ),
    Fit {
        theory: |_| Some(-2.0),
        ..Fit::new(
            "model.gas.radius_m",
            "pressure.measured",
            FitShape::PowerLaw,
            &[RADIUS_EXPONENT],
        )
    },
    Fit {
        theory: |_| Some(0.5),
        ..Fit::new(TEMPERATURE, "mean_speed", FitShape::PowerLaw, &[MEAN_SPEED_EXPONENT])
    },
];

/// A line through a pressure over the temperature.
const fn pressure_line(
    of: &'static str,
    parameters: &'static [&'static Definition],
    theory: fn(&ModelConfig) -> Option<f64>,
) -> Fit {
    Fit { theory, ..Fit::new(TEMPERATURE, of, FitShape::Line, parameters) }
}

fn exact_slope(model: &ModelConfig) -> Option<f64> {
    pressure_slope(model, |moments| moments.mean_square_m2_per_s2)
}

/// Metrics that are plotted against swept numbers.
pub(crate) const ORDINATES: &[Ordinate] = &[
    Ordinate {
        companion: Some(("pressure.mean_speed_formula", "N m ⟨v⟩² / (2A)")),
        ..Ordinate::new("pressure.measured", "pressure")
    },
    Ordinate::new("mean_speed", "mean speed"),
    Ordinate::new("compressibility_factor", "compressibility factor"),
];

/// dP/dT of a pressure that is proportional to T.
fn pressure_slope(model: &ModelConfig, square: fn(&SpeedMoments) -> f64) -> Option<f64> {
    let ModelConfig::Gas(config) = model else { return None };
    let temperature = laws::temperature_k(config).filter(|temperature| *temperature > 0.0)?;
    let moments = laws::speed_moments(config)?;
    Some(laws::pressure_n_per_m(config, square(&moments)) / temperature)
}
