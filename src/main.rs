//! `run-experiment`: arguments to exit code, nothing else.

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    kinetoscope::cli::allocator::keep_little();
    kinetoscope::cli::Arguments::parse().execute().into()
}
