//! A recorder on its own thread, so that the model advances while frames are encoded, compressed and written. The order of the
//! frames does not change; therefore, the bytes are the same.

use crate::disc_drawing::DiscDrawing;
use crate::error::RecordError;
use crate::file::RecordingFile;
use crate::frame::{Frame, LogLine};
use crate::packing::WITHOUT_THREAD;
use crate::recorder::{Clock, Outcome, Recorder, RecorderState};
use std::io::Write;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

/// Bytes of frames that are handed to the thread together: waking it for each small frame would cost more than writing them.
const BATCH_BYTES: usize = 64 << 10;
/// Bytes of a batch from which the thread is started at once: one frame of this size takes longer to write than the thread to start.
const THREAD_BYTES: usize = 256 << 10;
/// Added to the bytes of each frame, so that many empty frames fill a batch, too.
const BYTES_PER_FRAME: usize = 256;
/// Time after which the next frame is handed over with those before it, whatever their size.
const BATCH_TIME: Duration = Duration::from_millis(10);
/// Maximum number of batches in memory: one being filled, one being written, and two queued for a slow disk.
const BATCHES: usize = 4;
/// Maximum size of these batches in bytes. A larger frame is filled after the previous one has been written.
const MAX_BYTES: usize = 32 << 20;

/// Frames that are handed to the thread together, in order.
type Batch = Vec<(Clock, Frame)>;

/// A request to the thread.
enum Task<W: Write> {
    Write(Batch),
    Remark(LogLine),
    /// An action on the recorder, after all earlier requests.
    With(Action<W>),
}

type Action<W> = Box<dyn FnOnce(&mut Recorder<W>) + Send>;

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
    worker: Worker<W>,
    /// The frames that were filled since the last batch, their bytes, and the bytes at which they are handed over.
    batch: Batch,
    batch_bytes: usize,
    batch_limit: usize,
    started: Instant,
    handed_over: Instant,
    /// Index of the next frame.
    next: u64,
    drawing: Option<Box<DiscDrawing>>,
    /// Frames that have been written, empty.
    spare: Vec<Frame>,
    /// What every frame starts as.
    blank: Frame,
    /// Number of batches in memory, and its maximum.
    in_memory: usize,
    at_most: usize,
}

/// Who writes the frames.
enum Worker<W: Write> {
    /// No thread yet.
    Waiting(Box<Recorder<W>>),
    Running {
        tasks: Sender<Task<W>>,
        // Batches that have been written, their frames empty.
        used: Receiver<Batch>,
        thread: JoinHandle<Result<Recorder<W>, RecordError>>,
    },
    /// Its error was taken.
    Failed,
}

impl<W: Write + Send + 'static> FrameWriter<W> {
    /// Moves a recorder to its own thread; on `wasm32`, which has no threads, it stays on this one.
    #[must_use]
    pub fn start(recorder: Recorder<W>) -> Self {
        if cfg!(target_family = "wasm") {
            return Self::on_this_thread(recorder);
        }
        let frames = recorder.frames_written();
        Self { place: Place::Background(Background::new(recorder)), frames }
    }
}

impl<W: Write> FrameWriter<W> {
    /// Keeps a recorder on the caller's thread: the same bytes, and no frame is written while the model advances.
    #[must_use]
    pub fn on_this_thread(recorder: Recorder<W>) -> Self {
        let (frames, frame) = (recorder.frames_written(), recorder.empty_frame());
        Self { place: Place::Here(Box::new(recorder), frame), frames }
    }

    /// Number of frames queued so far.
    #[must_use]
    pub fn frames_written(&self) -> u64 {
        self.frames
    }
}

impl<W: Write + Send + 'static> FrameWriter<W> {
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
            Place::Background(background) => background.remark(line),
            Place::Here(recorder, _) => recorder.remark(line),
        }
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
        let task = move |recorder: &mut Recorder<RecordingFile>| {
            // An error means that the caller has stopped waiting.
            let _ = answer.send(recorder.save_point());
        };
        background.ask(Task::With(Box::new(task)))?;
        answered.recv().unwrap_or_else(|_| Err(background.failure()))
    }
}

impl<W: Write> Background<W> {
    fn new(recorder: Recorder<W>) -> Self {
        Self {
            batch: Batch::new(),
            batch_bytes: 0,
            // A viewer sees every frame as soon as it is filled.
            batch_limit: if recorder.is_observed() { 0 } else { BATCH_BYTES },
            started: Instant::now(),
            handed_over: Instant::now(),
            next: recorder.frames_written(),
            drawing: recorder.disc_drawing().map(Box::new),
            spare: Vec::new(),
            blank: recorder.empty_frame(),
            in_memory: 0,
            at_most: BATCHES,
            worker: Worker::Waiting(Box::new(recorder)),
        }
    }

    /// An empty frame: one that has been written, or a new one.
    fn empty_frame(&mut self) -> Result<Frame, RecordError> {
        if self.batch.is_empty() {
            self.begin_batch()?;
        }
        Ok(self.spare.pop().unwrap_or_else(|| self.blank.clone()))
    }

    /// Waits until the maximum number of batches allows another one.
    fn begin_batch(&mut self) -> Result<(), RecordError> {
        while self.take_back(self.in_memory >= self.at_most)? {}
        self.in_memory += 1;
        Ok(())
    }

    /// Takes back a batch that has been written, if there is one, or else waits for it.
    fn take_back(&mut self, waits: bool) -> Result<bool, RecordError> {
        let Worker::Running { used, .. } = &self.worker else { return Ok(false) };
        let written = match waits {
            true => Some(used.recv().map_err(|_| self.failure())?),
            false => used.try_recv().ok(),
        };
        let Some(written) = written else { return Ok(false) };
        self.in_memory -= 1;
        // Otherwise, frames have grown.
        if self.in_memory < self.at_most {
            self.spare.extend(written.into_iter().map(|(_, frame)| frame));
        }
        Ok(true)
    }

