//! When two runs that differ are unrelated: as recorded, and as their Lyapunov exponent predicts.

use kinetoscope::run::recording;
use kinetoscope::verify::divergence::{Divergence, UNRELATED};
use kinetoscope_analysis::analyze;
use std::path::Path;

/// What is known of the time from which on two runs are unrelated. The exponent is that of the first recording which has one.
pub(super) fn lines(divergence: &Divergence, paths: [&Path; 2], unit: &str) -> Vec<String> {
    let (since, separation) = divergence.first();
    let observed = divergence.unrelated.map(|time| {
        format!("unrelated, with a separation above {UNRELATED}, from time {time:?}{unit} on")
    });
    let predicted = paths.into_iter().find_map(exponent).map(|found| match found {
        Exponent { value, error, is_chaotic: true } => {
            let time = since + libm::log(UNRELATED / separation) / value;
            format!(
                "predicted by lyapunov.exponent, {value:.3e} ± {error:.1e}: unrelated from time {time:.3e}{unit} on"
            )
        }
        Exponent { value, error, .. } => format!(
            "lyapunov.exponent, {value:.1e} ± {error:.1e}, is compatible with 0: the separation does not grow exponentially"
        ),
    });
    observed
        .into_iter()
        .chain(predicted.filter(|_| separation > 0.0 && separation < UNRELATED))
        .collect()
}

struct Exponent {
    value: f64,
    error: f64,
    is_chaotic: bool,
}

/// The exponent of a run that recorded what it follows from.
fn exponent(path: &Path) -> Option<Exponent> {
    let recording = recording::open(path).ok()?;
    let manifest = kinetoscope_manifest::parse_run(recording.manifest()).ok()?;
    let mut channels = manifest.record.channels.iter().flatten();
    channels.find(|name| ["events", "divergence"].contains(&name.as_str()))?;
    let run = analyze(&recording).ok()?;
    let found = run.measurement("lyapunov.exponent")?.estimate;
    let error = found.conditional_standard_error.or(found.standard_error)?;
    let is_chaotic = run.measurement("lyapunov.divergence_time").is_some();
    Some(Exponent { value: found.value, error, is_chaotic })
}
