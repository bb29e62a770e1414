//! What a test expects of a manifest that breaks a rule, and of one that breaks none.

use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_manifest::{Diagnostics, Experiment, Lookup, parse_with};

/// Some metrics; only the analysis, which this package does not know, has the list of all.
pub(crate) fn metrics(model: &str) -> Vec<&'static str> {
    match model {
        "dem" => vec!["bed.height", "energy.residual_relative"],
        "gas" => vec!["a2", "mean_speed", "pressure.ideal_gas", "pressure.measured"],
        _ => Vec::new(),
    }
}

/// Reads a manifest that may name these metrics.
fn read(text: &str) -> Result<Experiment, Diagnostics> {
    let lookup = Lookup { metrics: Some(metrics), ..Lookup::default() };
    parse_with(text, "m.toml", &[], lookup)
}

/// The experiment of a manifest without errors.
pub(crate) fn experiment(text: &str) -> Experiment {
    read(text).unwrap_or_else(|errors| panic!("{errors}\n{text}"))
}

/// The errors of a manifest.
pub(crate) fn errors(text: &str) -> Diagnostics {
    read(text).err().unwrap_or_else(|| panic!("accepted:\n{text}"))
}

/// Expects exactly one error, which contains the message, at the line of `<-`.
pub(crate) fn rejected(text: &str, message: &str) {
    let line = 1 + text.lines().position(|line| line.contains("# <-")).unwrap_or(0);
    let errors = errors(text);
    let rendered = errors.to_string();
    assert!(rendered.contains(message), "wanted: {message}\n{rendered}");
    assert_eq!(errors.len(), 1, "{rendered}");
    if text.contains("# <-") {
        assert!(
            rendered.contains(&format!("--> m.toml:{line}:")),
            "expected line {line}\n{rendered}"
        );
    }
}

/// Expects no error, and returns the model of the first run.
pub(crate) fn accepted(text: &str) -> ModelConfig {
    (*experiment(text).runs[0].manifest.model).clone()
}