    /// Why the thread has ended early.
    fn failure(&mut self) -> RecordError {
        match std::mem::replace(&mut self.worker, Worker::Failed) {
            Worker::Running { thread, .. } => thread
                .join()
                .map_or_else(|_| stopped(), |ended| ended.err().unwrap_or_else(stopped)),
            Worker::Waiting(_) | Worker::Failed => stopped(),
        }
    }
}

impl<W: Write + Send + 'static> Background<W> {
    fn write(&mut self, clock: Clock, fill: impl FnOnce(&mut Frame)) -> Result<(), RecordError> {
        let mut frame = self.empty_frame()?;
        fill(&mut frame);
        self.batch_bytes += frame.bytes() + BYTES_PER_FRAME;
        self.batch.push((clock, frame));
        self.next += 1;
        if self.batch_bytes >= self.batch_limit || self.handed_over.elapsed() >= BATCH_TIME {
            self.hand_over()?;
        }
        Ok(())
    }

    /// Draws the discs of the batch if the thread is so far behind that the next batch would wait for it, unless the drawings of all
    /// batches would be too large.
    fn draw_if_behind(&mut self) -> Result<(), RecordError> {
        while self.take_back(false)? {}
        let Some(drawing) = &self.drawing else { return Ok(()) };
        let drawn = self.batch.iter().map(|(_, frame)| drawing.max_bytes(frame)).sum::<usize>();
        let fits = self.batch_bytes.saturating_add(drawn) <= MAX_BYTES / BATCHES;
        if self.in_memory >= self.at_most && fits {
            let first = self.next - self.batch.len() as u64;
            for ((_, frame), index) in self.batch.iter_mut().zip(first..) {
                drawing.encode(frame, index);
            }
        }
        Ok(())
    }

    fn hand_over(&mut self) -> Result<(), RecordError> {
        if self.batch.is_empty() || self.write_here()? {
            return Ok(());
        }
        self.at_most = Ord::clamp(MAX_BYTES / self.batch_bytes, 1, BATCHES);
        self.draw_if_behind()?;
        let batch = std::mem::take(&mut self.batch);
        self.batch_bytes = 0;
        self.handed_over = Instant::now();
        self.send(Task::Write(batch))
    }

    /// Writes the batch on this thread, if the time for another one has not come; returns whether it did.
    fn write_here(&mut self) -> Result<bool, RecordError> {
        let Worker::Waiting(recorder) = &mut self.worker else { return Ok(false) };
        if self.started.elapsed() >= WITHOUT_THREAD || self.batch_bytes >= THREAD_BYTES {
            return Ok(false);
        }
        for (clock, mut frame) in self.batch.drain(..) {
            recorder.write(clock, &mut frame)?;
            frame.clear();
            self.spare.push(frame);
        }
        self.in_memory = 0;
        self.batch_bytes = 0;
        self.handed_over = Instant::now();
        Ok(true)
    }

    fn remark(&mut self, line: LogLine) -> Result<(), RecordError> {
        self.hand_over()?;
        match &mut self.worker {
            Worker::Waiting(recorder) => recorder.remark(line),
            _ => self.send(Task::Remark(line)),
        }
    }

    /// A request after all frames so far.
    fn ask(&mut self, task: Task<W>) -> Result<(), RecordError> {
        self.hand_over()?;
        self.send(task)
    }

    fn send(&mut self, task: Task<W>) -> Result<(), RecordError> {
        self.start()?;
        match &self.worker {
            Worker::Running { tasks, .. } => tasks.send(task).map_err(|_| self.failure()),
            Worker::Waiting(_) | Worker::Failed => Err(stopped()),
        }
    }

    fn start(&mut self) -> Result<(), RecordError> {
        self.worker = match std::mem::replace(&mut self.worker, Worker::Failed) {
            Worker::Waiting(recorder) => {
                // The batches in memory are a bound for both.
                let (tasks, to_do) = channel();
                let (give_back, used) = channel();
                let work = move || work(*recorder, &to_do, &give_back);
                let thread = Builder::new().spawn(work).map_err(RecordError::Thread)?;
                Worker::Running { tasks, used, thread }
            }
            worker => worker,
        };
        Ok(())
    }

    /// Waits until the thread has finished all requests and returns the recorder.
    fn join(mut self) -> Result<Recorder<W>, RecordError> {
        if let Worker::Waiting(mut recorder) = self.worker {
            for (clock, frame) in &mut self.batch {
                recorder.write(*clock, frame)?;
            }
            return Ok(*recorder);
        }
        self.hand_over()?;
        match self.worker {
            Worker::Running { tasks, thread, .. } => {
                drop(tasks);
                thread.join().unwrap_or_else(|_| Err(stopped()))
            }
            Worker::Waiting(_) | Worker::Failed => Err(stopped()),
        }
    }
}

fn work<W: Write>(
    mut recorder: Recorder<W>,
    tasks: &Receiver<Task<W>>,
    give_back: &Sender<Batch>,
) -> Result<Recorder<W>, RecordError> {
    for task in tasks {
        match task {
            Task::Write(mut batch) => {
                for (clock, frame) in &mut batch {
                    recorder.write(*clock, frame)?;
                    frame.clear();
                }
                // An error means that no further frame will be filled.
                let _ = give_back.send(batch);
            }
            Task::Remark(line) => recorder.remark(line)?,
            Task::With(action) => action(&mut recorder),
        }
    }
    Ok(recorder)
}

fn stopped() -> RecordError {
    RecordError::Container("the recorder has stopped".to_owned())
}
