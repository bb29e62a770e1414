//! What a test expects of a manifest that breaks a rule, and of one that breaks none.

use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_manifest::{Diagnostics, Experiment, parse};

/// The experiment of a manifest without errors.
pub(crate) fn experiment(text: &str) -> Experiment {
    parse(text, "m.toml", &[]).unwrap_or_else(|errors| panic!("{errors}\n{text}"))
}

/// The errors of a manifest.
pub(crate) fn errors(text: &str) -> Diagnostics {
    parse(text, "m.toml", &[]).err().unwrap_or_else(|| panic!("accepted:\n{text}"))
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
    experiment(text).runs[0].manifest.model.clone()
}
