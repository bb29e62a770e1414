//! The analysis of recordings where they were made, by the program `analyze-recordings` that lies beside this one: what is found
//! is remembered in `.analyzed`, so that the analysis of a whole sweep reads no recording again.

use crate::plan::Plan;
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// Has the plan's recordings analyzed that are there. Unchanged ones that were analyzed before cost next to nothing.
///
/// # Errors
/// Why not all were analyzed: nothing is lost, since the analysis of the whole reads them then.
pub fn remember(plan: &Plan) -> Result<(), String> {
    let there: Vec<PathBuf> = plan
        .runs
        .iter()
        .map(|run| plan.folder.join(run.file_name()))
        .filter(|path| path.exists())
        .collect();
    if there.is_empty() {
        return Ok(());
    }
    let own = std::env::current_exe().map_err(|error| error.to_string())?;
    let program = own.with_file_name(format!("analyze-recordings{}", std::env::consts::EXE_SUFFIX));
    let status = Command::new(&program)
        .arg("--remember")
        .args(&there)
        .stdout(Stdio::null())
        .status()
        .map_err(|error| format!("{}: {error}", program.display()))?;
    if status.success() { Ok(()) } else { Err(format!("{} ended: {status}", program.display())) }
}
