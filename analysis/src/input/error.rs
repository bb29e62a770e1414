//! Errors of the input: paths that name nothing to analyze, and recordings that cannot be read.

use kinetoscope_console::text::shown_path;
use kinetoscope_console::{Exit, Explained, Message};
use kinetoscope_files::regular_file::is_of_file;
use kinetoscope_object_storage::error::StoreError;
use kinetoscope_recording::error::ReadError;
use std::io;
use std::path::Path;

/// What to do if a disk fails.
pub(crate) const ON_FAILED_DISK: &str = "check the disk, then run the same command again";

/// A path that names nothing to analyze, with the user's next step.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", message.what)]
pub(crate) struct InvalidPath {
    /// What is wrong, and what to do.
    pub(crate) message: Message,
    /// Whether the same command may succeed later.
    pub(crate) is_retryable: bool,
}

impl InvalidPath {
    pub(super) fn new(what: String, help: &str) -> Self {
        Self { message: Message::new(what, help), is_retryable: false }
    }

    pub(super) fn without_recordings(path: &Path) -> Self {
        Self::new(
            format!("{} contains no finished recording (*.mcap)", shown_path(path)),
            "run the experiment first; the same command completes an interrupted run, and a partial file is analyzed only if it is named. Without recordings (`keep = \"metrics\"`), there are `analyze`, `plot`, `table` and `restore`",
        )
    }
}

impl From<StoreError> for InvalidPath {
    fn from(error: StoreError) -> Self {
        Self { message: error.message(), is_retryable: error.is_retryable }
    }
}

/// A recording or another file of its folder that cannot be read, or not to its end.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, thiserror::Error)]
#[error("{}", message.what)]
pub struct UnreadableRecording {
    /// What is wrong, and what to do.
    pub message: Message,
    /// Whether the machine failed and not the file, so that the same command may succeed later.
    pub(crate) is_of_machine: bool,
}

impl UnreadableRecording {
    pub(crate) fn new(what: impl Into<String>, help: impl Into<String>) -> Self {
        Message::new(what, help).into()
    }

    /// A file that cannot be read: with `help`, unless the disk failed.
    pub(crate) fn of_io(error: &io::Error, what: String, help: &str) -> Self {
        let is_of_machine = !is_of_file(error);
        let help = if is_of_machine { ON_FAILED_DISK } else { help };
        Self { message: Message::new(what, help), is_of_machine }
    }

    /// The exit code of a command that could not read these; `None` if it could read all.
    pub(crate) fn exit<'a>(all: impl IntoIterator<Item = &'a Self>) -> Option<Exit> {
        all.into_iter().map(Self::own_exit).reduce(Exit::worst)
    }

    fn own_exit(&self) -> Exit {
        if self.is_of_machine { Exit::Retryable } else { Exit::Unreadable }
    }
}

impl Explained for UnreadableRecording {
    fn help(&self) -> Option<String> {
        self.message.help.clone()
    }
}

/// A file that is damaged or is not what was expected.
impl From<Message> for UnreadableRecording {
    fn from(message: Message) -> Self {
        Self { message, is_of_machine: false }
    }
}

impl From<&ReadError> for UnreadableRecording {
    fn from(error: &ReadError) -> Self {
        Self { message: error.message(), is_of_machine: error.is_of_machine() }
    }
}

impl From<ReadError> for UnreadableRecording {
    fn from(error: ReadError) -> Self {
        Self::from(&error)
    }
}
