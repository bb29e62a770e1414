//! The program `analyze-recordings`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(kinetoscope_analysis::cli::main() as u8)
}
