//! One run: prepare the model, move it from frame to frame, record, and end in order whatever happens.

pub mod benchmark;
pub mod checkpoint;
pub mod schedule;

use crate::interrupt::Interrupt;
use crate::live::Live;
use crate::run::schedule::Schedule;
use checkpoint::{Checkpointer, NeverSaved, Safekeeping, Underway};
use kinetoscope_manifest::RunManifest;
use kinetoscope_manifest::record::{Compression, RecordConfig};
use kinetoscope_physics::model::{Extent, Fault, Model, Progress, Refusal, Target};
use kinetoscope_physics::random::Seed;
use kinetoscope_physics::{ForModel, with_model};
use kinetoscope_recording::background::FrameWriter;
use kinetoscope_recording::checkpoint as checkpoint_file;
use kinetoscope_recording::error::RecordError;
use kinetoscope_recording::file::RecordingFile;
use kinetoscope_recording::frame::{Frame, Level, LogLine};
use kinetoscope_recording::layout::layout_json;
use kinetoscope_recording::recorder::{self, Clock, Header, Outcome, Recorder, Selection};
use kinetoscope_recording::scenery::Scenery;
use std::fmt;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// One run to be done: what, and where its recording goes.
#[derive(Clone, Copy, Debug)]
pub struct Assignment<'a> {
    /// Model, seed, replicate and what to record.
    pub manifest: &'a RunManifest,
    /// The canonical text of `manifest`, embedded in the recording.
    pub canonical: &'a str,
    /// The run's content key.
    pub content_key: &'a str,
    /// The folder of the recording.
    pub folder: &'a Path,
    /// The recording's file name without its ending.
    pub stem: &'a str,
}

/// How a run ended that left a readable recording.
#[derive(Clone, Debug)]
pub struct Ending {
    /// Complete, at fault, or interrupted.
    pub outcome: Outcome,
    /// Whether something was there to go on with.
    pub beginning: Beginning,
    /// Where the recording is.
    pub path: PathBuf,
    /// Frames recorded, the start included.
    pub frames: u64,
    /// Size of the recording.
    pub bytes: u64,
    /// Steps or events done.
    pub work: u64,
    /// Time that it took.
    pub wall_time: Duration,
}

/// How a run began.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Beginning {
    /// Nothing was there.
    Anew,
    /// What was there was of no use, for this reason.
    AnewAfter(String),
    /// It went on from a checkpoint.
    WentOn {
        /// The first frame that was recorded since.
        frame: u64,
    },
}

/// How runs are conducted. Nothing of it changes a byte of the recording.
#[derive(Clone, Copy)]
pub struct Conduct<'a> {
    /// Whether to stop.
    pub interrupt: &'a Interrupt,
    /// Time between two checkpoints, at least.
    pub checkpoint_every: Duration,
    /// Hears how many frames after the start are done and how many there will be.
    pub on_frame: &'a (dyn Fn(u64, u64) + Sync),
    /// Where viewers watch one run at a time, if anywhere.
    pub live: Option<&'a Live>,
}

/// Why a run left no usable recording.
#[derive(Debug)]
pub enum RunError {
    /// The start can't be built or can't be run.
    Refused(Refusal),
    /// The recording could not be written.
    Record(RecordError),
}

impl fmt::Display for RunError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused(refusal) => refusal.fmt(formatter),
            Self::Record(error) => error.fmt(formatter),
        }
    }
}

impl std::error::Error for RunError {}

impl From<Refusal> for RunError {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}

impl From<RecordError> for RunError {
    fn from(error: RecordError) -> Self {
        Self::Record(error)
    }
}

/// What can be said of a run before it is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Frames, the start included.
    pub frames: u64,
    /// Particles, those that enter while it runs among them.
    pub particles: u64,
    /// Upper estimate of the recording's size, without a series that is recorded only on request.
    pub bytes: u64,
    /// Whether such a series comes on top: how many collisions or contacts there will be is not known before.
    pub has_series_on_request: bool,
    /// Height of what a viewer shows, in the state's length unit.
    pub view_height: f64,
    /// Length of the run, as the model counts it.
    pub extent: Extent,
    /// How long the run takes beside the others of its experiment: particle steps, particle times, or events.
    pub relative_cost: f64,
    /// Memory that the run may take.
    pub memory_bytes: u64,
}

/// Schemas, manifest, index and summary of a recording: 16 to 20 KiB with all channels.
const BYTES_BESIDE_FRAMES: u64 = 24 << 10;
/// Memory of a run without particles: the program, and the chunk that its recorder fills.
const PROGRAM_BYTES: u64 = 64 << 20;
/// A model, its neighbors or events, and what is between it and its recorder, as a number of recorded frames. The most that was
/// seen of 10^6 particles is 3.5, of a bed that begins with a recording; 3.3 of one that tells its contact forces.
const FRAMES_IN_MEMORY: u64 = 8;

