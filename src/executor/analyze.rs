//! Analysis of the recordings on the machine that executed the runs, by the program `analyze-recordings` in the same folder. The
//! results are cached in `.analyzed`, so that the analysis of the whole sweep does not read the recordings again.

use crate::plan::Plan;
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// Analyzes the existing recordings of the plan. Recordings that have not changed since their last analysis are skipped.
///
/// # Errors
/// A failed analysis. The analysis of the whole sweep then reads the recordings itself.
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
