//! Why a recording was not verified, compared, merged or restored.

use kinetoscope_console::text::shown_path;
use kinetoscope_console::{Explained, Message};
use kinetoscope_physics::model::SetupError;
use kinetoscope_recording::error::{ReadError, RecordError};
use std::io;
use std::path::PathBuf;
use thiserror::Error;

/// The reason why a recording was not verified, compared, merged or restored.
#[derive(Debug, Error)]
pub enum VerifyError {
    /// The file cannot be read, or holds no frame.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// This version of the program does not accept the manifest; all errors are listed.
    #[error("this version does not understand the manifest in the recording\n{}", .0.trim_end())]
    Manifest(String),
    /// The recording from which the run started is missing.
    #[error("the run started from another recording: {0}")]
    Start(String),
    /// The physics of this program is another one.
    #[error(
        "{path} was recorded with physics version {recorded} of {model}, and this program has version {own}",
        path = shown_path(.path)
    )]
    OtherPhysics {
        /// The recording.
        path: PathBuf,
        /// Name of the model.
        model: String,
        /// The version in the recording.
        recorded: u32,
        /// The version of this program.
        own: u32,
    },
    /// Arguments that do not fit the recordings, or name a file that cannot be written.
    #[error("{}", .0.what)]
    Arguments(Message),
    /// The recording cannot be used for this purpose.
    #[error("{}", .0.what)]
    Unsuitable(Message),
    /// The rerun gives other messages.
    #[error("the rerun differs from {path} in frame {frame}, {channel}: the file was changed, or another program wrote it", path = shown_path(.path))]
    Differs {
        /// The recording.
        path: PathBuf,
        /// The first frame that differs.
        frame: u64,
        /// The first channel that differs in this frame.
        channel: String,
    },
    /// The rerun does not start.
    #[error("the rerun failed: {0}")]
    Setup(#[from] SetupError),
    /// The rerun or a result cannot be written.
    #[error(transparent)]
    Write(#[from] RecordError),
    /// The temporary file of the rerun failed.
    #[error(
        "cannot write the rerun to {folder}: {source}",
        folder = shown_path(&std::env::temp_dir()),
        source = .0
    )]
    Temporary(io::Error),
    /// The program received a signal.
    #[error("stopped before the end, without a result")]
    Interrupted(u8),
}

impl Explained for VerifyError {
    fn help(&self) -> Option<String> {
        let help = match self {
            Self::Read(error) => return error.help(),
            Self::Write(error) => return error.help(),
            Self::Setup(error) => return error.help(),
            Self::Arguments(message) | Self::Unsuitable(message) => return message.help.clone(),
            Self::OtherPhysics { recorded, .. } => {
                return Some(format!(
                    "restore its frames with a program of version {recorded}; its keyframes can be viewed with any"
                ));
            }
            Self::Manifest(_) => "use the version that wrote it",
            Self::Start(_) => {
                "put that recording into the folder of this one, or into an adjacent folder"
            }
            Self::Differs { .. } => "compare versions with `kinetoscope info`",
            Self::Temporary(_) => "free some space there, or name another folder in TMPDIR",
            Self::Interrupted(_) => "run the same command again",
        };
        Some(help.to_owned())
    }
}
