//! Program `kinetoscope`: every subcommand. `run-experiment` is its `run`, `analyze-recordings` its `analyze`.

mod view;

use clap::{CommandFactory as _, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use kinetoscope::Recording;
use kinetoscope::cli::analysis::Analysis;
use kinetoscope::cli::benchmark::BenchmarkArguments;
use kinetoscope::cli::check::CheckArguments;
use kinetoscope::cli::doctor::DoctorArguments;
use kinetoscope::cli::exit::{Exit, OF_RUN, exit_codes};
use kinetoscope::cli::info::InfoArguments;
use kinetoscope::cli::inspect::{CompareArguments, VerifyArguments};
use kinetoscope::cli::lock::LockArguments;
use kinetoscope::cli::messages::Failure;
use kinetoscope::cli::rerun::Metrics;
use kinetoscope::cli::restore::{FillArguments, ZoomArguments};
use kinetoscope::cli::run::RunArguments;
use kinetoscope::cli::starter::{NewArguments, print_schema};
use kinetoscope::cli::why::WhyArguments;
use kinetoscope::cli::{Program, messages};
use kinetoscope_analysis::cli::{
    self as analysis, AnalyzeArguments, ExportArguments, PlotArguments,
};
use kinetoscope_console::text::shown_path;
use kinetoscope_console::{Ended, with_nearest_subcommand};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use view::ViewArguments;

/// Reproducible particle experiments: a manifest in, recordings and checked physics out.
#[derive(Debug, Parser)]
#[command(name = "kinetoscope", version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
#[command(subcommand_help_heading = "Subcommands", disable_help_subcommand = true)]
enum Command {
    #[command(after_help = exit_codes(OF_RUN))]
    Run(RunArguments),
    #[command(after_help = exit_codes(&[]))]
    New(NewArguments),
    #[command(after_help = exit_codes(&[1, 4, 5, 129, 130, 143]))]
    Check(CheckArguments),
    #[command(after_help = exit_codes(&[1, 4, 5, 129, 130, 143]))]
    Lock(LockArguments),
    #[command(after_help = exit_codes(&[1, 4, 5, 129, 130, 143]))]
    Verify(VerifyArguments),
    #[command(after_help = exit_codes(&[4, 5]))]
    Compare(CompareArguments),
    #[command(after_help = exit_codes(&[1, 4, 5, 129, 130, 143]))]
    Fill(FillArguments),
    #[command(after_help = exit_codes(&[1, 4, 5, 129, 130, 143]))]
    Zoom(ZoomArguments),
    #[command(after_help = exit_codes(&[1]))]
    Why(WhyArguments),
    #[command(after_help = exit_codes(&[5]))]
    Info(InfoArguments),
    #[command(after_help = exit_codes(&[1]))]
    Benchmark(BenchmarkArguments),
    #[command(after_help = analysis::EXIT_CODES)]
    Analyze(AnalyzeArguments),
    #[command(after_help = exit_codes(&[5]))]
    Export(ExportArguments),
    #[command(after_help = exit_codes(&[5]))]
    Plot(PlotArguments),
    #[command(after_help = exit_codes(&[5, 130, 143]))]
    View(ViewArguments),
    /// Print the JSON Schema of manifests, for editors
    #[command(after_help = exit_codes(&[]))]
    Schema,
    /// Print the completions of a program for a shell
    #[command(after_help = exit_codes(&[]))]
    Completions {
        /// The shell
        shell: Shell,
        /// The program
        #[arg(value_enum, default_value_t = ProgramName::Kinetoscope)]
        program: ProgramName,
    },
    /// Write the manual pages into a folder, for packages of distributions
    #[command(after_help = exit_codes(&[]))]
    ManPages {
        /// The folder
        folder: PathBuf,
    },
    #[command(
        after_help = "Exit codes:\n  0    no problem\n  1    a problem was found; its remedy is printed\n  2    bad arguments\n  70   an internal error, or not enough memory\n  75   the output cannot be written"
    )]
    Doctor(DoctorArguments),
}

/// A program with completions.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum ProgramName {
    Kinetoscope,
    RunExperiment,
    AnalyzeRecordings,
}

