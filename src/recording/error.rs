//! The errors of recording and reading, with the user's next step.

use crate::channels::SCHEMA_VERSION;
use kinetoscope_console::text::{plural, shown_path};
use kinetoscope_console::{Explained, ON_MISSING_THREAD};
use kinetoscope_files::regular_file::{MAX_MANIFEST_BYTES, is_of_file};
use std::io;
use std::path::PathBuf;
use thiserror::Error;

/// A recording that cannot be written.
#[derive(Debug, Error)]
pub enum RecordError {
    /// The disk or another sink failed. The message names the path.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The system starts no thread for the recorder or for a check.
    #[error("a thread cannot be started: {0}")]
    Thread(io::Error),
    /// Another process writes the same recording.
    #[error("{} is being written by another process", shown_path(path))]
    Locked {
        /// The partial file.
        path: PathBuf,
    },
    /// A finished recording of the same name has other bytes.
    #[error(
        "{} already exists with other bytes than the new recording {}; both were kept",
        shown_path(existing),
        shown_path(partial)
    )]
    Differs {
        /// The finished recording, unchanged.
        existing: PathBuf,
        /// The new recording.
        partial: PathBuf,
    },
    /// A killed run cannot be resumed from its files.
    #[error("{} cannot be resumed: {what}", shown_path(path))]
    NotContinued {
        /// The partial file or the checkpoint.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// The canonical text of the manifest is longer than the reader accepts.
    #[error(
        "the run's manifest has {bytes} bytes with all its keys; must be at most {MAX_MANIFEST_BYTES}"
    )]
    LongManifest {
        /// Its size.
        bytes: u64,
    },
    /// The manifest names a channel that the model does not have.
    #[error("this model has no channel \"{name}\"")]
    UnknownTopic {
        /// The name, without the leading slash.
        name: String,
        /// The existing channels.
        known: Vec<&'static str>,
    },
    /// The playback rate is out of range, or the playback would be too long for the viewers.
    #[error(
        "frame {frame} cannot be played at {rate} frames per second: viewers support up to 50 per second and 93 days in total"
    )]
    Playback {
        /// Frame that has no log time.
        frame: u64,
        /// Frames per second of playback.
        rate: f64,
    },
    /// The model broke its declaration: a defect of the program.
    #[error("{0}")]
    Declaration(String),
    /// The container rejected its input: a defect of the program.
    #[error("the MCAP writer rejected a record: {0}")]
    Container(String),
}

impl Explained for RecordError {
    fn help(&self) -> Option<String> {
        let help = match self {
            Self::Io(source) if source.kind() == io::ErrorKind::StorageFull => {
                "free space on this disk, then run the same command again"
            }
            Self::Io(_) => {
                "check the disk and the folder's permissions, then run the same command again"
            }
            Self::Thread(_) => ON_MISSING_THREAD,
            Self::Locked { .. } => "wait for it to end, then run the same command again",
            Self::Differs { .. } => "compare the two, then delete one of them",
            Self::NotContinued { .. } => "delete it to start the run again",
            Self::LongManifest { .. } => {
                "start from a recording (start_from) instead of a state that is written out"
            }
            Self::UnknownTopic { known, .. } => {
                return Some(format!("name some of: {}", known.join(", ")));
            }
            Self::Playback { .. } => "record fewer frames, or change `record.playback_fps`",
            Self::Declaration(_) | Self::Container(_) => {
                "this is a defect of the program: please report it"
            }
        };
        Some(help.to_owned())
    }
}

impl RecordError {
    /// Whether the same command may succeed later: disk, threads, lock and I/O.
    #[must_use]
    pub fn is_retryable(&self) -> bool {
        matches!(self, Self::Io(_) | Self::Thread(_) | Self::Locked { .. })
    }
}

impl From<mcap::McapError> for RecordError {
    fn from(error: mcap::McapError) -> Self {
        match error {
            mcap::McapError::Io(source) => Self::Io(source),
            other => Self::Container(other.to_string()),
        }
    }
}

