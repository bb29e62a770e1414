//! A recorder on its own thread, so that the model advances while frames are encoded, compressed and written. The order of the
//! frames does not change; therefore, the bytes are the same.

use crate::error::RecordError;
use crate::file::RecordingFile;
use crate::frame::{Frame, LogLine};
use crate::recorder::{Clock, Outcome, Recorder, RecorderState};
use std::io::Write;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, JoinHandle};

/// Maximum number of frames in memory: one being filled, one being written, and two queued for a slow disk.
const FRAMES: usize = 4;
/// Maximum size of these frames in bytes. A larger frame is filled after the previous one has been written.
const FRAMES_BYTES: usize = 32 << 20;

/// A request to the thread.
enum Task<W: Write> {
    Write(Clock, Frame),
    Remark(LogLine),
    /// An action on the recorder, after all earlier requests.
    With(Action<W>),
}

type Action<W> = Box<dyn FnOnce(&Recorder<W>) + Send>;

/// Writes one recording, on its own thread where there are threads.
pub struct FrameWriter<W: Write> {
    place: Place<W>,
    frames: u64,
}

enum Place<W: Write> {
    Background(Background<W>),
    /// On the caller's thread, with the frame that is filled.
    Here(Box<Recorder<W>>, Frame),
}

/// The recorder's thread, and the frames that go there and back.
struct Background<W: Write> {
    tasks: Sender<Task<W>>,
    // Frames that have been written, empty.
    used: Receiver<Frame>,
    // `None` after its error was taken.
    thread: Option<JoinHandle<Result<Recorder<W>, RecordError>>>,
    // What every frame starts as.
    blank: Frame,
    // Frames in memory, and how many there may be.
    in_memory: usize,
    at_most: usize,
}

impl<W: Write + Send + 'static> FrameWriter<W> {
    /// Moves a recorder to its own thread; on `wasm32`, which has no threads, it stays on this one.
    #[must_use]
    pub fn start(recorder: Recorder<W>) -> Self {
        if cfg!(target_family = "wasm") {
            return Self::on_this_thread(recorder);
        }
        // The frames in memory are a bound for both.
        let (tasks, to_do) = channel();
        let (give_back, used) = channel();
        let (frames, blank) = (recorder.frames_written(), recorder.empty_frame());
        let thread = Some(thread::spawn(move || work(recorder, &to_do, &give_back)));
        let background = Background { tasks, used, thread, blank, in_memory: 0, at_most: FRAMES };
        Self { place: Place::Background(background), frames }
    }
}

impl<W: Write> FrameWriter<W> {
    /// Keeps a recorder on the caller's thread: the same bytes, and no frame is written while the model advances.
    #[must_use]
    pub fn on_this_thread(recorder: Recorder<W>) -> Self {
        let (frames, frame) = (recorder.frames_written(), recorder.empty_frame());
        Self { place: Place::Here(Box::new(recorder), frame), frames }
    }

    /// Queues the next frame. `fill` fills the empty frame; the call blocks while too many frames are queued.
    ///
    /// # Errors
    /// As [`Recorder::write`], for an earlier frame.
    pub fn write(
        &mut self,
        clock: Clock,
        fill: impl FnOnce(&mut Frame),
    ) -> Result<(), RecordError> {
        match &mut self.place {
            Place::Background(background) => background.write(clock, fill)?,
            Place::Here(recorder, frame) => {
                fill(frame);
                recorder.write(clock, frame)?;
                frame.clear();
            }
        }
        self.frames += 1;
        Ok(())
    }

    /// As [`Recorder::remark`].
    ///
    /// # Errors
    /// A sink that fails, now or before.
    pub fn remark(&mut self, line: LogLine) -> Result<(), RecordError> {
        match &mut self.place {
            Place::Background(background) => background.ask(Task::Remark(line)),
            Place::Here(recorder, _) => recorder.remark(line),
        }
    }

    /// Number of frames queued so far.
    #[must_use]
    pub fn frames_written(&self) -> u64 {
        self.frames
    }

    /// As [`Recorder::finish`], after all frames.
    ///
    /// # Errors
    /// A sink that fails; the recording is then torn.
    pub fn finish(self, outcome: &Outcome) -> Result<W, RecordError> {
        match self.place {
            Place::Background(background) => background.join()?.finish(outcome),
            Place::Here(recorder, _) => recorder.finish(outcome),
        }
    }
}

impl FrameWriter<RecordingFile> {
    /// As [`Recorder::save_point`], after all queued frames.
    ///
    /// # Errors
    /// A disk that fails, now or before.
    pub fn save_point(&mut self) -> Result<RecorderState, RecordError> {
        let background = match &mut self.place {
            Place::Background(background) => background,
            Place::Here(recorder, _) => return recorder.save_point(),
        };
        let (answer, answered) = channel();
        let task = move |recorder: &Recorder<RecordingFile>| {
            // An error means that the caller has stopped waiting.
            let _ = answer.send(recorder.save_point());
        };
        background.ask(Task::With(Box::new(task)))?;
        answered.recv().unwrap_or_else(|_| Err(background.failure()))
    }
}

impl<W: Write> Background<W> {
    fn write(&mut self, clock: Clock, fill: impl FnOnce(&mut Frame)) -> Result<(), RecordError> {
        let mut frame = self.empty_frame()?;
        fill(&mut frame);
        self.at_most = Ord::clamp(FRAMES_BYTES / Ord::max(frame.bytes(), 1), 1, FRAMES);
        self.ask(Task::Write(clock, frame))
    }

    /// An empty frame: one that has been written, or a new one if the maximum is not reached.
    fn empty_frame(&mut self) -> Result<Frame, RecordError> {
        loop {
            if self.in_memory < self.at_most {
                return Ok(self.used.try_recv().unwrap_or_else(|_| {
                    self.in_memory += 1;
                    self.blank.clone()
                }));
            }
            let frame = self.used.recv().map_err(|_| self.failure())?;
            if self.in_memory == self.at_most {
                return Ok(frame);
            }
            // Frames have grown.
            self.in_memory -= 1;
        }
    }

    fn ask(&mut self, task: Task<W>) -> Result<(), RecordError> {
        self.tasks.send(task).map_err(|_| self.failure())
    }

    /// Why the thread has ended early.
    fn failure(&mut self) -> RecordError {
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(Err(error))) => error,
            Some(Ok(Ok(_)) | Err(_)) | None => stopped(),
        }
    }

    /// Waits until the thread has finished all requests and returns the recorder.
    fn join(self) -> Result<Recorder<W>, RecordError> {
        drop(self.tasks);
        match self.thread.map(JoinHandle::join) {
            Some(Ok(recorder)) => recorder,
            Some(Err(_)) | None => Err(stopped()),
        }
    }
}

fn work<W: Write>(
    mut recorder: Recorder<W>,
    tasks: &Receiver<Task<W>>,
    give_back: &Sender<Frame>,
) -> Result<Recorder<W>, RecordError> {
    for task in tasks {
        match task {
            Task::Write(clock, mut frame) => {
                recorder.write(clock, &mut frame)?;
                frame.clear();
                // An error means that no further frame will be filled.
                let _ = give_back.send(frame);
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
