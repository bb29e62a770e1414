//! The program under its three names: `kinetoscope` with every subcommand, `run-experiment` for its `run`, and `analyze-recordings`
//! for its `analyze`. Arguments in, text and an exit code out.
//!
//! Start reading at `running`. Invariant: every other package returns values; only this one prints results.

mod allocator;
mod benchmark;
mod bundling;
mod check;
mod comparison;
mod demo;
mod doctor;
mod engine;
mod executor;
mod grading;
mod info;
mod locking;
mod manifests;
mod messages;
mod named_recordings;
mod output;
mod planning;
mod program_name;
mod running;
mod shipped;
mod view;
mod why;

use allocator::start_threads_for;
use benchmark::BenchmarkArguments;
use bundling::bundle::BundleArguments;
use bundling::reproduce::ReproduceArguments;
use check::CheckArguments;
use clap::{CommandFactory as _, Parser, Subcommand};
use clap_complete::Shell;
use comparison::fill_and_zoom::{FillArguments, ZoomArguments};
use comparison::restore::RestoreArguments;
use comparison::verify_and_compare::{CompareArguments, VerifyArguments};
use demo::DemoArguments;
use doctor::DoctorArguments;
use engine::ENGINE;
use grading::GradeArguments;
use info::InfoArguments;
use kinetoscope_analysis::cli::{
    self as analysis, AnalyzeArguments, ExportArguments, PlotArguments, TableArguments,
};
use kinetoscope_console::Exit;
use kinetoscope_console::text::shown_path;
use locking::lock::LockArguments;
use manifests::starter::{NewArguments, print_schema};
use messages::Failure;
use messages::argument_errors;
use messages::examples::{FIRST_STEPS, with_examples};
use messages::exit::{self, OF_RUN, exit_codes};
use messages::suggestion::with_nearest_subcommand;
use planning::planner::parallel_runs;
use program_name::ProgramName;
use running::RunArguments;
use running::simulate::SimulateArguments;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use view::ViewArguments;
use why::WhyArguments;

/// Reproducible particle experiments: a manifest in, recordings and checked physics out.
#[derive(Debug, Parser)]
#[command(name = "kinetoscope", version, arg_required_else_help = true, after_help = FIRST_STEPS)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
#[command(subcommand_help_heading = "Subcommands", disable_help_subcommand = true)]
enum Command {
    #[command(after_help = with_examples("run", &exit_codes(OF_RUN)))]
    Run(RunArguments),
    #[command(after_help = with_examples("simulate", &exit_codes(&[])))]
    Simulate(SimulateArguments),
    #[command(after_help = with_examples("new", &exit_codes(&[])))]
    New(NewArguments),
    #[command(after_help = with_examples("demo", &exit_codes(OF_RUN)))]
    Demo(DemoArguments),
    #[command(after_help = with_examples("check", &exit_codes(&[1, 4, 5, 129, 130, 143])))]
    Check(CheckArguments),
    #[command(after_help = with_examples("lock", &exit_codes(&[1, 4, 5, 129, 130, 143])))]
    Lock(LockArguments),
    #[command(after_help = with_examples("bundle", &exit_codes(&[1, 4, 5, 129, 130, 143])))]
    Bundle(BundleArguments),
    #[command(after_help = with_examples("reproduce", &exit_codes(&[1, 4, 5, 129, 130, 143])))]
    Reproduce(ReproduceArguments),
    #[command(after_help = with_examples("verify", &exit_codes(&[1, 4, 5, 129, 130, 143])))]
    Verify(VerifyArguments),
    #[command(after_help = with_examples("compare", &exit_codes(&[4, 5])))]
    Compare(CompareArguments),
    #[command(after_help = with_examples("fill", &exit_codes(&[1, 4, 5, 129, 130, 143])))]
    Fill(FillArguments),
    #[command(after_help = with_examples("zoom", &exit_codes(&[1, 4, 5, 129, 130, 143])))]
    Zoom(ZoomArguments),
    #[command(after_help = with_examples("restore", &exit_codes(&[1, 5, 129, 130, 143])))]
    Restore(RestoreArguments),
    #[command(after_help = with_examples("why", &exit_codes(OF_RUN)))]
    Why(WhyArguments),
    #[command(after_help = with_examples("info", &exit_codes(&[5])))]
    Info(InfoArguments),
    #[command(after_help = with_examples("benchmark", &exit_codes(OF_RUN)))]
    Benchmark(BenchmarkArguments),
    #[command(after_help = with_examples("analyze", analysis::EXIT_CODES))]
    Analyze(AnalyzeArguments),
    #[command(after_help = with_examples("export", &exit_codes(&[5])))]
    Export(ExportArguments),
    #[command(after_help = with_examples("plot", &exit_codes(&[5])))]
    Plot(PlotArguments),
    #[command(after_help = with_examples("table", &exit_codes(&[5])))]
    Table(TableArguments),
    #[command(after_help = with_examples("grade", &exit_codes(&[1, 4, 129, 130, 143])))]
    Grade(GradeArguments),
    #[command(after_help = with_examples("view", &exit_codes(&[5, 130, 143])))]
    View(ViewArguments),
    /// Print the JSON Schema of manifests, for editors
    #[command(after_help = with_examples("schema", &exit_codes(&[])))]
    Schema,
    /// Print the completions of a program for a shell
    #[command(after_help = with_examples("completions", &exit_codes(&[])))]
    Completions {
        /// The shell
        shell: Shell,
        /// The program
        #[arg(value_enum, default_value_t = ProgramName::Kinetoscope)]
        program: ProgramName,
    },
    /// Write the manual pages into a folder, for packages of distributions
    #[command(after_help = with_examples("man-pages", &exit_codes(&[])))]
    ManPages {
        /// The folder
        folder: PathBuf,
    },
    #[command(
        after_help = with_examples("doctor", "Exit codes:\n  0    no problem\n  1    a problem was found; its remedy is printed\n  2    bad arguments\n  70   an internal error, or not enough memory\n  75   the output cannot be written")
    )]
    Doctor(DoctorArguments),
}