/// The reason why a recording, or the rest of it, cannot be read.
#[derive(Debug, Error)]
#[error("{}{fault}{}", shown_path(path), self.intact_part())]
pub struct ReadError {
    /// The file.
    pub path: PathBuf,
    /// Number of frames read before the error, all intact.
    pub intact_frames: u64,
    /// What is wrong.
    pub fault: ReadFault,
}

/// A defect of a recording. The text follows the path.
#[derive(Debug, Error)]
pub enum ReadFault {
    /// The file cannot be opened or read.
    #[error(": {0}")]
    Io(io::Error),
    /// Not an MCAP file.
    #[error(" is not an MCAP file")]
    NotMcap,
    /// An MCAP file of another program.
    #[error(" is an MCAP file, but not a recording of this program")]
    Foreign,
    /// A recording of several runs.
    #[error(" holds several runs, merged for a viewer")]
    Merged,
    /// A recording of another schema version.
    #[error(" has schema version {found}; this program reads version {SCHEMA_VERSION}")]
    OtherSchema {
        /// The version found.
        found: u32,
    },
    /// The file ends before its footer: the run was killed or the copy is incomplete.
    #[error(
        " is cut off (intact up to byte {byte}): the run was not finished, or the copy is incomplete"
    )]
    Torn {
        /// End of the intact part.
        byte: u64,
    },
    /// Another process is writing the file.
    #[error(" is being written by another process, so far {byte} bytes")]
    Growing {
        /// End of the intact part.
        byte: u64,
    },
    /// Bytes differ from those that were written.
    #[error(" is damaged at byte {byte}: {what}")]
    Damaged {
        /// Position of the damage.
        byte: u64,
        /// The inconsistency found.
        what: String,
    },
}

impl Explained for ReadError {
    fn help(&self) -> Option<String> {
        let help = match &self.fault {
            ReadFault::Io(error) if error.kind() == io::ErrorKind::InvalidInput => {
                "name a recording: a regular file *.mcap"
            }
            ReadFault::Io(error) if error.kind() == io::ErrorKind::OutOfMemory => {
                "end other programs, or read it on a machine with more memory"
            }
            ReadFault::Io(_) if self.is_of_machine() => {
                "check the disk, then run the same command again"
            }
            ReadFault::Io(_) => "check that the file exists and may be read",
            ReadFault::NotMcap => "name a recording (*.mcap)",
            ReadFault::Foreign => "name a recording that run-experiment wrote",
            ReadFault::Merged => {
                "name a recording of one run; keep merged recordings in another folder"
            }
            ReadFault::OtherSchema { .. } => {
                "run its manifest again, or use the program that wrote it"
            }
            ReadFault::Torn { .. } => "run its manifest again, or copy the file again",
            ReadFault::Growing { .. } => "wait for the end of its run",
            ReadFault::Damaged { .. } => {
                "copy the file again, or run its manifest again with --force"
            }
        };
        Some(help.to_owned())
    }
}

impl ReadError {
    /// Whether a disk or another part of the machine failed, so that the same command may succeed later.
    #[must_use]
    pub fn is_of_machine(&self) -> bool {
        matches!(&self.fault, ReadFault::Io(error) if !is_of_file(error))
    }

    /// The frames that could be read.
    fn intact_part(&self) -> String {
        match (&self.fault, self.intact_frames) {
            (
                ReadFault::NotMcap
                | ReadFault::Foreign
                | ReadFault::Merged
                | ReadFault::OtherSchema { .. },
                _,
            )
            | (ReadFault::Io(_), 0) => String::new(),
            (ReadFault::Growing { .. }, frames) => {
                format!("; it has {} so far", plural(frames, "frame"))
            }
            (_, 0) => "; no frame could be read".to_owned(),
            (_, 1) => "; frame 0 is intact, the rest is lost".to_owned(),
            (_, frames) => format!("; frames 0 to {} are intact, the rest is lost", frames - 1),
        }
    }
}
