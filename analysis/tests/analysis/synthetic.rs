//! Recordings with known numbers, written without physics from a manifest and frames made by hand.
#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use kinetoscope_manifest::{ExperimentRecord, Run, RunManifest, parse, run_key};
use kinetoscope_recording::channels::{
    self, ChannelDeclaration, DemContactForces, DemContactStatistics, DemEnergy, DemTemperature,
    GasCollisions, GasEnergyBalance, GasInvariants, GasPressure, GasSpeeds, GasTemperature,
    OrbitElements, OrbitEnergy, PackingCollisions, PackingPressure, PackingTemperature,
    PerCollision,
};
use kinetoscope_recording::frame::{Frame, StateColumn};
use kinetoscope_recording::recorder::{Clock, Compression, Header, Outcome, Recorder, Selection};
use kinetoscope_recording::scenery::{DrawnRadius, Scenery};
use std::num::{NonZeroU32, NonZeroU64};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// The frames of a run.
pub(crate) type Frames = Vec<(Clock, Frame)>;

/// The folder of an experiment with one recording per run.
pub(crate) struct Folder {
    directory: TempDir,
    pub(crate) files: Vec<String>,
}

impl Folder {
    /// Writes all runs of a manifest, each with the frames from `frames`.
    pub(crate) fn write(manifest: &str, frames: impl Fn(&RunManifest) -> Frames) -> Self {
        let experiment = parse(manifest, "synthetic.toml", &[]).unwrap();
        let directory = TempDir::new().unwrap();
        let mut files = Vec::new();
        for (index, run) in experiment.runs.iter().enumerate() {
            let name = format!("{}__{index:03}.mcap", experiment.name);
            let whole = frames(&run.manifest);
            write_run(&directory.path().join(&name), run, &whole, &Outcome::Complete);
            files.push((name, key_of(run)));
        }
        let names = files.iter().map(|(name, _)| name.clone()).collect();
        let record = ExperimentRecord::new(&experiment, files);
        std::fs::write(directory.path().join("experiment.toml"), record.to_toml()).unwrap();
        Self { directory, files: names }
    }

    pub(crate) fn path(&self) -> &Path {
        self.directory.path()
    }

    /// The path as an argument of a command line.
    pub(crate) fn name(&self) -> &str {
        self.path().to_str().unwrap()
    }

    pub(crate) fn file(&self, index: usize) -> PathBuf {
        self.path().join(&self.files[index])
    }

    /// Analyzes the folder and reads `metrics.json`.
    pub(crate) fn metrics(&self) -> Metrics {
        analyze(&[self.name()]).exited_with(0);
        self.written()
    }

    /// The contents of `metrics.json`.
    pub(crate) fn written(&self) -> Metrics {
        let text = std::fs::read_to_string(self.path().join("metrics.json")).unwrap();
        Metrics(serde_json::from_str(&text).unwrap())
    }

    /// The text of `report.html`.
    pub(crate) fn page(&self) -> String {
        std::fs::read_to_string(self.path().join("report.html")).unwrap()
    }

    /// Analyzes the folder and keeps a copy of its `metrics.json` as a baseline.
    pub(crate) fn baseline(&self) -> PathBuf {
        self.metrics();
        let file = self.path().join("baseline.json");
        std::fs::copy(self.path().join("metrics.json"), &file).unwrap();
        file
    }
}

/// One frame per index; `fill` adds its state and messages, and returns its time.
pub(crate) fn frames_of(
    indices: impl IntoIterator<Item = u32>,
    fill: impl Fn(u32, &mut Frame) -> f64,
) -> Frames {
    let frame = |index: u32| {
        let mut frame = Frame::new();
        let time = fill(index, &mut frame);
        (Clock { count: u64::from(index), time }, frame)
    };
    indices.into_iter().map(frame).collect()
}

/// Two frames of one gas particle that starts at the center, with the same pressure.
pub(crate) fn two_frames(pressure: &GasPressure) -> Frames {
    frames_of(0..2, |index, frame| {
        frame.push_state(&[0.0, 0.0, 1.0, 0.0]);
        frame.push(pressure);
        f64::from(index)
    })
}

