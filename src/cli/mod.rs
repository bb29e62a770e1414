//! The command line of `run-experiment` and of the subcommands of `kinetoscope`: arguments in, text and an exit code out.
//!
//! Start reading at [`run`]. Invariant: everything below this folder returns values; only this folder prints results.

pub mod allocator;
pub mod analysis;
pub mod benchmark;
pub mod check;
mod checked;
pub mod doctor;
pub mod executor;
pub mod exit;
mod expected_time;
mod experiment;
pub mod info;
pub mod inspect;
pub mod live;
pub mod lock;
mod locked;
mod manifests;
pub mod messages;
pub mod output;
mod pipeline;
mod planner;
mod plotted_fields;
mod program;
pub mod rerun;
pub mod restore;
mod result_arguments;
mod results;
pub mod run;
mod run_arguments;
pub mod starter;
mod step;
pub mod why;

use crate::cli::exit::{Exit, OF_RUN, exit_codes};
use clap::Parser;
use kinetoscope_console::Ended;
pub use program::Program;
pub use result_arguments::ResultArguments;

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
        Err(error) => match kinetoscope_console::report(&error, "run-experiment") {
            Ended::Answered => Exit::Done,
            Ended::Rejected => Exit::BadManifest,
            Ended::Unwritten => Exit::Retryable,
        },
    }
}
