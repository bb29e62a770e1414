//! Guarantee: `kinetoscope verify` reruns a recording and finds it byte-identical: for each model, for a run that ended in a fault, and for every
//! compression. A recording of another version of the program is equal in its messages.
//!
//! Control: a recording with another fault in its outcome is rejected.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::forged_recording::{Forgery, kinetoscope, record, stderr, stdout};
use crate::small_experiments::{MANIFESTS, manifest};
use kinetoscope_recording::reader::{Outcome, Recording};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Damping so strong that explicit steps of the default length diverge and the run ends in a fault.
const FAULT: &str = "seed = 3\n[model.dem]\ndiscs = 30\nwidth_m = 0.01\nheight_m = 0.01\nduration_s = 0.04\n\
    damping_n_s_per_m = 1.5e3\non_unstable_time_step = \"warn\"\n[record]\nframes = 20\n";

fn verify(recording: &Path) -> std::process::Output {
    kinetoscope(["verify".as_ref(), recording.as_os_str()])
}

#[test]
fn every_model_is_verified_byte_by_byte() {
    let folder = tempfile::tempdir().unwrap();
    for (name, manifest) in MANIFESTS {
        let recording = record(folder.path(), name, manifest);
        let verified = verify(&recording);
        assert_eq!(verified.status.code(), Some(0), "{name}: {}", stderr(&verified));
        let text = stdout(&verified);
        assert!(text.contains(" frames rerun: equal in every byte"), "{name}: {text}");
    }
}

#[test]
fn every_compression_is_verified_byte_by_byte() {
    let folder = tempfile::tempdir().unwrap();
    let (_, manifest) = MANIFESTS[0];
    for compression in ["lz4", "none"] {
        let manifest = format!("{manifest}compression = \"{compression}\"\n");
        let verified = verify(&record(folder.path(), "packed", &manifest));
        assert!(stdout(&verified).contains("equal in every byte"), "{}", stderr(&verified));
    }
}

#[test]
fn rerun_ends_in_the_recorded_fault() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(folder.path(), "fault", FAULT);
    let outcome = Recording::open(&recording).unwrap().provenance().outcome.clone();
    let Some(Outcome::Fault(fault)) = outcome else { panic!("{outcome:?}") };
    let verified = verify(&recording);
    assert_eq!(verified.status.code(), Some(0), "{}", stderr(&verified));
    let text = stdout(&verified);
    assert!(text.contains("equal in every byte"), "{text}");
    assert!(text.contains(&format!("both failed in the same way: {fault}")), "{text}");

    let forged = folder.path().join("forged.mcap");
    let metadata = BTreeMap::from([("outcome_detail".to_owned(), "another fault".to_owned())]);
    Forgery { metadata, ..Forgery::default() }.write(&recording, &forged);
    let verified = verify(&forged);
    assert_eq!(verified.status.code(), Some(4));
    let expected = format!(
        "first difference: outcome: failed: another fault in the file, failed: {fault} in the rerun"
    );
    assert!(stderr(&verified).contains(&expected), "{}", stderr(&verified));
}

#[test]
fn equal_messages_in_other_bytes_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(folder.path(), "packing", manifest("packing"));
    let other = folder.path().join("other.mcap");
    Forgery::default().write(&recording, &other);
    assert_ne!(fs::read(&recording).unwrap(), fs::read(&other).unwrap());
    let verified = verify(&other);
    assert_eq!(verified.status.code(), Some(0), "{}", stderr(&verified));
    let text = stdout(&verified);
    assert!(text.contains("21 frames rerun: equal in every message, not in every byte"), "{text}");
}

#[test]
fn recordings_of_other_versions_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(folder.path(), "gas", manifest("gas_exact"));
    let opened = Recording::open(&recording).unwrap();
    let physics = opened.provenance().physics_version + 1;
    let key = kinetoscope_manifest::run_key(
        opened.manifest(),
        physics,
        opened.provenance().schema_version,
    );
    let other = folder.path().join("other.mcap");
    let metadata = BTreeMap::from([
        ("program_version".to_owned(), "0.0.9".to_owned()),
        ("physics_version".to_owned(), physics.to_string()),
        ("run_key".to_owned(), key.to_string()),
    ]);
    Forgery { metadata, ..Forgery::default() }.write(&recording, &other);
    let verified = verify(&other);
    assert_eq!(verified.status.code(), Some(0), "{}", stderr(&verified));
    let text = stdout(&verified);
    assert!(text.contains("recorded by version 0.0.9 of the program"), "{text}");
    assert!(text.contains(&format!("recorded with physics version {physics} of gas")), "{text}");
    assert!(text.contains("equal in every message"), "{text}");
}

#[test]
fn differences_of_manifests_of_other_versions_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(folder.path(), "gas", manifest("gas_exact"));
    let opened = Recording::open(&recording).unwrap();
    let provenance = opened.provenance();
    let other = folder.path().join("other.mcap");
    let forge = |change: &dyn Fn(&str) -> String| {
        let key = kinetoscope_manifest::run_key(
            &change(opened.manifest()),
            provenance.physics_version,
            provenance.schema_version,
        );
        let metadata = BTreeMap::from([("run_key".to_owned(), key.to_string())]);
        Forgery { manifest: Some(change), metadata, message: None }.write(&recording, &other);
        verify(&other)
    };
    // An older version lacks a key, which has its default in this version.
    let older = forge(&|text| text.replace("propagation = \"exact\"\n", ""));
    assert_eq!(older.status.code(), Some(0), "{}", stderr(&older));
    let note =
        "this version reads the manifest differently: model.gas.propagation: (none) → \"exact\"";
    assert!(stdout(&older).contains(note), "{}", stdout(&older));

    let newer = forge(&|text| text.replace("propagation = \"exact\"\n", "viscosity = 1.0\n"));
    assert_eq!(newer.status.code(), Some(5));
    assert!(stderr(&newer).contains("does not understand"), "{}", stderr(&newer));
    assert!(stderr(&newer).contains("viscosity"), "{}", stderr(&newer));
}
