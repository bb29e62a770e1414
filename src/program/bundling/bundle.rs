//! `bundle`: writes an experiment and its results into one file.

use super::archive::{ArchiveError, write};
use super::contents::{Claims, files, finished_time};
use super::description::{Description, Named};
use super::program::program;
use super::starts::starts;
use crate::engine::ENGINE;
use crate::locking::locked_runs::{Parallel, Reruns};
use crate::messages::exit::of_output;
use crate::messages::progress::size;
use crate::messages::result_arguments::ResultArguments;
use crate::messages::{Failure, bad, plural, word};
use clap::Args;
use kinetoscope_console::Exit;
use kinetoscope_console::text::shown_path;
use kinetoscope_files::output_file;
use serde_json::json;
use std::fs;
use std::path::PathBuf;

/// Write an experiment with its results into one ZIP file, which anyone can rerun with `reproduce`
///
/// The file contains the manifest, the hashes of all messages, the metrics, plots and report, and descriptions for archives
/// (RO-Crate, Citation File Format, Zenodo, CodeMeta). The same recordings give the same bytes.
#[derive(Debug, Args)]
pub(crate) struct BundleArguments {
    /// Manifest of the experiment
    #[arg(value_name = "MANIFEST")]
    manifest: PathBuf,
    /// An author of the results: "NAME", or "NAME <https://orcid.org/…>"; can be repeated
    #[arg(long, required = true, value_name = "AUTHOR")]
    author: Vec<String>,
    /// The authors' organization: "NAME", or "NAME <https://…>"
    #[arg(long, value_name = "NAME")]
    affiliation: Option<String>,
    /// The license of the results, as an SPDX identifier such as CC-BY-4.0
    #[arg(long, value_name = "LICENSE")]
    license: String,
    /// Include the recordings
    #[arg(long)]
    recordings: bool,
    /// Folder of the recordings, which are in DIR/NAME
    #[arg(long, value_name = "DIR", default_value = "recordings")]
    output: PathBuf,
    /// The bundle [default: NAME.zip]
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
    /// The wheel that contains this program: its hash and its list of packages (CycloneDX) are included
    #[arg(long, value_name = "FILE")]
    wheel: Option<PathBuf>,
    #[command(flatten)]
    parallel: Parallel,
    #[command(flatten)]
    result: ResultArguments,
}

impl BundleArguments {
    /// Writes the bundle. Runs that are not recorded are executed first, and all are analyzed.
    #[must_use]
    pub(crate) fn execute(&self) -> Exit {
        self.result.concluded(self.bundle().unwrap_or_else(|failure| self.result.failed(&failure)))
    }

    fn bundle(&self) -> Result<Exit, Failure> {
        let description = self.description()?;
        let (program, packages) = program(self.wheel.as_deref())?;
        // A file that cannot be bundled is reported before the runs.
        if self.manifest.is_file() {
            starts(&self.manifest)?;
        }
        let rerun =
            Reruns::recorded(self.output.clone(), self.parallel)?.execute(&self.manifest)?;
        let name = rerun.experiment.name.as_str();
        let file = self.file.clone().unwrap_or_else(|| PathBuf::from(format!("{name}.zip")));
        let unwritten = |error: &std::io::Error| {
            let what = format!("cannot write {}: {error}", shown_path(&file));
            Failure::new(of_output(error), what).help("name another file with --file")
        };
        output_file::check(&file).map_err(|error| unwritten(&error))?;
        let claims = Claims {
            description,
            program,
            packages,
            engine: ENGINE,
            finished: finished_time(&rerun),
            with_recordings: self.recordings,
        };
        let files = files(&self.manifest, &rerun, &claims)?;
        write(&file, &files).map_err(|error| match error {
            ArchiveError::Io(error) => unwritten(&error),
            ArchiveError::Damaged(what) => {
                bad(what).help("choose another `name` in the manifest, or leave --recordings out")
            }
        })?;
        let bytes = fs::metadata(&file).map_or(0, |metadata| metadata.len());
        let count = plural(files.len() as u64 + 1, "file");
        let text = format!("{}: {count}, {}", shown_path(&file), size(bytes));
        self.result.print(
            &text,
            || json!({ "exit_code": 0, "file": file, "bytes": bytes, "files": files.len() + 1 }),
        );
        self.result.say_commands(&format!(
            "\nNext, on any machine:\n  kinetoscope reproduce {}",
            word(&file.to_string_lossy())
        ));
        Ok(Exit::Done)
    }

    fn description(&self) -> Result<Description, Failure> {
        let description = Description {
            authors: self
                .author
                .iter()
                .map(|author| Named::parse(author))
                .collect::<Result<_, _>>()?,
            affiliation: self.affiliation.as_deref().map(Named::parse).transpose()?,
            license: self.license.clone(),
        };
        description.reject_incomplete()?;
        Ok(description)
    }
}
