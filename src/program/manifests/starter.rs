//! `new` prints a starter manifest, and `schema` the JSON Schema of manifests.

use crate::messages::print_exactly;
use clap::Args;
use kinetoscope_console::Exit;
use kinetoscope_manifest::model::ModelConfig;

/// Print a commented starter manifest: keys of the model with unit and default.
#[derive(Debug, Args)]
pub(crate) struct NewArguments {
    /// The model of the experiment
    #[arg(value_name = "MODEL", value_parser = ModelConfig::NAMES)]
    model: String,
}

impl NewArguments {
    /// Prints the manifest.
    #[must_use]
    pub(crate) fn execute(&self) -> Exit {
        kinetoscope_manifest::starter(&self.model).map_or(Exit::BadInput, print_exactly)
    }
}

/// Prints the JSON Schema of manifests.
#[must_use]
pub(crate) fn print_schema() -> Exit {
    print_exactly(&kinetoscope_manifest::json_schema())
}
