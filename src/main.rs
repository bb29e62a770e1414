//! Program `run-experiment`: from arguments to an exit code.

use std::process::ExitCode;

fn main() -> ExitCode {
    kinetoscope::cli::allocator::keep_little();
    kinetoscope::cli::run_experiment().into()
}
