//! The program `analyze-recordings`.

use std::process::ExitCode;

fn main() -> ExitCode {
    kinetoscope_console::catch_internal_errors(|| {
        ExitCode::from(kinetoscope_analysis::cli::main() as u8)
    })
}
