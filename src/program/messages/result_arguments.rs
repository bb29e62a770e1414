//! The result of a command: text or JSON on standard output, and the error that ended it.

use crate::messages::progress::Verbosity;
use crate::messages::{self, Failure};
use clap::Args;
use kinetoscope_console::{Exit, StandardOutput};
use serde_json::json;

/// How a command prints its result.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Messages")]
pub(crate) struct ResultArguments {
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
    /// Errors only.
    pub(crate) fn errors_only() -> Self {
        Self { quiet: true, ..Self::default() }
    }

    /// The amount of progress output.
    pub(crate) fn verbosity(&self) -> Verbosity {
        if self.quiet || self.json { Verbosity::Quiet } else { Verbosity::Normal }
    }

    /// Prints the result as text or as JSON.
    pub(crate) fn print(&self, text: &str, json: impl FnOnce() -> serde_json::Value) {
        if self.json {
            self.print_json(&json());
        }
        self.say(text);
    }

    /// Prints a text, unless errors only or JSON are requested.
    pub(crate) fn say(&self, text: &str) {
        if self.is_said(text) {
            self.output.print_wrapped(&format!("{text}\n"));
        }
    }

    /// Prints a text with commands, which stay on one line each.
    pub(crate) fn say_commands(&self, text: &str) {
        if self.is_said(text) {
            self.output.print(&format!("{text}\n"));
        }
    }

    fn is_said(&self, text: &str) -> bool {
        !self.quiet && !self.json && !text.is_empty()
    }

    /// Prints a JSON document.
    pub(crate) fn print_json(&self, document: &serde_json::Value) {
        self.output.print_json(&format!("{document:#}\n"));
    }

    /// Prints the error that ended the command, and as JSON if that is requested.
    pub(crate) fn failed(&self, failure: &Failure) -> Exit {
        let exit = failure.report();
        if self.json {
            self.print_json(&json!({ "exit_code": exit.code(), "errors": [failure.plain_text()] }));
        }
        exit
    }

    /// The exit code, if all text was printed.
    pub(crate) fn concluded(&self, exit: Exit) -> Exit {
        messages::concluded(&self.output, exit)
    }
}
