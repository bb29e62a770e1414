//! The names under which the program is called.

use clap::ValueEnum;
use std::path::{Path, PathBuf};

/// What the program does, by the name under which it was called: it may be a link or a copy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProgramName {
    /// Every subcommand. Also the meaning of an unknown name.
    Kinetoscope,
    /// The subcommand `run`.
    RunExperiment,
    /// The subcommand `analyze`.
    AnalyzeRecordings,
}

impl ProgramName {
    /// The name of this call: the first word of the command line, without its folders.
    pub(crate) fn called() -> Self {
        Self::of(&called_path())
    }

    /// The meaning of the file name of a program.
    pub(crate) fn of(path: &Path) -> Self {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let name = name.strip_suffix(std::env::consts::EXE_SUFFIX).unwrap_or(name);
        let known = [Self::RunExperiment, Self::AnalyzeRecordings];
        known.into_iter().find(|program| program.text() == name).unwrap_or(Self::Kinetoscope)
    }

    /// The name as the user writes it.
    pub(crate) const fn text(self) -> &'static str {
        match self {
            Self::Kinetoscope => "kinetoscope",
            Self::RunExperiment => "run-experiment",
            Self::AnalyzeRecordings => "analyze-recordings",
        }
    }

    /// The subcommand that executes runs; `None` where the program does nothing else.
    pub(crate) const fn run_subcommand(self) -> Option<&'static str> {
        match self {
            Self::Kinetoscope => Some("run"),
            Self::RunExperiment | Self::AnalyzeRecordings => None,
        }
    }
}

/// The program as the user wrote it, with its folders.
pub(crate) fn called_path() -> PathBuf {
    std::env::args_os().next().map(PathBuf::from).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::ProgramName;
    use std::path::Path;

    #[test]
    fn program_under_an_unknown_name_is_kinetoscope() {
        for (path, expected) in [
            ("run-experiment", ProgramName::RunExperiment),
            ("/usr/bin/run-experiment", ProgramName::RunExperiment),
            ("../bin/analyze-recordings", ProgramName::AnalyzeRecordings),
            ("target/release/kinetoscope", ProgramName::Kinetoscope),
            ("run-experiment-2", ProgramName::Kinetoscope),
            ("", ProgramName::Kinetoscope),
        ] {
            assert_eq!(ProgramName::of(Path::new(path)), expected, "{path}");
        }
    }
}
