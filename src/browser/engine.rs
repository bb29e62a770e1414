//! One run at a time, advanced in parts, so that the page stays responsive and can stop it.

use crate::sink::Sink;
use kinetoscope::run::prepared::Prepared;
use kinetoscope::run::resources::memory::needed_memory_bytes;
use kinetoscope::run::{Advanced, RunError, RunState, record_start_on_this_thread};
use kinetoscope_analysis::run::RunOptions;
use kinetoscope_console::{Explained, Message};
use kinetoscope_manifest::{Experiment, RunManifest, parse, parse_run, run_key};
use kinetoscope_physics::{kind_of, state_columns_of};
use kinetoscope_recording::channels::SCHEMA_VERSION;
use kinetoscope_recording::claim::Claim;
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::frame_hashes::{FrameHasher, HashDifference, HashingObserver};
use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::recorder::{Compression, Outcome, Recorder};
use serde_json::{Value, json};
use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Bytes of a manifest that a page may pass.
const MOST_MANIFEST_BYTES: usize = 256 << 10;
/// Bytes of a recording that is kept: its metrics need a copy, and the memory is limited to 512 MB.
const MOST_RECORDED_BYTES: usize = 128 << 20;

/// What to do where a recording cannot be written: there is no disk, only the limit of the sink.
const ON_FULL_SINK: &str =
    "record fewer frames or channels in [record], or run the manifest with the program";

/// What a call led to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Status {
    /// The answer is complete, or the run is on its way to the next frame.
    Working = 0,
    /// The run has reached a frame.
    AtFrame = 1,
    /// The run has ended.
    Ended = 2,
    /// The answer is an error with its remedy.
    Failed = 3,
}

/// The answer to a call.
#[derive(Debug)]
pub struct Answer {
    /// What it led to.
    pub status: Status,
    /// JSON, or the bytes that were asked for.
    pub bytes: Vec<u8>,
}

impl Answer {
    fn new(status: Status, value: &Value) -> Self {
        Self { status, bytes: value.to_string().into_bytes() }
    }

    fn failed(error: &impl Explained) -> Self {
        let Message { what, help } = error.message();
        Self::new(Status::Failed, &json!({ "error": what, "help": help }))
    }

    fn refused(what: &str, help: &str) -> Self {
        Self::new(Status::Failed, &json!({ "error": what, "help": help }))
    }
}

/// The planned experiment, the run in progress, and the one that has ended.
#[derive(Default)]
pub struct Engine {
    experiment: Option<Experiment>,
    run: Option<CurrentRun>,
    ended: Option<Vec<u8>>,
}

/// A run in progress.
struct CurrentRun {
    state: RunState<Sink>,
    hasher: Arc<Mutex<FrameHasher>>,
    /// The state of the newest frame.
    newest: Rc<RefCell<Vec<f64>>>,
    claim: Option<Claim>,
    run_key: String,
}

fn locked(hasher: &Mutex<FrameHasher>) -> MutexGuard<'_, FrameHasher> {
    hasher.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The versions of the program, of the messages and of each model's physics.
#[must_use]
pub fn version() -> Answer {
    let physics: serde_json::Map<String, Value> = kinetoscope_physics::kinds()
        .iter()
        .map(|kind| (kind.name.to_owned(), kind.physics_version.into()))
        .collect();
    let version = env!("CARGO_PKG_VERSION");
    Answer::new(
        Status::Working,
        &json!({ "program": version, "schema": SCHEMA_VERSION, "physics": physics }),
    )
}

impl Engine {
    /// The runs of a manifest, or its errors.
    pub fn plan(&mut self, manifest: &[u8]) -> Answer {
        if manifest.len() > MOST_MANIFEST_BYTES {
            return Answer::refused(
                "the manifest is longer than 256 kB",
                "shorten it, or run it with the program",
            );
        }
        let text = String::from_utf8_lossy(manifest);
        match parse(&text, "manifest", &[]) {
            Ok(experiment) => {
                let runs: Vec<Value> = experiment
                    .runs
                    .iter()
                    .map(|run| planned(&run.manifest, run.replicate))
                    .collect();
                let answer = json!({ "name": experiment.name, "runs": runs });
                self.experiment = Some(experiment);
                Answer::new(Status::Working, &answer)
            }
            Err(errors) => Answer::new(Status::Failed, &json!({ "error": errors.render(false) })),
        }
    }

