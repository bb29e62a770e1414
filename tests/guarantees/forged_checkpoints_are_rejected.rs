//! Guarantee: whatever a checkpoint with a correct checksum contains, the run ends without a panic or a hang, and leaves a readable
//! recording. A state that no run can have starts the run from scratch, with a message.
//!
//! Setup: runs of every model and variant are interrupted; each checkpoint is changed at seeded places, by single bits and by
//! numbers that are not finite, negative or huge; then the program resumes all of them, with limits of its processor time and
//! memory. Control: an unchanged checkpoint is resumed, and some of the changed ones are rejected.

#![allow(clippy::unwrap_used, reason = "a test may panic")]
#![cfg(unix)]

use crate::forged_recording::{recordings, stderr};
use crate::mutated_recording::Numbers;
use crate::small_experiments::MANIFESTS;
use kinetoscope::interrupt::Interrupt;
use kinetoscope::plan::Plan;
use kinetoscope::run::{RunContext, RunSpec, execute};
use kinetoscope_recording::checkpoint::{self, decode_head};
use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::recorder::{Outcome, RecorderState};
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

/// Executes all runs up to their seventh frame, and interrupts them there.
fn interrupt_all(plan: &Plan) {
    fs::create_dir_all(&plan.folder).unwrap();
    for run in &plan.runs {
        let spec = RunSpec {
            manifest: &run.run.manifest,
            canonical: run.run.manifest.canonical(),
            run_key: run.run_key.as_str(),
            folder: &plan.folder,
            stem: run.stem(),
        };
        let interrupt = Interrupt::default();
        let stop = |done, _| {
            if done >= 7 {
                interrupt.stop();
            }
        };
        let context = RunContext {
            interrupt: &interrupt,
            checkpoint_every: Duration::from_secs(5),
            on_frame: &stop,
            on_written: &|| {},
            live: None,
            gnuplot: None,
        };
        assert_eq!(execute(&spec, None, context).unwrap().outcome, Outcome::Interrupted);
    }
}

/// Changes the content of a checkpoint and corrects its checksum.
fn forge(path: &Path, numbers: &mut Numbers) {
    let mut bytes = fs::read(path).unwrap();
    // Layout: magic 8, version 4, identity with its length, length 8, content, checksum 4.
    let identity = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let (first, end) = (16 + identity + 8, bytes.len() - 4);
    // The messages of the open chunk take the most bytes; the model's state follows them.
    let head = decode_head::<(u64, RecorderState)>(&bytes[first..end]);
    let model = end - head.unwrap().1.len();
    let start = if numbers.is_one_in(4) { first } else { model };
    for _ in 0..1 + numbers.below(3) {
        let place = start + numbers.below(end - start);
        let specials = [f64::NAN, f64::INFINITY, -1.0, 1e300, -1e9, 0.0, 1e-300, 4294967295.0];
        match numbers.below(4) {
            0 => bytes[place] ^= 1 << numbers.below(8),
            1 => bytes[place] = 0xff,
            2 => bytes[place] = bytes[place].wrapping_add(1),
            _ => {
                let number = specials[numbers.below(specials.len())].to_le_bytes();
                let length = number.len().min(end - place);
                bytes[place..place + length].copy_from_slice(&number[..length]);
            }
        }
    }
    let checksum = crc32fast::hash(&bytes[..end]).to_le_bytes();
    bytes[end..].copy_from_slice(&checksum);
    fs::write(path, bytes).unwrap();
}

/// Resumes all runs with at most 120 s of processor time and 1 GiB of memory; returns the messages.
fn resume_all(manifest: &Path, output: &Path) -> (Option<i32>, String) {
    let mut command = Command::new("sh");
    command
        .args(["-c", r#"ulimit -t 120; ulimit -v 1048576; exec "$0" "$@""#])
        .arg(env!("CARGO_BIN_EXE_run-experiment"))
        .args(["--jobs", "2", "--threads", "1", "--output"])
        .args([output, manifest]);
    let done = command.output().unwrap();
    (done.status.code(), stderr(&done))
}

/// Forges `count` checkpoints per manifest; returns the number of rejected ones.
fn forge_and_resume(count: usize, seed: u64) -> usize {
    let mut numbers = Numbers(seed);
    let mut rejected = 0;
    for (name, text) in MANIFESTS {
        let folder = tempfile::tempdir().unwrap();
        let manifest = folder.path().join(format!("{name}.toml"));
        let text = format!("replicates = {}\n{text}", count + 1);
        fs::write(&manifest, &text).unwrap();
        let experiment = kinetoscope_manifest::parse(&text, &format!("{name}.toml"), &[]).unwrap();
        let output = folder.path().join("recordings");
        let plan = Plan::new(&experiment, &output, false, &Interrupt::default());
        interrupt_all(&plan);
        for run in &plan.runs[1..] {
            forge(&checkpoint::path(&plan.folder, &run.stem()), &mut numbers);
        }
        let (code, messages) = resume_all(&manifest, &output);
        assert!(matches!(code, Some(0 | 1)), "{name}: {code:?}: {messages}");
        assert!(!messages.contains("internal error"), "{name}: {messages}");
        let intact = &plan.runs[0].stem();
        assert!(messages.contains(&format!("{intact}: done from frame")), "{name}: {messages}");
        rejected += messages.matches("restarted from scratch").count();
        let found = recordings(&plan.folder);
        assert_eq!(found.len(), count + 1, "{name}: {messages}");
        for recording in found {
            let outcome = Recording::open(&recording).unwrap().provenance().outcome.clone();
            assert!(matches!(outcome, Some(Outcome::Complete | Outcome::Fault(_))), "{name}");
        }
    }
    rejected
}

#[test]
fn forged_checkpoints_neither_panic_nor_hang() {
    let rejected = forge_and_resume(3, 1);
    assert!(rejected > 5, "{rejected} of {} are rejected", 3 * MANIFESTS.len());
}

#[test]
#[ignore = "takes minutes: 100 checkpoints per manifest"]
fn full_harness_forged_checkpoints() {
    assert!(forge_and_resume(100, 2) > 200);
}
