//! One manifest of a pipeline of experiments.

use kinetoscope_manifest::Override;
use std::path::PathBuf;

/// One manifest of a pipeline.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Step {
    /// The manifest.
    pub(crate) manifest: PathBuf,
    /// Whether the command line names it; otherwise another manifest starts from it.
    pub(crate) is_named: bool,
    /// The manifests that it starts from.
    pub(crate) starts_from: Vec<PathBuf>,
}

impl Step {
    /// The overrides of its manifest: those of the command line belong to the manifests that it names.
    pub(crate) fn overrides<'a>(&self, overrides: &'a [Override]) -> &'a [Override] {
        if self.is_named { overrides } else { &[] }
    }
}