    /// Starts a planned run, whose recording is kept.
    pub fn start(&mut self, run: usize) -> Answer {
        let planned = self.experiment.as_ref().and_then(|experiment| experiment.runs.get(run));
        let Some(planned) = planned else {
            return Answer::refused("no such run is planned", "plan a manifest first");
        };
        let manifest = planned.manifest.clone();
        self.begin(&manifest, Sink::of(MOST_RECORDED_BYTES), None)
    }

    /// Starts the run of a claim, whose messages are compared and not kept.
    pub fn verify(&mut self, claim: &[u8]) -> Answer {
        let Some(claim) = Claim::from_bytes(claim) else {
            return Answer::refused(
                "the manifest and the hashes in this page are damaged: nothing can be compared",
                "load the page again, or compare the recording with `kinetoscope verify`",
            );
        };
        if claim.manifest.len() > MOST_MANIFEST_BYTES {
            return Answer::refused(
                "the manifest in this page is longer than 256 kB",
                "compare the recording with `kinetoscope verify`",
            );
        }
        match parse_run(&claim.manifest) {
            Ok(manifest) => self.begin(&manifest, Sink::empty(), Some(claim)),
            Err(errors) => Answer::new(Status::Failed, &json!({ "error": errors.render(false) })),
        }
    }

    fn begin(&mut self, manifest: &RunManifest, sink: Sink, claim: Option<Claim>) -> Answer {
        self.run = None;
        self.ended = None;
        match CurrentRun::new(manifest, sink, claim) {
            Ok(run) => {
                let answer = run.description(manifest);
                self.run = Some(run);
                Answer::new(Status::AtFrame, &answer)
            }
            Err(error) => Answer::failed(&error),
        }
    }

    /// Advances the run by at most so many steps or events, and at most to its next frame. A run that is compared ends at the first
    /// difference.
    pub fn advance(&mut self, budget: u64) -> Answer {
        let Some(run) = &mut self.run else {
            return Answer::refused("no run is in progress", "start one");
        };
        // The start may differ already.
        if run.differs_now() {
            return self.end(&Outcome::Interrupted);
        }
        match run.state.advance(budget) {
            Ok(Advanced::Working) => Answer { status: Status::Working, bytes: Vec::new() },
            Ok(Advanced::ToFrame) if !run.differs_now() => {
                Answer { status: Status::AtFrame, bytes: Vec::new() }
            }
            Ok(Advanced::ToFrame) => self.end(&Outcome::Interrupted),
            Ok(Advanced::ToEnd(outcome)) => self.end(&outcome),
            Err(error) => {
                self.run = None;
                Answer::refused(&error.to_string(), ON_FULL_SINK)
            }
        }
    }

    fn end(&mut self, outcome: &Outcome) -> Answer {
        let Some(CurrentRun { state, hasher, claim, .. }) = self.run.take() else {
            return Answer::refused("no run is in progress", "start one");
        };
        let sink = match state.recorder.finish(outcome) {
            Ok(sink) => sink,
            Err(error) => return Answer::refused(&error.to_string(), ON_FULL_SINK),
        };
        let mut hasher = locked(&hasher);
        let hashes = hasher.hashes();
        let messages: String = hashes.messages.iter().map(|byte| format!("{byte:02x}")).collect();
        let fault = if let Outcome::Fault(what) = outcome { Some(what) } else { None };
        let difference = claim.map(|claim| match claim.hashes.first_difference(hashes) {
            None => Value::Null,
            Some(HashDifference { first, last, topics }) => {
                json!({ "first": first, "last": last, "topics": topics })
            }
        });
        let mut answer = json!({ "frames": hashes.frames, "messages": messages, "fault": fault });
        match difference {
            Some(difference) => answer["difference"] = difference,
            None => self.ended = Some(sink.into_bytes()),
        }
        Answer::new(Status::Ended, &answer)
    }

    /// The state of the newest frame.
    #[must_use]
    pub fn columns(&self) -> Answer {
        let Some(run) = &self.run else {
            return Answer::refused("no run is in progress", "start one");
        };
        let bytes = run.newest.borrow().iter().flat_map(|value| value.to_le_bytes()).collect();
        Answer { status: Status::Working, bytes }
    }