impl ProgramName {
    /// The arguments. Those of the two other programs are those of a subcommand each.
    fn command(self) -> clap::Command {
        let kinetoscope = Arguments::command();
        let (name, subcommand) = match self {
            Self::Kinetoscope => return kinetoscope,
            Self::RunExperiment => ("run-experiment", "run"),
            Self::AnalyzeRecordings => ("analyze-recordings", "analyze"),
        };
        let found = kinetoscope.get_subcommands().find(|command| command.get_name() == subcommand);
        found.cloned().unwrap_or_default().name(name).version(env!("CARGO_PKG_VERSION"))
    }
}

/// The analysis, as a library.
struct LinkedAnalysis;

impl Analysis for LinkedAnalysis {
    fn cache(&self, recordings: &[PathBuf]) -> Result<(), String> {
        analysis::cache(recordings)
    }
}

impl Metrics for LinkedAnalysis {
    fn of(&self, recording: &Recording) -> Result<Vec<(String, f64)>, String> {
        let analysis =
            kinetoscope_analysis::analyze(recording).map_err(|error| error.to_string())?;
        let with_value = analysis.measurements.iter().filter(|found| found.reason.is_none());
        Ok(with_value.map(|found| (found.name().to_owned(), found.estimate.value)).collect())
    }
}

/// The optional features, and whether this program was built with them.
const FEATURES: [(&str, bool); 2] =
    [("object-storage", cfg!(feature = "object-storage")), ("parquet", cfg!(feature = "parquet"))];

fn main() -> ExitCode {
    kinetoscope_console::catch_internal_errors(execute)
}

/// Parses the arguments and executes the subcommand.
fn execute() -> ExitCode {
    kinetoscope::cli::allocator::keep_little();
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            let error = with_nearest_subcommand(error, &Arguments::command());
            return match kinetoscope_console::report(&error, &called()) {
                Ended::Answered => Exit::Done,
                Ended::Rejected => Exit::BadManifest,
                Ended::Unwritten => Exit::Retryable,
            }
            .into();
        }
    };
    let program = Program::kinetoscope(&LinkedAnalysis);
    match &arguments.command {
        Command::Run(arguments) => arguments.execute(&program).into(),
        Command::New(arguments) => arguments.execute().into(),
        Command::Check(arguments) => arguments.execute(&program, &LinkedAnalysis).into(),
        Command::Lock(arguments) => arguments.execute(&program, &LinkedAnalysis).into(),
        Command::Verify(arguments) => arguments.execute().into(),
        Command::Compare(arguments) => arguments.execute().into(),
        Command::Fill(arguments) => arguments.execute().into(),
        Command::Zoom(arguments) => arguments.execute().into(),
        Command::Why(arguments) => arguments.execute().into(),
        Command::Info(arguments) => arguments.execute().into(),
        Command::Benchmark(arguments) => arguments.execute().into(),
        Command::Analyze(arguments) => ExitCode::from(arguments.execute() as u8),
        Command::Export(arguments) => ExitCode::from(arguments.execute() as u8),
        Command::Plot(arguments) => ExitCode::from(arguments.execute() as u8),
        Command::View(arguments) => arguments.execute().into(),
        Command::Schema => print_schema().into(),
        Command::Completions { shell, program } => print_completions(*shell, *program).into(),
        Command::ManPages { folder } => write_man_pages(folder).into(),
        Command::Doctor(arguments) => arguments.execute(&FEATURES).into(),
    }
}

/// The program with the subcommand that was called, for the help of an error.
fn called() -> String {
    let command = Arguments::command();
    let subcommand = std::env::args().nth(1).filter(|name| command.find_subcommand(name).is_some());
    subcommand.map_or_else(|| "kinetoscope".to_owned(), |name| format!("kinetoscope {name}"))
}

/// Prints completions; the generator itself would panic at a closed pipe.
fn print_completions(shell: Shell, program: ProgramName) -> Exit {
    let (mut text, mut command) = (Vec::new(), program.command());
    let name = command.get_name().to_owned();
    clap_complete::generate(shell, &mut command, name, &mut text);
    messages::print_exactly(String::from_utf8_lossy(&text).trim_end())
}

/// Writes the pages `kinetoscope.1`, `kinetoscope-run.1` and so on.
fn write_man_pages(folder: &Path) -> Exit {
    let written = std::fs::create_dir_all(folder)
        .and_then(|()| clap_mangen::generate_to(Arguments::command(), folder));
    match written {
        Ok(()) => Exit::Done,
        Err(error) => {
            let what = format!("cannot write the manual pages to {}: {error}", shown_path(folder));
            Failure::new(Exit::of_output(&error), what).help("name another folder").report()
        }
    }
}