/// Run the experiment of a manifest: one MCAP recording per run, with every frame.
#[derive(Debug, Parser)]
#[command(name = "run-experiment", version, after_help = exit_codes(OF_RUN))]
struct RunExperiment {
    #[command(flatten)]
    run: RunArguments,
}

/// Compute metrics with standard errors, plots and checks from recordings
///
/// Writes report.html, metrics.json, metrics.csv and one file per plot next to the recordings; for a folder of experiments also
/// index.html.
#[derive(Debug, Parser)]
#[command(name = "analyze-recordings", version, after_help = analysis::EXIT_CODES)]
struct AnalyzeRecordings {
    #[command(flatten)]
    analyze: AnalyzeArguments,
}

/// The optional features, and whether this program was built with them.
const FEATURES: [(&str, bool); 3] = [
    ("engine", cfg!(feature = "engine")),
    ("object-storage", cfg!(feature = "object-storage")),
    ("parquet", cfg!(feature = "parquet")),
];

/// The program: does what its name, its arguments and the files say, and returns the exit code.
#[must_use]
pub fn main() -> ExitCode {
    kinetoscope_console::catch_internal_errors(|| {
        allocator::keep_little();
        let name = ProgramName::called();
        let exit = match name {
            ProgramName::Kinetoscope => Arguments::try_parse_from(words()).map(|arguments| {
                match &arguments.command {
                    // It starts its threads when it knows the number of its runs.
                    Command::Run(arguments) => arguments.execute(name),
                    _ => with_threads(|| execute(&arguments)),
                }
            }),
            ProgramName::RunExperiment => {
                RunExperiment::try_parse().map(|arguments| arguments.run.execute(name))
            }
            ProgramName::AnalyzeRecordings => AnalyzeRecordings::try_parse()
                .map(|arguments| with_threads(|| arguments.analyze.execute(ENGINE))),
        };
        exit.unwrap_or_else(|error| reject(name, error)).into()
    })
}

/// Executes a command for whose threads the system has room.
fn with_threads(command: impl FnOnce() -> Exit) -> Exit {
    match start_threads_for(parallel_runs(None, usize::MAX)) {
        Ok(()) => command(),
        Err(failure) => failure.report(),
    }
}