    /// The metrics and the charts of the run that has ended.
    #[must_use]
    pub fn metrics(&self) -> Answer {
        let Some(bytes) = &self.ended else {
            return Answer::refused("no run has ended", "let the run reach its end");
        };
        let recording =
            match Recording::from_bytes(bytes.clone(), Path::new("the recording in memory")) {
                Ok(recording) => recording,
                Err(error) => return Answer::failed(&error),
            };
        let options = RunOptions { with_figures: true, ..RunOptions::default() };
        match kinetoscope_analysis::analyze_with(&recording, options) {
            Ok(analysis) => {
                let main = kinetoscope_analysis::main_metrics(&analysis);
                let found = analysis.measurements.iter();
                let metrics = found.map(|it| measurement(it, main.contains(&it.name())));
                let metrics: Vec<Value> = metrics.collect();
                let charts = kinetoscope_analysis::charts_of_run(&analysis);
                Answer::new(Status::Working, &json!({ "metrics": metrics, "charts": charts }))
            }
            Err(error) => Answer::refused(
                &error.message.what,
                error.message.help.as_deref().unwrap_or_default(),
            ),
        }
    }

    /// The recording of the run that has ended.
    #[must_use]
    pub fn recording(&self) -> Answer {
        match &self.ended {
            Some(bytes) => Answer { status: Status::Working, bytes: bytes.clone() },
            None => Answer::refused("no run has ended", "let the run reach its end"),
        }
    }
}

impl CurrentRun {
    fn new(manifest: &RunManifest, sink: Sink, claim: Option<Claim>) -> Result<Self, RunError> {
        let canonical = manifest.canonical();
        let key = run_key(&canonical, kind_of(&manifest.model).physics_version, SCHEMA_VERSION);
        let mut start = Prepared::new_while(manifest, &canonical, key.as_str(), &|_| true)?;
        start.header.compression = Compression::None;
        let hasher: Arc<Mutex<FrameHasher>> = Arc::default();
        let mut recorder = Recorder::create(sink, &start.header)?;
        recorder.show_to(Box::new(HashingObserver(Arc::clone(&hasher))))?;
        let mut first = Frame::new();
        start.model.observe(&mut first);
        let newest = Rc::new(RefCell::new(first.state().to_vec()));
        let seen = Rc::clone(&newest);
        let state =
            record_start_on_this_thread(start, recorder)?.with_viewer(Box::new(move |frame, _| {
                let mut seen = seen.borrow_mut();
                seen.clear();
                seen.extend_from_slice(frame.state());
            }));
        Ok(Self { state, hasher, newest, claim, run_key: key.as_str().to_owned() })
    }

    /// Whether the last frame is not the one of the claim.
    fn differs_now(&self) -> bool {
        let differs = |claim: &Claim| locked(&self.hasher).differs_now(&claim.hashes);
        self.claim.as_ref().is_some_and(differs)
    }

    fn description(&self, manifest: &RunManifest) -> Value {
        let kind = kind_of(&manifest.model);
        let columns: Vec<&str> =
            state_columns_of(&manifest.model).iter().map(|column| column.name).collect();
        let mut answer = planned(manifest, manifest.replicate);
        answer["frames"] = (self.state.schedule.frames() + 1).into();
        answer["columns"] = json!(columns);
        answer["run_key"] = json!(self.run_key);
        answer["version"] = json!([kind.physics_version, SCHEMA_VERSION]);
        if let Some(claim) = &self.claim {
            answer["claimed"] = json!([claim.physics_version, claim.schema_version]);
            answer["manifest"] = claim.manifest.as_str().into();
            answer["messages"] = claim.hashes.frames.into();
            answer["every"] = claim.hashes.every.into();
        }
        answer
    }
}

fn planned(manifest: &RunManifest, replicate: u32) -> Value {
    json!({
        "model": manifest.model.name(),
        "particles": manifest.model.particles(),
        "replicate": replicate,
        "memory_bytes": needed_memory_bytes(manifest),
    })
}

fn measurement(found: &kinetoscope_analysis::Measurement, is_main: bool) -> Value {
    let not_finite =
        || (!found.estimate.value.is_finite()).then(|| "the value is not finite".into());
    let reason = found.reason.clone().or_else(not_finite);
    let theory = found.theory.filter(|theory| theory.in_range());
    json!({
        "main": is_main,
        "name": found.name(),
        "label": found.definition.label,
        "unit": found.definition.unit,
        "value": found.estimate.value,
        "standard_error": found.estimate.standard_error,
        "theory": theory.map(|theory| theory.value),
        "accuracy": theory.map(|theory| theory.accuracy),
        "out_of_range": found.theory.is_some() && theory.is_none(),
        "reason": reason,
    })
}
