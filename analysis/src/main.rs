//! `analyze-recordings`: arguments to exit code, nothing else.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(kinetoscope_analysis::cli::main() as u8)
}
