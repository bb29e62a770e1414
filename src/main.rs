//! `run-experiment`: arguments to exit code, nothing else.

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    kinetoscope::allocation::keep_little();
    kinetoscope::command::Arguments::parse().execute().into()
}
