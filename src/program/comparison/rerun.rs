//! What the commands that execute a recorded run again share: signals, progress, and their errors.

use crate::messages::Failure;
use crate::messages::exit::exit_of_unread;
use crate::messages::progress::ProgressDisplay;
use crate::messages::result_arguments::ResultArguments;
use kinetoscope::executor::observer::ExecutionObserver as _;
use kinetoscope::interrupt::Interrupt;
use kinetoscope::verify::error::VerifyError;
use kinetoscope_console::text::shown_path;
use kinetoscope_console::{Exit, Explained as _};
use kinetoscope_recording::error::RecordError;
use std::path::Path;

/// Listens to Ctrl-C and other signals from now on.
pub(crate) fn listen() -> Result<Interrupt, Failure> {
    Interrupt::listen()
        .map_err(|error| Failure::new(Exit::Retryable, format!("cannot listen to Ctrl-C: {error}")))
}

/// The error of a command that received a signal.
pub(crate) fn stop_if_interrupted(interrupt: &Interrupt) -> Result<(), Failure> {
    interrupt.exit_code().map_or(Ok(()), |code| {
        Err(Failure::new(Exit::Signal(code), "interrupted").help("run the same command again"))
    })
}

/// Executes a run again with a progress bar.
pub(crate) fn with_progress<T>(
    recording: &Path,
    result: &ResultArguments,
    rerun: impl FnOnce(&Interrupt, &(dyn Fn(u64, u64) + Sync)) -> T,
) -> Result<T, Failure> {
    let interrupt = listen()?;
    let progress = ProgressDisplay::new(1, result.verbosity());
    let bar = progress.start_run(&shown_path(recording));
    let done = rerun(&interrupt, &|frame, of| bar.frame(frame, of));
    progress.close();
    Ok(done)
}

/// The exit code of an error.
pub(crate) fn exit_of(error: &VerifyError) -> Exit {
    match error {
        VerifyError::Arguments(_) => Exit::BadInput,
        VerifyError::Differs { .. } | VerifyError::Write(RecordError::Differs { .. }) => {
            Exit::Differs
        }
        VerifyError::Read(error) => exit_of_unread(error),
        VerifyError::Manifest(_)
        | VerifyError::Start(_)
        | VerifyError::OtherPhysics { .. }
        | VerifyError::Unsuitable(_)
        | VerifyError::Setup(_) => Exit::Unreadable,
        VerifyError::Temporary(_) => Exit::Retryable,
        VerifyError::Write(error) if error.is_retryable() => Exit::Retryable,
        VerifyError::Write(_) => Exit::RunFailed,
        VerifyError::Interrupted(code) => Exit::Signal(*code),
    }
}

impl From<VerifyError> for Failure {
    fn from(error: VerifyError) -> Self {
        Self::of(exit_of(&error), error.message())
    }
}
