//! `benchmark`: the time of each run without recording, as a table.

use crate::comparison::rerun::{listen, stop_if_interrupted};
use crate::manifests::pipeline;
use crate::manifests::{ManifestArguments, ManifestReader};
use crate::messages::exit;
use crate::messages::result_arguments::ResultArguments;
use crate::messages::{Failure, bad};
use clap::Args;
use kinetoscope::outputs::sidecars;
use kinetoscope::run::benchmark::{self, TimingError, time_table};
use kinetoscope_console::Exit;
use kinetoscope_console::Explained as _;
use kinetoscope_console::text::shown_path;
use kinetoscope_files::output_file::check_results_folder;
use kinetoscope_manifest::TimingTable;
use kinetoscope_object_storage::address::Address;
use serde_json::Value as Json;
use std::io;
use std::path::{Path, PathBuf};

/// Measure the time of every run, one at a time and without recording, and print a table.
#[derive(Debug, Args)]
pub(crate) struct BenchmarkArguments {
    /// Manifest (TOML file)
    #[arg(value_name = "MANIFEST")]
    path: PathBuf,
    #[command(flatten)]
    manifest: ManifestArguments,
    /// Write the table to DIR/NAME/timing.json as well; the report of the recordings there shows it
    #[arg(long, short, value_name = "DIR", help_heading = "Output")]
    output: Option<PathBuf>,
    #[command(flatten)]
    result: ResultArguments,
}

impl BenchmarkArguments {
    /// Measures, prints and writes the table.
    #[must_use]
    pub(crate) fn execute(&self) -> Exit {
        self.result.concluded(self.measure().unwrap_or_else(|failure| self.result.failed(&failure)))
    }

    fn measure(&self) -> Result<Exit, Failure> {
        if let Some(output) = self.output.as_deref().filter(|output| Address::is_one(output)) {
            return Err(bad(format!("the table cannot be written to {}", shown_path(output)))
                .help("name a local folder with --output DIR"));
        }
        let interrupt = listen()?;
        let overrides = self.manifest.overrides()?;
        let output = self.output.clone().unwrap_or_else(|| PathBuf::from("recordings"));
        let reader = ManifestReader::new(output, None);
        pipeline::order(std::slice::from_ref(&self.path), &overrides, &reader)?;
        let experiment = reader.read(&self.path, &overrides)?;
        if let Some(folder) = &self.output {
            let results = folder.join(&experiment.name);
            check_results_folder(&results).map_err(|error| unwritten(folder, &error))?;
        }
        let table = time_table(&experiment, &interrupt);
        stop_if_interrupted(&interrupt)?;
        let table = table.map_err(|error| {
            let exit = match error {
                TimingError::Setup(_) => Exit::BadInput,
                TimingError::Fault(_) => Exit::RunFailed,
            };
            Failure::of(exit, error.message())
        })?;
        self.result.print(benchmark::text(&table).trim_end(), || json(&table));
        let Some(folder) = &self.output else { return Ok(Exit::Done) };
        let path =
            sidecars::write_timing(folder, &table).map_err(|error| unwritten(folder, &error))?;
        self.result.say(&format!("Wrote {}", shown_path(&path)));
        Ok(Exit::Done)
    }
}

fn unwritten(folder: &Path, error: &io::Error) -> Failure {
    let what = format!("the table cannot be written to {}: {error}", shown_path(folder));
    Failure::new(exit::of_output(error), what)
        .help("make the folder writable, or name another one with --output DIR")
}

fn json(table: &TimingTable) -> Json {
    serde_json::to_value(table).unwrap_or_default()
}
