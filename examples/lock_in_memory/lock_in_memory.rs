//! Executes every run of the manifest on standard input in memory, and prints its lock file, as `kinetoscope lock` writes it but
//! for the bound of the time, the manifest's values, the checked metrics and the hash of the checks. It needs no threads and no files; therefore, it also runs as WebAssembly:
//!
//!     cargo build --release --package kinetoscope-lock-in-memory --target wasm32-wasip1
//!     node tests/architectures/wasi.mjs lock_in_memory.wasm experiments/first_run.toml < experiments/first_run.toml

use kinetoscope::verify::fingerprint::fingerprint;
use kinetoscope::verify::lock_file::{LockFile, LockedExperiment, RunHashes, metrics_hash};
use kinetoscope::{Experiment, run};
use kinetoscope_physics::kind_of;
use kinetoscope_recording::channels::SCHEMA_VERSION;
use std::error::Error;
use std::{env, io};

fn main() -> Result<(), Box<dyn Error>> {
    let name = env::args().nth(1).ok_or("usage: lock_in_memory NAME < MANIFEST")?;
    let experiment: Experiment = io::read_to_string(io::stdin())?.parse()?;
    let (mut keys, mut messages, mut first) = (Vec::new(), Vec::new(), None);
    for planned in &experiment.runs {
        let recording = run(planned)?;
        let found = fingerprint(&recording)?;
        keys.push(recording.provenance().run_key.clone());
        messages.push(found.messages.clone());
        if first.is_none() {
            let analysis = kinetoscope_analysis::analyze(&recording)?;
            let with_value = analysis.measurements.iter().filter(|one| one.reason.is_none());
            let metrics = metrics_hash(with_value.map(|one| (one.name(), one.estimate.value)));
            let version = kind_of(&planned.manifest.model).physics_version;
            first = Some((metrics, found.tags(), version));
        }
    }
    let (metrics, tags, physics_version) = first.ok_or("the manifest has no run")?;
    let model = experiment.model().to_owned();
    let mut file = LockFile::new(SCHEMA_VERSION);
    let manifest = name;
    let RunHashes { keys, messages, groups } = RunHashes::new(&keys, &messages);
    file.put(LockedExperiment {
        manifest,
        model,
        physics_version,
        at_most_s: 1,
        runs: experiment.runs.len(),
        keys,
        messages,
        groups,
        frames: tags.frames,
        tags: LockedExperiment::tags_text(&tags),
        metrics,
        checks: "0".repeat(8),
        values: String::new(),
        checked: String::new(),
    });
    print!("{}", file.text()?);
    Ok(())
}