/// Builds the start as [`execute`] would, and says what the run will be.
///
/// # Errors
/// The model's or the schedule's refusal.
pub fn estimate(manifest: &RunManifest) -> Result<Estimate, Refusal> {
    struct Action<'a>(&'a RunManifest);
    impl ForModel for Action<'_> {
        type Output = Result<Estimate, Refusal>;
        fn call<M: Model>(self, config: &M::Config) -> Self::Output {
            let model = M::prepare(config, seed(self.0), false)?;
            let schedule = Schedule::new(self.0.record.interval, model.extent())?;
            let header = header(&model, self.0, String::new(), String::new());
            header.check().map_err(|error| Refusal(error.to_string()))?;
            let mut start = Frame::new();
            model.observe(&mut start);
            let columns = M::STATE_COLUMNS.len();
            let particles = (start.state().len() / columns) as u64 + model.particles_to_come();
            let frames = schedule.frames() + 1;
            let bytes_of_a_frame = bytes_of_a_frame(&start, particles, columns);
            Ok(Estimate {
                frames,
                particles,
                bytes: BYTES_BESIDE_FRAMES + frames * bytes_of_a_frame,
                has_series_on_request: wants_opt_in::<M>(&self.0.record),
                view_height: view_height(&model.scenery()),
                extent: model.extent(),
                relative_cost: relative_cost(model.extent(), particles),
                memory_bytes: PROGRAM_BYTES + FRAMES_IN_MEMORY * bytes_of_a_frame,
            })
        }
    }
    with_model(&manifest.model, Action(manifest))
}

fn relative_cost(extent: Extent, particles: u64) -> f64 {
    match extent {
        Extent::Steps { total, .. } => total as f64 * particles as f64,
        Extent::Time(duration) => duration * particles as f64,
        Extent::Events(events) => events as f64,
    }
}

/// The state as it is, the drawing at its measured size when compressed (about 50 bytes a disc), and the headers.
fn bytes_of_a_frame(frame: &Frame, particles: u64, columns: usize) -> u64 {
    let state = particles * (columns * size_of::<f64>()) as u64;
    let scalars: u64 = frame.messages().iter().map(|message| message.payload.len() as u64).sum();
    let headers = 100 * (frame.messages().len() as u64 + 4);
    state + 50 * particles + scalars + headers
}

/// Does one run, or goes on with it.
///
/// # Errors
/// A refused start, or a recording that could not be written. A physical fault and an interruption are endings.
pub fn execute(assignment: Assignment<'_>, conduct: Conduct<'_>) -> Result<Ending, RunError> {
    struct Action<'a>(Assignment<'a>, Conduct<'a>);
    impl ForModel for Action<'_> {
        type Output = Result<Ending, RunError>;
        fn call<M: Model>(self, config: &M::Config) -> Self::Output {
            drive::<M>(config, self.0, self.1)
        }
    }
    with_model(&assignment.manifest.model, Action(assignment, conduct))
}

/// A run to be done again: what its recording says of itself.
#[derive(Clone, Copy, Debug)]
pub struct Replay<'a> {
    /// Model, seed, replicate and what to record.
    pub manifest: &'a RunManifest,
    /// The text of `manifest` as the recording has it.
    pub embedded: &'a str,
    /// The content key as the recording has it.
    pub content_key: &'a str,
}

/// Does a run as [`execute`] would and records it into any sink, which it gives back with how the run ended.
///
/// # Errors
/// A refused start, or a sink that fails.
pub fn replay_into<W: Write + Send + 'static>(
    replay: Replay<'_>,
    sink: W,
    interrupt: &Interrupt,
    on_frame: &(dyn Fn(u64, u64) + Sync),
) -> Result<(W, Outcome), RunError> {
    struct Action<'a, W>(Replay<'a>, W, &'a Interrupt, &'a (dyn Fn(u64, u64) + Sync));
    impl<W: Write + Send + 'static> ForModel for Action<'_, W> {
        type Output = Result<(W, Outcome), RunError>;
        fn call<M: Model>(self, config: &M::Config) -> Self::Output {
            let Self(Replay { manifest, embedded, content_key }, sink, interrupt, on_frame) = self;
            let model = M::prepare(config, seed(manifest), wants_opt_in::<M>(&manifest.record))?;
            let schedule = Schedule::new(manifest.record.interval, model.extent())?;
            let header = header(&model, manifest, embedded.to_owned(), content_key.to_owned());
            let mut underway =
                record_start(model, FrameWriter::start(Recorder::create(sink, &header)?))?;
            let outcome =
                record_frames(&mut underway, &schedule, &mut NeverSaved, interrupt, on_frame)?;
            Ok((underway.recorder.finish(&outcome)?, outcome))
        }
    }
    with_model(&replay.manifest.model, Action(replay, sink, interrupt, on_frame))
}

