//! A recorder on a thread of its own: the model goes on while frames are encoded, compressed and written. The frames come
//! in the same order, hence the bytes are the same.

use crate::error::RecordError;
use crate::file::RecordingFile;
use crate::frame::{Frame, LogLine};
use crate::recorder::{Clock, Outcome, Recorder, RecorderState};
use std::io::Write;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{self, JoinHandle};

/// Frames on their way: one that is written and one that waits.
const FRAMES_UNDER_WAY: usize = 2;

/// What the thread is asked for.
enum Task<W: Write> {
    Write(Clock, Frame),
    Remark(LogLine),
    /// Anything that needs the recorder itself, after all that was asked before.
    With(Action<W>),
}

type Action<W> = Box<dyn FnOnce(&Recorder<W>) + Send>;

/// Writes one recording beside the caller's work, on a thread of its own.
pub struct FrameWriter<W: Write> {
    tasks: SyncSender<Task<W>>,
    used_frames: Receiver<Frame>,
    // Gone once it has been asked why it ended.
    thread: Option<JoinHandle<Result<Recorder<W>, RecordError>>>,
    frames: u64,
}

impl<W: Write + Send + 'static> FrameWriter<W> {
    /// Gives a recorder a thread of its own.
    #[must_use]
    pub fn start(recorder: Recorder<W>) -> Self {
        let (tasks, to_do) = sync_channel(FRAMES_UNDER_WAY);
        // One frame more than can be under way: giving one back never waits.
        let (give_back, used_frames) = sync_channel(FRAMES_UNDER_WAY + 2);
        let frames = recorder.frames_written();
        let thread = Some(thread::spawn(move || work(recorder, &to_do, &give_back)));
        Self { tasks, used_frames, thread, frames }
    }
}

impl<W: Write> FrameWriter<W> {
    /// Writes the next frame after all that was handed over before; the frame comes back empty, perhaps as another one.
    ///
    /// # Errors
    /// As [`Recorder::write`], of this frame or of one handed over before.
    pub fn write(&mut self, clock: Clock, frame: &mut Frame) -> Result<(), RecordError> {
        let empty = self.used_frames.try_recv().unwrap_or_default();
        self.ask(Task::Write(clock, std::mem::replace(frame, empty)))?;
        self.frames += 1;
        Ok(())
    }

    /// As [`Recorder::remark`].
    ///
    /// # Errors
    /// A sink that fails, now or before.
    pub fn remark(&mut self, line: LogLine) -> Result<(), RecordError> {
        self.ask(Task::Remark(line))
    }

    /// Frames handed over so far.
    #[must_use]
    pub fn frames_written(&self) -> u64 {
        self.frames
    }

    /// As [`Recorder::finish`], after all frames.
    ///
    /// # Errors
    /// A sink that fails; the recording is then torn.
    pub fn finish(self, outcome: &Outcome) -> Result<W, RecordError> {
        self.join()?.finish(outcome)
    }

    fn ask(&mut self, task: Task<W>) -> Result<(), RecordError> {
        self.tasks.send(task).map_err(|_| self.failure())
    }

    /// Why the thread has ended before it was asked to.
    fn failure(&mut self) -> RecordError {
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(Err(error))) => error,
            Some(Ok(Ok(_)) | Err(_)) | None => stopped(),
        }
    }

    /// Lets the thread do what is left and takes the recorder back.
    fn join(self) -> Result<Recorder<W>, RecordError> {
        drop(self.tasks);
        match self.thread.map(JoinHandle::join) {
            Some(Ok(recorder)) => recorder,
            Some(Err(_)) | None => Err(stopped()),
        }
    }
}

impl FrameWriter<RecordingFile> {
    /// As [`Recorder::save_point`], after all frames handed over so far.
    ///
    /// # Errors
    /// A disk that fails, now or before.
    pub fn save_point(&mut self) -> Result<RecorderState, RecordError> {
        let (answer, answered) = sync_channel(1);
        let task = move |recorder: &Recorder<RecordingFile>| {
            // Nobody listens only where the caller is gone.
            let _ = answer.send(recorder.save_point());
        };
        self.ask(Task::With(Box::new(task)))?;
        answered.recv().unwrap_or_else(|_| Err(self.failure()))
    }
}

fn work<W: Write>(
    mut recorder: Recorder<W>,
    tasks: &Receiver<Task<W>>,
    give_back: &SyncSender<Frame>,
) -> Result<Recorder<W>, RecordError> {
    for task in tasks {
        match task {
            Task::Write(clock, mut frame) => {
                recorder.write(clock, &frame)?;
                frame.clear();
                // A full channel means that there are frames enough.
                let _ = give_back.try_send(frame);
            }
            Task::Remark(line) => recorder.remark(line)?,
            Task::With(action) => action(&recorder),
        }
    }
    Ok(recorder)
}

fn stopped() -> RecordError {
    RecordError::Container("the recorder has stopped".to_owned())
}
