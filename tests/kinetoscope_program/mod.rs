//! The program `kinetoscope`, which a package of its own builds next to `run-experiment`.

use std::path::Path;
use std::process::Command;

/// A call of `kinetoscope`. `cargo test --workspace` builds it; for one test of this package, build it first.
pub(crate) fn kinetoscope() -> Command {
    let name = format!("kinetoscope{}", std::env::consts::EXE_SUFFIX);
    let program = Path::new(env!("CARGO_BIN_EXE_run-experiment")).with_file_name(name);
    assert!(program.exists(), "build it first: cargo build --package kinetoscope-program");
    Command::new(program)
}
