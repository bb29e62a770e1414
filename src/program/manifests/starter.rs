//! `new` prints a manifest to begin from or writes it to a file, and `schema` prints the JSON Schema of manifests.

use crate::messages::exit::of_output;
use crate::messages::{Failure, bad, concluded, print_exactly};
use crate::shipped::{SHIPPED, Shipped};
use clap::Args;
use kinetoscope_console::text::{plural, shown_path};
use kinetoscope_console::{Exit, StandardOutput};
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_manifest::{experiment_name, nearest};
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// Print a manifest to begin from: a commented starter with keys of the model, unit and default, or an experiment that the program carries.
#[derive(Debug, Args)]
pub(crate) struct NewArguments {
    /// A model for its starter (dem, gas, packing, orbit), or an experiment that --list names
    #[arg(value_name = "NAME", required_unless_present_any = ["list", "all"])]
    name: Option<String>,
    /// Print the names of the experiments that the program carries, each with its question, and stop
    #[arg(long, exclusive = true)]
    list: bool,
    /// Write all these experiments to a folder, and stop
    #[arg(long, value_name = "DIR", exclusive = true)]
    all: Option<PathBuf>,
    /// Write the manifest to a new file
    #[arg(long, short, value_name = "FILE", requires = "name")]
    output: Option<PathBuf>,
}

impl NewArguments {
    /// Prints or writes the manifest.
    #[must_use]
    pub(crate) fn execute(&self) -> Exit {
        match (&self.all, &self.name) {
            (Some(folder), _) => write_all(folder).unwrap_or_else(|failure| failure.report()),
            (None, Some(name)) => self.write_one(name).unwrap_or_else(|failure| failure.report()),
            (None, None) => list(),
        }
    }

    fn write_one(&self, name: &str) -> Result<Exit, Failure> {
        let manifest = manifest_of(name)?;
        match &self.output {
            None => Ok(print_exactly(manifest.trim_end())),
            Some(file) if experiment_name(manifest, file).is_none() => {
                let what = format!("the name of {} cannot name an experiment", shown_path(file));
                Err(bad(what).help("use letters, digits, _ and - only, such as my_gas.toml"))
            }
            Some(file) => write_new(file, manifest).map(|()| said(&next(file))),
        }
    }
}

/// The starter of a model, or the experiment of a name.
fn manifest_of(name: &str) -> Result<&'static str, Failure> {
    let shipped = || Shipped::named(name).map(|shipped| shipped.manifest);
    kinetoscope_manifest::starter(name).or_else(shipped).ok_or_else(|| {
        let known = SHIPPED.iter().map(|shipped| shipped.name).chain(ModelConfig::NAMES);
        let failure = bad(format!("there is no model and no experiment {name:?}"));
        match nearest(name, known) {
            Some(near) => failure.help(format!("did you mean `{near}`?")),
            None => failure.help(
                "the models are dem, gas, packing and orbit; `kinetoscope new --list` lists the experiments",
            ),
        }
    })
}

/// Writes a manifest to a file that does not exist yet.
pub(crate) fn write_new(file: &Path, manifest: &str) -> Result<(), Failure> {
    let written = File::create_new(file).and_then(|mut to| to.write_all(manifest.as_bytes()));
    written.map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => bad(format!("{} exists already", shown_path(file)))
            .help("name another file, or remove this one"),
        _ => not_written(file, &error),
    })
}

fn not_written(path: &Path, error: &io::Error) -> Failure {
    let what = format!("cannot write {}: {error}", shown_path(path));
    Failure::new(of_output(error), what).help("name another place")
}

/// Writes every experiment; files that exist stay as they are.
fn write_all(folder: &Path) -> Result<Exit, Failure> {
    fs::create_dir_all(folder).map_err(|error| not_written(folder, &error))?;
    let (mut written, mut kept) = (0, 0);
    for shipped in SHIPPED {
        let file = folder.join(format!("{}.toml", shipped.name));
        if file.exists() {
            kept += 1;
            continue;
        }
        write_new(&file, shipped.manifest)?;
        written += 1;
    }
    let mut line = format!("written: {} to {}", plural(written, "manifest"), shown_path(folder));
    if kept > 0 {
        line += &format!("; {} existed already and stayed as they were", plural(kept, "file"));
    }
    Ok(said(&line))
}

/// Prints the experiments with their questions.
fn list() -> Exit {
    let width = SHIPPED.iter().map(|shipped| shipped.name.len()).max().unwrap_or(0);
    let lines =
        SHIPPED.iter().map(|shipped| format!("{:width$}  {}", shipped.name, shipped.question()));
    print_exactly(&lines.collect::<Vec<_>>().join("\n"))
}

/// The command that runs a manifest.
fn next(file: &Path) -> String {
    format!(
        "written: {}\n\nNext:\n  kinetoscope run {}",
        shown_path(file),
        crate::messages::word(&file.to_string_lossy())
    )
}

fn said(text: &str) -> Exit {
    let output = StandardOutput::default();
    output.print(&format!("{text}\n"));
    concluded(&output, Exit::Done)
}

/// Prints the JSON Schema of manifests.
#[must_use]
pub(crate) fn print_schema() -> Exit {
    print_exactly(&kinetoscope_manifest::json_schema())
}
