//! Program `run-experiment`: from arguments to an exit code.

use std::process::ExitCode;

fn main() -> ExitCode {
    kinetoscope_console::catch_internal_errors(|| {
        kinetoscope::cli::allocator::keep_little();
        kinetoscope::cli::run_experiment().into()
    })
}
