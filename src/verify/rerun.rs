//! A run that is executed again: recorded into a sink, or only advanced.

use crate::interrupt::Interrupt;
use crate::run::prepared::Prepared;
use crate::run::{RunState, record_frames, record_now};
use crate::verify::error::VerifyError;
use kinetoscope_physics::model::{Model, Progress, SimulationFault, Target};
use kinetoscope_recording::background::FrameWriter;
use kinetoscope_recording::error::RecordError;
use kinetoscope_recording::observer::FrameObserver;
use kinetoscope_recording::reader::{Outcome, StoredFrames};
use kinetoscope_recording::recorder::Recorder;
use std::io::Write;

/// Steps of one call, after which an interrupt is noticed.
const BUDGET: u64 = 10_000;

/// A run that is executed again and recorded.
pub(crate) struct Rerun<'a> {
    /// The model and the header of the recording.
    pub(crate) start: Prepared,
    interrupt: &'a Interrupt,
    /// Ends this rerun without a signal.
    pub(crate) stop: Interrupt,
    /// The first frame to record. Unless it is the start, the model is past the frame before it.
    pub(crate) first: u64,
    /// The frame after which the rerun ends, and its outcome then. Without it, the rerun ends with the run.
    pub(crate) last: Option<(u64, Outcome)>,
    /// Whether the recording may continue after the end of the rerun.
    pub(crate) is_part: bool,
    /// Receives the messages, and the state of the model at the keyframes of `keyframes_of`.
    pub(crate) observer: Option<Box<dyn FrameObserver>>,
    pub(crate) keyframes_of: StoredFrames,
}

/// What a rerun has recorded.
pub(crate) struct Recorded<W> {
    pub(crate) sink: W,
    pub(crate) frames: u64,
    pub(crate) outcome: Outcome,
}

impl<'a> Rerun<'a> {
    /// The whole run.
    pub(crate) fn new(start: Prepared, interrupt: &'a Interrupt) -> Self {
        let stop = interrupt.with_own_stop();
        let keyframes_of = start.header.stored;
        let (first, last, is_part, observer) = (0, None, false, None);
        Self { start, interrupt, stop, first, last, is_part, observer, keyframes_of }
    }

    /// Executes and records the run. `between` is called between two parts of the work.
    ///
    /// # Errors
    /// A sink that fails, or a signal.
    pub(crate) fn record<W: Write + Send + 'static>(
        self,
        sink: W,
        on_frame: &(dyn Fn(u64, u64) + Sync),
        between: impl FnMut(&RunState<W>) -> Result<(), RecordError>,
    ) -> Result<Recorded<W>, VerifyError> {
        let interrupt = self.interrupt;
        let recorded = self.record_unless_stopped(sink, on_frame, between);
        match interrupt.exit_code() {
            Some(code) => Err(VerifyError::Interrupted(code)),
            None => Ok(recorded?),
        }
    }

    fn record_unless_stopped<W: Write + Send + 'static>(
        self,
        sink: W,
        on_frame: &(dyn Fn(u64, u64) + Sync),
        mut between: impl FnMut(&RunState<W>) -> Result<(), RecordError>,
    ) -> Result<Recorded<W>, RecordError> {
        let Self { start, first, stop, last, observer, keyframes_of, .. } = self;
        let stop_after = |frame| {
            if last.as_ref().is_some_and(|(last, _)| *last == frame) {
                stop.stop();
            }
        };
        stop_after(0);
        let mut recorder = Recorder::create(sink, &start.header)?;
        if let Some(observer) = observer {
            recorder.show_to(observer)?;
        }
        let writer = FrameWriter::start(recorder.at_frame(first));
        let next = if first == 0 { 1 } else { first };
        let mut state = RunState::new(start, writer, next).with_keyframes_of(keyframes_of);
        if first == 0 {
            record_now(&mut state)?;
        }
        let on_frame = |frame, of| {
            stop_after(frame);
            on_frame(frame, of);
        };
        let outcome = record_frames(&mut state, &stop, &on_frame, |state, _| between(state))?;
        let outcome = match (outcome, &last) {
            (Outcome::Interrupted, Some((_, outcome))) => outcome.clone(),
            (outcome, _) => outcome,
        };
        let frames = state.recorder.frames_written();
        Ok(Recorded { sink: state.recorder.finish(&outcome)?, frames, outcome })
    }
}

/// Why a model did not reach its target.
pub(crate) enum Stopped {
    /// The program received a signal.
    Signal(u8),
    /// The physics failed.
    Fault(SimulationFault),
}

/// Advances a model to a target.
///
/// # Errors
/// Physics that fails, or a signal.
pub(crate) fn advance(
    model: &mut dyn Model,
    target: Target,
    interrupt: &Interrupt,
) -> Result<(), Stopped> {
    loop {
        match model.advance(target, BUDGET) {
            Ok(Progress::Reached) => return Ok(()),
            Ok(Progress::Working) => {}
            Err(fault) => return Err(Stopped::Fault(fault)),
        }
        if let Some(code) = interrupt.exit_code() {
            return Err(Stopped::Signal(code));
        }
    }
}
