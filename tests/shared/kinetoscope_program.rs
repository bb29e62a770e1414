//! The program under its name `kinetoscope`.

use std::process::Command;

/// A call of `kinetoscope`.
pub(crate) fn kinetoscope() -> Command {
    Command::new(env!("CARGO_BIN_EXE_kinetoscope"))
}
