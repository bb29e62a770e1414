//! Starter manifests: every key of a model with its unit and default, commented.

use crate::model::ModelConfig;

/// Returns a commented manifest of a model to begin from: all its keys, at their defaults.
#[must_use]
pub fn starter(model: &str) -> Option<&'static str> {
    ModelConfig::starter(model)
}
