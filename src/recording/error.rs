//! What can go wrong while recording or reading, with the user's next step.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// A recording that can't be written.
#[derive(Debug)]
pub enum RecordError {
    /// The disk, or what stands in for it. The message names the path.
    Io(io::Error),
    /// Another process writes the same recording.
    Locked {
        /// The partial file.
        path: PathBuf,
    },
    /// A finished recording of the same name holds other bytes.
    Differs {
        /// The finished recording; it was left as it is.
        existing: PathBuf,
        /// The new one.
        partial: PathBuf,
    },
    /// What a killed run left can't be gone on with.
    NotContinued {
        /// The partial file or the checkpoint.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// The manifest asks for a channel that the model does not have.
    UnknownTopic {
        /// The name, without the leading slash.
        name: String,
        /// What there is.
        known: Vec<&'static str>,
    },
    /// The playback rate is out of range, or the playback would be too long for the viewers.
    Playback {
        /// Frame that has no log time.
        frame: u64,
        /// Frames a second of playback.
        rate: f64,
    },
    /// The model broke its declaration: a defect of the program.
    Declaration(String),
    /// The container refused what it was given: a defect of the program.
    Container(String),
}

impl RecordError {
    /// Whether the same command may succeed later: disk, lock and I/O.
    #[must_use]
    pub fn is_retryable(&self) -> bool {
        matches!(self, Self::Io(_) | Self::Locked { .. })
    }
}

impl fmt::Display for RecordError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io(source) if source.kind() == io::ErrorKind::StorageFull => {
                write!(
                    formatter,
                    "{source}. Free space on this disk, then run the same command again"
                )
            }
            Self::Io(source) => write!(
                formatter,
                "{source}. Check the disk and the folder's permissions, then run the same command again"
            ),
            Self::Locked { path } => write!(
                formatter,
                "{} is being written by another process. Wait for it to end, then run the same command again",
                path.display()
            ),
            Self::Differs { existing, partial } => write!(
                formatter,
                "{} is there already and holds other bytes than the new recording {}. Both were kept: \
                 compare the two, then delete the one that is not wanted",
                existing.display(),
                partial.display()
            ),
            Self::NotContinued { path, what } => {
                write!(formatter, "{} can't be gone on with: {what}", path.display())
            }
            Self::UnknownTopic { name, known } => write!(
                formatter,
                "this model has no channel \"{name}\". Name some of: {}",
                known.join(", ")
            ),
            Self::Playback { frame, rate } => write!(
                formatter,
                "frame {frame} can't be played at {rate} frames a second: viewers take up to 50 a second and 93 days in all. \
                 Record fewer frames, or change `record.playback_rate`"
            ),
            Self::Declaration(what) => {
                write!(formatter, "{what}. This is a defect of the program: please report it")
            }
            Self::Container(what) => {
                write!(
                    formatter,
                    "the MCAP writer refused: {what}. This is a defect of the program: please report it"
                )
            }
        }
    }
}

impl std::error::Error for RecordError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        if let Self::Io(source) = self { Some(source) } else { None }
    }
}

impl From<io::Error> for RecordError {
    fn from(source: io::Error) -> Self {
        Self::Io(source)
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

/// Why a recording, or the rest of it, can't be read.
#[derive(Debug)]
pub struct ReadError {
    /// The file.
    pub path: PathBuf,
    /// Frames that were read before, all intact.
    pub intact_frames: u64,
    /// What is wrong.
    pub fault: ReadFault,
}

/// What is wrong with a recording.
#[derive(Debug)]
pub enum ReadFault {
    /// The file can't be opened or read.
    Io(io::Error),
    /// Not an MCAP file.
    NotMcap,
    /// An MCAP file of another program.
    Foreign,
    /// A recording with a layout that this program does not know.
    OtherSchema {
        /// The layout's version.
        found: u32,
    },
    /// The file ends before its footer: the run was killed or the copy is incomplete.
    Torn {
        /// Where the file stops making sense.
        byte: u64,
    },
    /// Bytes that are not what was written.
    Damaged {
        /// Where.
        byte: u64,
        /// What does not fit.
        what: String,
    },
}

impl fmt::Display for ReadError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = self.path.display();
        match &self.fault {
            ReadFault::Io(source) if self.intact_frames == 0 => {
                return write!(
                    formatter,
                    "{path}: {source}. Check that the file exists and may be read"
                );
            }
            ReadFault::Io(source) => write!(formatter, "{path}: {source}. Check the disk")?,
            ReadFault::NotMcap => {
                return write!(
                    formatter,
                    "{path} is not an MCAP file. Name a recording or a folder of recordings"
                );
            }
            ReadFault::Foreign => {
                return write!(
                    formatter,
                    "{path} is an MCAP file, but no recording of this program. Name a recording that run-experiment wrote"
                );
            }
            ReadFault::OtherSchema { found } => {
                return write!(
                    formatter,
                    "{path} has layout version {found}; this program reads version {}. Use the program that wrote it",
                    crate::channels::SCHEMA_VERSION
                );
            }
            ReadFault::Torn { byte } => write!(
                formatter,
                "{path} is cut off (intact up to byte {byte}): the run was not finished, or the copy is incomplete. \
                 Run its manifest again, or copy the file again"
            )?,
            ReadFault::Damaged { byte, what } => write!(
                formatter,
                "{path} is damaged at byte {byte}: {what}. Copy the file again, or run its manifest again with --force"
            )?,
        }
        match self.intact_frames {
            0 => formatter.write_str("; no frame could be read"),
            1 => formatter.write_str("; frame 0 is intact, the rest is lost"),
            frames => {
                write!(formatter, "; frames 0 to {} are intact, the rest is lost", frames - 1)
            }
        }
    }
}

impl std::error::Error for ReadError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        if let ReadFault::Io(source) = &self.fault { Some(source) } else { None }
    }
}