/// Executes a subcommand.
fn execute(arguments: &Arguments) -> Exit {
    match &arguments.command {
        Command::Run(arguments) => arguments.execute(ProgramName::Kinetoscope),
        Command::Simulate(arguments) => arguments.execute(),
        Command::New(arguments) => arguments.execute(),
        Command::Demo(arguments) => arguments.execute(ENGINE),
        Command::Check(arguments) => arguments.execute(),
        Command::Lock(arguments) => arguments.execute(),
        Command::Bundle(arguments) => arguments.execute(),
        Command::Reproduce(arguments) => arguments.execute(),
        Command::Verify(arguments) => arguments.execute(),
        Command::Compare(arguments) => arguments.execute(),
        Command::Fill(arguments) => arguments.execute(),
        Command::Zoom(arguments) => arguments.execute(),
        Command::Restore(arguments) => arguments.execute(),
        Command::Why(arguments) => arguments.execute(),
        Command::Info(arguments) => arguments.execute(),
        Command::Benchmark(arguments) => arguments.execute(),
        Command::Analyze(arguments) => arguments.execute(ENGINE),
        Command::Export(arguments) => arguments.execute(),
        Command::Plot(arguments) => arguments.execute(),
        Command::Table(arguments) => arguments.execute(),
        Command::Grade(arguments) => arguments.execute(),
        Command::View(arguments) => arguments.execute(),
        Command::Schema => print_schema(),
        Command::Completions { shell, program } => print_completions(*shell, *program),
        Command::ManPages { folder } => write_man_pages(folder),
        Command::Doctor(arguments) => arguments.execute(&FEATURES),
    }
}

/// Prints help, version or what is wrong with the arguments.
fn reject(name: ProgramName, error: clap::Error) -> Exit {
    match name {
        ProgramName::Kinetoscope => {
            let error = with_nearest_subcommand(error, &Arguments::command());
            argument_errors::report(&error, &called())
        }
        ProgramName::RunExperiment | ProgramName::AnalyzeRecordings => {
            argument_errors::report(&error, name.text())
        }
    }
}

/// The arguments of a program.
fn command_of(name: ProgramName) -> clap::Command {
    match name {
        ProgramName::Kinetoscope => Arguments::command(),
        ProgramName::RunExperiment => RunExperiment::command(),
        ProgramName::AnalyzeRecordings => AnalyzeRecordings::command(),
    }
}

/// The words of the command line of `kinetoscope`: a manifest in place of a subcommand means `run`, and `help run` means `run --help`.
fn words() -> Vec<OsString> {
    let mut words: Vec<OsString> = std::env::args_os().collect();
    let first = words.get(1).map(|word| word.to_string_lossy().into_owned());
    match first.as_deref() {
        Some("help") => {
            words.remove(1);
            words.push("--help".into());
        }
        Some(manifest) if manifest.ends_with(".toml") => words.insert(1, "run".into()),
        _ => {}
    }
    words
}

/// The program with the subcommand that was called, for the help of an error.
fn called() -> String {
    let (command, words) = (Arguments::command(), words());
    let name = words.get(1).map(|word| word.to_string_lossy());
    let subcommand = name.filter(|name| command.find_subcommand(name.as_ref()).is_some());
    subcommand.map_or_else(|| "kinetoscope".to_owned(), |name| format!("kinetoscope {name}"))
}

/// Prints completions; the generator itself would panic at a closed pipe.
fn print_completions(shell: Shell, program: ProgramName) -> Exit {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut command_of(program), program.text(), &mut text);
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
            Failure::new(exit::of_output(&error), what).help("name another folder").report()
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::Arguments;
    use crate::messages::examples::EXAMPLES;
    use clap::{CommandFactory as _, Parser as _};

    /// Guarantee: the help of every subcommand has examples, and each is a command line that the program accepts.
    #[test]
    fn examples_of_the_help_are_accepted() {
        let command = Arguments::command();
        let subcommands: Vec<&str> = command.get_subcommands().map(|one| one.get_name()).collect();
        let with_examples: Vec<&str> = EXAMPLES.iter().map(|(name, _)| *name).collect();
        assert_eq!(with_examples, subcommands);
        for (name, examples) in EXAMPLES {
            for example in *examples {
                let words = ["kinetoscope"].into_iter().chain(example.split(' '));
                let parsed = Arguments::try_parse_from(words);
                assert!(parsed.is_ok(), "{example}: {}", parsed.unwrap_err());
                assert!(example.split(' ').next() == Some(name), "{example}");
            }
        }
    }
}