/// The text without its line breaks.
pub(crate) fn flat(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn key_of(run: &Run) -> kinetoscope_manifest::RunKey {
    run_key(&run.manifest.canonical(), 1, channels::SCHEMA_VERSION)
}

/// The header of a recording without channels, in a view from -1 to 1.
pub(crate) fn header(model: &'static str) -> Header {
    Header {
        manifest: String::new(),
        run_key: String::new(),
        model,
        physics_version: 1,
        program_version: "0".to_owned(),
        time_unit: "s",
        state_columns: PLANE,
        channels: &[],
        selection: Selection::Named(Vec::new()),
        scenery: Scenery {
            walls: Vec::new(),
            view: [[-1.0, -1.0], [1.0, 1.0]],
            drawn_radius: DrawnRadius::Fixed(0.01),
            speed_range_top: 1.0,
            speed_unit: "",
            arrows: false,
            force_range_top: None,
            trail: false,
            unused_fields: Vec::new(),
            names: Vec::new(),
            central_particle: None,
        },
        playback_fps: 25.0,
        max_drawn_particles: NonZeroU32::new(10_000).unwrap(),
        draw_every: NonZeroU64::MIN,
        compression: Compression::Zstd,
        stored: kinetoscope_recording::recorder::StoredFrames::All,
        frames_expected: None,
        model_time: None,
    }
}

/// Writes one recording.
pub(crate) fn write_run(path: &Path, run: &Run, frames: &Frames, outcome: &Outcome) {
    let model = run.manifest.model.name();
    let names = &run.manifest.record.channels;
    let header = Header {
        manifest: run.manifest.canonical(),
        run_key: key_of(run).to_string(),
        time_unit: match model {
            "orbit" => "d",
            "packing" => "",
            _ => "s",
        },
        state_columns: if model == "orbit" { SPACE } else { PLANE },
        channels: channels_of(model),
        selection: Selection::Named(
            ["state"]
                .into_iter()
                .filter(|state| {
                    names.as_ref().is_none_or(|names| names.iter().any(|name| name == state))
                })
                .chain(channels_of(model).iter().map(|channel| &channel.topic[1..]))
                // Drawings on request only, because they take most of the time.
                .chain(names.iter().flatten().map(String::as_str).filter(|name| *name == "discs"))
                .map(str::to_owned)
                .collect(),
        ),
        ..header(model)
    };
    let mut recorder = Recorder::create(std::fs::File::create(path).unwrap(), &header).unwrap();
    for (clock, frame) in frames {
        recorder.write(*clock, &mut frame.clone()).unwrap();
    }
    recorder.finish(outcome).unwrap();
}

const PLANE: &[StateColumn] = &[
    StateColumn { name: "x", unit: "" },
    StateColumn { name: "y", unit: "" },
    StateColumn { name: "vx", unit: "" },
    StateColumn { name: "vy", unit: "" },
];

const SPACE: &[StateColumn] = &[
    StateColumn { name: "x", unit: "AU" },
    StateColumn { name: "y", unit: "AU" },
    StateColumn { name: "z", unit: "AU" },
    StateColumn { name: "vx", unit: "AU/d" },
    StateColumn { name: "vy", unit: "AU/d" },
    StateColumn { name: "vz", unit: "AU/d" },
];

const DEM: &[ChannelDeclaration] = &[
    ChannelDeclaration::of::<DemEnergy>(),
    ChannelDeclaration::of::<DemContactStatistics>(),
    ChannelDeclaration::of::<DemTemperature>(),
    ChannelDeclaration::opt_in::<DemContactForces>(),
];

const GAS: &[ChannelDeclaration] = &[
    ChannelDeclaration::of::<GasPressure>(),
    ChannelDeclaration::of::<GasTemperature>(),
    ChannelDeclaration::of::<GasInvariants>(),
    ChannelDeclaration::of::<GasCollisions>(),
    ChannelDeclaration::of::<GasSpeeds>(),
    ChannelDeclaration::of::<GasEnergyBalance>(),
];

const PACKING: &[ChannelDeclaration] = &[
    ChannelDeclaration::of::<PackingTemperature>(),
    ChannelDeclaration::of::<PackingCollisions>(),
    ChannelDeclaration::of::<PackingPressure>(),
    ChannelDeclaration::opt_in::<PerCollision>(),
];

const ORBIT: &[ChannelDeclaration] =
    &[ChannelDeclaration::of::<OrbitEnergy>(), ChannelDeclaration::of::<OrbitElements>()];

fn channels_of(model: &str) -> &'static [ChannelDeclaration] {
    match model {
        "dem" => DEM,
        "gas" => GAS,
        "packing" => PACKING,
        _ => ORBIT,
    }
}

/// The output of `analyze-recordings`, and its exit code.
pub(crate) struct AnalysisOutput {
    pub(crate) code: i32,
    pub(crate) text: String,
}

impl AnalysisOutput {
    /// The same output, after a comparison of its exit code.
    #[track_caller]
    pub(crate) fn exited_with(self, code: i32) -> Self {
        assert_eq!(self.code, code, "{}", self.text);
        self
    }
}

/// Runs `analyze-recordings`.
pub(crate) fn analyze(arguments: &[&str]) -> AnalysisOutput {
    let output: Output = Command::new(env!("CARGO_BIN_EXE_analyze-recordings"))
        .args(arguments)
        .env("COLUMNS", "60")
        .output()
        .unwrap();
    let text = format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    AnalysisOutput { code: output.status.code().unwrap(), text }
}

/// `metrics.json`.
pub(crate) struct Metrics(serde_json::Value);

impl Metrics {
    /// Number of all metrics.
    pub(crate) fn len(&self) -> usize {
        self.0["metrics"].as_array().unwrap().len()
    }

    /// All metrics of a name.
    pub(crate) fn all(&self, name: &str) -> Vec<&serde_json::Value> {
        let metrics = self.0["metrics"].as_array().unwrap();
        metrics.iter().filter(|metric| metric["name"] == name).collect()
    }

    /// The first metric of a name: that of a sweep if there is one, otherwise that of the first run.
    pub(crate) fn first(&self, name: &str) -> &serde_json::Value {
        let all = self.all(name);
        assert!(!all.is_empty(), "no metric {name}");
        all[0]
    }

    /// Its value.
    pub(crate) fn value(&self, name: &str) -> f64 {
        self.first(name)["value"].as_f64().unwrap()
    }

    /// Its standard error.
    pub(crate) fn error(&self, name: &str) -> Option<f64> {
        self.first(name)["standard_error"].as_f64()
    }

    /// Theory's value.
    pub(crate) fn theory(&self, name: &str) -> Option<f64> {
        self.first(name)["theory"]["value"].as_f64()
    }

    /// Asserts that a value is within a relative tolerance, or an absolute one if the expected value is zero.
    pub(crate) fn assert_near(&self, name: &str, expected: f64, tolerance: f64) {
        let value = self.value(name);
        let size = if expected == 0.0 { 1.0 } else { expected.abs() };
        assert!(
            (value - expected).abs() <= tolerance * size,
            "{name}: {value:e}, not {expected:e}"
        );
    }
}