/// The layout for the viewer that goes with a run, as JSON.
///
/// # Errors
/// The model's or the schedule's refusal, or a template that does not fit the model.
pub fn layout(manifest: &RunManifest) -> Result<String, RunError> {
    struct Action<'a>(&'a RunManifest);
    impl ForModel for Action<'_> {
        type Output = Result<String, RunError>;
        fn call<M: Model>(self, config: &M::Config) -> Self::Output {
            let model = M::prepare(config, seed(self.0), false)?;
            let header = header(&model, self.0, String::new(), String::new());
            Ok(layout_json(&header)?)
        }
    }
    with_model(&manifest.model, Action(manifest))
}

fn view_height(scenery: &Scenery) -> f64 {
    let [[_, bottom], [_, top]] = scenery.view;
    top - bottom
}

fn drive<M: Model>(
    config: &M::Config,
    assignment: Assignment<'_>,
    conduct: Conduct<'_>,
) -> Result<Ending, RunError> {
    let started = Instant::now();
    let Assignment { manifest, folder, stem, content_key, .. } = assignment;
    let identity = format!(
        "{content_key} program {} {} physics {}",
        env!("CARGO_PKG_VERSION"),
        M::NAME,
        M::PHYSICS_VERSION
    );
    let (mut underway, beginning) = begin::<M>(config, assignment, &identity, conduct.live)?;
    let schedule = Schedule::new(manifest.record.interval, underway.model.extent())?;
    let every = conduct.checkpoint_every;
    let mut checkpointer = Checkpointer::new(folder, stem, identity, every);
    let Conduct { interrupt, on_frame, .. } = conduct;
    let outcome = record_frames(&mut underway, &schedule, &mut checkpointer, interrupt, on_frame)?;
    let frames = underway.recorder.frames_written();
    let work = underway.model.count();
    let file = underway.recorder.finish(&outcome)?;
    let path = match outcome {
        Outcome::Interrupted => file.keep_partial()?,
        Outcome::Complete | Outcome::Fault(_) => {
            let path = file.final_path().to_owned();
            file.commit()?;
            checkpoint_file::remove(folder, stem)?;
            path
        }
    };
    Ok(Ending {
        outcome,
        beginning,
        bytes: fs::metadata(&path).map(|file| file.len()).unwrap_or_default(),
        path,
        frames,
        work,
        wall_time: started.elapsed(),
    })
}

/// Goes on with what a killed or stopped run left, or starts anew where there is nothing or it is of no use.
fn begin<M: Model>(
    config: &M::Config,
    assignment: Assignment<'_>,
    identity: &str,
    live: Option<&Live>,
) -> Result<(Underway<M>, Beginning), RunError> {
    let Assignment { manifest, canonical, content_key, folder, stem } = assignment;
    let header = |model: &M| header(model, manifest, canonical.to_owned(), content_key.to_owned());
    let spectator = || live.and_then(|live| live.spectator(stem));
    let beginning = match checkpoint::go_on(folder, stem, identity, header, spectator) {
        Ok(Some(underway)) => {
            let beginning = Beginning::WentOn { frame: underway.next };
            return Ok((underway, beginning));
        }
        Ok(None) => Beginning::Anew,
        Err(error @ RecordError::Locked { .. }) => return Err(error.into()),
        Err(error) => Beginning::AnewAfter(error.to_string()),
    };
    let model = M::prepare(config, seed(manifest), wants_opt_in::<M>(&manifest.record))?;
    Schedule::new(manifest.record.interval, model.extent())?;
    let file = RecordingFile::create(folder, stem)?;
    // From here on an older checkpoint would count on bytes that are gone.
    checkpoint_file::remove(folder, stem)?;
    let mut recorder = Recorder::create_resumable(file, &header(&model))?;
    if let Some(spectator) = spectator() {
        recorder.show_to(spectator)?;
    }
    Ok((record_start(model, FrameWriter::start(recorder))?, beginning))
}

fn record_start<M: Model, W: Write>(
    model: M,
    mut recorder: FrameWriter<W>,
) -> Result<Underway<M, W>, RecordError> {
    record_now(&model, &mut recorder)?;
    Ok(Underway { model, recorder, next: 1 })
}

fn record_now<M: Model, W: Write>(
    model: &M,
    recorder: &mut FrameWriter<W>,
) -> Result<(), RecordError> {
    recorder.write(clock(model), |frame| model.observe(frame))
}

