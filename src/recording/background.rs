//! A recorder on a thread of its own: the model goes on while frames are filled from snapshots, encoded, compressed and
//! written. They come in the same order, hence the bytes are the same.

use crate::error::RecordError;
use crate::file::RecordingFile;
use crate::frame::{LogLine, Snapshot};
use crate::recorder::{Clock, Outcome, Recorder, RecorderState};
use std::io::Write;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{self, JoinHandle};

/// Snapshots on their way: one that is written and one that waits.
const UNDER_WAY: usize = 2;

/// What the thread is asked for.
enum Task<W: Write, S> {
    Write(Clock, S),
    Remark(LogLine),
    /// Anything that needs the recorder itself, after all that was asked before.
    With(Action<W>),
}

type Action<W> = Box<dyn FnOnce(&Recorder<W>) + Send>;

/// Writes one recording beside the caller's work, on a thread of its own.
pub struct FrameWriter<W: Write, S> {
    tasks: SyncSender<Task<W, S>>,
    used: Receiver<S>,
    // Gone once it has been asked why it ended.
    thread: Option<JoinHandle<Result<Recorder<W>, RecordError>>>,
    frames: u64,
}

impl<W: Write + Send + 'static, S: Snapshot> FrameWriter<W, S> {
    /// Gives a recorder a thread of its own.
    #[must_use]
    pub fn start(recorder: Recorder<W>) -> Self {
        let (tasks, to_do) = sync_channel(UNDER_WAY);
        // One snapshot more than can be under way: giving one back never waits.
        let (give_back, used) = sync_channel(UNDER_WAY + 2);
        let frames = recorder.frames_written();
        let thread = Some(thread::spawn(move || work(recorder, &to_do, &give_back)));
        Self { tasks, used, thread, frames }
    }
}

impl<W: Write, S: Snapshot> FrameWriter<W, S> {
    /// A snapshot to take the next frame with: one that a frame has been filled from, where there is one.
    #[must_use]
    pub fn snapshot(&self) -> S {
        self.used.try_recv().unwrap_or_default()
    }

    /// Writes the next frame after all that was handed over before.
    ///
    /// # Errors
    /// As [`Recorder::write`], of this frame or of one handed over before.
    pub fn write(&mut self, clock: Clock, snapshot: S) -> Result<(), RecordError> {
        self.ask(Task::Write(clock, snapshot))?;
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

    fn ask(&mut self, task: Task<W, S>) -> Result<(), RecordError> {
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

impl<S: Snapshot> FrameWriter<RecordingFile, S> {
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

fn work<W: Write, S: Snapshot>(
    mut recorder: Recorder<W>,
    tasks: &Receiver<Task<W, S>>,
    give_back: &SyncSender<S>,
) -> Result<Recorder<W>, RecordError> {
    let mut frame = recorder.empty_frame();
    for task in tasks {
        match task {
            Task::Write(clock, mut snapshot) => {
                snapshot.fill(&mut frame);
                // At once, so that the next frame is taken with it; a full channel means that there are snapshots enough.
                let _ = give_back.try_send(snapshot);
                recorder.write(clock, &mut frame)?;
                frame.clear();
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
