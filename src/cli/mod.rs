//! The command line of `run-experiment` and of the subcommands of `kinetoscope`: arguments in, text and an exit code out.
//!
//! Start reading at [`run`]. Invariant: everything below this folder returns values; only this folder prints results.

pub mod allocator;
pub mod analysis;
pub mod benchmark;
pub mod check;
pub mod doctor;
pub mod executor;
pub mod exit;
mod expected_time;
mod experiment;
pub mod info;
pub mod inspect;
pub mod live;
mod manifests;
pub mod messages;
pub mod output;
mod pipeline;
mod plotted_fields;
mod results;
pub mod run;
pub mod starter;
pub mod why;

use crate::cli::analysis::{Analysis, AnalysisProgram};
use crate::cli::exit::{Exit, OF_RUN, exit_codes};
use crate::cli::messages::{Failure, word};
use crate::executor::progress::Verbosity;
use clap::{Args, Parser};
use kinetoscope_usage::{Ended, StandardOutput};
use serde_json::json;
use std::path::PathBuf;

/// Run the experiment of a manifest: one MCAP recording per run, with every frame.
#[derive(Debug, Parser)]
#[command(name = "run-experiment", version, after_help = exit_codes(OF_RUN))]
struct RunExperiment {
    #[command(flatten)]
    run: run::RunArguments,
}

/// The program `run-experiment`: parses its arguments and executes the runs.
#[must_use]
pub fn run_experiment() -> Exit {
    match RunExperiment::try_parse() {
        Ok(arguments) => arguments.run.execute(&Program::run_experiment()),
        Err(error) => match kinetoscope_usage::report(&error, "run-experiment") {
            Ended::Answered => Exit::Done,
            Ended::Rejected => Exit::BadManifest,
            Ended::Unwritten => Exit::Retryable,
        },
    }
}

/// The program that the user called.
pub struct Program<'a> {
    /// The subcommand that executes runs; `None` in `run-experiment`, which does nothing else.
    pub(crate) run_subcommand: Option<&'static str>,
    pub(crate) analysis: &'a dyn Analysis,
}

impl<'a> Program<'a> {
    /// `run-experiment`, which starts the program `analyze-recordings`.
    #[must_use]
    pub fn run_experiment() -> Self {
        Self { run_subcommand: None, analysis: &AnalysisProgram }
    }

    /// `kinetoscope`, which links the analysis.
    #[must_use]
    pub fn kinetoscope(analysis: &'a dyn Analysis) -> Self {
        Self { run_subcommand: Some("run"), analysis }
    }

    /// The command of the analysis, as the user called this program: through cargo, which runs programs in `target`, or
    /// by a path.
    fn analysis_command(&self, cargo_feature: &str) -> String {
        let own = std::env::args_os().next().map(PathBuf::from).unwrap_or_default();
        let is_cargo = own.components().any(|part| part.as_os_str() == "target");
        match (self.run_subcommand, is_cargo) {
            (None, true) => {
                format!("cargo run --release{cargo_feature} --bin analyze-recordings --")
            }
            (None, false) => word(&own.with_file_name("analyze-recordings").display().to_string()),
            (Some(_), true) => {
                format!("cargo run --release{cargo_feature} --bin kinetoscope -- analyze")
            }
            (Some(_), false) => format!("{} analyze", word(&own.display().to_string())),
        }
    }
}

/// How much is printed.
#[derive(Debug, Args)]
#[command(next_help_heading = "Messages")]
pub struct MessageArguments {
    /// Print errors only
    #[arg(long, short, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Print one line per finished run, on a terminal as well
    #[arg(long, short)]
    verbose: bool,
    /// Print the summary as JSON
    #[arg(long)]
    pub json: bool,
    #[arg(skip)]
    output: StandardOutput,
}

impl MessageArguments {
    /// Prints a text, unless errors only or JSON are requested.
    pub(crate) fn say(&self, text: &str) {
        if !self.quiet && !self.json && !text.is_empty() {
            self.output.print(&format!("{text}\n"));
        }
    }

    /// Prints a JSON document.
    pub(crate) fn print_json(&self, document: &serde_json::Value) {
        self.output.print_json(&format!("{document:#}\n"));
    }

    /// Prints the error that ended the command, and as JSON if that is requested.
    pub(crate) fn failed(&self, failure: &Failure) -> Exit {
        let exit = failure.report();
        if self.json {
            self.print_json(&json!({ "exit_code": exit.code(), "errors": [failure.text()] }));
        }
        exit
    }

    /// The exit code, if all text was printed.
    pub(crate) fn concluded(&self, exit: Exit) -> Exit {
        messages::concluded(&self.output, exit)
    }

    pub(crate) fn verbosity(&self) -> Verbosity {
        match (self.quiet, self.verbose) {
            (true, _) => Verbosity::Quiet,
            (false, true) => Verbosity::Verbose,
            (false, false) => Verbosity::Normal,
        }
    }
}

/// How a short command prints its result.
#[derive(Debug, Args)]
#[command(next_help_heading = "Messages")]
pub struct ResultArguments {
    /// Print errors only
    #[arg(long, short)]
    pub quiet: bool,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
    #[arg(skip)]
    output: StandardOutput,
}

impl ResultArguments {
    /// Prints the result as text or as JSON.
    pub(crate) fn print(&self, text: &str, json: impl FnOnce() -> serde_json::Value) {
        if self.json {
            self.print_json(&json());
        } else if !self.quiet && !text.is_empty() {
            self.output.print(&format!("{text}\n"));
        }
    }

    /// Prints a JSON document.
    pub(crate) fn print_json(&self, document: &serde_json::Value) {
        self.output.print_json(&format!("{document:#}\n"));
    }

    /// Prints the error that ended the command, and as JSON if that is requested.
    pub(crate) fn failed(&self, failure: &Failure) -> Exit {
        let exit = failure.report();
        if self.json {
            self.print_json(&json!({ "exit_code": exit.code(), "errors": [failure.text()] }));
        }
        exit
    }

    /// The exit code, if all text was printed.
    pub(crate) fn concluded(&self, exit: Exit) -> Exit {
        messages::concluded(&self.output, exit)
    }
}
