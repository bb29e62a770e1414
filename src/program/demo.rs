//! `demo`: one experiment from manifest to report.

use crate::manifests::starter::write_new;
use crate::messages::{Failure, bad, concluded};
use crate::program_name::ProgramName;
use crate::running::RunArguments;
use crate::shipped::Shipped;
use clap::{Args, Parser};
use kinetoscope_analysis::cli::AnalyzeArguments;
use kinetoscope_console::text::shown_path;
use kinetoscope_console::{Exit, StandardOutput};
use kinetoscope_files::regular_file::{MAX_MANIFEST_BYTES, read_text};
use std::path::Path;

/// Run the experiment `first_run`, analyze it and open its report: manifest, recording and page stay in this folder.
#[derive(Debug, Args)]
pub(crate) struct DemoArguments {
    /// Print where the report is, and do not open it
    #[arg(long)]
    no_open: bool,
}

/// The experiment.
const NAME: &str = "first_run";

/// The command line of the analysis.
#[derive(Debug, Parser)]
struct Analyze {
    #[command(flatten)]
    arguments: AnalyzeArguments,
}

impl DemoArguments {
    /// Runs, analyzes and opens the report.
    #[must_use]
    pub(crate) fn execute(&self, engine: &'static [u8]) -> Exit {
        self.run(engine).unwrap_or_else(|failure| failure.report())
    }

    fn run(&self, engine: &'static [u8]) -> Result<Exit, Failure> {
        let file = format!("{NAME}.toml");
        write_manifest(Path::new(&file))?;
        let recordings = Path::new("recordings");
        let run = RunArguments::of_manifest(Path::new(&file), recordings, None, None);
        let ran = run.execute(ProgramName::Kinetoscope);
        if ran != Exit::Done {
            return Ok(ran);
        }
        let folder = recordings.join(NAME);
        let mut words = vec!["analyze".into(), folder.clone().into_os_string()];
        if !self.no_open {
            words.push("--open".into());
        }
        let analyze = Analyze::try_parse_from(words).map_err(bad)?;
        let analyzed = analyze.arguments.execute(engine);
        let output = StandardOutput::default();
        output.print(&format!(
            "\nmanifest   {file}\nrecording  {}\nreport     {}\n\nChange the manifest, then:\n  kinetoscope run {file} && kinetoscope analyze {file} --open\n",
            shown_path(&folder.join(format!("{NAME}*.mcap"))),
            shown_path(&folder.join("report.html")),
        ));
        Ok(analyzed.worst(concluded(&output, Exit::Done)))
    }
}

/// Writes the manifest, unless it is there already.
fn write_manifest(file: &Path) -> Result<(), Failure> {
    let manifest = Shipped::named(NAME).map_or("", |shipped| shipped.manifest);
    match read_text(file, MAX_MANIFEST_BYTES) {
        Ok(present) if present == manifest => Ok(()),
        Ok(_) => Err(bad(format!("{} is here with other contents", shown_path(file))).help(
            "run it with `kinetoscope run`, or repeat `kinetoscope demo` in an empty folder",
        )),
        Err(_) => write_new(file, manifest),
    }
}