fn record_frames<M: Model, W: Write>(
    underway: &mut Underway<M, W>,
    schedule: &Schedule,
    safekeeping: &mut impl Safekeeping<M, W>,
    interrupt: &Interrupt,
    on_frame: &(dyn Fn(u64, u64) + Sync),
) -> Result<Outcome, RecordError> {
    let mut budget = Budget::default();
    while underway.next <= schedule.frames() {
        let target = schedule.target(underway.next);
        match advance_to(underway, target, &mut budget, safekeeping, interrupt)? {
            Ok(Arrival::Reached) => {}
            Ok(Arrival::Interrupted) => {
                safekeeping.save(underway)?;
                return Ok(Outcome::Interrupted);
            }
            Err(fault) => {
                let line = LogLine { level: Level::Error, text: fault.0.clone() };
                underway.recorder.remark(line)?;
                return Ok(Outcome::Fault(fault.0));
            }
        }
        record_now(&underway.model, &mut underway.recorder)?;
        on_frame(underway.next, schedule.frames());
        underway.next += 1;
        safekeeping.save_if_due(underway)?;
    }
    Ok(Outcome::Complete)
}

enum Arrival {
    Reached,
    Interrupted,
}

fn advance_to<M: Model, W: Write>(
    underway: &mut Underway<M, W>,
    target: Target,
    budget: &mut Budget,
    safekeeping: &mut impl Safekeeping<M, W>,
    interrupt: &Interrupt,
) -> Result<Result<Arrival, Fault>, RecordError> {
    loop {
        if interrupt.is_raised() {
            return Ok(Ok(Arrival::Interrupted));
        }
        let started = Instant::now();
        let progress = match underway.model.advance(target, budget.steps) {
            Ok(progress) => progress,
            Err(fault) => return Ok(Err(fault)),
        };
        budget.adapt(started.elapsed());
        if progress == Progress::Reached {
            return Ok(Ok(Arrival::Reached));
        }
        safekeeping.save_if_due(underway)?;
    }
}

/// How much work a model is given at once: enough to be fast, little enough that a signal is served soon. How work is
/// cut does not change a bit of the trajectory, so the clock may decide.
struct Budget {
    steps: u64,
}

impl Default for Budget {
    fn default() -> Self {
        Self { steps: 1 }
    }
}

impl Budget {
    const SHORT: Duration = Duration::from_millis(20);
    const LONG: Duration = Duration::from_millis(100);

    fn adapt(&mut self, took: Duration) {
        if took < Self::SHORT {
            self.steps = self.steps.saturating_mul(2);
        } else if took > Self::LONG {
            self.steps = (self.steps / 2).max(1);
        }
    }
}

fn clock<M: Model>(model: &M) -> Clock {
    Clock { count: model.count(), time: model.time() }
}

fn seed(manifest: &RunManifest) -> Seed {
    Seed { seed: manifest.seed, replicate: manifest.replicate }
}

/// Whether the manifest names a channel that is recorded only on request.
fn wants_opt_in<M: Model>(record: &RecordConfig) -> bool {
    let mut on_request = M::CHANNELS.iter().filter(|channel| channel.opt_in);
    on_request.any(|channel| {
        let name = channel.topic.trim_start_matches('/');
        record.channels.iter().flatten().any(|wanted| wanted == name)
    })
}

fn header<M: Model>(
    model: &M,
    manifest: &RunManifest,
    canonical: String,
    content_key: String,
) -> Header {
    let record = &manifest.record;
    let schedule = Schedule::new(record.interval, model.extent()).ok();
    Header {
        manifest: canonical,
        content_key,
        model: M::NAME,
        physics_version: M::PHYSICS_VERSION,
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        time_unit: M::TIME_UNIT,
        state_columns: M::STATE_COLUMNS,
        channels: model.channels(),
        selection: match &record.channels {
            None => Selection::All,
            Some(channels) => Selection::Named(channels.clone()),
        },
        scenery: model.scenery(),
        playback_rate: record.playback_rate.get(),
        drawn_particles: record.drawn_particles,
        compression: match record.compression {
            Compression::Zstd => recorder::Compression::Zstd,
            Compression::Zstd3 => recorder::Compression::Zstd3,
            Compression::Lz4 => recorder::Compression::Lz4,
            Compression::None => recorder::Compression::None,
        },
        frames_expected: schedule.map(|schedule| schedule.frames() + 1),
        model_time: duration(model.extent()),
    }
}

/// The run's length in the model's time unit; `None` where it is in events.
fn duration(extent: Extent) -> Option<f64> {
    match extent {
        Extent::Steps { total, step } => Some(total as f64 * step),
        Extent::Time(duration) => Some(duration),
        Extent::Events(_) => None,
    }
}
