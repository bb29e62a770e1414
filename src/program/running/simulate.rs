//! `simulate`: runs in memory for another program, which asks for one after the other on standard input, as the Python package does.
//!
//! A request is a line of JSON with a manifest, the folder of the recordings that runs start from, and values of `--set`:
//! `["exp.toml", "recordings", "seed=2"]`. The answer is a line of JSON: `exit_code` and either `error`
//! or `metrics`, which are the contents of `metrics.json`, and `recording_bytes`, the size of the recording that follows. It is not compressed.

use crate::manifests::{ManifestArguments, ManifestReader};
use crate::messages::{Failure, bad, complain, exit};
use crate::running::results::unexpected;
use clap::Args;
use kinetoscope::interrupt::Interrupt;
use kinetoscope::run::in_memory::run_uncompressed;
use kinetoscope_analysis::{analyze, metrics_of_run};
use kinetoscope_console::{Exit, Explained as _};
use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::recorder::Outcome;
use serde_json::json;
use std::io::{self, BufRead as _, ErrorKind, Read as _, Write as _};
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;
use std::thread;

/// Bytes of the longest request. A longer line is none.
const MOST_REQUEST_BYTES: u64 = 1 << 20;

/// Execute runs in memory for another program: requests on standard input, recordings and metrics on standard output
///
/// A request is a line such as ["exp.toml", "recordings", "seed=2"]: a manifest of one run, the folder of recordings that it may start from,
/// and overrides of its keys. The answer is a line of JSON with the
/// metrics, and then so many bytes of the recording, without compression, as the line states in `recording_bytes`. The end of the input ends
/// the program, and a run in progress.
#[derive(Debug, Args)]
pub(crate) struct SimulateArguments {}

impl SimulateArguments {
    /// Answers requests until the input ends.
    #[must_use]
    pub(crate) fn execute(&self) -> Exit {
        // A run in memory leaves nothing that a signal has to save.
        let interrupt = Interrupt::default();
        let (sender, requests) = channel();
        let ended = interrupt.clone();
        thread::spawn(move || {
            let mut input = io::stdin().lock();
            let mut line = Vec::new();
            while input.by_ref().take(MOST_REQUEST_BYTES).read_until(b'\n', &mut line).is_ok()
                && !line.is_empty()
                && sender.send(mem::take(&mut line)).is_ok()
            {}
            ended.stop();
        });
        for request in requests {
            let answer = simulated(&request, &interrupt);
            if interrupt.is_raised() {
                break;
            }
            match written(answer) {
                Ok(()) => {}
                Err(error) if error.kind() == ErrorKind::BrokenPipe => break,
                Err(error) => {
                    complain(&format!("error: standard output cannot be written: {error}"));
                    return Exit::Retryable;
                }
            }
        }
        Exit::Done
    }
}

/// The recording of a requested run, and the contents of its `metrics.json`.
fn simulated(request: &[u8], interrupt: &Interrupt) -> Result<(Recording, String), Failure> {
    let words: Vec<String> = serde_json::from_slice(request).unwrap_or_default();
    let [manifest, recordings, set @ ..] = words.as_slice() else {
        return Err(bad("the request is not a list of texts in JSON")
            .help(r#"write a line such as ["exp.toml", "recordings", "seed=2"]"#));
    };
    let overrides = ManifestArguments { set: set.to_vec() }.overrides()?;
    let reader = ManifestReader::new(PathBuf::from(recordings), None);
    let experiment = reader.read(Path::new(manifest), &overrides)?;
    let [run] = experiment.runs.as_slice() else {
        let what = format!("the manifest has {} runs", experiment.runs.len());
        return Err(
            bad(what).help("one run is executed in memory; execute a sweep with `kinetoscope run`")
        );
    };
    let recording = run_uncompressed(run, interrupt)
        .map_err(|error| Failure::of(exit::of_run_error(&error), error.message()))?;
    let unexpected = |outcome: &Outcome| unexpected(outcome, None, &experiment);
    if let Some(message) = recording.provenance().outcome.as_ref().and_then(unexpected) {
        return Err(Failure::of(Exit::RunFailed, message));
    }
    let analysis =
        analyze(&recording).map_err(|error| Failure::of(Exit::Unreadable, error.message))?;
    let metrics = metrics_of_run(&experiment.name, &analysis)
        .map_err(|error| Failure::new(Exit::Unreadable, error))?;
    Ok((recording, metrics))
}

/// Writes an answer.
fn written(answer: Result<(Recording, String), Failure>) -> io::Result<()> {
    let mut output = io::stdout().lock();
    match answer {
        Ok((recording, metrics)) => {
            let bytes = recording.bytes();
            writeln!(
                output,
                "{{\"exit_code\":0,\"recording_bytes\":{bytes},\"metrics\":{metrics}}}"
            )?;
            recording.write_to(&mut output)?;
        }
        Err(failure) => {
            let answer = json!({ "exit_code": failure.exit.code(), "error": failure.plain_text() });
            writeln!(output, "{answer}")?;
        }
    }
    output.flush()
}
