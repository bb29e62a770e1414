//! Starts the program `analyze-recordings` that lies next to this one.

use kinetoscope_console::text::shown_path;
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// Has recordings analyzed; the results are cached in `.analysis-cache`. Unchanged recordings cost next to nothing.
///
/// # Errors
/// Why not all were analyzed. Nothing is lost: the analysis of the whole experiment reads them then.
pub fn cache(recordings: &[PathBuf]) -> Result<(), String> {
    let own = std::env::current_exe().map_err(|error| error.to_string())?;
    let program = own.with_file_name(format!("analyze-recordings{}", std::env::consts::EXE_SUFFIX));
    let status = Command::new(&program)
        .arg("--cache-only")
        .args(recordings)
        .stdout(Stdio::null())
        .status()
        .map_err(|error| format!("{}: {error}", shown_path(&program)))?;
    if status.success() {
        Ok(())
    } else {
        Err(format!("{} failed: {status}", shown_path(&program)))
    }
}
