//! The commands that follow a run, as the user can copy them.

use crate::messages::word;
use crate::program_name::{ProgramName, called_path};
use std::env;
use std::path::{Path, PathBuf};

/// The program of this name that is installed with `own`: in the same folder, or on the PATH if `own` was found there. `None` if
/// there is none.
fn neighbor(own: &Path, name: &str) -> Option<PathBuf> {
    let file = format!("{name}{}", env::consts::EXE_SUFFIX);
    let path = env::var_os("PATH").unwrap_or_default();
    match own.parent() {
        Some(folder) if folder.as_os_str().is_empty() => {
            env::split_paths(&path).map(|folder| folder.join(&file)).find(|file| file.is_file())
        }
        _ => Some(own.with_file_name(file)).filter(|file| file.is_file()),
    }
}

/// The file of this program, behind all links; empty if the system does not state it.
fn linked_program() -> PathBuf {
    env::current_exe().and_then(|program| program.canonicalize()).unwrap_or_default()
}

fn has_all_subcommands(program: &Path) -> bool {
    program.is_file() && ProgramName::of(program) == ProgramName::Kinetoscope
}

/// Whether `cargo run` started this program, which is in `target` then.
fn is_called_by_cargo(own: &Path) -> bool {
    env::var_os("CARGO").is_some() && own.components().any(|part| part.as_os_str() == "target")
}

impl ProgramName {
    /// The command of the analysis, as the user called this program: through cargo, which runs programs in `target`, or
    /// by a path. A link without the other names next to it leads to a program that has all subcommands.
    fn analysis_command(self, cargo_feature: &str) -> String {
        let own = called_path();
        let is_cargo = is_called_by_cargo(&own);
        match (self.run_subcommand(), is_cargo) {
            (None, true) => {
                format!("cargo run --release{cargo_feature} --bin analyze-recordings --")
            }
            (None, false) => match neighbor(&own, "analyze-recordings") {
                None if has_all_subcommands(&linked_program()) => {
                    format!("{} analyze", word(&linked_program().to_string_lossy()))
                }
                _ => word(&own.with_file_name("analyze-recordings").to_string_lossy()),
            },
            (Some(_), true) => {
                format!("cargo run --release{cargo_feature} --bin kinetoscope -- analyze")
            }
            (Some(_), false) => format!("{} analyze", word(&own.to_string_lossy())),
        }
    }

    /// The command that restores the frames of a recording of keyframes, which `run-experiment` has not.
    fn fill_command(self) -> String {
        let own = called_path();
        if is_called_by_cargo(&own) {
            return "cargo run --release --bin kinetoscope -- fill".to_owned();
        }
        let program = match neighbor(&own, "kinetoscope") {
            _ if self.run_subcommand().is_some() => own,
            None if has_all_subcommands(&linked_program()) => linked_program(),
            _ => own.with_file_name("kinetoscope"),
        };
        format!("{} fill", word(&program.to_string_lossy()))
    }

    /// Formats the commands that restore these recordings of keyframes and analyze `destinations`, as the user can copy them.
    pub(crate) fn next_command(
        self,
        keyframes: &[PathBuf],
        destinations: &[String],
        is_remote: bool,
    ) -> String {
        let feature = if is_remote { " --features object-storage" } else { "" };
        let command = self.analysis_command(feature);
        let words: Vec<String> = destinations.iter().map(|destination| word(destination)).collect();
        let fill = match keyframes {
            [] => String::new(),
            [recording] => {
                format!("\n  {} {}", self.fill_command(), word(&recording.to_string_lossy()))
            }
            several => {
                format!(
                    "\n  {} FILE.mcap    # for each of {} recordings",
                    self.fill_command(),
                    several.len()
                )
            }
        };
        format!("\nNext:{fill}\n  {command} {}", words.join(" "))
    }
}
